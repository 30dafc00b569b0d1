"""What is done to signals between recording and judging: each function takes histories and gives a new one.

A signal is the straight line through its values, and is treated as just that: integrals are exact, ends and new times are
interpolated. Signs are those of SAE J211 (x forward: a braking car is negative) and stay as they are unless `reversed_sign`
turns them. A filter state goes along wherever it still holds: filtering and integrating may change places, and a sum or a
resultant is filtered alike only if its parts are.
"""

from __future__ import annotations

import math

import numpy as np

from ridedown import units
from ridedown.errors import InvalidInput
from ridedown.signals.codes import ChannelCode
from ridedown.signals.filters import LEAST_SAMPLES_PER_CLASS
from ridedown.signals.history import Filter, Floats, TimeHistory, sample_times

MAX_SAMPLES = 10_000_000
"""Values of one resampled signal at most: ten seconds at 1 MHz."""

_INTEGRALS = {
    units.JERK: units.ACCELERATION,
    units.ACCELERATION: units.SPEED,
    units.SPEED: units.LENGTH,
    units.ANGULAR_ACCELERATION: units.ANGULAR_VELOCITY,
    units.ANGULAR_VELOCITY: units.ANGLE,
    units.FORCE: units.IMPULSE,
    units.POWER: units.ENERGY,
}
_DERIVATIVES = {integral: rate for rate, integral in _INTEGRALS.items()}

_SAME_TIME = 1e-6  # parts of an interval within which two times are one


# integrals and derivatives


def integrated(history: TimeHistory, *, initial: float = 0.0, at: float | None = None) -> TimeHistory:
    """The integral over time, in SI: an acceleration gives m/s, a speed m, a force N s.

    Exact at every value's time for the straight lines between the values. initial: the integral [SI] at time `at` [s], the
    start where left out: `integrated(pulse, initial=15.86, at=0.0)` is the velocity of a car that came at 15.86 m/s.

    >>> pulse = TimeHistory([0.0, -100.0, -100.0], "m/s2", start=-0.01, interval=0.01)
    >>> integrated(pulse, initial=10.0, at=0.0).values.tolist()
    [10.5, 10.0, 9.0]

    Raises: InvalidInput for a unit whose integral has no name here, fewer than two values, or a time outside the signal.
    """
    rate = units.dimension(history.unit)
    if rate not in _INTEGRALS:
        raise InvalidInput(f"{_called(history)}.unit: got {history.unit!r}, {rate.called}; need {_named(_INTEGRALS)}.")
    _need_two(history)
    time, values = history.si
    integral = np.concatenate(([0.0], np.cumsum(np.diff(time) * 0.5 * (values[1:] + values[:-1]))))
    if at is not None:
        _within(history, at, "at")
        i = min(max(int(np.searchsorted(time, at, side="right")) - 1, 0), len(time) - 2)
        value_at = float(_interpolated(history, np.array([at]), values)[0])
        integral -= integral[i] + (at - time[i]) * 0.5 * (values[i] + value_at)
    return history.replaced(values=integral + initial, unit=_INTEGRALS[rate].unit, code=None)


def differentiated(history: TimeHistory) -> TimeHistory:
    """The derivative by time, in SI: a deflection gives m/s, a speed m/s2.

    Within, the slope of the parabola through three neighbours (second order, on uneven times too); at the ends, of the one
    through the last three. It makes noise larger: filter first.

    >>> differentiated(TimeHistory([0.0, 1.0, 4.0, 9.0], "m", interval=1.0)).values.tolist()
    [0.0, 2.0, 4.0, 6.0]

    Raises: InvalidInput for a unit whose derivative has no name here, fewer than two values, or a jump.
    """
    integral = units.dimension(history.unit)
    if integral not in _DERIVATIVES:
        raise InvalidInput(f"{_called(history)}.unit: got {history.unit!r}, {integral.called}; need {_named(_DERIVATIVES)}.")
    _need_two(history)
    time, values = history.si
    if np.diff(time).min() == 0.0:
        place = time[int(np.argmin(np.diff(time)))]
        raise InvalidInput(f"{_called(history)}: got a jump at {place:g} s; need one value at each time. Resample it first.")
    by_time = history.interval if history.interval is not None else time
    slopes = np.gradient(values, by_time, edge_order=2 if len(values) > 2 else 1)
    return history.replaced(values=slopes, unit=_DERIVATIVES[integral].unit, code=None)


