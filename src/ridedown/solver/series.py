"""The power series of a step: every coordinate, deflection and force, term by term, in all lanes at once.

With the coefficients of the positions up to order j + 1 known, those of the forces of order j follow from the laws, and from
them the positions' of order j + 2: `q[j+2] = acceleration[j] / ((j + 1)(j + 2))`. The tangent of a bar's rotation has its own
recurrence, `T' = (1 + T^2) theta'`.

Arrays end in the lane l: q (j, i, l) coordinates, d and f (j, e, l) deflections and forces, tan, sec2, moment (j, b, l).
"""

from __future__ import annotations

import numpy as np

from ridedown.solver.cache import kernel
from ridedown.solver.laws import D0, F0, V0, C, K
from ridedown.solver.workspace import DEGREE, LANES


@kernel
def start_tangents(bar_coordinate, q, tan, sec2):
    """tan(theta) of orders 0 and 1 at the state in q[0], q[1]."""
    for b in range(bar_coordinate.size):
        i = bar_coordinate[b]
        for l in range(LANES):
            t = np.tan(q[0, i, l])
            tan[0, b, l] = t
            sec2[0, b, l] = 1.0 + t * t
            tan[1, b, l] = (1.0 + t * t) * q[1, i, l]


@kernel
def tangents(j, bar_coordinate, q, tan, sec2):
    """sec2[j], then tan[j + 1], by T' = (1 + T^2) theta'."""
    share = 1.0 / (j + 1)
    for b in range(bar_coordinate.size):
        i = bar_coordinate[b]
        for l in range(LANES):
            sec2[j, b, l] = 2.0 * tan[0, b, l] * tan[j, b, l]
            tan[j + 1, b, l] = (j + 1) * sec2[0, b, l] * q[j + 1, i, l]
        for a in range(1, j):
            for l in range(LANES):
                sec2[j, b, l] += tan[a, b, l] * tan[j - a, b, l]
        for a in range(1, j + 1):
            order = float(j - a + 1)
            for l in range(LANES):
                tan[j + 1, b, l] += order * sec2[a, b, l] * q[j - a + 1, i, l]
        for l in range(LANES):
            tan[j + 1, b, l] *= share


@kernel
def deflections(j, term_start, term_coordinate, term_sign, lever, arm, q, tan, d):
    """d[j] = sum of signed coordinates + arm * tan."""
    for e in range(lever.size):
        first = term_start[e]
        i, sign = term_coordinate[first], term_sign[first]
        b = lever[e]
        if b >= 0:
            for l in range(LANES):
                d[j, e, l] = sign * q[j, i, l] + arm[e, l] * tan[j, b, l]
        else:
            for l in range(LANES):
                d[j, e, l] = sign * q[j, i, l]
        for t in range(first + 1, term_start[e + 1]):
            i, sign = term_coordinate[t], term_sign[t]
            for l in range(LANES):
                d[j, e, l] += sign * q[j, i, l]


@kernel
def forces(j, line, d, f):
    """f[j] by each law's line in its present mode."""
    order = float(j + 1)
    for e in range(line.shape[1]):
        if j == 0:
            for l in range(LANES):
                f[0, e, l] = (
                    line[F0, e, l]
                    + line[K, e, l] * (d[0, e, l] - line[D0, e, l])
                    + line[C, e, l] * (d[1, e, l] - line[V0, e, l])
                )
        else:
            for l in range(LANES):
                f[j, e, l] = line[K, e, l] * d[j, e, l] + order * line[C, e, l] * d[j + 1, e, l]


@kernel
def pulls(j, reaction_start, reaction_coordinate, reaction_sign, lever, bar_coordinate, arm, f, pull):
    """What the forces of order j pull each body with, and the moments about each bar (eq 4)."""
    for i in range(pull.shape[0]):
        for l in range(LANES):
            pull[i, l] = 0.0
    for e in range(lever.size):
        for t in range(reaction_start[e], reaction_start[e + 1]):
            i, sign = reaction_coordinate[t], reaction_sign[t]
            for l in range(LANES):
                pull[i, l] -= sign * f[j, e, l]
        if lever[e] >= 0:
            i = bar_coordinate[lever[e]]
            for l in range(LANES):
                pull[i, l] -= arm[e, l] * f[j, e, l]


@kernel
def conjugate_moments(j, bar_coordinate, sec2, moment, pull):
    """The work-conjugate moment: the printed one times sec^2(theta)."""
    for b in range(bar_coordinate.size):
        i = bar_coordinate[b]
        for l in range(LANES):
            moment[j, b, l] = pull[i, l]
            pull[i, l] = sec2[0, b, l] * moment[j, b, l]
        for a in range(1, j + 1):
            for l in range(LANES):
                pull[i, l] += sec2[a, b, l] * moment[j - a, b, l]


@kernel
def positions(j, parent, inverse_inertia, pull, q):
    """q[j + 2] of each coordinate, relative to its parent."""
    share = 1.0 / ((j + 1) * (j + 2))
    for i in range(parent.size):
        above = parent[i]
        for l in range(LANES):
            pull[i, l] *= inverse_inertia[i, l]
        if above < 0:
            for l in range(LANES):
                q[j + 2, i, l] = share * pull[i, l]
        else:  # parents come before their children, so theirs is an acceleration already
            for l in range(LANES):
                q[j + 2, i, l] = share * (pull[i, l] - pull[above, l])
