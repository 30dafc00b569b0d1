"""Benchmark problem P1 by a method of its own: what the product's solver is checked against, set by set.

P1 is an offset head-on collision of two cars with an adult, and a child in a seat, in vehicle 1: 14 states, about 16
events in 0.2 s. Nothing here is shared with the product: absolute coordinates, Gragg-Bulirsch-Stoer extrapolation
(order 10) with a fixed step, and the force laws, which have no memory, picked anew from the state and its derivative at
each event.

How events are found. Each law has guards, functions that are positive while its formula holds. A step is short against
every period of the system (0.4 ms against 20 ms), so that the cubic through a guard's values and slopes at both ends
shows every dip below zero; one that comes near zero is looked at again at its true lowest point. The root itself is
found on the trajectory, by taking the step anew with other lengths, not on an interpolant. So are peaks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Seven = tuple[float, float, float, float, float, float, float]  # a value for each spring and each tie

OUTCOMES = (
    "adult |acceleration| [m/s2]",
    "adult excursion [m]",
    "child |acceleration| [m/s2]",
    "child displacement relative to the seat [m]",
    "vehicle 1 |acceleration| [m/s2]",
    "vehicle 1 displacement [m]",
)

# state: x1 v1 x2 v2 xb vb th om xa va xc vc xs vs
STATES = 14
SPRINGS = 4  # 1 right, 1 left, 2 right, 2 left
TIES = 3  # adult, harness, seat
GUARDS = 2 * (SPRINGS + TIES)

# parameters, in the order of the benchmark
M1, M2, K1, K2, KNEE, KA, CA, KC, CC, KS, CS, SPEED = range(12)
WIDTH, HALF_OFFSET, BAR_MASS, BAR_INERTIA = 1.1, 0.443, 40.0, 157.0
ADULT, CHILD, SEAT, SLACK = 80.0, 18.0, 5.0, 0.005
LONG_ARM, SHORT_ARM = WIDTH / 2.0 + HALF_OFFSET, WIDTH / 2.0 - HALF_OFFSET
END = 0.2

NOMINAL = np.array([1500.0, 1500.0, 118.2e3, 465e3, 0.356, 98.1e3, 2801.0, 49e3, 939.0, 50e3, 500.0, 13.33])

# modes: a spring is off, on its first or on its second piece; a tie is open, taut, or clipped (it cannot push)
OFF, FIRST, SECOND = 0, 1, 2
OPEN, TAUT, CLIPPED = 0, 1, 2

STEP = 4e-4  # s
COLUMNS = 5  # of the extrapolation: order 10
FAR = 1e300  # a guard that cannot be reached
SHALLOW_GAP = 1e-14  # m: what rounding does to a gap
SHALLOW_FORCE = 1e-9  # N: what it does to a force of 1e5 N
TURN_ENOUGH = 1e-10  # s: a peak is flat, so that 1e-10 s beside it is 1e-16 of it below
MAX_EVENTS = 500

STATUS_OK, STATUS_TOO_MANY_EVENTS, STATUS_UNSETTLED = 0, 1, 2

# what can be asked of a moment on the trajectory
GUARD, GUARD_SLOPE, OUTCOME_PEAK, OUTCOME_SLOPE = 0, 1, 2, 3

_Function = TypeVar("_Function", bound=Callable[..., Any])


def _jit(function: _Function) -> _Function:
    # numba's cache knows a file by its path but its functions by the module's name: one cached under another name fails
    cache = __name__ == "benchmarks.p1_reference"
    return cast("_Function", numba.njit(cache=cache, nogil=True, error_model="numpy")(function))


class Step(NamedTuple):
    """A step about to be taken, and room to try it with other lengths."""

    p: Floats
    mode: Ints
    law: Floats  # (8, 3) each element's force as intercept, stiffness, damping; then 1 / M1, 1 / M2
    y: Floats  # the state where it starts
    table: Floats  # (COLUMNS + 4, STATES)
    there: Floats  # the state where it ends
    dy: Floats
    value: Floats
    slope: Floats


@_jit
def _gaps(y: Floats) -> tuple[Seven, Seven]:
    """Deflections (of ties: beyond the slack) and their rates: springs 1 right, 1 left, 2 right, 2 left; the ties."""
    tangent = np.tan(y[6])
    turn = (1.0 + tangent * tangent) * y[7]
    gap = (
        y[0] - y[4] - LONG_ARM * tangent,
        y[0] - y[4] + SHORT_ARM * tangent,
        y[2] + y[4] - LONG_ARM * tangent,
        y[2] + y[4] + SHORT_ARM * tangent,
        y[8] - y[0] - SLACK,
        y[10] - y[12] - SLACK,
        y[12] - y[0] - SLACK,
    )
    rate = (
        y[1] - y[5] - LONG_ARM * turn,
        y[1] - y[5] + SHORT_ARM * turn,
        y[3] + y[5] - LONG_ARM * turn,
        y[3] + y[5] + SHORT_ARM * turn,
        y[9] - y[1],
        y[11] - y[13],
        y[13] - y[1],
    )
    return gap, rate


@_jit
def _forces(law: Floats, gap: Seven, rate: Seven) -> Seven:
    return (
        law[0, 0] + law[0, 1] * gap[0],
        law[1, 0] + law[1, 1] * gap[1],
        law[2, 0] + law[2, 1] * gap[2],
        law[3, 0] + law[3, 1] * gap[3],
        law[4, 1] * gap[4] + law[4, 2] * rate[4],
        law[5, 1] * gap[5] + law[5, 2] * rate[5],
        law[6, 1] * gap[6] + law[6, 2] * rate[6],
    )


@_jit
def _set_law(p: Floats, mode: Ints, law: Floats) -> None:
    """Fill `law` (see `Step`) for these modes."""
    law[:] = 0.0
    law[7, 0], law[7, 1] = 1.0 / p[M1], 1.0 / p[M2]
    for e in range(SPRINGS):
        if mode[e] == FIRST:
            law[e, 1] = p[K1]
        elif mode[e] == SECOND:
            law[e, 0], law[e, 1] = (p[K1] - p[K2]) * p[KNEE], p[K2]
    for i in range(TIES):
        if mode[SPRINGS + i] == TAUT:
            law[SPRINGS + i, 1], law[SPRINGS + i, 2] = p[KA + 2 * i], p[CA + 2 * i]


@_jit
def _slope(law: Floats, y: Floats, dy: Floats) -> None:
    """Derivative of the state."""
    gap, rate = _gaps(y)
    f = _forces(law, gap, rate)
    for i in range(0, STATES, 2):
        dy[i] = y[i + 1]
    dy[1] = -(f[0] + f[1]) * law[7, 0]
    dy[3] = -(f[2] + f[3]) * law[7, 1]
    dy[5] = (f[0] + f[1] - f[2] - f[3]) * (1.0 / BAR_MASS)
    dy[7] = (LONG_ARM * (f[0] + f[2]) - SHORT_ARM * (f[1] + f[3])) * (1.0 / BAR_INERTIA)
    dy[9] = -f[4] * (1.0 / ADULT)
    dy[11] = -f[5] * (1.0 / CHILD)
    dy[13] = (f[5] - f[6]) * (1.0 / SEAT)


@_jit
def _advance(law: Floats, y: Floats, h: float, table: Floats, out: Floats) -> None:
    """One step of length `h` from `y`: Gragg's midpoint rule with 2, 4, 6, ... parts, extrapolated to parts of zero."""
    before, now, dy, start = table[COLUMNS], table[COLUMNS + 1], table[COLUMNS + 2], table[COLUMNS + 3]
    _slope(law, y, start)
    for j in range(COLUMNS):
        parts = 2 * (j + 1)
        part = h / parts
        for i in range(STATES):
            before[i] = y[i]
            now[i] = y[i] + part * start[i]
        for _ in range(parts - 1):
            _slope(law, now, dy)
            for i in range(STATES):
                after = before[i] + 2.0 * part * dy[i]
                before[i] = now[i]
                now[i] = after
        _slope(law, now, dy)
        for i in range(STATES):
            table[j, i] = 0.5 * (before[i] + now[i] + part * dy[i])
        # the last row of Neville's scheme in the squares of the parts, kept in place
        for k in range(j - 1, -1, -1):
            ratio = (j + 1.0) / (k + 1.0)
            weight = 1.0 / (ratio * ratio - 1.0)
            for i in range(STATES):
                table[k, i] = table[k + 1, i] + weight * (table[k + 1, i] - table[k, i])
    for i in range(STATES):
        out[i] = table[0, i]


