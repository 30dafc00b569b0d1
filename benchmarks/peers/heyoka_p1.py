"""P1 by heyoka: Taylor series in batches, events located by the integrator, modes and peaks by hand.

What makes it fast. The force laws are linear in each mode, and their coefficients are runtime parameters of a lane, so
that one compiled integrator serves every mode. `tan(theta)` is a state in place of theta, so that the right-hand side
is polynomial. Occupants move relative to what they are tied to, so that guards are linear in the states. A lane whose
crash is over takes the next one at once. Nothing depends on time, so that a step may run past the end, and its overhang
is left out. All work between two steps is one compiled function, which needs of the integrator only its arrays.

What makes it right. Modes are set from the state and not from the event that was reported, so that coincident events
(equal slacks) are all taken. A mode is left a little beyond its bound: a guard that starts at zero makes heyoka lose
the root that follows in the same step, silently. No event has a cooldown, which would hide one that comes soon after
another.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import heyoka as hy
import numba
import numpy as np
from numpy.typing import NDArray

from benchmarks.p1_reference import (
    ADULT,
    BAR_INERTIA,
    BAR_MASS,
    CA,
    CHILD,
    CLIPPED,
    END,
    FIRST,
    K1,
    K2,
    KA,
    KNEE,
    LONG_ARM,
    M1,
    M2,
    OFF,
    OPEN,
    SEAT,
    SECOND,
    SHORT_ARM,
    SLACK,
    SPEED,
    SPRINGS,
    STATES,
    TAUT,
    TIES,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

TOLERANCE = 1e-9  # 1e-7 is hardly faster: most steps end at events
LANES = 16  # of 8, 16, 24, 32 and 48 the fastest on AVX-512, within noise

# states; the ties' are relative: adult to vehicle, child to seat, seat to vehicle
X1, V1, X2, V2, XB, VB, TAN, OM, XA, VA, XC, VC, XS, VS = range(STATES)

# runtime parameters of a lane: two inverse masses; for each spring, its force as intercept and stiffness; for each tie,
# its pull as intercept, stiffness, damping; then two guards for each, written alike
SPRING, TIE = 2, 2 + 2 * SPRINGS
SPRING_GUARD = TIE + 3 * TIES
TIE_GUARD = SPRING_GUARD + 4 * SPRINGS
PARAMETERS = TIE_GUARD + 6 * TIES

GRACE = 1e-13  # m: how far beyond its bound a mode is left
DUE = 0.5 * GRACE

# rows of what a lane keeps: time, part of the step that counts, and its running power; accelerations as sums of states;
# peaks; bounds of the six outcomes' series; coefficients just read
TIME, PART, POWER, SUMS, PEAK, ABOVE, LAST, WOBBLE, READ = 0, 1, 2, 3, 12, 18, 24, 30, 36
ROWS = READ + 7
NEXT, DONE, CRASH = 0, 1, 2  # counts: the next crash, crashes done; then the crash in each lane, -1 for none

_Function = TypeVar("_Function", bound=Callable[..., Any])


def _jit(function: _Function) -> _Function:
    decorate = numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
    return cast("_Function", decorate(function))


class Heyoka:
    """P1 on one thread; compiled by heyoka when made, and by numba when first used."""

    def __init__(self, *, tolerance: float = TOLERANCE) -> None:
        self.integrator = _integrator(tolerance)

    def solve(self, params: Floats) -> Floats:
        """Outcomes (N, 6) of parameter sets (N, 12); a crash that could not be solved is a row of NaN."""
        integrator = self.integrator
        outputs = np.empty((len(params), 6))
        counts = np.zeros(CRASH + LANES, dtype=np.int64)
        modes = np.zeros((SPRINGS + TIES, LANES), dtype=np.int64)
        own, series = np.zeros(ROWS * LANES), np.zeros((integrator.order + 1, 6 * LANES))
        state, par, coefficients, length = integrator.state, integrator.pars, integrator.tc, integrator.last_h
        for j in range(LANES):
            _start(params, counts, modes, own, state, par, j)
        step, going = integrator.step, True
        while going:
            step(write_tc=True)
            going = _between(params, outputs, counts, modes, own, series, state, par, coefficients, length)
        return outputs


def _integrator(tolerance: float) -> Any:
    """P1 with its laws left open; two guards for each law are terminal events, which fire as they fall below zero."""
    names = ("x1", "v1", "x2", "v2", "xb", "vb", "tan", "om", "xa", "va", "xc", "vc", "xs", "vs")
    x1, v1, x2, v2, xb, vb, tan, om, xa, va, xc, vc, xs, vs = hy.make_vars(*names)
    par = hy.par
    far, near = LONG_ARM * tan, SHORT_ARM * tan
    springs = (x1 - xb - far, x1 - xb + near, x2 + xb - far, x2 + xb + near)
    ties = ((xa, va), (xc, vc), (xs, vs))

    def spring(at: int, d: Any) -> Any:
        return par[at] + par[at + 1] * d

    def tie(at: int, x: Any, v: Any) -> Any:
        return par[at] + par[at + 1] * x + par[at + 2] * v

    f11, f12, f21, f22 = (spring(SPRING + 2 * e, d) for e, d in enumerate(springs))
    adult, child, seat = (tie(TIE + 3 * i, x, v) for i, (x, v) in enumerate(ties))
    brake, seat_push = (f11 + f12) * par[0], (child - seat) / SEAT
    system = [
        (x1, v1),
        (v1, -brake),
        (x2, v2),
        (v2, -(f21 + f22) * par[1]),
        (xb, vb),
        (vb, (f11 + f12 - f21 - f22) / BAR_MASS),
        (tan, (1.0 + tan * tan) * om),
        (om, (f11 + f21) * (LONG_ARM / BAR_INERTIA) - (f12 + f22) * (SHORT_ARM / BAR_INERTIA)),
        (xa, va),
        (va, brake - adult / ADULT),
        (xc, vc),
        (vc, -child / CHILD - seat_push),
        (xs, vs),
        (vs, brake + seat_push),
    ]
    guards = [spring(SPRING_GUARD + 4 * e + n, d) for e, d in enumerate(springs) for n in (0, 2)]
    guards += [tie(TIE_GUARD + 6 * i + n, x, v) for i, (x, v) in enumerate(ties) for n in (0, 3)]
    falling = hy.event_direction.negative
    return hy.taylor_adaptive_batch(
        system,
        np.zeros((STATES, LANES)),
        tol=tolerance,
        pars=np.zeros((PARAMETERS, LANES)),
        t_events=[hy.t_event_batch(guard, direction=falling, cooldown=0.0) for guard in guards],
        high_accuracy=False,
        compact_mode=False,
    )


@_jit
def _start(params: Floats, counts: Ints, modes: Ints, own: Floats, state: Floats, par: Floats, j: int) -> None:
    """Put the next crash in lane j; when there is none, the first again, whose result is left."""
    more = counts[NEXT] < len(params)
    crash = counts[NEXT] if more else 0
    counts[CRASH + j] = crash if more else -1
    counts[NEXT] += 1 if more else 0
    p = params[crash]
    state[:, j] = 0.0
    state[V1, j] = state[V2, j] = p[SPEED]
    par[0, j], par[1, j] = 1.0 / p[M1], 1.0 / p[M2]
    for e in range(SPRINGS):  # all touch, and close at the first instant
        modes[e, j] = FIRST
        _set_spring(p, FIRST, par, e, j)
    for i in range(TIES):
        modes[SPRINGS + i, j] = OPEN
        _set_tie(0.0, 0.0, OPEN, par, i, j)
    own[TIME * LANES + j] = 0.0
    for which in range(6):
        own[(PEAK + which) * LANES + j] = 0.0


@_jit
def _set_spring(p: Floats, mode: int, par: Floats, e: int, j: int) -> None:
    """The force and the guards of spring e in lane j."""
    law, guard = SPRING + 2 * e, SPRING_GUARD + 4 * e
    par[guard + 2, j], par[guard + 3, j] = 1.0, 0.0
    if mode == OFF:
        par[law, j], par[law + 1, j] = 0.0, 0.0
        par[guard, j], par[guard + 1, j] = GRACE, -1.0
    elif mode == FIRST:
        par[law, j], par[law + 1, j] = 0.0, p[K1]
        par[guard, j], par[guard + 1, j] = GRACE, 1.0
        par[guard + 2, j], par[guard + 3, j] = p[KNEE] + GRACE, -1.0
    else:
        par[law, j], par[law + 1, j] = (p[K1] - p[K2]) * p[KNEE], p[K2]
        par[guard, j], par[guard + 1, j] = GRACE - p[KNEE], 1.0


@_jit
def _set_tie(k: float, c: float, mode: int, par: Floats, i: int, j: int) -> None:
    """The pull and the guards of tie i in lane j."""
    law, guard = TIE + 3 * i, TIE_GUARD + 6 * i
    par[law : law + 3, j] = 0.0
    par[guard : guard + 6, j] = 0.0
    par[guard + 3, j] = 1.0
    if mode == OPEN:
        par[guard, j], par[guard + 1, j] = GRACE + SLACK, -1.0
    elif mode == TAUT:
        par[law, j], par[law + 1, j], par[law + 2, j] = -k * SLACK, k, c
        par[guard, j], par[guard + 1, j], par[guard + 2, j] = GRACE * (k + c) - k * SLACK, k, c
    else:
        par[guard, j], par[guard + 1, j] = GRACE - SLACK, 1.0
        par[guard + 3, j], par[guard + 4, j], par[guard + 5, j] = GRACE * (k + c) + k * SLACK, -k, -c


@_jit
def _settle(p: Floats, modes: Ints, y: Floats, par: Floats, j: int) -> None:
    """Set every mode of lane j that is due, with its force and guards."""
    far, near = LONG_ARM * y[TAN, j], SHORT_ARM * y[TAN, j]
    gap1, gap2 = y[X1, j] - y[XB, j], y[X2, j] + y[XB, j]
    for e, d in enumerate((gap1 - far, gap1 + near, gap2 - far, gap2 + near)):
        old = modes[e, j]
        new = _spring_mode(old, d, p[KNEE])
        if new != old:
            modes[e, j] = new
            _set_spring(p, new, par, e, j)
    for i in range(TIES):
        x, v = y[XA + 2 * i, j] - SLACK, y[VA + 2 * i, j]
        k, c = p[KA + 2 * i], p[CA + 2 * i]
        old = modes[SPRINGS + i, j]
        new = _tie_mode(old, x, k * x + c * v, DUE * (k + c))
        if new != old:
            modes[SPRINGS + i, j] = new
            _set_tie(k, c, new, par, i, j)


@_jit
def _spring_mode(old: int, d: float, knee: float) -> int:
    new = old
    if old == OFF:
        new = FIRST if d > DUE else OFF
    elif old == SECOND:
        new = FIRST if d < knee - DUE else SECOND
    elif d < -DUE:
        new = OFF
    elif d > knee + DUE:
        new = SECOND
    return new


@_jit
def _tie_mode(old: int, x: float, pull: float, due: float) -> int:
    """x: how far beyond the slack."""
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
    return new


@_jit
def _between(
    params: Floats,
    outputs: Floats,
    counts: Ints,
    modes: Ints,
    own: Floats,
    series: Floats,
    state: Floats,
    par: Floats,
    coefficients: Floats,
    length: Floats,
) -> bool:
    """After a step: take in its peaks, pass lanes on, settle their modes. True while there is work."""
    _prepare(own, par, length)
    _series(own, series, coefficients)
    _raise_peaks(own, series)
    for j in range(LANES):
        own[TIME * LANES + j] += length[j]
        time, crash = own[TIME * LANES + j], counts[CRASH + j]
        if time < END:
            _settle(params[max(crash, 0)], modes, state, par, j)
            continue
        if crash >= 0:
            counts[DONE] += 1
            for which in range(6):
                outputs[crash, which] = own[(PEAK + which) * LANES + j] if time >= END else np.nan
        _start(params, counts, modes, own, state, par, j)
    return bool(counts[DONE] < len(params))


@_jit
def _prepare(own: Floats, par: Floats, length: Floats) -> None:
    """How much of each lane's step counts; adult, child and vehicle 1's deceleration as sums of states."""
    for j in range(LANES):
        left = END - own[TIME * LANES + j]
        own[PART * LANES + j] = min(left, length[j])
        own[POWER * LANES + j] = 1.0
        for i in range(3):
            own[(SUMS + i) * LANES + j] = par[TIE + i, j] * (1.0 / ADULT)
            own[(SUMS + 3 + i) * LANES + j] = par[TIE + 3 + i, j] * (1.0 / CHILD)
        inverse_mass, k11, k12 = par[0, j], par[SPRING + 1, j], par[SPRING + 3, j]
        own[(SUMS + 6) * LANES + j] = inverse_mass * (par[SPRING, j] + par[SPRING + 2, j])
        own[(SUMS + 7) * LANES + j] = inverse_mass * (k11 + k12)
        own[(SUMS + 8) * LANES + j] = inverse_mass * (SHORT_ARM * k12 - LONG_ARM * k11)
    for i in range(ABOVE * LANES, (ABOVE + 18) * LANES):
        own[i] = 0.0


@_jit
def _series(own: Floats, series: Floats, coefficients: Floats) -> None:
    """The outcomes' series over the part that counts, scaled to [0, 1], and their bounds.

    Lanes run side by side: one flat array and constant offsets, so that the loop becomes vector instructions.
    """
    for k in range(coefficients.shape[1]):
        first, slope, out = 1.0 * (k == 0), 1.0 * k * (k > 1), series[k]
        for row, name in enumerate((X1, XB, TAN, XA, VA, XC, VC)):
            source, target = coefficients[name, k], own[(READ + row) * LANES : (READ + row + 1) * LANES]
            for j in range(LANES):
                target[j] = source[j]
        for j in range(LANES):
            power = own[POWER * LANES + j]
            x1, tan = own[READ * LANES + j], own[(READ + 2) * LANES + j]
            gap = x1 - own[(READ + 1) * LANES + j]
            xa, va = own[(READ + 3) * LANES + j], own[(READ + 4) * LANES + j]
            xc, vc = own[(READ + 5) * LANES + j], own[(READ + 6) * LANES + j]
            adult = first * own[SUMS * LANES + j] + own[(SUMS + 1) * LANES + j] * xa + own[(SUMS + 2) * LANES + j] * va
            child = own[(SUMS + 4) * LANES + j] * xc + own[(SUMS + 5) * LANES + j] * vc
            child += first * own[(SUMS + 3) * LANES + j]
            brake = own[(SUMS + 7) * LANES + j] * gap + own[(SUMS + 8) * LANES + j] * tan
            brake += first * own[(SUMS + 6) * LANES + j]
            _note(own, out, 0, j, slope, power * adult)
            _note(own, out, 1, j, slope, power * xa)
            _note(own, out, 2, j, slope, power * child)
            _note(own, out, 3, j, slope, power * xc)
            _note(own, out, 4, j, slope, power * brake)
            _note(own, out, 5, j, slope, power * x1)
            own[POWER * LANES + j] = power * own[PART * LANES + j]


@_jit
def _note(own: Floats, out: Floats, which: int, j: int, slope: float, v: float) -> None:
    """Write down a coefficient of an outcome's series, and add it to the value at the end and to the bounds."""
    out[which * LANES + j] = v
    own[(LAST + which) * LANES + j] += v
    own[(ABOVE + which) * LANES + j] += abs(v)
    own[(WOBBLE + which) * LANES + j] += slope * abs(v)


