"""What the animation is drawn from: the arms of the bar, who sits where, and what restrains them."""

from __future__ import annotations

from typing import Any

from ridedown.scenario import (
    Airbag,
    AnyRestraint,
    Belt,
    CrashScenario,
    NetworkScenario,
    Occupant,
    Restraint,
    Scenario,
    SledScenario,
)

_CAR_WIDTH = 1.8  # m, where the scenario names none
_RAILS = 1.1  # m


def geometry(scenario: Scenario) -> dict[str, Any]:
    """Lengths [m] and names; `kind` is crash, wall, sled or network."""
    if isinstance(scenario, NetworkScenario):
        return {
            "kind": "network",
            "masses": [{"name": body.name, "mass": float(body.mass)} for body in scenario.masses],
            "elements": [{"name": element.name, "between": list(element.between)} for element in scenario.elements],
            "occupants": [],
        }
    return {**_vehicles(scenario), "occupants": [_occupant(occupant) for occupant in scenario.occupants]}


def _vehicles(scenario: CrashScenario | SledScenario) -> dict[str, Any]:
    if isinstance(scenario, SledScenario):
        return {"kind": "sled", "width": _CAR_WIDTH, "masses": []}
    bar = scenario.bar
    vehicles = [vehicle for vehicle in (scenario.vehicle1, scenario.vehicle2) if vehicle is not None]
    arms = [_RAILS / 2.0] * 4 if bar is None else [float(arm) for arm in bar.lengths()]
    return {
        "kind": "wall" if scenario.vehicle2 is None else "crash",
        "width": _CAR_WIDTH if bar is None or bar.width is None else float(bar.width),
        "arms": arms,
        "masses": [float(vehicle.mass) for vehicle in vehicles],
    }


def _occupant(occupant: Occupant) -> dict[str, Any]:
    return {
        "name": occupant.name,
        "kind": occupant.kind,
        "vehicle": occupant.vehicle,
        "bodies": [{"name": body.name, "channel": f"{occupant.name}.{body.name}"} for body in occupant.bodies],
        "restraints": [_restraint(name, one) for name, one in occupant.held_by()],
    }


def _restraint(name: str, one: Restraint | AnyRestraint) -> dict[str, Any]:
    if isinstance(one, Restraint):
        return {"name": name, "kind": "lumped", "slack": float(one.slack)}
    made: dict[str, Any] = {"name": name, "kind": one.kind, "on": one.on}
    if isinstance(one, Belt):
        return {**made, "slack": float(one.slack)}
    made["gap"] = float(one.gap)
    if isinstance(one, Airbag):
        made |= {"fire_time": float(one.fire_time), "fill_time": float(one.fill_time)}
    return made
