"""Free parameters: points of a unit cube as values, and values as fields of scenarios."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ridedown import units
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import Scenario, parameters
from ridedown.scenario.quantities import Refused, read
from ridedown.studies.calibration.file import FreeParameter

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Unknown:
    """A free parameter, SI: its bounds, and where it is searched by ratio. prior: value and standard deviation, if any."""

    name: str
    unit: str
    lower: float
    upper: float
    by_ratio: bool = False
    prior: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Setting:
    """A field of one case's scenario and the unknowns, by index, that set or multiply it."""

    path: str
    base: float | None
    """What factors multiply where nothing sets the field."""
    sets: int | None
    factors: tuple[int, ...]


def values_of(unknowns: Sequence[Unknown], points: Floats) -> Floats:
    """Points of the unit cube, (..., n), as values, SI.

    >>> values_of([Unknown("k", "N/m", 1e3, 1e5, by_ratio=True), Unknown("d", "m", 0.0, 0.2)], np.array([0.5, 0.5])).round(3)
    array([1.e+04, 1.e-01])
    """
    lower = np.array([unknown.lower for unknown in unknowns])
    upper = np.array([unknown.upper for unknown in unknowns])
    by_ratio = np.array([unknown.by_ratio for unknown in unknowns])
    ratio = np.where(by_ratio, upper / np.where(by_ratio, lower, 1.0), 1.0)
    values: Floats = np.where(by_ratio, lower * ratio**points, lower + (upper - lower) * points)
    return values


def points_of(unknowns: Sequence[Unknown], values: Floats) -> Floats:
    """Values, (..., n), as points of the unit cube: the inverse of `values_of`."""
    columns = []
    for i, unknown in enumerate(unknowns):
        x = values[..., i]
        if unknown.by_ratio:
            columns.append(np.log(x / unknown.lower) / np.log(unknown.upper / unknown.lower))
        else:
            columns.append((x - unknown.lower) / (unknown.upper - unknown.lower))
    points: Floats = np.stack(columns, axis=-1)
    return points


def table_of(settings: Sequence[Setting], values: Floats) -> dict[str, Floats]:
    """The fields of one case by path, each a column (R,), for values (R, n)."""
    table = {}
    for setting in settings:
        column = np.full(len(values), setting.base) if setting.sets is None else values[:, setting.sets].copy()
        for factor in setting.factors:
            column *= values[:, factor]
        table[setting.path] = column
    return table


def resolve(
    free: Sequence[FreeParameter], scenarios: Mapping[str, Scenario], fitted: Sequence[str]
) -> tuple[tuple[Unknown, ...], dict[str, tuple[Setting, ...]]]:
    """The unknowns, and the settings of each case and prediction by its name.

    scenarios: of all cases and predictions; fitted: the names of the cases. Raises: InvalidInput, UnknownName.
    """
    known = {case: {p.path: (p.value, p.unit) for p in parameters(scenario)} for case, scenario in scenarios.items()}
    unknowns: list[Unknown] = []
    sets: dict[str, dict[str, int]] = {case: {} for case in scenarios}
    factors: dict[str, dict[str, list[int]]] = {case: {} for case in scenarios}
    for p, parameter in enumerate(free):
        where = f"parameters.{p}"
        places = list(_places(parameter, known, fitted, where))
        unit = _one_unit([known[case][path][1] for case, path in places], parameter, where)
        # one unknown for all, or one for each case
        owners = list(dict.fromkeys(case for case, _ in places)) if parameter.each else [""]
        for owner in owners:
            name = f"{parameter.name} ({owner})" if owner else parameter.name
            unknowns.append(_unknown(parameter, name, unit, where))
            for case, path in places:
                if owner not in {"", case}:
                    continue
                if parameter.factor:
                    factors[case].setdefault(path, []).append(len(unknowns) - 1)
                elif path in sets[case]:
                    raise InvalidInput(f"{where}.paths: got {path!r} of {case!r}, set before; need one parameter for a field.")
                else:
                    sets[case][path] = len(unknowns) - 1
    settings = {}
    for case in scenarios:
        paths = dict.fromkeys([*sets[case], *factors[case]])
        settings[case] = tuple(
            Setting(path, float(known[case][path][0]), sets[case].get(path), tuple(factors[case].get(path, ())))
            for path in paths
        )
    return tuple(unknowns), settings


def _places(
    parameter: FreeParameter, known: Mapping[str, Mapping[str, object]], fitted: Sequence[str], where: str
) -> Iterator[tuple[str, str]]:
    """Case and path of every field that a parameter sets."""
    for s, one in enumerate(parameter.sets):
        cases = one.cases or (tuple(fitted) if parameter.each else tuple(known))
        for case in cases:
            if case not in known:
                raise UnknownName.among(f"{where}.cases", case, known)
            for pattern in one.paths:
                paths = [path for path in known[case] if _matches(pattern, path)]
                if not paths:
                    unknown = UnknownName.among("path", pattern, known[case])
                    raise UnknownName(f"parameters.{s}.paths, of {case!r}: {unknown} Or name other cases in `cases`.")
                yield from ((case, path) for path in paths)


def _matches(pattern: str, path: str) -> bool:
    wanted, parts = pattern.split("."), path.split(".")
    return len(wanted) == len(parts) and all(w in {"*", part} for w, part in zip(wanted, parts, strict=True))


def _one_unit(found: Sequence[str], parameter: FreeParameter, where: str) -> str:
    if parameter.factor:
        return ""
    if len(set(found)) > 1:
        raise InvalidInput(f"{where}.paths: got fields in {' and '.join(sorted(set(found)))}; need fields of one unit.")
    return found[0]


def _unknown(parameter: FreeParameter, name: str, unit: str, where: str) -> Unknown:
    lower, upper = (number(value, unit, f"{where}.bounds.{i}") for i, value in enumerate(parameter.bounds))
    if not lower < upper:
        raise InvalidInput(f"{where}.bounds: got {lower:g} to {upper:g} {unit}; need the least value first. Swap them.")
    by_ratio = parameter.scale == "log"
    if by_ratio and lower <= 0.0:
        raise InvalidInput(f"{where}.bounds.0: got {lower:g} {unit}; need > 0 on a log scale. Raise it, or use a linear scale.")
    prior = None
    if parameter.prior is not None:
        prior = (
            number(parameter.prior.value, unit, f"{where}.prior.value"),
            number(parameter.prior.sigma, unit, f"{where}.prior.sigma"),
        )
        if prior[1] <= 0.0:
            raise InvalidInput(f"{where}.prior.sigma: got {prior[1]:g} {unit}; need > 0.")
    return Unknown(name, unit, lower, upper, by_ratio, prior)


def number(value: float | str, unit: str, where: str) -> float:
    """A number as a file writes it, in SI; text must be of the unit's dimension. Raises: InvalidInput."""
    try:
        return read(value, units.dimension(unit))
    except Refused as refused:
        raise InvalidInput(f"{where}: {refused}") from None
