"""Network scenarios: masses and elements written directly, for published models that are not of the paper's form."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from ridedown.scenario.base import Check, Model, Name, unused
from ridedown.scenario.member import ForceDeflection
from ridedown.scenario.model import Description, distinct
from ridedown.scenario.quantities import Damping, Mass, Slack, Stiffness, Velocity

WALL = "wall"


class PointMass(Model):
    """A mass that moves along one line; forward, towards the wall, is positive."""

    name: Name = Field(description='a name such as "m1"')
    mass: Mass
    speed: Velocity = Field(0.0, description="initial speed")


class Tie(Model):
    """A spring and a damper in parallel between two bodies. Its deflection is `x_second - x_first`."""

    name: Name = Field("", validate_default=False, description="first-second if left out")
    between: tuple[str, str] = Field(description='two bodies, such as ["wall", "m1"]')
    law: Literal["linear", "kelvin-voigt", "threshold"] = Field("linear", description="linear acts both ways")
    stiffness: Stiffness
    damping: Damping = 0.0
    slack: Slack = 0.0


class Crush(ForceDeflection):
    """A crushing element with a force-deflection curve between two bodies. Its deflection is `x_second - x_first`."""

    name: Name = Field("", validate_default=False, description="first-second if left out")
    between: tuple[str, str] = Field(description='two bodies, such as ["wall", "m1"]')
    law: Literal["curve"] = "curve"


def _which(element: Any) -> str:
    if isinstance(element, Tie | Crush):
        return f"({type(element).__name__.lower()})"
    if not isinstance(element, dict):
        return "(tie)"
    curved = "law" not in element and ("pieces" in element or "points" in element)
    return "(crush)" if curved or element.get("law") == "curve" else "(tie)"


Element = Annotated[
    Annotated[Tie, Tag("(tie)")] | Annotated[Crush, Tag("(crush)")],
    Discriminator(_which),
]


class NetworkScenario(Description):
    """Masses and the elements between them and a rigid wall ahead; all undeformed at time 0. Numbers are SI.

    >>> NetworkScenario(
    ...     masses=[{"name": "m1", "mass": "800 kg", "speed": "14 m/s"}],
    ...     elements=[{"between": ["wall", "m1"], "stiffness": "1 kN/m", "damping": "10 kN s/m"}],
    ... ).elements[0].name
    'wall-m1'
    """

    masses: tuple[PointMass, ...] = Field(description="the bodies")
    elements: tuple[Element, ...] = Field(description="what acts between them")

    def complete(self) -> None:
        """Fill in what was left out."""
        taken = {body.name for body in self.masses} | {element.name for element in self.elements}
        named = []
        for element in self.elements:
            name = element.name or unused("-".join(element.between), taken)
            taken.add(name)
            named.append(element.model_copy(update={"name": name}))
        self._fill(elements=tuple(named))

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        for field in ("masses", "elements"):
            yield Check(field, bool(getattr(self, field)), "an empty list", "at least one entry")
        bodies = [body.name for body in self.masses]
        yield from distinct("masses", bodies)
        yield from distinct("elements", [element.name for element in self.elements], taken=tuple(bodies))
        known = {WALL, *bodies}
        for i, element in enumerate(self.elements):
            for j, body in enumerate(element.between):
                yield Check(
                    f"elements.{i}.between.{j}",
                    body in known,
                    f'"{body}"',
                    f"one of {', '.join([WALL, *bodies])}",
                )
            first, second = element.between
            yield Check(
                f"elements.{i}.between",
                first != second,
                f'"{first}" twice',
                "two different bodies",
                "Change one of them.",
            )