@_jit
def _tie_acceleration(tie: int, dy: Floats) -> float:
    if tie == 0:
        return float(dy[9] - dy[1])
    if tie == 1:
        return float(dy[11] - dy[13])
    return float(dy[13] - dy[1])


@_jit
def _guards(p: Floats, mode: Ints, y: Floats, dy: Floats, value: Floats, slope: Floats) -> None:
    """Two guards for each law, positive while its mode holds, and their time derivatives."""
    gap, rate = _gaps(y)
    for e in range(SPRINGS + TIES):
        low, high = 2 * e, 2 * e + 1
        value[low], slope[low], value[high], slope[high] = FAR, 0.0, FAR, 0.0
        if mode[e] == OFF:  # and OPEN
            value[high], slope[high] = -gap[e], -rate[e]
        elif e < SPRINGS:
            knee = p[KNEE]
            if mode[e] == FIRST:
                value[low], slope[low] = gap[e], rate[e]
                value[high], slope[high] = knee - gap[e], -rate[e]
            else:
                value[low], slope[low] = gap[e] - knee, rate[e]
        else:
            i = e - SPRINGS
            k, c = p[KA + 2 * i], p[CA + 2 * i]
            pull, pull_slope = k * gap[e] + c * rate[e], k * rate[e] + c * _tie_acceleration(i, dy)
            if mode[e] == TAUT:
                value[low], slope[low] = pull, pull_slope
            else:
                value[low], slope[low] = gap[e], rate[e]
                value[high], slope[high] = -pull, -pull_slope