# parts and grids


def trimmed(history: TimeHistory, start: float | None = None, end: float | None = None) -> TimeHistory:
    """The signal from `start` to `end` [s], its own ends where left out; values there are interpolated.

    An evenly sampled signal stays so where both ends are sample times, and gets time stamps where one is not. At a jump, the
    start takes the value after it and the end the value before.

    >>> trimmed(TimeHistory([0.0, 1.0, 2.0, 3.0], "g", interval=0.1), 0.1, 0.2).values.tolist()
    [1.0, 2.0]
    >>> trimmed(TimeHistory([0.0, 1.0, 2.0], "g", interval=0.1), 0.05).time.tolist()
    [0.05, 0.1, 0.2]

    Raises: InvalidInput for ends outside the signal, or where the start is not before the end.
    """
    start = history.start if start is None else _within(history, start, "start")
    end = history.end if end is None else _within(history, end, "end")
    if not start < end:
        raise InvalidInput(f"start: got {start:g} s with an end at {end:g} s; need a start before the end. Turn them round.")
    time, values = history.time, history.values
    if history.interval is not None:
        first, last = (start - history.start) / history.interval, (end - history.start) / history.interval
        if max(abs(first - round(first)), abs(last - round(last))) <= _SAME_TIME:
            part = slice(round(first), round(last) + 1)
            return history.replaced(values=values[part], start=float(time[part.start]))
    inner = slice(int(np.searchsorted(time, start, side="right")), int(np.searchsorted(time, end, side="left")))
    at_start = _interpolated(history, np.array([start]))
    at_end = _interpolated(history, np.array([end]), before=True)
    return history.replaced(
        values=np.concatenate((at_start, values[inner], at_end)),
        stamps=np.concatenate(([start], time[inner], [end])),
        interval=None,
    )


def resampled(
    history: TimeHistory,
    interval: float,
    *,
    start: float | None = None,
    end: float | None = None,
    allow_aliasing: bool = False,
) -> TimeHistory:
    """The signal at even times, `interval` [s] apart, between `start` and `end` [s]; values are interpolated.

    Where `start` is left out, the times are the whole multiples of the interval within the signal, so that time zero is one
    of them. At a jump, the value after it.

    Lowering the rate folds what is too quick for the new one into what is not. So a lower rate is refused unless the signal
    was filtered with a class of a tenth of that rate at most, the rule that SAE J211 has for recording; or `allow_aliasing`.
    A signal with its own time stamps has no rate to lower: it is taken as the lines between its values.

    >>> resampled(TimeHistory([0.0, 1.0, 2.0], "g", interval=0.1), 0.05).values.tolist()
    [0.0, 0.5, 1.0, 1.5, 2.0]

    Raises: InvalidInput for an interval that is not > 0, ends outside the signal, or a rate lowered without a filter.
    """
    if not (math.isfinite(interval) and interval > 0.0):
        raise InvalidInput(f"interval: got {interval:g} s; need > 0 s. Give the time between two values.")
    _need_rate(history, interval, allow_aliasing=allow_aliasing)
    end = history.end if end is None else _within(history, end, "end")
    on_grid = math.ceil(history.start / interval - _SAME_TIME) * interval
    start = on_grid if start is None else _within(history, start, "start")
    steps = (end - start) / interval + _SAME_TIME
    if steps >= MAX_SAMPLES:
        raise InvalidInput(f"interval: got {interval:g} s for {end - start:g} s; need at most {MAX_SAMPLES} values. Raise it.")
    if steps < 0.0:
        raise InvalidInput(
            f"interval: got {interval:g} s; need a multiple of it within {history.start:g} .. {end:g} s. Lower it."
        )
    times = sample_times(start, interval, math.floor(steps) + 1)
    values = _interpolated(history, np.clip(times, history.start, history.end))
    return history.replaced(values=values, start=start, interval=interval, stamps=None)


