"""Tests in ISO-MME 1.6: `<test>.mme`, `Channel/<test>.chn`, and a file for each channel, `Channel/<test>.001`.

The descriptors are read at once, a channel's values when they are asked for. A channel that is listed without a file, or
whose file is not as its descriptors say, is said to be so, and the rest goes on. The unit is the one of the `Unit` line;
where there is none it is the SI unit of the channel code's quantity. Whether and how a channel was filtered is told by the
last character of its code, and only where that is unknown (`?`, `S`) by the channel frequency class.

References:
    ISO/TS 13499, Road vehicles - Multimedia data exchange format for impact tests, and its related electronic document
    A (RED A), version 1.6; the files as laboratories write them. The standard itself was not at hand.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from ridedown import units
from ridedown.errors import InvalidInput
from ridedown.signals import isomme_extras as extras
from ridedown.signals.codes import UNKNOWN, ChannelCode
from ridedown.signals.files import Tree, open_tree
from ridedown.signals.isomme_curves import Channel, explicit, loader
from ridedown.signals.isomme_text import FORMAT, NO_VALUE, Descriptors, by_key, descriptors_of, read_descriptors
from ridedown.signals.isomme_write import write_isomme
from ridedown.signals.numerals import lines_of
from ridedown.signals.record import ChannelInfo, TestRecord, Vehicle

__all__ = ["read_isomme", "recognises", "write_isomme"]

SUFFIX = ".mme"
MAX_CHANNELS = 20_000
"""Channels of one test at most."""
MAX_PROBLEMS = 200
"""Problems kept of one test."""

_Value = TypeVar("_Value", float, int)

_NUMBERED = re.compile(r"\.([0-9]{1,6})$", re.ASCII)
_LISTED = re.compile(r"name of channel *([0-9]{1,6})", re.ASCII)
_WELL = {"", "ok", "good", "valid"}
_EDITION = re.compile(r"([0-9]{1,3})(?:\.[0-9]+)*", re.ASCII)
_DATES = (re.compile(r"(?P<y>[0-9]{4})-(?P<m>[0-9]{1,2})-(?P<d>[0-9]{1,2})", re.ASCII),
          re.compile(r"(?P<d>[0-9]{1,2})\.(?P<m>[0-9]{1,2})\.(?P<y>[0-9]{4})", re.ASCII))  # fmt: skip


def recognises(tree: Tree) -> bool:
    """Whether a folder or a zip holds an ISO-MME test."""
    return bool(tree.find(SUFFIX))


def read_isomme(source: Tree | str | Path) -> TestRecord:
    """The test in a folder, a zip, or beside a file `<test>.mme`.

    Channels are named by their number in the list of channels, and found by their code as well.

    Raises: InvalidInput, naming file and line, where there is no test, several, or one of edition 2.
    """
    tree, name = _opened(source)
    head = descriptors_of(tree.read_text(name), PurePosixPath(name).name)
    edition = head.text("Data format edition number") or head.text("Version")
    if (found := _EDITION.match(edition)) and int(found[1]) >= 2:
        raise InvalidInput(
            f"{head.where}:{head.line('Data format edition number')}: got ISO-MME {edition[:20]}; need an edition "
            "below 2, such as 1.6. "
            "Edition 2 is laid out differently and is not supported: ask the laboratory for a 1.6 export."
        )
    return _Reader(tree, name, head).record()


def _opened(source: Tree | str | Path) -> tuple[Tree, str]:
    if isinstance(source, str | Path):
        path = Path(source)
        if path.suffix.lower() == SUFFIX and path.is_file():
            return open_tree(path), path.name
        tree = open_tree(path)
    else:
        tree = source
    tests = tree.find(SUFFIX)
    if len(tests) != 1:
        found = ", ".join(tests[:3]) + (", ..." if len(tests) > 3 else "") or "none"
        raise InvalidInput(f"ISO-MME test: got {found}; need one file *.mme. Give the folder, the zip or the .mme of one test.")
    return tree, tests[0]


@dataclass
class _Reader:
    """One test on its way to a record; notes what is wrong as it goes."""

    tree: Tree
    name: str
    head: Descriptors
    problems: list[str] = field(default_factory=list)

    def record(self) -> TestRecord:
        channels = self.channels()
        infos = {key: channel.info for key, channel in channels.items()}
        speed = self.tried(self.head.number, ".Closing speed")
        return TestRecord(
            identifier=PurePosixPath(self.name).stem,
            title=self.head.text("Title"),
            date=self.date(),
            laboratory=self.head.text("Laboratory name"),
            format=FORMAT,
            closing_speed=speed,
            vehicles=self.vehicles(),
            occupants=extras.occupants(self.head.all(".Occupant")) or extras.occupants_of(infos.values()),
            restraints=extras.restraints(self.head.all(".Restraint")),
            barrier=extras.barrier(self.head.text(".Barrier")),
            channels=MappingProxyType(infos),
            problems=tuple(self.problems),
            fields=by_key(self.head),
            load=loader(self.tree, channels),
        )

    def note(self, sentence: str) -> None:
        if len(self.problems) < MAX_PROBLEMS:
            self.problems.append(sentence)

    # channels

    def channels(self) -> dict[str, Channel]:
        """Every channel, by its number as text, in the order of their numbers."""
        listed, files = self.listed()
        if len(listed) + len(files) > MAX_CHANNELS:
            raise InvalidInput(f"{self.head.where}: got over {MAX_CHANNELS} channels; need at most that. Split the test.")
        for number in sorted(set(files) - set(listed)):
            self.note(f"{files[number]}: is not in the list of channels; taken all the same")
        return {
            str(number): self.channel(number, listed.get(number, ""), files.get(number, ""))
            for number in sorted({*listed, *files})
        }

    def listed(self) -> tuple[dict[int, str], dict[int, str]]:
        """What the list of channels calls each number, and the file of each number."""
        base = PurePosixPath(self.name.lower()).parent
        lists = [name for name in self.tree.find(".chn") if base in PurePosixPath(name.lower()).parents]
        lists.sort(
            key=lambda name: (PurePosixPath(name.lower()).stem != PurePosixPath(self.name.lower()).stem, len(name), name)
        )
        if not lists:
            self.note(f"{self.head.where}: no list of channels, *.chn; the files of the folder Channel are taken")
            return {}, self.files(base / "channel", None)
        if len(lists) > 1:
            self.note(f"{self.head.where}: several lists of channels; {lists[0]} is taken")
        head = descriptors_of(self.tree.read_text(lists[0]), lists[0])
        listed: dict[int, str] = {}
        for key, value in head:
            if match := _LISTED.fullmatch(key.lower()):
                if int(match[1]) in listed:
                    self.note(f"{lists[0]}: channel {int(match[1])} is listed twice; the first counts")
                listed.setdefault(int(match[1]), value)
        count = self.tried(head.whole, "Number of channels")
        if count is not None and count != len(listed):
            self.note(f"{lists[0]}:{head.line('Number of channels')}: says {count} channels and lists {len(listed)}")
        path = PurePosixPath(lists[0].lower())
        return listed, self.files(path.parent, path.stem)

    def files(self, folder: PurePosixPath, stem: str | None) -> dict[int, str]:
        """Files of a folder with a number for an ending; those named as the list of channels first."""
        found: dict[int, str] = {}
        names = [name for name in self.tree.names() if PurePosixPath(name.lower()).parent == folder and _NUMBERED.search(name)]
        names.sort(key=lambda name: (stem is not None and PurePosixPath(name.lower()).stem != stem, len(name), name))
        for name in names:
            match = _NUMBERED.search(name)
            if match:
                found.setdefault(int(match[1]), name)
        return found

    def channel(self, number: int, listed: str, file: str) -> Channel:
        listed_code, _, listed_name = (part.strip() for part in listed.partition("/"))
        code = self.code(number, "" if listed_code.upper() == NO_VALUE else listed_code)
        if not file:
            self.note(f"channel {number}, {listed or 'without a name'}: is listed, but has no file")
            return Channel(_described(number, code, listed_name, status="no file", readable=False), "", None)
        try:
            head, _ = read_descriptors(lines_of(self.tree.read_text(file)), file)
        except InvalidInput as error:
            self.note(str(error))
            return Channel(_described(number, code, listed_name, status="cannot be read", readable=False), "", None)
        own = head.text("Channel code")
        if own and own.upper() != str(code or UNKNOWN):
            if code:
                self.note(f"{file}: channel code {own[:40]!r}; the list of channels has {code}. The file's own counts")
            code = self.code(number, own)
        return Channel(self.info(number, code, listed_name, head), file, head)

    def info(self, number: int, code: ChannelCode | None, listed_name: str, head: Descriptors) -> ChannelInfo:
        unit = units.recognised(head.text("Unit"))
        if not unit and code and code.default_unit and not head.text("Unit"):
            unit = code.default_unit
            self.note(f"{head.where}: names no unit; {unit} is taken, the SI unit for the channel code {code}")
        status = head.text("Data status")
        status = "" if status.lower() in _WELL else status
        if status:
            self.note(f"{head.where}:{head.line('Data status')}: data status {status[:40]!r}")
        info = _described(
            number,
            code,
            head.text("Name of the channel") or listed_name,
            sensor=head.text("Transducer type"),
            unit=unit,
            start=None if explicit(head) else self.tried(head.number, "Time of first sample"),
            interval=None if explicit(head) else self.tried(head.number, "Sampling interval"),
            samples=self.tried(head.whole, "Number of samples"),
            status=status,
            fields=by_key(head),
        )
        return extras.amended(info, head)

    def code(self, number: int, text: str) -> ChannelCode | None:
        if not text or text == UNKNOWN:
            return None
        try:
            return ChannelCode.parse(text)
        except InvalidInput as error:
            self.note(f"channel {number}: {error}")
            return None

    # what was tested

    def vehicles(self) -> tuple[Vehicle, ...]:
        count = self.tried(self.head.whole, "Number of test objects") or 0
        return tuple(
            Vehicle(
                number=number,
                name=self.head.text(f"Name of test object {number}"),
                mass=self.quantity(f"Mass test object {number}", "kg"),
                speed=self.quantity(f"Velocity test object {number}", "m/s"),
                fields=extras.fields(self.head.text(f".Fields of test object {number}")),
            )
            for number in range(1, min(max(count, 0), 9) + 1)
        )

    def quantity(self, key: str, si: str) -> float | None:
        """A quantity in SI: a bare number is SI already."""
        try:
            given = self.head.quantity(key)
            if given is None:
                return None
            value, unit = given
            return float(units.convert(np.array([value]), unit, si)[0]) if unit else value
        except InvalidInput as error:
            self.note(str(error))
            return None

    def date(self) -> date | None:
        text = self.head.text("Date of the test")
        for form in _DATES:
            if match := form.fullmatch(text):
                try:
                    return date(int(match["y"]), int(match["m"]), int(match["d"]))
                except ValueError:
                    break
        if text:
            self.note(
                f"{self.head.where}:{self.head.line('Date of the test')}: got date {text[:40]!r}; need one such as 2017-10-03"
            )
        return None

    def tried(self, read: Callable[[str], _Value | None], key: str) -> _Value | None:
        """A field, None and a problem where it holds what it may not."""
        try:
            return read(key)
        except InvalidInput as error:
            self.note(str(error))
            return None


def _described(number: int, code: ChannelCode | None, name: str, **said: Any) -> ChannelInfo:
    """A channel as its code describes it."""
    if code is None:
        return ChannelInfo(str(number), number, name, **said)
    return ChannelInfo(
        str(number),
        number,
        name,
        location=code.place,
        quantity=code.kind,
        axis=code.axis,
        vehicle=code.vehicle if code.object != "B" else 0,
        occupant=code.seat,
        code=str(code),
        redundant=code.redundant,
        **said,
    )
