"""What the codes of an EV5 header mean: sensors, places, units, seats; and the ISO-MME channel code, where it is certain.

Certain means: each part of the code follows from the header itself, with nothing guessed. A place whose code is not in
the table keeps that code as its location and gets no ISO-MME code.
"""

from __future__ import annotations

from collections.abc import Mapping

from ridedown.signals.codes import QUANTITIES, SEATS, ChannelCode

PLACES: Mapping[str, str] = {
    "HDCG": "head",
    "NEKU": "neck_upper",
    "CHST": "chest",
    "PVCN": "pelvis",
    "FMRL": "femur_left",
    "FMRR": "femur_right",
    "TBLU": "tibia_left_upper",
    "TBLL": "tibia_left_lower",
    "TBRU": "tibia_right_upper",
    "TBRL": "tibia_right_lower",
    "FTLR": "foot_left_rear",
    "FTLF": "foot_left_front",
    "FTRR": "foot_right_rear",
    "FTRF": "foot_right_front",
    "SHBT": "belt_shoulder",
    "LPBO": "belt_lap",
    "FLLR": "floor_left_rear",
    "FLRR": "floor_right_rear",
    "ENGN": "engine",
}
"""SENATT, what the sensor is attached to, in plain words: those that test 10146 uses, where the commentary of each channel
says what its code means. The guide's full list was not at hand; other codes stand for themselves."""

_ISO = {
    "head": ("HEAD", "00", "00"),
    "neck_upper": ("NECK", "UP", "00"),
    "chest": ("CHST", "00", "00"),
    "pelvis": ("PELV", "00", "00"),
    "femur_left": ("FEMR", "LE", "00"),
    "femur_right": ("FEMR", "RI", "00"),
    "tibia_left_upper": ("TIBI", "LE", "UP"),
    "tibia_left_lower": ("TIBI", "LE", "LO"),
    "tibia_right_upper": ("TIBI", "RI", "UP"),
    "tibia_right_lower": ("TIBI", "RI", "LO"),
    "seat_crossmember_left": ("SECM", "LE", "RE"),
    "seat_crossmember_right": ("SECM", "RI", "RE"),
    "engine": ("ENGN", "00", "00"),
    "engine_top": ("ENGN", "TP", "00"),
    "engine_bottom": ("ENGN", "BO", "00"),
}

_QUANTITIES = {"g": "AC", "N": "FO", "N m": "MO", "mm": "DS", "deg/s": "AV"}
_SENSORS = {"AC": {"AC"}, "LC": {"FO", "MO"}, "DS": {"DS"}, "AV": {"AV"}}  # sensor type to the quantities that it can measure

_POSITIONS = {seat: position for position, seat in SEATS.items()}
_ISO_DUMMIES = {("H3", "50"): "H3", ("H3", "05"): "HF", ("H3", "95"): "HM", ("TH", "50"): "TH"}

DUMMIES: Mapping[str, str] = {"H3": "Hybrid III", "H2": "Hybrid II", "TH": "THOR"}
"""OCCTYP in words, where certain; other types keep their code."""

STATUSES: Mapping[str, str] = {
    "AM": "",  # as measured: all is well
    "CF": "questionable",
    "MN": "meaningless",
    "CM": "computed",
    "NO": "no data",
}
"""DASTAT in words (the guide's list as data laboratories use it)."""


def kind_of(sensor: str, unit: str) -> str:
    """The physical quantity in plain words, of the unit and where that is not known of the sensor; else empty."""
    quantity = _QUANTITIES.get(unit) or next(iter(sorted(_SENSORS.get(sensor.upper(), ()))), "")
    return QUANTITIES.get(quantity, "")


def axis_of(text: str) -> str:
    """`x`, `y`, `z` or `resultant` of an AXIS code (XL, YG, RS, ...); empty where it has none."""
    code = text.upper()
    if code[:1] in {"X", "Y", "Z"}:
        return code[0].lower()
    return "resultant" if code in {"RS", "RES"} else ""


def place_of(attachment: str, commentary: str) -> str:
    """The place in plain words, of what the sensor is attached to and, where that is coarser, of its commentary.

    Test 10146 codes the rear seat's crossmember as the floor, and both ends of the engine alike: only the commentary
    tells.

    >>> place_of("FLLR", "LEFT REAR SEAT CROSSMEMBER X"), place_of("ENGN", "TOP OF ENGINE X"), place_of("STCL", "")
    ('seat_crossmember_left', 'engine_top', 'STCL')
    """
    plain = PLACES.get(attachment.upper(), attachment)
    words = commentary.upper().replace("-", " ")
    side = next((side for side in ("left", "right") if side.upper() in words.split()), "")
    if "SEAT" in words and ("CROSSMEMBER" in words or "CROSS MEMBER" in words):
        return f"seat_crossmember_{side}" if side else "seat_crossmember"
    if plain == "engine":
        ends = [end for end in ("top", "bottom") if end.upper() in words.split()]
        return f"engine_{ends[0]}" if len(ends) == 1 else "engine"
    return plain


def iso_code(
    *, vehicle: int, seat: str, dummy: tuple[str, str], sensor: str, place: str, axis: str, unit: str, redundant: bool
) -> str | None:
    """The ISO-MME code of a channel, unfiltered, None where any part of it would be a guess.

    dummy: (OCCTYP, DUMMSIZ) of the occupant in that seat, empty texts where there is none.

    >>> iso_code(vehicle=1, seat="02", dummy=("H3", "05"), sensor="AC", place="head", axis="x", unit="g", redundant=False)
    '13HEAD0000HFACX0'
    """
    quantity = _QUANTITIES.get(unit)
    if place not in _ISO or quantity is None or quantity not in _SENSORS.get(sensor.upper(), ()):
        return None
    if not 1 <= vehicle <= 9:
        return None
    location, fine1, fine2 = _ISO[place]
    position, section = "0", "00"
    if seat:
        if seat not in _POSITIONS:
            return None
        position = _POSITIONS[seat]
        section = _ISO_DUMMIES.get(dummy, "00")
    if redundant:
        # Fine location 1 has a mark for it. Where that is taken, the lists leave several ways: no guess.
        if fine1 != "00":
            return None
        fine1 = "RD"
    direction = {"": "0", "resultant": "R"}.get(axis, axis.upper())
    return str(ChannelCode(str(vehicle), position, location, fine1, fine2, section, quantity, direction, "0"))
