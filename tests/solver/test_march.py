"""How a march ends: every status, and what it leaves behind."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import Response, load, simulate, simulate_many
from ridedown.errors import SimulationStopped
from ridedown.scenario import CrashScenario, NetworkScenario, substitute
from ridedown.solver.march import Stop
from ridedown.status import Status
from tests import samples
from tests.samples import examples


def p1(**values: float) -> CrashScenario:
    return substitute(load("p1"), {path.replace("__", "."): value for path, value in values.items()})


def overturning() -> CrashScenario:
    """The members' second pieces give way."""
    return substitute(load("p1"), {f"vehicle{n}.members.pieces.1.stiffness": 0.0 for n in (1, 2)})


def at_rest_on_a_jump() -> CrashScenario:
    """The bar stands against the members of a vehicle that stands: they push back only once they are crushed."""
    soft, jump = {"pieces": [{"stiffness": 200e3}]}, {"initial_force": 20e3, "pieces": [{"stiffness": 200e3}]}
    return CrashScenario(
        vehicle1={"mass": 1500.0, "speed": 10.0, "members": soft},
        vehicle2={"mass": 1500.0, "speed": 0.0, "members": jump},
        bar={"mass": 40.0, "rail_spacing": 1.1, "speed": 0.0},
    )


def stiff() -> NetworkScenario:
    return NetworkScenario(
        duration=0.2,
        masses=[{"name": "m", "mass": 1e-3, "speed": 10.0}],
        elements=[{"between": ["wall", "m"], "stiffness": 1e12}],
    )


def assert_usable(response: Response) -> None:
    """The part computed so far can be read in full, and holds no NaN."""
    assert math.isfinite(response.end_time)
    for channel in response.channels:
        assert np.isfinite(response.at(channel, np.linspace(0.0, response.end_time, 7))).all(), channel
        assert math.isfinite(response.peak(channel).value), channel
    assert response.energy.residual == pytest.approx(0.0, abs=1e-9)
    response.summary()


@pytest.mark.parametrize(
    ("scenario", "status"),
    [
        (overturning(), Status.BAR_TURNED),
        (p1(bar__mass=1e-300, vehicle2__mass=1400.0), Status.NOT_FINITE),  # between two alike cars it would not move
        (p1(vehicle1__mass=1e-300), Status.NOT_FINITE),
        (at_rest_on_a_jump(), Status.CHATTER),
        (stiff(), Status.TOO_MANY_STEPS),
    ],
    ids=["bar turned", "bar of no mass", "vehicle of no mass", "at rest on a jump", "too stiff"],
)
def test_a_crash_that_stops_says_why_and_leaves_what_it_has(scenario: Any, status: Status) -> None:
    with pytest.raises(SimulationStopped) as stopped:
        simulate(scenario)
    assert status.sentence in str(stopped.value)
    response = stopped.value.response
    assert response.status is status
    assert not response.completed
    assert response.end_time < scenario.duration
    assert_usable(response)
    assert simulate(scenario, throw=False).end_time == response.end_time
    many = simulate_many(scenario, {"duration": [scenario.duration] * 2})
    assert many.failures() == {status.sentence: 2}
    for name, column in many.items():
        assert np.isfinite(column).all(), name


def test_the_bar_stops_short_of_its_pole() -> None:
    response = simulate(overturning(), throw=False)
    assert 1.3 < abs(response.peak("bar.rotation").value) < math.pi / 2.0


@pytest.mark.parametrize("lever_arm", ["printed", "work-conjugate"])
@pytest.mark.parametrize("inertia", [180.0, 300.0, 1000.0])
def test_a_bar_under_constant_forces_turns_as_its_tangent_does(lever_arm: str, inertia: float) -> None:
    # nothing but tan(theta) goes on for ever here: what looks at positions alone would step to the end
    flat, spring = {"points": [[0.0, 40e3], [0.1, 40e3]]}, {"pieces": [{"stiffness": 700e3}]}
    car = {"mass": 2000.0, "speed": 13.33, "right": flat, "left": spring}
    bar = {"mass": 40.0, "inertia": inertia, "rail_spacing": 1.1, "lateral_offset": 0.6, "lever_arm": lever_arm}
    assert_members_follow(simulate(CrashScenario(vehicle1=car, vehicle2=car, bar=bar), throw=False))


