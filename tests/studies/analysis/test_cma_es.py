"""The global search finds what is known, and a seed counts."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown.studies.analysis.cma_es import Effort, runs


@pytest.mark.parametrize("dimensions", [2, 5])
def test_the_search_finds_the_bottom_of_a_curved_valley(dimensions):
    def rosenbrock(points):
        x = 4.0 * points - 2.0
        return (100.0 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1.0 - x[:, :-1]) ** 2).sum(axis=1)

    effort = Effort(restarts=4, sample=128, population=32, generations=600, patience=60)
    best = min(runs(rosenbrock, dimensions, effort, np.random.default_rng(3)), key=lambda run: run.value)
    np.testing.assert_allclose(4.0 * best.best - 2.0, 1.0, atol=1e-3)


def test_the_search_finds_a_corner_of_the_box_and_passes_by_what_cannot_be():
    def objective(points):
        return np.where(points[:, 0] > 0.7, np.inf, points.sum(axis=1))

    found = next(runs(objective, 3, Effort(sample=32, population=24), np.random.default_rng(0)))
    np.testing.assert_allclose(found.best, 0.0, atol=1e-6)
