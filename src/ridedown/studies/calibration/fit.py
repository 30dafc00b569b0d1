"""Calibration: global search, least squares, covariance, bands, warnings."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.criteria.rating import rating
from ridedown.errors import InvalidInput
from ridedown.scenario import Scenario, Source, lower
from ridedown.studies.analysis.cma_es import Effort, runs
from ridedown.studies.calibration.file import Calibration, Search, load_calibration
from ridedown.studies.calibration.fitted import Beyond, Calibrated, FittedChannel, FittedNumber, FittedParameter
from ridedown.studies.calibration.identifiability import Candidate, confounded
from ridedown.studies.calibration.least_squares import STEP, jacobian, least_squares
from ridedown.studies.calibration.likelihood import Likelihood
from ridedown.studies.calibration.posterior import Posterior, sample
from ridedown.studies.calibration.problem import EXPECTED_MISFIT, Problem, ResolvedCase, known_channels
from ridedown.studies.calibration.sampling import Samples
from ridedown.studies.calibration.targets import ChannelTarget, NumberTarget
from ridedown.studies.calibration.uncertainty import Block, Uncertainty, uncertainty
from ridedown.studies.calibration.unknowns import Unknown, points_of, values_of
from ridedown.studies.calibration.wording import in_case, in_words

Floats = NDArray[np.float64]
Progress = Callable[[str, int, float], None]
"""Told what is being done, how many candidates were tried in all, and the least misfit so far."""

EFFORTS = {
    "quick": Effort(restarts=2, sample=128, population=12, generations=30, patience=10),
    "normal": Effort(restarts=4, sample=256, population=24, generations=60, patience=15),
    "thorough": Effort(restarts=8, sample=1024, population=64, generations=200, patience=30),
}
"""What the file's words stand for."""

_SAME = 1.01  # misfits this near each other are taken for the same place
_MEASURABLE = ("acceleration", "force", "excursion", "relative_displacement", "displacement", "deflection")
_WIDER = 2.0  # so many times as far as its band: what says another thing than it
_MOST_LIKELY = 2000  # candidates of the search that are looked at again
_CANDIDATE_STEPS = 60  # samples of a channel that could be measured, as many independent values


def calibrate(
    source: str | os.PathLike[str] | Mapping[str, Any] | Calibration, *, progress: Progress | None = None
) -> Calibrated:
    """Find the parameters of a calibration (see docs/calibration.md) that follow its tests best, and how sure they are.

    source: a TOML or YAML file, or a mapping of the same shape. progress: told of every batch of candidates. A keyboard
    interrupt ends the search: what comes back is then the best so far, and says `interrupted`.

    >>> found = calibrate({
    ...     "cases": [{"scenario": "neon-wall", "targets": [
    ...         {"outcome": "vehicle1.right.deflection.max", "value": "700 mm", "sigma": "10 mm"}]}],
    ...     "parameters": [{"name": "force", "factor": True, "bounds": [0.5, 2], "paths": ["vehicle1.members.points.*.1"]}],
    ...     "search": {"effort": "quick"},
    ... })
    >>> round(found.values["force"], 2), found.numbers[0].met
    (1.09, True)

    Raises: InvalidInput and UnknownName for anything wrong in the file; InvalidInput where no candidate can be crashed.
    """
    calibration, folder = load_calibration(source)
    problem = Problem.of(calibration, folder)
    if progress is not None:
        problem.on_try = lambda: progress("searching", problem.tried, problem.best_value)
    point, starts, interrupted = _search(problem, effort_of(calibration.search), calibration.search.seed)
    if progress is not None:
        progress("bands", problem.tried, problem.best_value)
    problem.on_try = lambda: None
    found = _judged(problem, point)
    posterior = None
    if calibration.posterior and not interrupted:
        posterior = sample(problem, point, found.uncertainty, calibration.search.seed, progress)
    return _result(problem, point, found, starts=starts, interrupted=interrupted, posterior=posterior)


def effort_of(search: Search) -> Effort:
    """How hard a file asks to search."""
    base = EFFORTS[search.effort]
    fields = ("restarts", "sample", "population", "generations", "patience")
    return Effort(**{f: getattr(base, f) if getattr(search, f) is None else getattr(search, f) for f in fields})