def test_a_bar_turned_by_a_constant_moment_from_rest() -> None:
    # theta is a series in t^2, t^6, t^10, ...: the last coefficients looked at may all be zero
    right = {"pieces": [{"stiffness": 0.0, "until": 0.3}, {"stiffness": 325e3}]}
    left = right | {"initial_force": 20e3}
    car = {"mass": 1500.0, "speed": 5.0, "right": right, "left": left}
    bar = {"mass": 40.0, "inertia": 229.0, "rail_spacing": 1.1}
    assert_members_follow(simulate(CrashScenario(vehicle1=car, vehicle2=car, bar=bar), throw=False))


@examples(40)
@given(seed=st.integers(0, 10**6))
def test_members_follow_the_bar(seed: int) -> None:
    data = samples.crash_data(np.random.default_rng(seed), wall=False)
    data["bar"] |= {"inertia": 157.0, "lateral_offset": 0.6}
    assert_members_follow(simulate(CrashScenario(**data), throw=False))


def assert_members_follow(response: Response) -> None:
    """Deflections are those of eqs 5-8, at every time."""
    assert isinstance(response.scenario, CrashScenario)
    assert response.scenario.bar is not None
    times = np.linspace(0.0, response.end_time, 501)
    bar, tangent = response.at("bar.displacement", times), np.tan(response.at("bar.rotation", times))
    l1, l2, l3, l4 = response.scenario.bar.lengths()
    for member, sign, arm in (
        ("vehicle1.right", -1.0, -l2),
        ("vehicle1.left", -1.0, l1),
        ("vehicle2.right", 1.0, -l3),
        ("vehicle2.left", 1.0, l4),
    ):
        exact = response.at(f"{member.split('.')[0]}.displacement", times) + sign * bar + arm * tangent
        np.testing.assert_allclose(response.at(f"{member}.deflection", times), exact, rtol=0.0, atol=1e-9)
    assert response.energy.residual == pytest.approx(0.0, abs=1e-9)


def test_parts_that_move_together_until_one_is_stopped_do_not_chatter() -> None:
    # the third and fourth mass part by less than rounding before the fourth meets the wall
    chain = NetworkScenario(
        duration=0.1,
        masses=[{"name": f"m{i}", "mass": mass, "speed": 8.7} for i, mass in ((1, 1300.0), (2, 32.0), (3, 250.0), (4, 53.0))],
        elements=[
            {"name": "front", "between": ["wall", "m1"], "law": "kelvin-voigt", "stiffness": 20e3},
            {"name": "a", "between": ["m1", "m2"], "pieces": [{"stiffness": 500e3}]},
            {"name": "b", "between": ["m2", "m3"], "pieces": [{"stiffness": 130e3}]},
            {"name": "c", "between": ["m3", "m4"], "law": "kelvin-voigt", "stiffness": 32e3},
            {
                "name": "late",
                "law": "kelvin-voigt",
                "between": ["wall", "m4"],
                "stiffness": 7650.0,
                "damping": 500.0,
                "slack": 0.01,
            },
        ],
    )
    many = simulate_many(chain, {"late.slack": np.geomspace(1e-4, 0.1, 4000)})
    assert many.failures() == {}


def test_two_members_that_give_way_in_turn_settle() -> None:
    # a light bar stands against two jumps, and is pushed and turned: it leans on one of them, and leaves the other
    jump = {"initial_force": 20e3, "pieces": [{"stiffness": 100e3}]}
    crash = CrashScenario(
        duration=0.1,
        vehicle1={
            "mass": 1325.0,
            "speed": 5.0,
            "right": {"initial_force": 20e3, "pieces": [{"stiffness": 400e3}]},
            "left": {"pieces": [{"stiffness": 160e3}]},
        },
        vehicle2={"mass": 1500.0, "speed": 0.0, "members": jump},
        bar={
            "mass": 16.0,
            "inertia": 157.0,
            "rail_spacing": 1.1,
            "lateral_offset": 0.6,
            "lever_arm": "printed",
            "speed": 0.0,
        },
    )
    response = simulate(crash)
    assert_members_follow(response)
    soon = 0.5e-3
    assert response.at("vehicle2.right.deflection", soon) < 0.0
    assert response.at("vehicle2.right.force", soon) == 0.0
    assert response.at("vehicle2.left.deflection", soon) > 0.0
    assert response.at("vehicle2.left.force", soon) > 20e3


def test_every_stop_but_a_full_record_is_a_status() -> None:
    assert {stop.value for stop in Stop} - {Stop.RECORD_FULL.value} == {status.value for status in Status}
    for status in Status:
        assert status.sentence


def test_a_record_that_is_full_is_made_larger() -> None:
    response = simulate(load("marzbanrad-5"))
    assert response.phases.start.size > 256
    assert response.completed
