"""Units: one table of dimensions, each with its units and their exact size in SI.

Scenario files and measured signals share it. Inside the package everything is SI; a signal may keep the unit it was recorded
in, and says which.

References:
    BIPM, The International System of Units, 9th edition, 2019; g and the pound are exact by definition
    (third CGPM, 1901; international yard and pound agreement, 1959).
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.errors import InvalidInput

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Dimension:
    """A kind of quantity: how it is called, its SI unit, an example, and its units with their size in SI."""

    called: str
    unit: str
    example: str
    units: Mapping[str, Fraction]


def _dimension(called: str, unit: str, example: str, units: dict[str, str]) -> Dimension:
    return Dimension(called, unit, example, MappingProxyType({u: Fraction(size) for u, size in units.items()}))


_POUND_FORCE = Fraction("4.4482216152605")  # 0.45359237 kg at 9.80665 m/s2
_INCH, _FOOT = Fraction("0.0254"), Fraction("0.3048")
# As near as a double is to pi: the one size here that no fraction gives exactly.
_DEGREE = Fraction(math.pi) / 180

# what scenarios are written in, and signals too

MASS = _dimension("a mass", "kg", "1500 kg", {"kg": "1", "t": "1000", "lb": "0.45359237"})
LENGTH = _dimension("a length", "m", "5 mm", {"m": "1", "mm": "1/1000", "cm": "1/100", "in": "0.0254", "ft": "0.3048"})
TIME = _dimension("a time", "s", "200 ms", {"s": "1", "ms": "1/1000", "us": "1/1000000"})
SPEED = _dimension(
    "a speed",
    "m/s",
    "48 km/h",
    {
        "m/s": "1",
        "km/h": "10/36",
        "kph": "10/36",
        "mph": "0.44704",
        "ft/s": "0.3048",
        "mm/ms": "1",
        "mm/s": "1/1000",
        "in/s": "0.0254",
    },
)
FORCE = _dimension("a force", "N", "40 kN", {"N": "1", "kN": "1000", "MN": "1000000", "lbf": str(_POUND_FORCE)})
STIFFNESS = _dimension(
    "a stiffness",
    "N/m",
    "98.1 kN/m",
    {
        "N/m": "1",
        "kN/m": "1000",
        "MN/m": "1000000",
        "N/mm": "1000",
        "kN/mm": "1000000",
        "lbf/in": str(_POUND_FORCE / _INCH),
    },
)
DAMPING = _dimension(
    "a damping coefficient",
    "N s/m",
    "2801 N s/m",
    {
        "N s/m": "1",
        "Ns/m": "1",
        "N/(m/s)": "1",
        "kN s/m": "1000",
        "kNs/m": "1000",
        "kN/(m/s)": "1000",
        "N s/mm": "1000",
        "Ns/mm": "1000",
        "kg/s": "1",
    },
)
INERTIA = _dimension(
    "a moment of inertia", "kg m2", "157 kg m2", {"kg m2": "1", "kgm2": "1", "kg mm2": "1/1000000", "t m2": "1000"}
)
ACCELERATION = _dimension("an acceleration", "m/s2", "40 g", {"m/s2": "1", "m/s/s": "1", "g": "9.80665"})
FRACTION = _dimension("a fraction", "", "50 %", {"": "1", "%": "1/100"})

# what else is measured

JERK = _dimension("a jerk", "m/s3", "900 g/s", {"m/s3": "1", "g/s": "9.80665"})
ANGLE = _dimension("an angle", "rad", "30 deg", {"rad": "1", "deg": str(_DEGREE)})
ANGULAR_VELOCITY = _dimension("an angular velocity", "rad/s", "500 deg/s", {"rad/s": "1", "deg/s": str(_DEGREE)})
ANGULAR_ACCELERATION = _dimension("an angular acceleration", "rad/s2", "4000 rad/s2", {"rad/s2": "1", "deg/s2": str(_DEGREE)})
MOMENT = _dimension(
    "a moment",
    "N m",
    "135 N m",
    {
        "N m": "1",
        "kN m": "1000",
        "N mm": "1/1000",
        "lbf in": str(_POUND_FORCE * _INCH),
        "lbf ft": str(_POUND_FORCE * _FOOT),
    },
)
IMPULSE = _dimension("an impulse", "N s", "400 N s", {"N s": "1", "kN s": "1000"})
ENERGY = _dimension("an energy", "J", "200 kJ", {"J": "1", "kJ": "1000"})
POWER = _dimension("a power", "W", "40 kW", {"W": "1", "kW": "1000"})
PRESSURE = _dimension(
    "a pressure",
    "Pa",
    "200 kPa",
    {"Pa": "1", "kPa": "1000", "MPa": "1000000", "bar": "100000", "psi": str(_POUND_FORCE / _INCH**2)},
)
FREQUENCY = _dimension("a frequency", "Hz", "10 kHz", {"Hz": "1", "kHz": "1000"})
VOLTAGE = _dimension("a voltage", "V", "5 V", {"V": "1", "mV": "1/1000"})

DIMENSIONS = (
    MASS, LENGTH, TIME, SPEED, FORCE, STIFFNESS, DAMPING, INERTIA, ACCELERATION, FRACTION, JERK, ANGLE, ANGULAR_VELOCITY,
    ANGULAR_ACCELERATION, MOMENT, IMPULSE, ENERGY, POWER, PRESSURE, FREQUENCY, VOLTAGE,
)  # fmt: skip

# Units as test files spell them. A spelling stands here only if it can mean one thing in a crash test: "nm" and "mn" do not.
_SPELLINGS = {
    "g": ("G", "G'S", "g's", "Gs", "gn", "g0"),
    "m/s2": ("m/sec2", "m/s**2", "m/ss", "M/SEC2", "MPS2", "m s-2", "m/(s s)", "m/(s2)"),
    "m/s": ("M/SEC", "m/sec", "MPS", "m s-1"),
    "km/h": ("KPH", "KMH", "Km/h", "kmh"),
    "mm/s": ("MM/SEC", "mm/sec"),
    "m": ("meter", "metre", "METER", "METRE"),
    "mm": ("millimeter", "millimetre", "MILLIMETER"),
    "N": ("NWT", "NEWTON", "NEWTONS", "Newton", "newton", "Newtons"),
    "N m": ("Nm", "NWM", "NM", "Newton meter", "N-m", "N.m"),
    "kN m": ("kNm",),
    "N mm": ("Nmm",),
    "N s": ("Ns",),
    "kN": ("KNWT",),
    "s": ("SEC", "sec", "second", "seconds", "SECONDS"),
    "ms": ("MSEC", "msec", "millisecond", "milliseconds"),
    "us": ("usec", "USEC", "MICROSEC"),
    "deg": ("°", "degree", "degrees", "DEGREES"),
    "deg/s": ("DPS", "°/s", "deg/sec", "DEG/SEC", "degree/s"),
    "deg/s2": ("°/s2",),
    "rad/s": ("rad/sec", "RAD/SEC"),
    "rad/s2": ("rad/sec2", "RAD/SEC2"),
    "": ("1", "-", "none", "NONE", "dimensionless"),
    "%": ("percent", "PCT"),
    "lbf": ("LBF",),
    "kg": ("kilogram", "KILOGRAM"),
}
# Not understood in capitals: with them a prefix could be another one, or the unit another unit.
_NO_CAPITALS = {"mV", "t", "in", "bar"}

_TIDY = str.maketrans({"·": " ", "⋅": " ", "*": " ", "²": "2", "³": "3", "^": "", "µ": "u", "μ": "u", "’": "'"})


def tidied(unit: str) -> str:
    """A unit with the ways to write a product, a power and a micro made one.

    >>> tidied("N·s / m"), tidied("m/s^2"), tidied("kg m²")
    ('N s/m', 'm/s2', 'kg m2')
    """
    return re.sub(r"\s*/\s*", "/", " ".join(unit.translate(_TIDY).split()))


_DIMENSION_OF = {unit: dimension for dimension in DIMENSIONS for unit in dimension.units}


def _table_of_spellings() -> dict[str, str]:
    table = {tidied(spelling): unit for unit, spellings in _SPELLINGS.items() for spelling in spellings}
    capitals: dict[str, set[str]] = {}
    for unit in _DIMENSION_OF:
        capitals.setdefault(unit.upper(), set()).add(unit)
    for capital, meant in capitals.items():
        if len(meant) == 1 and not meant & _NO_CAPITALS:
            table.setdefault(capital, next(iter(meant)))
    return {spelling: unit for spelling, unit in table.items() if spelling not in _DIMENSION_OF}


_UNIT_OF = _table_of_spellings()
_LONGEST = 40
_EXACT = 2**53  # below it every whole number is a double


def spelled(unit: str) -> str:
    """A unit as this table spells it, whichever way a test file wrote it.

    >>> spelled("G'S"), spelled("M/S2"), spelled("NWT"), spelled("N·m"), spelled("µs")
    ('g', 'm/s2', 'N', 'N m', 'us')

    Raises: InvalidInput for a unit that is not known; it offers the nearest.
    """
    tidy = tidied(unit) if len(unit) <= _LONGEST else unit
    if tidy in _DIMENSION_OF:
        return tidy
    if tidy in _UNIT_OF:
        return _UNIT_OF[tidy]
    shown = repr(unit if len(unit) <= _LONGEST else unit[: _LONGEST - 3] + "...")
    near = difflib.get_close_matches(tidy[:_LONGEST], [u for u in _DIMENSION_OF if u], n=1, cutoff=0.5)
    fix = f"Did you mean {near[0]!r}?" if near else "Convert the values first, or correct the unit."
    raise InvalidInput(f"unit: got {shown}; need a unit that is known, such as m/s2, g, N, mm or deg/s. {fix}")


def is_known(unit: str) -> bool:
    """Whether a unit is known, in any of its spellings.

    >>> is_known("KN"), is_known("furlong")
    (True, False)
    """
    return len(unit) <= _LONGEST and (tidied(unit) in _DIMENSION_OF or tidied(unit) in _UNIT_OF)


def recognised(unit: str) -> str:
    """A unit as this table spells it, or as it stands where it is not known: a reader keeps what it cannot name.

    >>> recognised("MM"), recognised(" furlong ")
    ('mm', 'furlong')
    """
    return spelled(unit) if is_known(unit) else unit.strip()


def dimension(unit: str) -> Dimension:
    """The dimension that a unit measures.

    >>> dimension("km/h").called, dimension("km/h").unit
    ('a speed', 'm/s')

    Raises: InvalidInput for a unit that is not known.
    """
    return _DIMENSION_OF[spelled(unit)]


def size(unit: str, to: str | None = None) -> Fraction:
    """How many of `to` one `unit` is, exactly; of the SI unit where `to` is left out.

    >>> size("km/h"), size("mm", "in")
    (Fraction(5, 18), Fraction(5, 127))

    Raises: InvalidInput for a unit that is not known, or two of different dimensions.
    """
    of, unit = dimension(unit), spelled(unit)
    if to is None:
        return of.units[unit]
    into, to = dimension(to), spelled(to)
    if into is not of:
        raise InvalidInput(
            f"unit: got {unit or 'none'!r}, {of.called}, to be converted to {to or 'none'!r}, {into.called}; "
            f"need {of.called} such as {of.unit or '%'!r}. Convert to a unit of the same dimension."
        )
    return of.units[unit] / into.units[to]


def convert(values: ArrayLike, unit: str, to: str | None = None) -> Floats:
    """Values in `unit` as values in `to` (the SI unit where left out), of the same shape; each right to its last digit or two.

    >>> convert([36.0, 54.0], "km/h", "m/s").tolist(), convert(-20.0, "g", "m/s2").tolist()
    ([10.0, 15.0], -196.133)

    Raises: InvalidInput for a unit that is not known, or two of different dimensions.
    """
    ratio = size(unit, to)
    numbers = np.asarray(values, dtype=np.float64)
    if ratio == 1:
        return numbers.copy()
    # Two whole numbers, where they are doubles: -20 g is then the same double as -196.133 m/s2, and 356 mm as 0.356 m.
    converted: Floats
    with np.errstate(over="ignore"):  # a value too large becomes infinite, which whoever takes it refuses by name
        if max(ratio.numerator, ratio.denominator) < _EXACT:
            converted = numbers * float(ratio.numerator) / float(ratio.denominator)
        else:
            converted = numbers * float(ratio)
    return converted
