"""How long a step is, and where it leads: the state at its end, and what moved with time."""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined, part
from ridedown.solver import events, series
from ridedown.solver.layout import (
    D0,
    DEGREE,
    DOWN,
    DRIFT,
    FASTER,
    FILL,
    FILLING,
    GD0,
    MOVES,
    NEEDS,
    PULL,
    REEL,
    SLOWER,
    STRIDE,
    UP,
    at,
    bend_at,
    guard_at,
    guard_of,
    line_at,
    memory_at,
    mode_at,
    row,
)
from ridedown.solver.vector import WIDTH, binary_exponent, floor, load, power_of_two, spread, store, union, where

NO, YES = events.NO, events.YES
_GAUSS = np.polynomial.legendre.leggauss(DEGREE + 1)  # exact to twice the degree
_NODES, _WEIGHTS = 0.5 * (1.0 + _GAUSS[0]), 0.5 * _GAUSS[1]
_TINY = 1e-300  # a coefficient below it sets no step
BRAKING_TIME = 0.05  # s: a crash brakes its speed in about so long; sets the scale of acceleration
_BRAKING = np.log2(BRAKING_TIME)


@part
def choose_steps(
    lanes, driven, coordinates, bars, tolerance, until, pause, time, scale, idle, trial, acc, tan, step, last, power
):  # fmt: skip
    """The length of each lane's step, from its last acceleration coefficients, and no further than the next pause.

    If they fall off as scale / r^n, the step is the same fraction of r whichever of them is looked at. Four are: in a motion
    from rest, or one that is even in time, every second or three in four are zero. The tangents are looked at too: under
    constant forces they alone go on for ever.

    Nothing is left out of a driven body's acceleration. What follows from it in those of others does so two orders later, or
    one: of its last two orders some is left out there, and so they count.

    What is left out of an acceleration counts as long as the step is: of one longer than a crash takes to brake, less may be.
    """
    share = np.log2(tolerance) / (DEGREE - 2)
    for block in range(0, lanes, WIDTH):
        steepest = spread(-1e3)  # the logarithm of 1 / r
        finite = load(scale, block) < np.inf
        for j in range(DEGREE - 3, DEGREE + 1):
            total = spread(0.0)
            for b in range(bars):
                total += abs(load(tan, at(b, j) + block))
            total *= j * (j - 1.0)
            for i in range(coordinates):
                if i != driven or j > DEGREE - 2:
                    total += abs(load(acc, at(i, j - 2) + block))
            coefficient = total / load(scale, block)
            finite &= coefficient < np.inf
            steepest = max(steepest, _logarithm(max(coefficient, _TINY)) * (1.0 / (j - 2)))
        store(scale, block, where(finite, load(scale, block), np.nan))  # a lane that is not finite stops where it is
        exponent = share - steepest
        exponent -= max(exponent - _BRAKING, 0.0) * (1.0 / (DEGREE - 1))
        h, tried = _power_of_two(exponent), load(trial, block)
        # while modes settle, the step they are read on never grows: so what is round-off in one mode is in the next
        h = where((load(idle, block) > 0.0) & (h > tried), tried, h)
        store(trial, block, h)
        remaining = load(pause, block) - load(time, block)
        goes = finite & (load(until, block) > 0.0)  # a lane without a crash does not
        ends = goes & (h >= remaining)
        store(last, block, where(ends, YES, NO))
        store(step, block, where(goes, min(h, remaining), 0.0))
    powers(lanes, step, power)


@inlined
def _logarithm(x):
    """To base two, within 0.01: a step's length needs no more. x positive and normal."""
    exponent, fraction = binary_exponent(x)
    return exponent + (2.0 - fraction * (1.0 / 3.0)) * fraction - 5.0 / 3.0


@inlined
def _power_of_two(y):
    """2^y within 0.3 %."""
    y = min(max(y, -1e3), 1e3)
    below = floor(y)
    rest = y - below
    return power_of_two(below) * (1.0 + rest * (2.0 / 3.0 + rest * (1.0 / 3.0)))


@part
def powers(lanes, step, power):
    """Powers of each lane's step, in rows by order."""
    for block in range(0, lanes, WIDTH):
        h, p = load(step, block), spread(1.0)
        for j in range(DEGREE + 1):
            store(power, row(j) + block, p)
            p *= h


