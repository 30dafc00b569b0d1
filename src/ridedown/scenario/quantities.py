"""Quantities with units, as scenario files write them: `"98.1 kN/m"`, `"48 km/h"`, `"50 %"`, or a bare number in SI.

Everything past this file is a bare float in SI units. A field says which quantity it holds by its type (`Mass`, ...),
and the same rule checks a single value and a column of values.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from numbers import Real
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from ridedown.units import (
    ACCELERATION,
    DAMPING,
    FORCE,
    FRACTION,
    INERTIA,
    LENGTH,
    MASS,
    SPEED,
    STIFFNESS,
    TIME,
    Dimension,
    tidied,
)

Number = float | NDArray[np.float64]
"""One value, or a column with one value per crash."""

Truth = bool | np.bool_ | NDArray[np.bool_]
"""Whether a rule holds: once, or in each crash."""


class Refused(ValueError):
    """A value that a field may not hold: what was got, what is needed, what to change, and which field of the model."""

    def __init__(self, got: str, need: str, fix: str = "", *, field: str = "") -> None:
        self.got, self.need, self.fix, self.field = got, need, fix, field
        super().__init__(f"got {got}; need {need}." + (f" {fix}" if fix else ""))


DIMENSIONS = (MASS, LENGTH, TIME, SPEED, FORCE, STIFFNESS, DAMPING, INERTIA, ACCELERATION, FRACTION)
"""The dimensions that a scenario's fields have; `ridedown.units` has more, for measurements."""

_DIMENSION_OF = {unit: dimension for dimension in DIMENSIONS for unit in dimension.units}

# At most 60 characters and a three-digit exponent: enough for any double, and exact arithmetic stays cheap.
_NUMBER = re.compile(
    r"\s*([+-]?(?=[0-9.]{1,60}(?![0-9.]))(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)(?![0-9.])\s*(.*?)\s*",
    re.DOTALL,
)


def read(value: object, dimension: Dimension) -> float:
    """The value in SI units of a bare number or of text with a unit of the `dimension`.

    >>> read("98.1 kN/m", STIFFNESS), read("36 km/h", SPEED), read(0.5, FRACTION), read("50 %", FRACTION)
    (98100.0, 10.0, 0.5, 0.5)

    Raises: Refused, where it is neither, has no unit, has another dimension's unit, or is not finite.
    """
    if isinstance(value, str):
        return _read_text(value, dimension)
    if isinstance(value, bool) or not isinstance(value, Real):
        raise Refused(_called(value), wanted(dimension))
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise Refused(f"{number}", f"a finite number, {wanted(dimension)}")
    return number


def read_any(text: str) -> tuple[float, Dimension]:
    """The value in SI units of text with a unit of any dimension, and that dimension.

    >>> value, dimension = read_any("98.1 kN/m")
    >>> value, dimension.called
    (98100.0, 'a stiffness')

    Raises: Refused, where it is no number with a unit that scenarios know.
    """
    match = _NUMBER.fullmatch(text)
    unit = tidied(match.group(2)) if match else ""
    shown = f'"{text if len(text) <= 60 else text[:57] + "..."}"'
    if not unit:
        raise Refused(shown, 'a bare number, or text with a unit such as "98.1 kN/m"')
    return _read_text(text, _dimension_of(shown, unit)), _DIMENSION_OF[unit]


def dimension_of(unit: str) -> Dimension:
    """The dimension that a unit measures. Raises: Refused for one that scenarios do not know."""
    return _dimension_of(f'"{unit}"', tidied(unit))


def _dimension_of(shown: str, unit: str) -> Dimension:
    if unit in _DIMENSION_OF:
        return _DIMENSION_OF[unit]
    near = [u for u in _DIMENSION_OF if u.lower() == unit.lower()] or difflib.get_close_matches(unit, _DIMENSION_OF, n=1)
    raise Refused(shown, "a unit that scenario files know", f'Did you mean "{near[0]}"?' if near else "")


