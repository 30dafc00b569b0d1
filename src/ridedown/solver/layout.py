"""Where things lie in the solver's flat arrays.

Everything that the lanes carry is kept in rows of STRIDE numbers, one number a lane; a row's place follows from constants.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined

Table = np.ndarray[tuple[int, int], np.dtype[np.float64]]
Cube = np.ndarray[tuple[int, int, int], np.dtype[np.float64]]
"""Numbers in two and in three dimensions, as the kernels' annotations say them."""

STRIDE = 72
"""Lanes there is room for, in whole vectors; how many are in use is up to the caller."""

DEGREE = 16
"""Degree of the position series; accelerations have degree DEGREE - 2."""

ORDERS = DEGREE + 1

K, C, D0, V0, F0, PULL, FILL, FILLING = range(8)
"""Rows of a line of force: f = f0 + k (d - d0) + c (v - v0); a restraint's d0 falls at the rate PULL, and its force is FILL of
that, which changes at the rate FILLING."""
LINE_ROWS = 8

SPRING, DAMPER, AT_0, AT_1, SPRING_RISE, DAMPER_RISE, AT_2 = range(7)
"""Rows of the force of restraints side by side: f[j] = SPRING d[j] + DAMPER (j + 1) d[j + 1]; AT_1 more of order 1, and AT_0 in
place of order 0. Where a bag fills, SPRING_RISE d[j - 1] + DAMPER_RISE j d[j] more from order 2 on, and AT_2 of that order."""
SUM_ROWS = 7

COEFFICIENT_ROWS, PIECE_ROWS = 9, 3
"""Rows of an element's coefficients and of a piece of its curve: what they are is up to the law."""

A, B, GD0, GV0, G0, GA, DRIFT = range(7)
"""Rows of a guard: a (d - d0) + b (v - v0); a restraint's has g0 and ga d'' added, and its d0 falls at the rate DRIFT."""
GUARD_ROWS = 7

LATCH, SET, PIECE, REEL, PAYOUT, STAGE, BRANCH, BARE, RATE, STALLED = 0, 1, 2, 3, 4, 5, 6, 7, 8, 10
"""Rows of a law's memory. Threshold: v*. Curves: largest deflection so far, permanent set, piece unloaded from (0: never).
Restraints: belt that the reel has taken in, and that its limiter has let out; the limiter's stage, 2 for its stop; the mode
that the belt is in but for its reel; whether its damper alone gives the limiter's force; and, for each of two pretensioners,
the rate of its pull and whether it is stalled."""
MEMORY_ROWS = 12

NUMBER, NEEDS = range(2)
"""Rows of a law's mode: its number, and what a restraint in it needs looked at, as bits."""
MODE_ROWS = 2

GUARDED, RATES, BENDS, MOVES, PUSHES = 15, 16, 32, 64, 128
"""What a mode of a restraint needs: bit n for guard n of its four, if that can turn negative; guards that look at the rate, or
at the acceleration too; something that moves with time; a force."""

DOWN, UP, SLOWER, FASTER = range(4)
"""Rows of a bend: how far a coordinate, or a bar's tangent, can go down and up in a step beyond its straight course, and its
rate."""
BEND_ROWS = 4

HAD, TAKEN = range(2)
"""Rows of how many samples there are: before the step at hand, and with those in it."""
SAMPLED_ROWS = 2

BEST, WHEN = range(2)
"""Rows of a tracked extreme: the best so far, and its time."""
EXTREME_ROWS = 2


@inlined
def at(index, order):
    """Start of the row of that order in the series of a coordinate, element or bar."""
    return (index * ORDERS + order) * STRIDE


@inlined
def of_crash(table, index, crash):
    """The number of that row and crash, of a table in which one column may stand for all crashes."""
    return table[index, min(crash, table.shape[1] - 1)]


@inlined
def row(index):
    """Start of the row of that number."""
    return index * STRIDE


@inlined
def line_at(e, part):
    """Start of a row of an element's line of force."""
    return (e * LINE_ROWS + part) * STRIDE


@inlined
def coefficient_at(e, part):
    """Start of a row of an element's coefficients."""
    return (e * COEFFICIENT_ROWS + part) * STRIDE


@inlined
def piece_at(p, part):
    """Start of a row of a piece of a curve."""
    return (p * PIECE_ROWS + part) * STRIDE


@inlined
def sum_at(e, part):
    """Start of a row of the force of the restraints side by side that e is the first of."""
    return (e * SUM_ROWS + part) * STRIDE


@inlined
def guard_at(g, part):
    """Start of a row of a guard; pair p has guards 2 p and 2 p + 1. Element e has pair e; a restraint has another."""
    return (g * GUARD_ROWS + part) * STRIDE


@inlined
def guard_of(e, pair, n):
    """Guard n, 0 to 3, of restraint e, whose second pair of guards is `pair`."""
    return 2 * (e if n < 2 else pair) + n % 2


@inlined
def bend_at(i, part):
    """Start of a row of how a coordinate bends; the bars come after the coordinates."""
    return (i * BEND_ROWS + part) * STRIDE


@inlined
def mode_at(e, part):
    """Start of a row of the mode that an element is in."""
    return (e * MODE_ROWS + part) * STRIDE


@inlined
def memory_at(e, part):
    """Start of a row of what an element's law remembers."""
    return (e * MEMORY_ROWS + part) * STRIDE


@inlined
def extreme_at(k, part):
    """Start of a row of a tracked extreme."""
    return (k * EXTREME_ROWS + part) * STRIDE
