"""The first event of a step: which guard turns negative, and when.

Each guard is a polynomial on the step, g(t) = a (d - d0) + b (d' - v0); a restraint's has more to it (see `layout`). A cheap
bound clears most: with every coefficient that pulls down taken in full, the guard still stays positive. The rest are read
closely. Most of those fall throughout the step and end below zero: they have one root, and Newton's method finds all of them
at once, side by side. What is left goes to Bernstein coefficients.
"""

from __future__ import annotations

from ridedown.compiled import inlined, kernel, part
from ridedown.network.model import Floats, Ints
from ridedown.solver import laws, polynomial, series, together
from ridedown.solver.layout import (
    BENDS,
    DEGREE,
    DOWN,
    DRIFT,
    FASTER,
    G0,
    GA,
    GD0,
    GV0,
    NEEDS,
    RATES,
    SLOWER,
    STRIDE,
    UP,
    A,
    B,
    Table,
    at,
    bend_at,
    guard_at,
    guard_of,
    mode_at,
    row,
)
from ridedown.solver.vector import ALL_LANES, WIDTH, first_lane, lanes_of, load, spread, store, union, where

GAP_ROUND_OFF = 1e-14  # m
RATE_ROUND_OFF = 1e-13  # m/s
ACCELERATION_ROUND_OFF = 1e-11  # m/s2
_SAME = 1e-13  # of the step: at one instant, within round-off
_IDLE_ALL = 6  # steps of no length in which every negative guard may change its mode at once; then one at a time, in turn
NO, YES = 0.0, 1.0
"""Whether a step goes on to its pause, as a number of the lane."""
_FIRST, _LATEST, _SOONEST = ((DEGREE + n) * STRIDE for n in (1, 2, 3))
"""Rows below the powers of the step, all fractions of it: the earliest event found, what it cannot come after, and, one row
for each guard of the element at hand, what its own cannot come before."""
POWER_ROWS = DEGREE + 7


