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

import numpy as np

from ridedown.solver import events, extremes, laws, series
from ridedown.solver.cache import kernel
from ridedown.solver.workspace import DEGREE, LANES


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
IDLE = -1
"""Crash number of a lane that has none."""

STEP_LIMIT = 100_000
_BAR_LIMIT = 1.4  # rad: tan has its pole at pi/2
_IDLE_ALL = 6  # steps of no length in which every negative guard may change its mode at once; then one at a time
_IDLE_LIMIT = 60  # steps of no length before a crash is given up as chattering
_BRAKING_TIME = 0.05  # s: a crash brakes its speed in about so long; sets the scale of acceleration


@kernel
def march(s, x, w, out, record, tolerance, with_work):
    """Solve every crash of the columns `x`; results into `out`, and the phases of lane 0 into `record` if it has room.

    `tolerance`: what the last acceleration coefficients of a step may amount to, over the crash's own scale of acceleration.
    """
    # plain arrays from here on: the compiler turns loops over them into vector instructions
    parent, law, lever, bars, arm = s.parent, s.law, s.lever, s.bar_coordinate, w.arm
    term_start, term_coordinate, term_sign = s.term_start, s.term_coordinate, s.term_sign
    reaction_start, reaction_coordinate, reaction_sign = s.reaction_start, s.reaction_coordinate, s.reaction_sign
    piece_start, coefficients, pieces, duration = s.piece_start, x.coefficients, x.pieces, x.duration
    row, time, step, power, last, steps, idle = w.row, w.time, w.step, w.power, w.last, w.steps, w.idle
    q, tan, sec2, moment, d, f, pull = w.q, w.tan, w.sec2, w.moment, w.d, w.f, w.pull
    inverse_inertia, scale, mode, line, guard, memory = w.inverse_inertia, w.scale, w.mode, w.line, w.guard, w.memory
    event, suspect, pending, pending_count = w.event, w.suspect, w.pending, w.pending_count
    best, best_time, work, lane_series, poly, room = (
        w.best,
        w.best_time,
        w.work,
        w.series,
        w.poly,
        w.room,
    )
    tracked_start, tracked_family, tracked_index = s.tracked_start, s.tracked_family, s.tracked_index
    tracked_weight, tracked_sense = s.tracked_weight, s.tracked_sense

    sum1, sum2, sum3 = w.sum1, w.sum2, w.sum3
    phases, log = record.phases, record.log

    taken = 0
    active = 0
    for l in range(LANES):
        # a lane left over carries a copy of the last crash through the arithmetic, and never moves
        crash = min(taken, duration.size - 1)
        _load(
            l,
            crash,
            parent,
            x.inertia,
            x.rate,
            x.arm,
            row,
            time,
            last,
            steps,
            idle,
            event,
            q,
            inverse_inertia,
            scale,
            arm,
        )
        _open(
            l,
            crash,
            law,
            piece_start,
            coefficients,
            pieces,
            line,
            guard,
            memory,
            mode,
            work,
            tracked_sense,
            best,
            best_time,
        )
        if taken < duration.size:
            taken += 1
            active += 1
        else:
            row[l] = IDLE
    series.start_tangents(bars, q, tan, sec2)
    for j in range(2):
        series.deflections(j, term_start, term_coordinate, term_sign, lever, arm, q, tan, d)

    while active > 0:
        for j in range(DEGREE):
            if j > 0:
                series.tangents(j, bars, q, tan, sec2)
                series.deflections(j + 1, term_start, term_coordinate, term_sign, lever, arm, q, tan, d)
            series.forces(j, line, d, f)
            if j < DEGREE - 1:
                series.pulls(j, reaction_start, reaction_coordinate, reaction_sign, lever, bars, arm, f, pull)
                if s.conjugate:
                    series.conjugate_moments(j, bars, sec2, moment, pull)
                series.positions(j, parent, inverse_inertia, pull, q)

        _choose_steps(tolerance, row, duration, time, scale, q, step, last, sum1, sum2)
        _powers(step, power)
        events.find(guard, d, row, last, step, power, event, pending, pending_count, suspect, sum1, sum2, poly, room)
        for l in range(LANES):
            if pending_count[l] > 0:  # rule 2
                step[l] = 0.0
                last[l] = False
                event[l] = events.NO_EVENT
                idle[l] += 1
                changed = -1
                for n in range(pending_count[l] if idle[l] <= _IDLE_ALL else 1):
                    g = pending[n, l]
                    if g // 2 != changed:
                        changed = g // 2
                        _change(
                            g,
                            l,
                            row[l],
                            time[l],
                            d,
                            law,
                            piece_start,
                            coefficients,
                            pieces,
                            line,
                            guard,
                            memory,
                            mode,
                            log,
                        )
        _powers(step, power)
        for k in range(tracked_sense.size):
            extremes.gather(
                k, tracked_start, tracked_family, tracked_index, tracked_weight, power, q, d, f, lane_series
            )
            extremes.track(k, tracked_sense[k], time, step, lane_series, best, best_time, suspect, sum1, sum2, sum3, poly, room)
        if with_work:
            _add_work(power, d, f, work)
        if phases.shape[0] > 0 and row[0] >= 0 and step[0] > 0.0:
            _keep_phase(time[0], step[0], q, d, f, phases, record.count)
        _advance(step, time, steps, idle, q, sum1, sum2)

        for l in range(LANES):
            if row[l] >= 0:
                stop = _stop_of(l, last, steps, idle, bars, q, phases.shape[0], record.count[0], log)
                if stop != GOING:
                    event[l] = events.NO_EVENT
                    _store(l, row[l], stop, time, steps, q, memory, work, best, best_time, out)
                    row[l] = IDLE
                    active -= 1
                    if taken < duration.size:
                        _load(
                            l,
                            taken,
                            parent,
                            x.inertia,
                            x.rate,
                            x.arm,
                            row,
                            time,
                            last,
                            steps,
                            idle,
                            event,
                            q,
                            inverse_inertia,
                            scale,
                            arm,
                        )
                        _open(
                            l,
                            taken,
                            law,
                            piece_start,
                            coefficients,
                            pieces,
                            line,
                            guard,
                            memory,
                            mode,
                            work,
                            tracked_sense,
                            best,
                            best_time,
                        )
                        taken += 1
                        active += 1

        series.start_tangents(bars, q, tan, sec2)
        for j in range(2):
            series.deflections(j, term_start, term_coordinate, term_sign, lever, arm, q, tan, d)
        for l in range(LANES):
            if event[l] != events.NO_EVENT:  # rule 5
                _change(
                    event[l],
                    l,
                    row[l],
                    time[l],
                    d,
                    law,
                    piece_start,
                    coefficients,
                    pieces,
                    line,
                    guard,
                    memory,
                    mode,
                    log,
                )
                event[l] = events.NO_EVENT


