"""Signals in Parquet: a column of times and a column for each channel, units in the columns' metadata.

As `Response.to_parquet` writes it: `time` in s, every field with its `unit`. A column without that metadata may carry its
unit in its name. The footer is read at once; a channel's values when they are asked for.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ridedown import units
from ridedown.errors import InvalidInput
from ridedown.signals import tables
from ridedown.signals.files import InMemory, shown
from ridedown.signals.history import Floats, TimeHistory
from ridedown.signals.record import ChannelInfo, TestRecord

SUFFIXES = (".parquet", ".pq")

MAX_ROWS = 10_000_000
"""Rows of one table at most: ten seconds at 1 MHz; a column of them takes 80 MB."""
MAX_TABLE_BYTES = 4 * 2**30
"""The whole table unpacked at most, as its footer declares; it is read a column at a time."""

_ABOUT = b"ridedown"


def read_parquet(source: str | Path | InMemory) -> TestRecord:
    """The signals in a Parquet file, a channel for each column of numbers.

    Raises: InvalidInput, naming the file, for what is no Parquet table, has no column of times, or is larger than a test is.
    """
    path = source if isinstance(source, InMemory) else Path(source)
    where = shown(path.name)
    with _opened(path) as file:
        columns = _columns(file, where)
        headings = [(column.name, column.unit) for column in columns]
        at = tables.column_of_times(headings, where)
        said = tables.parsed((file.schema_arrow.metadata or {}).get(_ABOUT, b"").decode("utf-8", "replace"))
        times = units.convert(_values(file, columns[at], where), columns[at].unit or "s")
        if len(times) != file.metadata.num_rows:
            raise InvalidInput(
                f"{where}: got {len(times)} times; need {file.metadata.num_rows}, as its footer says. Write it again."
            )
    said = said if isinstance(said, dict) else {}
    grid = tables.grid_of(times, where, said.get("clock"))
    channels = [column for i, column in enumerate(columns) if i != at]
    loader = _Loader(path, where, times, grid, {column.name: column for column in channels})
    test = said.get("test")
    header = {k: v for k, v in test.items() if isinstance(v, str)} if isinstance(test, dict) else {}
    return TestRecord(
        identifier=header.get("identifier", path.stem),
        title=header.get("title", ""),
        laboratory=header.get("laboratory", ""),
        format="Parquet",
        channels=MappingProxyType({column.name: _info(column, i, len(times)) for i, column in enumerate(channels, start=1)}),
        problems=tuple(problem for column in channels for problem in column.problems(where)),
        load=loader,
    )


@dataclass(frozen=True, slots=True)
class _Column:
    """A column as the footer describes it; `fault`: why it cannot be read, empty where it can."""

    name: str
    field: str
    unit: str | None
    about: Any
    fault: str = ""

    def problems(self, where: str) -> Iterator[str]:
        if self.fault:
            yield f"{where}: column {self.name[:60]!r} {self.fault}"
        elif self.unit is None:
            yield f"{where}: column {self.name[:60]!r} has no unit; its values are taken as bare numbers"
        elif not units.is_known(self.unit):
            yield f"{where}: column {self.name[:60]!r} is in {self.unit[:40]!r}, a unit that is not known"


@dataclass(frozen=True, slots=True)
class _Loader:
    path: Path | InMemory
    where: str
    times: Floats
    grid: tables.Grid
    columns: Mapping[str, _Column]

    def __call__(self, info: ChannelInfo) -> TimeHistory:
        column = self.columns[info.key]
        if column.fault:
            raise InvalidInput(f"{self.where}: column {column.name[:60]!r} {column.fault}. Write it again as numbers.")
        with _opened(self.path) as file:
            values = _values(file, column, self.where)
        if len(values) != len(self.times):
            raise InvalidInput(f"{self.where}: got {len(values)} values in {column.name[:60]!r}; need {len(self.times)}.")
        return tables.column(column.name, values, self.times, self.grid, column.unit or "", column.about, self.where)


def _info(column: _Column, number: int, samples: int) -> ChannelInfo:
    code = column.about.get("code") if isinstance(column.about, dict) else None
    return tables.with_meaning_of(
        ChannelInfo(
            key=column.name,
            number=number,
            name=column.name,
            unit=column.unit or "",
            samples=samples,
            status="cannot be read" if column.fault else "",
            code=code[:40] if isinstance(code, str) else None,
            readable=not column.fault,
        ),
        column.about,
    )


@contextmanager
def _opened(path: Path | InMemory) -> Iterator[Any]:
    """The file as pyarrow sees it; whatever pyarrow makes of a damaged one is an InvalidInput."""
    import pyarrow as pa  # noqa: PLC0415  slow to import, and few runs need it
    import pyarrow.parquet as pq  # noqa: PLC0415

    try:
        with path.open("rb") as raw, pq.ParquetFile(raw) as file:
            yield file
    except InvalidInput:
        raise
    except OSError as problem:
        why = problem.strerror or " ".join(str(problem).split())[:200]
        raise InvalidInput(f"{shown(path.name)}: cannot be read as Parquet ({why}). Write the file again.") from problem
    except (pa.ArrowException, ValueError, TypeError, KeyError, IndexError, MemoryError, OverflowError) as problem:
        raise InvalidInput(f"{shown(path.name)}: got a damaged Parquet file; need a whole one. Write it again.") from problem


def _columns(file: Any, where: str) -> list[_Column]:
    import pyarrow as pa  # noqa: PLC0415

    if not 0 < file.metadata.num_rows <= MAX_ROWS:
        raise InvalidInput(f"{where}: got {file.metadata.num_rows} rows; need 1 .. {MAX_ROWS}. Split the table.")
    schema = file.schema_arrow
    if len(schema) > tables.MAX_COLUMNS:
        raise InvalidInput(f"{where}: got {len(schema)} columns; need at most {tables.MAX_COLUMNS}. Split the table.")
    # Not asked of each column: pyarrow 26 ends the process where the statistics of a damaged column do not add up.
    size = sum(file.metadata.row_group(i).total_byte_size for i in range(file.metadata.num_row_groups))
    if size > MAX_TABLE_BYTES:
        raise InvalidInput(f"{where}: got {size} bytes unpacked; need at most {MAX_TABLE_BYTES}. Split the table.")
    parsed = []
    for i, field in enumerate(schema):
        about = {k.decode("utf-8", "replace"): v.decode("utf-8", "replace") for k, v in (field.metadata or {}).items()}
        name, unit = (field.name, units.recognised(about["unit"])) if "unit" in about else tables.name_and_unit(field.name)
        fault = ""
        if not (pa.types.is_integer(field.type) or pa.types.is_floating(field.type) or pa.types.is_decimal(field.type)):
            fault = "holds no numbers"
        elif len(schema.get_all_field_indices(field.name)) > 1:
            fault = "has the name of another"
        parsed.append(_Column(name, schema.field(i).name, unit, tables.parsed(about.get("ridedown", "")), fault))
    names = tables.distinct([column.name for column in parsed])
    return [_Column(name, c.field, c.unit, c.about, c.fault) for name, c in zip(names, parsed, strict=True)]


def _values(file: Any, column: _Column, where: str) -> Floats:
    """A column's values (n,), NaN where there is none."""
    if column.fault:
        raise InvalidInput(f"{where}: column {column.name[:60]!r} {column.fault}. Write it again as numbers.")
    import pyarrow as pa  # noqa: PLC0415

    table = file.read(columns=[column.field], use_threads=False)
    if table.num_columns != 1:
        raise InvalidInput(
            f"{where}: got {table.num_columns} columns called {column.field[:60]!r}; need one. Rename the others."
        )
    stored = table.column(0)
    values: Floats = np.asarray(stored.cast(pa.float64(), safe=False).to_numpy(), dtype=np.float64)
    if np.isinf(values).any():
        raise InvalidInput(
            f"{where}: got an infinite value in {column.name[:60]!r}, row {int(np.argmax(np.isinf(values))) + 1}; need finite "
            "numbers. Mend the recording there."
        )
    return values


