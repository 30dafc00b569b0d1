"""The motion of a vehicle, from whatever has one."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown import load, network, simulate
from ridedown.errors import InvalidInput, UnknownName
from ridedown.motion import motion_of
from ridedown.scenario.lowering import pulse_of
from ridedown.signals import TimeHistory


def test_a_sled_and_its_response_move_alike():
    sled = load("sled-half-sine")
    one, two, times = motion_of(sled), motion_of(simulate(sled)), np.linspace(0.0, 0.2, 101)
    for prescribed, solved in zip(one.at(times), two.at(times), strict=True):
        np.testing.assert_allclose(solved, prescribed, atol=1e-9)


def test_a_pulse_ends_with_its_last_piece():
    sled = load("sled-half-sine")
    motion = motion_of(pulse_of(sled))
    assert motion.end == pytest.approx(0.1, rel=1e-15)
    np.testing.assert_allclose(motion.at([0.02, 0.05])[0], motion_of(sled).at([0.02, 0.05])[0], rtol=1e-15)
    with pytest.raises(InvalidInput, match="need a pulse that ends"):
        motion_of(network.Pulse(np.zeros(1), np.array([[-100.0]])))


def test_a_measured_channel_counts_from_time_zero():
    history = TimeHistory([0.0, 5.0, -20.0, -10.0], "g", start=-0.01, interval=0.01)
    motion = motion_of(history)
    assert motion.end == pytest.approx(0.02, rel=1e-12)
    np.testing.assert_allclose(motion.at([0.0, 0.005])[0], 9.80665 * np.array([5.0, -7.5]), rtol=1e-12)
    with pytest.raises(InvalidInput):
        motion_of(TimeHistory([0.0, 5.0], "mm", interval=0.01))


def test_a_vehicle_that_is_not_there():
    with pytest.raises(UnknownName):
        motion_of(load("sled-half-sine"), "vehicle2")
