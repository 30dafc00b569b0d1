"""What a study file says of a kind that is more than rows fixed beforehand: a bound, an optimisation, a solution box."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from ridedown.scenario.base import Check, Model
from ridedown.scenario.quantities import Deflection, Distance, Duration, Quantity, Slack
from ridedown.studies.parameters import Grid
from ridedown.units import ACCELERATION

Peak = Annotated[float, Quantity(ACCELERATION, above=0.0, fix="A peak deceleration is a magnitude, without a sign.")]


class BuiltDesign(Model):
    """A restraint by what it did: name, peak deceleration, and excursions forward and, before that, rearward."""

    name: str = Field(description="what it is called")
    peak: Peak
    excursion: Distance
    rearward: Deflection = 0.0


class BoundOptions(Model):
    """What limiting performance is asked for.

    excursions, or an evenly spaced `grid` of them: the curve, at two or more that rise. excursion: of the ideal history; that
    of the first design, or the middle one, if left out. vehicle: whose pulse it is. occupants: of the scenario, or masses of
    theirs, to set beside it; designs: others, known by their numbers. rearward: room behind the occupant; seat: whether a seat
    is behind it at all. slack: that it moves before a restraint acts. horizon: until when it must be kept.
    """

    excursions: tuple[Deflection, ...] | None = Field(None, description="a list of lengths that rise")
    grid: Grid | None = Field(None, description="evenly spaced excursions")
    excursion: Distance | None = None
    vehicle: str = "vehicle1"
    occupants: tuple[str, ...] = ()
    designs: tuple[BuiltDesign, ...] = ()
    rearward: Deflection = 0.0
    seat: bool = Field(default=True, strict=True, description="whether a seat is behind the occupant")
    slack: Slack = 0.0
    horizon: Duration | None = None

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        both = self.excursions is not None and self.grid is not None
        yield Check("excursions", not both, "both excursions and a grid", "one of them", "Take one out.")
        given = self.excursions is not None or self.grid is not None
        yield Check("excursions", given, "nothing", "excursions, or a grid of them", 'As in ["100 mm", "200 mm", "300 mm"].')
        if self.excursions is not None:
            several = len(self.excursions) >= 2
            yield Check("excursions", several, f"a list of {len(self.excursions)}", "two or more", "Add the others.")
            rising = all(one < other for one, other in zip(self.excursions, self.excursions[1:], strict=False))
            yield Check("excursions", rising, "some that do not rise", "each larger than the one before", "Sort them.")
            free = self.slack == 0.0 or self.excursions[0] > self.slack
            yield Check("excursions.0", free, self.excursions[0], "more than the slack", "No restraint acts before.", "m")
        room = self.excursion is None or self.slack == 0.0 or self.excursion > self.slack
        yield Check("excursion", room, self.excursion or 0.0, "more than the slack", "No restraint acts before.", "m")
        seated = self.seat or self.rearward == 0.0
        yield Check("rearward", seated, self.rearward, "nothing where there is no seat", "Take it out.", "m")
        twice = next((name for name in self.occupants if self.occupants.count(name) > 1), "")
        yield Check("occupants", not twice, f"{twice} twice", "each once", "Take one out.")
