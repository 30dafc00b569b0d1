"""Which parameter matters: Sobol indices, and Morris screening for many parameters, through SALib.

`first` is the share of an outcome's variance that a parameter makes by itself, `total` the share that it has a part in. Their
difference is what it does together with others. Parameters must be independent.

References:
    A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181, 2010 (rows, and the
        estimator of the first index, table 2 b).
    M. J. W. Jansen, Analysis of variance designs for model output, Comput. Phys. Commun. 117, 1999 (total index).
    M. D. Morris, Factorial sampling plans for preliminary computational experiments, Technometrics 33, 1991.
    F. Campolongo, J. Cariboni, A. Saltelli, An effective screening design, Environ. Model. Softw. 22, 2007 (mu star).
    J. Herman, W. Usher, SALib, J. Open Source Softw. 2(9), 2017.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Seed, Sobol, Variables, seed_of
from ridedown.studies.analysis.evaluation import BATCH, Estimate, Evaluator, Floats, Progress, Runs, check_count, check_share

_SAME = 1e-12  # of the largest magnitude: outcomes that differ by no more are equal, but for rounding


@dataclass(frozen=True, slots=True)
class Index:
    """Share of an outcome's variance due to one parameter: by itself, and with all others. `idle`: no row changed with it."""

    parameter: str
    first: Estimate
    total: Estimate
    idle: bool


@dataclass(frozen=True, slots=True)
class OutcomeIndices:
    """The indices of one outcome, in the order of the parameters. `constant`: it never changed, and no index means anything.

    blocks: how many of the design's blocks of d + 2 rows had no failed row, and were used, of how many.
    """

    outcome: str
    indices: tuple[Index, ...]
    constant: bool
    mean: float
    deviation: float
    blocks: int
    of_blocks: int


@dataclass(frozen=True, slots=True)
class SobolSensitivity:
    """Sobol indices of some outcomes. idle: parameters that had no effect on any of them."""

    outcomes: tuple[OutcomeIndices, ...]
    idle: tuple[str, ...]
    evaluations: int
    failed: int
    seed: int


@dataclass(frozen=True, slots=True)
class Effect:
    """Elementary effects of one parameter on an outcome, over the middle 98 % of its values.

    mean: with sign; mean_size: of the magnitudes (mu star), for ranking; deviation: large where the effect is curved or
    depends on others. All in the outcome's unit, for a move over the whole range.
    """

    parameter: str
    mean: float
    mean_size: Estimate
    deviation: float
    idle: bool


@dataclass(frozen=True, slots=True)
class OutcomeEffects:
    """The effects on one outcome. trajectories: how many had no failed row, and were used, of how many."""

    outcome: str
    effects: tuple[Effect, ...]
    constant: bool
    trajectories: int
    of_trajectories: int


@dataclass(frozen=True, slots=True)
class MorrisScreening:
    """Morris screening of some outcomes. idle: parameters that had no effect on any of them."""

    outcomes: tuple[OutcomeEffects, ...]
    idle: tuple[str, ...]
    evaluations: int
    failed: int
    seed: int


