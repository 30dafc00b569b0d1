"""The study file: which scenarios, what varies in them, which outcomes, and what kind of study it is."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from ridedown import catalogue
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import Scenario, load, lower
from ridedown.scenario.base import Check, Model, Name
from ridedown.scenario.quantities import Factor, SampleStep, Share
from ridedown.scenario.reading import SUFFIXES, anchored, table_in, text_of
from ridedown.studies.file.options import BoundOptions, BoxOptions, Member, OptimiseOptions
from ridedown.studies.file.parameters import StudyParameter

_NEED = "need a table of fields such as kind, scenario and [[parameters]]. docs/studies.md has examples."

Kind = Literal["sweep", "sample", "sensitivity", "bound", "optimise", "box"]


_TABLES = ("sample", "sensitivity", "bound", "optimise", "box")
"""Tables of options, each of the kind it is named after."""


class Case(Model):
    """One of several scenarios of a study: results put its name before its outcomes, as in `full.adult.acceleration.peak`."""

    name: Name = Field(description="how results call it")
    scenario: str | dict[str, Any] = Field(description="a catalogue name, a file, or a scenario written out")
    weight: Factor = 1.0
    """Its share in `weighted.<outcome>`, over the sum of all weights."""


class Correlation(Model):
    """The rank correlation (Spearman) of two parameters."""

    between: tuple[str, str] = Field(description="the names of two parameters")
    rank: float = Field(description="their rank correlation, between -1 and 1")


class SampleOptions(Model):
    """How a sample is drawn and judged.

    rows: in all; with a Sobol sequence rounded up to `scramblings` times a power of two. design: how the rows lie. confidence:
    of intervals. rare: rows are drawn where a limit is exceeded instead (importance sampling), after a search in levels of
    `level_rows`, by a mixture of so many `components`; `rows` for each limit.
    """

    rows: int = Field(16_384, strict=True, description="how many rows")
    design: Literal["sobol", "latin-hypercube", "random"] = "sobol"
    scramblings: int = Field(16, strict=True, description="independent parts of a Sobol sequence, by which it is judged")
    seed: int = Field(0, strict=True, description="a whole number from 0")
    confidence: Share = Field(0.95, description="of intervals")
    rare: bool = Field(default=False, strict=True, description="whether rows are drawn where a limit is exceeded")
    level_rows: int = Field(2000, strict=True, description="rows of each level of the search, of a rare event")
    components: int = Field(2, strict=True, description="at least as many as there are separate ways to exceed the limit")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        for field, least in (("rows", 100 if self.rare else 1), ("level_rows", 100), ("components", 1)):
            yield Check(field, getattr(self, field) >= least, f"{getattr(self, field)}", f"{least} or more")
        sobol = not self.rare or self.design == "sobol"
        yield Check("design", sobol, f'"{self.design}" of a rare event', "none", "Rows are drawn where the limit is exceeded.")
        yield Check("scramblings", self.scramblings >= 2, f"{self.scramblings}", "2 or more")
        yield Check("seed", self.seed >= 0, f"{self.seed}", "a whole number of 0 or more")
        yield Check("confidence", 0.0 < self.confidence < 1.0, f"{self.confidence}", "a number between 0 and 1")


class SensitivityOptions(Model):
    """How sensitivity is found: Sobol indices of `rows` blocks of d + 2 rows, or Morris screening of `rows` trajectories."""

    method: Literal["sobol", "morris"] = "sobol"
    rows: int = Field(1024, strict=True, description="blocks or trajectories, best a power of two")
    seed: int = Field(0, strict=True, description="a whole number from 0")
    confidence: Share = Field(0.95, description="of intervals")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("rows", self.rows >= 2, f"{self.rows}", "2 or more")
        yield Check("seed", self.seed >= 0, f"{self.seed}", "a whole number of 0 or more")
        yield Check("confidence", 0.0 < self.confidence < 1.0, f"{self.confidence}", "a number between 0 and 1")


class Limit(Model):
    """The most, or the least, that an outcome may come to. Of a `.peak` the magnitude counts, whichever way it points."""

    outcome: str = Field(description="name of an outcome")
    most: float | str | None = Field(None, description="largest value allowed, bare SI or with a unit")
    least: float | str | None = Field(None, description="smallest value allowed")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        given = self.most is not None or self.least is not None
        yield Check("most", given, "nothing", "the largest value allowed, or `least`")


class Study(Model):
    """A study, as its file has it. Scenarios are read where the study is read, by `load_study`.

    outcomes: names as `simulate_many` has them and criteria (see `ridedown.studies.rows.outcomes`), for every scenario that has
    them, or with a scenario's name before for that one; the usual ones if left out. step: between the samples that criteria
    are computed from.
    """

    kind: Kind = Field(description="what kind of study it is")
    name: str = ""
    description: str = ""
    scenario: str | dict[str, Any] | None = Field(None, description="a catalogue name, a file, or a scenario written out")
    scenarios: tuple[Case, ...] = Field((), description="several scenarios, each with a name")
    parameters: tuple[StudyParameter, ...] = Field((), description="what varies")
    outcomes: tuple[str, ...] = ()
    limits: tuple[Limit, ...] = ()
    correlations: tuple[Correlation, ...] = ()
    sample: SampleOptions | None = Field(None, description="how a sample is drawn")
    sensitivity: SensitivityOptions | None = Field(None, description="how sensitivity is found")
    population: tuple[Member, ...] = Field((), description="whom and what a design is for")
    optimise: OptimiseOptions | None = Field(None, description="what is sought")
    box: BoxOptions | None = Field(None, description="how a solution box is sought")
    bound: BoundOptions | None = Field(None, description="what limiting performance is asked for")
    step: SampleStep = Field(1e-4, description="time between the samples that criteria are computed from")

    def complete(self) -> None:
        """Fill in the options of its kind."""
        if self.kind == "sample" and self.sample is None:
            self._fill(sample=SampleOptions())
        if self.kind == "sensitivity" and self.sensitivity is None:
            self._fill(sensitivity=SensitivityOptions())
        if self.kind == "box" and self.box is None:
            self._fill(box=BoxOptions())

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        both = self.scenario is not None and bool(self.scenarios)
        yield Check("scenario", not both, "both scenario and scenarios", "one of them", "Put all into [[scenarios]].")
        given = self.scenario is not None or bool(self.scenarios)
        yield Check("scenario", given, "nothing", "a catalogue name, a file, or a table [scenario]")
        for kind in _TABLES:
            wanted = self.kind == kind or getattr(self, kind) is None
            yield Check(kind, wanted, f'a table [{kind}] with kind = "{self.kind}"', "none", "Take it out, or change the kind.")
        names = [case.name for case in self.scenarios]
        for i, name in enumerate(names):
            own = name not in names[:i] and name != "weighted"
            yield Check(f"scenarios.{i}.name", own, f'"{name}"', "a name of its own", "Rename it.")
        if self.kind == "bound":
            yield from self._bound_checks()
            return
        yield Check("parameters", bool(self.parameters), "none", "one table [[parameters]] or more", "Say what varies.")
        if self.kind == "sweep":
            for i, parameter in enumerate(self.parameters):
                listed = parameter.values is not None or parameter.grid is not None
                where = f"parameters.{i}.values"
                yield Check(
                    where, listed, "no list of values", "values or a grid in a sweep", 'For others use kind = "sample".'
                )
        drawn = self.kind in {"sample", "optimise"} or not self.correlations
        yield Check("correlations", drawn, f'correlations with kind = "{self.kind}"', "none", "Only samples have them.")
        none = self.kind == "optimise" or not self.population
        yield Check("population", none, f'a population with kind = "{self.kind}"', "none", "Only an optimisation has one.")
        if self.kind == "optimise":
            yield from self._optimise_checks()
        if self.kind == "box" or (self.sample is not None and self.sample.rare):
            what = "a box" if self.kind == "box" else "a rare event"
            yield Check("limits", bool(self.limits), "none", "one table [[limits]] or more", f"They are what {what} is about.")
        if self.kind == "box":
            for i, parameter in enumerate(self.parameters):
                ranged = parameter.range is not None
                yield Check(f"parameters.{i}.range", ranged, "nothing", "a range, within which the box is sought")
        once = len(set(self.outcomes)) == len(self.outcomes)
        yield Check("outcomes", once, "an outcome twice", "each once", "Take one out.")

    def _optimise_checks(self) -> Iterator[Check]:
        yield Check("optimise", self.optimise is not None, "nothing", "a table [optimise] with objectives")
        yield Check("limits", not self.limits, 'limits with kind = "optimise"', "none", "Put them into optimise.constraints.")
        ranged = [parameter.range is not None for parameter in self.parameters]
        yield Check("parameters", any(ranged), "none with a range", "one or more", "A range is what a design is sought in.")
        for i, parameter in enumerate(self.parameters):
            listed = parameter.values is not None or parameter.grid is not None
            need = "a range of what is sought, or a distribution of what differs from crash to crash"
            yield Check(f"parameters.{i}.range", not listed, "a list of values", need, "Put lists into [[population]].")
        keys = [set(member.values) for member in self.population]
        for i, own in enumerate(keys):
            yield Check(
                f"population.{i}.values", own == keys[0] and bool(own), ", ".join(sorted(own)) or "none", "the same in all"
            )
        own = {place for parameter in self.parameters for place in (parameter.name, *parameter.places)}
        both = sorted(own & set().union(*keys))
        once = ", ".join(both)
        yield Check("population.0.values", not both, f"{once}, which a parameter sets too", "each set once", "Take one out.")
        several = bool(self.population)
        yield Check("population", all(ranged) or not several, "a population and distributions", "one of them", "Take one out.")
        assert self.optimise is not None
        for field in ("objectives", "constraints"):
            for i, one in enumerate(getattr(self.optimise, field)):
                known = one.measure == "mean" or several or not all(ranged)
                where = f"optimise.{field}.{i}.measure"
                yield Check(
                    where, known, f'"{one.measure}" of one crash', "a population", "Give distributions, or [[population]]."
                )

    def _bound_checks(self) -> Iterator[Check]:
        yield Check("bound", self.bound is not None, "nothing", "a table [bound] with excursions", "docs/studies.md has one.")
        yield Check("scenarios", not self.scenarios, "several scenarios", "one scenario", "Make a study of each.")
        for field in ("parameters", "outcomes", "correlations"):
            none = not getattr(self, field)
            yield Check(field, none, f'{field} with kind = "bound"', "none", "Take them out: the excursion is what varies.")


@dataclass(frozen=True, eq=False)
class LoadedStudy:
    """A study with its scenarios read; `scenarios` by name, "" where there is only one. All that its results depend on.

    text: the file as it was read, to be kept with the results; empty for a study that was no file.
    """

    study: Study
    scenarios: Mapping[str, Scenario]
    weights: Mapping[str, float]
    text: str = ""

    @property
    def searches(self) -> bool:
        """Whether its rows follow from one another, so that their spread says nothing."""
        study = self.study
        return study.kind in {"optimise", "box"} or (study.sample is not None and study.sample.rare)

    @property
    def identity(self) -> dict[str, Any]:
        """Plain data that two studies share only if their results do."""
        scenarios = {
            # of a measured pulse the scenario has the file's name only; what is in it shows in the network
            name: {**json.loads(scenario.model_dump_json()), "network": _digest(lower(scenario)).hexdigest()}
            for name, scenario in self.scenarios.items()
        }
        own = self.study.model_dump(mode="json", exclude={"name", "description", "scenario", "scenarios"})
        return {**own, "scenarios": scenarios, "weights": dict(self.weights)}

    @property
    def hash(self) -> str:
        """Of the identity, 64 hexadecimal digits."""
        return hash_of(self.identity)


def _digest(value: Any) -> Any:
    """SHA-256 of plain data with arrays in it."""
    digest = hashlib.sha256()
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            digest.update(field.name.encode() + _digest(getattr(value, field.name)).digest())
    elif isinstance(value, np.ndarray):
        digest.update(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, list | tuple):
        for item in value:
            digest.update(_digest(item).digest())
    else:
        digest.update(repr(value).encode())
    return digest


def hash_of(identity: Mapping[str, Any]) -> str:
    """SHA-256 of plain data, the keys in order."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()


