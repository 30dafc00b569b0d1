"""The NCAP risk curves, against values worked out apart from them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from ridedown.criteria.risk import (
    chest_injury_risk,
    combined_risk,
    femur_injury_risk,
    head_injury_risk,
    neck_injury_risk,
    relative_risk,
)
from ridedown.errors import InvalidInput, UnknownName


@given(st.floats(1.0, 5000.0))
def test_the_head_curve_is_a_normal_distribution_of_the_logarithm(hic: float) -> None:
    assert head_injury_risk(hic) == pytest.approx(norm.cdf((math.log(hic) - 7.45231) / 0.73998), rel=1e-9, abs=1e-15)


def test_half_the_population_is_hurt_where_the_exponent_is_zero() -> None:
    assert head_injury_risk(math.exp(7.45231)) == pytest.approx(0.5)
    assert chest_injury_risk((10.5456 / 1.568) ** (1 / 0.4612) / 1000) == pytest.approx(0.5)
    assert chest_injury_risk((10.5456 / 1.7212) ** (1 / 0.4612) / 1000, dummy="Hybrid III 05") == pytest.approx(0.5)
    assert femur_injury_risk(5.795 / 0.5196 * 1000) == pytest.approx(0.5)
    assert femur_injury_risk(5.7949 / 0.7619 * 1000, dummy="Hybrid III 05") == pytest.approx(0.5)
    assert neck_injury_risk(3.2269 / 1.9688, 0.0, 0.0) == pytest.approx(0.5)
    assert neck_injury_risk(0.0, 10.9745 / 2.375 * 1000, 0.0) == pytest.approx(0.5)
    assert neck_injury_risk(0.0, 0.0, 10.958 / 3.770 * 1000, dummy="Hybrid III 05") == pytest.approx(0.5)


def test_the_smaller_woman_is_hurt_more_by_the_same_load() -> None:
    for curve, load in ((chest_injury_risk, 0.04), (femur_injury_risk, 6000.0)):
        assert curve(load, dummy="Hybrid III 05") > curve(load, dummy="Hybrid III 50")


@given(st.floats(0.0, 1e4), st.floats(0.0, 1e4))
def test_more_load_is_never_less_risk(one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert head_injury_risk(low) <= head_injury_risk(high)
    assert femur_injury_risk(low) <= femur_injury_risk(high)
    assert chest_injury_risk(low * 1e-5) <= chest_injury_risk(high * 1e-5)


def test_the_worst_of_the_neck_counts() -> None:
    assert neck_injury_risk(1.0, 4000.0, 100.0) == max(neck_injury_risk(1.0, 0.0, 0.0), neck_injury_risk(0.0, 4000.0, 0.0))


@given(st.lists(st.floats(0.0, 1.0), max_size=5))
def test_the_combined_risk_is_at_least_the_largest_and_at_most_the_sum(risks: list[float]) -> None:
    combined = combined_risk(*risks)
    assert max(risks, default=0.0) - 1e-12 <= combined <= min(sum(risks), 1.0) + 1e-12


def test_the_fleet_has_a_relative_risk_of_one() -> None:
    assert relative_risk(0.30) == pytest.approx(2.0)
    assert relative_risk(0.15) == 1.0


def test_what_no_load_can_be_is_refused() -> None:
    with pytest.raises(InvalidInput, match="hic15: got -1; need >= 0"):
        head_injury_risk(-1.0)
    with pytest.raises(InvalidInput, match=r"deflection: got -0\.03 m; need >= 0\. Give the magnitude"):
        chest_injury_risk(-0.03)
    with pytest.raises(InvalidInput, match="force"):
        femur_injury_risk(math.nan)
    with pytest.raises(InvalidInput, match="risk: got 12; need 0 <= risk <= 1"):
        combined_risk(0.1, 12.0)
    with pytest.raises(UnknownName, match="Hybrid III 50"):
        femur_injury_risk(1.0, dummy="Hybrid III 95")
