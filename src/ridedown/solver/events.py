"""The first event of a step: which guard turns negative, and when.

Each guard is a polynomial on the step, g(t) = a (d - d0) + b (d' - v0); a restraint's has more to it (see `layout`). A cheap
bound clears most: with every coefficient that pulls down taken in full, the guard still stays positive. The rest are read
closely. Most of those fall throughout the step and end below zero: they have one root, and Newton's method finds all of them
at once, side by side. What is left goes to Bernstein coefficients.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.network.model import Floats, Ints
from ridedown.solver import laws, polynomial, together
from ridedown.solver.layout import DEGREE, DRIFT, G0, GA, GD0, GV0, STRIDE, A, B, Table, at, guard_at, row
from ridedown.solver.vector import ALL_LANES, WIDTH, first_lane, lanes_of, load, spread, store, where

GAP_ROUND_OFF = 1e-14  # m
RATE_ROUND_OFF = 1e-13  # m/s
ACCELERATION_ROUND_OFF = 1e-11  # m/s2
NO_EVENT = -1
_SAME = 1e-13  # of the step: at one instant, within round-off
_IDLE_ALL = 6  # steps of no length in which every negative guard may change its mode at once; then one at a time
_ORDER = np.arange(DEGREE + 3.0)
NO, YES = 0.0, 1.0
"""Whether a step goes on to its pause, as a number of the lane."""
_FIRST, _LATEST, _SOONEST = ((DEGREE + n) * STRIDE for n in (1, 2, 3))
"""Rows below the powers of the step, all fractions of it: the earliest event found, what it cannot come after, and, one row
for each guard of the element at hand, what its own cannot come before."""
POWER_ROWS = DEGREE + 7


@kernel
def find(
    lanes: int, law: Ints, pair_element: Ints, second_pair: Ints, guard: Floats, d: Floats, crash: Ints, last: Floats,
    idle: Floats, step: Floats, power: Floats, event: Ints, pending: Ints, pending_count: Ints, falling: Floats, owner: Ints,
    poly: Floats, room: Table,
) -> None:  # fmt: skip
    """What ends each lane's step: a guard negative at the start (it has no length), or the first to turn negative in it.

    The step of a lane with an event shrinks to it, and `pending`, empty at first, names the guards whose modes change then.
    `falling` and `owner` are room for one guard a lane and more, to be solved together.
    """
    count = 0
    for block in range(0, lanes, WIDTH):
        store(power, _FIRST + block, 1.0)
        store(power, _LATEST + block, 1.0)
    for e in range(law.size):
        if law[e] == laws.LINEAR:  # no guards
            continue
        for block in range(0, lanes, WIDTH):
            if law[e] == laws.ELASTIC:
                suspects = _suspects_of_curve(block, e, guard, d, power)
            elif law[e] == laws.RESTRAINT:
                suspects = _suspects_of_restraint(block, e, second_pair[e], guard, d, power)
            else:
                suspects = _suspects(block, e, guard, d, power)
            while suspects != 0:
                bit = first_lane(suspects)
                suspects &= suspects - 1
                l, g = block + bit % WIDTH, 2 * e + bit // WIDTH
                if bit >= 2 * WIDTH:
                    g += 2 * (second_pair[e] - e - 1)
                if crash[l] < 0 or power[_SOONEST + (bit // WIDTH) * STRIDE + l] > power[_LATEST + l]:
                    continue
                if count == STRIDE:
                    _note_all(count, falling, owner, power, event)
                    count = 0
                if law[e] == laws.RESTRAINT:
                    kind = _examine_restraint(g, e, l, guard, d, power, pending, pending_count, falling, count, poly)
                else:
                    kind = _examine(g, l, guard, d, power, pending, pending_count, falling, count, poly)
                if kind == _FALLS:
                    owner[2 * count] = l
                    owner[2 * count + 1] = g
                    count += 1
                elif kind == _SEARCH:
                    root = polynomial.first_root(poly, room)
                    power[_LATEST + l] = min(power[_LATEST + l], root)
                    _note(g, l, root, power, event)
    _note_all(count, falling, owner, power, event)
    for l in range(lanes):
        if pending_count[l] > 0:  # rule 2: a step of no length
            step[l], last[l], event[l] = 0.0, NO, NO_EVENT
            idle[l] += 1.0
            if idle[l] > _IDLE_ALL:
                pending_count[l] = 1
        elif event[l] != NO_EVENT:  # rule 5
            first = power[_FIRST + l]
            if first < 1.0 or last[l] == NO:
                step[l] *= first
                last[l] = NO
                pending[l] = event[l]
                pending_count[l] = 1
            event[l] = NO_EVENT
    for x in range(count):  # others at the same instant change with it, to spare a step of no length
        l, g = owner[2 * x], owner[2 * x + 1]
        same = abs(falling[row(together.ROOT) + x] - power[_FIRST + l]) <= _SAME
        if same and step[l] > 0.0 and pending_count[l] > 0 and pair_element[pending[l] // 2] != pair_element[g // 2]:
            pending[row(pending_count[l]) + l] = g
            pending_count[l] += 1


_CLEAR, _FALLS, _SEARCH = range(3)


@inlined
def _suspects(block, e, guard, d, power):
    """In which lanes of a block the guards of element e may start or turn negative, as bits; the second guard's come after."""
    g, h = 2 * e, 2 * e + 1
    a, b = load(guard, guard_at(g, A) + block), load(guard, guard_at(g, B) + block)
    u, w = load(guard, guard_at(h, A) + block), load(guard, guard_at(h, B) + block)
    o, p = at(e, 0) + block, row(1) + block
    now, then = load(d, o), load(d, o + STRIDE)
    start = a * (now - load(guard, guard_at(g, GD0) + block)) + b * (then - load(guard, guard_at(g, GV0) + block))
    start2 = u * (now - load(guard, guard_at(h, GD0) + block)) + w * (then - load(guard, guard_at(h, GV0) + block))
    now, then = then, load(d, o + 2 * STRIDE)
    slope = (a * now + 2.0 * b * then) * load(power, p)
    slope2 = (u * now + 2.0 * w * then) * load(power, p)
    dip, dip2 = spread(0.0), spread(0.0)
    for j in range(2, DEGREE):
        now, then = then, load(d, o + (j + 1) * STRIDE)
        scale = load(power, p + (j - 1) * STRIDE)
        now *= scale
        rate = (j + 1.0) * then * scale
        dip += min(a * now + b * rate, 0.0)
        dip2 += min(u * now + w * rate, 0.0)
    first = _unclear(a, b, start, slope, dip, power, _SOONEST + block, 0.0)
    return first | (_unclear(u, w, start2, slope2, dip2, power, _SOONEST + STRIDE + block, 0.0) << WIDTH)


