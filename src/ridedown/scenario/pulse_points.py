"""Pulses given point by point: accelerations at times, in the signs of SAE J211."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from pydantic import Field

from ridedown import network
from ridedown.scenario import pulse_shapes as shapes
from ridedown.scenario.base import Check
from ridedown.scenario.pulse import OwnPulse, brakes, one_of, same_in_all
from ridedown.scenario.quantities import Acceleration, Factor, Instant, Number

MOST_POINTS = 100_000


class PointsPulse(OwnPulse):
    """Accelerations at times, straight between them and zero before the first and after the last; braking is negative."""

    kind: Literal["points"]
    points: tuple[tuple[Instant, Acceleration], ...] = Field(
        description="pairs of time and acceleration, negative for braking; a time given twice is a jump"
    )
    scale: Factor = Field(1.0, description="factor on every acceleration")

    def lowered(self) -> network.Pulse:
        """The acceleration as the network takes it."""
        return network.Pulse(*shapes.through(*self._numbers()), amplitude=self.scale)

    def change(self) -> Number:
        """The change of velocity [m/s]."""
        return self.scale * self._gone()

    def end(self) -> Number:
        """When the pulse is over [s]."""
        return float(self._numbers()[0][-1])

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("points", 2 <= len(self.points) <= MOST_POINTS, f"{len(self.points)}", f"2 .. {MOST_POINTS} points")
        for i, j, number in self._columns():
            alike = same_in_all(f"points.{i}.{j}", number)
            yield alike._replace(fix="All rows share the shape of the pulse: vary its size with scale.")
        time = self._numbers()[0]
        i = 1 + int(np.argmin(np.diff(time)))
        falls = f">= {time[i - 1]:g} s, the time before it"
        yield Check(f"points.{i}.0", bool(time[i] >= time[i - 1]), float(time[i]), falls, "Sort the points.", "s")
        yield Check(
            "points",
            bool(time[-1] > time[0]),
            f"all at {time[0]:g} s",
            "points at different times",
            "Give one at a later time.",
        )
        yield brakes("points", self._gone())

    def _gone(self) -> float:
        time, value = self._numbers()
        return -float(np.trapezoid(value, time))

    def _numbers(self) -> tuple[shapes.Floats, shapes.Floats]:
        """Times [s] and accelerations [m/s2], (n,)."""
        if next(self._columns(), None) is None:
            time, value = np.array(self.points, dtype=np.float64).T
        else:
            time, value = np.array([[one_of(number) for number in point] for point in self.points]).T
        return time, value

    def _columns(self) -> Iterator[tuple[int, int, Number]]:
        """The numbers that are columns, with their places."""
        for i, point in enumerate(self.points):
            for j, number in enumerate(point):
                if isinstance(number, np.ndarray):
                    yield i, j, number
