"""The restraint law as modes: a belt on its reel, a bag that fills, a padded surface (see `ridedown.network.Restraint`).

    e = d - slack + w      elongation; w is what the reel has taken in, w' = r the rate at which pretensioners pull
    line of a branch       F + k (e - e_branch) + c v, v = d'; the branch is a piece of the curve, or the unloading line

    mode                   force                     guards, positive inside the mode
    0 open                 0                         touch - e          where touch = max(set, 0)
    i on piece i           line                      e - e_i, or e' where it unloads on a line; e_(i+1) - e;
                                                     f - low; high - f
    n + 1 unloading line   line                      e - touch; e_max - e; f - low; high - f
    n + 2 clipped          0                         minus the line; e - touch; and what keeps it on its branch
    n + 3, n + 4 slipping  the limiter's, stage 1, 2 f_fixed'; payout left; and what keeps e on its branch
    n + 5, n + 6 held      stall force of 1, 2       f_fixed' with this pretensioner pulling; minus f_fixed' with it stalled;
                                                     and what keeps e on its branch
    n + 7 free             0                         none; a timer locks the reel

`low` is the highest stall force of the pretensioners that pull in vain, or zero; `high` the lowest force at which something
gives: a pretensioner stalls, the limiter slips. f_fixed' = k (v + r) + c d'' is how fast the force would rise if the reel
stayed as it is: while it slips or holds at a constant force, the reel lies where the branch's line gives just that force, so
that nothing jumps when it is fixed again. A belt that is taken up so fast that its damper alone gives more than the limiter
lets through has no such place: until then it slips *bare*, with no elongation.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.network import Action
from ridedown.network.model import Floats, Ints
from ridedown.solver import layout
from ridedown.solver.layout import (
    BARE,
    BENDS,
    BRANCH,
    D0,
    DRIFT,
    F0,
    FILLING,
    G0,
    GA,
    GD0,
    GUARDED,
    GV0,
    LATCH,
    MOVES,
    NEEDS,
    NUMBER,
    PAYOUT,
    PIECE,
    PULL,
    PUSHES,
    RATE,
    RATES,
    REEL,
    SET,
    STAGE,
    STALLED,
    V0,
    A,
    B,
    C,
    K,
    coefficient_at,
    guard_at,
    guard_of,
    line_at,
    memory_at,
    mode_at,
    piece_at,
)

LOCK, PULL_1, PULL_2, STAGE_2, FILL = (int(action) for action in Action)

OPEN = 0
UNLOADING, CLIPPED, SLIPPING_1, SLIPPING_2, HELD_1, HELD_2, FREE = range(1, 8)
"""Modes after those of the n pieces: n + UNLOADING, ..."""

STIFFNESS, DAMPING, SLACK, LIMIT, PAYOUTS, STALL = 0, 1, 2, 3, 5, 7
"""Rows of a restraint's coefficients; of the last three there are two each."""
KNOT, FORCE, SLOPE = range(3)
"""Rows of a piece of its curve."""

_NEVER = 1e300
_ROUND_OFF = 1e-14  # m: of an elongation
_CLEARLY = 1e-6  # m/s: a rate that is no round-off
_JUMP = 1e-7  # what the force may be above the one that something gives at, and count as having come there by itself


@kernel
def enter(
    e: int, l: int, after: int, piece_start: Ints, coefficients: Floats, pieces: Floats, pair: int, line: Floats,
    guard: Floats, memory: Floats, mode: Ints,
) -> None:  # fmt: skip
    """Put restraint e of lane l into mode `after`: its line of force and its four guards, of pair e and of `pair`."""
    _enter(e, l, after, piece_start, coefficients, pieces, pair, line, guard, memory, mode)


