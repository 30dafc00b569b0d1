"""An occupant in a sled that follows its own crash responds as in the crash: sled and crash are one and the same to it."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import pytest

from ridedown import load, simulate
from ridedown.scenario import CrashScenario, NetworkScenario, SledScenario, dump

CHILD = {
    "kind": "child",
    "mass": 18,
    "restraint": {"stiffness": 49e3, "slack": 0.005, "damping_ratio": 0.5},
    "seat": {"mass": 5, "restraint": {"stiffness": 50e3, "slack": 0.005, "damping_ratio": 0.5, "law": "kelvin-voigt"}},
}


def followed(crash: CrashScenario, vehicle: int = 1) -> SledScenario:
    """A sled that follows a vehicle of a crash, with those who sit in it."""
    people = [{**o.model_dump(exclude_none=True), "vehicle": 1} for o in crash.occupants if o.vehicle == vehicle]
    return SledScenario(pulse={"kind": "scenario", "scenario": crash, "vehicle": vehicle}, occupants=people)


def assert_same(crash: CrashScenario, vehicle: int = 1) -> None:
    sled = followed(crash, vehicle)
    one, other = simulate(crash), simulate(sled)
    assert sled.duration == crash.duration
    for occupant in sled.occupants:
        for quantity in ("acceleration", "velocity", "excursion"):
            name = f"{occupant.name}.{quantity}"
            expected = one.peak(name)
            found = other.peak(name)
            assert found.value == pytest.approx(expected.value, rel=1e-9)
            if quantity != "velocity":  # whose largest value is there from the start
                assert found.time == pytest.approx(expected.time, abs=1e-9)
            times = one.times(1e-3)
            scale = abs(expected.value)
            np.testing.assert_allclose(other.at(name, times), one.at(name, times), rtol=0, atol=1e-9 * scale)
    there = [(e.time, e.what) for e in one.events if e.who.startswith(tuple(f"{o.name}." for o in sled.occupants))]
    here = [(e.time, e.what) for e in other.events]
    assert [what for _, what in here] == [what for _, what in there]
    np.testing.assert_allclose([t for t, _ in here], [t for t, _ in there], atol=1e-9)


@pytest.mark.parametrize("name", ["paper-adult-offset", "paper-adult-full", "paper-child-offset", "p1"])
def test_published_crashes(name):
    crash = load(name)
    assert isinstance(crash, CrashScenario)
    assert_same(crash)


def test_the_other_vehicle():
    crash = load("example-offset")
    assert isinstance(crash, CrashScenario)
    people = [o.model_copy(update={"coupled": False}) for o in crash.occupants]
    assert_same(crash.model_copy(update={"occupants": tuple(people)}), vehicle=2)


def test_restraints_with_everything_on():
    crash = load("example-restraints")
    assert isinstance(crash, CrashScenario)
    people = [o.model_copy(update={"coupled": False}) for o in crash.occupants]
    crash = crash.model_copy(update={"occupants": tuple(people)})
    assert_same(crash)
    sled = followed(crash)
    assert load(tomllib.loads(dump(sled))) == sled


def test_a_wall_with_a_plastic_front_and_a_child():
    members: dict[str, Any] = {"pieces": [{"stiffness": 3e5}], "unloading": "plastic", "unloading_stiffness": 5e6}
    assert_same(CrashScenario(vehicle1={"mass": 1400, "speed": 14, "members": members}, occupants=[CHILD], duration=0.12))


def test_a_mass_of_a_network():
    network = load("marzbanrad-2")
    assert isinstance(network, NetworkScenario)
    sled = SledScenario(pulse={"kind": "scenario", "scenario": network, "vehicle": "vehicle"})
    one, other = simulate(network), simulate(sled)
    times = one.times(1e-3)
    np.testing.assert_allclose(other.at("vehicle1.acceleration", times), one.at("vehicle.acceleration", times), atol=1e-9)
    assert sled.initial_speed == 14.0


def test_a_sled_of_a_reconstruction_says_so():
    assert any(source.confidence == "reconstructed" for source in followed(load("paper-adult-full")).sources)


def test_half_the_pulse_is_half_the_speed():
    sled = load({"pulse": {"kind": "scenario", "scenario": "paper-adult-full", "scale": 0.5}})
    crash = simulate(load("paper-adult-full"))
    times = crash.times(1e-3)
    np.testing.assert_allclose(
        simulate(sled).at("vehicle1.velocity", times), crash.at("vehicle1.velocity", times) / 2, atol=1e-12
    )
