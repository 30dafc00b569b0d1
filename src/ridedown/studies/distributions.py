"""The distributions that a parameter of a study may have (see `distribution`).

References: N. L. Johnson, S. Kotz, N. Balakrishnan, Continuous univariate distributions, 2nd edition, 1994, chapters 13 (normal
and truncated), 14 (lognormal), 26 (triangular).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BeforeValidator, Discriminator, Field, Tag
from scipy.special import log_ndtr, ndtr, ndtri

from ridedown.scenario.base import Check, exclusive, of_known_kind
from ridedown.scenario.quantities import Quantity, show
from ridedown.studies.distribution import Distribution, Floats, Level, Positive, Weight

_LEAST_SHARE = 1e-9  # of the normal that truncation must leave, for its inverse to have digits left

_LOG_ROOT_2_PI = 0.5 * float(np.log(2.0 * np.pi))


class Normal(Distribution):
    """A normal distribution.

    >>> Normal(mean="98 kN/m", sd="5 kN/m").ppf([0.5, 0.975]).round(0)
    array([ 98000., 107800.])
    """

    kind: Literal["normal"] = "normal"
    mean: Level = Field(description="expected value")
    sd: Level = Field(description="standard deviation")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield _positive("sd", self.sd, self.unit)

    def ppf(self, u: ArrayLike) -> Floats:
        """The value that a share u does not exceed."""
        return self.from_normal(ndtri(np.asarray(u, dtype=np.float64)))

    def from_normal(self, z: ArrayLike) -> Floats:
        """The value that stands where z stands in the standard normal distribution."""
        found: Floats = self.mean + self.sd * np.asarray(z, dtype=np.float64)
        return found

    def cdf(self, x: ArrayLike) -> Floats:
        """Share that does not exceed x."""
        return np.asarray(ndtr((np.asarray(x, dtype=np.float64) - self.mean) / self.sd))

    def logpdf(self, x: ArrayLike) -> Floats:
        """Logarithm of the density."""
        return _log_normal_density((np.asarray(x, dtype=np.float64) - self.mean) / self.sd) - float(np.log(self.sd))

    def expected(self) -> float:
        """Expected value."""
        return self.mean

    def deviation(self) -> float:
        """Standard deviation."""
        return self.sd

    def support(self) -> tuple[float, float]:
        """Least and largest value."""
        return -np.inf, np.inf


class TruncatedNormal(Distribution):
    """A normal distribution cut off below, above or on both sides. `mean` and `sd` are those before it was cut.

    >>> cut = TruncatedNormal(mean="5 mm", sd="5 mm", lower=0.0)
    >>> round(1e3 * cut.expected(), 2), round(1e3 * float(cut.ppf(1e-9)), 6)
    (6.44, 0.0)
    """

    kind: Literal["truncated-normal"] = "truncated-normal"
    mean: Level = Field(description="expected value before it was cut")
    sd: Level = Field(description="standard deviation before it was cut")
    lower: Level | None = Field(None, description="least value; none if left out")
    upper: Level | None = Field(None, description="largest value; none if left out")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield _positive("sd", self.sd, self.unit)
        given = self.lower is not None or self.upper is not None
        yield Check("lower", given, "no bound", "lower, upper or both", 'Or write kind = "normal".')
        low, high = self.support()
        yield Check("upper", low < high, high, f"> lower, {show(low, self.unit or '')}", "", self.unit or "")
        if low < high and self.sd > 0.0:
            share = float(self._share())
            fix = "Move the mean toward them, or take another distribution."
            field = "lower" if self.lower is not None else "upper"
            yield Check(
                field, share >= _LEAST_SHARE, f"{share:.2g} of the normal within the bounds", f">= {_LEAST_SHARE:g}", fix
            )

    def _scaled(self) -> tuple[float, float]:
        low, high = self.support()
        return (low - self.mean) / self.sd, (high - self.mean) / self.sd

    def _share(self) -> float:
        a, b = self._scaled()
        # in the tail that keeps digits
        return float(ndtr(-a) - ndtr(-b) if a > 0.0 else ndtr(b) - ndtr(a))

    def ppf(self, u: ArrayLike) -> Floats:
        """The value that a share u does not exceed."""
        shares = np.asarray(u, dtype=np.float64)
        start, share = self._scaled()[0], self._share()
        z = -ndtri(ndtr(-start) - shares * share) if start > 0.0 else ndtri(ndtr(start) + shares * share)
        low, high = self.support()
        found: Floats = np.clip(self.mean + self.sd * z, low, high)
        return found

    def cdf(self, x: ArrayLike) -> Floats:
        """Share that does not exceed x."""
        a, b = self._scaled()
        z = np.clip((np.asarray(x, dtype=np.float64) - self.mean) / self.sd, a, b)
        below = ndtr(-a) - ndtr(-z) if a > 0.0 else ndtr(z) - ndtr(a)
        found: Floats = below / self._share()
        return found

    def logpdf(self, x: ArrayLike) -> Floats:
        """Logarithm of the density."""
        values = np.asarray(x, dtype=np.float64)
        low, high = self.support()
        inside = (values >= low) & (values <= high)
        density = _log_normal_density((values - self.mean) / self.sd) - np.log(self.sd * self._share())
        return np.where(inside, density, -np.inf)

    def expected(self) -> float:
        """Expected value."""
        return self.mean + self.sd * self._moments()[0]

    def deviation(self) -> float:
        """Standard deviation."""
        first, second = self._moments()
        return self.sd * float(np.sqrt(second - first * first))

    def _moments(self) -> tuple[float, float]:
        """First and second moment in standard deviations about the mean of the normal (Johnson et al., eq. 13.134-135)."""
        a, b = self._scaled()
        at_a, at_b = np.exp(_log_normal_density(np.array([a, b])))
        share = self._share()
        first = (at_a - at_b) / share
        second = 1.0 + ((a * at_a if np.isfinite(a) else 0.0) - (b * at_b if np.isfinite(b) else 0.0)) / share
        return float(first), float(second)

    def support(self) -> tuple[float, float]:
        """Least and largest value."""
        return -np.inf if self.lower is None else self.lower, np.inf if self.upper is None else self.upper


class LogNormal(Distribution):
    """A lognormal distribution: of a median, with `sigma` the standard deviation of the logarithm; or of a mean and an sd.

    >>> round(float(LogNormal(median="98 kN/m", sigma=0.1).ppf(0.975)))
    119219
    >>> given = LogNormal(mean=10.0, sd=2.0)
    >>> round(given.expected(), 12), round(given.deviation(), 12)
    (10.0, 2.0)
    """

    kind: Literal["lognormal"] = "lognormal"
    median: Level | None = Field(None, description="median")
    sigma: Positive | None = Field(None, description="standard deviation of the natural logarithm")
    mean: Level | None = Field(None, description="instead of the median: expected value")
    sd: Level | None = Field(None, description="instead of sigma: standard deviation")

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        yield exclusive(
            "median", "mean", given=self.median is not None and self.mean is not None, fix="Give one of them, with its spread."
        )
        first, spread = ("mean", "sd") if self.mean is not None else ("median", "sigma")
        for field in (first, spread):
            yield Check(field, getattr(self, field) is not None, "nothing", "median and sigma, or mean and sd")
        other = "sigma" if first == "mean" else "sd"
        yield Check(other, getattr(self, other) is None, f"{other} beside {first}", f"{spread} beside {first}")
        for field in ("median", "mean", "sd"):
            value = getattr(self, field)
            if value is not None:
                yield _positive(field, value, self.unit)

    def _log(self) -> tuple[float, float]:
        """Mean and standard deviation of the logarithm."""
        if self.median is not None and self.sigma is not None:
            return float(np.log(self.median)), self.sigma
        assert self.mean is not None
        assert self.sd is not None
        variance = float(np.log1p((self.sd / self.mean) ** 2))
        return float(np.log(self.mean)) - 0.5 * variance, variance**0.5

    def ppf(self, u: ArrayLike) -> Floats:
        """The value that a share u does not exceed."""
        return self.from_normal(ndtri(np.asarray(u, dtype=np.float64)))

    def from_normal(self, z: ArrayLike) -> Floats:
        """The value that stands where z stands in the standard normal distribution."""
        center, sigma = self._log()
        found: Floats = np.exp(center + sigma * np.asarray(z, dtype=np.float64))
        return found

    def cdf(self, x: ArrayLike) -> Floats:
        """Share that does not exceed x."""
        return np.exp(log_ndtr(self._standard(x)))

    def logpdf(self, x: ArrayLike) -> Floats:
        """Logarithm of the density."""
        values = np.asarray(x, dtype=np.float64)
        logs = np.log(np.where(values > 0.0, values, 1.0))
        density = _log_normal_density(self._standard(x)) - logs - np.log(self._log()[1])
        return np.where(values > 0.0, density, -np.inf)

    def _standard(self, x: ArrayLike) -> Floats:
        values = np.asarray(x, dtype=np.float64)
        center, sigma = self._log()
        logs = np.where(values > 0.0, np.log(np.where(values > 0.0, values, 1.0)), -np.inf)
        return np.asarray((logs - center) / sigma)

    def expected(self) -> float:
        """Expected value."""
        center, sigma = self._log()
        return float(np.exp(center + 0.5 * sigma * sigma))

    def deviation(self) -> float:
        """Standard deviation."""
        return self.expected() * float(np.sqrt(np.expm1(self._log()[1] ** 2)))

    def support(self) -> tuple[float, float]:
        """Least and largest value."""
        return 0.0, np.inf


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


def _positive(field: str, value: float, unit: str | None) -> Check:
    return Check(field, value > 0.0, value, f"> 0 {unit or ''}".rstrip(), "", unit or "")


def _rising(field: str, value: float, other: str, other_value: float, unit: str | None) -> Check:
    return Check(field, value > other_value, value, f"> {other}, {show(other_value, unit or '')}", "", unit or "")


def _log_normal_density(z: Floats) -> Floats:
    return -0.5 * z * z - _LOG_ROOT_2_PI


KINDS: dict[str, type[Distribution]] = {
    "normal": Normal,
    "truncated-normal": TruncatedNormal,
    "lognormal": LogNormal,
    "uniform": Uniform,
    "triangular": Triangular,
    "discrete": Discrete,
}


def _known(value: object) -> object:
    """A distribution, or a table with a kind that there is."""
    return of_known_kind(value, Distribution, KINDS, "a table with the kind of distribution")


def _which(value: Any) -> str:
    kind = type(value) if isinstance(value, Distribution) else KINDS[value["kind"]]
    return f"({kind.__name__.lower()})"


AnyDistribution = Annotated[
    Annotated[Normal, Tag("(normal)")]
    | Annotated[TruncatedNormal, Tag("(truncatednormal)")]
    | Annotated[LogNormal, Tag("(lognormal)")]
    | Annotated[Uniform, Tag("(uniform)")]
    | Annotated[Triangular, Tag("(triangular)")]
    | Annotated[Discrete, Tag("(discrete)")],
    Discriminator(_which),
    BeforeValidator(_known),
]
"""A field of a study file that holds a distribution of any kind."""