@kernel
def change(
    e: int, l: int, which: int, d: float, v: float, piece_start: Ints, coefficients: Floats, pieces: Floats, pair: int,
    line: Floats, guard: Floats, memory: Floats, mode: Ints,
) -> tuple[int, int]:  # fmt: skip
    """Put restraint e of lane l into the mode on the other side of its guard `which` (0 to 3).

    That mode, and the one that it is left for at once, which is mostly the same.
    """
    before = mode[mode_at(e, NUMBER) + l]
    beyond = _next_mode(e, l, which, d, v, piece_start, coefficients, pieces, memory, mode)
    after = _left_for(e, l, before, beyond, which, d, v, piece_start, coefficients, pieces, memory)
    _enter(e, l, after, piece_start, coefficients, pieces, pair, line, guard, memory, mode)
    return beyond, after


@inlined
def _enter(e, l, after, piece_start, coefficients, pieces, pair, line, guard, memory, mode):
    first, count = piece_start[e], piece_start[e + 1] - piece_start[e]
    mode[mode_at(e, NUMBER) + l] = after
    branch = int(memory[memory_at(e, BRANCH) + l]) if after > count + UNLOADING else after
    k, e0, f0 = _branch(e, l, branch, first, count, coefficients, pieces, memory)
    c, unloads = coefficients[coefficient_at(e, DAMPING) + l], coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0
    shift = coefficients[coefficient_at(e, SLACK) + l] - memory[memory_at(e, REEL) + l]  # e = d - shift
    touch = shift + max(memory[memory_at(e, SET) + l], 0.0)
    pull = _pull(e, l, memory)
    d0 = shift + e0
    needs = 0
    if after == OPEN:
        needs = _guard(0, e, l, -1.0, 0.0, touch, 0.0, 0.0, 0.0, pull, pair, guard)
        needs |= _line(e, l, 0.0, 0.0, 0.0, 0.0, pull, line)
    elif after <= count + UNLOADING:
        goes_on = after < count
        if after > count:
            needs = _guard(0, e, l, 1.0, 0.0, touch, 0.0, 0.0, 0.0, pull, pair, guard)
            needs |= _guard(1, e, l, -1.0, 0.0, shift + memory[memory_at(e, LATCH) + l], 0.0, 0.0, 0.0, pull, pair, guard)
        else:
            if unloads:
                needs = _guard(0, e, l, 0.0, 1.0, 0.0, -pull, 0.0, 0.0, 0.0, pair, guard)
            else:
                needs = _guard(0, e, l, 1.0, 0.0, d0, 0.0, 0.0, 0.0, pull, pair, guard)
            if goes_on:
                next_piece = shift + pieces[piece_at(first + after, KNOT) + l]
                needs |= _guard(1, e, l, -1.0, 0.0, next_piece, 0.0, 0.0, 0.0, pull, pair, guard)
        low, high = _low(e, l, coefficients, memory), _high(e, l, coefficients, memory)
        if low > 0.0 or c > 0.0:
            needs |= _guard(2, e, l, k, c, d0, 0.0, f0 - low, 0.0, pull, pair, guard)
        if high < _NEVER:
            needs |= _guard(3, e, l, -k, -c, d0, 0.0, high - f0, 0.0, pull, pair, guard)
        needs |= _line(e, l, k, c, d0, f0, pull, line)
    elif after == count + CLIPPED:
        needs = _guard(0, e, l, -k, -c, d0, 0.0, -f0, 0.0, pull, pair, guard)
        needs |= _guard(1, e, l, 1.0, 0.0, touch, 0.0, 0.0, 0.0, pull, pair, guard)
        if branch <= count and unloads:
            needs |= _guard(2, e, l, 0.0, 1.0, 0.0, -pull, 0.0, 0.0, 0.0, pair, guard)
        elif 1 < branch <= count:
            needs |= _guard(2, e, l, 1.0, 0.0, d0, 0.0, 0.0, 0.0, pull, pair, guard)
        if branch < count:
            next_piece = shift + pieces[piece_at(first + branch, KNOT) + l]
            needs |= _guard(3, e, l, -1.0, 0.0, next_piece, 0.0, 0.0, 0.0, pull, pair, guard)
        needs |= _line(e, l, 0.0, 0.0, 0.0, 0.0, pull, line)
    elif after == count + FREE:
        needs = _line(e, l, 0.0, 0.0, 0.0, 0.0, 0.0, line)
    else:
        needs = _enter_given(
            e, l, after - count, first, count, k, c, e0, f0, pull, coefficients, pieces, pair, line, guard, memory
        )
    gone = mode[mode_at(e, NEEDS) + l] & ~needs & GUARDED
    for n in range(4):
        if (gone >> n) & 1 != 0:  # can turn negative no more
            _guard(n, e, l, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, pair, guard)
    mode[mode_at(e, NEEDS) + l] = needs