@kernel
def find(
    lanes: int, law: Ints, leader: Ints, direction: Floats, pair_element: Ints, second_pair: Ints, rests: Ints,
    coordinates: int, term_start: Ints, term_coordinate: Ints, term_sign: Floats, lever: Ints, arm: Floats, q: Floats,
    tan: Floats, bend: Floats, mode: Ints, guard: Floats, d: Floats, crash: Ints, last: Floats, idle: Floats, step: Floats,
    power: Floats, found: Ints, root: Floats, found_count: Ints, pending: Ints, pending_count: Ints, falling: Floats,
    owner: Ints, shape: Floats, poly: Floats, room: Table, timed: bool,
) -> None:  # fmt: skip
    """What ends each lane's step: a guard negative at the start (it has no length), or the first to turn negative in it.

    The step of a lane with an event shrinks to it, and `pending`, empty at first, names the guards whose modes change then:
    those that turn negative at that instant, in the order of their numbers, so that nothing depends on a lane's neighbours.
    `timed`: whether crashes are side by side in like modes, so that what bends both ways is told in all of a block at once.
    `found` and `root` are room for events and when they are, `falling` and `owner` for guards to be solved together, `shape`
    for one guard in the lanes of a block.
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
                needs, first = union(mode, mode_at(e, NEEDS) + block), leader[e]
                known = rests[row(first) + block] != series.RESTS
                if needs & RATES != 0 and not known:
                    series.deflect(block, first, term_start, term_coordinate, term_sign, lever, arm, q, tan, d)
                    known = True
                suspects = _suspects_of_restraint(
                    block, e, first, direction[e], second_pair[e], needs, coordinates, term_start, term_coordinate, term_sign,
                    lever, arm, bend, guard, d, power,
                )  # fmt: skip
                if suspects != 0 and not known:
                    series.deflect(block, first, term_start, term_coordinate, term_sign, lever, arm, q, tan, d)
            else:
                suspects = _suspects(block, e, guard, d, power)
            for n in range(4 if law[e] == laws.RESTRAINT else 2):
                bits = (suspects >> (n * WIDTH)) & ALL_LANES
                if bits == 0:
                    continue
                if count > STRIDE - WIDTH:
                    _note_all(count, falling, owner, power, found, root, found_count)
                    count = 0
                g = guard_of(e, second_pair[e], n)
                count = _examine(
                    g, leader[e], direction[e], block, bits, _SOONEST + n * STRIDE, guard, d, crash, power, found, root,
                    found_count, pending, pending_count, falling, owner, count, shape, poly, room, timed,
                )  # fmt: skip
    _note_all(count, falling, owner, power, found, root, found_count)
    for l in range(lanes):
        if pending_count[l] > 0:  # rule 2: a step of no length
            step[l], last[l] = 0.0, NO
            idle[l] += 1.0
            if idle[l] > _IDLE_ALL:
                pending[l] = pending[row(int(idle[l]) % pending_count[l]) + l]
                pending_count[l] = 1
        elif found_count[l] > 0 and (power[_FIRST + l] < 1.0 or last[l] == NO):  # rule 5
            step[l] *= power[_FIRST + l]
            last[l] = NO
            pending_count[l] = _at_once(l, power[_FIRST + l], pair_element, found, root, found_count[l], pending)
        found_count[l] = 0


@inlined
def _at_once(l, first, pair_element, found, root, count, pending):
    """The guards that turn negative at that instant, one an element, into `pending`; how many."""
    kept = 0
    for n in range(count):
        g, at_n = found[row(n) + l], root[row(n) + l]
        beaten = at_n - first > _SAME
        for m in range(count):
            other, at_m = found[row(m) + l], root[row(m) + l]
            sooner = at_m < at_n or (at_m == at_n and other < g)
            beaten |= sooner and pair_element[other // 2] == pair_element[g // 2]
        if beaten:
            continue
        place = kept
        while place > 0 and pending[row(place - 1) + l] > g:
            pending[row(place) + l] = pending[row(place - 1) + l]
            place -= 1
        pending[row(place) + l] = g
        kept += 1
    return kept


_CLEAR, _FALLS, _SEARCH = range(3)


@inlined
def _suspects(block, e, guard, d, power):
    """In which lanes of a block the guards of element e may start or turn negative, as bits; the second guard's come after."""
    suspects = _suspects_of_guard(block, e, 2 * e, _SOONEST, guard, d, power)
    if lanes_of(load(guard, guard_at(2 * e + 1, GD0) + block) > laws.NEVER) != 0:  # most modes have but one
        suspects |= _suspects_of_guard(block, e, 2 * e + 1, _SOONEST + STRIDE, guard, d, power) << WIDTH
    return suspects


@inlined
def _suspects_of_guard(block, e, g, soonest, guard, d, power):
    a, b = load(guard, guard_at(g, A) + block), load(guard, guard_at(g, B) + block)
    o, p = at(e, 0) + block, row(1) + block
    now, then = load(d, o), load(d, o + STRIDE)
    start = a * (now - load(guard, guard_at(g, GD0) + block)) + b * (then - load(guard, guard_at(g, GV0) + block))
    now, then = then, load(d, o + 2 * STRIDE)
    slope = (a * now + 2.0 * b * then) * load(power, p)
    dip = spread(0.0)
    for j in range(2, DEGREE):
        now, then = then, load(d, o + (j + 1) * STRIDE)
        dip += min((a * now + ((j + 1.0) * b) * then) * load(power, p + (j - 1) * STRIDE), 0.0)
    round_off = GAP_ROUND_OFF * abs(a) + RATE_ROUND_OFF * abs(b)
    return _unclear(round_off, start, slope, dip, power, soonest + block)


