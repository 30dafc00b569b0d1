"""Moving means and the phaseless low-pass against brute force and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, filtfilt

from ridedown.criteria.moving import integral, largest_mean, lowpassed, refined


@st.composite
def signals(draw: st.DrawFn, rows: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Unevenly sampled signals, with jumps, 0.1 s or so long."""
    n = draw(st.integers(3, 25))
    steps = draw(st.lists(st.sampled_from([0.0, 1e-4, 1e-3, 3e-3, 0.01, 0.017]), min_size=n - 1, max_size=n - 1))
    time = np.concatenate(([draw(st.sampled_from([-0.05, 0.0, 0.2]))], np.array(steps))).cumsum()
    time = np.append(time, time[-1] + 0.02)
    number = st.floats(-500.0, 500.0).map(lambda x: round(x, 3))
    values = draw(st.lists(st.lists(number, min_size=n + 1, max_size=n + 1), min_size=rows, max_size=rows))
    return time, np.array(values)


def mean_from(time: np.ndarray, values: np.ndarray, start: float, window: float) -> float:
    """Length of the vector of means over one window, each integrated piece by piece."""
    means = []
    for row in values:
        total = 0.0
        for t0, t1, a0, a1 in zip(time[:-1], time[1:], row[:-1], row[1:], strict=True):
            low, high = max(t0, start), min(t1, start + window)
            if high > low:
                at = [a0 + (a1 - a0) * (t - t0) / (t1 - t0) for t in (low, high)]
                total += 0.5 * (at[0] + at[1]) * (high - low)
        means.append(total / window)
    return math.hypot(*means)


@settings(max_examples=150, deadline=None)
@given(signals(), st.sampled_from([0.001, 0.010, 0.0173]))
def test_no_window_has_a_larger_mean_than_the_one_found(signal: tuple[np.ndarray, np.ndarray], window: float) -> None:
    time, values = signal
    found = largest_mean(time, values, window)
    if time[-1] - time[0] < window:
        assert found is None
        return
    assert found is not None
    tolerance = 1e-9 * max(1.0, float(np.abs(values).max()))
    assert found.value == pytest.approx(mean_from(time, values, found.start, window), abs=tolerance)
    assert found.start >= time[0] - 1e-12
    assert found.end <= time[-1] + 1e-12
    for start in np.linspace(time[0], time[-1] - window, 120):
        assert mean_from(time, values, float(start), window) <= found.value + tolerance


def test_the_maximum_between_breakpoints_is_solved_for() -> None:
    # x rises while y falls: the length of the mean vector is largest or smallest in the middle; here an arch, not an end
    time = np.array([0.0, 0.1])
    found = largest_mean(np.array([0.0, 0.05, 0.1]), np.array([[0.0, 100.0, 0.0]]), 0.02)
    assert found is not None
    assert found.start == pytest.approx(0.04, abs=1e-12)
    assert found.value == pytest.approx(90.0, rel=1e-12)
    ends = largest_mean(time, np.array([[0.0, 10.0], [10.0, 0.0]]), 0.02)
    assert ends is not None
    assert ends.value == pytest.approx(math.hypot(1.0, 9.0), rel=1e-12)


def test_of_equally_good_windows_the_first_is_named() -> None:
    found = largest_mean(np.linspace(0.0, 0.3, 301), np.full((1, 301), 7.0), 0.01)
    assert found is not None
    assert (found.start, found.value) == pytest.approx((0.0, 7.0), rel=1e-12)


def test_a_window_may_not_start_before_begin_or_reach_beyond_the_end() -> None:
    time, values = np.array([0.0, 0.1]), np.array([[10.0, 0.0]])
    late = largest_mean(time, values, 0.01, 0.05)
    assert late is not None
    assert (late.start, late.value) == pytest.approx((0.05, 4.5), rel=1e-12)
    assert largest_mean(time, values, 0.01, 0.0905) is None
    assert largest_mean(time, values, 0.01, 0.09) is not None


@pytest.mark.parametrize("frequency", [2.0, 13.0, 26.0])
def test_the_gain_of_the_lowpass_is_that_of_four_butterworth_poles(frequency: float) -> None:
    time = np.linspace(0.0, 3.0, 30_001)
    through = lowpassed(time, np.sin(2.0 * np.pi * frequency * time)[np.newaxis], 13.0)[0]
    middle = slice(10_000, 20_000)
    phase = np.sin(2.0 * np.pi * frequency * time[middle])
    gain = 2.0 * float(np.mean(through[middle] * phase))  # whole periods: 1 s
    assert gain == pytest.approx(1.0 / (1.0 + (frequency / 13.0) ** 4 * (math.sqrt(2.0) - 1.0)), rel=1e-4)
    quadrature = 2.0 * float(np.mean(through[middle] * np.cos(2.0 * np.pi * frequency * time[middle])))
    assert abs(quadrature) < 1e-4  # nothing shifts in time


@settings(max_examples=30, deadline=None)
@given(signals(rows=1))
def test_the_lowpass_is_the_digital_filter_in_the_limit_of_fast_sampling(signal: tuple[np.ndarray, np.ndarray]) -> None:
    time, values = signal
    step = 2e-5
    grid = np.arange(time[0] - 0.4, time[-1] + 0.4, step)
    sampled = np.interp(grid, *_without_jumps(time, values[0]))
    corner = 13.0 * (math.sqrt(2.0) - 1.0) ** -0.25
    b, a = butter(2, corner * 2.0 * step)
    digital = np.interp(time, grid, filtfilt(b, a, sampled))
    size = max(1.0, float(np.abs(values).max()))
    assert np.abs(lowpassed(time, values, 13.0)[0] - digital).max() < 2e-3 * size


def _without_jumps(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    later = time.copy()
    for i in range(1, later.size):
        later[i] = max(later[i], later[i - 1] + 1e-9)
    return later, values


def test_a_constant_stays_constant_through_the_lowpass() -> None:
    time = np.array([0.0, 0.001, 0.001, 0.5, 2.0])
    assert lowpassed(time, np.full((1, 5), 42.0), 13.0)[0] == pytest.approx(42.0, rel=1e-12)


def test_the_lowpass_does_not_depend_on_where_a_straight_line_is_sampled() -> None:
    time, values = np.array([0.0, 0.03, 0.1]), np.array([[0.0, 300.0, 0.0]])
    fine, more = refined(time, values, 1e-4)
    coarse_at = np.searchsorted(fine, time)
    assert lowpassed(fine, more, 13.0)[0][coarse_at] == pytest.approx(lowpassed(time, values, 13.0)[0], rel=1e-9)


def test_refining_keeps_the_signal_and_its_jumps() -> None:
    time, values = np.array([0.0, 0.01, 0.01, 0.0105]), np.array([[0.0, 5.0, -5.0, 0.0]])
    fine, more = refined(time, values, 1e-3)
    assert np.diff(fine).max() <= 1e-3 + 1e-15
    assert set(time) <= set(fine)
    assert integral(fine, more[0])[-1] == pytest.approx(integral(time, values[0])[-1], rel=1e-12)
