"""The power series of a step: every coordinate, deflection and force, term by term, in all lanes at once.

With the coefficients of the positions up to order j + 1 known, those of the forces of order j follow from the laws, and from
them the positions' of order j + 2: `q[j+2] = acceleration[j] / ((j + 1)(j + 2))`. The tangent of a bar's rotation has its own
recurrence, `T' = (1 + T^2) theta'`.

Series in rows as `layout.at` says: q and acc of the coordinates (acc absolute), d and f of the elements, tan, sec2 and moment
of the bars.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import part
from ridedown.solver.layout import D0, F0, V0, C, K, at, line_at, row


@part
def start(lanes, bar_coordinate, term_start, term_coordinate, term_sign, lever, arm, q, tan, sec2, d):
    """Tangents and deflections of orders 0 and 1, at the state in q."""
    for b in range(bar_coordinate.size):
        theta, rate = at(bar_coordinate[b], 0), at(bar_coordinate[b], 1)
        t0, t1, s0 = at(b, 0), at(b, 1), at(b, 0)
        for l in range(lanes):
            t = np.tan(q[theta + l])
            tan[t0 + l] = t
            sec2[s0 + l] = 1.0 + t * t
            tan[t1 + l] = (1.0 + t * t) * q[rate + l]
    for e in range(lever.size):
        for j in range(2):
            _deflection(lanes, e, j, term_start, term_coordinate, term_sign, lever, arm, q, tan, d)


@part
def _deflection(lanes, e, j, term_start, term_coordinate, term_sign, lever, arm, q, tan, d):
    """d[j] = sum of signed coordinates + arm * tan."""
    first, end = term_start[e], term_start[e + 1]
    to, a = at(e, j), row(e)
    q1, sign1 = at(term_coordinate[first], j), term_sign[first]
    if end - first == 2 and lever[e] >= 0:  # a front member: in one go
        q2, sign2 = at(term_coordinate[first + 1], j), term_sign[first + 1]
        t = at(lever[e], j)
        for l in range(lanes):
            d[to + l] = sign1 * q[q1 + l] + sign2 * q[q2 + l] + arm[a + l] * tan[t + l]
        return
    for l in range(lanes):
        d[to + l] = sign1 * q[q1 + l]
    for n in range(first + 1, end):
        qn, sign = at(term_coordinate[n], j), term_sign[n]
        for l in range(lanes):
            d[to + l] += sign * q[qn + l]
    if lever[e] >= 0:
        t = at(lever[e], j)
        for l in range(lanes):
            d[to + l] += arm[a + l] * tan[t + l]


@part
def tangents(lanes, j, bar_coordinate, q, tan, sec2):
    """sec2[j], then tan[j + 1], by T' = (1 + T^2) theta'."""
    share = 1.0 / (j + 1)
    for b in range(bar_coordinate.size):
        i = bar_coordinate[b]
        s, t = at(b, j), at(b, j + 1)
        s0, t0, tj, q1 = at(b, 0), at(b, 0), at(b, j), at(i, j + 1)
        for l in range(lanes):
            sec2[s + l] = 2.0 * tan[t0 + l] * tan[tj + l]
        for n in range(1, (j + 1) // 2):  # the square's sum is symmetric
            ta, tb = at(b, n), at(b, j - n)
            for l in range(lanes):
                sec2[s + l] += 2.0 * tan[ta + l] * tan[tb + l]
        if j % 2 == 0:
            ta = at(b, j // 2)
            for l in range(lanes):
                sec2[s + l] += tan[ta + l] * tan[ta + l]
        for l in range(lanes):
            tan[t + l] = sec2[s0 + l] * q[q1 + l]
        for n in range(1, j, 2):  # two terms in one go
            sa, qa, x = at(b, n), at(i, j - n + 1), (j - n + 1) * share
            sb, qb, y = at(b, n + 1), at(i, j - n), (j - n) * share
            for l in range(lanes):
                tan[t + l] += x * sec2[sa + l] * q[qa + l] + y * sec2[sb + l] * q[qb + l]
        if j % 2 == 1:
            sn, qn = at(b, j), at(i, 1)
            for l in range(lanes):
                tan[t + l] += share * sec2[sn + l] * q[qn + l]


@part
def forces(lanes, j, term_start, term_coordinate, term_sign, lever, arm, line, q, tan, d, f):
    """d[j + 1] of every element, then f[j] by its law's line in its present mode."""
    order = float(j + 1)
    for e in range(lever.size):
        k, c, to, dj, dk = line_at(e, K), line_at(e, C), at(e, j), at(e, j), at(e, j + 1)
        if j == 0:
            d0, v0, f0 = line_at(e, D0), line_at(e, V0), line_at(e, F0)
            for l in range(lanes):
                spring = line[k + l] * (d[dj + l] - line[d0 + l])
                f[to + l] = line[f0 + l] + spring + line[c + l] * (d[dk + l] - line[v0 + l])
            continue
        first = term_start[e]
        if term_start[e + 1] - first == 1 and lever[e] < 0:  # a restraint: in one go
            q1, sign1 = at(term_coordinate[first], j + 1), term_sign[first]
            for l in range(lanes):
                new = sign1 * q[q1 + l]
                d[dk + l] = new
                f[to + l] = line[k + l] * d[dj + l] + order * line[c + l] * new
        else:
            _deflection(lanes, e, j + 1, term_start, term_coordinate, term_sign, lever, arm, q, tan, d)
            for l in range(lanes):
                f[to + l] = line[k + l] * d[dj + l] + order * line[c + l] * d[dk + l]


