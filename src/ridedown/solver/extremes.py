"""Exact extremes of tracked quantities: from each step's polynomial, not from samples.

The ends of the step count, and where some point between could go beyond them, the polynomial is searched. A quantity of one
term (an acceleration, a force, a relative displacement) is read from its series in place; one of several is summed first.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import part
from ridedown.network import Family
from ridedown.solver import polynomial
from ridedown.solver.layout import BEST, DEGREE, END, FALL, RISE, STRIDE, WHEN, at, extreme_at, row

POSITION, RATE, ACCELERATION, DEFLECTION, DEFLECTION_RATE, FORCE = (int(family) for family in Family)


@part
def _gather(lanes, k, tracked_start, tracked_family, tracked_index, tracked_weight, q, acc, d, f, series):
    """The series of tracked quantity k in all lanes."""
    for j in range(DEGREE + 1):
        to = row(j)
        for l in range(lanes):
            series[to + l] = 0.0
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
            for l in range(lanes):
                series[to + l] += factor * source[of + l]


@part
def _bounds(lanes, source, base, power, extreme, end, rise, fall):
    """The series' value at the end of the step, and how high it and its negative could go at most between."""
    stride = np.uint64(STRIDE)
    for l in range(lanes):
        o = base + l
        start = source[o]
        c = source[o + stride] * power[row(1) + l]
        total = start + c
        more = max(c, 0.0)
        less = max(-c, 0.0)
        slowest = c
        fastest = c
        o += stride
        for j in range(2, DEGREE + 1):  # unrolled: DEGREE is a constant
            o += stride
            c = source[o] * power[row(j) + l]
            up = max(c, 0.0)
            down = max(-c, 0.0)
            total += c
            more += up
            less += down
            fastest += j * up
            slowest -= j * down
        # one that rises or falls throughout does not go beyond its ends
        turns = (slowest < 0.0) & (fastest > 0.0)
        extreme[end + l] = total
        extreme[rise + l] = start + more if turns else -np.inf
        extreme[fall + l] = less - start if turns else -np.inf


@part
def _track(lanes, k, sense, source, base, time, step, power, extreme, suspect, poly, room):
    """Raise extreme k by what this step holds of a series, whose row of order 0 starts at `base` in `source`.

    `sense`: +1 largest, -1 smallest (kept as its negative), 0 largest magnitude.
    """
    best, when = extreme_at(k, BEST), extreme_at(k, WHEN)
    end, rise, fall = extreme_at(k, END), extreme_at(k, RISE), extreme_at(k, FALL)
    _bounds(lanes, source, base, power, extreme, end, rise, fall)
    for l in range(lanes):
        now = extreme[best + l]
        ends = (abs(source[base + l]) > now) | (abs(extreme[end + l]) > now)
        suspect[l] = ends | (extreme[rise + l] > now) | (extreme[fall + l] > now)
    for l in range(lanes):
        if suspect[l] != 0 and step[l] > 0.0:
            start, finish = source[base + l], extreme[end + l]
            low = abs(start) if sense == 0 else sense * start
            high = abs(finish) if sense == 0 else sense * finish
            if low > extreme[best + l]:
                extreme[best + l] = low
                extreme[when + l] = time[l]
            if high > extreme[best + l]:
                extreme[best + l] = high
                extreme[when + l] = time[l] + step[l]
            for sign in (1.0, -1.0):
                if extreme[(rise if sign > 0.0 else fall) + l] > extreme[best + l] and sense * sign >= 0.0:
                    for j in range(DEGREE + 1):
                        poly[j] = sign * source[base + row(j) + l] * power[row(j) + l]
                    peak, where = polynomial.maximum(poly, extreme[best + l], room)
                    if where >= 0.0:
                        extreme[best + l] = peak
                        extreme[when + l] = time[l] + where * step[l]


@part
def track_all(
    lanes, tracked_start, tracked_family, tracked_index, tracked_weight, tracked_sense, q, acc, d, f, series,
    time, step, power, extreme, suspect, poly, room,
):  # fmt: skip
    """Raise every tracked extreme by what this step holds."""
    for k in range(tracked_sense.size):
        first = tracked_start[k]
        family, base = tracked_family[first], at(tracked_index[first], np.int64(0))
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
            source, base = series, np.uint64(0)
        _track(lanes, k, tracked_sense[k], source, base, time, step, power, extreme, suspect, poly, room)
