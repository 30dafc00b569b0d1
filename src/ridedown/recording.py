"""A simulated response as laboratories hold theirs: time histories, and a test record with channel codes.

A lumped vehicle is recorded as its centre of gravity, an occupant of one mass as its chest; both are accelerations along x of
the whole mass. Pelvis, chest and head of an occupant of several masses are recorded as such. What has no such place
(excursions, forces of the restraints) is recorded without a code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput
from ridedown.scenario import NetworkScenario, Scenario, SledScenario
from ridedown.scenario import Occupant as ScenarioOccupant
from ridedown.signals.codes import SEATS, ChannelCode
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import Occupant, TestRecord, Vehicle
from ridedown.solver.phases import Phases

Floats = NDArray[np.float64]

_MOST_POINTS = 5_000_000  # of one history: 80 MB
_QUANTITIES = {"acceleration": "AC", "velocity": "VE", "displacement": "DS"}
_LOCATIONS = {"pelvis": "PELV", "chest": "CHST", "head": "HEAD"}
_ADULTS, _CHILDREN = "132546789", "465789132"
"""Positions in the vehicle, in the order in which its occupants are given them: the front seats first, children behind."""


def knots(phases: Phases, series: Floats, tolerance: float) -> tuple[Floats, Floats]:
    """Times [s] and values between which a channel is straight to within `tolerance` times its largest magnitude.

    Two equal times are a jump. The largest and the smallest value are among the values, exact.

    Raises: InvalidInput for a tolerance that is not > 0, or one that would take millions of points.
    """
    if not tolerance > 0.0:
        raise InvalidInput(f"tolerance: got {tolerance:g}; need > 0, a part of the channel's peak. Give 1e-6 or so.")
    tops = [phases.largest(series, sense) for sense in (1, -1)]
    allowed = tolerance * max(abs(value) for value, _ in tops)
    orders = np.arange(series.shape[1])
    # no more than this is any second derivative within the phase, times its length squared
    bend = (np.abs(series) * phases.length[:, None] ** orders * orders * (orders - 1)).sum(axis=1)
    pieces = np.ones(phases.start.size) if allowed == 0.0 else np.maximum(np.ceil(np.sqrt(bend / (8.0 * allowed))), 1.0)
    if not pieces.sum() < _MOST_POINTS:
        raise InvalidInput(f"tolerance: got {tolerance:g}; need one that {_MOST_POINTS:,} points can keep. Give a larger one.")
    times, values = [], []
    for n in range(phases.start.size):
        local = np.linspace(0.0, phases.length[n], int(pieces[n]) + 1)
        begin, end = phases.start[n], phases.start[n] + phases.length[n]
        inside = [time - begin for _, time in tops if begin < time < end]
        local = np.array(sorted({*local.tolist(), *inside})) if inside else local
        times.append(begin + local)
        values.append(np.polynomial.polynomial.polyval(local, series[n]))
    return np.maximum.accumulate(np.concatenate(times)), np.concatenate(values)


def code_of(channel: str, places: Mapping[str, tuple[str, str, str]]) -> str | None:
    """The ISO-MME code of a channel, where its body has a place, else None."""
    body, _, quantity = channel.rpartition(".")
    if body not in places or quantity not in _QUANTITIES:
        return None
    vehicle, position, location = places[body]
    if location == "CHST" and quantity == "displacement":
        return None  # a displacement of the chest is its deflection, to every other program
    return str(ChannelCode(vehicle, position, location, "00", "00", "00", _QUANTITIES[quantity], "X", "0"))


def places_of(scenario: Scenario) -> dict[str, tuple[str, str, str]]:
    """Vehicle, position and main location, as channel codes have them, of each vehicle and mass; nine people to a vehicle.

    Of an occupant of several bodies, pelvis, chest and head have places; its mean motion has none.
    """
    if isinstance(scenario, NetworkScenario):
        return {}
    places = {f"vehicle{n}": (str(n), "0", "VEHC") for n in (1, 2)}
    taken: set[tuple[str, str]] = set()
    for occupant in scenario.occupants:
        vehicle = str(occupant.vehicle)
        order = _CHILDREN if occupant.kind == "child" else _ADULTS
        place = next(((vehicle, position) for position in order if (vehicle, position) not in taken), None)
        if place is not None:
            taken.add(place)
            parts = {f"{occupant.name}.{body.name}": _LOCATIONS.get(body.name) for body in occupant.bodies}
            for name, location in (parts or {occupant.name: "CHST"}).items():
                if location is not None:
                    places[name] = (*place, location)
    return places


def _position_of(occupant: ScenarioOccupant, places: Mapping[str, tuple[str, str, str]]) -> str | None:
    """Where an occupant sits, None where there is no place left, or none of its masses has one."""
    return next((places[name][1] for name in occupant.mass_names if name in places), None)


def record_of(scenario: Scenario, units: Mapping[str, str], times: Floats, at: Callable[[str, Floats], Floats]) -> TestRecord:
    """A test record of the channels, sampled evenly at `times` [s]."""
    places = places_of(scenario)
    step = float(times[-1] / (times.size - 1))
    histories = [
        TimeHistory(at(name, times), unit, interval=step, name=name, code=code_of(name, places)) for name, unit in units.items()
    ]
    name = scenario.name or "scenario"
    vehicles: list[Vehicle] = []
    occupants: list[Occupant] = []
    if isinstance(scenario, SledScenario):
        vehicles.append(Vehicle(1, "vehicle1", speed=float(np.ravel(scenario.initial_speed)[0])))
    elif not isinstance(scenario, NetworkScenario):
        for number, given in ((1, scenario.vehicle1), (2, scenario.vehicle2)):
            if given is not None:
                vehicles.append(Vehicle(number, f"vehicle{number}", float(given.mass), float(given.speed)))
    if not isinstance(scenario, NetworkScenario):
        for occupant in scenario.occupants:
            position = _position_of(occupant, places)
            if position is not None:
                seat = SEATS.get(position, f"position {position}")
                masses = f"{len(occupant.bodies)} lumped masses" if occupant.bodies else "a lumped mass"
                occupants.append(Occupant(seat, occupant.vehicle, dummy=f"{occupant.name}, {masses}"))
    return TestRecord.of(
        histories,
        identifier=name,
        title=f"{name}, simulated by ridedown",
        format="simulation",
        vehicles=tuple(vehicles),
        occupants=tuple(occupants),
    )