def _read_text(text: str, dimension: Dimension) -> float:
    shown = f'"{text if len(text) <= 60 else text[:57] + "..."}"'
    match = _NUMBER.fullmatch(text)
    if re.match(r"[\s+-]*[0-9]+,[0-9]", text):
        raise Refused(shown, wanted(dimension), "Write a decimal point, and no separators between thousands.")
    if match is None:
        raise Refused(shown, wanted(dimension))
    digits, unit = match.groups()
    unit = tidied(unit)
    if unit not in dimension.units:
        raise _wrong_unit(shown, digits, unit, dimension)
    # Exact until the last step: "356 mm" is the same double as 0.356.
    try:
        number = float(Fraction(digits) * dimension.units[unit])
    except OverflowError:
        raise Refused(shown, f"a finite number, {wanted(dimension)}") from None
    return number


def _wrong_unit(shown: str, digits: str, unit: str, dimension: Dimension) -> Refused:
    if not unit:
        return Refused(
            f"{shown}, text without a unit",
            wanted(dimension),
            f"Add the unit, or write the bare number {digits} for {dimension.unit}.",
        )
    if unit in _DIMENSION_OF:
        return Refused(f"{shown}, {_DIMENSION_OF[unit].called}", wanted(dimension))
    near = difflib.get_close_matches(unit, dimension.units, n=1, cutoff=0.5)
    by_case = [u for u in dimension.units if u.lower() == unit.lower()]
    guess = by_case or near
    known = ", ".join(f'"{u}"' for u in dimension.units if u)
    fix = f'Did you mean "{guess[0]}"?' if guess else f"Units known: {known}."
    return Refused(f'{shown}, with the unknown unit "{unit}"', wanted(dimension), fix)


def wanted(dimension: Dimension) -> str:
    """What to ask for, as in `a stiffness such as "98.1 kN/m"`."""
    return f'{dimension.called} such as "{dimension.example}"'


def show(value: float, unit: str) -> str:
    """A number and its unit, as error messages print it."""
    return f"{value:.12g} {unit if math.isfinite(value) else ''}".rstrip()


def write(value: float, dimension: Dimension) -> str | float:
    """A value [SI] as scenario files write it; reads back as the very same float."""
    if dimension is FRACTION:
        return value
    return f"{repr(value).removesuffix('.0')} {dimension.unit}"


