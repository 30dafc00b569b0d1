"""What a body part may bear: head injury criterion, severity index, and the level held for 3 ms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria import levels, windows
from ridedown.criteria.checks import STANDARD_GRAVITY, Floats, magnitude, number, signal
from ridedown.criteria.powers import severity
from ridedown.criteria.strung import Strung
from ridedown.errors import InvalidInput

# Two times a window apart differ from it by what their own rounding makes; an interval in samples is meant exactly.
_ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class HIC:
    """Head injury criterion, `value` [s g^2.5, written without a unit], and its window from `start` to `end` [s]."""

    value: float
    start: float
    end: float

    @property
    def duration(self) -> float:
        """Of the window [s]; it may be shorter than the longest allowed."""
        return self.end - self.start


@dataclass(frozen=True, slots=True)
class Clip:
    """The level held, `value` [m/s2].

    start, end: of the interval that it is held on [s]; where cumulative, the first and the last moment at that level.
    """

    value: float
    start: float
    end: float

    @property
    def value_g(self) -> float:
        """The level [g]."""
        return self.value / STANDARD_GRAVITY


def hic(
    time: ArrayLike, acceleration: ArrayLike, *, max_window: float = 0.015, signed: bool = False, sampled: bool = False
) -> HIC:
    """Head injury criterion: the largest (t2 - t1) [mean of a from t1 to t2]^2.5 with t2 - t1 <= max_window, a in g, t in s.

    Exact over the signal that is straight between its samples: both ends of the window are free, within a sample too, and the
    window may be shorter than the longest. Windows lie within the record. Where several are equally bad, one of them is given.

    time: (n,) [s], never falling; two equal times are a jump. acceleration: (n,) [m/s2], the resultant of the head's centre of
    gravity, CFC 1000. max_window [s]: 0.015 for HIC15, 0.036 for HIC36.
    signed: take a signal of one axis with its sign, so that a window whose mean is negative counts nothing. If left out, its
    magnitude counts, which is the resultant of one axis: a head that is braked is not better off for the sign.
    sampled: windows from sample to sample only; never above the exact value of a resultant.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), or a window that is not above 0 s.

    References: 49 CFR 571.208 (FMVSS 208), S6.2 (HIC15 and HIC36); J. Versace, "A review of the severity index", SAE 710881,
    1971.

    >>> import numpy as np
    >>> time = np.linspace(0.0, 0.010, 101)
    >>> pulse = 100 * 9.80665 * np.sin(np.pi * time / 0.010)  # a half-sine of 100 g and 10 ms
    >>> found = hic(time, pulse)
    >>> f"{found.value:.1f} from {1e3 * found.start:.2f} to {1e3 * found.end:.2f} ms"  # 414.6 for the smooth half-sine
    '414.6 from 1.65 to 8.35 ms'
    """
    times, a = signal(time, acceleration)
    window = number(max_window, "max_window", "s", above=0.0)
    if sampled:
        window *= 1.0 + _ROUNDING
        a = a if signed else np.abs(a)
    elif not signed:
        times, a = magnitude(times, a)
    scale = float(np.max(np.abs(a)))  # fifth powers of the search stay near 1 whatever the unit's size
    if scale == 0.0:
        return HIC(0.0, float(times[0]), float(times[0]))
    square, start, end = windows.search(times, a / scale, window, sampled=sampled)
    with np.errstate(over="ignore"):
        return HIC(_value_of(square, scale), start, end)


def hic_of(signals: Strung, max_window: float) -> Floats:
    """HIC of R signals end to end, none of them anywhere below 0 [m/s2]: (R,). Raises: InvalidInput as `hic` does."""
    with np.errstate(over="ignore"):
        return np.array([_value_of(float(square), float(scale)) for square, scale in windows.search_each(signals, max_window)])


def _value_of(square: float, scale: float) -> float:
    """HIC from its square for accelerations in units of `scale` [m/s2]; what overflows is refused, and no warning is wanted."""
    value = float(np.sqrt(square) * np.float64(scale / STANDARD_GRAVITY) ** 2.5)
    if not np.isfinite(value):
        raise InvalidInput(f"acceleration: got a peak of {scale:g} m/s2; need one that a head can have. Check its unit.")
    return value


def hic_by_sum(time: ArrayLike, acceleration: ArrayLike, *, max_window: float = 0.015) -> HIC:
    """Head injury criterion by a plain sum of samples: each counts for the time from it to the next, as a laboratory has it.

    The largest (t2 - t1) [sum of a dt / (t2 - t1)]^2.5 with both t1 and t2 at samples and the sum over the samples from t1 up
    to the one before t2. It is HIC of the staircase through the samples, not of the line, and so about half a sample late. It
    gives the official intervals of NHTSA test 10146 to the last printed digit, and `hic` does not: that laboratories use this
    rule is inferred from there. To compare with their results only; `hic` is the criterion.

    time, acceleration, max_window: as of `hic`. The magnitude counts.

    Raises: InvalidInput as `hic` does.

    >>> import numpy as np
    >>> time = np.linspace(0.0, 0.010, 101)
    >>> found = hic_by_sum(time, 100 * 9.80665 * np.sin(np.pi * time / 0.010))
    >>> f"{found.value:.1f} from {1e3 * found.start:.2f} to {1e3 * found.end:.2f} ms"  # `hic`: from 1.65 to 8.35 ms
    '414.7 from 1.70 to 8.40 ms'
    """
    times, a = signal(time, acceleration)
    # two samples at one time are a jump, so the staircase is a signal like any other
    return hic(np.repeat(times, 2)[1:-1], np.repeat(a[:-1], 2), max_window=max_window, sampled=True)


def severity_index(time: ArrayLike, acceleration: ArrayLike) -> float:
    """Gadd's severity index: the integral of |a|^2.5 over the record, a in g, t in s [s g^2.5, written without a unit].

    Exact over the signal that is straight between its samples. HIC with no limit to its window is never above it.

    time: (n,) [s]; acceleration: (n,) [m/s2], a resultant, or one axis, whose magnitude counts.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`).

    References: C. W. Gadd, "Use of a weighted-impulse criterion for estimating injury hazard", SAE 660793, 1966.

    >>> round(severity_index([0.0, 0.010], [50 * 9.80665, 50 * 9.80665]), 3)  # 50^2.5 times 10 ms
    176.777
    """
    return float(severity_of(Strung.one(*magnitude(*signal(time, acceleration))))[0])


def severity_of(signals: Strung) -> Floats:
    """The severity index of R signals end to end, none of them anywhere below 0 [m/s2]: (R,)."""
    found = np.empty(signals.count)
    severity(signals.time, signals.values, signals.starts, STANDARD_GRAVITY, found)
    return found


def clip(time: ArrayLike, acceleration: ArrayLike, *, duration: float = 0.003, cumulative: bool = False) -> Clip:
    """The highest level that the magnitude of a signal holds for a time: the 3 ms clip.

    Exact over the signal that is straight between its samples. Continuous: held on one interval of that duration, within the
    record. Cumulative: the intervals at or above the level add up to it. Cumulative is never below continuous.

    time: (n,) [s]; acceleration: (n,) [m/s2], the resultant of the chest (CFC 180) or of the head (CFC 1000), or one axis,
    whose magnitude counts. duration [s].

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), or one shorter than the duration.

    References: 49 CFR 571.208 (FMVSS 208), S6.3: 60 g but for intervals whose *cumulative* duration is not more than 3 ms.
    UN R94 and Euro NCAP TB 021 take it cumulative as well, SAE J1727 has both (the three from memory).

    >>> time, pulse = [0.0, 0.030, 0.060], [0.0, 50 * 9.80665, 0.0]  # a triangle of 50 g and 60 ms
    >>> found = clip(time, pulse)
    >>> f"{found.value_g:.2f} g from {1e3 * found.start:.2f} to {1e3 * found.end:.2f} ms"
    '47.50 g from 28.50 to 31.50 ms'
    """
    times, a = magnitude(*signal(time, acceleration))
    length = _held_for(times, duration)
    work = np.empty(times.size, dtype=np.int64)
    if cumulative:
        value = float(levels.highest_reached(times, a, length, work))
        return Clip(value, *_first_and_last(times, a, value))
    value, start = levels.highest_held(times, a, length, work)
    return Clip(float(value), float(start), float(start) + length)


def clip_of(signals: Strung, duration: float = 0.003, *, cumulative: bool = False) -> Floats:
    """The clip of R signals end to end, all as long, nowhere below 0 [m/s2]: (R,). Raises: InvalidInput as `clip`."""
    length = _held_for(signals.time[: signals.starts[1]], duration)
    found, work = np.empty(signals.count), np.empty(signals.longest, dtype=np.int64)
    levels.each_highest(signals.time, signals.values, signals.starts, length, cumulative, work, found)
    return found


def _held_for(times: Floats, duration: float) -> float:
    """The duration, at most as long as the signal. Raises: InvalidInput for a longer one."""
    length = number(duration, "duration", "s", above=0.0)
    lasts = float(times[-1] - times[0])
    if length > lasts * (1.0 + _ROUNDING):
        raise InvalidInput(
            f"time: got a signal of {lasts:g} s; need >= {length:g} s, the duration. A level cannot be held longer."
        )
    return min(length, lasts)


def _first_and_last(times: Floats, a: Floats, level: float) -> tuple[float, float]:
    """The first and the last moment at which the signal is at or above a level that it reaches."""
    above = np.flatnonzero(a >= level)
    return _crossing(times, a, above[0], above[0] - 1, level), _crossing(times, a, above[-1], above[-1] + 1, level)


def _crossing(times: Floats, a: Floats, i: int, beside: int, level: float) -> float:
    """When the line from sample i, at or above the level, to the one beside it, if there is one, passes the level."""
    if not 0 <= beside < times.size:
        return float(times[i])
    return float(times[i] + (a[i] - level) / (a[i] - a[beside]) * (times[beside] - times[i]))
