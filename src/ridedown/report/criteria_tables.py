"""The criteria of a crash as tables and as data for JSON: beside the official results, and verdicts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ridedown.limits import CRITERIA, Assessment, CrashCriteria, Evidence, Judgement, OccupantCriteria, assess_all, regulations
from ridedown.limits.findings import Finding, in_field
from ridedown.report.criteria_channels import Channels
from ridedown.report.tables import NONE, Column, Table, number
from ridedown.signals.ev5_results import hic_window
from ridedown.signals.record import OfficialResult

_MS = 1e3

_OFFICIAL: Mapping[str, str] = {"CLIP3M": "chest_3ms", "LFEM": "femur_left", "RFEM": "femur_right"}
"""What the laboratory calls a result, and our key for it. HIC is told by its window."""

_SUM_OF_SAMPLES = (
    "HIC is exact over the signal between its samples. Beside the official result it stands once more as a plain sum of "
    "samples, the rule that laboratories seem to follow; that sum is about half a sample late."
)

_DIGITS = {"": 3, "g": 2, "mm": 1, "N": 0, "m/s": 3, "km/h": 2}


@dataclass(frozen=True, slots=True)
class Compared:
    """A criterion of ours beside the official result of that name, in the same unit; forces are magnitudes of compression.

    part: "value", or "start" or "end" of its interval, in ms. value: None where the channels do not allow it. by_laboratory:
    the same by the laboratory's own rule, where that is another: HIC as a plain sum of samples.
    """

    official_name: str
    criterion: str
    part: str
    unit: str
    value: float | None
    official: float
    by_laboratory: float | None = None

    @property
    def difference(self) -> float | None:
        """Ours less the official one."""
        return None if self.value is None else self.value - self.official


def compared(occupant: OccupantCriteria) -> tuple[Compared, ...]:
    """An occupant's criteria beside the official results that have a counterpart.

    A HIC whose window the header does not tell stands beside both, HIC15 and HIC36.
    """
    return tuple(_compared(occupant))


def _compared(occupant: OccupantCriteria) -> Iterator[Compared]:
    hic = occupant.official.get("HIC")
    if hic is not None:
        for key in _hic_keys(hic):
            found, rule = occupant.findings.get(key), occupant.by_laboratory.get(key)
            yield Compared("HIC", key, "value", "", occupant.value(key), hic.value, None if rule is None else rule.value)
            for part, theirs in (("start", hic.start), ("end", hic.end)):
                if theirs is not None:
                    ours, ruled = (None if one is None else _MS * getattr(one, part) for one in (found, rule))
                    yield Compared("T1" if part == "start" else "T2", key, part, "ms", ours, _MS * theirs, ruled)
    for name, key in _OFFICIAL.items():
        if name in occupant.official:
            # recorded with a sign or without one: what is official of a femur is its compression
            yield Compared(name, key, "value", CRITERIA[key].unit, occupant.value(key), abs(occupant.official[name].value))


def _hic_keys(hic: OfficialResult) -> tuple[str, ...]:
    match hic_window(hic):
        case 0.015:
            return ("hic15",)
        case 0.036:
            return ("hic36",)
        case _:
            return ("hic15", "hic36")


# tables


def occupant_name(occupant: OccupantCriteria, found: CrashCriteria) -> str:
    """What an occupant is called: by its seat, and by its vehicle too where there is more than one."""
    if len(found.vehicles) > 1 and occupant.vehicle:
        return f"occupant {occupant.seat} of {_vehicle_name(occupant.vehicle)}"
    return f"occupant {occupant.seat}"


def occupant_title(occupant: OccupantCriteria, found: CrashCriteria) -> str:
    """The name with the dummy: `Occupant 01, Hybrid III 50`."""
    name = occupant_name(occupant, found)
    return f"{name[0].upper()}{name[1:]}" + (f", {occupant.dummy}" if occupant.dummy else "")


def occupant_table(occupant: OccupantCriteria, found: CrashCriteria) -> Table:
    """One occupant's criteria: value, when, the official result and the difference, the channels; one row each."""
    beside = compared(occupant)
    # an official result is shown also where our channels do not allow the criterion
    keys = dict.fromkeys((*occupant.findings, *(one.criterion for one in beside)))
    rows = [row for key in keys for row in _occupant_rows(occupant, key, beside)]
    known = {one.official_name for one in beside}
    rows += [
        (f"{name} (no criterion here)", NONE, result.unit or NONE, NONE, NONE, f"{result.value:g}", NONE, NONE, NONE)
        for name, result in occupant.official.items()
        if name not in known
    ]
    columns = (
        Column("Criterion", numeric=False),
        Column("Value"),
        Column("Unit", numeric=False),
        Column("from", "ms"),
        Column("to", "ms"),
        Column("Official"),
        Column("Difference"),
        Column("Official interval", "ms"),
        Column("Channels", numeric=False),
    )
    return Table(occupant_title(occupant, found), columns, tuple(rows)).without_empty_columns()


