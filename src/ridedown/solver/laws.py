"""The force laws as modes: in each, the force is linear in deflection d and rate v, until a guard turns negative.

    law            mode                     force                          guards, positive inside the mode
    linear         0                        k (d - s) + c v                none
    kelvin-voigt   0 open                   0                              s - d
                   1 taut                   k (d - s) + c v                the force
                   2 clipped                0                              minus that force; d - s
    threshold      0 open                   0                              s - d
                   1 damped                 k (d - s) + c (v - v*)         d - s; v - v*          paper, eqs 13-18
                   2 undamped               k (d - s)                      d - s; v* - v
    elastic curve  0 open                   0                              -d
                   i on piece i             F_i + k_i (d - d_i)            d - d_i; d_(i+1) - d   paper, eq 9
    plastic curve  0 open                   0                              set - d
                   i on piece i             F_i + k_i (d - d_i)            v; d_(i+1) - d
                   n + 1 on unloading line  k_u (d - set)                  d - set; d_max - d

The restraint law has files of its own: `restraint.py`, `restraint_line.py` and `reel.py`.

`v*` is the rate at the instant that the slack is taken up. A plastic curve's set is `d_max - F(d_max) / k_u`, and never counts
as less than zero: a member pushes only while it is shorter than it was.

Arrays, in rows as `layout` says: `coefficients` are an element's stiffness, damping and slack, `pieces` a piece's knot, force
and slope; `line`, `guard`, `memory` and `mode`. Guards 2e and 2e + 1 are those of element e.
"""

from __future__ import annotations

from ridedown.compiled import inlined
from ridedown.network import Law
from ridedown.solver.layout import (
    D0,
    F0,
    GD0,
    GV0,
    LATCH,
    NUMBER,
    PIECE,
    SET,
    V0,
    A,
    B,
    C,
    K,
    coefficient_at,
    guard_at,
    line_at,
    memory_at,
    mode_at,
    piece_at,
)

LINEAR, KELVIN_VOIGT, THRESHOLD, ELASTIC, PLASTIC, RESTRAINT = (int(law) for law in Law)

OPEN = 0
TAUT, CLIPPED = 1, 2
DAMPED, UNDAMPED = 1, 2

STIFFNESS, DAMPING, SLACK = range(3)
KNOT, FORCE, SLOPE = range(3)


NEVER = -1e300
"""Reference of a guard that is never negative."""


@inlined
def enter(e, l, after, law, piece_start, coefficients, pieces, line, guard, memory, mode):
    """Put element e of lane l into mode `after`: its line of force and its guards."""
    k, c, d0, v0, f0 = 0.0, 0.0, 0.0, 0.0, 0.0
    a1, b1, d1, v1 = 1.0, 0.0, NEVER, 0.0
    a2, b2, d2, v2 = 1.0, 0.0, NEVER, 0.0
    stiffness, damping, slack = (
        coefficients[coefficient_at(e, STIFFNESS) + l],
        coefficients[coefficient_at(e, DAMPING) + l],
        coefficients[coefficient_at(e, SLACK) + l],
    )
    if law[e] == LINEAR:
        k, c, d0 = stiffness, damping, slack
    elif law[e] == ELASTIC or law[e] == PLASTIC:
        first, end = piece_start[e], piece_start[e + 1]
        p = first + after - 1
        shortest = max(memory[memory_at(e, SET) + l], 0.0)  # deflection up to which the member does not touch
        if after == OPEN:
            a1, d1 = -1.0, shortest
        elif p < end:
            k, d0, f0 = pieces[piece_at(p, SLOPE) + l], pieces[piece_at(p, KNOT) + l], pieces[piece_at(p, FORCE) + l]  # eq 9
            if law[e] == PLASTIC:
                a1, b1, d1 = 0.0, 1.0, 0.0
            else:
                d1 = d0
            if p + 1 < end:
                a2, d2 = -1.0, pieces[piece_at(p + 1, KNOT) + l]
        else:
            k, d0 = stiffness, memory[memory_at(e, SET) + l]
            d1 = shortest
            a2, d2 = -1.0, memory[memory_at(e, LATCH) + l]
    elif after == OPEN:
        a1, d1 = -1.0, slack
    elif law[e] == KELVIN_VOIGT:
        if after == TAUT:
            k, c, d0 = stiffness, damping, slack
            a1, b1, d1 = stiffness, damping, slack
        else:
            a1, b1, d1 = -stiffness, -damping, slack
            d2 = slack
    else:
        v_star = memory[memory_at(e, LATCH) + l]
        k, d0, v0 = stiffness, slack, v_star  # eqs 13-18
        c = damping if after == DAMPED else 0.0
        d1 = slack
        a2, b2, d2, v2 = 0.0, 1.0 if after == DAMPED else -1.0, 0.0, v_star
    mode[mode_at(e, NUMBER) + l] = after
    line[line_at(e, K) + l] = k
    line[line_at(e, C) + l] = c
    line[line_at(e, D0) + l] = d0
    line[line_at(e, V0) + l] = v0
    line[line_at(e, F0) + l] = f0
    _guard(2 * e, l, a1, b1, d1, v1, guard)
    _guard(2 * e + 1, l, a2, b2, d2, v2, guard)


@inlined
def _guard(g, l, a, b, d0, v0, guard):
    guard[guard_at(g, A) + l] = a
    guard[guard_at(g, B) + l] = b
    guard[guard_at(g, GD0) + l] = d0
    guard[guard_at(g, GV0) + l] = v0


@inlined
def next_mode(e, l, second, d, v, law, piece_start, coefficients, pieces, memory, mode):
    """The mode on the other side of element e's first or second guard; takes down what the law must remember.

    d, v: its deflection and rate at the event.
    """
    now = mode[mode_at(e, NUMBER) + l]
    if law[e] == KELVIN_VOIGT:
        if now == TAUT:
            return CLIPPED
        return OPEN if now == CLIPPED and second else TAUT
    if law[e] == THRESHOLD:
        if now == OPEN:
            memory[memory_at(e, LATCH) + l] = v  # v* of eq 16
            return DAMPED
        if not second:
            return OPEN
        return UNDAMPED if now == DAMPED else DAMPED
    if law[e] == ELASTIC:
        return now + 1 if now == OPEN or second else now - 1
    first = piece_start[e]
    unloading = piece_start[e + 1] - first + 1
    unloaded_from = int(memory[memory_at(e, PIECE) + l])
    if now == OPEN:
        return 1 if unloaded_from == 0 else unloading
    if now == unloading:
        return unloaded_from if second else OPEN
    if second:
        return now + 1
    p = first + now - 1
    force = pieces[piece_at(p, FORCE) + l] + pieces[piece_at(p, SLOPE) + l] * (d - pieces[piece_at(p, KNOT) + l])
    memory[memory_at(e, LATCH) + l] = d
    memory[memory_at(e, SET) + l] = d - force / coefficients[coefficient_at(e, STIFFNESS) + l]
    memory[memory_at(e, PIECE) + l] = now
    return unloading
