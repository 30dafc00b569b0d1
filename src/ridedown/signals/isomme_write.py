"""Writing a test as ISO-MME 1.6, whole or not at all.

The folder or the zip is written aside, under a name of its own beside the place asked for, and takes that place in one
step. What is there already is replaced only if it is an ISO-MME test and nothing else.

What a record holds and ISO-MME has no descriptor for goes under keys that begin with a dot, as laboratories do with keys of
their own; other programs pass over them.
"""

from __future__ import annotations

import re
import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ridedown.errors import InvalidInput
from ridedown.signals import isomme_extras as extras
from ridedown.signals.codes import CLASSES, UNKNOWN, ChannelCode
from ridedown.signals.history import TimeHistory
from ridedown.signals.isomme_text import FORMAT, folded, one_line, written
from ridedown.signals.record import ChannelInfo, TestRecord

_UNSAFE = re.compile(r"[^A-Za-z0-9._-]+", re.ASCII)
_OURS = re.compile(r"(?:[^/]+\.mme|channel/[^/]+\.(?:chn|[0-9]{1,6}))", re.IGNORECASE)


def write_isomme(record: TestRecord, path: str | Path) -> tuple[str, ...]:
    """Write a test into a folder, or a zip if the path ends so; give a sentence for each channel that had to be left out.

    A channel is left out whose curve cannot be read. Values are written so that they read back bit for bit.

    Raises: InvalidInput, where something other than an ISO-MME test is at that path, or no channel can be read.
    """
    path = Path(path)
    _check_place(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=f".{path.name}.", dir=path.parent))
    try:
        folder = aside / "test"
        left_out = _write_folder(record, folder)
        if path.suffix.lower() == ".zip":
            packed = aside / "packed"
            _pack(folder, packed, _stem(record))
            packed.replace(path)
        else:
            _take_place(folder, path, aside)
    finally:
        shutil.rmtree(aside, ignore_errors=True)
    return left_out


def _check_place(path: Path) -> None:
    """Refuse a place that holds anything but an ISO-MME test."""
    if path.suffix.lower() == ".zip":
        if path.exists() and not _is_test_zip(path):
            raise InvalidInput(
                f"path: got {path.name}, which is something else; need a new name or an ISO-MME test. Choose another."
            )
        return
    if path.is_symlink() or (path.exists() and not path.is_dir()):
        raise InvalidInput(f"path: got {path.name}, which is no folder; need a new name or an ISO-MME test. Choose another.")
    if not path.exists():
        return
    names = [item.relative_to(path).as_posix() for item in path.rglob("*") if item.is_symlink() or not item.is_dir()]
    strange = sorted(name for name in names if not _OURS.fullmatch(name))
    if strange or (names and not any(name.lower().endswith(".mme") for name in names)):
        shown = strange[0] if strange else names[0]
        raise InvalidInput(
            f"path: got the folder {path.name}, which holds {shown}; need an empty folder, or one with an ISO-MME test and "
            "nothing else. Choose another."
        )


def _is_test_zip(path: Path) -> bool:
    if not zipfile.is_zipfile(path):
        return False
    with zipfile.ZipFile(path) as packed:
        names = [name for name in packed.namelist() if not name.endswith("/")]
    return any(name.lower().endswith(".mme") for name in names)


def _take_place(folder: Path, path: Path, aside: Path) -> None:
    """Put the written folder where it was asked for; what was there goes aside first, and back if that fails."""
    old = aside / "old"
    if path.exists():
        path.rename(old)
    try:
        folder.rename(path)
    except OSError:
        if old.exists():
            old.rename(path)
        raise


def _pack(folder: Path, target: Path, stem: str) -> None:
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in sorted(item for item in folder.rglob("*") if item.is_file()):
            packed.write(file, f"{stem}/{file.relative_to(folder).as_posix()}")


def _stem(record: TestRecord) -> str:
    """The test's name as file names may have it."""
    return _UNSAFE.sub("_", record.identifier).strip("._") or "test"


def _write_folder(record: TestRecord, folder: Path) -> tuple[str, ...]:
    stem = _stem(record)
    (folder / "Channel").mkdir(parents=True)
    channels = _Channels(record, folder / "Channel", stem)
    channels.write_all()
    if not channels.listed:
        raise InvalidInput(
            f"record {record.identifier}: got no channel that can be read; need one. {'; '.join(channels.left_out[:2])}"
        )
    pairs = [("Instrumentation standard", ""), ("Number of channels", str(len(channels.listed)))]
    pairs += [(f"Name of channel {number:03}", entry) for number, entry in sorted(channels.listed.items())]
    _put(folder / "Channel" / f"{stem}.chn", written(pairs))
    _put(folder / f"{stem}.mme", written(merged(record.fields if record.format == FORMAT else {}, _test_pairs(record))))
    return tuple(channels.left_out)


def _put(file: Path, text: str) -> None:
    file.write_text(text, encoding="utf-8", newline="\n")


