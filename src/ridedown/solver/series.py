"""The power series of a step: every coordinate, deflection and force, term by term, in all lanes at once.

With the coefficients of the positions up to order j + 1 known, those of the forces of order j follow from the laws, and from
them the positions' of order j + 2: `q[j+2] = acceleration[j] / ((j + 1)(j + 2))`. The tangent of a bar's rotation has its own
recurrence, `T' = (1 + T^2) theta'`.

Series in rows as `layout.at` says: q and acc of the coordinates (acc absolute; that of the ground, zero, comes last), d and f
of the elements, tan, sec2, turn (theta') and moment of the bars.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.network.model import Floats, Ints
from ridedown.solver.laws import ELASTIC, PLASTIC, RESTRAINT
from ridedown.solver.layout import (
    AT_0,
    AT_1,
    AT_2,
    D0,
    DAMPER,
    DAMPER_RISE,
    DEGREE,
    F0,
    FILL,
    FILLING,
    MOVES,
    NEEDS,
    PULL,
    PUSHES,
    SPRING,
    SPRING_RISE,
    STRIDE,
    V0,
    C,
    K,
    at,
    line_at,
    mode_at,
    row,
    sum_at,
)
from ridedown.solver.vector import WIDTH, lanes_of, load, pick, spread, store, union

_TANGENT = np.array(
    [1, 1 / 3, 2 / 15, 17 / 315, 62 / 2835, 1382 / 155925, 21844 / 6081075, 929569 / 638512875, 6404582 / 10854718875]
)
"""Coefficients of tan x = x + x^3 / 3 + ...: Abramowitz and Stegun (1964), 4.3.67."""


_ORDERS = np.arange(DEGREE)
"""The orders, in turn. Read from here, as elements and bodies are from their lists: of an index that it counts up itself, the
compiler makes thirty, one for each row in use, and keeps them in memory."""


@part
def start(lanes, bar_coordinate, term_start, term_coordinate, term_sign, lever, arm, q, tan, sec2, turn, d):
    """Tangents and deflections of orders 0 and 1, at the state in q."""
    for b in range(bar_coordinate.size):
        theta, rate = at(bar_coordinate[b], 0), at(bar_coordinate[b], 1)
        t0, t1 = at(b, 0), at(b, 1)
        for l in range(0, lanes, WIDTH):
            t, v = _tangent(load(q, theta + l)), load(q, rate + l)
            store(tan, t0 + l, t)
            store(sec2, t0 + l, 1.0 + t * t)
            store(turn, t0 + l, v)
            store(tan, t1 + l, (1.0 + t * t) * v)
    for e in range(lever.size):
        first = term_start[e]
        alone = term_start[e + 1] == first + 1 and lever[e] < 0
        for j in range(2):
            to, q1, sign1 = at(e, j), at(term_coordinate[first], j), term_sign[first]
            for l in range(0, lanes, WIDTH):
                if alone:
                    store(d, to + l, sign1 * load(q, q1 + l))
                else:
                    store(d, to + l, _deflection(e, j, l, term_start, term_coordinate, term_sign, lever, arm, q, tan))


@inlined
def _tangent(angle):
    """The tangent of angles up to 80 degrees, to a few units in the last place.

    From an eighth of the angle, where the series' terms fall a hundredfold each, by tan 2x = 2 tan x / (1 - tan^2 x) thrice.
    """
    x = angle * 0.125
    square = x * x
    t = spread(_TANGENT[_TANGENT.size - 1])
    for n in range(_TANGENT.size - 2, -1, -1):
        t = t * square + _TANGENT[n]
    t *= x
    for _ in range(3):
        t = 2.0 * t / (1.0 - t * t)
    return t


@part
def _deflection(e, j, l, term_start, term_coordinate, term_sign, lever, arm, q, tan):
    """d[j] of element e: the sum of its signed coordinates, and arm * tan."""
    total = spread(0.0)
    for n in range(term_start[e], term_start[e + 1]):
        total += term_sign[n] * load(q, at(term_coordinate[n], j) + l)
    if lever[e] >= 0:
        total += load(arm, row(e) + l) * load(tan, at(lever[e], j) + l)
    return total


EXPANDS, RESTS, FILLS, DIFFERS = range(4)
"""What the first of restraints side by side does in a step, in a vector: its force has a series; or it is zero and passed over,
as the deflections of orders 2 and up are, unless `deflect` is called; or it has a series, and a bag fills. What it does in all
vectors stands in the first one's second lane: one of these, or that they differ."""
ALL = 1
"""That lane."""


