"""Many channels of a solved crash at many times: each series is put together once a phase, and evaluated there."""

from __future__ import annotations

from collections.abc import Sequence
from math import perm

import numpy as np

from ridedown.compiled import kernel
from ridedown.network import Channel, Family
from ridedown.network.model import Floats, Ints
from ridedown.solver.layout import ORDERS, Cube, Table
from ridedown.solver.phases import Phases

_SOURCE = {
    Family.POSITION: (0, 0), Family.RATE: (0, 1), Family.ACCELERATION: (0, 2),
    Family.DEFLECTION: (1, 0), Family.DEFLECTION_RATE: (1, 1), Family.FORCE: (2, 0),
}  # fmt: skip
"""The series that a family is read from (0 position, 1 deflection, 2 force), and how often it is differentiated."""

_FALLING = np.array([[perm(order + times, times) for order in range(ORDERS)] for times in range(3)], dtype=np.float64)
"""[times, order]: what the power order + times is multiplied by when it is differentiated so often."""


def sampled(phases: Phases, channels: Sequence[Channel], times: Floats) -> Floats:
    """Channels (C) at times (T,) [s] within the crash, shape (C, T), SI; at an event, the values just after it."""
    values = np.empty((times.size, len(channels)))
    phase = np.clip(np.searchsorted(phases.start, times, side="right") - 1, 0, phases.start.size - 1)
    terms = [_terms(phases, channel) for channel in channels]
    table = np.array([term for each in terms for term in each]).reshape(-1, 4)
    whole = table[:, :3].astype(np.int64)
    _sample(
        np.ascontiguousarray(phases.position),
        np.ascontiguousarray(phases.deflection),
        np.ascontiguousarray(phases.force),
        np.cumsum([0, *map(len, terms)], dtype=np.int64),
        whole[:, 0].copy(),
        whole[:, 1].copy(),
        whole[:, 2].copy(),
        table[:, 3].copy(),
        np.array([channel.constant for channel in channels]),
        phase,
        times - phases.start[phase],
        np.empty((ORDERS, len(channels))),
        values,
    )
    return np.ascontiguousarray(values.T)


def _terms(phases: Phases, channel: Channel) -> list[tuple[int, int, int, float]]:
    """Source, index, derivative and weight of every series that a channel is the sum of."""
    found = []
    for family, index, weight in channel.terms:
        source, derivative = _SOURCE[family]
        links = phases.chains[index] if family == Family.ACCELERATION else (index,)
        found += [(source, link, derivative, weight) for link in links]
    return found


@kernel
def _sample(
    position: Cube, deflection: Cube, force: Cube, start: Ints, source: Ints, index: Ints, derivative: Ints, weight: Floats,
    constant: Floats, phase: Ints, local: Floats, series: Table, values: Table,
) -> None:  # fmt: skip
    """Into `values` (T, C): channel c is the sum of terms start[c] .. start[c + 1], at times `local` (T,) in their phases.

    `series` is room for the polynomials of all channels in one phase, (order, C): evaluated side by side, they are vectors.
    """
    last = -1
    for t in range(values.shape[0]):
        if phase[t] != last:
            last = phase[t]
            for order in range(ORDERS):
                for c in range(values.shape[1]):
                    series[order, c] = 0.0
            for c in range(values.shape[1]):
                series[0, c] = constant[c]
                for term in range(start[c], start[c + 1]):
                    own = position
                    if source[term] == 1:
                        own = deflection
                    elif source[term] == 2:
                        own = force
                    times, i = derivative[term], index[term]
                    for order in range(ORDERS - times):
                        series[order, c] += weight[term] * _FALLING[times, order] * own[last, order + times, i]
        for c in range(values.shape[1]):
            values[t, c] = series[ORDERS - 1, c]
        for order in range(ORDERS - 2, -1, -1):
            for c in range(values.shape[1]):
                values[t, c] = values[t, c] * local[t] + series[order, c]