@inlined
def _suspects_of_curve(block, e, guard, d, power):
    """The same of an element whose guards look at its deflection only."""
    g, h = 2 * e, 2 * e + 1
    a, u = load(guard, guard_at(g, A) + block), load(guard, guard_at(h, A) + block)
    o, p = at(e, 0) + block, row(1) + block
    now, slope = load(d, o), load(d, o + STRIDE) * load(power, p)
    down, up = spread(0.0), spread(0.0)
    for j in range(2, DEGREE + 1):
        c = load(d, o + j * STRIDE) * load(power, p + (j - 1) * STRIDE)
        down += min(c, 0.0)
        up += max(c, 0.0)
    start, start2 = a * (now - load(guard, guard_at(g, GD0) + block)), u * (now - load(guard, guard_at(h, GD0) + block))
    none = spread(0.0)
    first = _unclear(a, none, start, a * slope, min(a * down, a * up), power, _SOONEST + block, 0.0)
    return first | (_unclear(u, none, start2, u * slope, min(u * down, u * up), power, _SOONEST + STRIDE + block, 0.0) << WIDTH)


@part
def _suspects_of_restraint(block, e, pair, guard, d, power):
    """The same of the four guards of a restraint: those of its second pair come last.

    How far deflection, rate and acceleration can go down and up in the step is summed once for all of them.
    """
    o, p = at(e, 0) + block, row(1) + block
    bends, rates = spread(0.0), spread(0.0)  # whether any guard looks at the acceleration, or the rate
    for n in range(4):
        g = 2 * (e if n < 2 else pair) + n % 2
        bends += abs(load(guard, guard_at(g, GA) + block))
        rates += abs(load(guard, guard_at(g, B) + block))
    down, up = _range(o, 0, p, d, power)
    down_rate, up_rate = spread(0.0), spread(0.0)
    if lanes_of(rates > 0.0) != 0:
        down_rate, up_rate = _range(o, 1, p, d, power)
    down_bend, up_bend = spread(0.0), spread(0.0)
    if lanes_of(bends > 0.0) != 0:
        down_bend, up_bend = _range(o, 2, p, d, power)
    here, rate, bend = load(d, o), load(d, o + STRIDE), 2.0 * load(d, o + 2 * STRIDE)
    bend_rate, length = 6.0 * load(d, o + 3 * STRIDE), load(power, p)
    suspects = 0
    for n in range(4):
        g = 2 * (e if n < 2 else pair) + n % 2
        a, b, ga = (
            load(guard, guard_at(g, A) + block),
            load(guard, guard_at(g, B) + block),
            load(guard, guard_at(g, GA) + block),
        )
        start = load(guard, guard_at(g, G0) + block) + a * (here - load(guard, guard_at(g, GD0) + block))
        start += b * (rate - load(guard, guard_at(g, GV0) + block)) + ga * bend
        slope = (a * (rate + load(guard, guard_at(g, DRIFT) + block)) + b * bend + ga * bend_rate) * length
        dip = min(a * down, a * up) + min(b * down_rate, b * up_rate) + min(ga * down_bend, ga * up_bend)
        more = ACCELERATION_ROUND_OFF * abs(ga)
        suspects |= _unclear(a, b, start, slope, dip, power, _SOONEST + n * STRIDE + block, more) << (n * WIDTH)
    return suspects


