"""Every criterion against a slow way of finding it that shares nothing with the fast one but the definition.

Signals are straight between a few samples at uneven times, of either sign, with jumps, longer and shorter than the windows.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from ridedown import criteria
from ridedown.errors import InvalidInput

Floats = NDArray[np.float64]
G0 = 9.80665

# The same examples each time: what is new each time was searched at length when these were written.
slow = settings(max_examples=40, deadline=None, derandomize=True)
quick = settings(max_examples=150, deadline=None, derandomize=True)


@st.composite
def signals(
    draw: st.DrawFn, *, low: float = -1000.0, high: float = 1000.0, most: int = 9, longest: float = 0.02, least: float = 1e-3
) -> tuple[Floats, Floats]:
    """Times [s] and values; a step of 0 is a jump."""
    count = draw(st.integers(2, most))
    steps = draw(st.lists(st.one_of(st.just(0.0), st.floats(least, longest)), min_size=count - 1, max_size=count - 1))
    level = st.one_of(st.floats(low, high), st.sampled_from([max(low, 0.0), high, 0.5 * high]))
    values = draw(st.lists(level, min_size=count, max_size=count))
    assume(sum(steps) > 0.0)
    begin = draw(st.sampled_from([0.0, 0.013]))
    return begin + np.concatenate(([0.0], np.cumsum(steps))), np.array(values)


def at(signal: tuple[Floats, Floats], times: Floats) -> Floats:
    return np.interp(times, *signal)


def fine(signal: tuple[Floats, Floats], parts: int) -> tuple[Floats, Floats]:
    """The same signal at many more points, jumps kept."""
    time, values = signal
    share = np.linspace(0.0, 1.0, parts + 1)
    pairs = [k for k in range(time.size - 1) if time[k + 1] > time[k]]
    times = np.concatenate([time[k] + share * (time[k + 1] - time[k]) for k in pairs])
    return times, np.concatenate([values[k] + share * (values[k + 1] - values[k]) for k in pairs])


def velocity_at(signal: tuple[Floats, Floats], times: Floats) -> Floats:
    """The integral of the signal from its start to each of the times."""
    time, values = signal
    at_samples = np.concatenate(([0.0], np.cumsum(np.diff(time) * (values[1:] + values[:-1]) / 2.0)))
    k = np.clip(np.searchsorted(time, times, side="right") - 1, 0, time.size - 2)
    h = np.where(time[k + 1] > time[k], time[k + 1] - time[k], 1.0)
    s = np.clip(times - time[k], 0.0, None)
    return at_samples[k] + s * (values[k] + 0.5 * s * (values[k + 1] - values[k]) / h)


def hic_of_windows(signal: tuple[Floats, Floats], starts: Floats, ends: Floats, window: float) -> Floats:
    length = ends - starts
    gain = (velocity_at(signal, ends) - velocity_at(signal, starts)) / G0
    good = (length > 0.0) & (length <= window * (1.0 + 1e-12)) & (gain > 0.0)
    return np.where(good, np.where(good, gain, 0.0) ** 2.5 / np.where(good, length, 1.0) ** 1.5, 0.0)


def rectified(signal: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """The magnitude, with a sample where it touches zero."""
    samples = [(signal[0][0], abs(signal[1][0]))]
    for t0, t1, v0, v1 in zip(signal[0], signal[0][1:], signal[1], signal[1][1:], strict=False):
        if v0 * v1 < 0.0 and t1 > t0:
            samples.append((min(t0 + (t1 - t0) * v0 / (v0 - v1), t1), 0.0))
        samples.append((t1, abs(v1)))
    return np.array([t for t, _ in samples]), np.array([v for _, v in samples])


def brute_hic(signal: tuple[Floats, Floats], window: float) -> float:
    """Windows between all points of a grid, and around the best of them grids ever finer; of all lengths and of the longest."""
    time = signal[0]
    grid = np.unique(np.concatenate((fine(signal, 24)[0], time + window, time - window)))
    grid = grid[(grid >= time[0]) & (grid <= time[-1])]
    starts, ends = (a.ravel() for a in np.meshgrid(grid, grid))
    values = hic_of_windows(signal, starts, ends, window)
    best = float(values.max(initial=0.0))
    for k in np.argsort(values)[-30:]:
        one, other, reach = starts[k], ends[k], float(np.diff(grid).max())
        for _ in range(24):
            around = np.linspace(-reach, reach, 9)
            first, second = (a.ravel() for a in np.meshgrid(one + around, other + around))
            first, second = np.concatenate((first, one + around)), np.concatenate((second, one + around + window))
            first, second = np.clip(first, time[0], time[-1]), np.clip(second, time[0], time[-1])
            found = hic_of_windows(signal, first, second, window)
            i = int(np.argmax(found))
            best = max(best, float(found[i]))
            one, other, reach = first[i], second[i], 0.5 * reach
    return best


@slow
@given(signals(), st.sampled_from([0.015, 0.036, 0.0007, 1.0]), st.booleans())
def test_hic(signal: tuple[Floats, Floats], window: float, signed: bool) -> None:
    found = criteria.hic(*signal, max_window=window, signed=signed)
    if not signed:
        signal = rectified(signal)
    slowly = brute_hic(signal, window)
    assert found.value == pytest.approx(slowly, rel=1e-7, abs=1e-12)
    assert found.value >= slowly * (1.0 - 1e-11) - 1e-30  # where the signal is as good as nothing
    here = hic_of_windows(signal, np.array([found.start]), np.array([found.end]), window)[0]
    assert found.value == pytest.approx(here, rel=1e-9, abs=1e-15)  # the window given is the one of the value
    assert found.duration <= window * (1.0 + 1e-12)


@quick
@given(signals(most=30), st.sampled_from([0.015, 0.036, 1.0]), st.booleans())
def test_hic_over_pairs_of_samples(signal: tuple[Floats, Floats], window: float, signed: bool) -> None:
    time, values = signal[0], signal[1] if signed else np.abs(signal[1])
    velocity = np.concatenate(([0.0], np.cumsum(np.diff(time) * (values[1:] + values[:-1]) / 2.0))) / G0
    slowly = 0.0
    for i, j in itertools.combinations(range(time.size), 2):
        length = time[j] - time[i]
        if 0.0 < length <= window * (1.0 + 1e-9) and velocity[j] > velocity[i]:
            slowly = max(slowly, length * ((velocity[j] - velocity[i]) / length) ** 2.5)
    found = criteria.hic(*signal, max_window=window, signed=signed, sampled=True)
    assert found.value == pytest.approx(slowly, rel=1e-11, abs=1e-15)
    assert slowly == 0.0 or (found.start in time and found.end in time)


def intervals_above(signal: tuple[Floats, Floats], level: float) -> list[tuple[float, float]]:
    """Where the magnitude is at or above a level > 0, one segment and one sign at a time."""
    pieces = []
    for t0, t1, v0, v1 in zip(signal[0], signal[0][1:], signal[1], signal[1][1:], strict=False):
        for one, other in ((v0, v1), (-v0, -v1)):
            if t1 > t0 and max(one, other) >= level:
                begin = t0 if one >= level else t0 + (t1 - t0) * (level - one) / (other - one)
                end = t1 if other >= level else t0 + (t1 - t0) * (level - one) / (other - one)
                pieces.append((begin, end))
    return sorted(pieces)


def held(signal: tuple[Floats, Floats], level: float, cumulative: bool) -> float:
    """The longest time on end, or the time in all, at or above a level."""
    pieces = intervals_above(signal, level)
    if cumulative:
        return sum(end - begin for begin, end in pieces)
    longest, run, last = 0.0, 0.0, -math.inf
    for begin, end in pieces:
        run = run + end - begin if begin <= last + 1e-15 else end - begin
        longest, last = max(longest, run), end
    return longest


@quick
@given(signals(most=30), st.sampled_from([0.003, 0.0101]), st.booleans())
def test_clip(signal: tuple[Floats, Floats], duration: float, cumulative: bool) -> None:
    if signal[0][-1] - signal[0][0] < duration:
        with pytest.raises(InvalidInput, match="cannot be held longer"):
            criteria.clip(*signal, duration=duration, cumulative=cumulative)
        return
    low, high = 0.0, float(np.abs(signal[1]).max())
    if held(signal, high, cumulative) >= duration - 1e-13:
        low = high
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if held(signal, middle, cumulative) >= duration - 1e-13 else (low, middle)
    found = criteria.clip(*signal, duration=duration, cumulative=cumulative)
    assert found.value == pytest.approx(low, rel=1e-8, abs=1e-6)
    if found.value > 0.0 and not cumulative:
        assert found.end - found.start == pytest.approx(duration, rel=1e-12)
        inside = np.linspace(found.start, found.end, 201)[1:-1]
        level = np.min(np.abs(at(signal, inside))) if np.all(np.diff(signal[0]) > 0.0) else found.value
        assert level >= found.value * (1.0 - 1e-9)


@quick
@given(signals())
def test_severity_index(signal: tuple[Floats, Floats]) -> None:
    # 48 nodes on each piece; x^2.5 at its zero is the least smooth part, and 1e-9 of it then
    nodes, weights = np.polynomial.legendre.leggauss(48)
    time, values = rectified(signal)
    across = 0.5 * (values[1:] + values[:-1])[:, None] + 0.5 * np.diff(values)[:, None] * nodes
    slowly = float(np.sum(0.5 * np.diff(time) * ((np.maximum(across, 0.0) / G0) ** 2.5 @ weights)))
    assert criteria.severity_index(*signal) == pytest.approx(slowly, rel=1e-9, abs=1e-12)


def motion(signal: tuple[Floats, Floats], speed: float, parts: int = 4000) -> tuple[Floats, Floats, Floats]:
    """Times, velocity and displacement at many points; trapezia are exact for the velocity, Simpson's rule for the way."""
    times, a = fine(signal, parts)
    h = np.diff(times)
    v = speed + np.concatenate(([0.0], np.cumsum(h * (a[1:] + a[:-1]) / 2.0)))
    middle = v[:-1] + h * (3.0 * a[:-1] + a[1:]) / 8.0
    return times, v, np.concatenate(([0.0], np.cumsum(h * (v[:-1] + 4.0 * middle + v[1:]) / 6.0)))