def _called(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        return "a list"
    return "nothing" if value is None else repr(value)


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a field holds: a dimension and bounds [SI]. `above` is exclusive, `least` and `most` are inclusive."""

    dimension: Dimension
    above: float | None = None
    least: float | None = None
    most: float | None = None
    fix: str = ""

    @property
    def unit(self) -> str:
        """The SI unit."""
        return self.dimension.unit

    @property
    def rule(self) -> str:
        """The bounds in words, as in `> 0 s and <= 10 s`."""
        bounds = ((">", self.above), (">=", self.least), ("<=", self.most))
        return " and ".join(f"{sign} {show(bound, self.unit)}" for sign, bound in bounds if bound is not None)

    def holds(self, value: Number) -> Truth:
        """Whether the value, or each of a column, is within the bounds."""
        ok: Truth = True
        if self.above is not None:
            ok = ok & (value > self.above)
        if self.least is not None:
            ok = ok & (value >= self.least)
        if self.most is not None:
            ok = ok & (value <= self.most)
        return ok

    def read(self, value: object) -> float:
        """The value in SI units, checked against the bounds. Raises: Refused."""
        number = read(value, self.dimension)
        if not self.holds(number):
            got = f'"{value}"' if isinstance(value, str) else show(number, self.unit)
            raise Refused(got, self.rule, self.fix)
        return number

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        number: dict[str, Any] = {"type": "number"}
        bounds = {"exclusiveMinimum": self.above, "minimum": self.least, "maximum": self.most}
        number |= {key: bound for key, bound in bounds.items() if bound is not None}
        units = "|".join(re.escape(unit).replace("/", r"\/").replace(r"\ ", " ") for unit in self.dimension.units)
        text = {"type": "string", "pattern": rf"^\s*[+-]?[\d.]+([eE][+-]?\d+)?\s*({units})\s*$"}
        about = f"{self.dimension.called}, in {self.unit or 'parts of one'} or with a unit".removeprefix("a ")
        return {"anyOf": [number, text], "description": about, "examples": [self.dimension.example]}


_FORWARD = (
    "A vehicle's speed is along its own forward direction: two cars that meet head-on both have positive speeds, "
    "and one that stands still has 0."
)
_RATIO = 'Write 50 % of critical as "50 %" or 0.5.'

Mass = Annotated[float, Quantity(MASS, above=0.0)]
Inertia = Annotated[float, Quantity(INERTIA, above=0.0, fix="Leave it out for a bar that cannot turn.")]
Speed = Annotated[float, Quantity(SPEED, least=0.0, fix=_FORWARD)]
Velocity = Annotated[float, Quantity(SPEED)]
"""A speed that may be negative: backward."""
Duration = Annotated[float, Quantity(TIME, above=0.0, most=10.0, fix="A crash lasts a few tenths of a second.")]
Instant = Annotated[float, Quantity(TIME, least=0.0, most=10.0, fix="Times count from first contact, at 0 s.")]
Span = Annotated[float, Quantity(TIME, above=0.0, most=10.0, fix="It ends after it begins.")]
Force = Annotated[float, Quantity(FORCE, least=0.0, fix="A member can push, not pull.")]
Pull = Annotated[float, Quantity(FORCE, above=0.0, fix="Leave it out where there is no such force.")]
Stiffness = Annotated[float, Quantity(STIFFNESS, least=0.0)]
Damping = Annotated[float, Quantity(DAMPING, least=0.0)]
DampingRatio = Annotated[float, Quantity(FRACTION, least=0.0, most=10.0, fix=_RATIO)]
Slack = Annotated[float, Quantity(LENGTH, least=0.0, fix="Write 0 for a restraint that is taut from the start.")]
Gap = Annotated[float, Quantity(LENGTH, least=0.0, fix="Write 0 for a surface that is touched from the start.")]
Deflection = Annotated[float, Quantity(LENGTH, least=0.0)]
Distance = Annotated[float, Quantity(LENGTH, above=0.0)]
Offset = Annotated[float, Quantity(LENGTH)]
"""A length that may be negative: to the other side."""
Arm = Annotated[
    float,
    Quantity(LENGTH, least=0.0, fix="Arms are lengths; for members on one side of the bar's middle give rail_spacing."),
]
Overlap = Annotated[float, Quantity(FRACTION, above=0.0, most=1.0, fix='Write 60 % as "60 %" or 0.6.')]
RecordTime = Annotated[float, Quantity(TIME)]
"""A time on a record's clock, which may be negative: before time zero."""
Acceleration = Annotated[float, Quantity(ACCELERATION)]
"""As SAE J211 has it: a braking car's is negative."""
PeakDeceleration = Annotated[
    float, Quantity(ACCELERATION, above=0.0, fix="A named shape brakes the car: give its peak as a magnitude, without a sign.")
]
VelocityChange = Annotated[
    float, Quantity(SPEED, above=0.0, fix="A named shape brakes the car: give its change of velocity as a magnitude.")
]
Part = Annotated[float, Quantity(FRACTION, least=0.0, most=1.0, fix='Write 40 % as "40 %" or 0.4.')]
Share = Annotated[float, Quantity(FRACTION)]
"""A part of a whole, where the rule between 0 and 1 is the model's own."""
SampleStep = Annotated[float, Quantity(TIME, least=1e-6, most=1e-3, fix="A clip lasts 3 ms: 0.1 ms suits all criteria.")]
Factor = Annotated[float, Quantity(FRACTION, above=0.0, fix="Write 1 for the pulse as it is.")]
