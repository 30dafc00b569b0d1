"""The bound for every crash of a map: what is drawn against what is solved for one crash alone."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown.apps.web.bounds import bound_here, bound_map
from ridedown.apps.web.maps import outcomes
from ridedown.apps.web.requests import scenario_of
from ridedown.errors import InvalidInput, UnknownName
from ridedown.motion import motion_of
from ridedown.scenario import Scenario, load, substitute
from ridedown.simulation import simulate
from ridedown.studies.bound import Limiting, gap_of

DRIVER = "driver.acceleration.peak"
MAPS = {
    "one pulse": ("example-offset", DRIVER, "driver.restraint.stiffness", "driver.restraint.slack", 0.003),
    "a pulse for each column": ("example-offset", DRIVER, "vehicle1.speed", "driver.restraint.slack", 0.03),
    "a pulse for each row": ("sled-half-sine", "adult.acceleration.peak", "adult.restraint.slack", "pulse.duration", 0.03),
    "a pulse for each crash": ("example-offset", DRIVER, "vehicle1.speed", "vehicle1.mass", 0.03),
    "the other vehicle": (
        "example-offset", "other-driver.acceleration.peak", "other-driver.mass", "other-driver.restraint.slack", 0.003,
    ),
    "an occupant who pushes on the car": (
        "example-restraints", "driver.chest.acceleration.peak", "driver.shoulder-belt.stiffness", "driver.airbag.gap", 0.03,
    ),
}  # fmt: skip
"""Scenario, outcome, axes, and how far what is drawn between may be from what is solved."""


def asked(name: str, outcome: str, x: str, y: str, **more: object) -> tuple[Scenario, dict[str, object]]:
    message = {"scenario": name, "outcome": outcome, "x": x, "y": y, **more}
    return scenario_of(message), message


@pytest.mark.parametrize("kind", MAPS)
def test_what_is_drawn_is_near_what_is_solved(kind: str) -> None:
    name, outcome, x, y, near = MAPS[kind]
    scenario, message = asked(name, outcome, x, y)
    header, found = bound_map(scenario, message)
    assert header["body"] == outcome.removesuffix(".acceleration.peak")
    rng = np.random.default_rng(3)
    places = [place for place in rng.integers(8, 92, (12, 2)) if np.isfinite(found["least"][place[1], place[0]])][:6]
    assert len(places) >= 4
    for i, j in places:
        response = simulate(substitute(scenario, {x: float(found["x"][i]), y: float(found["y"][j])}))
        gap = gap_of(response, header["body"])
        assert found["excursion"][j, i] == pytest.approx(gap.design.excursion, rel=1e-5)
        assert found["least"][j, i] == pytest.approx(gap.bound.peak, rel=near)
        assert found["least"][j, i] <= gap.design.peak * (1.0 + near)


def test_within_one_room_for_all() -> None:
    scenario, message = asked("example-offset", DRIVER, "driver.restraint.stiffness", "driver.restraint.slack", room=0.25)
    _, found = bound_map(scenario, message)
    response = simulate(scenario)
    least = Limiting(motion_of(response, "vehicle1"), horizon=response.end_time).bound(0.25).peak
    assert found["least"] == pytest.approx(np.full((100, 100), least), rel=1e-6)  # sent as floats
    here = bound_here(scenario, message)
    assert here["least"] == pytest.approx(least, rel=1e-12)
    assert (here["within"], here["room"]) == (0.25, 0.25)


def test_the_crash_that_is_chosen_is_solved_for_itself() -> None:
    values = {"vehicle1.mass": 1100.0, "driver.restraint.slack": 0.03}
    scenario, message = asked("example-offset", DRIVER, "vehicle1.speed", "vehicle1.mass", values=values)
    here = bound_here(scenario, message)
    response = simulate(substitute(load("example-offset"), values))
    gap = gap_of(response, "driver")
    design = gap.design
    said = [here[field] for field in ("peak", "excursion", "least", "needs")]
    assert said == pytest.approx([design.peak, design.excursion, gap.bound.peak, gap.least_excursion], rel=1e-12)
    assert here["outcome"] == abs(response.peak("driver.acceleration").value)
    assert here["holds"] is True


def test_crashes_that_cannot_be_have_no_bound() -> None:
    scenario, message = asked(
        "example-restraints", "driver.chest.acceleration.peak", "driver.shoulder-belt.stiffness", "driver.shoulder-belt.slack"
    )
    _, found = bound_map(scenario, message)
    refused = found["x"] > 150e3  # stiffer than its own unloading
    assert np.isnan(found["least"][:, refused]).all()
    assert np.isfinite(found["least"][:, ~refused]).mean() > 0.99


@pytest.mark.parametrize(
    ("outcome", "error"),
    [("driver.excursion.max", InvalidInput), ("vehicle1.acceleration.peak", InvalidInput), ("nonsense", InvalidInput)],
)
def test_outcomes_without_a_bound(outcome: str, error: type[Exception]) -> None:
    scenario, message = asked("example-offset", outcome, "vehicle1.speed", "vehicle1.mass")
    for compute in (bound_map, bound_here):
        with pytest.raises(error, match="no bound"):
            compute(scenario, message)


@pytest.mark.parametrize(
    ("more", "error"), [({"x": "vehicle1.sped"}, UnknownName), ({"room": -1.0}, InvalidInput), ({"room": "wide"}, InvalidInput)]
)
def test_what_is_refused(more: dict[str, object], error: type[Exception]) -> None:
    scenario, message = asked("example-offset", DRIVER, "vehicle1.speed", "vehicle1.mass")
    with pytest.raises(error):
        bound_map(scenario, {**message, **more})


def test_networks_and_cars_have_none() -> None:
    assert {one["bound"] for one in outcomes(load("marzbanrad-5"))} == {None}
    bodies = {one["bound"] for one in outcomes(load("example-restraints"))}
    assert bodies == {None, "driver.pelvis", "driver.chest", "driver.head"}
