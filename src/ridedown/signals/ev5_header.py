"""The header of an NHTSA EV5 test: sections of records, one a line, their fields named in order.

    # comment
    ----- EV5 -----
    ----- TEST -----
    V5|NCAP - 2018 TOYOTA CAMRY LE|...
    ----- VEHICLE -----
    ...
    ----- END -----

Nothing is interpreted here but the text itself: an empty field, or `NULL`, is not available. What a header holds beyond
the fields named below is kept as it stands, in `Row.extra`; a section that is not known is kept in `Header.unknown`.

References:
    NHTSA Test Reference Guide, Version 5, Volume I: Vehicle Tests (November 2014): sections, fields and their order.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date

from ridedown.errors import InvalidInput
from ridedown.signals.numerals import lines_of


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split())


_BEFORE, _AFTER = (tuple(f"{measure}{i}" for i in range(1, 22)) for measure in ("BX", "AX"))

FIELDS: Mapping[str, tuple[str, ...]] = {
    "TEST": _names("""
        VERNO TITLE TSTOBJ TSTDAT TSTPRF CONNO TSTREF TSTTYP TSTCNF TKSURF TKCOND TEMP RECTYP LINK CLSSPD IMPANG OFFSET IMPPNT
        TOTCRV TSTCOM
    """),
    "VEHICLE": (
        *_names("""
            VEHNO MAKE MODEL YEAR NHTSANO BODY VIN ENGINE ENGDSP TRANSM VEHTWT CURBWT WHLBAS VEHLEN VEHWID VEHCG STRSEP COLMEC
            MODIND MODDSC
        """),
        *_BEFORE,
        *_names("VEHSPD CRBANG PDOF BMPENG SILENG APLENG DPD1 DPD2 DPD3 DPD4 DPD5 DPD6 VDI LENCNT DAMDST CRHDST"),
        *_AFTER,
        *_names("CARANG VEHOR VEHCOM"),
    ),
    "BARRIER": _names("BARRIG BARSHP BARANG BARDIA BARCOM"),
    "OCCUPANT": _names("""
        VEHNO OCCLOC OCCTYP OCCAGE OCCSEX OCCHT OCCWT MTHCAL DUMMSIZ DUMMAN DUMMOD DUMDSC HH HW HR HS CD CS AD HD KD HB NB CB KB
        SEPOSN CNTRH1 CNTRH2 CNTRC1 CNTRC2 CNTRL1 CNTRL2 HIC T1 T2 CLIP3M LFEM RFEM CSI LBELT SBELT TTI PELVG OCCCOM
    """),
    "RESTRAINT": _names("VEHNO OCCLOC RSTNO RSTTYP RSTMNT DEPLOY RSTCOM"),
    "INSTRUMENTATION": _names("""
        VEHNO CURNO SENTYP SENLOC SENATT AXIS XUNITS YUNITS PREFIL INSMAN CALDAT INSRAT CHLMAX INIVEL NFP NLP DELT DASTAT CHSTAT
        INSCOM
    """),
}
"""The fields of each section, in order. BX1-BX21 and AX1-AX21 are measures of the vehicle before and after the crash."""

_SECTION = re.compile(r"-{3,} *([A-Z0-9_ ]*?) *-{3,}", re.ASCII | re.IGNORECASE)
_NUMBER = re.compile(r"[+-]?(?:[0-9]{1,40}\.?[0-9]{0,40}|\.[0-9]{1,40})(?:[eE][+-]?[0-9]{1,3})?", re.ASCII)
_DATE = re.compile(r"([0-9]{1,2})[/-]([A-Z]{3})[/-]([0-9]{4})", re.ASCII)
_MONTHS = ("JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC")

MAX_PROBLEMS = 200
"""Problems kept of one header: rubbish with a problem on every line shall not fill the memory."""


@dataclass(frozen=True, slots=True)
class Row:
    """One record of a section: its fields by name, as they stand, and what comes after the last field that has a name."""

    line: int
    fields: Mapping[str, str]
    extra: tuple[str, ...] = ()

    def text(self, field: str) -> str:
        """A field without the blanks around it; empty where it is not available."""
        text = self.fields.get(field, "").strip()
        return "" if text.upper() == "NULL" else text

    def number(self, field: str) -> float | None:
        """A field as a number, None where it is not available.

        Raises: InvalidInput, where it holds something else.
        """
        text = self.text(field)
        if not text:
            return None
        if not _NUMBER.fullmatch(text) or abs(value := float(text)) > 1e300:
            raise InvalidInput(
                f"{field}: got {text[:40]!r}; need a number, or nothing. Correct line {self.line} of the header."
            )
        return value

    def whole(self, field: str) -> int | None:
        """A field as a whole number, None where it is not available.

        Raises: InvalidInput, where it holds something else, or one beyond 1e9.
        """
        value = self.number(field)
        if value is not None and (value != int(value) or abs(value) > 1e9):
            raise InvalidInput(
                f"{field}: got {self.text(field)[:40]}; need a whole number below 1e9. Correct line {self.line} of the header."
            )
        return None if value is None else int(value)

    def date(self, field: str) -> date | None:
        """A field as a date, None where it is not available.

        Raises: InvalidInput, where it holds something else.
        """
        text = self.text(field).upper()
        if not text:
            return None
        match = _DATE.fullmatch(text)
        if match and match[2] in _MONTHS:
            try:
                return date(int(match[3]), _MONTHS.index(match[2]) + 1, int(match[1]))
            except ValueError:
                pass
        raise InvalidInput(
            f"{field}: got {text[:40]!r}; need a date such as 03/OCT/2017. Correct line {self.line} of the header."
        )


@dataclass(frozen=True, slots=True)
class Header:
    """All sections of a header, and what was found wrong in it."""

    sections: Mapping[str, tuple[Row, ...]]
    unknown: Mapping[str, tuple[str, ...]]
    problems: tuple[str, ...]

    def rows(self, section: str) -> tuple[Row, ...]:
        """The records of a section, none where the header does not have it."""
        return self.sections.get(section, ())


def read_header(text: str, name: str = "header") -> Header:
    r"""The sections of an EV5 header; `name` stands before the line number in messages.

    >>> header = read_header("----- EV5 -----\n----- TEST -----\nV5|A TEST\n----- END -----\n")
    >>> header.rows("TEST")[0].text("TITLE")
    'A TEST'

    Raises: InvalidInput, where it is not an EV5 header or holds no record at all.
    """
    sections: dict[str, list[Row]] = {}
    unknown: dict[str, list[str]] = {}
    problems: list[str] = []
    section = ""
    started = False
    for number, line in enumerate(lines_of(text), start=1):
        if section == "END":
            break
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        if mark := _SECTION.fullmatch(line.strip()):
            section = mark[1].upper()
            started = started or section == "EV5"
            if section not in {"EV5", "END"}:
                (sections if section in FIELDS else unknown).setdefault(section, [])
        elif not started:
            raise InvalidInput(
                f"{name}:{number}: got {line[:40]!r}; need '----- EV5 -----' first. Give the header of an EV5 test."
            )
        elif section in FIELDS:
            row = _row(section, number, line)
            if len(row.fields) < len(FIELDS[section]) and len(problems) < MAX_PROBLEMS:
                problems.append(
                    f"{name}:{number}: {section} has {len(row.fields)} fields of {len(FIELDS[section])}; "
                    "the rest count as not available"
                )
            sections[section].append(row)
        else:
            unknown.setdefault(section, []).append(line)
    if not any(sections.values()):
        raise InvalidInput(f"{name}: got no record in any section; need at least TEST. Give the header of an EV5 test.")
    if section != "END":
        problems.append(f"{name}: ends without '----- END -----'; it may be cut short")
    if not sections.get("TEST"):
        problems.append(f"{name}: no TEST record; what the test was is not known")
    problems += [f"{name}: section {key!r} is not known; kept as it stands" for key in list(unknown)[:5]]
    return Header(
        {key: tuple(rows) for key, rows in sections.items()},
        {key: tuple(lines) for key, lines in unknown.items()},
        tuple(problems),
    )


def _row(section: str, number: int, line: str) -> Row:
    names = FIELDS[section]
    values = line.split("|")
    extra = tuple(values[len(names) :])
    # A line may end with one more bar, which is not a field.
    return Row(number, dict(zip(names, values, strict=False)), () if extra == ("",) else extra)
