"""A crash of one vehicle against a wall, or of two against each other, with their occupants."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pydantic import Field

from ridedown.scenario.bar import Bar
from ridedown.scenario.base import NOT_YET, Check, Model, unused, without_default
from ridedown.scenario.occupant import Occupant
from ridedown.scenario.quantities import Duration
from ridedown.scenario.vehicle import Vehicle

Confidence = Literal["primary", "second-hand", "reconstructed"]

RESERVED = ("vehicle1", "vehicle2", "bar", "duration", "wall")
"""Names that occupants and masses may not have, for parameter paths and channels use them."""


class Source(Model):
    """Where a scenario's numbers come from, and how sure they are."""

    title: str = Field(description="title of the publication")
    authors: str = ""
    year: int | None = Field(None, strict=True)
    where: str = Field("", description="journal, report, table, equation")
    confidence: Confidence = Field(
        description='"primary" (read there), "second-hand" (quoted by others) or "reconstructed" (ours)'
    )
    note: str = ""


class Description(Model):
    """What scenarios of every kind say of themselves."""

    name: str = ""
    description: str = ""
    duration: Duration = Field(0.2, description="how long to simulate")
    sources: tuple[Source, ...] = ()


class Collision(Model):
    """What vehicle 1 meets: vehicle 2 by way of the bar, or a rigid wall."""

    kind: Literal["vehicle", "wall"] = Field(description='"vehicle" or "wall"')


class CrashScenario(Description):
    """A head-on crash, all in contact and moving freely at time 0. Numbers are SI.

    >>> crash = CrashScenario(
    ...     vehicle1={"mass": "1500 kg", "speed": "48 km/h", "members": {"pieces": [{"stiffness": "200 kN/m"}]}}
    ... )
    >>> crash.vehicle1.mass, crash.collision.kind
    (1500.0, 'wall')
    """

    vehicle1: Vehicle
    vehicle2: Vehicle | None = None
    collision: Collision = Field(NOT_YET, json_schema_extra=without_default, description="what vehicle 1 meets")
    bar: Bar | None = None
    occupants: tuple[Occupant, ...] = ()

    def complete(self) -> None:
        """Fill in what was left out."""
        if self.collision is None:
            self._fill(collision=Collision(kind="wall" if self.vehicle2 is None else "vehicle"))
        self._fill(occupants=named(self.occupants))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        wall = self.collision.kind == "wall"
        two = self.vehicle2 is not None
        yield Check(
            "collision.kind",
            not (wall and two),
            '"wall" with a vehicle2',
            "one vehicle against a wall",
            'Take vehicle2 out, or set kind = "vehicle".',
        )
        yield Check(
            "vehicle2",
            wall or two,
            "nothing",
            "a second vehicle",
            'Add it, or set collision.kind = "wall".',
        )
        yield Check(
            "bar",
            self.bar is None or not wall,
            "a bar with a rigid wall",
            "none",
            "Take the bar out: the members press on the wall itself; or add vehicle2.",
        )
        yield Check(
            "bar",
            self.bar is not None or wall,
            "nothing",
            "a bumper bar between the two vehicles",
            "Add a [bar] with mass, inertia and rail_spacing.",
        )
        for i, occupant in enumerate(self.occupants):
            yield Check(
                f"occupants.{i}.vehicle",
                occupant.vehicle == 1 or two,
                f"{occupant.vehicle}",
                "the number of a vehicle in this scenario",
                "There is no vehicle2 here.",
            )
        yield from distinct("occupants", [occupant.name for occupant in self.occupants])


def named(occupants: tuple[Occupant, ...]) -> tuple[Occupant, ...]:
    """The occupants, those without a name called after their kind."""
    taken = {occupant.name for occupant in occupants}
    found = []
    for occupant in occupants:
        name = occupant.name or unused(occupant.kind, taken)
        taken.add(name)
        found.append(occupant.model_copy(update={"name": name}))
    return tuple(found)


def distinct(field: str, names: list[str], taken: tuple[str, ...] = ()) -> Iterator[Check]:
    """The rule that names differ from each other and from those taken."""
    seen = set(taken)
    for i, name in enumerate(names):
        where = f"{field}.{i}.name"
        yield Check(where, name not in RESERVED, f'"{name}", a reserved name', "another name", "Rename it.")
        yield Check(where, name not in seen, f'"{name}" a second time', "a name of its own", "Rename one of them.")
        seen.add(name)
