"""What a sample tells: quantiles of outcomes, and the probability of exceeding limits, each with its interval.

Rows drawn at random are judged by exact theory: Clopper-Pearson for a share, order statistics for a quantile. Rows of a Sobol
sequence are more even than random ones, and are judged by how several scramblings differ, with Student's t.

A row that failed has no outcome. It is left out of the estimate, and the interval is widened by what it could have been: its
lower end takes all failed rows as within the limit, its upper end takes them all as beyond it.

References:
    C. J. Clopper, E. S. Pearson, The use of confidence or fiducial limits, Biometrika 26, 1934.
    H. A. David, H. N. Nagaraja, Order statistics, 3rd edition, 2003, section 7.1.
    A. B. Owen, Scrambled net variance for integrals of smooth functions, Ann. Stat. 25, 1997.
    E. B. Wilson, Probable inference, J. Am. Stat. Assoc. 22, 1927.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from scipy.special import betaincinv, ndtri, stdtrit

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Design, LatinHypercube, Random, Scramblings, Seed, Variables, seed_of
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

DesignName = Literal["sobol", "latin-hypercube", "random"]

SHARES = (0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99)
"""Quantiles that a summary has."""

_ENOUGH = 5  # exceedances in each scrambling on the average, below which their spread says little


@dataclass(frozen=True, slots=True)
class Exceedance:
    """How likely a limit is exceeded: the probability, and the rows that it is counted from."""

    limit: Limit
    probability: Estimate
    exceeded: int
    rows: int
    failed: int

    @property
    def beta(self) -> float:
        """Reliability index: the probability as standard deviations of a normal; infinite where no row exceeded the limit."""
        return float(-ndtri(self.probability.value))


@dataclass(frozen=True, slots=True)
class Quantile:
    """The value that a share of all rows does not exceed."""

    share: float
    value: Estimate


@dataclass(frozen=True, slots=True)
class Summary:
    """One outcome over a sample: mean, standard deviation, extremes and quantiles, of the rows that did not fail."""

    outcome: str
    mean: Estimate
    deviation: float
    least: float
    largest: float
    quantiles: tuple[Quantile, ...]
    rows: int
    failed: int


@dataclass(frozen=True, slots=True)
class Sampled:
    """A sample: summaries of its outcomes, probabilities of exceeding its limits, and what it took."""

    summaries: tuple[Summary, ...]
    exceedances: tuple[Exceedance, ...]
    design: str
    evaluations: int
    failed: int
    seed: int


def sample(
    evaluator: Evaluator,
    variables: Variables,
    outcomes: Sequence[str],
    *,
    limits: Sequence[Limit] = (),
    rows: int = 16_384,
    design: DesignName = "sobol",
    scramblings: int = 16,
    shares: Sequence[float] = SHARES,
    confidence: float = 0.95,
    seed: Seed = None,
    batch: int = BATCH,
    progress: Progress | None = None,
) -> Sampled:
    """Evaluate rows of distributed parameters, and summarise what comes back.

    rows: in all; with a Sobol sequence, rounded up to `scramblings` times a power of two. A Latin hypercube is judged as if it
    were random, which makes intervals too wide, not too narrow.

    Raises: InvalidInput, UnknownName.

    >>> from ridedown.studies.distributions import Normal
    >>> strength = Variables({"load": Normal(mean=0.0, sd=1.0)})
    >>> found = sample(lambda table: {"load": table["load"]}, strength, ["load"], limits=[Limit("load", most=2.0)], seed=0)
    >>> found.exceedances[0].probability.low < 0.02275 < found.exceedances[0].probability.high
    True
    """
    check_count(rows, "rows")
    fixed = seed_of(seed)
    plan, size, groups = plan_of(design, len(variables.names), rows, scramblings, fixed)
    names = list(dict.fromkeys([*outcomes, *(limit.outcome for limit in limits)]))
    runs = Runs(evaluator, names, batch=batch, total=size, progress=progress)
    found = {name: np.empty(size) for name in names}
    for start in range(0, size, batch):
        part = slice(start, min(start + batch, size))
        for name, values in runs(variables.columns(plan.rows(part.start, part.stop))).items():
            found[name][part] = values
    return Sampled(
        tuple(summary(name, found[name], shares=shares, groups=groups, confidence=confidence) for name in outcomes),
        tuple(exceedance(limit, found[limit.outcome], groups=groups, confidence=confidence) for limit in limits),
        design,
        runs.done,
        runs.failed,
        fixed,
    )


def plan_of(design: str, dimensions: int, rows: int, scramblings: int, seed: int) -> tuple[Design, int, int]:
    """The design of a name, its number of rows, and how many independent parts of equal size they are made of.

    One part means that rows are judged as random ones are. Raises: InvalidInput for a design that is not known.
    """
    if design == "random":
        return Random(dimensions, seed), rows, 1
    if design == "latin-hypercube":
        return LatinHypercube(dimensions, seed, rows), rows, 1
    if design != "sobol":
        known = ", ".join(get_args(DesignName))
        raise InvalidInput(f"design: got {design!r}; need one of {known}.")
    check_count(scramblings, "scramblings", 2)
    size = 1 << (max(1, -(-rows // scramblings)) - 1).bit_length()
    return Scramblings(dimensions, seed, size, scramblings), size * scramblings, scramblings


def exceedance(limit: Limit, values: Floats, *, groups: int = 1, confidence: float = 0.95) -> Exceedance:
    """Probability of exceeding a limit, of an outcome's values (R,), NaN where a row failed.

    groups: of how many independent parts of equal size the rows are made, as `Scramblings` are; 1 for rows at random.
    """
    excess = limit.excess(_parts(values, groups))
    failed = np.isnan(excess)
    beyond = (excess > 0.0).sum(axis=1)
    lost = failed.sum(axis=1)
    good, bad, size = int(beyond.sum()), int(lost.sum()), values.size
    value = good / (size - bad) if size > bad else np.nan
    low, high = share_interval(good, size, confidence)[0], share_interval(good + bad, size, confidence)[1]
    spread_tells = groups > 1 and min(good, size - good - bad) >= _ENOUGH * groups
    if spread_tells:
        each = excess.shape[1]
        low = max(0.0, _mean_interval(beyond / each, confidence)[0])
        high = min(1.0, _mean_interval((beyond + lost) / each, confidence)[1])
    return Exceedance(limit, Estimate(value, low, high, confidence), good, size, bad)


def share_interval(count: int, size: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of a share of which `count` of `size` random rows are a sample, after Clopper and Pearson: it never covers less
    often than stated.

    >>> low, high = share_interval(0, 100)
    >>> low, round(high, 4)
    (0.0, 0.0362)
    """
    tail = 0.5 * (1.0 - check_share(confidence, "confidence"))
    low = 0.0 if count == 0 else float(betaincinv(count, size - count + 1, tail))
    high = 1.0 if count == size else float(betaincinv(count + 1, size - count, 1.0 - tail))
    return low, high


