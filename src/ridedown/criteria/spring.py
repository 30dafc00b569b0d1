"""An occupant on a slack spring in a car that brakes: its motion, solved on each straight piece of the pulse.

z is the occupant's displacement ahead of the car and d the car's deceleration, straight on a piece. Free, z'' = d and z is a
cubic. On the spring, y = z - slack follows y'' + w^2 y = d, so y = (d0 + d1 s)/w^2 + A cos ws + B sin ws. Taking up the slack,
peaks and letting go are located, not stepped over.
"""

from __future__ import annotations

import math

from ridedown.compiled import kernel, part
from ridedown.criteria.checks import Floats, Table
from ridedown.criteria.strung import Ints

_LATER = 1.0 + 1e-12  # the same peak again, a swing later, is not a higher one
_HALVINGS = 200  # more than a double has bits between any two lengths that matter


@part
def _free(z: float, u: float, d: float, slope: float, s: float) -> float:
    """Displacement a time s later, without the spring."""
    return z + s * (u + s * (0.5 * d + s * slope / 6.0))


@part
def _taken_up(z: float, u: float, d: float, slope: float, slack: float, length: float) -> float:
    """When the free occupant has taken up the slack, within `length`; -1 if not."""
    turns = (length, length)
    inside = d * d - 2.0 * slope * u
    if inside >= 0.0:
        q = -(d + math.copysign(math.sqrt(inside), d))
        one = q / slope if slope != 0.0 else length
        two = 2.0 * u / q if q != 0.0 else length
        turns = (min(max(min(one, two), 0.0), length), min(max(one, two, 0.0), length))
    start = 0.0
    for end in (turns[0], turns[1], length):  # z rises or falls throughout each
        if end > start and _free(z, u, d, slope, end) > slack and _free(z, u, d, slope, start) <= slack:
            low, high = start, end
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                if middle in (low, high):
                    break
                if _free(z, u, d, slope, middle) > slack:
                    high = middle
                else:
                    low = middle
            return high
        start = end
    return -1.0


@part
def _held(y: float, u: float, d: float, slope: float, w: float, s: float) -> float:
    """Extension of the spring a time s later; the forms do not cancel, however short the piece and steep the pulse on it."""
    angle, half = w * s, math.sin(0.5 * w * s)
    if angle > 0.5:
        beyond = angle - math.sin(angle)
    else:  # its series: the next term is below 1e-17 of it
        square = angle * angle
        beyond = angle * square / 6.0
        beyond *= 1.0 - square / 20.0 * (
            1.0 - square / 42.0 * (1.0 - square / 72.0 * (1.0 - square / 110.0 * (1.0 - square / 156.0)))
        )
    return y * math.cos(angle) + (u * math.sin(angle) + (2.0 * d * half * half + slope * beyond / w) / w) / w


@part
def _rate(y: float, u: float, d: float, slope: float, w: float, s: float) -> float:
    """Rate of the extension a time s later."""
    sine, half = math.sin(w * s), math.sin(0.5 * w * s)
    return u * math.cos(w * s) - w * y * sine + (d * sine + 2.0 * slope * half * half / w) / w


@part
def _let_go(y: float, u: float, d: float, slope: float, w: float, low: float, high: float) -> float:
    """When the spring goes slack, between `low`, where it is stretched, and `high`, where it would push."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if _held(y, u, d, slope, w, middle) >= 0.0:
            low = middle
        else:
            high = middle
    return high


@part
def _next_turn(phase: float, half: float) -> float:
    """The first of the angles 2 pi n -+ half after `phase`."""
    turn = 2.0 * math.pi * math.floor(phase / (2.0 * math.pi))
    for angle in (turn - half, turn + half, turn + 2.0 * math.pi - half, turn + 2.0 * math.pi + half):
        if angle > phase:
            return angle
    return turn + 4.0 * math.pi - half


@part
def _hold(y: float, u: float, d: float, slope: float, w: float, length: float) -> tuple[float, float, float, float, bool]:
    """Follow the spring for `length` or until it lets go: time spent, extension then, greatest extension, when, if it holds."""
    a = y - d / (w * w)
    b = (u - slope / (w * w)) / w
    size = math.hypot(a, b)
    level = -slope / (w * w * w)  # y' = 0 where size cos(w s + phase) is at this level
    phase = math.atan2(a, b)
    turning = size > abs(level)
    half = math.acos(level / size) if turning else 0.0
    most, when = y, 0.0
    start, angle = 0.0, phase
    while True:
        end = length
        if turning:
            angle = _next_turn(angle, half)
            end = min(max((angle - phase) / w, start), length)
        reached = _held(y, u, d, slope, w, end)
        if reached > most * _LATER:
            most, when = reached, end
        if reached < 0.0:
            return _let_go(y, u, d, slope, w, start, end), 0.0, most, when, False
        if not end < length:
            return length, reached, most, when, True
        start = end


@kernel
def greatest_extension(time: Floats, d: Floats, w: float, slack: float) -> tuple[float, float, float, float, bool]:
    """Of the spring: greatest extension [m] and when [s]; in the end: displacement [m], its rate [m/s], whether it holds.

    time, d: (n,), the car's deceleration [m/s2]; w: natural frequency [rad/s]; slack [m]. At rest in the car to begin with.
    """
    z, u = 0.0, 0.0
    most, when = 0.0, time[0]
    holds = slack == 0.0 and d[0] > 0.0
    for i in range(time.size - 1):
        length = time[i + 1] - time[i]
        if length <= 0.0:
            continue
        slope = (d[i + 1] - d[i]) / length
        t, now = time[i], d[i]
        while length > 0.0:
            if holds:
                y = z - slack
                spent, z, extension, at, holds = _hold(y, u, now, slope, w, length)
                if extension > most * _LATER:
                    most, when = extension, t + at
                z, u = slack + z, _rate(y, u, now, slope, w, spent)
            else:
                spent = _taken_up(z, u, now, slope, slack, length)
                holds = spent >= 0.0
                if not holds:
                    spent = length
                z, u = _free(z, u, now, slope, spent), u + spent * (now + 0.5 * spent * slope)
                z = slack if holds else z
            t += spent
            now += slope * spent
            length -= spent
    return most, when, z, u, holds


@kernel
def greatest_extensions(time: Floats, d: Floats, starts: Ints, w: float, slack: float, found: Table) -> None:
    """The same of each of R signals end to end (see `strung`): (R, 5), the last 1 where the spring holds."""
    for r in range(starts.size - 1):
        first, final = starts[r], starts[r + 1]
        most, when, z, u, holds = greatest_extension(time[first:final], d[first:final], w, slack)
        found[r, 0], found[r, 1], found[r, 2], found[r, 3], found[r, 4] = most, when, z, u, 1.0 if holds else 0.0
