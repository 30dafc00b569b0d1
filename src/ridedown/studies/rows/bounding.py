"""A study of kind `bound`: its rows are excursions, its outcomes the least peaks, and what it says is a `BoundStudy`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ridedown.errors import InvalidInput, UnknownName
from ridedown.motion import motion_of
from ridedown.network import channels
from ridedown.response import Response
from ridedown.scenario import Scenario, SledScenario, lower
from ridedown.scenario.pulse_motion import PulseMotion
from ridedown.scenario.quantities import Quantity
from ridedown.simulation import simulate
from ridedown.studies.bound import BoundStudy, Design, Gap, Limiting, bound_study, gap_of
from ridedown.studies.bound.lead import Floats
from ridedown.studies.file.options import BoundOptions
from ridedown.studies.file.parameters import grid_levels
from ridedown.studies.rows.crashes import COMPLETED, Rows
from ridedown.units import LENGTH

EXCURSION, PEAK, OPEN = "excursion", "peak", "peak_without_seat"
"""Columns of the results: the excursion [m], the least peak within it, and that with no seat behind the occupant [m/s2]."""


@dataclass(frozen=True, eq=False)
class LeastPeaks:
    """The least peaks within excursions, of a scenario's pulse. The scenario is solved when first needed, if it must be."""

    scenario: Scenario
    options: BoundOptions

    @classmethod
    def of(cls, scenario: Scenario, options: BoundOptions) -> LeastPeaks:
        """For a scenario, with what can be checked before anything is solved.

        Raises: UnknownName for a vehicle or an occupant that there is not; InvalidInput for an occupant of another vehicle.
        """
        network = lower(scenario)
        riding = {one.name: f"vehicle{one.vehicle}" for one in getattr(scenario, "occupants", ())}
        bodies = [name.removesuffix(".excursion") for name in channels(network) if name.endswith(".excursion")]
        bodies = list(dict.fromkeys([*riding, *bodies]))
        vehicles = [
            name
            for name, parent, turns in zip(network.coordinates, network.parent, network.is_rotation, strict=True)
            if parent < 0 and not turns and name != "bar"
        ]
        if options.vehicle not in vehicles:
            raise UnknownName(f"bound.vehicle: {UnknownName.among('vehicle', options.vehicle, vehicles)}")
        for i, name in enumerate(options.occupants):
            if name not in bodies:
                raise UnknownName(f"bound.occupants.{i}: {UnknownName.among('occupant', name, bodies)}")
            vehicle = riding.get(name.partition(".")[0], options.vehicle)
            if vehicle != options.vehicle:
                raise InvalidInput(
                    f"bound.occupants.{i}: got {name}, who is in {vehicle}; need one in "
                    f"{options.vehicle}, whose pulse it is. Take another, or another vehicle."
                )
        return cls(scenario, options)

    @property
    def excursions(self) -> Floats:
        """Of the curve [m], rising. Raises: InvalidInput."""
        options = self.options
        if options.excursions is not None or options.grid is None:
            return np.array(options.excursions, dtype=np.float64)
        levels = grid_levels("bound.grid", options.grid, [Quantity(LENGTH, least=0.0)])
        if levels[0] > levels[-1] or (options.slack > 0.0 and levels[0] <= options.slack):
            rule = "a least excursion, then a larger one" if levels[0] > levels[-1] else "more than the slack"
            raise InvalidInput(f"bound.grid.start: got {levels[0]:g} m; need {rule}. Change start or stop.")
        return levels

    @property
    def units(self) -> dict[str, str]:
        """Every outcome with its SI unit."""
        return {PEAK: "m/s2", OPEN: "m/s2"}

    @cached_property
    def response(self) -> Response:
        """The scenario solved."""
        return simulate(self.scenario)

    @cached_property
    def motion(self) -> PulseMotion:
        """Of the vehicle. Nothing is solved for that of a sled."""
        return motion_of(self.scenario if isinstance(self.scenario, SledScenario) else self.response, self.options.vehicle)

    @cached_property
    def limiting(self) -> tuple[Limiting, Limiting]:
        """The bounds with the seat that there is, and with none. Raises: InvalidInput for a pulse that does not brake."""
        rearward = self.options.rearward if self.options.seat else math.inf
        return tuple(  # type: ignore[return-value]
            Limiting(self.motion, rearward=room, slack=self.options.slack, horizon=self.options.horizon)
            for room in (rearward, math.inf)
        )

    def check(self) -> None:
        """Raises: InvalidInput for a pulse that takes no speed from the vehicle, or an occupant whom nothing brakes."""
        _ = self.limiting, self.gaps

    @cached_property
    def gaps(self) -> list[Design | Gap]:
        """The designs beside the bound."""
        found: list[Design | Gap] = [gap_of(self.response, name, name=name) for name in self.options.occupants]
        return found + [Design(one.name, one.peak, one.excursion, one.rearward) for one in self.options.designs]

    def rows(self, columns: Mapping[str, Floats]) -> Rows:
        """The least peaks within these excursions."""
        excursions = columns[EXCURSION]
        own, free = (limiting.peaks(excursions) for limiting in self.limiting)
        return Rows({PEAK: own, OPEN: free}, np.zeros(excursions.size, dtype=np.int32), [(COMPLETED, "")])

    def study(self, name: str, peaks: Floats, unlimited: Floats) -> BoundStudy:
        """The whole study, with the curve that was kept of it, (n,) each."""
        options, excursions = self.options, self.excursions
        excursion = options.excursion
        if excursion is None and not self.gaps:
            excursion = float(excursions[excursions.size // 2])
        found = bound_study(
            self.motion,
            excursions[[0, -1]],
            designs=self.gaps,
            excursion=excursion,
            name=name,
            rearward=options.rearward if options.seat else math.inf,
            slack=options.slack,
            horizon=options.horizon,
        )
        return replace(found, excursions=excursions, peaks=peaks, unlimited=unlimited)
