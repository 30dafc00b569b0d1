"""What changes at the start of a step: modes beyond guards that turned negative, and what is due at that time.

The march pauses wherever something is due: a timer of a restraint, the next piece of the driven body's pulse, the end. A timer
that changes nothing before its restraint's mode does (a bag that fires and touches nobody) can wait: the step goes on past it,
and it goes off late, at the step's end, with the same outcome. Where pieces of the pulse overlap, the first step that starts
within the next one takes it.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.network.model import Floats, Ints
from ridedown.solver import laws, reel, restraint, series
from ridedown.solver.layout import DEGREE, GD0, NUMBER, Table, at, guard_at, mode_at, of_crash, row

TIMER = -1
"""What the log has for the mode before, where a timer went off; after it, the timer's number."""


@kernel
def change_modes(
    lanes: int, pair_element: Ints, pending: Ints, pending_count: Ints, crash: Ints, time: Floats, alarm: Floats,
    steps: Floats, d: Floats, law: Ints, piece_start: Ints, coefficients: Floats, pieces: Floats, second_pair: Ints,
    line: Floats, guard: Floats, memory: Floats, mode: Ints, log: Table,
) -> None:  # fmt: skip
    """The mode beyond each guard that has turned negative; and where a crash begins, of what already touches and closes in.

    A guard that says when a pretensioner pulls again may not be there any more, where a timer waited: it is read again.
    """
    for l in range(lanes):
        if steps[l] == 0.0 and crash[l] >= 0:
            for e in range(law.size):
                if law[e] != laws.LINEAR and mode[mode_at(e, NUMBER) + l] == laws.OPEN and _closes_in(e, l, d, guard):
                    _change(
                        e, 2 * e, l, time[l], d, law, piece_start, coefficients, pieces, second_pair, line, guard,
                        memory, mode, log,
                    )  # fmt: skip
        changed = -1
        for n in range(pending_count[l]):
            g = pending[row(n) + l]
            e = pair_element[g // 2]
            stale = alarm[l] <= time[l] and g // 2 >= law.size and g % 2 == 0
            if e != changed and not stale:
                changed = e
                _change(
                    e, g, l, time[l], d, law, piece_start, coefficients, pieces, second_pair, line, guard, memory,
                    mode, log,
                )  # fmt: skip
        pending_count[l] = 0


_CLEARLY = 1e-6  # m/s: a rate that is no round-off


@inlined
def _closes_in(e, l, d, guard):
    """Whether element e, open, is at its slack or beyond, and deflects further: no series is needed to tell."""
    gap = guard[guard_at(2 * e, GD0) + l] - d[at(e, 0) + l]
    return gap <= 0.0 and d[at(e, 1) + l] > _CLEARLY


@inlined
def _change(
    e, g, l, time, d, law, piece_start, coefficients, pieces, second_pair, line, guard, memory, mode, log
):  # fmt: skip
    """Guard g, of element e, has turned negative in lane l: into the mode on its other side, and note the event down."""
    before = mode[mode_at(e, NUMBER) + l]
    here, rate = d[at(e, 0) + l], d[at(e, 1) + l]
    if law[e] == laws.RESTRAINT:
        which = g - 2 * e if g // 2 == e else g - 2 * second_pair[e] + 2
        beyond, after = restraint.change(
            e, l, which, here, rate, piece_start, coefficients, pieces, second_pair[e], line, guard, memory, mode
        )
        if beyond != after:
            _note(time, e, before, beyond, log)
            before = beyond
    else:
        after = laws.next_mode(e, l, g % 2 == 1, here, rate, law, piece_start, coefficients, pieces, memory, mode)
        laws.enter(e, l, after, law, piece_start, coefficients, pieces, line, guard, memory, mode)
    _note(time, e, before, after, log)


@kernel
def keep_time(
    lanes: int, driven: int, timer_element: Ints, timer_action: Ints, timer_value: Table, pulse_start: Floats,
    pulse_end: Floats, pulse_series: Table, pulse_amplitude: Floats, pulse_length: Floats, crash: Ints, until: Floats,
    due: Floats, pause: Floats, time: Floats, timer: Floats, alarm: Floats, amplitude: Floats, per: Floats, origin: Floats,
    piece: Ints, d: Floats, acc: Floats, piece_start: Ints, coefficients: Floats, pieces: Floats, second_pair: Ints,
    line: Floats, guard: Floats, memory: Floats, mode: Ints, log: Table,
) -> None:  # fmt: skip
    """What is due at this time: timers, and the next piece of the pulse; and the driven body's acceleration from here on."""
    for l in range(lanes):
        if crash[l] >= 0 and (time[l] >= due[l] or alarm[l] < pause[l]):
            number = crash[l]
            while alarm[l] <= time[l]:
                alarm[l] = _go_off(
                    l, number, alarm[l], time[l], timer_element, timer_action, timer_value, timer, d, piece_start, coefficients,
                    pieces, second_pair, line, guard, memory, mode, log,
                )  # fmt: skip
            due[l] = pause[l] = until[l]
            if driven >= 0:
                if piece[l] < 0:
                    piece[l], amplitude[l], per[l] = 0, pulse_amplitude[number], 1.0 / pulse_length[number]
                _next_piece(l, time[l], pulse_start, pulse_length[number], origin, piece)
                if piece[l] + 1 < pulse_start.size:
                    due[l] = min(due[l], pulse_start[piece[l] + 1] * pulse_length[number])
                pause[l] = min(pause[l], pulse_end[piece[l]] * pulse_length[number])
            if pause[l] == until[l]:  # what waits goes off before the end
                pause[l] = min(until[l], alarm[l])
            elif alarm[l] < pause[l]:
                pause[l] = _first_that_does_not_wait(
                    l, number, pause[l], timer_element, timer_action, timer_value, timer, memory, mode
                )
            due[l] = min(due[l], pause[l])
    if driven >= 0:
        series.drive(lanes, driven, pulse_series, amplitude, per, piece, origin, time, acc)


@part
def _go_off(
    l, number, due, time, timer_element, timer_action, timer_value, timer, d, piece_start, coefficients, pieces, second_pair,
    line, guard, memory, mode, log,
):  # fmt: skip
    """The timers of lane l that are due then go off, now; when the next of them does."""
    following = np.inf
    for t in range(timer_element.size):
        if timer[row(t) + l] <= due:
            timer[row(t) + l] = np.inf
            e = timer_element[t]
            restraint.fire(
                e, l, timer_action[t], of_crash(timer_value, t, number), time - due, d[at(e, 0) + l], d[at(e, 1) + l],
                piece_start, coefficients, pieces, second_pair[e], line, guard, memory, mode,
            )  # fmt: skip
            _note(due, e, TIMER, t, log)
        following = min(following, timer[row(t) + l])
    return following


@part
def _first_that_does_not_wait(l, number, pause, timer_element, timer_action, timer_value, timer, memory, mode):
    """When the first timer of lane l goes off that cannot wait until the pause; or the pause."""
    for t in range(timer_element.size):
        when = timer[row(t) + l]
        if when < pause and not restraint.waits(
            timer_element[t], l, timer_action[t], of_crash(timer_value, t, number), memory, mode
        ):
            pause = when
    return pause


@part
def _note(time, e, before, after, log):
    n = int(log[0, 0])
    if n + 1 < log.shape[0]:  # the first row counts the others
        log[0, 0] += 1.0
        log[n + 1, 0] = time
        log[n + 1, 1] = e
        log[n + 1, 2] = before
        log[n + 1, 3] = after


@part
def _next_piece(l, time, start, length, origin, piece):
    """Find the pulse's piece at this time for lane l, and when it began."""
    n = piece[l]
    while n + 1 < start.size and start[n + 1] * length <= time:
        n += 1
    piece[l] = n
    origin[l] = start[n] * length


@part
def settle(e, l, step, d, piece_start, coefficients, pieces, memory, mode):
    """Where the reel of restraint e of lane l is, at the end of its last step."""
    here, rate = d[at(e, DEGREE) + l], 0.0
    for j in range(DEGREE - 1, -1, -1):
        rate = rate * step + here
        here = here * step + d[at(e, j) + l]
    reel.settle(e, l, here, rate, piece_start, coefficients, pieces, memory, mode)
