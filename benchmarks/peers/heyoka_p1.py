"""P1 by heyoka: Taylor series in batches, events located by the integrator, modes and peaks by hand.

What makes it fast: the force laws are linear in each mode, and their coefficients are runtime parameters, lane by lane,
so that one compiled integrator serves every mode; `tan(theta)` is a state of its own, so that the right-hand side is
polynomial; occupants move relative to what they are tied to, so that guards are states plus constants; a lane whose
crash is over takes the next one at once; all of Python's work between two steps is one compiled function; the system
does not depend on time, so that a step may run past the end and its overhang is left out.

What makes it right: modes are set from the state and its rates, not from the one event that was reported, so that
coincident events are all taken; a guard is an event only as it falls, with no cooldown, so that an event just passed is
neither found again nor hides the next.
"""

from __future__ import annotations

from typing import Any

import heyoka as hy
import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

import os
TOLERANCE = 1e-9
LANES = int(os.environ.get('LANES','8'))

M1, M2, K1, K2, KNEE, KA, CA, KC, CC, KS, CS, SPEED = range(12)
WIDTH, HALF_OFFSET, BAR_MASS, BAR_INERTIA = 1.1, 0.443, 40.0, 157.0
ADULT, CHILD, SEAT, SLACK = 80.0, 18.0, 5.0, 0.005
LONG_ARM, SHORT_ARM = WIDTH / 2.0 + HALF_OFFSET, WIDTH / 2.0 - HALF_OFFSET
END = 0.2

# states: the ties' are relative, adult to vehicle, child to seat, seat to vehicle
X1, V1, X2, V2, XB, VB, TAN, OM, XA, VA, XC, VC, XS, VS = range(14)
SPRINGS, TIES = 4, 3  # springs 1 right, 1 left, 2 right, 2 left; ties adult, child, seat
# runtime parameters of a lane: the two inverse masses; each law as intercept, stiffness (and damping);
# each law's two guards, linear as well
SPRING_LAW, TIE_LAW = 2, 2 + 2 * SPRINGS
SPRING_GUARD = TIE_LAW + 3 * TIES
TIE_GUARD = SPRING_GUARD + 4 * SPRINGS
PARAMETERS = TIE_GUARD + 6 * TIES

OFF, FIRST, SECOND = 0, 1, 2  # a spring
OPEN, TAUT, CLIPPED = 0, 1, 2  # a tie; clipped: it could only push
# A mode is left this far beyond its bound [m]: a guard never starts at zero, where the integrator loses its next root.
GRACE = 1e-13
DUE = 0.5 * GRACE
# rows of what each lane keeps of its own
TIME, PART, SCALE, BEND, LEAST, BEST = 0, 1, 2, 3, 4, 5
ABOVE, SUM, WOBBLE, MODE = 11, 17, 23, 29
SERIES = MODE + SPRINGS + TIES
ROWS = SERIES + 6 * 40
CRASH = 2


def _integrator(lanes: int, tolerance: float) -> Any:
    """P1 with its laws' coefficients left open, and two falling guards for each law as terminal events."""
    x1, v1, x2, v2, xb, vb, tan, om, xa, va, xc, vc, xs, vs = hy.make_vars(
        "x1", "v1", "x2", "v2", "xb", "vb", "tan", "om", "xa", "va", "xc", "vc", "xs", "vs"
    )
    par = hy.par
    gap1, gap2, far, near = x1 - xb, x2 + xb, LONG_ARM * tan, SHORT_ARM * tan
    springs = (gap1 - far, gap1 + near, gap2 - far, gap2 + near)
    f = [par[SPRING_LAW + 2 * e] + par[SPRING_LAW + 2 * e + 1] * d for e, d in enumerate(springs)]
    ties = ((xa, va), (xc, vc), (xs, vs))
    pull = [
        par[TIE_LAW + 3 * i] + par[TIE_LAW + 3 * i + 1] * x + par[TIE_LAW + 3 * i + 2] * v
        for i, (x, v) in enumerate(ties)
    ]
    brake = (f[0] + f[1]) * par[0]
    seat = (pull[1] - pull[2]) / SEAT
    system = [
        (x1, v1),
        (v1, -brake),
        (x2, v2),
        (v2, -(f[2] + f[3]) * par[1]),
        (xb, vb),
        (vb, ((f[0] + f[1]) - (f[2] + f[3])) / BAR_MASS),
        (tan, (1.0 + tan * tan) * om),
        (om, (f[0] + f[2]) * (LONG_ARM / BAR_INERTIA) - (f[1] + f[3]) * (SHORT_ARM / BAR_INERTIA)),
        (xa, va),
        (va, brake - pull[0] / ADULT),
        (xc, vc),
        (vc, -pull[1] / CHILD - seat),
        (xs, vs),
        (vs, brake + seat),
    ]
    guards = []
    for e, d in enumerate(springs):
        for g in (SPRING_GUARD + 4 * e, SPRING_GUARD + 4 * e + 2):
            guards.append(par[g] + par[g + 1] * d)
    for i, (x, v) in enumerate(ties):
        for g in (TIE_GUARD + 6 * i, TIE_GUARD + 6 * i + 3):
            guards.append(par[g] + par[g + 1] * x + par[g + 2] * v)
    falling = hy.event_direction.negative
    return hy.taylor_adaptive_batch(
        system,
        np.zeros((14, lanes)),
        tol=tolerance,
        pars=np.zeros((PARAMETERS, lanes)),
        t_events=[hy.t_event_batch(g, direction=falling, cooldown=0.0) for g in guards],
        high_accuracy=False,
        compact_mode=False,
    )


