"""A response as time histories and as a test record."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown import load, simulate
from ridedown.errors import InvalidInput, UnknownName


@pytest.fixture(scope="module")
def response():
    return simulate(load("p1"))


@pytest.mark.parametrize("channel", ["adult.acceleration", "child.acceleration", "vehicle1.velocity", "bar.rotation"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_a_history_is_straight_within_its_tolerance(response, channel, tolerance) -> None:
    time, values = response.history(channel, tolerance).si
    middle = 0.5 * (time[1:] + time[:-1])
    apart = np.diff(time) > 1e-9  # not across a jump
    chords = 0.5 * (values[1:] + values[:-1])
    worst = np.abs(chords - response.at(channel, middle))[apart].max()
    assert worst <= tolerance * abs(response.peak(channel).value)


def test_a_history_holds_the_exact_extremes(response) -> None:
    _, values = response.history("adult.acceleration", 0.1).si
    assert values.min() == pytest.approx(response.minimum("adult.acceleration").value, rel=1e-13)
    assert values.max() == pytest.approx(response.maximum("adult.acceleration").value, abs=1e-9)


def test_a_jump_is_two_equal_stamps(response) -> None:
    # a damped belt closes at a speed: its force jumps
    time, values = response.history("child.acceleration").si
    steps = np.abs(np.diff(values))[np.diff(time) == 0.0]
    assert (np.diff(time) >= 0.0).all()
    assert steps.max() > 1.0


def test_what_never_moves_is_two_points_a_phase() -> None:
    still = simulate(load("p1").model_copy(update={"duration": 1e-4}))
    history = still.history("child.acceleration")
    assert not history.values.any()
    assert len(history) == 2 * still.phases.start.size


@pytest.mark.parametrize("tolerance", [0.0, -1e-6, float("nan"), 1e-300])
def test_a_tolerance_that_cannot_be_is_refused(response, tolerance) -> None:
    with pytest.raises(InvalidInput, match="tolerance"):
        response.history("adult.acceleration", tolerance)


def test_an_unknown_channel_offers_the_nearest(response) -> None:
    with pytest.raises(UnknownName, match=r"adult\.acceleration"):
        response.history("adult.aceleration")


def test_a_record_has_every_channel_and_codes_where_there_is_a_place(response) -> None:
    record = response.to_record()
    assert tuple(record.channels) == response.channels
    assert record.channels["adult.acceleration"].code == "11CHST000000ACX0"
    assert record.channels["child.acceleration"].code == "14CHST000000ACX0"
    assert record.channels["vehicle2.velocity"].code == "20VEHC000000VEX0"
    assert record.channels["adult.excursion"].code is None
    assert record.channels["adult.displacement"].code is None  # a chest's displacement is its deflection elsewhere
    codes = [info.code for info in record.channels.values() if info.code]
    assert len(codes) == len(set(codes))
    assert [(v.mass, v.speed) for v in record.vehicles] == [(1500.0, 13.33), (1500.0, 13.33)]
    history = record.history("adult.acceleration")
    assert history.sampling_rate == pytest.approx(10e3)
    np.testing.assert_array_equal(history.values, response.at("adult.acceleration", response.times()))


def test_a_record_of_a_network_has_no_codes() -> None:
    record = simulate(load("marzbanrad-2")).to_record()
    assert not any(info.code for info in record.channels.values())
    assert record.occupants == ()