@part
def _enter_given(e, l, kind, first, count, k, c, e0, f0, pull, coefficients, pieces, pair, line, guard, memory):
    """A mode in which the force is given and the reel gives way, slipping or held by a pretensioner; what it needs."""
    force = _given(e, l, kind, coefficients)
    bare = memory[memory_at(e, BARE) + l] > 0.0
    needs = _line(e, l, 0.0, 0.0, 0.0, force, 0.0, line)
    if kind >= HELD_1:
        n = kind - HELD_1
        rate = memory[memory_at(e, RATE + n) + l]
        others = pull - (0.0 if memory[memory_at(e, STALLED + n) + l] > 0.0 else rate)
        needs |= _guard(0, e, l, 0.0, k, 0.0, -(others + rate), 0.0, c, 0.0, pair, guard)
        needs |= _guard(1, e, l, 0.0, -k, 0.0, -others, 0.0, -c, 0.0, pair, guard)
    else:
        most = coefficients[coefficient_at(e, PAYOUTS + kind - SLIPPING_1) + l]
        if bare:
            needs |= _guard(0, e, l, 0.0, c, 0.0, 0.0, -force, 0.0, 0.0, pair, guard)
        else:
            needs |= _guard(0, e, l, 0.0, k, 0.0, -pull, 0.0, c, 0.0, pair, guard)
        if most < _NEVER:  # payout so far and what the reel gives from here on: w less (elongation + slack - d)
            left = (
                most
                - memory[memory_at(e, PAYOUT) + l]
                - memory[memory_at(e, REEL) + l]
                + coefficients[coefficient_at(e, SLACK) + l]
            )
            left += max(memory[memory_at(e, SET) + l], 0.0) if bare else e0 + (force - f0) / k
            needs |= _guard(1, e, l, -1.0, 0.0 if bare else -c / k, 0.0, 0.0, left, 0.0, 0.0, pair, guard)
    if c > 0.0 and not bare:
        branch = int(memory[memory_at(e, BRANCH) + l])
        if (
            branch <= count and coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0
        ):  # it grows no longer: on to the unloading line
            needs |= _guard(2, e, l, 0.0, 0.0, 0.0, 0.0, 0.0, -c, 0.0, pair, guard)
        else:
            needs |= _guard(2, e, l, 0.0, -c, 0.0, 0.0, force - f0, 0.0, 0.0, pair, guard)
        if branch < count:
            above = pieces[piece_at(first + branch, FORCE) + l] - force
            needs |= _guard(3, e, l, 0.0, c, 0.0, 0.0, above, 0.0, 0.0, pair, guard)
        elif branch > count:
            top = k * (memory[memory_at(e, LATCH) + l] - memory[memory_at(e, SET) + l])
            # a line entered from its top, where the curve has just been left, is not above it by round-off
            needs |= _guard(3, e, l, 0.0, c, 0.0, 0.0, top + k * _ROUND_OFF - force, 0.0, 0.0, pair, guard)
    return needs


