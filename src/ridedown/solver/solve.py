"""From arrays to kernels and back: solve one network and keep its phases, or many and keep their outcomes."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields

import numpy as np

from ridedown.network import Channel, Network
from ridedown.network.model import Floats, Ints
from ridedown.solver import workspace
from ridedown.solver.apart import Apart, Part, alike_of, apart, occupants_of, tracked_of
from ridedown.solver.extremes import SAMPLED
from ridedown.solver.layout import STRIDE
from ridedown.solver.march import Stop, march
from ridedown.solver.phases import Phases, phases_of

TOLERANCE = 4e-9
"""What the last acceleration terms of a step may come to, over the crash's own scale. The truncation left is far smaller."""

_WORTH_IT = 32  # crashes, from which on to solve vehicles apart from their occupants
_WORTH_A_THREAD = 4 * STRIDE  # crashes for each
_CAPACITY = 256  # phases kept at first; eight times as many where that is too few
_NOTHING = workspace.Tracked(
    start=np.zeros(1, dtype=np.int64),
    family=np.zeros(0, dtype=np.int64),
    item=np.zeros(0, dtype=np.int64),
    weight=np.zeros(0),
    sense=np.zeros(0, dtype=np.int64),
    sample_time=np.zeros(0),
)


Columns = Floats | list[Floats]
"""A table, or its rows one by one: where crashes are solved in parts, one number may stand for all of a row."""


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """What is kept of many crashes (see `workspace.Results`): columns, or tables of them; of samples, tables (R, T)."""

    stop: Ints
    time: Floats
    steps: Ints
    position: Columns
    rate: Columns
    set: Columns
    reel: Columns
    payout: Columns
    work: Columns
    best: Columns
    best_time: Columns
    samples: Columns


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


def solve_many(network: Network, quantities: workspace.Tracked = _NOTHING, *, work: bool = False, threads: int = 1) -> Solved:
    """Solve every crash of the network's columns, in lanes, on up to so many threads (the interpreter is released).

    What moves the same in every row, whatever others do, is solved once (see `apart`). `work`: also integrate
    the work done on each element.
    """
    parts = apart(network, quantities) if network.size >= _WORTH_IT else None
    solved = None if parts is None else _solve_apart(network, parts, quantities, work=work, threads=threads)
    return solved or _solve_whole(network, quantities, work=work, threads=threads)


