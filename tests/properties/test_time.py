"""A crash does not know how long it is watched, or when it starts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import Response, simulate
from ridedown.scenario import NetworkScenario
from tests import samples
from tests.compare import assert_alike, continuous
from tests.samples import examples


def before(response: Response, time: float) -> list[tuple[str, str, float]]:
    """Who met with what by then, and when; those of one instant come in any order."""
    return sorted((e.who, e.what, round(e.time, 9)) for e in response.events if e.time < time)


@examples(25)
@given(seed=st.integers(0, 10**6))
def test_half_as_long(seed: int) -> None:
    whole = simulate(samples.crash(seed, duration=0.2), throw=False)
    half = simulate(samples.crash(seed, duration=0.1), throw=False)
    if whole.end_time < 0.1:  # stopped before
        assert half.end_time == whole.end_time
        return
    assert half.completed
    times = np.linspace(0.0, 0.1, 101)
    assert_alike(half, whole, rtol=1e-12, times=times) if whole.completed else None
    for channel in continuous(whole):
        late = whole.peak(channel)
        if late.time < 0.1:
            assert half.peak(channel).value == pytest.approx(late.value, rel=1e-12), channel
        else:
            assert abs(half.peak(channel).value) <= abs(late.value) * (1.0 + 1e-12), channel
    assert before(whole, 0.1 - 1e-9) == before(half, 0.1 - 1e-9)


def fall(gap: float) -> NetworkScenario:
    """Two masses that fly on together until the first meets ties to the wall, `gap` further on."""
    return NetworkScenario(
        duration=0.1 + gap / 10.0,
        masses=[{"name": "car", "mass": 1000.0, "speed": 10.0}, {"name": "rider", "mass": 75.0, "speed": 10.0}],
        elements=[
            {
                "name": "front",
                "between": ["wall", "car"],
                "law": "kelvin-voigt",
                "stiffness": 300e3,
                "damping": 2e3,
                "slack": gap,
            },
            {
                "name": "late",
                "between": ["wall", "car"],
                "law": "threshold",
                "stiffness": 200e3,
                "damping": 4e3,
                "slack": gap + 0.1,
            },
            {"name": "belt", "between": ["car", "rider"], "law": "threshold", "stiffness": 80e3, "damping": 2e3, "slack": 0.02},
        ],
    )


@examples(15)
@given(gap=st.floats(1e-6, 5.0))
def test_the_same_crash_a_little_later(gap: float) -> None:
    now, later = simulate(fall(0.0)), simulate(fall(gap))
    shift = gap / 10.0
    # metres flown are digits lost
    rtol = 1e-11 * (1.0 + gap)
    for channel in ("car.velocity", "rider.velocity", "belt.deflection", "car.acceleration", "front.force", "belt.force"):
        first, second = now.peak(channel), later.peak(channel)
        assert second.value == pytest.approx(first.value, rel=rtol), channel
        if channel not in {"car.velocity", "rider.velocity"}:  # largest from the start on
            assert second.time - shift == pytest.approx(first.time, abs=1e-6), channel
    assert [(e.who, e.what) for e in later.events] == [(e.who, e.what) for e in now.events]
    times = [e.time for e in now.events]
    np.testing.assert_allclose([e.time - shift for e in later.events], times, rtol=0.0, atol=1e-9 * (1.0 + gap))
    grid = np.linspace(0.0, 0.1, 51)[1:]
    for channel in ("car.velocity", "rider.velocity"):
        np.testing.assert_allclose(later.at(channel, grid + shift), now.at(channel, grid), rtol=0.0, atol=1e-9 * (1.0 + gap))
