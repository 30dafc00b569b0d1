"""Means over a moving window and a phaseless low-pass, both exact for a signal that is linear between its samples.

Neither knows a sampling rate: the samples may lie anywhere, two at one time are a jump.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Values that differ by less, relative, are one value: of several windows that are as good, the first is named.
_ROUNDING = 1e-11


def first_largest(values: Floats) -> int:
    """The index of the first of the values, none negative, that is the largest but for rounding."""
    return int(np.argmax(values >= values.max() * (1.0 - _ROUNDING)))


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
    last = float(time[-1]) - window
    begin = max(begin, float(time[0]))
    if last < begin - 1e-12 * max(abs(last), window):
        return None
    last = max(last, begin)
    breaks = np.unique(np.concatenate((time, time - window, [begin, last])))
    breaks = breaks[(breaks >= begin) & (breaks <= last)]
    if breaks.size == 1:
        breaks = np.repeat(breaks, 2)
    # Three points fix each mean's quadratic on a piece exactly.
    a, b = breaks[:-1], breaks[1:]
    middle = 0.5 * (a + b)
    means = [_means(time, components, at, window) for at in (a, middle, b)]
    c0, c1, c2 = means[0], 4.0 * means[1] - 3.0 * means[0] - means[2], 2.0 * (means[0] + means[2]) - 4.0 * means[1]
    quartic = np.stack(
        (
            (c0 * c0).sum(axis=0),
            (2.0 * c0 * c1).sum(axis=0),
            (c1 * c1 + 2.0 * c0 * c2).sum(axis=0),
            (2.0 * c1 * c2).sum(axis=0),
            (c2 * c2).sum(axis=0),
        )
    )
    ends = np.append(quartic[0], quartic[:, -1].sum())
    first = first_largest(ends)
    best, where = float(ends[first]), float(breaks[first])
    bound = (_TO_BERNSTEIN @ quartic).max(axis=0)
    for p in np.flatnonzero(bound > best * (1.0 + _ROUNDING)):
        slope = (quartic[1:, p] * np.array([1.0, 2.0, 3.0, 4.0]))[::-1]
        for root in np.roots(slope):
            x = float(root.real)
            if abs(root.imag) < 1e-6 and 0.0 < x < 1.0:
                value = float(np.polyval(quartic[::-1, p], x))
                if value > best * (1.0 + _ROUNDING):
                    best, where = value, float(a[p] + x * (b[p] - a[p]))
    return Window(math.sqrt(max(best, 0.0)), where, where + window)


# The power basis on [0, 1] as Bernstein coefficients: b_i = sum_j C(i, j)/C(4, j) c_j.
_TO_BERNSTEIN = np.array([[math.comb(i, j) / math.comb(4, j) for j in range(5)] for i in range(5)])


def _means(time: Floats, components: Floats, at: Floats, window: float) -> Floats:
    """Means, (k, m), of the components over [at, at + window]."""
    return (_primitive(time, components, at + window) - _primitive(time, components, at)) / window


def _primitive(time: Floats, components: Floats, at: Floats) -> Floats:
    """The integrals, (k, m), of piecewise-linear components from the first sample to the times `at`."""
    step = np.diff(time)
    whole = np.zeros_like(components)
    np.cumsum(0.5 * step * (components[:, 1:] + components[:, :-1]), axis=1, out=whole[:, 1:])
    k = np.clip(np.searchsorted(time, at, side="right") - 1, 0, step.size - 1)
    inside = np.clip(at - time[k], 0.0, step[k])
    length = np.where(step[k] > 0.0, step[k], 1.0)
    slope = (components[:, k + 1] - components[:, k]) / length
    result: Floats = whole[:, k] + inside * (components[:, k] + 0.5 * inside * slope)
    return result


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
    w = 2.0 * math.pi * cutoff * (math.sqrt(2.0) - 1.0) ** -0.25  # two passes: the corner of each lies above the cut-off
    pole = w * complex(-1.0, 1.0) / math.sqrt(2.0)
    weight = w / (2.0 * math.sqrt(2.0)) * complex(1.0, -1.0)
    forwards = _decayed(np.diff(time), components, pole)
    backwards = _decayed(np.diff(time)[::-1], components[:, ::-1], pole)[:, ::-1]
    result: Floats = (weight * (forwards + backwards)).real
    return result


def _decayed(step: Floats, components: Floats, pole: complex) -> NDArray[np.complex128]:
    """The integral of exp(pole (t - s)) x(s) over all s before each sample, (k, n), for a signal constant before the first."""
    growth = np.exp(pole * step)
    level = np.expm1(pole * step) / pole
    # (exp(z) - 1 - z)/pole^2 cancels for short steps: there its series is used
    z = pole * step
    series = step**2 * (0.5 + z / 6.0 + z**2 / 24.0 + z**3 / 120.0)
    ramp = np.where(np.abs(z) < 1e-3, series, (np.expm1(z) - z) / pole**2)
    slope = np.diff(components, axis=1) / np.where(step > 0.0, step, 1.0)
    state = np.empty(components.shape, dtype=np.complex128)
    state[:, 0] = -components[:, 0] / pole
    added = components[:, :-1] * level + slope * ramp
    for i in range(step.size):
        state[:, i + 1] = growth[i] * state[:, i] + added[:, i]
    return state
