"""Few knots for a measured pulse: the straight lines that stand for thousands of samples.

Between knots the reduced acceleration is straight, and at the knots it has no jump. Of all such lines the one nearest to the
samples (least squares over time) leaves a remainder that is orthogonal to every straight line over the whole window: its
integral and its double integral end at zero. So velocity change and displacement at the end are exact whatever the knots, and
these need only keep the way there. Knots start out dense and even; then each is taken out that can go, and those left are
moved to where they do best, as long as bounds on velocity, displacement and peak hold.

References:
    C. de Boor, A Practical Guide to Splines, Springer, 2001, ch. XIV (least squares by linear splines; knots as free numbers).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

VELOCITY_BAND = 1e-3
"""How far the velocity may be off on the way, in parts of its largest change."""
DISPLACEMENT_BAND = 0.9e-4
"""m; how far the displacement may be off on the way."""
PEAK_BAND = 5e-3
"""How far the largest acceleration may be off, in parts of it."""

_FIRST = 32  # intervals to begin with
_TRIES = 12  # knots that look dispensable, tried before the search for one to take out ends
_STEPS = (1, -1, 4, -4, 16, -16)  # samples by which knots are moved
_FITS = 6000  # least-squares fits in all: about a second
_IDLE_ROUNDS = 2


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """An acceleration that is straight between its samples, with what fits need: (n,) each.

    time [s], rising; value [m/s2]; integral of the value and of value times time, from the first sample on. step: (n - 1,) [s].
    """

    time: Floats
    value: Floats
    step: Floats
    integral: Floats
    moment: Floats

    @classmethod
    def of(cls, time: Floats, value: Floats) -> Samples:
        """The samples with their integrals. Time counts from the first, so that nothing is lost to a clock's offset."""
        local, h = time - time[0], np.diff(time)
        area = 0.5 * h * (value[1:] + value[:-1])
        moment = h * h * (value[:-1] + 2.0 * value[1:]) / 6.0 + local[:-1] * area
        return cls(local, value, h, _running(area), _running(moment))