@numba.njit(cache=True)
def _settle(p, own, y, par, l):
    """Set the modes of lane l, and its laws and guards, from the state; all that are due, not only what was reported."""
    far, near = LONG_ARM * y[TAN, l], SHORT_ARM * y[TAN, l]
    gap1, gap2 = y[X1, l] - y[XB, l], y[X2, l] + y[XB, l]
    knee = p[KNEE]
    for e, d in enumerate((gap1 - far, gap1 + near, gap2 - far, gap2 + near)):
        old = own[MODE + e, l]
        new = old
        if old == FIRST:
            if d < -DUE:
                new = OFF
            elif d > knee + DUE:
                new = SECOND
        elif old == OFF:
            if d > DUE:
                new = FIRST
        elif d < knee - DUE:
            new = FIRST
        if new != old:
            own[MODE + e, l] = new
            _set_spring(p, new, par, e, l)
    for i in range(TIES):
        x, v = y[XA + 2 * i, l] - SLACK, y[VA + 2 * i, l]
        k, c = p[KA + 2 * i], p[CA + 2 * i]
        pull, due = k * x + c * v, DUE * (k + c)
        old = own[MODE + SPRINGS + i, l]
        new = old
        if old == OPEN:
            if x > DUE:
                new = TAUT if pull > 0.0 else CLIPPED
        elif old == TAUT:
            if pull < -due:
                new = CLIPPED if x > 0.0 else OPEN
        elif x < -DUE:
            new = OPEN
        elif pull > due:
            new = TAUT
        if new != old:
            own[MODE + SPRINGS + i, l] = new
            _set_tie(k, c, new, par, i, l)


@numba.njit(cache=True)
def _set_spring(p, mode, par, e, l):
    law, guard = SPRING_LAW + 2 * e, SPRING_GUARD + 4 * e
    k1, k2, knee = p[K1], p[K2], p[KNEE]
    par[guard, l], par[guard + 1, l], par[guard + 2, l], par[guard + 3, l] = 1.0, 0.0, 1.0, 0.0
    if mode == OFF:
        par[law, l], par[law + 1, l] = 0.0, 0.0
        par[guard, l], par[guard + 1, l] = GRACE, -1.0
    elif mode == FIRST:
        par[law, l], par[law + 1, l] = 0.0, k1
        par[guard, l], par[guard + 1, l] = GRACE, 1.0
        par[guard + 2, l], par[guard + 3, l] = knee + GRACE, -1.0
    else:
        par[law, l], par[law + 1, l] = (k1 - k2) * knee, k2
        par[guard, l], par[guard + 1, l] = GRACE - knee, 1.0


