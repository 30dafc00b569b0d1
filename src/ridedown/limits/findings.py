"""Each criterion that a regulation may ask for, computed from evidence: its value, when, from which channels, how far to trust.

One function a criterion, by its key in CRITERIA. Values are in SI; a criterion's field unit is how it is printed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ridedown import criteria, units
from ridedown.criteria import chest, legs, neck, roadside
from ridedown.criteria.checks import Floats
from ridedown.limits.evidence import CannotJudge, Evidence, Person, Pulse, Signals


@dataclass(frozen=True, slots=True)
class Finding:
    """A criterion's value in SI, its time or interval [s] where it has one, the channels used, and remarks.

    at_least: the value can only be larger than this, because an axis was not measured: it can fail a limit, not pass it.
    indicator: of a body that the criterion is not defined for; shown, and judged by nobody.
    """

    value: float
    start: float | None = None
    end: float | None = None
    used: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    at_least: bool = False
    indicator: bool = False


@dataclass(frozen=True, slots=True)
class Criterion:
    """What a criterion is called, and the unit that the field prints it in."""

    label: str
    unit: str


CRITERIA: Mapping[str, Criterion] = {
    "hic15": Criterion("HIC15", ""),
    "hic36": Criterion("HIC36", ""),
    "head_3ms": Criterion("head acceleration, 3 ms", "g"),
    "chest_3ms": Criterion("chest acceleration, 3 ms", "g"),
    "chest_peak": Criterion("chest acceleration, peak", "g"),
    "chest_deflection": Criterion("chest deflection", "mm"),
    "viscous_criterion": Criterion("viscous criterion", "m/s"),
    "nij": Criterion("Nij", ""),
    "neck_tension": Criterion("neck tension", "N"),
    "neck_compression": Criterion("neck compression", "N"),
    "femur_left": Criterion("left femur compression", "N"),
    "femur_right": Criterion("right femur compression", "N"),
    "olc": Criterion("OLC", "g"),
    "asi": Criterion("ASI (2010)", ""),
    "asi_1998": Criterion("ASI (1998)", ""),
    "thiv": Criterion("THIV", "km/h"),
    "phd": Criterion("PHD", "g"),
    "occupant_impact_velocity": Criterion("occupant impact velocity", "m/s"),
    "ridedown_acceleration": Criterion("occupant ridedown acceleration", "g"),
}


def in_field(value: float, unit: str) -> float:
    """A number of SI in a unit of CRITERIA."""
    return float(units.convert([value], units.dimension(unit).unit, unit)[0]) if unit else value


# occupants


def _resultant(signals: Signals) -> Floats:
    length: Floats = np.sqrt((signals.values**2).sum(axis=0)) if signals.values.shape[0] > 1 else signals.values[0]
    return length


def _hic(window: float, rule: Callable[..., criteria.HIC] = criteria.hic) -> Callable[[Evidence, Person], Finding]:
    def compute(evidence: Evidence, person: Person) -> Finding:
        place = "chest" if person.lumped else "head"
        signals = evidence.signals(person, place)
        found = rule(signals.time, _resultant(signals), max_window=window)
        remarks = signals.remarks
        if person.lumped:
            remarks = (*remarks, "a lumped occupant has no head; this is of its whole mass, an indicator only")
        return Finding(
            found.value,
            found.start,
            found.end,
            signals.used,
            remarks,
            indicator=person.lumped,
            at_least=_is_along_x_only(person, place),
        )

    return compute


def _held(place: str) -> Callable[[Evidence, Person], Finding]:
    def compute(evidence: Evidence, person: Person) -> Finding:
        # Cumulative, as the regulations have it: exceeded for no more than 3 ms in all.
        signals = evidence.signals(person, place)
        found = criteria.clip(signals.time, _resultant(signals), cumulative=True)
        along_x = _is_along_x_only(person, place)
        return Finding(found.value, found.start, found.end, signals.used, signals.remarks, at_least=along_x)

    return compute


def _is_along_x_only(person: Person, place: str) -> bool:
    """Whether this is the head of a simulated occupant: a mass that cannot nod, and knows only a part of the resultant."""
    return person.simulated and place == "head"


def _chest_peak(evidence: Evidence, person: Person) -> Finding:
    signals = evidence.signals(person, "chest")
    found = criteria.peak(signals.time, _resultant(signals))
    return Finding(abs(found.value), found.time, found.time, signals.used, signals.remarks)


def _deflection(evidence: Evidence, person: Person) -> Finding:
    signals = evidence.signals(person, "chest deflection")
    found = chest.chest_deflection(signals.time, signals.values[0])
    return Finding(abs(found.value), found.time, found.time, signals.used, signals.remarks)


def _viscous(evidence: Evidence, person: Person) -> Finding:
    signals = evidence.signals(person, "chest deflection, class 180")
    dummy = _dummy_among(person, chest.CHEST_CONSTANTS, "chest depth")
    found = chest.viscous_criterion(signals.time, signals.values[0], dummy=dummy)
    return Finding(found.value, found.time, found.time, signals.used, signals.remarks)


def _nij(evidence: Evidence, person: Person) -> Finding:
    axial, moment = evidence.signals(person, "neck axial force"), evidence.signals(person, "neck moment")
    shear = evidence.signals(person, "neck shear force")
    dummy = _dummy_among(person, neck.NECK_INTERCEPTS, "critical loads of the neck")
    if dummy not in {"Hybrid III 50", "Hybrid III 05"}:
        raise CannotJudge(f"no lever from the load cell to the occipital condyle is known for the {dummy}")
    about_condyle = neck.condyle_moment(moment.values[0], shear.values[0])
    found = neck.nij(axial.time, axial.values[0], about_condyle, dummy=dummy)
    used = (*axial.used, *moment.used, *shear.used)
    remarks = (*axial.remarks, *moment.remarks, *shear.remarks, f"{found.loading}, moment about the occipital condyle")
    return Finding(found.value, found.time, found.time, used, remarks)


def _neck_force(which: str) -> Callable[[Evidence, Person], Finding]:
    def compute(evidence: Evidence, person: Person) -> Finding:
        signals = evidence.signals(person, "neck axial force")
        found = neck.neck_forces(signals.time, signals.values[0])
        value = found.tension if which == "tension" else found.compression
        time = found.tension_time if which == "tension" else found.compression_time
        return Finding(value, time, time, signals.used, signals.remarks)

    return compute


def _femur(side: str) -> Callable[[Evidence, Person], Finding]:
    def compute(evidence: Evidence, person: Person) -> Finding:
        signals = evidence.signals(person, f"{side} femur")
        found = legs.femur_force(signals.time, signals.values[0])
        return Finding(-found.value, found.time, found.time, signals.used, signals.remarks)

    return compute


def _dummy_among(person: Person, known: Mapping[str, object], what: str) -> str:
    if person.dummy not in known:
        raise CannotJudge(f"no {what} known for {f'the {person.dummy}' if person.dummy else 'an occupant without a dummy'}")
    return person.dummy


OF_OCCUPANTS: Mapping[str, Callable[[Evidence, Person], Finding]] = {
    "hic15": _hic(0.015),
    "hic36": _hic(0.036),
    "head_3ms": _held("head"),
    "chest_3ms": _held("chest"),
    "chest_peak": _chest_peak,
    "chest_deflection": _deflection,
    "viscous_criterion": _viscous,
    "nij": _nij,
    "neck_tension": _neck_force("tension"),
    "neck_compression": _neck_force("compression"),
    "femur_left": _femur("left"),
    "femur_right": _femur("right"),
}

BY_LABORATORIES: Mapping[str, Callable[[Evidence, Person], Finding]] = {
    "hic15": _hic(0.015, criteria.hic_by_sum),
    "hic36": _hic(0.036, criteria.hic_by_sum),
}
"""Criteria that laboratories compute by a rule of their own, by that rule: to stand beside their results, for nothing else."""


# vehicles


def _olc(evidence: Evidence, vehicle: str) -> Finding:
    pulse = evidence.pulse(vehicle)
    found = criteria.olc(pulse.time, pulse.acceleration)
    if found.value is None:
        raise CannotJudge(
            f"the pulse does not stop the criterion's occupant: it gets {found.displacement:.3f} m ahead of the vehicle"
        )
    return Finding(found.value, found.start, found.end, pulse.used, pulse.remarks)


def _asi(edition: str) -> Callable[[Evidence, str], Finding]:
    def compute(evidence: Evidence, vehicle: str) -> Finding:
        pulse = evidence.pulse(vehicle)
        lateral, vertical, missing = None, None, []
        try:
            lateral = _aligned(evidence.across(vehicle, "lateral"), pulse)
        except CannotJudge as why:
            missing.append(str(why))
        try:
            vertical = _aligned(evidence.across(vehicle, "vertical"), pulse)
        except CannotJudge as why:
            missing.append(str(why))
        found = roadside.asi(pulse.time, pulse.acceleration, lateral, vertical, edition=edition)  # type: ignore[arg-type]
        remarks = (*pulse.remarks, *missing)
        return Finding(found.value, found.time, found.time, pulse.used, remarks, at_least=bool(missing))

    return compute


def _head_flight(which: str) -> Callable[[Evidence, str], Finding]:
    def compute(evidence: Evidence, vehicle: str) -> Finding:
        pulse = evidence.pulse(vehicle)
        lateral = _aligned(evidence.across(vehicle, "lateral"), pulse)
        yaw = _aligned(evidence.across(vehicle, "yaw rate"), pulse)
        if which == "thiv":
            impact = roadside.thiv(pulse.time, pulse.acceleration, lateral, yaw)
            if impact.value is None:
                raise CannotJudge("the theoretical head never reaches 0.6 m ahead or 0.3 m aside")
            return Finding(impact.value, impact.time, impact.time, pulse.used, pulse.remarks)
        return _after(roadside.phd(pulse.time, pulse.acceleration, lateral, yaw), pulse)

    return compute


def _flail(which: str) -> Callable[[Evidence, str], Finding]:
    def compute(evidence: Evidence, vehicle: str) -> Finding:
        pulse = evidence.pulse(vehicle)
        lateral = _aligned(evidence.across(vehicle, "lateral"), pulse)
        if which == "velocity":
            impact = roadside.occupant_impact_velocity(pulse.time, pulse.acceleration, lateral)
            if impact.value is None:
                raise CannotJudge("the occupant never reaches 0.6 m ahead or 0.3 m aside")
            return Finding(impact.value, impact.time, impact.time, pulse.used, pulse.remarks)
        ride = roadside.occupant_ridedown_acceleration(pulse.time, pulse.acceleration, lateral)
        worst = max((ride.forward, ride.lateral), key=lambda part: -1.0 if part.value is None else part.value)
        return _after(worst, pulse)

    return compute


def _after(found: roadside.AfterContact, pulse: Pulse) -> Finding:
    if found.value is None:
        raise CannotJudge("no contact with the interior, or less than 10 ms of record after it")
    return Finding(found.value, found.start, found.end, pulse.used, pulse.remarks)


def _aligned(signals: Signals, pulse: Pulse) -> Floats:
    if signals.time.shape != pulse.time.shape or not np.allclose(signals.time, pulse.time, rtol=0.0, atol=1e-9):
        raise CannotJudge(f"channel {', '.join(signals.used)} is not sampled at the times of the pulse")
    row: Floats = signals.values[0]
    return row


OF_VEHICLES: Mapping[str, Callable[[Evidence, str], Finding]] = {
    "olc": _olc,
    "asi": _asi("EN 1317-1:2010"),
    "asi_1998": _asi("EN 1317-1:1998"),
    "thiv": _head_flight("thiv"),
    "phd": _head_flight("phd"),
    "occupant_impact_velocity": _flail("velocity"),
    "ridedown_acceleration": _flail("acceleration"),
}
