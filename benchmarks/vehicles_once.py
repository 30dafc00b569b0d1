"""What it gains to solve once what is the same in every row: vehicles, in studies in which only restraints vary.

    python benchmarks/vehicles_once.py

P1 with restraints that differ from row to row: its adult's, its child's, both; and the adult's alone while the child sits by.
Beside it the same crashes with vehicles that differ by a trillionth, so that each row solves its own; and the same with cars
that differ as much as the restraints do, as in a study of everything. Processor time of one thread, in turn: medians, and
medians of the ratios of each turn.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from ridedown import load, simulate_many
from ridedown.scenario import CrashScenario

ROWS, TURNS = 16_384, 9
"""Rows of a table: as many as a study solves at once."""
VARIED = {
    "adult": ("adult.restraint.stiffness", "adult.restraint.damping"),
    "child": (
        "child.restraint.stiffness",
        "child.restraint.damping",
        "child.seat.restraint.stiffness",
        "child.seat.restraint.damping",
    ),
}
NOMINAL = {
    "adult.restraint.stiffness": 98.1e3,
    "adult.restraint.damping": 2801.0,
    "child.restraint.stiffness": 49e3,
    "child.restraint.damping": 939.0,
    "child.seat.restraint.stiffness": 50e3,
    "child.seat.restraint.damping": 500.0,
}  # N/m, N s/m
CARS = {
    ("vehicle1.mass",): 1500.0,
    ("vehicle2.mass",): 1500.0,
    ("vehicle1.members.pieces.0.stiffness", "vehicle2.members.pieces.0.stiffness"): 118.2e3,
    ("vehicle1.members.pieces.1.stiffness", "vehicle2.members.pieces.1.stiffness"): 465e3,
    ("vehicle1.members.pieces.0.until", "vehicle2.members.pieces.0.until"): 0.356,
    ("vehicle1.speed", "vehicle2.speed"): 13.33,
}  # kg, N/m, m, m/s
OUTCOMES = {
    "adult": ("adult.acceleration.peak", "adult.excursion.max"),
    "child": ("child.acceleration.peak", "child.relative_displacement.max"),
}
VEHICLE = ("vehicle1.acceleration.peak", "vehicle1.displacement.max")
CASES = (("adult",), ("adult",)), (("child",), ("child",)), (("adult", "child"),) * 2, (("adult", "child"), ("adult",))
"""Who is in the car, and whose restraints vary."""


def seconds(crash: CrashScenario, table: Mapping[str, Any], outcomes: tuple[str, ...]) -> float:
    """Processor time of one study [s]."""
    begin = time.process_time()
    simulate_many(crash, table, outcomes=outcomes, threads=1)
    return time.process_time() - begin


def main() -> None:
    """Print the comparison."""
    print(
        f"{'in the car':>13} {'varied':>13}  {'once':>13}  {'each':>13}  {'all varied':>13}  gain: once/each  once/all varied"
    )
    whole, rng = load("p1"), np.random.default_rng(0)
    cars = {paths: value * rng.uniform(0.8, 1.2, ROWS) for paths, value in CARS.items()}
    for names, varied in CASES:
        crash = whole.model_copy(update={"occupants": tuple(one for one in whole.occupants if one.name in names)})
        once = {path: NOMINAL[path] * rng.uniform(0.8, 1.2, ROWS) for name in varied for path in VARIED[name]}
        each = once | {"vehicle1.mass": 1500.0 * (1.0 + 1e-12 * np.arange(ROWS) / ROWS)}
        all_varied = once | {path: column for paths, column in cars.items() for path in paths}
        outcomes = (*(outcome for name in names for outcome in OUTCOMES[name]), *VEHICLE)
        turns = np.array([[seconds(crash, t, outcomes) for t in (once, each, all_varied)] for _ in range(TURNS + 1)])[1:]
        us = 1e6 * np.median(turns, axis=0) / ROWS
        gains = np.median(turns[:, 1:] / turns[:, :1], axis=0)
        times = "  ".join(f"{one:5.1f} us/crash" for one in us)
        print(f"{' + '.join(names):>13} {' + '.join(varied):>13}  {times}  {gains[0]:15.2f}  {gains[1]:15.2f}")


if __name__ == "__main__":
    main()
