"""The four scores of ISO/TS 18571 over two columns of samples taken at the same, evenly spaced times.

Shift and dynamic time warping are searched in memory that grows with the number of samples only. The warping path of least cost
is not kept and traced back: each cell of the band carries what the score needs of the best path to it, the sum of the
differences along the path and the sum of the reference. A row of the band is worked in the place of the one before it.
"""

from __future__ import annotations

import math

import numpy as np

from ridedown.compiled import kernel, part
from ridedown.criteria.checks import Floats, Table

INNER, OUTER = 0.05, 0.5
"""Half the widths of the corridors, of the reference's largest magnitude."""

LARGEST_SHIFT = 0.2
"""Of the number of samples: as much as the candidate is shifted, and where the phase score comes to 0."""

WARP = 0.1
"""Of the number of samples that overlap after the shift: fewer than this lie between two that are warped onto each other."""

WORST_MAGNITUDE, WORST_SLOPE = 0.5, 2.0
"""Relative errors at which the scores come to 0."""

# Correlations that differ by no more are equal: a straight line correlates with itself alike at every shift, but for rounding.
_TIE = 1e-12

Scores = tuple[float, float, float, float, int]
"""Corridor, phase, magnitude, slope; and the shift in samples, positive where the candidate is late."""


@part
def _corridor(reference: Floats, candidate: Floats) -> float:
    """Mean over the samples of 1 within the inner corridor, 0 beyond the outer, the square of a straight line between them."""
    largest = 0.0
    for i in range(reference.size):
        largest = max(largest, abs(reference[i]))
    inner, outer = INNER * largest, OUTER * largest
    total = 0.0
    for i in range(reference.size):
        left = (outer - abs(candidate[i] - reference[i])) / (outer - inner)
        left = min(max(left, 0.0), 1.0)
        total += left * left
    return total / reference.size


@part
def _spread(values: Floats, mean: Floats, spread: Floats) -> None:
    """Mean of the first i + 1 values, and the sum of the squares of their distances from it (Welford), for every i.

    spread is exactly zero as long as the values are equal.
    """
    mean[0], spread[0] = values[0], 0.0
    for i in range(1, values.size):
        off = values[i] - mean[i - 1]
        mean[i] = mean[i - 1] + off / (i + 1.0)
        spread[i] = spread[i - 1] + off * (values[i] - mean[i])


@part
def _covariance(one: Floats, i: int, mean: float, other: Floats, j: int, other_mean: float, size: int) -> float:
    """Sum of the products of the distances from their means, of `size` values from one[i] and other[j] on."""
    # four sums, as one would wait for itself at every addition
    a = b = c = d = 0.0
    whole = size - size % 4
    for k in range(0, whole, 4):
        a += (one[i + k] - mean) * (other[j + k] - other_mean)
        b += (one[i + k + 1] - mean) * (other[j + k + 1] - other_mean)
        c += (one[i + k + 2] - mean) * (other[j + k + 2] - other_mean)
        d += (one[i + k + 3] - mean) * (other[j + k + 3] - other_mean)
    for k in range(whole, size):
        a += (one[i + k] - mean) * (other[j + k] - other_mean)
    return (a + b) + (c + d)


@part
def _shift(reference: Floats, candidate: Floats, backward: Floats, moments: Floats, correlations: Floats) -> int:
    """The shift at which the curves correlate best; of equal ones the smallest, and the late candidate before the early one.

    backward: (2, n), the curves from their ends; moments: (8, n) of work; correlations: (2, n) of work, late and early.
    A piece that is flat has no correlation and is never the best.
    """
    size = reference.size
    curves = (reference, candidate, backward[0], backward[1])
    for k in range(4):
        _spread(curves[k], moments[2 * k], moments[2 * k + 1])
    shifts = int(LARGEST_SHIFT * size)
    best = -math.inf
    for k in range(shifts + 1):
        rest = size - k
        last = rest - 1
        for early in range(2):
            i, j = (k, 0) if early else (0, k)
            # what begins at sample 0 is counted from the front, what ends with the record from the back
            first, second = (4, 2) if early else (0, 6)
            spread = math.sqrt(moments[first + 1, last]) * math.sqrt(moments[second + 1, last])
            value = -math.inf
            if spread > 0.0:
                value = _covariance(reference, i, moments[first, last], candidate, j, moments[second, last], rest) / spread
            correlations[early, k] = value
            best = max(best, value)
    for k in range(shifts + 1):
        if correlations[0, k] >= best - _TIE:
            return k
        if correlations[1, k] >= best - _TIE:
            return -k
    return 0


