"""The curves of an EV5 test: a file for each, `time<TAB>value` a line or one value a line.

Sample i of a curve is taken at t_i = i DELT 1e-6 s, i = NFP..NLP, with index 0 at time zero. Where a file has a column of
times and it says otherwise than the header, the file's own times count, as they stand beside the values, and the
contradiction is said. Samples that are missing at the end, or too many, are said too; nothing is filled in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.signals.numerals import Floats, lines_of, numbers_of

MAX_SAMPLES = 10_000_000
"""Samples of one curve at most; the longest recordings of the database have some 100,000."""

ROUNDING = 0.05
"""How far a file's times may be from the header's, in parts of a sample interval, before it counts as a contradiction:
times are printed to a microsecond, which is a hundredth of the interval at 10 kHz."""


@dataclass(frozen=True, slots=True)
class Grid:
    """When a curve was sampled, as the header has it: index of the first and last sample, and the interval [s]."""

    first: int
    last: int
    interval: float

    @property
    def count(self) -> int:
        """How many samples that is."""
        return self.last - self.first + 1

    @property
    def start(self) -> float:
        """Time of the first sample [s]."""
        return self.first * self.interval

    @property
    def end(self) -> float:
        """Time of the last sample [s]."""
        return self.last * self.interval


@dataclass(frozen=True, slots=True)
class Curve:
    """One curve: values (n,), evenly sampled from `start` [s] at `interval` [s], or at `stamps` (n,) [s]; and remarks."""

    values: Floats
    start: float
    interval: float | None
    stamps: Floats | None
    remarks: tuple[str, ...]


def read_curve(text: str, grid: Grid | None, where: str) -> Curve:
    r"""A curve of the text of its file; `grid` None where the header does not say when it was sampled.

    >>> read_curve("-0.0001\t1.5\n0.0000\t2.5\n", Grid(-1, 0, 1e-4), "v1.001").values
    array([1.5, 2.5])

    Raises: InvalidInput, naming file and line, where it holds anything but numbers in one or two columns, or no times.
    """
    lines = lines_of(text.rstrip())
    first = 1
    while lines and not lines[0].strip():
        lines, first = lines[1:], first + 1
    if not lines:
        raise InvalidInput(f"{where}:1: got an empty file; need a curve. Fetch the file again.")
    if len(lines) > MAX_SAMPLES:
        raise InvalidInput(f"{where}: got {len(lines)} lines; need at most {MAX_SAMPLES}. Split the curve.")
    columns = [line.split() for line in lines]
    width = len(columns[0])
    uneven = next((i for i, parts in enumerate(columns) if len(parts) != width), None)
    if width not in {1, 2} or uneven is not None:
        line = uneven or 0
        rule = "one or two numbers" if uneven is None else f"{width} number{'s' * (width > 1)} as on the lines before"
        raise InvalidInput(f"{where}:{line + first}: got {lines[line].strip()[:40]!r}; need {rule}. Correct the line.")
    values = numbers_of([parts[-1] for parts in columns], where, first)
    remarks = list(_count_remarks(values.size, grid, where))
    if width == 1:
        if grid is None:
            raise InvalidInput(f"{where}: got values without times; need DELT and NFP in the header. Complete the header.")
        return Curve(values, grid.start, grid.interval, None, tuple(remarks))
    times = numbers_of([parts[0] for parts in columns], where, first)
    return _timed(values, times, grid, where, first, remarks)


def _count_remarks(count: int, grid: Grid | None, where: str) -> tuple[str, ...]:
    if grid is None or count == grid.count:
        return ()
    if count < grid.count:
        return (f"{where}: ends early, {count} samples of the {grid.count} that the header gives",)
    return (f"{where}: holds {count} samples; the header gives {grid.count}",)


def _timed(values: Floats, times: Floats, grid: Grid | None, where: str, first: int, remarks: list[str]) -> Curve:
    falls = np.flatnonzero(np.diff(times) < 0.0)
    if falls.size:
        line = int(falls[0]) + 1 + first
        raise InvalidInput(
            f"{where}:{line}: got time {times[falls[0] + 1]:g} s after {times[falls[0]]:g} s; need times that never fall. "
            "Correct the line."
        )
    if grid is not None:
        expected = grid.start + grid.interval * np.arange(times.size)
        worst = float(np.abs(times - expected).max())
        if worst <= max(ROUNDING * grid.interval, 0.51e-6):
            return Curve(values, grid.start, grid.interval, None, tuple(remarks))
        remarks.append(
            f"{where}: its times, {times[0]:g} .. {times[-1]:g} s, are up to {worst:.3g} s from those of the header, "
            f"{grid.start:g} .. {grid.end:g} s; its own count"
        )
    if times.size >= 2:
        interval = float(times[-1] - times[0]) / (times.size - 1)
        even = times[0] + interval * np.arange(times.size)
        if interval > 0.0 and float(np.abs(times - even).max()) <= max(ROUNDING * interval, 0.51e-6):
            return Curve(values, float(times[0]), interval, None, tuple(remarks))
    return Curve(values, float(times[0]), None, times, tuple(remarks))
