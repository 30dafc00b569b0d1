"""The four scores of ISO/TS 18571 against the package of its makers, and against loops over whole matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from ridedown.criteria.agreement import agreement
from tests.criteria import rating_twins as twins
from tests.criteria.rating_twins import Floats
from tests.samples import examples

KINDS = ("wave", "walk", "noise", "steps", "box", "corners", "integers")


def curve(rng: np.random.Generator, size: int, kind: str) -> Floats:
    t = np.linspace(0.0, 1.0, size)
    made: Floats
    match kind:
        case "wave":
            made = np.sin(7.0 * t + rng.normal()) * np.exp(-t * rng.uniform(0.0, 3.0))
        case "walk":
            made = np.cumsum(rng.normal(size=size))
        case "noise":
            made = rng.normal(size=size)
        case "steps":  # flat pieces, and many ways of equal cost
            made = np.round(3.0 * np.sin(9.0 * t + rng.normal()))
        case "box":
            made = np.where(np.abs(t - rng.uniform(0.2, 0.8)) < rng.uniform(0.02, 0.2), 1.0, 0.0)
        case "corners":
            knots = [0.0, rng.uniform(0.1, 0.4), rng.uniform(0.5, 0.8), 1.0]
            made = np.interp(t, knots, [0.0, *rng.integers(-3, 4, 2), 0.0])
        case _:
            made = rng.integers(0, 3, size).astype(float)
    return made


def pair(seed: int, sizes: tuple[int, int]) -> tuple[Floats, Floats]:
    """Two curves that have nothing to do with each other, or one and what became of it."""
    rng = np.random.default_rng(seed)
    size = int(rng.integers(*sizes))
    one, other = curve(rng, size, rng.choice(KINDS)), curve(rng, size, rng.choice(KINDS))
    match rng.integers(4):
        case 0:
            other = one * rng.uniform(0.5, 1.5) + rng.choice([0.0, 0.1, 1.0])
        case 1:
            other = np.roll(one, rng.integers(-size // 4, size // 4))
        case 2:
            other = one + 0.2 * other
        case _:
            pass
    return one * 10.0 ** rng.integers(-3, 4), other * 10.0 ** rng.choice([-3, 0, 0, 0, 3])


@examples(250)
@given(st.integers(0, 2**32 - 1))
def test_scores_are_those_of_the_package(seed: int) -> None:
    one, other = pair(seed, (101, 300))
    assume(np.ptp(one) > 0.0 and np.ptp(other) > 0.0)
    assume(twins.told_apart(one, other))
    assert agreement(one, other)[:4] == pytest.approx(twins.by_package(one, other), abs=1e-12)


@examples(150)
@given(st.integers(0, 2**32 - 1))
def test_scores_are_those_of_loops_over_whole_matrices(seed: int) -> None:
    one, other = pair(seed, (101, 130))
    assume(np.ptp(one) > 0.0 and np.ptp(other) > 0.0)
    found = agreement(one, other)
    assert found[:4] == pytest.approx(twins.by_loops(one, other), abs=1e-12)
    assert found[4] == twins.first_best_shift(one, other)


@pytest.mark.parametrize("seed", range(3))
def test_long_curves_score_as_by_the_package(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one = curve(rng, 2001, "wave") + 0.02 * curve(rng, 2001, "walk")
    other = np.roll(one, 37) + 0.05 * curve(rng, 2001, "walk")
    assert agreement(one, other)[:4] == pytest.approx(twins.by_package(one, other), abs=1e-12)


def test_a_straight_line_is_not_shifted() -> None:
    # it correlates perfectly with itself at every shift; rounding must not choose one
    line = 0.1 * np.arange(201.0) + 0.7
    assert agreement(line, line) == (1.0, 1.0, 1.0, 1.0, 0)


def test_a_period_is_not_gained_or_lost() -> None:
    wave = np.sin(2.0 * np.pi * np.arange(400) / 20.0)
    assert agreement(wave, wave) == (1.0, 1.0, 1.0, 1.0, 0)
    assert agreement(wave, np.roll(wave, 3))[4] == 3
    assert agreement(wave, np.roll(wave, 10))[4] == 10  # as early as late: late is meant


@pytest.mark.parametrize("late", [-20, -7, 7, 20])
def test_the_shift_says_who_is_late(late: int) -> None:
    t = np.arange(200.0)
    one, other = np.exp(-(((t - 90.0) / 12.0) ** 2)), np.exp(-(((t - 90.0 - late) / 12.0) ** 2))
    assert agreement(one, other)[4] == late
    assert agreement(one, other)[1] == pytest.approx(1.0 - abs(late) / 40.0, rel=1e-14)


def test_a_spike_in_a_flat_curve_can_be_scored() -> None:
    # at every shift but none a piece is flat
    one, other = np.zeros(150), np.zeros(150)
    one[-1], other[0] = 1.0, 1.0
    found = agreement(one, other)
    assert np.isfinite(found).all()
    assert found[4] == 0


@pytest.mark.parametrize("power", [-300, -150, 150, 300])
def test_the_unit_does_not_matter(power: int) -> None:
    one, other = pair(5, (150, 151))
    plain = agreement(one, other)
    assert agreement(one * 2.0**power, other * 2.0**power) == plain