def _solve_whole(network: Network, quantities: workspace.Tracked, *, work: bool, threads: int) -> Solved:
    """Every thread carries crashes of its own, and takes the next from the same columns: none waits while there are any.

    The calling thread only waits, so that it can be interrupted: no more crashes are taken then.
    """
    structure, numbers = workspace.structure_of(network, quantities, each=work), workspace.numbers_of(network)
    results, record = workspace.results_for(network, quantities), workspace.record_for(network, 0)
    queue = np.zeros(1, dtype=np.int64)
    places = min(STRIDE, network.size)

    def run(_thread: int = 0) -> None:
        lanes = workspace.lanes_for(network, quantities.sense.size)
        march(structure, numbers, lanes, queue, places, results, record, TOLERANCE, work)

    count = min(threads, network.size // _WORTH_A_THREAD)
    if count == 0:
        run()
    else:
        with ThreadPoolExecutor(count) as pool:
            try:
                list(pool.map(run, range(count)))
            except BaseException:
                queue[0] = network.size
                raise
    return _solved(results, quantities)


def _solved(results: workspace.Results, quantities: workspace.Tracked) -> Solved:
    results.best[quantities.sense < 0] *= -1.0  # kept as their negatives
    return Solved(*results)


def _solve_apart(network: Network, parts: Apart, quantities: workspace.Tracked, *, work: bool, threads: int) -> Solved | None:
    """What is alike in all rows once, then the occupants that differ; None where that cannot be solved to the end."""
    phases, alike = _solve_one(alike_of(network, parts), tracked_of(network, quantities, parts.alike), work=work)
    if alike.stop[0] != Stop.COMPLETED:
        return None
    solved = _unsolved(network, quantities)
    for part in parts.occupants:
        occupants, their = occupants_of(network, parts, part, phases), tracked_of(network, quantities, part)
        _put(solved, part, _solve_whole(occupants, their, work=work, threads=threads), quantities.sense)
    # over the vehicle's state as its occupants followed it, which differs from row to row by round-off
    _put(solved, parts.alike, alike, quantities.sense)
    unfinished = np.flatnonzero(solved.stop != Stop.COMPLETED)
    if unfinished.size:  # these are wanted as far as they came, vehicles and all
        whole = _solve_whole(network.rows(unfinished), quantities, work=work, threads=threads)
        _replace(solved, unfinished, whole)
    return solved


def _unsolved(network: Network, quantities: workspace.Tracked) -> Solved:
    """Every crash completed, and nothing known yet of what moves in them."""
    coordinates, elements, count = len(network.coordinates), len(network.elements), quantities.sense.size
    sampled = int((quantities.sense == SAMPLED).sum())
    return Solved(
        np.full(network.size, int(Stop.COMPLETED)),
        network.duration.copy(),
        np.zeros(network.size, dtype=np.int64),
        *([np.zeros(0)] * rows for rows in (*[coordinates] * 2, *[elements] * 4, *[count] * 2, sampled)),
    )


def _put(solved: Solved, part: Part, own: Solved, sense: Ints) -> None:
    """Put what was solved of a part in its place: its own columns, or one number for all crashes."""
    is_sample = sense == SAMPLED
    number = np.cumsum(is_sample) - 1  # of each sampled quantity among them
    places = dict.fromkeys(("position", "rate"), part.coordinates)
    places |= dict.fromkeys(("set", "reel", "payout", "work"), part.elements)
    places |= dict.fromkeys(("best", "best_time"), part.quantities)
    places["samples"] = number[part.quantities][is_sample[part.quantities]]
    for_all = own.stop.size != solved.stop.size
    for name, numbers in places.items():
        for place, column in zip(numbers.tolist(), getattr(own, name), strict=True):
            spread = np.broadcast_to(column, (solved.stop.size, *column.shape[1:])) if for_all else column
            getattr(solved, name)[place] = spread
    np.copyto(solved.stop, own.stop, where=own.stop != Stop.COMPLETED)
    solved.steps[:] += own.steps


def _replace(solved: Solved, rows: Ints, others: Solved) -> None:
    """Put other solutions in the place of those rows."""
    for field in fields(Solved):
        mine, theirs = getattr(solved, field.name), getattr(others, field.name)
        if isinstance(mine, list):
            for n, column in enumerate(theirs):
                mine[n] = mine[n].copy()
                mine[n][rows] = column
        else:
            mine[rows] = theirs


def solve_one(network: Network) -> tuple[Phases, Stop]:
    """Solve the one crash of a network, keeping its phases."""
    phases, solved = _solve_one(network, _NOTHING, work=False)
    return phases, Stop(int(solved.stop[0]))


def _solve_one(network: Network, quantities: workspace.Tracked, *, work: bool) -> tuple[Phases, Solved]:
    structure, numbers = workspace.structure_of(network, quantities, each=True), workspace.numbers_of(network)
    results, lanes = workspace.results_for(network, quantities), workspace.lanes_for(network, quantities.sense.size)
    capacity = _CAPACITY
    while True:
        record = workspace.record_for(network, capacity)
        march(structure, numbers, lanes, np.zeros(1, dtype=np.int64), 1, results, record, TOLERANCE, work)
        if results.stop[0] != Stop.RECORD_FULL:
            break
        capacity *= 8
    phases = phases_of(network, int(record.kept[0]), record.phases, record.log, results)
    return phases, _solved(results, quantities)
