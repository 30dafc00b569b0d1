"""Occupants and what restrains them: an adult in a belt, a child in a seat of its own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field, StrictBool

from ridedown.scenario.base import Check, Model, Name, exclusive, unused
from ridedown.scenario.quantities import Damping, DampingRatio, Mass, Number, Refused, Slack, Stiffness
from ridedown.scenario.restraints import AnyRestraint, damper

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
        return damper(self.damping, self.damping_ratio, self.stiffness, mass)

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        both = self.damping is not None and self.damping_ratio is not None
        yield exclusive("damping", "damping_ratio", given=both, fix="Give the coefficient or the fraction of critical.")


class Seat(Model):
    """A child's seat: its own mass, and how it is held to the vehicle (eqs 11-12)."""

    mass: Mass = Field(description="mass of the seat")
    restraint: Restraint | None = Field(None, description="between seat and vehicle; a damping ratio uses the seat's own mass")
    restraints: tuple[AnyRestraint, ...] = Field((), description="instead of restraint: belts and surfaces, side by side")

    def complete(self) -> None:
        """Fill in what was left out."""
        self._fill(restraints=named(self.restraints, set(type(self).model_fields)))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield from _held_once(self.restraint, self.restraints)
        yield from _apart(type(self), [("restraints", one.name) for one in self.restraints])
        for i, one in enumerate(self.restraints):
            yield _on_none(i, one)


class Body(Model):
    """One mass of an occupant."""

    name: Name = Field(description='"pelvis", "chest" and "head" are judged as such; or a name of your own')
    mass: Mass


class Joint(Model):
    """A spring and a damper between two bodies of an occupant, both ways, at ease where all begin."""

    name: Name = Field("", validate_default=False, description="first-second if left out")
    between: tuple[str, str] = Field(description='two bodies, such as ["pelvis", "chest"]')
    stiffness: Stiffness
    damping: Damping = 0.0


