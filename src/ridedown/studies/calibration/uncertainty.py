"""How sure fitted parameters are: a covariance that allows for residuals that hang together, and bands from it.

The estimator makes the squares of r = w (f(x) - y) least. To first order its covariance is the sandwich

    C = A^-1 B A^-1,    A = J' J,    B = J' S J,

J the derivatives of r, S the covariance of r's noise. Of a measured number S is the variance that the file states. Of a
channel it is estimated from what the fit leaves. Samples of a channel are never independent: the filter ties neighbours, and
so does what the model cannot follow. So they are thinned to the spacing at which the filter alone would leave them
independent, and taken for a first-order process, S_ij = s^2 phi^|i-j|. Its restricted likelihood does not count what the
parameters have taken out of the residuals as missing noise. With e = r less its best fit by J, both whitened by phi,

    -2 log L(phi) = (n - p) log s^2 + log |R| + log |J' R^-1 J|,    s^2 = e' R^-1 e / (n - p).

Some thirty samples do not tell phi: the best of all phi taken for the true one leaves bands of coloured noise too narrow, since
the variance of what is fitted grows with phi faster and faster. So S is its mean over all phi, each weighted by its L: what is
left when s is integrated out (evenly in log s) and phi is as likely anywhere between its ends, -0.9 and 0.98.

Bands are C's deviations times Student's t of N - p degrees of freedom, N the mean of n (1 - phi^2) / (1 + phi^2), the number of
values with a variance as well known.

References:
    H. White, A heteroskedasticity-consistent covariance matrix estimator, Econometrica 48, 1980 (the sandwich).
    H. Patterson, R. Thompson, Recovery of inter-block information when block sizes are unequal, Biometrika 58, 1971
    (restricted likelihood).
    D. Harville, Bayesian inference for variance components using only error contrasts, Biometrika 61, 1974 (restricted
    likelihood as one that is integrated over the parameters); J. Berger, B. Liseo, R. Wolpert, Integrated likelihood methods
    for eliminating nuisance parameters, Statistical Science 14, 1999 (over phi as well).
    G. Bayley, J. Hammersley, The "effective" number of independent observations in an autocorrelated time series, J. R. Stat.
    Soc. Suppl. 8, 1946 (N).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

LEVEL = 0.95
"""Of all bands."""

_FEWEST = 3.0  # degrees of freedom that bands are given at least: fewer say nothing
_BOX = 1.0 / 12.0  # variance of an even spread over the box
_FLAT = 1e-10  # of the largest eigenvalue of A: directions below it leave the residuals as they are
_UNKNOWN = 1e4  # variance given to those: a hundred boxes
_PHI = np.tanh(np.linspace(np.arctanh(-0.9), np.arctanh(0.98), 100))
"""Correlations of neighbours that are tried: beyond, noise cannot be told from a constant, or from a buzz. Denser where the
likelihood of a thousand samples is narrower; each stands for (1 - phi^2) of the scale."""


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Part of the residuals at the best point: derivatives (rows, n), and residuals (rows,) of a channel, thinned, or the known
    variance of measured numbers.
    """

    slope: Floats
    channel: Floats | None = None
    variance: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """What is known of noise (n,): its covariance (n,) by lag, how alike neighbours are, and how many independent values it is
    worth; each the mean over first-order processes by their likelihood.
    """

    covariance: Floats
    phi: float
    independent: float

    @property
    def deviation(self) -> float:
        """Standard deviation."""
        return float(np.sqrt(self.covariance[0]))


