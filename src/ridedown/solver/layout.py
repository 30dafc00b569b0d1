"""Where things lie in the solver's flat arrays.

Everything that the lanes carry is kept in rows of STRIDE numbers, one number a lane; a row's place follows from constants.
"""

from __future__ import annotations

from ridedown.compiled import inlined

STRIDE = 72
"""Lanes there is room for, in whole vectors; how many are in use is up to the caller."""

DEGREE = 16
"""Degree of the position series; accelerations have degree DEGREE - 2."""

ORDERS = DEGREE + 1

K, C, D0, V0, F0 = range(5)
"""Rows of a line of force: f = f0 + k (d - d0) + c (v - v0)."""
LINE_ROWS = 5

A, B, GD0, GV0 = range(4)
"""Rows of a guard: a (d - d0) + b (v - v0)."""
GUARD_ROWS = 4

LATCH, SET, PIECE = range(3)
"""Rows of a law's memory. Threshold: v*. Plastic: largest deflection so far, permanent set, piece unloaded from (0: never)."""
MEMORY_ROWS = 3

BEST, WHEN = range(2)
"""Rows of a tracked extreme: the best so far, and its time."""
EXTREME_ROWS = 2


@inlined
def at(index, order):
    """Start of the row of that order in the series of a coordinate, element or bar."""
    return (index * ORDERS + order) * STRIDE


@inlined
def row(index):
    """Start of the row of that number."""
    return index * STRIDE


@inlined
def line_at(e, part):
    """Start of a row of an element's line of force."""
    return (e * LINE_ROWS + part) * STRIDE


@inlined
def guard_at(g, part):
    """Start of a row of a guard; element e has guards 2 e and 2 e + 1."""
    return (g * GUARD_ROWS + part) * STRIDE


@inlined
def memory_at(e, part):
    """Start of a row of what an element's law remembers."""
    return (e * MEMORY_ROWS + part) * STRIDE


@inlined
def extreme_at(k, part):
    """Start of a row of a tracked extreme."""
    return (k * EXTREME_ROWS + part) * STRIDE
