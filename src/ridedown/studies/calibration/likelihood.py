"""How likely the measurements are, for parameters: errors of a channel as independent normal values, as many as it is worth.

A channel's errors have the standard deviation that the fit leaves; its samples are thinned to what the filter leaves
independent, and count for less where neighbours are alike all the same (see `uncertainty`). Numbers have the deviation that the
file states. Priors are the file's own, and even within the bounds on the scales of the search.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ridedown.studies.calibration.problem import Problem
from ridedown.studies.calibration.targets import ChannelTarget, Evaluation
from ridedown.studies.calibration.uncertainty import noise_of
from ridedown.studies.calibration.unknowns import values_of

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Likelihood:
    """The log of the likelihood of points of the unit cube, as a function: (R, n) to (R,), less a constant.

    noise: by case and channel, what the squares of its errors are divided by.
    """

    problem: Problem
    noise: Mapping[tuple[str, str], float]

    @classmethod
    def of(cls, problem: Problem, point: Floats) -> Likelihood:
        """With the noise that the best point (n,) leaves."""
        noise = {}
        for case in problem.cases:
            evaluation = case.evaluate(values_of(problem.unknowns, point[None]))
            for target in case.channels:
                thinned = _errors(target, evaluation)[0, :: target.thinning]
                found = noise_of(thinned, np.zeros((thinned.size, 0)))
                tied = target.thinning * max((1.0 + found.phi) / (1.0 - found.phi), 1.0)
                noise[case.name, target.name] = max(found.deviation**2, 1e-300) * tied
        return cls(problem, noise)

    def __call__(self, points: Floats) -> Floats:
        """Minus infinity where a point cannot be."""
        values = values_of(self.problem.unknowns, points)
        total = np.zeros(len(points))
        for case in self.problem.cases:
            evaluation = case.evaluate(values)
            for target in case.channels:
                total += (_errors(target, evaluation) ** 2).sum(axis=1) / self.noise[case.name, target.name]
            for number in case.numbers:
                total += (number.residuals(evaluation.outcomes[number.name]) ** 2).sum(axis=1)
        for i, unknown in enumerate(self.problem.unknowns):
            if unknown.prior is not None:
                total += ((values[:, i] - unknown.prior[0]) / unknown.prior[1]) ** 2
        return np.where(np.isnan(total), -np.inf, -0.5 * total)


def _errors(target: ChannelTarget, evaluation: Evaluation) -> Floats:
    assert target.measured is not None, "checked when the file was read"
    return evaluation.channels[target.name] - target.measured
