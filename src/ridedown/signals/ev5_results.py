"""The official results of an EV5 header: what the laboratory found for each occupant.

The database fills a field that was not measured with 0 as often as it leaves it empty: test 10146 has 0 for both belt
forces, which were not instrumented, and for CSI. None of these results can be exactly 0 where it was measured, save T1, the
start of the HIC interval. So 0 counts as not available; T1 and T2 count if HIC does. A row of nines (9999, 99999.9) is a
filler too, and is said where one is met.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType

from ridedown.errors import InvalidInput
from ridedown.signals.ev5_header import Row
from ridedown.signals.record import OfficialResult

UNITS: Mapping[str, str] = {
    "HIC": "",
    "T1": "ms",
    "T2": "ms",
    "CLIP3M": "g",
    "LFEM": "N",
    "RFEM": "N",
    "CSI": "",
    "LBELT": "N",
    "SBELT": "N",
    "TTI": "",
    "PELVG": "g",
}
"""The results, by the names of the header, and their units there."""

_NINES = re.compile(r"-?9{4,}(?:\.[09]*)?")
_LONG_NINES = re.compile(r"-?9{5,}(?:\.[09]*)?")

HIC15, HIC36 = 0.015, 0.036
"""The two windows that a HIC is taken over [s]."""

_MARGIN = 0.5e-3  # s: how much longer than its window an interval may look; old headers print T1 and T2 to 1 ms
_SHORT = 0.15e-3  # s: the same for one that looks shorter; headers that tell HIC15 print to 0.1 ms


def official_results(row: Row) -> tuple[Mapping[str, OfficialResult], tuple[str, ...]]:
    """The results of an OCCUPANT record by the header's names, and what was found wrong with them.

    HIC has its interval with it, in seconds; T1 and T2 stand beside it as the header prints them. `hic_window` tells
    which HIC it is.
    """
    found: dict[str, OfficialResult] = {}
    problems = []
    for name, unit in UNITS.items():
        try:
            value = row.number(name)
        except InvalidInput as error:
            problems.append(str(error))
            continue
        if value is None or (value == 0.0 and name != "T1"):
            continue
        pattern = _LONG_NINES if unit == "N" else _NINES
        if pattern.fullmatch(row.text(name)):
            problems.append(f"{name}: got {row.text(name)}, a filler on line {row.line}; it counts as not available")
            continue
        found[name] = OfficialResult(value, unit)
    start, end = found.get("T1"), found.get("T2")
    if "HIC" in found and start and end and start.value < end.value:
        found["HIC"] = OfficialResult(found["HIC"].value, "", start.value / 1e3, end.value / 1e3)
    else:
        found.pop("T1", None)
        found.pop("T2", None)
    return MappingProxyType(found), tuple(problems)


def hic_window(hic: OfficialResult) -> float | None:
    """The window of an official HIC [s], told by its interval; None where the header does not tell.

    An interval beyond 15 ms means HIC36. One of 15 ms, or a shorter one, could be either: the best interval of a short
    pulse is short. It counts as HIC15 only where it is the full 15 ms, as the best interval of HIC36 is that by chance
    alone.

    >>> hic_window(OfficialResult(140.0, "", 0.0777, 0.0927))
    0.015
    """
    if hic.start is None or hic.end is None:
        return None
    length = hic.end - hic.start
    if length > HIC15 + _MARGIN:
        return HIC36 if length <= HIC36 + _MARGIN else None
    return HIC15 if length >= HIC15 - _SHORT else None
