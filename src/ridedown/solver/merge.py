"""A solved motion in fewer polynomials: as few over each stretch in which nothing changes as are as good as exact.

A phase ends at an event, where the acceleration has a kink, or where its power series would grow too long. The motion knows
nothing of the latter: between events it is smooth, and the polynomial through its values at Chebyshev's nodes serves over some
three times the length that a power series of its degree does, for its error falls as (w h / 4)^n / n!, not as (w h)^n / n!.
See L. N. Trefethen, "Approximation Theory and Approximation Practice" (2013), ch. 8.

Where a stretch takes several polynomials, they overlap by half, so that a step that starts in one seldom has to end with it.
Their degree leaves room: what follows from their last terms in the motion of an occupant is still among the terms of a step.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import chebyshev

from ridedown.network.model import Floats, Ints
from ridedown.solver.layout import DEGREE
from ridedown.solver.phases import Phases

ERROR = 1e-12
"""What a polynomial may be off, of the largest value: some digits less than a phase leaves out at its end."""

_SAME_TIME = 1e-12  # s
_N = DEGREE - 4  # coefficients: three orders less than an acceleration has
_NODES = 0.5 + 0.5 * np.cos(np.pi * (np.arange(_N) + 0.5) / _N)  # on [0, 1]
_BETWEEN = 0.5 + 0.5 * np.cos(np.pi * np.arange(_N + 1) / _N)  # where a polynomial through values at the nodes is off most
_PLACES = np.concatenate((_NODES, _BETWEEN))
_OF_VALUES = np.linalg.inv(chebyshev.chebvander(2.0 * _NODES - 1.0, _N - 1)).T  # [node, k]: Chebyshev's coefficients
_THERE = chebyshev.chebvander(2.0 * _BETWEEN - 1.0, _N - 1).T  # [k, point]


def _powers_of_chebyshev() -> Floats:
    """[k, m]: what Chebyshev's polynomial k on [0, 1] has of the power m; whole numbers, exact."""
    powers = np.zeros((_N, _N))
    powers[0, 0], powers[1, :2] = 1.0, (-1.0, 2.0)
    for k in range(2, _N):  # T(k) = 2 (2 u - 1) T(k - 1) - T(k - 2)
        powers[k, 1:] = 4.0 * powers[k - 1, :-1]
        powers[k] -= 2.0 * powers[k - 1] + powers[k - 2]
    return powers


_POWERS = _powers_of_chebyshev()


def merged(phases: Phases, series: Floats, changes: Floats) -> tuple[Floats, Floats, Floats]:
    """An acceleration in few polynomials that keep it: when each starts and ends [s] (p,), and its coefficients (p, D).

    `series`: its coefficients by phase (n, DEGREE - 1). Both in ascending powers of the time since phase or polynomial start.
    `changes`: when it has a kink [s]. The last polynomial goes on for ever. A stretch without changes that would take twice as
    many polynomials as it has phases stays as it is.
    """
    largest = np.abs(series[:, 0]).max()
    first = _stretches(phases.start, changes)
    last = np.append(first[1:], phases.start.size)
    begin, until = phases.start, np.append(phases.start[1:], phases.end)
    found = [(begin[a:b], until[a:b], series[a:b]) for a, b in zip(first, last, strict=True)]
    left, cells = np.arange(first.size), 1
    while left.size:
        cuts = np.linspace(begin[first[left]], until[last[left] - 1], cells + 1, axis=1)
        low, high = (cuts[:, :-2], cuts[:, 2:]) if cells > 1 else (cuts[:, :1], cuts[:, 1:])
        fits, error = _through(phases.start, series, low, high, first[left], last[left] - 1)
        good = error <= ERROR * largest
        for n in np.flatnonzero(good):
            found[left[n]] = (low[n], high[n], np.pad(fits[n], ((0, 0), (0, series.shape[1] - _N))))
        cells = max(3, cells + 1)  # two would be one polynomial again
        left = left[~good & (2 * (last[left] - first[left]) >= cells)]
    start, end, parts = (np.concatenate(arrays) for arrays in zip(*found, strict=True))
    end[-1] = np.inf
    orders = np.flatnonzero(parts.any(axis=0)).max(initial=0) + 1
    return start, end, parts[:, :orders]


def _stretches(start: Floats, changes: Floats) -> Ints:
    """The phases at whose start something changes, and the first."""
    nearest = np.abs(start[:, np.newaxis] - changes).min(axis=1, initial=np.inf)
    nearest[0] = 0.0
    return np.flatnonzero(nearest <= _SAME_TIME)


def _through(start: Floats, series: Floats, low: Floats, high: Floats, first: Ints, last: Ints) -> tuple[Floats, Floats]:
    """Polynomials of each stretch from `low` to `high` (s, p) through the values of its phases, first to last (s,).

    Their coefficients (s, p, _N), and how far those of each stretch are off at most (s,).
    """
    low, length = low[..., np.newaxis], (high - low)[..., np.newaxis]

    def value(places: Floats) -> Floats:
        time = low + length * places
        phase = np.searchsorted(start, time, side="right") - 1
        phase = np.clip(phase, first[:, np.newaxis, np.newaxis], last[:, np.newaxis, np.newaxis])
        since = time - start[phase]
        total = series[phase, -1]
        for order in range(series.shape[1] - 2, -1, -1):
            total = total * since + series[phase, order]
        return total

    values = value(_PLACES)
    fits = values[..., :_N] @ _OF_VALUES
    error: Floats = np.abs(fits @ _THERE - values[..., _N:]).max(axis=(1, 2))
    return fits @ _POWERS / length ** np.arange(_N), error
