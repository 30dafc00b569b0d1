"""Whatever bytes a file holds, reading gives a record or one clear refusal: never another error, and little memory.

2,000 inputs here, from fixed seeds: 500 texts and 500 changes of a good table, 500 changes of a good Parquet file, 500 of a
good zip. Each channel that claims to be readable is read. `python -m tests.signals.test_hostile_files 100000 1` runs more.
"""

from __future__ import annotations

import random
import sys
import tempfile
import tracemalloc
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals import TestRecord, TimeHistory, read, write
from ridedown.signals.files import open_tree

FOUND = Path(__file__).parent / "hostile"
GOOD = (
    b'# ridedown: {"test": {"identifier": "x"}}\n# ridedown: {"channels": {"a": {"code": "11HEAD0000H3ACX0", "filtered": '
    b'[[180, "SAE J211"]]}}}\ntime [s],a [g],b [mm]\n-0.0001,1.5,2\n0,1e3,\n0.0001,-.5,4\n'
)
TOKENS = [
    b"", b",", b";", b"\t", b"\n", b"\r\n", b"\r", b'"', b"[", b"]", b"(", b"#", b"# ridedown: {", b"nan", b"inf", b"1e999",
    b"-", b"1,5", b"0x10", b"1_000", b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"\xe9", b"9" * 400, b"1e-400", b"time",
    b"time [s]",
    b"[g]", b"s", b"[" * 3000, b'{"a":' * 2000, b"\xe2\x80\xa8", b"\x1c", b"\x85", b" ", b"0.0002", b"-1", b"PAR1",
    b"PK\x03\x04",
    b'{"channels": []}', b'{"channels": {"a": {"filtered": [[true, "x"]]}}}', b'{"clock": {"interval": 1e-320}}',
    b'{"channels": {"a": {"filtered": [[1e400, ""]]}}}',
]  # fmt: skip


def mutated(content: bytes, chance: random.Random) -> bytes:
    """A few bytes changed, cut out, doubled, swapped, or replaced by what is likely to hurt."""
    data = bytearray(content)
    for _ in range(chance.randint(1, 6)):
        at, to = sorted(chance.randint(0, len(data)) for _ in range(2))
        match chance.randrange(6):
            case 0:
                data[at:at] = chance.choice(TOKENS)
            case 1:
                data[at : at + chance.randint(1, 8)] = chance.choice(TOKENS)
            case 2:
                del data[at : min(to, at + 40)]
            case 3:
                data[at:at] = data[at : min(to, at + 200)]
            case 4 if data:
                data[min(at, len(data) - 1)] = chance.randrange(256)
            case 5:
                data[at : at + 4] = chance.choice([0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 0x10000]).to_bytes(4, "little")
            case _:
                pass
    return bytes(data)


def outcome(path: Path) -> str:
    """What reading gave: "read", or "refused"; anything but these two raises, and fails."""
    refusal = ""
    try:
        record = read(path)
    except (InvalidInput, UnknownName) as problem:
        refusal = str(problem)
    if refusal:
        assert len(refusal) < 1000
        assert "\n" not in refusal
        return "refused"
    assert isinstance(record, TestRecord)
    for sentence in record.faults():
        assert len(sentence) < 1000
    for info, history in record.readable():
        assert isinstance(history, TimeHistory)
        assert len(history) > 0, info
    return "read"


def good_table(folder: Path) -> bytes:
    return GOOD


def good_parquet(folder: Path) -> bytes:
    signals = [TimeHistory([1.0, 2.0, 3.0], "g", interval=1e-4, name=name, code="11HEAD0000H3ACX0") for name in ("a", "b")]
    write(TestRecord.of(signals, identifier="x"), folder / "good.parquet")
    return (folder / "good.parquet").read_bytes()