@dataclass(frozen=True, slots=True, eq=False)
class Uncertainty:
    """Covariance (n, n) of a point in the unit cube, and how many standard deviations a band reaches to either side."""

    covariance: Floats
    reach: float
    freedom: float
    """Degrees of freedom: infinite where all noise is stated."""

    @property
    def deviation(self) -> Floats:
        """Standard deviations (n,), in parts of the box."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Floats:
        """Correlations (n, n)."""
        d = self.deviation
        return self.covariance / np.where(d > 0.0, d, 1.0)[:, None] / np.where(d > 0.0, d, 1.0)

    @property
    def within_box(self) -> Floats:
        """The covariance (n, n) with no direction wider than the box: what predictions are given."""
        variances, axes = np.linalg.eigh(self.covariance)
        capped: Floats = (axes * np.clip(variances, 0.0, _BOX)) @ axes.T
        return capped

    def band(self, slope: Floats) -> Floats:
        """Half the width (...,) of the band of predicted values, from their derivatives (..., n)."""
        half: Floats = self.reach * np.sqrt(np.maximum(np.einsum("...i,ij,...j->...", slope, self.within_box, slope), 0.0))
        return half


def uncertainty(blocks: Sequence[Block], dimensions: int) -> Uncertainty:
    """The covariance of the point that makes the squares of all blocks least."""
    bread, meat = np.zeros((dimensions, dimensions)), np.zeros((dimensions, dimensions))
    independent = 0.0
    for block in blocks:
        bread += block.slope.T @ block.slope
        if block.channel is None:
            meat += block.variance * block.slope.T @ block.slope
            continue
        noise = noise_of(block.channel, block.slope)
        independent += noise.independent
        meat = meat + block.slope.T @ _toeplitz_product(noise.covariance, block.slope)
    known = sum(len(block.slope) for block in blocks if block.channel is None)
    freedom = max(independent + known - dimensions, _FEWEST) if independent else np.inf
    return Uncertainty(_sandwich(bread, meat), _quantile(freedom), freedom)


def noise_of(residuals: Floats, slope: Floats) -> Noise:
    """The noise of residuals (n,) after a fit of parameters with these derivatives (n, p): first-order processes, each weighted
    by its restricted likelihood.

    >>> rng = np.random.default_rng(0)
    >>> found = noise_of(2.0 * rng.standard_normal(1000), np.ones((1000, 1)))
    >>> round(found.deviation, 1), abs(found.phi) < 0.05
    (2.0, True)
    """
    basis = _basis(slope)
    n, p = basis.shape
    if n <= p + 1 or not residuals.any():
        white = np.zeros(n)
        white[:1] = np.mean(residuals**2)
        return Noise(white, 0.0, float(n))
    variance, log_likelihood = _restricted(residuals, basis)
    squares = _PHI**2
    weight = (1.0 - squares) * np.exp(log_likelihood - log_likelihood.max())
    weight /= weight.sum()
    return Noise(
        covariance=(weight * variance) @ _PHI[:, None] ** np.arange(n),
        phi=float(weight @ _PHI),
        independent=float(weight @ (n * (1.0 - squares) / (1.0 + squares))),
    )


def _restricted(residuals: Floats, basis: Floats) -> tuple[Floats, Floats]:
    """Variance, and log of the restricted likelihood, for each of the correlations that are tried."""
    n, p = basis.shape
    columns = _whitened(np.column_stack([basis, residuals]))
    # the last column's part that the others leave is the last of the triangle's diagonal
    diagonal = np.abs(np.diagonal(np.linalg.qr(columns, mode="r"), axis1=1, axis2=2))
    variance = np.maximum(diagonal[:, -1] ** 2 / (n - p), 1e-300)
    determinants = (n - 1) * np.log1p(-(_PHI**2)) + 2.0 * np.log(diagonal[:, :-1]).sum(axis=1)
    log_likelihood: Floats = -0.5 * ((n - p) * np.log(variance) + determinants)
    return variance, log_likelihood


def _basis(slope: Floats) -> Floats:
    """An orthonormal basis (n, p) of what the parameters can change."""
    if slope.shape[1] == 0:
        return slope
    left, values, _ = np.linalg.svd(slope, full_matrices=False)
    kept: Floats = left[:, values > 1e-6 * max(float(values[0]), 1e-300)]
    return kept


def _whitened(columns: Floats) -> Floats:
    """Columns (n, k) with the correlation of a first-order process taken out: (phi, n, k), for each phi that is tried."""
    phi = _PHI[:, None, None]
    rest = (columns[1:] - phi * columns[:-1]) / np.sqrt(1.0 - phi**2)
    return np.concatenate([np.broadcast_to(columns[:1], (_PHI.size, 1, columns.shape[1])), rest], axis=1)


def _toeplitz_product(covariance: Floats, slope: Floats) -> Floats:
    """S J for a covariance (n,) of lags and J (n, p)."""
    n = covariance.size
    around = np.concatenate([covariance, [0.0], covariance[:0:-1]])
    product: Floats = np.fft.irfft(np.fft.rfft(around)[:, None] * np.fft.rfft(slope, 2 * n, axis=0), 2 * n, axis=0)[:n]
    return product


def _sandwich(bread: Floats, meat: Floats) -> Floats:
    values, axes = np.linalg.eigh(bread)
    flat = values <= _FLAT * max(float(values[-1]), 1e-300)
    inverse = np.where(flat, 0.0, 1.0 / np.where(flat, 1.0, values))
    turned = inverse[:, None] * (axes.T @ meat @ axes) * inverse
    turned[flat, flat] = _UNKNOWN
    covariance: Floats = axes @ turned @ axes.T
    return 0.5 * (covariance + covariance.T)


def _quantile(freedom: float) -> float:
    from scipy.stats import norm, t  # noqa: PLC0415  slow to import

    level = 0.5 + 0.5 * LEVEL
    return float(norm.ppf(level) if np.isinf(freedom) else t.ppf(level, freedom))
