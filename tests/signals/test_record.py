"""A record finds channels by key, number, code, name and meaning, and one bad channel does not stop the others."""

from __future__ import annotations

import pytest

from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals import ChannelInfo, TestRecord, TimeHistory
from ridedown.signals.record import Occupant, OfficialResult


def channel(key: str, **fields: object) -> ChannelInfo:
    return ChannelInfo(key, number=int(key), **fields)


INFOS = [
    channel("1", name="HEAD CG X", location="head", occupant="01", vehicle=1, quantity="acceleration", axis="x",
            code="11HEAD0000H3ACX0"),
    channel("2", name="HEAD CG Y", location="head", occupant="01", vehicle=1, quantity="acceleration", axis="y"),
    channel("3", name="HEAD CG X", location="head", occupant="02", vehicle=1, quantity="acceleration", axis="x"),
    channel("4", name="ENGINE TOP", location="engine_top", vehicle=1, quantity="acceleration", axis="x"),
    channel("5", name="ENGINE BOTTOM", location="engine_bottom", vehicle=1, quantity="acceleration", axis="x", redundant=True),
    channel("6", name="LOST", location="engine_top", vehicle=1, quantity="acceleration", axis="x", readable=False),
    channel("7", name="BROKEN", location="chest", occupant="01", vehicle=2, quantity="force"),
]  # fmt: skip


def load(info: ChannelInfo) -> TimeHistory:
    if not info.readable or info.name == "BROKEN":
        raise InvalidInput(f"v1.00{info.key}:12: got 'x'; need one finite number. Correct the line.")
    remarks = ("v1.005: ends early",) if info.key == "5" else ()
    return TimeHistory([float(info.key)] * 3, "g", interval=0.1, name=info.name, remarks=remarks)


@pytest.fixture
def record() -> TestRecord:
    return TestRecord(
        "v1",
        occupants=(
            Occupant("01", official={"HIC": OfficialResult(140.0, "", 0.0777, 0.0927)}),
            Occupant("02"),
            Occupant("01", vehicle=2),
        ),
        channels={info.key: info for info in INFOS},
        problems=("v1.EV5:9: TOTCRV is 8, but 7 channels are listed",),
        load=load,
    )


def keys(infos: tuple[ChannelInfo, ...]) -> list[str]:
    return [info.key for info in infos]


@pytest.mark.parametrize("asked", ["1", 1, "001", "11HEAD0000H3ACX0", "11head0000h3acx0", "HEAD CG X", "head cg x", INFOS[0]])
def test_a_channel_is_found_by_key_number_code_and_name(record, asked):
    assert record.channel(asked).key == "1"
    assert record.history(asked).values.tolist() == [1.0, 1.0, 1.0]


def test_an_unknown_channel_is_answered_with_the_nearest(record):
    with pytest.raises(UnknownName, match="Did you mean 'ENGINE TOP'"):
        record.history("ENGINE TIP")


@pytest.mark.parametrize(
    ("meaning", "found"),
    [
        ({"location": "head"}, ["1", "2", "3"]),
        ({"location": "head", "occupant": "01", "axis": "x"}, ["1"]),
        ({"location": "engine"}, ["4", "5"]),
        ({"location": "engine_top"}, ["4"]),  # 6 has no curve
        ({"location": "engine", "redundant": False}, ["4"]),
        ({"vehicle": 2}, ["7"]),
        ({"quantity": "force"}, ["7"]),
        ({"location": "eng"}, []),
        ({"location": "pelvis"}, []),
    ],
)
def test_channels_are_found_by_meaning(record, meaning, found):
    assert keys(record.find(**meaning)) == found


def test_the_rest_goes_on_where_one_channel_cannot_be_read(record):
    assert [info.key for info, _ in record.readable()] == ["1", "2", "3", "4", "5"]
    with pytest.raises(InvalidInput, match=r"^v1\.007:12: got 'x'"):
        record.history("7")


def test_faults_are_those_of_the_header_and_of_each_curve(record):
    assert record.faults() == (
        "v1.EV5:9: TOTCRV is 8, but 7 channels are listed",
        "v1.005: ends early",
        "v1.007:12: got 'x'; need one finite number. Correct the line.",
    )


def test_an_occupant_is_found_by_seat_and_vehicle(record):
    assert record.occupant("01").official["HIC"].value == 140.0
    assert record.occupant("01", vehicle=2).vehicle == 2
    with pytest.raises(UnknownName, match="seat: no '03'"):
        record.occupant("03")


def test_a_record_of_signals_at_hand_has_each_under_its_name():
    signals = [TimeHistory([1.0], "g", interval=0.1, name=name) for name in ("a", "b")]
    record = TestRecord.of(signals, identifier="sled 7", title="sled", format="none")
    assert list(record.channels) == ["a", "b"]
    assert record.history("b") is signals[1]
    assert (record.title, record.history(2).name) == ("sled", "b")
    with pytest.raises(InvalidInput, match="got 'a' twice or empty"):
        TestRecord.of([signals[0], signals[0]], identifier="x")
    with pytest.raises(UnknownName, match="Did you mean 'title'"):
        TestRecord.of(signals, identifier="x", titel="y")


def test_a_record_without_curves_says_so():
    with pytest.raises(InvalidInput, match="got a record without curves"):
        TestRecord("x", channels={"1": INFOS[0]}).history("1")
