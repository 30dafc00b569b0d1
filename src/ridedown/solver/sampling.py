"""Many channels of a solved crash at many times: each series is put together once a phase, and evaluated there."""

from __future__ import annotations

from collections.abc import Sequence

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


def sampled(phases: Phases, channels: Sequence[Channel], times: Floats) -> Floats:
    """Channels (C) at times (T,) [s] within the crash, shape (C, T), SI; at an event, the values just after it."""
    values = np.empty((len(channels), times.size))
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
        np.empty(ORDERS),
        values,
    )
    return values


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
    constant: Floats, phase: Ints, local: Floats, series: Floats, values: Table,
) -> None:  # fmt: skip
    """Into `values` (C, T): channel c is the sum of terms start[c] .. start[c + 1], at times `local` (T,) in their phases.

    `series` is room for the polynomial of one channel in one phase.
    """
    for c in range(values.shape[0]):
        last = -1
        for t in range(values.shape[1]):
            if phase[t] != last:
                last = phase[t]
                for order in range(ORDERS):
                    series[order] = 0.0
                series[0] = constant[c]
                for term in range(start[c], start[c + 1]):
                    own = position
                    if source[term] == 1:
                        own = deflection
                    elif source[term] == 2:
                        own = force
                    times = derivative[term]
                    for order in range(ORDERS - times):
                        factor = weight[term]
                        for k in range(times):
                            factor *= order + 1 + k
                        series[order] += factor * own[last, order + times, index[term]]
            value = series[ORDERS - 1]
            for order in range(ORDERS - 2, -1, -1):
                value = value * local[t] + series[order]
            values[c, t] = value
