"""Measured tests that were dropped on the page, zips and loose tables: kept in memory, by a hash of their bytes, a few at a
time.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from threading import Lock
from typing import Any

import numpy as np

from ridedown.apps.web.crash import Frame, finite
from ridedown.apps.web.refusals import TooMuch
from ridedown.apps.web.results import table_of, verdict_row
from ridedown.apps.web.untrusted import read_table, size_of
from ridedown.errors import InvalidInput, RidedownError, UnknownName
from ridedown.report.criteria import CriteriaReport
from ridedown.scenario import dump
from ridedown.signals import TestRecord, filtered, holds_laboratory_test, read_bytes
from ridedown.studies.calibration.of_test import is_acceleration
from ridedown.studies.sled_of_test import sled_of_test

MOST_BYTES = 48 * 2**20
"""One upload: test 10146 with all of its 630 curves is 30 MB as a zip."""
MOST_KEPT = 128 * 2**20
"""All uploads together; the oldest go first."""
MOST_TESTS = 16
MOST_CHANNELS = 8
"""Channels drawn at once."""

_CLASSES = (None, 60, 180, 600, 1000)
_POINTS = 2000  # of one curve: a screen is narrower


@dataclass(frozen=True, slots=True, eq=False)
class Upload:
    """A test, its size, and what was found in it."""

    record: TestRecord
    size: int
    answer: dict[str, Any]


class Uploads:
    """The tests that this server holds, until it ends."""

    def __init__(self) -> None:
        self._kept: dict[str, Upload] = {}
        self._lock = Lock()

    def add(self, content: bytes, name: str) -> dict[str, Any]:
        """Read a file, judge it and keep it: what the page shows of it, with its `test`, the hash to ask for it by.

        Raises: InvalidInput for what is no test.
        """
        if len(content) > MOST_BYTES:
            raise TooMuch(f"file: got {len(content):,} bytes; need {MOST_BYTES:,} at most. Leave out channels.")
        key = hashlib.sha256(content).hexdigest()[:20]
        with self._lock:
            if key in self._kept:
                return self._kept[key].answer
        record, size = _read(content, PurePosixPath(name.replace("\\", "/")).name[-100:] or "test.zip")
        upload = Upload(record, size, {"kind": "test", "test": key, **_about(record)})
        with self._lock:
            self._kept[key] = upload
            while len(self._kept) > MOST_TESTS or sum(one.size for one in self._kept.values()) > MOST_KEPT:
                self._kept.pop(next(iter(self._kept)))
        return upload.answer

    def about(self, message: Mapping[str, Any]) -> dict[str, Any]:
        """What there is to show of a test: header, criteria, verdicts, channels, and the sled of its pulse."""
        return self._of(message).answer

    def record(self, message: Mapping[str, Any]) -> TestRecord:
        """The test that a message names. Raises: UnknownName where it is not held."""
        return self._of(message).record

    def channels(self, message: Mapping[str, Any]) -> Frame:
        """Curves of some channels, as recorded, or filtered to the class `cfc`."""
        record, keys = self._of(message).record, message.get("channels")
        if not isinstance(keys, list) or not 1 <= len(keys) <= MOST_CHANNELS:
            raise InvalidInput(f"channels: got {type(keys).__name__}; need a list of 1 to {MOST_CHANNELS}. Choose fewer.")
        cfc = message.get("cfc")
        if cfc not in _CLASSES:
            raise InvalidInput(f"cfc: got {cfc!r}; need 60, 180, 600, 1000, or none.")
        histories = [record.history(str(key)[:200]) for key in keys]
        if cfc is not None:
            histories = [filtered(history, float(cfc)) for history in histories]
        start, end = min(h.start for h in histories), max(h.end for h in histories)
        times = np.linspace(start, end, _POINTS + 1)
        values = [np.interp(times, h.time, h.values, left=np.nan, right=np.nan) for h in histories]
        lines = [
            {"label": f"{key}: {h.name}" if h.name != key else str(key), "row": i, "colour": i, "unit": h.unit}
            for i, (key, h) in enumerate(zip(keys, histories, strict=True))
        ]
        header = {"kind": "channels", "lines": lines, "start": start, "end": end}
        return header, {"time": times, "values": finite(np.array(values))}

    def _of(self, message: Mapping[str, Any]) -> Upload:
        key = str(message.get("test"))
        with self._lock:
            if key in self._kept:
                return self._kept[key]
        raise UnknownName("test: this server does not hold it any more; it keeps tests in memory only. Drop the file again.")


def _read(content: bytes, name: str) -> tuple[TestRecord, int]:
    """The test in these bytes, and how many bytes it takes in memory."""
    if holds_laboratory_test(content, name):
        return read_bytes(content, name), len(content)
    record = read_table(content, name)
    return record, size_of(record)


def _about(record: TestRecord) -> dict[str, Any]:
    report = CriteriaReport(record)
    verdicts = [
        verdict_row(one, assessment.regulation.name)
        for assessment in report.assessments
        if not assessment.regulation.remark and assessment.regulation.occupants != "none"
        for one in assessment.judgements
        if one.value is not None
    ]
    return {
        "title": report.title,
        "description": report.description,
        "notes": list(report.notes),
        "tables": [table_of(table) for table in report.tables],
        "verdicts": verdicts,
        "channels": [
            {
                "key": info.key,
                "label": ", ".join(part for part in (info.name, info.location, info.quantity, info.axis) if part),
                "unit": info.unit,
                "group": _group(info.occupant, info.vehicle),
                "acceleration": is_acceleration(info),
            }
            for info in record.channels.values()
            if info.readable
        ],
        **_sled(record),
    }


def _group(occupant: str | None, vehicle: int | None) -> str:
    if occupant:
        return f"occupant {occupant}"
    return "barrier" if vehicle == 0 else f"vehicle {vehicle}" if vehicle else "other"


def _sled(record: TestRecord) -> dict[str, Any]:
    """The test as a sled, in the text of a scenario file; or why it cannot be one without more being said."""
    try:
        return {"sled": dump(sled_of_test(record)), "no_sled": ""}
    except RidedownError as why:
        return {"sled": None, "no_sled": str(why)}
