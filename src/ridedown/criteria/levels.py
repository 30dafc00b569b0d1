"""The search behind the clips: the highest level that a signal, straight between its samples, holds for a time.

Continuous: the window of the given length whose lowest value is highest. Both ends of the window and what lies between them
are followed from sample to sample; between two such steps the ends move along straight lines, so the best place is at an end of
the step or where the two lines meet. Cumulative: the time spent above a level falls in straight pieces as the level rises, with
corners at the samples' values only; those are halved until one straight piece is left, and that is solved.
"""

from __future__ import annotations

import numpy as np

from ridedown.compiled import inlined, kernel
from ridedown.criteria.checks import Floats
from ridedown.criteria.strung import Ints


@inlined
def _on(time: Floats, y: Floats, i: int, t: float) -> float:
    """The value at t on segment i."""
    return float(y[i] + (y[i + 1] - y[i]) * ((t - time[i]) / (time[i + 1] - time[i])))


@kernel
def highest_held(  # noqa: C901, PLR0912 - one sweep
    time: Floats, y: Floats, duration: float, queue: Ints
) -> tuple[float, float]:
    """The highest level below which y >= 0 does not fall for `duration` on end, and when that begins [s].

    time, y: (n,), at least `duration` long; queue: (n,), samples inside the window whose values rise, the lowest first.
    """
    last = time.size - 1
    i = 0  # the segment of the window's start
    j = 0  # the segment of its end
    head, tail = 0, 0
    t = time[0]
    while j < last - 1 and time[j + 1] < t + duration:
        j += 1
        while tail > head and y[queue[tail - 1]] >= y[j]:
            tail -= 1
        queue[tail] = j
        tail += 1
    best, start = -1.0, t
    while True:
        next_start, next_end = time[i + 1], time[j + 1] - duration
        then = max(min(next_start, next_end), t)
        between = y[queue[head]] if tail > head else np.inf
        # neither end is above the samples beside it: nearly all windows are passed over by that
        most = min(between, max(y[i], y[i + 1]), max(y[j], y[j + 1]))
        if most > best and time[i + 1] > time[i] and time[j + 1] > time[j]:
            left, right = _on(time, y, i, t), _on(time, y, j, t + duration)
            left_then, right_then = _on(time, y, i, then), _on(time, y, j, then + duration)
            value = min(left, right, between)
            if value > best:
                best, start = value, t
            value = min(left_then, right_then, between)
            if value > best:
                best, start = value, then
            ahead, behind = left - right, left_then - right_then
            if ahead * behind < 0.0:  # the ends' lines meet on the way
                share = ahead / (ahead - behind)
                value = min(left + share * (left_then - left), between)
                if value > best:
                    best, start = value, t + share * (then - t)
        if next_end < next_start:  # both at once: the start first, so that its next segment is tried as well
            j += 1
            if j >= last:
                return best, start
            while tail > head and y[queue[tail - 1]] >= y[j]:
                tail -= 1
            queue[tail] = j
            tail += 1
        else:
            i += 1
            if tail > head and queue[head] <= i:
                head += 1
        t = then


@kernel
def highest_reached(  # noqa: C901, PLR0912, PLR0915 - one search
    time: Floats, y: Floats, duration: float, active: Ints
) -> float:
    """The highest level that y >= 0 is at or above for `duration` in all; (n,) each, at least `duration` long."""
    count = 0
    low, high = 0.0, 0.0
    for i in range(time.size - 1):
        high = max(high, y[i], y[i + 1])
        if time[i + 1] > time[i]:
            active[count] = i
            count += 1
    above = 0.0  # time above `high`, of the segments that are no longer active
    while True:
        # a sample's value strictly between: from the middle of what is left, for a pulse rises and falls in order
        pivot = -1.0
        for offset in range(count):
            i = active[(count // 2 + offset) % count]
            if low < y[i] < high:
                pivot = y[i]
                break
            if low < y[i + 1] < high:
                pivot = y[i + 1]
                break
        if pivot < 0.0:
            break
        spent = above
        for k in range(count):
            i = active[k]
            lower, upper = min(y[i], y[i + 1]), max(y[i], y[i + 1])
            if lower >= pivot:
                spent += time[i + 1] - time[i]
            elif upper > pivot:
                spent += (time[i + 1] - time[i]) * (upper - pivot) / (upper - lower)
        if spent >= duration:
            low = pivot
        else:
            high = pivot
        kept = 0
        for k in range(count):
            i = active[k]
            lower, upper = min(y[i], y[i + 1]), max(y[i], y[i + 1])
            if lower >= high:
                above += time[i + 1] - time[i]
            elif upper > low:
                active[kept] = i
                kept += 1
        count = kept
    # One straight piece: each segment left spans from low to high. Flat ones, at `high`, are above already.
    at_high, at_low = above, above
    for k in range(count):
        i = active[k]
        lower, upper = min(y[i], y[i + 1]), max(y[i], y[i + 1])
        length = time[i + 1] - time[i]
        if upper == lower:
            at_high += length if lower >= high else 0.0
            at_low += length if lower > low else 0.0
        else:
            at_high += length * max(upper - high, 0.0) / (upper - lower)
            at_low += length * (upper - low) / (upper - lower)
    if at_high >= duration:
        return high
    if at_low <= duration:
        return low
    return low + (high - low) * (at_low - duration) / (at_low - at_high)


@kernel
def each_highest(
    time: Floats,
    y: Floats,
    starts: Ints,
    duration: float,
    cumulative: bool,  # noqa: FBT001 - kernels take no keywords
    work: Ints,
    found: Floats,
) -> None:
    """The highest level of each of R signals end to end (see `strung`), held on end or in all, (R,); work: the longest."""
    for r in range(starts.size - 1):
        first, final = starts[r], starts[r + 1]
        if cumulative:
            found[r] = highest_reached(time[first:final], y[first:final], duration, work[: final - first])
        else:
            found[r], _ = highest_held(time[first:final], y[first:final], duration, work[: final - first])
