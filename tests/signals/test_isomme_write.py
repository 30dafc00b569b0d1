from __future__ import annotations

import zipfile
from dataclasses import fields
from datetime import date

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown.errors import InvalidInput
from ridedown.signals import isomme_write
from ridedown.signals.ev5 import read_ev5
from ridedown.signals.history import Filter, TimeHistory
from ridedown.signals.isomme import read_isomme, write_isomme
from ridedown.signals.record import TestRecord, Vehicle
from tests.signals.ev5_samples import VALUES, channel, curve, header, row, sections
from tests.signals.ev5_samples import write as write_ev5
from tests.signals.isomme_samples import MME, data, head, lines, listing, one, write


def assert_same(one_record: TestRecord, other: TestRecord, *, but: tuple[str, ...] = ("load", "problems", "channels")) -> None:
    for part in fields(TestRecord):
        if part.name not in but:
            assert getattr(one_record, part.name) == getattr(other, part.name), part.name
    assert {key: info for key, info in one_record.channels.items() if info.readable} == dict(other.channels)
    for key in other.channels:
        assert one_record.history(key).identical(other.history(key)), key
        assert one_record.history(key).name == other.history(key).name


def laboratory(folder):
    """A test with what laboratories do: keys of their own, repeated comments, a clock, filters, signs, umlauts."""
    reference = {"Reference_channel": "explicit", "Reference_channel_name": "10TIRS000000TI00"}
    dropped = {"Sampling_interval": "DROP", "Time_of_first_sample": "DROP", "Channel_frequency_class": "NOVALUE"}
    clock = head("10TIRS000000TI00", Unit="s", Name_of_the_channel="Time", **reference, **dropped)
    timed = head("13CHST0000HFDSXC", Unit="mm", **reference)
    channels = {
        1: lines(head(Comments="one\ntwo: 2")) + data(),
        5: lines(timed) + data((0.1 + 0.2, 1e-300, -0.0, 5e-324)),
        9: lines(clock) + data((-0.1, 0.0, 0.0, 1.0 / 3.0)),
        12: lines(head("11NECKUP00H3MOYB", Unit="Nm", **{"Sampling_interval": "0.00005", ".Own_key": "kept: as it is"}))
        + data(),
    }
    codes = {1: "11HEAD0000H3ACXA", 5: "13CHST0000HFDSXC", 9: "10TIRS000000TI00", 12: "11NECKUP00H3MOYB"}
    return write(
        folder, channels, mme=lines(MME | {"Laboratory name": "Prüflabor", ".Own": "thing"}), codes=codes, encoding="cp1252"
    )


@pytest.mark.parametrize("name", ["out", "out.zip"])
def test_a_written_test_reads_back_identical(tmp_path, name):
    record = read_isomme(laboratory(tmp_path / "t7"))
    assert write_isomme(record, tmp_path / name) == ()
    again = read_isomme(tmp_path / name)
    assert_same(record, again)
    assert again.problems == ()
    assert again.fields[".Own"] == "thing"
    assert again.channel(12).fields[".Own key"] == "kept: as it is"
    assert again.history(5).stamps.tolist() == [-0.1, 0.0, 0.0, 1.0 / 3.0]
    assert set(again.channels) == {"1", "5", "9", "12"}


def test_written_twice_the_files_are_the_same(tmp_path):
    record = read_isomme(laboratory(tmp_path / "t7"))
    write_isomme(record, tmp_path / "a")
    write_isomme(read_isomme(tmp_path / "a"), tmp_path / "b")
    first, second = (
        {p.relative_to(f).as_posix(): p.read_bytes() for p in f.rglob("*") if p.is_file()}
        for f in (tmp_path / "a", tmp_path / "b")
    )
    assert first == second
    assert set(first) == {"t7.mme", "Channel/t7.chn", "Channel/t7.001", "Channel/t7.005", "Channel/t7.009", "Channel/t7.012"}


