"""The search behind HIC: the best window of a signal that is straight between its samples, exactly.

With velocity V (the integral of a), a window (t1, t2) of length T with D = V(t2) - V(t1) has HIC^2 = D^5 / T^3 = T^2 (D/T)^5.
All pairs of times are searched by halving: a pair of blocks of segments, t1 in the one and t2 in the other, is left out when
nothing in it can beat the best window found so far. Over a block, a is at most its largest sample, so D is at most linear in
t1 and t2; T (D/T)^2.5 is convex in (D, T), so that bound is largest at a corner of the blocks, cut by T <= window. Where a
pair is down to two segments, D is quadratic in t1 and in t2 and the best window in it is found in closed form.
"""

from __future__ import annotations

import math

import numpy as np

from ridedown.compiled import inlined, kernel, part
from ridedown.criteria.checks import Floats, Table
from ridedown.criteria.strung import Ints, Strung

# What a window may gain and still be passed over, relative in HIC^2: rounding of V is of that size.
_SLACK = 1e-12

_Stack = np.ndarray[tuple[int, int], np.dtype[np.int64]]

Window = tuple[float, float, float]
"""HIC^2, start and end [s]."""


@inlined
def _square(gain: float, length: float) -> float:
    """HIC^2 of a window of this length in which the velocity gains so much; none for a loss."""
    rate = gain / length if gain > 0.0 and length > 0.0 else 0.0
    return length * length * rate * rate * rate * rate * rate