@_jit
def _side(value: float, slope: float, curvature: float, shallow: float) -> bool:
    """Is the quantity above zero just after now?"""
    if abs(value) > shallow:
        return value > 0.0
    if abs(slope) > 1e-9 * (1.0 + abs(curvature)):
        return slope > 0.0
    return curvature > 0.0


@_jit
def _settle(p: Floats, mode: Ints, y: Floats, law: Floats, dy: Floats) -> bool:
    """Set every mode from the state and its derivative; False if no set of modes agrees with itself."""
    gap, rate = _gaps(y)
    for _ in range(12):
        _set_law(p, mode, law)
        _slope(law, y, dy)
        steady = True
        tangent = np.tan(y[6])
        bend = (1.0 + tangent * tangent) * (dy[7] + 2.0 * tangent * y[7] * y[7])
        for e in range(SPRINGS):
            push = dy[1] - dy[5] if e < 2 else dy[3] + dy[5]
            push += -LONG_ARM * bend if e % 2 == 0 else SHORT_ARM * bend
            new = OFF
            if _side(gap[e], rate[e], push, SHALLOW_GAP):
                new = SECOND if _side(gap[e] - p[KNEE], rate[e], push, SHALLOW_GAP) else FIRST
            steady = steady and new == mode[e]
            mode[e] = new
        for i in range(TIES):
            e = SPRINGS + i
            k, c = p[KA + 2 * i], p[CA + 2 * i]
            pull = _tie_acceleration(i, dy)
            new = OPEN
            if _side(gap[e], rate[e], pull, SHALLOW_GAP):
                # the pull's second derivative is left out: both zero at once is a graze, and either mode is right
                taut = _side(k * gap[e] + c * rate[e], k * rate[e] + c * pull, 0.0, SHALLOW_FORCE)
                new = TAUT if taut else CLIPPED
            steady = steady and new == mode[e]
            mode[e] = new
        if steady:
            return True
    return False


