"""What every criterion must keep: finer samples of one signal, another clock, another direction of time, another size."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from ridedown import criteria

Floats = NDArray[np.float64]
G0 = 9.80665

KNOTS = np.array([0.0, 0.012, 0.030, 0.030, 0.041, 0.055, 0.071, 0.090, 0.160])
VALUES = -G0 * np.array([0.0, 38.0, 21.0, 33.0, 47.0, 52.0, 12.0, -3.0, 0.0])

CRITERIA: dict[str, Callable[[Floats, Floats], float | None]] = {
    "hic15": lambda t, a: criteria.hic(t, a).value,
    "hic36": lambda t, a: criteria.hic(t, a, max_window=0.036).value,
    "hic of any window": lambda t, a: criteria.hic(t, a, max_window=10.0).value,
    "clip": lambda t, a: criteria.clip(t, a).value,
    "cumulative clip": lambda t, a: criteria.clip(t, a, cumulative=True).value,
    "severity index": criteria.severity_index,
    "peak": lambda t, a: criteria.peak(t, a).value,
    "change of velocity": lambda t, a: criteria.delta_v(t, a, start=float(t[0])).value,
    "crush": lambda t, a: criteria.dynamic_crush(t, a, 12.0, start=float(t[0])).value,
    "rebound": lambda t, a: criteria.coefficient_of_restitution(t, a, 12.0, start=float(t[0])),
    "olc": lambda t, a: criteria.olc(t, a, start=float(t[0])).value,
    "vpi": lambda t, a: criteria.vpi(t, a, start=float(t[0])).value,
}
POWER = {"hic15": 2.5, "hic36": 2.5, "hic of any window": 2.5, "severity index": 2.5}


def finer(step: float) -> tuple[Floats, Floats]:
    """The same signal with samples in between, at least `step` apart, jump and kinks kept."""
    times, values = [KNOTS[:1]], [VALUES[:1]]
    for k in range(KNOTS.size - 1):
        count = max(1, math.floor((KNOTS[k + 1] - KNOTS[k]) / step))
        times.append(np.linspace(KNOTS[k], KNOTS[k + 1], count + 1)[1:])
        values.append(np.linspace(VALUES[k], VALUES[k + 1], count + 1)[1:])
    return np.concatenate(times), np.concatenate(values)


@pytest.mark.parametrize("name", CRITERIA)
@pytest.mark.parametrize("step", [3e-3, 1e-4, 7.3e-6])
def test_samples_in_between_change_nothing(name: str, step: float) -> None:
    # the sums of many more terms, 20,000 of them, round to 1e-12
    assert CRITERIA[name](*finer(step)) == pytest.approx(CRITERIA[name](KNOTS, VALUES), rel=1e-11)


@pytest.mark.parametrize("name", CRITERIA)
def test_another_clock_changes_nothing(name: str) -> None:
    assert CRITERIA[name](KNOTS + 3.7, VALUES) == pytest.approx(CRITERIA[name](KNOTS, VALUES), rel=1e-11)


@pytest.mark.parametrize("name", ["hic15", "hic36", "clip", "cumulative clip", "severity index"])
def test_time_running_backwards_changes_nothing(name: str) -> None:
    assert CRITERIA[name](KNOTS[-1] - KNOTS[::-1], VALUES[::-1]) == pytest.approx(CRITERIA[name](KNOTS, VALUES), rel=1e-12)


@pytest.mark.parametrize("name", [name for name in CRITERIA if name not in {"crush", "rebound", "olc", "vpi"}])
@pytest.mark.parametrize("size", [0.01, 2.0])
def test_a_larger_signal_counts_by_its_power(name: str, size: float) -> None:
    expected = size ** POWER.get(name, 1.0) * CRITERIA[name](KNOTS, VALUES)
    assert CRITERIA[name](KNOTS, size * VALUES) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", CRITERIA)
def test_error_of_sampling_a_smooth_pulse_falls_with_its_square(name: str) -> None:
    def error(rate: float) -> float:
        def sampled(rate: float) -> float:
            time = np.arange(round(0.15 * rate) + 1) / rate
            # both ends fall between samples, smoothly, so that what is lost is by curvature alone
            pulse = np.where(np.abs(time - 0.0503) < 0.0401, np.cos(math.pi * (time - 0.0503) / 0.0802) ** 4, 0.0)
            return CRITERIA[name](time, -60.0 * G0 * pulse)

        return abs(sampled(rate) / sampled(400_000.0) - 1.0)

    # curvature of the pulse over 1 kHz: (1 ms * 78/s)^2 / 8 * 4, and 2.5 times that where the power is 2.5
    assert error(1_000.0) < 1e-2
    assert error(10_000.0) < 1e-4


def test_hic_windows_may_only_add() -> None:
    values = [criteria.hic(KNOTS, VALUES, max_window=w).value for w in np.geomspace(1e-4, 1.0, 60)]
    assert np.all(np.diff(values) >= -1e-9)
    assert values[-1] <= criteria.severity_index(KNOTS, VALUES) * (1.0 + 1e-12)  # Jensen


def test_cumulative_is_not_below_continuous_nor_exact_below_sampled() -> None:
    time, a = finer(1e-3)
    assert criteria.clip(time, a, cumulative=True).value >= criteria.clip(time, a).value
    assert criteria.hic(time, a).value >= criteria.hic(time, a, sampled=True).value


@pytest.mark.parametrize("kind", ["noise", "a rising spike train", "a plateau"])
def test_long_records_are_searched_to_the_end(kind: str) -> None:
    time = np.arange(200_001) / 1e6
    a = {
        "noise": np.abs(np.random.default_rng(3).normal(0.0, 500.0, time.size)),
        "a rising spike train": 500.0 * (1.0 + time) * (np.arange(time.size) % 50 == 0),
        "a plateau": np.full(time.size, 500.0),
    }[kind]
    found = criteria.hic(time, a)
    assert found.value >= criteria.hic(time, a, sampled=True).value * (1.0 - 1e-12)
    assert criteria.clip(time, a, cumulative=True).value >= criteria.clip(time, a).value >= 0.0
