"""What the kernels work on: the structure of a network, its numbers, and the lanes that carry many crashes abreast.

Many crashes are solved at once in *lanes*: one loop over the lanes is one straight line of vector instructions, and where
crashes differ (another mode of a law, another step) they differ in numbers, not in branches. A lane that finishes its crash
takes the next. One crash takes one lane.

Names below: q position series, d deflection series, f force series; j order of the coefficient, i coordinate, e element,
b bar, g guard (two to a pair, one pair to an element, two to a restraint), l lane.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ridedown.network import Family, Law, Network
from ridedown.network.model import Floats, Ints
from ridedown.solver import events, together
from ridedown.solver.extremes import SAMPLED
from ridedown.solver.layout import (
    BEND_ROWS,
    COEFFICIENT_ROWS,
    DEGREE,
    EXTREME_ROWS,
    G0,
    GUARD_ROWS,
    LINE_ROWS,
    MEMORY_ROWS,
    MODE_ROWS,
    ORDERS,
    PIECE_ROWS,
    SAMPLED_ROWS,
    STRIDE,
    SUM_ROWS,
    Cube,
    Table,
)
from ridedown.solver.polynomial import WORK_SHAPE
from ridedown.solver.vector import WIDTH


class Structure(NamedTuple):
    """The integers of a network (see `Network`), and what to keep the extremes of."""

    parent: Ints
    law: Ints
    term_start: Ints
    term_coordinate: Ints
    term_sign: Floats
    bar_coordinate: Ints  # (b,) rotation coordinate of each bar
    bar_of: Ints  # (i,) bar that a coordinate is the rotation of, -1 = none
    lever: Ints  # (e,) bar that an element has an arm on, -1 = none
    conjugate: bool
    pull_start: Ints  # (i + 1,) the elements that act on each coordinate, by a sign or by their arm
    pull_element: Ints
    pull_sign: Floats
    piece_start: Ints
    pair_element: Ints  # (m + restraints,) the element of each pair of guards
    second_pair: Ints  # (e,) the second pair of a restraint, -1 = none
    free: Ints  # (e,) 1 for a restraint whose reel is free at first
    empty: Ints  # (e,) 1 for a restraint that is empty at first
    bodies: Ints  # the coordinates that are not driven, in their order
    leading: Ints  # the elements with a series of their own: all but restraints that another stands for
    leader: Ints  # (e,) the first of the restraints side by side with this one, which stands for them in the series
    beside: Ints  # (e,) the next of them, -1 = none
    direction: Floats  # (e,) sign of its deflection in that of the first
    watched: Ints  # the coordinates that restraints deflect with; a bar comes after all coordinates
    quiet: Ints  # (e,) 1 for a restraint whose deflection nobody asks for: where it gives no force, it can rest
    timer_element: Ints
    timer_action: Ints
    driven: int  # coordinate with a prescribed acceleration, -1 = none
    pulse_start: Floats
    pulse_end: Floats
    pulse_series: Table
    tracked_start: Ints  # (k + 1,) terms of each tracked quantity
    tracked_family: Ints  # of each term: a Family
    tracked_index: Ints
    tracked_weight: Floats
    tracked_sense: Ints  # (k,) +1 largest, -1 smallest, 0 largest magnitude, 2 sampled
    sample_time: Floats  # (T,) s, rising


class Numbers(NamedTuple):
    """The numbers of a network, a column a crash; of a table, one column may stand for all."""

    inertia: Table  # (i, R)
    rate: Table  # (i, R)
    arm: Table  # (e, R)
    varied: Table  # (v, R) what varies of the laws' coefficients and the pieces of their curves
    varied_row: Ints  # (v,) where that goes in the rows of `Lanes.own`
    timer_time: Table  # (t, R)
    timer_value: Table  # (t, R)
    pulse_amplitude: Floats  # (R,)
    pulse_length: Floats  # (R,)
    duration: Floats  # (R,)


class Lanes(NamedTuple):
    """The state and the series of the crashes at hand, in rows as `layout` says: one row is one number of every lane."""

    # which crash, and where it is: one row each
    crash: Ints  # its number, -1 = none
    until: Floats  # its duration; 0 where there is none
    due: Floats  # the next time at which something is: a timer, the pulse's next piece, or the end
    pause: Floats  # the next time to stop at: the same, but that a piece of the pulse may be used beyond the next one's start
    timer: Floats  # rows by timer: when it goes off, infinite once it has
    alarm: Floats  # when the next of them does
    amplitude: Floats  # what the pulse's shape is multiplied by
    per: Floats  # one over the pulse's length
    origin: Floats  # the time at which its piece at hand starts
    piece: Ints  # and the number of that
    time: Floats
    step: Floats
    last: Floats  # whether this step goes on to the pause, 1 or 0
    steps: Floats
    idle: Floats  # steps of no length since the crash last advanced
    trial: Floats  # the length of step that its modes are read on
    scale: Floats  # the acceleration that the step control measures against
    power: Floats  # rows by order: powers of the step; then what `events` says
    bend: Floats  # rows as `layout` says
    # series, rows by index and order
    q: Floats  # coordinates
    acc: Floats  # and of the ground, zero, last
    d: Floats  # elements
    f: Floats
    tan: Floats  # bars
    sec2: Floats
    turn: Floats
    moment: Floats
    # the crash's own numbers, rows by index
    inverse_inertia: Floats
    arm: Floats
    own: Floats  # both that follow: what does not vary is there from the start
    coefficients: (
        Floats  # rows by element: stiffness, damping, slack, limits, payouts, stall forces; as far as its law has them
    )
    pieces: Floats  # rows by piece: knot, force, slope
    # its laws
    mode: Ints  # rows as `layout` says
    line: Floats
    guard: Floats
    memory: Floats
    total: Floats  # the force of restraints side by side, rows as `layout` says
    rests: Ints  # what they do in a step, in the first lane of each vector (see `series.side_by_side`)
    work: Floats  # done on each element so far
    # events and extremes
    found: Ints  # rows: the guards that may end this step, found_count of them
    root: Floats  # and at what fraction of it
    found_count: Ints
    pending: Ints  # guards found negative at the start of the step, pending_count of them
    pending_count: Ints
    extreme: Floats
    sampled: Ints  # rows as `layout` says
    # room to work in
    falling: Floats  # polynomials to be solved together, a column each
    owner: Ints  # and two numbers for each: whose it is
    series: Floats
    shape: Floats  # rows as `events` says
    poly: Floats
    room: Table


class Tracked(NamedTuple):
    """Quantities whose extremes are wanted: quantity k is the sum of weight * term over its terms."""

    start: Ints  # (k + 1,)
    family: Ints
    item: Ints
    weight: Floats
    sense: Ints  # (k,) +1 largest, -1 smallest, 0 largest magnitude, 2 sampled
    sample_time: Floats  # (T,) s, rising


class Results(NamedTuple):
    """What is kept of each crash; the last axis is the crash, but of the samples the time."""

    stop: Ints  # (R,) of march.Stop
    time: Floats  # (R,) reached
    steps: Ints
    position: Table  # (i, R) at the end
    rate: Table
    set: Table  # (e, R)
    reel: Table  # (e, R) belt taken in
    payout: Table  # (e, R) belt that the load limiter let out
    work: Table  # (e, R) done on each element, if asked for
    best: Table  # (k, R) extremes tracked
    best_time: Table
    samples: Cube  # (s, R, T) of the sampled quantities; NaN where a crash stopped before


class Record(NamedTuple):
    """The phases of one crash and its changes of mode, as `march` notes them down."""

    kept: Ints  # (1,) how many phases
    phases: Cube  # (n, ORDERS + 1, columns) first row: time, step; then the series by order, columns q, d, f
    log: Table  # (n + 1, 4) first row: how many; then time, element, mode before, mode after


def lanes_for(network: Network, tracked: int) -> Lanes:
    """Room for STRIDE crashes abreast of a network of this structure."""
    n, m, bars = len(network.coordinates), len(network.elements), int(network.is_rotation.sum())
    of_pair = _element_of_pairs(network)
    pairs, coefficients = of_pair.size, m * COEFFICIENT_ROWS
    floats = {
        "until": 1,
        "due": 1,
        "pause": 1,
        "timer": network.timer_element.size,
        "alarm": 1,
        "amplitude": 1,
        "per": 1,
        "origin": 1,
        "time": 1,
        "step": 1,
        "last": 1,
        "steps": 1,
        "idle": 1,
        "trial": 1,
        "scale": 1,
        "power": events.POWER_ROWS,
        "bend": BEND_ROWS * (n + bars),
        "q": n * ORDERS,
        "acc": (n + 1) * ORDERS,
        "d": m * ORDERS,
        "f": m * ORDERS,
        "tan": bars * ORDERS,
        "sec2": bars * ORDERS,
        "turn": bars * ORDERS,
        "moment": bars * ORDERS,
        "inverse_inertia": n,
        "arm": m,
        "line": m * LINE_ROWS,
        "memory": m * MEMORY_ROWS,
        "total": m * SUM_ROWS,
        "work": m,
        "root": 2 * pairs,
        "extreme": tracked * EXTREME_ROWS,
        "falling": together.ROWS,
        "series": ORDERS,
        "shape": events.SHAPE_ROWS,
        "guard": 2 * pairs * GUARD_ROWS,
        "own": coefficients + len(network.knot) * PIECE_ROWS,
    }
    whole = {
        "crash": 1,
        "piece": 1,
        "mode": m * MODE_ROWS,
        "rests": m,
        "found": 2 * pairs,
        "found_count": 1,
        "pending": 2 * pairs,
        "pending_count": 1,
        "sampled": SAMPLED_ROWS,
        "owner": 2,
    }
    lanes, numbers = _rows_of_zeros(floats, np.float64), _rows_of_zeros(whole, np.int64)
    guard, own = lanes["guard"], lanes["own"]
    # no guard of a restraint turns negative until it is put into a mode
    restrains = (network.law == Law.RESTRAINT)[of_pair]
    guard.reshape(pairs, 2, GUARD_ROWS, STRIDE)[restrains, :, G0] = 1.0
    for rows, columns in _own(network):
        own.reshape(-1, STRIDE)[rows] = columns[:, :1]
    return Lanes(
        **lanes,
        **numbers,
        coefficients=own[: coefficients * STRIDE],
        pieces=own[coefficients * STRIDE :],
        poly=np.zeros(ORDERS),
        room=np.zeros(WORK_SHAPE),
    )


def _rows_of_zeros(rows: Mapping[str, int], kind: type) -> dict[str, Any]:
    """So many rows of zeros under each name, one after the other from the start of a cache line on."""
    room: NDArray[Any] = np.zeros(sum(rows.values()) * STRIDE + WIDTH, dtype=kind)
    end = -room.ctypes.data // room.itemsize % WIDTH
    found = {}
    for name, count in rows.items():
        start, end = end, end + count * STRIDE
        found[name] = room[start:end]
    return found


def _element_of_pairs(network: Network) -> Ints:
    """The element of each pair of guards: every element has one, and restraints another."""
    return np.concatenate((np.arange(len(network.elements)), np.flatnonzero(network.law == Law.RESTRAINT)))


def results_for(network: Network, tracked: Tracked) -> Results:
    """Room for the results of every crash of the network's columns."""
    n, m, rows, count = len(network.coordinates), len(network.elements), network.size, tracked.sense.size
    sampled = int((tracked.sense == SAMPLED).sum())
    return Results(
        stop=np.full(rows, -1, dtype=np.int64),
        time=np.zeros(rows),
        steps=np.zeros(rows, dtype=np.int64),
        position=np.zeros((n, rows)),
        rate=np.zeros((n, rows)),
        set=np.zeros((m, rows)),
        reel=np.zeros((m, rows)),
        payout=np.zeros((m, rows)),
        work=np.zeros((m, rows)),
        best=np.zeros((count, rows)),
        best_time=np.zeros((count, rows)),
        samples=np.empty((sampled, rows, tracked.sample_time.size)),
    )