@kernel
def _load(l, crash, parent, inertia, rate, arms, row, time, last, steps, idle, event, q, inverse_inertia, scale, arm):
    """Put a crash into lane l, at its start."""
    row[l] = crash
    time[l] = 0.0
    last[l] = False
    steps[l] = 0
    idle[l] = 0
    event[l] = events.NO_EVENT
    fastest = 0.0
    for i in range(parent.size):
        q[0, i, l] = 0.0
        q[1, i, l] = rate[i, crash]
        inverse_inertia[i, l] = 1.0 / inertia[i, crash]
        fastest = max(fastest, abs(rate[i, crash]))
    scale[l] = max(fastest, 1e-3) / _BRAKING_TIME
    for e in range(arm.shape[0]):
        arm[e, l] = arms[e, crash]


@kernel
def _open(
    l, crash, law, piece_start, coefficients, pieces, line, guard, memory, mode, work, tracked_sense, best, best_time
):
    """Every law of lane l open, as before the crash, and nothing tracked yet."""
    for e in range(law.size):
        memory[:, e, l] = 0.0
        work[e, l] = 0.0
        laws.enter(e, l, crash, laws.OPEN, law, piece_start, coefficients, pieces, line, guard, memory, mode)
    for k in range(tracked_sense.size):
        best[k, l] = -np.inf
        best_time[k, l] = 0.0


@kernel
def _change(g, l, crash, time, d, law, piece_start, coefficients, pieces, line, guard, memory, mode, log):
    """Guard g of lane l has turned negative: into the mode on its other side, and note the event down."""
    e = g // 2
    before = mode[e, l]
    after = laws.next_mode(
        e, l, crash, g % 2 == 1, d[0, e, l], d[1, e, l], law, piece_start, coefficients, pieces, memory, mode
    )
    laws.enter(e, l, crash, after, law, piece_start, coefficients, pieces, line, guard, memory, mode)
    n = int(log[0, 0])
    if n + 1 < log.shape[0]:  # the first row counts the others
        log[0, 0] += 1.0
        log[n + 1, 0] = time
        log[n + 1, 1] = e
        log[n + 1, 2] = before
        log[n + 1, 3] = after


