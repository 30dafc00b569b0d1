"""Roots and extrema of a polynomial on [0, 1], never by sampling.

A polynomial's coefficients in the Bernstein basis bound it, and their sign changes bound the number of its roots (Descartes'
rule in the Bernstein form): none means no root, one means exactly one. Halving the interval (de Casteljau) settles the rest.
See G. Farin, "Curves and Surfaces for CAGD", 5th ed. (2002), ch. 5; J. Lane and R. Riesenfeld, "Bounds on a polynomial",
BIT 21 (1981) 112-117.

Polynomials are given as coefficients p[first] .. p[last] of ascending powers, `p[first]` being the constant.
"""

from __future__ import annotations

from math import comb

import numpy as np

from ridedown.solver.cache import kernel

MAX_DEGREE = 24
NO_ROOT = 2.0
"""What `first_root` answers where there is none: outside [0, 1]."""

_DEPTH = 40  # halvings; a dip still undecided at 2^-40 of the step is a touch within round-off
_DIFFERENCES, _DERIVATIVE = _DEPTH + 1, _DEPTH + 2  # rows to work in, below those of the halvings
_ITERATIONS = 80  # of the bracketed Newton search: bisection alone would need 53
_NEWTON_DONE = 1e-9  # the error left by a Newton step of this length is of the order of its square

_INVERSE_BINOMIAL = np.array(
    [[1.0 / comb(n, k) if k <= n else 0.0 for k in range(MAX_DEGREE + 1)] for n in range(MAX_DEGREE + 1)]
)


@kernel
def value(p, first, last, t):
    """The polynomial at t."""
    total = p[last]
    for k in range(last - 1, first - 1, -1):
        total = total * t + p[k]
    return total


@kernel
def _differentiate(p, first, last, room):
    """Coefficients of the derivative, into room[_DERIVATIVE, 0] .. [last - first - 1]."""
    for k in range(1, last - first + 1):
        room[_DERIVATIVE, k - 1] = k * p[first + k]


@kernel
def _to_bernstein(p, first, last, room):
    """Bernstein coefficients on [0, 1], into room[0, 0] .. [last - first]."""
    n = last - first
    for k in range(n + 1):
        room[0, k] = p[first + k] * _INVERSE_BINOMIAL[n, k]
    for start in range(n - 1, -1, -1):
        for i in range(start + 1, n + 1):
            room[0, i] += room[0, i - 1]


@kernel
def _halve(room, depth, n):
    """De Casteljau at the middle: row depth + 1 takes the left half's coefficients, row depth becomes the right half's."""
    room[depth + 1, 0] = room[depth, 0]
    for level in range(1, n + 1):
        for k in range(n - level + 1):
            room[depth, k] = 0.5 * (room[depth, k] + room[depth, k + 1])
        room[depth + 1, level] = room[depth, 0]


@kernel
def _first_sign(room, row, n):
    """Sign of the first coefficient of a row that is not zero: the polynomial's just after the start of its interval."""
    for i in range(n + 1):
        if room[row, i] != 0.0:
            return 1 if room[row, i] > 0.0 else -1
    return 0


@kernel
def _sign_changes(room, row, n):
    """How often the sign changes along a row, zeros passed over; stops counting at two."""
    changes = 0
    sign = 0
    for i in range(n + 1):
        s = 1 if room[row, i] > 0.0 else (-1 if room[row, i] < 0.0 else 0)
        if s != 0:
            if sign != 0 and s != sign:
                changes += 1
                if changes == 2:
                    return 2
            sign = s
    return changes


@kernel
def _only_root(p, first, last, low, high):
    """The one root in [low, high]: Newton from the secant's crossing, kept in its bracket."""
    at_low, at_high = value(p, first, last, low), value(p, first, last, high)
    falling = at_low > at_high
    t = low + (high - low) * at_low / (at_low - at_high)
    if not (low < t < high):
        t = 0.5 * (low + high)
    for _ in range(_ITERATIONS):
        f, slope = p[last], 0.0
        for k in range(last - 1, first - 1, -1):
            slope = slope * t + f
            f = f * t + p[k]
        if (f > 0.0) == falling:
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


