"""What restraints as they are built cost in a study, beside one plain belt, on the same pulses.

    python benchmarks/restraints.py

In sleds on one half-sine given by so many points: the founding paper's adult (plain); a driver with a two-stage load limiter,
two pretensioners, airbag, knee bolster and seat back on three masses (everything on); and the driver of `example-restraints`,
who has a lap belt, a second bag and a head restraint, too (more still). All vary two numbers from row to row. Processor time
of one thread: medians of several turns, of the times and of their ratios to the plain belt's in the same turn. After each, the
steps of a crash; after the ratio, how much more there is to work out: masses and elements that give force, over all steps.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from ridedown import load, simulate_many
from ridedown.scenario import SledScenario, lower
from ridedown.solver.solve import solve_one

ROWS, TURNS = 4096, 9
PEAK, DURATION, SPEED = 230.0, 0.11, 15.5  # m/s2, s, m/s
MORE_STILL = ("lap-belt", "head-airbag", "head-restraint")

Study = tuple[SledScenario, dict[str, Any], str]
"""A sled, the table of what varies, and the outcome."""


def sled(name: str, points: int, without: tuple[str, ...] = ()) -> SledScenario:
    """The occupant of a catalogue scenario, on the pulse, without some of the restraints."""
    times = np.linspace(0.0, DURATION, points)
    values = -PEAK * np.sin(np.pi * times / DURATION)
    occupant = load(name).occupants[0]
    kept = tuple(one for one in occupant.restraints if one.name not in without)
    occupant = occupant.model_copy(update={"coupled": False, "restraints": kept})
    pulse: Any = {"kind": "points", "points": [list(pair) for pair in zip(times.tolist(), values.tolist(), strict=True)]}
    return SledScenario(pulse=pulse, speed=SPEED, occupants=(occupant,))


def studies(points: int) -> tuple[Study, Study, Study]:
    """Plain, everything on, and more still."""
    rng = np.random.default_rng(0)
    stiffness, slack = rng.uniform(0.8, 1.2, ROWS), rng.uniform(0.005, 0.03, ROWS)
    plain = {"adult.restraint.stiffness": 98.1e3 * stiffness, "adult.restraint.slack": slack}
    full = {"driver.shoulder-belt.load_limiter.force": 5.5e3 * stiffness, "driver.shoulder-belt.slack": slack}
    return (
        (sled("paper-adult-full", points), plain, "adult.acceleration.peak"),
        (sled("example-restraints", points, MORE_STILL), full, "driver.chest.acceleration.peak"),
        (sled("example-restraints", points), full, "driver.chest.acceleration.peak"),
    )


def cost(study: Study) -> tuple[float, float]:
    """Processor time of a crash [us], and its steps."""
    scenario, table, outcome = study
    begin = time.process_time()
    many = simulate_many(scenario, table, outcomes=[outcome], threads=1)
    return 1e6 * (time.process_time() - begin) / ROWS, float(many.steps.mean())


def to_work_out(scenario: SledScenario) -> int:
    """Masses and elements that give force, over all steps of the crash."""
    network = lower(scenario)
    phases, _stop = solve_one(network)
    masses = len(network.coordinates) - 1  # but for the driven vehicle
    return masses * phases.start.size + int(phases.force.any(axis=1).sum())


def main() -> None:
    """Print the comparison."""
    print(f"{'points':>6}  {'plain':>18}  {'everything on':>36}  {'more still':>36}")
    for points in (10, 30, 60, 150):
        compared = studies(points)
        for study in compared:
            cost(study)  # what is compiled, or loaded, at first
        turns = np.array([[cost(study) for study in compared] for _ in range(TURNS)])
        micros, steps = np.median(turns, axis=0).T
        ratios = np.median(turns[:, :, 0] / turns[:, :1, 0], axis=0)
        work = [to_work_out(study[0]) for study in compared]
        shown = [f"{micros[n]:7.1f} us {steps[n]:4.0f} steps" for n in range(3)]
        shown[1:] = [f"{shown[n]}  {ratios[n]:4.1f} (work {work[n] / work[0]:4.1f})" for n in (1, 2)]
        print(f"{points:>6}  {'  '.join(shown)}")


if __name__ == "__main__":
    main()
