"""Many polynomials on [0, 1] side by side: how often each changes its sign, and the roots of those that do so once."""

from __future__ import annotations

from ridedown.compiled import part
from ridedown.solver.layout import DEGREE, STRIDE, row
from ridedown.solver.polynomial import TO_BERNSTEIN
from ridedown.solver.vector import ALL_LANES, WIDTH, lanes_of, load, spread, store, where

ROOT, MOVED = DEGREE + 1, DEGREE + 2
"""Rows for the roots, and for how far the last iteration moved them, below those of the coefficients."""
ROWS = DEGREE + 3

_ITERATIONS = 8  # at most
_DONE = 1e-12  # what the last iteration may have moved; the rest is bisected


@part
def sign_changes(degree, shape):
    """How often eight polynomials fall through zero on [0, 1], and rise through it, at most; and where the last is, roughly.

    By Descartes' rule: no more often than their Bernstein coefficients do, and exactly once where those do. A coefficient of
    zero counts as both: whoever sees both must look closely. shape: the polynomials, in the first lanes of rows by order of
    ascending powers (`layout.row`).
    """
    falls, rises, place = spread(0.0), spread(0.0), spread(1.0)
    before = load(shape, row(0))
    for i in range(degree + 1):
        b = load(shape, row(0))
        for k in range(1, i + 1):
            b += TO_BERNSTEIN[degree, k, i] * load(shape, row(k))
        down, up, zero = (before > 0.0) & (b < 0.0), (before < 0.0) & (b > 0.0), b == 0.0
        falls += where(down | zero, 1.0, 0.0)
        rises += where(up | zero, 1.0, 0.0)
        place = where(down | up, (i - 1.0 + before / (before - b)) / degree, place)  # of the control polygon
        before = b
    return falls, rises, place


@part
def solve(count, falling):
    """The roots of the first `count` columns, each a polynomial that goes from plus to minus once on [0, 1], into row ROOT.

    falling: rows by order of ascending powers, a polynomial a column (`layout.row`); in row ROOT, where to start from: best a
    place from which Newton's method cannot go astray. Where it does, to another root just beyond an end of the interval too,
    halving what is left of the interval finds the root all the same.
    """
    root, moved = row(ROOT), row(MOVED)
    for x in range(0, count, WIDTH):
        t, change = load(falling, root + x), spread(1.0)
        low, high = spread(0.0), spread(1.0)
        for _ in range(_ITERATIONS):
            o = row(DEGREE) + x
            f = load(falling, o)
            slope = spread(0.0)
            for _j in range(DEGREE):  # Horner's rule, value and slope
                o -= STRIDE
                slope = slope * t + f
                f = f * t + load(falling, o)
            moving = change > _DONE  # one that has arrived stays, whatever its neighbours still do
            low, high = where(f > 0.0, t, low), where(f > 0.0, high, t)
            nearer = t - f / slope
            inside = (nearer >= low) & (nearer <= high)
            nearer = where(inside, nearer, 0.5 * (low + high))
            change = where(moving, where(inside, abs(nearer - t), 1.0), change)
            t = where(moving, nearer, t)
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
