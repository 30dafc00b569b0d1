"""Which channels are drawn together against time, in which unit and colour: for figures on paper and on the live page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ridedown.network import Law, Network
from ridedown.response import Response
from ridedown.scenario import CrashScenario, NetworkScenario, Scenario

G = 9.80665  # m/s2, the standard value


@dataclass(frozen=True, slots=True)
class Line:
    """One channel in a figure: its label, and the number of its colour and dashes; the same body looks the same everywhere."""

    label: str
    channel: str
    index: int
    dash: int | None = None


@dataclass(frozen=True, slots=True)
class Kind:
    """A figure against time: file name, title, quantity with unit, factor from SI, and what to say of its peaks."""

    name: str
    title: str
    ylabel: str
    scale: float
    unit: str


DISPLACEMENT = Kind("displacement", "Displacement", "displacement, m", 1.0, "m")
VELOCITY = Kind("velocity", "Velocity", "velocity, m/s", 1.0, "m/s")
ACCELERATION = Kind("acceleration", "Acceleration", "acceleration, g", 1.0 / G, "g")
EXCURSION = Kind("excursion", "Excursion of the occupants", "displacement, mm", 1e3, "mm")
MEMBERS = Kind("crush-force", "Crush forces", "force, kN", 1e-3, "kN")
RESTRAINTS = Kind("restraint-force", "Restraint forces", "force, kN", 1e-3, "kN")
TIES = Kind("force", "Forces of springs and dampers", "force, kN", 1e-3, "kN")
ROTATION = Kind("bar-rotation", "Rotation of the bumper bar", "angle, degrees", 180.0 / np.pi, "degrees")


def against_time(response: Response) -> Iterator[tuple[Kind, list[Line]]]:
    """The figures against time that a response has something to show in, in the order to look at them in."""
    scenario, network = response.scenario, response.network
    yield ACCELERATION, bodies(scenario, "acceleration")
    yield VELOCITY, bodies(scenario, "velocity")
    yield DISPLACEMENT, bodies(scenario, "displacement")
    if lines := excursions(scenario):
        yield EXCURSION, lines
    if lines := elements(scenario, network, crushing=False):
        yield TIES if isinstance(scenario, NetworkScenario) else RESTRAINTS, lines
    if lines := elements(scenario, network, crushing=True):
        yield MEMBERS, lines
    if "bar.rotation" in network.coordinates:
        yield ROTATION, [Line("bar", "bar.rotation", 6, dash=0)]


def bodies(scenario: Scenario, quantity: str) -> list[Line]:
    """A quantity of every vehicle and every mass of an occupant, or of the masses of a network."""
    if isinstance(scenario, NetworkScenario):
        names = {body.name: i for i, body in enumerate(scenario.masses)}
    else:
        names = {name: i for i, name in enumerate(vehicles(scenario))} | _occupant_index(scenario)
    return [Line(name, f"{name}.{quantity}", i) for name, i in names.items()]


def vehicles(scenario: Scenario) -> tuple[str, ...]:
    """The names of the vehicles; none in a network."""
    if isinstance(scenario, NetworkScenario):
        return ()
    two = isinstance(scenario, CrashScenario) and scenario.vehicle2 is not None
    return ("vehicle1", "vehicle2") if two else ("vehicle1",)


def excursions(scenario: Scenario) -> list[Line]:
    """How far every mass of an occupant comes forward in its vehicle, and a child in its seat."""
    if isinstance(scenario, NetworkScenario):
        return []
    lines = []
    index = _occupant_index(scenario)
    for occupant in scenario.occupants:
        for name in occupant.mass_names:
            lines.append(Line(f"{name}, to the vehicle", f"{name}.excursion", index[name]))
            if occupant.kind == "child":
                lines.append(Line(f"{name}, to the seat", f"{name}.relative_displacement", index[name] + len(index)))
    return lines


def elements(scenario: Scenario, network: Network, *, crushing: bool) -> list[Line]:
    """The forces of what crushes, or of everything else."""
    curves = {Law.ELASTIC, Law.PLASTIC}
    names = [name for name, law in zip(network.elements, network.law.tolist(), strict=True) if (law in curves) == crushing]
    of_occupants = not crushing and bool(getattr(scenario, "occupants", ()))
    return [Line(name, f"{name}.force", i) for i, name in enumerate(names, 2 if of_occupants else 0)]


def _occupant_index(scenario: Scenario) -> dict[str, int]:
    """The masses of the occupants, each with the number of its colour."""
    names = [name for occupant in getattr(scenario, "occupants", ()) for name in occupant.mass_names]
    return {name: 2 + i for i, name in enumerate(names)}
