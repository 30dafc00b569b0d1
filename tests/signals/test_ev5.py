from __future__ import annotations

from datetime import date

import pytest

from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals.ev5 import read_ev5, recognises
from ridedown.signals.ev5_results import hic_window
from ridedown.signals.files import open_tree
from ridedown.signals.record import OfficialResult
from tests.signals.ev5_samples import VALUES, channel, curve, header, pack, row, sections, write


@pytest.fixture
def plain(tmp_path):
    return write(tmp_path / "test", header(sections([channel(1), channel(2, AXIS="YL")])), {1: curve(VALUES), 2: curve(VALUES)})


def read(tmp_path, channels, curves=None, **more):
    return read_ev5(write(tmp_path / "test", header(sections(channels, **more)), curves or {}))


def test_a_folder_a_zip_a_zip_with_a_folder_and_the_header_file_hold_the_same_test(plain, tmp_path):
    places = [plain, plain / "v00007.EV5", pack(plain, tmp_path / "a.zip"), pack(plain, tmp_path / "b.zip", "v00007/data/")]
    for place in [*places, open_tree(plain)]:
        record = read_ev5(place)
        assert (record.identifier, record.title, record.date) == ("v00007", "A TEST", date(2017, 10, 3))
        assert (record.laboratory, record.format, record.closing_speed) == ("LAB", "NHTSA EV5", 10.0)
        assert record.problems == ()
        assert record.history(1).values.tolist() == list(VALUES)
        assert (record.history(1).start, record.history(1).interval, record.history(1).unit) == (-2e-4, 1e-4, "g")
    assert recognises(open_tree(plain))


def test_names_in_small_letters_and_crlf_do_not_matter(tmp_path):
    folder = tmp_path / "test"
    folder.mkdir()
    (folder / "V00007.ev5").write_bytes(header(sections([channel(1)]), end="\r\n").encode())
    (folder / "v00007.001").write_bytes(curve(VALUES).replace("\n", "\r\n").encode())
    record = read_ev5(folder)
    assert record.problems == ()
    assert record.history(1).values.tolist() == list(VALUES)


def test_curve_numbers_go_beyond_999(tmp_path):
    record = read(tmp_path, [channel(7), channel(1234)], {7: curve(VALUES), 1234: curve([2.0 * v for v in VALUES])})
    assert record.history(1234).values.tolist() == [2.0 * v for v in VALUES]
    assert record.problems == ()


@pytest.mark.parametrize(("delt", "rate"), [(80, 12_500.0), (125, 8_000.0), (50, 20_000.0), ("12.5", 80_000.0)])
def test_any_sampling_rate(tmp_path, delt, rate):
    interval = float(delt) / 1e6
    record = read(tmp_path, [channel(1, DELT=delt)], {1: curve(VALUES, interval=interval)})
    history = record.history(1)
    assert history.sampling_rate == pytest.approx(rate, rel=1e-12)
    assert history.remarks == ()
    assert history.time[2] == 0.0


def test_four_occupants_have_their_own_channels_results_and_codes(tmp_path):
    occupants = [
        row("OCCUPANT", VEHNO=1, OCCLOC=f"{i:02}", OCCTYP="H3", DUMMSIZ=size, HIC=100 * i, T1=50, T2=86, CLIP3M=30 + i)
        for i, size in ((1, "50"), (2, "05"), (3, "5"), (4, "95"))
    ]
    record = read(tmp_path, [channel(i, SENLOC=f"{i:02}") for i in range(1, 5)], {i: curve(VALUES) for i in range(1, 5)},
                  OCCUPANT=occupants)  # fmt: skip
    assert [occupant.seat for occupant in record.occupants] == ["01", "02", "03", "04"]
    assert [occupant.percentile for occupant in record.occupants] == ["50", "05", "05", "95"]
    assert [occupant.official["HIC"].value for occupant in record.occupants] == [100.0, 200.0, 300.0, 400.0]
    assert [hic_window(occupant.official["HIC"]) for occupant in record.occupants] == [0.036] * 4
    codes = [record.find(location="head", occupant=seat)[0].code for seat in ("01", "02", "03", "04")]
    assert codes == ["11HEAD0000H3ACX0", "13HEAD0000HFACX0", "16HEAD0000HFACX0", "14HEAD0000HMACX0"]