@kernel
def side_by_side(
    lanes: int, law: Ints, leader: Ints, beside: Ints, direction: Floats, quiet: Ints, recorded: bool, mode: Ints,
    line: Floats, d: Floats, f: Floats, total: Floats, rests: Ints,
) -> None:  # fmt: skip
    """Sum up, for restraints side by side, the force of all of them; the first stands for them in the series."""
    for e in range(law.size):
        if law[e] != RESTRAINT or leader[e] != e:
            continue
        alike = DIFFERS
        for l in range(0, lanes, WIDTH):
            pushes, one = 0, e
            while one >= 0:
                pushes |= union(mode, mode_at(one, NEEDS) + l) & PUSHES
                one = beside[one]
            if pushes != 0 or quiet[e] == 0 or recorded:
                rests[row(e) + l] = _sum_up(e, l, beside, direction, mode, line, d, total)
            elif rests[row(e) + l] != RESTS:
                rests[row(e) + l] = RESTS
                for j in range(DEGREE):
                    store(f, at(e, j) + l, 0.0)
            alike = rests[row(e)] if l == 0 or rests[row(e) + l] == alike else DIFFERS
        rests[row(e) + ALL] = alike


@part
def _sum_up(e, l, beside, direction, mode, line, d, total):
    """The force of the restraints beside e, along its deflection, in a vector; whether one of them fills."""
    spring, damper, spring_rise, damper_rise = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
    at_0, at_1, at_2 = spread(0.0), spread(0.0), spread(0.0)
    here, rate = load(d, at(e, 0) + l), load(d, at(e, 1) + l)
    one, fills = e, False
    while one >= 0:
        needs, sign = union(mode, mode_at(one, NEEDS) + l), direction[one]
        if needs & PUSHES != 0:
            fill = load(line, line_at(one, FILL) + l)
            own_spring, own_damper = load(line, line_at(one, K) + l), load(line, line_at(one, C) + l)
            force = load(line, line_at(one, F0) + l) + own_spring * (sign * here - load(line, line_at(one, D0) + l))
            force += own_damper * (sign * rate)
            at_0 += sign * (fill * force)
            spring += fill * own_spring
            damper += fill * own_damper
            if needs & MOVES != 0:
                filling = load(line, line_at(one, FILLING) + l)
                pulled = sign * own_spring * load(line, line_at(one, PULL) + l)
                at_1 += fill * pulled + filling * (sign * force)
                at_2 += filling * pulled
                spring_rise += filling * own_spring
                damper_rise += filling * own_damper
                fills |= lanes_of(abs(filling) > 0.0) != 0
        one = beside[one]
    store(total, sum_at(e, SPRING) + l, spring)
    store(total, sum_at(e, DAMPER) + l, damper)
    store(total, sum_at(e, AT_0) + l, at_0)
    store(total, sum_at(e, AT_1) + l, at_1)
    if not fills:
        return EXPANDS
    store(total, sum_at(e, SPRING_RISE) + l, spring_rise)
    store(total, sum_at(e, DAMPER_RISE) + l, damper_rise)
    store(total, sum_at(e, AT_2) + l, at_2)
    return FILLS


@part
def deflect(block, e, term_start, term_coordinate, term_sign, lever, arm, q, tan, d):
    """The deflections that were passed over where an element rests."""
    for j in range(2, DEGREE + 1):
        store(d, at(e, j) + block, _deflection(e, j, block, term_start, term_coordinate, term_sign, lever, arm, q, tan))


