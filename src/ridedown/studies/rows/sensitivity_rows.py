"""Sensitivity of a study whose rows are kept: which rows it asks for, and what it makes of them.

Both are asked of the same functions (see `sensitivity`), once with an evaluator that takes notes, once with one that reads.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Variables
from ridedown.studies.analysis.evaluation import Evaluator
from ridedown.studies.analysis.sensitivity import MorrisScreening, SobolSensitivity, morris_screening, sobol_indices
from ridedown.studies.file.study import SensitivityOptions

Floats = NDArray[np.float64]


def asked_rows(options: SensitivityOptions, variables: Variables) -> dict[str, Floats]:
    """The rows that the method evaluates, in order: a column (R,) for each parameter.

    Raises: InvalidInput for correlated parameters.
    """
    asked: list[Mapping[str, Floats]] = []

    def note(columns: Mapping[str, Floats]) -> dict[str, Floats]:
        asked.append({name: np.array(column) for name, column in columns.items()})
        return {"noted": np.zeros(next(iter(columns.values())).size)}

    _found(options, variables, note, ["noted"])
    return {name: np.concatenate([columns[name] for columns in asked]) for name in variables.names}


def told_by(
    options: SensitivityOptions, variables: Variables, rows: Mapping[str, Floats], kept: Mapping[str, Floats]
) -> dict[str, Any]:
    """What the method makes of the outcomes kept of its rows, as plain data: `outcomes` with indices or effects, `idle`."""
    at = 0

    def read(columns: Mapping[str, Floats]) -> dict[str, Floats]:
        nonlocal at
        part = slice(at, at + next(iter(columns.values())).size)
        if not all(np.array_equal(columns[name], rows[name][part]) for name in columns):
            raise InvalidInput("sensitivity: got rows that were not those kept; need the same. Start anew in another folder.")
        at = part.stop
        return {name: values[part] for name, values in kept.items()}

    found = asdict(_found(options, variables, read, list(kept)))
    outcomes = {one.pop("outcome"): one for one in found["outcomes"]}
    return {"method": options.method, "seed": options.seed, "idle": found["idle"], "outcomes": outcomes}


def _found(
    options: SensitivityOptions, variables: Variables, evaluator: Evaluator, outcomes: Sequence[str]
) -> SobolSensitivity | MorrisScreening:
    seed, confidence = options.seed, options.confidence
    if options.method == "morris":
        return morris_screening(evaluator, variables, outcomes, trajectories=options.rows, seed=seed, confidence=confidence)
    return sobol_indices(evaluator, variables, outcomes, blocks=options.rows, seed=seed, confidence=confidence)