def reduced(time: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Knots of the piecewise-linear acceleration that stands for samples: times [s] and values [m/s2].

    time: (n,) [s], never falling; two equal ones are a jump, and stay one. value: (n,) [m/s2].

    >>> time = np.linspace(0.0, 0.1, 1001)
    >>> knots, values = reduced(time, np.interp(time, [0.0, 0.04, 0.1], [0.0, -300.0, 0.0]))
    >>> knots.round(6).tolist(), values.round(6).tolist()
    ([0.0, 0.04, 0.1], [0.0, -300.0, 0.0])
    """
    velocity = _running(0.5 * np.diff(time) * (value[1:] + value[:-1]))
    bounds = _Bounds(VELOCITY_BAND * float(np.abs(velocity).max()), DISPLACEMENT_BAND, float(np.abs(value).max()))
    cuts = np.flatnonzero(np.diff(time) == 0.0) + 1
    stretches = [part for part in zip(np.split(time, cuts), np.split(value, cuts), strict=True) if part[0].size > 1]
    # each stretch ends with no error left, so that each may use the whole band
    parts = [_stretch(t, a, bounds) for t, a in stretches]
    return np.concatenate([knots for knots, _ in parts]), np.concatenate([values for _, values in parts])


@dataclass(frozen=True, slots=True)
class _Bounds:
    velocity: float
    displacement: float
    peak: float


def _stretch(time: Floats, value: Floats, bounds: _Bounds) -> tuple[Floats, Floats]:
    search = _Search(Samples.of(time, value), bounds)
    knots = np.array(search.run(), dtype=np.int64)
    return time[knots], fitted(search.samples, knots)


class _Search:
    """The search for few knots, as indices of samples, within bounds."""

    def __init__(self, samples: Samples, bounds: _Bounds) -> None:
        self.samples = samples
        self.bounds = bounds
        self.fits = 0
        self.peak = float(np.abs(samples.value).max())

    def run(self) -> list[int]:
        """The knots found: moving them makes more of them dispensable, until twice it has not."""
        knots, idle = self._thinned(self._dense()), 0
        while idle < _IDLE_ROUNDS and self.fits < _FITS:
            fewer = self._thinned(self._moved(knots))
            idle = 0 if len(fewer) < len(knots) else idle + 1
            knots = fewer
        return knots

    def _dense(self) -> list[int]:
        last, intervals = self.samples.time.size - 1, _FIRST
        while True:
            knots = np.unique(np.round(np.linspace(0, last, intervals + 1)).astype(np.int64)).tolist()
            if len(knots) > last or self._judged(knots)[0] <= 1.0:
                return list(knots)
            intervals *= 2

    def _thinned(self, knots: list[int]) -> list[int]:
        """The knots without those that can go, the least needed first: many at once while that does, then one by one."""
        many = len(knots) // 4
        while many > 1 and self.fits < _FITS:
            gone = _apart(self._least_needed(knots), many)
            fewer = [place for j, place in enumerate(knots) if j - 1 not in gone]
            if self._judged(fewer)[0] <= 1.0:
                knots = fewer
            else:
                many //= 2
        while self.fits < _FITS:
            for j in self._least_needed(knots)[:_TRIES]:
                fewer = knots[: j + 1] + knots[j + 2 :]
                if self._judged(fewer)[0] <= 1.0:
                    knots = fewer
                    break
            else:
                break
        return knots

    def _least_needed(self, knots: list[int]) -> list[int]:
        """Inner knots in the order of what the line straight past them would change: its area times its length."""
        time, value = self.samples.time[knots], fitted(self.samples, np.array(knots))
        span = time[2:] - time[:-2]
        line = value[:-2] + (value[2:] - value[:-2]) * (time[1:-1] - time[:-2]) / span
        return list(np.argsort(np.abs(value[1:-1] - line) * span**2))

    def _moved(self, knots: list[int]) -> list[int]:
        """The knots, each where the motion is followed best."""
        worst, cost = self._judged(knots)
        for j in range(1, len(knots) - 1):
            for step in _STEPS:
                place = knots[j] + step
                if self.fits >= _FITS or not knots[j - 1] < place < knots[j + 1]:
                    continue
                other = [*knots[:j], place, *knots[j + 1 :]]
                new_worst, new_cost = self._judged(other)
                if new_cost < cost and new_worst <= max(1.0, worst):
                    knots, worst, cost = other, new_worst, new_cost
        return knots

    def _judged(self, knots: list[int]) -> tuple[float, float]:
        """The worst error over its bound, and the sum of squares of the errors of the motion over their bounds."""
        self.fits += 1
        own = np.array(knots)
        value = fitted(self.samples, own)
        velocity, displacement = errors(self.samples, own, value)
        v, x = velocity / self.bounds.velocity, displacement / self.bounds.displacement
        off = abs(_largest(value) - self.peak) / (PEAK_BAND * self.bounds.peak)
        return max(_largest(v), _largest(x), off), float(v @ v + x @ x)


def _apart(order: list[int], count: int) -> set[int]:
    """The first so many of the indices, no two of them next to each other."""
    taken: set[int] = set()
    for j in order:
        if len(taken) == count:
            break
        if j - 1 not in taken and j + 1 not in taken:
            taken.add(j)
    return taken


def fitted(samples: Samples, knots: Ints) -> Floats:
    """Values at the knots of the continuous line of straight pieces nearest to the samples, in least squares over time."""
    from scipy.linalg.lapack import dptsv  # noqa: PLC0415  slow to import, and few scenarios need it

    time = samples.time[knots]
    length = np.diff(time)
    area = np.diff(samples.integral[knots])
    later = (np.diff(samples.moment[knots]) - time[:-1] * area) / length
    right = np.zeros(knots.size)
    right[1:] += later
    right[:-1] += area - later
    diagonal = np.zeros(knots.size)
    diagonal[:-1] += length / 3.0
    diagonal[1:] += length / 3.0
    values: Floats = dptsv(diagonal, length / 6.0, right)[2]
    return values


def errors(samples: Samples, knots: Ints, value: Floats) -> tuple[Floats, Floats]:
    """How far velocity [m/s] and displacement [m] of the line through the knots are off, at each sample."""
    off, h = np.interp(samples.time, samples.time[knots], value) - samples.value, samples.step
    half = 0.5 * h * (off[1:] + off[:-1])
    velocity = _running(half)
    return velocity, _running(h * (velocity[:-1] + half / 3.0 + h * off[:-1] / 6.0))


def _largest(values: Floats) -> float:
    """Magnitude of the largest."""
    return max(float(values.max()), -float(values.min()))


def _running(parts: Floats) -> Floats:
    total = np.empty(parts.size + 1)
    total[0] = 0.0
    np.cumsum(parts, out=total[1:])
    return total