@inlined
def _next_mode(e, l, which, d, v, piece_start, coefficients, pieces, memory, mode):
    """The mode on the other side of guard `which` (0 to 3) of restraint e; takes down what it must remember."""
    first, count = piece_start[e], piece_start[e + 1] - piece_start[e]
    now = mode[mode_at(e, NUMBER) + l]
    if now == OPEN:
        for n in range(2):
            memory[memory_at(e, STALLED + n) + l] = 0.0
        return 1 if memory[memory_at(e, PIECE) + l] == 0.0 else count + UNLOADING
    if now <= count + UNLOADING:
        if which == 3:
            return _give(e, l, now, d, v, first, count, coefficients, pieces, memory)
        if which == 2:
            memory[memory_at(e, BRANCH) + l] = now
            return count + _what_pulls_again(e, l, coefficients, memory)
        if now > count:
            return OPEN if which == 0 else int(memory[memory_at(e, PIECE) + l])
        if which == 1:
            return now + 1
        if coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0:
            _unload(e, l, now, d, first, coefficients, pieces, memory)
            return count + UNLOADING
        return now - 1
    branch = int(memory[memory_at(e, BRANCH) + l])
    if now == count + CLIPPED:
        if which == 1:
            return OPEN
        if which == 0:
            return branch
        if which == 3:
            memory[memory_at(e, BRANCH) + l] = branch + 1
        elif coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0:
            _unload(e, l, branch, d, first, coefficients, pieces, memory)
            memory[memory_at(e, BRANCH) + l] = count + UNLOADING
        else:
            memory[memory_at(e, BRANCH) + l] = branch - 1
        return now
    if which >= 2 and _moves_along(e, l, which, d, v, now - count, branch, first, count, coefficients, pieces, memory):
        return now
    settle(e, l, d, v, piece_start, coefficients, pieces, memory, mode)
    bare = memory[memory_at(e, BARE) + l] > 0.0
    memory[memory_at(e, BARE) + l] = 0.0
    if now >= count + HELD_1:
        memory[memory_at(e, STALLED + now - count - HELD_1) + l] = 0.0 if which == 0 else 1.0
    elif which == 1:
        _all_let_out(e, l, now - count - SLIPPING_1, coefficients, memory)
    elif bare:
        return now
    return branch


@inlined
def _left_for(e, l, before, beyond, which, d, v, piece_start, coefficients, pieces, memory):
    """The mode that the one beyond a guard is left for at once, where the rate alone says so: there is no damper. Or itself.

    A pretensioner is held for no time where the belt is pulled out of it: it stalls. A reel that gives way no more has a belt
    whose elongation has just stopped growing: it unloads.
    """
    if coefficients[coefficient_at(e, DAMPING) + l] > 0.0:
        return beyond
    first, count = piece_start[e], piece_start[e + 1] - piece_start[e]
    if count + HELD_1 <= beyond <= count + HELD_2:
        n = beyond - count - HELD_1
        if v + _pull(e, l, memory) - memory[memory_at(e, RATE + n) + l] > _CLEARLY:
            branch = int(memory[memory_at(e, BRANCH) + l])
            k, e0, f0 = _branch(e, l, branch, first, count, coefficients, pieces, memory)
            elongation = e0 + (coefficients[coefficient_at(e, STALL + n) + l] - f0) / k
            memory[memory_at(e, REEL) + l] = elongation + coefficients[coefficient_at(e, SLACK) + l] - d
            memory[memory_at(e, STALLED + n) + l] = 1.0
            return branch
    elif before > count + CLIPPED and which == 0 and beyond <= count and coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0:
        _unload(e, l, beyond, d, first, coefficients, pieces, memory)
        return count + UNLOADING
    return beyond


@part
def _moves_along(e, l, which, d, v, kind, branch, first, count, coefficients, pieces, memory):
    """A belt whose reel gives way goes on to another branch of its curve; or answers that there is none further down."""
    after = branch + 1
    if which == 3 and branch > count:
        after = int(memory[memory_at(e, PIECE) + l])
    elif which == 2:
        after = branch - 1
        if branch <= count and coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0:
            elongation = _elongation(e, l, v, kind, branch, first, count, coefficients, pieces, memory)
            reel = memory[memory_at(e, REEL) + l]
            memory[memory_at(e, REEL) + l] = elongation + coefficients[coefficient_at(e, SLACK) + l] - d
            _unload(e, l, branch, d, first, coefficients, pieces, memory)
            memory[memory_at(e, REEL) + l] = reel
            after = count + UNLOADING
        elif after == OPEN or branch > count:
            if kind < HELD_1:
                memory[memory_at(e, BARE) + l] = 1.0
                return True
            return False
    memory[memory_at(e, BRANCH) + l] = after
    return True


