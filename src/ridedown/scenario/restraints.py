"""Restraints as they are built: a belt on its reel, an airbag that fills, and the surfaces that an occupant meets.

Each has a force that grows with its elongation or penetration in linear pieces, from zero. They act side by side.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, get_args

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag

from ridedown.scenario.base import Check, Model, Name, exclusive, of_known_kind
from ridedown.scenario.member import ForceCurve
from ridedown.scenario.quantities import (
    Damping,
    DampingRatio,
    Distance,
    Gap,
    Instant,
    Number,
    Pull,
    Slack,
    Span,
    Stiffness,
)

Surface = Literal["knee_bolster", "dashboard", "wheel", "seat_back"]

_NO_JUMP = "Begin the curve at zero: an occupant could rest on a jump. A steep first piece does as well."


class Hold(ForceCurve):
    """What every restraint is: a force against elongation or penetration, from zero, on one mass of an occupant."""

    name: Name = Field("", validate_default=False, description="what its channels are called; made from the kind if left out")
    on: Name | None = Field(None, description="which of the occupant's bodies it acts on, where there are several")
    stiffness: Stiffness | None = Field(None, description="slope of a force that grows evenly; or pieces, or points")

    def curve(self) -> tuple[tuple[Number, ...], tuple[Number, ...], tuple[Number, ...]]:
        """Where each piece starts [m], the force there [N] and its slope [N/m]."""
        return super().curve() if self.stiffness is None else ((0.0,), (0.0,), (self.stiffness,))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from super().checks()
        if self.points is not None:
            yield Check("points.0.1", self.points[0][1] == 0.0, self.points[0][1], "0 N at deflection 0 m", _NO_JUMP, "N")

    def _given(self) -> Iterator[Check]:
        for field in ("pieces", "points"):
            both = self.stiffness is not None and getattr(self, field) is not None
            yield exclusive("stiffness", field, given=both, fix="Give the curve once.")
        if self.stiffness is None:
            given = self.pieces if self.points is None else self.points
            yield Check(
                "stiffness" if given is None else "pieces" if self.points is None else "points",
                bool(given),
                "nothing" if given is None else "an empty list",
                "a stiffness, pieces or points",
                'For a force that grows evenly write stiffness = "60 kN/m".',
            )


class Damped(Hold):
    """A restraint with a damper, given as a coefficient or as a fraction of critical."""

    alternatives: ClassVar[dict[str, str]] = {"damping": "damping_ratio", "damping_ratio": "damping"}

    damping: Damping | None = Field(None, description="damper coefficient; 0 if neither it nor the ratio is given")
    damping_ratio: DampingRatio | None = Field(
        None, description="instead of damping: fraction of critical, of the first piece and the mass that it acts on"
    )

    def complete(self) -> None:
        """Fill in what was left out."""
        if self.damping is None and self.damping_ratio is None:
            self._fill(damping=0.0)

    def coefficient(self, mass: Number) -> Number:
        """Damper coefficient [N s/m] on a mass [kg]."""
        return damper(self.damping, self.damping_ratio, self.curve()[2][0], mass)

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from super().checks()
        both = self.damping is not None and self.damping_ratio is not None
        yield exclusive("damping", "damping_ratio", given=both, fix="Give the coefficient or the fraction of critical.")
        if self.damping_ratio is not None:
            yield Check(
                "damping_ratio",
                self.curve()[2][0] > 0.0,
                "a fraction of critical with a curve that begins flat",
                "a first piece that rises",
                "Give the coefficient as damping.",
            )


def damper(coefficient: Number | None, ratio: Number | None, stiffness: Number, mass: Number) -> Number:
    """Damper coefficient [N s/m]: as given, or `c = 2 xi sqrt(k m)` of a ratio (eq. 29)."""
    if ratio is None:
        assert coefficient is not None
        return coefficient
    root: Number = (stiffness * mass) ** 0.5
    return 2.0 * ratio * root


class Pretensioner(Model):
    """Takes belt in at an even rate from the time it fires, as long as the force stays below that at which it stalls."""

    fire_time: Instant = Field(description="when it fires")
    pull_in: Distance = Field(description="length of belt that it takes in, where it does not stall")
    duration: Span = Field(description="time to take it in")
    stall_force: Pull | None = Field(None, description="belt force at which it stalls; none if left out")


class LoadLimiter(Model):
    """Lets belt out at a force, for good: one stage or two, to a largest payout and then a hard stop."""

    force: Pull = Field(description="belt force at which it gives, in its first stage")
    second_force: Pull | None = Field(None, description="belt force of the second stage, if it has one")
    switch_payout: Distance | None = Field(None, description="payout at which the second stage begins")
    switch_time: Instant | None = Field(None, description="instead of switch_payout: when the second stage begins")
    max_payout: Distance | None = Field(None, description="payout in all, then it stops for good; no end if left out")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        by_length, by_time = self.switch_payout is not None, self.switch_time is not None
        two_stages = self.second_force is not None
        yield exclusive(
            "switch_payout",
            "switch_time",
            given=by_length and by_time,
            fix="The second stage begins at a payout or at a time.",
        )
        yield Check(
            "second_force",
            by_length or by_time or not two_stages,
            "a second stage that nothing switches to",
            "switch_payout or switch_time",
            "Say when it begins, or leave second_force out.",
        )
        yield Check(
            "switch_payout" if by_length else "switch_time",
            two_stages or not (by_length or by_time),
            "a switch without a second stage",
            "second_force",
            "Give the force of the second stage, or leave the switch out.",
        )
        if self.max_payout is not None and self.switch_payout is not None:
            yield Check(
                "max_payout",
                self.max_payout > self.switch_payout,
                self.max_payout,
                "more than switch_payout",
                "The second stage begins before the hard stop.",
                "m",
            )

    def forces(self) -> tuple[tuple[str, Number], ...]:
        """The force of each stage [N], with its field."""
        first = ("force", self.force)
        return (first,) if self.second_force is None else (first, ("second_force", self.second_force))


class Belt(Damped):
    """A belt on its reel: webbing, retractor, pretensioners, load limiter."""

    kind: Literal["belt"]
    slack: Slack = Field(0.0, description="belt to be taken up before it pulls")
    lock_time: Instant | None = Field(None, description="when the retractor locks; before, it gives freely. Locked if left out")
    pretensioners: tuple[Pretensioner, ...] = Field((), description="none, one or two")
    load_limiter: LoadLimiter | None = Field(None, description="lets belt out at a force")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from super().checks()
        count = len(self.pretensioners)
        yield Check("pretensioners", count <= 2, f"a list of {count}", "at most two", "Join those that fire together.")
        for i, one in enumerate(self.pretensioners):
            if self.lock_time is not None:
                yield Check(
                    f"pretensioners.{i}.fire_time",
                    one.fire_time >= self.lock_time,
                    one.fire_time,
                    "lock_time or later",
                    "A reel that is still free gives back what is pulled in.",
                    "s",
                )
            yield from self._stalls_first(one, i)
        yield from self._rises()

    def _stalls_first(self, one: Pretensioner, i: int) -> Iterator[Check]:
        """A pretensioner that could outpull the limiter would let out what it takes in."""
        if self.load_limiter is None:
            return
        stall = one.stall_force
        yield Check(
            f"pretensioners.{i}.stall_force",
            stall is not None,
            "nothing, with a load limiter",
            "a stall force below that of the load limiter",
            "The limiter would let out what the pretensioner takes in.",
        )
        assert stall is not None
        for field, force in self.load_limiter.forces():
            yield Check(
                f"load_limiter.{field}",
                force > stall,
                force,
                f"more than pretensioners.{i}.stall_force",
                "The limiter would let out what the pretensioner takes in.",
                "N",
            )

    def _rises(self) -> Iterator[Check]:
        """At a limiter's or a stall force the elongation follows from the force: there the curve has to rise."""
        limiter = self.load_limiter
        forces = [] if limiter is None else [force for _, force in limiter.forces()]
        forces += [one.stall_force for one in self.pretensioners if one.stall_force is not None]
        _, starts, slopes = self.curve()
        for i, (start, slope) in enumerate(zip(starts, slopes, strict=True)):
            flat = np.asarray(slope) <= 0.0
            field = f"pieces.{i}.stiffness" if self.points is None else f"points.{min(i + 1, len(starts) - 1)}.1"
            for force in forces:
                yield Check(
                    "stiffness" if self.stiffness is not None else field,
                    ~(flat & (np.asarray(start) <= force)),
                    "webbing that does not grow tighter",
                    "a force that rises up to that of the load limiter and of every stall",
                    "Let the curve rise, or carry it on with one more piece.",
                )