def record_for(network: Network, capacity: int) -> Record:
    """Room for `capacity` phases of one crash, and as many events."""
    columns = max(len(network.coordinates) + 2 * len(network.elements), 2)
    return Record(
        kept=np.zeros(1, dtype=np.int64),
        phases=np.empty((capacity, DEGREE + 2, columns)),
        log=np.zeros((capacity + 1, 4)),
    )


def structure_of(network: Network, tracked: Tracked, *, each: bool = False) -> Structure:
    """The integers of a network, with what is to be tracked, as the kernels take them.

    `each`: whether the force of every element is wanted by itself, tracked or not.
    """
    bars = np.flatnonzero(network.is_rotation)
    bar_of = np.full(len(network.coordinates) + 1, -1, dtype=np.int64)
    bar_of[bars] = np.arange(len(bars))
    lever = bar_of[network.lever]  # -1 reads the last entry, which is -1
    levered = np.flatnonzero(network.lever >= 0)
    coordinate = np.concatenate((network.reaction_coordinate, network.lever[levered]))
    element = np.concatenate((np.repeat(np.arange(len(network.elements)), np.diff(network.reaction_start)), levered))
    sign = np.concatenate((-network.reaction_sign, np.zeros(len(levered))))
    leader, direction = _side_by_side(network, tracked, each=each)
    leads = leader[element] == element
    coordinate, element, sign = coordinate[leads], element[leads], sign[leads]
    order = np.argsort(coordinate, kind="stable")
    restraints = np.flatnonzero(network.law == Law.RESTRAINT)
    second_pair = np.full(len(network.elements), -1, dtype=np.int64)
    second_pair[restraints] = len(network.elements) + np.arange(restraints.size)
    return Structure(
        parent=network.parent,
        law=network.law,
        term_start=network.term_start,
        term_coordinate=network.term_coordinate,
        term_sign=network.term_sign,
        bar_coordinate=bars.astype(np.int64),
        bar_of=bar_of[:-1],
        lever=lever,
        conjugate=network.conjugate,
        pull_start=np.searchsorted(coordinate[order], np.arange(len(network.coordinates) + 1)),
        pull_element=element[order],
        pull_sign=sign[order],
        piece_start=network.piece_start,
        pair_element=_element_of_pairs(network),
        second_pair=second_pair,
        free=network.free.astype(np.int64),
        empty=network.empty.astype(np.int64),
        bodies=np.flatnonzero(np.arange(len(network.coordinates)) != network.driven),
        leading=np.flatnonzero(leader == np.arange(leader.size)),
        leader=leader,
        beside=_next_of(leader),
        direction=direction,
        watched=_watched(network, lever),
        quiet=_quiet(network, tracked),
        timer_element=network.timer_element,
        timer_action=network.timer_action,
        driven=network.driven,
        pulse_start=np.ascontiguousarray(network.pulse_start),
        pulse_end=np.ascontiguousarray(network.pulse_end),
        pulse_series=np.ascontiguousarray(network.pulse_series),
        tracked_start=tracked.start,
        tracked_family=tracked.family,
        tracked_index=tracked.item,
        tracked_weight=tracked.weight,
        tracked_sense=tracked.sense,
        sample_time=tracked.sample_time,
    )


