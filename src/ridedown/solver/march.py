"""The march: event by event through many crashes abreast.

    series of the step  ->  its length  ->  first event in it  ->  extremes, work  ->  state at its end  ->  mode there

The rules that leave no event out (docs/theory.md, "Events"):
 1. Nothing but a guard turning negative changes a mode.
 2. At the start of every step each guard's sign is read from its first coefficient that is not round-off; a negative one
    changes its mode at once, in a step of no length, and all is read again. Coincident events settle so.
 3. A guard that starts at zero is divided by t before its next root is sought.
 4. Roots are isolated by Bernstein coefficients, never by sampling.
 5. The earliest root of all guards ends the step; only its mode changes, and those of others at that instant; rule 2 does
    the rest.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.network.model import Floats, Ints
from ridedown.solver import changes, events, extremes, laws, reel, restraint_line, series, stepping
from ridedown.solver.layout import (
    BEST,
    FILL,
    FILLING,
    MEMORY_ROWS,
    PAYOUT,
    REEL,
    SET,
    TAKEN,
    WHEN,
    Table,
    at,
    extreme_at,
    line_at,
    memory_at,
    of_crash,
    row,
)
from ridedown.solver.vector import (
    ALL_LANES,
    WIDTH,
    count_up,
    first_lane,
    lanes_of,
    load,
    where,
)
from ridedown.solver.workspace import Lanes, Numbers, Record, Results, Structure


class Stop(IntEnum):
    """Why a crash's march ended."""

    COMPLETED = 0
    TOO_MANY_STEPS = 1
    BAR_TURNED = 2
    NOT_FINITE = 3
    CHATTER = 4
    RECORD_FULL = 5


COMPLETED, TOO_MANY_STEPS, BAR_TURNED, NOT_FINITE, CHATTER, RECORD_FULL = (int(stop) for stop in Stop)
NO_CRASH = -1
"""Crash number of a lane that has none."""
NO, YES = events.NO, events.YES

STEP_LIMIT = 100_000
_BAR_LIMIT = 1.4  # rad: tan has its pole at pi/2
_IDLE_LIMIT = 60  # steps of no length before a crash is given up as chattering