@dataclass
class _Channels:
    """The channels of one test on their way to the folder."""

    record: TestRecord
    folder: Path
    stem: str
    listed: dict[int, str] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)
    clocks: dict[bytes, str] = field(default_factory=dict)

    def write_all(self) -> None:
        """Every channel, those that hold times first: others refer to them."""
        for info in sorted(self.record.channels.values(), key=lambda info: info.quantity != "time"):
            try:
                history = self.record.history(info.key)
            except InvalidInput as error:
                self.left_out.append(str(error))
                continue
            self.write(info, history)

    def write(self, info: ChannelInfo, history: TimeHistory) -> None:
        number = self.free(info.number)
        code = _code_of(history)
        pairs = _channel_pairs(info, history, code)
        if history.stamps is not None:
            if is_clock(history) and history.code:
                self.clocks.setdefault(history.stamps.tobytes(), history.code)
            pairs |= {"Reference channel": "explicit", "Reference channel name": self.clock(history)}
        if self.record.format != FORMAT and info.fields:
            pairs[".Fields"] = extras.dumped_fields(info.fields)
        self.listed[number] = " / ".join(filter(None, (code or UNKNOWN, one_line(history.name))))
        values = "".join(f"{value!r}\n" for value in history.values.tolist())
        text = written(merged(info.fields if self.record.format == FORMAT else {}, pairs)) + values
        _put(self.folder / f"{self.stem}.{number:03}", text)

    def clock(self, history: TimeHistory) -> str:
        """The code of the channel that holds the history's stamps, written with the first that needs it."""
        stamps = history.time
        key = stamps.tobytes()
        if key not in self.clocks:
            code = f"00TIRS{len(self.clocks) + 1:04}00TI00"  # time reference signal, numbered by its fine locations
            self.clocks[key] = code
            clock = TimeHistory(stamps, "s", stamps=stamps, name=f"Time {len(self.clocks)}", code=code)
            info = ChannelInfo(key="", name=clock.name, unit="s", quantity="time", code=code)
            self.write(info, clock)
        return self.clocks[key]

    def free(self, wanted: int | None) -> int:
        """The number that a channel has, or if it has none or it is taken, one beyond all that are wanted."""
        if wanted is not None and wanted > 0 and wanted not in self.listed:
            return wanted
        taken = {info.number or 0 for info in self.record.channels.values()} | set(self.listed)
        return max(taken, default=0) + 1


def is_clock(history: TimeHistory) -> bool:
    """Whether a history holds its own times, as the channel does that others take theirs from."""
    return history.stamps is not None and history.unit == "s" and history.values.tobytes() == history.stamps.tobytes()


def merged(kept: Mapping[str, str], ours: Mapping[str, str]) -> list[tuple[str, str]]:
    """The descriptors that were read, in their order, with ours in the place of those that say something else."""
    left = {folded(key): (key, value) for key, value in ours.items()}
    pairs = []
    for key, value in kept.items():
        _, mine = left.pop(folded(key), ("", ""))
        pairs.append((key, value if not mine or _same(value, mine) else mine))
    return pairs + [(key, value) for key, value in left.values() if value or not (kept or key.startswith("."))]


def _same(one: str, other: str) -> bool:
    """Whether two values say the same: as text, or as numbers to the last digit."""
    try:
        return one == other or float(one) == float(other)
    except ValueError:
        return False


def _channel_pairs(info: ChannelInfo, history: TimeHistory, code: str) -> dict[str, str]:
    size = history.filtered.frequency_class if history.filtered else None
    return {
        "Test object number": str(info.vehicle) if info.vehicle else "",
        "Name of the channel": one_line(history.name),
        "Laboratory channel code": "",
        "Customer channel code": "",
        "Channel code": code or UNKNOWN,
        "Unit": {"N m": "Nm", "": "1"}.get(history.unit, one_line(history.unit)),
        "Reference system": "",
        "Transducer type": one_line(info.sensor),
        "Pre-filter type": "",
        "Cut off frequency": "",
        "Channel amplitude class": "",
        # What the file said stays, unless it is what tells the class: its code's letter does, where it has one.
        "Channel frequency class": "" if size is None or (info.fields and code[-1:] in CLASSES) else f"{size:g}",
        "Reference channel": "implicit",
        "Reference channel name": "",
        "Sampling interval": "" if history.interval is None else repr(history.interval),
        "Bit resolution": "",
        "Time of first sample": "" if history.interval is None else repr(history.start),
        "Number of samples": str(len(history)),
        "Data status": one_line(info.status) or "ok",
        ".Meaning": extras.meaning(info),
        ".Filter": extras.filter_text(history.filtered),
    }


def _code_of(history: TimeHistory) -> str:
    """The code to write: with the letter of the class that the history went through, if it says one."""
    if not history.code:
        return ""
    try:
        code = ChannelCode.parse(history.code)
    except InvalidInput:
        return ""
    size = history.filtered.frequency_class if history.filtered else None
    return str(code if size is None or size == code.frequency_class else code.filtered(size))


def _test_pairs(record: TestRecord) -> dict[str, str]:
    pairs = {
        "Data format edition number": "" if record.fields and record.format == FORMAT else "1.6",
        "Laboratory name": one_line(record.laboratory),
        "Title": one_line(record.title),
        "Date of the test": record.date.isoformat() if record.date else "",
        "Number of test objects": str(max((vehicle.number for vehicle in record.vehicles), default=0)),
    }
    for vehicle in record.vehicles:
        if 1 <= vehicle.number <= 9:
            object_ = f"test object {vehicle.number}"
            pairs[f"Name of {object_}"] = one_line(vehicle.name)
            pairs[f"Velocity {object_}"] = "" if vehicle.speed is None else repr(vehicle.speed)
            pairs[f"Mass {object_}"] = "" if vehicle.mass is None else repr(vehicle.mass)
            pairs[f".Fields of {object_}"] = extras.dumped_fields(vehicle.fields)
    pairs[".Closing speed"] = "" if record.closing_speed is None else repr(record.closing_speed)
    pairs[".Barrier"] = extras.dumped(record.barrier) if record.barrier else ""
    if record.occupants != extras.occupants_of(info for info in record.channels.values() if info.readable):
        pairs[".Occupant"] = "\n".join(extras.dumped(occupant) for occupant in record.occupants)
    pairs[".Restraint"] = "\n".join(extras.dumped(restraint) for restraint in record.restraints)
    if record.format != FORMAT:
        pairs[".Source"] = one_line(record.format)
        pairs[".Fields"] = extras.dumped_fields(record.fields)
    return pairs
