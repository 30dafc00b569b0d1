"""Means over a moving window and a phaseless low-pass, both exact for a signal that is linear between its samples.

Neither knows a sampling rate: the samples may lie anywhere, two at one time are a jump.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.criteria.checks import Floats, Table
from ridedown.criteria.strung import Ints

# Values that differ by less, relative, are one value: of several windows that are as good, the first is named.
_ROUNDING = 1e-11


def first_largest(values: Floats) -> int:
    """The index of the first of the values, none negative, that is the largest but for rounding."""
    return int(np.argmax(values >= values.max() * (1.0 - _ROUNDING)))


def first_largest_each(values: Floats, starts: Ints) -> Floats:
    """Of each of R signals end to end the value that `first_largest` finds, (R,)."""
    most = np.maximum.reduceat(values, starts[:-1])
    good = np.flatnonzero(values >= np.repeat(most * (1.0 - _ROUNDING), np.diff(starts)))
    found: Floats = values[good[np.searchsorted(good, starts[:-1])]]
    return found


@dataclass(frozen=True, slots=True)
class Window:
    """The largest value of a mean over a moving window, and the window [s] that has it."""

    value: float
    start: float
    end: float


def refined(time: Floats, values: Floats, longest: float) -> tuple[Floats, Floats]:
    """The same piecewise-linear signals, (k, n), with samples put in so that none are more than `longest` [s] apart."""
    step = np.diff(time)
    parts = np.maximum(1, np.ceil(step / longest * (1.0 - 1e-12))).astype(np.intp)
    if parts.max() == 1:
        return time, values
    first = np.repeat(np.arange(step.size), parts)
    at = (np.arange(first.size) - np.repeat(np.cumsum(parts) - parts, parts)) / np.repeat(parts, parts)
    finer = np.append(time[first] + at * step[first], time[-1])
    between = values[:, first] + at * (values[:, first + 1] - values[:, first])
    return finer, np.concatenate((between, values[:, -1:]), axis=1)


def largest_mean(time: Floats, components: Floats, window: float, begin: float = -math.inf) -> Window | None:
    """The largest length of the vector of moving means of the components, (k, n), over windows that start at `begin` or later.

    Between breakpoints (a sample enters or leaves the window) each mean is a quadratic in time and the square of the length a
    quartic: its largest coefficient on the Bernstein basis bounds it, and only pieces that could hold the maximum are solved.
    None where less than a window is left after `begin`.
    """
    value, start = largest_means(time, components, np.array([0, time.size]), window, np.array([begin]))[0]
    return None if math.isnan(value) else Window(float(value), float(start), float(start) + window)


def largest_means(time: Floats, components: Floats, starts: Ints, window: float, begins: Floats) -> Floats:
    """The same of R signals end to end (see `strung`), each with its own `begin`, (R,): (R, 2), value and start.

    NaN where `begin` is, or where less than a window is left after it.
    """
    found = np.empty((starts.size - 1, 2))
    _largest_means(time, np.ascontiguousarray(components), starts, window, begins, np.empty(components.shape), found)
    return found


@part
def _mean_of(
    time: Floats, components: Table, whole: Table, c: int, i: int, j: int, t: float, window: float
) -> tuple[float, float, float]:
    """The mean of component c over the window from t, in segment i, to its end, in segment j; its rate; half its second."""
    sums = 0.0
    levels = 0.0
    slopes = 0.0
    for end in range(2):
        k, at, sign = (j, t + window, 1.0) if end == 1 else (i, t, -1.0)
        length = time[k + 1] - time[k]
        slope = (components[c, k + 1] - components[c, k]) / length if length > 0.0 else 0.0
        s = min(max(at - time[k], 0.0), length)
        sums += sign * (whole[c, k] + s * (components[c, k] + 0.5 * s * slope))
        levels += sign * (components[c, k] + s * slope)
        slopes += sign * slope
    return sums / window, levels / window, 0.5 * slopes / window


@inlined
def _quartic(q: tuple[float, float, float, float, float], x: float) -> float:
    return q[0] + x * (q[1] + x * (q[2] + x * (q[3] + x * q[4])))


@inlined
def _slope(q: tuple[float, float, float, float, float], x: float) -> float:
    return q[1] + x * (2.0 * q[2] + x * (3.0 * q[3] + x * 4.0 * q[4]))


@part
def _bernstein_bound(q: tuple[float, float, float, float, float]) -> float:
    """No less than a quartic is anywhere on [0, 1]: the largest of its Bernstein coefficients, sum_j C(i, j)/C(4, j) q_j."""
    one = q[0] + q[1] / 4.0
    two = q[0] + q[1] / 2.0 + q[2] / 6.0
    three = q[0] + 0.75 * q[1] + q[2] / 2.0 + q[3] / 4.0
    return max(q[0], one, two, three, q[0] + q[1] + q[2] + q[3] + q[4])


@part
def _best_inside(q: tuple[float, float, float, float, float]) -> float:
    """Where within [0, 1] a quartic has its highest maximum; -1 where it has none."""
    a, b, c = 12.0 * q[4], 6.0 * q[3], 2.0 * q[2]  # its curvature a x^2 + b x + c, between whose roots the slope rises or falls
    inside = b * b - 4.0 * a * c
    one, two = 0.0, 0.0
    if inside > 0.0:
        half = -0.5 * (b + math.copysign(math.sqrt(inside), b))
        one = half / a if a != 0.0 else 0.0
        two = c / half if half != 0.0 else 0.0
    first, second = min(max(min(one, two), 0.0), 1.0), min(max(one, two, 0.0), 1.0)
    best, where = -math.inf, -1.0
    start = 0.0
    for end in (first, second, 1.0):
        if end > start and _slope(q, start) > 0.0 > _slope(q, end):
            low, high = start, end
            for _ in range(60):
                middle = 0.5 * (low + high)
                if not low < middle < high:
                    break
                if _slope(q, middle) > 0.0:
                    low = middle
                else:
                    high = middle
            if _quartic(q, high) > best:
                best, where = _quartic(q, high), high
        start = max(start, end)
    return where


@kernel
def _largest_means(  # noqa: C901, PLR0912 - one sweep
    time: Floats, components: Table, starts: Ints, window: float, begins: Floats, whole: Table, found: Table
) -> None:
    """See `largest_means`; whole: (k, N), room for the integrals."""
    kinds = components.shape[0]
    for r in range(starts.size - 1):
        found[r, 0], found[r, 1] = math.nan, math.nan
        first, final = starts[r], starts[r + 1] - 1
        last, t = time[final] - window, max(begins[r], time[first])
        if math.isnan(begins[r]) or last < t - 1e-12 * max(abs(last), window):
            continue
        last = max(last, t)
        for c in range(kinds):
            whole[c, first] = 0.0
            for k in range(first, final):
                area = 0.5 * (time[k + 1] - time[k]) * (components[c, k + 1] + components[c, k])
                whole[c, k + 1] = whole[c, k] + area
        i = first
        while i < final - 1 and time[i + 1] <= t:
            i += 1
        j = i
        while j < final - 1 and time[j + 1] - window <= t:
            j += 1
        best, where = -1.0, t
        while True:
            then = max(min(time[i + 1], time[j + 1] - window, last), t)
            h = then - t
            q0, q1, q2, q3, q4 = 0.0, 0.0, 0.0, 0.0, 0.0
            for c in range(kinds):
                c0, c1, c2 = _mean_of(time, components, whole, c, i, j, t, window)
                c1, c2 = c1 * h, c2 * h * h
                q0 += c0 * c0
                q1 += 2.0 * c0 * c1
                q2 += c1 * c1 + 2.0 * c0 * c2
                q3 += 2.0 * c1 * c2
                q4 += c2 * c2
            q = (q0, q1, q2, q3, q4)
            if q0 > best * (1.0 + _ROUNDING):
                best, where = q0, t
            if _bernstein_bound(q) > best * (1.0 + _ROUNDING):
                x = _best_inside(q)
                if x >= 0.0 and _quartic(q, x) > best * (1.0 + _ROUNDING):
                    best, where = _quartic(q, x), t + x * h
                if _quartic(q, 1.0) > best * (1.0 + _ROUNDING):
                    best, where = _quartic(q, 1.0), then
            if then >= last:
                break
            leaves, enters = time[i + 1] <= then, time[j + 1] - window <= then
            if leaves and i < final - 1:
                i += 1
            if enters and j < final - 1:
                j += 1
            if not (leaves or enters):  # cannot be; a loop that would never end must not be trusted to rounding
                break
            t = then
        found[r, 0], found[r, 1] = math.sqrt(max(best, 0.0)), where


def integral(time: Floats, values: Floats) -> Floats:
    """The integral of a piecewise-linear signal from its first sample to each, (n,)."""
    whole = np.zeros(time.size)
    np.cumsum(0.5 * np.diff(time) * (values[1:] + values[:-1]), out=whole[1:])
    return whole


def lowpassed(time: Floats, components: Floats, cutoff: float) -> Floats:
    """The components, (k, n), through the phaseless four-pole Butterworth low-pass, at their own times.

    Two poles run forwards and the same two backwards, so that nothing shifts in time; the gain of the whole at `cutoff` [Hz]
    is 1/sqrt(2). Its response to an impulse, w/(2 sqrt 2) exp(-w|t|/sqrt 2) (cos + sin)(w|t|/sqrt 2), is the real part of one
    complex exponential either way, and an exponential meets a piecewise-linear signal in closed form, segment by segment.
    Before and after the record the signal is taken to stay at its end values, so that a constant stays constant.
    """
    return np.stack([lowpassed_each(time, np.ascontiguousarray(row), np.array([0, time.size]), cutoff) for row in components])


def lowpassed_each(time: Floats, values: Floats, starts: Ints, cutoff: float) -> Floats:
    """The same of R signals end to end, (N,) (see `strung`)."""
    through = np.empty_like(values)
    # two passes: the corner of each lies above the cut-off
    _lowpassed(time, values, starts, 2.0 * math.pi * cutoff * (math.sqrt(2.0) - 1.0) ** -0.25, through)
    return through


@part
def _decay(step: float, w: float) -> tuple[complex, complex, complex]:
    """What is left of the state over a step, and what a level and a slope of 1 add to it, with the pole p = w (-1 + i)/sqrt 2.

    exp(z), (exp(z) - 1)/p and (exp(z) - 1 - z)/p^2 with z = p step, none of them from differences that cancel.
    """
    turn = w * step / math.sqrt(2.0)
    left, cos, sin = math.exp(-turn), math.cos(turn), math.sin(turn)
    z, growth = complex(-turn, turn), complex(left * cos, left * sin)
    half = math.sin(0.5 * turn)
    less = complex(math.expm1(-turn) * cos - 2.0 * half * half, left * sin)  # exp(z) - 1
    level = less * complex(-1.0, -1.0) / (math.sqrt(2.0) * w)
    if turn < 0.1:
        series = complex(1.0 / 362880.0, 0.0)
        for divisor in (40320.0, 5040.0, 720.0, 120.0, 24.0, 6.0, 2.0):
            series = series * z + 1.0 / divisor
        ramp = step * step * series
    else:
        ramp = (less - z) * complex(0.0, 1.0) / (w * w)
    return growth, level, ramp


@kernel
def _lowpassed(time: Floats, values: Floats, starts: Ints, w: float, through: Floats) -> None:
    """See `lowpassed`; w: of the poles [rad/s]."""
    weight = w / (2.0 * math.sqrt(2.0)) * complex(1.0, -1.0)
    constant = complex(1.0, 1.0) / (math.sqrt(2.0) * w)  # the state that a level of 1 leads to, -1/p
    for r in range(starts.size - 1):
        first, final = starts[r], starts[r + 1] - 1
        before = -1.0
        growth, level, ramp = _decay(0.0, w)
        state = values[first] * constant
        through[first] = (weight * state).real
        for i in range(first, final):
            step = time[i + 1] - time[i]
            if step != before:
                growth, level, ramp = _decay(step, w)
                before = step
            slope = (values[i + 1] - values[i]) / step if step > 0.0 else 0.0
            state = growth * state + values[i] * level + slope * ramp
            through[i + 1] = (weight * state).real
        state = values[final] * constant
        through[final] += (weight * state).real
        for i in range(final - 1, first - 1, -1):
            step = time[i + 1] - time[i]
            if step != before:
                growth, level, ramp = _decay(step, w)
                before = step
            slope = (values[i] - values[i + 1]) / step if step > 0.0 else 0.0
            state = growth * state + values[i + 1] * level + slope * ramp
            through[i] += (weight * state).real
