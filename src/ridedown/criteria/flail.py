"""The flail space: an occupant who flies on freely in the vehicle until the interior is reached.

Seen from a frame that moves on with the vehicle's first velocity the free occupant stands still, and the vehicle is what
moves. Accelerations and the yaw rate are straight lines between their samples. Over a step the integrals are taken by
Gauss's rule with four points, which is exact without yaw, where the integrands are straight lines; with yaw, and steps of a
millisecond at most, what the rule leaves is below the rounding of a double.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ridedown.compiled import kernel, part
from ridedown.criteria.checks import Floats, Table
from ridedown.criteria.strung import Ints

_LONGEST_STEP = 1e-3  # s

# Gauss-Legendre on [0, 1], four points; as their decimals are, and not as numpy finds them, so that they are constants here
_NODES = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)
_WEIGHTS = (0.17392742256872692, 0.3260725774312731, 0.3260725774312731, 0.17392742256872692)

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclass(frozen=True, slots=True)
class Contact:
    """When the occupant reaches the interior: the time [s], where from the start [m] and how fast against it [m/s]."""

    time: float
    forward: float
    lateral: float
    forward_velocity: float
    lateral_velocity: float

    @property
    def speed(self) -> float:
        """The resultant velocity [m/s] against the interior."""
        return math.hypot(self.forward_velocity, self.lateral_velocity)


class _Step(NamedTuple):
    """A part of a signal: how long [s], forward and lateral acceleration and yaw rate at its start, and how much they rise.

    Then the vehicle's heading, velocity and displacement at its start, and where the occupant is from the sensor.
    """

    length: float
    forward: float
    lateral: float
    yaw: float
    forward_rise: float
    lateral_rise: float
    yaw_rise: float
    heading: float
    u: float
    v: float
    x: float
    y: float
    ahead: float
    aside: float


@part
def _moved(step: _Step, share: float) -> tuple[float, float, float, float, float]:
    """The vehicle's heading, velocity and displacement in the frame, `share` of the way through a step."""
    length = share * step.length
    u, v, x, y = 0.0, 0.0, 0.0, 0.0
    for k in range(4):
        at = _NODES[k] * share
        forward, lateral = step.forward + at * step.forward_rise, step.lateral + at * step.lateral_rise
        angle = step.heading + at * step.length * (step.yaw + 0.5 * at * step.yaw_rise)
        cos, sin = 1.0, 0.0
        if angle != 0.0:
            cos, sin = math.cos(angle), math.sin(angle)
        along, across = forward * cos - lateral * sin, forward * sin + lateral * cos
        u += _WEIGHTS[k] * length * along
        v += _WEIGHTS[k] * length * across
        x += _WEIGHTS[k] * (1.0 - _NODES[k]) * length * length * along
        y += _WEIGHTS[k] * (1.0 - _NODES[k]) * length * length * across
    heading = step.heading + length * (step.yaw + 0.5 * share * step.yaw_rise)
    return heading, step.u + u, step.v + v, step.x + length * step.u + x, step.y + length * step.v + y


@part
def _seen_from(
    step: _Step, share: float, heading: float, along: float, across: float, x: float, y: float
) -> tuple[float, float, float, float]:
    """Path from the start and velocity of the occupant as seen from the vehicle that has moved so: x, y, u, v."""
    rate = step.yaw + share * step.yaw_rise
    cos, sin = math.cos(heading), math.sin(heading)
    away_x, away_y = step.ahead - x, step.aside - y
    seen_x, seen_y = cos * away_x + sin * away_y, cos * away_y - sin * away_x
    u = -cos * along - sin * across + rate * seen_y
    v = sin * along - cos * across - rate * seen_x
    return seen_x - step.ahead, seen_y - step.aside, u, v


@part
def _seen(step: _Step, share: float) -> tuple[float, float, float, float]:
    """The same, `share` of the way through a step."""
    heading, along, across, x, y = _moved(step, share)
    return _seen_from(step, share, heading, along, across, x, y)


@part
def _beyond(step: _Step, share: float, ahead: float, aside: float) -> float:
    """How far the occupant is beyond the free space, as a part of it; negative within."""
    x, y, _, _ = _seen(step, share)
    return max(x / ahead, abs(y) / aside) - 1.0


