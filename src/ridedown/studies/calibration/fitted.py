"""What a calibration comes to: parameters, curves and numbers with their bands, warnings, fitted scenarios."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.criteria.rating import Rating
from ridedown.scenario import Scenario, dump
from ridedown.studies.calibration.file import Calibration

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FittedParameter:
    """A parameter, SI: its value, its 95 % band, its bounds.

    deviation: standard deviation in parts of the box, on the scale it is searched by.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    lower: float
    upper: float
    by_ratio: bool
    deviation: float

    @property
    def bound(self) -> float:
        """The bound that it is nearer to."""
        return self.lower if self.value - self.lower < self.upper - self.value else self.upper

    @property
    def at_bound(self) -> bool:
        """Whether it stands at one of its bounds."""
        return abs(self.value - self.bound) < 1e-4 * (self.upper - self.lower)


@dataclass(frozen=True, slots=True)
class Peak:
    """The value of largest magnitude of a curve, with its sign, and its time [s]."""

    value: float
    time: float


@dataclass(frozen=True, slots=True, eq=False)
class FittedChannel:
    """A channel over time (T,), SI: the model's and its band (low, high), what was measured if anything.

    wide_low, wide_high: the band with the scatter of the fitted channels of this unit added, in which a measured curve should
    lie; the same as the band where there is none. rating: ISO/TS 18571, None where it cannot be.
    """

    case: str
    name: str
    unit: str
    fitted: bool
    times: Floats
    model: Floats
    low: Floats
    high: Floats
    wide_low: Floats
    wide_high: Floats
    measured: Floats | None
    rating: Rating | None
    cfc: float | None

    @property
    def peak(self) -> Peak:
        """The model's peak."""
        return _peak(self.times, self.model)

    @property
    def measured_peak(self) -> Peak | None:
        """What was measured."""
        return None if self.measured is None else _peak(self.times, self.measured)

    @property
    def peak_error(self) -> float | None:
        """The model's peak over the measured one, less one."""
        found = self.measured_peak
        return None if found is None or found.value == 0.0 else self.peak.value / found.value - 1.0

    @property
    def peak_time_error(self) -> float | None:
        """Time of the model's peak less that of the measured one [s]."""
        found = self.measured_peak
        return None if found is None else self.peak.time - found.time

    @property
    def rms(self) -> float | None:
        """Root mean square of model less measured."""
        return None if self.measured is None else float(np.sqrt(np.mean((self.model - self.measured) ** 2)))

    @property
    def within(self) -> float | None:
        """Share of the measured samples within the wide band."""
        if self.measured is None:
            return None
        return float(np.mean((self.measured >= self.wide_low) & (self.measured <= self.wide_high)))

    def as_json(self) -> dict[str, Any]:
        """Plain data; curves as lists."""
        return {
            "case": self.case,
            "channel": self.name,
            "unit": self.unit,
            "cfc": self.cfc,
            "rating": None if self.rating is None else self.rating.value,
            "grade": None if self.rating is None else self.rating.grade,
            "rating_parts": None
            if self.rating is None
            else {part: getattr(self.rating, part) for part in ("corridor", "phase", "magnitude", "slope")},
            "peak": self.peak.value,
            "peak_time": self.peak.time,
            "measured_peak": None if self.measured_peak is None else self.measured_peak.value,
            "measured_peak_time": None if self.measured_peak is None else self.measured_peak.time,
            "peak_error": self.peak_error,
            "peak_time_error": self.peak_time_error,
            "rms": self.rms,
            "within": self.within,
            **{
                key: None if getattr(self, key) is None else getattr(self, key).tolist()
                for key in ("times", "measured", "model", "low", "high", "wide_low", "wide_high")
            },
        }


@dataclass(frozen=True, slots=True)
class FittedNumber:
    """An outcome, SI: the model's value and its 95 % band, and what it should be, if anything."""

    case: str
    name: str
    unit: str
    fitted: bool
    model: float
    low: float
    high: float
    wanted: float | None
    sigma: float | None
    rounded: bool
    least: float | None
    most: float | None

    @property
    def met(self) -> bool | None:
        """Whether it is within two standard deviations, the rounding, or the limits; None where nothing was asked."""
        if self.wanted is not None:
            if self.sigma is None:
                return None
            return abs(self.model - self.wanted) <= (1.0 if self.rounded else 2.0) * self.sigma
        if self.least is None and self.most is None:
            return None
        return (self.least is None or self.model >= self.least) and (self.most is None or self.model <= self.most)

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "case": self.case,
            "outcome": self.name,
            "unit": self.unit,
            "model": self.model,
            "low": self.low,
            "high": self.high,
            "value": self.wanted,
            "sigma": None if self.rounded else self.sigma,
            "within": self.sigma if self.rounded else None,
            "min": self.least,
            "max": self.most,
            "met": self.met,
        }


