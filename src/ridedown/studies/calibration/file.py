"""Calibration files: which tests, what is measured in each, which parameters are free, what is predicted.

Numbers whose dimension depends on what they are compared with (`value`, `sigma`, `bounds`, ...) are kept as written, and read
when the scenarios are known.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from numbers import Real
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, StrictBool, StringConstraints

from ridedown.errors import InvalidInput
from ridedown.scenario import Scenario
from ridedown.scenario.base import Check, Model
from ridedown.scenario.quantities import Quantity, Refused
from ridedown.scenario.reading import table_in, text_of
from ridedown.signals.record import TestRecord
from ridedown.units import TIME

Title = Annotated[str, StringConstraints(min_length=1, max_length=80, strip_whitespace=True)]


def _written(value: object) -> object:
    """A bare number, or text with a unit that is read later."""
    if isinstance(value, bool) or not isinstance(value, Real | str):
        raise Refused(f"{value!r}", 'a number in SI, or text with a unit such as "40 kN"')
    return value if isinstance(value, str) else float(value)


def _several(value: object) -> object:
    return [value] if isinstance(value, str | int) else value


def _key(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, str | int):
        raise Refused(f"{value!r}", "the number, the name or the code of a channel")
    return str(value)


def _positive(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, Real) or not 0.0 < float(value) < float("inf"):
        raise Refused(f"{value!r}", "a number > 0", "Leave a target out to ignore it.")
    return float(value)


def _class(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, Real) or not 0.0 < float(value) < float("inf"):
        fix = "The standards name 60, 180, 600 and 1000; class 60 lets 100 Hz pass. Leave it out for no filter."
        raise Refused(f"{value!r}", "a channel frequency class > 0 such as 60, which is no frequency", fix)
    return float(value)


def _scenario(value: object) -> object:
    if isinstance(value, str | os.PathLike | Mapping | Scenario):
        return value
    raise Refused(f"{value!r}", "a catalogue name, a file or a table")


def _record(value: object) -> object:
    if isinstance(value, str | os.PathLike | TestRecord):
        return value
    raise Refused(f"{value!r}", "the path of a test")


Written = Annotated[float | str, BeforeValidator(_written)]
"""A number whose dimension is known later."""
Weight = Annotated[float, BeforeValidator(_positive)]
Time = Annotated[float, Quantity(TIME)]
Class = Annotated[float, BeforeValidator(_class)]
Keys = Annotated[tuple[Annotated[str, BeforeValidator(_key)], ...], BeforeValidator(_several)]


class Target(Model):
    """What a case is compared with: a channel over time, or an outcome, which is a number.

    Of a case, a channel needs `measured`, and an outcome needs `value`, or `min` and `max`. Of a prediction neither does.
    """

    channel: str = Field("", description="a channel of the model, such as driver.acceleration")
    measured: Keys = Field((), description="channels of the record, by number, name or code; several are averaged")
    cfc: Class | None = Field(None, description="channel frequency class that both are filtered to")
    window: tuple[Time, Time] | None = Field(None, description="from when to when; all of it if left out")
    outcome: str = Field("", description="an outcome of the model, such as driver.excursion.max")
    value: Written | None = Field(None, description="what it should be")
    sigma: Written | None = Field(
        None,
        description="standard deviation: of value, of a channel (5 % of its peak if left out), or how soft min and max are",
    )
    peak: Written | None = Field(
        None, description="of a channel: standard deviation of its peak, which then counts as a number too"
    )
    within: Written | None = Field(None, description="instead of sigma: half the width that value was rounded to")
    min: Written | None = Field(None, description="what an outcome may be at least")
    max: Written | None = Field(None, description="what an outcome may be at most")
    weight: Weight = 1.0

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        both = "both" if self.channel and self.outcome else "neither"
        fix = "Use two targets for two things."
        yield Check("channel", bool(self.channel) != bool(self.outcome), both, "a channel or an outcome", fix)
        if self.channel:
            for field in ("value", "within", "min", "max"):
                given = getattr(self, field) is not None
                yield Check(field, not given, "a value with a channel", "none", "It goes with an outcome.")
            if self.window is not None:
                start, end = self.window
                yield Check("window.0", start >= 0.0, start, "0 s or later", "The model starts at time 0.", "s")
                yield Check("window.1", end > start, end, "an end after the start", "", "s")
        else:
            for field in ("measured", "cfc", "window", "peak"):
                yield Check(field, not getattr(self, field), "a value with an outcome", "none", "It goes with a channel.")
            yield from self._of_an_outcome()

    def _of_an_outcome(self) -> Iterator[Check]:
        limit = self.min is not None or self.max is not None
        yield Check("value", not (limit and self.value is not None), "value with min or max", "one of them", "Use two targets.")
        many = self.sigma is not None and self.within is not None
        yield Check("within", not many, "both sigma and within", "one of them", "within is for rounded numbers.")
        fix = "Without it nothing says how near is near enough."
        spread = self.sigma is not None or self.within is not None
        yield Check("sigma", self.value is None or spread, "nothing", "sigma or within", fix)
        yield Check("sigma", not limit or self.sigma is not None, "nothing", "sigma: how softly the limit acts", fix)
        yield Check("within", self.within is None or self.value is not None, "within without a value", "a value")


class Prediction(Model):
    """A crash that is predicted with the fitted parameters, and not fitted: with measurements, an honest test."""

    name: Title = Field("", validate_default=False, description="the scenario's name if left out")
    scenario: Annotated[Any, BeforeValidator(_scenario)] = Field(description="a catalogue name, a file or a table")
    record: Annotated[Any, BeforeValidator(_record)] | None = Field(None, description="path of a test")
    targets: tuple[Target, ...] = Field(description="channels and outcomes to predict")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("targets", bool(self.targets), "an empty list", "one target at least")
        for i, target in enumerate(self.targets):
            where = f"targets.{i}"
            fix = "Name the path of the test in `record`."
            yield Check(f"{where}.measured", self.record is not None or not target.measured, "a channel", "a record", fix)


class Case(Prediction):
    """One test, or one set of numbers, and the scenario that should give it."""

    weight: Weight = 1.0

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from super().checks()
        for i, target in enumerate(self.targets):
            where = f"targets.{i}"
            yield Check(
                f"{where}.measured",
                not target.channel or bool(target.measured),
                "nothing",
                "the measured channel",
                "Or predict it.",
            )
            given = any(x is not None for x in (target.value, target.min, target.max))
            yield Check(f"{where}.value", not target.outcome or given, "nothing", "value, min or max", "Or predict it.")


class Sets(Model):
    """The fields that a parameter sets, and in which cases."""

    paths: tuple[str, ...] = Field(description='paths such as "driver.restraint.stiffness"; * stands for one part of a path')
    cases: tuple[str, ...] = Field((), description="names of cases and predictions; all of them if left out")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("paths", bool(self.paths), "an empty list", "one path at least")


class Prior(Model):
    """What is known of a parameter beforehand, as one more measurement."""

    value: Written
    sigma: Written


class FreeParameter(Model):
    """Something to be found: its bounds, and the fields that it sets, alike in all cases or in each its own."""

    name: Title
    bounds: tuple[Written, Written] = Field(description="least and largest value")
    scale: Literal["linear", "log"] = Field("linear", description="log: searched by ratio")
    factor: StrictBool = Field(default=False, description="whether it multiplies what the fields hold")
    paths: tuple[str, ...] = Field((), description="the fields it sets; or use sets")
    cases: tuple[str, ...] = Field((), description="in which cases; all if left out")
    sets: tuple[Sets, ...] = Field((), description="instead of paths: different fields in different cases")
    each: StrictBool = Field(default=False, description="whether every case has a value of its own")
    prior: Prior | None = None

    def complete(self) -> None:
        """Write `paths` and `cases` as `sets`."""
        if self.paths and not self.sets:
            self._fill(sets=(Sets(paths=self.paths, cases=self.cases),))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("paths", bool(self.sets), "nothing", "the paths that it sets", "Give paths, or sets.")
        alone = not self.paths or self.sets == (Sets(paths=self.paths, cases=self.cases),)
        yield Check("sets", alone, "both paths and sets", "one of them", "Write the paths as one more of the sets.")


class Search(Model):
    """How hard to search."""

    seed: int = Field(0, strict=True, ge=0, description="the same seed finds the same parameters")
    effort: Literal["quick", "normal", "thorough"] = "normal"
    restarts: int | None = Field(None, strict=True, ge=1, le=1000)
    sample: int | None = Field(None, strict=True, ge=1, le=1_000_000)
    population: int | None = Field(None, strict=True, ge=4, le=100_000)
    generations: int | None = Field(None, strict=True, ge=1, le=100_000)
    patience: int | None = Field(None, strict=True, ge=1, le=100_000)


class Calibration(Model):
    """A calibration: cases, free parameters, search, predictions."""

    title: str = ""
    description: str = ""
    cases: tuple[Case, ...] = Field(description="the tests")
    parameters: tuple[FreeParameter, ...] = Field(description="what is free")
    predict: tuple[Prediction, ...] = Field((), description="what is predicted")
    search: Search = Field(default_factory=Search)
    posterior: StrictBool = Field(default=False, description="whether to sample the posterior as well")

    def complete(self) -> None:
        """Name what was not named."""
        taken: set[str] = set()

        def named(entry: Any, i: int) -> Any:
            given = entry.name or (Path(entry.scenario).stem if isinstance(entry.scenario, str) else "")
            stem = given or f"{'case' if isinstance(entry, Case) else 'prediction'} {i}"
            name = entry.name or (stem if stem not in taken else f"{stem} {i}")
            taken.add(name)
            return entry.model_copy(update={"name": name})

        self._fill(cases=tuple(named(case, i) for i, case in enumerate(self.cases, 1)))
        self._fill(predict=tuple(named(p, i) for i, p in enumerate(self.predict, 1)))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("cases", bool(self.cases), "an empty list", "one case at least")
        yield Check("parameters", bool(self.parameters), "an empty list", "one free parameter at least")
        for field, entries in (
            ("cases", (*self.cases, *self.predict)),
            ("parameters", self.parameters),
        ):
            names = [entry.name for entry in entries]
            for i, name in enumerate(names):
                yield Check(f"{field}.{i}.name", name not in names[:i], f'"{name}" a second time', "a name of its own")


def load_calibration(source: str | os.PathLike[str] | Mapping[str, Any] | Calibration) -> tuple[Calibration, Path]:
    """A calibration from a TOML or YAML file or a mapping of the same shape, and the folder that its paths start from.

    >>> calibration, _ = load_calibration({
    ...     "cases": [{"scenario": "neon-wall", "targets": [
    ...         {"outcome": "vehicle1.right.deflection.max", "value": "736 mm", "sigma": "10 mm"}]}],
    ...     "parameters": [{"name": "force", "factor": True, "bounds": [0.5, 2], "paths": ["vehicle1.members.points.*.1"]}],
    ... })
    >>> calibration.cases[0].name
    'neon-wall'

    Raises: InvalidInput for anything wrong in it, naming the field or the line.
    """
    if isinstance(source, Calibration):
        return source, Path()
    if isinstance(source, Mapping):
        return Calibration.model_validate(dict(source)), Path()
    if not isinstance(source, str | os.PathLike):
        raise InvalidInput(f"calibration: got {type(source).__name__}; need a file or a mapping.")
    path = Path(source)
    data = table_in(path, text_of(path, "calibration"), "need a calibration: `cases` and `parameters`.")
    return Calibration.model_validate(data), path.parent
