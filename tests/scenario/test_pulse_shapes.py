"""Pulses of every named shape, against closed forms written out by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from ridedown.scenario import SledScenario, load, lower, substitute
from ridedown.scenario.lowering import pulse_of
from ridedown.scenario.pulse_motion import PulseMotion

G = 9.80665
V, T = 14.0, 0.11  # m/s, s


def motion(pulse: dict[str, Any], end: float = 0.2) -> PulseMotion:
    scenario = load({"pulse": pulse, "duration": end})
    assert isinstance(scenario, SledScenario)
    return PulseMotion.of(pulse_of(scenario), end=end, speed=float(scenario.initial_speed))


def half_sine(t):
    """Deceleration, speed taken and way of it, of a half-sine of V in T."""
    peak, w = math.pi * V / (2 * T), math.pi / T
    return peak * np.sin(w * t), peak / w * (1 - np.cos(w * t)), peak / w * (t - np.sin(w * t) / w)


def haversine(t):
    peak, w = 2 * V / T, 2 * math.pi / T
    return (
        peak / 2 * (1 - np.cos(w * t)),
        peak / 2 * (t - np.sin(w * t) / w),
        peak / 2 * (t**2 / 2 - (1 - np.cos(w * t)) / w**2),
    )


def square(t):
    return np.full_like(t, V / T), V / T * t, V / T * t**2 / 2


@pytest.mark.parametrize("shape", [half_sine, haversine, square])
def test_the_smooth_shapes_follow_their_formulas_to_rounding(shape):
    found = motion({"kind": shape.__name__.replace("_", "-"), "delta_v": V, "duration": T})
    t = np.linspace(0.0, T, 4001)[:-1]
    a, v, x = found.at(t)
    deceleration, taken, way = shape(t)
    np.testing.assert_allclose(a, -deceleration, rtol=0, atol=2e-15 * np.abs(deceleration).max() * 5)
    np.testing.assert_allclose(v, V - taken, rtol=0, atol=1e-14 * V)
    np.testing.assert_allclose(x, V * t - way, rtol=0, atol=1e-14)
    assert found.at(T)[0] == 0.0
    assert abs(found.at(0.2)[1]) < 1e-14 * V  # at rest, and it stays there


@pytest.mark.parametrize("peak_at", [0.0, 0.3, 0.5, 1.0])
def test_a_triangle(peak_at):
    found = motion({"kind": "triangle", "delta_v": V, "duration": T, "peak_at": peak_at})
    peak = 2 * V / T
    knots = [0.0, peak_at * T, T]
    inside = np.linspace(0.0, T, 101)[1:-1]
    np.testing.assert_allclose(found.at(inside)[0], -np.interp(inside, knots, [0.0, peak, 0.0]), rtol=1e-12)
    # the centre of the area lies at (1 + peak_at)/3 of the duration: x(T) = V T - V (T - centre)
    assert found.at(T)[2] == pytest.approx(V * T * (1 + peak_at) / 3, rel=1e-13)
    assert abs(found.at(T)[1]) < 1e-13


def test_a_trapezoid():
    found = motion({"kind": "trapezoid", "duration": T, "peak": "20 g", "rise": "20 %", "fall": 0.3}, end=0.3)
    peak = 20 * G
    t = np.array([0.0, 0.5, 1.0, 2.0, 3.4, 4.25, 4.9]) * 0.2 * T
    expected = np.interp(t, [0.0, 0.2 * T, 0.7 * T, T], [0.0, peak, peak, 0.0])
    np.testing.assert_allclose(found.at(t)[0], -expected, rtol=1e-12)
    assert found.speed == pytest.approx(peak * T * 0.75, rel=1e-15)  # by its area
    assert abs(found.at(0.3)[1]) < 1e-13


@pytest.mark.parametrize(("rise", "fall"), [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.9, 0.1), (0.7, 0.3), (0.5, 0.5)])
def test_a_trapezoid_at_its_limits(rise, fall):
    found = motion({"kind": "trapezoid", "delta_v": V, "duration": T, "rise": rise, "fall": fall})
    assert abs(found.at(0.2)[1]) < 1e-13
    assert np.abs(found.at(np.linspace(0, 0.2, 999))[0]).max() <= V / T / (1 - (rise + fall) / 2) * (1 + 1e-12)


@pytest.mark.parametrize(
    "pair",
    [
        {"delta_v": V, "duration": T},
        {"delta_v": V, "peak": math.pi * V / (2 * T)},
        {"duration": T, "peak": math.pi * V / (2 * T)},
    ],
)
def test_two_of_three_give_the_third(pair):
    found, expected = motion({"kind": "half-sine", **pair}), motion({"kind": "half-sine", "delta_v": V, "duration": T})
    t = np.linspace(0.0, 0.2, 201)
    for one, other in zip(found.at(t), expected.at(t), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-11)


def test_the_equivalent_square_wave_stops_within_the_crush():
    found = motion({"kind": "equivalent-square-wave", "speed": "15 m/s", "crush": "0.6 m"})
    end = 2 * 0.6 / 15
    assert found.at(0.0)[0] == pytest.approx(-(15**2) / (2 * 0.6), rel=1e-15)
    assert abs(found.at(end)[1]) < 1e-13
    assert found.at(end)[2] == pytest.approx(0.6, rel=1e-14)


def test_the_tipped_one_stops_within_the_crush_at_the_time():
    v0, crush, end = 15.0, 0.62, 0.09
    found = motion({"kind": "tipped-equivalent-square-wave", "speed": v0, "crush": crush, "time": end})
    r = crush / (v0 * end)
    assert found.at(0.0)[0] == pytest.approx(-2 * v0 / end * (2 - 3 * r), rel=1e-14)
    assert found.before(end)[0] == pytest.approx(-2 * v0 / end * (3 * r - 1), rel=1e-14)
    assert abs(found.at(end)[1]) < 1e-13
    assert found.at(end)[2] == pytest.approx(crush, rel=1e-14)


def test_the_fmvss_208_sled_is_one_of_48_km_h():
    found = motion({"kind": "fmvss-208-sled"})
    assert found.speed * 3.6 == pytest.approx(48.3, abs=0.05)
    assert found.at(0.0625)[0] == pytest.approx(-17.2 * G, rel=1e-15)
    assert found.at(0.125)[0] == 0.0


def test_points_are_joined_by_straight_lines_and_nothing_is_before_or_after():
    found = motion({"kind": "points", "points": [["10 ms", -100], ["30 ms", "-200 m/s2"], [0.03, -50], [0.05, -50]]})
    np.testing.assert_allclose(found.at([0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.1])[0], [0, -100, -150, -50, -50, 0, 0])
    assert found.before(0.03)[0] == pytest.approx(-200)
    assert found.speed == pytest.approx(0.02 * 150 + 0.02 * 50, rel=1e-14)
    assert abs(found.at(0.06)[1]) < 1e-14


def test_columns_share_the_shape():
    sled = load({"pulse": {"kind": "haversine", "delta_v": 10, "duration": 0.1}})
    many = lower(substitute(sled, {"pulse.delta_v": [10.0, 14.0], "pulse.duration": [0.1, 0.12]}))
    for row, (change, length) in enumerate([(10.0, 0.1), (14.0, 0.12)]):
        one = lower(load({"pulse": {"kind": "haversine", "delta_v": change, "duration": length}}))
        assert many.pulse_amplitude[row] == one.pulse_amplitude[0]
        assert many.pulse_length[row] == one.pulse_length[0]
        assert many.rate[0, row] == change
        np.testing.assert_array_equal(many.pulse_series, one.pulse_series)


def test_a_tipped_wave_in_columns_keeps_its_ratio():
    sled = load({"pulse": {"kind": "tipped-equivalent-square-wave", "speed": 15, "crush": 0.6, "time": 0.09}})
    found = lower(substitute(sled, {"pulse.speed": [15.0, 30.0], "pulse.crush": [0.6, 1.2]}))
    np.testing.assert_allclose(found.pulse_amplitude, [-30 / 0.09, -60 / 0.09])


def test_a_tables_rows_and_knots_tell_the_same_motion():
    found = motion({"kind": "half-sine", "delta_v": V, "duration": T})
    time, a, v, x = found.knots(1e-4)
    assert time[0] == 0.0
    assert time[-1] == 0.2
    fine = np.linspace(0.0, T, 5001)
    assert np.abs(np.interp(fine, time, a) - found.at(fine)[0]).max() <= 1e-4 * math.pi * V / (2 * T) * 1.05
    np.testing.assert_allclose((v, x), found.at(time)[1:], atol=1e-14)


def test_a_jump_is_two_rows():
    found = motion({"kind": "square", "delta_v": V, "duration": T})
    time, a, *_ = found.knots()
    assert time.tolist() == [0.0, T, T, 0.2]
    np.testing.assert_allclose(a, [-V / T, -V / T, 0.0, 0.0])
    rows = found.table(0.05)[0]
    assert rows.tolist() == sorted(rows.tolist())
    assert (rows == T).sum() == 2
