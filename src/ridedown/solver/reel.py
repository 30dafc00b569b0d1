"""The reel of a belt, and its curve: what pulls, what gives, and where both are. Modes as in `restraint.py`."""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.network.model import Floats, Ints
from ridedown.solver.layout import (
    BARE,
    BRANCH,
    LATCH,
    NUMBER,
    PAYOUT,
    PIECE,
    RATE,
    REEL,
    SET,
    STAGE,
    STALLED,
    coefficient_at,
    memory_at,
    mode_at,
    piece_at,
)

OPEN = 0
UNLOADING, CLIPPED, SLIPPING_1, SLIPPING_2, HELD_1, HELD_2, FREE = range(1, 8)
"""Modes after those of the n pieces: n + UNLOADING, ..."""

STIFFNESS, DAMPING, SLACK, LIMIT, PAYOUTS, STALL = 0, 1, 2, 3, 5, 7
"""Rows of a restraint's coefficients; of the last three there are two each."""
KNOT, FORCE, SLOPE = range(3)
"""Rows of a piece of its curve."""


@inlined
def gives_way(e, l, piece_start, mode):
    """Whether the reel of a restraint gives way, so that only its force says where it is: it slips or is held."""
    kind = mode[mode_at(e, NUMBER) + l] - piece_start[e + 1] + piece_start[e]
    return SLIPPING_1 <= kind <= HELD_2


@kernel
def settle(
    e: int, l: int, d: float, v: float, piece_start: Ints, coefficients: Floats, pieces: Floats, memory: Floats,
    mode: Ints,
) -> None:  # fmt: skip
    """Where the reel is, of a restraint that slips or is held: its line, fixed there, gives the force that it has."""
    count = piece_start[e + 1] - piece_start[e]
    now = mode[mode_at(e, NUMBER) + l]
    branch = int(memory[memory_at(e, BRANCH) + l])
    elongation = elongation_of(e, l, v, now - count, branch, piece_start[e], count, coefficients, pieces, memory)
    before = memory[memory_at(e, REEL) + l]
    after = elongation + coefficients[coefficient_at(e, SLACK) + l] - d
    memory[memory_at(e, REEL) + l] = after
    if now <= count + SLIPPING_2:
        memory[memory_at(e, PAYOUT) + l] += before - after


@part
def elongation_of(e, l, v, kind, branch, first, count, coefficients, pieces, memory):
    """Elongation of a belt whose reel gives way: where its branch's line gives the force that it has."""
    if memory[memory_at(e, BARE) + l] > 0.0:
        return max(memory[memory_at(e, SET) + l], 0.0)
    k, e0, f0 = branch_of(e, l, branch, first, count, coefficients, pieces, memory)
    force = given_force(e, l, kind, coefficients)
    return e0 + (force - f0 - coefficients[coefficient_at(e, DAMPING) + l] * v) / k


@inlined
def given_force(e, l, kind, coefficients):
    """The force of a mode, given by its number after the pieces', in which the reel gives way."""
    return coefficients[coefficient_at(e, LIMIT + kind - SLIPPING_1 if kind < HELD_1 else STALL + kind - HELD_1) + l]


@part
def branch_of(e, l, branch, first, count, coefficients, pieces, memory):
    """Slope, elongation and force of the point that a branch's line starts from."""
    if branch == OPEN:
        return 0.0, 0.0, 0.0
    if branch <= count:
        p = first + branch - 1
        return pieces[piece_at(p, SLOPE) + l], pieces[piece_at(p, KNOT) + l], pieces[piece_at(p, FORCE) + l]
    return coefficients[coefficient_at(e, STIFFNESS) + l], memory[memory_at(e, SET) + l], 0.0


@part
def unload(e, l, piece, d, first, coefficients, pieces, memory):
    """Take down where a curve is left for its unloading line, and the set that it leads to."""
    p = first + piece - 1
    elongation = d - coefficients[coefficient_at(e, SLACK) + l] + memory[memory_at(e, REEL) + l]
    force = pieces[piece_at(p, FORCE) + l] + pieces[piece_at(p, SLOPE) + l] * (elongation - pieces[piece_at(p, KNOT) + l])
    memory[memory_at(e, LATCH) + l] = elongation
    memory[memory_at(e, SET) + l] = elongation - force / coefficients[coefficient_at(e, STIFFNESS) + l]
    memory[memory_at(e, PIECE) + l] = piece


@inlined
def pull_of(e, l, memory):
    """Rate at which the reel is pulled in."""
    rate = 0.0
    for n in range(2):
        if memory[memory_at(e, STALLED + n) + l] == 0.0:
            rate += memory[memory_at(e, RATE + n) + l]
    return rate


@inlined
def _limit(e, l, coefficients, memory):
    """The load limiter's force at its present stage."""
    stage = int(memory[memory_at(e, STAGE) + l])
    return coefficients[coefficient_at(e, LIMIT + stage) + l] if stage < 2 else np.inf


@inlined
def gives_at(e, l, coefficients, memory):
    """The lowest force at which something gives."""
    force = _limit(e, l, coefficients, memory)
    for n in range(2):
        if memory[memory_at(e, STALLED + n) + l] == 0.0 and memory[memory_at(e, RATE + n) + l] > 0.0:
            force = min(force, coefficients[coefficient_at(e, STALL + n) + l])
    return force


@inlined
def pulls_again_at(e, l, coefficients, memory):
    """The highest force at which a stalled pretensioner pulls again, or zero."""
    force = 0.0
    for n in range(2):
        if memory[memory_at(e, STALLED + n) + l] > 0.0:
            force = max(force, coefficients[coefficient_at(e, STALL + n) + l])
    return force


@part
def what_gives(e, l, coefficients, memory):
    """The mode, after the pieces', of what gives at the force `gives_at`."""
    high = gives_at(e, l, coefficients, memory)
    if high == _limit(e, l, coefficients, memory):
        return SLIPPING_1 if memory[memory_at(e, STAGE) + l] == 0.0 else SLIPPING_2
    pulls = memory[memory_at(e, STALLED) + l] == 0.0 and memory[memory_at(e, RATE) + l] > 0.0
    return HELD_1 if pulls and coefficients[coefficient_at(e, STALL) + l] == high else HELD_2


@part
def what_pulls_again(e, l, coefficients, memory):
    """The mode, after the pieces', at the force `pulls_again_at`: a pretensioner that was stalled, or no force at all."""
    low = pulls_again_at(e, l, coefficients, memory)
    if low == 0.0:
        return CLIPPED
    n = 0 if memory[memory_at(e, STALLED) + l] > 0.0 and coefficients[coefficient_at(e, STALL) + l] == low else 1
    memory[memory_at(e, STALLED + n) + l] = 0.0
    return HELD_1 + n


@part
def all_let_out(e, l, n, coefficients, memory):
    """A stage of the load limiter ends for the belt that it let out: on to the next, past one that may let out no more."""
    out = coefficients[coefficient_at(e, PAYOUTS + n) + l]
    memory[memory_at(e, PAYOUT) + l] = max(memory[memory_at(e, PAYOUT) + l], out)
    memory[memory_at(e, STAGE) + l] = 1.0 if n == 0 and coefficients[coefficient_at(e, PAYOUTS + 1) + l] > out else 2.0
