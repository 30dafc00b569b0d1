"""The scores of ISO/TS 18571 twice more: by loops over whole matrices, and by the package that its makers keep."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TIE = 1e-12


def by_loops(reference: Floats, candidate: Floats) -> tuple[float, float, float, float]:
    """Corridor, phase, magnitude and slope, each as its definition reads."""
    shift = first_best_shift(reference, candidate)
    n = reference.size
    ours, theirs = shifted(reference, candidate, shift)
    return corridor(reference, candidate), max(0.0, 1.0 - abs(shift) / (0.2 * n)), magnitude(ours, theirs), slope(ours, theirs)


def corridor(reference: Floats, candidate: Floats) -> float:
    largest = max(abs(value) for value in reference.tolist())
    points = []
    for one, other in zip(reference.tolist(), candidate.tolist(), strict=True):
        off = abs(one - other) / largest
        points.append(1.0 if off <= 0.05 else 0.0 if off >= 0.5 else ((0.5 - off) / 0.45) ** 2)
    return math.fsum(points) / len(points)


def correlations(reference: Floats, candidate: Floats) -> list[tuple[float, int]]:
    """Correlation and shift, from no shift on, late before early; -inf where a piece is flat."""
    found = []
    for k in range(int(0.2 * reference.size) + 1):
        for shift in (k, -k) if k else (0,):
            ours, theirs = shifted(reference, candidate, shift)
            if np.ptp(ours) == 0.0 or np.ptp(theirs) == 0.0:
                found.append((-math.inf, shift))
                continue
            ours, theirs = ours - ours.mean(), theirs - theirs.mean()
            found.append((float(ours @ theirs / math.sqrt(float(ours @ ours) * float(theirs @ theirs))), shift))
    return found


def first_best_shift(reference: Floats, candidate: Floats) -> int:
    found = correlations(reference, candidate)
    best = max(found)[0]
    return next(shift for value, shift in found if value >= best - TIE)


def told_apart(reference: Floats, candidate: Floats) -> bool:
    """Whether one shift is better than all others by more than rounding, so that everyone has to find the same."""
    found = sorted(correlations(reference, candidate))
    return found[-1][0] - found[-2][0] > 10.0 * TIE


def shifted(reference: Floats, candidate: Floats, shift: int) -> tuple[Floats, Floats]:
    """What overlaps where the candidate, late by `shift` samples, is moved to the front."""
    n = reference.size
    return (reference[: n - shift], candidate[shift:]) if shift >= 0 else (reference[-shift:], candidate[: n + shift])


def warped(reference: Floats, candidate: Floats) -> list[tuple[int, int]]:
    """The warping path, as pairs of samples of candidate and reference: the whole matrix of costs, then back from its end."""
    n = reference.size
    band = math.ceil(0.1 * n) - 1
    cost = [[math.inf] * n for _ in range(n)]
    for i in range(n):
        for j in range(max(0, i - band), min(n, i + band + 1)):
            before = min((cost[a][b] for a, b in _before(i, j)), default=0.0)
            cost[i][j] = before + float(candidate[i] - reference[j]) ** 2
    path = [(n - 1, n - 1)]
    while path[-1] != (0, 0):
        path.append(min(_before(*path[-1]), key=lambda pair: cost[pair[0]][pair[1]]))
    return path


def _before(i: int, j: int) -> list[tuple[int, int]]:
    return [pair for pair in ((i - 1, j), (i, j - 1), (i - 1, j - 1)) if min(pair) >= 0]


def magnitude(reference: Floats, candidate: Floats) -> float:
    path = warped(reference, candidate)
    difference = math.fsum(abs(float(candidate[i] - reference[j])) for i, j in path)
    return max(0.0, 1.0 - difference / math.fsum(abs(float(reference[j])) for _, j in path) / 0.5)


def slope(reference: Floats, candidate: Floats) -> float:
    ours, theirs = smoothed_slopes(reference), smoothed_slopes(candidate)
    return max(0.0, 1.0 - float(np.abs(ours - theirs).sum() / np.abs(ours).sum()) / 2.0)


def smoothed_slopes(values: Floats) -> Floats:
    slopes = np.gradient(values)
    n = values.size
    return np.array([slopes[k - half : k + half + 1].mean() for k in range(n) for half in (min(k, n - 1 - k, 4),)])


def by_package(reference: Floats, candidate: Floats) -> tuple[float, float, float, float]:
    """Corridor, phase, magnitude and slope by objective-rating-metrics (VSI, Graz University of Technology)."""
    from objective_rating_metrics.rating import ISO18571  # noqa: PLC0415  imports and compiles for seconds

    time = np.arange(reference.size) * 1e-4
    with np.errstate(invalid="ignore", divide="ignore"):  # a flat piece has the correlation 0/0, which is never its best
        rated = ISO18571(np.column_stack((time, reference)), np.column_stack((time, candidate)))
        return rated.corridor_rating(-1), rated.phase_rating(-1), rated.magnitude_rating(-1), rated.slope_rating(-1)
