"""Several goals at once: the designs of which none is better in one goal without being worse in another (Pareto front).

NSGA-II for two goals, NSGA-III for more, through pymoo.

References:
    K. Deb et al., A fast and elitist multiobjective genetic algorithm: NSGA-II, IEEE Trans. Evol. Comput. 6, 2002.
    K. Deb, H. Jain, An evolutionary many-objective optimization algorithm (NSGA-III), IEEE Trans. Evol. Comput. 18, 2014.
    I. Das, On characterizing the knee of the Pareto curve based on normal-boundary intersection, Struct. Optim. 18, 1999.
    E. Zitzler, L. Thiele, Multiobjective evolutionary algorithms, IEEE Trans. Evol. Comput. 3, 1999 (hypervolume).
    J. Blank, K. Deb, pymoo: multi-objective optimization in Python, IEEE Access 8, 2020.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import comb
from typing import Any, Literal

import numpy as np
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.algorithms.moo.nsga3 import NSGA3
from pymoo.core.problem import Problem
from pymoo.indicators.hv import HV
from pymoo.optimize import minimize
from pymoo.util.ref_dirs import get_reference_directions

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Seed, Sobol, seed_of
from ridedown.studies.analysis.evaluation import BATCH, Evaluator, Floats, Progress, check_count
from ridedown.studies.analysis.goals import Goal, Judge, Population, Requirement

Algorithm = Literal["nsga2", "nsga3"]

_FLAT = 1e-6
"""By what part of the front's size a knee is at least out of the plane: less is rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Front:
    """A Pareto front, by rising first goal.

    parameters: a column (R,) each; goals: their words and values, (R, k); requirements: the values of their measures, (R, q).
    knee: the row that bulges the most out of the plane through the front's corners; None where none does. hypervolume: what the
    front dominates of the space up to `reference` (k,), in the goals' units. feasible: whether any design held all
    requirements; where none did, the front is empty.
    """

    parameters: Mapping[str, Floats]
    goals: Mapping[str, Floats]
    requirements: Mapping[str, Floats]
    knee: int | None
    hypervolume: float
    reference: tuple[float, ...]
    feasible: bool
    algorithm: str
    evaluations: int
    failed: int
    seed: int
    warnings: tuple[str, ...]

    @property
    def size(self) -> int:
        """Number of designs on the front."""
        return len(next(iter(self.parameters.values())))


class _Designs(Problem):  # type: ignore[misc]
    """The designs as pymoo asks for them: a failed one is worse than any seen, and breaks a requirement of its own."""

    def __init__(self, judge: Judge) -> None:
        super().__init__(
            n_var=len(judge.names), n_obj=len(judge.goals), n_ieq_constr=len(judge.requirements) + 1, xl=0.0, xu=1.0
        )
        self._judge = judge
        self._worst = np.zeros(len(judge.goals))

    def _evaluate(self, x: Floats, out: dict[str, Any], *_: Any, **__: Any) -> None:
        judged = self._judge(np.atleast_2d(x))
        good = ~judged.failed
        if good.any():
            self._worst = np.maximum(self._worst, judged.goals[good].max(axis=0))
        bounds = np.array([abs(one.limit.bound) or 1.0 for one in self._judge.requirements])
        excess = np.where(judged.failed[:, None], 1e3, judged.excess / bounds)
        out["F"] = np.where(judged.failed[:, None], self._worst, judged.goals)
        out["G"] = np.concatenate([excess, np.where(judged.failed, 1e3, -1.0)[:, None]], axis=1)


def pareto(
    evaluator: Evaluator,
    ranges: Mapping[str, tuple[float, float]],
    goals: Sequence[Goal],
    *,
    requirements: Sequence[Requirement] = (),
    population: Population | None = None,
    algorithm: Algorithm | None = None,
    candidates: int = 100,
    generations: int = 100,
    reference: Sequence[float] | None = None,
    seed: Seed = None,
    batch: int = BATCH,
    progress: Progress | None = None,
) -> Front:
    """The Pareto front of two goals or more within the ranges (least, largest; SI).

    reference: the point that the hypervolume reaches to, in the goals' order; a tenth beyond the front if left out, and then
    not to be compared between runs.

    Raises: InvalidInput, UnknownName.

    >>> ranges = {"a": (0.0, 1.0), "b": (0.0, 1.0)}
    >>> two = [Goal("one"), Goal("other")]
    >>> front = pareto(lambda t: {"one": t["a"], "other": 1.0 - t["a"] + t["b"]}, ranges, two, seed=0, generations=60)
    >>> bool(front.parameters["b"].max() < 0.01)
    True
    """
    if len(goals) < 2:
        raise InvalidInput(f"goals: got {len(goals)}; need two or more. For one, use optimise.")
    check_count(candidates, "candidates", 8)
    check_count(generations, "generations")
    if algorithm not in {None, "nsga2", "nsga3"}:
        raise InvalidInput(f"algorithm: got {algorithm!r}; need nsga2 or nsga3. Leave it out for the one that suits.")
    if reference is not None and len(reference) != len(goals):
        raise InvalidInput(f"reference: got {len(reference)} numbers; need {len(goals)}, one for each goal.")
    fixed = seed_of(seed)
    total = candidates * generations
    judge = Judge(evaluator, ranges, goals, requirements, population, batch=batch, total=total, progress=progress)
    chosen = algorithm or ("nsga2" if len(goals) == 2 else "nsga3")
    start = Sobol(len(judge.names), fixed).rows(0, candidates)
    method = NSGA2(pop_size=candidates, sampling=start) if chosen == "nsga2" else _nsga3(len(goals), candidates, start)
    found = minimize(_Designs(judge), method, ("n_gen", generations), seed=fixed, verbose=False)
    unit = np.empty((0, len(judge.names))) if found.X is None else np.atleast_2d(found.X)
    return _front(judge, unit, reference, chosen, fixed)