class Airbag(Hold):
    """A bag that fills with time: its force is the fill times that of the full bag, and it never pulls."""

    kind: Literal["airbag"]
    fire_time: Instant = Field(description="when it fires")
    fill_time: Span = Field(description="time to fill, from then; the fill grows evenly")
    gap: Gap = Field(0.0, description="distance before the full bag is touched")
    venting: Damping = Field(0.0, description="what its vents add, as a damper coefficient of the full bag")

    def coefficient(self, mass: Number) -> Number:  # noqa: ARG002  as the other restraints have it
        """Damper coefficient of the full bag [N s/m]."""
        return self.venting


class Contact(Damped):
    """A surface inside the car. A seat back is met moving rearwards, the others moving forwards."""

    kind: Surface
    gap: Gap = Field(0.0, description="distance before it is touched")

    @property
    def direction(self) -> float:
        """+1 where it is met moving forwards, -1 rearwards."""
        return -1.0 if self.kind == "seat_back" else 1.0


KINDS = ("belt", "airbag", *get_args(Surface))


def _which(restraint: Any) -> str:
    kind = restraint.get("kind") if isinstance(restraint, dict) else getattr(restraint, "kind", None)
    return f"({kind})" if kind in {"belt", "airbag"} else "(contact)"


def _of_a_known_kind(restraint: object) -> object:
    return of_known_kind(restraint, Model, KINDS, "a table with the kind of restraint")


AnyRestraint = Annotated[
    Annotated[Belt, Tag("(belt)")] | Annotated[Airbag, Tag("(airbag)")] | Annotated[Contact, Tag("(contact)")],
    Discriminator(_which),
    BeforeValidator(_of_a_known_kind),
]
