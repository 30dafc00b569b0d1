"""Tests made by the product itself: curves of known restraints, with noise."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from ridedown.scenario import load, substitute
from ridedown.signals import TestRecord, TimeHistory, filtered
from ridedown.simulation import simulate
from ridedown.studies.calibration.of_test import TEMPLATES

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


Noise = Callable[[np.random.Generator], NDArray[np.float64]]
"""Draws noise (n,) of deviation 1 at the times of a record."""

_TIMES = np.arange(-500, 2001) * 1e-4
_BEFORE = 20_000  # values for the noise to settle in


def white(rng: np.random.Generator) -> NDArray[np.float64]:
    """Noise in which no value knows of another."""
    return rng.normal(0.0, 1.0, _TIMES.size)


def through_a_class(frequency_class: float) -> Noise:
    """White noise through a channel frequency class."""

    def draw(rng: np.random.Generator) -> NDArray[np.float64]:
        drawn = rng.normal(0.0, 1.0, _TIMES.size + 2 * _BEFORE)
        smooth = filtered(TimeHistory(drawn, "", interval=1e-4), frequency_class).values[_BEFORE : _BEFORE + _TIMES.size]
        made: NDArray[np.float64] = smooth / smooth.std()
        return made

    return draw


def lasting(time: float) -> Noise:
    """Noise whose correlation falls by e in that time [s]."""
    tied = np.exp(-1e-4 / time)

    def draw(rng: np.random.Generator) -> NDArray[np.float64]:
        drawn = rng.normal(0.0, np.sqrt(1.0 - tied**2), _TIMES.size + _BEFORE)
        made: NDArray[np.float64] = lfilter([1.0], [1.0, -tied], drawn)[_BEFORE:]
        return made

    return draw


def record(
    true: Mapping[str, float],
    noise: float,
    rng: np.random.Generator | None = None,
    base: Any = BASE,
    kind: Noise = white,
) -> TestRecord:
    """Acceleration [m/s2], excursion [m] and belt force [N] of the adult at 10 kHz, the acceleration with noise of that
    deviation.
    """
    rng = np.random.default_rng(0) if rng is None else rng
    response = simulate(substitute(base, dict(true)))
    curves = []
    for name in ("adult.acceleration", "adult.excursion", "adult.restraint.force"):
        values = np.where(_TIMES < 0.0, 0.0, response.at(name, np.clip(_TIMES, 0.0, response.end_time)))
        drawn = noise * kind(rng) if name == "adult.acceleration" else 1e-3 * np.abs(values).max() * white(rng)
        curves.append(TimeHistory(values + drawn, response.unit(name), start=-0.05, interval=1e-4, name=name))
    return TestRecord.of(curves, identifier="synthetic")


OF_SLED = {"stiffness": 45e3, "slack": 0.02, "damping ratio": 0.25}
MASS = 74.0
"""The occupant of `sled_test`, kg."""


def sled_test() -> TestRecord:
    """A sled test of a restraint that is known, as a table that names its channels and says no more."""
    template = TEMPLATES["spring and damper"]
    occupant = {**template.occupant, "name": "occupant", "mass": MASS}
    sled = load("sled-fmvss-208").model_copy(update={"occupants": ()})
    made = load(sled.model_dump(exclude_unset=True, mode="python") | {"occupants": [occupant]})
    response = simulate(substitute(made, {f"occupant.{n.path}": OF_SLED[n.name] for n in template.numbers}))
    times = np.arange(0, 1501) * 1e-4
    return TestRecord.of(
        [
            TimeHistory(response.at(channel, times) / 9.80665, "g", interval=1e-4, name=name)
            for name, channel in (("sled x", "vehicle1.acceleration"), ("chest x", "occupant.acceleration"))
        ],
        identifier="sled 7",
    )


def spec(test: TestRecord, **changes: Any) -> dict[str, Any]:
    """A calibration of the adult's restraint to that record."""
    case = {"name": "sled", "scenario": BASE, "record": test, "targets": [CHEST]}
    return {"cases": [case], "parameters": PARAMETERS, "search": {"effort": "quick"}} | changes
