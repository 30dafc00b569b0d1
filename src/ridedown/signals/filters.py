"""Channel frequency classes: the low-pass filters that crash signals are judged through.

A class of 60, 180, 600 or 1000 is a Butterworth filter of two poles, run forwards and then backwards, so that nothing is
shifted in time: four poles in all. SAE J211 and ISO 6487 place the corner of one pass a little differently (2.0775 and
1.25/0.6 of the class, in Hz) and treat the ends differently:

- SAE J211: each pass starts as if the signal had always been at the mean of the first ten samples that it meets.
- ISO 6487: before that, the signal is carried on at both ends by its own mirror image in its first and last point, over
  0.01 s or 100 samples, whichever is more, or as far as a short signal goes.

References:
    SAE J211-1, Instrumentation for Impact Test, Part 1, Electronic Instrumentation.
    ISO 6487, Road vehicles, Measurement techniques in impact tests, Instrumentation.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals.codes import ChannelCode
from ridedown.signals.history import Filter, Floats, TimeHistory

Standard = Literal["SAE J211", "ISO 6487"]

CORNERS = {"SAE J211": 2.0775, "ISO 6487": 1.25 / 0.6}
"""Corner frequency of one pass, over the class. Two passes are 6 dB down there, and 3 dB down at 5/3 of the class."""

CLASSES = (60, 180, 600, 1000)
"""The classes that the standards name; the formula holds for others too."""

LEAST_SAMPLES_PER_CLASS = 10.0
"""Sampling rate over the class, at least (SAE J211, ISO 6487)."""

_START_SAMPLES = 10
_MIRROR_TIME, _MIRROR_SAMPLES = 0.01, 100
_ROUNDING = 1e-6  # of a sampling rate: an interval read from a file is right to some digits only


def coefficients(cfc: float, interval: float, *, standard: Standard = "SAE J211") -> tuple[float, float, float, float, float]:
    """`a0, a1, a2, b1, b2` of one pass: `y[i] = a0 x[i] + a1 x[i-1] + a2 x[i-2] + b1 y[i-1] + b2 y[i-2]`.

    cfc: channel frequency class [Hz]; interval: between two samples [s].

    >>> a0, a1, a2, b1, b2 = coefficients(180, 1e-4)
    >>> round(a0 + a1 + a2 + b1 + b2, 12)  # a constant stays what it is
    1.0

    Raises: InvalidInput for a class that is not > 0, or fewer than ten samples in 1/class; UnknownName for the standard.
    """
    if standard not in CORNERS:
        raise UnknownName.among("standard", standard, CORNERS)
    if not (math.isfinite(cfc) and cfc > 0.0):
        raise InvalidInput(f"cfc: got {cfc:g} Hz; need > 0 Hz. The standards name 60, 180, 600 and 1000.")
    least = LEAST_SAMPLES_PER_CLASS * cfc
    if 1.0 / interval < least * (1.0 - _ROUNDING):
        raise InvalidInput(
            f"cfc: got class {cfc:g} for a signal sampled at {1.0 / interval:g} Hz; need {least:g} Hz at least, ten times the "
            "class. Choose a lower class."
        )
    w_d = 2.0 * math.pi * cfc * CORNERS[standard]
    w_a = math.tan(w_d * interval / 2.0)
    root = math.sqrt(2.0) * w_a
    denominator = 1.0 + root + w_a**2
    a0 = w_a**2 / denominator
    b1 = -2.0 * (w_a**2 - 1.0) / denominator
    b2 = (-1.0 + root - w_a**2) / denominator
    return a0, 2.0 * a0, a0, b1, b2


def filtered(history: TimeHistory, cfc: float, *, standard: Standard = "SAE J211") -> TimeHistory:
    """The signal through a channel frequency class, without shift in time; the result says what it went through.

    cfc: 60, 180, 600, 1000, or any other class [Hz]. A signal that was filtered before is filtered again, and its state
    names both. Near the ends of a recording, within some 0.5/class seconds, the result depends on the end treatment.

    >>> history = TimeHistory([5.0] * 40, "g", interval=1e-4)
    >>> smooth = filtered(history, 180)
    >>> bool(np.allclose(smooth.values, 5.0, rtol=1e-12)), str(smooth.filtered)
    (True, 'CFC 180 (SAE J211)')

    Raises: InvalidInput for a signal that is not evenly sampled, or at less than ten times the class; UnknownName for the
    standard.
    """
    if history.interval is None:
        raise InvalidInput(
            f"{history.name or 'history'}: got a signal with its own time stamps; a filter needs an even interval. "
            "Use ridedown.signals.resampled first."
        )
    weights = coefficients(cfc, history.interval, standard=standard)
    values = history.values
    if standard == "ISO 6487":
        # The tolerance: 0.01 s at 10 kHz are 100 samples, and not 101 because of a rounded interval.
        wanted = max(math.ceil(_MIRROR_TIME / history.interval * (1.0 - _ROUNDING)), _MIRROR_SAMPLES)
        beyond = min(wanted, len(values) - 1)
        smooth = _both_ways(mirrored(values, beyond), weights)[beyond : beyond + len(values)]
    else:
        smooth = _both_ways(values, weights)
    return history.replaced(
        values=smooth,
        filtered=Filter(cfc, standard, after=history.filtered),
        code=_recoded(history.code, cfc),
    )


def smoothed(values: Floats, cfc: float, interval: float) -> Floats:
    """Rows of values (..., n), sampled every `interval` [s], each through a channel class (SAE J211) as `filtered` does it.

    >>> bool(np.allclose(smoothed(np.full((2, 40), 5.0), 180, 1e-4), 5.0, rtol=1e-12))
    True

    Raises: InvalidInput for a class too high for the interval.
    """
    return _both_ways(values, coefficients(cfc, interval))


def mirrored(values: Floats, count: int) -> Floats:
    """The values (n,) carried on by `count` < n more at each end: turned by half a turn about the first and the last point.

    >>> mirrored(np.array([1.0, 2.0, 4.0]), 2).tolist()
    [-2.0, 0.0, 1.0, 2.0, 4.0, 6.0, 7.0]
    """
    before = 2.0 * values[0] - values[count:0:-1]
    after = 2.0 * values[-1] - values[-2 : -count - 2 : -1]
    return np.concatenate((before, values, after))


def _both_ways(values: Floats, weights: tuple[float, float, float, float, float]) -> Floats:
    return _one_way(_one_way(values, weights)[..., ::-1], weights)[..., ::-1]


def _one_way(values: Floats, weights: tuple[float, float, float, float, float]) -> Floats:
    """One pass, started as if the signal had always been at the mean of its first ten values."""
    from scipy.signal import lfilter  # noqa: PLC0415  a third of a second to import

    a0, a1, a2, b1, b2 = weights
    level = values[..., :_START_SAMPLES].mean(axis=-1, keepdims=True)
    # What differs from the level, from rest: the same as the whole from the level, and nothing is lost to rounding.
    result: Floats = lfilter([a0, a1, a2], [1.0, -b1, -b2], values - level) + level
    return result


def _recoded(code: str | None, cfc: float) -> str | None:
    """The channel code with the filter's letter; none for a code that is not one."""
    try:
        return None if code is None else str(ChannelCode.parse(code).filtered(int(cfc) if cfc == int(cfc) else 0))
    except InvalidInput:
        return None
