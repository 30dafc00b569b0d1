"""An evaluator that keeps every row it is asked for, and answers from what is kept: what searches can be resumed with.

A search with a seed asks for the same rows each time, as long as it gets the same answers. So a search that was stopped is
started again: what it asks for at first is answered from the folder, bit for bit, and the rest is computed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pyarrow as pa

from ridedown.errors import InvalidInput
from ridedown.studies.results.store import Store, packed
from ridedown.studies.rows.crashes import Rows
from ridedown.studies.rows.plan import Floats, Plan
from ridedown.studies.running.workers import Workers

UNIT = 16_384
"""Rows of a request that are computed, or answered, together."""

_PIECE = 512
"""Rows given to a worker at a time. Like UNIT it is the same whatever the machine, so that no bit depends on who computes."""

Told = Callable[[int, int, int], None]
"""Told how many rows were answered from the folder, how many were computed, and how many of those failed."""


class Kept:
    """The evaluator of a search: columns of parameters by name to columns of outcomes, (R,) each; NaN where a row failed."""

    def __init__(self, store: Store, plan: Plan, crew: Workers, told: Told) -> None:
        self._store, self._plan, self._crew, self._told = store, plan, crew, told
        self._chunk = 0
        self._start = 0  # the first row of that chunk
        self._at = 0  # the next row
        self._there: pa.Table | None = None  # the chunk, if it was kept before
        self._waiting: list[tuple[Mapping[str, Floats], Rows]] = []
        self.before = self.computed = self.failed = 0

    @property
    def written(self) -> int:
        """Rows that are kept so far."""
        return self._at if self._there is not None else self._start

    def __call__(self, columns: Mapping[str, Floats]) -> dict[str, Floats]:
        """The outcomes of these columns of parameters.

        Raises: InvalidInput where the rows kept are not those asked for.
        """
        size = next(iter(columns.values())).size
        parts = []
        for start in range(0, size, UNIT):
            part = {name: columns[name][start : start + UNIT] for name in self._plan.units}
            parts.append(self._unit(part))
            self._told(self.before, self.computed, self.failed)
        return {name: np.concatenate([part[name] for part in parts]) for name in self._plan.function.units}

    def end(self) -> tuple[int, int]:
        """Write what waits; how many rows and chunks there are in all."""
        if self._waiting:
            self._write()
        return self._at, self._chunk

    def _unit(self, columns: Mapping[str, Floats]) -> Mapping[str, Floats]:
        if self._at == self._start:
            self._there = self._store.read(self._chunk, self._start)
        size = next(iter(columns.values())).size
        first, self._at = self._at - self._start, self._at + size
        if self._there is None:
            rows = self._computed(columns)
            self._waiting.append((columns, rows))
            self.computed += size
            self.failed += rows.failed
            if self._at - self._start >= self._plan.chunk_rows:
                self._write()
            return rows.columns
        found = self._there.slice(first, size)
        kept = {name: found[name].to_numpy() for name in columns}
        if found.num_rows != size or not all(np.array_equal(kept[name], column) for name, column in columns.items()):
            raise InvalidInput(
                f"--resume: got rows that are not those kept, from row {self._start + first} on; need the same libraries and "
                "machine as before. Start anew in another folder."
            )
        self.before += size
        if self._at - self._start == self._there.num_rows:
            self._next()
        # a row without an outcome was kept as null, and is read as NaN
        return {name: found[name].to_numpy() for name in self._plan.function.units}

    def _computed(self, columns: Mapping[str, Floats]) -> Rows:
        size = next(iter(columns.values())).size
        pieces = [
            {name: column[start : start + _PIECE] for name, column in columns.items()} for start in range(0, size, _PIECE)
        ]
        return _joined(self._crew.rows(self._plan.function, pieces))

    def _write(self) -> None:
        columns = {name: np.concatenate([part[name] for part, _ in self._waiting]) for name in self._plan.units}
        rows = _joined([rows for _, rows in self._waiting])
        self._store.write(self._chunk, packed(self._plan, self._start, columns, rows))
        self._waiting = []
        self._next()

    def _next(self) -> None:
        self._chunk, self._start, self._there = self._chunk + 1, self._at, None


def _joined(parts: list[Rows]) -> Rows:
    """The rows of several parts, one after another."""
    if len(parts) == 1:
        return parts[0]
    reasons = list(dict.fromkeys(reason for part in parts for reason in part.reasons))
    # the first reason, that of a whole row, is the first of every part
    codes = [np.array([reasons.index(reason) for reason in part.reasons], dtype=np.int32)[part.reason] for part in parts]
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in parts[0].columns}
    return Rows(columns, np.concatenate(codes), reasons)
