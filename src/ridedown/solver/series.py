"""The power series of a step: every coordinate, deflection and force, term by term, in all lanes at once.

With the coefficients of the positions up to order j + 1 known, those of the forces of order j follow from the laws, and from
them the positions' of order j + 2: `q[j+2] = acceleration[j] / ((j + 1)(j + 2))`. The tangent of a bar's rotation has its own
recurrence, `T' = (1 + T^2) theta'`.

Series in rows as `layout.at` says: q and acc of the coordinates (acc absolute), d and f of the elements, tan, sec2 and moment of
the bars.
"""

from __future__ import annotations

import numpy as np

from ridedown.solver.cache import part
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
    to = at(e, j)
    q1, sign1 = at(term_coordinate[first], j), term_sign[first]
    if end - first == 1:
        for l in range(lanes):
            d[to + l] = sign1 * q[q1 + l]
    else:
        q2, sign2 = at(term_coordinate[first + 1], j), term_sign[first + 1]
        for l in range(lanes):
            d[to + l] = sign1 * q[q1 + l] + sign2 * q[q2 + l]
        for n in range(first + 2, end):
            qn, sign = at(term_coordinate[n], j), term_sign[n]
            for l in range(lanes):
                d[to + l] += sign * q[qn + l]
    if lever[e] >= 0:
        t, a = at(lever[e], j), row(e)
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
        for n in range(1, j + 1):
            sn, qn, order = at(b, n), at(i, j - n + 1), (j - n + 1) * share
            for l in range(lanes):
                tan[t + l] += order * sec2[sn + l] * q[qn + l]


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
        to, m = at(i, j), row(i)
        if bar_of[i] >= 0:
            _turn(lanes, i, j, conjugate, bar_of[i], pull_start, pull_element, arm, sec2, moment, f, acc)
        else:
            _pull(lanes, i, j, pull_start, pull_element, pull_sign, f, acc)
        qj = at(i, j + 2)
        if parent[i] < 0:
            for l in range(lanes):
                a = acc[to + l] * inverse_inertia[m + l]
                acc[to + l] = a
                q[qj + l] = share * a
        else:  # parents come before their children
            above = at(parent[i], j)
            for l in range(lanes):
                a = acc[to + l] * inverse_inertia[m + l]
                q[qj + l] = share * (a - acc[above + l])
                acc[to + l] = a


@part
def _pull(lanes, i, j, pull_start, pull_element, pull_sign, f, acc):
    """What the forces of order j pull body i with."""
    first, end = pull_start[i], pull_start[i + 1]
    to = at(i, j)
    if end == first:
        for l in range(lanes):
            acc[to + l] = 0.0
        return
    f1, sign1 = at(pull_element[first], j), pull_sign[first]
    if end - first == 1:
        for l in range(lanes):
            acc[to + l] = sign1 * f[f1 + l]
        return
    f2, sign2 = at(pull_element[first + 1], j), pull_sign[first + 1]
    for l in range(lanes):
        acc[to + l] = sign1 * f[f1 + l] + sign2 * f[f2 + l]
    for n in range(first + 2, end):
        fn, sign = at(pull_element[n], j), pull_sign[n]
        for l in range(lanes):
            acc[to + l] += sign * f[fn + l]


@part
def _turn(lanes, i, j, conjugate, b, pull_start, pull_element, arm, sec2, moment, f, acc):
    """The moment of order j about bar b: the sum of -arm f (eq 4), times sec^2(theta) if work-conjugate."""
    to = at(i, j)
    for l in range(lanes):
        acc[to + l] = 0.0
    for n in range(pull_start[i], pull_start[i + 1]):
        fn, a = at(pull_element[n], j), row(pull_element[n])
        for l in range(lanes):
            acc[to + l] -= arm[a + l] * f[fn + l]
    if conjugate:
        m = at(b, j)
        for l in range(lanes):
            moment[m + l] = acc[to + l]
            acc[to + l] = 0.0
        for n in range(j + 1):
            s, mn = at(b, n), at(b, j - n)
            for l in range(lanes):
                acc[to + l] += sec2[s + l] * moment[mn + l]
