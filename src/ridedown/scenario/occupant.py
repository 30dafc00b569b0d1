"""Occupants and what restrains them: an adult in a belt, a child in a seat of its own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field, StrictBool

from ridedown.scenario.base import Check, Model, Name, exclusive
from ridedown.scenario.quantities import Damping, DampingRatio, Mass, Number, Refused, Slack, Stiffness

RestraintLaw = Literal["threshold", "kelvin-voigt", "linear"]


def _no_truth_value(value: object) -> object:
    if isinstance(value, bool):  # which Python takes for 1 or 0
        raise Refused("true" if value else "false", "1 or 2")
    return value


class Restraint(Model):
    """A belt, a harness or a seat's mounting: a spring with slack, and a damper.

    `threshold` is the paper's law (eqs 13-18): the damper counts from the relative velocity at which the slack is taken
    up. `kelvin-voigt` pulls only, with a plain damper. `linear` is always engaged, both ways (eqs 25-29).
    """

    alternatives: ClassVar[dict[str, str]] = {"damping": "damping_ratio", "damping_ratio": "damping"}

    stiffness: Stiffness = Field(description="spring stiffness")
    slack: Slack = Field(0.0, description="relative displacement before the restraint engages")
    damping: Damping | None = Field(None, description="damper coefficient; 0 if neither it nor the ratio is given")
    damping_ratio: DampingRatio | None = Field(
        None, description="instead of damping: fraction of critical, of the mass that the restraint holds"
    )
    law: RestraintLaw = Field("threshold", description="when spring and damper act")

    def complete(self) -> None:
        """Fill in what was left out."""
        if self.damping is None and self.damping_ratio is None:
            self._fill(damping=0.0)

    def coefficient(self, mass: Number) -> Number:
        """Damper coefficient [N s/m] for a mass [kg]: `c = 2 xi sqrt(k m)` where given as a ratio (eq. 29)."""
        if self.damping_ratio is None:
            assert self.damping is not None
            return self.damping
        root: Number = (self.stiffness * mass) ** 0.5
        return 2.0 * self.damping_ratio * root

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        both = self.damping is not None and self.damping_ratio is not None
        yield exclusive("damping", "damping_ratio", given=both, fix="Give the coefficient or the fraction of critical.")


class Seat(Model):
    """A child's seat: its own mass, and how it is held to the vehicle (eqs 11-12)."""

    mass: Mass = Field(description="mass of the seat")
    restraint: Restraint = Field(description="between seat and vehicle; a damping ratio uses the seat's own mass")


class Occupant(Model):
    """Someone in a vehicle, moving with it before contact."""

    name: Name = Field("", validate_default=False, description="made from the kind if left out")
    kind: Literal["adult", "child"] = Field(description='"adult" or "child"')
    vehicle: Annotated[Literal[1, 2], BeforeValidator(_no_truth_value)] = Field(1, description="number of the vehicle")
    mass: Mass = Field(description="mass of the occupant")
    coupled: StrictBool = Field(default=False, description="whether the restraint pushes back on the vehicle")
    restraint: Restraint = Field(description="adult to vehicle, or child to seat")
    seat: Seat | None = Field(None, description="the child's seat")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        child = self.kind == "child"
        seated = self.seat is not None
        yield Check("seat", seated or not child, "nothing", "a seat for a child", "Add its mass and restraint.")
        yield Check("seat", child or not seated, "a seat for an adult", "none", 'Take it out, or set kind = "child".')
