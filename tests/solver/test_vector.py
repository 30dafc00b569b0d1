"""Vectors as values: each operation against numpy's on the same eight numbers."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest

import ridedown.solver.vector_instructions  # noqa: F401 - teaches numba what vectors are
from ridedown.solver.vector import (
    ALL_LANES,
    WIDTH,
    binary_exponent,
    first_lane,
    floor,
    lanes_of,
    load,
    power_of_two,
    spread,
    store,
    union,
    where,
)

njit: Any = numba.njit(error_model="numpy")


@njit
def arithmetic(a, b, out):
    x, y = load(a, 0), load(b, 0)
    store(out, 0, x + y)
    store(out, 8, x - 2.0 * y)
    store(out, 16, x / y)
    store(out, 24, -x * 3)
    store(out, 32, abs(x))
    store(out, 40, min(x, y))
    store(out, 48, max(x, 0.0))
    store(out, 56, floor(x))
    total = spread(1.0)
    total += x
    total -= y
    total *= 2.0
    store(out, 64, total)


@njit
def comparisons(a, b, bits):
    x, y = load(a, 0), load(b, 0)
    bits[0], bits[1], bits[2], bits[3] = lanes_of(x < y), lanes_of(x <= y), lanes_of(x > 0.0), lanes_of(x >= y)
    bits[4], bits[5], bits[6] = lanes_of(x == y), lanes_of((x < y) & (x > 0.0)), lanes_of((x < y) | (x > 0.0))


@njit
def chosen(a, b, out):
    x, y = load(a, 0), load(b, 0)
    store(out, 0, where(x < y, x, -1.0))


@njit
def lanes_in_turn(bits, out):
    n = 0
    while bits != 0:
        out[n] = first_lane(bits)
        bits &= bits - 1
        n += 1
    return n


@njit
def united(whole, index):
    return union(whole, index)


@njit
def taken_apart(a, out):
    exponent, fraction = binary_exponent(load(a, 0))
    store(out, 0, exponent)
    store(out, 8, fraction)
    store(out, 16, power_of_two(exponent) * fraction)


@pytest.fixture
def pair() -> tuple[np.ndarray, np.ndarray]:
    return np.array([1.5, -2.0, 3.0, 0.0, 7.0, -1e300, 4.0, 2.5]), np.array([1.0, 2.0, 3.0, 5.0, -7.0, 1e-3, 8.0, np.inf])


def as_bits(mask: np.ndarray) -> int:
    return int((mask << np.arange(WIDTH)).sum())


def test_arithmetic_is_numpys(pair) -> None:
    a, b = pair
    out = np.zeros(72)
    arithmetic(a, b, out)
    expected = [a + b, a - 2 * b, a / b, -3 * a, abs(a), np.minimum(a, b), np.maximum(a, 0), np.floor(a), (1 + a - b) * 2]
    np.testing.assert_array_equal(out.reshape(9, 8), expected)


def test_comparisons_are_numpys(pair) -> None:
    a, b = pair
    bits = np.zeros(7, dtype=np.int64)
    comparisons(a, b, bits)
    masks = [a < b, a <= b, a > 0, a >= b, a == b, (a < b) & (a > 0), (a < b) | (a > 0)]
    assert bits.tolist() == [as_bits(mask) for mask in masks]


def test_what_is_no_number_compares_false_and_stays_where_it_comes_first() -> None:
    nan, one = np.full(WIDTH, np.nan), np.ones(WIDTH)
    bits = np.zeros(7, dtype=np.int64)
    comparisons(nan, one, bits)
    assert not bits.any()
    out = np.zeros(72)
    arithmetic(nan, one, out)
    assert np.isnan(out[40:56]).all()


def test_where_chooses_lane_by_lane(pair) -> None:
    a, b = pair
    out = np.zeros(8)
    chosen(a, b, out)
    np.testing.assert_array_equal(out, np.where(a < b, a, -1.0))


@pytest.mark.parametrize(("bits", "lanes"), [(0, []), (1, [0]), (0b10100110, [1, 2, 5, 7]), (ALL_LANES, list(range(8)))])
def test_lanes_come_in_turn(bits, lanes) -> None:
    out = np.zeros(WIDTH, dtype=np.int64)
    assert out[: lanes_in_turn(bits, out)].tolist() == lanes


def test_a_union_has_the_bits_of_eight_whole_numbers() -> None:
    whole = np.array([1 << 40, 1, 2, 2, 0, 16, 0, 128, 0, 1 << 62])
    assert united(whole, 0) == 1 << 40 | 1 | 2 | 16 | 128
    assert united(whole, 1) == 1 | 2 | 16 | 128
    assert united(np.zeros(8, dtype=np.int64), 0) == 0


def test_a_number_is_its_fraction_times_a_power_of_two() -> None:
    a = np.array([1.0, 0.75, 3.999, 1e-300, 1e300, 2.0, 6.0, 1023.0])
    out = np.zeros(24)
    taken_apart(a, out)
    fraction, exponent = np.frexp(a)
    np.testing.assert_array_equal(out.reshape(3, 8), [exponent - 1.0, 2.0 * fraction, a])
