"""A crash seen in a mirror, or from the other vehicle, is the same crash."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import simulate
from ridedown.scenario import CrashScenario
from tests import samples
from tests.compare import assert_alike, continuous
from tests.samples import examples

SEEDS = st.integers(0, 10**6)
RTOL = 1e-8  # the sums are taken in another order, and what is stiff between light parts makes rounding grow


def _two_vehicles(seed: int) -> samples.Data:
    return samples.crash_data(np.random.default_rng(seed), wall=False, softening=False)


def _other_side(name: str) -> str:
    swapped = {"right": "left", "left": "right"}
    return ".".join(swapped.get(part, part) for part in name.split("."))


def _other_vehicle(name: str) -> str:
    swapped = {"vehicle1": "vehicle2", "vehicle2": "vehicle1"}
    return ".".join(swapped.get(part, part) for part in name.split("."))


@examples(25)
@given(seed=SEEDS)
def test_left_and_right(seed: int) -> None:
    data = _two_vehicles(seed)
    mirrored = {**data, "bar": dict(data["bar"])}
    if "lateral_offset" in mirrored["bar"]:
        mirrored["bar"]["lateral_offset"] *= -1.0
    for vehicle in ("vehicle1", "vehicle2"):
        given_sides = {side: data[vehicle][side] for side in ("right", "left") if side in data[vehicle]}
        mirrored[vehicle] = data[vehicle] | {_other_side(side): member for side, member in given_sides.items()}
    one, other = (simulate(CrashScenario(**d), throw=False) for d in (data, mirrored))
    assert_alike(
        one,
        other,
        rtol=RTOL,
        other_name=_other_side,
        factor=lambda name: -1.0 if name.startswith("bar.rotation") else 1.0,
    )


@examples(25)
@given(seed=SEEDS)
def test_from_the_other_vehicle(seed: int) -> None:
    data = _two_vehicles(seed)
    bar: dict[str, Any] = data["bar"]
    occupants = [{"name": f"o{i}", **o} for i, o in enumerate(data["occupants"])]
    one = simulate(CrashScenario(**data | {"occupants": occupants}), throw=False)
    turned = simulate(
        CrashScenario(
            duration=data["duration"],
            vehicle1=data["vehicle2"],
            vehicle2=data["vehicle1"],
            bar=bar | ({"speed": -bar["speed"]} if "speed" in bar else {}),
            occupants=[occupant | {"vehicle": 3 - occupant["vehicle"]} for occupant in occupants],
        ),
        throw=False,
    )
    assert_alike(
        one,
        turned,
        rtol=RTOL,
        channels=[name for name in continuous(one) if name != "bar.acceleration"],
        other_name=_other_vehicle,
        factor=lambda name: -1.0 if name in {"bar.displacement", "bar.velocity"} else 1.0,
    )


def test_alike_cars_head_on_leave_the_bar_where_it_is() -> None:
    data = _two_vehicles(3)
    car = {
        "mass": 1500.0,
        "speed": 13.33,
        "members": {"pieces": [{"stiffness": 118.2e3, "until": 0.356}, {"stiffness": 465e3}]},
    }
    data |= {"vehicle1": car, "vehicle2": car, "bar": {"mass": 40.0, "inertia": 157.0, "rail_spacing": 1.1}}
    response = simulate(CrashScenario(**data))
    for channel in ("bar.displacement", "bar.velocity", "bar.rotation", "bar.rotation_rate"):
        assert response.peak(channel).value == pytest.approx(0.0, abs=1e-8)
