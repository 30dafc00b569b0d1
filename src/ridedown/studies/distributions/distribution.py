"""What every distribution of a parameter is: how study files write its values, and what it answers.

A value is a bare number in SI, or text with a unit; or bare numbers with `unit` beside them. What a model then holds is SI,
and `unit` is the SI unit, so that the parameter it is used for can refuse the wrong dimension (`check_against`).

    {kind = "normal", mean = "98 kN/m", sd = "5 kN/m"}
    {kind = "uniform", lower = 40, upper = 64, unit = "km/h"}
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from fractions import Fraction
from typing import Annotated, Any, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, model_validator
from pydantic_core import CoreSchema, core_schema
from scipy.special import ndtr

from ridedown.errors import InvalidInput
from ridedown.scenario.base import Model
from ridedown.scenario.quantities import Quantity, Refused, dimension_of, read_any
from ridedown.units import FRACTION, Dimension, tidied

Floats = NDArray[np.float64]

NEGLIGIBLE = 1e-12
"""A parameter may not leave its bounds with more than this probability: about 7 standard deviations of a normal."""


class _Level:
    """Marks a field that holds a value of the parameter: read by `Distribution`, which knows the unit of all of them."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(_number)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [{"type": "number"}, {"type": "string"}], "description": "in SI, in `unit`, or with a unit"}


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise Refused(f'"{value}"' if isinstance(value, str) else repr(value), "a number, or text with a unit")
    if not np.isfinite(value):
        raise Refused(f"{value}", "a finite number")
    return float(value)


Level = Annotated[float, _Level()]
"""A value of the parameter, SI."""

Positive = Annotated[float, Quantity(FRACTION, above=0.0)]
Weight = Annotated[float, Quantity(FRACTION, least=0.0)]


class Distribution(Model):
    """What all distributions tell. Arrays of any shape go in, the same shape comes out; SI units."""

    kind: str
    unit: str | None = Field(None, description="unit of the bare numbers; SI if left out")

    @abstractmethod
    def ppf(self, u: ArrayLike) -> Floats:
        """The value that a share u of all values does not exceed: the inverse of the cumulative distribution."""

    @abstractmethod
    def cdf(self, x: ArrayLike) -> Floats:
        """Share of all values that do not exceed x."""

    @abstractmethod
    def logpdf(self, x: ArrayLike) -> Floats:
        """Natural logarithm of the density [1/unit]; of the probability, where the values are discrete."""

    def pdf(self, x: ArrayLike) -> Floats:
        """Density [1/unit]; probability, where the values are discrete."""
        found: Floats = np.exp(self.logpdf(x))
        return found

    def from_normal(self, z: ArrayLike) -> Floats:
        """The value that stands where z stands in the standard normal distribution."""
        return self.ppf(ndtr(np.asarray(z, dtype=np.float64)))

    @abstractmethod
    def expected(self) -> float:
        """Expected value."""

    @abstractmethod
    def deviation(self) -> float:
        """Standard deviation."""

    @abstractmethod
    def support(self) -> tuple[float, float]:
        """Least and largest value; infinite where there is none."""

    def beyond(self, quantity: Quantity) -> float:
        """Probability of a value outside the bounds of a quantity."""
        low, high = self.support()
        least = max((bound for bound in (quantity.above, quantity.least) if bound is not None), default=-np.inf)
        below = float(self.cdf(least)) if low < least else 0.0
        above = 0.0 if quantity.most is None or high <= quantity.most else 1.0 - float(self.cdf(quantity.most))
        return below + above

    def check_against(self, quantity: Quantity, path: str) -> None:
        """Whether a parameter of this quantity can be so distributed.

        Raises: InvalidInput where the unit is another dimension's, or values fall outside the parameter's bounds.
        """
        if self.unit is not None and self.unit != quantity.unit:
            given = dimension_of(self.unit).called if self.unit else FRACTION.called
            raise InvalidInput(
                f"{path}: got a distribution of {given}; need {quantity.dimension.called}. "
                f'Give its values as bare SI numbers or with a unit, such as "{quantity.dimension.example}".'
            )
        if (outside := self.beyond(quantity)) > NEGLIGIBLE:
            raise InvalidInput(
                f"{path}: got a {self.kind} distribution with {outside:.2g} of its values outside {quantity.rule}; "
                f"need less than {NEGLIGIBLE:g}. Give bounds, as in a truncated-normal or uniform distribution."
            )

    @model_validator(mode="before")
    @classmethod
    def _in_si(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        data = dict(data)
        unit, dimension = data.get("unit"), None
        if unit is not None:
            if not isinstance(unit, str):
                raise Refused(repr(unit), 'a unit such as "kN/m"', field="unit")
            dimension = _of_unit(unit)
            data["unit"] = dimension.unit
        scale = Fraction(1) if dimension is None else dimension.units[tidied(unit or "")]
        for field in _levels(cls):
            if data.get(field) is None:
                continue
            several = isinstance(data[field], list | tuple)
            found = []
            for i, given in enumerate(data[field] if several else [data[field]]):
                value, its = _read(given, scale, f"{field}.{i}" if several else field)
                if its is not None and dimension is not None and its is not dimension:
                    raise Refused(f"{its.called} beside {dimension.called}", "values of one dimension", field=field)
                dimension = its or dimension
                found.append(value)
            data[field] = tuple(found) if several else found[0]
        if dimension is not None:
            data["unit"] = dimension.unit
        return data


def _levels(model: type[Distribution]) -> list[str]:
    def marked(annotation: Any, metadata: list[Any]) -> bool:
        return any(isinstance(extra, _Level) for extra in metadata) or any(
            marked(inner, list(getattr(inner, "__metadata__", ()))) for inner in get_args(annotation)
        )

    return [name for name, info in model.model_fields.items() if marked(info.annotation, info.metadata)]


def _of_unit(unit: str) -> Dimension:
    try:
        return dimension_of(unit)
    except Refused as refused:
        raise Refused(refused.got, refused.need, refused.fix, field="unit") from None


def _read(value: object, scale: Fraction, where: str) -> tuple[object, Dimension | None]:
    """The value in SI, and its dimension where it says so; what is no number is left for the field to refuse."""
    if isinstance(value, str):
        try:
            return read_any(value)
        except Refused as refused:
            raise Refused(refused.got, refused.need, refused.fix, field=where) from None
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not np.isfinite(value):
        return value, None
    if scale == 1:
        return float(value), None
    return float(Fraction(repr(float(value))) * scale), None  # exact until the last step, as text is
