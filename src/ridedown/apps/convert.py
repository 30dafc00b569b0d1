"""A test, or a simulated crash, from one format into another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ridedown.apps.measured import checked, format_of, is_scenario, output
from ridedown.errors import InvalidInput
from ridedown.signals import parquet, read, write

if TYPE_CHECKING:
    from ridedown.response import Response
    from ridedown.signals.record import TestRecord

Simulate = Callable[[str], "Response"]
"""Simulates the scenario in a file or of a catalogue name."""


@dataclass(frozen=True, slots=True)
class Converted:
    """What was written: where, as what, channels of how many, how many of those have no curve, and what else to know."""

    path: Path
    format: str
    written: int
    channels: int
    without_curve: int
    remarks: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.written} of {self.channels} channels written to {self.path} ({self.format})"


def convert(source: str, target: str, simulate: Simulate) -> Converted:
    """Read a test, or simulate a scenario, and write it in the format that the target's name tells.

    Raises: InvalidInput for anything that cannot be read or written; the target then is as it was.
    """
    path = output(target)
    record = _record(source, simulate)
    _check_apart(Path(source), path)  # a name of the catalogue is no path that exists
    left_out = write(record, path)
    total = len(record.channels)
    without = sum(not info.readable for info in record.channels.values())
    said = [f"left out: {why}" for why in left_out if not _known(why, record)]
    if path.suffix.lower() in {".csv", ".tsv", *parquet.SUFFIXES}:
        said += _lost(record)
    return Converted(path, format_of(path), total - len(left_out), total, without, tuple(said))


def _record(source: str, simulate: Simulate) -> TestRecord:
    if not is_scenario(source):
        return read(checked(source))
    response = simulate(source)
    if not response.completed:
        raise InvalidInput(
            f"{source}: got a simulation that stopped at {1e3 * response.end_time:.3f} ms: {response.status.sentence}; "
            "need one that is whole. Run it to see what it came to."
        )
    return response.to_record()


def _check_apart(source: Path, path: Path) -> None:
    """Refuse to write a folder over one that the test is read from, or is in: its curves are read while it is written."""
    if not source.exists() or not path.exists():
        return
    inside, outer = source.resolve(), path.resolve()
    if path.is_dir() and inside != outer and inside.is_relative_to(outer):
        raise InvalidInput(f"OUT: got the folder {path}, which holds the test itself; need another. Choose a new name.")


def _lost(record: TestRecord) -> list[str]:
    """What a table has no place for and a reader could miss."""
    if record.vehicles or record.occupants:
        return ["a table has no place for vehicles, their speed, occupants and official results; ISO-MME has"]
    return []


def _known(why: str, record: TestRecord) -> bool:
    """Whether a sentence is about a channel that the header lists and no file has: those are counted, not listed."""
    words = why.removeprefix("channel ").split(":", 1)[0]
    info = record.channels.get(words)
    return info is not None and not info.readable
