"""Which parameters the measurements cannot tell apart, and which further measurement would.

A parameter is unsure where its 95 % band takes more than a quarter of its box. It is confounded where it would be sure if
others were known: its variance is more than ten times what it is with the others held (the variance inflation factor). Which
others, the eigenvectors of the scaled Fisher matrix say that leave the residuals nearly as they are.

References: D. Belsley, E. Kuh, R. Welsch, Regression Diagnostics, Wiley 1980, ch. 3 (scaling, small eigenvalues, inflation
factors).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ridedown.studies.calibration.fitted import Confounded, Help
from ridedown.studies.calibration.uncertainty import Uncertainty
from ridedown.studies.calibration.unknowns import Unknown, points_of, values_of
from ridedown.studies.calibration.wording import in_case, in_words

Floats = NDArray[np.float64]

UNSURE = 0.125
"""Half-width of a 95 % band, in parts of the box, above which a parameter is unsure: the band is then a quarter of it."""
INFLATED = 10.0
"""Variance inflation factor above which it is other parameters that make it so."""
_TAKES_PART, _TIED = 0.3, 0.5  # of the first one's step, and correlation with it: parameters with less are not named
_HELPS = 0.5  # a measurement that helps makes a half-width so much smaller, at least
_MOST_HELPS = 3
_SHOWN_STEP = 0.1
_AS_BEFORE = 0.8  # of the prior's deviation


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A channel that could be measured: its derivatives (rows, n), over the standard deviation of a sample."""

    case: str
    channel: str
    slope: Floats


def confounded(
    unknowns: Sequence[Unknown],
    point: Floats,
    fisher: Floats,
    found: Uncertainty,
    candidates: Sequence[Candidate],
    *,
    several: bool = False,
) -> tuple[Confounded, ...]:
    """What cannot be told at this point of the unit cube, the least sure first, and the measurements that would help.

    fisher: (n, n), of the measurements at hand, scaled as the candidates are. several: whether there is more than one test, so
    that a channel has to be said with its case.
    """
    half = found.reach * found.deviation
    inflation = _inflation(found.covariance)
    told: list[Confounded] = []
    done: set[int] = set()
    for i in np.argsort(-half, kind="stable"):
        if half[i] <= UNSURE or i in done:
            continue
        if _rests_on_prior(unknowns[i], found.deviation[i]):
            sentence = f"{unknowns[i].name} rests on its prior: what is measured hardly tells it."
            told.append(Confounded((unknowns[i].name,), (1.0,), sentence))
            continue
        direction = _direction(found.covariance, int(i))
        tied = np.abs(found.correlation[i]) > _TIED
        taking_part = tied & (np.abs(direction) > _TAKES_PART * abs(direction[i])) & (inflation[i] >= INFLATED)
        partners = [int(j) for j in np.argsort(-np.abs(direction)) if taking_part[j] and j != i]
        done |= {int(i), *partners}
        members = (int(i), *partners)
        helps = _helps(int(i), fisher, found, candidates)
        told.append(
            Confounded(
                tuple(unknowns[j].name for j in members),
                tuple(float(direction[j]) for j in members),
                _sentence(unknowns, point, members, direction, half, found.correlation, helps, several=several),
                helps,
            )
        )
    return tuple(told)


def _rests_on_prior(unknown: Unknown, deviation: float) -> bool:
    """Whether a parameter is hardly surer than it was before any measurement."""
    if unknown.prior is None:
        return False
    middle, sigma = unknown.prior
    low = max(middle - sigma, 1e-9 * middle) if unknown.by_ratio else middle - sigma
    ends = points_of([unknown], np.array([[low], [middle + sigma]]))
    return bool(deviation > _AS_BEFORE * 0.5 * float(ends[1, 0] - ends[0, 0]))


def _inflation(covariance: Floats) -> Floats:
    """Variance of each parameter over what it is with the others held."""
    d = np.sqrt(np.diag(covariance))
    correlation = covariance / d[:, None] / d
    values, axes = np.linalg.eigh(correlation)
    inverse = (axes**2) @ (1.0 / np.maximum(values, 1e-12))
    found: Floats = inverse
    return found


