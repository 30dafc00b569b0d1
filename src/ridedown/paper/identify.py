"""The paper's unstated vehicles, found again from its ten numbers: the inverse problem, solved with ridedown itself.

It is a calibration file like any other (`identify.toml`), searched until what is found also shows the paper's trends. The
numbers depend on ratios of force to mass alone, so that vehicle 1's mass stays as in the catalogue, and so does the spacing
of its rails. Whatever is found is a reconstruction: see docs/decisions/paper-vehicle.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.paper import cases
from ridedown.paper.candidates import FILE, calibration_to, scenario_of, with_vehicle
from ridedown.paper.numbers import PRINTED, Headline, headlines
from ridedown.paper.reproduce import Reproduction
from ridedown.paper.trends import trends
from ridedown.scenario import CrashScenario, dump
from ridedown.simulation import simulate
from ridedown.studies.analysis.cma_es import Effort, runs
from ridedown.studies.calibration.fit import effort_of
from ridedown.studies.calibration.problem import Problem
from ridedown.studies.calibration.unknowns import values_of

NEAR = 0.03
"""The largest relative error that a vehicle of the paper may have in any of the ten numbers [1]."""

_DIGITS = 4
"""Significant digits of the values found."""


@dataclass(frozen=True, slots=True)
class Identified:
    """Vehicles that give the ten numbers, a reconstruction, and what they do to the occupants in all of the paper's cases.

    values: the unknowns by name, SI. scenario: the offset collision with the adult and the child; in the full one the lateral
    offset is zero. tried: how many candidates the search crashed.
    """

    values: dict[str, float]
    reproduction: Reproduction
    scenario: CrashScenario
    tried: int

    @property
    def table(self) -> tuple[Headline, ...]:
        """The ten numbers beside those looked for."""
        return self.reproduction.headlines

    @property
    def toml(self) -> str:
        """The scenario as a file."""
        return dump(self.scenario)

    @property
    def within(self) -> int:
        """How many of the ten round to what is printed."""
        return sum(headline.rounds_to_print for headline in self.table)

    @property
    def worst(self) -> float:
        """The largest relative error of the ten [1]."""
        return max(abs(headline.error) for headline in self.table)

    @property
    def trends_hold(self) -> bool:
        """Whether every trend of the paper holds."""
        return all(trend.holds for trend in self.reproduction.trends)

    @property
    def complete(self) -> bool:
        """Whether there is nothing left to gain: every trend holds and all ten numbers round to those looked for."""
        return self.trends_hold and self.worst <= NEAR and self.within == len(self.table)


def identify(
    target: Sequence[float] | None = None,
    *,
    seed: int | np.random.Generator | None = None,
    effort: Effort | None = None,
) -> Identified:
    """Find vehicles that give the ten numbers, by global search with `simulate_many`.

    target: the ten numbers, in the order and the units of `ridedown.paper.numbers.PRINTED`; the paper's own if left out.
    seed: of the search; the file's if left out. The same one finds the same vehicles. effort: when to give up; the file's if
    left out.

    Returns: the first that are `complete`, their values rounded to four digits; or else the best there were: first by the
    trends, then by errors of at most 3 %, then by how many numbers round to the target's.

    Raises: InvalidInput for a target that is not ten positive numbers, and where not one candidate could be crashed to its
    end, as may be with very little effort.
    """
    calibration = calibration_to(target)
    wanted = [printed.value for printed in PRINTED] if target is None else [float(number) for number in target]
    problem = Problem.of(calibration, FILE.parent)
    rng = np.random.default_rng(calibration.search.seed if seed is None else seed)
    best: Identified | None = None
    for found in runs(problem.misfit, len(problem.unknowns), effort or effort_of(calibration.search), rng):
        if not np.isfinite(found.value):
            continue
        names = [unknown.name for unknown in problem.unknowns]
        values = dict(zip(names, values_of(problem.unknowns, found.best).tolist(), strict=True))
        latest = _judged(values, wanted, found.tried)
        if best is None or _rank(latest) > _rank(best):
            best = latest
        if best.complete:
            break
    if best is None:
        raise InvalidInput("effort: got a search that no candidate survived; need more candidates. Search harder.")
    return best


def _judged(found: Mapping[str, float], wanted: Sequence[float], tried: int) -> Identified:
    """The vehicles with their values rounded, in all of the paper's cases."""
    values = {name: float(f"{value:.{_DIGITS}g}") for name, value in found.items()}
    responses = {case.scenario: simulate(with_vehicle(scenario_of(case), values)) for case in cases.ALL}
    table = tuple(replace(h, paper=number) for h, number in zip(headlines(responses), wanted, strict=True))
    return Identified(
        values=values,
        reproduction=Reproduction(table, trends(responses), responses),
        scenario=_offset_with_both(values),
        tried=tried,
    )


def _rank(identified: Identified) -> tuple[bool, bool, int, float]:
    return identified.trends_hold, identified.worst <= NEAR, identified.within, -identified.worst


def _offset_with_both(values: Mapping[str, float]) -> CrashScenario:
    adult, child = (scenario_of(case) for case in (cases.ADULT_OFFSET, cases.CHILD_OFFSET))
    both = adult.model_copy(
        update={
            "name": "paper-vehicle-identified",
            "description": "Adult and child in an offset head-on collision. The vehicles are a reconstruction.",
            "occupants": (*adult.occupants, *child.occupants),
        }
    )
    return with_vehicle(both, values)
