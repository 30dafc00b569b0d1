"""A calibration made of a test alone: what can be fitted is found, and a known restraint comes back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals import TestRecord, TimeHistory
from ridedown.signals.record import ChannelInfo, Occupant, Vehicle
from ridedown.simulation import simulate
from ridedown.studies import calibrate
from ridedown.studies.calibration.of_test import TEMPLATES, calibration_of_test, fittable
from ridedown.studies.sled_of_test import sled_of_test
from tests.studies.calibration.synthetic import MASS, OF_SLED, sled_test


@pytest.fixture(scope="module")
def record() -> TestRecord:
    return sled_test()


def test_a_known_restraint_comes_back(record: TestRecord) -> None:
    asked = calibration_of_test(record, "chest x", "spring and damper", pulse="sled x", mass=MASS, effort="quick")
    found = calibrate(asked)
    # the pulse is straight lines through what was filtered, and the peak counts by itself
    for name, value in OF_SLED.items():
        assert found.values[name] == pytest.approx(value, rel=0.06)
    assert found.channels[0].rating is not None
    assert found.channels[0].rating.value > 0.97


def test_what_is_held_stays(record: TestRecord) -> None:
    asked = calibration_of_test(
        record, "chest x", "spring and damper", pulse="sled x", mass=MASS, free={"stiffness": (20e3, 90e3)},
        held={"slack": 0.02, "damping ratio": 0.25}, end=0.1, effort="quick",
    )  # fmt: skip
    found = calibrate(asked)
    assert list(found.values) == ["stiffness"]
    assert found.values["stiffness"] == pytest.approx(OF_SLED["stiffness"], rel=0.03)
    fitted = found.scenarios["occupant"].occupants[0]
    assert (fitted.mass, fitted.restraint.slack, fitted.restraint.damping_ratio) == (MASS, 0.02, 0.25)
    assert found.channels[0].times[-1] == pytest.approx(0.1)


def test_every_template_is_one_that_can_be_simulated_and_whose_numbers_are_there(record: TestRecord) -> None:
    for name in TEMPLATES:
        asked = calibration_of_test(record, "chest x", name, pulse="sled x")
        assert [p.name for p in asked.parameters] == [n.name for n in TEMPLATES[name].numbers]
        assert simulate(asked.cases[0].scenario).completed


def test_the_pulse_that_is_named_gives_the_speed(record: TestRecord) -> None:
    sled = sled_of_test(record, pulse="sled x")
    change = -np.trapezoid(record.history("sled x").si[1], record.history("sled x").time)
    assert sled.initial_speed == pytest.approx(change, rel=2e-3)


def test_the_mass_is_that_of_the_dummy() -> None:
    curve = TimeHistory([0.0, -1.0, 0.0], "g", interval=1e-3, name="x")
    infos = {
        key: ChannelInfo(key, name=key, location="chest", quantity="acceleration", axis="x", unit="g", vehicle=1, occupant=seat)
        for key, seat in (("c", "03"), ("b", "02"), ("a", "01"))
    }
    people = (
        Occupant("01", 1, dummy="Hybrid III", percentile="50"),
        Occupant("02", 1, dummy="Hybrid III", percentile="05"),
        Occupant("03", 1, dummy="THOR", percentile="50"),
    )
    test = TestRecord("t", vehicles=(Vehicle(1),), occupants=people, channels=infos, load=lambda _: curve)
    assert [(one.key, one.seat, one.mass) for one in fittable(test)] == [
        ("a", "01", 78.0),
        ("b", "02", 49.0),
        ("c", "03", 78.0),
    ]


@pytest.mark.parametrize(
    ("channel", "changes", "error", "words"),
    [
        ("chest y", {}, UnknownName, "chest x"),
        ("chest x", {"template": "rope"}, UnknownName, "belt"),
        ("chest x", {"free": {}}, InvalidInput, "need one at least"),
        ("chest x", {"free": {"stifness": (1.0, 2.0)}}, UnknownName, "stiffness"),
        ("chest x", {"end": -0.1}, InvalidInput, "end"),
        ("chest x", {"pulse": ""}, InvalidInput, "pulse"),
        ("chest x", {"pulse": "sled y"}, UnknownName, "sled x"),
        ("chest x", {"pulse": "chest x"}, InvalidInput, "which is fitted"),
        ("chest x", {"mass": -1.0}, InvalidInput, "mass"),
    ],
)
def test_what_cannot_be_is_refused(
    record: TestRecord, channel: str, changes: dict[str, Any], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        calibration_of_test(record, channel, **({"template": "spring and damper", "pulse": "sled x"} | changes))