def _occupant_rows(occupant: OccupantCriteria, key: str, beside: Iterable[Compared]) -> Iterator[tuple[str, ...]]:
    """A criterion's row; below it, where the laboratory's rule is another, one by that, with the official result."""
    finding, theirs = occupant.findings.get(key), occupant.by_laboratory.get(key)
    label = CRITERIA[key].label
    official = _official_cells(beside, key)
    by_rule = theirs is not None and official[0] != NONE
    yield _occupant_row(
        label + (" (indicator only)" if finding is not None and finding.indicator else ""),
        key,
        finding,
        (NONE, NONE, NONE) if by_rule else official,
    )
    if by_rule:
        yield _occupant_row(f"{label}, sum of samples", key, theirs, official)


def _occupant_row(label: str, key: str, finding: Finding | None, official: tuple[str, str, str]) -> tuple[str, ...]:
    unit = CRITERIA[key].unit
    return (
        label,
        _shown(None if finding is None else _field(finding.value, key), unit),
        unit or NONE,
        number(None if finding is None else finding.start, scale=_MS),
        number(None if finding is None else finding.end, scale=_MS),
        *official,
        ", ".join(finding.used) if finding is not None else NONE,
    )


def _official_cells(beside: Iterable[Compared], key: str) -> tuple[str, str, str]:
    """Official value, difference, official interval of one criterion; ours by the laboratory's rule, where that is another."""
    mine = {one.part: one for one in beside if one.criterion == key}
    if "value" not in mine:
        return NONE, NONE, NONE
    value = mine["value"]
    interval = f"{mine['start'].official:.1f} to {mine['end'].official:.1f}" if {"start", "end"} <= set(mine) else NONE
    ours = value.value if value.by_laboratory is None else value.by_laboratory
    digits = _digits(ours if ours is not None else value.official, value.unit)
    return f"{value.official:g}", _signed(None if ours is None else ours - value.official, max(digits, 1)), interval


def missing_table(found: CrashCriteria) -> Table:
    """What could not be computed, of whom, and why; one row for each reason."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for occupant in found.occupants:
        for key, why in occupant.missing.items():
            reasons.setdefault((occupant_name(occupant, found), why), []).append(CRITERIA[key].label)
    for vehicle in found.vehicles:
        for key, why in vehicle.missing.items():
            label = CRITERIA[key].label if key in CRITERIA else key.replace("_", " ")
            reasons.setdefault((_vehicle_name(vehicle.vehicle), why), []).append(label)
    columns = (Column("Of", numeric=False), Column("Not computed", numeric=False), Column("Why", numeric=False))
    rows = tuple((who, ", ".join(labels), why) for (who, why), labels in reasons.items())
    return Table("What the channels do not allow", columns, rows)


def vehicle_table(found: CrashCriteria) -> Table:
    """Each vehicle's motion and what is judged by it, one row each."""
    rows: list[tuple[str, ...]] = []
    for vehicle in found.vehicles:
        name = _vehicle_name(vehicle.vehicle)
        crush, crushed_at = vehicle.crush or (None, None)
        peak = vehicle.peak
        rows += [
            (name, label, number(value, digits, scale=scale), unit, number(time, scale=_MS), NONE)
            for label, value, digits, scale, unit, time in (
                ("speed at contact", vehicle.speed, 2, 3.6, "km/h", None),
                ("delta-v", vehicle.delta_v, 2, 3.6, "km/h", None),
                ("dynamic crush", crush, 0, 1e3, "mm", crushed_at),
                ("time to zero velocity", vehicle.time_to_zero_velocity, 2, _MS, "ms", None),
                ("coefficient of restitution", vehicle.restitution, 3, 1.0, NONE, None),
                (
                    "peak acceleration",
                    None if peak is None else abs(peak.value),
                    2,
                    1 / 9.80665,
                    "g",
                    None if peak is None else peak.time,
                ),
                ("VPI", vehicle.vpi, 1, 1.0, "m/s²", None),
            )
            if value is not None
        ]
        for key, finding in vehicle.findings.items():
            unit = CRITERIA[key].unit
            value = _field(finding.value, key)
            said = "lower bound: not every axis was measured" if finding.at_least else NONE
            rows.append((name, CRITERIA[key].label, _shown(value, unit), unit or NONE, number(finding.start, scale=_MS), said))
    columns = (
        Column("Vehicle", numeric=False),
        Column("What", numeric=False),
        Column("Value"),
        Column("Unit", numeric=False),
        Column("at, or from", "ms"),
        Column("Remark", numeric=False),
    )
    return Table("Vehicles", columns, tuple(rows)).without_empty_columns()


def occupant_notes(found: CrashCriteria) -> tuple[str, ...]:
    """What there is to know about occupants' values: a second sensor that stands in, a channel left out, and the like."""
    laboratory = [_SUM_OF_SAMPLES] if any(occupant.by_laboratory for occupant in found.occupants) else []
    said: dict[tuple[str, str], list[str]] = {}
    for occupant in found.occupants:
        for key, finding in occupant.findings.items():
            for remark in finding.remarks:
                said.setdefault((occupant_title(occupant, found), remark), []).append(CRITERIA[key].label)
    notes = (f"{who}, {', '.join(labels)}: {remark.rstrip('.')}." for (who, remark), labels in said.items())
    return (*laboratory, *notes)


