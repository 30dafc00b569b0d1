"""The posterior of the parameters by Markov chains, where bands from derivatives are not trusted.

What is drawn from is `likelihood.Likelihood`, within the bounds.

References: D. Foreman-Mackey, D. Hogg, D. Lang, J. Goodman, emcee: the MCMC hammer, PASP 125, 2013.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput
from ridedown.studies.calibration.likelihood import Likelihood
from ridedown.studies.calibration.problem import Problem
from ridedown.studies.calibration.uncertainty import Uncertainty
from ridedown.studies.calibration.unknowns import values_of

Floats = NDArray[np.float64]

_STEPS, _BURNT = 500, 150
_LEAST_WALKERS = 24


@dataclass(frozen=True, slots=True, eq=False)
class Posterior:
    """Draws (S, n) of the parameters' values, SI, their names, the chains' acceptance and autocorrelation time in steps."""

    names: tuple[str, ...]
    draws: Floats
    acceptance: float
    autocorrelation: float

    def quantiles(self, name: str) -> tuple[float, float, float]:
        """2.5 %, 50 % and 97.5 % of a parameter."""
        low, middle, high = np.quantile(self.draws[:, self.names.index(name)], [0.025, 0.5, 0.975])
        return float(low), float(middle), float(high)

    def as_json(self) -> dict[str, Any]:
        """Quantiles by the parameters' names, and how the chains went."""
        return {
            "parameters": {
                name: dict(zip(("low", "median", "high"), self.quantiles(name), strict=True)) for name in self.names
            },
            "draws": len(self.draws),
            "acceptance": self.acceptance,
            "autocorrelation_steps": self.autocorrelation,
        }


def sample(
    problem: Problem, point: Floats, found: Uncertainty, seed: int, progress: Callable[[str, int, float], None] | None = None
) -> Posterior:
    """Draw from the posterior, starting around the best point. Raises: InvalidInput where emcee is not installed."""
    try:
        import emcee  # noqa: PLC0415  an optional package
    except ImportError:
        raise InvalidInput("posterior: got no package emcee; need it for chains. pip install 'ridedown[posterior]'") from None

    n = point.size
    walkers = max(2 * n + 2, _LEAST_WALKERS)
    rng = np.random.default_rng(seed)
    likelihood = Likelihood.of(problem, point)

    def log_density(points: Floats) -> Floats:
        inside = ((points >= 0.0) & (points <= 1.0)).all(axis=1)
        density = np.full(len(points), -np.inf)
        if inside.any():
            density[inside] = likelihood(points[inside])
        return density

    spread = np.linalg.cholesky(found.within_box + 1e-12 * np.eye(n))
    start = np.clip(point + 0.5 * rng.standard_normal((walkers, n)) @ spread.T, 1e-6, 1.0 - 1e-6)
    sampler = emcee.EnsembleSampler(walkers, n, log_density, vectorize=True)
    state = emcee.State(start, random_state=np.random.RandomState(rng.integers(2**32)).get_state())
    for step, _ in enumerate(sampler.sample(state, iterations=_STEPS), 1):
        if progress is not None:
            progress("posterior", step * walkers, float("nan"))
    tau = float(np.max(sampler.get_autocorr_time(quiet=True, tol=0)))
    draws = sampler.get_chain(discard=_BURNT, flat=True)
    return Posterior(
        tuple(unknown.name for unknown in problem.unknowns),
        values_of(problem.unknowns, draws),
        float(np.mean(sampler.acceptance_fraction)),
        tau,
    )
