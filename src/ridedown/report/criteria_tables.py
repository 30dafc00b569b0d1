"""The criteria of a crash as tables and as data for JSON: beside the official results, the peaks of every channel, verdicts."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.limits import CRITERIA, Assessment, CrashCriteria, Evidence, Judgement, OccupantCriteria, assess, regulations
from ridedown.limits.findings import in_field
from ridedown.report.tables import NONE, Column, Table, number
from ridedown.signals.ev5_results import HIC15, HIC36, hic_window
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import ChannelInfo, OfficialResult, TestRecord

_MS = 1e3
_MOST_NAMED = 12
"""Channels, or runs of them, that a table names for one reason; the rest it counts."""

_OFFICIAL: Mapping[str, str] = {"CLIP3M": "chest_3ms", "LFEM": "femur_left", "RFEM": "femur_right"}
"""What the laboratory calls a result, and our key for it. HIC is told by its window."""

_DIGITS = {"": 3, "g": 2, "mm": 1, "N": 0, "m/s": 3, "km/h": 2}
_PLAIN_HIC = ("hic15", "hic36")


@dataclass(frozen=True, slots=True)
class Compared:
    """A criterion of ours beside the official result of that name, in the same unit; forces are magnitudes of compression.

    part: "value", or "start" or "end" of its interval, in ms. value: None where the channels do not allow it.
    """

    official_name: str
    criterion: str
    part: str
    unit: str
    value: float | None
    official: float

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
            yield Compared("HIC", key, "value", "", occupant.value(key), hic.value)
            found = occupant.findings.get(key)
            for part, theirs in (("start", hic.start), ("end", hic.end)):
                if theirs is not None:
                    ours = None if found is None else getattr(found, part)
                    name = "T1" if part == "start" else "T2"
                    yield Compared(name, key, part, "ms", None if ours is None else _MS * ours, _MS * theirs)
    for name, key in _OFFICIAL.items():
        if name in occupant.official:
            # recorded with a sign or without one: what is official of a femur is its compression
            yield Compared(name, key, "value", CRITERIA[key].unit, occupant.value(key), abs(occupant.official[name].value))


def _hic_keys(hic: OfficialResult) -> tuple[str, ...]:
    window = hic_window(hic)
    return {HIC15: ("hic15",), HIC36: ("hic36",)}.get(window, _PLAIN_HIC) if window is not None else _PLAIN_HIC


# tables


def occupant_table(occupant: OccupantCriteria) -> Table:
    """One occupant's criteria: value, when, the official result and the difference, the channels; one row each."""
    beside = compared(occupant)
    rows = []
    for key, finding in occupant.findings.items():
        unit = CRITERIA[key].unit
        rows.append(
            (
                CRITERIA[key].label + (" (indicator only)" if finding.indicator else ""),
                _shown(occupant.value(key), unit),
                unit or NONE,
                number(finding.start, scale=_MS),
                number(finding.end, scale=_MS),
                *_official_cells(beside, key),
                ", ".join(finding.used),
            )
        )
    known = {one.official_name for one in beside}
    rows += [
        (f"{name}, official", NONE, result.unit or NONE, NONE, NONE, _shown(result.value, result.unit), NONE, NONE, NONE)
        for name, result in occupant.official.items()
        if name not in known
    ]
    who = f"Occupant {occupant.seat}" + (f", {occupant.dummy}" if occupant.dummy else "")
    columns = (
        Column(who, numeric=False),
        Column("Value"),
        Column("Unit", numeric=False),
        Column("from", "ms"),
        Column("to", "ms"),
        Column("Official"),
        Column("Difference"),
        Column("Official interval", "ms"),
        Column("Channels", numeric=False),
    )
    return Table(f"{who}: criteria", columns, tuple(rows)).without_empty_columns()


def _official_cells(beside: Iterable[Compared], key: str) -> tuple[str, str, str]:
    """Official value, difference, official interval of one criterion."""
    mine = {one.part: one for one in beside if one.criterion == key}
    if "value" not in mine:
        return NONE, NONE, NONE
    value = mine["value"]
    interval = f"{mine['start'].official:.1f} to {mine['end'].official:.1f}" if {"start", "end"} <= set(mine) else NONE
    digits = _digits(value.value if value.value is not None else value.official, value.unit)
    return f"{value.official:g}", _signed(value.difference, digits), interval


