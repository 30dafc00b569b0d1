"""Extremes give right answers, or a status that says what happened: never a silent NaN, never an endless loop."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ridedown import Response, load, simulate, simulate_many
from ridedown.scenario import CrashScenario, NetworkScenario, lower, substitute
from ridedown.status import Status
from tests.compare import assert_alike

MEMBERS = {"pieces": [{"stiffness": 150e3, "until": 0.3}, {"stiffness": 550e3}]}


def wall(members: dict[str, Any], *, speed: float = 10.0, duration: float = 0.2, **more: Any) -> Response:
    vehicle = {"mass": 1000.0, "speed": speed, "members": members}
    return simulate(CrashScenario(vehicle1=vehicle, duration=duration, **more))


def assert_sound(scenario: CrashScenario | NetworkScenario, *, status: Status | None = Status.COMPLETED) -> Response:
    """It ends as it should, adds up, and holds nothing but numbers, alone and in a table."""
    response = simulate(scenario, throw=False)
    if status is not None:
        assert response.status is status
    assert response.energy.residual == pytest.approx(0.0, abs=1e-9)
    assert response.momentum.residual == pytest.approx(0.0, abs=1e-9)
    many = simulate_many(scenario, {"duration": [scenario.duration]})
    assert many.status[0] == response.status.value
    for name, column in many.items():
        assert np.isfinite(column).all(), name
    return response


@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 1e3, 1e6])
def test_stiffness_ratios(ratio: float) -> None:
    k1, k2 = (1e3, 1e3 * ratio) if ratio > 1.0 else (1e9, 1e9 * ratio)
    until = 0.1 if ratio > 1.0 else 1e-4
    response = wall({"pieces": [{"stiffness": k1 / 2, "until": until}, {"stiffness": k2 / 2}]}, duration=0.5)
    rest, force = 0.5 * 1000.0 * 10.0**2 - 0.5 * k1 * until**2, k1 * until
    beyond = (math.sqrt(force**2 + 2.0 * k2 * rest) - force) / k2
    assert response.maximum("vehicle1.right.deflection").value == pytest.approx(until + beyond, rel=1e-10)
    assert -response.minimum("vehicle1.acceleration").value == pytest.approx((force + k2 * beyond) / 1000.0, rel=1e-10)
    assert response.at("vehicle1.velocity", 0.5) == pytest.approx(-10.0, rel=1e-9) or beyond > 1.0
    assert response.energy.residual == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("law", ["threshold", "kelvin-voigt", "linear"])
def test_no_damping_at_all(law: str) -> None:
    belt = {"stiffness": 80e3, "slack": 0.01, "damping": 0.0, "law": law}
    response = wall(MEMBERS, occupants=[{"kind": "adult", "mass": 80.0, "restraint": belt, "coupled": True}])
    assert response.energy.elements["adult.restraint"].dissipated == pytest.approx(0.0, abs=1e-9 * response.energy.initial)


@pytest.mark.parametrize("ratio", [1.0, 2.0, 10.0])
@pytest.mark.parametrize("law", ["threshold", "kelvin-voigt", "linear"])
def test_overdamped(law: str, ratio: float) -> None:
    full = load("paper-adult-full")
    belt = {"stiffness": 98.1e3, "slack": 0.005, "damping_ratio": ratio, "law": law}
    adult = {"kind": "adult", "mass": 80.0, "restraint": belt}
    data = {"vehicle1": full.vehicle1, "vehicle2": full.vehicle2, "bar": full.bar}
    assert_sound(CrashScenario(**data, occupants=[adult, adult | {"coupled": True}]))


@pytest.mark.parametrize("speeds", [(0.0, 13.0), (13.0, 0.0), (0.0, 0.0), (1e-9, 1e-9), (80.0, 0.0)])
def test_vehicles_that_stand_or_hardly_move(speeds: tuple[float, float]) -> None:
    p1 = substitute(load("example-offset"), {"vehicle1.speed": speeds[0], "vehicle2.speed": speeds[1]})
    response = simulate(p1, throw=False)
    if speeds == (0.0, 0.0):
        assert response.completed
        assert response.events == ()
        assert response.energy.initial == 0.0
    elif sum(speeds) > 1e-6:
        assert_sound(p1, status=None)


def grazed(slack: float) -> NetworkScenario:
    return NetworkScenario(
        duration=0.5,
        masses=[{"name": "m", "mass": 1000.0, "speed": 10.0}],
        elements=[
            {"name": "spring", "between": ["wall", "m"], "stiffness": 400e3},
            {"name": "tie", "between": ["wall", "m"], "law": "kelvin-voigt", "stiffness": 1e6, "damping": 1e4, "slack": slack},
        ],
    )


@pytest.mark.parametrize("law", ["kelvin-voigt", "threshold"])
@pytest.mark.parametrize("miss", [0.0, 1e-16, -1e-16, 1e-14, -1e-14, 1e-12, -1e-12, 1e-9, -1e-9, 1e-6, -1e-6])
def test_grazing_contact(miss: float, law: str) -> None:
    # the mass swings out to 0.5 m: the tie starts right there
    scenario = grazed(0.5 + miss)
    tie = scenario.elements[1].model_copy(update={"law": law})
    scenario = scenario.model_copy(update={"elements": (scenario.elements[0], tie)})
    response = assert_sound(scenario)
    touched = [event for event in response.events if event.who == "tie"]
    if miss >= 1e-9:
        assert touched == []
    if miss <= -1e-9:
        assert touched[0].what == "slack taken up"
        assert response.maximum("tie.force").value > 0.0
    assert response.at("m.velocity", 0.5) == pytest.approx(10.0 * math.cos(20.0 * 0.5), abs=max(1e-9, 1e4 * abs(miss)))


def test_coincident_events_are_the_limit_of_events_close_together() -> None:
    p1 = load("p1")
    for path in ("adult.restraint.slack", "child.restraint.slack", "vehicle1.members.pieces.0.until"):
        value = next(p for p in (0.005, 0.356) if ("until" in path) == (p > 0.1))
        apart = substitute(p1, {path: value * (1.0 + 1e-11)})
        assert_alike(simulate(p1), simulate(apart), rtol=1e-8)


def test_all_at_once() -> None:
    """Everything alike, and no slack anywhere: twelve contacts at time 0."""
    belt = {"stiffness": 98.1e3, "damping_ratio": 0.5, "slack": 0.0}
    adult = {"kind": "adult", "mass": 80.0, "restraint": belt}
    child = {"kind": "child", "mass": 18.0, "restraint": belt, "seat": {"mass": 5.0, "restraint": belt}}
    car = {"mass": 1500.0, "speed": 13.33, "members": MEMBERS | {"initial_force": 10e3}}
    bar = {"mass": 40.0, "inertia": 157.0, "rail_spacing": 1.1}
    people = [occupant | {"vehicle": n} for occupant in (adult, child) for n in (1, 2)]
    response = assert_sound(CrashScenario(vehicle1=car, vehicle2=car, bar=bar, occupants=people))
    assert response.peak("child.acceleration").value == pytest.approx(response.peak("child2.acceleration").value, rel=1e-8)
    assert response.peak("adult.acceleration").value == pytest.approx(response.peak("adult2.acceleration").value, rel=1e-8)


def test_an_initial_force_on_one_side_only() -> None:
    car = {"mass": 1500.0, "speed": 13.33, "right": MEMBERS | {"initial_force": 40e3}, "left": MEMBERS}
    bar = {"mass": 40.0, "inertia": 157.0, "rail_spacing": 1.1, "lateral_offset": 0.3}
    response = assert_sound(CrashScenario(vehicle1=car, vehicle2=car | {"speed": 5.0}, bar=bar), status=None)
    assert response.at("vehicle1.right.force", 0.0) == pytest.approx(40e3)
    assert response.at("vehicle1.left.force", 0.0) == 0.0


@pytest.mark.parametrize("slack", [10.0, 1e300])
def test_a_slack_that_is_never_taken_up(slack: float) -> None:
    response = assert_sound(substitute(load("p1"), {"adult.restraint.slack": slack}))
    assert response.maximum("adult.restraint.force").value == 0.0
    assert response.at("adult.velocity", 0.2) == pytest.approx(13.33, rel=1e-14)
    assert not any(event.who == "adult.restraint" for event in response.events)


@pytest.mark.parametrize("value", [1e-3, 1e6, 1e12, 1e300])
@pytest.mark.parametrize("path", ["vehicle1.mass", "bar.mass", "adult.mass", "child.seat.mass", "bar.inertia"])
def test_masses_from_nothing_to_everything(path: str, value: float) -> None:
    if path in {"adult.mass", "child.seat.mass", "bar.inertia"} and value < 1.0:
        value = 0.05  # lighter still takes ten thousands of steps
    assert_sound(substitute(load("p1"), {path: value}))


def test_a_light_bar_between_stiff_members() -> None:
    stiff = {"pieces": [{"stiffness": 5e6}]}
    car = {"mass": 1500.0, "speed": 13.33, "members": stiff}
    bar = {"mass": 0.1, "rail_spacing": 1.1, "speed": 3.0}
    scenario = CrashScenario(vehicle1=car, vehicle2=car | {"mass": 2500.0}, bar=bar, duration=0.05)
    response = assert_sound(scenario)
    # the members in series between the two cars, as if there were no bar
    reduced, stiffness = 1500.0 * 2500.0 / 4000.0, 5e6
    rate = math.sqrt(stiffness / reduced)
    peak = rate * 26.66 * reduced / 1500.0
    assert -response.minimum("vehicle1.acceleration").value == pytest.approx(peak, rel=0.02)


@pytest.mark.parametrize("duration", [1e-300, 1e-12, 1e-6, 10.0])
@pytest.mark.parametrize("name", ["example-wall", "navigator-neon", "marzbanrad-2", "paper-adult-full"])
def test_durations_from_an_instant_to_ten_seconds(name: str, duration: float) -> None:
    scenario = substitute(load(name), {"duration": duration})
    response = assert_sound(scenario)
    assert response.end_time == pytest.approx(duration, rel=1e-14)


@pytest.mark.parametrize("speed", [1e-3, 1.0, 300.0])
def test_speeds_from_a_crawl_to_that_of_sound(speed: float) -> None:
    response = assert_sound(substitute(load("example-wall"), {"vehicle1.speed": speed}))
    assert response.maximum("vehicle1.right.deflection").value > 0.0


def test_what_cannot_be_counted_is_a_status() -> None:
    for path, value in (("vehicle1.mass", 1e-300), ("bar.mass", 1e-300), ("adult.restraint.stiffness", 1e300)):
        values = {"vehicle2.mass": 1400.0, path: value}  # between two alike cars the bar would not move
        response = simulate(substitute(load("p1"), values), throw=False)
        assert response.status in {Status.NOT_FINITE, Status.TOO_MANY_STEPS}, path
        many = simulate_many(load("p1"), values)
        assert many.status[0] == response.status.value


def test_a_lowered_network_holds_what_was_given() -> None:
    network = lower(substitute(load("p1"), {"adult.restraint.slack": 1e300}))
    assert network.slack.max() == 1e300
