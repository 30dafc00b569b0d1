"""An occupant who flies free in a car that brakes, and is then braked at a constant rate: what OLC asks for.

z is how far the occupant is ahead of its place in the car and u the rate of that; the car's acceleration is straight between
samples, so z is cubic there. Where z comes up to the free flight, and then z - u (t - t1)/2 up to the whole way, is solved for.
"""

from __future__ import annotations

import math

from ridedown.compiled import kernel, part
from ridedown.criteria.checks import Floats, Table
from ridedown.criteria.strung import Ints


@part
def _cubic(c0: float, c1: float, c2: float, c3: float, s: float) -> float:
    return c0 + s * (c1 + s * (c2 + s * c3))


@part
def _reach(c0: float, c1: float, c2: float, c3: float, length: float, level: float) -> float:
    """When on [0, length] a cubic first comes up to a level; -1 if it does not."""
    if c0 >= level:
        return 0.0
    if c0 + length * (abs(c1) + length * (abs(c2) + length * abs(c3))) < level:
        return -1.0
    inside = c2 * c2 - 3.0 * c1 * c3
    one, two = length, length
    if inside >= 0.0:  # where it turns: c1 + 2 c2 s + 3 c3 s^2 = 0
        q = -(c2 + math.copysign(math.sqrt(inside), c2))
        one = q / (3.0 * c3) if c3 != 0.0 else length
        two = c1 / q if q != 0.0 else length
    start = 0.0
    for end in (min(max(min(one, two), 0.0), length), min(max(one, two, 0.0), length), length):
        if end > start and _cubic(c0, c1, c2, c3, end) >= level:
            low, high = start, end
            while True:
                middle = 0.5 * (low + high)
                if not low < middle < high:
                    return high
                if _cubic(c0, c1, c2, c3, middle) >= level:
                    high = middle
                else:
                    low = middle
        start = max(start, end)
    return -1.0


@part
def _direction(time: Floats, a: Floats, first: int, final: int) -> float:
    """-1 where the largest change of velocity, at a sample or where a goes through zero, is negative; else 1."""
    velocity, largest = 0.0, 0.0
    for i in range(first, final):
        h = time[i + 1] - time[i]
        if h > 0.0 and ((a[i] < 0.0 < a[i + 1]) or (a[i + 1] < 0.0 < a[i])):
            turn = velocity + 0.5 * h * a[i] * a[i] / (a[i] - a[i + 1])
            largest = turn if abs(turn) > abs(largest) else largest
        velocity += 0.5 * h * (a[i] + a[i + 1])
        largest = velocity if abs(velocity) > abs(largest) else largest
    return -1.0 if largest < 0.0 else 1.0


@kernel
def directions(time: Floats, a: Floats, starts: Ints, found: Floats) -> None:
    """Of each of R signals end to end (see `strung`): the sign of its largest change of velocity, (R,)."""
    for r in range(starts.size - 1):
        found[r] = _direction(time, a, starts[r], starts[r + 1] - 1)


@kernel
def ideal_restraints(time: Floats, d: Floats, starts: Ints, free: float, way: float, found: Table) -> None:
    """Of each of R signals end to end: t1 [s], t2 [s], the constant deceleration between them, the largest z; (R, 4).

    time, d: (N,), the car's deceleration [m/s2]; free, way: of the occupant until t1 and until t2 [m]. NaN for what is not
    reached.
    """
    for r in range(starts.size - 1):
        found[r, :] = math.nan
        z, u, furthest, t1 = 0.0, 0.0, 0.0, math.nan
        held, done = False, False
        for i in range(starts[r], starts[r + 1] - 1):
            whole = time[i + 1] - time[i]
            if not whole > 0.0:
                continue
            slope = (d[i + 1] - d[i]) / whole
            t, now, length = time[i], d[i], whole
            if not held:
                s = _reach(z, u, 0.5 * now, slope / 6.0, whole, free)
                held = s >= 0.0 and time[i] + s < time[starts[r + 1] - 1]
                if held:
                    z, u = _cubic(z, u, 0.5 * now, slope / 6.0, s), u + s * (now + 0.5 * s * slope)
                    t, now, length = time[i] + s, now + slope * s, whole - s
                    t1 = t
                    found[r, 0] = t1
            if held and not done:
                since = t - t1
                s = _reach(z - 0.5 * u * since, 0.5 * (u - now * since), -0.25 * slope * since, -slope / 12.0, length, way)
                if s >= 0.0:
                    done = True
                    change = u + s * (now + 0.5 * s * slope)
                    if change > 0.0:
                        found[r, 1], found[r, 2] = t + s, change / (t + s - t1)
            z, u = _cubic(z, u, 0.5 * now, slope / 6.0, length), u + length * (now + 0.5 * length * slope)
            furthest = max(furthest, z)
        found[r, 3] = furthest