def aligned(*histories: TimeHistory, interval: float | None = None) -> tuple[TimeHistory, ...]:
    """The signals on one even grid: over the time they share, at the smallest of their intervals, or at the one given.

    Signals that share a grid already come back as they are.

    >>> a, b = TimeHistory([0.0, 1.0, 2.0], "g", interval=0.1), TimeHistory([5.0] * 5, "g", start=0.05, interval=0.05)
    >>> [signal.time.round(3).tolist() for signal in aligned(a, b)]
    [[0.05, 0.1, 0.15, 0.2], [0.05, 0.1, 0.15, 0.2]]

    Raises: InvalidInput where they share no time, or none is evenly sampled and no interval is given.
    """
    if all(_same_grid(histories[0], other) for other in histories) and interval in {None, histories[0].interval}:
        return histories
    known = [history.interval for history in histories if history.interval is not None]
    if interval is None and not known:
        raise InvalidInput("interval: got signals with time stamps only; need an even interval to bring them to. Give one.")
    step = interval if interval is not None else min(known)
    start, end = max(history.start for history in histories), min(history.end for history in histories)
    if not start < end:
        raise InvalidInput(f"histories: got no time that all share ({start:g} .. {end:g} s); need some. Check their time zero.")
    start = math.ceil(start / step - _SAME_TIME) * step
    return tuple(resampled(history, step, start=min(max(start, history.start), history.end), end=end) for history in histories)


# offsets and signs


def zeroed(history: TimeHistory, start: float | None = None, end: float = 0.0) -> TimeHistory:
    """The signal less its mean from `start` (its first value where left out) up to, not including, `end` [s], time zero.

    >>> zeroed(TimeHistory([2.0, 2.0, 1.0, -8.0], "g", start=-0.02, interval=0.01)).values.tolist()
    [0.0, 0.0, -1.0, -10.0]

    Raises: InvalidInput for fewer than two values in that time: there is then no telling an offset from a signal.
    """
    time, values = history.time, history.values
    start = history.start if start is None else start
    slack = _SAME_TIME * history.interval if history.interval is not None else 0.0
    window = (time >= start - slack) & (time < end - slack)
    if np.count_nonzero(window) < 2:
        raise InvalidInput(
            f"{_called(history)}: got {np.count_nonzero(window)} values from {start:g} s to {end:g} s; need two at least to "
            "tell an offset. Choose a window before the impact that was recorded."
        )
    if history.interval is not None:
        offset = values[window].mean()
    else:
        span = time[window][-1] - time[window][0]
        offset = np.trapezoid(values[window], time[window]) / span if span > 0.0 else values[window].mean()
    return history.replaced(values=values - offset)


def reversed_sign(history: TimeHistory) -> TimeHistory:
    """The signal with its sign turned: a sensor that was mounted the other way round.

    >>> reversed_sign(TimeHistory([1.0, -2.0], "g", interval=0.1)).values.tolist()
    [-1.0, 2.0]
    """
    return history.replaced(values=-history.values)


# several signals


def resultant(*components: TimeHistory) -> TimeHistory:
    """The length of the vector with these components, at each of their times: `sqrt(x^2 + y^2 + z^2)`.

    Filter the components first, each with the same class, as SAE J211 has it; a resultant is not filtered.

    >>> x, y = TimeHistory([3.0, 0.0], "g", interval=0.1), TimeHistory([4.0, -2.0], "g", interval=0.1)
    >>> resultant(x, y).values.tolist()
    [5.0, 2.0]

    Raises: InvalidInput where units, times or filter states differ, or for fewer than two components.
    """
    _need_alike(components, "resultant")
    squares = np.sum([np.square(component.values) for component in components], axis=0)
    return components[0].replaced(
        values=np.sqrt(squares),
        name=_named_after("resultant", components),
        code=_code_of_resultant(components),
        remarks=_remarks(components),
    )


def mean(*histories: TimeHistory) -> TimeHistory:
    """The mean of signals that measure the same thing twice or more, at each of their times.

    >>> mean(TimeHistory([1.0, 2.0], "g", interval=0.1), TimeHistory([3.0, 2.0], "g", interval=0.1)).values.tolist()
    [2.0, 2.0]

    Raises: InvalidInput where units, times or filter states differ, or for fewer than two signals.
    """
    _need_alike(histories, "mean")
    values = np.mean([history.values for history in histories], axis=0)
    return histories[0].replaced(values=values, name=_named_after("mean", histories), code=None, remarks=_remarks(histories))


# checks and parts


