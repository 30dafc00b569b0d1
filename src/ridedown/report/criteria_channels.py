"""The channels of a test: the peaks of each that could be read, and why the others could not be used."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.report.tables import NONE, Column, Table, number
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import ChannelInfo, TestRecord

_MS = 1e3
_MOST_NAMED = 12
"""Channels, or runs of them, that a table names for one reason; the rest it counts."""


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
            _recorded(one.largest),
            number(one.largest_time, scale=_MS),
            _recorded(one.smallest),
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


def _recorded(value: float) -> str:
    return f"{value:.5g}".replace("-", "\u2212")
