"""Vehicles that the paper's may have been: what is free in them, and the ten numbers that each would give."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ridedown.paper.cases import Case, G
from ridedown.paper.numbers import ACCELERATION, PRINTED
from ridedown.scenario import CrashScenario, load, substitute
from ridedown.simulation import simulate_many

Floats = NDArray[np.float64]

_OFFSET = "bar.lateral_offset"
_CRUSH = tuple(f"{vehicle}.{side}.deflection.max" for vehicle in ("vehicle1", "vehicle2") for side in ("right", "left"))
_TURN = "bar.rotation.peak"


@dataclass(frozen=True, slots=True)
class Unknown:
    """Something that the paper does not print: its SI unit, its bounds, and the fields of a scenario that it sets."""

    name: str
    unit: str
    lower: float
    upper: float
    paths: tuple[str, ...]
    by_ratio: bool = False
    """Whether it is searched by its logarithm."""


# Eight unknowns for ten numbers, within the bounds of what a car may be. Everything else is as in the catalogue: what is
# printed, what the numbers cannot tell, and what a wider search left at its bound (docs/decisions/paper-vehicle.md).
_MEMBERS_1, _MEMBERS_2 = "vehicle1.members", "vehicle2.members"
_FIRST = (f"{_MEMBERS_1}.pieces.0.stiffness", f"{_MEMBERS_2}.pieces.0.stiffness")
UNKNOWNS = (
    Unknown("vehicle 1, initial force", "N", 0.0, 40e3, (f"{_MEMBERS_1}.initial_force",)),
    Unknown("vehicle 1, knee", "m", 0.1, 0.9, (f"{_MEMBERS_1}.pieces.0.until",)),
    Unknown("vehicle 1, second stiffness", "N/m", 200e3, 3e6, (f"{_MEMBERS_1}.pieces.1.stiffness",), by_ratio=True),
    Unknown("vehicle 2, knee", "m", 0.1, 0.9, (f"{_MEMBERS_2}.pieces.0.until",)),
    Unknown("vehicle 2, second stiffness", "N/m", 200e3, 3e6, (f"{_MEMBERS_2}.pieces.1.stiffness",), by_ratio=True),
    Unknown("vehicle 2, mass", "kg", 1000.0, 2200.0, ("vehicle2.mass",)),
    Unknown("both vehicles, first stiffness", "N/m", 30e3, 300e3, _FIRST, by_ratio=True),
    Unknown("lateral offset", "m", 0.2, 1.08, (_OFFSET,)),
)


@dataclass(frozen=True, slots=True)
class Crashes:
    """What candidates come to: the ten numbers in the paper's units, shape (R, 10), in the order of `PRINTED`.

    NaN where a crash could not be solved. crush: the largest deflection of any member in either collision [m], shape (R,);
    turn: the bar's largest rotation [rad], shape (R,).
    """

    numbers: Floats
    crush: Floats
    turn: Floats


def values_of(points: Floats) -> Floats:
    """Points of the unit cube, shape (..., n), as values of the unknowns, SI."""
    lower, upper = (np.array([getattr(u, side) for u in UNKNOWNS]) for side in ("lower", "upper"))
    by_ratio = np.array([u.by_ratio for u in UNKNOWNS])
    values: Floats = np.where(
        by_ratio, lower * (upper / np.where(by_ratio, lower, 1.0)) ** points, lower + (upper - lower) * points
    )
    return values


def crash(values: Floats, *, threads: int = 2) -> Crashes:
    """Crash every candidate, shape (R, n), head-on in full and in offset: two simulations a candidate, on up to two threads."""
    table = {path: column for unknown, column in zip(UNKNOWNS, values.T, strict=True) for path in unknown.paths}

    def simulated(collision: _Collision) -> Mapping[str, Floats]:
        fields = {path: column for path, column in table.items() if collision.is_offset or path != _OFFSET}
        many = simulate_many(collision.scenario, fields, outcomes=collision.outcomes, threads=1)
        return {name: np.where(many.completed, np.abs(column), np.nan) for name, column in many.items()}

    with ThreadPoolExecutor(min(threads, 2)) as pool:
        done = list(pool.map(simulated, _collisions()))
    numbers = np.empty((len(values), len(PRINTED)))
    for collision, outcomes in zip(_collisions(), done, strict=True):
        for row, outcome in collision.numbers.items():
            numbers[:, row] = outcomes[outcome] / (G if PRINTED[row].quantity == ACCELERATION else 1.0)
    crush = np.max([outcomes[name] for outcomes in done for name in _CRUSH], axis=0)
    return Crashes(numbers, crush, np.max([outcomes[_TURN] for outcomes in done], axis=0))


def scenario_of(case: Case) -> CrashScenario:
    """The catalogue's scenario of one of the paper's cases."""
    scenario = load(case.scenario)
    assert isinstance(scenario, CrashScenario)
    return scenario


def with_vehicle(scenario: CrashScenario, values: Floats) -> CrashScenario:
    """One of the paper's scenarios with a candidate's vehicles and bar, shape (n,), in place of the catalogue's."""
    table = {path: float(v) for unknown, v in zip(UNKNOWNS, values, strict=True) for path in unknown.paths}
    if not _is_offset(scenario):
        del table[_OFFSET]
    return substitute(scenario, table)


@dataclass(frozen=True, slots=True)
class _Collision:
    """The full or the offset collision with the occupants of all its cases, who do not push back on their vehicle."""

    scenario: CrashScenario
    numbers: Mapping[int, str]
    """Outcomes by the index in `PRINTED` of the number that they are for."""

    @property
    def is_offset(self) -> bool:
        return _is_offset(self.scenario)

    @property
    def outcomes(self) -> tuple[str, ...]:
        return (*self.numbers.values(), *_CRUSH, _TURN)


@cache
def _collisions() -> tuple[_Collision, _Collision]:
    rows = range(len(PRINTED))
    offset = [row for row in rows if _is_offset(scenario_of(PRINTED[row].case))]
    return _collision([row for row in rows if row not in offset]), _collision(offset)


def _collision(rows: Sequence[int]) -> _Collision:
    scenarios = {PRINTED[row].case: scenario_of(PRINTED[row].case) for row in rows}
    names = {case: f"occupant{i}" for i, case in enumerate(scenarios, 1)}
    occupants = [s.occupants[0].model_copy(update={"name": names[case]}) for case, s in scenarios.items()]
    crash_of_all = next(iter(scenarios.values())).model_copy(update={"occupants": tuple(occupants)})
    outcomes = {row: f"{names[PRINTED[row].case]}.{PRINTED[row].channel.split('.')[1]}.peak" for row in rows}
    return _Collision(crash_of_all, outcomes)


def _is_offset(scenario: CrashScenario) -> bool:
    return scenario.bar is not None and scenario.bar.lateral_offset != 0.0