@kernel
def march(
    s: Structure, x: Numbers, w: Lanes, queue: Ints, places: int, out: Results, record: Record, tolerance: float,
    with_work: bool,
) -> None:  # fmt: skip
    """Solve crashes of the columns `x`; results into `out`, and the phases of lane 0 into `record` if it has room.

    `queue`: the next crash to be taken, by whichever thread marches on these columns. `places`: how many crashes to carry
    abreast. `tolerance`: what the last acceleration coefficients of a step may amount to, over the crash's own scale of
    acceleration.
    """
    # plain arrays from here on; a named tuple that is read further down is copied whole each time it is read
    parent, law, lever, bars, bar_of, arm = s.parent, s.law, s.lever, s.bar_coordinate, s.bar_of, w.arm
    term_start, term_coordinate, term_sign = s.term_start, s.term_coordinate, s.term_sign
    pull_start, pull_element, pull_sign = s.pull_start, s.pull_element, s.pull_sign
    piece_start, coefficients, pieces, duration = s.piece_start, w.coefficients, w.pieces, x.duration
    varied, varied_row, own = x.varied, x.varied_row, w.own
    pair_element, second_pair, empty, quiet = s.pair_element, s.second_pair, s.empty, s.quiet
    timer_element, timer_action, timer_value = s.timer_element, s.timer_action, x.timer_value
    driven, pulse_length = s.driven, x.pulse_length
    pulse_start, pulse_end, pulse_series = s.pulse_start, s.pulse_end, s.pulse_series
    crash, until, time, step, power, bend, rests = w.crash, w.until, w.time, w.step, w.power, w.bend, w.rests
    due, pause, timer, alarm = w.due, w.pause, w.timer, w.alarm
    amplitude, per, origin, piece = w.amplitude, w.per, w.origin, w.piece
    last, steps, idle = w.last, w.steps, w.idle
    q, acc, d, f = w.q, w.acc, w.d, w.f
    tan, sec2, turn, moment = w.tan, w.sec2, w.turn, w.moment
    inverse_inertia, scale, mode, line, guard, memory = w.inverse_inertia, w.scale, w.mode, w.line, w.guard, w.memory
    found, root, found_count = w.found, w.root, w.found_count
    pending, pending_count, falling, owner = w.pending, w.pending_count, w.falling, w.owner
    extreme, sampled, work, lane_series, shape, poly, room = w.extreme, w.sampled, w.work, w.series, w.shape, w.poly, w.room
    tracked_start, tracked_family, tracked_index = s.tracked_start, s.tracked_family, s.tracked_index
    tracked_weight, tracked_sense = s.tracked_weight, s.tracked_sense
    phases, log = record.phases, record.log
    leader, beside, direction, watched, total = s.leader, s.beside, s.direction, s.watched, w.total
    leading, bodies = s.leading, s.bodies
    conjugate, free, sample_time, trial = s.conjugate, s.free, s.sample_time, w.trial
    inertia, rate, arms, timer_time, pulse_amplitude = x.inertia, x.rate, x.arm, x.timer_time, x.pulse_amplitude
    samples, kept = out.samples, record.kept

    timed = driven >= 0 or timer_element.size > 0
    restrained, recorded = pair_element.size > law.size, phases.shape[0] > 0
    lanes = (places + WIDTH - 1) // WIDTH * WIDTH  # in whole vectors
    active, more, vacant = 0, True, True
    for l in range(lanes):
        crash[l] = NO_CRASH

    while True:
        if vacant and more:
            vacant = False
            active, more = _take(
                queue, active, places, inertia, rate, arms, duration, timer_time, timed, crash, until, due, pause, time, last,
                steps, idle, q, inverse_inertia, scale, arm, timer, alarm, piece, sampled, varied, varied_row, own,
                law, piece_start, coefficients, pieces, second_pair, free, empty, line, guard, memory, mode, work,
                tracked_sense.size, extreme,
            )  # fmt: skip
        if active == 0:
            break
        series.start(lanes, bars, term_start, term_coordinate, term_sign, lever, arm, q, tan, sec2, turn, d)
        changes.change_modes(
            lanes, pair_element, pending, pending_count, crash, time, alarm, steps, d, law, piece_start, coefficients, pieces,
            second_pair, line, guard, memory, mode, log,
        )  # fmt: skip
        if timed:
            changes.keep_time(
                lanes, driven, timer_element, timer_action, timer_value, pulse_start, pulse_end, pulse_series, pulse_amplitude,
                pulse_length, crash, until, due, pause, time, timer, alarm, amplitude, per, origin, piece, d, acc, piece_start,
                coefficients, pieces, second_pair, line, guard, memory, mode, log,
            )  # fmt: skip

        if restrained:
            series.side_by_side(
                lanes, law, leader, beside, direction, quiet, recorded, mode, line, d, f, total, rests,
            )  # fmt: skip
        series.expand(
            lanes, conjugate, law, leading, rests, parent, bodies, driven, term_start, term_coordinate, term_sign, lever,
            pull_start, pull_element, pull_sign, bars, bar_of, arm, inverse_inertia, line, total, q, tan, sec2, turn, moment,
            d, f, acc,
        )  # fmt: skip

        stepping.choose_steps(
            lanes, driven, parent.size, bars.size, tolerance, until, pause, time, scale, idle, trial, acc, tan, step, last,
            power,
        )  # fmt: skip
        if restrained:
            stepping.bends(lanes, parent.size, watched, q, tan, step, power, bend)
        events.find(
            lanes, law, leader, direction, pair_element, second_pair, rests, parent.size, term_start, term_coordinate,
            term_sign, lever, arm, q, tan, bend, mode, guard, d, crash, last, idle, step, power, found, root, found_count,
            pending, pending_count, falling, owner, shape, poly, room, timed,
        )  # fmt: skip
        stepping.powers(lanes, step, power)
        extremes.track_all(
            lanes, tracked_start, tracked_family, tracked_index, tracked_weight, tracked_sense, q, acc, d, f, lane_series,
            time, step, power, extreme, falling, owner, poly, room, crash, until, pause, last, sample_time, sampled, samples,
            shape, timed,
        )  # fmt: skip
        if with_work:
            stepping.add_work(lanes, law.size, step, d, f, rests, work)
        if recorded and crash[0] >= 0 and step[0] > 0.0:
            stepping.keep_phase(parent.size, law.size, time[0], step[0], q, d, f, phases, kept)
        stepping.advance(lanes, parent.size, step, last, pause, time, steps, idle, q, scale)
        for e in range(law.size):
            if law[e] == laws.RESTRAINT:
                stepping.move_on(lanes, e, second_pair[e], step, mode, line, guard, memory)

        full = recorded and (kept[0] >= phases.shape[0] or int(log[0, 0]) + 1 >= log.shape[0])
        for block in range(0, lanes, WIDTH):
            stopped = ALL_LANES if full else _stopped(block, until, pause, last, steps, idle, scale, bars, q)
            while stopped != 0:
                l = block + first_lane(stopped)
                stopped &= stopped - 1
                if crash[l] >= 0:
                    stop = _stop_of(l, until, pause, last, steps, idle, scale, bars, q)
                    _settle(
                        l, block, law, leader, rests, term_start, term_coordinate, term_sign, lever, arm, q, tan, d, step,
                        piece_start, coefficients, pieces, memory, mode,
                    )  # fmt: skip
                    _store(l, crash[l], stop, time, steps, q, memory, work, extreme, sampled, out)
                    crash[l] = NO_CRASH
                    until[l] = 0.0
                    pending_count[l] = 0
                    active -= 1
                    vacant |= not timed or not _in_use(block, block + WIDTH, crash)


