"""A study made ready to run: its rows, each a function of its number alone, and what is computed of each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Design as Points
from ridedown.studies.analysis.designs import Sobol, Variables, check_correlation
from ridedown.studies.analysis.reliability import plan_of as points_of
from ridedown.studies.file.parameters import StudyParameter, Varied, resolve
from ridedown.studies.file.study import LoadedStudy, Study
from ridedown.studies.rows.bounding import EXCURSION, LeastPeaks
from ridedown.studies.rows.crashes import Evaluator, Rows
from ridedown.studies.rows.sensitivity_rows import asked_rows

Floats = NDArray[np.float64]

CHUNK = 16_384
"""Rows solved, written and forgotten together."""

ASKED_CHUNK = 1024
"""Rows that a search has to come to before they are written: what it costs to end it."""

LARGE_CHUNK, MANY_ROWS = 65_536, 10**8
"""The same of studies with more rows than that, whose files would be too many."""

MOST_ROWS = 10**12


class Design(Protocol):
    """Which values the rows take: `rows` of them in all."""

    @property
    def rows(self) -> int:
        """How many."""
        ...

    def columns(self, start: int, stop: int) -> dict[str, Floats]:
        """The parameters of the rows from `start` up to `stop`, by name, (stop - start,) each; whatever else was asked for."""
        ...


class Function(Protocol):
    """What is computed of rows: an `Evaluator`, or anything else with outcomes and units."""

    @property
    def units(self) -> dict[str, str]:
        """Every outcome with its SI unit."""
        ...

    def rows(self, columns: Mapping[str, Floats]) -> Rows:
        """Outcomes of columns of parameters."""
        ...


@dataclass(frozen=True, eq=False)
class FullGrid:
    """Every combination of the parameters' levels; the last parameter changes from row to row."""

    parameters: tuple[Varied, ...]

    @property
    def rows(self) -> int:
        """How many combinations."""
        return math.prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many levels each parameter has."""
        return tuple(one.levels.size for one in self.parameters if one.levels is not None)

    def columns(self, start: int, stop: int) -> dict[str, Floats]:
        """The parameters of the rows from `start` up to `stop`."""
        places = np.unravel_index(np.arange(start, stop), self.shape)
        return {
            one.name: one.levels[place] for one, place in zip(self.parameters, places, strict=True) if one.levels is not None
        }


@dataclass(frozen=True, eq=False)
class Drawn:
    """Rows drawn from the parameters' distributions. groups: of how many independent parts of equal size they are made."""

    variables: Variables
    points: Points
    rows: int
    groups: int

    def columns(self, start: int, stop: int) -> dict[str, Floats]:
        """The parameters of the rows from `start` up to `stop`."""
        return self.variables.columns(self.points.rows(start, stop))


@dataclass(frozen=True, eq=False)
class Listed:
    """Rows written out: columns by name, (R,) each, the first of them the row of number `first`."""

    listed: Mapping[str, Floats]
    first: int = 0

    @property
    def rows(self) -> int:
        """How many."""
        return self.first + next(iter(self.listed.values())).size

    def columns(self, start: int, stop: int) -> dict[str, Floats]:
        """The parameters of the rows from `start` up to `stop`."""
        return {name: column[start - self.first : stop - self.first] for name, column in self.listed.items()}


@dataclass(frozen=True, eq=False)
class Asked:
    """Rows that a search asks for as it goes; how many is known at its end. rows: about so many, at most.

    variables: what may be asked for. `columns` are of rows spread over it, for trials.
    """

    variables: Variables
    rows: int

    def columns(self, start: int, stop: int) -> dict[str, Floats]:
        """The parameters of trial rows from `start` up to `stop`."""
        return self.variables.columns(Sobol(len(self.variables.names), 0).rows(start, stop))


