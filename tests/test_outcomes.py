"""Outcomes: their names, units and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown import Outcomes, load, simulate, simulate_many
from ridedown.errors import InvalidInput, UnknownName
from ridedown.network import channels
from ridedown.outcomes import wanted
from ridedown.scenario import NetworkScenario, lower, substitute
from ridedown.status import Status


@pytest.fixture(scope="module")
def some() -> Outcomes:
    return simulate_many(load("example-offset"), {"vehicle1.speed": [8.0, 12.0, 16.0]})


def test_a_mapping_of_columns(some: Outcomes) -> None:
    assert len(some) == len(list(some)) == len(some.units)
    assert all(some[name].shape == (3,) and some[name].dtype == np.float64 for name in some)
    assert "driver.acceleration.peak" in some
    assert some.completed.all()
    assert some.failures() == {}
    np.testing.assert_array_equal(some.status, Status.COMPLETED.value)
    np.testing.assert_array_equal(some.time, 0.2)


def test_units(some: Outcomes) -> None:
    units = some.units
    assert units["driver.acceleration.peak"] == "m/s2"
    assert units["driver.acceleration.peak_time"] == "s"
    assert units["vehicle1.right.absorbed"] == "J"
    assert units["vehicle1.right.residual"] == "m"
    assert units["bar.rotation.peak"] == "rad"
    assert units["vehicle1.velocity.final"] == "m/s"


def test_every_known_outcome_can_be_asked_for() -> None:
    scenario = load("example-wall")
    network = lower(scenario)
    kinds = ("peak", "max", "min", "peak_time", "max_time", "min_time")
    names = [f"{channel}.{kind}" for channel in channels(network) for kind in kinds]
    names += ["energy.initial", "energy.final", "vehicle1.velocity.final", "vehicle1.left.residual", "adult.restraint.absorbed"]
    many = simulate_many(scenario, {"vehicle1.speed": [10.0, 15.0]}, outcomes=names)
    assert list(many) == names
    for name in names:
        assert np.isfinite(many[name]).all(), name


def test_only_what_is_asked_for_in_that_order() -> None:
    names = ["adult.excursion.max", "energy.final", "adult.acceleration.peak"]
    many = simulate_many(load("p1"), {"vehicle1.speed": [10.0]}, outcomes=names)
    assert list(many) == names
    assert list(simulate_many(load("p1"), {}, outcomes=[])) == []


@pytest.mark.parametrize(
    ("asked", "nearest"),
    [
        ("adult.acceleration.peek", r"adult\.acceleration\.peak"),
        ("adult.excursion.maximum", r"adult\.excursion\.max"),
        ("energy", r"energy\."),
        ("vehicle1.right.residual", "outcome"),  # an elastic member keeps none
        ("adult.acceleration.final", "outcome"),
    ],
)
def test_unknown_outcomes_are_refused_with_the_nearest(asked: str, nearest: str) -> None:
    with pytest.raises(UnknownName, match=nearest):
        simulate_many(load("p1"), {"vehicle1.speed": [10.0]}, outcomes=[asked])


def test_an_outcome_that_was_not_asked_for(some: Outcomes) -> None:
    with pytest.raises(UnknownName, match="outcome"):
        some["driver.acceleration.max"]


def test_the_usual_choice_suits_every_network() -> None:
    for name in ("p1", "example-wall", "marzbanrad-2", "navigator-neon"):
        network = lower(load(name))
        plan = wanted(network, None)
        assert len(set(plan.names)) == len(plan.names)
        for body, rotation in zip(network.coordinates, network.is_rotation, strict=True):
            assert f"{body}.peak" in plan.names if rotation else f"{body}.acceleration.peak" in plan.names


def test_failures_are_counted_by_their_sentence() -> None:
    members = [f"vehicle{n}.members.pieces.1.stiffness" for n in (1, 2)]
    many = simulate_many(load("p1"), dict.fromkeys(members, np.array([465e3, 0.0, 465e3, 0.0])))
    np.testing.assert_array_equal(many.completed, [True, False, True, False])
    assert many.failures() == {Status.BAR_TURNED.sentence: 2}
    assert (many.time[~many.completed] < 0.2).all()


def test_a_stopped_crash_keeps_the_outcomes_of_the_part_computed() -> None:
    members = {f"vehicle{n}.members.pieces.1.stiffness": 0.0 for n in (1, 2)}
    many = simulate_many(load("p1"), {path: [value] for path, value in members.items()})
    response = simulate(substitute(load("p1"), members), throw=False)
    assert many.time[0] == pytest.approx(response.end_time, rel=1e-12)
    assert many["adult.excursion.max"][0] == pytest.approx(response.maximum("adult.excursion").value, rel=1e-12)


def test_energy_of_the_start() -> None:
    many = simulate_many(load("example-wall"), {"vehicle1.speed": [10.0, 20.0]})
    np.testing.assert_allclose(many["energy.initial"], 0.5 * 1580.0 * np.array([10.0, 20.0]) ** 2, rtol=1e-14)


@pytest.mark.parametrize("count", [17, 333, 2001])  # none in most steps, about eight in each, and many
def test_samples_are_the_response_at_those_times(count: int) -> None:
    scenario, times = load("p1"), np.linspace(0.0, 0.2, count)
    names = [
        "adult.acceleration",
        "adult.excursion",
        "child.velocity",
        "vehicle1.right.force",
        "child.restraint.deflection_rate",
    ]
    speeds = np.linspace(8.0, 14.0, 100)  # more crashes than lanes
    many = simulate_many(scenario, {"vehicle1.speed": speeds}, outcomes=[], samples=names, times=times)
    for row in (0, 41, 99):
        response = simulate(substitute(scenario, {"vehicle1.speed": speeds[row]}))
        for name in names:
            scale = abs(response.peak(name).value)
            np.testing.assert_allclose(many.samples[name][row], response.at(name, times), rtol=0.0, atol=1e-11 * scale)


def test_samples_of_a_crash_that_stops_end_there() -> None:
    # its bar turns too far in one crash, and not in the others
    scenario, times = load("p1"), np.linspace(0.0, 0.2, 101)
    table = {"bar.lateral_offset": [0.1, 0.886, 0.1], "bar.mass": [20.0, 20.0, 20.0], "vehicle1.speed": [13.0, 60.0, 13.0]}
    many = simulate_many(scenario, table, outcomes=[], samples=["adult.velocity"], times=times)
    known = np.isfinite(many.samples["adult.velocity"])
    np.testing.assert_array_equal(known, times < many.time[:, np.newaxis] + 1e-12)
    assert known.all(axis=1).tolist() == [True, False, True]


def test_a_sample_at_an_event_is_the_value_just_after_it() -> None:
    scenario = load("p1")
    response = simulate(scenario)
    taken_up = next(event.time for event in response.events if event.who == "adult.restraint")
    times = [0.0, np.nextafter(taken_up, 0.0), np.nextafter(taken_up, 1.0)]
    force = simulate_many(scenario, {}, outcomes=[], samples=["adult.restraint.force"], times=times).samples
    before, after = force["adult.restraint.force"][0, 1:]
    assert before == 0.0
    assert after > 100.0  # the damper engages at once


def test_the_end_of_a_crash_is_sampled_however_its_last_step_is_rounded() -> None:
    # one that leaves the wall early goes on to the end in a single step: to 0.11 s, give or take the last bit
    wall = NetworkScenario(
        duration=0.11,
        masses=[{"name": "m", "mass": 100.0, "speed": 5.0}],
        elements=[{"name": "front", "between": ["wall", "m"], "law": "kelvin-voigt", "stiffness": 1e7}],
    )
    stiffness = np.geomspace(3e6, 1e9, 500)
    many = simulate_many(
        wall, {"front.stiffness": stiffness}, outcomes=["m.velocity.final"], samples=["m.velocity"], times=[0.0, 0.11]
    )
    assert many.completed.all()
    np.testing.assert_allclose(many.samples["m.velocity"], np.array([[5.0, -5.0]] * 500), rtol=1e-9)


@pytest.mark.parametrize(
    ("samples", "times", "says"),
    [
        (["adult.acceleration"], None, "times: got samples without times"),
        ([], [0.0], "samples: got times without samples"),
        (["adult.acceleration"], [0.0, 0.3], "need rising times from 0 to 0.2 s"),
        (["adult.acceleration"], [0.1, 0.1], "need rising times"),
        (["adult.aceleration"], [0.1], "Did you mean"),
    ],
)
def test_samples_that_cannot_be(samples: list[str], times: list[float] | None, says: str) -> None:
    with pytest.raises((InvalidInput, UnknownName), match=says):
        simulate_many(load("p1"), {}, samples=samples, times=times)


def test_what_a_load_limiter_let_out_and_what_stays_of_a_restraint() -> None:
    scenario = load("example-restraints")
    limits = [3.5e3, 5.5e3]
    many = simulate_many(scenario, {"driver.shoulder-belt.load_limiter.force": limits})
    for row, limit in enumerate(limits):
        response = simulate(substitute(scenario, {"driver.shoulder-belt.load_limiter.force": limit}))
        assert many["driver.shoulder-belt.paid_out"][row] == pytest.approx(
            response.restraints["driver.shoulder-belt"].paid_out, rel=1e-9
        )
    assert many["driver.shoulder-belt.paid_out"][0] > many["driver.shoulder-belt.paid_out"][1] > 0.0
    assert "driver.knee_bolster.paid_out" not in list(many)
