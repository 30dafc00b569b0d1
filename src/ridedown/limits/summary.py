"""Every criterion that a crash's channels allow, occupant by occupant and vehicle by vehicle, and what is missing, and why."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from ridedown import criteria
from ridedown.criteria import risk
from ridedown.errors import InvalidInput
from ridedown.limits.evidence import CannotJudge, Evidence, Person, Pulse, evidence
from ridedown.limits.findings import BY_LABORATORIES, CRITERIA, OF_OCCUPANTS, OF_VEHICLES, Finding, in_field
from ridedown.signals.record import OfficialResult

if TYPE_CHECKING:
    from ridedown.response import Response
    from ridedown.signals.record import TestRecord

_KMH = 3.6

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class OccupantCriteria:
    """One occupant's criteria by their keys (see CRITERIA), SI; `missing`: why each of the others could not be computed.

    risks: probabilities by the US NCAP curves, where the dummy has them: head, neck, chest, femur, combined.
    official: the laboratory's own results, as it names them. Forces and deflections are magnitudes, of compression.
    by_laboratory: the criteria of `findings` that stand beside an official HIC once more, by the laboratory's plain sum of
    samples.
    """

    seat: str
    vehicle: str
    dummy: str
    lumped: bool
    findings: Mapping[str, Finding]
    missing: Mapping[str, str]
    risks: Mapping[str, float]
    official: Mapping[str, OfficialResult]
    by_laboratory: Mapping[str, Finding]

    def value(self, key: str) -> float | None:
        """A criterion in its field unit; None where it could not be computed."""
        found = self.findings.get(key)
        return None if found is None else in_field(found.value, CRITERIA[key].unit)

    def as_json(self) -> dict[str, Any]:
        """Plain data for JSON, in field units; null where not computed, with the reason under `not_computed`."""
        left, right = self.value("femur_left"), self.value("femur_right")
        return {
            "seat": self.seat,
            "vehicle": self.vehicle,
            "dummy": self.dummy,
            "lumped": self.lumped,
            "hic15": self.value("hic15"),
            "hic15_interval_s": _interval(self.findings.get("hic15")),
            "hic36": self.value("hic36"),
            "hic36_interval_s": _interval(self.findings.get("hic36")),
            "clip_3ms_g": self.value("chest_3ms"),
            "clip_3ms_interval_s": _interval(self.findings.get("chest_3ms")),
            "chest_peak_g": self.value("chest_peak"),
            "head_3ms_g": self.value("head_3ms"),
            "chest_deflection_mm": self.value("chest_deflection"),
            "viscous_criterion_ms": self.value("viscous_criterion"),
            # compression negative, as recorded and as the official results have it
            "femur_n": {"left": None if left is None else -left, "right": None if right is None else -right},
            "nij": self.value("nij"),
            "neck_tension_n": self.value("neck_tension"),
            "neck_compression_n": self.value("neck_compression"),
            "injury_risk": dict(self.risks),
            "official": {name: result.value for name, result in self.official.items()},
            "official_units": {name: result.unit for name, result in self.official.items()},
            "sum_of_samples": {
                key: {"value": found.value, "interval_s": _interval(found)} for key, found in self.by_laboratory.items()
            },
            "channels": {key: list(finding.used) for key, finding in self.findings.items()},
            "remarks": {key: list(finding.remarks) for key, finding in self.findings.items() if finding.remarks},
            "not_computed": dict(self.missing),
        }


@dataclass(frozen=True, slots=True)
class VehicleCriteria:
    """One vehicle's criteria: its motion in SI (None where it could not be computed), and those of CRITERIA by their keys.

    delta_v, peak: magnitudes. crush: dynamic crush and its time. used, rejected: the channels of the pulse, and those that were
    not believed, each with the reason.
    """

    vehicle: str
    speed: float | None
    delta_v: float | None
    crush: tuple[float, float] | None
    time_to_zero_velocity: float | None
    restitution: float | None
    vpi: float | None
    peak: criteria.Peak | None
    findings: Mapping[str, Finding]
    missing: Mapping[str, str]
    used: tuple[str, ...]
    rejected: tuple[str, ...]
    remarks: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Plain data for JSON, in the units that the names say; null where not computed."""
        olc = self.findings.get("olc")
        others = {key: finding for key, finding in self.findings.items() if key != "olc"}
        return {
            "vehicle": self.vehicle,
            "speed_kmh": None if self.speed is None else self.speed * _KMH,
            "delta_v_kmh": None if self.delta_v is None else self.delta_v * _KMH,
            "dynamic_crush_m": None if self.crush is None else self.crush[0],
            "time_to_zero_velocity_s": self.time_to_zero_velocity,
            "restitution": self.restitution,
            "olc_g": None if olc is None else olc.value / criteria.STANDARD_GRAVITY,
            "vpi_ms2": self.vpi,
            "peak_g": None if self.peak is None else abs(self.peak.value) / criteria.STANDARD_GRAVITY,
            "peak_time_s": None if self.peak is None else self.peak.time,
            "roadside": {
                key: {
                    "value": in_field(found.value, CRITERIA[key].unit),
                    "unit": CRITERIA[key].unit,
                    "at_least": found.at_least,
                }
                for key, found in others.items()
            },
            "channels": list(self.used),
            "rejected": list(self.rejected),
            "remarks": list(self.remarks),
            "not_computed": dict(self.missing),
        }


