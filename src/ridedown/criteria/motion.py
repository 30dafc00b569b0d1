"""A body's motion from its acceleration: velocity and displacement of a signal that is straight between its samples, exactly.

On a segment the velocity is a parabola and the displacement a cubic; where either reaches a level is solved for, not looked up
at the nearest sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ridedown.criteria.checks import Floats


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Time [s], acceleration [m/s2], velocity [m/s] and displacement [m] at the samples, (n,) each."""

    time: Floats
    acceleration: Floats
    velocity: Floats
    displacement: Floats

    @classmethod
    def of(cls, time: Floats, acceleration: Floats, speed: float = 0.0, displacement: float = 0.0) -> Motion:
        """The motion that begins with this speed [m/s] and displacement [m]."""
        h = np.diff(time)
        before, after = acceleration[:-1], acceleration[1:]
        velocity = speed + np.concatenate(([0.0], np.cumsum(0.5 * h * (before + after))))
        moved = h * velocity[:-1] + h * h * (2.0 * before + after) / 6.0
        return cls(time, acceleration, velocity, displacement + np.concatenate(([0.0], np.cumsum(moved))))

    @property
    def lengths(self) -> Floats:
        """Of the segments [s], (n - 1,)."""
        lengths: Floats = np.diff(self.time)
        return lengths

    @property
    def slopes(self) -> Floats:
        """Of the acceleration on the segments [m/s3], (n - 1,); 0 at a jump."""
        h = self.lengths
        slopes: Floats = np.divide(np.diff(self.acceleration), h, out=np.zeros_like(h), where=h > 0.0)
        return slopes

    def at(self, time: float) -> tuple[float, float, float]:
        """Acceleration, velocity and displacement at a time within the signal; at a jump, after it."""
        i = min(int(np.searchsorted(self.time, time, side="right")) - 1, self.time.size - 2)
        s, slope = time - self.time[i], self.slopes[i]
        a, v, x = self.acceleration[i], self.velocity[i], self.displacement[i]
        return float(a + slope * s), float(v + s * (a + 0.5 * slope * s)), float(x + s * (v + s * (0.5 * a + slope * s / 6.0)))

    def first_stop(self) -> float | None:
        """When the velocity, positive to begin with, first falls to zero [s]; None if it does not."""
        a, v = self.acceleration[:-1], self.velocity[:-1]
        rows = np.stack([-v, -a, -0.5 * self.slopes, np.zeros_like(a)])
        return first_reach(self.time, rows, 0.0)

    def first_reach(self, level: float) -> float | None:
        """When the displacement first comes up to this level [s]; None if it does not."""
        a, v, x = self.acceleration[:-1], self.velocity[:-1], self.displacement[:-1]
        return first_reach(self.time, np.stack([x, v, 0.5 * a, self.slopes / 6.0]), level)

    def velocity_turns(self) -> tuple[Floats, Floats]:
        """Times [s] and velocities at the samples and wherever between them the acceleration goes through zero, in order."""
        a = self.acceleration
        i = np.flatnonzero((a[:-1] * np.sign(a[1:]) < 0.0) & (self.lengths > 0.0))
        s = self.lengths[i] * a[i] / (a[i] - a[i + 1])
        times = np.insert(self.time, i + 1, self.time[i] + s)
        return times, np.insert(self.velocity, i + 1, self.velocity[i] + 0.5 * s * a[i])


def first_reach(time: Floats, rows: Floats, level: float) -> float | None:
    """When a function first comes up to a level from below [s]; None if it does not.

    time: (n,); rows: (4, n - 1), on each segment the coefficients of 1, s, s^2 and s^3 with s counted from its start.
    """
    h = np.diff(time)
    top = np.maximum(rows[0], _cubic(rows, h))
    for s in _turns(rows):
        inside = (s > 0.0) & (s < h)
        top = np.where(inside, np.maximum(top, _cubic(rows, np.where(inside, s, 0.0))), top)
    over = np.flatnonzero(top >= level)
    if over.size == 0:
        return None
    i = int(over[0])
    column = rows[:, i : i + 1]
    turns = sorted(float(s[0]) for s in _turns(column) if 0.0 < s[0] < h[i])
    start = 0.0
    for end in (*turns, float(h[i])):
        if _at(column, start) >= level:
            break
        if _at(column, end) >= level:
            start = _bisect(column, level, start, end)
            break
        start = end
    return float(time[i] + start)


def _cubic(rows: Floats, s: Floats) -> Floats:
    values: Floats = rows[0] + s * (rows[1] + s * (rows[2] + s * rows[3]))
    return values


def _at(column: Floats, s: float) -> float:
    return float(_cubic(column, np.array([s]))[0])


def _turns(rows: Floats) -> tuple[Floats, Floats]:
    """Where the derivatives c1 + 2 c2 s + 3 c3 s^2 are zero; NaN for those that are not."""
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # no turn, or one beyond all times
        inside = rows[2] ** 2 - 3.0 * rows[1] * rows[3]
        q = -(rows[2] + np.copysign(np.sqrt(inside), rows[2]))
        one: Floats = q / (3.0 * rows[3])
        two: Floats = rows[1] / q
    return one, two


def _bisect(column: Floats, level: float, low: float, high: float) -> float:
    """Where a cubic that rises from below the level to above it reaches it."""
    c0, c1, c2, c3 = (float(c) for c in column[:, 0])
    while True:
        middle = 0.5 * (low + high)
        if middle in {low, high}:
            return high
        if c0 + middle * (c1 + middle * (c2 + middle * c3)) >= level:
            high = middle
        else:
            low = middle


def on_one_grid(one: tuple[Floats, Floats], other: tuple[Floats, Floats]) -> tuple[Floats, Floats, Floats]:
    """Two signals at all their samples within the time that both cover: times, and each one's values; jumps are kept."""
    begin, end = max(one[0][0], other[0][0]), min(one[0][-1], other[0][-1])
    times = np.unique(np.concatenate((one[0], other[0], [begin, end])))
    times = times[(times >= begin) & (times <= end)]
    sides = [(_just(time, values, times, "left"), _just(time, values, times, "right")) for time, values in (one, other)]
    jumps = np.any([before != after for before, after in sides], axis=0)
    twice = np.repeat(np.arange(times.size), 1 + jumps)
    second = np.concatenate(([False], twice[1:] == twice[:-1]))
    first, then = (np.where(second | ~jumps[twice], after[twice], before[twice]) for before, after in sides)
    return times[twice], first, then


def _just(time: Floats, values: Floats, at: Floats, side: str) -> Floats:
    """The values just before (left) or just after (right) the times `at`, all within the signal."""
    if side == "left":
        i = np.clip(np.searchsorted(time, at, side="left") - 1, 0, time.size - 2)
    else:
        i = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    h = time[i + 1] - time[i]
    share = np.divide(at - time[i], h, out=np.ones_like(h), where=h > 0.0)
    just: Floats = np.where(share >= 1.0, values[i + 1], values[i] + share * (values[i + 1] - values[i]))
    return just