@dataclass(frozen=True, slots=True)
class Help:
    """A measurement that would tell parameters apart: a channel of a case, and the 95 % band's half-width of each in parts of
    the box, without it and with it.
    """

    case: str
    channel: str
    without: float
    with_it: float


@dataclass(frozen=True, slots=True)
class Confounded:
    """Parameters that the measurements cannot tell apart, or one that they hardly depend on, and what would help.

    names: the parameter first that is least sure, then those that make up for it. weights: the direction in which the residuals
    stay as they are, in parts of the box.
    """

    names: tuple[str, ...]
    weights: tuple[float, ...]
    sentence: str
    helps: tuple[Help, ...] = ()


@dataclass(frozen=True, slots=True)
class Beyond:
    """Parameters that do as well far outside their bands, in places other than the one where the search ended."""

    names: tuple[str, ...]
    sentence: str


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """A calibration done. `interrupted`: stopped by the user; the parameters are the best there were so far.

    misfit: sum of the squares of the weighted residuals. starts: how many searches were made, and how many ended in the same
    place. covariance, correlation: (n, n), of the parameters in parts of their boxes, on the scales that they are searched by.
    """

    calibration: Calibration
    parameters: tuple[FittedParameter, ...]
    channels: tuple[FittedChannel, ...]
    numbers: tuple[FittedNumber, ...]
    misfit: float
    freedom: float
    covariance: Floats
    correlation: Floats
    confounded: tuple[Confounded, ...]
    warnings: tuple[str, ...]
    scenarios: Mapping[str, Scenario]
    starts: tuple[int, int]
    tried: int
    interrupted: bool = False
    posterior: Any = None
    beyond: Beyond | None = None

    @property
    def values(self) -> dict[str, float]:
        """Values by the parameters' names, SI."""
        return {parameter.name: parameter.value for parameter in self.parameters}

    def parameter(self, name: str) -> FittedParameter:
        """The parameter of that name."""
        return next(parameter for parameter in self.parameters if parameter.name == name)

    def toml(self, case: str) -> str:
        """The fitted scenario of a case or a prediction as a file."""
        return dump(self.scenarios[case])

    def parameters_json(self) -> dict[str, Any]:
        """Parameters, covariance and correlations as plain data."""
        return {
            "parameters": {
                p.name: {
                    "value": p.value,
                    "low": p.low,
                    "high": p.high,
                    "unit": p.unit,
                    "bounds": [p.lower, p.upper],
                    "scale": "log" if p.by_ratio else "linear",
                    "deviation": p.deviation,
                    "at_bound": p.at_bound,
                }
                for p in self.parameters
            },
            "covariance": self.covariance.tolist(),
            "correlation": self.correlation.tolist(),
        }

    def as_json(self) -> dict[str, Any]:
        """Everything as plain data, SI (see docs/calibration.md)."""
        return {
            "title": self.calibration.title,
            "interrupted": self.interrupted,
            "misfit": self.misfit,
            "degrees_of_freedom": self.freedom,
            "searches": {"made": self.starts[0], "ended_here": self.starts[1], "candidates": self.tried},
            **self.parameters_json(),
            "channels": [c.as_json() for c in self.channels if c.fitted],
            "numbers": [n.as_json() for n in self.numbers if n.fitted],
            "predictions": {
                "channels": [c.as_json() for c in self.channels if not c.fitted],
                "numbers": [n.as_json() for n in self.numbers if not n.fitted],
            },
            "confounded": [
                {
                    "parameters": list(one.names),
                    "direction": list(one.weights),
                    "sentence": one.sentence,
                    "would_help": [
                        {"case": h.case, "channel": h.channel, "half_width": h.without, "half_width_with_it": h.with_it}
                        for h in one.helps
                    ],
                }
                for one in self.confounded
            ],
            "warnings": list(self.warnings),
            "posterior": None if self.posterior is None else self.posterior.as_json(),
            "scenarios": {name: dump(scenario) for name, scenario in self.scenarios.items()},
        }


def _peak(times: Floats, values: Floats) -> Peak:
    i = int(np.argmax(np.abs(values)))
    return Peak(float(values[i]), float(times[i]))
