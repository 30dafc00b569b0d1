"""Tests made by the product itself: curves of known restraints, with noise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ridedown.scenario import load, substitute
from ridedown.signals import TestRecord, TimeHistory
from ridedown.simulation import simulate

BASE = load("paper-adult-full")
STIFFNESS, SLACK, DAMPING = (f"adult.restraint.{field}" for field in ("stiffness", "slack", "damping_ratio"))
TRUE = {STIFFNESS: 60e3, SLACK: 0.03, DAMPING: 0.3}
PARAMETERS = [
    {"name": "stiffness", "paths": [STIFFNESS], "bounds": ["10 kN/m", "300 kN/m"], "scale": "log"},
    {"name": "slack", "paths": [SLACK], "bounds": ["0 mm", "100 mm"]},
    {"name": "damping", "paths": [DAMPING], "bounds": [0, 1]},
]
CHEST = {"channel": "adult.acceleration", "measured": "adult.acceleration", "cfc": 60, "window": ["0 ms", "150 ms"]}


def restraint(rng: np.random.Generator) -> dict[str, float]:
    """A restraint drawn at random."""
    return {STIFFNESS: 10 ** rng.uniform(4.3, 5.2), SLACK: rng.uniform(0.005, 0.06), DAMPING: rng.uniform(0.05, 0.6)}


def record(true: Mapping[str, float], noise: float, rng: np.random.Generator | None = None, base: Any = BASE) -> TestRecord:
    """Acceleration [m/s2], excursion [m] and belt force [N] of the adult at 10 kHz, the acceleration with white noise."""
    rng = np.random.default_rng(0) if rng is None else rng
    response = simulate(substitute(base, dict(true)))
    times = np.arange(-500, 2001) * 1e-4
    curves = []
    for name in ("adult.acceleration", "adult.excursion", "adult.restraint.force"):
        values = np.where(times < 0.0, 0.0, response.at(name, np.clip(times, 0.0, response.end_time)))
        spread = noise if name == "adult.acceleration" else 1e-3 * np.abs(values).max()
        curves.append(
            TimeHistory(
                values + rng.normal(0.0, spread, times.size), response.unit(name), start=-0.05, interval=1e-4, name=name
            )
        )
    return TestRecord.of(curves, identifier="synthetic")


def spec(test: TestRecord, **changes: Any) -> dict[str, Any]:
    """A calibration of the adult's restraint to that record."""
    case = {"name": "sled", "scenario": BASE, "record": test, "targets": [CHEST]}
    return {"cases": [case], "parameters": PARAMETERS, "search": {"effort": "quick"}} | changes
