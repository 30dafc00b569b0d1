"""The ten numbers that the paper prints in section 4, beside ours."""

from __future__ import annotations

from dataclasses import dataclass

from ridedown.paper import cases
from ridedown.paper.cases import Case, G, Responses

DISPLACEMENT = "relative displacement, m"
ACCELERATION = "peak acceleration, g"
ROUNDING = {DISPLACEMENT: 0.005, ACCELERATION: 0.5}
"""Half a unit of the last printed digit."""


@dataclass(frozen=True, slots=True)
class Printed:
    """A number in the paper: where it stands, what it is, and the channel whose peak it is."""

    figure: int
    case: Case
    quantity: str
    value: float
    channel: str


@dataclass(frozen=True, slots=True)
class Headline:
    """A number of the paper beside ours."""

    figure: int
    case: str
    quantity: str
    paper: float
    ours: float

    @property
    def error(self) -> float:
        """Ours over the paper's, less one."""
        return self.ours / self.paper - 1.0

    @property
    def rounds_to_print(self) -> bool:
        """Whether ours, rounded as the paper rounds, is what the paper prints."""
        return abs(self.ours - self.paper) <= ROUNDING[self.quantity]

    def to_dict(self) -> dict[str, object]:
        """Ready for JSON."""
        return {
            "figure": self.figure,
            "case": self.case,
            "quantity": self.quantity,
            "paper": self.paper,
            "ours": self.ours,
            "error": self.error,
        }


PRINTED = (
    Printed(8, cases.ADULT_FULL, DISPLACEMENT, 0.27, "adult.relative_displacement"),
    Printed(10, cases.ADULT_FULL, ACCELERATION, 40.0, "adult.acceleration"),
    Printed(8, cases.ADULT_OFFSET, DISPLACEMENT, 0.22, "adult.relative_displacement"),
    Printed(10, cases.ADULT_OFFSET, ACCELERATION, 30.0, "adult.acceleration"),
    Printed(13, cases.DAMPING[0], ACCELERATION, 50.0, "adult.acceleration"),
    Printed(16, cases.STIFFNESS[0], ACCELERATION, 30.0, "adult.acceleration"),
    # "relative" is to the seat: relative to the vehicle the child would move about 0.35 m
    Printed(17, cases.CHILD_FULL, DISPLACEMENT, 0.18, "child.relative_displacement"),
    Printed(19, cases.CHILD_FULL, ACCELERATION, 47.0, "child.acceleration"),
    Printed(17, cases.CHILD_OFFSET, DISPLACEMENT, 0.14, "child.relative_displacement"),
    Printed(19, cases.CHILD_OFFSET, ACCELERATION, 36.0, "child.acceleration"),
)


def headlines(responses: Responses) -> tuple[Headline, ...]:
    """The ten numbers, from the responses of `cases.run()`."""
    return tuple(Headline(p.figure, p.case.title, p.quantity, p.value, _ours(p, responses)) for p in PRINTED)


def _ours(printed: Printed, responses: Responses) -> float:
    peak = abs(responses[printed.case.scenario].peak(printed.channel).value)
    return peak / G if printed.quantity == ACCELERATION else peak