@quick
@given(signals(low=-1000.0, high=300.0, longest=0.03), st.floats(0.5, 20.0))
def test_motion_of_the_vehicle(signal: tuple[Floats, Floats], speed: float) -> None:
    times, v, x = motion(signal, speed)
    change = criteria.delta_v(*signal)
    # between points of the grid 1e-5 s apart at most, velocity turns by less than 1000 m/s2 times that
    assert abs(change.value) == pytest.approx(np.abs(v - speed).max(), abs=1e-6)
    assert np.interp(change.time, times, v - speed) == pytest.approx(change.value, abs=1e-2)
    stop, crush = criteria.time_to_zero_velocity(*signal, speed), criteria.dynamic_crush(*signal, speed)
    if not np.any(v <= 0.0):
        assert stop is None or v.min() < 1e-6
        return
    k = int(np.argmax(v <= 0.0))
    assert times[max(k - 1, 0)] - 1e-9 <= stop <= times[k] + 1e-9
    assert (crush.value, crush.time) == (pytest.approx(x[k], abs=1e-6), stop)
    assert criteria.average_square_wave(*signal, speed) == pytest.approx(speed / (stop - times[0]), rel=1e-12)
    assert criteria.equivalent_square_wave(*signal, speed) == pytest.approx(speed**2 / 2.0 / crush.value, rel=1e-12)
    assert criteria.coefficient_of_restitution(*signal, speed) == pytest.approx(-v.min() / speed, abs=1e-6)


