"""Signals in delimited text: CSV and TSV with units in the header, a column of times and a column for each channel.

Headings are `name [unit]`, as this package writes them, `name (unit)`, or `name_unit`; or a second line holds the units.
Columns are set apart by commas, semicolons or tabs; with the last two, decimal commas are understood. Lines before the
header that begin with # or % or // are comments.
"""

from __future__ import annotations

import csv
import json
import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ridedown import units
from ridedown.errors import InvalidInput
from ridedown.signals import tables
from ridedown.signals.files import MAX_FILE_BYTES, InMemory, Tree, decoded, read_bounded, shown
from ridedown.signals.history import Floats, TimeHistory
from ridedown.signals.numerals import numbers_of
from ridedown.signals.record import ChannelInfo, TestRecord, info_of

SUFFIXES = (".csv", ".tsv", ".txt")

_COMMENTS = ("#", "%", "//")
_MARK = "# ridedown: "
_MISSING = frozenset({"", "nan", "na", "n/a", "null", "none", "novalue", "-"})
_BLOCK = 4096  # lines that are taken apart at once: cells as texts are ten times as large as the numbers
_COMMA_NUMBER = re.compile(r"^([\s\"+-]*[0-9]*),([0-9]*(?:[eE][+-]?[0-9]+)?[\s\"]*)$", re.ASCII)


def read_delimited(source: str | Path | InMemory | Tree, name: str | None = None) -> TestRecord:
    """The signals in a CSV or TSV file, a channel for each column; or in the file `name` of a tree.

    A column that ends early or begins late is read as far as it goes and says so in its remarks; one with a gap cannot be
    read, and the others can.

    Raises: InvalidInput, naming file and line, for what is no table of numbers with headings, has no times, or is larger than
    a test is (see `ridedown.signals.files`).
    """
    if isinstance(source, Tree):
        file = name or source.names()[0]
        text = source.read_text(file)
    else:
        path = source if isinstance(source, InMemory) else Path(source)
        file = path.name
        text = decoded(_bytes_of(path), file)
    return _record(_table(text, shown(Path(file).name)), Path(file).stem)


def _bytes_of(path: Path | InMemory) -> bytes:
    try:
        with path.open("rb") as file:
            content = read_bounded(file, MAX_FILE_BYTES + 1)
    except OSError as problem:
        raise InvalidInput(
            f"path: got {path}, which cannot be read ({problem.strerror}); need a file. Check the path."
        ) from problem
    if len(content) > MAX_FILE_BYTES:
        raise InvalidInput(
            f"{shown(path.name)}: got more than {MAX_FILE_BYTES >> 20} MiB; need less. Write it as Parquet, or lower its rate."
        )
    return content


# taking the text apart


@dataclass(frozen=True, slots=True)
class _Table:
    """A text taken apart: headings, rows (n, m), NaN where a cell is empty, and what the comments say of the columns."""

    where: str
    names: list[str]
    units: list[str | None]
    rows: Floats
    about: dict[str, Any]


def _table(text: str, where: str) -> _Table:
    lines = text.split("\n")
    while lines and not lines[-1].strip():
        lines.pop()
    about: dict[str, Any] = {}
    at = 0
    while at < len(lines) and (not lines[at].strip() or lines[at].lstrip().startswith(_COMMENTS)):
        said = tables.parsed(lines[at].removeprefix(_MARK)) if lines[at].startswith(_MARK) else None
        if isinstance(said, dict):
            about |= said
        at += 1
    if at == len(lines):
        raise InvalidInput(f"{where}:{at + 1}: got no header; need names with units, such as time [s],pulse [g]. Add one.")
    delimiter = _delimiter(lines[at])
    headings = _cells(lines[at], delimiter, f"{where}:{at + 1}")
    _check_header(headings, f"{where}:{at + 1}")
    bracketed = any("[" in heading for heading in headings)
    columns = [tables.name_and_unit(heading, suffixes=not bracketed) for heading in headings]
    names, spelled = [name for name, _ in columns], [unit for _, unit in columns]
    if not any(unit is not None for unit in spelled) and at + 1 < len(lines):
        row_of_units = _row_of_units(lines[at + 1], delimiter, len(headings))
        if row_of_units:
            spelled, at = list(row_of_units), at + 1
    rows = _rows(lines[at + 1 :], delimiter, len(headings), where, at + 2)
    return _Table(where, tables.distinct(names), spelled, rows, about)


