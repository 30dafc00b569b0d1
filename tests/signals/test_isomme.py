from __future__ import annotations

from datetime import date

import numpy as np
import pytest

from ridedown.errors import InvalidInput
from ridedown.signals.files import open_tree
from ridedown.signals.history import Filter
from ridedown.signals.isomme import read_isomme, recognises
from tests.signals.ev5_samples import pack
from tests.signals.isomme_samples import MME, VALUES, data, head, lines, one, write


@pytest.fixture
def plain(tmp_path):
    return write(tmp_path / "t7", one())


def test_what_was_tested_and_a_channel(plain):
    record = read_isomme(plain)
    assert (record.identifier, record.title, record.laboratory) == ("t7", "A test: full width", "CRASH LAB")
    assert (record.date, record.format) == (date(2026, 5, 14), "ISO-MME 1.6")
    assert [(v.number, v.name, v.mass, v.speed) for v in record.vehicles] == [(1, "Blue car", 1234.5, 13.92)]
    assert [(o.seat, o.vehicle, o.dummy, o.percentile) for o in record.occupants] == [("01", 1, "Hybrid III", "50")]
    assert record.fields["Comments"] == "first\nsecond: with a colon"
    assert record.fields["Customer name"] == ""
    assert record.problems == ()
    history = record.history("11HEAD0000H3ACXA")
    assert history.values.tolist() == list(VALUES)
    assert (history.unit, history.name, history.start, history.interval) == ("g", "Head acceleration X", -2e-4, 1e-4)
    assert history.filtered == Filter(1000.0)
    (info,) = record.find(location="head", occupant="01", quantity="acceleration", axis="x")
    assert (info.number, info.sensor, info.samples, info.status, info.vehicle) == (1, "Accelerometer", 4, "", 1)


def test_a_folder_a_zip_a_zip_with_a_folder_and_the_mme_file_hold_the_same_test(plain, tmp_path):
    for place in [
        plain,
        plain / "t7.mme",
        pack(plain, tmp_path / "a.zip"),
        pack(plain, tmp_path / "b.zip", "x/t7/"),
        open_tree(plain),
    ]:
        record = read_isomme(place)
        assert record.problems == ()
        assert record.history(1).values.tolist() == list(VALUES)
    assert recognises(open_tree(plain))


def test_letter_case_of_names_and_keys_does_not_matter(tmp_path):
    folder = tmp_path / "t7"
    (folder / "CHANNEL").mkdir(parents=True)
    (folder / "T7.MME").write_text(lines({key.upper(): value for key, value in MME.items()}))
    (folder / "CHANNEL" / "t7.CHN").write_text("NAME OF CHANNEL 001: 11head0000h3acxa\n")
    (folder / "CHANNEL" / "T7.001").write_text(
        lines({key.lower(): value for key, value in head("11head0000h3acxa").items()}) + data()
    )
    record = read_isomme(folder)
    assert record.problems == ()
    assert record.title == "A test: full width"
    assert record.history(1).code == "11HEAD0000H3ACXA"
    assert record.history(1).values.tolist() == list(VALUES)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "cp1252", "latin-1"])
def test_encodings_as_met(tmp_path, encoding):
    mme = lines(MME | {"Title": "Prüfung 30° – Fußgänger" if encoding != "latin-1" else "Prüfung 30° Fußgänger"})
    record = read_isomme(write(tmp_path / "t7", one(Unit="°/s"), mme=mme, encoding=encoding))
    assert record.title.startswith("Prüfung 30°")
    assert record.title.endswith("Fußgänger")
    assert record.history(1).unit == "deg/s"


@pytest.mark.parametrize("end", ["\r\n", "\r"])
def test_line_ends_as_met(tmp_path, end):
    record = read_isomme(write(tmp_path / "t7", {1: one()[1].replace("\n", end)}, mme=lines(MME).replace("\n", end)))
    assert record.history(1).values.tolist() == list(VALUES)


def test_times_may_stand_in_another_channel(tmp_path):
    clock = lines(head("10TIRS000000TI00", Unit="ms", Name_of_the_channel="Time", Sampling_interval="DROP")) + data(
        (-1.0, 0.0, 0.0, 5.0)
    )
    signal = (
        lines(head(Reference_channel="Explicit", Reference_channel_name="10TIRS000000TI00", Sampling_interval="NOVALUE"))
        + data()
    )
    record = read_isomme(write(tmp_path / "t7", {1: signal, 2: clock}, codes={1: "11HEAD0000H3ACXA", 2: "10TIRS000000TI00"}))
    history = record.history(1)
    assert history.interval is None
    assert history.stamps.tolist() == [-1e-3, 0.0, 0.0, 5e-3]
    assert history.values.tolist() == list(VALUES)


