"""What every analysis asks of a model: columns of parameters in, columns of outcomes out, in batches, counted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput, UnknownName

Floats = NDArray[np.float64]

Evaluator = Callable[[Mapping[str, Floats]], Mapping[str, Floats]]
"""Parameters by path or name, a column (R,) each, to outcomes by name, a column (R,) each; NaN where a row failed."""

Progress = Callable[[int, int], None]
"""Told how many evaluations are done, and of how many; where that is not known beforehand, of how many at most."""

BATCH = 65_536
"""Rows given to the evaluator at a time: what bounds the memory."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number and the interval that holds the true one with the stated confidence."""

    value: float
    low: float
    high: float
    confidence: float = 0.95


@dataclass(frozen=True, slots=True)
class Limit:
    """An outcome that may not be more than a bound, or not less than one.

    >>> Limit("driver.hic15", most=700.0).excess(np.array([650.0, 800.0]))
    array([-50., 100.])
    """

    outcome: str
    most: float | None = None
    least: float | None = None

    def __post_init__(self) -> None:
        if (self.most is None) == (self.least is None) or not np.isfinite(self.bound):
            raise InvalidInput(
                f"{self.outcome}: got most {self.most} and least {self.least}; need one of them, a finite number."
            )

    @property
    def bound(self) -> float:
        """The bound."""
        bound = self.most if self.most is not None else self.least
        return np.nan if bound is None else float(bound)

    @property
    def rule(self) -> str:
        """The limit in words, as in `driver.hic15 <= 700`."""
        return f"{self.outcome} {'<=' if self.most is not None else '>='} {self.bound:g}"

    def excess(self, values: Floats) -> Floats:
        """By how much the values break the limit: positive where they do, negative where there is room, NaN where failed."""
        return values - self.bound if self.most is not None else self.bound - values


class Runs:
    """An evaluator that is called in batches and counts its rows, so that every result can say what it took."""

    def __init__(
        self,
        evaluator: Evaluator,
        outcomes: Sequence[str],
        *,
        batch: int = BATCH,
        total: int = 0,
        progress: Progress | None = None,
    ) -> None:
        if isinstance(batch, bool) or not isinstance(batch, int) or batch < 1:  # type: ignore[redundant-expr]
            raise InvalidInput(f"batch: got {batch!r}; need a whole number of 1 or more.")
        if not outcomes:
            raise InvalidInput("outcomes: got none; need at least one. Name what is to be found.")
        self._evaluator = evaluator
        self._outcomes = tuple(dict.fromkeys(outcomes))
        self._batch = batch
        self._total = total
        self._progress = progress
        self.done = 0
        """Rows evaluated."""
        self.failed = 0
        """Rows of which an outcome that was asked for is not a finite number."""

    def __call__(self, columns: Mapping[str, Floats]) -> dict[str, Floats]:
        """The outcomes of rows, a column (R,) each; NaN for an outcome that is not a finite number.

        Raises: UnknownName for an outcome that the evaluator does not give; InvalidInput for columns of another length.
        """
        rows = len(next(iter(columns.values())))
        found = {name: np.empty(rows) for name in self._outcomes}
        for start in range(0, rows, self._batch):
            part = slice(start, min(start + self._batch, rows))
            given = self._evaluator({name: column[part] for name, column in columns.items()})
            size = part.stop - part.start
            for name in self._outcomes:
                if name not in given:
                    raise UnknownName.among("outcome", name, given)
                values = np.asarray(given[name], dtype=np.float64)
                if values.shape != (size,):
                    raise InvalidInput(f"{name}: got an array of shape {values.shape}; need ({size},), a value for each row.")
                found[name][part] = np.where(np.isfinite(values), values, np.nan)
            bad = np.zeros(size, dtype=np.bool_)
            for name in self._outcomes:
                bad |= np.isnan(found[name][part])
            self.done += size
            self.failed += int(bad.sum())
            if self._progress is not None:
                self._progress(self.done, max(self._total, self.done))
        return found


def check_share(value: float, name: str) -> float:
    """A number between 0 and 1, both excluded. Raises: InvalidInput otherwise."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < 1.0:  # type: ignore[redundant-expr]
        raise InvalidInput(f"{name}: got {value!r}; need > 0 and < 1.")
    return float(value)


def check_count(value: int, name: str, least: int = 1) -> int:
    """A whole number of at least so many. Raises: InvalidInput otherwise."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:  # type: ignore[redundant-expr]
        raise InvalidInput(f"{name}: got {value!r}; need a whole number of {least} or more.")
    return int(value)
