"""What the kernels work on: the structure of a network, its numbers, and the lanes that carry many crashes abreast.

Many crashes are solved at once in *lanes*: every array of the workspace ends in an axis of LANES crashes, one loop over the
lanes is one straight line of vector instructions, and where crashes differ (another mode of a law, another step) they differ
in numbers, not in branches. A lane that finishes its crash takes the next.

Names below: q position series, d deflection series, f force series; j order of the coefficient, i coordinate, e element,
b bar, g guard (two to an element), l lane.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ridedown.network import Network
from ridedown.network.model import Floats, Ints
from ridedown.solver.polynomial import MAX_DEGREE, WORK_SHAPE

Bools = NDArray[np.bool_]

LANES = 32
DEGREE = 12
"""Degree of the position series; accelerations have degree DEGREE - 2."""


class Structure(NamedTuple):
    """The integers of a network (see `Network`), and what to keep the extremes of."""

    parent: Ints
    law: Ints
    term_start: Ints
    term_coordinate: Ints
    term_sign: Floats
    bar_coordinate: Ints  # (b,) rotation coordinate of each bar
    lever: Ints  # (e,) bar that an element has an arm on, -1 = none
    conjugate: bool
    reaction_start: Ints
    reaction_coordinate: Ints
    reaction_sign: Floats
    piece_start: Ints
    tracked_start: Ints  # (k + 1,) terms of each tracked quantity
    tracked_family: Ints  # of each term: a Family
    tracked_index: Ints
    tracked_weight: Floats
    tracked_sense: Ints  # (k,) +1 largest, -1 smallest, 0 largest magnitude


class Numbers(NamedTuple):
    """The numbers of a network, a column a crash."""

    inertia: Floats  # (i, R)
    rate: Floats  # (i, R)
    arm: Floats  # (e, R)
    coefficients: Floats  # (3, e, R) stiffness, damping, slack
    pieces: Floats  # (3, p, R) knot, force, slope
    duration: Floats  # (R,)


class Lanes(NamedTuple):
    """The state and the series of the crashes at hand; the last axis is the lane."""

    # which crash, and where it is
    row: Ints  # -1 = none
    time: Floats
    step: Floats
    power: Floats  # (j, l) powers of the step
    last: Bools  # whether this step ends the crash
    steps: Ints
    idle: Ints  # steps of no length since the crash last advanced
    # series
    q: Floats  # (j, i, l)
    tan: Floats  # (j, b, l)
    sec2: Floats  # (j, b, l)
    moment: Floats  # (j, b, l)
    d: Floats  # (j, e, l)
    f: Floats  # (j, e, l)
    pull: Floats  # (i, l)
    # the crash in each lane
    inverse_inertia: Floats  # (i, l)
    arm: Floats  # (e, l)
    scale: Floats  # (l,) the acceleration that the step control measures against
    # its laws: see laws.py
    mode: Ints  # (e, l)
    line: Floats  # (5, e, l)
    guard: Floats  # (4, g, l)
    memory: Floats  # (3, e, l)
    # events and extremes
    event: Ints  # (l,) guard that ends this step, -1 = none
    suspect: Ints  # (l,) whether what is at hand needs a closer look
    pending: Ints  # (g, l) guards found negative at the start of the step
    pending_count: Ints
    best: Floats  # (k, l)
    best_time: Floats
    work: Floats  # (e, l) work done on each element so far
    # room to work in
    sum1: Floats  # (l,)
    sum2: Floats
    sum3: Floats
    series: Floats  # (j, l)
    poly: Floats  # (MAX_DEGREE + 1,)
    room: Floats


class Tracked(NamedTuple):
    """Quantities whose extremes are wanted: quantity k is the sum of weight * term over its terms."""

    start: Ints  # (k + 1,)
    family: Ints
    index: Ints
    weight: Floats
    sense: Ints  # (k,) +1 largest, -1 smallest, 0 largest magnitude


class Results(NamedTuple):
    """What is kept of each crash; the last axis is the crash."""

    stop: Ints  # (R,) of march.Stop
    time: Floats  # (R,) reached
    steps: Ints
    position: Floats  # (i, R) at the end
    rate: Floats
    set: Floats  # (e, R)
    work: Floats  # (e, R) done on each element, if asked for
    best: Floats  # (k, R) extremes tracked
    best_time: Floats


class Record(NamedTuple):
    """The phases of one crash and its changes of mode, as `march` notes them down."""

    count: Ints  # (1,) phases
    phases: Floats  # (n, DEGREE + 2, columns) first row: time, step; then the series by order, columns q, d, f
    log: Floats  # (n + 1, 4) first row: how many; then time, element, mode before, mode after


def lanes_for(network: Network, tracked: int) -> Lanes:
    """Room for LANES crashes of a network of this structure."""
    n, m = len(network.coordinates), len(network.elements)
    bars = int(network.is_rotation.sum())
    room = {"i": n, "e": m, "b": bars, "g": 2 * m, "k": tracked, "j": DEGREE + 1, "l": LANES}

    def zeros(axes: str, dtype: type = np.float64) -> Any:
        return np.zeros(tuple(room[a] if a in room else int(a) for a in axes), dtype=dtype)

    whole = np.int64
    return Lanes(
        row=zeros("l", whole),
        time=zeros("l"),
        step=zeros("l"),
        power=zeros("jl"),
        last=zeros("l", np.bool_),
        steps=zeros("l", whole),
        idle=zeros("l", whole),
        q=zeros("jil"),
        tan=zeros("jbl"),
        sec2=zeros("jbl"),
        moment=zeros("jbl"),
        d=zeros("jel"),
        f=zeros("jel"),
        pull=zeros("il"),
        inverse_inertia=zeros("il"),
        arm=zeros("el"),
        scale=zeros("l"),
        mode=zeros("el", whole),
        line=zeros("5el"),
        guard=zeros("4gl"),
        memory=zeros("3el"),
        event=zeros("l", whole),
        suspect=zeros("l", whole),
        pending=zeros("gl", whole),
        pending_count=zeros("l", whole),
        best=zeros("kl"),
        best_time=zeros("kl"),
        work=zeros("el"),
        sum1=zeros("l"),
        sum2=zeros("l"),
        sum3=zeros("l"),
        series=zeros("jl"),
        poly=np.zeros(MAX_DEGREE + 1),
        room=np.zeros(WORK_SHAPE),
    )


def results_for(network: Network, tracked: int) -> Results:
    """Room for the results of every crash of the network's columns."""
    n, m, rows = len(network.coordinates), len(network.elements), network.size
    return Results(
        stop=np.full(rows, -1, dtype=np.int64),
        time=np.zeros(rows),
        steps=np.zeros(rows, dtype=np.int64),
        position=np.zeros((n, rows)),
        rate=np.zeros((n, rows)),
        set=np.zeros((m, rows)),
        work=np.zeros((m, rows)),
        best=np.zeros((tracked, rows)),
        best_time=np.zeros((tracked, rows)),
    )