@part
def bends(lanes, coordinates, watched, q, tan, step, power, bend):
    """How far down and up watched coordinates, and bars' tangents, can go in the step beyond their straight course; and how
    much slower and faster than now.
    """
    for block in range(0, lanes, WIDTH):
        h = load(step, block)
        per = where(h > 0.0, 1.0 / h, 0.0)
        for n in range(watched.size):
            i = watched[n]
            source, first = (q, at(i, 0)) if i < coordinates else (tan, at(i - coordinates, 0))
            total = load(source, first + 2 * STRIDE + block) * load(power, row(2) + block)
            size, rate, rate_size = abs(total), spread(0.0), spread(0.0)
            for j in range(3, DEGREE + 1):
                c = load(source, first + j * STRIDE + block) * load(power, row(j) + block)
                total += c
                size += abs(c)
                rate += j * c
                rate_size += j * abs(c)
            store(bend, bend_at(i, DOWN) + block, 0.5 * (total - size))
            store(bend, bend_at(i, UP) + block, 0.5 * (total + size))
            store(bend, bend_at(i, SLOWER) + block, 0.5 * (rate - rate_size) * per)
            store(bend, bend_at(i, FASTER) + block, 0.5 * (rate + rate_size) * per)


@part
def add_work(lanes, elements, step, d, f, rests, work):
    """Work done on each element in this step: the integral of f d' dt, exact by Gauss's rule."""
    for e in range(elements):
        for block in range(0, lanes, WIDTH):
            if rests[row(e) + block] == series.RESTS:
                continue
            h, total = load(step, block), spread(0.0)
            for n in range(_NODES.size):
                t = _NODES[n] * h
                force, rate = load(f, at(e, DEGREE - 1) + block), DEGREE * load(d, at(e, DEGREE) + block)
                for j in range(DEGREE - 1, 0, -1):
                    force = force * t + load(f, at(e, j - 1) + block)
                    rate = rate * t + float(j) * load(d, at(e, j) + block)
                total += _WEIGHTS[n] * force * rate
            to = row(e) + block
            store(work, to, load(work, to) + where(h > 0.0, total * h, 0.0))


@part
def keep_phase(coordinates, elements, time, step, q, d, f, phases, kept):
    """Keep lane 0's series of this step: time, length, then q, d and f by order."""
    n = kept[0]
    phases[n, 0, 0] = time
    phases[n, 0, 1] = step
    for j in range(phases.shape[1] - 1):  # not a constant, lest the compiler writes it out order by order
        for i in range(coordinates):
            phases[n, j + 1, i] = q[at(i, j)]
        for e in range(elements):
            phases[n, j + 1, coordinates + e] = d[at(e, j)]
            phases[n, j + 1, coordinates + elements + e] = f[at(e, j)] if j < DEGREE else 0.0
    kept[0] += 1


@part
def advance(lanes, coordinates, step, last, pause, time, steps, idle, q, scale):
    """The state at the end of the step."""
    for block in range(0, lanes, WIDTH):
        h = load(step, block)
        moved = h > 0.0
        for i in range(coordinates):
            o = at(i, DEGREE) + block
            position = load(q, o)
            rate = DEGREE * position
            for j in range(DEGREE - 1, 0, -1):
                o -= STRIDE
                c = load(q, o)
                position = position * h + c
                rate = rate * h + float(j) * c
            at_start, rate_row = load(q, o - STRIDE), o
            position = position * h + at_start
            store(q, rate_row, where(moved, rate, load(q, rate_row)))
            store(q, rate_row - STRIDE, where(moved, position, at_start))
            # a number that is not finite makes this one not finite too, and nothing else ever does
            store(scale, block, load(scale, block) + where(moved, 0.0 * (position + rate), 0.0))
        store(time, block, where(moved & (load(last, block) > NO), load(pause, block), load(time, block) + h))
        store(steps, block, load(steps, block) + 1.0)
        store(idle, block, where(moved, 0.0, load(idle, block)))


@part
def move_on(lanes, e, pair, step, mode, line, guard, memory):
    """What moves with time in restraint e: its reel, as pretensioners pull, and its fill."""
    for block in range(0, lanes, WIDTH):
        if union(mode, mode_at(e, NEEDS) + block) & MOVES == 0:
            continue
        h = load(step, block)
        drawn = h * load(line, line_at(e, PULL) + block)
        reel, zero = memory_at(e, REEL) + block, line_at(e, D0) + block
        store(memory, reel, load(memory, reel) + drawn)
        store(line, zero, load(line, zero) - drawn)
        fill = line_at(e, FILL) + block
        store(line, fill, load(line, fill) + h * load(line, line_at(e, FILLING) + block))
        for n in range(4):
            g = guard_of(e, pair, n)
            zero = guard_at(g, GD0) + block
            store(guard, zero, load(guard, zero) - h * load(guard, guard_at(g, DRIFT) + block))