@_jit
def _raise_peaks(own: Floats, series: Floats) -> None:
    """Take in both ends of every series; look inside only where it can rise above them and the peak so far."""
    for i in range(6 * LANES):
        start, end, best = series[0, i], own[LAST * LANES + i], own[PEAK * LANES + i]
        best = max(best, start, end)
        own[PEAK * LANES + i] = best
        own[ABOVE * LANES + i] += start - abs(start) - best
        own[WOBBLE * LANES + i] -= abs(series[1, i])
    for i in range(6 * LANES):
        if own[ABOVE * LANES + i] > 0.0 and own[WOBBLE * LANES + i] > 0.0:
            own[PEAK * LANES + i] = _maximum(series[:, i], own[PEAK * LANES + i])


@_jit
def _maximum(c: Floats, best: float) -> float:
    """The greater of `best` and the maxima of sum c[k] u^k inside 0 <= u <= 1.

    The step is short against every period, so that an eighth of it holds no more than one turn.
    """
    left, at_left = 0.0, c[1]
    for part in range(1, 9):
        right = 0.125 * part
        at_right = _slope(c, right)
        if at_left > 0.0 >= at_right:
            best = max(best, _value(c, _turn(c, left, right, at_left, at_right)))
        left, at_left = right, at_right
    return best


@_jit
def _turn(c: Floats, a: float, b: float, at_a: float, at_b: float) -> float:
    """Where the slope passes zero between a and b, by Illinois' rule; a peak is flat, so 1e-9 beside it will do."""
    enough = 1e-9 * (abs(at_a) + abs(at_b))
    kept, u = 0, b
    for _ in range(60):
        u = (a * at_b - b * at_a) / (at_b - at_a)
        here = _slope(c, u)
        if abs(here) <= enough or b - a < 1e-9:
            break
        if here > 0.0:
            a, at_a = u, here
            at_b *= 0.5 if kept == 1 else 1.0
            kept = 1
        else:
            b, at_b = u, here
            at_a *= 0.5 if kept == -1 else 1.0
            kept = -1
    return u


@_jit
def _value(c: Floats, u: float) -> float:
    total = 0.0
    for k in range(len(c) - 1, -1, -1):
        total = total * u + c[k]
    return total


@_jit
def _slope(c: Floats, u: float) -> float:
    total = 0.0
    for k in range(len(c) - 1, 0, -1):
        total = total * u + k * c[k]
    return total
