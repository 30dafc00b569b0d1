"""What varies in a study: a number of the scenario, or several that move together; over values, or as it is distributed."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import Scenario, quantities
from ridedown.scenario.base import Check, Model
from ridedown.scenario.quantities import Quantity, Refused
from ridedown.studies.distributions import AnyDistribution, Discrete, Distribution, Uniform

Floats = NDArray[np.float64]

Raw = float | str
"""A bare number in SI, or text with a unit: which units it may have is known once its path is."""

WAYS = ("values", "grid", "range", "distribution")
"""The ways to say how a parameter varies."""


class Grid(Model):
    """Evenly spaced values from `start` to `stop`, both included; by equal factors where the spacing is "log"."""

    start: Raw = Field(description="first value, bare SI or with a unit")
    stop: Raw = Field(description="last value")
    count: int = Field(strict=True, description="how many values")
    spacing: Literal["linear", "log"] = "linear"

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("count", self.count >= 2, f"{self.count}", "2 or more values", 'For a single one write "values".')


class StudyParameter(Model):
    """One thing that varies.

    path: of a number as `ridedown.scenario.parameters` has it, in every scenario of the study that has such a number; with a
    scenario's name before it, in that one alone. paths: several that take the same value. name: how results call it; the path
    if left out.
    """

    name: str = Field("", description="how results call it")
    path: str | None = Field(None, description="which number of the scenario varies")
    paths: tuple[str, ...] | None = Field(None, description="several numbers that take the same value")
    values: tuple[Raw, ...] | None = Field(None, description="the values, one by one")
    grid: Grid | None = Field(None, description="evenly spaced values")
    range: tuple[Raw, Raw] | None = Field(None, description="least and largest value, all between alike")
    distribution: AnyDistribution | None = Field(None, description="how it is distributed")

    def complete(self) -> None:
        """Name it after its path."""
        if not self.name and self.places:
            self._fill(name=self.places[0])

    @property
    def places(self) -> tuple[str, ...]:
        """All its paths."""
        return self.paths or ((self.path,) if self.path is not None else ())

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        both = self.path is not None and self.paths is not None
        yield Check("path", not both, "both path and paths", "one of them", "Put all into paths.")
        yield Check("path", bool(self.places), "nothing", "the path of a number, such as adult.restraint.stiffness")
        given = [way for way in WAYS if getattr(self, way) is not None]
        words = ", ".join(WAYS)
        yield Check("values", len(given) == 1, " and ".join(given) or "nothing", f"one of {words}", "Say how it varies once.")
        yield Check("values", self.values is None or bool(self.values), "an empty list", "one value or more")
        reserved = self.name.lower() not in {"row", "status", "why"}
        yield Check("name", reserved, f'"{self.name}"', "a name that results have no column of", "Rename it.")


@dataclass(frozen=True, eq=False)
class Varied:
    """A parameter read against its scenarios: SI, and where it goes in each.

    targets: scenario's name to the paths there. levels: the values listed, (n,), or None. distribution: of the values; those
    listed are all as likely.
    """

    name: str
    unit: str
    targets: Mapping[str, tuple[str, ...]]
    levels: Floats | None
    distribution: Distribution


def resolve(
    given: tuple[StudyParameter, ...], scenarios: Mapping[str, Scenario], *, where: Sequence[str] = ()
) -> tuple[Varied, ...]:
    """The parameters read against the scenarios, which are keyed by their names ("" for the only one).

    where: what messages call each of them, if not parameters.0 and so on.

    Raises: UnknownName for a path that no scenario has; InvalidInput for a value that its field may not hold, for two
    parameters of one name, or that both set one number.
    """
    known = {name: quantities(scenario) for name, scenario in scenarios.items()}
    called = where or [f"parameters.{i}" for i in range(len(given))]
    varied = tuple(_resolved(name, parameter, known) for name, parameter in zip(called, given, strict=True))
    for (first, one), (second, other) in itertools.combinations(zip(called, varied, strict=True), 2):
        if one.name.lower() == other.name.lower():  # SQL, which results are asked in, knows no case
            again = "a second time" if one.name == other.name else f'beside "{one.name}"'
            raise InvalidInput(f'{second}.name: got "{other.name}" {again}; need a name of its own. Rename it.')
        for scenario in scenarios:
            twice = set(one.targets.get(scenario, ())) & set(other.targets.get(scenario, ()))
            if twice:
                raise InvalidInput(f"{second}: got {min(twice)}, which {first} sets too; need each set once. Take one out.")
    return varied


def _resolved(where: str, parameter: StudyParameter, known: Mapping[str, Mapping[str, Quantity]]) -> Varied:
    targets: dict[str, list[str]] = {}
    found: list[Quantity] = []
    for path in parameter.places:
        hits = _places(path, known)
        if not hits:
            every = dict.fromkeys(path for paths in known.values() for path in paths)
            raise UnknownName(f"{where}.path: {UnknownName.among('parameter', path, every)}")
        for scenario, inner in hits:
            targets.setdefault(scenario, []).append(inner)
            found.append(known[scenario][inner])
    odd = next((quantity for quantity in found if quantity.dimension is not found[0].dimension), None)
    if odd is not None:
        raise InvalidInput(
            f"{where}.paths: got {found[0].dimension.called} and {odd.dimension.called}; need numbers of one kind. "
            "Make two parameters of them."
        )
    levels: Floats | None = None
    if parameter.values is not None:
        levels = np.array([_value(f"{where}.values.{i}", value, found) for i, value in enumerate(parameter.values)])
    elif parameter.grid is not None:
        levels = grid_levels(f"{where}.grid", parameter.grid, found)
    elif parameter.range is not None:
        low, high = (_value(f"{where}.range.{i}", value, found) for i, value in enumerate(parameter.range))
        if not low < high:
            raise InvalidInput(f"{where}.range: got {low:g} and {high:g}; need the least value, then a larger one. Turn them.")
        distribution: Distribution = Uniform(lower=low, upper=high)
    elif parameter.distribution is not None:
        distribution = parameter.distribution
        for quantity in found:
            distribution.check_against(quantity, f"{where}.distribution")
    if levels is not None:
        distribution = Discrete(values=tuple(float(level) for level in np.unique(levels)))
    own = {scenario: tuple(dict.fromkeys(paths)) for scenario, paths in targets.items()}
    return Varied(parameter.name, found[0].unit, own, levels, distribution)


def _places(path: str, known: Mapping[str, Mapping[str, Quantity]]) -> list[tuple[str, str]]:
    """Scenarios and paths that a path in a study means: in the scenario it names, else in all that have it."""
    name, _, inner = path.partition(".")
    if name in known and inner in known[name]:
        return [(name, inner)]
    return [(scenario, path) for scenario, paths in known.items() if path in paths]


def _value(where: str, given: Any, allowed: list[Quantity]) -> float:
    """A value in SI that every one of the fields may hold."""
    try:
        values = [quantity.read(given) for quantity in allowed]
    except Refused as refused:
        raise InvalidInput(f"{where}: {refused}") from None
    return values[0]


def grid_levels(where: str, grid: Grid, allowed: list[Quantity]) -> Floats:
    """The values of a grid in SI, (count,), each of which all these quantities may hold. Raises: InvalidInput."""
    start, stop = _value(f"{where}.start", grid.start, allowed), _value(f"{where}.stop", grid.stop, allowed)
    if start == stop:
        raise InvalidInput(f"{where}.stop: got {stop:g}, as start; need another value. For a single one write values.")
    if grid.spacing == "linear":
        return np.linspace(start, stop, grid.count)
    if not (start > 0.0 and stop > 0.0):
        raise InvalidInput(f'{where}.start: got {min(start, stop):g}; need > 0 for spacing = "log". Start above zero.')
    levels = np.exp(np.linspace(math.log(start), math.log(stop), grid.count))
    levels[[0, -1]] = start, stop
    return levels
