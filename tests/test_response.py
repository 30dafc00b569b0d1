"""What a response says of itself: channels, exact peaks, events, results, exports."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from ridedown import Response, load, simulate
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import CrashScenario, substitute

NAMES = ("p1", "example-offset", "example-wall", "example-restraints", "navigator-neon", "paper-child-offset", "marzbanrad-2")


@pytest.fixture(scope="module", params=NAMES)
def response(request: pytest.FixtureRequest) -> Response:
    return simulate(load(request.param))


@pytest.fixture(scope="module")
def p1() -> Response:
    return simulate(load("p1"))


def dense(response: Response, count: int = 40001) -> np.ndarray:
    return np.linspace(0.0, response.end_time, count)


def test_peaks_are_those_of_dense_sampling(response: Response) -> None:
    times = dense(response)
    for channel in response.channels:
        values = response.at(channel, times)
        size = max(np.abs(values).max(), 1e-9)
        low, high, peak = response.minimum(channel), response.maximum(channel), response.peak(channel)
        assert high.value >= values.max() - 1e-12 * size, channel
        assert low.value <= values.min() + 1e-12 * size, channel
        # no higher than where it says: at an event, just before or just after
        near = np.clip(high.time + np.array([-1e-9, 0.0, 1e-9]), 0.0, response.end_time)
        assert np.abs(response.at(channel, near) - high.value).min() <= 1e-5 * size, channel
        assert abs(peak.value) == max(abs(low.value), abs(high.value)), channel
        assert peak in {low, high} or abs(low.value) == abs(high.value), channel


def test_channels_are_derivatives_of_each_other(response: Response) -> None:
    h = 1e-6
    times = np.linspace(2e-3, response.end_time - 2e-3, 101)
    away = np.abs(times[:, np.newaxis] - response.phases.start).min(axis=1) > 3 * h
    times = times[away]
    for channel in response.channels:
        if channel.endswith(".velocity"):
            below, above = (channel.replace("velocity", q) for q in ("displacement", "acceleration"))
            slope = (response.at(below, times + h) - response.at(below, times - h)) / (2 * h)
            np.testing.assert_allclose(response.at(channel, times), slope, atol=1e-5)
            slope = (response.at(channel, times + h) - response.at(channel, times - h)) / (2 * h)
            np.testing.assert_allclose(response.at(above, times), slope, atol=1e-3 * (1.0 + np.abs(slope).max()))


def test_continuous_channels_do_not_jump(response: Response) -> None:
    starts = response.phases.start[1:]
    for channel in response.channels:
        if channel.endswith((".displacement", ".velocity", ".deflection", "rotation", "excursion")):
            before, after = response.at(channel, np.nextafter(starts, 0.0)), response.at(channel, starts)
            np.testing.assert_allclose(before, after, atol=1e-10, err_msg=channel)


def test_channels_at_the_start(p1: Response) -> None:
    assert p1.at("vehicle1.velocity", 0.0) == 13.33
    assert p1.at("vehicle1.displacement", 0.0) == 0.0
    assert p1.at("adult.velocity", 0.0) == 13.33
    assert p1.at("adult.relative_velocity", 0.0) == 0.0
    assert p1.at("vehicle1.acceleration", 0.0) == 0.0


def test_shapes_follow_the_times(p1: Response) -> None:
    assert p1.at("bar.rotation", 0.1).shape == ()
    assert p1.at("bar.rotation", [0.1, 0.1]).shape == (2,)
    assert p1.at("bar.rotation", np.zeros((2, 3))).shape == (2, 3)
    assert p1.at("bar.rotation", []).shape == (0,)


def test_relative_channels_are_differences(p1: Response) -> None:
    t = dense(p1, 101)
    at = p1.at
    np.testing.assert_allclose(
        at("child.relative_displacement", t), at("child.displacement", t) - at("child.seat.displacement", t), atol=1e-14
    )
    np.testing.assert_allclose(
        at("child.excursion", t), at("child.displacement", t) - at("vehicle1.displacement", t), atol=1e-14
    )
    np.testing.assert_array_equal(at("adult.excursion", t), at("adult.relative_displacement", t))
    np.testing.assert_allclose(
        at("child.seat.excursion_velocity", t), at("child.seat.velocity", t) - at("vehicle1.velocity", t), atol=1e-13
    )


def test_equations_of_motion_hold_at_all_times() -> None:
    # eqs 1-4 as printed, 10-12, and what the paper's forcing functions are made of (eqs 26, 33)
    response = simulate(load("paper-child-offset"))
    scenario = response.scenario
    assert isinstance(scenario, CrashScenario)
    bar = scenario.bar
    assert bar is not None
    l1, l2, l3, l4 = bar.lengths()
    t = dense(response, 501)
    f11, f12, f21, f22 = (response.at(f"vehicle{i}.{side}.force", t) for i in (1, 2) for side in ("right", "left"))
    seat, harness = response.at("child.seat.restraint.force", t), response.at("child.restraint.force", t)
    mass1, mass2 = scenario.vehicle1.mass, scenario.vehicle2.mass if scenario.vehicle2 else 0.0
    for residual, size in (
        (mass1 * response.at("vehicle1.acceleration", t) + f11 + f12, 1e5),  # eq 1
        (mass2 * response.at("vehicle2.acceleration", t) + f21 + f22, 1e5),  # eq 2
        (bar.mass * response.at("bar.acceleration", t) + f21 + f22 - f11 - f12, 1e5),  # eq 3
        (18.0 * response.at("child.acceleration", t) + harness, 1e3),  # eq 11
        (5.0 * response.at("child.seat.acceleration", t) + seat - harness, 1e3),  # eq 12
    ):
        np.testing.assert_allclose(residual, 0.0, atol=1e-9 * size)
    h = 1e-6
    away = np.abs(t[:, np.newaxis] - response.phases.start).min(axis=1) > 3 * h
    inner = t[away & (t > h) & (t < response.end_time - h)]
    turn = (response.at("bar.rotation_rate", inner + h) - response.at("bar.rotation_rate", inner - h)) / (2 * h)
    g11, g12, g21, g22 = (response.at(f"vehicle{i}.{side}.force", inner) for i in (1, 2) for side in ("right", "left"))
    moment = g12 * l1 - g11 * l2 + g22 * l4 - g21 * l3
    np.testing.assert_allclose(bar.inertia * turn + moment, 0.0, atol=1e-5 * np.abs(g12 * l1).max())  # eq 4


def test_forcing_functions() -> None:
    adult = simulate(load("paper-adult-full"))
    t = dense(adult, 101)
    k, c = 98.1e3, np.sqrt(98.1e3 * 80.0)
    taken_up = next(e.time for e in adult.events if e.who == "adult.restraint")
    v_star = adult.at("adult.relative_velocity", taken_up)
    f = c * (adult.at("vehicle1.velocity", t) + v_star) + k * (adult.at("vehicle1.displacement", t) + 0.005)
    np.testing.assert_allclose(adult.at("adult.forcing", t), f, rtol=1e-12)  # eq 26
    assert adult.unit("adult.forcing") == "N"

    child = simulate(load("paper-child-full"))
    network = child.network
    own = {}
    for name in ("child.restraint", "child.seat.restraint"):
        e = network.elements.index(name)
        closed = next(event.time for event in child.events if event.who == name)
        v_star = child.at(f"{name}.deflection_rate", closed)
        own[name] = network.damping[e, 0] * v_star + network.stiffness[e, 0] * network.slack[e, 0]
    e = network.elements.index("child.seat.restraint")
    f2 = network.damping[e, 0] * child.at("vehicle1.velocity", t) + network.stiffness[e, 0] * child.at(
        "vehicle1.displacement", t
    )
    f2 += own["child.seat.restraint"] - own["child.restraint"]
    np.testing.assert_allclose(child.at("child.seat.forcing", t), f2, rtol=1e-11)  # eqs 32, 33


def test_events_are_in_order_and_those_of_the_elements(response: Response) -> None:
    times = [event.time for event in response.events]
    assert times == sorted(times)
    assert {event.who for event in response.events} <= set(response.network.elements)
    assert all(0.0 <= time <= response.end_time for time in times)
    assert len({(e.time, e.who, e.what) for e in response.events}) == len(times)


def test_what_happens_in_a_wall_test() -> None:
    response = simulate(load("neon-wall"))
    story = [event.what for event in response.events if event.who == "vehicle1.right"]
    assert story[0] == "contact"
    assert story[1:-2] == [f"on to piece {n}" for n in range(2, len(story) - 1)]
    assert story[-2:] == ["starts to unload", "contact lost"]


def test_an_unknown_channel_is_answered_with_the_nearest(p1: Response) -> None:
    with pytest.raises(UnknownName, match=r"adult\.acceleration"):
        p1.at("adult.aceleration", 0.0)
    with pytest.raises(UnknownName):
        p1.peak("bar.spin")


@pytest.mark.parametrize("times", [-1e-3, 0.2001, [0.0, 0.3], np.nan])
def test_times_outside_are_refused(p1: Response, times: object) -> None:
    with pytest.raises(InvalidInput, match="times"):
        p1.at("adult.acceleration", times)


def test_vehicle_results(response: Response) -> None:
    for name, vehicle in response.vehicles.items():
        end = response.at(f"{name}.velocity", response.end_time)
        assert vehicle.delta_v == pytest.approx(end - vehicle.speed)
        assert vehicle.peak_acceleration.value <= 0.0
        assert vehicle.dynamic_crush.value >= vehicle.residual_crush >= 0.0
        if vehicle.time_to_rest is not None:
            assert response.at(f"{name}.velocity", vehicle.time_to_rest) == pytest.approx(0.0, abs=1e-9)
            assert (response.at(f"{name}.velocity", np.linspace(0.0, vehicle.time_to_rest, 999)[:-1]) > 0.0).all()


def test_occupant_results(response: Response) -> None:
    scenario = response.scenario
    if not isinstance(scenario, CrashScenario):
        assert response.occupants == {}
        assert set(response.masses) == {body.name for body in scenario.masses}
        return
    assert list(response.occupants) == [occupant.name for occupant in scenario.occupants]
    for name, occupant in response.occupants.items():
        assert occupant.peak_acceleration == response.peak(f"{name}.acceleration")
        assert occupant.excursion == response.maximum(f"{name}.excursion")


@pytest.mark.parametrize(("name", "measured"), [("neon-wall", 0.17), ("expedition-wall", 0.13)])
def test_restitution_of_the_wall_tests(name: str, measured: float) -> None:
    assert simulate(load(name)).restitution == pytest.approx(measured, abs=0.005)


def test_restitution_of_elastic_cars_is_one_and_of_parts_still_in_contact_none() -> None:
    members = {"pieces": [{"stiffness": 300e3}]}
    wall = CrashScenario(vehicle1={"mass": 1500.0, "speed": 10.0, "members": members})
    assert simulate(wall).restitution == pytest.approx(1.0, rel=1e-9)
    assert simulate(substitute(wall, {"duration": 0.05})).restitution is None
    assert simulate(load("marzbanrad-2")).restitution is None
    stands = substitute(wall, {"vehicle1.speed": 0.0})
    assert simulate(stands).restitution is None


def test_a_car_that_stands_and_is_not_met_stays() -> None:
    members = {"pieces": [{"stiffness": 300e3}]}
    response = simulate(CrashScenario(vehicle1={"mass": 1500.0, "speed": 0.0, "members": members}))
    assert response.events == ()
    assert response.peak("vehicle1.displacement").value == 0.0
    assert response.energy.residual == 0.0
    assert response.momentum.residual == 0.0


def test_summary_is_plain_data(response: Response) -> None:
    text = json.dumps(response.summary(), allow_nan=False)
    assert json.loads(text)["status"]["completed"] is True


def test_sources(response: Response) -> None:
    assert response.sources
    assert all(source.confidence in {"primary", "second-hand", "reconstructed"} for source in response.sources)


def test_csv_round_trip(p1: Response, tmp_path: Path) -> None:
    p1.to_csv(tmp_path / "p1.csv")
    with (tmp_path / "p1.csv").open(encoding="utf-8") as file:
        header = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",")
    table = p1.table()
    assert header == [f"{name} [{'s' if name == 'time' else p1.unit(name)}]" for name in table]
    for column, (name, values) in zip(rows.T, table.items(), strict=True):
        np.testing.assert_allclose(column, values, rtol=1e-11, atol=1e-300, err_msg=name)


def test_parquet_round_trip(p1: Response, tmp_path: Path) -> None:
    p1.to_parquet(tmp_path / "p1.parquet", times=[0.0, 0.05, 0.1])
    table = pq.read_table(tmp_path / "p1.parquet")
    assert table.column_names == ["time", *p1.channels]
    assert table.schema.field("adult.acceleration").metadata == {b"unit": b"m/s2"}
    np.testing.assert_array_equal(table["adult.acceleration"], p1.at("adult.acceleration", [0.0, 0.05, 0.1]))


def test_a_table_of_some_channels(p1: Response) -> None:
    table = p1.to_arrow(names=["bar.rotation"])
    assert table.column_names == ["time", "bar.rotation"]
    assert table.num_rows == 2001


def test_grids(p1: Response) -> None:
    times = p1.times()
    assert times[0] == 0.0
    assert times[-1] == p1.end_time == 0.2
    assert np.diff(times).max() <= 1e-4 * (1 + 1e-9)
    drawn = p1.drawing_times()
    assert set(p1.phases.start) <= set(drawn)
    assert (np.diff(drawn) > 0.0).all()


def test_a_response_says_what_it_is(p1: Response) -> None:
    assert repr(p1).startswith("<Response of p1: 200 ms, ")


def test_time_to_rest() -> None:
    members = {"pieces": [{"stiffness": 300e3}]}
    response = simulate(CrashScenario(vehicle1={"mass": 1500.0, "speed": 10.0, "members": members}))
    quarter = 0.5 * math.pi / math.sqrt(600e3 / 1500.0)
    assert response.time_to_rest("vehicle1") == pytest.approx(quarter, rel=1e-10)
    assert simulate(load("marzbanrad-2")).time_to_rest("vehicle") is None


@pytest.mark.parametrize("name", ["p1", "example-offset", "example-restraints", "sled-fmvss-208", "marzbanrad-2"])
def test_many_channels_at_once_are_what_each_is_alone(name: str) -> None:
    """To round-off: 1e-12 of the channel's largest value."""
    response = simulate(load(name))
    times = np.concatenate((response.drawing_times(), [0.1, 0.05, 0.0]))  # in any order
    together = response.sampled(response.channels, times)
    assert together.shape == (len(response.channels), times.size)
    for channel, values in zip(response.channels, together, strict=True):
        alone = response.at(channel, times)
        np.testing.assert_allclose(values, alone, rtol=0.0, atol=1e-12 * max(np.abs(alone).max(), 1e-300), err_msg=channel)
    assert response.sampled([], times).shape == (0, times.size)
    with pytest.raises(UnknownName, match=r"vehicle1\.velocity|velocity"):
        response.sampled(["vehicle1.velocty"], times)
