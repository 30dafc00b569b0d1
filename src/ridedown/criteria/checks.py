"""What every criterion asks of a signal before it computes anything, and the constants they share."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.errors import InvalidInput

Floats = NDArray[np.float64]
Table = np.ndarray[tuple[int, int], np.dtype[np.float64]]
"""Numbers in two dimensions, as the kernels' annotations say them."""

STANDARD_GRAVITY = 9.80665
"""m/s2, the g of every criterion: the standard acceleration of free fall (third CGPM, 1901)."""


def signal(time: ArrayLike, values: ArrayLike, name: str = "acceleration") -> tuple[Floats, Floats]:
    """Time [s] and values as plain arrays of doubles, (n,), fit for the kernels.

    Between two samples a signal is the straight line through them. Two samples at one time are a jump: the first is the value
    just before it, the second just after; of more at one time those between have no duration and are left out.

    Raises: InvalidInput for other shapes, fewer than two samples, anything not finite, time that falls, or no duration.
    """
    times, numbers = _column(time, "time"), _column(values, name)
    if times.size != numbers.size:
        raise InvalidInput(f"{name}: got {numbers.size} values; need {times.size}, one for each time. Check what was read.")
    if times.size < 2:
        raise InvalidInput(f"time: got {times.size} samples; need >= 2. A signal is what lies between its samples.")
    steps = np.diff(times)
    if steps.min() < 0.0:
        place = int(np.argmax(steps < 0.0))
        raise InvalidInput(
            f"time: got {times[place]:g} s and then {times[place + 1]:g} s at sample {place + 1}; need times that never fall. "
            "Sort the samples."
        )
    if not times[-1] > times[0]:
        raise InvalidInput(f"time: got a signal that lasts {times[-1] - times[0]:g} s; need > 0 s. Check the unit of time.")
    if steps.min() == 0.0:
        within = np.concatenate(([False], (steps[:-1] == 0.0) & (steps[1:] == 0.0), [False]))
        times, numbers = times[~within], numbers[~within]
    return times, numbers


def _column(values: ArrayLike, name: str) -> Floats:
    try:
        column = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as problem:
        raise InvalidInput(f"{name}: got {type(values).__name__}; need numbers. Give an array of shape (n,).") from problem
    if np.ndim(values) != 1:
        raise InvalidInput(f"{name}: got an array of shape {np.shape(values)}; need shape (n,). Give one channel at a time.")
    if not np.isfinite(column).all():
        place = int(np.argmin(np.isfinite(column)))
        raise InvalidInput(f"{name}: got {column[place]} at sample {place}; need finite numbers. Cut or mend the record there.")
    # Kernels are compiled for arrays that may be written; histories hand out theirs read-only.
    return column if column.flags.writeable else column.copy()


def number(value: float, name: str, unit: str, *, above: float | None = None) -> float:
    """A finite number, greater than `above` where that is given.

    Raises: InvalidInput otherwise.
    """
    rule = "a finite number" if above is None else f"> {above:g} {unit}"
    try:
        checked = float(value)
    except (TypeError, ValueError) as problem:
        raise InvalidInput(f"{name}: got {value!r}; need {rule}. Give it in {unit}.") from problem
    if not math.isfinite(checked) or (above is not None and not checked > above):
        raise InvalidInput(f"{name}: got {checked:g} {unit}; need {rule}. Give it in {unit}.")
    return checked


def from_time_zero(times: Floats, values: Floats, start: float | None, name: str = "start") -> tuple[Floats, Floats]:
    """The signal from `start` [s] on; where that is None, from time zero, or from the first sample where that is later.

    Time zero is first contact in every recorder's file (SAE J211), and what was recorded before it is standstill and drift:
    integrated, it would only shift the velocity at contact.

    Raises: InvalidInput for a start outside the signal.
    """
    if start is None:
        begin = max(float(times[0]), 0.0)
        if begin >= times[-1]:
            raise InvalidInput(
                f"time: got a signal that ends at {times[-1]:g} s; need one that goes beyond time zero, the first contact. "
                "Shift its time, or say where to begin with `start`."
            )
    else:
        begin = number(start, name, "s")
        if not times[0] <= begin < times[-1]:
            raise InvalidInput(f"{name}: got {begin:g} s; need {times[0]:g} <= start < {times[-1]:g} s, within the signal.")
    if begin == times[0]:
        return times, values
    after = int(np.searchsorted(times, begin, side="right"))
    before = after - 1
    if times[before] == begin:
        return times[before:].copy(), values[before:].copy()
    share = (begin - times[before]) / (times[after] - times[before])
    first = values[before] + share * (values[after] - values[before])
    return np.concatenate(([begin], times[after:])), np.concatenate(([first], values[after:]))


def magnitude(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """|values|, straight between samples again: a sample of 0 is put in where the line goes through zero."""
    if values.min() >= 0.0:
        return times, values
    size = np.abs(values)
    crossing = np.flatnonzero(values[:-1] * np.sign(values[1:]) < 0.0)
    crossing = crossing[times[crossing + 1] > times[crossing]]
    if crossing.size == 0:
        return times, size
    share = size[crossing] / (size[crossing] + size[crossing + 1])
    at = np.minimum(times[crossing] + share * (times[crossing + 1] - times[crossing]), times[crossing + 1])
    return np.insert(times, crossing + 1, at), np.insert(size, crossing + 1, 0.0)
