"""A measured or computed signal over time: values with their unit, when they were taken, and what was done to them.

Signs are those of SAE J211: x forward, y to the right, z down, seen by the vehicle or the dummy; a braking car's x
acceleration is negative. Between two values a signal is the straight line through them. Nothing here changes in place:
each operation gives a new history.

References:
    SAE J211-1, Instrumentation for Impact Test, Part 1, Electronic Instrumentation; signs: SAE J1733.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown import units
from ridedown.errors import InvalidInput

Floats = NDArray[np.float64]

LATEST = 1e12
"""s; a time beyond it is a mistake, and arithmetic with it soon overflows. Clocks that count from 1970 are at 2e9 s."""
SHORTEST = 1e-12
"""s; the shortest interval between even values. Recorders are a million times slower."""

_ON_GRID = 1e-6  # parts of an interval: how near the start must be to a multiple of the interval to be one


@dataclass(frozen=True, slots=True)
class Filter:
    """What a signal was filtered with: channel frequency class [Hz], the standard, and the filter before it, if any.

    standard: "SAE J211", "ISO 6487", or empty where only the class is known.

    >>> print(Filter(180, "SAE J211", after=Filter(1000)))
    CFC 180 (SAE J211) after CFC 1000
    """

    frequency_class: float
    standard: str = ""
    after: Filter | None = None

    def __str__(self) -> str:
        own = f"CFC {self.frequency_class:g}" + (f" ({self.standard})" if self.standard else "")
        return own if self.after is None else f"{own} after {self.after}"


@dataclass(frozen=True, slots=True, eq=False)
class TimeHistory:
    """A signal: `values` (n,) in `unit`, taken at `start + i interval` [s], or at `stamps` (n,) [s].

    stamps: never falling; two equal ones are a jump, the first value just before it and the second just after.
    unit: as `ridedown.units` spells it, "" for none; one that is not known there is kept as it stands, and cannot be
    converted. code: the 16-character ISO-MME channel code, where known. filtered: the channel class it went through; None
    where it is unfiltered or nobody says. remarks: what was found odd about it when it was read.

    A start that is a whole number of intervals is kept as just that, so that index 0 of a recording is at 0.0 s exactly.

    >>> pulse = TimeHistory([0.0, -20.0, -18.0], "g", start=-0.0001, interval=0.0001, name="crossmember X")
    >>> len(pulse), pulse.time.tolist(), pulse.sampling_rate
    (3, [-0.0001, 0.0, 0.0001], 10000.0)
    >>> pulse.converted("m/s2").values.tolist()
    [0.0, -196.133, -176.5197]

    Raises: InvalidInput for values or stamps that are not (n,) or not finite, no value at all, time that falls, an interval
    that is not > 0, both an interval and stamps, or neither.
    """

    values: Floats
    unit: str
    start: float = 0.0
    interval: float | None = None
    stamps: Floats | None = None
    name: str = ""
    code: str | None = None
    filtered: Filter | None = None
    remarks: tuple[str, ...] = ()

    def __init__(
        self,
        values: ArrayLike,
        unit: str,
        start: float = 0.0,
        interval: float | None = None,
        stamps: ArrayLike | None = None,
        name: str = "",
        code: str | None = None,
        filtered: Filter | None = None,
        remarks: tuple[str, ...] = (),
    ) -> None:
        called = f"{name}.values" if name else "values"
        numbers = _column(values, called)
        if numbers.size == 0:
            raise InvalidInput(f"{called}: got no value; need one at least. Leave out a channel that was not recorded.")
        if (interval is None) == (stamps is None):
            got = "both an interval and stamps" if stamps is not None else "neither an interval nor stamps"
            raise InvalidInput(f"{name or 'history'}: got {got}; need one of them. Give the interval if evenly sampled.")
        if interval is not None:
            start, interval = _grid(float(start), float(interval), numbers.size, name or "history")
        times = None if stamps is None else _times(stamps, numbers.size, name or "history")
        put = object.__setattr__
        put(self, "values", numbers)
        put(self, "unit", units.recognised(unit))
        put(self, "start", start if times is None else float(times[0]))
        put(self, "interval", interval)
        put(self, "stamps", times)
        put(self, "name", name)
        put(self, "code", code)
        put(self, "filtered", filtered)
        put(self, "remarks", tuple(remarks))

    def __len__(self) -> int:
        return self.values.size

    def __repr__(self) -> str:
        rate = "at stamps" if self.interval is None else f"at {self.sampling_rate:g} Hz"
        state = f", {self.filtered}" if self.filtered else ""
        return f"<TimeHistory {self.name!r} [{self.unit}] {len(self)} values {rate}, {self.start:g} .. {self.end:g} s{state}>"

    # when

    @property
    def time(self) -> Floats:
        """Time of each value [s], (n,)."""
        return sample_times(self.start, self.interval, len(self)) if self.stamps is None else self.stamps

    @property
    def sampling_rate(self) -> float:
        """Values a second [Hz].

        Raises: InvalidInput where the signal is not evenly sampled.
        """
        if self.interval is None:
            raise InvalidInput(
                f"{self.name or 'history'}.interval: got stamps; need an even interval. "
                "Use ridedown.signals.resampled to sample it evenly."
            )
        return 1.0 / self.interval

    @property
    def end(self) -> float:
        """Time of the last value [s]."""
        return float(self.time[-1])

    @property
    def duration(self) -> float:
        """Time from the first value to the last [s]."""
        return self.end - self.start

    # in other units, under other names

    @property
    def si(self) -> tuple[Floats, Floats]:
        """Time [s] and values in SI, both (n,), as criteria take them: `criteria.hic(*history.si)`.

        Raises: InvalidInput where the unit is not known.
        """
        return self.time, units.convert(self.values, self.unit)

    def converted(self, unit: str) -> TimeHistory:
        """The same signal in another unit of the same dimension.

        Raises: InvalidInput for a unit that is not known or of another dimension.
        """
        return self.replaced(values=units.convert(self.values, self.unit, unit), unit=unit)

    def renamed(self, name: str, code: str | None = None) -> TimeHistory:
        """The same signal under another name, and another channel code where one is given."""
        return self.replaced(name=name, code=self.code if code is None else code)

    def replaced(self, **fields: Any) -> TimeHistory:
        """The same signal but for the fields given, each checked as a new one is."""
        return replace(self, **fields)

    def identical(self, other: TimeHistory) -> bool:
        """Whether both hold the same values at the same times, bit for bit, in the same unit, filter state and code."""
        return (
            np.array_equal(self.values, other.values)
            and np.array_equal(self.time, other.time)
            and (self.unit, self.code, self.filtered) == (other.unit, other.code, other.filtered)
        )


def sample_times(start: float, interval: float | None, count: int) -> Floats:
    """Times [s] of `count` evenly spaced values, (count,): whole multiples of the interval wherever the start is one.

    An interval that is one part of a whole number, 1/10000 s, counts as just that: value 3 is then at 0.0003 s and not at
    0.00030000000000000003 s, as `3 * 0.0001` is.

    >>> sample_times(-0.0001, 0.0001, 5).tolist()
    [-0.0001, 0.0, 0.0001, 0.0002, 0.0003]
    """
    if interval is None:
        raise InvalidInput("interval: got None; need the time between two values. Give it in seconds.")
    first = start / interval
    nearest = round(first)
    if abs(first - nearest) > _ON_GRID:
        return start + interval * np.arange(count, dtype=np.float64)
    whole = np.arange(nearest, nearest + count, dtype=np.float64)
    rate = round(1.0 / interval)
    times: Floats = whole / rate if rate > 0 and 1.0 / rate == interval else whole * interval
    return times


def _grid(start: float, interval: float, count: int, name: str) -> tuple[float, float]:
    if not SHORTEST <= interval <= LATEST:
        raise InvalidInput(f"{name}.interval: got {interval:g} s; need > 0 s, and no less than {SHORTEST:g} s. Check its unit.")
    if not (abs(start) <= LATEST and abs(start) / interval < 1e15 and interval * count <= LATEST):
        raise InvalidInput(f"{name}.start: got {start:g} s; need a time near the recording. Give that of the first value.")
    return float(sample_times(start, interval, 1)[0]), interval


def _times(stamps: ArrayLike, count: int, name: str) -> Floats:
    times = _column(stamps, f"{name}.stamps")
    if times.size != count:
        raise InvalidInput(f"{name}.stamps: got {times.size} times; need {count}, one for each value. Check what was read.")
    if not np.abs(times).max() <= LATEST:
        raise InvalidInput(f"{name}.stamps: got {times[-1]:g} s; need times within {LATEST:g} s of zero. Check their unit.")
    falls = np.flatnonzero(times[1:] < times[:-1])
    if falls.size:
        i = int(falls[0])
        raise InvalidInput(
            f"{name}.stamps: got {times[i]:g} s and then {times[i + 1]:g} s at value {i + 1}; need times that never fall. "
            "Sort the values."
        )
    return times


def _column(values: ArrayLike, called: str) -> Floats:
    """Values as an array of its own that nothing can write to."""
    try:
        column = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as problem:
        raise InvalidInput(f"{called}: got {type(values).__name__}; need numbers. Give an array of shape (n,).") from problem
    if column.ndim != 1:
        raise InvalidInput(f"{called}: got an array of shape {column.shape}; need shape (n,). Give one channel at a time.")
    if not np.isfinite(column).all():
        i = int(np.argmin(np.isfinite(column)))
        raise InvalidInput(f"{called}: got {column[i]} at value {i}; need finite numbers. Cut or mend the recording there.")
    column.setflags(write=False)
    return column
