"""Many polynomials, each with one root on [0, 1]: Newton's method on all of them at once."""

from __future__ import annotations

from ridedown.compiled import part
from ridedown.solver.layout import DEGREE, STRIDE, row
from ridedown.solver.vector import ALL_LANES, WIDTH, lanes_of, load, spread, store, where

ROOT, MOVED = DEGREE + 1, DEGREE + 2
"""Rows for the roots, and for how far the last iteration moved them, below those of the coefficients."""
ROWS = DEGREE + 3

_ITERATIONS = 8  # at most
_DONE = 1e-12  # what the last iteration may have moved; the rest is bisected


@part
def solve(count, falling):
    """The roots of the first `count` columns, each a polynomial that goes from plus to minus once on [0, 1], into row ROOT.

    falling: rows by order of ascending powers, a polynomial a column (`layout.row`); in row ROOT, where to start from: best a
    place from which Newton's method cannot go astray. Where it does, halving the interval finds the root all the same.
    """
    root, moved = row(ROOT), row(MOVED)
    for x in range(0, count, WIDTH):
        t, change = load(falling, root + x), spread(1.0)
        for _ in range(_ITERATIONS):
            o = row(DEGREE) + x
            f = load(falling, o)
            slope = spread(0.0)
            for _j in range(DEGREE):  # Horner's rule, value and slope
                o -= STRIDE
                slope = slope * t + f
                f = f * t + load(falling, o)
            moving = change > _DONE  # one that has arrived stays, whatever its neighbours still do
            further = f / slope
            t = where(moving, min(max(t - further, 0.0), 1.0), t)
            change = where(moving, abs(further), change)
            if lanes_of(change <= _DONE) == ALL_LANES:
                break
        store(falling, root + x, t)
        store(falling, moved + x, change)
    for x in range(count):
        if not falling[moved + x] <= _DONE:
            falling[root + x] = _bisect(x, falling)


@part
def _bisect(x, falling):
    low, high = 0.0, 1.0
    for _ in range(53):
        t = 0.5 * (low + high)
        f = 0.0
        for j in range(DEGREE, -1, -1):
            f = f * t + falling[row(j) + x]
        if f > 0.0:
            low = t
        else:
            high = t
    return high
