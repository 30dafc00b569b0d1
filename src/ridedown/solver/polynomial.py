"""Roots and extrema of a polynomial on [0, 1], never by sampling.

A polynomial's coefficients in the Bernstein basis bound it, and their sign changes bound the number of its roots (Descartes'
rule in the Bernstein form): none means no root, one means exactly one. Halving the interval (de Casteljau) settles the rest.
See G. Farin, "Curves and Surfaces for CAGD", 5th ed. (2002), ch. 5; J. Lane and R. Riesenfeld, "Bounds on a polynomial",
BIT 21 (1981) 112-117.

A polynomial is an array of ascending powers; trailing zeros do no harm.
"""

from __future__ import annotations

from math import comb

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.network.model import Floats
from ridedown.solver.layout import Table

MAX_DEGREE = 24
NO_ROOT = 2.0
"""What `first_root` answers where there is none: outside [0, 1]."""

TIE = 1e-13
"""Of a value: what is no more than this above another is the same but for round-off."""

_DEPTH = 40  # halvings; a dip still undecided at 2^-40 of the step is a touch within round-off
_ITERATIONS = 80  # of the bracketed Newton search: bisection alone would need 53
_NEWTON_DONE = 1e-9  # the error left by a Newton step of this length is of the order of its square
_DIFFERENCES, _DERIVATIVE = _DEPTH + 1, _DEPTH + 2  # rows to work in, below those of the halvings

TO_BERNSTEIN = np.array(
    [
        [[comb(i, k) / comb(n, k) if k <= i <= n else 0.0 for i in range(MAX_DEGREE + 1)] for k in range(n + 1)]
        + [[0.0] * (MAX_DEGREE + 1)] * (MAX_DEGREE - n)
        for n in range(MAX_DEGREE + 1)
    ]
)
"""[n, k, i]: what the power k adds to the Bernstein coefficient i of degree n."""


@inlined
def beats(value, best):
    """Whether a value exceeds the best so far by more than round-off: of a level top, the first point is wanted."""
    return value - TIE * abs(value) > best


@part
def _to_bernstein(p, room):
    """Bernstein coefficients on [0, 1], into the first row."""
    n = p.size - 1
    for i in range(n + 1):
        room[0, i] = p[0]
    for k in range(1, n + 1):
        for i in range(n + 1):
            room[0, i] += TO_BERNSTEIN[n, k, i] * p[k]


@part
def _halve(room, depth, n):
    """De Casteljau at the middle: row depth + 1 takes the left half's coefficients, row depth becomes the right half's."""
    room[depth + 1, 0] = room[depth, 0]
    for level in range(1, n + 1):
        for k in range(n - level + 1):
            room[depth, k] = 0.5 * (room[depth, k] + room[depth, k + 1])
        room[depth + 1, level] = room[depth, 0]


@part
def _signs(b, n):
    """The sign of the first of b[0] .. b[n] that is not zero, and how often the sign changes along them, counted up to two.

    The first is the polynomial's sign just after the start of its interval.
    """
    first, sign, changes = 0, 0, 0
    for i in range(n + 1):
        s = 1 if b[i] > 0.0 else (-1 if b[i] < 0.0 else 0)
        if s != 0:
            if sign == 0:
                first = s
            elif s != sign:
                changes += 1
                if changes == 2:
                    break
            sign = s
    return first, changes


@part
def _value(p, t):
    total = p[p.size - 1]
    for k in range(p.size - 2, -1, -1):
        total = total * t + p[k]
    return total


@part
def _only_root(p, low, high):
    """The one root between low and high of a polynomial that starts positive there and ends negative.

    Newton from the secant's crossing, kept in its bracket. An end of the interval may itself be a root, for halvings like to
    end at roots that are round numbers: the bracket is drawn in first until both its ends have a sign of their own.
    """
    n = p.size - 1
    round_off = 0.0
    for k in range(n + 1):
        round_off += 1e-15 * abs(p[k])
    at_low, at_high = _value(p, low), _value(p, high)
    for _ in range(_ITERATIONS):
        if at_low > round_off and at_high < -round_off:
            break
        t = 0.5 * (low + high)
        f = _value(p, t)
        if f > round_off or (f >= -round_off and at_low <= round_off):
            low, at_low = t, f
        else:
            high, at_high = t, f
        if high - low <= 4e-16:
            return high
    t = low + (high - low) * at_low / (at_low - at_high)
    for _ in range(_ITERATIONS):
        f, slope = p[n], 0.0
        for k in range(n - 1, -1, -1):
            slope = slope * t + f
            f = f * t + p[k]
        if f > 0.0:
            low = t
        else:
            high = t
        nearer = t - f / slope
        if low <= nearer <= high:
            if abs(nearer - t) <= _NEWTON_DONE:
                return nearer
            t = nearer
        else:
            if high - low <= 4e-16:
                return t
            t = 0.5 * (low + high)
    return t


@part
def _next_interval(start, width):
    """Start and width of the interval after [start, start + width], in the order of the halvings."""
    start += width
    while width < 1.0 and np.floor(start / (2.0 * width)) * 2.0 * width == start:
        width *= 2.0
    return start, width


@kernel
def first_root(p: Floats, room: Table) -> float:
    """The first t in (0, 1] at which a polynomial that is positive at 0 turns negative, or NO_ROOT.

    `room` is to work in, of shape WORK_SHAPE.
    """
    n = p.size - 1
    _to_bernstein(p, room)
    depth = 0
    start, width = 0.0, 1.0
    # row `depth` holds the interval at hand, the rows above it the right halves still to do
    while True:
        first, changes = _signs(room[depth], n)
        if first < 0:
            return start  # the root lies on the boundary between two halves
        if changes == 1:
            return _only_root(p, start, start + width)
        if changes == 2 and depth < _DEPTH:
            _halve(room, depth, n)
            depth += 1
            width *= 0.5
            continue
        if depth == 0:
            return NO_ROOT
        depth -= 1
        start, width = _next_interval(start, width)


@kernel
def maximum(p: Floats, best: float, room: Table) -> tuple[float, float]:
    """The largest value on [0, 1] and where first, or (best, -1) if nothing there exceeds `best` by more than round-off."""
    n = p.size - 1
    where = -1.0
    _to_bernstein(p, room)
    for k in range(1, n + 1):
        room[_DERIVATIVE, k - 1] = k * p[k]
    depth = 0
    start, width = 0.0, 1.0
    while True:
        top = room[depth, 0]
        for i in range(1, n + 1):
            top = max(top, room[depth, i])
        split = False
        if top > best:
            if beats(room[depth, 0], best):
                best, where = room[depth, 0], start
            if beats(room[depth, n], best):
                best, where = room[depth, n], start + width
            for i in range(n):
                room[_DIFFERENCES, i] = room[depth, i + 1] - room[depth, i]
            first, changes = _signs(room[_DIFFERENCES], n - 1)
            split = changes == 2 and depth < _DEPTH
            if changes == 1 and first > 0:
                t = _only_root(room[_DERIVATIVE, :n], start, start + width)
                peak = _value(p, t)
                if beats(peak, best):
                    best, where = peak, t
        if split:
            _halve(room, depth, n)
            depth += 1
            width *= 0.5
            continue
        if depth == 0:
            return best, where
        depth -= 1
        start, width = _next_interval(start, width)


WORK_SHAPE = (_DEPTH + 3, MAX_DEGREE + 1)
"""Shape of the room that `first_root` and `maximum` work in."""
