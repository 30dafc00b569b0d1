"""Exact extremes of tracked quantities: from each step's polynomial, not from samples."""

from __future__ import annotations

from ridedown.network import Family
from ridedown.solver import polynomial
from ridedown.solver.cache import kernel
from ridedown.solver.workspace import DEGREE, LANES

ACCELERATION, DEFLECTION, DEFLECTION_RATE = (
    int(Family.ACCELERATION),
    int(Family.DEFLECTION),
    int(Family.DEFLECTION_RATE),
)


@kernel
def _falling(n, order):
    """n (n - 1) ..., `order` factors: what differentiating a power brings down."""
    return 1.0 if order == 0 else (float(n) if order == 1 else float(n * (n - 1)))


@kernel
def gather(k, tracked_start, tracked_family, tracked_index, tracked_weight, power, q, d, f, series):
    """The series of tracked quantity k in all lanes, scaled to the step."""
    for j in range(DEGREE + 1):
        for l in range(LANES):
            series[j, l] = 0.0
    for t in range(tracked_start[k], tracked_start[k + 1]):
        family, index, weight = tracked_family[t], tracked_index[t], tracked_weight[t]
        if family <= ACCELERATION:
            for j in range(DEGREE + 1 - family):
                factor = weight * _falling(j + family, family)
                for l in range(LANES):
                    series[j, l] += factor * q[j + family, index, l]
        elif family <= DEFLECTION_RATE:
            shift = family - DEFLECTION
            for j in range(DEGREE + 1 - shift):
                factor = weight * _falling(j + shift, shift)
                for l in range(LANES):
                    series[j, l] += factor * d[j + shift, index, l]
        else:
            for j in range(DEGREE):
                for l in range(LANES):
                    series[j, l] += weight * f[j, index, l]
    for j in range(1, DEGREE + 1):
        for l in range(LANES):
            series[j, l] *= power[j, l]


@kernel
def track(k, sense, time, step, series, best, best_time, suspect, up, down, end, p, room):
    """Raise extreme k by what this step holds, given its series.

    `sense`: +1 largest, -1 smallest (kept as its negative), 0 largest magnitude.
    """
    for l in range(LANES):
        up[l] = max(series[1, l], 0.0)
        down[l] = min(series[1, l], 0.0)
        end[l] = series[0, l] + series[1, l]
    for j in range(2, DEGREE + 1):
        for l in range(LANES):
            c = series[j, l]
            up[l] += max(c, 0.0)
            down[l] += min(c, 0.0)
            end[l] += c
    # the ends of the step first; then a search where some point between could go beyond them
    suspects = 0
    for l in range(LANES):
        start = series[0, l]
        low = abs(start) if sense == 0 else sense * start
        high = abs(end[l]) if sense == 0 else sense * end[l]
        now = best[k, l]
        moving = step[l] > 0.0
        at_start = moving & (low > now)
        now = low if at_start else now
        at_end = moving & (high > now)
        now = high if at_end else now
        when = time[l] if at_start else best_time[k, l]
        best_time[k, l] = time[l] + step[l] if at_end else when
        best[k, l] = now
        beyond = ((sense >= 0) & (start + up[l] > now)) | ((sense <= 0) & (-start - down[l] > now))
        suspect[l] = 1 if moving & beyond else 0
        suspects += suspect[l]
    if suspects > 0:
        for l in range(LANES):
            if suspect[l] == 1:
                if sense >= 0 and series[0, l] + up[l] > best[k, l]:
                    _search(k, l, 1.0, time, step, series, best, best_time, p, room)
                if sense <= 0 and -series[0, l] - down[l] > best[k, l]:
                    _search(k, l, -1.0, time, step, series, best, best_time, p, room)


@kernel
def _search(k, l, sign, time, step, series, best, best_time, p, room):
    for j in range(DEGREE + 1):
        p[j] = sign * series[j, l]
    peak, where = polynomial.maximum(p, 0, DEGREE, best[k, l], room)
    if where >= 0.0:
        best[k, l] = peak
        best_time[k, l] = time[l] + where * step[l]