@numba.njit(cache=True)
def _set_tie(k, c, mode, par, i, l):
    law, guard = TIE_LAW + 3 * i, TIE_GUARD + 6 * i
    par[law : law + 3, l] = 0.0
    par[guard : guard + 6, l] = 0.0
    par[guard, l], par[guard + 3, l] = 1.0, 1.0
    if mode == OPEN:
        par[guard, l], par[guard + 1, l] = GRACE + SLACK, -1.0
    elif mode == TAUT:
        par[law, l], par[law + 1, l], par[law + 2, l] = -k * SLACK, k, c
        par[guard, l], par[guard + 1, l], par[guard + 2, l] = GRACE * (k + c) - k * SLACK, k, c
    else:
        par[guard, l], par[guard + 1, l] = GRACE - SLACK, 1.0
        par[guard + 3, l], par[guard + 4, l], par[guard + 5, l] = GRACE * (k + c) + k * SLACK, -k, -c


@numba.njit(cache=True)
def _maximum(c, order, best):
    """The greatest of `best` and sum c[k] u^k over 0 <= u <= 1."""
    above, end, slope, wobble = c[0], c[0], c[1], 0.0
    for k in range(1, order + 1):
        above += abs(c[k])
        end += c[k]
        if k > 1:
            wobble += k * abs(c[k])
    best = max(best, c[0], end)
    if above <= best or slope - wobble > 0.0 or slope + wobble < 0.0:
        return best
    left, at_left = 0.0, slope
    for part in range(1, 9):
        right = 0.125 * part
        at_right = _slope_at(c, order, right)
        if at_left > 0.0 >= at_right:
            best = max(best, _top(c, order, left, right, at_left, at_right))
        left, at_left = right, at_right
    return best


@numba.njit(cache=True)
def _slope_at(c, order, u):
    s = order * c[order]
    for k in range(order - 1, 0, -1):
        s = s * u + k * c[k]
    return s


@numba.njit(cache=True)
def _top(c, order, a, b, at_a, at_b):
    """The value where the slope passes zero between a and b: the secant rule with Illinois' correction."""
    kept = 0
    u = b
    for _ in range(60):
        u = (a * at_b - b * at_a) / (at_b - at_a)
        s = _slope_at(c, order, u)
        if s == 0.0 or b - a < 1e-9 or abs(s) < 1e-9 * (abs(at_a) + abs(at_b)):
            break
        if s > 0.0:
            a, at_a = u, s
            at_b *= 0.5 if kept == 1 else 1.0
            kept = 1
        else:
            b, at_b = u, s
            at_a *= 0.5 if kept == -1 else 1.0
            kept = -1
    value = c[order]
    for k in range(order - 1, -1, -1):
        value = value * u + c[k]
    return value