def test_belt_forces_are_found(tmp_path):
    belts = [
        channel(1, SENTYP="LC", SENATT="SHBT", AXIS="NA", YUNITS="NWT"),
        channel(2, SENTYP="LC", SENATT="LPBO", AXIS="NA", YUNITS="NWT"),
    ]
    occupant = row("OCCUPANT", VEHNO=1, OCCLOC="01", OCCTYP="H3", DUMMSIZ=50, LBELT=4321, SBELT=5678.5)
    record = read(tmp_path, belts, {1: curve(VALUES), 2: curve(VALUES)}, OCCUPANT=[occupant])
    (shoulder,) = record.find(location="belt_shoulder", occupant="01", quantity="force")
    assert (shoulder.number, shoulder.unit, shoulder.code) == (1, "N", None)
    assert record.find(location="belt_lap", occupant="01")[0].number == 2
    assert record.occupant("01").official["LBELT"] == OfficialResult(4321.0, "N")
    assert record.occupant("01").official["SBELT"] == OfficialResult(5678.5, "N")


def test_two_vehicles_keep_their_channels_apart(tmp_path):
    vehicles = [
        row("VEHICLE", VEHNO=1, VEHTWT=1000, VEHSPD=50), row("VEHICLE", VEHNO=2, VEHTWT=2000, VEHSPD=0, VEHCOM="LAST")
    ]  # fmt: skip
    occupants = [row("OCCUPANT", VEHNO=v, OCCLOC="01", OCCTYP="H3", DUMMSIZ=s, HIC=v * 100) for v, s in ((1, 50), (2, "05"))]
    given = sections([channel(1), channel(2, VEHNO=2)], OCCUPANT=occupants) | {"VEHICLE": vehicles}
    record = read_ev5(write(tmp_path / "test", header(given), {1: curve(VALUES), 2: curve(VALUES)}))
    assert [(v.number, v.mass, v.speed) for v in record.vehicles] == [(1, 1000.0, 50 / 3.6), (2, 2000.0, 0.0)]
    assert record.vehicles[1].fields["VEHCOM"] == "LAST"
    assert record.find(location="head", vehicle=2)[0].code == "21HEAD0000HFACX0"
    assert record.occupant("01", 2).official["HIC"].value == 200.0


def test_a_test_without_barrier_occupants_or_date_is_read(tmp_path):
    given = {"TEST": [row("TEST", TITLE="BARE", TSTDAT="NULL")], "INSTRUMENTATION": [channel(1)]}
    record = read_ev5(write(tmp_path / "test", header(given), {1: curve(VALUES)}))
    assert (record.date, record.barrier, record.occupants, record.vehicles, record.restraints) == (None, None, (), (), ())
    assert record.closing_speed is None
    assert record.problems == ()
    assert record.history(1).code == "11HEAD000000ACX0"  # no dummy is named


def test_barrier_restraints_and_later_fields_are_kept(tmp_path):
    record = read(tmp_path, [channel(1) + "|LATER"], {1: curve(VALUES)}, BARRIER=["R|LCB|30|0|WALL"],
                  RESTRAINT=["1|01|1|3PT|BC|NA|BELT", "1|01|2|FRT|SW|DP|BAG"])  # fmt: skip
    assert (record.barrier.kind, record.barrier.shape, record.barrier.fields["BARANG"]) == ("R", "LCB", "30")
    assert [(r.seat, r.kind, r.mount, r.deployment) for r in record.restraints] == [
        ("01", "3PT", "BC", "NA"),
        ("01", "FRT", "SW", "DP"),
    ]
    assert record.channel(1).fields["FIELD21"] == "LATER"


# what was not measured, and what is wrong


def test_zero_and_empty_are_no_results(tmp_path):
    occupant = row("OCCUPANT", VEHNO=1, OCCLOC="01", HIC=0, T1=0, T2=0, CLIP3M="", LFEM="NULL", RFEM="0.0", CSI=0, TTI=0.0)
    assert read(tmp_path, [], OCCUPANT=[occupant]).occupants[0].official == {}


def test_an_interval_may_begin_at_time_zero_and_counts_only_with_its_hic(tmp_path):
    occupant = row("OCCUPANT", VEHNO=1, OCCLOC="01", HIC=500, T1=0, T2=15)
    (found,) = read(tmp_path, [], OCCUPANT=[occupant]).occupants
    assert found.official["HIC"] == OfficialResult(500.0, "", 0.0, 0.015)
    assert found.official["T1"] == OfficialResult(0.0, "ms")


def test_a_row_of_nines_is_a_filler_and_said(tmp_path):
    occupant = row("OCCUPANT", VEHNO=1, OCCLOC="01", HIC=9999, CLIP3M="9999.9", LFEM=9999, RFEM=-99999)
    record = read(tmp_path, [], OCCUPANT=[occupant])
    assert dict(record.occupants[0].official) == {"LFEM": OfficialResult(9999.0, "N")}  # a femur may well have carried 9999 N
    assert sum("filler" in problem for problem in record.problems) == 3


