"""The first event of a step: which guard turns negative, and when.

Each guard is a polynomial on the step, g(t) = a (d - d0) + b (d' - v0). A cheap bound clears most: with every coefficient that
pulls down taken in full, the guard still stays positive. The rest are read closely, by Bernstein coefficients.
"""

from __future__ import annotations

from ridedown.solver import polynomial
from ridedown.solver.cache import kernel
from ridedown.solver.laws import GD0, GV0, A, B
from ridedown.solver.workspace import DEGREE, LANES

GAP_ROUND_OFF = 1e-14  # m
RATE_ROUND_OFF = 1e-13  # m/s
NO_EVENT = -1


@kernel
def find(guard, d, row, last, step, power, event, pending, pending_count, suspect, start, dip, poly, room):
    """Sort each lane's guards: negative at the start (into `pending`), or first to turn negative in the step (into `event`).

    The step of a lane with an event shrinks to it.
    """
    for l in range(LANES):
        pending_count[l] = 0
    for g in range(guard.shape[1]):
        e = g // 2
        for l in range(LANES):
            a, b = guard[A, g, l], guard[B, g, l]
            start[l] = a * (d[0, e, l] - guard[GD0, g, l]) + b * (d[1, e, l] - guard[GV0, g, l])
            dip[l] = 0.0
        for j in range(1, DEGREE):
            order = float(j + 1)
            for l in range(LANES):
                c = (guard[A, g, l] * d[j, e, l] + order * guard[B, g, l] * d[j + 1, e, l]) * power[j, l]
                dip[l] += min(c, 0.0)
        suspects = 0
        for l in range(LANES):
            round_off = GAP_ROUND_OFF * abs(guard[A, g, l]) + RATE_ROUND_OFF * abs(guard[B, g, l])
            suspect[l] = 1 - ((start[l] + dip[l] > 0.0) & (start[l] > round_off))
            suspects += suspect[l]
        if suspects > 0:
            for l in range(LANES):
                if suspect[l] == 1 and row[l] >= 0:
                    _examine(g, l, guard, d, last, step, power, event, pending, pending_count, poly, room)


@kernel
def _examine(g, l, guard, d, last, step, power, event, pending, pending_count, p, room):
    """Read one guard closely: the sign it starts with, then its first root."""
    e = g // 2
    a, b = guard[A, g, l], guard[B, g, l]
    round_off = GAP_ROUND_OFF * abs(a) + RATE_ROUND_OFF * abs(b)
    p[0] = a * (d[0, e, l] - guard[GD0, g, l]) + b * (d[1, e, l] - guard[GV0, g, l])
    for j in range(1, DEGREE):
        p[j] = (a * d[j, e, l] + (j + 1) * b * d[j + 1, e, l]) * power[j, l]
    p[DEGREE] = a * d[DEGREE, e, l] * power[DEGREE, l]
    first = 0
    while first < DEGREE and abs(p[first]) <= round_off:
        first += 1  # within round-off of zero: the next coefficient decides, and the root at zero is divided out
    if abs(p[first]) <= round_off:
        return
    if p[first] < 0.0:
        pending[pending_count[l], l] = g
        pending_count[l] += 1
        return
    root = polynomial.first_root(p, first, DEGREE, room)
    if root < 1.0 or (root == 1.0 and not last[l]):
        step[l] *= root
        for j in range(1, DEGREE + 1):
            power[j, l] = power[j - 1, l] * step[l]
        event[l] = g
        last[l] = False