def test_an_ev5_test_goes_through_iso_mme_unchanged(tmp_path):
    occupant = row("OCCUPANT", VEHNO=1, OCCLOC="02", OCCTYP="H3", DUMMSIZ="05", HIC=335, T1=67.8, T2=82.8, LFEM=-1182)
    rows = [
        channel(1, SENLOC="02"),
        channel(2, SENATT="SHBT", SENTYP="LC", YUNITS="NWT", AXIS="NA", DASTAT="CF"),
        channel(3, SENATT="FLLR", SENLOC="NA", CHSTAT="R", INSCOM="LEFT REAR SEAT CROSSMEMBER XR: ümlaut"),
        channel(4),
        channel(5, VEHNO=0, SENATT="LC0101", SENLOC="NA", SENTYP="LC", YUNITS="NWM"),
    ]
    text = header(sections(rows, OCCUPANT=[occupant], RESTRAINT=["1|02|1|3PT|BC|NA|BELT"], BARRIER=["R|LCB|0|0|WALL"]))
    record = read_ev5(write_ev5(tmp_path / "e", text, {1: curve(VALUES), 2: curve(VALUES), 3: curve(VALUES), 5: curve(VALUES)}))
    (left_out,) = write_isomme(record, tmp_path / "out")
    assert "channel 4: got no curve file" in left_out
    again = read_isomme(tmp_path / "out")
    for part in (
        "identifier",
        "title",
        "date",
        "laboratory",
        "closing_speed",
        "vehicles",
        "occupants",
        "restraints",
        "barrier",
    ):
        assert getattr(again, part) == getattr(record, part), part
    assert list(again.channels) == ["1", "2", "3", "5"]
    for key, info in again.channels.items():
        assert record.history(key).identical(again.history(key))
        for said in fields(info):
            if said.name != "fields":
                assert getattr(info, said.name) == getattr(record.channels[key], said.name), (key, said.name)


SIGNALS = st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20)


@given(
    values=SIGNALS,
    start=st.floats(-10, 10),
    interval=st.floats(1e-7, 1.0),
    unit=st.sampled_from(["g", "m/s2", "N", "N m", "mm", "deg/s", "", "%", "furlong"]),
    name=st.text(st.characters(blacklist_categories=["Cs", "Cc"]), max_size=40),
    filtered=st.sampled_from(
        [None, Filter(60), Filter(180, "SAE J211"), Filter(100), Filter(60, "ISO 6487", Filter(1000, "SAE J211"))]
    ),
    code=st.sampled_from([None, "11HEAD0000H3ACX0", "B0FBAR000000FOX?"]),
)
def test_any_signal_reads_back_bit_for_bit(tmp_path_factory, values, start, interval, unit, name, filtered, code):
    out = tmp_path_factory.mktemp("out") / "t"
    name = " ".join(name.split()) or "x"
    history = TimeHistory(values, unit, start=start, interval=interval, name=name, code=code, filtered=filtered)
    record = TestRecord.of([history], identifier="t")
    write_isomme(record, out)
    (read,) = read_isomme(out).channels.values()
    again = read_isomme(out).history(read)
    assert again.values.tobytes() == history.values.tobytes()
    assert again.time.tobytes() == history.time.tobytes()
    assert (again.unit, again.name) == (history.unit, "" if name.upper() == "NOVALUE" else name)
    if filtered is None or code:
        assert again.filtered == filtered


def test_stamps_with_jumps_read_back_and_share_their_clock(tmp_path):
    stamps, other = np.array([0.0, 0.1, 0.1, 1.0 / 3.0]), np.array([0.0, 1.0, 2.0, 3.0])
    signals = [
        TimeHistory([1.0, 2.0, 3.0, float(i)], "m/s2", stamps=s, name=f"s{i}") for i, s in enumerate((stamps, stamps, other))
    ]
    record = TestRecord.of(signals, identifier="t")
    write_isomme(record, tmp_path / "out")
    again = read_isomme(tmp_path / "out")
    assert again.problems == ()
    assert [info.quantity for info in again.channels.values()] == ["", "", "", "time", "time"]
    for signal in signals:
        assert again.history(signal.name).identical(signal)


def test_the_code_gets_the_letter_of_the_filter(tmp_path):
    history = TimeHistory([1.0, 2.0], "g", interval=1e-4, name="a", code="11HEAD0000H3ACX0", filtered=Filter(180, "SAE J211"))
    write_isomme(TestRecord.of([history], identifier="t"), tmp_path / "out")
    assert read_isomme(tmp_path / "out").history("a").code == "11HEAD0000H3ACXC"
    assert read_isomme(tmp_path / "out").history("a").filtered == Filter(180, "SAE J211")


def test_names_that_no_file_may_have_are_made_ones(tmp_path):
    history = TimeHistory([1.0], "g", interval=1e-4, name="a\nb: c")
    record = TestRecord.of(
        [history],
        identifier="../../etc/passwd",
        title="x\nComments :y",
        date=date(2026, 1, 2),
        vehicles=(Vehicle(1, "a\nb", 1.0),),
    )
    write_isomme(record, tmp_path / "out")
    again = read_isomme(tmp_path / "out")
    assert again.identifier == "etc_passwd"
    assert (again.title, again.vehicles[0].name, again.history(1).name) == ("x Comments :y", "a b", "a b: c")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out"]


