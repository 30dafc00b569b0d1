"""A measured test as a sled: the pulse of its vehicle, in few straight lines, with an occupant to begin from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown import units
from ridedown.errors import InvalidInput
from ridedown.limits import evidence
from ridedown.limits.evidence import CannotJudge
from ridedown.limits.measured import SHAPE_CLASS, levelled, through
from ridedown.scenario import SledScenario
from ridedown.scenario.pulse_reduction import reduced
from ridedown.signals.record import TestRecord

Floats = NDArray[np.float64]

_BEGIN_FROM = {
    "name": "driver",
    "kind": "adult",
    "mass": "77 kg",
    "restraint": {"stiffness": "60 kN/m", "slack": "20 mm", "damping_ratio": "20 %"},
}
"""One mass on a spring and a damper: a start for sliders and for `ridedown calibrate`, and nobody's measurement."""


def sled_of_test(record: TestRecord, *, pulse: str = "", occupant: Mapping[str, Any] | None = None) -> SledScenario:
    """The sled of a test's first vehicle: its acceleration, class 60, from time zero on, as few points; and an occupant.

    pulse: a channel of the vehicle's acceleration along x, for a record that does not say which of its channels that is; the
    speed is then that which the pulse takes off. occupant: the table of one, as in a scenario file; one mass on a spring and a
    damper if left out. The scenario is complete in itself: it names no file.

    Raises: InvalidInput where the record holds no pulse of a vehicle, or no speed; UnknownName for a channel it has not.
    """
    time, value, speed, used = _of_channel(record, pulse) if pulse else _of_vehicle(record)
    after = time >= 0.0
    if np.count_nonzero(after) < 2:
        raise InvalidInput("test: got a record that ends before time zero; need what comes after it. Give another test.")
    time, value = time[after] - time[after][0], value[after]
    knots, values = reduced(time, value)
    said = ", ".join(filter(None, (f"test {record.identifier}", record.title)))
    return SledScenario(
        name=_name(record.identifier),
        description=f"The pulse of {said}: channels {', '.join(used)}, class {SHAPE_CLASS}.",
        duration=float(time[-1]),
        speed=speed,
        pulse={"kind": "points", "points": [[float(t), float(a)] for t, a in zip(knots, values, strict=True)]},
        occupants=[_BEGIN_FROM if occupant is None else dict(occupant)],
    )


_Motion = tuple[Floats, Floats, float | None, tuple[str, ...]]
"""Times (n,) [s] and accelerations (n,) [m/s2] of the vehicle, its speed [m/s] where known, and the channels used."""


def _of_vehicle(record: TestRecord) -> _Motion:
    """The motion of the first vehicle that the record tells of."""
    have = evidence(record)
    if not have.vehicles:
        raise InvalidInput("test: got one without a vehicle; need channels of a vehicle's motion. Give another test.")
    vehicle = have.vehicles[0]
    try:
        pulse, speed = have.pulse(vehicle), have.speed(vehicle)
    except CannotJudge as why:
        raise InvalidInput(f"test: got no pulse that can be used ({why}); need the vehicle's acceleration and speed.") from None
    return pulse.time, pulse.shape, float(speed), pulse.used


def _of_channel(record: TestRecord, key: str) -> _Motion:
    """The motion that one channel tells."""
    history = record.history(key)
    if not units.is_known(history.unit) or units.dimension(history.unit) is not units.ACCELERATION:
        raise InvalidInput(f"pulse: got {key[:60]!r} in {history.unit!r}; need an acceleration. Name another channel.")
    smooth, _ = through(history, SHAPE_CLASS)
    time, value = smooth.si
    return time, levelled(time, value), None, (history.name or key,)


def _name(identifier: str) -> str:
    kept = "".join(c if c.isalnum() or c in "-_" else "-" for c in identifier).strip("-") or "test"
    return f"sled-{kept}"[:60]