def wilson_interval(count: int, size: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of a share after Wilson: it covers as often as stated on the average, and is shorter than Clopper-Pearson's.

    >>> [round(end, 4) for end in wilson_interval(5, 100)]
    [0.0215, 0.1118]
    """
    z = float(ndtri(0.5 + 0.5 * check_share(confidence, "confidence")))
    share, weight = count / size, z * z / size
    middle = (share + 0.5 * weight) / (1.0 + weight)
    half = z / (1.0 + weight) * float(np.sqrt(share * (1.0 - share) / size + 0.25 * weight / size))
    return max(0.0, middle - half), min(1.0, middle + half)


def summary(
    outcome: str, values: Floats, *, shares: Sequence[float] = SHARES, groups: int = 1, confidence: float = 0.95
) -> Summary:
    """Mean, extremes and quantiles of an outcome's values (R,), NaN where a row failed. groups: as in `exceedance`.

    The intervals are those of the rows that did not fail.
    """
    parts = [part[~np.isnan(part)] for part in _parts(values, groups)]
    kept = np.sort(np.concatenate(parts))
    failed = values.size - kept.size
    if not kept.size:
        none = Estimate(np.nan, np.nan, np.nan, confidence)
        quantiles = tuple(Quantile(check_share(share, "shares"), none) for share in shares)
        return Summary(outcome, none, np.nan, np.nan, np.nan, quantiles, values.size, failed)
    whole = groups > 1 and all(part.size for part in parts)
    means = np.array([part.mean() for part in parts]) if whole else kept
    low, high = _mean_interval(means, confidence)
    for part in parts:
        part.sort()
    return Summary(
        outcome,
        Estimate(float(kept.mean()), low, high, confidence),
        float(kept.std(ddof=1)) if kept.size > 1 else np.nan,
        float(kept[0]),
        float(kept[-1]),
        tuple(_quantile(kept, parts if whole else [], share, confidence) for share in shares),
        values.size,
        failed,
    )


def _quantile(kept: Floats, parts: list[Floats], share: float, confidence: float) -> Quantile:
    """A quantile of sorted values; interval by order statistics, or by how those of the parts differ."""
    value = _between(kept, check_share(share, "shares"))
    # a tail that hardly any row of a part reaches is told by the rows of all parts
    tail = min(share, 1.0 - share) * min((part.size for part in parts), default=0)
    if parts and tail >= _ENOUGH:
        low, high = _mean_interval(np.array([_between(part, share) for part in parts]), confidence)
        # The quantile of a part is biased, and the more so the fewer rows it has: its spread is used, not its mean.
        half = 0.5 * (high - low)
        return Quantile(share, Estimate(value, value - half, value + half, confidence))
    from scipy.stats import binom  # noqa: PLC0415  slow to import

    rest = 0.5 * (1.0 - confidence)
    below = int(binom.ppf(rest, kept.size, share))
    above = int(binom.ppf(1.0 - rest, kept.size, share)) + 1
    # where even the extremes are not far out enough, nothing bounds the quantile
    low = -np.inf if below < 1 else float(kept[below - 1])
    high = np.inf if above > kept.size else float(kept[above - 1])
    return Quantile(share, Estimate(value, low, high, confidence))


def _between(rising: Floats, share: float) -> float:
    """The quantile of sorted values, linear between two of them, as numpy's: which sorts once more whatever it is given."""
    place = share * (rising.size - 1)
    below = int(place)
    pair = rising[below : below + 2]
    return float(np.quantile(pair, place - below))


def _mean_interval(values: Floats, confidence: float) -> tuple[float, float]:
    """Student's interval of the mean of independent values."""
    if values.size < 2:
        return -np.inf, np.inf
    half = float(stdtrit(values.size - 1, 0.5 + 0.5 * confidence) * values.std(ddof=1) / np.sqrt(values.size))
    middle = float(values.mean())
    return middle - half, middle + half


def _parts(values: Floats, groups: int) -> Floats:
    check_count(groups, "groups")
    if values.ndim != 1 or not values.size or values.size % groups:
        raise InvalidInput(
            f"values: got shape {values.shape}; need a column whose length {groups} divides, as many as the groups."
        )
    return values.reshape(groups, -1)