@kernel
def _take(
    queue: Ints, active: int, places: int, inertia: Table, rate: Table, arms: Table, duration: Floats, timer_time: Table,
    timed: bool, crash: Ints, until: Floats, due: Floats, pause: Floats, time: Floats, last: Floats, steps: Floats,
    idle: Floats, q: Floats, inverse_inertia: Floats, scale: Floats, arm: Floats, timer: Floats, alarm: Floats, piece: Ints,
    sampled: Ints, varied: Table, varied_row: Ints, own: Floats, law: Ints, piece_start: Ints, coefficients: Floats,
    pieces: Floats, second_pair: Ints, free: Ints, empty: Ints, line: Floats, guard: Floats, memory: Floats, mode: Ints,
    work: Floats, tracked: int, extreme: Floats,
) -> tuple[int, bool]:  # fmt: skip
    """Put the next crashes into the lanes that have none. How many have one now, and whether there may be more to take.

    Timed crashes, on a pulse or with timers, start side by side: a vector takes new ones when all of its own have ended. So
    they are in like modes at like times, and more of what no lane needs is passed over than idle lanes cost.
    """
    for block in range(0, places, WIDTH):
        end = min(block + WIDTH, places)
        if timed and _in_use(block, end, crash):
            continue
        for l in range(block, end):
            if crash[l] != NO_CRASH:
                continue
            number = count_up(queue)
            if number >= duration.size:
                return active, False
            _load(
                l, number, inertia, rate, arms, duration, timer_time, timed, crash, until, due, pause, time, last, steps, idle,
                q, inverse_inertia, scale, arm, timer, alarm, piece, sampled, varied, varied_row, own,
            )  # fmt: skip
            _open(
                l, law, piece_start, coefficients, pieces, second_pair, free, empty, line, guard, memory, mode, work,
                tracked, extreme,
            )  # fmt: skip
            active += 1
    return active, True


@inlined
def _in_use(block, end, crash):
    """Whether any of those lanes has a crash."""
    busy = False
    for l in range(block, end):
        busy |= crash[l] != NO_CRASH
    return busy


@part
def _load(
    l, number, inertia, rate, arms, duration, timer_time, timed, crash, until, due, pause, time, last, steps, idle, q,
    inverse_inertia, scale, arm, timer, alarm, piece, sampled, varied, varied_row, own,
):  # fmt: skip
    """Put a crash into lane l, at its start."""
    crash[l] = number
    until[l] = duration[number]
    due[l] = 0.0 if timed else until[l]
    pause[l] = until[l]
    piece[l] = -1
    sampled[row(TAKEN) + l] = 0
    for t in range(timer_time.shape[0]):
        timer[row(t) + l] = of_crash(timer_time, t, number)
    alarm[l] = 0.0 if timer_time.shape[0] > 0 else np.inf
    time[l] = 0.0
    last[l] = NO
    steps[l] = 0.0
    idle[l] = 0.0
    fastest = 1e-3
    for i in range(inertia.shape[0]):
        speed = of_crash(rate, i, number)
        q[at(i, 0) + l] = 0.0
        q[at(i, 1) + l] = speed
        inverse_inertia[row(i) + l] = 1.0 / of_crash(inertia, i, number)
        fastest = max(fastest, abs(speed))
    scale[l] = fastest / stepping.BRAKING_TIME
    for e in range(arms.shape[0]):
        arm[row(e) + l] = of_crash(arms, e, number)
    for n in range(varied_row.size):
        own[row(varied_row[n]) + l] = varied[n, number]


