"""First roots and maxima on [0, 1] against numpy's roots and dense sampling."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from ridedown.solver import polynomial
from tests.samples import examples

Floats = NDArray[np.float64]

ROOM = np.zeros(polynomial.WORK_SHAPE)
GRID = np.linspace(0.0, 1.0, 4001)
COEFFICIENTS = st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=13)


def first_root(p: Floats | list[float], first: int = 0) -> float:
    return float(polynomial.first_root(np.array(p[first:], dtype=float), ROOM))


def maximum(p: Floats | list[float], best: float = -np.inf) -> tuple[float, float]:
    value, where = polynomial.maximum(np.array(p, dtype=float), best, ROOM)
    return float(value), float(where)


def with_roots(roots: list[float], factor: float = 1.0) -> Floats:
    """The polynomial with these roots, positive at 0."""
    p = Polynomial.fromroots(roots) if roots else Polynomial([1.0])
    coefficients: Floats = p.coef * np.sign(p.coef[0]) * factor
    return coefficients


@examples(200)
@given(roots=st.lists(st.floats(0.01, 1.5), min_size=1, max_size=9), factor=st.floats(1e-8, 1e8))
def test_simple_roots(roots: list[float], factor: float) -> None:
    roots = sorted(roots)
    assume(all(b - a > 0.05 for a, b in pairwise(roots)))
    assume(all(abs(root - 1.0) > 1e-9 for root in roots))
    p = with_roots(roots, factor)
    if roots[0] > 1.0:
        assert first_root(p) == polynomial.NO_ROOT
    else:
        assert first_root(p) == pytest.approx(roots[0], abs=1e-8)


@examples(300)
@given(p=COEFFICIENTS)
def test_nothing_is_negative_before_the_root_and_something_is_after(p: list[float]) -> None:
    assume(p[0] > 1e-12)
    root, values = first_root(p), Polynomial(p)(GRID)
    round_off = 1e-14 * np.abs(p).sum()
    assert values[root > GRID].min() >= -round_off
    if root <= 1.0:
        assert abs(Polynomial(p)(root)) <= 1e-9 * np.abs(p).sum()
        after = root + np.geomspace(1e-9, 1e-3, 20)
        assert Polynomial(p)(after).min() < round_off


@examples(300)
@given(p=COEFFICIENTS)
def test_first_root_is_that_of_numpy(p: list[float]) -> None:
    assume(p[0] > 1e-6 and abs(p[-1]) > 1e-3)
    found = np.roots(p[::-1])
    real = np.sort(found[np.abs(found.imag) < 1e-9].real)
    inside = real[(real > 1e-9) & (real < 1.0 - 1e-9)]
    slopes = np.abs(Polynomial(p).deriv()(inside))
    assume(inside.size == 0 or slopes.min() > 1e-3)  # a touch may be read either way
    # a pair of roots just off the axis is a dip that nearly touches
    assume(not np.any((np.abs(found.imag) < 1e-4) & (np.abs(found.imag) >= 1e-9)))
    assume(not np.any(np.abs(found - 1.0) < 1e-6))
    expected = inside[0] if inside.size else polynomial.NO_ROOT
    assert first_root(p) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("depth", [1e-2, 1e-5, 1e-8, 1e-10])
@examples(40)
@given(where=st.floats(0.02, 0.98), others=st.lists(st.floats(2.0, 3.0), max_size=6))
def test_dips_that_nearly_touch(depth: float, where: float, others: list[float]) -> None:
    # (t - where)^2 +- depth, times what is positive on [0, 1]
    rest = Polynomial(with_roots(others))
    rest = rest if rest(0.0) > 0.0 else -rest
    dip = Polynomial([where**2, -2.0 * where, 1.0])
    assert first_root(((dip + depth) * rest).coef) == polynomial.NO_ROOT
    if np.sqrt(depth) < where:
        assert first_root(((dip - depth) * rest).coef) == pytest.approx(where - np.sqrt(depth), abs=1e-9 / np.sqrt(depth))


@examples(100)
@given(where=st.floats(0.02, 0.98), others=st.lists(st.floats(1.1, 3.0), max_size=8))
def test_a_touch_is_no_event_or_an_event_where_it_touches(where: float, others: list[float]) -> None:
    p = (Polynomial([where**2, -2.0 * where, 1.0]) * Polynomial(with_roots(others))).coef
    root = first_root(p * np.sign(p[0]))
    assert root == polynomial.NO_ROOT or root == pytest.approx(where, abs=1e-5)


@examples(100)
@given(where=st.floats(0.05, 0.9), more=st.floats(0.01, 0.05))
def test_a_triple_root_and_a_root_behind_a_touch(where: float, more: float) -> None:
    assert first_root(with_roots([where] * 3)) == pytest.approx(where, abs=2e-5)  # as well as a cube root of rounding lets it
    root = first_root(with_roots([where, where, where + more]))
    assert root == pytest.approx(where + more, abs=1e-7) or root == pytest.approx(where, abs=1e-6)


@pytest.mark.parametrize("end", [0.5, 0.75, 1.0])
@pytest.mark.parametrize("first", [0.125, 0.25, 0.375, 0.3, 0.4999])
def test_a_root_that_another_one_at_the_end_of_its_interval_must_not_hide(first: float, end: float) -> None:
    # halving ends intervals at such places, and an event of another guard ends the step
    assert first_root(with_roots([first, end])) == pytest.approx(first, abs=1e-9)
    assert first_root(with_roots([first, end, 1.0912133091105334, 1.4375])) == pytest.approx(first, abs=1e-9)
    up = Polynomial(with_roots([first, end])).integ()  # highest where it first levels out
    assert maximum(up.coef)[0] == pytest.approx(max(up(first), up(1.0)), rel=1e-12)


def test_roots_at_the_ends() -> None:
    assert first_root([1.0, -1.0]) in {1.0, polynomial.NO_ROOT}  # the next step starts there, and will see to it
    assert first_root([1.0, -1.0 + 1e-12]) == polynomial.NO_ROOT
    assert first_root([1e-12, -1.0]) == pytest.approx(1e-12, rel=1e-9)
    assert first_root([1e-300, -1.0]) == pytest.approx(1e-300, abs=1e-14)
    assert first_root([1.0]) == polynomial.NO_ROOT
    assert first_root([1.0, 0.0, 0.0]) == polynomial.NO_ROOT


def test_the_root_at_zero_is_divided_out() -> None:
    p = np.array([0.0, 0.3, -1.0])  # t (0.3 - t)
    assert first_root(p, 1) == pytest.approx(0.3, rel=1e-14)
    assert first_root(np.array([0.0, 0.0, 0.3, -1.0]), 2) == pytest.approx(0.3, rel=1e-14)


def test_the_first_of_many_roots() -> None:
    roots = [0.05, 0.15, 0.3, 0.42, 0.55, 0.61, 0.7, 0.83, 0.91, 0.97]
    assert first_root(with_roots(roots)) == pytest.approx(0.05, abs=1e-12)
    assert first_root(with_roots(roots[1:])) == pytest.approx(0.15, abs=1e-11)
    assert first_root(with_roots(roots[5:])) == pytest.approx(0.61, abs=1e-12)


@examples(300)
@given(p=COEFFICIENTS)
def test_maximum(p: list[float]) -> None:
    value, where = maximum(p)
    poly = Polynomial(p)
    assert 0.0 <= where <= 1.0
    size = np.abs(p).sum()
    if size > 0.0:
        assume(abs(p[-1]) > 1e-6)
    assert poly(where) == pytest.approx(value, abs=1e-14 * size)
    assert value >= poly(GRID).max() - 1e-14 * size
    turns = poly.deriv().roots()
    turns = turns[(np.abs(turns.imag) < 1e-6) & (turns.real > 0.0) & (turns.real < 1.0)].real
    assert value == pytest.approx(max(poly(t) for t in (0.0, 1.0, *turns)), abs=1e-11 * max(size, 1e-300))


@examples(100)
@given(p=COEFFICIENTS, best=st.floats(-2.0, 4.0))
def test_a_maximum_below_the_best_so_far_is_passed_over(p: list[float], best: float) -> None:
    value, where = maximum(p)
    assume(abs(value - best) > 1e-12)
    assert maximum(p, best) == ((value, where) if value > best else (best, -1.0))


def test_a_constant_and_a_line() -> None:
    assert maximum([3.0]) == (3.0, 0.0)
    assert maximum([3.0, 1.0]) == (4.0, 1.0)
    assert maximum([3.0, -1.0]) == (3.0, 0.0)
    assert maximum([0.0, 1.0, -1.0]) == pytest.approx((0.25, 0.5))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("at", [0, 1, 5])
def test_what_is_not_a_number_does_not_hang(bad: float, at: int) -> None:
    p = np.array([1.0, -0.5, 0.25, -0.125, 0.0625, -0.5])
    p[at] = bad
    first_root(p)
    maximum(p)