@inlined
def _suspects_of_curve(block, e, guard, d, power):
    """The same of an element whose guards look at its deflection only."""
    g, h = 2 * e, 2 * e + 1
    a, u = load(guard, guard_at(g, A) + block), load(guard, guard_at(h, A) + block)
    o, p = at(e, 0) + block, row(1) + block
    now, slope = load(d, o), load(d, o + STRIDE) * load(power, p)
    total, size = spread(0.0), spread(0.0)
    for j in range(2, DEGREE + 1):
        c = load(d, o + j * STRIDE) * load(power, p + (j - 1) * STRIDE)
        total += c
        size += abs(c)
    down, up = 0.5 * (total - size), 0.5 * (total + size)
    start, start2 = a * (now - load(guard, guard_at(g, GD0) + block)), u * (now - load(guard, guard_at(h, GD0) + block))
    least, least2 = GAP_ROUND_OFF * abs(a), GAP_ROUND_OFF * abs(u)
    first = _unclear(least, start, a * slope, min(a * down, a * up), power, _SOONEST + block)
    return first | (_unclear(least2, start2, u * slope, min(u * down, u * up), power, _SOONEST + STRIDE + block) << WIDTH)


@inlined
def _suspects_of_restraint(
    block, e, first, sign, pair, needs, coordinates, term_start, term_coordinate, term_sign, lever, arm, bend, guard, d, power
):  # fmt: skip
    """The same of those guards of a restraint that can turn negative, by how far its coordinates can bend in the step.

    Its deflection is `sign` times that of element `first`, whose orders 2 and up must be there if a guard looks at the rate.
    """
    down, up, slower, faster = _bounds(block, e, coordinates, term_start, term_coordinate, term_sign, lever, arm, bend)
    o, p = at(first, 0) + block, row(1) + block
    here, rate, length = sign * load(d, o), sign * load(d, o + STRIDE), load(power, p)
    bend_now, bend_rate, down_bend, up_bend = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
    if needs & RATES != 0:
        bend_now = 2.0 * sign * load(d, o + 2 * STRIDE)
    if needs & BENDS != 0:
        bend_rate = 6.0 * sign * load(d, o + 3 * STRIDE)
        down_bend, up_bend = _range_of_acceleration(o, p, sign, d, power)
    suspects = 0
    for n in range(4):
        if (needs >> n) & 1 == 0:
            continue
        g = guard_of(e, pair, n)
        a = load(guard, guard_at(g, A) + block)
        start = load(guard, guard_at(g, G0) + block) + a * (here - load(guard, guard_at(g, GD0) + block))
        slope = a * (rate + load(guard, guard_at(g, DRIFT) + block))
        dip = min(a * down, a * up)
        round_off = GAP_ROUND_OFF * abs(a)
        if needs & RATES != 0:
            b = load(guard, guard_at(g, B) + block)
            start += b * (rate - load(guard, guard_at(g, GV0) + block))
            slope += b * bend_now
            dip += min(b * slower, b * faster)
            round_off += RATE_ROUND_OFF * abs(b)
        if needs & BENDS != 0:
            ga = load(guard, guard_at(g, GA) + block)
            start += ga * bend_now
            slope += ga * bend_rate
            dip += min(ga * down_bend, ga * up_bend)
            round_off += ACCELERATION_ROUND_OFF * abs(ga)
        suspects |= _unclear(round_off, start, slope * length, dip, power, _SOONEST + n * STRIDE + block) << (n * WIDTH)
    return suspects


@inlined
def _bounds(block, e, coordinates, term_start, term_coordinate, term_sign, lever, arm, bend):
    """How far down and up the deflection of an element can go in the step beyond its straight course, and its rate."""
    down, up, slower, faster = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
    first, terms = term_start[e], term_start[e + 1] - term_start[e]
    for n in range(terms if lever[e] < 0 else terms + 1):
        levered = n == terms
        i = coordinates + lever[e] if levered else term_coordinate[first + n]
        weight = load(arm, row(e) + block) if levered else spread(term_sign[first + n])
        lower, upper = weight * load(bend, bend_at(i, DOWN) + block), weight * load(bend, bend_at(i, UP) + block)
        down += min(lower, upper)
        up += max(lower, upper)
        lower, upper = weight * load(bend, bend_at(i, SLOWER) + block), weight * load(bend, bend_at(i, FASTER) + block)
        slower += min(lower, upper)
        faster += max(lower, upper)
    return down, up, slower, faster