@dataclass(frozen=True, slots=True)
class CrashCriteria:
    """All criteria of a crash, measured or simulated."""

    title: str
    simulated: bool
    occupants: tuple[OccupantCriteria, ...]
    vehicles: tuple[VehicleCriteria, ...]

    def as_json(self) -> dict[str, Any]:
        """Plain data for JSON: `occupants`, `vehicle` (the first) and `vehicles` (all)."""
        vehicles = [vehicle.as_json() for vehicle in self.vehicles]
        return {
            "title": self.title,
            "simulated": self.simulated,
            "occupants": [occupant.as_json() for occupant in self.occupants],
            "vehicle": vehicles[0] if vehicles else None,
            "vehicles": vehicles,
        }


def criteria_of(source: TestRecord | Response | Evidence) -> CrashCriteria:
    """Every criterion that the channels of a test, or a simulated crash, allow.

    Nothing that is missing or damaged stops the rest: it is named, with the reason, in `missing`.

    Raises: TypeError where the source is neither.
    """
    have = evidence(source)
    return CrashCriteria(
        have.title,
        have.simulated,
        tuple(_occupant(have, person) for person in have.people),
        tuple(_vehicle(have, vehicle) for vehicle in have.vehicles),
    )


def _occupant(have: Evidence, person: Person) -> OccupantCriteria:
    findings: dict[str, Finding] = {}
    missing: dict[str, str] = {}
    for key, compute in OF_OCCUPANTS.items():
        try:
            findings[key] = compute(have, person)
        except (CannotJudge, InvalidInput) as why:
            missing[key] = str(why)
    official = person.official or {}
    risks = _risks(person, {key: finding.value for key, finding in findings.items()})
    rules = BY_LABORATORIES if "HIC" in official else {}
    theirs = {key: compute(have, person) for key, compute in rules.items() if key in findings}
    return OccupantCriteria(
        person.name, person.vehicle, person.dummy, person.lumped, findings, missing, risks, official, theirs
    )


def _risks(person: Person, values: Mapping[str, float]) -> dict[str, float]:
    if person.dummy not in risk.RISK_CURVES:
        return {}
    found: dict[str, float] = {}
    if "hic15" in values:
        found["head"] = risk.head_injury_risk(values["hic15"])
    if {"nij", "neck_tension", "neck_compression"} <= set(values):
        loads = values["nij"], values["neck_tension"], values["neck_compression"]
        found["neck"] = risk.neck_injury_risk(*loads, dummy=person.dummy)
    if "chest_deflection" in values:
        found["chest"] = risk.chest_injury_risk(values["chest_deflection"], dummy=person.dummy)
    if {"femur_left", "femur_right"} <= set(values):
        found["femur"] = risk.femur_injury_risk(max(values["femur_left"], values["femur_right"]), dummy=person.dummy)
    if len(found) == 4:
        found["combined"] = risk.combined_risk(*found.values())
    return found


def _vehicle(have: Evidence, vehicle: str) -> VehicleCriteria:
    missing: dict[str, str] = {}

    def tried(key: str, compute: Callable[[], T]) -> T | None:
        try:
            return compute()
        except (CannotJudge, InvalidInput) as why:
            missing[key] = str(why)
            return None

    findings = {
        key: found for key, compute in OF_VEHICLES.items() if (found := tried(key, partial(compute, have, vehicle))) is not None
    }
    speed = tried("speed", lambda: have.speed(vehicle))
    pulse = tried("pulse", lambda: have.pulse(vehicle))
    if pulse is None:
        return VehicleCriteria(vehicle, speed, None, None, None, None, None, None, findings, missing, (), (), ())
    delta_v = tried("delta_v", lambda: abs(criteria.delta_v(pulse.time, pulse.acceleration).value))
    vpi = tried("vpi", lambda: _vpi(pulse))
    peak = tried("peak", lambda: criteria.peak(pulse.time, pulse.shape))
    crush = have.crush(vehicle)
    stop = restitution = None
    if speed is not None:
        alone = len(have.vehicles) == 1
        crush = crush or tried("dynamic_crush", lambda: _crush(pulse, speed, alone=alone))
        stop = tried("time_to_zero_velocity", lambda: _stop(pulse, speed))
        restitution = tried("restitution", lambda: _restitution(pulse, speed, alone=alone))
    return VehicleCriteria(
        vehicle,
        speed,
        delta_v,
        crush,
        stop,
        restitution,
        vpi,
        peak,
        findings,
        missing,
        pulse.used,
        pulse.rejected,
        pulse.remarks,
    )


_AGAINST_A_WALL = "needs a fixed wall: what another vehicle moves is not in this vehicle's pulse"


def _restitution(pulse: Pulse, speed: float, *, alone: bool) -> float | None:
    if not alone:
        raise CannotJudge(_AGAINST_A_WALL)
    return criteria.coefficient_of_restitution(pulse.time, pulse.acceleration, speed)


def _crush(pulse: Pulse, speed: float, *, alone: bool) -> tuple[float, float]:
    if not alone:
        raise CannotJudge(_AGAINST_A_WALL)
    found = criteria.dynamic_crush(pulse.time, pulse.acceleration, speed)
    if found is None:
        raise CannotJudge("the vehicle does not come to rest within the record")
    return found.value, found.time


def _stop(pulse: Pulse, speed: float) -> float:
    found = criteria.time_to_zero_velocity(pulse.time, pulse.acceleration, speed)
    if found is None:
        raise CannotJudge("the vehicle does not come to rest within the record")
    return found


def _vpi(pulse: Pulse) -> float:
    found = criteria.vpi(pulse.time, pulse.acceleration)
    if found.value is None:
        raise CannotJudge("the record ends before the peak of the mass on its spring")
    return found.value


def _interval(finding: Finding | None) -> list[float] | None:
    return None if finding is None or finding.start is None or finding.end is None else [finding.start, finding.end]
