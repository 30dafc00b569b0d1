"""What a candidate is judged by: measured channels, measured numbers, limits; each as standardised values.

A standardised value is a model's value over its standard deviation, so that of numbers one counts for one. A channel of n
samples through a filter holds fewer independent values than samples: n_i = 2 B T of bandwidth B and length T (Nyquist). Its
samples count n_i/n each, so that channels and numbers can be weighed against each other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ridedown.studies.calibration.sampling import Samples

Floats = NDArray[np.float64]

_MARGIN = 0.85
"""How much of a rounding a search may use: its result is rounded too."""
_PULL = 1e-3
"""How weakly a rounded number draws its value to its middle, so that a search always has a slope to follow."""


@dataclass(frozen=True, slots=True, eq=False)
class ChannelTarget:
    """A channel (T,) to match: `measured` in `unit`, the standard deviation expected of it."""

    name: str
    unit: str
    samples: Samples
    measured: Floats | None
    sigma: float
    weight: float
    independent: float
    """Number of independent values, n_i."""
    peak_sigma: float = np.inf
    """Standard deviation of its peak, where that counts by itself."""

    @property
    def scale(self) -> float:
        """What a sample is divided by."""
        return self.sigma * float(np.sqrt(self.samples.times.size / self.independent))

    def peak_of(self, values: Floats) -> Floats:
        """The extreme (R,) of channels (R, T) on the side on which the measured one has its peak."""
        assert self.measured is not None
        side = np.sign(self.measured[np.argmax(np.abs(self.measured))])
        extreme: Floats = side * (side * values).max(axis=1)
        return extreme

    @property
    def thinning(self) -> int:
        """Every how many samples are as good as independent after the filter."""
        return max(1, round(self.samples.times.size / self.independent))


@dataclass(frozen=True, slots=True, eq=False)
class NumberTarget:
    """An outcome to match or to keep within limits.

    value: None where there is only a limit. sigma: of the value, or the half-width that it is rounded to where `rounded`, or
    the softness of the limits `least` and `most`.
    """

    name: str
    unit: str
    value: float | None
    sigma: float
    weight: float
    rounded: bool = False
    least: float = -np.inf
    most: float = np.inf

    @property
    def deviation(self) -> float:
        """Standard deviation: of a number that is only known to its rounding, that of an even spread."""
        return self.sigma / float(np.sqrt(3.0)) if self.rounded else self.sigma

    def residuals(self, x: Floats) -> Floats:
        """How far outcomes (R,) are from it, (R, 1 or 2): squares add up to the misfit."""
        if self.value is None:
            beyond = np.maximum(x - self.most, 0.0) + np.maximum(self.least - x, 0.0)
            return (beyond / self.sigma)[:, None]
        error = (x - self.value) / self.sigma
        if not self.rounded:
            return error[:, None]
        beyond = np.sign(error) * np.maximum(np.abs(error) - _MARGIN, 0.0)
        return np.stack([beyond, np.sqrt(_PULL) * error], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """What candidates come to in one case: channels (R, T) and outcomes (R,), by their names; NaN where a crash failed."""

    channels: Mapping[str, Floats]
    outcomes: Mapping[str, Floats]


def residuals(
    channels: tuple[ChannelTarget, ...], numbers: tuple[NumberTarget, ...], found: Evaluation, weight: float
) -> list[Floats]:
    """Weighted residuals of a case, a block (R, rows) for each target with something to match."""
    blocks = []
    for channel in channels:
        if channel.measured is not None:
            error = (found.channels[channel.name] - channel.measured) / channel.scale
            blocks.append(np.sqrt(weight * channel.weight) * error)
            if np.isfinite(channel.peak_sigma):
                beyond = channel.peak_of(found.channels[channel.name]) - channel.peak_of(channel.measured[None])
                blocks.append(np.sqrt(weight * channel.weight) * beyond[:, None] / channel.peak_sigma)
    blocks += [np.sqrt(weight * number.weight) * number.residuals(found.outcomes[number.name]) for number in numbers]
    return blocks
