"""A study made ready to run: its rows, each a function of its number alone, and what is computed of each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput
from ridedown.studies.crashes import Evaluator, Rows
from ridedown.studies.parameters import Varied, resolve
from ridedown.studies.study import LoadedStudy

Floats = NDArray[np.float64]

CHUNK = 16_384
"""Rows solved, written and forgotten together."""

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


def plan_of(loaded: LoadedStudy) -> Plan:
    """The plan of a study that goes through rows fixed beforehand.

    Raises: InvalidInput, UnknownName for what does not fit the scenarios.
    """
    study = loaded.study
    if study.kind != "sweep":
        raise InvalidInput(f'kind: got "{study.kind}"; need "sweep". The others are not run by this command.')
    parameters = resolve(study.parameters, loaded.scenarios)
    function = Evaluator.of(loaded.scenarios, parameters, study.outcomes, weights=loaded.weights, step=study.step)
    design = FullGrid(parameters)
    if design.rows > MOST_ROWS:
        raise InvalidInput(f"parameters: got a grid of {design.rows:.3g} rows; need at most {MOST_ROWS:g}. Take fewer values.")
    chunk_rows = CHUNK if design.rows <= MANY_ROWS else LARGE_CHUNK
    return Plan(loaded.hash, {one.name: one.unit for one in parameters}, design, function, chunk_rows)