@part
def _open(
    l, law, piece_start, coefficients, pieces, second_pair, free, empty, line, guard, memory, mode, work, tracked, extreme,
):  # fmt: skip
    """Every law of lane l open, as before the crash, and nothing tracked yet."""
    for e in range(law.size):
        for slot in range(MEMORY_ROWS):
            memory[memory_at(e, slot) + l] = 0.0
        work[row(e) + l] = 0.0
        if law[e] != laws.RESTRAINT:
            laws.enter(e, l, laws.OPEN, law, piece_start, coefficients, pieces, line, guard, memory, mode)
            continue
        line[line_at(e, FILL) + l] = 0.0 if empty[e] != 0 else 1.0
        line[line_at(e, FILLING) + l] = 0.0
        start = piece_start[e + 1] - piece_start[e] + reel.FREE if free[e] != 0 else reel.OPEN
        restraint_line.enter(e, l, start, piece_start, coefficients, pieces, second_pair[e], line, guard, memory, mode)
    for k in range(tracked):
        extreme[extreme_at(k, BEST) + l] = -np.inf
        extreme[extreme_at(k, WHEN) + l] = 0.0


@part
def _settle(
    l, block, law, leader, rests, term_start, term_coordinate, term_sign, lever, arm, q, tan, d, step, piece_start,
    coefficients, pieces, memory, mode,
):  # fmt: skip
    """Where the reels of lane l are, at the end of its last step."""
    for e in range(law.size):
        if law[e] == laws.RESTRAINT and reel.gives_way(e, l, piece_start, mode):
            if leader[e] != e or rests[row(e) + block] == series.RESTS:
                series.deflect(block, e, term_start, term_coordinate, term_sign, lever, arm, q, tan, d)
            changes.settle(e, l, step[l], d, piece_start, coefficients, pieces, memory, mode)


@part
def _stopped(block, until, pause, last, steps, idle, scale, bars, q):
    """The lanes of a block whose crash ends here, as bits."""
    ends = (load(last, block) > NO) & (load(pause, block) >= load(until, block))
    goes = (load(until, block) > 0.0) & (where(ends, YES, NO) == NO) & (load(scale, block) < np.inf)
    goes &= (load(idle, block) <= _IDLE_LIMIT) & (load(steps, block) <= STEP_LIMIT)
    for b in range(bars.size):
        goes &= abs(load(q, at(bars[b], 0) + block)) <= _BAR_LIMIT
    return lanes_of(goes) ^ ALL_LANES


@part
def _stop_of(l, until, pause, last, steps, idle, scale, bars, q):
    """Why lane l ends here."""
    if not np.isfinite(scale[l]):
        return NOT_FINITE
    if last[l] != NO and pause[l] >= until[l]:
        return COMPLETED
    for b in range(bars.size):
        if abs(q[at(bars[b], 0) + l]) > _BAR_LIMIT:
            return BAR_TURNED
    if idle[l] > _IDLE_LIMIT:
        return CHATTER
    if steps[l] > STEP_LIMIT:
        return TOO_MANY_STEPS
    return RECORD_FULL


@part
def _store(l, number, stop, time, steps, q, memory, work, extreme, sampled, out):
    out.stop[number] = stop
    out.time[number] = time[l]
    out.steps[number] = int(steps[l])
    for i in range(out.position.shape[0]):
        out.position[i, number] = q[at(i, 0) + l]
        out.rate[i, number] = q[at(i, 1) + l]
    for e in range(out.work.shape[0]):
        out.set[e, number] = memory[memory_at(e, SET) + l]
        out.reel[e, number] = memory[memory_at(e, REEL) + l]
        out.payout[e, number] = memory[memory_at(e, PAYOUT) + l]
        out.work[e, number] = work[row(e) + l]
    for k in range(out.best.shape[0]):
        best = extreme[extreme_at(k, BEST) + l]
        out.best[k, number] = best if best > -np.inf else 0.0  # stopped before anything moved
        out.best_time[k, number] = extreme[extreme_at(k, WHEN) + l]
    for k in range(out.samples.shape[0]):
        for n in range(sampled[row(TAKEN) + l], out.samples.shape[2]):
            out.samples[k, number, n] = np.nan
