"""Parameters of a study that change none of its outcomes: more often a wrong path than a finding."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ridedown.studies.rows.crashes import Rows
from ridedown.studies.rows.plan import Plan

Floats = NDArray[np.float64]

_BASES = 8
"""Rows, spread over the study, in which each parameter is changed by itself."""

_SPREAD = 256
"""Rows, spread over the study, that the least and largest value of a parameter are taken from."""

_NOISE = 1e-9
"""Of an outcome's size: what rounding alone may come to."""


def without_effect(plan: Plan) -> tuple[str, ...]:
    """Names of the parameters that vary and yet change nothing in trial rows, each set to its least and largest value there."""
    spread = _columns(plan, _SPREAD)
    bases = _columns(plan, _BASES)
    count = next(iter(bases.values())).size
    varying = [name for name in plan.units if np.ptp(spread[name]) > 0.0]
    tables = [bases]
    for name in varying:
        tables += [{**bases, name: np.full(count, value)} for value in (spread[name].min(), spread[name].max())]
    stacked = {name: np.concatenate([table[name] for table in tables]) for name in bases}
    rows = plan.function.rows(stacked)
    parts = [slice(i * count, (i + 1) * count) for i in range(len(tables))]
    return tuple(
        name for i, name in enumerate(varying) if all(_alike(rows, parts[0], parts[2 * i + which]) for which in (1, 2))
    )


def remarks_on(plan: Plan) -> list[str]:
    """What to say of the study before it is run."""
    return [
        f"{name} has no effect: from its least to its largest value no outcome changes. Check its path."
        for name in without_effect(plan)
    ]


def _columns(plan: Plan, count: int) -> dict[str, Floats]:
    """Parameters of this many rows, spread evenly over the study: near the same places of blocks, whatever their period."""
    numbers = np.unique((np.arange(count) * 0.6180339887498949 % 1.0 * plan.rows).astype(np.int64))
    each = [plan.design.columns(int(number), int(number) + 1) for number in numbers]
    return {name: np.concatenate([columns[name] for columns in each]) for name in each[0]}


def _alike(rows: Rows, one: slice, other: slice) -> bool:
    if not np.array_equal(rows.reason[one] > 0, rows.reason[other] > 0):
        return False
    for column in rows.columns.values():
        a, b = column[one], column[other]
        size = max(np.nanmax(np.abs(a), initial=0.0), np.nanmax(np.abs(b), initial=0.0))
        if not np.allclose(a, b, rtol=0.0, atol=_NOISE * size, equal_nan=True):
            return False
    return True
