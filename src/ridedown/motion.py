"""The motion of a vehicle, wherever it comes from: a sled, a response, a measured channel, a pulse."""

from __future__ import annotations

import numpy as np

from ridedown import network
from ridedown.criteria.checks import from_time_zero, signal
from ridedown.errors import InvalidInput, UnknownName
from ridedown.network import channels
from ridedown.response import Response
from ridedown.scenario import SledScenario
from ridedown.scenario.lowering import pulse_of
from ridedown.scenario.pulse_motion import PulseMotion
from ridedown.scenario.pulse_shapes import through
from ridedown.signals import TimeHistory

Source = Response | SledScenario | TimeHistory | network.Pulse | PulseMotion
"""What has a vehicle's motion in it."""


def motion_of(source: Source, vehicle: str = "vehicle1") -> PulseMotion:
    """The motion of a vehicle, or of a mass in a network, in a response; a sled's needs no solving for.

    source: or an acceleration in the signs of SAE J211 (a braking car is negative): a measured channel, from time zero on, or
    from its first value if that is later; a network's pulse, whose last piece must be zero, so that it has an end. The speed of
    these is not known, and taken for 0.

    Raises: UnknownName for a body that is not there; InvalidInput for a signal that is not an acceleration, or a pulse without
    end.
    """
    if isinstance(source, PulseMotion):
        return source
    if isinstance(source, TimeHistory):
        time, value = from_time_zero(*signal(source.time, source.converted("m/s2").values, source.name or "history"), None)
        return PulseMotion(*through(time - time[0], value), end=float(time[-1] - time[0]), speed=0.0)
    if isinstance(source, network.Pulse):
        return _of_pulse(source)
    if isinstance(source, SledScenario):
        if vehicle != "vehicle1":
            raise UnknownName.among("vehicle", vehicle, ["vehicle1"])
        speed = float(np.ravel(source.initial_speed)[0])
        return PulseMotion.of(pulse_of(source), end=float(source.duration), speed=speed)
    bodies = [c for c, turns in zip(source.network.coordinates, source.network.is_rotation, strict=True) if not turns]
    if vehicle not in bodies:
        raise UnknownName.among("vehicle", vehicle, bodies)
    phases = source.phases
    series = phases.series(channels(source.network)[f"{vehicle}.acceleration"])
    kept = phases.length > 0.0
    return PulseMotion(phases.start[kept], series[kept], phases.end, float(source.at(f"{vehicle}.velocity", 0.0)))


def _of_pulse(pulse: network.Pulse) -> PulseMotion:
    if pulse.start.size < 2 or pulse.series[-1].any():
        raise InvalidInput("pulse.series: got a last piece that is not zero; need a pulse that ends. Add a piece of zeros.")
    end = float(np.ravel(pulse.length)[0]) * float(pulse.start[-1])
    return PulseMotion.of(pulse, end=end, speed=0.0)