@inlined
def _range_of_acceleration(o, p, sign, d, power):
    """How far a deflection's second derivative can go down and up in the step, beyond its first two terms."""
    total, size = spread(0.0), spread(0.0)
    for j in range(2, DEGREE - 1):
        c = ((j + 1.0) * (j + 2.0) * sign) * load(d, o + (j + 2) * STRIDE) * load(power, p + (j - 1) * STRIDE)
        total += c
        size += abs(c)
    return 0.5 * (total - size), 0.5 * (total + size)


@inlined
def _unclear(round_off, start, slope, dip, power, soonest):
    """In which lanes a guard may start or turn negative, as bits: by its start, its slope, and how far it can bend down."""
    fall = min(slope, 0.0) + dip
    stays = (start > round_off) & (start + fall > 0.0)
    leaves = (abs(start) <= round_off) & (slope > round_off) & (slope + dip > 0.0)  # zero at the start, and rising
    suspects = lanes_of(stays | leaves) ^ ALL_LANES
    store(power, soonest, where(start > round_off, start / -fall, 0.0))
    return suspects


@inlined
def _examine(
    g, e, sign, block, bits, soonest, guard, d, crash, power, found, root, found_count, pending, pending_count, falling, owner,
    count, shape, poly, room, timed,
):  # fmt: skip
    """Read guard g, of `sign` times element e, closely in the lanes of a block that `bits` names: its polynomial on [0, 1].

    Where it has one root, the polynomial goes into a column of `falling`; how many of them are in use after that.
    """
    a, b = load(guard, guard_at(g, A) + block), load(guard, guard_at(g, B) + block)
    ga = load(guard, guard_at(g, GA) + block)
    _read(e, sign, g, block, a, b, ga, guard, d, power, shape)
    start, end, fastest = load(shape, row(0)), load(shape, row(_END)), load(shape, row(_FASTEST))
    least = GAP_ROUND_OFF * abs(a) + RATE_ROUND_OFF * abs(b) + ACCELERATION_ROUND_OFF * abs(ga)
    store(shape, row(_ROUND_OFF), least)
    negative, positive = lanes_of(start < -least), lanes_of(start > least)
    falls, stays = positive & lanes_of(fastest < 0.0), lanes_of(end > 0.0)
    once = 0
    if timed and bits & positive & ~falls != 0:  # what never turns negative, and what does so once
        down, up, place = together.sign_changes(DEGREE, shape)
        bits &= ~(positive & lanes_of(down == 0.0))
        once = positive & lanes_of((down == 1.0) & (up == 0.0))
        store(shape, row(_PLACE), place)
    while bits != 0:
        n = first_lane(bits)
        bits &= bits - 1
        l, lane = block + n, 1 << n
        if crash[l] < 0 or power[soonest + l] > power[_LATEST + l]:
            continue
        kind = _CLEAR
        if negative & lane != 0:
            _postpone(g, l, power, pending, pending_count)
        elif falls & lane != 0:
            if stays & lane == 0:
                kind = _FALLS
                for j in range(DEGREE + 1):
                    falling[row(j) + count] = shape[row(j) + n]
                _falls(shape[n], shape[row(_END) + n], shape[row(_FASTEST) + n], l, count, falling, power)
        elif once & lane != 0:
            kind = _FALLS
            for j in range(DEGREE + 1):
                falling[row(j) + count] = shape[row(j) + n]
            falling[row(together.ROOT) + count] = shape[row(_PLACE) + n]
        else:
            for j in range(DEGREE + 1):
                poly[j] = shape[row(j) + n]
            round_off = shape[row(_ROUND_OFF) + n]
            kind = _examine_one(g, l, positive & lane != 0, round_off, poly, pending, pending_count, count, falling, power)
        if kind == _FALLS:
            owner[2 * count] = l
            owner[2 * count + 1] = g
            count += 1
        elif kind == _SEARCH:
            first = polynomial.first_root(poly, room)
            power[_LATEST + l] = min(power[_LATEST + l], first)
            _note(g, l, first, power, found, root, found_count)
    return count


