"""Change of velocity, crush, rest and rebound of pulses whose answer can be written down."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ridedown import criteria
from ridedown.errors import InvalidInput

T = 0.1  # s, duration of the pulses
K = np.linspace(0.0, 1.0, 20_001)
HALF_SINE = (T * K, -300.0 * np.sin(math.pi * K))
HAVERSINE = (T * K, -300.0 * np.sin(math.pi * K) ** 2)
REBOUND = ([0.0, 0.08, 0.08, 0.12, 0.12, 0.2], [-200.0, -200.0, -50.0, -50.0, 10.0, 10.0])  # -16, -18, then braked at 10 m/s2


def test_peak_keeps_its_sign_and_is_the_first_of_equals() -> None:
    assert criteria.peak([0.0, 1.0, 2.0, 3.0], [1.0, -5.0, 5.0, 0.0]) == criteria.Peak(-5.0, 1.0)
    assert criteria.peak([0.0, 1.0], [0.0, 9.80665]).value_g == pytest.approx(1.0)


def test_change_of_velocity_is_the_largest_and_not_that_at_the_end() -> None:
    found = criteria.delta_v(*REBOUND)
    assert (found.value, found.time) == pytest.approx((-18.0, 0.12))


def test_change_of_velocity_turns_between_samples() -> None:
    found = criteria.delta_v([0.0, 0.1, 0.3], [-100.0, -100.0, 300.0])  # zero at 0.15 s
    assert (found.value, found.time) == pytest.approx((-12.5, 0.15), rel=1e-13)


@pytest.mark.parametrize(("pulse", "mean"), [(HALF_SINE, 2.0 / math.pi), (HAVERSINE, 0.5)])
def test_change_of_velocity_of_smooth_pulses(pulse: tuple[np.ndarray, np.ndarray], mean: float) -> None:
    assert criteria.delta_v(*pulse).value == pytest.approx(-300.0 * T * mean, rel=1e-8)


def test_half_sine_that_stops_the_car_at_its_middle_throws_it_back_as_fast() -> None:
    v0 = 300.0 * T / math.pi
    assert criteria.time_to_zero_velocity(*HALF_SINE, v0) == pytest.approx(0.5 * T, rel=1e-8)
    crush = criteria.dynamic_crush(*HALF_SINE, v0)
    assert crush is not None
    assert (crush.value, crush.time) == pytest.approx((v0 * T / math.pi, 0.5 * T), rel=1e-8)
    assert criteria.coefficient_of_restitution(*HALF_SINE, v0) == pytest.approx(1.0, rel=1e-8)
    assert criteria.average_square_wave(*HALF_SINE, v0) == pytest.approx(2.0 * v0 / T, rel=1e-8)
    assert criteria.equivalent_square_wave(*HALF_SINE, v0) == pytest.approx(0.5 * math.pi * v0 / T, rel=1e-8)


def test_haversine() -> None:
    v0 = 300.0 * T / 4.0
    crush = criteria.dynamic_crush(*HAVERSINE, v0)
    assert crush is not None
    assert crush.value == pytest.approx(300.0 * T**2 * (1.0 / 16.0 + 0.25 / math.pi**2), rel=1e-8)
    assert criteria.coefficient_of_restitution(*HAVERSINE, v0) == pytest.approx(1.0, rel=1e-8)


def test_double_pulse() -> None:
    time, a = [0.0, 0.02, 0.02, 0.05, 0.05, 0.2], [-300.0, -300.0, 0.0, 0.0, -200.0, -200.0]
    # 15 m/s: 9 after the first pulse, held for 30 ms, then 45 ms to rest
    crush = criteria.dynamic_crush(time, a, 15.0)
    assert crush is not None
    assert crush.time == pytest.approx(0.095, rel=1e-13)
    assert crush.value == pytest.approx(12.0 * 0.02 + 9.0 * 0.03 + 4.5 * 0.045, rel=1e-13)
    assert criteria.average_square_wave(time, a, 15.0) == pytest.approx(15.0 / 0.095, rel=1e-13)
    assert criteria.equivalent_square_wave(time, a, 15.0) == pytest.approx(15.0**2 / (2.0 * crush.value), rel=1e-13)


def test_rebound_with_braking_on_the_ground() -> None:
    assert criteria.time_to_zero_velocity(*REBOUND, 15.0) == pytest.approx(0.075, rel=1e-13)
    assert criteria.coefficient_of_restitution(*REBOUND, 15.0) == pytest.approx(3.0 / 15.0, rel=1e-13)


def test_a_car_that_stops_and_stays_does_not_rebound() -> None:
    assert criteria.coefficient_of_restitution([0.0, 0.05, 0.05, 0.1], [-200.0, -200.0, 0.0, 0.0], 10.0) == 0.0


def test_a_touch_of_zero_between_samples_is_a_stop() -> None:
    # 5 - 100 t + 500 t^2 touches zero at 0.1 s, between the samples; a little faster and it does not
    assert criteria.time_to_zero_velocity([0.0, 0.15], [-100.0, 50.0], 5.0 - 1e-12) == pytest.approx(0.1, abs=1e-6)
    assert criteria.time_to_zero_velocity([0.0, 0.15], [-100.0, 50.0], 5.0 + 1e-9) is None


def test_a_car_that_does_not_stop_has_no_crush_to_speak_of() -> None:
    arguments = ([0.0, 0.05], [-100.0, -100.0], 15.0)
    assert criteria.time_to_zero_velocity(*arguments) is None
    assert criteria.dynamic_crush(*arguments) is None
    assert criteria.coefficient_of_restitution(*arguments) is None
    assert criteria.average_square_wave(*arguments) is None
    assert criteria.equivalent_square_wave(*arguments) is None


def test_what_comes_before_time_zero_is_left_out() -> None:
    late = ([-0.05, 0.0, 0.0, 0.10], [-3.0, -3.0, -200.0, -200.0])
    assert criteria.time_to_zero_velocity(*late, 15.0) == pytest.approx(0.075, rel=1e-13)
    assert criteria.delta_v(*late).value == pytest.approx(-20.0, rel=1e-13)
    assert criteria.delta_v(*late, start=-0.05).value == pytest.approx(-20.15, rel=1e-13)
    assert criteria.delta_v([-0.05, 0.1], [-200.0, -200.0]).value == pytest.approx(-20.0, rel=1e-13)  # within a sample


def test_a_start_may_be_given() -> None:
    crush = criteria.dynamic_crush([0.0, 1.0], [-200.0, -200.0], 15.0, start=0.4)
    assert crush is not None
    assert (crush.value, crush.time) == pytest.approx((0.5625, 0.475), rel=1e-12)
    assert criteria.average_square_wave([0.0, 1.0], [-200.0, -200.0], 15.0, start=0.4) == pytest.approx(200.0, rel=1e-12)


def test_a_record_that_begins_after_time_zero_begins_with_itself() -> None:
    assert criteria.delta_v([5.0, 5.1], [-200.0, -200.0]) == criteria.Peak(pytest.approx(-20.0), pytest.approx(5.1))


def test_starts_outside_the_signal_are_refused() -> None:
    for start in (-0.1, 1.0, math.nan):
        with pytest.raises(InvalidInput, match="start"):
            criteria.delta_v([0.0, 1.0], [1.0, 1.0], start=start)
    with pytest.raises(InvalidInput, match="beyond time zero"):
        criteria.delta_v([-1.0, -0.5], [1.0, 1.0])


@pytest.mark.parametrize("speed", [0.0, -15.0, math.nan, math.inf])
def test_speeds_are_above_zero(speed: float) -> None:
    for function in (criteria.dynamic_crush, criteria.time_to_zero_velocity, criteria.coefficient_of_restitution):
        with pytest.raises(InvalidInput, match="speed"):
            function([0.0, 1.0], [-1.0, -1.0], speed)