def good_zip(folder: Path) -> bytes:
    with zipfile.ZipFile(folder / "good.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("in/t.csv", GOOD)
        archive.writestr("in/about", b"x" * 2000)
    return (folder / "good.zip").read_bytes()


KINDS: dict[str, Callable[[Path], bytes]] = {"t.csv": good_table, "t.parquet": good_parquet, "t.zip": good_zip}


def campaign(name: str, count: int, seed: int, folder: Path) -> Counter[str]:
    chance = random.Random(seed)
    good = KINDS[name](folder)
    work = folder / "work"
    work.mkdir()
    path, tally = work / name, Counter[str]()
    for number in range(count):
        content = mutated(good, chance)
        path.write_bytes(content)
        try:
            tally[outcome(path)] += 1
        except BaseException:
            (folder / f"failed-{number}-{name}").write_bytes(content)
            raise
        assert [item.name for item in work.iterdir()] == [name]
    return tally


@pytest.mark.parametrize("path", sorted(FOUND.iterdir()), ids=lambda path: path.stem)
def test_what_the_fuzzer_found_before_is_refused(path):
    """Two Parquet files whose column statistics end the process in pyarrow 26, and one with fewer rows than its footer says."""
    assert outcome(path) == "refused"


@pytest.mark.parametrize("name", KINDS)
def test_a_changed_file_is_read_or_refused_and_nothing_is_written(tmp_path, name):
    tally = campaign(name, 500, 3, tmp_path)
    assert tally["refused"] > 50  # the changes do hurt
    assert tally.total() == 500


@settings(max_examples=500, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.one_of(
        st.binary(max_size=300),
        st.lists(st.one_of(st.sampled_from(TOKENS), st.binary(max_size=5)), max_size=40).map(b"".join),
        st.lists(st.sampled_from([b"time [s]", b"x [g]", b",", b"\n", b"0", b"1", b"0.1", b"-"]), max_size=40).map(b"".join),
    ),
    st.sampled_from(["t.csv", "t.tsv", "t.txt", "t.parquet", "t.zip", "t"]),
)
@example(b"time [s],x [g]\n0,1\n1e308,2\n", "t.csv")
@example(b"time [s],x [g]\n-1e308,1\n1e308,2\n", "t.csv")
@example(b"time [s],x [g]\n0,1\n5e-324,2\n", "t.csv")
@example(b"time [ms],x [g]\n0,1\n1e-322,2\n", "t.csv")
@example(b"time [s],x [g]\n1e17,1\n1e17,2\n100000000000000016,2\n", "t.csv")
@example(b'# ridedown: {"clock": {"interval": 1e-320}}\ntime [s],x [g]\n0,1\n1,2\n', "t.csv")
@example(b'# ridedown: {"channels": {"x": {"filtered": [[1, "a"], 2]}}}\ntime [s],x [g]\n0,1\n1,2\n', "t.csv")
@example(b"# ridedown: " + b"[" * 100_000 + b"\ntime [s],x [g]\n0,1\n1,2\n", "t.csv")
def test_any_bytes_are_read_or_refused(tmp_path_factory, content, name):
    path = tmp_path_factory.mktemp("any") / name
    path.write_bytes(content)
    outcome(path)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    st.binary(max_size=400).map(lambda rest: b"PK\x03\x04" + rest) | st.binary(max_size=200).map(lambda m: m + b"PK\x05\x06")
)
def test_any_bytes_that_begin_or_end_as_a_zip_are_opened_or_refused(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("zip") / "t.zip"
    path.write_bytes(content)
    try:
        tree = open_tree(path)
    except InvalidInput:
        return
    for name in tree.names():
        try:
            tree.read_text(name)
        except InvalidInput:
            continue


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("wide.csv", b"time [s]" + b",x [g]" * 19_000 + b"\n" + (b"0" + b",1" * 19_000 + b"\n") * 2),
        ("long line.csv", b"time [s],x [g]\n0," + b"1" * 5_000_000 + b"\n"),
        ("many lines.csv", b"time [s],x [g]\n" + b"\n" * 1_000_000),
        ("empty cells.csv", b"time [s]" + b",x" * 100 + b"\n" + b"0" + b"," * 5_000_000),
        ("no lines.csv", b"\xff" * 5_000_000),
        ("comments.csv", b"#\n" * 300_000),
    ],
)
def test_memory_stays_within_some_tens_of_the_files_size(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    tracemalloc.start()
    try:
        outcome(tmp_path / name)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # lists of lines: 8 bytes a line for the list and 50 for each text
    assert peak < 80 * len(content) + 50e6


if __name__ == "__main__":
    for kind in KINDS:
        print(kind, dict(campaign(kind, int(sys.argv[1]) // len(KINDS), int(sys.argv[2]), Path(tempfile.mkdtemp()))))