@part
def _give(e, l, now, d, v, first, count, coefficients, pieces, memory):
    """The force of a branch has gone above what something gives at: a pretensioner is held or stalls, the limiter slips."""
    memory[memory_at(e, BRANCH) + l] = now
    kind = _what_gives(e, l, coefficients, memory)
    given = _given(e, l, kind, coefficients)
    k, e0, f0 = _branch(e, l, now, first, count, coefficients, pieces, memory)
    elongation = d - coefficients[coefficient_at(e, SLACK) + l] + memory[memory_at(e, REEL) + l]
    damper = coefficients[coefficient_at(e, DAMPING) + l] * v
    jumped = f0 + k * (elongation - e0) + damper > given * (1.0 + _JUMP)
    if kind >= HELD_1 and jumped:  # it lets nothing out
        memory[memory_at(e, STALLED + kind - HELD_1) + l] = 1.0
        return now
    if jumped:  # the limiter lets out at once what brings the force down
        branch = now
        if now <= count and coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0:
            _unload(e, l, now, d, first, coefficients, pieces, memory)
            branch = count + UNLOADING
        while 1 < branch <= count and given - damper < pieces[piece_at(first + branch - 1, FORCE) + l]:
            branch -= 1
        memory[memory_at(e, BRANCH) + l] = branch
        memory[memory_at(e, BARE) + l] = 1.0 if damper > given else 0.0
        length = elongation - _elongation(e, l, v, kind, branch, first, count, coefficients, pieces, memory)
        left = max(coefficients[coefficient_at(e, PAYOUTS + kind - SLIPPING_1) + l] - memory[memory_at(e, PAYOUT) + l], 0.0)
        if length > left:  # or what is left of its stage, and stops
            memory[memory_at(e, REEL) + l] -= left
            memory[memory_at(e, BARE) + l] = 0.0
            _all_let_out(e, l, kind - SLIPPING_1, coefficients, memory)
            if branch <= count:
                branch = now
                while branch > 1 and elongation - left < pieces[piece_at(first + branch - 1, KNOT) + l]:
                    branch -= 1
            return branch
    return count + kind


@part
def _all_let_out(e, l, n, coefficients, memory):
    """A stage of the load limiter ends for the belt that it let out: on to the next, past one that may let out no more."""
    out = coefficients[coefficient_at(e, PAYOUTS + n) + l]
    memory[memory_at(e, PAYOUT) + l] = max(memory[memory_at(e, PAYOUT) + l], out)
    memory[memory_at(e, STAGE) + l] = 1.0 if n == 0 and coefficients[coefficient_at(e, PAYOUTS + 1) + l] > out else 2.0


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
    elongation = _elongation(e, l, v, now - count, branch, piece_start[e], count, coefficients, pieces, memory)
    before = memory[memory_at(e, REEL) + l]
    after = elongation + coefficients[coefficient_at(e, SLACK) + l] - d
    memory[memory_at(e, REEL) + l] = after
    if now <= count + SLIPPING_2:
        memory[memory_at(e, PAYOUT) + l] += before - after


@part
def _elongation(e, l, v, kind, branch, first, count, coefficients, pieces, memory):
    """Elongation of a belt whose reel gives way: where its branch's line gives the force that it has."""
    if memory[memory_at(e, BARE) + l] > 0.0:
        return max(memory[memory_at(e, SET) + l], 0.0)
    k, e0, f0 = _branch(e, l, branch, first, count, coefficients, pieces, memory)
    force = _given(e, l, kind, coefficients)
    return e0 + (force - f0 - coefficients[coefficient_at(e, DAMPING) + l] * v) / k


