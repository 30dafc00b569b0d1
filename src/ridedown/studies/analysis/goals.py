"""What a design is judged by: an outcome, or a measure of it over a population of occupants and crashes.

All measures are of how bad an outcome is: where more is better (`maximise`, or a requirement with `least`), they are taken of
its negative. So `MeanPlus(2.0)` of an outcome that is to be large is its mean less two standard deviations.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Seed, Sobol, Variables, seed_of
from ridedown.studies.analysis.evaluation import BATCH, Evaluator, Floats, Limit, Progress, Runs, check_count, check_share

Truths = NDArray[np.bool_]


class Measure(ABC):
    """One number for each design, of its outcomes over a population."""

    @abstractmethod
    def of(self, values: Floats, weights: Floats, sign: float) -> Floats:
        """The measure (R,), times the sign, of values (R, m) with weights (m,) whose sum is 1."""

    @abstractmethod
    def words(self, outcome: str) -> str:
        """What it is called."""


@dataclass(frozen=True, slots=True)
class Mean(Measure):
    """The weighted mean; of a population of one, its outcome."""

    def of(self, values: Floats, weights: Floats, sign: float) -> Floats:
        """The measure (R,), times the sign."""
        return sign * (values @ weights)

    def words(self, outcome: str) -> str:
        """What it is called."""
        return outcome


@dataclass(frozen=True, slots=True)
class MeanPlus(Measure):
    """The mean and `sigmas` standard deviations on top.

    >>> MeanPlus(2.0).of(np.array([[1.0, 3.0]]), np.array([0.5, 0.5]), 1.0)
    array([4.])
    """

    sigmas: float

    def of(self, values: Floats, weights: Floats, sign: float) -> Floats:
        """The measure (R,), times the sign."""
        mean = values @ weights
        off = values - mean[:, None]
        return sign * mean + self.sigmas * np.sqrt((off * off) @ weights)

    def words(self, outcome: str) -> str:
        """What it is called."""
        return f"{outcome}, mean plus {self.sigmas:g} standard deviations"


@dataclass(frozen=True, slots=True)
class QuantileOf(Measure):
    """The least value that a share of the population does not exceed.

    >>> QuantileOf(0.75).of(np.array([[4.0, 1.0, 2.0, 3.0]]), np.full(4, 0.25), 1.0)
    array([3.])
    """

    share: float

    def __post_init__(self) -> None:
        check_share(self.share, "share")

    def of(self, values: Floats, weights: Floats, sign: float) -> Floats:
        """The measure (R,), times the sign."""
        bad = sign * values
        order = np.argsort(bad, axis=1)
        reached = np.cumsum(weights[order], axis=1) >= self.share - 1e-12
        reached[:, -1] = True
        place = np.take_along_axis(order, np.argmax(reached, axis=1)[:, None], axis=1)
        return np.take_along_axis(bad, place, axis=1)[:, 0]

    def words(self, outcome: str) -> str:
        """What it is called."""
        return f"{outcome}, {self.share:.4g} quantile"


@dataclass(frozen=True, slots=True)
class Worst(Measure):
    """The worst of the population, whatever the weights."""

    def of(self, values: Floats, weights: Floats, sign: float) -> Floats:
        """The measure (R,), times the sign."""
        return np.asarray((sign * values[:, weights > 0.0]).max(axis=1))

    def words(self, outcome: str) -> str:
        """What it is called."""
        return f"{outcome}, worst"


@dataclass(frozen=True, slots=True)
class Beyond(Measure):
    """The share of the population whose outcome is more than `most`, or less than `least`.

    >>> Beyond(most=2.0).of(np.array([[1.0, 2.0, 3.0]]), np.array([0.5, 0.25, 0.25]), 1.0)
    array([0.25])
    """

    most: float | None = None
    least: float | None = None

    def __post_init__(self) -> None:
        Limit("share beyond", self.most, self.least)

    def of(self, values: Floats, weights: Floats, sign: float) -> Floats:
        """The measure (R,), times the sign."""
        beyond = Limit("", self.most, self.least).excess(values) > 0.0
        return sign * (beyond @ weights)

    def words(self, outcome: str) -> str:
        """What it is called."""
        broken = f"> {self.most:g}" if self.most is not None else f"< {self.least:g}"
        return f"share with {outcome} {broken}"


@dataclass(frozen=True, slots=True)
class Goal:
    """What is to be as small as can be, or as large."""

    outcome: str
    measure: Measure = field(default_factory=Mean)
    maximise: bool = False

    @property
    def sign(self) -> float:
        """-1 where more is better."""
        return -1.0 if self.maximise else 1.0

    @property
    def words(self) -> str:
        """What it is called."""
        return self.measure.words(self.outcome)


@dataclass(frozen=True, slots=True)
class Requirement:
    """What a design must hold: a measure of an outcome that is at most, or at least, so much.

    >>> Requirement("driver.hic15", most=700.0, measure=QuantileOf(0.95)).words
    'driver.hic15, 0.95 quantile <= 700'
    """

    outcome: str
    most: float | None = None
    least: float | None = None
    measure: Measure = field(default_factory=Mean)

    def __post_init__(self) -> None:
        Limit(self.outcome, self.most, self.least)

    @property
    def limit(self) -> Limit:
        """The limit."""
        return Limit(self.outcome, self.most, self.least)

    @property
    def sign(self) -> float:
        """-1 where it must be at least so much."""
        return 1.0 if self.most is not None else -1.0

    @property
    def words(self) -> str:
        """The requirement in words."""
        return f"{self.measure.words(self.outcome)} {'<=' if self.most is not None else '>='} {self.limit.bound:g}"


@dataclass(frozen=True, slots=True, eq=False)
class Population:
    """Whom and what a design is for: rows of further parameters, (m,) each, such as masses and speeds, with weights (m,).

    scatter: what is added to a design's own parameters in each row, (m,) each, SI: tolerances.
    """

    columns: Mapping[str, ArrayLike] = field(default_factory=dict)
    weights: ArrayLike | None = None
    scatter: Mapping[str, ArrayLike] = field(default_factory=dict)

    @classmethod
    def drawn(cls, variables: Variables, rows: int = 64, *, seed: Seed = 0) -> Population:
        """So many rows of distributed parameters, all of one weight. Each design meets the same rows."""
        check_count(rows, "rows")
        return cls(variables.columns(Sobol(len(variables.names), seed_of(seed)).rows(0, rows)))

    def arrays(self) -> tuple[dict[str, Floats], dict[str, Floats], Floats]:
        """Columns, scatter, and weights whose sum is 1. Raises: InvalidInput for columns that do not go together."""
        columns = {name: np.asarray(column, dtype=np.float64) for name, column in self.columns.items()}
        scatter = {name: np.asarray(column, dtype=np.float64) for name, column in self.scatter.items()}
        given = columns | {f"scatter of {name}": column for name, column in scatter.items()}
        sizes = {name: column.size for name, column in given.items()}
        if self.weights is not None:
            given["weights"] = np.asarray(self.weights, dtype=np.float64)
            sizes["weights"] = given["weights"].size
        for name, column in given.items():
            if column.ndim != 1 or not column.size or not np.isfinite(column).all():
                raise InvalidInput(f"population: got {name} of shape {column.shape}; need finite numbers, shape (m,).")
        if len(set(sizes.values())) > 1:
            (first, size), *others = sizes.items()
            other, other_size = next((name, n) for name, n in others if n != size)
            raise InvalidInput(f"population: got {other_size} rows of {other}; need {size}, as in {first}.")
        size = next(iter(sizes.values()), 1)
        weights = given.get("weights", np.ones(size))
        if (weights < 0.0).any() or not weights.sum() > 0.0:
            raise InvalidInput(f"population: got weights down to {weights.min():g}; need >= 0, and one above 0.")
        return columns, scatter, weights / weights.sum()


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """Designs judged: how bad each goal is (R, k), how far each requirement is exceeded (R, q), which designs failed (R,)."""

    goals: Floats
    excess: Floats
    failed: Truths

    @property
    def feasible(self) -> Truths:
        """Which designs hold all requirements."""
        return ~self.failed & (self.excess <= 0.0).all(axis=1)


class Judge:
    """Designs in the unit cube to how bad they are, in batches of designs and population together.

    A design of which any row fails, for an outcome that matters, has failed: its goals and excesses are infinite.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        ranges: Mapping[str, tuple[float, float]],
        goals: Sequence[Goal],
        requirements: Sequence[Requirement] = (),
        population: Population | None = None,
        *,
        batch: int = BATCH,
        total: int = 0,
        progress: Progress | None = None,
    ) -> None:
        self.names, self.low, self.high = checked_ranges(ranges)
        self._columns, self._scatter, self._weights = (population or Population()).arrays()
        for name in self._columns:
            if name in self.names:
                raise InvalidInput(f"population: got {name}, which the design sets; need another parameter. Give its scatter.")
        for name in self._scatter:
            if name not in self.names:
                raise InvalidInput(
                    f"population: got scatter of {name}; need a parameter of the design: {', '.join(self.names)}."
                )
        if not goals:
            raise InvalidInput("goals: got none; need at least one.")
        self.goals, self.requirements = tuple(goals), tuple(requirements)
        for listed, what in ((self.goals, "goals"), (self.requirements, "requirements")):
            words = [one.words for one in listed]
            twice = next((word for word in words if words.count(word) > 1), None)
            if twice is not None:
                raise InvalidInput(f"{what}: got {twice} twice; need each once.")
        outcomes = [*(goal.outcome for goal in self.goals), *(one.outcome for one in self.requirements)]
        size = self._weights.size
        self.runs = Runs(evaluator, outcomes, batch=batch, total=total * size, progress=progress)
        self._most = max(1, batch // size)

    def values(self, unit: Floats) -> Floats:
        """The parameters (R, n) of designs in the unit cube."""
        return np.clip(self.low + unit * (self.high - self.low), self.low, self.high)

    def __call__(self, unit: Floats) -> Judged:
        """Judge designs (R, n)."""
        parts = [self._judged(self.values(unit[start : start + self._most])) for start in range(0, len(unit), self._most)]
        return Judged(
            np.concatenate([part.goals for part in parts]),
            np.concatenate([part.excess for part in parts]),
            np.concatenate([part.failed for part in parts]),
        )

    def _judged(self, designs: Floats) -> Judged:
        count, size = len(designs), self._weights.size
        table = {name: np.repeat(designs[:, i], size) for i, name in enumerate(self.names)}
        for name, column in self._scatter.items():
            table[name] = table[name] + np.tile(column, count)
        table |= {name: np.tile(column, count) for name, column in self._columns.items()}
        found = {name: values.reshape(count, size) for name, values in self.runs(table).items()}
        failed = np.zeros(count, dtype=np.bool_)
        for values in found.values():
            failed |= np.isnan(values).any(axis=1)

        def bad(one: Goal | Requirement) -> Floats:
            values = np.where(failed[:, None], 0.0, found[one.outcome])
            return np.where(failed, np.inf, one.measure.of(values, self._weights, one.sign))

        goals = np.stack([bad(goal) for goal in self.goals], axis=1)
        excess = [bad(one) - one.sign * one.limit.bound for one in self.requirements]
        return Judged(goals, np.stack(excess, axis=1) if excess else np.zeros((count, 0)), failed)


def checked_ranges(ranges: Mapping[str, tuple[float, float]]) -> tuple[tuple[str, ...], Floats, Floats]:
    """Names, least and largest values of parameters. Raises: InvalidInput for none, or one without room."""
    if not ranges:
        raise InvalidInput("ranges: got none; need at least one parameter. Name what varies.")
    for name, (low, high) in ranges.items():
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise InvalidInput(f"{name}: got {low:g} to {high:g}; need a least value and a larger one, both finite.")
    low, high = np.array(list(ranges.values()), dtype=np.float64).T
    return tuple(ranges), low, high
