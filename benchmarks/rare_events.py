"""How often intervals of `rare_event` hold the exact probability: a plane at 3 to 5 standard deviations, 1 to 15 parameters.

python benchmarks/rare_events.py [SEEDS]
"""

from __future__ import annotations

import sys
from collections.abc import Mapping

import numpy as np
from scipy.special import ndtr

from ridedown.studies.analysis.designs import Variables
from ridedown.studies.analysis.evaluation import Floats, Limit
from ridedown.studies.analysis.importance import rare_event
from ridedown.studies.distributions import Normal


def plane(table: Mapping[str, Floats]) -> dict[str, Floats]:
    """A standard normal outcome."""
    return {"y": np.sum(list(table.values()), axis=0) / len(table) ** 0.5}


def main(seeds: int = 60) -> None:
    """Print a line for each number of parameters and each distance."""
    print("parameters  distance  held  rows in all  mean / exact  effective, least  warned")
    for count in (1, 2, 6, 15):
        variables = Variables({f"x{i}": Normal(mean=0.0, sd=1.0) for i in range(count)})
        for distance in (3.0, 4.0, 5.0):
            exact = float(ndtr(-distance))
            limit = Limit("y", most=distance)
            found = [rare_event(plane, variables, limit, rows=4000, level_rows=1000, seed=seed) for seed in range(seeds)]
            held = np.mean([one.probability.low < exact < one.probability.high for one in found])
            rows = np.mean([one.evaluations for one in found])
            ratio = np.mean([one.probability.value for one in found]) / exact
            effective = [one.effective for one in found]
            warned = sum(bool(one.warnings) for one in found)
            numbers = f"{count:10} {distance:9g} {held:5.0%} {rows:12.0f} {ratio:13.3f}"
            print(numbers, f"{np.mean(effective):9.0f} {min(effective):5.0f} {warned:9}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