def _nsga3(goals: int, candidates: int, start: Floats) -> NSGA3:
    """NSGA-III with as many directions as there are candidates, or a little fewer."""
    parts = 1
    while comb(goals + parts, parts + 1) <= candidates:
        parts += 1
    return NSGA3(get_reference_directions("das-dennis", goals, n_partitions=parts), pop_size=candidates, sampling=start)


def _front(judge: Judge, unit: Floats, reference: Sequence[float] | None, algorithm: str, seed: int) -> Front:
    signs = np.array([goal.sign for goal in judge.goals])
    if len(unit):
        judged = judge(unit)
        kept = np.flatnonzero(judged.feasible)
        kept = kept[_undominated(judged.goals[kept])]
        kept = kept[np.lexsort(judged.goals[kept].T[::-1])]
        unit, bad, excess = unit[kept], judged.goals[kept], judged.excess[kept]
    else:
        bad, excess = np.empty((0, len(judge.goals))), np.empty((0, len(judge.requirements)))
    values = judge.values(unit)
    knee, volume = None, 0.0
    point = np.full(len(judge.goals), np.nan) if reference is None else signs * np.asarray(reference, dtype=np.float64)
    warnings = []
    if len(unit):
        least, most = bad.min(axis=0), bad.max(axis=0)
        if reference is None:
            point = most + 0.1 * np.where(most > least, most - least, 1.0)
        knee = knee_of(bad)
        if knee is None:
            warnings.append("The front has no knee: nowhere does it bulge to the better side. Choose a design along it.")
        volume = float(HV(ref_point=point)(bad))
    else:
        warnings.append("No design was found that holds all requirements.")
    if judge.runs.failed:
        warnings.append(f"{judge.runs.failed} of {judge.runs.done} rows failed; designs with a failed row were not chosen.")
    return Front(
        {name: values[:, i] for i, name in enumerate(judge.names)},
        {goal.words: signs[i] * bad[:, i] for i, goal in enumerate(judge.goals)},
        {one.words: one.sign * excess[:, i] + one.limit.bound for i, one in enumerate(judge.requirements)},
        knee,
        volume,
        tuple(map(float, signs * point)),
        bool(len(unit)),
        algorithm,
        judge.runs.done,
        judge.runs.failed,
        seed,
        tuple(warnings),
    )


def knee_of(bad: Floats) -> int | None:
    """The row of a front (R, k), smaller being better, that bulges the most out of the plane through its corners.

    None where no row does: a front that is straight, or bulges to the worse side, has no knee, and its ends are none. A front
    of one design is its own knee.

    >>> knee_of(np.array([[0.0, 1.0], [0.2, 0.2], [1.0, 0.0]]))
    1
    >>> knee_of(np.array([[0.0, 1.0], [0.8, 0.8], [1.0, 0.0]])) is None
    True
    """
    if len(bad) == 1:
        return 0
    least, most = bad.min(axis=0), bad.max(axis=0)
    scaled = (bad - least) / np.where(most > least, most - least, 1.0)
    levels = scaled @ _normal(scaled)
    row = int(np.argmin(levels))
    return row if levels[row] < 1.0 - _FLAT else None


def _normal(scaled: Floats) -> Floats:
    """Of the plane normal @ x = 1 through a front's corners: for each goal the design that gives way in it the most alone.

    Where corners coincide, or the plane leans over, it falls in all goals alike, and goes through the nearest of those designs
    that are the best in a goal.
    """
    others = [np.delete(scaled, goal, axis=1).max(axis=1) for goal in range(scaled.shape[1])]
    corners = scaled[[int(np.argmin(other)) for other in others]]
    with suppress(np.linalg.LinAlgError):
        normal = np.asarray(np.linalg.solve(corners, np.ones(len(corners))), dtype=np.float64)
        if (normal > 0.0).all():
            return normal
    return np.full(len(corners), 1.0 / scaled[np.argmin(scaled, axis=0)].sum(axis=1).min())


def _undominated(bad: Floats) -> Floats:
    """Which rows no other is better than; of equal rows the first."""
    better = (bad[:, None, :] <= bad[None, :, :]).all(axis=2) & (bad[:, None, :] < bad[None, :, :]).any(axis=2)
    equal = np.tril((bad[:, None, :] == bad[None, :, :]).all(axis=2), -1).any(axis=1)
    return np.asarray(~better.any(axis=0) & ~equal)