@kernel
def first_root(p, first, last, room):
    """The first t in (0, 1] at which a polynomial with p[first] > 0 turns negative, or NO_ROOT.

    `room` is to work in, of shape WORK_SHAPE.
    """
    n = last - first
    low, end, fastest = p[first], p[first], 0.0
    for k in range(first + 1, last + 1):
        low += min(p[k], 0.0)
        end += p[k]
        fastest += (k - first) * (p[k] if k == first + 1 else max(p[k], 0.0))
    if low > 0.0 or (fastest < 0.0 and end > 0.0):
        return NO_ROOT
    if fastest < 0.0:
        return _only_root(p, first, last, 0.0, 1.0)  # falls throughout
    _to_bernstein(p, first, last, room)
    depth = 0
    start, width = 0.0, 1.0
    # row `depth` holds the interval at hand, the rows above it the right halves still to do
    while True:
        if _first_sign(room, depth, n) < 0:
            return start  # the root lies on the boundary between two halves
        changes = _sign_changes(room, depth, n)
        if changes == 1:
            return _only_root(p, first, last, start, start + width)
        if changes >= 2 and depth < _DEPTH:
            _halve(room, depth, n)
            depth += 1
            width *= 0.5
            continue
        # nothing here: on to the next interval on the right
        start += width
        if depth == 0:
            return NO_ROOT
        depth -= 1
        while width < 1.0 and _is_multiple(start, 2.0 * width):
            width *= 2.0


@kernel
def _is_multiple(x, unit):
    """Whether x, a dyadic fraction, is a whole multiple of `unit`."""
    return np.floor(x / unit) * unit == x


@kernel
def maximum(p, first, last, best, room):
    """Largest value on [0, 1] and where, or (best, -1) if nothing there exceeds `best`."""
    n = last - first
    where = -1.0
    end, slowest, fastest = p[first], 0.0, 0.0
    for k in range(first + 1, last + 1):
        end += p[k]
        slope = (k - first) * p[k]
        slowest += slope if k == first + 1 else min(slope, 0.0)
        fastest += slope if k == first + 1 else max(slope, 0.0)
    if p[first] > best:
        best, where = p[first], 0.0
    if end > best:
        best, where = end, 1.0
    if slowest >= 0.0 or fastest <= 0.0:
        return best, where  # rises or falls throughout
    _to_bernstein(p, first, last, room)
    derivative_known = False
    depth = 0
    start, width = 0.0, 1.0
    while True:
        top = room[depth, 0]
        for i in range(1, n + 1):
            top = max(top, room[depth, i])
        split = False
        if top > best:
            if room[depth, 0] > best:
                best, where = room[depth, 0], start
            if room[depth, n] > best:
                best, where = room[depth, n], start + width
            for i in range(n):
                room[_DIFFERENCES, i] = room[depth, i + 1] - room[depth, i]
            changes = _sign_changes(room, _DIFFERENCES, n - 1)
            split = changes >= 2 and depth < _DEPTH
            if changes == 1 and _first_sign(room, _DIFFERENCES, n - 1) > 0:
                if not derivative_known:
                    _differentiate(p, first, last, room)
                    derivative_known = True
                t = _only_root(room[_DERIVATIVE], 0, n - 1, start, start + width)
                peak = value(p, first, last, t)
                if peak > best:
                    best, where = peak, t
        if split:
            _halve(room, depth, n)
            depth += 1
            width *= 0.5
            continue
        start += width
        if depth == 0:
            return best, where
        depth -= 1
        while width < 1.0 and _is_multiple(start, 2.0 * width):
            width *= 2.0


WORK_SHAPE = (_DEPTH + 3, MAX_DEGREE + 1)
"""Shape of the room that `first_root` and `maximum` work in."""