@inlined
def _given(e, l, kind, coefficients):
    """The force of a mode, given by its number after the pieces', in which the reel gives way."""
    return coefficients[coefficient_at(e, LIMIT + kind - SLIPPING_1 if kind < HELD_1 else STALL + kind - HELD_1) + l]


@kernel
def fire(
    e: int, l: int, action: int, value: float, late: float, d: float, v: float, piece_start: Ints,
    coefficients: Floats, pieces: Floats, pair: int, line: Floats, guard: Floats, memory: Floats, mode: Ints,
) -> None:  # fmt: skip
    """A timer of restraint e goes off, so late [s] if it waited (see `waits`): do what its action says."""
    count = piece_start[e + 1] - piece_start[e]
    now = mode[mode_at(e, NUMBER) + l]
    if action == FILL:
        line[line_at(e, layout.FILL) + l] += late * (value - line[line_at(e, FILLING) + l])
        line[line_at(e, FILLING) + l] = value
        needs = mode_at(e, NEEDS) + l
        mode[needs] = (mode[needs] & ~(MOVES | PUSHES)) | _needs_of_line(e, l, line)
        return
    if action == LOCK:
        if now != count + FREE:
            return
        memory[memory_at(e, REEL) + l] = min(coefficients[coefficient_at(e, SLACK) + l] - d, 0.0)
        now = OPEN
    n = action - PULL_1
    if action in (PULL_1, PULL_2) and value == 0.0 and memory[memory_at(e, STALLED + n) + l] > 0.0:
        memory[memory_at(e, RATE + n) + l] = memory[memory_at(e, STALLED + n) + l] = 0.0
        if gives_way(e, l, piece_start, mode):  # at a force of its own
            return
    force = line[line_at(e, F0) + l] + line[line_at(e, K) + l] * (d - line[line_at(e, D0) + l]) + line[line_at(e, C) + l] * v
    if gives_way(e, l, piece_start, mode):
        settle(e, l, d, v, piece_start, coefficients, pieces, memory, mode)
        memory[memory_at(e, BARE) + l] = 0.0
        now = int(memory[memory_at(e, BRANCH) + l])
    if action == STAGE_2:
        memory[memory_at(e, STAGE) + l] = max(memory[memory_at(e, STAGE) + l], 1.0)
    elif action in (PULL_1, PULL_2):
        memory[memory_at(e, RATE + n) + l] = value
        stalled = value > 0.0 and force >= coefficients[coefficient_at(e, STALL + n) + l]
        memory[memory_at(e, STALLED + n) + l] = 1.0 if stalled else 0.0
    enter(e, l, now, piece_start, coefficients, pieces, pair, line, guard, memory, mode)


@inlined
def waits(e, l, action, value, memory, mode):
    """Whether a timer of restraint e can go off late: it changes nothing before a guard of the restraint turns negative.

    How full a bag is that touches nothing, the stage of a limiter whose belt is slack, and the end of a pretensioner that pulls
    in vain.
    """
    slack = mode[mode_at(e, NUMBER) + l] == OPEN
    if action in (FILL, STAGE_2):
        return slack
    if action == LOCK or value > 0.0 or slack:
        return False
    return memory[memory_at(e, STALLED + action - PULL_1) + l] > 0.0


@part
def _branch(e, l, branch, first, count, coefficients, pieces, memory):
    """Slope, elongation and force of the point that a branch's line starts from."""
    if branch == OPEN:
        return 0.0, 0.0, 0.0
    if branch <= count:
        p = first + branch - 1
        return pieces[piece_at(p, SLOPE) + l], pieces[piece_at(p, KNOT) + l], pieces[piece_at(p, FORCE) + l]
    return coefficients[coefficient_at(e, STIFFNESS) + l], memory[memory_at(e, SET) + l], 0.0


