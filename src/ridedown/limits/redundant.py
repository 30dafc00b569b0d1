"""Several accelerometers, one vehicle: which of them to believe.

An accelerometer that drifts, or whose mount moves, tells so by its integral: the velocity wanders away from that of the others.
Sensors of one crash have no other cause to differ in velocity but the vehicle's own turning, which moves left and right apart
in opposite ways and leaves their mean alone. So each sensor is integrated; of all pairs, one on either side where there are
both, the pair whose velocities stay closest over the whole record (root mean square) is believed, and its mean is the pulse.
No speed from the header takes part, so that the header remains a check.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ridedown.criteria.checks import Floats

DOUBTFUL = 0.5
"""m/s, root mean square. Where even the best pair's velocities differ by more, the pulse is given with a warning: over a record
of 300 ms that is what a constant error of 0.3 g comes to."""


@dataclass(frozen=True, slots=True)
class Sensor:
    """One candidate: a name for messages, its side ("left", "right" or ""), and its velocity change (n,) [m/s]."""

    name: str
    side: str
    velocity: Floats


@dataclass(frozen=True, slots=True)
class Choice:
    """Indices of the sensors believed, and sentences on those that were not and on how far the believed ones agree."""

    chosen: tuple[int, ...]
    rejected: tuple[str, ...]
    remarks: tuple[str, ...]


def choose(sensors: list[Sensor]) -> Choice:
    """Which of the sensors, one at least, to take the mean of. All velocities are on one and the same even grid.

    >>> import numpy as np
    >>> t = np.linspace(0.0, 0.3, 301)
    >>> good, also, drifting = -15.0 * np.minimum(t / 0.1, 1.0), -15.0 * np.minimum(t / 0.1, 1.0) + 0.2 * t, -15.0 * t / 0.1
    >>> choose([Sensor("1", "left", drifting), Sensor("2", "right", good), Sensor("3", "left", also)]).chosen
    (1, 2)
    """
    if len(sensors) == 1:
        return Choice((0,), (), (f"{sensors[0].name} is the only sensor: nothing to compare it with",))
    pairs = list(combinations(range(len(sensors)), 2))
    opposite = [pair for pair in pairs if {sensors[pair[0]].side, sensors[pair[1]].side} == {"left", "right"}]
    apart = {pair: _rms(sensors[pair[0]].velocity - sensors[pair[1]].velocity) for pair in opposite or pairs}
    best = min(apart, key=lambda pair: apart[pair])
    names = f"{sensors[best[0]].name} and {sensors[best[1]].name}"
    remarks = [f"{names} agree to {apart[best]:.2f} m/s root mean square"]
    if not opposite:
        remarks.append("no pair of one left and one right sensor: the vehicle's turning is not averaged out")
    if apart[best] > DOUBTFUL:
        remarks.append(f"even the best pair differs by {apart[best]:.2f} m/s: doubtful")
    mean = 0.5 * (sensors[best[0]].velocity + sensors[best[1]].velocity)
    rejected = tuple(
        f"{sensor.name}: {_rms(sensor.velocity - mean):.2f} m/s root mean square, "
        f"{abs(float(sensor.velocity[-1] - mean[-1])):.2f} m/s at the end, away from {names}"
        for i, sensor in enumerate(sensors)
        if i not in best
    )
    return Choice(best, rejected, tuple(remarks))


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
