"""Normal, truncated normal and lognormal distributions.

References: N. L. Johnson, S. Kotz, N. Balakrishnan, Continuous univariate distributions, 2nd edition, 1994, chapters 13 (normal
and truncated), 14 (lognormal).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field
from scipy.special import log_ndtr, ndtr, ndtri

from ridedown.scenario.base import Check, exclusive
from ridedown.scenario.quantities import show
from ridedown.studies.distributions.distribution import Distribution, Floats, Level, Positive

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


def _positive(field: str, value: float, unit: str | None) -> Check:
    return Check(field, value > 0.0, value, f"> 0 {unit or ''}".rstrip(), "", unit or "")


def _log_normal_density(z: Floats) -> Floats:
    return -0.5 * z * z - _LOG_ROOT_2_PI
