"""Vehicles: a mass on two longitudinal members."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import Field

from ridedown.scenario.base import NOT_YET, Check, Model, exclusive, without_default
from ridedown.scenario.member import Member
from ridedown.scenario.quantities import Mass, Speed


class Vehicle(Model):
    """One vehicle, moving along its own forward direction, with a right and a left member at its front.

    Files may give `members` once for both; built, `right` and `left` always hold them and `members` is None.
    """

    mass: Mass = Field(description="mass of the vehicle without the occupants")
    speed: Speed = Field(description="initial speed along its own forward direction")
    members: Member | None = Field(None, repr=False, description="both members, where they are alike")
    right: Member = Field(NOT_YET, json_schema_extra=without_default, description="right member")
    left: Member = Field(NOT_YET, json_schema_extra=without_default, description="left member")

    def complete(self) -> None:
        """Take `members` for both sides, and let one object stand for two that are alike."""
        given = self._given()
        if given == {"members"}:
            self._fill(right=self.members, left=self.members, members=None)
        elif given == {"right", "left"} and self.right == self.left:
            self._fill(left=self.right)

    @property
    def alike(self) -> bool:
        """Whether both members are one and the same description."""
        return self.right is self.left

    def checks(self) -> Iterator[Check]:
        """Both sides given, once."""
        given = self._given()
        fix = "Give `members` for two alike, or `right` and `left`."
        side = next((side for side in ("right", "left") if side in given), "right")
        yield exclusive("members", side, given="members" in given, fix=fix)
        yield Check("members", bool(given), "nothing", "a table of the longitudinal members", fix)
        other = "left" if side == "right" else "right"
        yield Check(other, other in given, "nothing", f"the {other} member as well as the {side}", fix)

    def _given(self) -> set[str]:
        return {field for field in ("members", "right", "left") if getattr(self, field) is not None}
