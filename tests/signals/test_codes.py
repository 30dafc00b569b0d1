from __future__ import annotations

import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown.errors import InvalidInput
from ridedown.signals.codes import SEATS, ChannelCode
from ridedown.signals.ev5_codes import axis_of, iso_code, place_of
from ridedown.units import recognised


@pytest.mark.parametrize(
    ("text", "place", "kind", "axis", "seat", "vehicle"),
    [
        ("11CHST0000H3ACXC", "chest", "acceleration", "x", "01", 1),
        ("13HEAD0000HFACRA", "head", "acceleration", "resultant", "02", 1),
        ("24NECKUP00P2MOZP", "neck_upper", "moment", "z", "04", 2),
        ("16FEMRRI00H3FOZB", "femur_right", "force", "z", "03", 1),
        ("11TIBILEUPH3FOZA", "tibia_left_upper", "force", "z", "01", 1),
        ("11TIBIRL00H3MOYB", "tibia_right_lower", "moment", "y", "01", 1),
        ("11CHST0000H3DSXC", "chest", "displacement", "x", "01", 1),
        ("11SEBE0000B3FO0D", "belt_shoulder", "force", "", "01", 1),
        ("13SEBE0000B6FO00", "belt_lap", "force", "", "02", 1),
        ("10SECMLERE00ACX0", "seat_crossmember_left", "acceleration", "x", None, 1),
        ("14SECM000000ACXD", "seat_crossmember_left", "acceleration", "x", None, 1),
        ("16BPIL000000ACX0", "b_pillar_right", "acceleration", "x", None, 1),
        ("10ENGNTP0000ACX0", "engine_top", "acceleration", "x", None, 1),
        ("10VEHCCG0000VEXA", "vehicle", "velocity", "x", None, 1),
        ("B0FBAR000000FOXD", "barrier", "force", "x", None, None),
        ("S0SLED000000ACXD", "sled", "acceleration", "x", None, None),
        ("11THSP0400THACXA", "thoracic_spine_04", "acceleration", "x", "01", 1),
        ("12HEAD0000Q6ACXA", "head", "acceleration", "x", "position 2", 1),
        ("10DASHLERE00ACX0", "DASHLERE", "acceleration", "x", None, 1),
        ("10ZZZZ000000XX00", "ZZZZ", "XX", "", None, 1),
    ],
)
def test_codes_in_plain_words(text, place, kind, axis, seat, vehicle):
    code = ChannelCode.parse(text)
    assert (code.place, code.kind, code.axis, code.seat, code.vehicle) == (place, kind, axis, seat, vehicle)


def test_filter_letters_are_channel_classes():
    letters = {letter: ChannelCode.parse(f"11HEAD0000H3ACX{letter}").frequency_class for letter in "0ABCDEFGHLPSX"}
    assert letters == {
        "0": None, "A": 1000, "B": 600, "C": 180, "D": 60, "E": 1000, "F": 600, "G": 180, "H": 60, "L": 20,
        "P": None, "S": None, "X": None,
    }  # fmt: skip


def test_a_filter_class_becomes_its_present_letter():
    code = ChannelCode.parse("11HEAD0000H3ACX0")
    assert [str(code.filtered(size))[-1] for size in (1000, 600, 180, 60, None, 100)] == ["A", "B", "C", "D", "0", "S"]


@pytest.mark.parametrize(
    "text", ["", "11HEAD0000H3ACX", "11HEAD0000H3ACX00", "11HEAD-000H3ACX0", "11HEÄD0000H3ACX0", "11HEAD 000H3ACX0"]
)
def test_anything_but_16_letters_and_digits_is_refused(text):
    with pytest.raises(InvalidInput, match="need 16 letters and digits"):
        ChannelCode.parse(text)


def test_a_part_of_the_wrong_length_is_refused():
    with pytest.raises(InvalidInput, match="channel code"):
        ChannelCode("1", "1", "HEAD", "000", "0", "H3", "AC", "X", "0")


