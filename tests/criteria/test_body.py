"""Chest, neck and legs: closed forms and brute force."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ridedown.criteria.chest import CHEST_CONSTANTS, chest_deflection, viscous_criterion
from ridedown.criteria.legs import femur_force, tibia_index
from ridedown.criteria.neck import NECK_INTERCEPTS, NeckIntercepts, condyle_moment, neck_forces, nij
from ridedown.errors import InvalidInput, UnknownName

TIME = np.linspace(0.0, 0.1, 1001)

# chest


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_viscous_criterion_of_a_half_sine_is_at_its_quarter(sign: float) -> None:
    found = viscous_criterion(TIME, sign * 0.04 * np.sin(np.pi * TIME / 0.1))
    assert found.value == pytest.approx(1.3 / 0.229 * 0.04**2 * math.pi / 0.1 / 2.0, rel=1e-5)
    assert found.time == pytest.approx(0.025, abs=1e-4)


def test_the_viscous_criterion_of_a_ramp_is_its_speed_times_its_end() -> None:
    ramp = np.minimum(TIME, 0.05) * 1.0  # 1 m/s to 50 mm
    found = viscous_criterion(TIME, ramp, dummy="Hybrid III 05")
    # one sample before the corner the difference of four sees [8 (2 h) - 3 h]/(12 h) of the speed: 13/12
    assert found.value == pytest.approx(1.3 / 0.187 * 0.0499 * 13.0 / 12.0, rel=1e-9)


def test_rebound_does_not_count() -> None:
    out = 0.05 * np.cos(0.5 * np.pi * TIME / 0.1)  # in from the start, and only out from there
    assert viscous_criterion(TIME, out).value == 0.0
    assert viscous_criterion(TIME, -out).value == 0.0


def test_the_viscous_criterion_is_the_sum_over_four_neighbours_at_every_sample() -> None:
    rng = np.random.default_rng(1)
    d = np.cumsum(rng.normal(0.0, 1e-4, 200))
    t = np.arange(200) * 1e-4
    by_hand = max(1.3 * d[i] / 0.229 * (8 * (d[i + 1] - d[i - 1]) - (d[i + 2] - d[i - 2])) / (12 * 1e-4) for i in range(2, 198))
    assert viscous_criterion(t, d).value == pytest.approx(by_hand, rel=1e-9)


def test_uneven_sampling_is_refused_for_the_viscous_criterion() -> None:
    with pytest.raises(InvalidInput, match="need even sampling"):
        viscous_criterion([0.0, 0.001, 0.002, 0.004, 0.005], [0.0] * 5)
    with pytest.raises(InvalidInput, match="need >= 5"):
        viscous_criterion([0.0, 0.001], [0.0, 0.0])


def test_a_dummy_without_a_chest_depth_is_told_the_nearest() -> None:
    with pytest.raises(UnknownName, match="Hybrid III 50"):
        viscous_criterion(TIME, TIME, dummy="Hybrid III 5O")
    assert viscous_criterion(TIME, TIME, dummy="no such", factor=1.0, depth=0.2).value > 0.0


def test_chest_constants_are_factors_and_depths_of_chests() -> None:
    assert all(c.factor in {1.0, 1.3} and 0.1 < c.depth < 0.3 for c in CHEST_CONSTANTS.values())


def test_deflection_keeps_the_sign_it_was_recorded_with() -> None:
    assert chest_deflection(TIME, -0.03 * np.sin(np.pi * TIME / 0.1)).value == pytest.approx(-0.03)
    assert chest_deflection([0.0, 1.0], [0.01, 0.03]).time == 1.0  # a pulse that ends the record


# neck


@pytest.mark.parametrize(
    ("force", "moment", "loading", "value"),
    [
        (6806.0, 310.0, "tension-flexion", 2.0),
        (680.6, -135.0, "tension-extension", 1.1),
        (-6160.0, 31.0, "compression-flexion", 1.1),
        (-616.0, -13.5, "compression-extension", 0.2),
    ],
)
def test_each_loading_has_its_own_intercepts(force: float, moment: float, loading: str, value: float) -> None:
    found = nij([0.0, 0.05, 0.1], [0.0, force, 0.0], [0.0, moment, 0.0])
    assert found.value == pytest.approx(value, rel=1e-12)
    assert (found.loading, found.time) == (loading, 0.05)
    assert getattr(found, loading.replace("-", "_")).value == pytest.approx(value, rel=1e-12)


def test_one_load_alone_is_one_at_its_intercept() -> None:
    for dummy, critical in NECK_INTERCEPTS.items():
        assert nij([0.0, 0.1], [critical.tension] * 2, [0.0, 0.0], dummy=dummy).value == pytest.approx(1.0)
        assert nij([0.0, 0.1], [0.0, 0.0], [-critical.extension] * 2, dummy=dummy).value == pytest.approx(1.0)


def test_force_and_moment_add_only_where_they_meet() -> None:
    found = nij([0.0, 0.01, 0.02, 0.03, 0.04], [0.0, 3403.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 155.0, 0.0])
    assert found.value == pytest.approx(0.5)


loads = st.lists(st.tuples(st.integers(-8000, 8000), st.integers(-300, 300)), min_size=2, max_size=12)


@settings(max_examples=100, deadline=None)
@given(loads)
def test_no_time_between_samples_has_a_larger_nij(pairs: list[tuple[int, int]]) -> None:
    time = np.linspace(0.0, 0.1, len(pairs))
    force, moment = (np.array(column) for column in zip(*pairs, strict=True))
    found = nij(time, force, moment)
    fine = np.unique(np.concatenate((np.linspace(0.0, 0.1, 20_001), time)))
    f, m = np.interp(fine, time, force), np.interp(fine, time, moment)
    c = NECK_INTERCEPTS["Hybrid III 50"]
    each = np.where(f > 0, f / c.tension, -f / c.compression) + np.where(m > 0, m / c.flexion, -m / c.extension)
    assert found.value == pytest.approx(each.max(), rel=1e-9, abs=1e-12)
    for name, here in {
        "tension_flexion": (f >= 0) & (m >= 0),
        "tension_extension": (f >= 0) & (m <= 0),
        "compression_flexion": (f <= 0) & (m >= 0),
        "compression_extension": (f <= 0) & (m <= 0),
    }.items():
        brute = each[here].max() if here.any() else 0.0
        mode = getattr(found, name).value
        assert brute - 1e-9 <= mode <= brute + 2e-3 * max(1.0, each.max())  # a sign change between two fine samples


def test_the_loading_up_to_a_change_of_sign_counts() -> None:
    # force turns from compression to tension at 0.05 s under a steady flexion of 155 N m
    found = nij([0.0, 0.1], [-6160.0, 6160.0], [155.0, 155.0])
    assert found.tension_flexion.value == pytest.approx(0.5 + 6160.0 / 6806.0)
    assert found.compression_flexion.value == pytest.approx(1.5)
    assert found.tension_extension.value == 0.0
    assert found.tension_extension.time is None


def test_moments_are_taken_to_the_condyle_before_nij() -> None:
    assert condyle_moment([10.0, -5.0], [500.0, -1000.0]) == pytest.approx([10.0 - 8.89, -5.0 + 17.78])
    with pytest.raises(InvalidInput, match="shear"):
        condyle_moment([1.0, 2.0], [1.0])


def test_intercepts_that_are_no_magnitudes_are_refused() -> None:
    with pytest.raises(InvalidInput, match=r"intercepts\.compression: got -6160"):
        nij([0.0, 0.1], [0.0, 0.0], [0.0, 0.0], intercepts=NeckIntercepts(6806.0, -6160.0, 310.0, 135.0))
    with pytest.raises(UnknownName, match="Hybrid III 50"):
        nij([0.0, 0.1], [0.0, 0.0], [0.0, 0.0], dummy="Hybrid III 50th")


def test_neck_forces_are_magnitudes_either_way() -> None:
    pushed = neck_forces(TIME, -900.0 * np.sin(np.pi * TIME / 0.1))
    assert (pushed.tension, pushed.compression) == pytest.approx((0.0, 900.0))


# legs


def test_the_femur_counts_compression_and_keeps_its_sign() -> None:
    force = np.where(TIME < 0.05, -1900.0 * np.sin(np.pi * TIME / 0.05), 4000.0)
    found = femur_force(TIME, force)
    assert (found.value, found.time) == pytest.approx((-1900.0, 0.025))
    assert femur_force([0.0, 0.1], [10.0, 500.0]).value == 0.0


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-200, 200)] * 2, st.floats(-9000, 9000)), min_size=2, max_size=10))
def test_no_time_between_samples_has_a_larger_tibia_index(rows: list[tuple[float, float, float]]) -> None:
    time = np.linspace(0.0, 0.1, len(rows))
    channels = [np.array(column) for column in zip(*rows, strict=True)]
    fine = np.unique(np.concatenate((np.linspace(0.0, 0.1, 5001), time)))
    x, y, z = (np.interp(fine, time, column) for column in channels)
    assert tibia_index(time, *channels).value == pytest.approx((np.hypot(x, y) / 225.0 + np.abs(z) / 35_900.0).max(), rel=1e-9)


def test_the_tibia_index_knows_its_dummies() -> None:
    assert tibia_index([0.0, 0.1], [115.0] * 2, [0.0] * 2, [0.0] * 2, dummy="Hybrid III 05").value == pytest.approx(1.0)
    with pytest.raises(UnknownName):
        tibia_index([0.0, 0.1], [0.0] * 2, [0.0] * 2, [0.0] * 2, dummy="Q3")
