"""The march: event by event through many crashes abreast.

    series of the step  ->  its length  ->  first event in it  ->  extremes, work  ->  state at its end  ->  mode there

The rules that leave no event out (docs/theory.md, "Events"):
 1. Nothing but a guard turning negative changes a mode.
 2. At the start of every step each guard's sign is read from its first coefficient that is not round-off; a negative one
    changes its mode at once, in a step of no length, and all is read again. Coincident events settle so.
 3. A guard that starts at zero is divided by t before its next root is sought.
 4. Roots are isolated by Bernstein coefficients, never by sampling.
 5. The earliest root of all guards ends the step; only its mode changes; rule 2 does the rest.
"""

from __future__ import annotations

from enum import IntEnum
from pathlib import Path

import numpy as np

from ridedown.compiled import folder_of, kernel, part
from ridedown.solver import events, extremes, laws, series
from ridedown.solver.layout import BEST, DEGREE, MEMORY_ROWS, SET, STRIDE, WHEN, at, extreme_at, memory_at, row


class Stop(IntEnum):
    """Why a crash's march ended."""

    COMPLETED = 0
    TOO_MANY_STEPS = 1
    BAR_TURNED = 2
    NOT_FINITE = 3
    CHATTER = 4
    RECORD_FULL = 5


COMPLETED, TOO_MANY_STEPS, BAR_TURNED, NOT_FINITE, CHATTER, RECORD_FULL = (int(stop) for stop in Stop)
GOING = -1
NO_CRASH = -1
"""Crash number of a lane that has none."""

STEP_LIMIT = 100_000
_BAR_LIMIT = 1.4  # rad: tan has its pole at pi/2
_IDLE_ALL = 6  # steps of no length in which every negative guard may change its mode at once; then one at a time
_IDLE_LIMIT = 60  # steps of no length before a crash is given up as chattering
_GAUSS = np.polynomial.legendre.leggauss(DEGREE + 1)  # exact to twice the degree
_NODES, _WEIGHTS = 0.5 * (1.0 + _GAUSS[0]), 0.5 * _GAUSS[1]
_BRAKING_TIME = 0.05  # s: a crash brakes its speed in about so long; sets the scale of acceleration


def is_cold() -> bool:
    """Whether the march has still to be compiled on this machine (some seconds, once)."""
    folder = folder_of(Path(__file__).resolve().parent)
    return folder is None or not any(folder.rglob("march.march-*.nbc"))