@_jit
def _hermite(h: float, g0: float, s0: float, g1: float, s1: float, at: float) -> float:
    u = at / h
    w = 1.0 - u
    return w * w * (g0 * (1.0 + 2.0 * u) + s0 * h * u) + u * u * (g1 * (1.0 + 2.0 * w) - s1 * h * w)


@_jit
def _shallow(which: int, mode: Ints) -> float:
    """How far below zero a guard may be by rounding alone."""
    element = which // 2
    if element < SPRINGS or mode[element] == OPEN:
        return SHALLOW_GAP
    is_force = which % 2 == (0 if mode[element] == TAUT else 1)
    return SHALLOW_FORCE if is_force else SHALLOW_GAP


@_jit
def _bounds(h: float, g0: float, s0: float, g1: float, s1: float) -> tuple[float, float]:
    """Between which values the cubic through both ends stays: its Bernstein coefficients."""
    inner0, inner1 = g0 + s0 * h / 3.0, g1 - s1 * h / 3.0
    return min(g0, inner0, inner1, g1), max(g0, inner0, inner1, g1)


@_jit
def _near(mode: Ints, which: int, g0: float, g1: float) -> float:
    """Where the cubic of a guard is below this, the trajectory is looked at."""
    return 1e4 * _shallow(which, mode) + 1e-3 * min(abs(g0), abs(g1))


@_jit
def _turning_points(h: float, g0: float, s0: float, g1: float, s1: float) -> tuple[float, float]:
    """Where the slope of the cubic through both ends is zero, in order; outside (0, h) is written as h."""
    # slope(u) = a u^2 + b u + c, u = t / h, the slopes times h
    a = 6.0 * (g0 - g1) + 3.0 * h * (s0 + s1)
    b = -6.0 * (g0 - g1) - h * (4.0 * s0 + 2.0 * s1)
    c = h * s0
    square = b * b - 4.0 * a * c
    if square < 0.0:
        return h, h
    q = -0.5 * (b + (np.sqrt(square) if b >= 0.0 else -np.sqrt(square)))
    u1 = q / a if a != 0.0 else 2.0
    u2 = c / q if q != 0.0 else 2.0
    u1 = u1 if 0.0 < u1 < 1.0 else 1.0
    u2 = u2 if 0.0 < u2 < 1.0 else 1.0
    return h * min(u1, u2), h * max(u1, u2)


@_jit
def _outcomes(law: Floats, y: Floats, dy: Floats, value: Floats, slope: Floats) -> None:
    """The six quantities whose maxima are asked for, and their time derivatives."""
    gap, rate = _gaps(y)
    value[0], value[2], value[4] = -dy[9], -dy[11], -dy[1]  # no force pushes an occupant on, or a car
    slope[0] = (law[4, 1] * rate[4] + law[4, 2] * _tie_acceleration(0, dy)) / ADULT
    slope[2] = (law[5, 1] * rate[5] + law[5, 2] * _tie_acceleration(1, dy)) / CHILD
    slope[4] = (law[0, 1] * rate[0] + law[1, 1] * rate[1]) * law[7, 0]
    value[1], slope[1] = gap[4] + SLACK, rate[4]
    value[3], slope[3] = gap[5] + SLACK, rate[5]
    value[5], slope[5] = y[0], y[1]


@_jit
def _ask(step: Step, at: float, what: int, which: int) -> float:
    """A guard, an outcome, or the slope of one, a time `at` into the step: on the trajectory itself."""
    _advance(step.law, step.y, at, step.table, step.there)
    _slope(step.law, step.there, step.dy)
    if what <= GUARD_SLOPE:
        _guards(step.p, step.mode, step.there, step.dy, step.value, step.slope)
    else:
        _outcomes(step.law, step.there, step.dy, step.value, step.slope)
    if what in (GUARD, OUTCOME_PEAK):
        return float(step.value[which])
    return float(step.slope[which])