def _direction(covariance: Floats, i: int) -> Floats:
    """How the others move with parameter i, (n,), where it moves by its own standard deviation: those that make up for it."""
    column: Floats = covariance[:, i] / np.sqrt(covariance[i, i])
    return column


def _helps(i: int, fisher: Floats, found: Uncertainty, candidates: Sequence[Candidate]) -> tuple[Help, ...]:
    """The channels that narrow the band of a parameter most."""
    without = _half(i, fisher, found)
    tried = [Help(c.case, c.channel, without, _half(i, fisher + c.slope.T @ c.slope, found)) for c in candidates]
    useful = [one for one in tried if one.with_it < _HELPS * without]
    return tuple(sorted(useful, key=lambda one: (round(one.with_it, 4), one.case, one.channel))[:_MOST_HELPS])


def _half(i: int, fisher: Floats, found: Uncertainty) -> float:
    """Half-width of a band with so much information, the box itself counted as some."""
    n = len(fisher)
    covariance = np.linalg.inv(fisher + 12.0 * np.eye(n))
    return float(min(found.reach * np.sqrt(covariance[i, i]), 0.5))


def _sentence(
    unknowns: Sequence[Unknown],
    point: Floats,
    members: tuple[int, ...],
    direction: Floats,
    half: Floats,
    correlation: Floats,
    helps: Sequence[Help],
    *,
    several: bool,
) -> str:
    first, *others = members
    name = unknowns[first].name
    whole = _taken(float(point[first]), float(half[first]))
    if not others:
        said = f"{name} is hardly told by what is measured: its 95 % band takes {whole}."
    else:
        names = " and ".join(unknowns[j].name for j in others)
        moved = _moved(unknowns, point, members, direction)
        pairs = ", ".join(f"{correlation[first, j]:+.2f}".replace("-", "\u2212") for j in others)
        said = (
            f"{name} cannot be told apart from {names} (correlation {pairs}): its 95 % band takes {whole}. "
            f"What is measured stays nearly the same with {moved}."
        )
    if helps:
        listed = ", ".join(
            f"{in_case(h.channel, h.case, several=several)} to {100.0 * min(1.0, 2.0 * h.with_it):.0f} %" for h in helps
        )
        return f"{said} Measuring one of these as well would narrow the band: {listed}."
    return f"{said} No channel of these crashes would tell much more: fix it, or add a test of another kind."


def _taken(at: float, half: float) -> str:
    """How much of its bounds a band takes, in words: what is left of it within them, as it is shown.

    >>> _taken(0.5, 0.2), _taken(0.9, 0.5), _taken(0.5, 0.6)
    ('40 % of its bounds', '60 % of its bounds, where they cut it', 'the whole of its bounds')
    """
    low, high = max(at - half, 0.0), min(at + half, 1.0)
    if high - low >= 1.0:
        return "the whole of its bounds"
    cut = low == 0.0 or high == 1.0
    return f"{100.0 * (high - low):.0f} % of its bounds{', where they cut it' if cut else ''}"


def _moved(unknowns: Sequence[Unknown], point: Floats, members: tuple[int, ...], direction: Floats) -> str:
    """A step along the direction, in words: a tenth of the box for the first, or as far as all stay within their bounds."""
    step = np.zeros_like(point)
    step[list(members)] = direction[list(members)] * _SHOWN_STEP / direction[members[0]]
    ahead, back = _room(point, step), _room(point, -step)
    step *= min(1.0, ahead) if ahead >= back else -min(1.0, back)
    before, after = values_of(unknowns, point), values_of(unknowns, point + step)
    return ", ".join(
        f"{unknowns[j].name} {in_words(before[j], unknowns[j].unit)} → {in_words(after[j], unknowns[j].unit)}" for j in members
    )


def _room(point: Floats, step: Floats) -> float:
    """How many such steps there are to the nearest bound."""
    moving = step != 0.0
    return float(np.min(np.where(step > 0.0, 1.0 - point, point)[moving] / np.abs(step[moving])))
