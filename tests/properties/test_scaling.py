"""Laws of similarity: a crash in other units of mass, or of length, is the same crash."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import Response, simulate
from ridedown.scenario import CrashScenario
from tests import samples
from tests.compare import assert_alike
from tests.samples import examples

SEEDS = st.integers(0, 10**6)
MASSES = {"mass", "inertia"}
FORCES = {"stiffness", "initial_force", "damping", "unloading_stiffness"}
LENGTHS = {"until", "slack", "rail_spacing", "lateral_offset"}


def scaled(value: Any, factors: dict[str, float], key: str = "") -> Any:
    """The data of a scenario with each number multiplied by its key's factor."""
    if isinstance(value, dict):
        return {k: scaled(v, factors, k) for k, v in value.items()}
    if key == "points":
        return [[d * factors.get("until", 1.0), f * factors.get("initial_force", 1.0)] for d, f in value]
    if isinstance(value, list):
        return [scaled(v, factors, key) for v in value]
    return value * factors[key] if key in factors else value


def both(seed: int, factors: dict[str, float], **changes: Any) -> tuple[Response, Response]:
    data = samples.crash_data(np.random.default_rng(seed), softening=False) | changes
    one, other = (simulate(CrashScenario(**d), throw=False) for d in (data, scaled(data, factors)))
    return one, other


def _force_factor(factor: float) -> Any:
    return lambda name: 1.0 / factor if name.endswith((".force", ".forcing")) else 1.0


@examples(15)
@given(seed=SEEDS, power=st.integers(-9, 9))
def test_force_and_mass_by_a_power_of_two_to_the_last_bit(seed: int, power: int) -> None:
    factor = 2.0**power
    one, other = both(seed, dict.fromkeys(MASSES | FORCES, factor))
    assert one.events == other.events
    assert_alike(one, other, rtol=1e-15, channels=one.channels, factor=_force_factor(factor))


@examples(15)
@given(seed=SEEDS, factor=st.floats(1e-3, 1e3))
def test_force_and_mass_together(seed: int, factor: float) -> None:
    one, other = both(seed, dict.fromkeys(MASSES | FORCES, factor))
    assert_alike(one, other, rtol=1e-8, factor=_force_factor(factor))


@examples(15)
@given(seed=SEEDS, factor=st.floats(0.1, 10.0))
def test_lengths_speeds_and_forces_together(seed: int, factor: float) -> None:
    # tan(theta) knows no length; stiffness and damping stay, so that the times do
    factors = dict.fromkeys(LENGTHS | {"initial_force", "speed"}, factor) | {"inertia": factor**2}
    one, other = both(seed, factors)
    assert_alike(
        one,
        other,
        rtol=1e-8,
        factor=lambda name: 1.0 if name.startswith("bar.rotation") else 1.0 / factor,
        channels=[name for name in one.channels if name.endswith(("displacement", "velocity", "rotation", "deflection"))],
    )


@pytest.mark.parametrize("seed", range(3))
def test_twice_the_time(seed: int) -> None:
    # an eighth of everything's stiffness would need new clocks: forces by 1/4, speeds by 1/2, dampers by 1/2
    data = samples.crash_data(np.random.default_rng(seed), softening=False)
    slow = scaled(data, {"stiffness": 0.25, "initial_force": 0.25, "unloading_stiffness": 0.25, "speed": 0.5, "duration": 2.0})
    one, other = (simulate(CrashScenario(**d), throw=False) for d in (data, slow))
    assert one.status is other.status
    times = np.linspace(0.0, min(one.end_time, 0.5 * other.end_time), 101)
    for name in ("vehicle1.displacement", "vehicle1.right.deflection"):
        np.testing.assert_allclose(other.at(name, 2.0 * times), one.at(name, times), rtol=0.0, atol=1e-9)
    for name in ("vehicle1.velocity", "vehicle1.right.deflection_rate"):
        assert 2.0 * abs(other.peak(name).value) == pytest.approx(abs(one.peak(name).value), rel=1e-9)  # of +v and -v, either