@inlined
def _range(o, times, p, d, power):
    """How far a deflection's derivative, of order `times`, can go down and up in the step, beyond its first two terms."""
    down, up = spread(0.0), spread(0.0)
    for j in range(2, DEGREE + 1 - times):
        c = load(d, o + (j + times) * STRIDE) * load(power, p + (j - 1) * STRIDE)
        if times == 1:
            c *= j + 1.0
        elif times == 2:
            c *= (j + 1.0) * (j + 2.0)
        down += min(c, 0.0)
        up += max(c, 0.0)
    return down, up


@part
def _examine_restraint(g, e, l, guard, d, power, pending, pending_count, falling, column, p):
    """Read one guard of a restraint closely, as `_examine` does."""
    a, b, ga = guard[guard_at(g, A) + l], guard[guard_at(g, B) + l], guard[guard_at(g, GA) + l]
    round_off = GAP_ROUND_OFF * abs(a) + RATE_ROUND_OFF * abs(b) + ACCELERATION_ROUND_OFF * abs(ga)
    o = at(e, 0) + l
    for j in range(DEGREE + 1):
        here = d[o + j * STRIDE]
        rate = (j + 1.0) * d[o + (j + 1) * STRIDE] if j < DEGREE else 0.0
        bend = (j + 1.0) * (j + 2.0) * d[o + (j + 2) * STRIDE] if j < DEGREE - 1 else 0.0
        if j == 0:
            here -= guard[guard_at(g, GD0) + l]
            rate -= guard[guard_at(g, GV0) + l]
        elif j == 1:
            here += guard[guard_at(g, DRIFT) + l]
        p[j] = (a * here + b * rate + ga * bend) * power[row(j) + l]
    p[0] += guard[guard_at(g, G0) + l]
    if p[0] < -round_off:
        return _postpone(g, l, power, pending, pending_count)
    first = 0 if p[0] > round_off else 1
    while first < DEGREE and abs(p[first]) <= round_off:
        first += 1
    if abs(p[first]) <= round_off:
        return _CLEAR
    if p[first] < 0.0:
        return _postpone(g, l, power, pending, pending_count)
    return _examine_shape(p, first, l, column, falling, power)


@inlined
def _unclear(a, b, start, slope, dip, power, soonest, more):
    round_off = GAP_ROUND_OFF * abs(a) + RATE_ROUND_OFF * abs(b) + more
    fall = min(slope, 0.0) + dip
    stays = (start > round_off) & (start + fall > 0.0)
    store(power, soonest, where(start > round_off, start / -fall, 0.0))
    leaves = (abs(start) <= round_off) & (slope > round_off) & (slope + dip > 0.0)  # zero at the start, and rising
    return lanes_of(stays | leaves) ^ ALL_LANES


