"""Tests of the NHTSA crash test database in EV5 ASCII: a header `vNNNNN.EV5` and a file for each curve, `vNNNNN.CCC`.

The header is read at once, a curve when it is asked for. A channel whose file is missing, that the laboratory calls
questionable or meaningless, or that ends before the others, is said to be so, and the rest goes on.

References:
    NHTSA Test Reference Guide, Version 5, Volume I: Vehicle Tests (November 2014).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path, PurePosixPath
from types import MappingProxyType
from typing import TypeVar

from ridedown import units
from ridedown.errors import InvalidInput
from ridedown.signals import ev5_codes as codes
from ridedown.signals.ev5_curves import Grid, read_curve
from ridedown.signals.ev5_header import MAX_PROBLEMS, Header, Row, read_header
from ridedown.signals.ev5_results import official_results
from ridedown.signals.files import Tree, open_tree
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import Barrier, ChannelInfo, Load, Occupant, Restraint, TestRecord, Vehicle

SUFFIX = ".ev5"
MAX_CHANNELS = 20_000
"""Channels of one test at most; the largest of the database have some 1,500."""

_SEAT = re.compile(r"[0-9]{1,2}", re.ASCII)
_CURVE = re.compile(r"[0-9]{1,6}", re.ASCII)
_KMH = 1.0 / 3.6
_Value = TypeVar("_Value", float, int, date)


def recognises(tree: Tree) -> bool:
    """Whether a folder or a zip holds an EV5 header."""
    return bool(tree.find(SUFFIX))


def read_ev5(source: Tree | str | Path) -> TestRecord:
    """The test in a folder, a zip, or beside a header file `vNNNNN.EV5`.

    Speeds are SI; channels keep the units of the header, and are named by their number: `record.history("1")`.

    Raises: InvalidInput, naming file and line, where there is no header, several, or one that cannot be read.
    """
    tree, header_name = _opened(source)
    header = read_header(tree.read_text(header_name), PurePosixPath(header_name).name)
    files = _curve_files(tree.names(), header_name)
    return _Reader(tree, header_name, header, files).record()


def _opened(source: Tree | str | Path) -> tuple[Tree, str]:
    """The tree, and the name of its one header."""
    if isinstance(source, str | Path):
        path = Path(source)
        if path.suffix.lower() == SUFFIX and path.is_file():
            return open_tree(path), path.name
        tree = open_tree(path)
    else:
        tree = source
    headers = tree.find(SUFFIX)
    if len(headers) != 1:
        found = ", ".join(headers[:3]) + (", ..." if len(headers) > 3 else "") or "none"
        raise InvalidInput(f"EV5 header: got {found}; need one file *.EV5. Give the folder, the zip or the header of one test.")
    return tree, headers[0]


def _curve_files(names: Iterable[str], header_name: str) -> dict[int, str]:
    """Curve number to file name: beside the header, of its name but for letter case, with digits for an ending."""
    header = PurePosixPath(header_name.lower())
    files: dict[int, str] = {}
    for name in sorted(names, key=len):  # 001 wins over 0001, whatever the order of the folder
        path = PurePosixPath(name.lower())
        if path.parent == header.parent and path.stem == header.stem and _CURVE.fullmatch(path.suffix[1:]):
            files.setdefault(int(path.suffix[1:]), name)
    return files


@dataclass
class _Reader:
    """One header on its way to a record; notes what is wrong as it goes."""

    tree: Tree
    header_name: str
    header: Header
    files: Mapping[int, str]
    problems: list[str] = field(default_factory=list)

    @property
    def where(self) -> str:
        return PurePosixPath(self.header_name).name

    def record(self) -> TestRecord:
        self.problems += self.header.problems
        test = next(iter(self.header.rows("TEST")), Row(0, {}))
        dummies = {
            (self.whole(row, "VEHNO") or 1, seat_of(row.text("OCCLOC"))): (
                row.text("OCCTYP").upper(),
                _size(row.text("DUMMSIZ")),
            )
            for row in self.header.rows("OCCUPANT")
        }
        channels = self.channels(dummies)
        total = self.whole(test, "TOTCRV")
        if total is not None and total != len(self.header.rows("INSTRUMENTATION")):
            self.note(test, f"TOTCRV is {total}, but {len(self.header.rows('INSTRUMENTATION'))} channels are listed")
        return self.assembled(test, channels)

    # channels

    def channels(self, dummies: Mapping[tuple[int, str], tuple[str, str]]) -> dict[str, _Channel]:
        """Every channel of the header by its number as text, in the order of the header."""
        rows = self.header.rows("INSTRUMENTATION")
        if len(rows) > MAX_CHANNELS:
            raise InvalidInput(f"{self.where}: got {len(rows)} channels; need at most {MAX_CHANNELS}. Split the test.")
        ends = Counter(grid.end for row in rows if (grid := self.grid(row)))
        common = max(ends, key=lambda end: (ends[end], end), default=None)
        found: dict[str, _Channel] = {}
        for row in rows:
            number = self.whole(row, "CURNO")
            if number is None or number < 0:
                self.note(row, "INSTRUMENTATION without a curve number; left out")
            elif str(number) in found:
                self.note(row, f"curve {number} is listed twice; the second is left out")
            else:
                found[str(number)] = self.channel(row, number, dummies, common)
        self.tell_missing(found)
        return found

    def channel(
        self, row: Row, number: int, dummies: Mapping[tuple[int, str], tuple[str, str]], common_end: float | None
    ) -> _Channel:
        vehicle = self.whole(row, "VEHNO")
        vehicle = 0 if vehicle is None else vehicle
        seat = seat_of(row.text("SENLOC"))
        place = codes.place_of(row.text("SENATT"), row.text("INSCOM"))
        axis, unit = codes.axis_of(row.text("AXIS")), units.recognised(row.text("YUNITS"))
        redundant = row.text("CHSTAT").upper() == "R"
        code = codes.iso_code(
            vehicle=vehicle,
            seat=seat,
            dummy=dummies.get((vehicle, seat), ("", "")),
            sensor=row.text("SENTYP"),
            place=place,
            axis=axis,
            unit=unit,
            redundant=redundant,
        )
        grid = self.grid(row)
        status = codes.STATUSES.get(row.text("DASTAT").upper(), row.text("DASTAT"))
        file = self.files.get(number, "")
        if status in {"questionable", "meaningless"}:
            self.note(row, f"curve {number}, {row.text('INSCOM')}, is {status}")
        if grid and common_end is not None and grid.end < common_end - 1.5 * grid.interval:
            self.note(row, f"curve {number}, {row.text('INSCOM')}, ends early, at {grid.end:g} s of {common_end:g} s")
        info = ChannelInfo(
            key=str(number),
            number=number,
            name=row.text("INSCOM"),
            sensor=row.text("SENTYP"),
            location=place,
            attachment=row.text("SENATT"),
            quantity=codes.kind_of(row.text("SENTYP"), unit),
            axis=axis,
            unit=unit,
            start=grid.start if grid else None,
            interval=grid.interval if grid else None,
            samples=grid.count if grid else None,
            status=status if file else "; ".join(filter(None, ("no file", status))),
            vehicle=vehicle,
            occupant=seat or None,
            code=code,
            redundant=redundant,
            readable=bool(file),
            fields=_raw(row),
        )
        return _Channel(info, file, grid, row.text("XUNITS"))

    def grid(self, row: Row) -> Grid | None:
        """When a channel was sampled, None where the header does not say, or says what cannot be."""
        try:
            first, last, step = row.whole("NFP"), row.whole("NLP"), row.number("DELT")
        except InvalidInput:
            return None
        if first is None or last is None or step is None or not 0.0 < step <= 1e9 or last < first:
            return None
        return Grid(first, last, step / 1e6)

    def tell_missing(self, channels: Mapping[str, _Channel]) -> None:
        """One sentence for all the channels that have no file."""
        missing = [channel.info.number or 0 for channel in channels.values() if not channel.file]
        if missing:
            self.problems.append(f"{self.where}: {len(missing)} of {len(channels)} channels have no file: {_ranges(missing)}")
        spare = sorted(set(self.files) - {channel.info.number for channel in channels.values()})
        if spare:
            self.problems.append(f"{self.where}: curve files that the header does not list: {_ranges(spare)}")

    # the record

    def assembled(self, test: Row, channels: Mapping[str, _Channel]) -> TestRecord:
        speed = self.number(test, "CLSSPD")
        return TestRecord(
            identifier=PurePosixPath(self.header_name).stem,
            title=test.text("TITLE"),
            date=self.date(test, "TSTDAT"),
            laboratory=test.text("TSTPRF"),
            format="NHTSA EV5",
            closing_speed=None if speed is None else speed * _KMH,
            vehicles=tuple(self.vehicle(row) for row in self.header.rows("VEHICLE")),
            occupants=tuple(self.occupant(row) for row in self.header.rows("OCCUPANT")),
            restraints=tuple(self.restraint(row) for row in self.header.rows("RESTRAINT")),
            barrier=next((_barrier(row) for row in self.header.rows("BARRIER")), None),
            channels=MappingProxyType({key: channel.info for key, channel in channels.items()}),
            problems=tuple(self.problems),
            fields=_raw(test),
            load=_loader(self.tree, channels),
        )

    def vehicle(self, row: Row) -> Vehicle:
        mass, speed = self.number(row, "VEHTWT"), self.number(row, "VEHSPD")
        return Vehicle(
            number=self.whole(row, "VEHNO") or 0,
            # Make and model are numbers of the guide's lists, and not at hand in words; the title tells them.
            name=" ".join(filter(None, (row.text("YEAR"), row.text("MAKE"), row.text("MODEL")))),
            mass=mass if mass and mass > 0.0 else None,
            speed=None if speed is None else speed * _KMH,
            fields=_raw(row),
        )

    def occupant(self, row: Row) -> Occupant:
        official, problems = official_results(row)
        self.problems += [f"{self.where}: {problem}" for problem in problems]
        kind = row.text("OCCTYP").upper()
        return Occupant(
            seat=seat_of(row.text("OCCLOC")) or row.text("OCCLOC"),
            vehicle=self.whole(row, "VEHNO") or 1,
            dummy=codes.DUMMIES.get(kind, kind),
            percentile=_size(row.text("DUMMSIZ")),
            official=official,
            fields=_raw(row),
        )

    def restraint(self, row: Row) -> Restraint:
        return Restraint(
            seat=seat_of(row.text("OCCLOC")) or row.text("OCCLOC"),
            vehicle=self.whole(row, "VEHNO") or 1,
            kind=row.text("RSTTYP"),
            mount=row.text("RSTMNT"),
            deployment=row.text("DEPLOY"),
            comment=row.text("RSTCOM"),
            fields=_raw(row),
        )

    # fields that may be wrong

    def number(self, row: Row, name: str) -> float | None:
        return self.tried(row.number, name)

    def whole(self, row: Row, name: str) -> int | None:
        return self.tried(row.whole, name)

    def date(self, row: Row, name: str) -> date | None:
        return self.tried(row.date, name)

    def tried(self, read: Callable[[str], _Value | None], name: str) -> _Value | None:
        """A field, None and a problem where it holds what it may not."""
        try:
            return read(name)
        except InvalidInput as error:
            if len(self.problems) < MAX_PROBLEMS:
                self.problems.append(f"{self.where}: {error}")
            return None

    def note(self, row: Row, sentence: str) -> None:
        if len(self.problems) < MAX_PROBLEMS:
            self.problems.append(f"{self.where}:{row.line}: {sentence}")


@dataclass(frozen=True, slots=True)
class _Channel:
    """A channel, and what it takes to read its curve."""

    info: ChannelInfo
    file: str
    grid: Grid | None
    time_unit: str


def _loader(tree: Tree, channels: Mapping[str, _Channel]) -> Load:
    def load(info: ChannelInfo) -> TimeHistory:
        channel = channels[info.key]
        if not channel.file:
            raise InvalidInput(
                f"channel {info.key}: got no curve file for {info.name!r}; need one. Fetch the test again, whole."
            )
        if units.recognised(channel.time_unit) not in {"s", ""}:
            raise InvalidInput(
                f"channel {info.key}: got XUNITS {channel.time_unit!r}; need SEC. This curve is no time history."
            )
        curve = read_curve(tree.read_text(channel.file), channel.grid, channel.file)
        return TimeHistory(
            curve.values,
            info.unit,
            start=curve.start,
            interval=curve.interval,
            stamps=curve.stamps,
            name=info.name,
            code=info.code,
            remarks=curve.remarks,
        )

    return load


def _barrier(row: Row) -> Barrier:
    return Barrier(kind=row.text("BARRIG"), shape=row.text("BARSHP"), fields=_raw(row))


def _raw(row: Row) -> Mapping[str, str]:
    """The fields of a record by name, those that have none as FIELD<n>, counted from 1."""
    extra = {f"FIELD{len(row.fields) + i}": value for i, value in enumerate(row.extra, start=1)}
    return MappingProxyType({**row.fields, **extra})


def seat_of(text: str) -> str:
    """A seat as two digits, `01`, empty where the text is none (`NA`, empty)."""
    return text.zfill(2) if _SEAT.fullmatch(text) else ""


def _size(text: str) -> str:
    """A dummy's percentile as two digits: `5` and `05` are the same."""
    return text.zfill(2) if _SEAT.fullmatch(text) else text


def _ranges(numbers: Iterable[int]) -> str:
    """Numbers, ascending, with runs as `4-12`; the first 20 runs of them."""
    runs: list[list[int]] = []
    for number in sorted(numbers):
        if runs and number == runs[-1][1] + 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    shown = ", ".join(f"{first}" if first == last else f"{first}-{last}" for first, last in runs[:20])
    return shown + (", ..." if len(runs) > 20 else "")