@kernel
def march(s, x, w, out, record, tolerance, with_work):
    """Solve every crash of the columns `x`; results into `out`, and the phases of lane 0 into `record` if it has room.

    `tolerance`: what the last acceleration coefficients of a step may amount to, over the crash's own scale of acceleration.
    """
    # plain arrays from here on: the compiler turns loops over them into vector instructions
    parent, law, lever, bars, bar_of, arm = s.parent, s.law, s.lever, s.bar_coordinate, s.bar_of, w.arm
    term_start, term_coordinate, term_sign = s.term_start, s.term_coordinate, s.term_sign
    pull_start, pull_element, pull_sign = s.pull_start, s.pull_element, s.pull_sign
    piece_start, coefficients, pieces, duration = s.piece_start, x.coefficients, x.pieces, x.duration
    crash, time, step, power, last, steps, idle = w.crash, w.time, w.step, w.power, w.last, w.steps, w.idle
    q, acc, d, f, tan, sec2, moment = w.q, w.acc, w.d, w.f, w.tan, w.sec2, w.moment
    inverse_inertia, scale, mode, line, guard, memory = w.inverse_inertia, w.scale, w.mode, w.line, w.guard, w.memory
    event, suspect, pending, pending_count, falling, owner = (
        w.event, w.suspect, w.pending, w.pending_count, w.falling, w.owner
    )  # fmt: skip
    extreme, work, lane_series, poly, room = w.extreme, w.work, w.series, w.poly, w.room
    tracked_start, tracked_family, tracked_index = s.tracked_start, s.tracked_family, s.tracked_index
    tracked_weight, tracked_sense = s.tracked_weight, s.tracked_sense
    phases, log = record.phases, record.log

    lanes = np.uint64(min(STRIDE, duration.size))
    taken = np.int64(0)
    active = np.int64(0)
    for l in range(lanes):
        crash[l] = NO_CRASH

    while True:
        for l in range(lanes):
            if crash[l] == NO_CRASH and taken < duration.size:
                _load(
                    l, taken, x.inertia, x.rate, x.arm, crash, time, last, steps, idle, pending_count, q, inverse_inertia,
                    scale, arm,
                )  # fmt: skip
                _open(
                    l, taken, law, piece_start, coefficients, pieces, line, guard, memory, mode, work,
                    tracked_sense.size, extreme,
                )  # fmt: skip
                taken += 1
                active += 1
        if active == 0:
            break
        series.start(lanes, bars, term_start, term_coordinate, term_sign, lever, arm, q, tan, sec2, d)
        for l in range(lanes):  # the mode beyond each guard that has turned negative
            changed = -1
            for n in range(pending_count[l]):
                g = pending[row(n) + l]
                if g // 2 != changed:
                    changed = g // 2
                    _change(g, l, crash[l], time[l], d, law, piece_start, coefficients, pieces, line, guard, memory, mode, log)

        for j in range(DEGREE):
            if j > 0:
                series.tangents(lanes, j, bars, q, tan, sec2)
            series.forces(lanes, j, term_start, term_coordinate, term_sign, lever, arm, line, q, tan, d, f)
            if j < DEGREE - 1:
                series.accelerations(
                    lanes, j, s.conjugate, parent, pull_start, pull_element, pull_sign, arm, inverse_inertia, bar_of,
                    sec2, moment, f, acc, q,
                )  # fmt: skip

        _choose_steps(
            lanes, parent.size, bars.size, tolerance, crash, duration, time, scale, idle, w.trial, q, tan, step, last, power
        )
        events.find(
            lanes, 2 * law.size, guard, d, crash, last, step, power, event, pending, pending_count, suspect, falling, owner,
            poly, room,
        )  # fmt: skip
        for l in range(lanes):
            if pending_count[l] > 0:  # rule 2: a step of no length
                step[l] = 0.0
                last[l] = False
                idle[l] += 1
                if idle[l] > _IDLE_ALL:
                    pending_count[l] = 1
            elif event[l] != events.NO_EVENT:  # rule 5
                pending[l] = event[l]
                pending_count[l] = 1
        _powers(lanes, step, power)
        extremes.track_all(
            lanes, tracked_start, tracked_family, tracked_index, tracked_weight, tracked_sense, q, acc, d, f, lane_series,
            time, step, power, extreme, suspect, poly, room,
        )  # fmt: skip
        if with_work:
            _add_work(lanes, law.size, step, d, f, work)
        if phases.shape[0] > 0 and crash[0] >= 0 and step[0] > 0.0:
            _keep_phase(parent.size, law.size, time[0], step[0], q, d, f, phases, record.kept)
        _advance(lanes, parent.size, step, time, steps, idle, q, scale)

        for l in range(lanes):
            if crash[l] >= 0:
                stop = _stop_of(l, last, steps, idle, scale, bars, q, phases.shape[0], record.kept[0], log)
                if stop != GOING:
                    _store(l, crash[l], stop, time, steps, q, memory, work, extreme, out)
                    crash[l] = NO_CRASH
                    pending_count[l] = 0
                    active -= 1


@part
def _load(
    l, number, inertia, rate, arms, crash, time, last, steps, idle, pending_count, q, inverse_inertia, scale, arm
):  # fmt: skip
    """Put a crash into lane l, at its start."""
    crash[l] = number
    time[l] = 0.0
    last[l] = False
    steps[l] = 0
    idle[l] = 0
    pending_count[l] = 0
    fastest = 1e-3
    for i in range(inertia.shape[0]):
        q[at(i, 0) + l] = 0.0
        q[at(i, 1) + l] = rate[i, number]
        inverse_inertia[row(i) + l] = 1.0 / inertia[i, number]
        fastest = max(fastest, abs(rate[i, number]))
    scale[l] = fastest / _BRAKING_TIME
    for e in range(arms.shape[0]):
        arm[row(e) + l] = arms[e, number]