@part
def _unload(e, l, piece, d, first, coefficients, pieces, memory):
    """Take down where a curve is left for its unloading line, and the set that it leads to."""
    p = first + piece - 1
    elongation = d - coefficients[coefficient_at(e, SLACK) + l] + memory[memory_at(e, REEL) + l]
    force = pieces[piece_at(p, FORCE) + l] + pieces[piece_at(p, SLOPE) + l] * (elongation - pieces[piece_at(p, KNOT) + l])
    memory[memory_at(e, LATCH) + l] = elongation
    memory[memory_at(e, SET) + l] = elongation - force / coefficients[coefficient_at(e, STIFFNESS) + l]
    memory[memory_at(e, PIECE) + l] = piece


@inlined
def _pull(e, l, memory):
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
def _high(e, l, coefficients, memory):
    """The lowest force at which something gives."""
    force = _limit(e, l, coefficients, memory)
    for n in range(2):
        if memory[memory_at(e, STALLED + n) + l] == 0.0 and memory[memory_at(e, RATE + n) + l] > 0.0:
            force = min(force, coefficients[coefficient_at(e, STALL + n) + l])
    return force


@inlined
def _low(e, l, coefficients, memory):
    """The highest force at which a stalled pretensioner pulls again, or zero."""
    force = 0.0
    for n in range(2):
        if memory[memory_at(e, STALLED + n) + l] > 0.0:
            force = max(force, coefficients[coefficient_at(e, STALL + n) + l])
    return force


@part
def _what_gives(e, l, coefficients, memory):
    """The mode, after the pieces', of what gives at the force `_high`."""
    high = _high(e, l, coefficients, memory)
    if high == _limit(e, l, coefficients, memory):
        return SLIPPING_1 if memory[memory_at(e, STAGE) + l] == 0.0 else SLIPPING_2
    pulls = memory[memory_at(e, STALLED) + l] == 0.0 and memory[memory_at(e, RATE) + l] > 0.0
    return HELD_1 if pulls and coefficients[coefficient_at(e, STALL) + l] == high else HELD_2


@part
def _what_pulls_again(e, l, coefficients, memory):
    """The mode, after the pieces', at the force `_low`: a pretensioner that was stalled, or no force at all."""
    low = _low(e, l, coefficients, memory)
    if low == 0.0:
        return CLIPPED
    n = 0 if memory[memory_at(e, STALLED) + l] > 0.0 and coefficients[coefficient_at(e, STALL) + l] == low else 1
    memory[memory_at(e, STALLED + n) + l] = 0.0
    return HELD_1 + n


@inlined
def _line(e, l, k, c, d0, f0, pull, line):
    """Put down a mode's line of force; what it needs."""
    line[line_at(e, K) + l] = k
    line[line_at(e, C) + l] = c
    line[line_at(e, D0) + l] = d0
    line[line_at(e, V0) + l] = 0.0
    line[line_at(e, F0) + l] = f0
    line[line_at(e, PULL) + l] = pull
    return _needs_of_line(e, l, line)


@inlined
def _needs_of_line(e, l, line):
    """Whether a line of force gives any force, and moves with time."""
    filling = line[line_at(e, FILLING) + l]
    most = abs(line[line_at(e, K) + l]) + abs(line[line_at(e, C) + l]) + abs(line[line_at(e, F0) + l])
    most *= abs(line[line_at(e, layout.FILL) + l]) + abs(filling)
    moves = filling != 0.0 or line[line_at(e, PULL) + l] != 0.0
    # one that is not a number does not rest: it stops its crash
    return (MOVES if moves else 0) | (0 if most <= 0.0 else PUSHES)


@part
def _guard(n, e, l, a, b, d0, v0, g0, ga, drift, pair, guard):
    """Put down guard n; what it needs, if it can turn negative."""
    g = guard_of(e, pair, n)
    guard[guard_at(g, A) + l] = a
    guard[guard_at(g, B) + l] = b
    guard[guard_at(g, GD0) + l] = d0
    guard[guard_at(g, GV0) + l] = v0
    guard[guard_at(g, G0) + l] = g0
    guard[guard_at(g, GA) + l] = ga
    guard[guard_at(g, DRIFT) + l] = drift
    return (1 << n) | (0 if b == 0.0 and ga == 0.0 else RATES) | (0 if ga == 0.0 else BENDS)
