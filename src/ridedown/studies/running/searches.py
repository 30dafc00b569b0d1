"""Studies that search: the best design, a solution box, rare events. Over an evaluator, as plain data for JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput, UnknownName
from ridedown.studies.analysis.box import solution_box
from ridedown.studies.analysis.evaluation import Evaluator, Limit
from ridedown.studies.analysis.goals import (
    Beyond,
    Goal,
    Judge,
    Mean,
    MeanPlus,
    Measure,
    Population,
    QuantileOf,
    Requirement,
    Worst,
)
from ridedown.studies.analysis.importance import rare_event
from ridedown.studies.analysis.optimise import optimise
from ridedown.studies.file.limits import bounds_of, limits_of, value_of
from ridedown.studies.file.options import Measured, OptimiseOptions
from ridedown.studies.file.parameters import Floats, Varied
from ridedown.studies.file.study import LoadedStudy, Study
from ridedown.studies.rows.plan import Plan, parameters_of, variables_of


def check_search(loaded: LoadedStudy, plan: Plan) -> None:
    """Have what is wrong with a search said before its first row. Raises: InvalidInput, UnknownName."""
    if loaded.study.optimise is not None:
        _goals(loaded.study.optimise, plan.function.units)
    limits_of(loaded.study, plan.function.units)


def found_by_search(loaded: LoadedStudy, plan: Plan, evaluator: Evaluator) -> dict[str, Any]:
    """What a search finds over an evaluator, as plain data.

    Of an optimisation: `chosen`, the design, and of several objectives the `front`; of a box `box`; of rare events
    `limits` with their probabilities.
    """
    study = loaded.study
    if study.optimise is not None:
        return _optimised(loaded, study.optimise, plan, evaluator)
    if study.box is not None:
        return _boxed(loaded, plan, evaluator)
    return _rare(study, plan, evaluator, parameters_of(loaded))


@dataclass(frozen=True, slots=True, eq=False)
class Tried:
    """The designs that an optimisation tried, in order: parameters, (D,) each, what its first objective comes to, (D,).

    held: which of them hold all constraints, (D,). rows: of each design, its population.
    """

    parameters: Mapping[str, Floats]
    goal: Floats
    held: NDArray[np.bool_]
    rows: int


def designs_tried(loaded: LoadedStudy, units: Mapping[str, str], columns: Mapping[str, Floats]) -> Tried:
    """What an optimisation made of the rows that it kept: all its columns, in order, with the units of the outcomes.

    Raises: InvalidInput, UnknownName for a study that does not fit.
    """
    options = loaded.study.optimise
    assert options is not None
    goals, requirements = _goals(options, units)
    parameters = parameters_of(loaded)
    ranges, population = _ranges(loaded.study, parameters), _population(loaded.study, options, parameters)
    size = population.arrays()[2].size
    designs = {name: columns[name][::size] for name in ranges}

    def kept(asked: Mapping[str, Floats]) -> Mapping[str, Floats]:
        assert next(iter(asked.values())).size == next(iter(columns.values())).size
        return columns

    count = next(iter(designs.values())).size
    judge = Judge(kept, ranges, goals, requirements, population, batch=max(count * size, 1))
    unit = np.stack([(designs[name] - low) / (high - low) for name, (low, high) in ranges.items()], axis=1)
    judged = judge(unit)
    return Tried(designs, goals[0].sign * judged.goals[:, 0], judged.feasible, size)


def _optimised(loaded: LoadedStudy, options: OptimiseOptions, plan: Plan, evaluator: Evaluator) -> dict[str, Any]:
    goals, requirements = _goals(options, plan.function.units)
    parameters = parameters_of(loaded)
    ranges, population = _ranges(loaded.study, parameters), _population(loaded.study, options, parameters)
    candidates, generations = options.designs
    said: dict[str, Any] = {
        "kind": "optimise",
        "limits": [],
        "objectives": [
            {"words": one.words, "outcome": one.outcome, "unit": _unit(one, plan), "sense": "max" if one.maximise else "min"}
            for one in goals
        ],
        "constraints": [
            {"words": one.words, "of": one.measure.words(one.outcome), "outcome": one.outcome, "unit": _unit(one, plan)}
            | {"most": one.most, "least": one.least, "beyond": _beyond(one)}
            for one in requirements
        ],
        "ranges": {name: list(ends) for name, ends in ranges.items()},
        "population": {name: np.ravel(column).tolist() for name, column in population.columns.items()},
    }
    if len(goals) == 1:
        best = optimise(
            evaluator,
            ranges,
            goals[0],
            requirements=requirements,
            population=population,
            candidates=candidates,
            generations=generations,
            seed=options.seed,
        )
        chosen = {
            "parameters": dict(best.parameters),
            "objectives": {best.goal: best.value},
            "constraints": dict(best.requirements),
            "feasible": best.feasible,
        }
        tail = {"at_end": list(best.at_end), "polished": best.polished, "front": None}
        return {**said, "method": "differential-evolution", "chosen": chosen, **tail, **_cost(best)}
    from ridedown.studies.analysis.pareto import pareto  # noqa: PLC0415  pymoo takes a second to load

    front = pareto(
        evaluator,
        ranges,
        goals,
        requirements=requirements,
        population=population,
        algorithm=options.algorithm,
        candidates=candidates,
        generations=generations,
        reference=options.reference,
        seed=options.seed,
    )
    columns = {"parameters": front.parameters, "objectives": front.goals, "constraints": front.requirements}
    knee = front.knee
    said |= {
        "method": front.algorithm,
        "chosen": None
        if knee is None
        else {
            **{key: {name: float(column[knee]) for name, column in of.items()} for key, of in columns.items()},
            "feasible": True,
        },
        "front": {
            **{key: {name: column.tolist() for name, column in of.items()} for key, of in columns.items()},
            "chosen": knee,
            "hypervolume": front.hypervolume,
            "reference": list(front.reference),
        },
    }
    return {**said, **_cost(front)}


def _boxed(loaded: LoadedStudy, plan: Plan, evaluator: Evaluator) -> dict[str, Any]:
    options = loaded.study.box
    assert options is not None
    limits = limits_of(loaded.study, plan.function.units)
    ranges = _ranges(loaded.study, parameters_of(loaded))
    found = solution_box(
        evaluator,
        ranges,
        limits,
        size=options.size,
        bad_share=options.bad_share,
        confidence=options.confidence,
        rows=options.rows,
        rounds=options.rounds,
        seed=options.seed,
    )
    box = {name: list(ends) for name, ends in found.ranges.items()}
    said = {key: value for key, value in asdict(found).items() if key not in {"ranges", *_cost(found)}}
    rules = [_rule(one) for one in limits]
    ends = {name: list(one) for name, one in ranges.items()}
    return {"kind": "box", "limits": rules, "ranges": ends, "box": {"ranges": box, **said}, **_cost(found)}


def _rare(study: Study, plan: Plan, evaluator: Evaluator, parameters: tuple[Varied, ...]) -> dict[str, Any]:
    options = study.sample
    assert options is not None
    variables = variables_of(study, parameters)
    found: list[dict[str, Any]] = []
    for limit in limits_of(study, plan.function.units):
        event = rare_event(
            evaluator,
            variables,
            limit,
            rows=options.rows,
            level_rows=options.level_rows,
            components=options.components,
            confidence=options.confidence,
            seed=options.seed,
        )
        said = {key: value for key, value in asdict(event).items() if key not in {"limit", "seed"}}
        found.append({**_rule(limit), **said, "beta": event.beta, "warnings": list(event.warnings)})
    return {"kind": "sample", "rare": True, "limits": found, "seed": options.seed, "confidence": options.confidence}


def _rule(limit: Limit) -> dict[str, Any]:
    return {"outcome": limit.outcome, "most": limit.most, "least": limit.least, "rule": limit.rule}


def _cost(found: Any) -> dict[str, Any]:
    """What a search took, and what it warns of."""
    took = {key: getattr(found, key) for key in ("evaluations", "failed", "seed")}
    return {**took, "warnings": list(found.warnings)}


def _ranges(study: Study, parameters: tuple[Varied, ...]) -> dict[str, tuple[float, float]]:
    ends: dict[str, tuple[float, float]] = {}
    for given, one in zip(study.parameters, parameters, strict=False):  # those of the population come after
        if given.range is not None:
            low, high = one.distribution.ppf(np.array([0.0, 1.0]))
            ends[one.name] = float(low), float(high)
    return ends


def _population(study: Study, options: OptimiseOptions, parameters: tuple[Varied, ...]) -> Population:
    if study.population:
        members: dict[str, Floats] = {
            one.name: one.levels for one in parameters[len(study.parameters) :] if one.levels is not None
        }
        return Population(members, weights=[member.weight for member in study.population])
    drawn = tuple(one for given, one in zip(study.parameters, parameters, strict=True) if given.range is None)
    if not drawn:
        return Population()
    return Population.drawn(variables_of(study, drawn), options.population_rows, seed=options.seed)


def _goals(options: OptimiseOptions, units: Mapping[str, str]) -> tuple[list[Goal], list[Requirement]]:
    """Objectives and constraints in SI. Raises: InvalidInput, UnknownName."""
    goals = []
    for i, one in enumerate(options.objectives):
        name, measure = _measured(f"optimise.objectives.{i}", one, units)
        goals.append(Goal(name, measure, maximise=one.sense == "max"))
    requirements = []
    for i, constraint in enumerate(options.constraints):
        where = f"optimise.constraints.{i}"
        name, measure = _measured(where, constraint, units)
        unit = "" if isinstance(measure, Beyond) else units[name]
        for side, bound in bounds_of(where, constraint, unit).items():
            if isinstance(measure, Beyond) and not 0.0 <= bound <= 1.0:
                raise InvalidInput(f"{where}.{side}: got {bound:g}; need a share from 0 to 1. It bounds the probability.")
            requirements.append(Requirement(name, measure=measure, **{side: bound}))
    for words, where in (([one.words for one in goals], "objectives"), ([one.words for one in requirements], "constraints")):
        twice = next((word for word in words if words.count(word) > 1), None)
        if twice is not None:
            raise InvalidInput(f"optimise.{where}: got {twice} twice; need each once. Take one out.")
    return goals, requirements


def _measured(where: str, given: Measured, units: Mapping[str, str]) -> tuple[str, Measure]:
    names = [name for name in units if name == given.outcome]
    names = names or [name for name in units if name.partition(".")[2] == given.outcome]
    if not names:
        raise UnknownName.among(f"{where}.outcome", given.outcome, units)
    if len(names) > 1:
        raise InvalidInput(
            f"{where}.outcome: got {given.outcome}, which {len(names)} scenarios have; need one of {', '.join(names)}, or "
            f"weighted.{given.outcome}."
        )
    sides = {"most": given.above, "least": given.below}
    beyond = {
        side: value_of(f"{where}.{'above' if side == 'most' else 'below'}", value, units[names[0]])
        for side, value in sides.items()
        if value is not None
    }
    measures: dict[str, Measure] = {"mean": Mean(), "worst": Worst()}
    if given.sigmas is not None:
        measures["mean-plus"] = MeanPlus(given.sigmas)
    if given.share is not None:
        measures["quantile"] = QuantileOf(given.share)
    if beyond:
        measures["probability"] = Beyond(**beyond)
    return names[0], measures[given.measure]


def _beyond(one: Requirement) -> dict[str, float | None] | None:
    """The values of the outcome, SI, that a share is beyond; none of another measure."""
    return {"most": one.measure.most, "least": one.measure.least} if isinstance(one.measure, Beyond) else None


def _unit(one: Goal | Requirement, plan: Plan) -> str:
    return "" if isinstance(one.measure, Beyond) else plan.function.units[one.outcome]