def missing_table(found: CrashCriteria) -> Table:
    """What could not be computed, of whom, and why; one row for each reason."""
    reasons: dict[tuple[str, str], list[str]] = {}
    for occupant in found.occupants:
        for key, why in occupant.missing.items():
            reasons.setdefault((f"occupant {occupant.seat}", why), []).append(CRITERIA[key].label)
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
                ("peak acceleration", None if peak is None else abs(peak.value), 2, 1 / 9.80665, "g", peak and peak.time),
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
    found = (assess(have, name) for name in regulations())
    return tuple(one for one in found if one.passed or one.failed)


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


# channels


@dataclass(frozen=True, slots=True)
class Peaks:
    """A channel that was read: its largest and smallest value, in its own unit as recorded, and when [s]."""

    info: ChannelInfo
    unit: str
    largest: float
    largest_time: float
    smallest: float
    smallest_time: float
    filtered: str
    remarks: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Plain data for JSON."""
        info = self.info
        return {
            "key": info.key,
            "name": info.name,
            "code": info.code,
            "location": info.location,
            "quantity": info.quantity,
            "axis": info.axis,
            "occupant": info.occupant,
            "vehicle": info.vehicle,
            "unit": self.unit,
            "largest": self.largest,
            "largest_time_s": self.largest_time,
            "smallest": self.smallest,
            "smallest_time_s": self.smallest_time,
            "filtered": self.filtered or None,
            "status": info.status,
            "remarks": list(self.remarks),
        }


@dataclass(frozen=True, slots=True)
class Channels:
    """A record's channels: the peaks of those that could be read, and the others with the reason."""

    peaks: tuple[Peaks, ...]
    unusable: tuple[tuple[ChannelInfo, str], ...]


def channels_of(record: TestRecord) -> Channels:
    """Read every channel once: its peaks, or why there are none."""
    peaks, unusable = [], []
    for info in record.channels.values():
        if not info.readable:
            unusable.append((info, info.status or "no curve"))
            continue
        try:
            peaks.append(_peaks(info, record.history(info)))
        except InvalidInput as problem:
            unusable.append((info, str(problem)))
    return Channels(tuple(peaks), tuple(unusable))


def _peaks(info: ChannelInfo, history: TimeHistory) -> Peaks:
    top, bottom = int(np.argmax(history.values)), int(np.argmin(history.values))
    time, values = history.time, history.values
    through = str(history.filtered) if history.filtered else ""
    return Peaks(
        info,
        history.unit,
        float(values[top]),
        float(time[top]),
        float(values[bottom]),
        float(time[bottom]),
        through,
        history.remarks,
    )


def peaks_table(channels: Channels) -> Table:
    """The peaks of every channel, as recorded."""
    columns = (
        Column("Channel", numeric=False),
        Column("Name", numeric=False),
        Column("Unit", numeric=False),
        Column("Largest"),
        Column("at", "ms"),
        Column("Smallest"),
        Column("at", "ms"),
        Column("Filter", numeric=False),
        Column("Status", numeric=False),
    )
    rows = tuple(
        (
            one.info.key,
            one.info.name if one.info.name != one.info.key else NONE,
            one.unit or NONE,
            _signed_plain(one.largest),
            number(one.largest_time, scale=_MS),
            _signed_plain(one.smallest),
            number(one.smallest_time, scale=_MS),
            one.filtered or NONE,
            one.info.status or NONE,
        )
        for one in channels.peaks
    )
    return Table("Channels: peaks as recorded, before any filter of ours", columns, rows).without_empty_columns()


def unusable_table(channels: Channels) -> Table:
    """The channels that could not be used, by the reason."""
    reasons: dict[str, list[str]] = {}
    for info, why in channels.unusable:
        reasons.setdefault(why, []).append(info.key)
    columns = (Column("Why", numeric=False), Column("How many"), Column("Channels", numeric=False))
    rows = tuple((why, str(len(keys)), _ranges(keys)) for why, keys in reasons.items())
    return Table("Channels that could not be used", columns, rows)


def _ranges(keys: Iterable[str]) -> str:
    """Keys in few words: runs of numbers as `4 to 12`.

    >>> _ranges(["4", "5", "6", "9", "belt"])
    '4 to 6, 9, belt'
    """
    runs: list[list[str]] = []
    for key in keys:
        if runs and key.isdecimal() and runs[-1][-1].isdecimal() and int(key) == int(runs[-1][-1]) + 1:
            runs[-1].append(key)
        else:
            runs.append([key])
    said = [run[0] if len(run) == 1 else f"{run[0]} to {run[-1]}" for run in runs]
    rest = len(said) - _MOST_NAMED
    return ", ".join(said) if rest <= 0 else ", ".join((*said[:_MOST_NAMED], f"and {sum(map(len, runs[_MOST_NAMED:]))} more"))


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


def _signed_plain(value: float) -> str:
    return f"{value:.5g}".replace("-", "\u2212")
