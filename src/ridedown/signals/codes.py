"""The 16-character channel code of ISO-MME, built and taken apart, and what it means in plain words.

    1    1    CHST     0000        H3       AC        X         C
    |    |    |        |           |        |         |         `- filter: 0 none, A CFC 1000, B 600, C 180, D 60, ...
    |    |    |        |           |        |         `- direction: X Y Z, R resultant, 0 undefined
    |    |    |        |           |        `- physical quantity: AC acceleration, FO force, ...
    |    |    |        |           `- dummy, or which section of the belt
    |    |    |        `- two fine locations of two characters: left, upper, ...
    |    |    `- main location: chest
    |    `- position in the vehicle: 1 front left (also 0, where it has none)
    `- test object: 1-9 vehicle, B fixed barrier, M mobile barrier, S sled, ...

Only the codes named here have a plain word; any other well-formed code is kept and shown as it stands.

References:
    ISO/TS 13499, Road vehicles - Multimedia data exchange format for impact tests, related electronic document B
    (RED B), version 1.6: the lists of codes. Read in the publicly kept listing of version 1.6.2 that comes with the
    open-source package pyisomme; the standard itself was not at hand.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ridedown.errors import InvalidInput

UNKNOWN = "?" * 16
"""Stands for a code that is not known: programs refuse a channel whose file has none at all."""

OBJECTS: Mapping[str, str] = {
    **{str(n): f"vehicle {n}" for n in range(1, 10)},
    "0": "undefined",
    "B": "fixed barrier",
    "C": "component",
    "D": "dummy",
    "H": "linear impactor",
    "M": "mobile barrier",
    "P": "pendulum",
    "S": "sled",
    "T": "test rig",
}

POSITIONS: Mapping[str, str] = {
    "0": "undefined",
    "1": "front left",
    "2": "front middle",
    "3": "front right",
    "4": "second row left",
    "5": "second row middle",
    "6": "second row right",
    "7": "third row left",
    "8": "third row middle",
    "9": "third row right",
}

SEATS: Mapping[str, str] = {"1": "01", "3": "02", "6": "03", "4": "04"}
"""Position to seat, as records of every format number the four common seats: 01 and 02 front left and right,
03 and 04 second row right and left (the order of the NHTSA database)."""

QUANTITIES: Mapping[str, str] = {
    "AC": "acceleration",
    "AA": "angular acceleration",
    "AN": "angle",
    "AV": "angular velocity",
    "DC": "distance",
    "DS": "displacement",
    "DV": "displacement",  # integrated from velocity
    "EN": "energy",
    "EV": "event",
    "FO": "force",
    "IM": "impulse",
    "MA": "mass",
    "MO": "moment",
    "PO": "power",
    "PR": "pressure",
    "ST": "strain",
    "SR": "stress",
    "TE": "temperature",
    "TI": "time",
    "VA": "velocity",  # integrated from acceleration
    "VD": "velocity",  # differentiated from displacement
    "VE": "velocity",
    "VO": "voltage",
}

DEFAULT_UNITS: Mapping[str, str] = {
    "AC": "m/s2",
    "AA": "rad/s2",
    "AN": "rad",
    "AV": "rad/s",
    "DC": "m",
    "DS": "m",
    "DV": "m",
    "EN": "J",
    "FO": "N",
    "MA": "kg",
    "MO": "N m",
    "PR": "Pa",
    "TI": "s",
    "VA": "m/s",
    "VD": "m/s",
    "VE": "m/s",
}
"""The unit that a channel has whose file names none."""

DUMMIES: Mapping[str, tuple[str, str]] = {
    "H2": ("Hybrid II", "50"),
    "H3": ("Hybrid III", "50"),
    "HF": ("Hybrid III", "05"),
    "HM": ("Hybrid III", "95"),
    "TH": ("THOR", "50"),
    "TF": ("THOR", "05"),
    "E1": ("EuroSID-1", "50"),
    "E2": ("ES-2", "50"),
    "ER": ("ES-2re", "50"),
    "S2": ("SID-IIs", "05"),
    "WS": ("WorldSID", "50"),
    "WF": ("WorldSID", "05"),
    "BR": ("BioRID", "50"),
    "P1": ("P3/4", ""),
    "P2": ("P1 1/2", ""),
    "P3": ("P3", ""),
    "P4": ("P6", ""),
    "P5": ("P10", ""),
    "Q0": ("Q0", ""),
    "Q1": ("Q1", ""),
    "Q2": ("Q1.5", ""),
    "Q3": ("Q3", ""),
    "Q6": ("Q6", ""),
    "QA": ("Q10", ""),
    "Y6": ("Hybrid III 3 year old", ""),
    "Y7": ("Hybrid III 6 year old", ""),
    "YA": ("Hybrid III 10 year old", ""),
}
"""Dummy section to (type, percentile where the type has one)."""

CLASSES: Mapping[str, int] = {
    "A": 1000,
    "B": 600,
    "C": 180,
    "D": 60,
    "E": 1000,  # E-H: the editions of 1987 and 1988
    "F": 600,
    "G": 180,
    "H": 60,
    "L": 20,
}
"""Filter letter to channel frequency class; other letters (0 none, P prefiltered, S special, ...) have no class."""

_PLAIN = {
    "HEAD": "head",
    "NECK": "neck",
    "CHST": "chest",
    "PELV": "pelvis",
    "THSP": "thoracic_spine",
    "LUSP": "lumbar_spine",
    "ABDO": "abdomen",
    "PUBC": "pubic_symphysis",
    "FEMR": "femur",
    "KNSL": "knee_slider",
    "TIBI": "tibia",
    "FOOT": "foot",
    "SECM": "seat_crossmember",
    "ENGN": "engine",
    "BPIL": "b_pillar",
    "SILB": "sill",
    "VEHC": "vehicle",
    "SLED": "sled",
    "FBAR": "barrier",
    "MBAR": "mobile_barrier",
}
_BELTS = {"B1": "belt_retractor", "B3": "belt_shoulder", "B4": "belt_shoulder", "B5": "belt_lap", "B6": "belt_lap"}
_FINE = {
    "LE": "left", "RI": "right", "UP": "upper", "LO": "lower", "TP": "top", "BO": "bottom", "FR": "front", "RE": "rear",
    "MI": "middle", "IN": "inner", "OU": "outer",
}  # fmt: skip
_PAIRS = {"LU": ("left", "upper"), "LL": ("left", "lower"), "RU": ("right", "upper"), "RL": ("right", "lower")}
_SIDES_BY_POSITION = {"1": "left", "4": "left", "7": "left", "3": "right", "6": "right", "9": "right"}
_TAKES_SIDE_OF_POSITION = {"SECM", "BPIL", "SILB"}
_REDUNDANT = {"RD", "L1", "L2", "M1", "R1", "U1"}
_UNSAID = {"00", "CG", "??"} | _REDUNDANT
_FORM = re.compile(r"[0-9A-Z?]{16}", re.ASCII)


@dataclass(frozen=True, slots=True)
class ChannelCode:
    """One channel code, part by part. A `?`, as some laboratories write, stands for a character that is not known.

    >>> code = ChannelCode.parse("11CHST0000H3ACXC")
    >>> code.location, code.section, code.quantity, code.direction, code.frequency_class
    ('CHST', 'H3', 'AC', 'X', 180)
    >>> code.place, code.kind, code.seat
    ('chest', 'acceleration', '01')
    >>> str(ChannelCode("1", "3", "FEMR", "LE", "00", "HF", "FO", "Z", "B"))
    '13FEMRLE00HFFOZB'

    Raises: InvalidInput, where a part has the wrong length or a character that no code has.
    """

    object: str
    position: str
    location: str
    fine1: str = "00"
    fine2: str = "00"
    section: str = "00"
    quantity: str = "00"
    direction: str = "0"
    filter: str = "0"

    def __post_init__(self) -> None:
        lengths = tuple(len(part) for part in self._parts)
        if lengths != (1, 1, 4, 2, 2, 2, 2, 1, 1) or not _FORM.fullmatch(str(self)):
            raise InvalidInput(f"channel code: got {str(self)[:40]!r}; {_RULE}")

    @property
    def _parts(self) -> tuple[str, ...]:
        return (
            self.object,
            self.position,
            self.location,
            self.fine1,
            self.fine2,
            self.section,
            self.quantity,
            self.direction,
            self.filter,
        )

    def __str__(self) -> str:
        return "".join(self._parts)

    @classmethod
    def parse(cls, text: str) -> ChannelCode:
        """The code that a text of 16 letters and digits holds; small letters count as capitals.

        Raises: InvalidInput.
        """
        code = text.strip().upper()
        if not _FORM.fullmatch(code):
            raise InvalidInput(f"channel code: got {text[:40]!r}; {_RULE}")
        return cls(code[0], code[1], code[2:6], code[6:8], code[8:10], code[10:12], code[12:14], code[14], code[15])

    # in plain words

    @property
    def place(self) -> str:
        """The location in plain words, sides and levels after it: `femur_left`, `tibia_right_upper`; else the raw code."""
        if self.location == "SEBE":
            return _BELTS.get(self.section, "belt")
        plain = _PLAIN.get(self.location)
        if plain is None:
            return self._raw_place
        words: list[str] = []
        for fine in (self.fine1, self.fine2):
            if fine not in _UNSAID:
                words += _PAIRS.get(fine, (_FINE.get(fine, fine.lower()),))
        side = _SIDES_BY_POSITION.get(self.position)
        if side and self.location in _TAKES_SIDE_OF_POSITION and not {"left", "right"} & set(words):
            words.insert(0, side)
        if self.location == "SECM":  # a seat's crossmember is looked for by its side; the row adds nothing
            words = [word for word in words if word not in {"rear", "front"}]
        return "_".join((plain, *words))

    @property
    def _raw_place(self) -> str:
        fine = self.fine1 + self.fine2
        return self.location + ("" if fine == "0000" else fine)

    @property
    def kind(self) -> str:
        """The physical quantity in plain words; the raw code where it has none here."""
        return QUANTITIES.get(self.quantity, self.quantity)

    @property
    def axis(self) -> str:
        """`x`, `y`, `z`, `resultant`, or empty where undefined. Axes 1-3 are X-Z against the sign of SAE J211."""
        return {"X": "x", "Y": "y", "Z": "z", "R": "resultant", "1": "-x", "2": "-y", "3": "-z"}.get(self.direction, "")

    @property
    def vehicle(self) -> int | None:
        """The number of the vehicle, None for a barrier, a sled, ..."""
        return int(self.object) if self.object in "123456789" else None

    @property
    def seat(self) -> str | None:
        """The occupant's seat (see SEATS; `position 5` for one that has no number there), None without an occupant.

        A vehicle part may stand at a position too; only a known dummy, or a part of a body, makes an occupant.
        """
        if self.position not in POSITIONS or self.position == "0":
            return None
        if self.section not in DUMMIES and self.location not in BODY and self.location != "SEBE":
            return None
        return SEATS.get(self.position, f"position {self.position}")

    @property
    def redundant(self) -> bool:
        """Whether it is marked as a second sensor for the same place."""
        return self.fine1 in _REDUNDANT or self.fine2 in _REDUNDANT or self.section == "RD"

    @property
    def frequency_class(self) -> int | None:
        """The channel frequency class of the filter letter, None where it has none."""
        return CLASSES.get(self.filter)

    @property
    def default_unit(self) -> str:
        """The unit of its quantity where the file names none, empty if not known."""
        return DEFAULT_UNITS.get(self.quantity, "")

    def filtered(self, frequency_class: float | None) -> ChannelCode:
        """The same code for a history of that channel frequency class (None: unfiltered; `S` for one without a letter)."""
        if frequency_class is None:
            return replace(self, filter="0")
        letter = next((letter for letter, size in CLASSES.items() if size == frequency_class), "S")
        return replace(self, filter=letter)


_RULE = "need 16 letters and digits, such as 11HEAD0000H3ACX0. Correct the code or leave it out."

BODY = frozenset(
    {
        "HEAD", "NECK", "CHST", "THSP", "LUSP", "PELV", "FEMR", "KNSL", "TIBI", "FOOT", "ABDO", "PUBC", "RIBS", "SHLD", "CLAV",
        "SPIN", "TRRI", "ANKL", "KNEE", "ILAC", "BAPL",
    }
)  # fmt: skip
"""Main locations on an occupant."""
