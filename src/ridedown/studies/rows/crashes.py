"""From columns of a study's parameters to columns of its outcomes, over all its scenarios; rows that fail say why."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import UnknownName
from ridedown.network import Network
from ridedown.outcomes import known_outcomes
from ridedown.scenario import Scenario, broken_rules, lower, total_forces
from ridedown.status import Status
from ridedown.studies.file.parameters import Varied
from ridedown.studies.rows.outcomes import Wanted, compute, known_criteria, wanted_of

Floats = NDArray[np.float64]

COMPLETED, REFUSED = "completed", "refused"
"""Words for a row whose crashes were all solved to their end, and for one with a value that its scenario may not hold.

The others are the names of `Status`, as `bar-turned`.
"""

WEIGHTED = "weighted"
"""What comes before an outcome that is the mean over all scenarios, by their weights."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Outcomes of R rows: columns by name, (R,) each, NaN where a row failed.

    status, why: (R,), an index into `reasons`, pairs of a word and a sentence; the first is a row that is whole.
    """

    columns: dict[str, Floats]
    reason: NDArray[np.int32]
    reasons: list[tuple[str, str]]

    @property
    def failed(self) -> int:
        """How many rows are not whole."""
        return int(np.count_nonzero(self.reason))


@dataclass(frozen=True, eq=False)
class Evaluator:
    """The crashes of a study as a function of its parameters. Data only, so that it can be sent to other machines.

    As a function it takes columns of parameters by name, (R,) each, SI, to columns of outcomes; NaN where a row failed.
    """

    scenarios: Mapping[str, Scenario]
    weights: Mapping[str, float]
    parameters: tuple[Varied, ...]
    wanted: Mapping[str, Wanted]
    weighted: tuple[str, ...]
    step: float

    @classmethod
    def of(
        cls,
        scenarios: Mapping[str, Scenario],
        parameters: tuple[Varied, ...],
        outcomes: Mapping[str, str],
        *,
        usual: bool = False,
        weights: Mapping[str, float] | None = None,
        step: float = 1e-4,
    ) -> Evaluator:
        """For scenarios by name, "" for the only one, and outcomes by name, each with its place in the study file.

        usual: before those the usual outcomes of each scenario.

        Raises: UnknownName for an outcome that no scenario has.
        """
        wanted, weighted = _wanted(scenarios, outcomes, usual=usual)
        return cls(scenarios, weights or dict.fromkeys(scenarios, 1.0), parameters, wanted, weighted, step)

    @property
    def units(self) -> dict[str, str]:
        """Every outcome with its SI unit, in order."""
        own = {_full(name, key): unit for name, want in self.wanted.items() for key, unit in want.units.items()}
        means = {f"{WEIGHTED}.{key}": next(iter(self.wanted.values())).units[key] for key in self.weighted}
        return own | means

    def __call__(self, columns: Mapping[str, Floats]) -> dict[str, Floats]:
        """Columns of outcomes of these columns of parameters."""
        return self.rows(columns).columns

    def rows(self, columns: Mapping[str, Floats]) -> Rows:
        """Outcomes of these columns of parameters, with the reason of every row that failed."""
        size = next(iter(columns.values())).size
        found: dict[str, Floats] = {}
        reason = np.zeros(size, dtype=np.int32)
        reasons = [(COMPLETED, "")]
        for name, scenario in self.scenarios.items():
            table = {path: columns[one.name] for one in self.parameters for path in one.targets.get(name, ())}
            self._case(name, scenario, table, found, reason, reasons)
        total = sum(self.weights.values())
        for key in self.weighted:
            parts = [self.weights[name] / total * found[_full(name, key)] for name in self.scenarios]
            found[f"{WEIGHTED}.{key}"] = np.sum(parts, axis=0)
        return Rows(found, reason, reasons)

    def _case(
        self,
        name: str,
        scenario: Scenario,
        table: Mapping[str, Floats],
        found: dict[str, Floats],
        reason: NDArray[np.int32],
        reasons: list[tuple[str, str]],
    ) -> None:
        """Put in the outcomes of one scenario."""
        size, want = reason.size, self.wanted[name]
        said = f"{name}: " if name else ""

        def fail(rows: NDArray[np.intp], word: str, sentence: str) -> None:
            new = rows[reason[rows] == 0]  # the first reason counts
            if new.size:
                reason[new] = len(reasons)
                reasons.append((word, said + sentence))

        good = np.ones(size, dtype=np.bool_)
        for sentence, mask in broken_rules(scenario, table).items():
            fail(np.flatnonzero(mask & good), REFUSED, sentence)
            good &= ~mask
        rows = np.flatnonzero(good)
        columns = {key: np.full(size, math.nan) for key in want.units}
        if rows.size:
            # one crash for all rows, where nothing varies in this scenario
            values, status = compute(scenario, {path: column[rows] for path, column in table.items()}, want, step=self.step)
            status = np.broadcast_to(status, rows.shape)
            whole = status == Status.COMPLETED.value
            for key, column in values.items():
                columns[key][rows] = np.where(whole, column, math.nan)
            for code in np.unique(status[~whole]):
                stopped = Status.of(int(code))
                fail(rows[status == code], stopped.name.lower().replace("_", "-"), stopped.sentence)
        found |= {_full(name, key): column for key, column in columns.items()}


def _full(scenario: str, outcome: str) -> str:
    return f"{scenario}.{outcome}" if scenario else outcome


def _wanted(
    scenarios: Mapping[str, Scenario], outcomes: Mapping[str, str], *, usual: bool
) -> tuple[dict[str, Wanted], tuple[str, ...]]:
    """What is to be computed of each scenario, and which outcomes are means over all of them."""
    known = {name: _known(scenario) for name, scenario in scenarios.items()}
    chosen: dict[str, dict[str, None]] = {name: {} for name in scenarios}
    if usual:
        chosen = {name: dict.fromkeys(wanted_of(scenario, None).units) for name, scenario in scenarios.items()}
    weighted: list[str] = []
    for outcome, place in outcomes.items():
        first, _, inner = outcome.partition(".")
        several = len(scenarios) > 1 or "" not in scenarios
        if several and first == WEIGHTED and all(inner in names for names in known.values()):
            weighted.append(inner)
            hits = [(name, inner) for name in scenarios]
        elif several and first in known and inner in known[first]:
            hits = [(first, inner)]
        else:
            hits = [(name, outcome) for name, names in known.items() if outcome in names]
        if not hits:
            every = [_full(name, key) for name, names in known.items() for key in names]
            raise UnknownName.among(place, outcome, every)
        for name, key in hits:
            chosen[name][key] = None
    return {name: wanted_of(scenarios[name], list(keys)) for name, keys in chosen.items()}, tuple(weighted)


def _known(scenario: Scenario) -> dict[str, str]:
    network: Network = lower(scenario)
    further = total_forces(getattr(scenario, "occupants", ()), network)
    return known_outcomes(network, further) | known_criteria(network)