@part
def _open(l, number, law, piece_start, coefficients, pieces, line, guard, memory, mode, work, tracked, extreme):
    """Every law of lane l open, as before the crash, and nothing tracked yet."""
    for e in range(law.size):
        for slot in range(MEMORY_ROWS):
            memory[memory_at(e, slot) + l] = 0.0
        work[row(e) + l] = 0.0
        laws.enter(e, l, number, laws.OPEN, law, piece_start, coefficients, pieces, line, guard, memory, mode)
    for k in range(tracked):
        extreme[extreme_at(k, BEST) + l] = -np.inf
        extreme[extreme_at(k, WHEN) + l] = 0.0


@part
def _change(g, l, number, time, d, law, piece_start, coefficients, pieces, line, guard, memory, mode, log):
    """Guard g of lane l has turned negative: into the mode on its other side, and note the event down."""
    e = g // 2
    before = mode[row(e) + l]
    after = laws.next_mode(
        e, l, number, g % 2 == 1, d[at(e, 0) + l], d[at(e, 1) + l], law, piece_start, coefficients, pieces, memory, mode
    )
    laws.enter(e, l, number, after, law, piece_start, coefficients, pieces, line, guard, memory, mode)
    n = int(log[0, 0])
    if n + 1 < log.shape[0]:  # the first row counts the others
        log[0, 0] += 1.0
        log[n + 1, 0] = time
        log[n + 1, 1] = e
        log[n + 1, 2] = before
        log[n + 1, 3] = after


@part
def _choose_steps(lanes, coordinates, bars, tolerance, crash, duration, time, scale, idle, trial, q, tan, step, last, power):
    """The length of each lane's step, from its last acceleration coefficients, and no further than the end.

    If they fall off as scale / r^n, the step is the same fraction of r whichever of them is looked at. Four are: in a motion
    from rest, or one that is even in time, every second or three in four are zero. The tangents are looked at too: under
    constant forces they alone go on for ever.
    """
    for j in range(DEGREE - 3, DEGREE + 1):
        total = row(j)  # a sum, not a maximum, for that would pass over what is no number
        for l in range(lanes):
            power[total + l] = 0.0
        for i in range(coordinates):
            of = at(i, j)
            for l in range(lanes):
                power[total + l] += abs(q[of + l])
        for b in range(bars):
            of = at(b, j)
            for l in range(lanes):
                power[total + l] += abs(tan[of + l])
    share = tolerance ** (1.0 / (DEGREE - 2))
    for l in range(lanes):
        last[l] = False
        step[l] = 0.0
        if crash[l] < 0:
            continue
        inverse = 0.0  # of r
        for j in range(DEGREE - 3, DEGREE + 1):
            coefficient = j * (j - 1) * power[row(j) + l] / scale[l]
            if not np.isfinite(coefficient):
                scale[l] = np.nan  # the lane stops here, where it is
            elif coefficient > 0.0:
                inverse = max(inverse, coefficient ** (1.0 / (j - 2)))
        if not np.isfinite(scale[l]):
            continue
        h = share / inverse if inverse > 0.0 else np.inf
        # while modes settle, the step they are read on never grows: so what is round-off in one mode is in the next
        trial[l] = min(h, trial[l]) if idle[l] > 0 else h
        remaining = duration[crash[l]] - time[l]
        last[l] = not trial[l] < remaining
        step[l] = remaining if last[l] else trial[l]
    _powers(lanes, step, power)


@part
def _powers(lanes, step, power):
    """Powers of each lane's step, in rows by order."""
    for l in range(lanes):
        p = 1.0
        for j in range(DEGREE + 1):
            power[row(j) + l] = p
            p *= step[l]


