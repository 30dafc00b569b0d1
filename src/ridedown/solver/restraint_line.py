"""What a mode of a restraint is, put down in its lane: its line of force and its guards, as `restraint.py` lists them."""

from __future__ import annotations

from ridedown.compiled import inlined, kernel, part
from ridedown.network.model import Floats, Ints
from ridedown.solver import layout, reel
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
    PULL,
    PUSHES,
    RATE,
    RATES,
    REEL,
    SET,
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
from ridedown.solver.reel import (
    CLIPPED,
    DAMPING,
    FORCE,
    FREE,
    HELD_1,
    KNOT,
    OPEN,
    PAYOUTS,
    SLACK,
    SLIPPING_1,
    STIFFNESS,
    UNLOADING,
)

_NEVER = 1e300
_ROUND_OFF = 1e-14  # m: of an elongation


@kernel
def enter(
    e: int, l: int, after: int, piece_start: Ints, coefficients: Floats, pieces: Floats, pair: int, line: Floats,
    guard: Floats, memory: Floats, mode: Ints,
) -> None:  # fmt: skip
    """Put restraint e of lane l into mode `after`: its line of force and its four guards, of pair e and of `pair`."""
    put_down(e, l, after, piece_start, coefficients, pieces, pair, line, guard, memory, mode)


@inlined
def put_down(e, l, after, piece_start, coefficients, pieces, pair, line, guard, memory, mode):
    """The same within the kernel that calls it."""
    first, count = piece_start[e], piece_start[e + 1] - piece_start[e]
    mode[mode_at(e, NUMBER) + l] = after
    branch = int(memory[memory_at(e, BRANCH) + l]) if after > count + UNLOADING else after
    k, e0, f0 = reel.branch_of(e, l, branch, first, count, coefficients, pieces, memory)
    c, unloads = coefficients[coefficient_at(e, DAMPING) + l], coefficients[coefficient_at(e, STIFFNESS) + l] > 0.0
    shift = coefficients[coefficient_at(e, SLACK) + l] - memory[memory_at(e, REEL) + l]  # e = d - shift
    touch = shift + max(memory[memory_at(e, SET) + l], 0.0)
    pull = reel.pull_of(e, l, memory)
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
        low, high = reel.pulls_again_at(e, l, coefficients, memory), reel.gives_at(e, l, coefficients, memory)
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
    force = reel.given_force(e, l, kind, coefficients)
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
def _line(e, l, k, c, d0, f0, pull, line):
    """Put down a mode's line of force; what it needs."""
    line[line_at(e, K) + l] = k
    line[line_at(e, C) + l] = c
    line[line_at(e, D0) + l] = d0
    line[line_at(e, V0) + l] = 0.0
    line[line_at(e, F0) + l] = f0
    line[line_at(e, PULL) + l] = pull
    return needs_of_line(e, l, line)


@inlined
def needs_of_line(e, l, line):
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