def _interpolated(history: TimeHistory, times: Floats, values: Floats | None = None, *, before: bool = False) -> Floats:
    """The lines through the values (the history's own where left out) at times (m,) within them; at a jump, the value after.

    before: the value before it.
    """
    known = history.time
    heights = history.values if values is None else values
    if len(known) == 1:
        return np.full(times.shape, heights[0])
    if before:
        right = np.clip(np.searchsorted(known, times, side="left"), 1, len(known) - 1)
    else:
        right = np.clip(np.searchsorted(known, times, side="right"), 1, len(known) - 1)
    left = right - 1
    span = known[right] - known[left]
    # A jump at the very end, or the very start, leaves no line to be on: then it is the value at that end.
    part = np.where(span > 0.0, (times - known[left]) / np.where(span > 0.0, span, 1.0), 0.0 if before else 1.0)
    between: Floats = np.where(part >= 1.0, heights[right], heights[left] + part * (heights[right] - heights[left]))
    return between


def _within(history: TimeHistory, time: float, what: str) -> float:
    slack = _SAME_TIME * (history.interval or 0.0)
    if not history.start - slack <= time <= history.end + slack:
        raise InvalidInput(
            f"{what}: got {time:g} s; need {history.start:g} .. {history.end:g} s, where {_called(history)} was recorded. "
            "Ask within it."
        )
    return min(max(time, history.start), history.end)


def _need_two(history: TimeHistory) -> None:
    if len(history) < 2:
        raise InvalidInput(f"{_called(history)}: got one value; need two at least. A signal is what lies between its values.")


def _need_rate(history: TimeHistory, interval: float, *, allow_aliasing: bool) -> None:
    if allow_aliasing or history.interval is None or interval <= history.interval * (1.0 + _SAME_TIME):
        return
    lowest = _lowest_class(history.filtered)
    if lowest is None or 1.0 / interval < LEAST_SAMPLES_PER_CLASS * lowest * (1.0 - _SAME_TIME):
        state = str(history.filtered) if history.filtered else "a signal that no filter is known of"
        raise InvalidInput(
            f"interval: got {interval:g} s for {state}, sampled every {history.interval:g} s; need a class of "
            f"{1.0 / interval / LEAST_SAMPLES_PER_CLASS:g} or lower for that rate. Filter it first, or allow_aliasing=True."
        )


def _lowest_class(state: Filter | None) -> float | None:
    if state is None:
        return None
    before = _lowest_class(state.after)
    return state.frequency_class if before is None else min(state.frequency_class, before)


def _same_grid(one: TimeHistory, other: TimeHistory) -> bool:
    return (
        len(one) == len(other) and (one.interval is None) == (other.interval is None) and np.array_equal(one.time, other.time)
    )


def _need_alike(histories: tuple[TimeHistory, ...], what: str) -> None:
    if len(histories) < 2:
        raise InvalidInput(f"{what}: got {len(histories)} signals; need two at least. Give each as an argument of its own.")
    first = histories[0]
    for other in histories[1:]:
        if other.unit != first.unit:
            raise InvalidInput(
                f"{what}: got {_called(first)} in {first.unit!r} and {_called(other)} in {other.unit!r}; need one unit. "
                "Convert one of them."
            )
        if not _same_grid(first, other):
            raise InvalidInput(
                f"{what}: got {_called(first)} and {_called(other)} at different times; need the same. "
                "Use ridedown.signals.aligned first."
            )
        if other.filtered != first.filtered:
            raise InvalidInput(
                f"{what}: got {_called(first)} ({first.filtered or 'no filter known'}) and {_called(other)} "
                f"({other.filtered or 'no filter known'}); need the same filter. Filter each alike first."
            )


def _code_of_resultant(components: tuple[TimeHistory, ...]) -> str | None:
    """The components' channel code with direction R, where they differ in nothing but direction."""
    try:
        codes = [ChannelCode.parse(component.code or "") for component in components]
    except InvalidInput:
        return None
    alike = {str(code)[:14] + str(code)[15] for code in codes}
    directions = [code.direction for code in codes]
    if len(alike) > 1 or len(set(directions)) < len(directions) or not set(directions) <= set("XYZ"):
        return None
    return str(codes[0])[:14] + "R" + str(codes[0])[15]


def _named_after(what: str, histories: tuple[TimeHistory, ...]) -> str:
    names = [history.name for history in histories if history.name]
    return f"{what} of {' and '.join(names)}" if names else ""


def _remarks(histories: tuple[TimeHistory, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(remark for history in histories for remark in history.remarks))


def _called(history: TimeHistory) -> str:
    return history.name or "history"


def _named(dimensions: dict[units.Dimension, units.Dimension]) -> str:
    return ", ".join(dimension.called for dimension in dimensions)