@part
def accelerations(
    lanes, j, conjugate, parent, pull_start, pull_element, pull_sign, arm, inverse_inertia, bar_of, sec2, moment, f, acc, q
):
    """acc[j] of every body, absolute, and q[j + 2] of every coordinate, relative to its parent.

    pull_start, pull_element, pull_sign: the elements that act on each coordinate; on a bar's rotation, by their arms.
    """
    share = 1.0 / ((j + 1) * (j + 2))
    for i in range(parent.size):
        to, m, qj = at(i, j), row(i), at(i, j + 2)
        first = pull_start[i]
        pulls = pull_start[i + 1] - first
        if bar_of[i] >= 0:
            _turn(lanes, i, j, conjugate, bar_of[i], pull_start, pull_element, arm, inverse_inertia, sec2, moment, f, acc)
        elif pulls == 1:  # an occupant
            f1, sign1 = at(pull_element[first], j), pull_sign[first]
            for l in range(lanes):
                acc[to + l] = sign1 * f[f1 + l] * inverse_inertia[m + l]
        elif pulls == 2:  # a vehicle, or a seat
            f1, sign1 = at(pull_element[first], j), pull_sign[first]
            f2, sign2 = at(pull_element[first + 1], j), pull_sign[first + 1]
            for l in range(lanes):
                acc[to + l] = (sign1 * f[f1 + l] + sign2 * f[f2 + l]) * inverse_inertia[m + l]
        else:
            _pull(lanes, i, j, pull_start, pull_element, pull_sign, inverse_inertia, f, acc)
        if parent[i] < 0:
            for l in range(lanes):
                q[qj + l] = share * acc[to + l]
        else:  # parents come before their children
            above = at(parent[i], j)
            for l in range(lanes):
                q[qj + l] = share * (acc[to + l] - acc[above + l])


@part
def _pull(lanes, i, j, pull_start, pull_element, pull_sign, inverse_inertia, f, acc):
    """acc[j] of a body that any number of elements act on."""
    to, m = at(i, j), row(i)
    for l in range(lanes):
        acc[to + l] = 0.0
    for n in range(pull_start[i], pull_start[i + 1]):
        fn, sign = at(pull_element[n], j), pull_sign[n]
        for l in range(lanes):
            acc[to + l] += sign * inverse_inertia[m + l] * f[fn + l]


@part
def _turn(lanes, i, j, conjugate, b, pull_start, pull_element, arm, inverse_inertia, sec2, moment, f, acc):
    """acc[j] of a bar's rotation: the moment, the sum of -arm f (eq 4), times sec^2(theta) if conjugate, over the inertia."""
    to, at_moment, m = at(i, j), at(b, j), row(i)
    for l in range(lanes):
        moment[at_moment + l] = 0.0
    for n in range(pull_start[i], pull_start[i + 1]):
        fn, a = at(pull_element[n], j), row(pull_element[n])
        for l in range(lanes):
            moment[at_moment + l] -= arm[a + l] * f[fn + l]
    if not conjugate:
        for l in range(lanes):
            acc[to + l] = moment[at_moment + l] * inverse_inertia[m + l]
        return
    for l in range(lanes):
        acc[to + l] = 0.0
    for n in range(j + 1):
        s, mn = at(b, n), at(b, j - n)
        for l in range(lanes):
            acc[to + l] += sec2[s + l] * moment[mn + l] * inverse_inertia[m + l]