@pytest.mark.parametrize(
    ("name", "times", "words"),
    [
        ("NOVALUE", (0.0, 1.0, 2.0, 3.0), "is 0 channels"),
        ("10TIRS000000TI0X", (0.0, 1.0, 2.0, 3.0), "is 0 channels"),
        ("10TIRS000000TI00", (0.0, 1.0, 2.0), "got 3 times for the 4 samples"),
        ("10TIRS000000TI00", (0.0, 2.0, 1.0, 3.0), "never fall"),
    ],
)
def test_times_that_do_not_do_are_refused(tmp_path, name, times, words):
    clock = lines(head("10TIRS000000TI00", Unit="s", Name_of_the_channel="Time", Number_of_samples="NOVALUE")) + data(times)
    signal = lines(head(Reference_channel="explicit", Reference_channel_name=name)) + data()
    record = read_isomme(write(tmp_path / "t7", {1: signal, 2: clock}, codes={1: "11HEAD0000H3ACXA", 2: "10TIRS000000TI00"}))
    with pytest.raises(InvalidInput, match=words):
        record.history(1)


@pytest.mark.parametrize(
    ("letter", "stated", "size"),
    [
        ("A", "NOVALUE", 1000),
        ("C", "1000", 180),
        ("0", "1000", None),
        ("P", "1000", None),
        ("?", "CFC 60", 60),
        ("S", "100", 100),
        ("?", "NOVALUE", None),
    ],
)
def test_the_code_tells_the_filter_before_the_frequency_class_does(tmp_path, letter, stated, size):
    code = f"11HEAD0000H3ACX{letter}"
    record = read_isomme(
        write(tmp_path / "t7", {1: lines(head(code, Channel_frequency_class=stated)) + data()}, codes={1: code})
    )
    assert record.history(1).filtered == (None if size is None else Filter(float(size)))


def test_a_missing_unit_is_the_si_unit_of_the_code_and_said(tmp_path):
    record = read_isomme(write(tmp_path / "t7", one(Unit="NOVALUE")))
    assert record.history(1).unit == "m/s2"
    assert "names no unit; m/s2 is taken" in record.problems[0]


def test_speeds_and_masses_may_name_their_unit(tmp_path):
    mme = lines(MME | {"Velocity test object 1": "50.4 km/h", "Mass test object 1": "1.5 t"})
    (vehicle,) = read_isomme(write(tmp_path / "t7", one(), mme=mme)).vehicles
    assert vehicle.speed == pytest.approx(14.0, rel=1e-15)
    assert vehicle.mass == 1500.0


def test_a_second_vehicle_and_a_barrier_are_told_apart(tmp_path):
    codes = {1: "21CHST0000HFACXC", 2: "B0FBAR000000FOX0"}
    record = read_isomme(write(tmp_path / "t7", {n: lines(head(code)) + data() for n, code in codes.items()}, codes=codes))
    assert [(o.seat, o.vehicle, o.percentile) for o in record.occupants] == [("01", 2, "05")]
    assert record.find(location="barrier", vehicle=0)[0].number == 2


# what is wrong is said, and the rest goes on


def test_a_channel_without_a_file_is_said(tmp_path):
    record = read_isomme(write(tmp_path / "t7", one(), codes={1: "11HEAD0000H3ACXA / Head", 2: "11CHST0000H3ACXC / Chest"}))
    assert record.problems == ("channel 2, 11CHST0000H3ACXC / Chest: is listed, but has no file",)
    assert (record.channel(2).readable, record.channel(2).location, record.channel(2).name) == (False, "chest", "Chest")
    assert record.history(1).values.size == 4
    with pytest.raises(InvalidInput, match="channel 2: got no file"):
        record.history(2)


def test_a_file_that_is_not_listed_is_read_and_said(tmp_path):
    record = read_isomme(write(tmp_path / "t7", {1: one()[1], 12: one()[1]}, codes={1: "11HEAD0000H3ACXA"}))
    assert "t7.012: is not in the list" in record.problems[0]
    assert record.history(12).values.size == 4


def test_without_a_list_of_channels_the_files_are_read(plain):
    (plain / "Channel" / "t7.chn").unlink()
    record = read_isomme(plain)
    assert "no list of channels" in record.problems[0]
    assert record.history(1).values.tolist() == list(VALUES)