@part
def _magnitude(
    reference: Floats, i: int, candidate: Floats, j: int, size: int, costs: Floats, paths: Floats, differences: Floats,
    references: Floats,
) -> float:  # fmt: skip
    """The score of what is left after dynamic time warping, of `size` samples from reference[i] and candidate[j] on.

    The path of least sum of squares goes by steps of one sample of either curve or of both, from the first pair to the last,
    and stays in the band. Of equal ways to a pair it takes the candidate's step, then the reference's, then both.
    costs, paths, differences, references: (>= 2 band + 3,) of work, by distance from the diagonal.
    """
    band = math.ceil(WARP * size) - 1
    width = 2 * band + 1
    for o in range(width + 2):
        paths[o], differences[o], references[o] = math.inf, 0.0, 0.0
    paths[band + 1] = 0.0  # so that the first pair, whose own cost is all that its path has, is reached at no cost
    for m in range(size):
        first, last = max(0, band - m), min(width, size - m + band)
        here = candidate[j + m]
        # In a loop of its own, so that no product is contracted with the sum of the path: equal paths have to stay equal.
        for o in range(first, last):
            off = here - reference[i + m - band + o]
            costs[o] = off * off
        before, before_difference, before_reference = math.inf, 0.0, 0.0
        for o in range(first, last):
            # the place o + 1 holds this distance from the diagonal, in the row before until it is overwritten
            path, difference, total = paths[o + 2], differences[o + 2], references[o + 2]
            if before < path:
                path, difference, total = before, before_difference, before_reference
            if paths[o + 1] < path:
                path, difference, total = paths[o + 1], differences[o + 1], references[o + 1]
            level = reference[i + m - band + o]
            before = path + costs[o]
            before_difference = difference + abs(here - level)
            before_reference = total + abs(level)
            paths[o + 1], differences[o + 1], references[o + 1] = before, before_difference, before_reference
    return _left(differences[band + 1], references[band + 1], WORST_MAGNITUDE)


@part
def _left(difference: float, size: float, worst: float) -> float:
    """The score of a relative error: 1 for none, 0 for the worst and beyond."""
    return 1.0 if difference == 0.0 else max(0.0, 1.0 - difference / size / worst)


@part
def _slope_at(values: Floats, first: int, size: int, k: int) -> float:
    """Slope at sample k of a piece of a curve, from one neighbour to the other, at its ends to the only one there."""
    before, after = first + max(k - 1, 0), first + min(k + 1, size - 1)
    slope: float = (values[after] - values[before]) / (after - before)
    return slope


@part
def _slope(reference: Floats, i: int, candidate: Floats, j: int, size: int) -> float:
    """The score of the slopes, each the mean over nine samples, fewer near the ends, of `size` samples after the shift."""
    difference = total = 0.0
    for k in range(size):
        half = min(k, size - 1 - k, 4)
        # the means near an end are over 1, 3, 5, 7 samples
        ours = theirs = 0.0
        for n in range(k - half, k + half + 1):
            ours += _slope_at(reference, i, size, n)
            theirs += _slope_at(candidate, j, size, n)
        difference += abs(theirs - ours) / (2 * half + 1)
        total += abs(ours) / (2 * half + 1)
    return _left(difference, total, WORST_SLOPE)


@kernel
def scores(reference: Floats, candidate: Floats, level: Table, work: Table, band: Table) -> Scores:
    """Corridor, phase, magnitude and slope score, and the shift of the candidate.

    reference, candidate: (n,); level: (4, n), the two less their means, and those backwards; work: (10, n); band: (4, m), m at
    least n / 5 + 3.
    """
    size = reference.size
    shift = _shift(level[0], level[1], level[2:], work[:8], work[8:])
    allowed = LARGEST_SHIFT * size
    phase = max(0.0, (allowed - abs(shift)) / allowed)
    i, j, rest = max(0, -shift), max(0, shift), size - abs(shift)
    magnitude = _magnitude(reference, i, candidate, j, rest, band[0], band[1], band[2], band[3])
    return _corridor(reference, candidate), phase, magnitude, _slope(reference, i, candidate, j, rest), shift


def agreement(reference: Floats, candidate: Floats) -> Scores:
    """The scores of a candidate against a reference, (n,) each, n at least 9, neither of them constant."""
    # Scores do not change with the unit of both, and here it must not matter either how large its squares are. By a power of
    # two nothing is rounded.
    unit = 2.0 ** math.frexp(max(float(np.abs(reference).max()), float(np.abs(candidate).max())))[1]
    reference, candidate = reference / unit, candidate / unit
    level = np.stack([_levelled(reference), _levelled(candidate)])
    level = np.concatenate([level, level[:, ::-1]])
    size = reference.size
    found = scores(reference, candidate, level, np.empty((10, size)), np.empty((4, size // 5 + 5)))
    corridor, phase, magnitude, slope, shift = found
    return float(corridor), float(phase), float(magnitude), float(slope), int(shift)


def _levelled(values: Floats) -> Floats:
    """The values less their mean, the largest of them near 1: their correlations are the same, and nothing underflows."""
    off = values - values.mean()
    found: Floats = off / np.abs(off).max()
    return found
