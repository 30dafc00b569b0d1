"""Energy and momentum add up, for crashes and networks of every kind, to 1e-9 of what there was at the start."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import Response, load, simulate
from ridedown.scenario import CrashScenario
from tests import samples
from tests.samples import examples

CLOSE = 1e-9  # of the initial energy, and of the sum of the bodies' initial momenta
SEEDS = st.integers(0, 10**6)
STIFFENING = {"pieces": [{"stiffness": 118.2e3, "until": 0.356}, {"stiffness": 465e3}]}
TABLE = {"points": [[0.0, 13.18e3], [0.1171, 134.75e3], [0.2342, 145.71e3], [0.3513, 145.71e3], [0.4684, 336.12e3]]}
PLASTIC = {"unloading": "plastic", "unloading_stiffness": 5e6}


def assert_balanced(response: Response) -> None:
    assert response.energy.residual == pytest.approx(0.0, abs=CLOSE)
    assert response.momentum.residual == pytest.approx(0.0, abs=CLOSE)


@examples(40)
@given(seed=SEEDS)
def test_any_crash(seed: int) -> None:
    response = simulate(samples.crash(seed), throw=False)
    assert_balanced(response)
    energy = response.energy
    for name, element in energy.elements.items():
        assert element.dissipated >= -CLOSE * energy.initial, name
        assert element.stored >= 0.0, name


@examples(40)
@given(seed=SEEDS)
def test_any_network(seed: int) -> None:
    assert_balanced(simulate(samples.network(seed), throw=False))


@examples(25)
@given(seed=SEEDS)
def test_nothing_is_left_out_where_arms_are_conjugate_and_occupants_coupled(seed: int) -> None:
    data = samples.crash_data(np.random.default_rng(seed))
    if "bar" in data:
        data["bar"]["lever_arm"] = "work-conjugate"
    for occupant in data["occupants"]:
        occupant["coupled"] = True
    response = simulate(CrashScenario(**data), throw=False)
    assert_balanced(response)
    for name, element in response.energy.elements.items():
        assert element.left_out == pytest.approx(0.0, abs=1e-12 * response.energy.initial), name
    assert response.momentum.left_out == pytest.approx(0.0, abs=1e-12 * response.momentum.initial)


def pair(offset: float, lever_arm: str = "work-conjugate", **occupant: Any) -> CrashScenario:
    """A mismatched pair, elastic against plastic, with an adult in each."""
    belt = {"stiffness": 98.1e3, "damping_ratio": 0.5, "slack": 0.005}
    adult = {"kind": "adult", "mass": 80.0, "restraint": belt} | occupant
    return CrashScenario(
        vehicle1={"mass": 1200.0, "speed": 15.0, "members": STIFFENING},
        vehicle2={"mass": 2400.0, "speed": 9.0, "members": TABLE | PLASTIC},
        bar={"mass": 40.0, "inertia": 157.0, "rail_spacing": 1.1, "lateral_offset": offset, "lever_arm": lever_arm},
        occupants=[adult, adult | {"vehicle": 2}],
    )


WALL = CrashScenario(vehicle1={"mass": 1500.0, "speed": 15.6, "members": TABLE | PLASTIC})


@pytest.mark.parametrize(
    "scenario",
    [WALL, pair(0.0, coupled=True), pair(0.7, coupled=True), load("navigator-neon")],
    ids=["wall", "mismatched pair", "offset pair", "navigator-neon"],
)
def test_what_is_lost_in_motion_is_found_in_the_elements(scenario: CrashScenario) -> None:
    response = simulate(scenario)
    energy = response.energy
    assert_balanced(response)
    found = energy.final + sum(element.stored + element.dissipated for element in energy.elements.values())
    assert found == pytest.approx(energy.initial, rel=CLOSE)


def test_elastic_members_dissipate_nothing() -> None:
    response = simulate(pair(0.7).model_copy(update={"occupants": ()}))
    for name in ("vehicle1.right", "vehicle1.left"):
        assert response.energy.elements[name].dissipated == pytest.approx(0.0, abs=CLOSE * response.energy.initial)


def test_the_wall_takes_up_the_momentum() -> None:
    momentum = simulate(WALL).momentum
    assert momentum.external == pytest.approx(momentum.final - momentum.initial, rel=CLOSE)
    assert momentum.left_out == 0.0


def test_the_printed_lever_arm_makes_or_loses_energy_and_the_balance_says_how_much() -> None:
    response = simulate(pair(0.7, "printed"))
    assert_balanced(response)
    members = [element for name, element in response.energy.elements.items() if name.startswith("vehicle")]
    assert abs(sum(member.left_out for member in members)) > 1e-3 * response.energy.initial


def test_an_uncoupled_belt_pulls_on_nothing() -> None:
    alone, coupled = simulate(pair(0.0)), simulate(pair(0.0, coupled=True))
    assert alone.momentum.left_out != 0.0
    assert alone.energy.elements["adult.restraint"].left_out != 0.0
    assert coupled.energy.elements["adult.restraint"].left_out == pytest.approx(0.0, abs=1e-9)
    # what the adult gives up, the belt takes and the car is not told of
    adult = 0.5 * 80.0 * (15.0**2 - float(alone.at("adult.velocity", alone.end_time)) ** 2)
    belt = alone.energy.elements["adult.restraint"]
    assert belt.absorbed + belt.left_out == pytest.approx(adult, rel=1e-9)
