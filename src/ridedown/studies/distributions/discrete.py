"""Some values, each with a weight."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from ridedown.scenario.base import Check
from ridedown.scenario.quantities import Quantity
from ridedown.studies.distributions.distribution import Distribution, Floats, Level, Weight


class Discrete(Distribution):
    """Some values, each with a weight; of equal weight if none are given.

    >>> Discrete(values=["48 km/h", "56 km/h"], weights=[3, 1]).ppf([0.2, 0.8]).round(2)
    array([13.33, 15.56])
    """

    kind: Literal["discrete"] = "discrete"
    values: tuple[Level, ...] = Field(description="the values")
    weights: tuple[Weight, ...] | None = Field(None, description="weights of the values, of any sum; equal if left out")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield Check("values", bool(self.values), "an empty list", "at least one value")
        yield Check("values", len(set(self.values)) == len(self.values), "a value twice", "each value once", "Add its weights.")
        if self.weights is not None:
            need = f"a list of {len(self.values)}, one for each value"
            yield Check("weights", len(self.weights) == len(self.values), f"a list of {len(self.weights)}", need)
            yield Check("weights", sum(self.weights) > 0.0, "weights that are all zero", "at least one above zero")

    def _table(self) -> tuple[Floats, Floats]:
        """The values that have a weight, rising, and their probabilities."""
        values = np.array(self.values)
        weights = np.ones(values.size) if self.weights is None else np.array(self.weights)
        order = np.argsort(values, kind="stable")
        order = order[weights[order] > 0.0]
        return values[order], weights[order] / weights.sum()

    def ppf(self, u: ArrayLike) -> Floats:
        """The value that a share u does not exceed."""
        values, shares = self._table()
        place = np.searchsorted(np.cumsum(shares), np.asarray(u, dtype=np.float64), side="left")
        return np.asarray(values[np.minimum(place, values.size - 1)])

    def cdf(self, x: ArrayLike) -> Floats:
        """Share that does not exceed x."""
        values, shares = self._table()
        total = np.minimum(np.concatenate([[0.0], np.cumsum(shares)]), 1.0)
        total[-1] = 1.0
        return np.asarray(total[np.searchsorted(values, np.asarray(x, dtype=np.float64), side="right")])

    def logpdf(self, x: ArrayLike) -> Floats:
        """Logarithm of the probability."""
        values, shares = self._table()
        at = np.asarray(x, dtype=np.float64)
        place = np.minimum(np.searchsorted(values, at), values.size - 1)
        return np.asarray(np.where(values[place] == at, np.log(shares[place]), -np.inf))

    def expected(self) -> float:
        """Expected value."""
        values, shares = self._table()
        return float(values @ shares)

    def deviation(self) -> float:
        """Standard deviation."""
        values, shares = self._table()
        return float(np.sqrt((values - self.expected()) ** 2 @ shares))

    def support(self) -> tuple[float, float]:
        """Least and largest value."""
        values, _ = self._table()
        return float(values[0]), float(values[-1])

    def beyond(self, quantity: Quantity) -> float:
        """Probability of a value outside the bounds of a quantity."""
        values, shares = self._table()
        return float(shares[~np.broadcast_to(quantity.holds(values), values.shape)].sum())
