"""What it gains to solve the vehicles once, in studies in which only restraints vary.

    python benchmarks/vehicles_once.py

P1 with its adult, its child, and both; their restraints differ from row to row. Beside it the same crashes with vehicles that
differ by a trillionth, so that each row solves its own. Processor time, of one thread, the least of several turns, in turn.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from ridedown import load, simulate_many
from ridedown.scenario import CrashScenario

ROWS, TURNS = 16_384, 5
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
OUTCOMES = {
    "adult": ("adult.acceleration.peak", "adult.excursion.max"),
    "child": ("child.acceleration.peak", "child.relative_displacement.max"),
}
VEHICLE = ("vehicle1.acceleration.peak", "vehicle1.displacement.max")


def seconds(crash: CrashScenario, table: Mapping[str, Any], outcomes: tuple[str, ...]) -> float:
    """Processor time of one study [s]."""
    begin = time.process_time()
    simulate_many(crash, table, outcomes=outcomes, threads=1)
    return time.process_time() - begin


def main() -> None:
    """Print the comparison."""
    print(f"{'occupants':>12}  {'once':>14}  {'each':>14}  gain")
    p1, rng = load("p1"), np.random.default_rng(0)
    for names in (("adult",), ("child",), ("adult", "child")):
        crash = p1.model_copy(update={"occupants": tuple(each for each in p1.occupants if each.name in names)})
        once = {path: NOMINAL[path] * rng.uniform(0.8, 1.2, ROWS) for name in names for path in VARIED[name]}
        each = once | {"vehicle1.mass": 1500.0 * (1.0 + 1e-12 * np.arange(ROWS) / ROWS)}
        outcomes = (*(outcome for name in names for outcome in OUTCOMES[name]), *VEHICLE)
        turns = [(seconds(crash, once, outcomes), seconds(crash, each, outcomes)) for _ in range(TURNS)]
        least = [1e6 * min(column) / ROWS for column in zip(*turns, strict=True)]
        print(f"{' + '.join(names):>12}  {least[0]:5.1f} us/crash  {least[1]:5.1f} us/crash  {least[1] / least[0]:4.2f}")


if __name__ == "__main__":
    main()