def _search(problem: Problem, effort: Effort, seed: int) -> tuple[Floats, tuple[int, int], bool]:
    """The best point, how many searches were made and ended there, and whether the user stopped them.

    A search that ends where an earlier one did is the last: two that agree from random starts are taken for enough.
    """
    ends: list[tuple[float, Floats]] = []
    interrupted = False
    try:
        for run in runs(problem.misfit, len(problem.unknowns), effort, np.random.default_rng(seed)):
            if not np.isfinite(run.value):
                continue
            point, value = least_squares(problem.residuals, run.best)
            ends.append((value, point) if value <= run.value else (run.value, run.best))
            if _agreeing(ends) >= 2:
                break
    except KeyboardInterrupt:
        interrupted = True
    if problem.best is None:
        raise InvalidInput(
            "parameters: got bounds within which no crash could be solved to its end; need some that can be. "
            f"Check the bounds, or search harder.{_refused_in_the_middle(problem)}"
        )
    if interrupted or not ends:
        return problem.best, (len(ends), _agreeing(ends)), interrupted
    _, point = min(ends, key=lambda end: end[0])
    return point, (len(ends), _agreeing(ends)), interrupted


def _refused_in_the_middle(problem: Problem) -> str:
    """The rule that the middle of the bounds breaks, in words, if it breaks one."""
    for case in problem.cases:
        try:
            case.with_values(values_of(problem.unknowns, np.full(len(problem.unknowns), 0.5)))
        except InvalidInput as refused:
            return f" In their middle, {case.name}: {refused}"
    return ""


def _agreeing(ends: Sequence[tuple[float, Floats]]) -> int:
    """How many searches ended with the least misfit."""
    least = min((value for value, _ in ends), default=np.inf)
    return sum(value <= _SAME * least + 1e-9 for value, _ in ends)


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A target of a case at the best point: values and derivatives, SI and by the unit cube's coordinates."""

    case: ResolvedCase
    target: ChannelTarget | NumberTarget
    value: Floats  # (T,) of a channel, (1,) of a number
    slope: Floats  # (T or 1, n)


@dataclass(frozen=True, slots=True, eq=False)
class _Judged:
    parts: tuple[_Part, ...]
    blocks: tuple[Block, ...]
    uncertainty: Uncertainty
    candidates: tuple[Candidate, ...]


def _judged(problem: Problem, point: Floats) -> _Judged:
    """Values, derivatives and covariance at the best point."""
    parts: list[_Part] = []
    candidates: list[Candidate] = []
    for case in (*problem.cases, *problem.predictions):
        other = _measurable(case) if case.fitted else ()
        value, slope = _values_and_slopes(problem, case, point, (*case.channels, *other))
        at = 0
        targets: tuple[ChannelTarget | NumberTarget, ...] = (*case.channels, *case.numbers, *other)
        for target in targets:
            rows = target.samples.times.size if isinstance(target, ChannelTarget) else 1
            part = _Part(case, target, value[at : at + rows], slope[at : at + rows])
            at += rows
            if isinstance(target, ChannelTarget) and target in other:
                scale = EXPECTED_MISFIT * float(np.abs(part.value).max())
                if scale > 0.0:
                    candidates.append(Candidate(case.name, target.name, part.slope / scale))
            else:
                parts.append(part)
    blocks = (*(block for part in parts if (block := _block(part)) is not None), *_prior_blocks(problem, point))
    return _Judged(tuple(parts), blocks, uncertainty(blocks, point.size), tuple(candidates))


def _values_and_slopes(
    problem: Problem, case: ResolvedCase, point: Floats, curves: Sequence[ChannelTarget]
) -> tuple[Floats, Floats]:
    """Channels and outcomes of a case in a row: their values (m,) and derivatives (m, n)."""

    def all_of(points: Floats) -> Floats:
        found = case.evaluate(values_of(problem.unknowns, points), curves)
        given = [found.channels[c.name] for c in curves[: len(case.channels)]]
        given += [found.outcomes[target.name][:, None] for target in case.numbers]
        given += [found.channels[c.name] for c in curves[len(case.channels) :]]
        return np.concatenate(given, axis=1)

    return all_of(point[None])[0], jacobian(all_of, point, STEP)


def _block(part: _Part) -> Block | None:
    """A target as part of the residuals; None for one that says nothing of the parameters: a limit, a prediction."""
    case, target = part.case, part.target
    if not case.fitted:
        return None
    weight = case.weight * target.weight
    if isinstance(target, ChannelTarget):
        assert target.measured is not None, "checked when the file was read"
        thin = target.thinning
        scale = target.scale / np.sqrt(weight * thin)
        return Block(part.slope[::thin] / scale, channel=(part.value - target.measured)[::thin] / scale)
    if target.value is None:
        return None
    return Block(part.slope * np.sqrt(weight) / target.deviation, variance=weight)


def _prior_blocks(problem: Problem, point: Floats) -> list[Block]:
    def scaled(points: Floats) -> Floats:
        values = values_of(problem.unknowns, points)
        return np.stack([values[:, i] / u.prior[1] for i, u in known], axis=1)  # type: ignore[index]

    known = [(i, u) for i, u in enumerate(problem.unknowns) if u.prior is not None]
    return [Block(jacobian(scaled, point))] if known else []


