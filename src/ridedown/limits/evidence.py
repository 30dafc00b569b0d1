"""What a criterion is judged from: channels by their meaning, whether a laboratory measured them or a simulation made them.

A criterion asks an `Evidence` for the head of an occupant or the pulse of a vehicle. It gets signals in SI, filtered as SAE
J211 says for that place, with the names of the channels used and what there is to say about them; or it hears why not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from ridedown.criteria.checks import Floats
from ridedown.signals.record import OfficialResult, TestRecord

if TYPE_CHECKING:
    from ridedown.response import Response


class CannotJudge(Exception):
    """A criterion cannot be computed from this evidence; the message says why. Never leaves this package."""


@dataclass(frozen=True, slots=True)
class Measure:
    """A place and what is measured there, along which axes, and the channel frequency class for it."""

    location: str
    quantity: str
    axes: tuple[str, ...]
    frequency_class: int


MEASURES: Mapping[str, Measure] = {
    "head": Measure("head", "acceleration", ("x", "y", "z"), 1000),
    "chest": Measure("chest", "acceleration", ("x", "y", "z"), 180),
    "chest deflection": Measure("chest", "displacement", ("x",), 600),
    "chest deflection, class 180": Measure("chest", "displacement", ("x",), 180),
    "neck axial force": Measure("neck_upper", "force", ("z",), 600),
    "neck shear force": Measure("neck_upper", "force", ("x",), 600),
    "neck moment": Measure("neck_upper", "moment", ("y",), 600),
    "left femur": Measure("femur_left", "force", ("z",), 600),
    "right femur": Measure("femur_right", "force", ("z",), 600),
}
"""What occupants are judged by. Classes: SAE J211-1, table of channel classes (head 1000, spine 180, femur and chest deflection
600); 600 for the neck as FMVSS 208 S6.6 has it for Nij; 180 for the deflection of the viscous criterion as UN R94 has it."""


@dataclass(frozen=True, slots=True)
class Person:
    """An occupant: what it is called (its seat, or its name in a simulation), which dummy (empty if none), and where.

    simulated: not a dummy but masses on springs. lumped: a simulated one of one mass: no head, no neck, no legs, and the chest
    is the whole of it. None: not known.
    """

    name: str
    vehicle: str
    dummy: str = ""
    child: bool | None = None
    lumped: bool = False
    simulated: bool = False
    official: Mapping[str, OfficialResult] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Signals:
    """Channels that belong together: times (n,) [s], values (k, n) in SI, the names of those used, and remarks."""

    time: Floats
    values: Floats
    used: tuple[str, ...]
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Pulse:
    """A vehicle's motion: times (n,) [s], acceleration in x for peaks (class 60) and to integrate (class 180) [m/s2], (n,).

    used, rejected: the channels the pulse was made of, and those that were left out, each with the reason.
    """

    time: Floats
    shape: Floats
    acceleration: Floats
    used: tuple[str, ...]
    rejected: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


class Evidence(Protocol):
    """Channels by meaning. The methods raise CannotJudge, with the reason, for what is not there or not fit to judge by."""

    title: str
    simulated: bool
    people: tuple[Person, ...]
    vehicles: tuple[str, ...]

    def signals(self, person: Person, measure: str) -> Signals:
        """The channels of one of MEASURES on an occupant."""
        ...

    def pulse(self, vehicle: str) -> Pulse:
        """The motion of a vehicle's occupant compartment along x."""
        ...

    def across(self, vehicle: str, what: str) -> Signals:
        """`lateral` or `vertical` acceleration, or `yaw rate`, of a vehicle, (1, n)."""
        ...

    def speed(self, vehicle: str) -> float:
        """A vehicle's speed at contact [m/s]."""
        ...

    def crush(self, vehicle: str) -> tuple[float, float] | None:
        """Dynamic crush [m] and its time [s] where the evidence knows it; None where it has to be integrated from the pulse."""
        ...


def evidence(source: TestRecord | Response | Evidence) -> Evidence:
    """The evidence in a test record or in a simulated response.

    Raises: TypeError for anything else.
    """
    if isinstance(source, TestRecord):
        from ridedown.limits.measured import RecordEvidence  # noqa: PLC0415  builds on this file

        return RecordEvidence(source)
    from ridedown.response import Response  # noqa: PLC0415  heavy, and a record needs none of it

    if isinstance(source, Response):
        from ridedown.limits.simulated import ResponseEvidence  # noqa: PLC0415

        return ResponseEvidence(source)
    if all(hasattr(source, name) for name in ("people", "vehicles", "signals", "pulse")):
        return source
    raise TypeError(f"source: got {type(source).__name__}; need a TestRecord or a Response.")
