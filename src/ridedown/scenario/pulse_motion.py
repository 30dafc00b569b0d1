"""The motion that a pulse prescribes: acceleration, velocity and displacement at any time, from polynomials on pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown import network

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PulseMotion:
    """An acceleration [m/s2] as a polynomial on each of P pieces, and the speed that it starts from.

    start: (P,) [s], the first at 0, rising. series: (P, D), ascending powers of the time since the piece's start. end [s]:
    as far as it is asked for; the pulse goes on. speed [m/s]: at time 0.

    >>> braking = PulseMotion(np.array([0.0]), np.array([[-150.0]]), end=0.1, speed=15.0)
    >>> [float(value) for value in braking.at(0.05)]
    [-150.0, 7.5, 0.5625]
    """

    start: Floats
    series: Floats
    end: float
    speed: float

    @classmethod
    def of(cls, pulse: network.Pulse, *, end: float, speed: float) -> PulseMotion:
        """The motion of a network's pulse of single values. A column's first value counts."""
        amplitude, length = (float(np.ravel(number)[0]) for number in (pulse.amplitude, pulse.length))
        series = amplitude * pulse.series / length ** np.arange(pulse.series.shape[1])
        return cls(length * pulse.start, series, end, speed)

    @property
    def starts(self) -> Floats:
        """Where the pieces start that the motion reaches [s]."""
        return self.start[: max(1, int(np.searchsorted(self.start, self.end, side="left")))]

    def at(self, times: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Acceleration [m/s2], velocity [m/s] and displacement [m] at times [s] not below 0; at a jump, just after it."""
        time = np.asarray(times, dtype=np.float64)
        piece = np.clip(np.searchsorted(self.start, time, side="right") - 1, 0, self.start.size - 1)
        return self._within(piece, time - self.start[piece])

    def before(self, times: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """The same; at a jump, just before it."""
        time = np.asarray(times, dtype=np.float64)
        piece = np.clip(np.searchsorted(self.start, time, side="left") - 1, 0, self.start.size - 1)
        return self._within(piece, time - self.start[piece])

    def table(self, step: float = 1e-4) -> tuple[Floats, Floats, Floats, Floats]:
        """Time, acceleration, velocity and displacement, evenly spaced, `step` [s] apart at most, and at each piece's start.

        A jump is two rows of one time.
        """
        even = np.linspace(0.0, self.end, max(2, int(np.ceil(self.end / step - 1e-9)) + 1))
        return self._rows(np.union1d(even, self.starts))

    def knots(self, tolerance: float = 1e-4) -> tuple[Floats, Floats, Floats, Floats]:
        """The rows between which the acceleration is straight to within `tolerance` times its largest magnitude.

        One that is piecewise linear is given by its own knots.
        """
        starts = self.starts
        length = np.diff(np.append(starts, self.end))
        orders = np.arange(self.series.shape[1])
        sizes = np.abs(self.series[: starts.size]) * length[:, None] ** orders
        looked_at = starts[:, None] + length[:, None] * np.linspace(0.0, 1.0, 9)[:-1]
        allowed = tolerance * np.abs(self.at(looked_at)[0]).max()
        # no more than this is any second derivative within the piece, times its length squared
        bend = (sizes * orders * (orders - 1)).sum(axis=1)
        parts = np.ones(starts.size) if allowed == 0.0 else np.maximum(np.ceil(np.sqrt(bend / (8.0 * allowed))), 1.0)
        inner = [s + h * np.arange(int(n)) / n for s, h, n in zip(starts, length, parts, strict=True)]
        return self._rows(np.append(np.concatenate(inner), self.end))

    def _rows(self, time: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        before, after = self.before(time), self.at(time)
        jump = (before[0] != after[0]) & np.isin(time, self.starts[1:])
        # rounding at a seam is no jump
        jump &= np.abs(before[0] - after[0]) > 1e-9 * max(np.abs(after[0]).max(), np.abs(before[0]).max())
        last = time == self.end
        twice = np.repeat(np.arange(time.size), 1 + (jump & ~last))
        second = np.concatenate(([False], twice[1:] == twice[:-1]))
        use_before = (jump[twice] & ~second) | (last & (time > 0.0))[twice]
        a, v, x = (np.where(use_before, b[twice], c[twice]) for b, c in zip(before, after, strict=True))
        return time[twice], a, v, x

    def _within(self, piece: NDArray[np.int64], local: Floats) -> tuple[Floats, Floats, Floats]:
        orders = np.arange(self.series.shape[1])
        once, twice = self.series / (orders + 1), self.series / ((orders + 1) * (orders + 2))
        length = np.diff(self.start)
        gained = length * _polynomial(once[:-1], length)
        velocity = self.speed + np.concatenate(([0.0], np.cumsum(gained)))
        moved = length * velocity[:-1] + length**2 * _polynomial(twice[:-1], length)
        place = np.concatenate(([0.0], np.cumsum(moved)))
        v0, x0 = velocity[piece], place[piece]
        return (
            _polynomial(self.series[piece], local),
            v0 + local * _polynomial(once[piece], local),
            x0 + local * (v0 + local * _polynomial(twice[piece], local)),
        )


def _polynomial(series: Floats, at: Floats) -> Floats:
    """Each row's polynomial at its own place."""
    value = np.zeros(np.shape(at))
    for order in range(series.shape[-1] - 1, -1, -1):
        value = value * at + series[..., order]
    return value
