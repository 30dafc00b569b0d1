"""Parquet tables are read by their columns' metadata, a column when it is asked for, and refused where they are no signals."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from ridedown.errors import InvalidInput
from ridedown.signals import Filter, TestRecord, TimeHistory, parquet, read, write
from ridedown.signals.parquet import read_parquet

TIMES = [0.0, 0.1, 0.2]


def stored(
    path: Path, columns: dict[str, object], units: dict[str, str] | None = None, times: list[float] | None = None
) -> Path:
    columns = {"time": TIMES if times is None else times, **columns}
    units = {"time": "s", **(units or {})}
    arrays = {name: values if isinstance(values, pa.Array) else pa.array(values) for name, values in columns.items()}
    fields = [
        pa.field(name, array.type, metadata={"unit": units[name]} if name in units else None) for name, array in arrays.items()
    ]
    pq.write_table(pa.table(list(arrays.values()), schema=pa.schema(fields)), path)
    return path


def test_units_come_from_the_metadata_or_the_name(tmp_path):
    path = stored(tmp_path / "t.parquet", {"a": [1.0, 2.0, 3.0], "b [mm]": [1, 2, 3], "c": [1.0] * 3}, {"a": "G'S"})
    record = read_parquet(path)
    assert [(info.key, info.unit, info.samples) for info in record.channels.values()] == [
        ("a", "g", 3),
        ("b", "mm", 3),
        ("c", "", 3),
    ]
    assert record.problems == ("t.parquet: column 'c' has no unit; its values are taken as bare numbers",)
    assert record.history("b").si[1].tolist() == [0.001, 0.002, 0.003]
    assert record.history("a").interval == 0.1


@pytest.mark.parametrize(
    "kind", [pa.float32(), pa.float16(), pa.int8(), pa.uint64(), pa.decimal128(10, 2)], ids=str
)  # fmt: skip
def test_any_kind_of_number_is_read(tmp_path, kind):
    values = [Decimal(1), Decimal(2), Decimal(3)] if pa.types.is_decimal(kind) else np.array([1, 2, 3], kind.to_pandas_dtype())
    path = stored(tmp_path / "t.parquet", {"a [g]": pa.array(values, kind)})
    assert read_parquet(path).history("a").values.tolist() == [1.0, 2.0, 3.0]


def test_a_column_of_something_else_cannot_be_read_and_the_others_can(tmp_path):
    path = stored(
        tmp_path / "t.parquet",
        {"a [g]": [1.0, 2.0, 3.0], "text": ["x", "y", "z"], "flags": [True, False, True], "pairs": [[1.0], [2.0], [3.0]],
         "gap [g]": [1.0, None, 3.0], "inf [g]": [1.0, np.inf, 2.0], "none [g]": pa.array([None, None, None], pa.float64())},
    )  # fmt: skip
    record = read_parquet(path)
    assert [info.key for info, _ in record.readable()] == ["a"]
    assert [p for p in record.problems if "holds no numbers" in p] == [
        f"t.parquet: column {name!r} holds no numbers" for name in ("text", "flags", "pairs")
    ]
    for name, message in (
        ("text", "holds no numbers"),
        ("gap", r"got no value in column 'gap' at 0\.1 s"),
        ("inf", "got an infinite value in 'inf', row 2"),
        ("none", "got no value in column 'none'; need one at least"),
    ):
        with pytest.raises(InvalidInput, match=message):
            record.history(name)
    assert len(record.faults()) >= 6


def test_a_column_that_ends_early_says_so(tmp_path):
    record = read_parquet(stored(tmp_path / "t.parquet", {"a [g]": [1.0, 2.0, None]}))
    assert record.history("a").values.tolist() == [1.0, 2.0]
    assert record.history("a").remarks == ("t.parquet: column 'a' ends early, at 0.1 s",)


def test_two_columns_of_one_name_are_not_guessed_between(tmp_path):
    table = pa.Table.from_arrays([pa.array(TIMES), pa.array(TIMES), pa.array(TIMES)], names=["time [s]", "a [g]", "a [g]"])
    pq.write_table(table, tmp_path / "t.parquet")
    record = read_parquet(tmp_path / "t.parquet")
    assert [info.readable for info in record.channels.values()] == [False, False]


def test_code_filter_state_and_time_stamps_come_back(tmp_path):
    state = Filter(60, "ISO 6487", after=Filter(1000))
    history = TimeHistory([1.0, 2.0], "g", stamps=[0.0, 0.1], name="x", code="11HEAD0000H3ACXD", filtered=state)
    write(TestRecord.of([history], identifier="sled 7", laboratory="here"), tmp_path / "t.parquet")
    record = read(tmp_path / "t.parquet")
    assert record.history("x").identical(history)
    assert record.history("x").interval is None
    assert (record.identifier, record.laboratory, record.channels["x"].code) == ("sled 7", "here", "11HEAD0000H3ACXD")


def test_other_programs_read_the_units(tmp_path):
    write(TestRecord.of([TimeHistory([1.0, 2.0], "g", interval=0.1, name="x")], identifier="x"), tmp_path / "t.parquet")
    table = pq.read_table(tmp_path / "t.parquet")
    assert table.schema.field("x").metadata[b"unit"] == b"g"
    assert table.to_pydict() == {"time": [0.0, 0.1], "x": [1.0, 2.0]}


@pytest.mark.parametrize(
    ("columns", "times", "message"),
    [
        ({"a": [1.0]}, [], "got 0 rows; need 1"),
        ({"a": [1.0, 2.0]}, [0.1, 0.0], r"got time 0 s after 0\.1 s; need times that never fall"),
        ({"a": [1.0, 2.0]}, [0.1, None], "got no time in row 2"),
    ],
)
def test_tables_without_good_times_are_refused(tmp_path, columns, times, message):
    path = stored(tmp_path / "t.parquet", {name: values[: len(times)] for name, values in columns.items()}, times=times)
    with pytest.raises(InvalidInput, match=message):
        read_parquet(path)


def test_a_table_without_times_is_refused(tmp_path):
    pq.write_table(pa.table({"a [g]": [1.0]}), tmp_path / "t.parquet")
    with pytest.raises(InvalidInput, match=r"^t\.parquet: got no column of times"):
        read_parquet(tmp_path / "t.parquet")


def test_more_rows_columns_or_bytes_than_a_test_has_are_refused(tmp_path, monkeypatch):
    path = stored(tmp_path / "t.parquet", {"a [g]": [1.0, 2.0, 3.0]})
    monkeypatch.setattr(parquet, "MAX_TABLE_BYTES", 10)
    with pytest.raises(InvalidInput, match=r"got [0-9]+ bytes unpacked; need at most 10"):
        read_parquet(path)
    monkeypatch.setattr(parquet, "MAX_ROWS", 2)
    with pytest.raises(InvalidInput, match=r"got 3 rows; need 1 \.\. 2"):
        read_parquet(path)
    monkeypatch.undo()
    monkeypatch.setattr("ridedown.signals.tables.MAX_COLUMNS", 1)
    with pytest.raises(InvalidInput, match="got 2 columns; need at most 1"):
        read_parquet(path)


@pytest.mark.parametrize("keep", [0, 4, 100, -1, -8, -40])
def test_a_file_cut_short_is_refused(tmp_path, keep):
    path = stored(tmp_path / "t.parquet", {"a [g]": [1.0, 2.0, 3.0]})
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(InvalidInput, match=r"^t\.parquet: "):
        read_parquet(path)


def test_a_file_that_changed_after_its_footer_was_read_is_refused(tmp_path):
    path = stored(tmp_path / "t.parquet", {"a [g]": [1.0, 2.0, 3.0]})
    record = read_parquet(path)
    stored(path, {"a [g]": [1.0, 2.0]}, times=[0.0, 0.1])
    with pytest.raises(InvalidInput, match="got 2 values in 'a'; need 3"):
        record.history("a")
