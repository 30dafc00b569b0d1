"""Where an occupant's energy goes: into the car that still moves, the ride-down, or into the restraint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria.checks import Floats, from_time_zero, number, signal
from ridedown.criteria.motion import Motion, on_one_grid
from ridedown.errors import InvalidInput

Signal = tuple[ArrayLike, ArrayLike]
"""Times [s] and values in SI, (n,) each, as a history's `si` gives them."""


@dataclass(frozen=True, slots=True)
class EnergySplit:
    """An occupant's energy per kilogram from first contact to the vehicle's standstill [J/kg].

    initial = ride_down + restraint + remaining. initial: v0^2/2. ride_down: given up over the way of the vehicle, which goes
    into its crush. restraint: given up by then over the way ahead in the vehicle, into belt, bag and seat; remaining: still to
    be given up, with the vehicle at rest, and so to the restraint too. stop: when the vehicle stands still [s].
    """

    initial: float
    ride_down: float
    restraint: float
    remaining: float
    stop: float

    @property
    def efficiency(self) -> float:
        """Ride-down efficiency: the part of the initial energy that rides down, 0 for an occupant free until the car stands."""
        return self.ride_down / self.initial


def energy_split(vehicle: Signal, occupant: Signal, speed: float, *, start: float | None = None) -> EnergySplit | None:
    """How an occupant's energy is shared between ride-down and restraint, per kilogram; None if the vehicle does not stop.

    With the occupant's deceleration d = -a_o, the work d dx_o over its way splits into d dx_v over the vehicle's way and
    d (dx_o - dx_v) over its way in the vehicle. Both are integrated until the vehicle stands still, exactly over signals that
    are straight between their samples, which need not be the same.

    vehicle, occupant: (time [s], acceleration [m/s2]), each (n,), negative when braking; speed [m/s]: of both at the start;
    start [s]: time zero, or the first sample that both have if that is later, if left out.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), signals with no time in common, an occupant's that
    ends before the vehicle stands still, a speed not above 0, or a start outside either.

    References: M. Huang, "Vehicle Crash Mechanics", CRC Press, 2002 (ride-down and restraint energy densities; from memory).

    >>> car = ([0.0, 0.10], [-150.0, -150.0])
    >>> occupant = ([0.0, 0.03, 0.03, 0.12], [0.0, 0.0, -200.0, -200.0])  # free for 30 ms
    >>> split = energy_split(car, occupant, 15.0)
    >>> [round(part, 3) for part in (split.initial, split.ride_down, split.restraint, split.remaining)]
    [112.5, 73.5, 38.5, 0.5]
    >>> round(split.efficiency, 3)
    0.653
    """
    v0 = number(speed, "speed", "m/s", above=0.0)
    one, other = signal(*vehicle, "vehicle"), signal(*occupant, "occupant")
    if max(one[0][0], other[0][0]) >= min(one[0][-1], other[0][-1]):
        raise InvalidInput(
            f"occupant: got {other[0][0]:g} .. {other[0][-1]:g} s; need time in common with the vehicle's "
            f"{one[0][0]:g} .. {one[0][-1]:g} s. Put both on one clock."
        )
    begin = max(float(one[0][0]), float(other[0][0]), 0.0) if start is None else start
    stop = Motion.of(*from_time_zero(*one, begin), v0).first_stop()
    if stop is None:
        return None
    if other[0][-1] < stop:
        raise InvalidInput(
            f"occupant: got a signal until {other[0][-1]:g} s; need one until {stop:g} s, when the vehicle stands still. "
            "Take a longer record."
        )
    times, a_v, a_o = on_one_grid(from_time_zero(*one, begin), from_time_zero(*other, begin))
    times, a_v, a_o = _until(times, a_v, a_o, stop)
    car, body = Motion.of(times, a_v, v0), Motion.of(times, a_o, v0)
    ride_down, whole = _work(body, car), _work(body, body)
    return EnergySplit(0.5 * v0 * v0, ride_down, whole - ride_down, 0.5 * float(body.velocity[-1]) ** 2, stop)


def ridedown_efficiency(vehicle: Signal, occupant: Signal, speed: float, *, start: float | None = None) -> float | None:
    """Ride-down efficiency: the part of an occupant's energy given up over the way of the vehicle until that stands still.

    The rest is taken by the restraint. 1 for an occupant that is one with the car, 0 for one that flies free until it stands;
    None if the vehicle does not stop. Arguments, errors and source as for `energy_split`.

    >>> car = ([0.0, 0.10], [-150.0, -150.0])
    >>> ridedown_efficiency(car, car, 15.0)
    1.0
    """
    split = energy_split(vehicle, occupant, speed, start=start)
    return None if split is None else split.efficiency


def _work(pushed: Motion, over: Motion) -> float:
    """The work per kilogram of one's deceleration over the other's way [J/kg]; Simpson's rule is exact, it is a cubic."""
    h = pushed.lengths
    a = pushed.acceleration
    v = over.velocity[:-1] + h * (3.0 * over.acceleration[:-1] + over.acceleration[1:]) / 8.0
    middle = 0.5 * (a[:-1] + a[1:]) * v
    return -float(np.sum(h * (a[:-1] * over.velocity[:-1] + 4.0 * middle + a[1:] * over.velocity[1:]))) / 6.0


def _until(times: Floats, one: Floats, other: Floats, end: float) -> tuple[Floats, Floats, Floats]:
    """Both signals up to the time `end` within them."""
    i = int(np.searchsorted(times, end, side="left"))
    share = (end - times[i - 1]) / (times[i] - times[i - 1])
    last_one, last_other = (float(a[i - 1] + share * (a[i] - a[i - 1])) for a in (one, other))
    return np.append(times[:i], end), np.append(one[:i], last_one), np.append(other[:i], last_other)
