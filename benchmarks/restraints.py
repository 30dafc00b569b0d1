"""What restraints as they are built cost in a study, beside one plain belt, on the same pulses.

    python benchmarks/restraints.py

The driver of `example-restraints` (three masses, two belts with pretensioners and a two-stage load limiter, two bags, knee
bolster, seat back, head restraint) and the founding paper's adult, in sleds on one half-sine given by so many points. Both
vary two numbers from row to row. Processor time, of one thread, the least of several turns.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from ridedown import load, simulate_many
from ridedown.scenario import SledScenario

ROWS, TURNS = 4096, 5
PEAK, DURATION, SPEED = 230.0, 0.11, 15.5  # m/s2, s, m/s


def sled(name: str, points: int) -> SledScenario:
    """The occupant of a catalogue scenario, on the pulse."""
    times = np.linspace(0.0, DURATION, points)
    values = -PEAK * np.sin(np.pi * times / DURATION)
    occupant = load(name).occupants[0].model_copy(update={"coupled": False})
    pulse: Any = {"kind": "points", "points": [list(pair) for pair in zip(times.tolist(), values.tolist(), strict=True)]}
    return SledScenario(pulse=pulse, speed=SPEED, occupants=(occupant,))


def cost(scenario: SledScenario, table: dict[str, Any], outcome: str) -> tuple[float, float]:
    """Processor time of a crash [us], and its steps."""
    least = np.inf
    for _ in range(TURNS):
        begin = time.process_time()
        many = simulate_many(scenario, table, outcomes=[outcome], threads=1)
        least = min(least, time.process_time() - begin)
    return 1e6 * least / ROWS, float(many.steps.mean())


def main() -> None:
    """Print the comparison."""
    print(f"{'points':>6}  {'plain':>18}  {'everything on':>18}  ratio")
    for points in (10, 30, 60, 150):
        rng = np.random.default_rng(0)
        vary = {"stiffness": rng.uniform(0.8, 1.2, ROWS), "slack": rng.uniform(0.005, 0.03, ROWS)}
        plain = cost(
            sled("paper-adult-full", points),
            {"adult.restraint.stiffness": 98.1e3 * vary["stiffness"], "adult.restraint.slack": vary["slack"]},
            "adult.acceleration.peak",
        )
        full = cost(
            sled("example-restraints", points),
            {
                "driver.shoulder-belt.load_limiter.force": 5.5e3 * vary["stiffness"],
                "driver.shoulder-belt.slack": vary["slack"],
            },
            "driver.chest.acceleration.peak",
        )
        shown = "  ".join(f"{us:7.1f} us {steps:4.0f} steps" for us, steps in (plain, full))
        print(f"{points:>6}  {shown}  {full[0] / plain[0]:5.1f}")


if __name__ == "__main__":
    main()
