"""Ride-down and restraint energy of motions whose answer can be written down."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ridedown import criteria
from ridedown.errors import InvalidInput

CAR = ([0.0, 0.1, 0.1, 0.2], [-150.0, -150.0, 0.0, 0.0])  # 15 m/s to rest in 100 ms, 0.75 m


def parts(split: criteria.EnergySplit | None) -> tuple[float, float, float, float]:
    assert split is not None
    return split.initial, split.ride_down, split.restraint, split.remaining


def test_an_occupant_one_with_the_car_rides_down_all_its_energy() -> None:
    assert parts(criteria.energy_split(CAR, CAR, 15.0)) == pytest.approx((112.5, 112.5, 0.0, 0.0), abs=1e-12)


def test_an_occupant_that_flies_free_rides_down_nothing() -> None:
    free = ([0.0, 0.1, 0.1, 0.2], [0.0, 0.0, -300.0, -300.0])
    assert parts(criteria.energy_split(CAR, free, 15.0)) == pytest.approx((112.5, 0.0, 0.0, 112.5), abs=1e-12)
    assert criteria.ridedown_efficiency(CAR, free, 15.0) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("free", [0.0, 0.02, 0.05])
def test_an_occupant_held_late_by_a_constant_force(free: float) -> None:
    # over the car's way from the end of the free flight: d (x_v(100 ms) - x_v(free)), d (100 ms - free) off its speed
    occupant = ([0.0, free, free, 0.2], [0.0, 0.0, -120.0, -120.0])
    way = 0.75 - (15.0 * free - 75.0 * free**2)
    left = 15.0 - 120.0 * (0.1 - free)
    initial, ride_down, restraint, remaining = parts(criteria.energy_split(CAR, occupant, 15.0))
    assert ride_down == pytest.approx(120.0 * way, rel=1e-12)
    assert remaining == pytest.approx(0.5 * left**2, rel=1e-12)
    assert restraint == pytest.approx(112.5 - 120.0 * way - 0.5 * left**2, rel=1e-10)
    assert initial == 112.5


def test_half_sine_car_and_ramped_belt() -> None:
    # v_v = v0 cos^2-like fall: v0 (1 + cos(pi t/T))/2 over T; belt force c t: ride-down is the integral of c t v_v
    T, v0, c = 0.1, 10.0, 1000.0
    t = np.linspace(0.0, T, 4001)
    car = (t, -0.5 * v0 * math.pi / T * np.sin(math.pi * t / T))
    split = criteria.energy_split((car[0], car[1] * (1.0 + 1e-7)), ([0.0, 0.2], [0.0, -200.0]), v0)
    assert split is not None
    assert split.ride_down == pytest.approx(c * v0 * T**2 * (0.25 - 1.0 / math.pi**2), rel=1e-4)
    assert split.ride_down + split.restraint + split.remaining == pytest.approx(split.initial, rel=1e-12)


def test_signals_of_different_clocks_are_met_where_both_are() -> None:
    early = (np.array([-0.05, 0.0, 0.0, 0.1, 0.1, 0.2]), np.array([-2.0, -2.0, -150.0, -150.0, 0.0, 0.0]))
    assert parts(criteria.energy_split(early, CAR, 15.0)) == pytest.approx((112.5, 112.5, 0.0, 0.0), abs=1e-9)


def test_a_car_that_does_not_stop_has_no_split() -> None:
    assert criteria.energy_split(([0.0, 0.05], [-150.0, -150.0]), CAR, 15.0) is None
    assert criteria.ridedown_efficiency(([0.0, 0.05], [-150.0, -150.0]), CAR, 15.0) is None


def test_what_cannot_be_split_is_refused() -> None:
    with pytest.raises(InvalidInput, match="Take a longer record"):
        criteria.energy_split(CAR, ([0.0, 0.05], [-150.0, -150.0]), 15.0)
    with pytest.raises(InvalidInput, match="time in common"):
        criteria.energy_split(CAR, ([0.5, 0.6], [-150.0, -150.0]), 15.0)
    with pytest.raises(InvalidInput, match="speed"):
        criteria.energy_split(CAR, CAR, 0.0)
    with pytest.raises(InvalidInput, match="occupant"):
        criteria.energy_split(CAR, ([0.0, 0.1], [math.nan, 0.0]), 15.0)