@_jit
def _root(step: Step, a: float, b: float, at_a: float, at_b: float, what: int, which: int, enough: float) -> float:
    """Where `_ask` changes sign between a and b: Illinois' rule, halving where that is slow.

    A guard is followed to a value of `enough`, a slope to a time of it.
    """
    last, kept = -1.0, 0
    for i in range(80):
        middle = (a * at_b - b * at_a) / (at_b - at_a) if i < 12 else 0.5 * (a + b)
        if not a < middle < b:
            middle = 0.5 * (a + b)
        if not a < middle < b or (what != GUARD and abs(middle - last) <= enough):
            return middle
        last = middle
        here = _ask(step, middle, what, which)
        if here == 0.0 or (what == GUARD and abs(here) <= enough):
            return middle
        if (here > 0.0) == (at_a > 0.0):
            a, at_a = middle, here
            at_b *= 0.5 if kept == 1 else 1.0
            kept = 1
        else:
            b, at_b = middle, here
            at_a *= 0.5 if kept == -1 else 1.0
            kept = -1
    return b


@_jit
def _falls(step: Step, h: float, ends: Floats, which: int) -> float:
    """When guard `which` falls below zero within the step, or FAR. `ends`: guards, slopes at both ends, in rows."""
    g0, s0, g1, s1 = ends[0, which], ends[1, which], ends[2, which], ends[3, which]
    shallow, near = _shallow(which, step.mode), _near(step.mode, which, g0, g1)
    turn1, turn2 = _turning_points(h, g0, s0, g1, s1)
    left = 0.0
    for right in (turn1, turn2, h):
        if right <= left or _hermite(h, g0, s0, g1, s1, right) > near:
            left = right
            continue
        low = right
        if right < h:  # a dip near zero: look at its true lowest point
            half = 0.25 * min(right, h - right)
            a, b = _ask(step, right - half, GUARD_SLOPE, which), _ask(step, right + half, GUARD_SLOPE, which)
            if a < 0.0 < b:
                low = _root(step, right - half, right + half, a, b, GUARD_SLOPE, which, TURN_ENOUGH)
        at_low = _ask(step, low, GUARD, which)
        if at_low < -shallow:
            at_left = g0 if left == 0.0 else _ask(step, left, GUARD, which)
            return _root(step, left, low, at_left, at_low, GUARD, which, shallow) if at_left > 0.0 else left
        left = right
    return FAR


@_jit
def _first_event(step: Step, h: float, ends: Floats) -> tuple[bool, float]:
    """Whether a guard falls below zero within the step, and the first time that one does (else `h`)."""
    first = FAR
    for which in range(GUARDS):
        g0, g1 = ends[0, which], ends[2, which]
        if g0 != FAR and _bounds(h, g0, ends[1, which], g1, ends[3, which])[0] <= _near(step.mode, which, g0, g1):
            first = min(first, _falls(step, h, ends, which))
    return first < FAR, min(first, h)


@_jit
def _raise_peaks(step: Step, h: float, ends: Floats, peaks: Floats) -> None:
    """Take in the step's largest outcomes. `ends`: outcomes and slopes at both ends, in rows."""
    for which in range(6):
        g0, s0, g1, s1 = ends[0, which], ends[1, which], ends[2, which], ends[3, which]
        peaks[which] = max(peaks[which], g0, g1)
        a, b, at_a, at_b = 0.0, h, s0, s1
        if _bounds(h, g0, s0, g1, s1)[1] <= peaks[which] * (1.0 + 1e-13):
            continue
        if s0 <= 0.0 or s1 >= 0.0:  # if there is a maximum, then inside, after a fall or before a rise
            first, second = _turning_points(h, g0, s0, g1, s1)
            top = first if _hermite(h, g0, s0, g1, s1, first) >= _hermite(h, g0, s0, g1, s1, second) else second
            a, b = 0.5 * top, 0.5 * (top + h)
            at_a, at_b = _ask(step, a, OUTCOME_SLOPE, which), _ask(step, b, OUTCOME_SLOPE, which)
        if at_a > 0.0 > at_b:
            at = _root(step, a, b, at_a, at_b, OUTCOME_SLOPE, which, TURN_ENOUGH)
            peaks[which] = max(peaks[which], _ask(step, at, OUTCOME_PEAK, which))