def _measurable(case: ResolvedCase) -> tuple[ChannelTarget, ...]:
    """The channels of a case that could be measured as well."""
    network = lower(case.scenario)
    duration = float(network.duration.max())
    end = max([target.samples.times[-1] for target in case.channels], default=duration)
    taken = {target.name for target in case.channels}
    return tuple(
        ChannelTarget(
            name,
            channel.unit,
            Samples.over(channel, 0.0, end, end / _CANDIDATE_STEPS, None, duration),
            None,
            np.nan,
            1.0,
            np.nan,
        )
        for name, channel in known_channels(case.scenario, network).items()
        if name not in taken and name.rsplit(".", 1)[-1] in _MEASURABLE
    )


def _result(
    problem: Problem, point: Floats, judged: _Judged, *, starts: tuple[int, int], interrupted: bool, posterior: Posterior | None
) -> Calibrated:
    found = judged.uncertainty
    values = values_of(problem.unknowns, point)
    parameters = _parameters(problem.unknowns, point, found)
    scatter = _scatter(judged.parts)
    fisher = sum((block.slope.T @ block.slope for block in judged.blocks), np.zeros((point.size, point.size)))
    several = len(problem.cases) > 1
    apart = confounded(problem.unknowns, point, fisher, found, judged.candidates, several=several)
    numbers = tuple(_number(p, p.target, found) for p in judged.parts if isinstance(p.target, NumberTarget))
    beyond = _farther(problem, point, found) if posterior is None else _wider(parameters, posterior)
    warnings = (
        *_warnings(parameters, starts, interrupted=interrupted),
        *_not_met(numbers, several=several),
        *(() if beyond is None else (beyond.sentence,)),
    )
    return Calibrated(
        calibration=problem.calibration,
        parameters=parameters,
        channels=tuple(_channel(p, p.target, found, scatter) for p in judged.parts if isinstance(p.target, ChannelTarget)),
        numbers=numbers,
        misfit=float(problem.misfit(point[None])[0]),
        freedom=found.freedom,
        covariance=found.covariance,
        correlation=found.correlation,
        confounded=apart,
        warnings=(*warnings, *(one.sentence for one in apart)),
        scenarios={case.name: _signed(case.with_values(values), problem) for case in (*problem.cases, *problem.predictions)},
        starts=starts,
        tried=problem.tried,
        interrupted=interrupted,
        posterior=posterior,
        beyond=beyond,
    )


def _signed(scenario: Scenario, problem: Problem) -> Scenario:
    """A fitted scenario that says so among its sources."""
    found = ", ".join(unknown.name for unknown in problem.unknowns)
    title = f"Calibration: {problem.calibration.title or 'no title'}"
    source = Source(title=title, authors="ridedown", confidence="reconstructed", note=f"Found by it: {found}.")
    return scenario.model_copy(update={"sources": (*scenario.sources, source)})


def _parameters(unknowns: Sequence[Unknown], point: Floats, found: Uncertainty) -> tuple[FittedParameter, ...]:
    half = found.reach * found.deviation
    middle, low, high = (values_of(unknowns, np.clip(p, 0.0, 1.0)) for p in (point, point - half, point + half))
    return tuple(
        FittedParameter(u.name, u.unit, float(v), float(lo), float(hi), u.lower, u.upper, u.by_ratio, float(d))
        for u, v, lo, hi, d in zip(unknowns, middle, low, high, found.deviation, strict=True)
    )


def _scatter(parts: Sequence[_Part]) -> dict[str, float]:
    """Root mean square of what the fit leaves, by unit."""
    left: dict[str, list[Floats]] = {}
    for part in parts:
        if part.case.fitted and isinstance(part.target, ChannelTarget) and part.target.measured is not None:
            left.setdefault(part.target.unit, []).append(part.value - part.target.measured)
    return {unit: float(np.sqrt(np.mean(np.concatenate(found) ** 2))) for unit, found in left.items()}


def _channel(part: _Part, target: ChannelTarget, found: Uncertainty, scatter: Mapping[str, float]) -> FittedChannel:
    half = found.band(part.slope)
    wide = np.sqrt(half**2 + (found.reach * scatter.get(target.unit, 0.0)) ** 2)
    times = target.samples.times
    rated = None
    if target.measured is not None:
        try:
            rated = rating((times, target.measured), (times, part.value))
        except InvalidInput:  # too short, or flat: there is no rating
            rated = None
    return FittedChannel(
        case=part.case.name,
        name=target.name,
        unit=target.unit,
        fitted=part.case.fitted,
        times=times,
        model=part.value,
        low=part.value - half,
        high=part.value + half,
        wide_low=part.value - wide,
        wide_high=part.value + wide,
        measured=target.measured,
        rating=rated,
        cfc=target.samples.cfc,
    )


