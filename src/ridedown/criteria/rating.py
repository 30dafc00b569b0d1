"""How well one curve agrees with another: the rating of ISO/TS 18571, from 0 to 1.

The rating itself is the package objective-rating-metrics of the Vehicle Safety Institute, Graz University of Technology; here
the two curves are brought onto the standard's grid and checked, and its four parts are named.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria.checks import Floats, number, signal
from ridedown.errors import InvalidInput

INTERVAL = 1e-4
"""s, between samples: the standard's parameters hold for 10 kHz."""

SHORTEST, LONGEST = 0.010, 0.5
"""s, of the interval that is rated. Shorter than 10 ms the smoothing of the slopes, nine samples, reaches over a tenth of it.
The memory for the time warping grows as the square of the length: 0.3 s take 0.6 GB, 0.5 s take 1 GB (measured)."""

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
    """The rating and its four parts, each from 0 to 1, the grade in words, and the interval [s] that was compared."""

    value: float
    corridor: float
    phase: float
    magnitude: float
    slope: float
    grade: str
    start: float
    end: float


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

    Raises: InvalidInput: the package is not installed, a bad signal, too short or too long a shared interval, or a curve that
    is constant over it, which has no phase and no slope to compare.

    References: ISO/TS 18571:2014, Road vehicles - Objective rating metric for non-ambiguous signals. The grades' bounds 0.94,
    0.80 and 0.58 are the standard's.
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
    parts = _parts(grid, *columns)
    value = float(np.dot(WEIGHTS, parts))
    # 0.4 + 0.2 + 0.2 + 0.2 of four ones is 1 to the last bit or one below
    value = min(round(value, 15), 1.0)
    grade = next((grade for bound, grade in GRADES if value > bound), GRADES[-1][1])
    return Rating(value, *parts, grade, float(grid[0]), float(grid[-1]))


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


def _parts(grid: Floats, reference: Floats, candidate: Floats) -> tuple[float, float, float, float]:
    """Corridor, phase, magnitude and slope, unrounded."""
    try:
        from objective_rating_metrics.rating import ISO18571  # noqa: PLC0415  imports matplotlib and compiles: seconds
    except ImportError:
        raise InvalidInput(
            "rating: got no package objective-rating-metrics; need it for ISO/TS 18571. pip install 'ridedown[rating]'"
        ) from None

    # Where a shifted piece is flat its correlation is 0/0, which the package rightly never takes for the best.
    with np.errstate(invalid="ignore", divide="ignore"):
        rated = ISO18571(np.column_stack((grid, reference)), np.column_stack((grid, candidate)))
        parts = rated.corridor_rating(-1), rated.phase_rating(-1), rated.magnitude_rating(-1), rated.slope_rating(-1)
    corridor, phase, magnitude, slope = (float(part) for part in parts)
    if not all(math.isfinite(part) for part in (corridor, phase, magnitude, slope)):
        raise InvalidInput(
            "reference: got a curve that is flat where the shifted candidate meets it; need one that moves there. "
            "Choose another interval."
        )
    return corridor, phase, magnitude, slope