@dataclass(frozen=True, eq=False)
class Plan:
    """All that is needed to compute any chunk of a study. Data only, so that it can be sent to other machines."""

    hash: str
    units: Mapping[str, str]
    """Of the parameters, by name."""
    design: Design
    function: Function
    chunk_rows: int = CHUNK

    @property
    def rows(self) -> int:
        """How many rows the study has."""
        return self.design.rows

    @property
    def chunks(self) -> int:
        """How many chunks it is computed in."""
        return -(-self.rows // self.chunk_rows)

    def span(self, chunk: int) -> tuple[int, int]:
        """First row of a chunk, and the one after its last."""
        start = chunk * self.chunk_rows
        return start, min(start + self.chunk_rows, self.rows)

    def part(self, chunk: int) -> Plan:
        """The plan with no more than a chunk needs, to be sent elsewhere."""
        if not isinstance(self.design, Listed):
            return self
        start, stop = self.span(chunk)
        return replace(self, design=Listed(self.design.columns(start, stop), start))


def plan_of(loaded: LoadedStudy) -> Plan:
    """The plan of a study that goes through rows fixed beforehand.

    Raises: InvalidInput, UnknownName for what does not fit the scenarios.
    """
    study = loaded.study
    if study.bound is not None:
        least = LeastPeaks.of(loaded.scenarios[""], study.bound)
        return Plan(loaded.hash, {EXCURSION: "m"}, Listed({EXCURSION: least.excursions}), least)
    parameters = parameters_of(loaded)
    function = Evaluator.of(
        loaded.scenarios,
        parameters,
        asked_outcomes(study),
        usual=not study.outcomes and study.kind not in {"optimise", "box"},
        weights=loaded.weights,
        step=study.step,
    )
    _check_names(parameters, function.units)
    if (most := _most_asked(study)) is not None:
        asked = Asked(variables_of(study, parameters), most)
        return Plan(loaded.hash, {one.name: one.unit for one in parameters}, asked, function, ASKED_CHUNK)
    design = _design(study, parameters)
    if design.rows > MOST_ROWS:
        raise InvalidInput(f"parameters: got {design.rows:.3g} rows; need at most {MOST_ROWS:g}. Take fewer values.")
    chunk_rows = CHUNK if design.rows <= MANY_ROWS else LARGE_CHUNK
    return Plan(loaded.hash, {one.name: one.unit for one in parameters}, design, function, chunk_rows)


def _check_names(parameters: tuple[Varied, ...], outcomes: Mapping[str, str]) -> None:
    """Refuse a parameter that an outcome's column would take the place of. Case is none of SQL's concern."""
    columns = {name.lower() for name in outcomes}
    for i, one in enumerate(parameters):
        if one.name.lower() in columns:
            raise InvalidInput(
                f'parameters.{i}.name: got "{one.name}", the name of an outcome; need one of its own. Rename it.'
            )


def parameters_of(loaded: LoadedStudy) -> tuple[Varied, ...]:
    """The parameters of a study, then those that its population gives. Raises: InvalidInput, UnknownName."""
    study = loaded.study
    paths = list(study.population[0].values) if study.population else []
    further = tuple(StudyParameter(path=path, values=tuple(one.values[path] for one in study.population)) for path in paths)
    called = [f"parameters.{i}" for i in range(len(study.parameters))] + ["population"] * len(further)
    return resolve(study.parameters + further, loaded.scenarios, where=called)


def asked_outcomes(study: Study) -> dict[str, str]:
    """The outcomes that a study asks for by name, each with its place in the file: those sought, limited and listed."""
    named: list[tuple[str, str]] = []
    if study.optimise is not None:
        for table in ("objectives", "constraints"):
            each = getattr(study.optimise, table)
            named += [(one.outcome, f"optimise.{table}.{i}.outcome") for i, one in enumerate(each)]
    limited = [(limit.outcome, f"limits.{i}.outcome") for i, limit in enumerate(study.limits)]
    listed = [(outcome, f"outcomes.{i}") for i, outcome in enumerate(study.outcomes)]
    named += [*limited, *listed] if study.box is not None else [*listed, *limited]
    places: dict[str, str] = {}
    for name, place in named:
        places.setdefault(name, place)
    return places


def _most_asked(study: Study) -> int | None:
    """About how many rows a search asks for, at most; None for a study whose rows are fixed beforehand."""
    if study.optimise is not None:
        candidates, generations = study.optimise.designs
        drawn = any(parameter.distribution is not None for parameter in study.parameters)
        members = len(study.population) or (study.optimise.population_rows if drawn else 1)
        return candidates * (generations + 1) * members
    if study.box is not None:
        return study.box.rows * (2 * study.box.rounds + 50)
    if study.sample is not None and study.sample.rare:
        return len(study.limits) * (study.sample.rows + 10 * study.sample.level_rows)
    return None


def variables_of(study: Study, parameters: tuple[Varied, ...]) -> Variables:
    """The parameters' distributions and correlations. Raises: InvalidInput, UnknownName."""
    names, pairs = [one.name for one in parameters], dict[tuple[str, str], float]()
    for i, correlation in enumerate(study.correlations):
        given = {frozenset(pair) for pair in pairs}
        check_correlation(*correlation.between, correlation.rank, names, given, f"correlations.{i}")
        pairs[correlation.between] = correlation.rank
    return Variables({one.name: one.distribution for one in parameters}, pairs)


def _design(study: Study, parameters: tuple[Varied, ...]) -> Design:
    if study.kind == "sample":
        return _drawn(study, parameters)
    if study.sensitivity is not None:
        return Listed(asked_rows(study.sensitivity, variables_of(study, parameters)))
    return FullGrid(parameters)


def _drawn(study: Study, parameters: tuple[Varied, ...]) -> Drawn:
    given = study.sample
    assert given is not None
    variables = variables_of(study, parameters)
    points, rows, groups = points_of(given.design, len(parameters), given.rows, given.scramblings, given.seed)
    return Drawn(variables, points, rows, groups)
