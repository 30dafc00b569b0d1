"""A sled: the vehicle's motion is prescribed, and the occupants ride in it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag

from ridedown.scenario.base import NOT_YET, Check, of_known_kind, without_default
from ridedown.scenario.model import Description, distinct, named
from ridedown.scenario.occupant import Occupant
from ridedown.scenario.pulse import (
    BasePulse,
    EquivalentSquareWave,
    FmvssPulse,
    SimplePulse,
    TippedEquivalentSquareWave,
    TrapezoidPulse,
    TrianglePulse,
)
from ridedown.scenario.pulse_measured import MeasuredPulse
from ridedown.scenario.pulse_points import PointsPulse
from ridedown.scenario.pulse_solved import ScenarioPulse
from ridedown.scenario.quantities import Duration, Number, Velocity

KINDS: dict[str, type[BasePulse]] = {
    "half-sine": SimplePulse,
    "haversine": SimplePulse,
    "triangle": TrianglePulse,
    "trapezoid": TrapezoidPulse,
    "square": SimplePulse,
    "equivalent-square-wave": EquivalentSquareWave,
    "tipped-equivalent-square-wave": TippedEquivalentSquareWave,
    "fmvss-208-sled": FmvssPulse,
    "points": PointsPulse,
    "measured": MeasuredPulse,
    "scenario": ScenarioPulse,
}

USUAL_DURATION = 0.2  # s


def _known(value: object) -> object:
    """A pulse, or a table with a kind that there is."""
    return of_known_kind(value, BasePulse, KINDS, "a table [pulse] with a kind")


def _which(value: Any) -> str:
    kind = type(value) if isinstance(value, BasePulse) else KINDS[value["kind"]]
    return f"({kind.__name__.lower()})"


AnyPulse = Annotated[
    Annotated[SimplePulse, Tag("(simplepulse)")]
    | Annotated[TrianglePulse, Tag("(trianglepulse)")]
    | Annotated[TrapezoidPulse, Tag("(trapezoidpulse)")]
    | Annotated[EquivalentSquareWave, Tag("(equivalentsquarewave)")]
    | Annotated[TippedEquivalentSquareWave, Tag("(tippedequivalentsquarewave)")]
    | Annotated[FmvssPulse, Tag("(fmvsspulse)")]
    | Annotated[PointsPulse, Tag("(pointspulse)")]
    | Annotated[MeasuredPulse, Tag("(measuredpulse)")]
    | Annotated[ScenarioPulse, Tag("(scenariopulse)")],
    Discriminator(_which),
    BeforeValidator(_known),
]


class SledScenario(Description):
    """A vehicle that follows a pulse, whatever its occupants do, with its occupants. Numbers are SI.

    In results the vehicle is `vehicle1`, as in a crash.

    >>> sled = SledScenario(pulse={"kind": "half-sine", "delta_v": "50 km/h", "duration": "100 ms"})
    >>> round(sled.initial_speed, 3), sled.duration
    (13.889, 0.2)
    """

    duration: Duration = Field(
        NOT_YET, json_schema_extra=without_default, description="how long to simulate; as long as a measured pulse, else 0.2 s"
    )
    pulse: AnyPulse = Field(description="how the vehicle moves")
    speed: Velocity | None = Field(None, description="initial speed of the vehicle; the pulse's own if left out")
    occupants: tuple[Occupant, ...] = ()

    def complete(self) -> None:
        """Fill in what was left out."""
        if self.duration is None:
            whole = self.pulse.whole()
            usual = max(USUAL_DURATION, float(np.max(self.pulse.end())))
            self._fill(duration=usual if whole is None else whole)
        self._fill(occupants=named(self.occupants))
        if isinstance(self.pulse, ScenarioPulse):
            more = tuple(source for source in self.pulse.scenario.sources if source not in self.sources)
            self._fill(sources=self.sources + more)

    @property
    def initial_speed(self) -> Number:
        """Speed of the vehicle and of its occupants at time 0 [m/s]."""
        speed = self.pulse.change() if self.speed is None else self.speed
        assert speed is not None
        return speed

    def checks(self) -> Iterator[Check]:
        """Rules between the fields, those of the pulse first: the others ask it for its speed."""
        for check in self.pulse.checks():
            yield check._replace(field=f"pulse.{check.field}")
        known = self.speed is not None or self.pulse.change() is not None
        fix = "The record does not tell the vehicle's: add it."
        yield Check("speed", known, "nothing", 'the initial speed of the vehicle, such as "56 km/h"', fix)
        for i, occupant in enumerate(self.occupants):
            yield Check(f"occupants.{i}.vehicle", occupant.vehicle == 1, "2", "1", "A sled has one vehicle.")
            yield Check(
                f"occupants.{i}.coupled",
                not occupant.coupled,
                "true",
                "false in a sled",
                "The vehicle's motion is prescribed: nothing pushes it.",
            )
        yield from distinct("occupants", [occupant.name for occupant in self.occupants])