def _delimiter(header: str) -> str:
    bare = re.sub(r'"[^"]*"|\[[^\]]*\]|\([^)]*\)', "", header)
    return next((mark for mark in ("\t", ";", ",") if mark in bare), ",")


def _cells(line: str, delimiter: str, where: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]
    except (csv.Error, StopIteration) as problem:
        raise InvalidInput(
            f"{where}: got a header that cannot be taken apart ({problem}); need one cell a column."
        ) from problem


def _check_header(headings: Sequence[str], where: str) -> None:
    if len(headings) > tables.MAX_COLUMNS:
        raise InvalidInput(f"{where}: got {len(headings)} columns; need at most {tables.MAX_COLUMNS}. Split the table.")
    if all(_is_number(heading) for heading in headings):
        raise InvalidInput(
            f"{where}: got numbers in the first line; need names with units, such as time [s],pulse [g]. Add them."
        )
    if not all(_is_text(heading) for heading in headings):
        raise InvalidInput(f"{where}: got a header that is no text; need names with units, such as time [s],pulse [g].")


def _is_text(heading: str) -> bool:
    """Whether a heading can be printed; spaces of any width may stand in it."""
    return all(mark.isprintable() or unicodedata.category(mark) == "Zs" for mark in heading)


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _row_of_units(line: str, delimiter: str, width: int) -> list[str] | None:
    """The units in a line of its own, None where the line holds anything else."""
    cells = [cell.strip().strip("[]()") for cell in line.split(delimiter)]
    if len(cells) != width or any(_is_number(cell) and cell != "1" for cell in cells):
        return None
    if not any(cells) or not all(units.is_known(cell) for cell in cells):
        return None
    return [units.spelled(cell) for cell in cells]


def _rows(lines: Sequence[str], delimiter: str, width: int, where: str, first: int) -> Floats:
    """The numbers of all lines (n, width); NaN where a cell is empty."""
    if len(lines) * width * 8 > 4 * MAX_FILE_BYTES:  # empty cells take more room as numbers than as text
        raise InvalidInput(f"{where}: got {len(lines)} lines of {width} columns; need fewer. Split the table.")
    if not lines:
        raise InvalidInput(f"{where}:{first}: got no values below the header; need one line at least. Check what was written.")
    if delimiter != "," and any("," in line for line in lines) and any("." in line for line in lines):
        number = next(n for n, line in enumerate(lines, start=first) if "," in line)
        raise InvalidInput(
            f"{where}:{number}: got decimal commas and decimal points; need one of them. Drop what groups digits."
        )
    rows = np.empty((len(lines), width))
    for block in range(0, len(lines), _BLOCK):
        cells = []
        for number, line in enumerate(lines[block : block + _BLOCK], start=first + block):
            parts = line.split(delimiter)
            if len(parts) != width:
                raise InvalidInput(
                    f"{where}:{number}: got {len(parts)} cells; need {width} as in the header. Correct the line or the header."
                )
            cells += parts
        rows[block : block + _BLOCK] = _numbers(cells, delimiter, where, first + block, width).reshape(-1, width)
    return rows


