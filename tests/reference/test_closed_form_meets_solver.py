"""The paper's closed form (eqs 25-33), driven by the solved vehicle motion, against the solver's own occupants."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

from ridedown import CrashScenario, Response, simulate
from ridedown.solver import closed_form
from ridedown.solver.closed_form import Motion, State, Tie, VehicleMotion

MEMBERS = {"pieces": [{"stiffness": 118.2e3, "until": 0.356}, {"stiffness": 465e3}]}
BELT = {"stiffness": 98.1e3, "damping_ratio": 0.5, "slack": 0.005}
HARNESS = {"stiffness": 49e3, "damping_ratio": 0.5, "slack": 0.005}
MOUNTING = {"stiffness": 50e3, "damping_ratio": 0.5, "slack": 0.005}


def crash(law: str, *, offset: float) -> Response:
    car = {"mass": 1500.0, "speed": 13.33, "members": MEMBERS}
    occupants: list[dict[str, Any]] = [
        {"kind": "adult", "mass": 80.0, "restraint": BELT | {"law": law}},
        {
            "kind": "child",
            "mass": 18.0,
            "restraint": HARNESS | {"law": law},
            "seat": {"mass": 5.0, "restraint": MOUNTING | {"law": law}},
        },
    ]
    bar = {"mass": 40.0, "inertia": 157.0, "rail_spacing": 1.1, "lateral_offset": offset}
    return simulate(CrashScenario(vehicle1=car, vehicle2=car, bar=bar, occupants=occupants))


def vehicle_of(response: Response) -> VehicleMotion:
    phases = response.phases
    lasting = phases.length > 0.0
    position = phases.position[lasting][:, :, response.network.coordinate("vehicle1")]
    return VehicleMotion(np.append(phases.start[lasting], phases.end), position)


def tie(restraint: dict[str, float], mass: float, v_star: float, *, damped: bool = True) -> Tie:
    damping = 2.0 * restraint["damping_ratio"] * np.sqrt(restraint["stiffness"] * mass) if damped else 0.0
    return Tie(restraint["stiffness"], damping, restraint["slack"], v_star)


def state(response: Response, body: str, time: float) -> State:
    return State(*(float(response.at(f"{body}.{q}", [time])[0]) for q in ("displacement", "velocity")))


def first(response: Response, who: str, whats: Iterable[str], after: float = 0.0) -> float:
    times = [event.time for event in response.events if event.who == who and event.what in whats and event.time > after]
    return min(times, default=response.end_time)


def assert_meets(motion: Motion, response: Response, body: str, times: np.ndarray[Any, Any]) -> None:
    for quantity in ("displacement", "velocity", "acceleration"):
        theirs = response.at(f"{body}.{quantity}", times)
        np.testing.assert_allclose(getattr(motion, quantity), theirs, rtol=0.0, atol=1e-9 * np.abs(theirs).max())


@pytest.mark.parametrize("offset", [0.0, 0.886], ids=["full", "offset"])
def test_adult_on_a_linear_restraint_all_through(offset: float) -> None:
    response = crash("linear", offset=offset)
    times = np.linspace(0.0, response.end_time, 301)[1:-1]
    belt = tie(BELT, 80.0, 0.0)
    motion = closed_form.adult(vehicle_of(response), 80.0, belt, engaged_at=0.0, start=State(0.0, 13.33), times=times)
    assert_meets(motion, response, "adult", times)
    np.testing.assert_allclose(
        closed_form.adult_forcing(vehicle_of(response), belt, times), response.at("adult.forcing", times), rtol=1e-9
    )


@pytest.mark.parametrize("offset", [0.0, 0.886], ids=["full", "offset"])
def test_child_on_linear_restraints_all_through(offset: float) -> None:
    response = crash("linear", offset=offset)
    times = np.linspace(0.0, response.end_time, 301)[1:-1]
    start = State(0.0, 13.33)
    child, seat = closed_form.child_in_seat(
        vehicle_of(response),
        18.0,
        tie(HARNESS, 18.0, 0.0),
        seat_mass=5.0,
        seat=tie(MOUNTING, 5.0, 0.0),
        engaged_at=0.0,
        child_start=start,
        seat_start=start,
        times=times,
    )
    assert_meets(child, response, "child", times)
    assert_meets(seat, response, "child.seat", times)


@pytest.mark.parametrize("law", ["threshold", "kelvin-voigt"])
@pytest.mark.parametrize("offset", [0.0, 0.886], ids=["full", "offset"])
def test_adult_while_the_belt_stays_engaged(law: str, offset: float) -> None:
    response = crash(law, offset=offset)
    vehicle = vehicle_of(response)
    engaged_at = first(response, "adult.restraint", ["slack taken up"])
    until = first(
        response,
        "adult.restraint",
        ["damping ends", "slack again", "damping outweighs the spring: no pull"],
        engaged_at,
    )
    assert until - engaged_at > 0.02  # s: a phase worth comparing
    v_star = float(response.at("adult.relative_velocity", [engaged_at])[0]) if law == "threshold" else 0.0
    times = np.linspace(engaged_at, until, 101)[1:-1]
    start = state(response, "adult", engaged_at)
    motion = closed_form.adult(vehicle, 80.0, tie(BELT, 80.0, v_star), engaged_at=engaged_at, start=start, times=times)
    assert_meets(motion, response, "adult", times)
    if law == "threshold":  # eq 17: from here on the damper is out
        slack_again = first(response, "adult.restraint", ["slack again", "damping sets in"], until)
        times = np.linspace(until, slack_again, 101)[1:-1]
        undamped = tie(BELT, 80.0, v_star, damped=False)
        motion = closed_form.adult(
            vehicle, 80.0, undamped, engaged_at=until, start=state(response, "adult", until), times=times
        )
        assert_meets(motion, response, "adult", times)


@pytest.mark.parametrize("offset", [0.0, 0.886], ids=["full", "offset"])
def test_child_while_both_restraints_stay_engaged(offset: float) -> None:
    response = crash("threshold", offset=offset)
    seat_at, harness_at = (first(response, f"{who}.restraint", ["slack taken up"]) for who in ("child.seat", "child"))
    both = max(seat_at, harness_at)
    ends = ["damping ends", "slack again"]
    until = min(first(response, f"{who}.restraint", ends, both) for who in ("child.seat", "child"))
    times = np.linspace(both, until, 101)[1:-1]
    v_seat = float(response.at("child.seat.relative_velocity", [seat_at])[0])
    v_child = float(response.at("child.relative_velocity", [harness_at])[0])
    child, seat = closed_form.child_in_seat(
        vehicle_of(response),
        18.0,
        tie(HARNESS, 18.0, v_child),
        seat_mass=5.0,
        seat=tie(MOUNTING, 5.0, v_seat),
        engaged_at=both,
        child_start=state(response, "child", both),
        seat_start=state(response, "child.seat", both),
        times=times,
    )
    assert_meets(child, response, "child", times)
    assert_meets(seat, response, "child.seat", times)
