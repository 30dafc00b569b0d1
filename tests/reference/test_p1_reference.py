"""The benchmark's own reference for P1 against the answers of two other methods, and against itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks import p1_reference

VECTORS = Path(__file__).resolve().parents[3] / "shared" / "vectors" / "p1.npz"

needs_vectors = pytest.mark.skipif(not VECTORS.exists(), reason="the shared reference answers are not beside this repository")


@needs_vectors
def test_all_reference_sets_are_met() -> None:
    vectors = np.load(VECTORS)
    outputs, status = p1_reference.solve(vectors["params"])
    assert not status.any()
    # two methods gave the reference answers, 1e-13 apart
    np.testing.assert_allclose(outputs, vectors["outputs"], rtol=1e-12)


@needs_vectors
def test_coincident_events_of_the_nominal_crash() -> None:
    # alike cars: springs meet their knees in pairs, adult and seat close their slacks at one instant
    outputs, _ = p1_reference.solve(p1_reference.NOMINAL)
    np.testing.assert_allclose(outputs[0], np.load(VECTORS)["nominal_outputs"], rtol=1e-12)


@needs_vectors
def test_random_sets_are_those_of_the_benchmark() -> None:
    np.testing.assert_array_equal(p1_reference.random_sets(200), np.load(VECTORS)["params"])


@pytest.mark.parametrize("spread", [0.2, 0.5])
def test_the_step_does_not_matter(spread: float) -> None:
    params = p1_reference.random_sets(60, seed=11, spread=spread)
    outputs, status = p1_reference.solve(params)
    others, _ = p1_reference.solve(params, step=2.3e-4)
    assert not status.any()
    np.testing.assert_allclose(outputs, others, rtol=3e-12)
