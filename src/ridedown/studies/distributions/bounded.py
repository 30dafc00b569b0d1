"""Distributions between two values: uniform and triangular.

References: N. L. Johnson, S. Kotz, N. Balakrishnan, Continuous univariate distributions, 2nd edition, 1994, chapter 26.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from ridedown.scenario.base import Check
from ridedown.scenario.quantities import show
from ridedown.studies.distributions.distribution import Distribution, Floats, Level


class Uniform(Distribution):
    """All values between two alike.

    >>> Uniform(lower=40, upper=64, unit="km/h").ppf([0.0, 1.0]).round(2)
    array([11.11, 17.78])
    """

    kind: Literal["uniform"] = "uniform"
    lower: Level = Field(description="least value")
    upper: Level = Field(description="largest value")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield _rising("upper", self.upper, "lower", self.lower, self.unit)

    def ppf(self, u: ArrayLike) -> Floats:
        """The value that a share u does not exceed."""
        found: Floats = self.lower + (self.upper - self.lower) * np.asarray(u, dtype=np.float64)
        return found

    def cdf(self, x: ArrayLike) -> Floats:
        """Share that does not exceed x."""
        return np.clip((np.asarray(x, dtype=np.float64) - self.lower) / (self.upper - self.lower), 0.0, 1.0)

    def logpdf(self, x: ArrayLike) -> Floats:
        """Logarithm of the density."""
        values = np.asarray(x, dtype=np.float64)
        inside = (values >= self.lower) & (values <= self.upper)
        return np.where(inside, -np.log(self.upper - self.lower), -np.inf)

    def expected(self) -> float:
        """Expected value."""
        return 0.5 * (self.lower + self.upper)

    def deviation(self) -> float:
        """Standard deviation."""
        return (self.upper - self.lower) / float(np.sqrt(12.0))

    def support(self) -> tuple[float, float]:
        """Least and largest value."""
        return self.lower, self.upper


class Triangular(Distribution):
    """A density that rises evenly from `lower` to `mode` and falls evenly to `upper`.

    >>> Triangular(lower="0 mm", mode="10 mm", upper="40 mm").ppf(0.25)
    array(0.01)
    """

    kind: Literal["triangular"] = "triangular"
    lower: Level = Field(description="least value")
    mode: Level = Field(description="most likely value")
    upper: Level = Field(description="largest value")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield _rising("upper", self.upper, "lower", self.lower, self.unit)
        within = self.lower <= self.mode <= self.upper
        yield Check("mode", within, self.mode, "a value from lower to upper", "", self.unit or "")

    def _turn(self) -> float:
        """Share of all values below the mode."""
        return (self.mode - self.lower) / (self.upper - self.lower)

    def ppf(self, u: ArrayLike) -> Floats:
        """The value that a share u does not exceed."""
        shares = np.asarray(u, dtype=np.float64)
        width = self.upper - self.lower
        rising = self.lower + np.sqrt(shares * width * (self.mode - self.lower))
        falling = self.upper - np.sqrt((1.0 - shares) * width * (self.upper - self.mode))
        return np.asarray(np.where(shares < self._turn(), rising, falling))

    def cdf(self, x: ArrayLike) -> Floats:
        """Share that does not exceed x."""
        values = np.clip(np.asarray(x, dtype=np.float64), self.lower, self.upper)
        width, turn = self.upper - self.lower, self._turn()
        before = ((values - self.lower) / width) ** 2 / (turn or 1.0)
        after = 1.0 - ((self.upper - values) / width) ** 2 / ((1.0 - turn) or 1.0)
        return np.asarray(np.where(values < self.mode, before, after))

    def logpdf(self, x: ArrayLike) -> Floats:
        """Logarithm of the density."""
        values = np.asarray(x, dtype=np.float64)
        width, turn = self.upper - self.lower, self._turn()
        before = 2.0 * (values - self.lower) / (width * width * (turn or 1.0))
        after = 2.0 * (self.upper - values) / (width * width * ((1.0 - turn) or 1.0))
        at_mode = 2.0 / width
        density = np.where(values < self.mode, before, np.where(values > self.mode, after, at_mode))
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(np.maximum(density, 0.0)))

    def expected(self) -> float:
        """Expected value."""
        return (self.lower + self.mode + self.upper) / 3.0

    def deviation(self) -> float:
        """Standard deviation."""
        a, b, c = self.lower, self.upper, self.mode
        # as squares, which do not cancel: a^2 + b^2 + c^2 - ab - ac - bc
        return float(np.sqrt(((a - b) ** 2 + (b - c) ** 2 + (a - c) ** 2) / 36.0))

    def support(self) -> tuple[float, float]:
        """Least and largest value."""
        return self.lower, self.upper


def _rising(field: str, value: float, other: str, other_value: float, unit: str | None) -> Check:
    return Check(field, value > other_value, value, f"> {other}, {show(other_value, unit or '')}", "", unit or "")