class Occupant(Model):
    """Someone in a vehicle, moving with it before contact: one mass, or two or three that are joined."""

    name: Name = Field("", validate_default=False, description="made from the kind if left out")
    kind: Literal["adult", "child"] = Field(description='"adult" or "child"')
    vehicle: Annotated[Literal[1, 2], BeforeValidator(_no_truth_value)] = Field(1, description="number of the vehicle")
    mass: Mass | None = Field(None, description="mass of the occupant; with bodies, left out")
    coupled: StrictBool = Field(default=False, description="whether the restraint pushes back on the vehicle")
    restraint: Restraint | None = Field(None, description="adult to vehicle, or child to seat")
    restraints: tuple[AnyRestraint, ...] = Field(
        (), description="instead of restraint: belts, airbags and surfaces, side by side"
    )
    bodies: tuple[Body, ...] = Field((), description="instead of mass: two or three masses")
    joints: tuple[Joint, ...] = Field((), description="springs and dampers between the bodies")
    seat: Seat | None = Field(None, description="the child's seat")

    @property
    def whole_mass(self) -> Number:
        """Mass of the occupant, of all its bodies [kg]."""
        if self.mass is not None:
            return self.mass
        total: Number = sum((body.mass for body in self.bodies[1:]), self.bodies[0].mass)
        return total

    @property
    def mass_names(self) -> tuple[str, ...]:
        """What its masses are called in channels: its own name, or that of each body."""
        return tuple(f"{self.name}.{body.name}" for body in self.bodies) or (self.name,)

    def held_by(self) -> Iterator[tuple[str, Restraint | AnyRestraint]]:
        """What holds it, and its seat: each with the name of its element."""
        for name, part in ((self.name, self), (f"{self.name}.seat", self.seat)):
            if part is not None and part.restraint is not None:
                yield f"{name}.restraint", part.restraint
            for one in () if part is None else part.restraints:
                yield f"{name}.{one.name}", one

    def complete(self) -> None:
        """Fill in what was left out."""
        taken = set(type(self).model_fields) | {body.name for body in self.bodies}
        restraints = named(self.restraints, taken)
        taken |= {one.name for one in (*restraints, *self.joints)}
        joints = []
        for joint in self.joints:
            name = joint.name or unused("-".join(joint.between), taken)
            taken.add(name)
            joints.append(joint.model_copy(update={"name": name}))
        self._fill(restraints=restraints, joints=tuple(joints))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        child = self.kind == "child"
        seated = self.seat is not None
        yield Check("seat", seated or not child, "nothing", "a seat for a child", "Add its mass and restraint.")
        yield Check("seat", child or not seated, "a seat for an adult", "none", 'Take it out, or set kind = "child".')
        yield from _held_once(self.restraint, self.restraints)
        lists = (("bodies", self.bodies), ("restraints", self.restraints), ("joints", self.joints))
        yield from _apart(type(self), [(field, one.name) for field, many in lists for one in many])
        yield from self._masses()
        yield from self._joined()

    def _masses(self) -> Iterator[Check]:
        several = bool(self.bodies)
        fix = "Give the mass of the whole, or of each body."
        yield exclusive("bodies", "mass", given=several and self.mass is not None, fix=fix)
        yield Check("mass", several or self.mass is not None, "nothing", 'a mass such as "80 kg"', fix)
        yield Check(
            "bodies",
            len(self.bodies) in {0, 2, 3},
            f"a list of {len(self.bodies)}",
            "two or three bodies",
            "For a single one give mass.",
        )
        yield Check(
            "restraint",
            not several or self.restraint is None,
            "one restraint for several bodies",
            "restraints, each with the body that it acts on",
            'Write restraints = [{ kind = "belt", on = "chest", ... }].',
        )
        yield Check("joints", several or not self.joints, "joints without bodies", "none", "Add bodies, or take them out.")

    def _joined(self) -> Iterator[Check]:
        """Every restraint and joint acts on bodies that there are, and every body is held."""
        bodies = [body.name for body in self.bodies]
        if not bodies:
            for i, one in enumerate(self.restraints):
                yield _on_none(i, one)
            return
        known = f"one of {', '.join(bodies)}"
        for i, one in enumerate(self.restraints):
            shown = "nothing" if one.on is None else f'"{one.on}"'
            yield Check(f"restraints.{i}.on", one.on in bodies, shown, known, "Say which body it acts on.")
        for i, joint in enumerate(self.joints):
            first, second = joint.between
            for j, body in enumerate(joint.between):
                yield Check(f"joints.{i}.between.{j}", body in bodies, f'"{body}"', known)
            yield Check(f"joints.{i}.between", first != second, f'"{first}" twice', "two different bodies")
        held = {one.on for one in self.restraints}
        for _ in bodies:
            held |= {body for joint in self.joints if held & set(joint.between) for body in joint.between}
        for i, body in enumerate(bodies):
            fix = "Join it to another body, or let a restraint act on it."
            yield Check(f"bodies.{i}", body in held, f'"{body}", held by nothing', "a joint or a restraint", fix)


def named(restraints: tuple[AnyRestraint, ...], taken: set[str]) -> tuple[AnyRestraint, ...]:
    """The restraints, those without a name named after their kind."""
    taken = taken | {one.name for one in restraints}
    found = []
    for one in restraints:
        name = one.name or unused(one.kind, taken)
        taken.add(name)
        found.append(one.model_copy(update={"name": name}))
    return tuple(found)


def _held_once(restraint: Restraint | None, restraints: tuple[AnyRestraint, ...]) -> Iterator[Check]:
    given = restraint is not None and bool(restraints)
    yield exclusive("restraint", "restraints", given=given, fix="The one lumps what the others are.")
    held = restraint is not None or bool(restraints)
    yield Check("restraint", held, "nothing", "a table restraint, or a list of restraints", "Nothing else holds it.")


def _apart(owner: type[Model], names: list[tuple[str, str]]) -> Iterator[Check]:
    """The rule that what an occupant is made of has names of its own, which are no fields either: paths would be ambiguous."""
    seen: set[str] = set()
    place: dict[str, int] = {}
    for field, name in names:
        i = place.get(field, 0)
        place[field] = i + 1
        where = f"{field}.{i}.name"
        yield Check(where, name not in owner.model_fields, f'"{name}", the name of a field', "another name", "Rename it.")
        yield Check(where, name not in seen, f'"{name}" a second time', "a name of its own", "Rename one of them.")
        seen.add(name)


def _on_none(i: int, one: AnyRestraint) -> Check:
    return Check(
        f"restraints.{i}.on",
        one.on is None,
        f'"{one.on}", but there is a single mass',
        "none",
        "Take it out, or give bodies.",
    )