@part
def _add_work(lanes, elements, step, d, f, work):
    """Work done on each element in this step: the integral of f d' dt, exact by Gauss's rule."""
    stride = np.uint64(STRIDE)
    for e in range(elements):
        to, top_f, top_d = row(e), at(e, DEGREE - 1), at(e, DEGREE)
        for n in range(_NODES.size):
            for l in range(lanes):
                t = _NODES[n] * step[l]
                o = top_f + l
                force = f[o]
                for _j in range(DEGREE - 1):  # unrolled: DEGREE is a constant
                    o -= stride
                    force = force * t + f[o]
                o = top_d + l
                rate = DEGREE * d[o]
                for j in range(DEGREE - 1, 0, -1):
                    o -= stride
                    rate = rate * t + float(j) * d[o]
                work[to + l] += _WEIGHTS[n] * step[l] * force * rate if step[l] > 0.0 else 0.0


@part
def _keep_phase(coordinates, elements, time, step, q, d, f, phases, kept):
    """Keep lane 0's series of this step: time, length, then q, d and f by order."""
    n = kept[0]
    phases[n, 0, 0] = time
    phases[n, 0, 1] = step
    for j in range(DEGREE + 1):
        for i in range(coordinates):
            phases[n, j + 1, i] = q[at(i, j)]
        for e in range(elements):
            phases[n, j + 1, coordinates + e] = d[at(e, j)]
            phases[n, j + 1, coordinates + elements + e] = f[at(e, j)] if j < DEGREE else 0.0
    kept[0] += 1


@part
def _advance(lanes, coordinates, step, time, steps, idle, q, scale):
    """The state at the end of the step."""
    for i in range(coordinates):
        position_row, rate_row, top = at(i, 0), at(i, 1), at(i, DEGREE)
        stride = np.uint64(top - at(i, DEGREE - 1))
        for l in range(lanes):
            h = step[l]
            o = top + l
            position = q[o]
            rate = DEGREE * q[o]
            for j in range(DEGREE - 1, 0, -1):  # unrolled: DEGREE is a constant
                o -= stride
                position = position * h + q[o]
                rate = rate * h + float(j) * q[o]
            position = q[position_row + l] + position * h
            q[position_row + l] = position if h > 0.0 else q[position_row + l]
            q[rate_row + l] = rate if h > 0.0 else q[rate_row + l]
            # a number that is not finite makes this one not finite too, and nothing else ever does
            scale[l] += 0.0 * (position + rate) if h > 0.0 else 0.0
    for l in range(lanes):
        time[l] += step[l]
        steps[l] += 1
        idle[l] = 0 if step[l] > 0.0 else idle[l]


@part
def _stop_of(l, last, steps, idle, scale, bars, q, capacity, kept, log):
    """Why lane l ends here, or GOING."""
    if not np.isfinite(scale[l]):
        return NOT_FINITE
    if last[l]:
        return COMPLETED
    for b in range(bars.size):
        if abs(q[at(bars[b], 0) + l]) > _BAR_LIMIT:
            return BAR_TURNED
    if idle[l] > _IDLE_LIMIT:
        return CHATTER
    if steps[l] > STEP_LIMIT:
        return TOO_MANY_STEPS
    if capacity > 0 and (kept >= capacity or int(log[0, 0]) + 1 >= log.shape[0]):
        return RECORD_FULL
    return GOING


@part
def _store(l, number, stop, time, steps, q, memory, work, extreme, out):
    out.stop[number] = stop
    out.time[number] = time[l]
    out.steps[number] = steps[l]
    for i in range(out.position.shape[0]):
        out.position[i, number] = q[at(i, 0) + l]
        out.rate[i, number] = q[at(i, 1) + l]
    for e in range(out.work.shape[0]):
        out.set[e, number] = memory[memory_at(e, SET) + l]
        out.work[e, number] = work[row(e) + l]
    for k in range(out.best.shape[0]):
        best = extreme[extreme_at(k, BEST) + l]
        out.best[k, number] = best if best > -np.inf else 0.0  # stopped before anything moved
        out.best_time[k, number] = extreme[extreme_at(k, WHEN) + l]