def _numbers(cells: list[str], delimiter: str, where: str, first: int, width: int) -> Floats:
    """Each cell's number, NaN for an empty one; the cells run along the lines, `width` to each."""
    if delimiter != ",":
        cells = [_COMMA_NUMBER.sub(r"\1.\2", cell) if "," in cell else cell for cell in cells]
    try:
        return numbers_of(cells, where)
    except InvalidInput:  # an empty cell, or worse: one by one, to tell which
        values = np.empty(len(cells))
        for i, cell in enumerate(cells):
            text = cell.strip().strip('"').strip()
            values[i] = np.nan if text.lower() in _MISSING else numbers_of([text], where, first + i // width)[0]
        return values


# the table as a record


def _record(table: _Table, stem: str) -> TestRecord:
    at = tables.column_of_times(list(zip(table.names, table.units, strict=True)), table.where)
    times = units.convert(table.rows[:, at], table.units[at] or "s")
    if np.isnan(times).any():
        raise InvalidInput(f"{table.where}: got no time in row {int(np.argmax(np.isnan(times))) + 1}; need one in each row.")
    grid = tables.grid_of(times, table.where, table.about.get("clock"))
    if len(table.names) < 2:
        raise InvalidInput(
            f"{table.where}: got times and nothing else; need a column beside them. Check what sets columns apart."
        )
    about = table.about.get("channels")
    curves: dict[str, TimeHistory] = {}
    infos: dict[str, ChannelInfo] = {}
    problems: list[str] = []
    failed: dict[str, str] = {}
    for i, (name, unit) in enumerate(zip(table.names, table.units, strict=True)):
        if i == at:
            continue
        try:
            said = about.get(name) if isinstance(about, dict) else None
            curves[name] = tables.column(name, table.rows[:, i], times, grid, unit or "", said, table.where)
            infos[name] = tables.with_meaning_of(info_of(curves[name], number=i), said)
        except InvalidInput as problem:
            failed[name] = str(problem)
            infos[name] = ChannelInfo(name, number=i, name=name, unit=unit or "", status="cannot be read", readable=False)
        problems += _doubts(name, unit, table.where)
    problems += failed.values()

    def load(info: ChannelInfo) -> TimeHistory:
        if info.key in failed:
            raise InvalidInput(failed[info.key])
        return curves[info.key]

    test = table.about.get("test")
    header = {k: v for k, v in test.items() if isinstance(v, str)} if isinstance(test, dict) else {}
    return TestRecord(
        identifier=header.get("identifier", stem),
        title=header.get("title", ""),
        laboratory=header.get("laboratory", ""),
        format="CSV",
        channels=MappingProxyType(infos),
        problems=tuple(problems),
        load=load,
    )


def _doubts(name: str, unit: str | None, where: str) -> tuple[str, ...]:
    if unit is None:
        return (f"{where}: column {name[:60]!r} has no unit; its values are taken as bare numbers",)
    if not units.is_known(unit):
        return (f"{where}: column {name[:60]!r} is in {unit[:40]!r}, a unit that is not known; its values cannot be converted",)
    return ()


# writing


def write_delimited(record: TestRecord, path: str | Path, *, delimiter: str = ",") -> tuple[str, ...]:
    """Write a record's channels as a table, each in its own unit: `time [s],head x [g],...`; reads back identical.

    Every number has the digits that bring back the very same double. Channel codes and filter states stand in comment lines
    above the header. A tab makes it TSV. The file is written aside and takes its place when it is whole. Gives a sentence for
    each channel that was left out, since it cannot be read.

    Raises: InvalidInput where the channels do not share their times, or a name cannot stand in a header.
    """
    table = tables.side_by_side(record)
    histories = table.histories
    headings = ["time [s]", *(f"{name} [{history.unit}]" for name, history in histories.items())]
    quoted = [f'"{heading}"' if delimiter in heading else heading for heading in headings]
    _check_names(delimiter.join(quoted), delimiter, list(histories))
    columns = [history.values.tolist() for history in histories.values()]
    with tables.written_aside(Path(path)) as aside, aside.open("x", encoding="utf-8", newline="\n") as file:
        for line in _comments(record, table):
            file.write(f"{_MARK}{line}\n")
        file.write(delimiter.join(quoted) + "\n")
        for i, time in enumerate(table.times.tolist()):
            cells = (repr(values[i]) if i < len(values) else "" for values in columns)
            file.write(delimiter.join((repr(time), *cells)) + "\n")
    return table.left_out


def _check_names(header: str, delimiter: str, names: list[str]) -> None:
    """Raises: InvalidInput where the header would not read back as these names."""
    headings = _cells(header, delimiter, "channels") if _is_text(header) or delimiter == "\t" else []
    back = tables.distinct([tables.name_and_unit(heading)[0] for heading in headings])[1:]
    if delimiter not in _delimiter(header) or back != names:
        bad = next((name for name, read in zip(names, [*back, *[""] * len(names)], strict=False) if name != read), names[0])
        raise InvalidInput(
            f"channels: got the name {bad[:60]!r}; a header has no place for quotes, line ends, outer spaces or "
            f"{delimiter!r} in brackets. Rename the channel."
        )


def _comments(record: TestRecord, table: tables.Table) -> list[str]:
    test = {"identifier": record.identifier, "title": record.title, "laboratory": record.laboratory}
    said = {key: about for key, history in table.histories.items() if (about := tables.about_of(history, table.infos[key]))}
    lines = [{"test": {k: v for k, v in test.items() if v}}, {"clock": {"interval": table.interval}}]
    return [json.dumps(line, ensure_ascii=False) for line in (*lines, *([{"channels": said}] if said else []))]