@numba.njit(cache=True, error_model="numpy")
def _start(params, outputs, count, own, y, par, l):
    """Put the next crash, if there is one, in lane l; else an idle copy of the first."""
    more = count[0] < len(params)
    i = count[0] if more else 0
    count[CRASH + l] = i if more else -1
    p = params[i]
    y[:, l] = 0.0
    y[V1, l] = y[V2, l] = p[SPEED]
    par[0, l], par[1, l] = 1.0 / p[M1], 1.0 / p[M2]
    for e in range(SPRINGS):
        own[MODE + e, l] = FIRST
        _set_spring(p, FIRST, par, e, l)
    for i in range(TIES):
        own[MODE + SPRINGS + i, l] = OPEN
        _set_tie(0.0, 0.0, OPEN, par, i, l)
    own[TIME, l] = 0.0
    own[BEST : BEST + 6, l] = 0.0
    if more:
        count[0] += 1


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def _take(own, row, which, l, slope, v):
    """Note a coefficient of an outcome's series, and add it to its bounds."""
    own[row + which, l] = v
    own[SUM + which, l] += v
    own[ABOVE + which, l] += abs(v)
    own[WOBBLE + which, l] += slope * abs(v)


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def _between(params, outputs, count, own, c, y, par, tc, h):
    """After a step: take in its peaks, hand lanes on, settle their modes. True while there is work."""
    order = tc.shape[1] - 1
    for l in range(LANES):
        own[PART, l] = min(h[l], END - own[TIME, l])
        own[SCALE, l] = 1.0
        own[BEND, l] = par[SPRING_LAW + 3, l] * SHORT_ARM - par[SPRING_LAW + 1, l] * LONG_ARM
        for row in range(18):
            own[ABOVE + row, l] = 0.0
    for k in range(order + 1):
        first, slope, row = 1.0 * (k == 0), 1.0 * k * (k > 1), SERIES + 6 * k
        for l in range(LANES):
            s = own[SCALE, l]
            adult = first * par[TIE_LAW, l] + par[TIE_LAW + 1, l] * tc[XA, k, l] + par[TIE_LAW + 2, l] * tc[VA, k, l]
            child = first * par[TIE_LAW + 3, l] + par[TIE_LAW + 4, l] * tc[XC, k, l] + par[TIE_LAW + 5, l] * tc[VC, k, l]
            push = first * (par[SPRING_LAW, l] + par[SPRING_LAW + 2, l])
            push += (par[SPRING_LAW + 1, l] + par[SPRING_LAW + 3, l]) * (tc[X1, k, l] - tc[XB, k, l])
            push += own[BEND, l] * tc[TAN, k, l]
            _take(own, row, 0, l, slope, s / ADULT * adult)
            _take(own, row, 1, l, slope, s * tc[XA, k, l])
            _take(own, row, 2, l, slope, s / CHILD * child)
            _take(own, row, 3, l, slope, s * tc[XC, k, l])
            _take(own, row, 4, l, slope, s * par[0, l] * push)
            _take(own, row, 5, l, slope, s * tc[X1, k, l])
            own[SCALE, l] = s * own[PART, l]
    for which in range(6):
        for l in range(LANES):
            start, end, best = own[SERIES + which, l], own[SUM + which, l], own[BEST + which, l]
            best = max(best, max(start, end))
            own[BEST + which, l] = best
            own[ABOVE + which, l] += start - abs(start) - best
            own[WOBBLE + which, l] -= abs(own[SERIES + 6 + which, l])
        for l in range(LANES):
            if own[ABOVE + which, l] > 0.0 and own[WOBBLE + which, l] > 0.0:
                for k in range(order + 1):
                    c[k] = own[SERIES + 6 * k + which, l]
                own[BEST + which, l] = _maximum(c, order, own[BEST + which, l])
    for l in range(LANES):
        own[TIME, l] += h[l]
        far, near = LONG_ARM * y[TAN, l], SHORT_ARM * y[TAN, l]
        gap1, gap2 = y[X1, l] - y[XB, l], y[X2, l] + y[XB, l]
        least = 1.0
        for e, d in enumerate((gap1 - far, gap1 + near, gap2 - far, gap2 + near)):
            g = SPRING_GUARD + 4 * e
            least = min(least, par[g, l] + par[g + 1, l] * d, par[g + 2, l] + par[g + 3, l] * d)
        for i in range(TIES):
            x, v, g = y[XA + 2 * i, l], y[VA + 2 * i, l], TIE_GUARD + 6 * i
            least = min(least, par[g, l] + par[g + 1, l] * x + par[g + 2, l] * v)
            least = min(least, par[g + 3, l] + par[g + 4, l] * x + par[g + 5, l] * v)
        own[LEAST, l] = least
    for l in range(LANES):
        crash = count[CRASH + l]
        if not own[TIME, l] < END:
            if crash >= 0:
                outputs[crash] = own[BEST : BEST + 6, l]
                if not own[TIME, l] >= END:
                    outputs[crash] = np.nan
                count[1] += 1
            _start(params, outputs, count, own, y, par, l)
        elif own[LEAST, l] < 1e-6:
            _settle(params[max(crash, 0)], own, y, par, l)
    return count[1] < len(params)


class Heyoka:
    """P1 on one thread."""

    def __init__(self, lanes: int = LANES, tolerance: float = TOLERANCE) -> None:
        self.integrator = _integrator(lanes, tolerance)
        self.lanes = lanes

    def solve(self, params: Floats) -> Floats:
        """Outcomes (N, 6) of parameter sets (N, 12)."""
        ta = self.integrator
        outputs = np.zeros((len(params), 6))
        count = np.zeros(CRASH + LANES, dtype=np.int64)
        own, c = np.zeros((ROWS, LANES)), np.zeros(40)
        y, par, tc, h = ta.state, ta.pars, ta.tc, ta.last_h
        for l in range(self.lanes):
            _start(params, outputs, count, own, y, par, l)
        self.steps = 0
        step = ta.step
        work = True
        while work:
            step(write_tc=True)
            self.steps += 1
            work = _between(params, outputs, count, own, c, y, par, tc, h)
        return outputs
