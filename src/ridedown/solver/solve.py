"""From arrays to kernels and back: solve one network and keep its phases, or many and keep their outcomes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ridedown.network import Channel, Network
from ridedown.network.model import Floats, Ints
from ridedown.solver import workspace
from ridedown.solver.extremes import SAMPLED
from ridedown.solver.march import Stop, march
from ridedown.solver.phases import Phases, phases_of

TOLERANCE = 4e-9
"""What the last acceleration terms of a step may come to, over the crash's own scale. The truncation left is far smaller."""

_NO_WORK = False
_CAPACITY = 256  # phases kept at first; eight times as many where that is too few
_NOTHING = workspace.Tracked(
    start=np.zeros(1, dtype=np.int64),
    family=np.zeros(0, dtype=np.int64),
    item=np.zeros(0, dtype=np.int64),
    weight=np.zeros(0),
    sense=np.zeros(0, dtype=np.int64),
    sample_time=np.zeros(0),
)


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """What is kept of many crashes; the last axis is the crash (see `workspace.Results`)."""

    stop: Ints
    time: Floats
    steps: Ints
    position: Floats
    rate: Floats
    set: Floats
    reel: Floats
    payout: Floats
    work: Floats
    best: Floats
    best_time: Floats
    samples: Floats


def tracked(
    quantities: Sequence[tuple[Channel, int]], sampled: Sequence[Channel] = (), times: Floats = _NOTHING.sample_time
) -> workspace.Tracked:
    """The quantities whose extremes are wanted, each a channel and a sense: +1 largest, -1 smallest, 0 largest magnitude.

    And the channels to be sampled at `times` (T,) [s], which rise.
    """
    quantities = [*quantities, *((channel, SAMPLED) for channel in sampled)]
    terms = [term for channel, _ in quantities for term in channel.terms]
    return workspace.Tracked(
        start=np.cumsum([0, *(len(channel.terms) for channel, _ in quantities)], dtype=np.int64),
        family=np.array([family for family, _, _ in terms], dtype=np.int64),
        item=np.array([index for _, index, _ in terms], dtype=np.int64),
        weight=np.array([weight for _, _, weight in terms], dtype=np.float64),
        sense=np.array([sense for _, sense in quantities], dtype=np.int64),
        sample_time=times,
    )


def solve_many(network: Network, quantities: workspace.Tracked = _NOTHING, *, work: bool = False) -> Solved:
    """Solve every crash of the network's columns, in lanes, on the calling thread (the interpreter is released).

    `work`: also integrate the work done on each element.
    """
    count = quantities.sense.size
    results = workspace.results_for(network, quantities)
    march(
        workspace.structure_of(network, quantities),
        workspace.numbers_of(network),
        workspace.lanes_for(network, count),
        results,
        workspace.record_for(network, 0),
        TOLERANCE,
        work,
    )
    results.best[quantities.sense < 0] *= -1.0
    return Solved(*results)


def solve_one(network: Network) -> tuple[Phases, Stop]:
    """Solve the one crash of a network, keeping its phases."""
    structure, numbers = workspace.structure_of(network, _NOTHING), workspace.numbers_of(network)
    results, lanes = workspace.results_for(network, _NOTHING), workspace.lanes_for(network, 0)
    capacity = _CAPACITY
    while True:
        record = workspace.record_for(network, capacity)
        march(structure, numbers, lanes, results, record, TOLERANCE, _NO_WORK)
        if results.stop[0] != Stop.RECORD_FULL:
            break
        capacity *= 8
    phases = phases_of(network, int(record.kept[0]), record.phases, record.log, results)
    return phases, Stop(int(results.stop[0]))