def write_parquet(record: TestRecord, path: str | Path) -> tuple[str, ...]:
    """Write a record's channels as a table (zstd), units, codes and filter states in the metadata; reads back identical.

    The file is written aside and takes its place when it is whole. Gives a sentence for each channel that was left out, since
    it cannot be read.

    Raises: InvalidInput where the channels do not share their times.
    """
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    table = tables.side_by_side(record)
    times, histories = table.times, table.histories
    names = ["time", *histories]
    if tables.distinct(names) != names:
        raise InvalidInput("channels: got a channel named 'time' or one with a very long name; need others. Rename it.")
    fields, columns = [pa.field("time", pa.float64(), metadata={"unit": "s"})], [pa.array(times)]
    for name, history in histories.items():
        about = tables.about_of(history, table.infos[name])
        metadata = {"unit": history.unit} | ({"ridedown": json.dumps(about)} if about else {})
        fields.append(pa.field(name, pa.float64(), metadata=metadata))
        columns.append(pa.concat_arrays([pa.array(history.values), pa.nulls(len(times) - len(history), pa.float64())]))
    test = {"identifier": record.identifier, "title": record.title, "laboratory": record.laboratory}
    said = {"test": {k: v for k, v in test.items() if v}, "clock": {"interval": table.interval}}
    schema = pa.schema(fields, metadata={_ABOUT: json.dumps(said)})
    with tables.written_aside(Path(path)) as aside:
        pq.write_table(pa.table(columns, schema=schema), aside, compression="zstd")
    return table.left_out