def _side_by_side(network: Network, tracked: Tracked, *, each: bool) -> tuple[Ints, Floats]:
    """Of every element, the first that has the same deflection, but for its sign, and pushes the same bodies; and that sign.

    Only of restraints whose own deflection and force nobody asks for; any other is the first of none but itself.
    """
    leader, direction = np.arange(len(network.elements)), np.ones(len(network.elements))
    if each or not (network.law == Law.RESTRAINT).any():
        return leader, direction
    heard = tracked.item[np.isin(tracked.family, (Family.DEFLECTION, Family.DEFLECTION_RATE, Family.FORCE))]
    first: dict[tuple[tuple[float, ...], ...], int] = {}
    for e in np.flatnonzero((network.law == Law.RESTRAINT) & (network.lever < 0)).tolist():
        if e in heard:
            continue
        terms = slice(network.term_start[e], network.term_start[e + 1])
        reactions = slice(network.reaction_start[e], network.reaction_start[e + 1])
        direction[e] = np.sign(network.term_sign[terms][0])
        moves = (network.term_coordinate[terms], network.term_sign[terms] * direction[e])
        pushes = (network.reaction_coordinate[reactions], network.reaction_sign[reactions] * direction[e])
        leader[e] = first.setdefault(tuple(tuple(numbers.tolist()) for numbers in (*moves, *pushes)), e)
    return leader, direction * direction[leader]


