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

from ridedown.compiled import inlined, kernel, part
from ridedown.network import Action
from ridedown.network.model import Floats, Ints
from ridedown.solver import layout, reel, restraint_line
from ridedown.solver.layout import (
    BARE,
    BRANCH,
    D0,
    F0,
    FILLING,
    MOVES,
    NEEDS,
    NUMBER,
    PAYOUT,
    PIECE,
    PUSHES,
    RATE,
    REEL,
    STAGE,
    STALLED,
    C,
    K,
    coefficient_at,
    line_at,
    memory_at,
    mode_at,
    piece_at,
)
from ridedown.solver.reel import (
    CLIPPED,
    DAMPING,
    FORCE,
    FREE,
    HELD_1,
    HELD_2,
    KNOT,
    OPEN,
    PAYOUTS,
    SLACK,
    SLIPPING_1,
    STALL,
    STIFFNESS,
    UNLOADING,
)

LOCK, PULL_1, PULL_2, STAGE_2, FILL = (int(action) for action in Action)

_CLEARLY = 1e-6  # m/s: a rate that is no round-off
_JUMP = 1e-7  # what the force may be above the one that something gives at, and count as having come there by itself


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
    restraint_line.put_down(e, l, after, piece_start, coefficients, pieces, pair, line, guard, memory, mode)
    return beyond, after


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
            return count + reel.what_pulls_again(e, l, coefficients, memory)
        if now > count:
            return OPEN if which == 0 else int(memory[memory_at(e, PIECE) + l])
        if which == 1:
            return now + 1
        if coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0:
            reel.unload(e, l, now, d, first, coefficients, pieces, memory)
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
            reel.unload(e, l, branch, d, first, coefficients, pieces, memory)
            memory[memory_at(e, BRANCH) + l] = count + UNLOADING
        else:
            memory[memory_at(e, BRANCH) + l] = branch - 1
        return now
    if which >= 2 and _moves_along(e, l, which, d, v, now - count, branch, first, count, coefficients, pieces, memory):
        return now
    reel.settle(e, l, d, v, piece_start, coefficients, pieces, memory, mode)
    bare = memory[memory_at(e, BARE) + l] > 0.0
    memory[memory_at(e, BARE) + l] = 0.0
    if now >= count + HELD_1:
        memory[memory_at(e, STALLED + now - count - HELD_1) + l] = 0.0 if which == 0 else 1.0
    elif which == 1:
        reel.all_let_out(e, l, now - count - SLIPPING_1, coefficients, memory)
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
        if v + reel.pull_of(e, l, memory) - memory[memory_at(e, RATE + n) + l] > _CLEARLY:
            branch = int(memory[memory_at(e, BRANCH) + l])
            k, e0, f0 = reel.branch_of(e, l, branch, first, count, coefficients, pieces, memory)
            elongation = e0 + (coefficients[coefficient_at(e, STALL + n) + l] - f0) / k
            memory[memory_at(e, REEL) + l] = elongation + coefficients[coefficient_at(e, SLACK) + l] - d
            memory[memory_at(e, STALLED + n) + l] = 1.0
            return branch
    elif before > count + CLIPPED and which == 0 and beyond <= count and coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0:
        reel.unload(e, l, beyond, d, first, coefficients, pieces, memory)
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
            elongation = reel.elongation_of(e, l, v, kind, branch, first, count, coefficients, pieces, memory)
            before = memory[memory_at(e, REEL) + l]
            memory[memory_at(e, REEL) + l] = elongation + coefficients[coefficient_at(e, SLACK) + l] - d
            reel.unload(e, l, branch, d, first, coefficients, pieces, memory)
            memory[memory_at(e, REEL) + l] = before
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
    kind = reel.what_gives(e, l, coefficients, memory)
    given = reel.given_force(e, l, kind, coefficients)
    k, e0, f0 = reel.branch_of(e, l, now, first, count, coefficients, pieces, memory)
    elongation = d - coefficients[coefficient_at(e, SLACK) + l] + memory[memory_at(e, REEL) + l]
    damper = coefficients[coefficient_at(e, DAMPING) + l] * v
    jumped = f0 + k * (elongation - e0) + damper > given * (1.0 + _JUMP)
    if kind >= HELD_1 and jumped:  # it lets nothing out
        memory[memory_at(e, STALLED + kind - HELD_1) + l] = 1.0
        return now
    if jumped:  # the limiter lets out at once what brings the force down
        branch = now
        if now <= count and coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0:
            reel.unload(e, l, now, d, first, coefficients, pieces, memory)
            branch = count + UNLOADING
        while 1 < branch <= count and given - damper < pieces[piece_at(first + branch - 1, FORCE) + l]:
            branch -= 1
        memory[memory_at(e, BRANCH) + l] = branch
        memory[memory_at(e, BARE) + l] = 1.0 if damper > given else 0.0
        length = elongation - reel.elongation_of(e, l, v, kind, branch, first, count, coefficients, pieces, memory)
        left = max(coefficients[coefficient_at(e, PAYOUTS + kind - SLIPPING_1) + l] - memory[memory_at(e, PAYOUT) + l], 0.0)
        if length > left:  # or what is left of its stage, and stops
            memory[memory_at(e, REEL) + l] -= left
            memory[memory_at(e, BARE) + l] = 0.0
            reel.all_let_out(e, l, kind - SLIPPING_1, coefficients, memory)
            if branch <= count:
                branch = now
                while branch > 1 and elongation - left < pieces[piece_at(first + branch - 1, KNOT) + l]:
                    branch -= 1
            return branch
    return count + kind


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
        mode[needs] = (mode[needs] & ~(MOVES | PUSHES)) | restraint_line.needs_of_line(e, l, line)
        return
    if action == LOCK:
        if now != count + FREE:
            return
        memory[memory_at(e, REEL) + l] = min(coefficients[coefficient_at(e, SLACK) + l] - d, 0.0)
        now = OPEN
    n = action - PULL_1
    if action in (PULL_1, PULL_2) and value == 0.0 and memory[memory_at(e, STALLED + n) + l] > 0.0:
        memory[memory_at(e, RATE + n) + l] = memory[memory_at(e, STALLED + n) + l] = 0.0
        if reel.gives_way(e, l, piece_start, mode):  # at a force of its own
            return
    force = line[line_at(e, F0) + l] + line[line_at(e, K) + l] * (d - line[line_at(e, D0) + l]) + line[line_at(e, C) + l] * v
    if reel.gives_way(e, l, piece_start, mode):
        reel.settle(e, l, d, v, piece_start, coefficients, pieces, memory, mode)
        memory[memory_at(e, BARE) + l] = 0.0
        now = int(memory[memory_at(e, BRANCH) + l])
    if action == STAGE_2:
        memory[memory_at(e, STAGE) + l] = max(memory[memory_at(e, STAGE) + l], 1.0)
    elif action in (PULL_1, PULL_2):
        memory[memory_at(e, RATE + n) + l] = value
        stalled = value > 0.0 and force >= coefficients[coefficient_at(e, STALL + n) + l]
        memory[memory_at(e, STALLED + n) + l] = 1.0 if stalled else 0.0
    restraint_line.enter(e, l, now, piece_start, coefficients, pieces, pair, line, guard, memory, mode)


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
