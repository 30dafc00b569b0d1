"""`read` tells a test's format by what is there, and says what it found where it is none."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path

import numpy as np
import pytest

from ridedown.errors import InvalidInput
from ridedown.signals import (
    TestRecord,
    TimeHistory,
    filtered,
    holds_laboratory_test,
    integrated,
    mean,
    read,
    read_bytes,
    write,
    zeroed,
)

TEST_10146 = Path(__file__).resolve().parents[3] / "shared" / "data" / "nhtsa_v10146"
needs_10146 = pytest.mark.skipif(not TEST_10146.exists(), reason="the measured crash data are not beside this repository")


@pytest.fixture
def record() -> TestRecord:
    signals = [
        TimeHistory([0.0, -1.5, 2.5], "g", start=-1e-4, interval=1e-4, name="head x", code="11HEAD0000H3ACX0"),
        TimeHistory([1.0, 2.0, 3.0], "N", start=-1e-4, interval=1e-4, name="femur", code="11FEMRLE00H3FOZ0"),
    ]
    return TestRecord.of(signals, identifier="sled7", title="a sled")


@pytest.mark.parametrize("name", ["t.csv", "t.tsv", "t.parquet", "t.pq", "t.zip", "folder", "T.CSV"])
def test_what_is_written_in_any_format_is_told_and_read(tmp_path, record, name):
    assert write(record, tmp_path / name) == ()
    back = read(tmp_path / name)
    formats = {"csv": "CSV", "tsv": "CSV", "parquet": "Parquet", "pq": "Parquet"}
    assert back.format.startswith(formats.get(name.lower().partition(".")[2], "ISO-MME"))
    for key in ("11HEAD0000H3ACX0", "11FEMRLE00H3FOZ0"):
        assert back.history(key if back.format != "CSV" else record.channel(key).name).identical(record.history(key))


@pytest.mark.parametrize("name", ["t.csv", "t.tsv", "t.parquet", "t.zip"])
def test_bytes_at_hand_are_read_as_their_file_is(tmp_path, record, name):
    write(record, tmp_path / name)
    content = (tmp_path / name).read_bytes()
    back, same = read_bytes(content, name), read(tmp_path / name)
    assert (back.format, back.identifier, dict(back.channels)) == (same.format, same.identifier, dict(same.channels))
    for key in back.channels:
        assert back.history(key).identical(same.history(key))
    assert holds_laboratory_test(content, name) == (name == "t.zip")


def test_bytes_that_are_no_test_are_refused():
    for name, words in (("t.zip", "got no zip"), ("v1.EV5", "need both"), ("t.parquet", "Parquet"), ("t.csv", "no header")):
        with pytest.raises(InvalidInput, match=words):
            read_bytes(b"", name)
    assert not holds_laboratory_test(b"", "t.zip")


def test_a_table_in_a_folder_or_a_zip_is_read_if_it_is_the_only_one(tmp_path, record):
    write(record, tmp_path / "a.csv")
    with zipfile.ZipFile(tmp_path / "a.zip", "w") as archive:
        archive.write(tmp_path / "a.csv", "inside/a.csv")
        archive.writestr("readme.md", "about")
    assert read(tmp_path / "a.zip").history("femur").identical(record.history("femur"))
    (tmp_path / "a.zip").unlink()
    assert list(read(tmp_path).channels) == ["head x", "femur"]
    write(record, tmp_path / "b.parquet")
    with pytest.raises(InvalidInput, match=r"got a\.csv, b\.parquet in .*need one test"):
        read(tmp_path)
    (tmp_path / "a.csv").unlink()
    assert read(tmp_path).format == "Parquet"


def test_parquet_is_told_by_its_first_bytes_too(tmp_path, record):
    write(record, tmp_path / "t.parquet")
    (tmp_path / "t.parquet").rename(tmp_path / "t.dat")
    assert read(tmp_path / "t.dat").format == "Parquet"


def test_what_is_no_test_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="which is no file or folder; need a test: NHTSA EV5"):
        read(tmp_path / "missing")
    with pytest.raises(InvalidInput, match=r"^path: got nothing in .*need one test"):
        read(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InvalidInput, match="which is no file or folder"):
        read(tmp_path / "pipe")
    (tmp_path / "x.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\0")
    with pytest.raises(InvalidInput, match=r"^x\.png:3: got binary data; need text"):
        read(tmp_path / "x.png")
    (tmp_path / "prose.txt").write_text("Dear colleague,\nplease find the data attached.\n")
    with pytest.raises(InvalidInput, match=r"^prose\.txt"):
        read(tmp_path / "prose.txt")
    with pytest.raises(InvalidInput, match=r"^path: got prose\.txt, pipe, x\.png|^prose\.txt"):
        read(tmp_path)


def test_two_tests_in_one_folder_are_not_guessed_between(tmp_path):
    (tmp_path / "v1.EV5").write_text("x")
    (tmp_path / "t.mme").write_text("x")
    with pytest.raises(InvalidInput, match="got a test of EV5 and one of ISO-MME"):
        read(tmp_path)


@needs_10146
def test_test_10146_is_told_from_its_folder_and_its_header():
    for path in (TEST_10146, TEST_10146 / "v10146.EV5"):
        assert read(path).history("1").unit == "g"


@needs_10146
def test_the_pulse_of_test_10146_gives_back_its_speed_and_nine_to_ten_of_rebound():
    record = read(TEST_10146)
    pulse = zeroed(mean(record.history("94"), record.history("99")))
    velocity = integrated(filtered(pulse, 180), initial=57.09 / 3.6, at=0.0).converted("km/h")
    # the data's own description: rebound of 9-10 km/h; this pair of sensors, its offset taken out, gives 10.05
    assert -10.1 < velocity.values.min() < -9.0
    assert abs(velocity.values[np.searchsorted(velocity.time, 0.0)] - 57.09) < 1e-9


@needs_10146
def test_the_wall_of_test_10146_takes_the_momentum_of_the_car():
    force = read(TEST_10146 / "barrier_total_fx.csv").history("force_x")
    assert (force.unit, len(force), force.start, force.interval) == ("N", 3500, -0.05, 1e-4)
    impulse = integrated(zeroed(force))
    # 1719 kg from 57.09 km/h, and 9-10 km/h back: 31.6-32.0 kN s, the load cells being some per cent off
    assert impulse.unit == "N s"
    assert -impulse.values[-1] / 1719.0 * 3.6 == pytest.approx(66.6, rel=0.05)