def _next_of(leader: Ints) -> Ints:
    """Of every element the next with the same leader, or -1."""
    following = np.full(leader.size, -1, dtype=np.int64)
    last: dict[int, int] = {}
    for e, first in enumerate(leader.tolist()):
        if first in last:
            following[last[first]] = e
        last[first] = e
    return following


def _watched(network: Network, lever: Ints) -> Ints:
    restrains = network.law == Law.RESTRAINT
    if not restrains.any():
        return np.zeros(0, dtype=np.int64)
    coordinates = network.term_coordinate[np.repeat(restrains, np.diff(network.term_start))]
    watched = np.zeros(len(network.coordinates) + int(network.is_rotation.sum()), dtype=np.bool_)
    watched[coordinates] = watched[len(network.coordinates) + lever[restrains & (lever >= 0)]] = True
    return np.flatnonzero(watched)


def _quiet(network: Network, tracked: Tracked) -> Ints:
    quiet = (network.law == Law.RESTRAINT).astype(np.int64)
    if quiet.any():
        quiet[tracked.item[np.isin(tracked.family, (Family.DEFLECTION, Family.DEFLECTION_RATE))]] = 0
    return quiet


def numbers_of(network: Network) -> Numbers:
    """The numbers of a network as the kernels take them: what is the same in every crash stands there once."""
    size = network.size
    varied_row, varied = np.zeros(0, dtype=np.int64), np.zeros((0, size))
    if size > 1:
        varies = [(rows, columns, _varies(columns)) for rows, columns in _own(network)]
        varied_row = np.concatenate([rows[which] for rows, _, which in varies])
        varied = np.concatenate([columns[which] for _, columns, which in varies])

    def table(column: Floats) -> Floats:
        return np.require(column if column.strides[-1] else column[..., :1], requirements=("C", "W"))

    def whole(column: Floats) -> Floats:
        return np.require(column, requirements=("C", "W"))

    return Numbers(
        inertia=table(network.inertia),
        rate=table(network.rate),
        arm=table(network.arm),
        varied=varied,
        varied_row=varied_row,
        timer_time=table(network.timer_time),
        timer_value=table(network.timer_value),
        pulse_amplitude=whole(network.pulse_amplitude),
        pulse_length=whole(network.pulse_length),
        duration=whole(network.duration),
    )


def _own(network: Network) -> list[tuple[Ints, Floats]]:
    """What the laws' coefficients and the pieces of their curves are, part by part: their rows in a lane, and their columns."""
    coefficients = [network.stiffness, network.damping, network.slack]
    if (network.law == Law.RESTRAINT).any():
        coefficients += [*network.limit, *network.payout, *network.stall]
    elements, pieces = np.arange(len(network.elements)), np.arange(len(network.knot))
    first = elements.size * COEFFICIENT_ROWS
    own = [(elements * COEFFICIENT_ROWS + part, columns) for part, columns in enumerate(coefficients)]
    curve = (network.knot, network.force, network.slope)
    return own + [(first + pieces * PIECE_ROWS + part, columns) for part, columns in enumerate(curve)]


def _varies(columns: Floats) -> NDArray[np.bool_]:
    """Which rows of a table are not one number all along."""
    if columns.strides[-1] == 0:
        return np.zeros(len(columns), dtype=np.bool_)
    varies: NDArray[np.bool_] = (columns != columns[:, :1]).any(axis=1)
    return varies
