"""The integral behind the severity index: of x^2.5 over a signal that is straight between its samples, exactly."""

from __future__ import annotations

import math

from ridedown.compiled import kernel, part
from ridedown.criteria.checks import Floats
from ridedown.criteria.strung import Ints


@part
def _mean_power(one: float, other: float) -> float:
    """Mean of x^2.5 over the line from `one` to `other`, both >= 0."""
    middle, half = 0.5 * (one + other), 0.5 * abs(one - other)
    # (b^3.5 - a^3.5)/(3.5 (b - a)) cancels where a and b are close: there the series in (half/middle)^2, to 1e-15 below 0.05
    if half < 0.05 * middle:
        e = (half / middle) * (half / middle)
        series = 1.0 + e * (0.625 + e * (-0.0078125 - e * (1.5 * 2.5 * 0.5 * 0.5 * 1.5 * 2.5 / 5040.0)))
        return middle * middle * math.sqrt(middle) * series
    if half == 0.0:
        return 0.0
    most, least = middle + half, max(middle - half, 0.0)
    return (most * most * most * math.sqrt(most) - least * least * least * math.sqrt(least)) / (7.0 * half)


@kernel
def severity(time: Floats, a: Floats, starts: Ints, unit: float, found: Floats) -> None:
    """The integral of (a/unit)^2.5 over each of R signals end to end (see `strung`), nowhere below 0: (R,)."""
    for r in range(starts.size - 1):
        total = 0.0
        for i in range(starts[r], starts[r + 1] - 1):
            total += (time[i + 1] - time[i]) * _mean_power(a[i] / unit, a[i + 1] / unit)
        found[r] = total