@quick
@given(signals(low=0.0, high=600.0, longest=0.05, least=0.005))
def test_olc(signal: tuple[Floats, Floats]) -> None:
    times, u, z = motion(signal, 0.0, 1000)
    assume(abs(z[-1] - 0.065) > 1e-9)  # or rounding says whether it is reached
    found = criteria.olc(signal[0], -signal[1])
    assert found.displacement == pytest.approx(z.max(), rel=1e-9, abs=1e-12)
    if z[-1] < 0.065:
        assert (found.start, found.end, found.value) == (None, None, None)
        return
    i = int(np.argmax(z >= 0.065))
    assert times[i - 1] - 1e-9 <= found.start <= times[i] + 1e-9
    ahead = z - 0.5 * u * (times - found.start)
    reached = np.flatnonzero((ahead >= 0.3) & (times > found.start))
    if reached.size == 0:
        assert found.value is None or ahead.max() > 0.3 - 1e-6
        return
    j = int(reached[0])
    assert times[j - 1] - 1e-9 <= found.end <= times[j] + 1e-9
    assert found.value == pytest.approx(u[j] / (times[j] - found.start), rel=2e-3)


def brute_vpi(signal: tuple[Floats, Floats], w: float, slack: float) -> tuple[float, bool]:
    """Peak acceleration of the occupant, by a solver of differential equations, and whether it was over by the end."""
    peak, state, when = 0.0, np.zeros(2), 0.0
    for t0, t1, v0, v1 in zip(signal[0], signal[0][1:], signal[1], signal[1][1:], strict=False):
        if t1 <= t0:
            continue

        def rates(t: float, y: Floats, t0: float = t0, t1: float = t1, v0: float = v0, v1: float = v1) -> list[float]:
            return [y[1], v0 + (v1 - v0) * (t - t0) / (t1 - t0) - w * w * max(y[0] - slack, 0.0)]

        solved = solve_ivp(rates, (t0, t1), state, rtol=1e-9, atol=1e-12, max_step=2e-3, dense_output=True)
        moments = np.linspace(t0, t1, 2001)
        assert solved.sol is not None
        size = w * w * np.maximum(solved.sol(moments)[0] - slack, 0.0)
        if size.max() > peak:
            peak, when = float(size.max()), float(moments[int(np.argmax(size))])
        state = solved.y[:, -1]
    loading = state[0] > slack and state[1] > 0.0
    return peak, peak > 0.0 and not loading and when < signal[0][-1]