_END, _FASTEST, _ROUND_OFF, _PLACE = DEGREE + 1, DEGREE + 2, DEGREE + 3, DEGREE + 4
"""Rows of `shape` after the coefficients: the guard at the step's end, how slowly it falls at least, its round-off, and where
its root is, roughly."""
SHAPE_ROWS = DEGREE + 5


@inlined
def _read(e, sign, g, block, a, b, ga, guard, d, power, shape):
    """The coefficients of a guard in all lanes of a block, and what they come to, into the rows of `shape`."""
    rates, bends = lanes_of(abs(b) + abs(ga) > 0.0) != 0, lanes_of(abs(ga) > 0.0) != 0
    o, p = at(e, 0) + block, row(0) + block
    end = load(guard, guard_at(g, G0) + block) + a * (sign * load(d, o) - load(guard, guard_at(g, GD0) + block))
    end += b * (sign * load(d, o + STRIDE) - load(guard, guard_at(g, GV0) + block))
    drift = a * load(guard, guard_at(g, DRIFT) + block)
    a, b, ga = sign * a, sign * b, sign * ga
    end += 2.0 * ga * load(d, o + 2 * STRIDE)
    store(shape, row(0), end)
    fastest = spread(0.0)
    for j in range(1, DEGREE + 1):
        c = a * load(d, o + j * STRIDE)
        if j == 1:
            c += drift
        if rates and j < DEGREE:
            c += ((j + 1.0) * b) * load(d, o + (j + 1) * STRIDE)
        if bends and j < DEGREE - 1:
            c += ((j + 1.0) * (j + 2.0) * ga) * load(d, o + (j + 2) * STRIDE)
        c *= load(power, p + j * STRIDE)
        store(shape, row(j), c)
        end += c
        fastest += c if j == 1 else float(j) * max(c, 0.0)
    store(shape, row(_END), end)
    store(shape, row(_FASTEST), fastest)


@inlined
def _examine_one(g, l, positive, round_off, p, pending, pending_count, column, falling, power):
    """Read a guard that does not simply fall from a positive start; where it starts at zero, p is divided by t as often."""
    first = 0 if positive else 1
    while first < DEGREE and abs(p[first]) <= round_off:
        first += 1  # within round-off of zero: the next coefficient decides, and the root at zero is divided out
    if abs(p[first]) <= round_off:
        return _CLEAR
    if p[first] < 0.0:
        return _postpone(g, l, power, pending, pending_count)
    return _examine_shape(p, first, l, column, falling, power)


@inlined
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
def _note(g, l, when, power, found, root, found_count):
    """Keep what may be the earliest event of a lane, or at the same instant."""
    if when <= 1.0 and when <= power[_FIRST + l] + _SAME:
        n = found_count[l]
        found[row(n) + l], root[row(n) + l] = g, when
        found_count[l] = n + 1
        power[_FIRST + l] = min(power[_FIRST + l], when)


@part
def _note_all(count, falling, owner, power, found, root, found_count):
    """Solve the guards that fall, and keep the earliest of each lane."""
    together.solve(count, falling)
    for x in range(count):
        _note(owner[2 * x + 1], owner[2 * x], falling[row(together.ROOT) + x], power, found, root, found_count)