# where it may be written


def record_of_one() -> TestRecord:
    return TestRecord.of([TimeHistory([1.0, 2.0], "g", interval=1e-4, name="a")], identifier="t")


def test_a_test_that_is_there_is_replaced_whole(tmp_path):
    write(tmp_path / "out", one() | {33: one()[1]})
    write_isomme(record_of_one(), tmp_path / "out")
    assert {p.name for p in (tmp_path / "out").rglob("*") if p.is_file()} == {"t.mme", "t.chn", "t.001"}
    write_isomme(record_of_one(), tmp_path / "out.zip")
    write_isomme(record_of_one(), tmp_path / "out.zip")
    with zipfile.ZipFile(tmp_path / "out.zip") as packed:
        assert set(packed.namelist()) == {"t/t.mme", "t/Channel/t.chn", "t/Channel/t.001"}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out", "out.zip"]


def test_an_empty_folder_is_used(tmp_path):
    (tmp_path / "out").mkdir()
    write_isomme(record_of_one(), tmp_path / "out")
    assert read_isomme(tmp_path / "out").identifier == "t"


@pytest.mark.parametrize("strange", ["notes.txt", "Movie/crash.avi", "Channel/readme.md", "t.mme/x"])
def test_a_folder_with_anything_else_is_left_alone(tmp_path, strange):
    out = tmp_path / "out"
    if strange == "notes.txt":
        out.mkdir()
    else:
        write(out, one())
    file = out / strange
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("mine")
    before = {p.relative_to(out): p.read_bytes() for p in out.rglob("*") if p.is_file()}
    with pytest.raises(InvalidInput, match="Choose another"):
        write_isomme(record_of_one(), out)
    assert {p.relative_to(out): p.read_bytes() for p in out.rglob("*") if p.is_file()} == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out"]


def test_a_folder_of_channels_without_a_test_is_left_alone(tmp_path):
    (tmp_path / "out" / "Channel").mkdir(parents=True)
    (tmp_path / "out" / "Channel" / "t.001").write_text("1\n")
    with pytest.raises(InvalidInput, match="Choose another"):
        write_isomme(record_of_one(), tmp_path / "out")


@pytest.mark.parametrize("name", ["out", "out.zip"])
def test_a_file_or_a_strange_zip_is_left_alone(tmp_path, name):
    (tmp_path / name).write_text("mine")
    with pytest.raises(InvalidInput, match="Choose another"):
        write_isomme(record_of_one(), tmp_path / name)
    assert (tmp_path / name).read_text() == "mine"
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as packed:
        packed.writestr("mine.txt", "mine")
    with pytest.raises(InvalidInput, match="Choose another"):
        write_isomme(record_of_one(), tmp_path / "other.zip")


def test_a_link_is_not_followed(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "elsewhere", target_is_directory=True)
    with pytest.raises(InvalidInput, match="Choose another"):
        write_isomme(record_of_one(), tmp_path / "out")
    assert list((tmp_path / "elsewhere").iterdir()) == []


@pytest.mark.parametrize("name", ["out", "out.zip"])
def test_a_write_that_fails_leaves_what_was_there(tmp_path, monkeypatch, name):
    write_isomme(record_of_one(), tmp_path / name)
    before = read_isomme(tmp_path / name).history("a").values.tolist()

    def fails(file, text):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(isomme_write, "_put", fails)
    with pytest.raises(OSError, match="No space left"):
        write_isomme(record_of_one(), tmp_path / name)
    assert read_isomme(tmp_path / name).history("a").values.tolist() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == [name]


def test_a_record_without_a_curve_is_not_written(tmp_path):
    record = read_ev5(write_ev5(tmp_path / "e", header(sections([channel(1)])), {}))
    with pytest.raises(InvalidInput, match="no channel that can be read"):
        write_isomme(record, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_list_of_channels_names_each_file(tmp_path):
    write_isomme(record_of_one(), tmp_path / "out")
    expected = listing({1: "???????????????? / a"}).replace("ISO 6487", "NOVALUE")
    assert (tmp_path / "out" / "Channel" / "t.chn").read_text() == expected


def test_a_channel_without_a_code_has_one_of_question_marks_and_none_again(tmp_path):
    write_isomme(record_of_one(), tmp_path / "out")  # other programs refuse a test where a channel has no code at all
    assert "Channel code                :????????????????\n" in (tmp_path / "out" / "Channel" / "t.001").read_text()
    again = read_isomme(tmp_path / "out")
    assert again.history("a").code is None
    assert again.problems == ()