@pytest.mark.parametrize(
    ("start", "end", "window"),
    [
        (77.7, 92.7, 0.015),
        (67.8, 82.8, 0.015),
        (50.0, 86.0, 0.036),
        (50.0, 70.0, 0.036),
        (50.0, 58.3, None),
        (50.0, 95.0, None),
    ],
)
def test_the_interval_tells_which_hic_it_is(start, end, window):
    assert hic_window(OfficialResult(300.0, "", start / 1e3, end / 1e3)) == window


def test_a_hic_without_interval_is_of_unknown_window():
    assert hic_window(OfficialResult(300.0, "")) is None


def test_a_channel_without_a_file_is_said_and_the_rest_goes_on(tmp_path):
    record = read(tmp_path, [channel(i) for i in (1, 2, 3, 5)], {1: curve(VALUES)})
    assert record.problems == ("v00007.EV5: 3 of 4 channels have no file: 2-3, 5",)
    assert (record.channel(2).readable, record.channel(2).status) == (False, "no file")
    assert record.history(1).values.size == 6
    with pytest.raises(InvalidInput, match="channel 2: got no curve file"):
        record.history(2)
    with pytest.raises(UnknownName):
        record.history(9)


@pytest.mark.parametrize(("status", "word"), [("CF", "questionable"), ("MN", "meaningless")])
def test_flagged_channels_are_said_and_still_read(tmp_path, status, word):
    record = read(tmp_path, [channel(1, DASTAT=status), channel(2, DASTAT="CM")], {1: curve(VALUES), 2: curve(VALUES)})
    assert (record.channel(1).status, record.channel(2).status) == (word, "computed")
    assert record.problems == (f"v00007.EV5:8: curve 1, CHANNEL 1, is {word}",)
    assert record.history(1).values.size == 6


def test_a_channel_that_ends_before_the_others_is_said(tmp_path):
    record = read(
        tmp_path, [channel(1), channel(2), channel(3, NLP=1)], {1: curve(VALUES), 2: curve(VALUES), 3: curve(VALUES[:4])}
    )
    assert record.problems == ("v00007.EV5:10: curve 3, CHANNEL 3, ends early, at 0.0001 s of 0.0003 s",)
    assert record.history(3).remarks == ()


def test_a_file_that_ends_early_is_said_with_its_history(tmp_path):
    record = read(tmp_path, [channel(1)], {1: curve(VALUES[:4])})
    assert record.history(1).remarks == ("v00007.001: ends early, 4 samples of the 6 that the header gives",)
    assert record.faults() == record.history(1).remarks


def test_a_damaged_curve_names_its_line_and_the_rest_goes_on(tmp_path):
    record = read(tmp_path, [channel(1), channel(2)], {1: "0.0\t1.0\n0.1\tbroken\n", 2: curve(VALUES)})
    with pytest.raises(InvalidInput, match=r"^v00007\.001:2: got 'broken'"):
        record.history(1)
    assert [info.number for info, _ in record.readable()] == [2]


def test_contradictions_in_the_header_are_said(tmp_path):
    text = sections([channel(1), channel(1, INSCOM="TWICE"), channel("", INSCOM="NONE"), channel(2, VEHNO="x", NFP=5, NLP=1)])
    text["TEST"] = [row("TEST", TITLE="T", TOTCRV=9, TSTDAT="yesterday", CLSSPD="fast")]
    record = read_ev5(write(tmp_path / "test", header(text), {1: curve(VALUES), 2: curve(VALUES), 8: curve(VALUES)}))
    said = " ".join(record.problems)
    for words in (
        "curve 1 is listed twice",
        "without a curve number",
        "TOTCRV is 9, but 4",
        "YESTERDAY",
        "'fast'",
        "does not list: 8",
        "'x'",
    ):
        assert words in said
    assert record.channel(1).name == "CHANNEL 1"
    assert record.history(2).start == -2e-4  # the header's own grid is impossible; the file's times do


def test_a_curve_that_is_not_over_time_is_refused(tmp_path):
    record = read(tmp_path, [channel(1, XUNITS="MM")], {1: curve(VALUES)})
    with pytest.raises(InvalidInput, match="XUNITS"):
        record.history(1)


def test_an_unknown_unit_is_kept(tmp_path):
    assert read(tmp_path, [channel(1, YUNITS="ZOG")], {1: curve(VALUES)}).history(1).unit == "ZOG"


@pytest.mark.parametrize("count", [0, 2])
def test_none_or_several_headers_are_refused(tmp_path, count):
    (tmp_path / "note.txt").write_text("x")
    for i in range(count):
        (tmp_path / f"v{i}.EV5").write_text(header(sections([])))
    with pytest.raises(InvalidInput, match=r"need one file \*\.EV5"):
        read_ev5(tmp_path)
