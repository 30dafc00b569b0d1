"""The best design for one goal: a global search by differential evolution, then a local polish.

A design that holds its requirements is better than any that does not; of those that do not, the one nearer to holding them is
better (Deb's rules). The population, if there is one, is evaluated for every design: robust and reliability-based design.

References:
    R. Storn, K. Price, Differential evolution, J. Glob. Optim. 11, 1997 (scipy's).
    K. Deb, An efficient constraint handling method for genetic algorithms, Comput. Methods Appl. Mech. Eng. 186, 2000.
    D. Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28, 1988 (scipy's SLSQP).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Seed, Sobol, seed_of
from ridedown.studies.analysis.evaluation import BATCH, Evaluator, Floats, Progress, check_count
from ridedown.studies.analysis.goals import Goal, Judge, Judged, Population, Requirement

_STEP = 1e-5  # of the range, for differences
_ROOM = 1e-10  # of a requirement's spread, that the polish keeps from it so as not to end outside by rounding
_SPREAD_LEFT = 1e-7


@dataclass(frozen=True, slots=True)
class Optimum:
    """The best design found.

    value: of the goal; requirements: the value of each requirement's measure, by its words. feasible: whether all hold.
    at_end: parameters at an end of their range, beyond which a better design may lie. polished: whether the local search
    bettered it.
    """

    parameters: Mapping[str, float]
    goal: str
    value: float
    requirements: Mapping[str, float]
    feasible: bool
    at_end: tuple[str, ...]
    polished: bool
    evaluations: int
    failed: int
    seed: int
    warnings: tuple[str, ...]


def optimise(
    evaluator: Evaluator,
    ranges: Mapping[str, tuple[float, float]],
    goal: Goal,
    *,
    requirements: Sequence[Requirement] = (),
    population: Population | None = None,
    candidates: int = 64,
    generations: int = 200,
    seed: Seed = None,
    batch: int = BATCH,
    progress: Progress | None = None,
) -> Optimum:
    """The design within the ranges (least, largest; SI) that has the least of a goal, or the most.

    candidates: designs of a generation; generations: at most. The search ends before where its candidates have come together.

    Raises: InvalidInput, UnknownName.

    >>> found = optimise(lambda t: {"y": (t["a"] - 0.3) ** 2 + t["b"]}, {"a": (0.0, 1.0), "b": (0.0, 1.0)}, Goal("y"), seed=0)
    >>> round(found.parameters["a"], 4), found.at_end
    (0.3, ('b',))
    """
    from scipy.optimize import Bounds, differential_evolution  # noqa: PLC0415  slow to import

    check_count(candidates, "candidates", 8)
    check_count(generations, "generations")
    fixed = seed_of(seed)
    total = candidates * (generations + 1)
    judge = Judge(evaluator, ranges, [goal], requirements, population, batch=batch, total=total, progress=progress)
    n = len(judge.names)
    start = Sobol(n, fixed).rows(0, candidates)
    order = _Order.of(judge(start))

    def merits(designs: Floats) -> Floats:
        return order.merit(judge(np.atleast_2d(designs.T)))

    try:
        found = differential_evolution(
            merits,  # type: ignore[arg-type]  # columns of designs to a column of merits, as vectorized asks
            Bounds(np.zeros(n), np.ones(n)),
            init=start,
            maxiter=generations,
            tol=_SPREAD_LEFT,
            atol=_SPREAD_LEFT,
            rng=np.random.default_rng(fixed),
            polish=False,
            updating="deferred",
            vectorized=True,
        )
    except RuntimeError as error:
        if isinstance(error.__cause__, InvalidInput):  # scipy takes it for a mistake in how it was called
            raise error.__cause__ from None
        raise
    best, merit = np.clip(np.asarray(found.x), 0.0, 1.0), float(found.fun)
    by_slope = _by_slope(judge, order, best) if merit < _Order.INFEASIBLE else best
    polished, better = _by_compass(judge, order, by_slope, best)
    return _optimum(judge, polished, better < merit, fixed)


@dataclass(frozen=True, slots=True, eq=False)
class _Order:
    """One number to order designs by: of those that hold their requirements in (-1, 1), of the others in (2, 3), of failed 4.

    The scales come from the first generation, so that the number has its digits where the outcomes are.
    """

    INFEASIBLE = 1.5

    middle: float
    scale: float
    spreads: Floats

    @classmethod
    def of(cls, first: Judged) -> _Order:
        good = ~first.failed
        if not good.any():
            return cls(0.0, 1.0, np.ones(first.excess.shape[1]))
        goals, excess = first.goals[good, 0], first.excess[good]
        spreads = np.abs(excess).mean(axis=0)
        scale = float(np.abs(goals - np.median(goals)).mean())
        return cls(float(np.median(goals)), scale or 1.0, np.where(spreads > 0.0, spreads, 1.0))

    def merit(self, judged: Judged) -> Floats:
        over = (np.maximum(np.where(judged.failed[:, None], 0.0, judged.excess), 0.0) / self.spreads).sum(axis=1)
        y = np.where(judged.failed, 0.0, judged.goals[:, 0] - self.middle) / self.scale
        merit = np.where(judged.feasible, y / (1.0 + np.abs(y)), 2.0 + over / (1.0 + over))
        return np.where(judged.failed, 4.0, merit)


def _by_slope(judge: Judge, order: _Order, start: Floats) -> Floats:
    """Sequential quadratic programming, all differences of a step in one batch."""
    from scipy.optimize import minimize  # noqa: PLC0415  slow to import

    n, count = start.size, len(judge.requirements)
    seen: dict[bytes, tuple[float, Floats, Floats, Floats]] = {}

    def at(x: Floats) -> tuple[float, Floats, Floats, Floats]:
        key = x.tobytes()
        if key not in seen:
            ends = np.concatenate([np.minimum(x + _STEP * np.eye(n), 1.0), np.maximum(x - _STEP * np.eye(n), 0.0)])
            judged = judge(np.concatenate([x[None], ends]))
            y = np.concatenate([judged.goals - order.middle, judged.excess], axis=1) / np.concatenate(
                [[order.scale], order.spreads]
            )
            y = np.where(np.isfinite(y), y, 1e3)
            widths = np.diagonal(ends[:n] - ends[n:])
            slopes = (y[1 : n + 1] - y[n + 1 :]) / widths[:, None]
            seen[key] = float(y[0, 0]), slopes[:, 0], y[0, 1:], slopes[:, 1:].T
        return seen[key]

    constraints = {"type": "ineq", "fun": lambda x: -at(x)[2] - _ROOM, "jac": lambda x: -at(x)[3]}
    found = minimize(  # type: ignore[call-overload]
        lambda x: at(np.clip(x, 0.0, 1.0))[0],
        start,
        jac=lambda x: at(np.clip(x, 0.0, 1.0))[1].copy(),  # scipy overwrites what it is given
        bounds=[(0.0, 1.0)] * n,
        constraints=[constraints] if count else (),
        method="SLSQP",
        options={"maxiter": 60, "ftol": 1e-12},
    )
    best: Floats = np.clip(np.asarray(found.x), 0.0, 1.0)
    return best


def _by_compass(judge: Judge, order: _Order, *starts: Floats) -> tuple[Floats, float]:
    """The best of the starts, moved along the axes by steps that halve: for kinks, where slopes mislead."""
    merits = order.merit(judge(np.array(starts)))
    x, best = starts[int(np.argmin(merits))], float(merits.min())
    n, step = x.size, 1e-2
    while step > 1e-8:
        tries = np.clip(np.concatenate([x + step * np.eye(n), x - step * np.eye(n)]), 0.0, 1.0)
        merits = order.merit(judge(tries))
        if merits.min() < best:
            x, best = tries[int(np.argmin(merits))], float(merits.min())
        else:
            step *= 0.5
    return x, best


def _optimum(judge: Judge, unit: Floats, polished: bool, seed: int) -> Optimum:  # noqa: FBT001
    judged = judge(unit[None])
    goal = judge.goals[0]
    values = judge.values(unit[None])[0]
    at_end = tuple(name for name, u in zip(judge.names, unit, strict=True) if min(u, 1.0 - u) < 1e-6)
    feasible = bool(judged.feasible[0])
    warnings = []
    if not feasible:
        warnings.append("No design was found that holds all requirements; this one comes nearest.")
    if judge.runs.failed:
        warnings.append(f"{judge.runs.failed} of {judge.runs.done} rows failed; designs with a failed row were not chosen.")
    return Optimum(
        dict(zip(judge.names, map(float, values), strict=True)),
        goal.words,
        float(goal.sign * judged.goals[0, 0]),
        {one.words: float(one.sign * judged.excess[0, i] + one.limit.bound) for i, one in enumerate(judge.requirements)},
        feasible,
        at_end,
        polished,
        judge.runs.done,
        judge.runs.failed,
        seed,
        tuple(warnings),
    )
