"""The paper's unstated vehicles, found again from its ten numbers: the inverse problem, solved with ridedown itself.

The numbers depend on ratios of force to mass alone, so that vehicle 1's mass stays as in the catalogue, and so does the spacing
of its rails. Whatever is found is a reconstruction: see docs/decisions/paper-vehicle.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput
from ridedown.paper import cases
from ridedown.paper.candidates import UNKNOWNS, Crashes, crash, scenario_of, values_of, with_vehicle
from ridedown.paper.numbers import PRINTED, ROUNDING, Headline, headlines
from ridedown.paper.reproduce import Reproduction
from ridedown.paper.trends import trends
from ridedown.scenario import CrashScenario, dump
from ridedown.simulation import simulate
from ridedown.studies.search import Effort, Found, runs

Floats = NDArray[np.float64]

MOST_CRUSH, MOST_TURN = 1.1, 1.0
"""What is taken for possible: deflection of a member [m], for which a car has room; rotation of the bar [rad]."""
NEAR = 0.03
"""The largest relative error that a vehicle of the paper may have in any of the ten numbers [1]."""

_MARGIN = 0.85
"""How much of the print's rounding the search uses: its result is rounded afterwards."""
_FAR = 0.028
"""Relative error above which a number costs much more, a little below `NEAR` for the same reason [1]."""
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
    seed: int | np.random.Generator | None = 0,
    effort: Effort | None = None,
    threads: int = 2,
) -> Identified:
    """Find vehicles that give the ten numbers, by global search with `simulate_many`.

    target: the ten numbers, in the order and the units of `ridedown.paper.numbers.PRINTED`; the paper's own if left out.
    seed: of the search; the same one finds the same vehicles, on one thread or two. effort: when to give up.

    Returns: the first that are `complete`, their values rounded to four digits; or else the best there were: first by the
    trends, then by errors of at most 3 %, then by how many numbers round to the target's.

    Raises: InvalidInput for a target that is not ten positive numbers; SimulationStopped if not one candidate could be crashed
    to its end, as may be with very little effort.
    """
    wanted = _checked(target)
    search = runs(
        lambda points: _misfit(crash(values_of(points), threads=threads), wanted),
        len(UNKNOWNS),
        effort or Effort(),
        np.random.default_rng(seed),
    )
    best: Identified | None = None
    for found in search:
        latest = _judged(found, wanted)
        if best is None or _rank(latest) > _rank(best):
            best = latest
        if best.complete:
            break
    assert best is not None
    return best


def _checked(target: Sequence[float] | None) -> Floats:
    if target is None:
        return np.array([printed.value for printed in PRINTED])
    numbers = np.asarray(target, dtype=np.float64)
    if numbers.shape != (len(PRINTED),) or not (np.isfinite(numbers) & (numbers > 0.0)).all():
        raise InvalidInput(f"target: got {target!r}; need {len(PRINTED)} positive numbers. Give them in the order of PRINTED.")
    return numbers


_ROUNDING = np.array([ROUNDING[printed.quantity] for printed in PRINTED])


def _misfit(crashes: Crashes, wanted: Floats) -> Floats:
    """How far candidates are from the numbers, shape (R,): nothing counts much once all round to them and the car has room."""
    error = np.abs(crashes.numbers - wanted)
    beyond_print = np.maximum(error / _ROUNDING - _MARGIN, 0.0) ** 2 + 1e-3 * (error / _ROUNDING) ** 2
    far = np.maximum(error / wanted - _FAR, 0.0) / 0.01
    room = np.maximum(crashes.crush - MOST_CRUSH, 0.0) / 0.03, np.maximum(crashes.turn - MOST_TURN, 0.0) / 0.1
    misfit = (beyond_print + far**2).sum(axis=1) + room[0] ** 2 + room[1] ** 2
    return np.where(np.isnan(misfit), np.inf, misfit)


def _judged(found: Found, wanted: Floats) -> Identified:
    """The vehicles with their values rounded, in all of the paper's cases."""
    values = np.array([float(f"{value:.{_DIGITS}g}") for value in values_of(found.best)])
    responses = {case.scenario: simulate(with_vehicle(scenario_of(case), values)) for case in cases.ALL}
    table = tuple(replace(h, paper=float(number)) for h, number in zip(headlines(responses), wanted, strict=True))
    return Identified(
        values={unknown.name: float(value) for unknown, value in zip(UNKNOWNS, values, strict=True)},
        reproduction=Reproduction(table, trends(responses), responses),
        scenario=_offset_with_both(values),
        tried=found.tried,
    )


def _rank(identified: Identified) -> tuple[bool, bool, int, float]:
    return identified.trends_hold, identified.worst <= NEAR, identified.within, -identified.worst


def _offset_with_both(values: Floats) -> CrashScenario:
    adult, child = (scenario_of(case) for case in (cases.ADULT_OFFSET, cases.CHILD_OFFSET))
    both = adult.model_copy(
        update={
            "name": "paper-vehicle-identified",
            "description": "Adult and child in an offset head-on collision. The vehicles are a reconstruction.",
            "occupants": (*adult.occupants, *child.occupants),
        }
    )
    return with_vehicle(both, values)
