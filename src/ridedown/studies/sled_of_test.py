"""A measured test as a sled: the pulse of its vehicle, in few straight lines, with an occupant to begin from."""

from __future__ import annotations

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.limits import evidence
from ridedown.limits.evidence import CannotJudge
from ridedown.scenario import SledScenario
from ridedown.scenario.pulse_reduction import reduced
from ridedown.signals.record import TestRecord

_BEGIN_FROM = {
    "name": "driver",
    "kind": "adult",
    "mass": "77 kg",
    "restraint": {"stiffness": "60 kN/m", "slack": "20 mm", "damping_ratio": "20 %"},
}
"""One mass on a spring and a damper: a start for sliders and for `ridedown calibrate`, and nobody's measurement."""


def sled_of_test(record: TestRecord) -> SledScenario:
    """The sled of a test's first vehicle: its acceleration, class 60, from time zero on, as few points; and an occupant.

    The scenario is complete in itself: it names no file.

    Raises: InvalidInput where the record holds no pulse of a vehicle, or no speed.
    """
    have = evidence(record)
    if not have.vehicles:
        raise InvalidInput("test: got one without a vehicle; need channels of a vehicle's motion. Give another test.")
    vehicle = have.vehicles[0]
    try:
        pulse, speed = have.pulse(vehicle), have.speed(vehicle)
    except CannotJudge as why:
        raise InvalidInput(f"test: got no pulse that can be used ({why}); need the vehicle's acceleration and speed.") from None
    after = pulse.time >= 0.0
    if np.count_nonzero(after) < 2:
        raise InvalidInput("test: got a record that ends before time zero; need what comes after it. Give another test.")
    time, value = pulse.time[after] - pulse.time[after][0], pulse.shape[after]
    knots, values = reduced(time, value)
    return SledScenario(
        name=_name(record.identifier),
        description=f"The pulse of test {record.identifier}, {record.title}: channels {', '.join(pulse.used)}, class 60.",
        duration=float(time[-1]),
        speed=float(speed),
        pulse={"kind": "points", "points": [[float(t), float(a)] for t, a in zip(knots, values, strict=True)]},
        occupants=[_BEGIN_FROM],
    )


def _name(identifier: str) -> str:
    kept = "".join(c if c.isalnum() or c in "-_" else "-" for c in identifier).strip("-") or "test"
    return f"sled-{kept}"[:60]