@pytest.mark.parametrize(
    ("values", "count", "words"), [(VALUES[:3], 3, "ends early, 3 samples of the 4"), ((*VALUES, 9.0), 5, "holds 5 samples")]
)
def test_a_wrong_count_is_said(tmp_path, values, count, words):
    history = read_isomme(write(tmp_path / "t7", {1: lines(head()) + data(values)})).history(1)
    assert len(history) == count
    assert words in history.remarks[0]


def test_values_missing_at_the_end_are_cut_off_and_said(tmp_path):
    history = read_isomme(write(tmp_path / "t7", {1: lines(head()) + data((1.0, 2.0, "NOVALUE", "NOVALUE"))})).history(1)
    assert history.values.tolist() == [1.0, 2.0]
    assert "ends early, 2 samples of the 4" in history.remarks[0]


@pytest.mark.parametrize("bad", ["NOVALUE", "nan", "1,5", "x", ""])
def test_a_wrong_value_names_its_line(tmp_path, bad):
    record = read_isomme(write(tmp_path / "t7", {1: lines(head()) + data((1.0, bad, 3.0, 4.0))}))
    with pytest.raises(InvalidInput, match=r"t7\.001:16: got"):
        record.history(1)


@pytest.mark.parametrize(
    "changed", [{"Sampling_interval": "NOVALUE"}, {"Sampling_interval": "0"}, {"Sampling_interval": "fast"}]
)
def test_a_channel_without_sampling_interval_is_refused(tmp_path, changed):
    record = read_isomme(write(tmp_path / "t7", one(**changed)))
    with pytest.raises(InvalidInput, match=r"t7\.001:10: got"):
        record.history(1)


def test_a_bad_code_is_said_and_the_channel_kept(tmp_path):
    record = read_isomme(write(tmp_path / "t7", one(code="HEAD X"), codes={1: "HEAD X"}))
    assert any("need 16 letters and digits" in problem for problem in record.problems)
    assert record.history("Head acceleration X").code is None


def test_a_flagged_channel_and_a_contradicting_list_are_said(tmp_path):
    record = read_isomme(write(tmp_path / "t7", one(Data_status="questionable"), codes={1: "11CHST0000H3ACXC", 2: "NOVALUE"}))
    said = " ".join(record.problems)
    assert "data status 'questionable'" in said
    assert "the list of channels has 11CHST0000H3ACXC" in said
    assert record.channel(1).code == "11HEAD0000H3ACXA"
    assert record.channel(1).status == "questionable"


def test_wrong_header_values_are_said(tmp_path):
    mme = lines(MME | {"Date of the test": "yesterday", "Mass test object 1": "heavy", "Number of test objects": "one"})
    record = read_isomme(write(tmp_path / "t7", one(), mme=mme))
    assert (record.date, record.vehicles) == (None, ())
    assert "yesterday" in " ".join(record.problems)
    mme = lines(MME | {"Date of the test": "14.05.2026", "Mass test object 1": "3 m"})
    record = read_isomme(write(tmp_path / "u7", one(), mme=mme))
    assert record.date == date(2026, 5, 14)
    assert record.vehicles[0].mass is None
    assert "a mass" in " ".join(record.problems)


@pytest.mark.parametrize("edition", ["2.0", "2", "2.1.3"])
def test_edition_2_is_answered_with_a_clear_sentence(tmp_path, edition):
    folder = write(tmp_path / "t7", one(), mme=lines(MME | {"Data format edition number": edition}))
    with pytest.raises(InvalidInput, match=rf"t7\.mme:1: got ISO-MME {edition}; need an edition below 2.* is not supported"):
        read_isomme(folder)


@pytest.mark.parametrize("edition", ["1.6", "1.4", "1.6.2", "NOVALUE"])
def test_editions_below_2_are_read(tmp_path, edition):
    assert read_isomme(write(tmp_path / "t7", one(), mme=lines(MME | {"Data format edition number": edition}))).title


def test_none_or_several_tests_are_refused(tmp_path):
    with pytest.raises(InvalidInput, match=r"need one file \*\.mme"):
        read_isomme(tmp_path)
    write(tmp_path / "a", one())
    write(tmp_path / "b", one())
    with pytest.raises(InvalidInput, match=r"need one file \*\.mme"):
        read_isomme(tmp_path)


def test_exponents_and_small_numbers_are_read_exactly(tmp_path):
    values = (1e-300, -1.7976931348623157e308, 0.1 + 0.2, 5e-324)
    history = read_isomme(write(tmp_path / "t7", {1: lines(head()) + data(values)})).history(1)
    assert history.values.tobytes() == np.array(values).tobytes()
