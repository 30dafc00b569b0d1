"""The shapes of generic pulses, as polynomials on pieces: pure functions of numbers.

A shape is `(start, series)`: start (P,), where each piece starts, the first at 0 and rising; series (P, D), coefficients in
ascending powers of the time since then. Shapes of one parameter or none last from 0 to 1 and have their largest value 1; after
that they are zero for ever. Sines are their own power series, cut where what is left out is below rounding.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Shape = tuple[Floats, Floats]

ORDERS = 15
"""Coefficients of a piece, at most."""

_QUARTERS = 3
"""Pieces to a quarter of a sine's period: (pi/6)^15 / 15! = 5e-17 is then the first term left out."""


def square() -> Shape:
    """Constant.

    >>> [array.tolist() for array in square()]
    [[0.0, 1.0], [[1.0], [0.0]]]
    """
    return np.array([0.0, 1.0]), np.array([[1.0], [0.0]])


def half_sine() -> Shape:
    """`sin(pi s)`."""
    return _sine(2 * _QUARTERS, math.pi, 0.0, 1.0, 0.0)


def haversine() -> Shape:
    """`(1 - cos(2 pi s)) / 2`, which begins and ends without a kink."""
    return _sine(4 * _QUARTERS, 2.0 * math.pi, -0.5 * math.pi, 0.5, 0.5)


def triangle(peak_at: float) -> Shape:
    """Straight up to the peak at `peak_at`, 0 .. 1, and straight down.

    >>> [array.tolist() for array in triangle(0.25)]
    [[0.0, 0.25, 1.0], [[0.0, 4.0], [1.0, -1.3333333333333333], [0.0, 0.0]]]
    """
    return through([0.0, peak_at, 1.0], [0.0, 1.0, 0.0])


def trapezoid(rise: float, fall: float) -> Shape:
    """Straight up during the part `rise`, constant, straight down during the part `fall`; both at least 0, at most 1 together.

    >>> trapezoid(0.25, 0.5)[0].tolist()
    [0.0, 0.25, 0.5, 1.0]
    """
    return through([0.0, rise, 1.0 - fall, 1.0], [0.0, 1.0, 1.0, 0.0])


def ramp(first: float, last: float) -> Shape:
    """Straight from the first value to the last.

    >>> ramp(2.0, 0.5)[1].tolist()
    [[2.0, -1.5], [0.0, 0.0]]
    """
    return through([0.0, 1.0], [first, last])


def through(times: list[float] | Floats, values: list[float] | Floats) -> Shape:
    """Straight lines through points, zero before the first and after the last; two at one time are a jump.

    times: (n,), not below 0, never falling. Of more than two points at one time, those between do not count.

    >>> [array.tolist() for array in through([1.0, 2.0], [3.0, 5.0])]
    [[0.0, 1.0, 2.0], [[0.0, 0.0], [3.0, 2.0], [0.0, 0.0]]]
    """
    time, value = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
    width = np.diff(time)
    kept = np.flatnonzero(width > 0.0)
    slope = np.diff(value)[kept] / width[kept]
    start = np.append(time[kept], time[-1])
    series = np.vstack((np.column_stack((value[kept], slope)), np.zeros((1, 2))))
    if start[0] > 0.0:
        start, series = np.insert(start, 0, 0.0), np.vstack((np.zeros((1, 2)), series))
    return start, series


def _sine(pieces: int, rate: float, phase: float, height: float, middle: float) -> Shape:
    """`middle + height sin(rate s + phase)` from 0 to 1."""
    start = np.arange(pieces + 1) / pieces
    orders = np.arange(ORDERS)
    factorials = np.array([math.factorial(order) for order in orders], dtype=np.float64)
    angle = rate * start[:-1, None] + phase
    # sin(x + u) = sum sin(x + k pi/2) u^k / k!, with the sines of quarter turns taken exactly
    turned = np.stack([np.sin(angle), np.cos(angle), -np.sin(angle), -np.cos(angle)], axis=-1)[:, 0, :]
    series = height * turned[:, orders % 4] * rate**orders / factorials
    series[:, 0] += middle
    return start, np.vstack((series, np.zeros((1, ORDERS))))