@kernel
def expand(
    lanes: int, conjugate: bool, law: Ints, leading: Ints, rests: Ints, parent: Ints, bodies: Ints, driven: int,
    term_start: Ints, term_coordinate: Ints, term_sign: Floats, lever: Ints, pull_start: Ints, pull_element: Ints,
    pull_sign: Floats, bar_coordinate: Ints, bar_of: Ints, arm: Floats, inverse_inertia: Floats, line: Floats,
    total: Floats, q: Floats, tan: Floats, sec2: Floats, turn: Floats, moment: Floats, d: Floats, f: Floats, acc: Floats,
) -> None:  # fmt: skip
    """The series of the step, order by order, from the state at its start and the modes there."""
    for n in range(DEGREE):
        j = _ORDERS[n]
        if j > 0:
            _tangents(lanes, j, bar_coordinate, q, tan, sec2, turn)
        _forces(lanes, j, law, leading, rests, term_start, term_coordinate, term_sign, lever, arm, line, total, q, tan, d, f)
        if j < DEGREE - 1:
            _accelerations(
                lanes, j, conjugate, parent, bodies, driven, pull_start, pull_element, pull_sign, arm, inverse_inertia, bar_of,
                sec2, moment, f, acc, q,
            )  # fmt: skip


@inlined
def _tangents(lanes, j, bar_coordinate, q, tan, sec2, turn):
    """sec2[j], then tan[j + 1], by T' = (1 + T^2) theta'."""
    for b in range(bar_coordinate.size):
        rate, first, last = at(bar_coordinate[b], j + 1), at(b, 0), at(b, j)
        middle = at(b, j // 2)
        for l in range(0, lanes, WIDTH):
            store(turn, last + l, (j + 1.0) * load(q, rate + l))
            square = spread(0.0)
            up, down = first + l, last + l
            while up < down:  # the square's sum is symmetric
                square += load(tan, up) * load(tan, down)
                up += STRIDE
                down -= STRIDE
            square *= 2.0
            if j % 2 == 0:
                square += load(tan, middle + l) * load(tan, middle + l)
            store(sec2, last + l, square)
            total = square * load(turn, first + l)
            up, down = first + l, last + l
            for _ in range(j):
                total += load(sec2, up) * load(turn, down)
                up += STRIDE
                down -= STRIDE
            store(tan, last + STRIDE + l, total * (1.0 / (j + 1)))


@part
def drive(lanes, driven, shape, amplitude, per, piece, origin, time, acc):
    """The series of the driven body's acceleration at each lane's time: its piece of the pulse, shifted to there."""
    orders = shape.shape[1]
    for l in range(0, lanes, WIDTH):
        since = load(time, l) - load(origin, l)
        factor, longer = load(amplitude, l), load(per, l)
        for j in range(orders):
            store(acc, at(driven, j) + l, factor * pick(shape, piece, l, j))
            factor *= longer
        if lanes_of(since > 0.0) == 0:  # at the start of a piece
            continue
        for first in range(orders - 1):  # Horner's rule, once an order: the next begins before this one has ended
            lower = load(acc, at(driven, orders - 1) + l)
            for k in range(orders - 2, first - 1, -1):
                lower = load(acc, at(driven, k) + l) + since * lower
                store(acc, at(driven, k) + l, lower)


@part
def _restrain(lanes, j, e, rests, term_start, term_coordinate, term_sign, lever, arm, total, q, tan, d, f):
    """d[j + 1] and f[j] of restraints side by side, of which e is the first."""
    order, first, to = float(j + 1), term_start[e], at(e, j)
    alone = term_start[e + 1] == first + 1 and lever[e] < 0
    q1, sign1 = at(term_coordinate[first], j + 1), term_sign[first]
    alike = rests[row(e) + ALL]
    if alike == RESTS:
        return
    if alike == EXPANDS and alone and j > 1:  # the most frequent by far
        spring, damper = sum_at(e, SPRING), sum_at(e, DAMPER)
        for l in range(0, lanes, WIDTH):
            new = sign1 * load(q, q1 + l)
            store(d, to + STRIDE + l, new)
            store(f, to + l, load(total, spring + l) * load(d, to + l) + order * load(total, damper + l) * new)
        return
    for l in range(0, lanes, WIDTH):
        state = rests[row(e) + l]
        if state == RESTS:
            continue
        if j == 0:
            store(f, to + l, load(total, sum_at(e, AT_0) + l))
            continue
        if alone:
            new = sign1 * load(q, q1 + l)
        else:
            new = _deflection(e, j + 1, l, term_start, term_coordinate, term_sign, lever, arm, q, tan)
        store(d, to + STRIDE + l, new)
        force = load(total, sum_at(e, SPRING) + l) * load(d, to + l) + order * load(total, sum_at(e, DAMPER) + l) * new
        if j == 1:
            force += load(total, sum_at(e, AT_1) + l)
        elif state == FILLS:
            force += (order - 1.0) * load(total, sum_at(e, DAMPER_RISE) + l) * load(d, to + l)
            force += load(total, sum_at(e, SPRING_RISE) + l) * load(d, to - STRIDE + l)
            if j == 2:
                force += load(total, sum_at(e, AT_2) + l)
        store(f, to + l, force)


@inlined
def _forces(lanes, j, law, leading, rests, term_start, term_coordinate, term_sign, lever, arm, line, total, q, tan, d, f):
    """d[j + 1] of every element, then f[j] by its law's line in its present mode; of restraints side by side, of the first."""
    order = float(j + 1)
    for n in range(leading.size):
        e = leading[n]
        if law[e] == RESTRAINT:
            _restrain(lanes, j, e, rests, term_start, term_coordinate, term_sign, lever, arm, total, q, tan, d, f)
            continue
        k, c, to, dj, dk = line_at(e, K), line_at(e, C), at(e, j), at(e, j), at(e, j + 1)
        if j == 0:
            d0, v0, f0 = line_at(e, D0), line_at(e, V0), line_at(e, F0)
            for l in range(0, lanes, WIDTH):
                spring = load(line, k + l) * (load(d, dj + l) - load(line, d0 + l))
                damper = load(line, c + l) * (load(d, dk + l) - load(line, v0 + l))
                store(f, to + l, load(line, f0 + l) + spring + damper)
            continue
        first, terms = term_start[e], term_start[e + 1] - term_start[e]
        q1, sign1 = at(term_coordinate[first], j + 1), term_sign[first]
        if terms == 1 and lever[e] < 0:  # a restraint
            for l in range(0, lanes, WIDTH):
                new = sign1 * load(q, q1 + l)
                store(d, dk + l, new)
                store(f, to + l, load(line, k + l) * load(d, dj + l) + order * load(line, c + l) * new)
        elif terms == 2:  # a front member, or a joint
            q2, sign2 = at(term_coordinate[first + 1], j + 1), term_sign[first + 1]
            a, t, levered = row(e), at(lever[e], j + 1), lever[e] >= 0
            damped = law[e] != ELASTIC and law[e] != PLASTIC
            for l in range(0, lanes, WIDTH):
                new = sign1 * load(q, q1 + l) + sign2 * load(q, q2 + l)
                if levered:
                    new += load(arm, a + l) * load(tan, t + l)
                store(d, dk + l, new)
                force = load(line, k + l) * load(d, dj + l)
                store(f, to + l, force + order * load(line, c + l) * new if damped else force)
        else:
            for l in range(0, lanes, WIDTH):
                new = _deflection(e, j + 1, l, term_start, term_coordinate, term_sign, lever, arm, q, tan)
                store(d, dk + l, new)
                store(f, to + l, load(line, k + l) * load(d, dj + l) + order * load(line, c + l) * new)


@inlined
def _accelerations(
    lanes, j, conjugate, parent, bodies, driven, pull_start, pull_element, pull_sign, arm, inverse_inertia, bar_of, sec2,
    moment, f, acc, q,
):  # fmt: skip
    """acc[j] of every body, absolute, and q[j + 2] of every coordinate, relative to its parent.

    pull_start, pull_element, pull_sign: the elements that act on each coordinate; on a bar's rotation, by their arms.
    """
    share = 1.0 / ((j + 1) * (j + 2))
    if driven >= 0:
        for l in range(0, lanes, WIDTH):
            store(q, at(driven, j + 2) + l, share * load(acc, at(driven, j) + l))
    for n in range(bodies.size):
        i = bodies[n]
        to, m, next_q = at(i, j), row(i), at(i, j + 2)
        above = at(parent[i] if parent[i] >= 0 else parent.size, j)  # parents come before their children
        first, end = pull_start[i], pull_start[i + 1]
        if bar_of[i] >= 0:
            _turn(lanes, i, j, conjugate, bar_of[i], pull_start, pull_element, arm, inverse_inertia, sec2, moment, f, acc)
            for l in range(0, lanes, WIDTH):
                store(q, next_q + l, share * load(acc, to + l))
        elif end - first == 1:  # an occupant
            f1, sign1 = at(pull_element[first], j), pull_sign[first]
            for l in range(0, lanes, WIDTH):
                new = sign1 * load(f, f1 + l) * load(inverse_inertia, m + l)
                store(acc, to + l, new)
                store(q, next_q + l, share * (new - load(acc, above + l)))
        elif end - first == 2:  # a vehicle, or a seat
            f1, sign1 = at(pull_element[first], j), pull_sign[first]
            f2, sign2 = at(pull_element[first + 1], j), pull_sign[first + 1]
            for l in range(0, lanes, WIDTH):
                new = (sign1 * load(f, f1 + l) + sign2 * load(f, f2 + l)) * load(inverse_inertia, m + l)
                store(acc, to + l, new)
                store(q, next_q + l, share * (new - load(acc, above + l)))
        else:
            for m1 in range(first, end, 2):  # two elements at a time
                f1, sign1 = at(pull_element[m1], j), pull_sign[m1]
                m2 = min(m1 + 1, end - 1)
                f2, sign2 = at(pull_element[m2], j), pull_sign[m2] if m2 > m1 else 0.0
                for l in range(0, lanes, WIDTH):
                    total = sign1 * load(f, f1 + l) + sign2 * load(f, f2 + l)
                    store(acc, to + l, total if m1 == first else total + load(acc, to + l))
            for l in range(0, lanes, WIDTH):
                new = load(acc, to + l) * load(inverse_inertia, m + l) if end > first else spread(0.0)
                store(acc, to + l, new)
                store(q, next_q + l, share * (new - load(acc, above + l)))


@inlined
def _turn(lanes, i, j, conjugate, b, pull_start, pull_element, arm, inverse_inertia, sec2, moment, f, acc):
    """acc[j] of a bar's rotation: the moment, the sum of -arm f (eq 4), times sec^2(theta) if conjugate, over the inertia."""
    to, of_bar, m = at(i, j), at(b, 0), row(i)
    moment_row = at(b, j)
    begin, until = pull_start[i], pull_start[i + 1]
    for l in range(0, lanes if until == begin else 0, WIDTH):
        store(moment, moment_row + l, 0.0)
    for n in range(begin, until, 2):
        n2 = min(n + 1, until - 1)
        f1, arm1 = at(pull_element[n], j), row(pull_element[n])
        f2, arm2, weight = at(pull_element[n2], j), row(pull_element[n2]), -1.0 if n2 > n else 0.0
        for l in range(0, lanes, WIDTH):
            total = weight * load(arm, arm2 + l) * load(f, f2 + l) - load(arm, arm1 + l) * load(f, f1 + l)
            store(moment, moment_row + l, total if n == begin else total + load(moment, moment_row + l))
    for l in range(0, lanes, WIDTH):
        total = load(moment, moment_row + l)
        if conjugate:
            total = spread(0.0)
            up, down = of_bar + l, moment_row + l
            for _ in range(j + 1):
                total += load(sec2, up) * load(moment, down)
                up += STRIDE
                down -= STRIDE
        store(acc, to + l, total * load(inverse_inertia, m + l))