def pulse_notes(found: CrashCriteria) -> tuple[str, ...]:
    """Which channels each vehicle's pulse is made of, and which were not believed, and why."""
    said = []
    for vehicle in found.vehicles:
        if vehicle.used:
            said.append(f"Pulse of {_vehicle_name(vehicle.vehicle)}: channel {', '.join(vehicle.used)}.")
        said += [f"Left out of it: {why}." for why in vehicle.rejected]
        said += [f"{remark}." for remark in vehicle.remarks]
    return tuple(said)


# regulations


def verdicts(have: Evidence) -> tuple[Assessment, ...]:
    """The crash before each regulation that finds anything to judge in it."""
    return tuple(one for one in assess_all(have, regulations()) if one.passed or one.failed)


def verdict_tables(assessments: Iterable[Assessment]) -> tuple[Table, ...]:
    """Verdicts: first the regulations for these occupants, then those written for other crashes, for orientation."""
    assessments = tuple(assessments)
    return tuple(
        table
        for table in (
            _verdicts("Before the regulations", [one for one in assessments if not one.regulation.remark]),
            _verdicts(
                "For orientation only: regulations written for other crashes than a test of a car's front",
                [one for one in assessments if one.regulation.remark],
            ),
        )
        if table.rows
    )


def _verdicts(caption: str, assessments: Iterable[Assessment]) -> Table:
    columns = (
        Column("Regulation", numeric=False),
        Column("Of", numeric=False),
        Column("Criterion", numeric=False),
        Column("Value"),
        Column("Limit"),
        Column("Margin"),
        Column("Unit", numeric=False),
        Column("Verdict", numeric=False),
        Column("Clause, or why not", numeric=False),
    )
    rows = tuple(_verdict_row(one, judgement) for one in assessments for judgement in one.judgements)
    return Table(caption, columns, rows)


def _verdict_row(assessment: Assessment, judgement: Judgement) -> tuple[str, ...]:
    label = CRITERIA[judgement.criterion].label if judgement.criterion else NONE
    unit = judgement.unit
    limit = judgement.shown(judgement.limit)
    return (
        assessment.regulation.name,
        judgement.subject,
        f"{label} ({judgement.level})" if judgement.level else label,
        _shown(judgement.shown(judgement.value), unit),
        NONE if limit is None else f"{limit:.6g}",
        _shown(judgement.shown(judgement.margin), unit),
        unit or NONE,
        judgement.verdict.value,
        judgement.reason or judgement.clause or NONE,
    )


# JSON


def as_json(
    found: CrashCriteria, channels: Channels, assessments: Iterable[Assessment], problems: Iterable[str]
) -> dict[str, Any]:
    """Everything as plain data for JSON: the criteria, each occupant's beside the official results, channels, verdicts."""
    data = found.as_json()
    for occupant, plain in zip(found.occupants, data["occupants"], strict=True):
        plain["compared"] = [
            {
                "official_name": one.official_name,
                "criterion": one.criterion,
                "part": one.part,
                "unit": one.unit,
                "value": one.value,
                "official": one.official,
                "difference": one.difference,
                "sum_of_samples": one.by_laboratory,
            }
            for one in compared(occupant)
        ]
    return {
        **data,
        "regulations": {one.regulation.name: [_judged(judgement) for judgement in one.judgements] for one in assessments},
        "channels": [one.as_json() for one in channels.peaks],
        "unusable": [{"key": info.key, "name": info.name, "reason": why} for info, why in channels.unusable],
        "problems": list(problems),
    }


def _judged(judgement: Judgement) -> dict[str, Any]:
    return {
        "of": judgement.subject,
        "vehicle": judgement.vehicle or None,
        "criterion": judgement.criterion or None,
        "level": judgement.level or None,
        "value": judgement.shown(judgement.value),
        "limit": judgement.shown(judgement.limit),
        "margin": judgement.shown(judgement.margin),
        "unit": judgement.unit,
        "verdict": judgement.verdict.value,
        "clause": judgement.clause or None,
        "reason": judgement.reason or None,
        "remarks": list(judgement.remarks),
    }


# numbers


def _field(value: float, key: str) -> float:
    return in_field(value, CRITERIA[key].unit)


def _vehicle_name(vehicle: str) -> str:
    return f"vehicle {vehicle}" if vehicle.isdecimal() else vehicle or "the vehicle"


def _digits(value: float, unit: str) -> int:
    """Decimals: by the unit; of a number without one, three, or one where it is large, as HIC is."""
    return 1 if not unit and abs(value) >= 10.0 else _DIGITS.get(unit, 2)


def _shown(value: float | None, unit: str) -> str:
    return NONE if value is None else number(value, _digits(value, unit))


def _signed(value: float | None, digits: int) -> str:
    text = number(value, digits)
    return f"+{text}" if value is not None and value > 0.0 and float(text) != 0.0 else text
