"""Exact extremes of tracked quantities: from each step's polynomial, not from samples.

The ends of the step count, and where some point between could go beyond them, the polynomial is searched. A quantity of one
term (an acceleration, a force, a relative displacement) is read from its series in place; one of several is summed first.
"""

from __future__ import annotations

import numpy as np

from ridedown.network import Family
from ridedown.solver import polynomial
from ridedown.solver.cache import kernel
from ridedown.solver.layout import BEST, DEGREE, END, FALL, RISE, STRIDE, WHEN, at, extreme_at, row

POSITION, RATE, ACCELERATION, DEFLECTION, DEFLECTION_RATE, FORCE = (int(family) for family in Family)


@kernel
def gather(lanes, k, tracked_start, tracked_family, tracked_index, tracked_weight, q, acc, d, f, series):
    """The series of tracked quantity k in all lanes."""
    for j in range(DEGREE + 1):
        to = row(j)
        for l in range(lanes):
            series[to + l] = 0.0
    for n in range(tracked_start[k], tracked_start[k + 1]):
        family, index, weight = tracked_family[n], tracked_index[n], tracked_weight[n]
        if family == POSITION:
            _add(lanes, q, index, 0, weight, series)
        elif family == RATE:
            _add(lanes, q, index, 1, weight, series)
        elif family == ACCELERATION:
            _add(lanes, acc, index, 0, weight, series)
        elif family == DEFLECTION:
            _add(lanes, d, index, 0, weight, series)
        elif family == DEFLECTION_RATE:
            _add(lanes, d, index, 1, weight, series)
        else:
            _add(lanes, f, index, 0, weight, series)


@kernel
def _add(lanes, source, index, shift, weight, series):
    """Add weight * a series, or `shift` = 1 times differentiated."""
    for j in range(DEGREE + 1 - shift):
        to, of = row(j), at(index, j + shift)
        factor = weight if shift == 0 else weight * (j + 1.0)
        for l in range(lanes):
            series[to + l] += factor * source[of + l]


@kernel
def _bounds(lanes, source, base, power, extreme, end, rise, fall):
    """The series' value at the end of the step, and how high it and its negative could go at most."""
    stride = np.uint64(STRIDE)
    for l in range(lanes):
        o = base + l
        start = source[o]
        total = start
        more = start
        less = -start
        for j in range(1, DEGREE + 1):  # unrolled: DEGREE is a constant
            o += stride
            c = source[o] * power[row(j) + l]
            total += c
            more += max(c, 0.0)
            less += max(-c, 0.0)
        extreme[end + l] = total
        extreme[rise + l] = more
        extreme[fall + l] = less


@kernel
def track(lanes, k, sense, source, base, time, step, power, extreme, suspect, poly, room):
    """Raise extreme k by what this step holds of a series, whose row of order 0 starts at `base` in `source`.

    `sense`: +1 largest, -1 smallest (kept as its negative), 0 largest magnitude.
    """
    best, when = extreme_at(k, BEST), extreme_at(k, WHEN)
    end, rise, fall = extreme_at(k, END), extreme_at(k, RISE), extreme_at(k, FALL)
    _bounds(lanes, source, base, power, extreme, end, rise, fall)
    suspects = 0
    for l in range(lanes):
        start = source[base + l]
        finish = extreme[end + l]
        low = abs(start) if sense == 0 else sense * start
        high = abs(finish) if sense == 0 else sense * finish
        now = extreme[best + l]
        if step[l] > 0.0:
            if low > now:
                now = low
                extreme[when + l] = time[l]
            if high > now:
                now = high
                extreme[when + l] = time[l] + step[l]
            extreme[best + l] = now
        beyond = (sense >= 0 and extreme[rise + l] > now) or (sense <= 0 and extreme[fall + l] > now)
        suspect[l] = 1 if beyond and step[l] > 0.0 else 0
        suspects += suspect[l]
    if suspects > 0:
        for l in range(lanes):
            if suspect[l] == 1:
                for sign in (1.0, -1.0):
                    if sense * sign >= 0.0 and extreme[(rise if sign > 0.0 else fall) + l] > extreme[best + l]:
                        for j in range(DEGREE + 1):
                            poly[j] = sign * source[base + row(j) + l] * power[row(j) + l]
                        peak, where = polynomial.maximum(poly, 0, DEGREE, extreme[best + l], room)
                        if where >= 0.0:
                            extreme[best + l] = peak
                            extreme[when + l] = time[l] + where * step[l]
