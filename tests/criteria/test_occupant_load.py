"""OLC and VPI of pulses whose answer can be written down."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ridedown import criteria
from ridedown.errors import InvalidInput

W = 50.0  # rad/s: 2500 N/m and 1 kg


@pytest.mark.parametrize("a", [50.0, 400.0])
def test_olc_of_a_constant_deceleration(a: float) -> None:
    # z(t) - u(t) (t - t1)/2 = a t t1/2, so t2 = t1 0.600/0.130 and the criterion is 0.600/0.470 of the deceleration
    found = criteria.olc([0.0, 1.0], [-a, -a])
    assert found.start == pytest.approx(math.sqrt(0.13 / a), rel=1e-12)
    assert found.end == pytest.approx(math.sqrt(0.13 / a) * 0.600 / 0.130, rel=1e-12)
    assert found.value == pytest.approx(a * 0.600 / 0.470, rel=1e-12)


@pytest.mark.parametrize("parts", [1, 2, 7, 1000])
def test_olc_of_a_blow(parts: int) -> None:
    # 10 m/s in 1 ms, then nothing: z = u (t - 0.5 ms), so t1 = 65/u + 0.5 ms and t2 = 600/u + 1 ms - t1
    time = np.concatenate((np.linspace(0.0, 0.001, parts + 1), [0.001, 0.2]))
    found = criteria.olc(time, np.concatenate((np.full(parts + 1, -1e4), [0.0, 0.0])))
    assert found.start == pytest.approx(0.007, rel=1e-12)
    assert found.end == pytest.approx(0.054, rel=1e-12)
    assert found.value == pytest.approx(10.0 / 0.047, rel=1e-12)


def test_olc_of_a_double_pulse() -> None:
    # 5 m/s at once, and 5 more at 40 ms: t1 = 13 ms, then z = 0.2 + 10 (t - 0.04), and 5 (t + t1) = 0.3 + 0.2 gives t2 = 87 ms
    time, a = [0.0, 1e-9, 1e-9, 0.04, 0.04, 0.04 + 1e-9, 0.04 + 1e-9, 0.2], [-5e9, -5e9, 0.0, 0.0, -5e9, -5e9, 0.0, 0.0]
    found = criteria.olc(time, a)
    assert found.start == pytest.approx(0.013, rel=1e-6)
    assert found.end == pytest.approx(0.087, rel=1e-6)
    assert found.value == pytest.approx(10.0 / 0.074, rel=1e-6)


def test_olc_of_other_lengths() -> None:
    found = criteria.olc([0.0, 1.0], [-100.0, -100.0], free_flight=0.1, restrained=0.3)
    assert found.value == pytest.approx(100.0 * 0.8 / 0.6, rel=1e-12)


def test_olc_does_not_ask_which_way_x_points() -> None:
    time, a = np.linspace(0.0, 0.1, 1001), 300.0 * np.sin(np.linspace(0.0, math.pi, 1001))
    assert criteria.olc(time, a) == criteria.olc(time, -a)
    assert criteria.vpi(time, a) == criteria.vpi(time, -a)


def test_olc_of_a_pulse_too_weak_says_how_far_it_came() -> None:
    weak = criteria.olc([0.0, 0.1], [-10.0, -10.0])
    assert (weak.value, weak.value_g, weak.start, weak.end) == (None, None, None, None)
    assert weak.displacement == pytest.approx(0.05, rel=1e-12)
    short = criteria.olc([0.0, 0.1], [-20.0, -20.0])  # 100 mm: flies free, and is not caught
    assert (short.value, short.end) == (None, None)
    assert short.start == pytest.approx(math.sqrt(0.13 / 20.0), rel=1e-12)
    assert criteria.olc([0.0, 0.1], [0.0, 0.0]).value is None


def test_olc_begins_at_time_zero() -> None:
    with_lead = criteria.olc([-0.05, 0.0, 0.0, 1.0], [-5.0, -5.0, -100.0, -100.0])
    assert with_lead.value == pytest.approx(criteria.olc([0.0, 1.0], [-100.0, -100.0]).value, rel=1e-12)


def test_vpi_of_a_blow_is_that_of_its_speed() -> None:
    # the spring is met at 4 m/s and nothing else acts: peak W u, a quarter turn after the slack of 30 mm
    found = criteria.vpi([0.0, 1e-9, 1e-9, 0.2], [-4e9, -4e9, 0.0, 0.0])
    assert found.value == pytest.approx(W * 4.0, rel=1e-8)
    assert found.time == pytest.approx(0.03 / 4.0 + 0.5 * math.pi / W, rel=1e-7)


@pytest.mark.parametrize("slack", [0.0, 0.03, 0.2])
def test_vpi_under_constant_deceleration(slack: float) -> None:
    found = criteria.vpi([0.0, 0.3], [-150.0, -150.0], slack=slack)
    assert found.value == pytest.approx(150.0 * (1.0 + math.sqrt(1.0 + 2.0 * W * W * slack / 150.0)), rel=1e-12)


@pytest.mark.parametrize("duration", [0.02, 0.05, 0.12])
def test_vpi_of_a_half_sine_without_slack(duration: float) -> None:
    # y'' + W^2 y = A sin(f t): y = A/(W^2 - f^2) (sin f t - f/W sin W t), and a free swing after the pulse
    f = math.pi / duration
    t = np.linspace(0.0, duration, 200_001)
    y = 300.0 / (W * W - f * f) * (np.sin(f * t) - f / W * np.sin(W * t))
    rate = 300.0 * f / (W * W - f * f) * (math.cos(f * duration) - math.cos(W * duration))
    expected = W * W * max(float(y.max()), math.hypot(y[-1], rate / W))
    time = np.concatenate((np.linspace(0.0, duration, 20_001), [0.4]))
    found = criteria.vpi(time, np.concatenate((-300.0 * np.sin(np.linspace(0.0, math.pi, 20_001)), [0.0])), slack=0.0)
    assert found.value == pytest.approx(expected, rel=1e-7)


def test_vpi_of_an_occupant_that_flies_back_and_is_caught_again() -> None:
    # 5 m/s: slack for 6 ms, half a swing of 62.8 ms, back out at 5 m/s; at 70 ms a blow of 12 m/s sends it in again at 7 m/s
    time = [0.0, 1e-9, 1e-9, 0.07, 0.07, 0.07 + 1e-9, 0.07 + 1e-9, 0.3]
    found = criteria.vpi(time, [-5e9, -5e9, 0.0, 0.0, -12e9, -12e9, 0.0, 0.0])
    back = 0.03 - 5.0 * (0.07 - 0.006 - math.pi / W)
    assert found.value == pytest.approx(W * 7.0, rel=1e-6)
    assert found.time == pytest.approx(0.07 + (0.03 - back) / 7.0 + 0.5 * math.pi / W, rel=1e-6)


def test_vpi_of_other_constants() -> None:
    found = criteria.vpi([0.0, 0.5], [-150.0, -150.0], stiffness=20e3, mass=50.0, slack=0.05)
    assert found.value == pytest.approx(150.0 * (1.0 + math.sqrt(1.0 + 2.0 * 400.0 * 0.05 / 150.0)), rel=1e-12)


def test_vpi_of_a_record_that_ends_before_the_peak_has_no_value() -> None:
    cut = criteria.vpi([0.0, 0.04], [-150.0, -150.0])
    assert (cut.value, cut.value_g) == (None, None)
    assert 0.0 < cut.reached < criteria.vpi([0.0, 0.2], [-150.0, -150.0]).reached
    assert criteria.vpi([0.0, 0.01], [-150.0, -150.0]) == criteria.VPI(None, 0.0, 0.0)  # the slack is not taken up
    assert criteria.vpi([0.0, 0.1], [0.0, 0.0]).value is None


def test_vpi_does_not_depend_on_the_samples_between() -> None:
    time, a = np.array([0.0, 0.013, 0.05, 0.05, 0.2]), np.array([0.0, -300.0, -100.0, -400.0, 0.0])
    finer = np.unique(np.concatenate((np.linspace(0.0, 0.2, 4001), [0.05 - 1e-12, 0.013])))
    coarse = criteria.vpi(time, a)
    fine = criteria.vpi(finer, np.where(finer < 0.05, np.interp(finer, time[:3], a[:3]), np.interp(finer, time[3:], a[3:])))
    assert fine.value == pytest.approx(coarse.value, rel=1e-9)
    assert fine.time == pytest.approx(coarse.time, rel=1e-6)


@pytest.mark.parametrize("wrong", [{"stiffness": 0.0}, {"mass": -1.0}, {"slack": -0.01}, {"stiffness": math.nan}])
def test_springs_are_springs(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidInput, match=next(iter(wrong))):
        criteria.vpi([0.0, 0.1], [-100.0, -100.0], **wrong)


@pytest.mark.parametrize("wrong", [{"free_flight": 0.0}, {"restrained": -0.1}])
def test_olc_lengths_are_lengths(wrong: dict[str, float]) -> None:
    with pytest.raises(InvalidInput, match=next(iter(wrong))):
        criteria.olc([0.0, 0.1], [-100.0, -100.0], **wrong)


def test_a_time_in_the_wrong_unit_does_not_swing_for_ever() -> None:
    with pytest.raises(InvalidInput, match="Check the units"):
        criteria.vpi([0.0, 1e9], [-100.0, -100.0])