def load_study(source: str | os.PathLike[str] | Mapping[str, Any] | Study | LoadedStudy) -> LoadedStudy:
    """The study of a TOML or YAML file, of a name in the catalogue, or of a mapping of the same shape, with its scenarios.

    A scenario is a name of the catalogue, a file relative to the study's own folder, or written out in the study.

    >>> varied = {"path": "adult.restraint.stiffness", "values": ["60 kN/m", "98.1 kN/m"]}
    >>> load_study({"kind": "sweep", "scenario": "p1", "parameters": [varied]}).scenarios[""].name
    'p1'

    Raises: InvalidInput for anything wrong in the file, naming the field; UnknownName for a scenario that there is not.
    """
    if isinstance(source, LoadedStudy):
        return source
    text, folder = "", Path()
    if isinstance(source, Study):
        study = source
    elif isinstance(source, Mapping):
        study = Study.model_validate(dict(source))
    else:
        path = _path(source)
        text = _text(path)
        study, folder = Study.model_validate(table_in(path, text, _NEED)), path.parent
    cases = study.scenarios or (Case(name="only", scenario=study.scenario or {}),)
    scenarios: dict[str, Scenario] = {}
    for i, case in enumerate(cases):
        where = f"scenarios.{i}.scenario" if study.scenarios else "scenario"
        scenarios[case.name if study.scenarios else ""] = _scenario(where, case.scenario, folder)
    weights = {name: case.weight for name, case in zip(scenarios, cases, strict=True)}
    return LoadedStudy(study=study, scenarios=scenarios, weights=weights, text=text)


def _path(source: str | os.PathLike[str]) -> Path:
    """The file itself, or that of a study which comes with ridedown: of that name, unless a file has it."""
    path = Path(source)
    if path.suffix or path.name != str(source) or path.exists():
        return path
    known = catalogue.studies()
    if path.name not in known:
        raise UnknownName(f"{UnknownName.among('study', path.name, known)} For a file, give its path with .toml or .yaml.")
    return known[path.name]


def _text(path: Path) -> str:
    if path.suffix.lower() not in SUFFIXES:
        raise InvalidInput(f'study: got "{path}"; need a study file, *.toml or *.yaml. Check the path.')
    return text_of(path, "study")


def _scenario(where: str, given: str | dict[str, Any], folder: Path) -> Scenario:
    try:
        if isinstance(given, dict):
            return load(anchored(given, folder))
        beside = folder / given
        return load(beside if beside.is_file() else given)
    except InvalidInput as error:
        text = str(error)
        # a file says where it is itself; a scenario written out is a part of the study
        inline = isinstance(given, dict)
        raise InvalidInput(f"{where}.{text}" if inline else f"{where}: {text}") from None