@part
def _roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Real roots of a x^2 + b x + c, without cancellation; NaN for those that do not exist."""
    inside = b * b - 4.0 * a * c
    if inside < 0.0:
        return math.nan, math.nan
    q = -0.5 * (b + math.copysign(math.sqrt(inside), b))
    first = q / a if a != 0.0 else math.nan
    second = c / q if q != 0.0 else math.nan
    return first, second


@part
def _bound(apart: float, gain: float, left: float, right: float, most_left: float, most_right: float, window: float) -> float:
    """Most that HIC^2 can be with t1 up to `left` before, t2 up to `right` after, an interval `apart` long that gains `gain`.

    `most_left`, `most_right`: the largest acceleration on either side. A corner beyond the window is replaced by the two points
    where the sides that meet in it are as long as the window.
    """
    if apart > window:
        return 0.0
    best = _square(gain, apart)
    p = min(left, window - apart)
    q = min(right, window - apart)
    best = max(best, _square(gain + most_left * p, apart + p))
    best = max(best, _square(gain + most_right * q, apart + q))
    rest = min(right, window - apart - p)
    best = max(best, _square(gain + most_left * p + most_right * rest, apart + p + rest))
    rest = min(left, window - apart - q)
    return max(best, _square(gain + most_left * rest + most_right * q, apart + rest + q))


@part
def _sample_pair(
    time: Floats, velocity: Floats, i: int, j: int, window: float, best: float, start: float, end: float
) -> Window:
    """The best window between ends of segments i and j, if better than the `best` (HIC^2) known."""
    for m in range(i, i + 2):
        for n in range(j, j + 2):
            length = time[n] - time[m]
            if length <= window:
                value = _square(velocity[n] - velocity[m], length)
                if value > best:
                    best, start, end = value, time[m], time[n]
    return best, start, end


@part
def _segment_pair(  # noqa: C901, PLR0912 - one derivation
    time: Floats, a: Floats, velocity: Floats, i: int, j: int, window: float, best: float, start: float, end: float
) -> Window:
    """The best window with t1 in segment i and t2 in segment j, if better than the `best` (HIC^2) known.

    t1 = time[i] + s1, t2 = time[j] + s2. HIC is stationary in t2 where a(t2) = 0.6 D/T, in t1 where a(t1) = 0.6 D/T; along
    T = window where a(t1) = a(t2). Each is at most quadratic here. Ends of the ranges are tried as well: the best window may
    begin or end with the record, at a jump or at a kink.
    """
    h1, h2 = time[i + 1] - time[i], time[j + 1] - time[j]
    a1, a2 = a[i], a[j]
    b1, b2 = (a[i + 1] - a[i]) / h1, (a[j + 1] - a[j]) / h2
    apart, gain = time[j] - time[i], velocity[j] - velocity[i]
    for end1 in range(2):  # t1 at an end of its segment
        s1 = h1 * end1
        rest, more = apart - s1, gain - s1 * (a1 + 0.5 * b1 * s1)
        x, y = _roots(0.7 * b2, b2 * rest + 0.4 * a2, a2 * rest - 0.6 * more)
        for s2 in (0.0, h2, x, y):
            if 0.0 <= s2 <= h2 and rest + s2 <= window:
                value = _square(more + s2 * (a2 + 0.5 * b2 * s2), rest + s2)
                if value > best:
                    best, start, end = value, time[i] + s1, time[j] + s2
    for end2 in range(2):  # t2 at an end of its segment
        s2 = h2 * end2
        rest, more = apart + s2, gain + s2 * (a2 + 0.5 * b2 * s2)
        x, y = _roots(-0.7 * b1, b1 * rest - 0.4 * a1, a1 * rest - 0.6 * more)
        for s1 in (x, y):
            if 0.0 <= s1 <= h1 and rest - s1 <= window:
                value = _square(more - s1 * (a1 + 0.5 * b1 * s1), rest - s1)
                if value > best:
                    best, start, end = value, time[i] + s1, time[j] + s2
    if b1 > 0.0 > b2:  # a maximum in both at once has a rising at t1 and falling at t2; level = a(t1) = a(t2)
        q = 1.0 / b2 - 1.0 / b1
        p = apart - a2 / b2 + a1 / b1
        c = gain - 0.5 * a2 * a2 / b2 + 0.5 * a1 * a1 / b1
        x, y = _roots(0.7 * q, p, -0.6 * c)
        for level in (x, y):
            s1, s2 = (level - a1) / b1, (level - a2) / b2
            length = apart + s2 - s1
            if 0.0 <= s1 <= h1 and 0.0 <= s2 <= h2 and length <= window:
                value = _square(gain + s2 * (a2 + 0.5 * b2 * s2) - s1 * (a1 + 0.5 * b1 * s1), length)
                if value > best:
                    best, start, end = value, time[i] + s1, time[j] + s2
    shift = window - apart  # s2 = s1 + shift: as long as the window
    low, high = max(0.0, -shift), min(h1, h2 - shift)
    if low <= high:
        turn = (a2 + b2 * shift - a1) / (b1 - b2) if b1 != b2 else low
        for s1 in (low, high, min(max(turn, low), high)):
            s2 = s1 + shift
            value = _square(gain + s2 * (a2 + 0.5 * b2 * s2) - s1 * (a1 + 0.5 * b1 * s1), window)
            if value > best:
                best, start, end = value, time[i] + s1, time[j] + s2
    return best, start, end


@part
def _prepare(time: Floats, a: Floats, velocity: Floats, least: Floats, most: Floats, highest: Floats) -> None:
    """Velocity at the samples; its least and most, and the highest acceleration, over the segments and all blocks of them.

    Blocks are numbered as in a heap: 1 is the whole, 2 k and 2 k + 1 are the halves of k, the segments come last.
    """
    size = least.size // 2
    segments = time.size - 1
    velocity[0] = 0.0
    for i in range(segments):
        h = time[i + 1] - time[i]
        velocity[i + 1] = velocity[i] + 0.5 * h * (a[i] + a[i + 1])
        low, high = min(velocity[i], velocity[i + 1]), max(velocity[i], velocity[i + 1])
        if (a[i] < 0.0) != (a[i + 1] < 0.0):
            turn = velocity[i] + 0.5 * h * a[i] * a[i] / (a[i] - a[i + 1])
            low, high = min(low, turn), max(high, turn)
        least[size + i], most[size + i], highest[size + i] = low, high, max(a[i], a[i + 1])
    for i in range(segments, size):
        least[size + i], most[size + i], highest[size + i] = math.inf, -math.inf, -math.inf
    for k in range(size - 1, 0, -1):
        least[k] = min(least[2 * k], least[2 * k + 1])
        most[k] = max(most[2 * k], most[2 * k + 1])
        highest[k] = max(highest[2 * k], highest[2 * k + 1])


@part
def _full_windows(time: Floats, velocity: Floats, window: float) -> Window:
    """The best window of nearly full length between two samples: a first value to beat."""
    best, start, end = 0.0, time[0], time[0]
    j = 0
    for i in range(time.size - 1):
        while j < time.size - 1 and time[j + 1] - time[i] <= window:
            j += 1
        value = _square(velocity[j] - velocity[i], time[j] - time[i])
        if value > best:
            best, start, end = value, time[i], time[j]
    return best, start, end


@part
def _block_bound(
    time: Floats, velocity: Floats, least: Floats, most: Floats, highest: Floats,
    j: int, k: int, first: int, last: int, begin: int, finish: int, window: float,
) -> float:  # fmt: skip
    """Most that HIC^2 can be with t1 in block j (segments from first up to last), t2 in block k (begin, finish)."""
    if j == k:
        length = min(time[last] - time[first], window)
        return _square(max(highest[j], 0.0) * length, length)
    apart = time[begin] - time[last]
    gain = most[k] - least[j]
    if apart > window or gain <= 0.0:
        return 0.0
    left, right = time[last] - time[first], time[finish] - time[begin]
    most_left, most_right = max(highest[j], 0.0), max(highest[k], 0.0)
    by_rate = _bound(apart, velocity[begin] - velocity[last], left, right, most_left, most_right, window)
    return by_rate if apart == 0.0 else min(by_rate, _square(gain, apart))


@kernel
def best_window(
    time: Floats, a: Floats, window: float, sampled: bool,  # noqa: FBT001 - kernels take no keywords
    velocity: Floats, least: Floats, most: Floats, highest: Floats, stack: _Stack,
) -> Window:  # fmt: skip
    """HIC^2 of the best window of at most this length, in the unit of `a`, its start and its end [s].

    time, a, velocity: (n,); least, most, highest: (2 m,), m a power of two, at least n - 1; stack: (3 * 64 + 4, 3).
    sampled: windows begin and end at samples only.
    """
    _prepare(time, a, velocity, least, most, highest)
    best, start, end = _full_windows(time, velocity, window)
    size = least.size // 2
    segments = time.size - 1
    stack[0, 0], stack[0, 1], stack[0, 2] = 1, 1, size
    depth = 1
    while depth > 0:
        depth -= 1
        j, k, width = stack[depth, 0], stack[depth, 1], stack[depth, 2]
        first, begin = j * width - size, k * width - size
        if begin >= segments:
            continue
        last, finish = min(first + width, segments), min(begin + width, segments)
        if _block_bound(time, velocity, least, most, highest, j, k, first, last, begin, finish, window) <= best * (
            1.0 + _SLACK
        ):
            continue
        if width > 1:
            half = width // 2
            for pair in range(4):
                one, two = 2 * j + pair // 2, 2 * k + pair % 2
                if one <= two:
                    stack[depth, 0], stack[depth, 1], stack[depth, 2] = one, two, half
                    depth += 1
        elif sampled:
            best, start, end = _sample_pair(time, velocity, first, begin, window, best, start, end)
        elif last > first and time[last] > time[first] and time[finish] > time[begin]:
            best, start, end = _segment_pair(time, a, velocity, first, begin, window, best, start, end)
    return best, start, end


@kernel
def each_best(time: Floats, a: Floats, starts: Ints, window: float, work: Table, stack: _Stack, found: Table) -> None:
    """HIC^2 of each of R signals end to end (see `strung`) in units of its largest sample, and that sample: (R, 2).

    work: (5, 2 m), m a power of two, at least as many as the longest has samples.
    """
    for r in range(starts.size - 1):
        first, final = starts[r], starts[r + 1]
        scale = 0.0
        for i in range(first, final):
            scale = max(scale, a[i])
        found[r, 0], found[r, 1] = 0.0, scale
        if scale == 0.0:
            continue
        scaled, velocity = work[3], work[4]
        for i in range(first, final):
            scaled[i - first] = a[i] / scale
        n = final - first
        size = 1
        while size < n - 1:
            size *= 2
        found[r, 0], _, _ = best_window(
            time[first:final], scaled[:n], window, False, velocity[:n],  # noqa: FBT003 - kernels take no keywords
            work[0][: 2 * size], work[1][: 2 * size], work[2][: 2 * size], stack,
        )  # fmt: skip


def search_each(signals: Strung, window: float) -> Floats:
    """As `search`, of signals that are nowhere below 0, each in units of its largest sample: HIC^2 and that sample, (R, 2)."""
    size = 1 << signals.longest.bit_length()
    found = np.empty((signals.count, 2))
    stack = np.empty((3 * 64 + 4, 3), dtype=np.int64)
    each_best(signals.time, signals.values, signals.starts, window, np.empty((5, 2 * size)), stack, found)
    return found


def search(times: Floats, a: Floats, window: float, *, sampled: bool) -> Window:
    """HIC^2 in the unit of `a`, start and end [s] of the best window of at most this length."""
    size = 1 << (times.size - 2).bit_length() if times.size > 2 else 1
    work = np.empty((3, 2 * size))
    stack = np.empty((3 * 64 + 4, 3), dtype=np.int64)
    found = best_window(times, a, window, sampled, np.empty(times.size), work[0], work[1], work[2], stack)
    return float(found[0]), float(found[1]), float(found[2])