def test_small_letters_and_unknown_characters_are_taken():
    code = ChannelCode.parse(" 11chstleup00dsx? ")
    assert str(code) == "11CHSTLEUP00DSX?"
    assert code.frequency_class is None


@given(st.text(alphabet=string.ascii_uppercase + string.digits + "?", min_size=16, max_size=16))
def test_any_code_is_built_back_from_its_parts(text):
    code = ChannelCode.parse(text)
    assert str(code) == text
    assert code.place
    assert code.kind
    assert isinstance(code.redundant, bool)


def test_redundant_sensors_are_told_by_their_fine_location():
    assert ChannelCode.parse("11HEADRD00H3ACX0").redundant
    assert ChannelCode.parse("11HEADRD00H3ACX0").place == "head"
    assert not ChannelCode.parse("11HEAD0000H3ACX0").redundant


def test_seats_are_those_of_the_database():
    assert SEATS == {"1": "01", "3": "02", "6": "03", "4": "04"}


# EV5 codes


def code(**changed):
    given = {
        "vehicle": 1, "seat": "01", "dummy": ("H3", "50"), "sensor": "AC", "place": "head", "axis": "x", "unit": "g",
        "redundant": False,
    }  # fmt: skip
    return iso_code(**(given | changed))


def test_codes_are_derived_where_every_part_is_known():
    assert code() == "11HEAD0000H3ACX0"
    assert code(vehicle=2, seat="04", dummy=("H3", "05")) == "24HEAD0000HFACX0"
    assert code(seat="03", dummy=("H3", "95"), place="chest") == "16CHST0000HMACX0"
    assert code(sensor="LC", place="neck_upper", axis="y", unit="N m") == "11NECKUP00H3MOY0"
    assert code(sensor="DS", place="chest", unit="mm") == "11CHST0000H3DSX0"
    assert code(sensor="AV", unit="deg/s") == "11HEAD0000H3AVX0"
    assert code(redundant=True) == "11HEADRD00H3ACX0"
    assert code(dummy=("XX", "50")) == "11HEAD000000ACX0"
    assert code(seat="", dummy=("", ""), place="seat_crossmember_left") == "10SECMLERE00ACX0"


@pytest.mark.parametrize(
    "changed",
    [
        {"place": "STCL"},  # a place whose code is not known
        {"seat": "07"},  # a seat without a position
        {"unit": "N"},  # an accelerometer does not measure newtons
        {"unit": "furlong"},
        {"sensor": "ZZ"},
        {"vehicle": 0},  # a barrier's load cell
        {"place": "femur_left", "sensor": "LC", "unit": "N", "redundant": True},  # no place left for the mark
    ],
)
def test_no_code_is_guessed(changed):
    assert code(**changed) is None


def test_the_commentary_tells_the_crossmember_from_the_floor():
    assert place_of("FLLR", "LEFT REAR SEAT CROSSMEMBER X") == "seat_crossmember_left"
    assert place_of("FLRR", "RIGHT REAR SEAT CROSS-MEMBER XR") == "seat_crossmember_right"
    assert place_of("FLLR", "") == "floor_left_rear"
    assert place_of("ENGN", "BOTTOM OF ENGINE X: No valid data after 67ms") == "engine_bottom"
    assert place_of("ENGN", "ENGINE, TOP OR BOTTOM") == "engine"
    assert place_of("hdcg", "") == "head"


def test_units_and_axes_of_the_header():
    assert [recognised(text) for text in ("G'S", "NWT", "NWM", "MM", "DPS", "sec", "XYZ")] == [
        "g",
        "N",
        "N m",
        "mm",
        "deg/s",
        "s",
        "XYZ",
    ]
    assert [axis_of(text) for text in ("XL", "YG", "zl", "RS", "NA", "")] == ["x", "y", "z", "resultant", "", ""]
