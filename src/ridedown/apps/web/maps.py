"""Maps: thousands of crashes over two parameters, and an outcome of each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.apps.web.crash import Frame, finite
from ridedown.apps.web.sliders import ends
from ridedown.errors import InvalidInput, UnknownName
from ridedown.report.lines import G, vehicles
from ridedown.scenario import NetworkScenario, Scenario, broken_rules
from ridedown.simulation import simulate_many

Floats = NDArray[np.float64]

USUAL_SIDE, MOST_SIDE = 100, 200
"""Crashes along each side of a map."""

_CHEST_LIMIT = 60.0 * G  # m/s2, as the founding paper has it of FMVSS 208: of the peak


def outcomes(scenario: Scenario) -> list[dict[str, Any]]:
    """What a map can show: outcomes with their unit, a limit [SI] where one is usual, and whose `bound` they have."""
    found: list[tuple[str, str, str, float | None]] = []
    if isinstance(scenario, NetworkScenario):
        for body in scenario.masses:
            found.append((f"{body.name}.acceleration.peak", f"{body.name}, peak acceleration", "m/s2", None))
            found.append((f"{body.name}.displacement.max", f"{body.name}, largest displacement", "m", None))
    else:
        for occupant in scenario.occupants:
            limit = _CHEST_LIMIT if occupant.kind == "adult" else None
            for name in occupant.mass_names:
                chest = name == occupant.name or name.endswith(".chest")
                found.append((f"{name}.acceleration.peak", f"{name}, peak acceleration", "m/s2", limit if chest else None))
                found.append((f"{name}.excursion.max", f"{name}, excursion", "m", None))
            for name, _ in occupant.held_by():
                found.append((f"{name}.force.max", f"{name}, largest force", "N", None))
        for vehicle in vehicles(scenario):
            found.append((f"{vehicle}.acceleration.peak", f"{vehicle}, peak acceleration", "m/s2", None))
            found.append((f"{vehicle}.velocity.change", f"{vehicle}, delta-v", "m/s", None))
            found.append((f"{vehicle}.displacement.max", f"{vehicle}, largest displacement", "m", None))
    riding = {name for one in getattr(scenario, "occupants", ()) for name in one.mass_names}
    return [
        {"name": name, "label": label, "unit": unit, "limit": limit, "bound": _bounded(name, riding)}
        for name, label, unit, limit in found
    ]


def _bounded(outcome: str, riding: set[str]) -> str | None:
    """The occupant, or the mass of one, whose peak acceleration an outcome is: its bound is known (see `bounds`)."""
    body = outcome.removesuffix(".acceleration.peak")
    return body if body != outcome and body in riding else None


def crash_map(scenario: Scenario, message: Mapping[str, Any]) -> Frame:
    """Crashes on a grid of `x` and `y`, parameter paths, and their `outcome`; signs are dropped from peaks.

    Arrays: `x` (n,), `y` (n,), `outcome` (n, n), a row for each y; NaN where a crash could not be solved, or breaks a
    rule of the scenario. `x_ends` and
    `y_ends`, pairs, replace the ends of the sliders.

    Raises: InvalidInput, UnknownName, naming the field.
    """
    side = _side(message.get("side", USUAL_SIDE))
    known = {one["name"]: one for one in outcomes(scenario)}
    outcome = str(message.get("outcome"))[:200]
    if outcome not in known:
        raise UnknownName.among("outcome", outcome, known)
    (first, x), (second, y) = axes(scenario, message, side)
    table = {first: np.tile(x, side), second: np.repeat(y, side)}
    allowed, why = allowed_rows(scenario, table)
    values = solved(concerned(scenario, {outcome, first, second}), table, allowed, outcome, threads=2)
    header = {
        "kind": "map",
        "x": first,
        "y": second,
        "outcome": known[outcome],
        "crashes": int(allowed.sum()),
        "failed": int(np.isnan(values[allowed]).sum()),
        "refused": int(np.count_nonzero(~allowed)),
        "why": why,
    }
    return header, {"x": x, "y": y, "outcome": finite(np.abs(values).reshape(side, side))}


def solved(
    scenario: Scenario, table: Mapping[str, Floats], allowed: NDArray[np.bool_], outcome: str, *, threads: int
) -> Floats:
    """An outcome of every row of a table (R,), NaN where a row is not allowed, or was not solved to its end."""
    values = np.full(allowed.size, np.nan)
    if allowed.any():
        rows = {path: column[allowed] for path, column in table.items()}
        many = simulate_many(scenario, rows, outcomes=[outcome], threads=threads)
        values[allowed] = np.where(many.completed, many[outcome], np.nan)
    return values


def axes(scenario: Scenario, message: Mapping[str, Any], side: int) -> tuple[tuple[str, Floats], tuple[str, Floats]]:
    """The parameters of `x` and `y`, each with its values (side,). Raises: InvalidInput, UnknownName."""
    known = ends(scenario)
    first, second = (_path(message, axis, known) for axis in ("x", "y"))
    if first == second:
        raise InvalidInput(f"y: got {second}, the parameter of x too; need two different ones. Choose another.")
    x, y = (_column(message, axis, known[path], side) for axis, path in (("x", first), ("y", second)))
    return (first, x), (second, y)


def allowed_rows(scenario: Scenario, table: Mapping[str, Floats]) -> tuple[NDArray[np.bool_], str]:
    """The rows that may be simulated, and the rule that most of the others break."""
    broken = broken_rules(scenario, table)
    allowed = np.ones(next(iter(table.values())).size, dtype=np.bool_)
    for mask in broken.values():
        allowed &= ~mask
    return allowed, max(broken, key=lambda rule: np.count_nonzero(broken[rule]), default="")


def concerned(scenario: Scenario, names: set[str]) -> Scenario:
    """The scenario without the occupants that no name is of, and who push on nothing: they change nobody's motion."""
    if isinstance(scenario, NetworkScenario):
        return scenario
    meant = {name.partition(".")[0] for name in names}
    kept = tuple(one for one in scenario.occupants if one.coupled or one.name in meant)
    return scenario.model_copy(update={"occupants": kept})


def _side(given: object) -> int:
    if isinstance(given, bool) or not isinstance(given, int) or not 2 <= given <= MOST_SIDE:
        raise InvalidInput(f"side: got {given!r}; need a whole number, 2 .. {MOST_SIDE}.")
    return given


def _path(message: Mapping[str, Any], axis: str, known: Mapping[str, tuple[float, float]]) -> str:
    path = str(message.get(axis))[:200]
    if path not in known:
        raise UnknownName.among("parameter", path, known)
    return path


def _column(message: Mapping[str, Any], axis: str, usual: tuple[float, float], side: int) -> Floats:
    """Evenly spaced values from one end to the other."""
    given = message.get(f"{axis}_ends") or usual
    try:
        low, high = (float(end) for end in given)
    except (TypeError, ValueError):
        raise InvalidInput(f"{axis}_ends: got {given!r}; need two numbers. Give the ends of the axis.") from None
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise InvalidInput(f"{axis}_ends: got {low:g} and {high:g}; need the lower end first.")
    return np.linspace(low, high, side)