@part
def _farthest(step: _Step, ahead: float, aside: float) -> float:
    """The share of a step at which the occupant is farthest out, by golden sections, to 1e-9."""
    low, high = 0.0, 1.0
    one, other = high - _GOLDEN, low + _GOLDEN
    at_one, at_other = _beyond(step, one, ahead, aside), _beyond(step, other, ahead, aside)
    while high - low > 1e-9:
        if at_one > at_other:
            high, other, at_other = other, one, at_one
            one = high - _GOLDEN * (high - low)
            at_one = _beyond(step, one, ahead, aside)
        else:
            low, one, at_one = one, other, at_other
            other = low + _GOLDEN * (high - low)
            at_other = _beyond(step, other, ahead, aside)
    return 0.5 * (low + high)


@part
def _met(step: _Step, ahead: float, aside: float, x_then: float, y_then: float, u_then: float, v_then: float) -> float:
    """The share of a step at which the occupant comes to the end of the free space; -1 if it does not.

    x_then, ...: what is seen of it at the end of the step.
    """
    x, y, u, v = _seen_from(step, 0.0, step.heading, step.u, step.v, step.x, step.y)
    end = 1.0
    if max(x_then / ahead, abs(y_then) / aside) < 1.0:
        # out and back within one step: where the way there turns round and a full step at the speed before would reach it
        turning = u > 0.0 > u_then and x + step.length * u >= ahead
        turning = turning or (v > 0.0 > v_then and y + step.length * v >= aside)
        turning = turning or (v < 0.0 < v_then and -y - step.length * v >= aside)
        if not turning:
            return -1.0
        end = _farthest(step, ahead, aside)
        if _beyond(step, end, ahead, aside) < 0.0:
            return -1.0
    low = 0.0
    for _ in range(60):  # halving ends at neighbouring doubles
        middle = 0.5 * (low + end)
        if not low < middle < end:
            break
        if _beyond(step, middle, ahead, aside) >= 0.0:
            end = middle
        else:
            low = middle
    return end


@kernel
def _contacts(
    time: Floats, forward: Floats, lateral: Floats, yaw: Floats, starts: Ints,
    ahead: float, aside: float, offset_ahead: float, offset_aside: float, found: Table,
) -> None:  # fmt: skip
    """The contact of each signal's occupant: time, x, y, u and v, (R, 5); NaN where there is none."""
    for r in range(starts.size - 1):
        found[r, :] = math.nan
        heading, u, v, x, y = 0.0, 0.0, 0.0, 0.0, 0.0
        i = starts[r]
        while i < starts[r + 1] - 1:
            whole = time[i + 1] - time[i]
            parts = max(1, math.ceil(whole / _LONGEST_STEP * (1.0 - 1e-12)))
            df, dl, dy = forward[i + 1] - forward[i], lateral[i + 1] - lateral[i], yaw[i + 1] - yaw[i]
            for k in range(parts):
                step = _Step(
                    whole / parts, forward[i] + k / parts * df, lateral[i] + k / parts * dl, yaw[i] + k / parts * dy,
                    df / parts, dl / parts, dy / parts, heading, u, v, x, y, offset_ahead, offset_aside,
                )  # fmt: skip
                heading, u, v, x, y = _moved(step, 1.0)
                seen_x, seen_y, seen_u, seen_v = _seen_from(step, 1.0, heading, u, v, x, y)
                share = _met(step, ahead, aside, seen_x, seen_y, seen_u, seen_v)
                if share >= 0.0:
                    found[r, 0] = time[i] + (k + share) / parts * whole
                    found[r, 1], found[r, 2], found[r, 3], found[r, 4] = _seen(step, share)
                    i = starts[r + 1]
                    break
            i += 1


def contacts(time: Floats, inputs: Floats, starts: Ints, ahead: float, aside: float, offset: tuple[float, float]) -> Floats:
    """When and how each occupant has first gone `ahead` forward or `aside` to either side [m]: (R, 5), NaN if never.

    time: (N,) [s], signals end to end (see `strung`); inputs: (3, N), forward and lateral acceleration [m/s2], yaw rate
    [rad/s]; offset: of the occupant from the sensor [m]. Found: as the fields of a `Contact`.
    """
    found = np.empty((starts.size - 1, 5))
    _contacts(time, inputs[0].copy(), inputs[1].copy(), inputs[2].copy(), starts, ahead, aside, *offset, found)
    return found