@kernel
def _choose_steps(tolerance, row, duration, time, scale, q, step, last, top, below):
    """The length of each lane's step, from its last two acceleration coefficients, and no further than the end."""
    for l in range(LANES):
        top[l] = 0.0
        below[l] = 0.0
    for i in range(q.shape[1]):
        for l in range(LANES):
            top[l] = max(top[l], abs(q[DEGREE, i, l]))
            below[l] = max(below[l], abs(q[DEGREE - 1, i, l]))
    for l in range(LANES):
        last[l] = False
        step[l] = 0.0
        if row[l] < 0:
            continue
        goal = tolerance * scale[l]
        h = np.inf
        if top[l] > 0.0:
            h = (goal / (DEGREE * (DEGREE - 1) * top[l])) ** (1.0 / (DEGREE - 2))
        if below[l] > 0.0:
            h = min(h, (goal / ((DEGREE - 1) * (DEGREE - 2) * below[l])) ** (1.0 / (DEGREE - 3)))
        remaining = duration[row[l]] - time[l]
        last[l] = not h < remaining
        step[l] = remaining if last[l] else h


@kernel
def _powers(step, power):
    for l in range(LANES):
        power[0, l] = 1.0
    for j in range(1, DEGREE + 1):
        for l in range(LANES):
            power[j, l] = power[j - 1, l] * step[l]


@kernel
def _add_work(power, d, f, work):
    """Work done on each element in this step: the integral of f d' dt, term by term."""
    for e in range(work.shape[0]):
        for a in range(DEGREE):
            for b in range(DEGREE - a):
                share = (b + 1) / (a + b + 1)
                for l in range(LANES):
                    work[e, l] += share * f[a, e, l] * d[b + 1, e, l] * power[a + b + 1, l]


@kernel
def _keep_phase(time, step, q, d, f, phases, count):
    """Keep lane 0's series of this step: time, length, then q, d and f by order."""
    coordinates, elements = q.shape[1], d.shape[1]
    phase = phases[count[0]]
    phase[0, 0] = time
    phase[0, 1] = step
    for j in range(DEGREE + 1):
        for i in range(coordinates):
            phase[j + 1, i] = q[j, i, 0]
        for e in range(elements):
            phase[j + 1, coordinates + e] = d[j, e, 0]
            phase[j + 1, coordinates + elements + e] = f[j, e, 0] if j < DEGREE else 0.0
    count[0] += 1


@kernel
def _advance(step, time, steps, idle, q, position, rate):
    """The state at the end of the step."""
    for i in range(q.shape[1]):
        for l in range(LANES):
            position[l] = q[DEGREE, i, l]
            rate[l] = DEGREE * q[DEGREE, i, l]
        for j in range(DEGREE - 1, 0, -1):
            order = float(j)
            for l in range(LANES):
                position[l] = position[l] * step[l] + q[j, i, l]
                rate[l] = rate[l] * step[l] + order * q[j, i, l]
        for l in range(LANES):
            q[0, i, l] = position[l] * step[l] + q[0, i, l]
            q[1, i, l] = rate[l]
    for l in range(LANES):
        time[l] += step[l]
        steps[l] += 1
        if step[l] > 0.0:
            idle[l] = 0


@kernel
def _stop_of(l, last, steps, idle, bars, q, capacity, kept, log):
    """Why lane l ends here, or GOING."""
    total = 0.0
    for i in range(q.shape[1]):
        total += q[0, i, l] + q[1, i, l]
    if not np.isfinite(total):
        return NOT_FINITE
    if last[l]:
        return COMPLETED
    for b in range(bars.size):
        if abs(q[0, bars[b], l]) > _BAR_LIMIT:
            return BAR_TURNED
    if idle[l] > _IDLE_LIMIT:
        return CHATTER
    if steps[l] > STEP_LIMIT:
        return TOO_MANY_STEPS
    if capacity > 0 and (kept >= capacity or int(log[0, 0]) + 1 >= log.shape[0]):
        return RECORD_FULL
    return GOING


@kernel
def _store(l, crash, stop, time, steps, q, memory, work, best, best_time, out):
    out.stop[crash] = stop
    out.time[crash] = time[l]
    out.steps[crash] = steps[l]
    for i in range(q.shape[1]):
        out.position[i, crash] = q[0, i, l]
        out.rate[i, crash] = q[1, i, l]
    for e in range(work.shape[0]):
        out.set[e, crash] = memory[laws.SET, e, l]
        out.work[e, crash] = work[e, l]
    for k in range(best.shape[0]):
        out.best[k, crash] = best[k, l]
        out.best_time[k, crash] = best_time[k, l]