@_jit
def _prepared(p: Floats) -> Step:
    """The crash at first contact: all move at one speed but the bar, which stands."""
    y = np.zeros(STATES)
    y[1] = y[3] = y[9] = y[11] = y[13] = p[SPEED]
    mode = np.zeros(SPRINGS + TIES, dtype=np.int64)
    table, there, dy = np.empty((COLUMNS + 4, STATES)), np.empty(STATES), np.empty(STATES)
    return Step(p, mode, np.empty((8, 3)), y, table, there, dy, np.empty(GUARDS), np.empty(GUARDS))


@_jit
def _crash(p: Floats, length: float, peaks: Floats) -> int:
    step = _prepared(p)
    mode, law, y, table, dy = step.mode, step.law, step.y, step.table, step.dy
    y1 = np.empty(STATES)
    guards, outcomes = np.empty((4, GUARDS)), np.empty((4, 6))
    peaks[:] = 0.0
    time, events = 0.0, 0
    if not _settle(p, mode, y, law, dy):
        return STATUS_UNSETTLED
    while time < END:
        h = min(length, END - time)
        _slope(law, y, dy)
        _guards(p, mode, y, dy, guards[0], guards[1])
        _outcomes(law, y, dy, outcomes[0], outcomes[1])
        _advance(law, y, h, table, y1)
        _slope(law, y1, dy)
        _guards(p, mode, y1, dy, guards[2], guards[3])
        found, at = _first_event(step, h, guards)
        if found:
            _advance(law, y, at, table, y1)
            _slope(law, y1, dy)
        _outcomes(law, y1, dy, outcomes[2], outcomes[3])
        if at > 0.0:
            _raise_peaks(step, at, outcomes, peaks)
        y[:] = y1
        time = END if not found and h < length else time + at
        if found:
            events += 1
            if events > MAX_EVENTS:
                return STATUS_TOO_MANY_EVENTS
            if not _settle(p, mode, y, law, dy):
                return STATUS_UNSETTLED
    return STATUS_OK


@_jit
def _crashes(params: Floats, length: float, outputs: Floats, status: Ints) -> None:
    for i in range(params.shape[0]):
        status[i] = _crash(params[i], length, outputs[i])


def solve(params: ArrayLike, *, step: float = STEP) -> tuple[Floats, Ints]:
    """True maxima of the six outcomes of P1, to about 1e-12 relative.

    Parameters
    ----------
    params
        (N, 12) SI values in the order M1, M2, k1, k2, ds, ka, ca, kc, cc, ks, cs, v0
    step
        length of a step between events [s]; another length is a check on the first

    Returns
    -------
    tuple
        outputs (N, 6), in the order of `OUTCOMES`, and status (N,), zero where all went well
    """
    params = np.atleast_2d(np.asarray(params, dtype=np.float64))
    outputs = np.empty((len(params), len(OUTCOMES)))
    status = np.zeros(len(params), dtype=np.int64)
    _crashes(params, step, outputs, status)
    return outputs, status


def random_sets(count: int, *, seed: int = 0, spread: float = 0.2) -> Floats:
    """The benchmark's parameter sets: every nominal value times its own uniform factor in 1 +- spread, (count, 12)."""
    factors = np.random.default_rng(seed).uniform(1.0 - spread, 1.0 + spread, (count, 12))
    return NOMINAL * factors
