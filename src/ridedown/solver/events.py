"""The first event of a step: which guard turns negative, and when.

Each guard is a polynomial on the step, g(t) = a (d - d0) + b (d' - v0). A cheap bound clears most: with every coefficient that
pulls down taken in full, the guard still stays positive. The rest are read closely. Most of those fall throughout the step and
end below zero: they have one root, and Newton's method finds all of them at once, side by side. What is left goes to
Bernstein coefficients.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import part
from ridedown.solver import polynomial
from ridedown.solver.layout import DEGREE, GD0, GV0, STRIDE, A, B, at, guard_at, row

GAP_ROUND_OFF = 1e-14  # m
RATE_ROUND_OFF = 1e-13  # m/s
NO_EVENT = -1


@part
def find(lanes, guards, guard, d, crash, last, step, power, event, pending, pending_count, suspect, falling, owner, poly, room):
    """Sort each lane's guards: negative at the start (into `pending`), or first to turn negative in the step (into `event`).

    The step of a lane with an event shrinks to it. `falling` and `owner` are room for one guard a lane and more, to be solved
    together.
    """
    count = np.int64(0)
    for l in range(lanes):
        pending_count[l] = 0
        event[l] = NO_EVENT
        power[row(DEGREE + 1) + l] = 1.0  # the earliest event so far, as a fraction of the step
    for g in range(guards):
        suspects = _suspects(lanes, g, guard, d, power, suspect)
        if suspects == 0:
            continue
        for l in range(lanes):
            if suspect[l] != 0 and crash[l] >= 0:
                kind = _examine(g, l, guard, d, power, pending, pending_count, poly)
                if kind == _FALLS:
                    if count == STRIDE:
                        _solve_together(count, falling, owner, power, event)
                        count = np.int64(0)
                    for j in range(DEGREE + 1):
                        falling[row(j) + np.uint64(count)] = poly[j]
                    owner[2 * count] = l
                    owner[2 * count + 1] = g
                    count += 1
                elif kind == _SEARCH:
                    _note(g, l, polynomial.first_root(poly, room), power, event)
    _solve_together(count, falling, owner, power, event)
    for l in range(lanes):
        first = power[row(DEGREE + 1) + l]
        if event[l] != NO_EVENT and (first < 1.0 or not last[l]):
            step[l] *= first
            last[l] = False
        else:
            event[l] = NO_EVENT


_CLEAR, _FALLS, _SEARCH = range(3)


@part
def _suspects(lanes, g, guard, d, power, suspect):
    """Mark the lanes in which guard g may start or turn negative."""
    e = g // 2
    a0, b0, d0, v0 = guard_at(g, A), guard_at(g, B), guard_at(g, GD0), guard_at(g, GV0)
    base = at(e, 0)
    stride = np.uint64(STRIDE)
    count = 0
    for l in range(lanes):
        a, b = guard[a0 + l], guard[b0 + l]
        o = base + l
        start = a * (d[o] - guard[d0 + l]) + b * (d[o + stride] - guard[v0 + l])
        o += stride
        slope = (a * d[o] + 2.0 * b * d[o + stride]) * power[row(1) + l]
        dip = 0.0
        for j in range(2, DEGREE):  # unrolled: DEGREE is a constant
            o += stride
            c = (a * d[o] + (j + 1.0) * b * d[o + stride]) * power[row(j) + l]
            dip += min(c, 0.0)
        round_off = GAP_ROUND_OFF * abs(a) + RATE_ROUND_OFF * abs(b)
        stays = (start > round_off) & (start + min(slope, 0.0) + dip > 0.0)
        leaves = (abs(start) <= round_off) & (slope > round_off) & (slope + dip > 0.0)  # zero at the start, and rising
        suspect[l] = 1 - (stays | leaves)
        count += suspect[l]
    return count


@part
def _examine(g, l, guard, d, power, pending, pending_count, p):
    """Read one guard closely, its polynomial into p.

    Answers _CLEAR, _FALLS (one root) or _SEARCH; then p is divided by t as often as it starts at zero.
    """
    e = g // 2
    a, b = guard[guard_at(g, A) + l], guard[guard_at(g, B) + l]
    round_off = GAP_ROUND_OFF * abs(a) + RATE_ROUND_OFF * abs(b)
    p[0] = a * (d[at(e, 0) + l] - guard[guard_at(g, GD0) + l]) + b * (d[at(e, 1) + l] - guard[guard_at(g, GV0) + l])
    for j in range(1, DEGREE):
        p[j] = (a * d[at(e, j) + l] + (j + 1) * b * d[at(e, j + 1) + l]) * power[row(j) + l]
    p[DEGREE] = a * d[at(e, DEGREE) + l] * power[row(DEGREE) + l]
    first = 0
    while first < DEGREE and abs(p[first]) <= round_off:
        first += 1  # within round-off of zero: the next coefficient decides, and the root at zero is divided out
    if abs(p[first]) <= round_off:
        return _CLEAR
    if p[first] < 0.0:
        pending[row(pending_count[l]) + l] = g
        pending_count[l] += 1
        return _CLEAR
    if first > 0:
        for j in range(DEGREE + 1):
            p[j] = p[j + first] if j + first <= DEGREE else 0.0
    end, fastest = p[0] + p[1], p[1]
    for j in range(2, DEGREE + 1):
        end += p[j]
        fastest += j * max(p[j], 0.0)
    if fastest >= 0.0:
        return _SEARCH
    return _CLEAR if end > 0.0 else _FALLS


@part
def _note(g, l, root, power, event):
    """Keep the earliest root of a lane."""
    at_lane = row(DEGREE + 1) + l
    if root < power[at_lane] or (root == 1.0 and event[l] == NO_EVENT):
        power[at_lane] = root
        event[l] = g


@part
def _solve_together(count, falling, owner, power, event):
    """Newton's method on `count` polynomials that fall through zero once on [0, 1], all at once; by bisection, the rest."""
    t, moved = row(DEGREE + 1), row(DEGREE + 2)
    n = np.uint64(count)
    stride = np.uint64(STRIDE)
    for x in range(n):
        start = falling[x]
        end = start
        for j in range(1, DEGREE + 1):
            end += falling[row(j) + x]
        falling[t + x] = start / (start - end)
        falling[moved + x] = 1.0
    for _ in range(6):
        for x in range(n):
            at_x = falling[t + x]
            o = row(DEGREE) + x
            f = falling[o]
            slope = 0.0
            for _j in range(DEGREE):  # unrolled Horner, value and slope
                o -= stride
                slope = slope * at_x + f
                f = f * at_x + falling[o]
            nearer = min(max(at_x - f / slope, 0.0), 1.0)
            falling[moved + x] = abs(nearer - at_x)
            falling[t + x] = nearer
    for x in range(n):
        root = falling[t + x]
        if not falling[moved + x] <= 1e-12:
            root = _bisect(x, falling)
        two = np.uint64(2)
        _note(owner[two * x + np.uint64(1)], np.uint64(owner[two * x]), root, power, event)


@part
def _bisect(x, falling):
    low, high = 0.0, 1.0
    for _ in range(53):
        t = 0.5 * (low + high)
        f = 0.0
        for j in range(DEGREE, -1, -1):
            f = f * t + falling[row(j) + x]
        if f > 0.0:
            low = t
        else:
            high = t
    return high