def _number(part: _Part, target: NumberTarget, found: Uncertainty) -> FittedNumber:
    value, half = float(part.value[0]), float(found.band(part.slope)[0])
    return FittedNumber(
        case=part.case.name,
        name=target.name,
        unit=target.unit,
        fitted=part.case.fitted,
        model=value,
        low=value - half,
        high=value + half,
        wanted=target.value,
        sigma=None if np.isnan(target.sigma) or target.value is None else target.sigma,
        rounded=target.rounded,
        least=target.least if np.isfinite(target.least) else None,
        most=target.most if np.isfinite(target.most) else None,
    )


def _warnings(parameters: Sequence[FittedParameter], starts: tuple[int, int], *, interrupted: bool) -> list[str]:
    said = []
    if interrupted:
        said.append("Interrupted: these are the best parameters so far; a longer search may find better ones.")
    elif starts[0] > 1 and starts[1] == 1:
        said.append(
            f"Of {starts[0]} searches from random starts only one ended here: there may be a better place. Search harder "
            '(search.effort = "thorough"), or narrow the bounds.'
        )
    said += [
        f"{p.name} is at its bound, {in_words(p.bound, p.unit)}: widen the bounds if they are not physical."
        for p in parameters
        if p.at_bound
    ]
    return said


def _not_met(numbers: Sequence[FittedNumber], *, several: bool) -> list[str]:
    """What is to be said where the model does not give what was asked: stated deviations are all that its bands know of."""
    asked = [one for one in numbers if one.fitted and one.wanted is not None]  # a limit is soft, and may be leant on
    missed = [in_case(one.name, one.case, several=several) for one in asked if one.met is False]
    if not missed:
        return []
    why = "The model cannot give that within these bounds, or more is asked than is known"
    return [f"Not met: {', '.join(missed)}. {why}: the bands, which rest on the deviations stated, are then too narrow."]


def _farther(problem: Problem, point: Floats, found: Uncertainty) -> Beyond | None:
    """What is to be said where the search came by candidates far outside the bands that fit as well, as far as noise tells.

    As well: their log-likelihood is less than the best one's by no more than that of a band's end would be.
    """
    points, misfits = (np.concatenate(parts) for parts in zip(*problem.candidates, strict=True))
    likeliest = points[np.argsort(misfits)[:_MOST_LIKELY]]  # those that cannot be come last
    likelihood = Likelihood.of(problem, point)
    lost = likelihood(point[None])[0] - likelihood(likeliest)
    alike = values_of(problem.unknowns, np.concatenate([point[None], likeliest[lost <= 0.5 * found.reach**2]]))
    half = _WIDER * found.reach * found.deviation
    low, high = (values_of(problem.unknowns, np.clip(end, 0.0, 1.0)) for end in (point - half, point + half))
    least, most = alike.min(axis=0), alike.max(axis=0)
    far = {
        unknown.name: f"{unknown.name} from {in_words(float(a), unknown.unit)} to {in_words(float(b), unknown.unit)}"
        for unknown, a, b, outside in zip(problem.unknowns, least, most, (least < low) | (most > high), strict=True)
        if outside
    }
    if not far:
        return None
    sentence = (
        f"The search came by candidates that fit as well, as far as noise tells, with {', '.join(far.values())}: bands are of "
        "the place where it ended. Sample the posterior (posterior = true)."
    )
    return Beyond(tuple(far), sentence)


def _wider(parameters: Sequence[FittedParameter], posterior: Posterior) -> Beyond | None:
    """What is to be said where chains go much farther than bands: these are of the one place where the search ended."""
    far = []
    for p in parameters:
        low, _, high = posterior.quantiles(p.name)
        drawn, band = (math.log(b / a) if p.by_ratio else b - a for a, b in ((low, high), (p.low, p.high)))
        if drawn > _WIDER * band:
            far.append(p.name)
    if not far:
        return None
    sentence = (
        f"The posterior of {', '.join(far)} is more than twice as wide as the band: bands are of the place where the "
        "search ended, and others give nearly the same. Trust the posterior."
    )
    return Beyond(tuple(far), sentence)


def point_of(unknowns: Sequence[Unknown], values: Mapping[str, float]) -> Floats:
    """Values by name as a point of the unit cube."""
    return points_of(unknowns, np.array([values[unknown.name] for unknown in unknowns]))
