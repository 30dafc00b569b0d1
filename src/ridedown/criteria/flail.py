"""The flail space: an occupant who flies on freely in the vehicle until the interior is reached.

Seen from a frame that moves on with the vehicle's first velocity the free occupant stands still, and the vehicle is what
moves. Accelerations and the yaw rate are straight lines between their samples. Over a step the integrals are taken by
Gauss's rule with four points, which is exact without yaw, where the integrands are straight lines; with yaw, and steps of a
millisecond at most, what the rule leaves is below the rounding of a double.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ridedown.criteria.checks import Floats
from ridedown.criteria.moving import refined

LONGEST_STEP = 1e-3  # s

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS


@dataclass(frozen=True, slots=True)
class Contact:
    """When the occupant reaches the interior: the time [s], where from the start [m] and how fast against it [m/s]."""

    time: float
    forward: float
    lateral: float
    forward_velocity: float
    lateral_velocity: float


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """The vehicle's motion under a free occupant: samples and, at each, heading, velocity and displacement in the frame."""

    time: Floats  # (n,)
    inputs: Floats  # (3, n): forward and lateral acceleration, yaw rate
    heading: Floats  # (n,) rad
    velocity: Floats  # (2, n)
    displacement: Floats  # (2, n)
    offset: tuple[float, float]  # of the occupant from the sensor, m

    @classmethod
    def of(cls, time: Floats, inputs: Floats, offset: tuple[float, float]) -> Flight:
        """Integrate from the first sample."""
        time, inputs = refined(time, inputs, LONGEST_STEP)
        step = np.diff(time)
        yaw = inputs[2]
        heading = np.zeros(time.size)
        np.cumsum(0.5 * step * (yaw[1:] + yaw[:-1]), out=heading[1:])
        gained, moved = _integrals(step, inputs[:, :-1], np.diff(inputs, axis=1), heading[:-1], np.ones(step.size))
        velocity = np.zeros((2, time.size))
        np.cumsum(gained, axis=1, out=velocity[:, 1:])
        displacement = np.zeros((2, time.size))
        np.cumsum(velocity[:, :-1] * step + moved, axis=1, out=displacement[:, 1:])
        return cls(time, inputs, heading, velocity, displacement, offset)

    def at(self, step: int, share: float) -> Contact:
        """The occupant relative to the vehicle, in the vehicle's directions, `share` of the way through a step."""
        length = self.time[step + 1] - self.time[step]
        part = np.array([share])
        first, rise = self.inputs[:, step : step + 1], np.diff(self.inputs[:, step : step + 2], axis=1)
        gained, moved = _integrals(np.array([length]), first, rise, self.heading[step : step + 1], part)
        at = share * length
        heading = self.heading[step] + at * (first[2, 0] + 0.5 * share * rise[2, 0])
        velocity = self.velocity[:, step] + gained[:, 0]
        displacement = self.displacement[:, step] + at * self.velocity[:, step] + moved[:, 0]
        rate = first[2, 0] + share * rise[2, 0]
        x, y, u, v = _seen(displacement, velocity, heading, rate, self.offset)
        return Contact(float(self.time[step] + at), float(x), float(y), float(u), float(v))

    def contact(self, ahead: float, aside: float) -> Contact | None:
        """The first time at which the occupant has gone `ahead` forward or `aside` to either side [m]; None if never."""
        x, y, u, v = _seen(self.displacement, self.velocity, self.heading, self.inputs[2], self.offset)
        beyond = np.maximum(x / ahead, np.abs(y) / aside)
        reached = beyond >= 1.0
        # Out and back within one step: where the way there turns round and a full step at the speed before would reach it.
        step = np.diff(self.time)
        turning = np.zeros(step.size, dtype=bool)
        for way, speed, space in ((x, u, ahead), (y, v, aside), (-y, -v, aside)):
            turning |= (speed[:-1] > 0.0) & (speed[1:] < 0.0) & (way[:-1] + step * speed[:-1] >= space)
        for k in np.flatnonzero(reached[1:] | turning):
            end = 1.0
            if not reached[k + 1]:
                end = self._farthest(int(k), ahead, aside)
                if self._beyond(int(k), end, ahead, aside) < 0.0:
                    continue
            return self.at(int(k), self._root(int(k), end, ahead, aside))
        return None

    def _beyond(self, step: int, share: float, ahead: float, aside: float) -> float:
        here = self.at(step, share)
        return max(here.forward / ahead, abs(here.lateral) / aside) - 1.0

    def _farthest(self, step: int, ahead: float, aside: float) -> float:
        from scipy.optimize import minimize_scalar  # noqa: PLC0415  slow to import, and hardly ever needed

        found = minimize_scalar(
            lambda share: -self._beyond(step, float(share), ahead, aside),
            bounds=(0.0, 1.0),
            method="bounded",
            options={"xatol": 1e-9},
        )
        return float(found.x)

    def _root(self, step: int, end: float, ahead: float, aside: float) -> float:
        low, high = 0.0, end
        for _ in range(60):  # halving ends at neighbouring doubles
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if self._beyond(step, middle, ahead, aside) >= 0.0:
                high = middle
            else:
                low = middle
        return high


def _integrals(step: Floats, first: Floats, rise: Floats, heading: Floats, share: Floats) -> tuple[Floats, Floats]:
    """Velocity gained and displacement from it, (2, m) each, over the first `share` of steps, in the frame's directions."""
    length = share * step
    gained = np.zeros((2, step.size))
    moved = np.zeros((2, step.size))
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        at = node * share
        forward, lateral = first[0] + at * rise[0], first[1] + at * rise[1]
        angle = heading + at * step * (first[2] + 0.5 * at * rise[2])
        cos, sin = np.cos(angle), np.sin(angle)
        here = np.stack((forward * cos - lateral * sin, forward * sin + lateral * cos))
        gained += weight * length * here
        moved += weight * length**2 * (1.0 - node) * here
    return gained, moved


def _seen(
    displacement: Floats, velocity: Floats, heading: Floats | float, rate: Floats | float, offset: tuple[float, float]
) -> tuple[Floats, Floats, Floats, Floats]:
    """Path from the start and velocity of the occupant as seen from the vehicle, in its directions: x, y, u, v."""
    cos, sin = np.cos(heading), np.sin(heading)
    away = offset[0] - displacement[0], offset[1] - displacement[1]
    x, y = cos * away[0] + sin * away[1], cos * away[1] - sin * away[0]
    u = -cos * velocity[0] - sin * velocity[1] + rate * y
    v = sin * velocity[0] - cos * velocity[1] - rate * x
    return x - offset[0], y - offset[1], u, v


def speed(contact: Contact) -> float:
    """The resultant velocity [m/s] against the interior."""
    return math.hypot(contact.forward_velocity, contact.lateral_velocity)
