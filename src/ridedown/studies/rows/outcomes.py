"""Outcomes of a study: what `simulate_many` keeps, and criteria of occupants and vehicles besides.

<body>.clip_3ms, .clip_3ms_cumulative       level held for 3 ms, on end or in all [m/s2]
<body>.hic15, .hic36, .severity_index       of the body's own acceleration
<vehicle>.olc, .vpi                         occupant load criterion, vehicle pulse index [m/s2]
<vehicle>.asi, .asi_1998, .thiv, .phd       roadside criteria: no unit, no unit, m/s, m/s2
<vehicle>.occupant_impact_velocity, .ridedown_acceleration   of the flail space [m/s], [m/s2]
<vehicle>.delta_v                           magnitude of its change of velocity, exact [m/s]
<vehicle>.dynamic_crush                     largest deflection of either member, exact [m]

A body is whatever has an acceleration: `adult`, `driver.chest`, `vehicle1`; a vehicle one that hangs on no other. Criteria
are computed by `ridedown.criteria` from the acceleration sampled every `step` (0.1 ms) and taken as straight in between: of a
smooth pulse that loses less than 1e-4; a jump in the acceleration is smeared over one step. The head of a lumped occupant is
its whole mass: its HIC is an indicator. NaN where a criterion has no value: an OLC whose occupant is never stopped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ridedown.criteria import many
from ridedown.criteria.many import Many
from ridedown.errors import InvalidInput, UnknownName
from ridedown.network import Network, channels
from ridedown.outcomes import Outcomes, known_outcomes, wanted
from ridedown.scenario import Scenario, lower, substitute, total_forces
from ridedown.simulation import simulate_many

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SAMPLED_AT_ONCE = 1024
"""Crashes whose channels are held sampled at one time: at 0.1 ms, 16 MB a channel."""

Measure = Callable[[Many], Floats]
"""A criterion of many crashes: a body's accelerations sampled to its values in SI, (R,), NaN where it has none."""


@dataclass(frozen=True, slots=True)
class Criterion:
    """A criterion of a body's sampled acceleration; `of_vehicle`: asked of vehicles only."""

    unit: str
    measure: Measure
    of_vehicle: bool = False


CRITERIA: Mapping[str, Criterion] = {
    "clip_3ms": Criterion("m/s2", many.clip),
    "clip_3ms_cumulative": Criterion("m/s2", partial(many.clip, cumulative=True)),
    "hic15": Criterion("", partial(many.hic, max_window=0.015)),
    "hic36": Criterion("", partial(many.hic, max_window=0.036)),
    "severity_index": Criterion("", many.severity_index),
    "olc": Criterion("m/s2", many.olc, of_vehicle=True),
    "vpi": Criterion("m/s2", many.vpi, of_vehicle=True),
    "asi": Criterion("", many.asi, of_vehicle=True),
    "asi_1998": Criterion("", many.asi_1998, of_vehicle=True),
    "thiv": Criterion("m/s", many.thiv, of_vehicle=True),
    "phd": Criterion("m/s2", many.phd, of_vehicle=True),
    "occupant_impact_velocity": Criterion("m/s", many.occupant_impact_velocity, of_vehicle=True),
    "ridedown_acceleration": Criterion("m/s2", many.phd, of_vehicle=True),  # along x the same
}

_EXACT = {"delta_v": "m/s", "dynamic_crush": "m"}


@dataclass(frozen=True, slots=True)
class Wanted:
    """The outcomes wanted of one scenario: their units by name, and what each is computed from.

    solved: outcomes that the solver keeps. sampled: criteria by name, each the channel and the criterion.
    crushes: `<vehicle>.dynamic_crush` to the deflections of its members. changes: `<vehicle>.delta_v` to the vehicle.
    """

    units: Mapping[str, str]
    solved: tuple[str, ...]
    sampled: Mapping[str, tuple[str, Criterion]]
    crushes: Mapping[str, tuple[str, ...]]
    changes: Mapping[str, str]


def known_criteria(network: Network) -> dict[str, str]:
    """Every criterion of a network's bodies, with its unit."""
    every = channels(network)
    found: dict[str, str] = {}
    for i, body in enumerate(network.coordinates):
        if f"{body}.acceleration" not in every or body == "bar":  # which is neither ridden nor ridden in
            continue
        vehicle = bool(network.parent[i] < 0)
        found |= {f"{body}.{key}": one.unit for key, one in CRITERIA.items() if vehicle or not one.of_vehicle}
        if vehicle:
            found[f"{body}.delta_v"] = _EXACT["delta_v"]
            if _members(network, body):
                found[f"{body}.dynamic_crush"] = _EXACT["dynamic_crush"]
    return found


