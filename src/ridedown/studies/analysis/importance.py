"""Rare events: the probability of exceeding a limit by importance sampling in the space of standard normals.

Rows are drawn where the limit is exceeded, and each counts by how likely it was (its weight). Where to draw is found by the
improved cross-entropy method: the limit is first smoothed, then sharpened level by level, and a mixture of normals follows. In
the final sample a tenth of the rows are drawn as they come (the defensive component), so that no weight is more than ten.

The estimate has no bias whatever the proposal; how exact it is, is told from the weights. One thing they cannot tell: a second
region of failure that no row was ever in. The defensive rows would meet it if it were as likely as about one in their number.

References:
    R. Y. Rubinstein, D. P. Kroese, The cross-entropy method, 2004; D. P. Kroese, T. Taimre, Z. I. Botev, Handbook of Monte
        Carlo methods, 2011, chapters 9, 10.
    I. Papaioannou, S. Geyer, D. Straub, Improved cross entropy-based importance sampling with a flexible mixture model,
        Reliab. Eng. Syst. Saf. 191, 2019.
    T. Hesterberg, Weighted average importance sampling and defensive mixture distributions, Technometrics 37, 1995.
    A. B. Owen, Monte Carlo theory, methods and examples, 2013, chapter 9 (effective number of rows).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtri

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Seed, Variables, seed_of
from ridedown.studies.analysis.evaluation import (
    BATCH,
    Estimate,
    Evaluator,
    Floats,
    Limit,
    Progress,
    Runs,
    check_count,
    check_share,
)
from ridedown.studies.analysis.reliability import share_interval

_DEFENSIVE = 0.1
_SPREAD = 1.5  # coefficient of variation that a level's weights are let to have (Papaioannou et al. 2019)
_MOST_LEVELS = 30
_LEAST_EFFECTIVE = 100.0
_LARGEST_PART = 0.05


@dataclass(frozen=True, slots=True)
class Mixture:
    """A mixture of m normals in d dimensions: shares (m,), means (m, d), Cholesky factors of the covariances (m, d, d)."""

    shares: Floats
    means: Floats
    roots: Floats

    def log_density(self, z: Floats) -> Floats:
        """Logarithm of the density of rows (R, d), less the constant that all normals share."""
        each = []
        for share, mean, root in zip(self.shares, self.means, self.roots, strict=True):
            off = np.linalg.solve(root, (z - mean).T)
            each.append(np.log(share) - 0.5 * (off * off).sum(axis=0) - np.log(np.diagonal(root)).sum())
        return _log_sum(np.array(each))

    def draw(self, rows: int, rng: np.random.Generator) -> Floats:
        """Rows (R, d), of each normal as many as its share."""
        counts = rng.multinomial(rows, self.shares)
        parts = [
            mean + rng.standard_normal((count, mean.size)) @ root.T
            for count, mean, root in zip(counts, self.means, self.roots, strict=True)
        ]
        return np.concatenate(parts)


@dataclass(frozen=True, slots=True)
class RareEvent:
    """How likely a limit is exceeded, by importance sampling.

    effective: the number of equally weighted rows beyond the limit that would be as exact. likeliest: the most likely row found
    beyond the limit, and its `distance` from the median in standard deviations. warnings: why not to trust it, in
    sentences.
    """

    limit: Limit
    probability: Estimate
    effective: float
    exceeded: int
    rows: int
    failed: int
    levels: int
    likeliest: Mapping[str, float]
    distance: float
    evaluations: int
    seed: int
    warnings: tuple[str, ...]

    @property
    def beta(self) -> float:
        """Reliability index: the probability as standard deviations of a normal."""
        return float(-ndtri(self.probability.value))


def rare_event(
    evaluator: Evaluator,
    variables: Variables,
    limit: Limit,
    *,
    rows: int = 10_000,
    level_rows: int = 2_000,
    components: int = 2,
    confidence: float = 0.95,
    seed: Seed = None,
    batch: int = BATCH,
    progress: Progress | None = None,
) -> RareEvent:
    """Probability of exceeding a limit that hardly any plain row exceeds.

    rows: of the final sample, which alone makes the estimate. level_rows: of each level of the search. components: normals of
    the mixture, at least as many as there are separate ways to fail.

    Raises: InvalidInput, UnknownName.

    >>> from ridedown.studies.distributions import Normal
    >>> two = Variables({"a": Normal(mean=0.0, sd=1.0), "b": Normal(mean=0.0, sd=1.0)})
    >>> found = rare_event(lambda t: {"sum": (t["a"] + t["b"]) / 2**0.5}, two, Limit("sum", most=4.5), seed=1)
    >>> found.probability.low < 3.3977e-06 < found.probability.high
    True
    >>> found.warnings
    ()
    """
    for value, name, least in ((rows, "rows", 100), (level_rows, "level_rows", 100), (components, "components", 1)):
        check_count(value, name, least)
    check_share(confidence, "confidence")
    fixed = seed_of(seed)
    rng = np.random.default_rng(fixed)
    runs = Runs(evaluator, [limit.outcome], batch=batch, total=rows + _MOST_LEVELS * level_rows, progress=progress)

    def excess(z: Floats) -> Floats:
        return limit.excess(runs(variables.columns_from_normal(z))[limit.outcome])

    proposal, levels, arrived = _search(excess, len(variables.names), level_rows, components, rng)
    z, weights = _final_sample(proposal, rows, rng)
    over = excess(z)
    beyond, failed = over > 0.0, np.isnan(over)
    estimate = _weighted(weights, beyond, failed, confidence)
    parts = weights[beyond]
    effective = float(parts.sum() ** 2 / (parts * parts).sum()) if parts.size else 0.0
    nearest = z[np.argmin(np.where(beyond, (z * z).sum(axis=1), np.inf))] if parts.size else np.full(z.shape[1], np.nan)
    return RareEvent(
        limit,
        estimate,
        effective,
        int(beyond.sum()),
        rows,
        int(failed.sum()),
        levels,
        {name: float(value[0]) for name, value in variables.columns_from_normal(nearest[None]).items()} if parts.size else {},
        float(np.linalg.norm(nearest)),
        runs.done,
        fixed,
        tuple(_warnings(parts, effective, int(failed.sum()), rows, arrived=arrived)),
    )


def _warnings(parts: Floats, effective: float, failed: int, rows: int, *, arrived: bool) -> list[str]:
    found = []
    if not parts.size:
        found.append("No row exceeded the limit: the probability is below the interval's upper end, and no more is known.")
    elif effective < _LEAST_EFFECTIVE:
        found.append(
            f"The rows beyond the limit count as {effective:.0f} only: the weights differ too much. "
            "Take more rows, or more rows a level."
        )
    if parts.size and parts.max() > _LARGEST_PART * parts.sum():
        found.append(f"One row makes {parts.max() / parts.sum():.0%} of the probability. The interval may be too narrow.")
    if not arrived:
        found.append("The search did not arrive at the limit within its levels. The proposal may miss where it is exceeded.")
    if failed:
        found.append(f"{failed} of {rows} rows failed; the interval's upper end counts them as exceeding the limit.")
    return found


Excess = Callable[[Floats], Floats]
"""Rows of standard normals (R, d) to how far each is beyond the limit (R,)."""


def _search(excess: Excess, dimensions: int, rows: int, components: int, rng: np.random.Generator) -> tuple[Mixture, int, bool]:
    """A proposal near where the limit is exceeded, the levels that it took, and whether it got there."""
    proposal = Mixture(np.ones(1), np.zeros((1, dimensions)), np.eye(dimensions)[None])
    width = np.inf
    for level in range(1, _MOST_LEVELS + 1):
        z = proposal.draw(rows, rng)
        over = excess(z)
        known = ~np.isnan(over)
        if not known.any():
            raise InvalidInput("rows: got none that did not fail; need some. Look at why they fail.")
        z, over = z[known], over[known]
        log_weights = _log_standard(z) - proposal.log_density(z)
        if width == np.inf:
            width = 10.0 * max(float(over.std()), np.finfo(float).tiny)
        # arrived where the sharp limit needs hardly more than the smooth one gives: its weights are as even
        beyond = over > 0.0
        if beyond.any():
            ratio = np.where(beyond, -log_ndtr(over / width), -np.inf)
            if _variation(ratio) <= _SPREAD:
                return proposal, level, True
        width = _next_width(over, log_weights, width)
        smooth = log_weights + log_ndtr(over / width)
        proposal = _fitted(z, np.exp(smooth - _log_sum(smooth)), components, rng)
    return proposal, _MOST_LEVELS, False


def _next_width(over: Floats, log_weights: Floats, width: float) -> float:
    """How much to smooth the limit next: as little as leaves the weights even enough, and never more than before."""
    low, high = np.log(width) - 12.0, np.log(width)
    for _ in range(24):
        middle = 0.5 * (low + high)
        if _variation(log_weights + log_ndtr(over / np.exp(middle))) > _SPREAD:
            low = middle
        else:
            high = middle
    return float(np.exp(high))


def _variation(logs: Floats) -> float:
    """Coefficient of variation of numbers given by their logarithms."""
    numbers = np.exp(logs - logs.max())
    return float(numbers.std() / numbers.mean())


def _log_sum(logs: Floats) -> Floats:
    """Logarithm of the sum, over the first axis, of numbers given by their logarithms."""
    most = logs.max(axis=0)
    return np.asarray(most + np.log(np.exp(logs - most).sum(axis=0)))


def _log_standard(z: Floats) -> Floats:
    found: Floats = -0.5 * (z * z).sum(axis=1)
    return found


def _fitted(z: Floats, weights: Floats, components: int, rng: np.random.Generator) -> Mixture:
    """The mixture that weighted rows are likeliest under, by expectation and maximisation (Geyer et al. 2019).

    Each covariance is drawn toward a multiple of the unit matrix, the more so the fewer rows it rests on.
    """
    rows, dimensions = z.shape
    centers = z[rng.choice(rows, size=components, replace=False, p=_full(weights, components))]
    near = ((z[:, None, :] - centers[None]) ** 2).sum(axis=2).argmin(axis=1)
    belongs = np.eye(components)[near]
    mixture = Mixture(np.ones(1), np.zeros((1, dimensions)), np.eye(dimensions)[None])
    likely = -np.inf
    for _ in range(12):
        shares = weights @ belongs
        kept = shares > 1e-3
        belongs, shares = belongs[:, kept], shares[kept] / shares[kept].sum()
        means, roots = [], []
        for k in range(shares.size):
            part = weights * belongs[:, k]
            part = part / part.sum()
            mean = part @ z
            off = z - mean
            covariance = (off.T * part) @ off
            effective = 1.0 / float(part @ part)
            toward = (dimensions + 1.0) / (dimensions + 1.0 + effective)
            covariance = (1.0 - toward) * covariance + toward * np.eye(dimensions)
            covariance += 1e-4 * np.eye(dimensions)
            means.append(mean)
            roots.append(np.linalg.cholesky(covariance))
        mixture = Mixture(shares, np.array(means), np.array(roots))
        logs = np.stack(
            [
                Mixture(shares[k : k + 1], mixture.means[k : k + 1], mixture.roots[k : k + 1]).log_density(z)
                for k in range(shares.size)
            ]
        )
        together = _log_sum(logs)
        belongs = np.exp(logs - together).T
        before, likely = likely, float(weights @ together)
        if likely - before < 1e-4:
            break
    return mixture


def _full(weights: Floats, components: int) -> Floats:
    """Weights to draw centres by, of which at least as many are not zero as are drawn."""
    small = 1e-6 / weights.size if np.count_nonzero(weights) < components else 0.0
    found: Floats = (weights + small) / (weights + small).sum()
    return found


def _final_sample(proposal: Mixture, rows: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Rows (R, d) of the proposal with its defensive component, and their weights (R,)."""
    dimensions = proposal.means.shape[1]
    defended = Mixture(
        np.concatenate([[_DEFENSIVE], (1.0 - _DEFENSIVE) * proposal.shares]),
        np.concatenate([np.zeros((1, dimensions)), proposal.means]),
        np.concatenate([np.eye(dimensions)[None], proposal.roots]),
    )
    z = defended.draw(rows, rng)
    return z, np.exp(_log_standard(z) - defended.log_density(z))


def _weighted(weights: Floats, beyond: NDArray[np.bool_], failed: NDArray[np.bool_], confidence: float) -> Estimate:
    """The mean weight of rows beyond the limit, with an interval on the logarithm, where it is nearer to normal."""
    reach = float(ndtri(0.5 + 0.5 * confidence))

    def ends(chosen: NDArray[np.bool_]) -> tuple[float, float, float]:
        parts = np.where(chosen, weights, 0.0)
        value = float(parts.mean())
        if value == 0.0:
            # no row in the defensive tenth either: the rule of Clopper and Pearson for none
            return 0.0, 0.0, share_interval(0, max(1, int(_DEFENSIVE * weights.size)), confidence)[1]
        variation = float(parts.std(ddof=1)) / value / weights.size**0.5
        spread = reach * float(np.sqrt(np.log1p(variation * variation)))
        return value, value * float(np.exp(-spread)), min(1.0, value * float(np.exp(spread)))

    value, low, _ = ends(beyond)
    return Estimate(value, low, ends(beyond | failed)[2], confidence)
