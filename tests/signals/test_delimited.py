"""Tables in text are read with the units of their headings, and what is written, as text or Parquet, reads back identical."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ridedown import load, simulate
from ridedown.errors import InvalidInput
from ridedown.signals import Filter, TestRecord, TimeHistory, files, read, tables, write
from ridedown.signals.delimited import read_delimited, write_delimited
from ridedown.signals.tables import grid_of, name_and_unit


def table(tmp_path, text: str | bytes, name: str = "t.csv") -> TestRecord:
    (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_delimited(tmp_path / name)


def only(record: TestRecord) -> TimeHistory:
    ((_, history),) = record.readable()
    return history


# headings


@pytest.mark.parametrize(
    ("text", "name", "unit"),
    [
        ("time [s],head x [g]\n0,1\n0.1,2\n", "head x", "g"),
        ("time (s),head x (m/s2)\n0,1\n0.1,2\n", "head x", "m/s2"),
        ("time_s,force_x_N\n0,1\n0.1,2\n", "force_x", "N"),
        ("Time [s];Kopf X [G'S]\n0;1\n0,1;2\n", "Kopf X", "g"),
        ("t (s)\thead x (M/S2)\n0\t1\n0.1\t2\n", "head x", "m/s2"),
        ("time,head x\ns,g\n0,1\n0.1,2\n", "head x", "g"),
        ("time,head x\n[s],[g]\n0,1\n0.1,2\n", "head x", "g"),
        ('"time [s]","head, x [g]"\n0,1\n0.1,2\n', "head, x", "g"),
        ("# a comment\n\n% another\ntime [s],head x [g]\n0,1\n0.1,2\n", "head x", "g"),
        ("head x [g],time [s]\n1,0\n2,0.1\n", "head x", "g"),
        ("zeit [s],x [furlong]\n0,1\n0.1,2\n", "x", "furlong"),
        ("time [s],overlap []\n0,1\n0.1,2\n", "overlap", ""),
        ("time [s], head x [g] \r\n0, 1\r\n 0.1 ,2 \r\n", "head x", "g"),
        ("\ufefftime [s],head x [g]\n0,1\n0.1,2\n\n\n", "head x", "g"),
        ('time [s];x [g]\n"0,0";"1,0"\n"0,1";"2,0"\n', "x", "g"),
        ("time [s],x [g]\r0,1\r0.1,2\r", "x", "g"),
    ],
)
def test_names_units_and_values_are_read_however_they_are_written(tmp_path, text, name, unit):
    history = only(table(tmp_path, text))
    assert (history.name, history.unit) == (name, unit)
    assert history.values.tolist() == [1.0, 2.0]
    assert history.time.tolist() == [0.0, 0.1]


def test_times_in_milliseconds_become_seconds(tmp_path):
    history = only(table(tmp_path, "time [ms],x [g]\n-0.1,1\n0,2\n0.1,3\n"))
    assert (history.start, history.interval) == (-0.0001, 0.0001)


@pytest.mark.parametrize(
    ("heading", "read_as"),
    [
        ("seat_t", ("seat_t", None)),  # a place, not tonnes
        ("door_in", ("door_in", None)),
        ("run_1", ("run_1", None)),
        ("seat_x", ("seat_x", None)),
        ("_g", ("_g", None)),
        ("pulse_g", ("pulse", "g")),
        ("pulse_m/s2", ("pulse", "m/s2")),
        ("HIC (15)", ("HIC (15)", None)),
        ("x [y] [g]", ("x [y]", "g")),
        ("x ()", ("x", "")),
    ],
)
def test_what_ends_a_heading_is_a_unit_only_where_it_can_be_nothing_else(heading, read_as):
    assert name_and_unit(heading) == read_as


def test_doubts_about_units_are_said(tmp_path):
    record = table(tmp_path, "time [s],a,b [furlong],c [g]\n0,1,2,3\n1,1,2,3\n")
    assert record.problems == (
        "t.csv: column 'a' has no unit; its values are taken as bare numbers",
        "t.csv: column 'b' is in 'furlong', a unit that is not known; its values cannot be converted",
    )
    assert [info.unit for info in record.channels.values()] == ["", "furlong", "g"]


def test_columns_of_one_name_are_told_apart(tmp_path):
    record = table(tmp_path, "time [s],x [g],x [g],[g]\n0,1,2,3\n1,1,2,3\n")
    assert list(record.channels) == ["x", "x (2)", "column 4"]


# what is missing


def test_a_column_that_ends_early_or_begins_late_says_so(tmp_path):
    record = table(tmp_path, "time [s],a [g],b [g]\n0,1,\n0.1,2,\n0.2,,7\n0.3,NaN,8\n")
    assert (record.history("a").values.tolist(), record.history("b").values.tolist()) == ([1.0, 2.0], [7.0, 8.0])
    assert (record.history("b").start, record.history("b").interval) == (0.2, 0.1)
    assert record.history("a").remarks == ("t.csv: column 'a' ends early, at 0.1 s",)
    assert record.history("b").remarks == ("t.csv: column 'b' begins late, at 0.2 s",)


def test_a_column_with_a_gap_or_without_values_cannot_be_read_and_the_others_can(tmp_path):
    record = table(tmp_path, "time [s],a [g],b [g],c [g]\n0,1,1,\n0.1,,2,\n0.2,3,3,\n")
    assert [info.key for info, _ in record.readable()] == ["b"]
    assert [info.readable for info in record.channels.values()] == [False, True, False]
    assert record.problems == (
        "t.csv: got no value in column 'a' at 0.1 s; need one in each row. Fill the gap.",
        "t.csv: got no value in column 'c'; need one at least. Leave the column out.",
    )
    with pytest.raises(InvalidInput, match=r"^t\.csv: got no value in column 'a' at 0\.1 s"):
        record.history("a")


# times


def test_times_rounded_in_print_are_taken_as_even_and_said_to_be(tmp_path):
    rows = "".join(f"{i / 30_000:.6f},{i}\n" for i in range(300))
    history = only(table(tmp_path, "time [s],x [g]\n" + rows))
    assert history.interval == pytest.approx(1 / 30_000, rel=1e-4)
    assert "of an interval off an even grid" in history.remarks[0]


def test_times_that_are_not_even_stay_as_they_are(tmp_path):
    history = only(table(tmp_path, "time [s],x [g]\n0,1\n0.1,2\n0.1,3\n0.3,4\n"))
    assert history.interval is None
    assert history.time.tolist() == [0.0, 0.1, 0.1, 0.3]


@given(
    st.integers(-5000, 5000),
    st.integers(2, 400),
    st.one_of(st.sampled_from([1e-4, 5e-5, 8e-5, 1e-3, 1 / 30_000, 1 / 3, 0.1]), st.floats(1e-6, 1.0)),
)
def test_even_times_are_found_again(first, count, interval):
    times = TimeHistory(np.zeros(count), "g", start=first * interval, interval=interval).time
    start, found, stamps, remarks = grid_of(times, "t")
    assert stamps is None
    assert remarks == ()
    again = TimeHistory(np.zeros(count), "g", start=start, interval=found).time
    # Far from zero the times tell their interval to fewer digits than it has: then the last bits of a time may differ.
    assert np.abs(again - times).max() <= 4.0 * np.spacing(np.abs(times).max())
    if found == float(f"{interval:.6g}"):
        assert np.array_equal(again, times)


@given(st.floats(-1e3, 1e3), st.integers(1, 100), st.floats(1e-6, 1.0))
def test_a_stated_interval_counts_where_it_agrees_with_the_times(start, count, interval):
    times = TimeHistory(np.zeros(count), "g", start=start, interval=interval).time
    assert grid_of(times, "t", {"interval": interval}) == (times[0], interval, None, ())
    if count > 1:
        assert grid_of(times, "t", {"interval": 2.0 * interval})[1] == pytest.approx(interval, rel=1e-6)


@pytest.mark.parametrize("clock", [None, 3, "x", {}, {"interval": "x"}, {"interval": -1.0}, {"interval": float("nan")}, [1]])
def test_a_stated_interval_that_is_none_is_passed_over(clock):
    assert grid_of(np.array([0.0, 0.1, 0.2]), "t", clock)[:2] == (0.0, 0.1)


def test_times_stated_not_to_be_even_stay_as_they_are():
    times = np.array([0.0, 0.1, 0.2])
    assert grid_of(times, "t", {"interval": None})[2] is times


# what is refused


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"^t\.csv:1: got no header"),
        ("# only\n# comments\n", r"^t\.csv:3: got no header"),
        ("0,1\n0.1,2\n", r"^t\.csv:1: got numbers in the first line; need names with units"),
        ("a [g],b [g]\n0,1\n", r"^t\.csv: got no column of times; need one"),
        ("time,x [g]\n0,1\n1,2\n", r"^t\.csv: got a column 'time' without a unit of time; need one\. Write time \[s\]"),
        ("time [g],x [g]\n0,1\n1,2\n", r"^t\.csv: got a column 'time' without a unit of time"),
        ("time [s]\n0\n1\n", r"^t\.csv: got times and nothing else"),
        ("time [s],x [g]\n", r"^t\.csv:2: got no values below the header"),
        ("time [s],x [g]\n0,1\n0.1\n", r"^t\.csv:3: got 1 cells; need 2 as in the header"),
        ("time [s],x [g]\n0,1\n0.1,2,3\n", r"^t\.csv:3: got 3 cells; need 2 as in the header"),
        ("# c\ntime [s],x [g]\n0,1\n0.1,two\n", r"^t\.csv:4: got 'two'; need one finite number"),
        ("time [s],x [g]\n0,1\n0.1,inf\n", r"^t\.csv:3: got 'inf'; need one finite number"),
        ("time [s],x [g]\n0,1\n0.1,1e999\n", r"^t\.csv:3: got '1e999'; need one finite number"),
        ("time [s],x [g]\n0,1\n0.1,1_0\n", r"^t\.csv:3: got '1_0'; need one finite number"),
        ("time [s];x [g]\n0;1.5\n0.1;1,5\n", r"^t\.csv:3: got decimal commas and decimal points; need one of them"),
        ("time [s];x [g]\n0;1.234,5\n0,1;2\n", r"^t\.csv:2: got decimal commas and decimal points"),
        ("time [s],x [g]\n0.1,1\n0,2\n", r"^t\.csv: got time 0 s after 0\.1 s; need times that never fall"),
        ("time [s],x [g]\n0,1\n,2\n", r"^t\.csv: got no time in row 2"),
        ("time [s],x [g]\n0,1\n0.1,\x00\n", r"^t\.csv:3: got binary data; need text"),
        ("time [s],x\x01 [g]\n0,1\n", r"^t\.csv:1: got a header that is no text"),
        ('time [s],"' + "x" * 200_000 + "\n0,1\n", r"^t\.csv:1: got a header that cannot be taken apart"),
        (",".join(["time [s]"] * 20_001) + "\n", r"^t\.csv:1: got 20001 columns; need at most 20000"),
    ],
)
def test_what_is_no_table_of_signals_is_refused_with_the_line(tmp_path, text, message):
    with pytest.raises(InvalidInput, match=message):
        table(tmp_path, text)


def test_a_file_that_is_not_there_or_too_large_is_refused(tmp_path, monkeypatch):
    with pytest.raises(InvalidInput, match="which cannot be read"):
        read_delimited(tmp_path / "missing.csv")
    monkeypatch.setattr("ridedown.signals.delimited.MAX_FILE_BYTES", 20)
    with pytest.raises(InvalidInput, match=r"^t\.csv: got more than 0 MiB"):
        table(tmp_path, "time [s],x [g]\n0,1\n0.1,2\n")


def test_many_empty_cells_do_not_become_a_great_deal_of_memory(tmp_path, monkeypatch):
    monkeypatch.setattr("ridedown.signals.delimited.MAX_FILE_BYTES", 8000)
    with pytest.raises(InvalidInput, match="got 50 lines of 101 columns; need fewer"):
        table(tmp_path, ",".join(["time [s]", *["x"] * 100]) + "\n" + ("," * 100 + "\n") * 50)


# writing

names = st.text(st.characters(codec="utf-8", categories=["L", "N", "P", "S", "Zs"]), min_size=1, max_size=30)
finite = st.floats(allow_nan=False, allow_infinity=False)
states = st.sampled_from([None, Filter(180, "SAE J211"), Filter(1000), Filter(60, "ISO 6487", after=Filter(1000, "SAE J211"))])


@st.composite
def records(draw: st.DrawFn) -> TestRecord:
    count = draw(st.integers(2, 20))
    clock = (
        {"start": draw(st.integers(-50, 50)) * 1e-4, "interval": draw(st.sampled_from([1e-4, 1 / 3, 8e-5]))}
        if draw(st.booleans())
        else {"stamps": np.cumsum(draw(st.lists(st.sampled_from([0.0, 0.1, 1 / 3, 7.0]), min_size=count, max_size=count)))}
    )
    signals = []
    for name in draw(st.lists(names, min_size=1, max_size=4, unique=True)):
        values = draw(st.lists(finite, min_size=count, max_size=count))
        code = draw(st.sampled_from([None, "11HEAD0000H3ACX0"]))
        unit = draw(st.sampled_from(["g", "m/s2", "", "N", "deg/s"]))
        signals.append(TimeHistory(values, unit, name=name, code=code, filtered=draw(states), **clock))
    return TestRecord.of(signals, identifier=draw(names), title=draw(names))


@settings(deadline=None)
@given(records(), st.sampled_from(["t.csv", "t.tsv", "t.parquet"]))
def test_what_is_written_reads_back_identical(tmp_path_factory, record, file):
    path = tmp_path_factory.mktemp("written") / file
    try:
        left_out = write(record, path)
    except InvalidInput as problem:  # a heading has no place for some names
        refusal = str(problem)
    else:
        refusal = ""
    assert path.exists() is not ("Rename" in refusal)
    if refusal:
        return
    assert left_out == ()
    back = read(path)
    assert (back.identifier, back.title) == (record.identifier, record.title)
    assert list(back.channels) == list(record.channels)
    for key in record.channels:
        assert back.history(key).identical(record.history(key)), key
        assert back.history(key).name == key


@pytest.mark.parametrize("name", ["head x", "Kopf, rechts; oben", "x [y]", "force_N", "time_s", "größe (mm)", "a\u2019b"])
@pytest.mark.parametrize("file", ["t.csv", "t.tsv", "t.parquet"])
def test_ordinary_names_can_be_written(tmp_path, name, file):
    write(TestRecord.of([TimeHistory([1.0, 2.0], "", interval=0.1, name=name)], identifier="x"), tmp_path / file)
    assert list(read(tmp_path / file).channels) == [name]


@pytest.mark.parametrize("file", ["t.csv", "t.tsv", "t.parquet"])
def test_every_double_comes_back(tmp_path, file):
    values = [0.1, 1 / 3, 5e-324, 1.7976931348623157e308, -0.0, 2.0**53 + 2.0, math.pi]
    record = TestRecord.of([TimeHistory(values, "g", interval=1e-4, name="x")], identifier="x")
    write(record, tmp_path / file)
    back = read(tmp_path / file).history("x").values
    assert back.tobytes() == record.history("x").values.tobytes()


@pytest.mark.parametrize("file", ["t.csv", "t.parquet"])
def test_channels_of_another_length_end_early_and_those_at_other_times_are_refused(tmp_path, file):
    long = TimeHistory([1.0, 2.0, 3.0], "g", interval=0.1, name="long")
    short = TimeHistory([1.0, 2.0], "g", interval=0.1, name="short")
    write(TestRecord.of([short, long], identifier="x"), tmp_path / file)
    back = read(tmp_path / file)
    assert back.history("short").identical(short)
    assert "ends early" in back.history("short").remarks[0]
    other = TimeHistory([1.0, 2.0], "g", interval=0.2, name="other")
    with pytest.raises(InvalidInput, match=r"^other: got times other than those of 'long'.*aligned first"):
        write(TestRecord.of([long, other], identifier="x"), tmp_path / file)
    assert list(read(tmp_path / file).channels) == ["short", "long"]  # the old file stands


def test_channels_that_cannot_be_read_are_left_out_and_named(tmp_path):
    record = table(tmp_path, "time [s],a [g],b [g]\n0,1,1\n0.1,,2\n0.2,3,3\n")
    (sentence,) = write_delimited(record, tmp_path / "other.csv")
    assert sentence.startswith("a: left out, since it cannot be read: t.csv: got no value in column 'a'")
    assert list(read(tmp_path / "other.csv").channels) == ["b"]


def test_nothing_is_left_behind_where_writing_fails(tmp_path, monkeypatch):
    record = TestRecord.of([TimeHistory([1.0, 2.0], "g", interval=0.1, name="x")], identifier="x")
    write(record, tmp_path / "t.csv")
    before = (tmp_path / "t.csv").read_bytes()
    monkeypatch.setattr(tables, "about_of", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write(record, tmp_path / "t.csv")
    assert [item.name for item in tmp_path.iterdir()] == ["t.csv"]
    assert (tmp_path / "t.csv").read_bytes() == before
    with pytest.raises(InvalidInput, match="which cannot be written"):
        write(record, tmp_path / "no" / "folder.csv")


def test_a_written_file_has_the_rights_of_any_other(tmp_path):
    (tmp_path / "plain").write_text("x")
    write(TestRecord.of([TimeHistory([1.0, 2.0], "g", interval=0.1, name="x")], identifier="x"), tmp_path / "t.csv")
    assert (tmp_path / "t.csv").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_what_a_response_writes_is_read(tmp_path):
    response = simulate(load("p1"))
    response.to_csv(tmp_path / "r.csv")
    response.to_parquet(tmp_path / "r.parquet")
    for file, digits in (("r.csv", 1e-11), ("r.parquet", 0.0)):
        record = read(tmp_path / file)
        assert tuple(record.channels) == response.channels
        assert record.problems == ()
        for key in record.channels:
            history = record.history(key)
            assert history.unit == response.unit(key)
            assert history.interval == 1e-4
            expected = response.at(key, np.clip(history.time, 0.0, response.end_time))
            assert np.abs(history.values - expected).max() <= max(digits, 1e-9) * max(np.abs(expected).max(), 1e-300)


def test_a_file_of_the_largest_size_is_within_the_bounds_of_a_tree():
    assert files.MAX_FILE_BYTES == 64 * 2**20


@pytest.mark.parametrize("name", ["t.csv", "t.tsv"])
def test_a_name_may_hold_a_space_that_does_not_break(tmp_path, name):
    record = TestRecord.of([TimeHistory([1.0, 2.0], "g", interval=0.1, name="Kopf\u00a0X")], identifier="x")
    write(record, tmp_path / name)
    assert tuple(read(tmp_path / name).channels) == ("Kopf\u00a0X",)