def sobol_indices(
    evaluator: Evaluator,
    variables: Variables,
    outcomes: Sequence[str],
    *,
    blocks: int = 1024,
    resamples: int = 200,
    confidence: float = 0.95,
    seed: Seed = None,
    batch: int = BATCH,
    progress: Progress | None = None,
) -> SobolSensitivity:
    """First and total Sobol indices by `blocks` times d + 2 rows. Intervals are bootstrapped.

    blocks: best a power of two. A block with a failed row is left out whole, for that outcome.

    Raises: InvalidInput for correlated parameters, of which indices do not add up; UnknownName.

    >>> from ridedown.studies.distributions import Uniform
    >>> three = Variables({name: Uniform(lower=0.0, upper=1.0) for name in ("a", "b", "c")})
    >>> found = sobol_indices(lambda t: {"y": 2.0 * t["a"] + t["b"]}, three, ["y"], seed=0)
    >>> [round(index.first.value, 2) for index in found.outcomes[0].indices], found.idle
    ([0.8, 0.2, 0.0], ('c',))
    """
    check_count(blocks, "blocks", 2)
    check_count(resamples, "resamples", 10)
    check_share(confidence, "confidence")
    fixed, names = seed_of(seed), _independent(variables)
    d, width = len(names), len(names) + 2
    runs = Runs(evaluator, outcomes, batch=batch, total=blocks * width, progress=progress)
    design = Sobol(2 * d, fixed)
    found = {name: np.empty((blocks, width)) for name in dict.fromkeys(outcomes)}
    step = max(1, batch // width)
    for start in range(0, blocks, step):
        stop = min(start + step, blocks)
        rows = _saltelli(design.rows(start, stop), d)
        for name, values in runs(variables.columns(rows)).items():
            found[name][start:stop] = values.reshape(-1, width)
    results = tuple(
        _outcome_indices(name, values, names, resamples, confidence, np.random.default_rng([fixed, i]))
        for i, (name, values) in enumerate(found.items())
    )
    idle = tuple(name for i, name in enumerate(names) if all(one.indices[i].idle for one in results))
    return SobolSensitivity(results, idle, runs.done, runs.failed, fixed)


def _saltelli(rows: Floats, d: int) -> Floats:
    """Saltelli's blocks of rows (n, 2 d): A, then A with one column of B after the other, then B; (n (d + 2), d)."""
    a, b = rows[:, :d], rows[:, d:]
    blocks = np.repeat(a[:, None, :], d + 2, axis=1)
    for i in range(d):
        blocks[:, i + 1, i] = b[:, i]
    blocks[:, d + 1] = b
    return blocks.reshape(-1, d)


def _outcome_indices(
    outcome: str, values: Floats, names: Sequence[str], resamples: int, confidence: float, rng: np.random.Generator
) -> OutcomeIndices:
    whole = values[~np.isnan(values).any(axis=1)]
    d, size = len(names), len(whole)
    constant = size > 0 and _alike(whole)
    idle = [size > 0 and not _moved(whole[:, 0], whole[:, i + 1], whole) for i in range(d)]
    if size < 2 or constant:
        none = Estimate(np.nan, np.nan, np.nan, confidence)
        indices = tuple(Index(name, none, none, still) for name, still in zip(names, idle, strict=True))
        mean = float(whole.mean()) if size else np.nan
        return OutcomeIndices(outcome, indices, constant, mean, 0.0 if constant else np.nan, size, len(values))
    from SALib.analyze import sobol as sobol_analysis  # noqa: PLC0415  slow to import

    found = sobol_analysis.analyze(
        {"num_vars": d, "names": list(names), "bounds": [[0.0, 1.0]] * d},
        whole.ravel(),
        calc_second_order=False,
        num_resamples=resamples,
        conf_level=confidence,
        seed=rng,  # a generator, for SALib takes the number 0 for no seed at all
    )
    indices = tuple(
        Index(
            name,
            _estimate(found["S1"][i], found["S1_conf"][i], confidence),
            _estimate(found["ST"][i], found["ST_conf"][i], confidence),
            idle[i],
        )
        for i, name in enumerate(names)
    )
    plain = whole[:, [0, -1]]
    return OutcomeIndices(outcome, indices, constant, float(plain.mean()), float(plain.std()), size, len(values))


def morris_screening(
    evaluator: Evaluator,
    variables: Variables,
    outcomes: Sequence[str],
    *,
    trajectories: int = 50,
    levels: int = 4,
    confidence: float = 0.95,
    seed: Seed = None,
    batch: int = BATCH,
    progress: Progress | None = None,
) -> MorrisScreening:
    """Elementary effects by `trajectories` times d + 1 rows: which of many parameters matter at all.

    levels: an even number of places in each parameter's distribution, from its 1 % to its 99 % quantile. A trajectory with a
    failed row is left out whole, for that outcome.

    Raises: InvalidInput, UnknownName.

    >>> from ridedown.studies.distributions import Uniform
    >>> three = Variables({name: Uniform(lower=0.0, upper=1.0) for name in ("a", "b", "c")})
    >>> found = morris_screening(lambda t: {"y": 2.0 * t["a"] - t["b"]}, three, ["y"], seed=0)
    >>> [round(effect.mean, 2) for effect in found.outcomes[0].effects], found.idle
    ([1.96, -0.98, 0.0], ('c',))
    """
    check_count(trajectories, "trajectories", 2)
    if check_count(levels, "levels", 2) % 2:
        raise InvalidInput(f"levels: got {levels}; need an even number, so that steps of half the range begin on a level.")
    check_share(confidence, "confidence")
    fixed, names = seed_of(seed), _independent(variables)
    d = len(names)
    problem = {"num_vars": d, "names": list(names), "bounds": [[0.0, 1.0]] * d}
    from SALib.sample import morris as morris_sample  # noqa: PLC0415  slow to import

    rows = morris_sample.sample(problem, trajectories, num_levels=levels, seed=np.random.default_rng([fixed, 0]))
    runs = Runs(evaluator, outcomes, batch=batch, total=len(rows), progress=progress)
    found = runs(variables.columns(0.01 + 0.98 * rows))
    results = tuple(
        _outcome_effects(problem, name, rows, values, levels, confidence, np.random.default_rng([fixed, 1, i]))
        for i, (name, values) in enumerate(found.items())
    )
    idle = tuple(name for i, name in enumerate(names) if all(one.effects[i].idle for one in results))
    return MorrisScreening(results, idle, runs.done, runs.failed, fixed)


def _outcome_effects(
    problem: Mapping[str, Any],
    outcome: str,
    rows: Floats,
    values: Floats,
    levels: int,
    confidence: float,
    rng: np.random.Generator,
) -> OutcomeEffects:
    names = problem["names"]
    d = len(names)
    each = values.reshape(-1, d + 1)
    kept = ~np.isnan(each).any(axis=1)
    whole = each[kept]
    size = len(whole)
    if size < 2:
        none = Estimate(np.nan, np.nan, np.nan, confidence)
        effects = tuple(Effect(name, np.nan, none, np.nan, idle=False) for name in names)
        return OutcomeEffects(outcome, effects, constant=False, trajectories=size, of_trajectories=len(each))
    paths = rows.reshape(-1, d + 1, d)[kept]
    from SALib.analyze import morris as morris_analysis  # noqa: PLC0415  slow to import

    found = morris_analysis.analyze(
        dict(problem), paths.reshape(-1, d), whole.ravel(), num_levels=levels, conf_level=confidence, seed=rng
    )
    moves = np.diff(paths, axis=1) != 0.0
    listed = []
    for i, name in enumerate(names):
        step = moves[:, :, i]
        idle = not _moved(whole[:, :-1][step], whole[:, 1:][step], whole)
        size_of = _estimate(found["mu_star"][i], found["mu_star_conf"][i], confidence)
        listed.append(Effect(name, float(found["mu"][i]), size_of, float(found["sigma"][i]), idle))
    return OutcomeEffects(outcome, tuple(listed), _alike(whole), size, len(each))


def _independent(variables: Variables) -> tuple[str, ...]:
    if variables.correlations:
        one, other = next(iter(variables.correlations))
        raise InvalidInput(
            f"correlation: got {one} with {other}; need independent parameters. Leave correlations out of a sensitivity study: "
            "shares of the variance do not add up with them."
        )
    return variables.names


def _alike(values: Floats) -> bool:
    return bool(np.ptp(values) <= _SAME * np.abs(values).max())


def _moved(before: Floats, after: Floats, values: Floats) -> bool:
    moved: NDArray[np.bool_] = np.abs(after - before) > _SAME * np.abs(values).max()
    return bool(moved.any())


def _estimate(value: float, half: float, confidence: float) -> Estimate:
    return Estimate(float(value), float(value - half), float(value + half), confidence)