@slow
@given(signals(low=-300.0, high=600.0, longest=0.06, least=0.002), st.sampled_from([(50.0, 0.03), (120.0, 0.0), (30.0, 0.01)]))
def test_vpi(signal: tuple[Floats, Floats], spring: tuple[float, float]) -> None:
    w, slack = spring
    _, u, _ = motion(signal, 0.0, 200)
    sign = 1.0 if u[int(np.argmax(np.abs(u)))] >= 0.0 else -1.0
    assume(abs(u.max() + u.min()) > 1e-3)  # or there is no saying which way the pulse goes
    found = criteria.vpi(*signal, stiffness=w * w, slack=slack)
    slowly, over = brute_vpi((signal[0], sign * signal[1]), w, slack)
    assert found.reached == pytest.approx(slowly, rel=1e-5, abs=1e-4)
    if slowly > 1e-3 and over:
        assert found.value == found.reached


@quick
@given(signals(low=-900.0, high=0.0, longest=0.04), signals(low=-900.0, high=100.0, longest=0.04), st.floats(1.0, 15.0))
def test_energy_split(vehicle: tuple[Floats, Floats], occupant: tuple[Floats, Floats], speed: float) -> None:
    begin = max(vehicle[0][0], occupant[0][0])
    assume(begin < min(vehicle[0][-1], occupant[0][-1]) - 1e-3)
    stop = criteria.time_to_zero_velocity(*vehicle, speed, start=begin)
    if stop is None:
        assert criteria.energy_split(vehicle, occupant, speed) is None
        return
    if stop > occupant[0][-1]:
        with pytest.raises(InvalidInput, match="Take a longer record"):
            criteria.energy_split(vehicle, occupant, speed)
        return
    split = criteria.energy_split(vehicle, occupant, speed)
    marks = np.unique(np.concatenate((vehicle[0], occupant[0], [begin, stop])))
    marks = marks[(marks >= begin) & (marks <= stop)]
    start_v, start_o = velocity_at(vehicle, marks[:1])[0], velocity_at(occupant, marks[:1])[0]
    ride_down = restraint = 0.0
    nodes, weights = np.polynomial.legendre.leggauss(4)
    for t0, t1 in itertools.pairwise(marks):
        times = 0.5 * (t0 + t1) + 0.5 * (t1 - t0) * nodes
        v_v = speed + velocity_at(vehicle, times) - start_v
        v_o = speed + velocity_at(occupant, times) - start_o
        step = 1e-6 * (t1 - t0)  # the slope of the velocity, not the signal, which may jump
        a_o = (velocity_at(occupant, times + step) - velocity_at(occupant, times - step)) / (2.0 * step)
        ride_down -= 0.5 * (t1 - t0) * float(np.sum(weights * a_o * v_v))
        restraint -= 0.5 * (t1 - t0) * float(np.sum(weights * a_o * (v_o - v_v)))
    scale = split.initial + abs(split.restraint)
    assert split.ride_down == pytest.approx(ride_down, abs=1e-7 * scale)
    assert split.restraint == pytest.approx(restraint, abs=1e-7 * scale)
    assert split.ride_down + split.restraint + split.remaining == pytest.approx(split.initial, abs=1e-11 * scale)
    assert criteria.ridedown_efficiency(vehicle, occupant, speed) == split.efficiency