@inlined
def _examine(g, l, guard, d, power, pending, pending_count, falling, column, p):
    """Read one guard closely, its polynomial on the step scaled to [0, 1].

    Answers _CLEAR, _FALLS (one root: the polynomial goes into that column of `falling`) or _SEARCH (it goes into p); it is
    divided by t as often as it starts at zero.
    """
    e = g // 2
    a, b = guard[guard_at(g, A) + l], guard[guard_at(g, B) + l]
    round_off = GAP_ROUND_OFF * abs(a) + RATE_ROUND_OFF * abs(b)
    o, to = at(e, 0) + l, row(0) + column
    c = a * (d[o] - guard[guard_at(g, GD0) + l]) + b * (d[o + STRIDE] - guard[guard_at(g, GV0) + l])
    falling[to] = c
    if c < -round_off:
        return _postpone(g, l, power, pending, pending_count)
    first = 0 if c > round_off else 1
    end, fastest = c, 0.0
    end_even, fastest_even = 0.0, 0.0  # sums of every second order, for they need not wait for each other
    for j in range(1, DEGREE, 2):
        this, that = d[o + j * STRIDE], d[o + (j + 1) * STRIDE]
        c = (a * this + _ORDER[j + 1] * b * that) * power[row(j) + l]
        rate = _ORDER[j + 2] * b * d[o + (j + 2) * STRIDE] if j + 1 < DEGREE else 0.0
        c_even = (a * that + rate) * power[row(j + 1) + l]
        falling[to + j * STRIDE] = c
        falling[to + (j + 1) * STRIDE] = c_even
        end += c
        end_even += c_even
        fastest += _ORDER[j] * max(c, 0.0) if j > 1 else c
        fastest_even += _ORDER[j + 1] * max(c_even, 0.0)
    end += end_even
    fastest += fastest_even
    if first == 0 and fastest < 0.0:
        return _falls(falling[to], end, fastest, l, column, falling, power)
    for j in range(DEGREE + 1):
        p[j] = falling[to + j * STRIDE]
    while first < DEGREE and abs(p[first]) <= round_off:
        first += 1  # within round-off of zero: the next coefficient decides, and the root at zero is divided out
    if abs(p[first]) <= round_off:
        return _CLEAR
    if p[first] < 0.0:
        return _postpone(g, l, power, pending, pending_count)
    return _examine_shape(p, first, l, column, falling, power)


@part
def _examine_shape(p, first, l, column, falling, power):
    """Whether a guard that is not simply falling from a positive start has one root, none, or must be searched.

    Divides p by t^first. One that bends down throughout has one root or none, as its end tells; so has one that bends up.
    """
    end, slope, fastest, most, least = p[first], 0.0, 0.0, 0.0, 0.0
    for j in range(DEGREE + 1):
        c = p[j + first] if j + first <= DEGREE else 0.0
        p[j] = c
        falling[row(j) + column] = c
        if j == 0:
            continue
        end += c
        slope += j * c
        fastest += j * max(c, 0.0) if j > 1 else c
        bend = j * (j - 1.0) * c
        most += max(bend, 0.0) if j > 2 else bend
        least += min(bend, 0.0) if j > 2 else bend
    if fastest < 0.0:
        return _falls(p[0], end, fastest, l, column, falling, power)
    if most <= 0.0 or least >= 0.0:
        if end < 0.0:  # Newton's method from where it goes straight to the root
            falling[row(together.ROOT) + column] = 1.0 if most <= 0.0 else 0.0
            return _FALLS
        if most <= 0.0 or p[1] >= 0.0 or slope <= 0.0:
            return _CLEAR
    return _SEARCH


@inlined
def _falls(start, end, fastest, l, column, falling, power):
    """Whether a guard that falls throughout, by no less than -`fastest`, turns negative in the step: when at the latest."""
    if end > 0.0:
        return _CLEAR
    falling[row(together.ROOT) + column] = start / (start - end)
    power[_LATEST + l] = min(power[_LATEST + l], start / -fastest)
    return _FALLS


@inlined
def _postpone(g, l, power, pending, pending_count):
    """A guard negative at the start: its mode changes before anything else happens."""
    power[_LATEST + l] = 0.0
    pending[row(pending_count[l]) + l] = g
    pending_count[l] += 1
    return _CLEAR


@inlined
def _note(g, l, root, power, event):
    """Keep the earliest root of a lane."""
    if root < power[_FIRST + l] or (root == 1.0 and event[l] == NO_EVENT):
        power[_FIRST + l] = root
        event[l] = g


@part
def _note_all(count, falling, owner, power, event):
    """Solve the guards that fall, and keep the earliest root of each lane."""
    together.solve(count, falling)
    for x in range(count):
        _note(owner[2 * x + 1], owner[2 * x], falling[row(together.ROOT) + x], power, event)
