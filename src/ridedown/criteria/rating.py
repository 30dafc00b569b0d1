"""How well one curve agrees with another: the rating of ISO/TS 18571, from 0 to 1.

Here the two curves are brought onto the standard's grid and checked, and its four scores weighed; `agreement` computes them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria.agreement import agreement
from ridedown.criteria.checks import Floats, number, signal
from ridedown.errors import InvalidInput

INTERVAL = 1e-4
"""s, between samples: the standard's parameters hold for 10 kHz."""

SHORTEST, LONGEST = 0.010, 2.0
"""s, of the interval that is rated. Shorter than 10 ms the smoothing of the slopes, nine samples, reaches over a tenth of it.
The time to search shift and warping grows as the square of the length: 3 ms for 0.15 s, half a second for 2 s."""

GRADES = ((0.94, "excellent"), (0.80, "good"), (0.58, "fair"), (0.0, "poor"))
"""A rating above the number has the grade; one of 0 is poor."""

WEIGHTS = (0.4, 0.2, 0.2, 0.2)
"""Of corridor, phase, magnitude and slope."""


class Curve(Protocol):
    """Anything that gives its times [s] and its values in SI as `si`, as a time history does."""

    @property
    def si(self) -> tuple[ArrayLike, ArrayLike]:
        """Times and values."""
        ...


@dataclass(frozen=True, slots=True)
class Rating:
    """The rating and its four parts, each from 0 to 1, the grade in words, and the interval [s] that was compared.

    shift: how much later than the reference the candidate is where they correlate best [s]; negative where it is early.
    """

    value: float
    corridor: float
    phase: float
    magnitude: float
    slope: float
    grade: str
    start: float
    end: float
    shift: float


def rating(
    reference: Curve | tuple[ArrayLike, ArrayLike],
    candidate: Curve | tuple[ArrayLike, ArrayLike],
    *,
    start: float | None = None,
    end: float | None = None,
) -> Rating:
    """Rate a candidate curve, such as a simulated one, against a reference, such as a measured one, by ISO/TS 18571.

    corridor: how far within 5 % to 50 % of the reference's peak it runs. phase: by how much it must be shifted to correlate
    best, up to 20 % of the interval. magnitude: what is left after shift and dynamic time warping. slope: how the slopes agree
    after the shift. The rating is 0.4, 0.2, 0.2 and 0.2 of them. It is not symmetric, and it depends on the interval: give
    `start` and `end` [s] where the curves have long flat tails.

    Parameters: reference, candidate: (times [s], values) each, or objects that give them as `si`, in one and the same unit.
    Both are read off at 10 kHz, straight between their samples, over the interval they share.

    >>> import numpy as np
    >>> t = np.linspace(0.0, 0.1, 1001)
    >>> pulse = 400.0 * np.sin(np.pi * t / 0.1) ** 2
    >>> same = rating((t, pulse), (t, pulse))
    >>> same.value, same.grade
    (1.0, 'excellent')

    Raises: InvalidInput: a bad signal, too short or too long a shared interval, or a curve that is constant over it, which has
    no phase and no slope to compare.

    References: ISO/TS 18571:2014, Road vehicles - Objective rating metric for non-ambiguous signals: clause 5, data at 10 kHz;
    6.1, weights; 6.2, corridors; 6.3, phase, magnitude and slope. The clauses are known by their headings only. What they
    say is second hand: the definitions and the constants are those of the package objective-rating-metrics 1.3 of the Vehicle
    Safety Institute, Graz University of Technology, as are the ways of equal cost that the warping prefers; the grades' bounds
    are from memory. The package is not part of this one; tests hold the scores against it. Of shifts that correlate equally
    the smallest is meant, and here equal means within 1e-12; the package, which compares to the last bit, takes any of them
    where the curves are straight lines. The second edition, of 2024, was not at hand.
    """
    first, second = _samples(reference, "reference"), _samples(candidate, "candidate")
    begin = max(first[0][0], second[0][0]) if start is None else number(start, "start", "s")
    finish = min(first[0][-1], second[0][-1]) if end is None else number(end, "end", "s")
    slack = 1e-9
    for name, (times, _) in (("reference", first), ("candidate", second)):
        if begin < times[0] - slack or finish > times[-1] + slack:
            raise InvalidInput(
                f"{name}: got a curve from {times[0]:g} to {times[-1]:g} s; need one that covers {begin:g} .. {finish:g} s. "
                "Choose start and end within both curves."
            )
    if not SHORTEST - slack <= finish - begin <= LONGEST + slack:
        raise InvalidInput(
            f"end: got an interval of {finish - begin:g} s; need {SHORTEST:g} .. {LONGEST:g} s, shared by both curves. "
            "Choose start and end, or check the curves' times."
        )
    grid = begin + INTERVAL * np.arange(math.floor((finish - begin) / INTERVAL + 1e-6) + 1)
    columns = [_on_grid(samples, grid, name) for samples, name in ((first, "reference"), (second, "candidate"))]
    corridor, phase, magnitude, slope, shift = agreement(*columns)
    value = float(np.dot(WEIGHTS, (corridor, phase, magnitude, slope)))
    # 0.4 + 0.2 + 0.2 + 0.2 of four ones is 1 to the last bit or one below
    value = min(round(value, 15), 1.0)
    grade = next((grade for bound, grade in GRADES if value > bound), GRADES[-1][1])
    return Rating(value, corridor, phase, magnitude, slope, grade, float(grid[0]), float(grid[-1]), shift * INTERVAL)


def _samples(curve: Curve | tuple[ArrayLike, ArrayLike], name: str) -> tuple[Floats, Floats]:
    times, values = curve if isinstance(curve, tuple) else curve.si
    return signal(times, values, name)


def _on_grid(samples: tuple[Floats, Floats], grid: Floats, name: str) -> Floats:
    column: Floats = np.interp(grid, *samples)
    size = float(np.abs(column).max())
    if float(np.ptp(column)) <= 1e-12 * size:
        raise InvalidInput(
            f"{name}: got a curve that is {column[0]:g} all through {grid[0]:g} .. {grid[-1]:g} s; need one that moves. "
            "Choose an interval in which both do."
        )
    return column
