"""Polynomials side by side: their changes of sign and their roots, against numpy's roots of each."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ridedown.compiled import kernel
from ridedown.network.model import Floats
from ridedown.solver import together
from ridedown.solver.layout import DEGREE, STRIDE
from ridedown.solver.vector import WIDTH, store


@kernel
def changes(degree: int, shape: Floats, out: Floats) -> None:
    falls, rises, place = together.sign_changes(degree, shape)
    store(out, 0, falls)
    store(out, 8, rises)
    store(out, 16, place)


@kernel
def roots(count: int, falling: Floats) -> None:
    together.solve(count, falling)


@pytest.fixture(scope="module", autouse=True)
def _compiled_anew() -> None:
    made: Any
    for made in (changes, roots):
        made.folder = None  # what is kept for this folder would not notice a change of the solver


def counted(polynomials: Floats) -> Floats:
    """Falls, rises and places (3, 8) of polynomials (8, n), ascending powers."""
    shape = np.zeros((DEGREE + 1) * STRIDE)
    for order, coefficients in enumerate(polynomials.T):
        shape[order * STRIDE : order * STRIDE + WIDTH] = coefficients
    out = np.zeros(3 * WIDTH)
    changes(polynomials.shape[1] - 1, shape, out)
    return out.reshape(3, WIDTH)


def crossings(polynomial: Floats) -> tuple[Floats, Floats]:
    """Where a polynomial falls through zero on [0, 1], and where it rises, by the eigenvalues of its companion matrix."""
    found = np.roots(polynomial[::-1])
    real = np.sort(found[(np.abs(found.imag) < 1e-9) & (found.real > 0.0) & (found.real < 1.0)].real)
    slope = np.polyval(np.polyder(polynomial[::-1]), real)
    return real[slope < 0.0], real[slope > 0.0]


@pytest.mark.parametrize("degree", [3, 8, DEGREE - 1, DEGREE])
def test_no_fewer_changes_than_roots_and_exact_where_there_is_one(degree: int) -> None:
    rng = np.random.default_rng(degree)
    none = one = 0
    for _ in range(100):
        polynomials = rng.normal(size=(WIDTH, degree + 1)) * rng.uniform(0.2, 1.0, (WIDTH, 1)) ** np.arange(degree + 1)
        polynomials[:, 0] += rng.uniform(-1.0, 3.0, WIDTH)
        for polynomial, (falls, rises, place) in zip(polynomials, counted(polynomials).T, strict=True):
            down, up = crossings(polynomial)
            assert down.size <= falls
            assert up.size <= rises
            none += falls + rises == 0.0
            if falls + rises == 1.0:
                one += 1
                assert (down.size, up.size) == (falls, rises)
                assert place == pytest.approx(float([*down, *up][0]), abs=0.3)
    assert min(none, one) > 50  # or nothing was tried


def test_a_coefficient_of_zero_is_both() -> None:
    polynomials = np.zeros((WIDTH, 4))
    polynomials[0] = 1.0, -1.0, 0.0, 0.0  # zero at the end
    polynomials[1, 1] = 1.0  # zero at the start
    polynomials[2] = 1.0, -4.0, 4.0, 0.0  # touches zero in the middle
    polynomials[3:, 0] = 1.0
    falls, rises, _ = counted(polynomials)
    assert (falls[:3] > 0.0).all()
    assert (rises[:2] > 0.0).all()
    assert falls[2] == rises[2]
    assert not falls[3:].any()
    assert not rises[3:].any()


def test_roots_that_newton_finds_and_those_it_does_not() -> None:
    falling = np.zeros(together.ROWS * STRIDE)
    rng = np.random.default_rng(5)
    expected = []
    for x in range(24):
        root = rng.uniform(0.01, 0.99)
        steep = 3 if x % 3 == 0 else 1  # of a triple root Newton's method gets nearer by a third each time: halving finds it
        coefficients = np.polynomial.polynomial.polypow([root, -1.0], steep)
        for order, coefficient in enumerate(coefficients):
            falling[order * STRIDE + x] = coefficient
        falling[together.ROOT * STRIDE + x] = rng.uniform(0.0, 1.0)
        expected.append((root, 1e-4 if steep > 1 else 1e-15))
    roots(24, falling)
    for x, (root, within) in enumerate(expected):
        assert falling[together.ROOT * STRIDE + x] == pytest.approx(root, abs=within)


@pytest.mark.parametrize(("beyond", "start"), [(-3e-18, 1e-18), (-1e-14, 0.0), (1.0 + 1e-13, 1.0)])
def test_a_root_just_beyond_the_interval_is_not_taken_for_the_one_in_it(beyond: float, start: float) -> None:
    falling = np.zeros(together.ROWS * STRIDE)
    sign = 1.0 if beyond > 0.0 else -1.0
    for order, coefficient in enumerate(np.polynomial.polynomial.polymul([beyond * sign, -sign], [0.3, -1.0])):
        falling[order * STRIDE] = coefficient
    falling[together.ROOT * STRIDE] = start
    roots(1, falling)
    assert falling[together.ROOT * STRIDE] == pytest.approx(0.3, abs=1e-15)
