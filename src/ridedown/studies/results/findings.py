"""What a finished study says: quantiles, probabilities of exceeding limits, indices, with their intervals; as plain data."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
from numpy.typing import NDArray

from ridedown.studies.analysis.evaluation import Estimate
from ridedown.studies.analysis.reliability import exceedance, summary
from ridedown.studies.bound import BoundStudy
from ridedown.studies.file.limits import limits_of
from ridedown.studies.file.parameters import resolve
from ridedown.studies.file.study import LoadedStudy
from ridedown.studies.results.store import chunk_files
from ridedown.studies.rows.bounding import OPEN, PEAK, LeastPeaks
from ridedown.studies.rows.plan import Drawn, Listed, Plan, variables_of
from ridedown.studies.rows.sensitivity_rows import told_by

Floats = NDArray[np.float64]


def column(folder: Path, name: str) -> Floats:
    """A column of the results in a folder, in the order of the rows, (R,); NaN where a row has none."""
    parts = [pq.ParquetFile(path).read([name], use_threads=False)[name].to_numpy() for path in chunk_files(folder)]
    values: Floats = np.concatenate(parts)
    return values


def results_of(loaded: LoadedStudy, plan: Plan, folder: Path) -> dict[str, Any]:
    """What the kept rows of a finished study say, as plain data for JSON.

    `limits`: for each, its rule in words, how many rows exceed it, of how many. Of a sample its probability with an interval,
    and `outcomes`: mean, deviation and quantiles with theirs. Of a sensitivity study `outcomes`: indices or effects.
    Of a bound `bound`, as `BoundStudy.as_json` has it.
    """
    limits = limits_of(loaded.study, plan.function.units)
    drawn = plan.design if isinstance(plan.design, Drawn) else None
    groups = 1 if drawn is None else drawn.groups
    given = loaded.study.sample
    confidence = 0.95 if given is None else given.confidence
    found: dict[str, Any] = {"kind": loaded.study.kind, "limits": []}
    for limit in limits:
        counted = exceedance(limit, column(folder, limit.outcome), groups=groups, confidence=confidence)
        said: dict[str, Any] = {"outcome": limit.outcome, "most": limit.most, "least": limit.least, "rule": limit.rule}
        said |= {"exceeded": counted.exceeded, "rows": counted.rows, "failed": counted.failed}
        if drawn is not None:
            said |= {"probability": asdict(counted.probability), "beta": counted.beta}
        found["limits"].append(said)
    if drawn is not None and given is not None:
        found |= {"design": given.design, "seed": given.seed, "parts": groups, "outcomes": {}}
        for name in plan.function.units:
            of = summary(name, column(folder, name), groups=groups, confidence=confidence)
            quantiles = [{"share": one.share, **asdict(one.value)} for one in of.quantiles]
            found["outcomes"][name] = {"mean": asdict(of.mean), "deviation": of.deviation, "quantiles": quantiles}
    if loaded.study.bound is not None:
        found["bound"] = kept_bound(loaded, folder).as_json()
    if loaded.study.sensitivity is not None and isinstance(plan.design, Listed):
        variables = variables_of(loaded.study, resolve(loaded.study.parameters, loaded.scenarios))
        kept = {name: column(folder, name) for name in plan.function.units}
        found |= told_by(loaded.study.sensitivity, variables, plan.design.listed, kept)
    plain: dict[str, Any] = finite(found)
    return plain


def kept_bound(loaded: LoadedStudy, folder: Path) -> BoundStudy:
    """What a finished study of kind `bound` found."""
    assert loaded.study.bound is not None
    function = LeastPeaks.of(loaded.scenarios[""], loaded.study.bound)
    name = loaded.study.name or loaded.scenarios[""].name
    return function.study(name, column(folder, PEAK), column(folder, OPEN))


def finite(value: Any) -> Any:
    """The same data with null for numbers that JSON has not."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, Estimate):
        return finite(asdict(value))
    return None if isinstance(value, float) and not math.isfinite(value) else value
