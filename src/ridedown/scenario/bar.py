"""The bumper bar: both vehicles' bumpers, moving as one rigid body between the four members."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Literal

from pydantic import Field

from ridedown.scenario.base import Check, Model, exclusive
from ridedown.scenario.quantities import Arm, Distance, Inertia, Mass, Number, Offset, Overlap, Velocity

LeverArm = Literal["work-conjugate", "printed"]


class Arms(Model):
    """Where the members press on the bar, counted from its middle."""

    l1: Arm = Field(description="vehicle 1, left member")
    l2: Arm = Field(description="vehicle 1, right member")
    l3: Arm = Field(description="vehicle 2, right member")
    l4: Arm = Field(description="vehicle 2, left member")


class Bar(Model):
    """The bar's mass, moment of inertia and arms.

    With a rail spacing `w` and half the lateral offset `c`, `l2 = l3 = w/2 + c` and `l1 = l4 = w/2 - c`. The paper
    prints the moment with bare arms (eq. 4) against deflections with `tan(theta)` (eqs 7-8): `printed`;
    `work-conjugate` takes the arms that those deflections imply, and conserves energy.
    """

    alternatives: ClassVar[dict[str, str]] = {"lateral_offset": "overlap", "overlap": "lateral_offset"}

    mass: Mass = Field(description="mass of both bumpers")
    inertia: Inertia | None = Field(None, description="about the middle; leave out for a bar that cannot turn")
    rail_spacing: Distance | None = Field(None, description="distance between a vehicle's right and left members")
    lateral_offset: Offset | None = Field(None, description="sideways shift of the vehicles; 0 is full overlap")
    overlap: Overlap | None = Field(None, description="instead of lateral_offset: overlapping part of the width")
    width: Distance | None = Field(None, description="vehicle width that the overlap is a fraction of")
    arms: Arms | None = Field(None, description="instead of rail_spacing: the four arms")
    lever_arm: LeverArm = Field("work-conjugate", description="lever arm law")
    speed: Velocity | None = Field(
        None, description="initial speed along vehicle 1's forward direction; (speed1 - speed2)/2 if left out"
    )

    def complete(self) -> None:
        """Fill in what was left out."""
        if self.rail_spacing is not None and self.lateral_offset is None and self.overlap is None:
            self._fill(lateral_offset=0.0)

    def lengths(self) -> tuple[Number, Number, Number, Number]:
        """The arms l1, l2, l3, l4 [m]."""
        if self.arms is not None:
            return self.arms.l1, self.arms.l2, self.arms.l3, self.arms.l4
        half_offset: Number = 0.0
        if self.overlap is None:
            assert self.lateral_offset is not None
            half_offset = self.lateral_offset / 2
        elif self.width is not None:
            half_offset = (1.0 - self.overlap) * self.width / 2
        assert self.rail_spacing is not None
        half = self.rail_spacing / 2
        return half - half_offset, half + half_offset, half + half_offset, half - half_offset

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check(
            "rail_spacing",
            self.rail_spacing is not None or self.arms is not None,
            "nothing",
            "rail_spacing, or the four arms",
            "Give the distance between a vehicle's members, about 1.1 m in a car.",
        )
        for field in ("rail_spacing", "lateral_offset", "overlap", "width"):
            given = self.arms is not None and getattr(self, field) is not None
            yield exclusive("arms", field, given=given, fix="Explicit arms need no other geometry.")
        yield exclusive(
            "lateral_offset",
            "overlap",
            given=self.lateral_offset is not None and self.overlap is not None,
            fix="Give the shift in metres or the overlap as a fraction.",
        )
        if self.overlap is not None and self.width is None:
            yield Check(
                "width",
                self.overlap == 1.0,
                "nothing",
                "the vehicle width that the overlap is a fraction of",
                'Add it, about "1.8 m" in a car, or give lateral_offset instead.',
            )
        l1, l2, l3, l4 = self.lengths()
        if self.inertia is None:
            yield Check(
                "inertia",
                (l1 == l2) & (l2 == l3) & (l3 == l4),
                "nothing with unequal arms",
                "the bar's moment of inertia",
                'Give it, such as "157 kg m2": an offset crash turns the bar.',
            )
