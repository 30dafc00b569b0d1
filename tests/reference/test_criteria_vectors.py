"""Criteria against numbers that nobody here computed: closed forms, 30-digit arithmetic and exact sums over samples."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ridedown import criteria

VECTORS = Path(__file__).resolve().parents[3] / "shared" / "vectors" / "criteria.json"
G0 = 9.80665
TIME = np.arange(3001) / 10000.0
WINDOWS = {"HIC15": 0.015, "HIC36": 0.036}
PULSES = ("halfsine_50g_60ms", "triangle_50g_60ms", "square_50g_60ms", "halfsine_100g_10ms")

needs_vectors = pytest.mark.skipif(not VECTORS.exists(), reason="the shared check vectors are not beside this repository")

Floats = NDArray[np.float64]


def vectors() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(VECTORS.read_text(encoding="utf-8"))
    return found


def shape(name: str, start: int, count: int, peak: float) -> Floats:
    """The pulses as the vectors define them [m/s2], at 10 kHz."""
    k = np.arange(count + 1)
    values = {
        "half_sine": peak * np.sin(np.pi * k / count) * (k < count),
        "tri": peak * (1.0 - np.abs(2.0 * k / count - 1.0)),
        "square": peak * (k < count),
    }[name]
    a = np.zeros(TIME.size)
    a[start : start + count + 1] = values * G0
    return a


def pulse(case: dict[str, Any]) -> Floats:
    name, _, numbers = case["input"].rstrip(")").partition("(")
    start, count, peak = (int(number) for number in numbers.split(","))
    return shape(name, start, count, float(peak))


@needs_vectors
@pytest.mark.parametrize("name", PULSES)
@pytest.mark.parametrize("which", WINDOWS)
def test_hic_between_samples_is_exact(name: str, which: str) -> None:
    case = vectors()["injury"][name]
    found = criteria.hic(TIME, pulse(case), max_window=WINDOWS[which])
    assert found.value == pytest.approx(case["sampled"][f"{which}_piecewise_linear_continuous"], rel=1e-12)


@needs_vectors
@pytest.mark.parametrize("name", PULSES)
@pytest.mark.parametrize("which", WINDOWS)
def test_hic_over_pairs_of_samples_is_exact(name: str, which: str) -> None:
    case = vectors()["injury"][name]
    found = criteria.hic(TIME, pulse(case), max_window=WINDOWS[which], sampled=True)
    assert found.value == pytest.approx(case["sampled"][f"{which}_sample_pairs"], rel=1e-12)
    if "square" not in name:  # any window within a square is as bad as any other
        assert found.start == pytest.approx(case["sampled"][f"{which}_sample_pairs_t1"], abs=1e-12)
        assert found.end == pytest.approx(case["sampled"][f"{which}_sample_pairs_t2"], abs=1e-12)


@needs_vectors
@pytest.mark.parametrize("name", PULSES)
@pytest.mark.parametrize("which", WINDOWS)
def test_hic_of_the_smooth_pulse_to_the_error_of_sampling(name: str, which: str) -> None:
    case = vectors()["injury"][name]
    found = criteria.hic(TIME, pulse(case), max_window=WINDOWS[which])
    # a chord lies below a half-sine by (pi h/T)^2/12 of its mean, and HIC takes 2.5 of it: 5.7e-6 and 2.06e-4 here
    duration = 0.010 if "10ms" in name else 0.060
    error = 2.5 * (math.pi * 1e-4 / duration) ** 2 / 12.0 if "halfsine" in name else 0.0
    assert found.value == pytest.approx(float(case["continuous"][which]) * (1.0 - error), rel=max(1e-2 * error, 1e-12))
    assert found.duration == pytest.approx(float(case["continuous"][f"{which}_optimal_window_s"]), abs=1e-6)


@needs_vectors
@pytest.mark.parametrize("name", PULSES)
@pytest.mark.parametrize("cumulative", [False, True])
def test_clip(name: str, cumulative: bool) -> None:
    case = vectors()["injury"][name]
    found = criteria.clip(TIME, pulse(case), cumulative=cumulative)
    # the ends of these windows fall on samples, where the sampled pulse is the smooth one
    assert found.value_g == pytest.approx(float(case["continuous"]["clip3ms_g"]), rel=1e-12)


@needs_vectors
@pytest.mark.parametrize("name", PULSES)
def test_change_of_velocity_to_the_error_of_sampling(name: str) -> None:
    case = vectors()["injury"][name]
    duration = 0.010 if "10ms" in name else 0.060
    error = (math.pi * 1e-4 / duration) ** 2 / 12.0 if "halfsine" in name else 0.0
    found = criteria.delta_v(TIME, pulse(case))
    assert found.value == pytest.approx(float(case["continuous"]["delta_v_mps"]) * (1.0 - error), rel=1e-8 if error else 1e-12)


@needs_vectors
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_olc_of_a_half_sine(sign: float) -> None:
    case = vectors()["olc"]["halfsine_50g_60ms_t0=0"]
    found = criteria.olc(TIME, sign * shape("half_sine", 0, 600, 50.0))
    # the pulse is short by 2.3e-6 (see above), so all comes later by about as much of 20 to 60 ms
    assert found.value_g == pytest.approx(float(case["OLC_g"]), rel=5e-6)
    assert found.start == pytest.approx(float(case["t1_s"]), abs=1e-7)
    assert found.end == pytest.approx(float(case["t2_s"]), abs=1e-7)


@needs_vectors
def test_olc_of_a_square() -> None:
    case = vectors()["olc"]["square_50g_60ms_t0=0"]
    with_jump = criteria.olc([0.0, 0.06, 0.06, 0.3], [-50.0 * G0, -50.0 * G0, 0.0, 0.0])
    assert with_jump.value_g == pytest.approx(float(case["OLC_g"]), rel=1e-12)
    assert with_jump.start == pytest.approx(float(case["t1_s"]), rel=1e-12)
    assert with_jump.end == pytest.approx(float(case["t2_s"]), rel=1e-12)
    # sampled, its end is a ramp of 0.1 ms from 59.9 ms on, half a sample short in all
    sampled = criteria.olc(TIME, -shape("square", 0, 600, 50.0))
    assert sampled.value_g == pytest.approx(float(case["OLC_g"]), rel=2e-4)


@needs_vectors
@pytest.mark.parametrize("name", ["square", "half_sine", "triangle", "haversine"])
@pytest.mark.parametrize(("peak", "duration"), [(50.0, 0.060), (200.0, 0.004)])
def test_hic_of_a_shape_with_any_window(name: str, peak: float, duration: float) -> None:
    factor = vectors()["hic_shape_factors"][name]
    k = np.linspace(0.0, 1.0, 2001)
    shapes = {"square": np.ones_like(k), "half_sine": np.sin(np.pi * k), "triangle": 1.0 - np.abs(2.0 * k - 1.0)}
    shapes["haversine"] = np.sin(np.pi * k) ** 2
    found = criteria.hic(duration * k, peak * G0 * shapes[name], max_window=1.0)
    assert found.value == pytest.approx(factor * peak**2.5 * duration, rel=3e-5)  # the factors have five figures, or four


@needs_vectors
def test_occupant_on_a_slack_spring_under_constant_deceleration() -> None:
    case = vectors()["restrained_occupant_under_constant_deceleration"]["E=20 g, f=6 Hz, s=0.05 m"]
    w = 2.0 * math.pi * 6.0
    found = criteria.vpi([0.0, 0.5], [-20.0 * G0, -20.0 * G0], stiffness=w * w, slack=0.05)
    assert found.value_g == pytest.approx(case["a_max_g"], abs=5e-4)  # printed to 0.001 g
    assert 0.05 + found.value / w**2 == pytest.approx(case["d_max_m"], abs=5e-5)  # and to 0.1 mm