def record_for(network: Network, capacity: int) -> Record:
    """Room for `capacity` phases of one crash, and as many events."""
    columns = max(len(network.coordinates) + 2 * len(network.elements), 2)
    return Record(
        count=np.zeros(1, dtype=np.int64),
        phases=np.empty((capacity, DEGREE + 2, columns)),
        log=np.zeros((capacity + 1, 4)),
    )


def structure_of(network: Network, tracked: Tracked) -> Structure:
    """The integers of a network, with what is to be tracked, as the kernels take them."""
    bars = np.flatnonzero(network.is_rotation)
    bar_of = np.full(len(network.coordinates) + 1, -1, dtype=np.int64)
    bar_of[bars] = np.arange(len(bars))
    return Structure(
        parent=network.parent,
        law=network.law,
        term_start=network.term_start,
        term_coordinate=network.term_coordinate,
        term_sign=network.term_sign,
        bar_coordinate=bars.astype(np.int64),
        lever=bar_of[network.lever],  # -1 reads the last entry, which is -1
        conjugate=network.conjugate,
        reaction_start=network.reaction_start,
        reaction_coordinate=network.reaction_coordinate,
        reaction_sign=network.reaction_sign,
        piece_start=network.piece_start,
        tracked_start=tracked.start,
        tracked_family=tracked.family,
        tracked_index=tracked.index,
        tracked_weight=tracked.weight,
        tracked_sense=tracked.sense,
    )


def numbers_of(network: Network) -> Numbers:
    """The numbers of a network as the kernels take them."""
    return Numbers(
        inertia=network.inertia,
        rate=network.rate,
        arm=network.arm,
        coefficients=np.stack((network.stiffness, network.damping, network.slack)),
        pieces=np.stack((network.knot, network.force, network.slope)),
        duration=network.duration,
    )