def _members(network: Network, vehicle: str) -> tuple[str, ...]:
    sides = (f"{vehicle}.right", f"{vehicle}.left")
    return tuple(side for side in sides if side in network.elements)


def wanted_of(scenario: Scenario, names: Sequence[str] | None) -> Wanted:
    """What is to be computed for outcomes of these names; for the usual ones of `simulate_many` if None.

    >>> from ridedown import load
    >>> wanted_of(load("p1"), ["adult.clip_3ms", "vehicle1.delta_v", "energy.final"]).units
    {'adult.clip_3ms': 'm/s2', 'vehicle1.delta_v': 'm/s', 'energy.final': 'J'}

    Raises: UnknownName, with the nearest.
    """
    network = lower(scenario)
    own = known_criteria(network)
    further = total_forces(getattr(scenario, "occupants", ()), network)
    known = known_outcomes(network, further) | own
    for name in names or ():
        if name not in known:
            raise UnknownName.among("outcome", name, known)
    plan = wanted(network, None if names is None else [name for name in names if name not in own], further=further)
    chosen = [name for name in names or () if name in own]
    split = {name: name.rsplit(".", 1) for name in chosen}
    every = list(plan.names) if names is None else list(names)
    return Wanted(
        units={name: known[name] for name in every},
        solved=plan.names,
        sampled={name: (f"{body}.acceleration", CRITERIA[key]) for name, (body, key) in split.items() if key in CRITERIA},
        crushes={name: _members(network, body) for name, (body, key) in split.items() if key == "dynamic_crush"},
        changes={name: body for name, (body, key) in split.items() if key == "delta_v"},
    )


def compute(scenario: Scenario, table: Mapping[str, Floats], want: Wanted, *, step: float) -> tuple[dict[str, Floats], Ints]:
    """Outcomes of R crashes by name, (R,) each, and each crash's `Status`; on the calling thread.

    Raises: InvalidInput for a row that breaks a rule (see `scenario.broken_rules`), or criteria of crashes whose durations
    differ.
    """
    deflections = dict.fromkeys(f"{member}.deflection.max" for members in want.crushes.values() for member in members)
    finals = dict.fromkeys(f"{body}.velocity.final" for body in want.changes.values())
    solved = list(dict.fromkeys([*want.solved, *deflections, *finals]))
    sampled = list(dict.fromkeys(channel for channel, _ in want.sampled.values()))
    rows = max((column.size for column in table.values()), default=1)
    at_once = SAMPLED_AT_ONCE if sampled else rows
    found: dict[str, Floats] = {name: np.empty(rows) for name in want.units}
    status = np.empty(rows, dtype=np.int64)
    times = _times(scenario, table, step) if sampled else None
    for start in range(0, rows, at_once):
        part = slice(start, min(start + at_once, rows))
        chunk = {path: column[part] for path, column in table.items()}
        outcomes = simulate_many(scenario, chunk, outcomes=solved, samples=sampled, times=times, threads=1)
        for name in want.solved:
            found[name][part] = outcomes[name]
        for name, members in want.crushes.items():
            found[name][part] = np.max([outcomes[f"{member}.deflection.max"] for member in members], axis=0)
        if want.changes:
            network = lower(substitute(scenario, chunk))
            for name, body in want.changes.items():
                found[name][part] = np.abs(outcomes[f"{body}.velocity.final"] - network.rate[network.coordinate(body)])
        _measure(want, outcomes, times, found, part)
        status[part] = outcomes.status
    return found, status


def _measure(want: Wanted, outcomes: Outcomes, times: Floats | None, found: dict[str, Floats], part: slice) -> None:
    """Put in the criteria of the crashes that were solved to their end."""
    if times is None:
        return
    whole = outcomes.completed
    sampled = {channel: Many(times, _apart(values, whole)) for channel, values in outcomes.samples.items()}
    for name, (channel, criterion) in want.sampled.items():
        column = np.full(whole.size, math.nan)
        if whole.any():
            column[whole] = criterion.measure(sampled[channel])
        found[name][part] = column


def _apart(values: Floats, rows: NDArray[np.bool_]) -> Floats:
    """Those rows of a table; one for all, where one row stands for all of it."""
    if values.strides[0] == 0:
        return values[:1].copy()
    return values if rows.all() else values[rows]


def _times(scenario: Scenario, table: Mapping[str, Floats], step: float) -> Floats:
    """When to sample [s]: from 0 to the end, `step` apart at most."""
    ends = table.get("duration", lower(scenario).duration)
    if np.ptp(ends) > 0.0:
        raise InvalidInput("outcomes: got criteria of crashes that differ in duration; need one duration. Do not vary it.")
    end = float(ends[0])
    return np.linspace(0.0, end, max(2, math.ceil(end / step - 1e-9) + 1))
