"""A seeded global search for the least of a function that is cheap in batches: CMA-ES with restarts.

References: N. Hansen, The CMA evolution strategy: a tutorial, 2016 (arXiv:1604.00772), whose names and constants these are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Objective = Callable[[Floats], Floats]
"""Candidates in the unit cube, shape (R, n), to their values, shape (R,); infinity for one that cannot be."""

_STILL = 1e-6
"""A run ends when its steps are this small, as a fraction of the box."""


@dataclass(frozen=True, slots=True)
class Found:
    """The best candidate of a run, shape (n,) in the unit cube, its value, and how many were tried in all so far."""

    best: Floats
    value: float
    tried: int


@dataclass(frozen=True, slots=True)
class Effort:
    """How hard to search: restarts, and for each a random sample to start from and generations of so many candidates.

    A run that has not gained a hundredth in `patience` generations is given up.
    """

    restarts: int = 8
    sample: int = 1024
    population: int = 128
    generations: int = 400
    patience: int = 60


def runs(objective: Objective, dimensions: int, effort: Effort, rng: np.random.Generator) -> Iterator[Found]:
    """Search the unit cube again and again, each time from the best of a new random sample; the caller decides when to stop."""
    tried = 0
    for _ in range(effort.restarts):
        sample = rng.random((effort.sample, dimensions))
        start = sample[np.argmin(objective(sample))]
        best, value, generations = _evolve(objective, start, effort, rng)
        tried += effort.sample + generations * effort.population
        yield Found(best, value, tried)


def _evolve(objective: Objective, start: Floats, effort: Effort, rng: np.random.Generator) -> tuple[Floats, float, int]:
    """One run of CMA-ES: the best candidate, its value, and the generations taken."""
    n, size = len(start), effort.population
    weights = np.log(size / 2 + 0.5) - np.log(np.arange(1, size // 2 + 1))
    weights /= weights.sum()
    mass = 1.0 / (weights**2).sum()  # mu_eff
    c_c, c_s = 4 / (n + 4), (mass + 2) / (n + mass + 5)
    c_1 = 2 / ((n + 1.3) ** 2 + mass)
    c_mu = min(1 - c_1, 2 * (mass - 2 + 1 / mass) / ((n + 2) ** 2 + mass))
    damping = 1 + c_s + 2 * max(0.0, np.sqrt((mass - 1) / (n + 1)) - 1)
    expected = np.sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n))

    mean, step, covariance = start.copy(), 0.2, np.eye(n)
    path_s, path_c = np.zeros(n), np.zeros(n)
    best, value, milestone, since = start, np.inf, np.inf, 0
    for generation in range(1, effort.generations + 1):
        variances, axes = np.linalg.eigh(covariance)
        lengths = np.sqrt(np.maximum(variances, 1e-20))
        raw = mean + step * (rng.standard_normal((size, n)) * lengths) @ axes.T
        inside = np.clip(raw, 0.0, 1.0)
        values = objective(inside)
        # a candidate outside counts as the nearest one inside, and a little worse the farther out it is
        outside = (((raw - inside) / step) ** 2).sum(axis=1)
        order = np.argsort(values + 1e-2 * outside, kind="stable")[: len(weights)]
        if values[order[0]] < value:
            best, value = inside[order[0]], float(values[order[0]])
        if value < 0.99 * milestone:
            milestone, since = value, 0
        since += 1
        if since > effort.patience or step * lengths.max() < _STILL:
            return best, value, generation

        moves = (inside[order] - mean) / step
        move = weights @ moves
        mean = mean + step * move
        path_s = (1 - c_s) * path_s + np.sqrt(c_s * (2 - c_s) * mass) * (axes @ ((axes.T @ move) / lengths))
        path_c = (1 - c_c) * path_c + np.sqrt(c_c * (2 - c_c) * mass) * move
        covariance = (1 - c_1 - c_mu) * covariance + c_1 * np.outer(path_c, path_c) + c_mu * (moves.T * weights) @ moves
        step = min(step * float(np.exp(c_s / damping * (np.linalg.norm(path_s) / expected - 1))), 0.5)
    return best, value, effort.generations
