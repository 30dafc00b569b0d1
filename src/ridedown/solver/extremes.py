"""Exact extremes of tracked quantities, from each step's polynomial; and samples of others at times given.

The ends of the step count, and where some point between could go beyond them, the polynomial is searched. Most of those turn
once, from rising to falling: Newton's method finds the tops of all of them side by side. The rest go to Bernstein
coefficients. A quantity of one term (an acceleration, a force, a relative displacement) is read from its series in place; one
of several is summed first.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.network import Family
from ridedown.network.model import Floats, Ints
from ridedown.solver import polynomial, together
from ridedown.solver.events import NO
from ridedown.solver.layout import BEST, DEGREE, HAD, STRIDE, TAKEN, WHEN, Cube, Table, at, extreme_at, row
from ridedown.solver.vector import WIDTH, first_lane, lanes_of, load, spread, store, where

POSITION, RATE, ACCELERATION, DEFLECTION, DEFLECTION_RATE, FORCE = (int(family) for family in Family)


SAMPLED = 2
"""In place of a sense: the quantity is sampled."""

_ORDER = np.arange(DEGREE + 1.0)


@kernel
def track_all(
    lanes: int, tracked_start: Ints, tracked_family: Ints, tracked_index: Ints, tracked_weight: Floats, tracked_sense: Ints,
    q: Floats, acc: Floats, d: Floats, f: Floats, series: Floats, time: Floats, step: Floats, power: Floats,
    extreme: Floats, falling: Floats, owner: Ints, poly: Floats, room: Table, crash: Ints, until: Floats, pause: Floats,
    last: Floats, sample_time: Floats, sampled: Ints, samples: Cube, shape: Floats, timed: bool,
) -> None:  # fmt: skip
    """Raise every tracked extreme by what this step holds, and take the samples that lie in it.

    `falling` and `owner` are room for polynomials solved together, `shape` for those of a block; `sampled` has how many samples
    a lane had before this step, and has after it.
    """
    taken = 0
    if sample_time.size > 0:
        _count_samples(lanes, crash, until, pause, last, time, step, sample_time, sampled)
    for k in range(tracked_sense.size):
        first = tracked_start[k]
        family, base = tracked_family[first], at(tracked_index[first], 0)
        source = q
        if family == ACCELERATION:
            source = acc
        elif family == DEFLECTION:
            source = d
        elif family == FORCE:
            source = f
        alone = tracked_start[k + 1] == first + 1 and tracked_weight[first] == 1.0
        if not alone or family in (RATE, DEFLECTION_RATE):
            _gather(lanes, k, tracked_start, tracked_family, tracked_index, tracked_weight, q, acc, d, f, series)
            source, base = series, 0
        if tracked_sense[k] == SAMPLED:
            _sample(lanes, source, base, taken, crash, time, sample_time, sampled, samples)
            taken += 1
            continue
        _track(lanes, k, tracked_sense[k], source, base, time, step, power, extreme, falling, owner, shape, poly, room, timed)


@part
def _count_samples(lanes, crash, until, pause, last, time, step, sample_time, sampled):
    """How many samples each lane has before this step, and after it. One at an event counts to the step after it."""
    for l in range(lanes):
        n = sampled[row(TAKEN) + l]
        sampled[row(HAD) + l] = n
        if crash[l] < 0 or step[l] <= 0.0:
            continue
        end = pause[l] if last[l] > NO else time[l] + step[l]  # to the last bit what `stepping.advance` makes of it
        while n + WIDTH <= sample_time.size and sample_time[n + WIDTH - 1] < end:
            n += WIDTH
        while n < sample_time.size and (sample_time[n] < end or end >= until[l] >= sample_time[n]):
            n += 1
        sampled[row(TAKEN) + l] = n


@part
def _sample(lanes, source, base, number, crash, time, sample_time, sampled, samples):
    """Samples of a quantity, whose series has its row of order 0 at `base` in `source`, at the times in this step.

    Eight at a time; of so many or more the last eight are taken together, whatever of them was taken before.
    """
    size = sample_time.size
    for l in range(lanes):
        first, end = sampled[row(HAD) + l], sampled[row(TAKEN) + l]
        if crash[l] < 0 or first == end:
            continue
        to, top = (number * samples.shape[1] + crash[l]) * size, base + row(DEGREE) + l
        for n in range(first, end, WIDTH):
            if end - first < WIDTH:
                for m in range(first, end):
                    samples[number, crash[l], m] = _value(source, top, sample_time[m] - time[l])
                break
            m = min(n, end - WIDTH)
            store(samples, to + m, _value(source, top, load(sample_time, m) - time[l]))


@inlined
def _value(source, top, t):
    """A series at times t since its start; `top` is where its last coefficient is."""
    value = t * source[top]
    for j in range(1, DEGREE):
        value = (value + source[top - j * STRIDE]) * t
    return value + source[top - DEGREE * STRIDE]


@part
def _gather(lanes, k, tracked_start, tracked_family, tracked_index, tracked_weight, q, acc, d, f, series):
    """The series of tracked quantity k in all lanes."""
    for l in range(0, (DEGREE + 1) * STRIDE, WIDTH):
        store(series, l, 0.0)
    for n in range(tracked_start[k], tracked_start[k + 1]):
        family, index, weight = tracked_family[n], tracked_index[n], tracked_weight[n]
        source = q
        if family == ACCELERATION:
            source = acc
        elif family in (DEFLECTION, DEFLECTION_RATE):
            source = d
        elif family == FORCE:
            source = f
        shift = 1 if family in (RATE, DEFLECTION_RATE) else 0
        for j in range(DEGREE + 1 - shift):
            to, of = row(j), at(index, j + shift)
            factor = weight if shift == 0 else weight * (j + 1.0)
            for l in range(0, lanes, WIDTH):
                store(series, to + l, load(series, to + l) + factor * load(source, of + l))


@part
def _track(lanes, k, sense, source, base, time, step, power, extreme, falling, owner, shape, poly, room, timed):
    """Raise extreme k by what this step holds of a series, whose row of order 0 starts at `base` in `source`.

    `sense`: +1 largest, -1 smallest (kept as its negative), 0 largest magnitude.
    """
    best, when = extreme_at(k, BEST), extreme_at(k, WHEN)
    count = 0
    for block in range(0, lanes, WIDTH):
        o = base + block
        start = load(source, o)
        c = load(source, o + STRIDE) * load(power, row(1) + block)
        total, size, slope, steepness = spread(0.0), spread(0.0), spread(0.0), spread(0.0)
        for j in range(2, DEGREE + 1):
            term = load(source, o + row(j)) * load(power, row(j) + block)
            total += term
            size += abs(term)
            slope += j * term
            steepness += j * abs(term)
        end = start + c + total
        # with every coefficient that pulls up, or down, taken in full
        highest, lowest = start + max(c, 0.0) + 0.5 * (total + size), start + min(c, 0.0) + 0.5 * (total - size)
        fastest, slowest = c + 0.5 * (slope + steepness), c + 0.5 * (slope - steepness)
        low, high = abs(start), abs(end)
        if sense > 0:
            low, high = start, end
        elif sense < 0:
            low, high = -start, -end
        length, begun = load(step, block), load(time, block)
        moved = length > 0.0
        now, since = load(extreme, best + block), load(extreme, when + block)
        better = moved & (low - polynomial.TIE * abs(low) > now)
        now, since = where(better, low, now), where(better, begun, since)
        better = moved & (high - polynomial.TIE * abs(high) > now)
        now, since = where(better, high, now), where(better, begun + length, since)
        store(extreme, best + block, now)
        store(extreme, when + block, since)
        # one that rises or falls throughout does not go beyond its ends
        turns = moved & (slowest < 0.0) & (fastest > 0.0)
        above = lanes_of(turns & (highest > now)) if sense >= 0 else 0
        below = lanes_of(turns & (-lowest > now)) if sense <= 0 else 0
        if above | below == 0:
            continue
        most, least = _bends(o, block, source, power)
        down, up, last = lanes_of(most < 0.0), lanes_of(least > 0.0), c + slope
        above &= ~up & (~down | lanes_of((c > 0.0) & (last < 0.0)))
        below &= ~down & (~up | lanes_of((c < 0.0) & (last > 0.0)))
        search = above | (below << WIDTH)
        once = down | (up << WIDTH)
        if timed and search & ~once != 0:  # those whose slope changes its sign not at all, or once
            _slopes(o, block, source, power, shape)
            falls, rises, _ = together.sign_changes(DEGREE - 1, shape)
            search &= once | ~(lanes_of(falls == 0.0) | (lanes_of(rises == 0.0) << WIDTH))
            once |= lanes_of((falls == 1.0) & (rises == 0.0)) | (lanes_of((rises == 1.0) & (falls == 0.0)) << WIDTH)
        while search != 0:
            bit = first_lane(search)
            search &= search - 1
            n, sign = bit % WIDTH, 1.0 if bit < WIDTH else -1.0
            l = block + n
            if (once >> bit) & 1 != 0:
                if count == STRIDE:
                    _raise_all(count, source, base, time, step, best, when, extreme, falling, owner)
                    count = 0
                _take_slope(l, sign, source, base, power, falling, count)
                owner[2 * count] = l
                owner[2 * count + 1] = 1 if sign > 0.0 else -1
                count += 1
            else:
                for j in range(DEGREE + 1):
                    poly[j] = sign * source[base + row(j) + l] * power[row(j) + l]
                peak, at_fraction = polynomial.maximum(poly, extreme[best + l], room)
                if at_fraction >= 0.0:
                    extreme[best + l] = peak
                    extreme[when + l] = time[l] + at_fraction * step[l]
    _raise_all(count, source, base, time, step, best, when, extreme, falling, owner)


@inlined
def _bends(o, block, source, power):
    """How far up, at most, and at least, a series bends anywhere in the step: bounds of its second derivative, scaled."""
    bend = 2.0 * load(source, o + row(2)) * load(power, row(2) + block)
    most, least = bend, bend
    for j in range(3, DEGREE + 1):
        bend = j * (j - 1.0) * load(source, o + row(j)) * load(power, row(j) + block)
        most += max(bend, 0.0)
        least += min(bend, 0.0)
    return most, least


@inlined
def _slopes(o, block, source, power, shape):
    """The slope of a series, scaled to [0, 1], in all lanes of a block, into the rows of `shape`."""
    for j in range(1, DEGREE + 1):
        store(shape, row(j - 1), j * load(source, o + row(j)) * load(power, row(j) + block))


@inlined
def _take_slope(l, sign, source, base, power, falling, column):
    """Put the slope of a series, times `sign` and scaled to [0, 1], which falls from plus to minus, into a column."""
    o, to = base + l, row(0) + column
    start = sign * source[o + STRIDE] * power[row(1) + l]
    end = start
    falling[to] = start
    for j in range(2, DEGREE + 1):
        slope = _ORDER[j] * sign * source[o + j * STRIDE] * power[row(j) + l]
        falling[to + (j - 1) * STRIDE] = slope
        end += slope
    falling[to + DEGREE * STRIDE] = 0.0
    falling[row(together.ROOT) + column] = start / (start - end)


@part
def _raise_all(count, source, base, time, step, best, when, extreme, falling, owner):
    """Find where the slopes at hand turn negative, and raise the extreme to what the series is there."""
    together.solve(count, falling)
    for x in range(count):
        l, t = owner[2 * x], falling[row(together.ROOT) + x]
        h = t * step[l]
        top = 0.0
        for j in range(DEGREE, -1, -1):
            top = top * h + source[base + row(j) + l]
        top *= owner[2 * x + 1]
        if polynomial.beats(top, extreme[best + l]):
            extreme[best + l] = top
            extreme[when + l] = time[l] + h
