"""What tends to something, gets there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ridedown import load, simulate
from ridedown.scenario import CrashScenario, NetworkScenario, substitute
from tests import samples
from tests.compare import assert_alike

PAPER = ("paper-adult-full", "paper-child-full", "paper-adult-offset", "paper-child-offset")
LAWS = ("threshold", "kelvin-voigt")


@pytest.mark.parametrize("law", LAWS)
def test_zero_slack_is_the_limit_of_little_slack(law: str) -> None:
    p1 = load("p1")
    adult = p1.occupants[0]
    belt = adult.restraint.model_copy(update={"law": law})
    p1 = p1.model_copy(update={"occupants": (adult.model_copy(update={"restraint": belt}), *p1.occupants[1:])})
    taut = simulate(substitute(p1, {"adult.restraint.slack": 0.0}))
    gaps = []
    for slack in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        loose = simulate(substitute(p1, {"adult.restraint.slack": slack}))
        gaps.append(abs(loose.peak("adult.acceleration").value / taut.peak("adult.acceleration").value - 1.0))
    assert sorted(gaps, reverse=True) == gaps
    assert gaps[-1] < 1e-5  # the speed at which a slack s is taken up goes with its root


def test_slack_below_rounding_is_none() -> None:
    p1 = load("p1")
    taut, hair = (simulate(substitute(p1, {"adult.restraint.slack": slack})) for slack in (0.0, 1e-300))
    assert_alike(taut, hair, rtol=1e-12)


@pytest.mark.parametrize("name", PAPER[:2])
def test_a_bar_that_may_turn_but_need_not(name: str) -> None:
    full = load(name)
    assert full.bar is not None
    assert full.bar.inertia is not None
    fixed = full.model_copy(update={"bar": full.bar.model_copy(update={"inertia": None})})
    free, held = simulate(full), simulate(fixed)
    assert_alike(held, free, rtol=1e-9)
    assert free.peak("bar.rotation").value == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("name", PAPER[2:])
@pytest.mark.parametrize("offset", [1e-3, 1e-5, 1e-7])
def test_full_overlap_is_the_limit_of_offset(name: str, offset: float) -> None:
    crash = load(name)
    full, nearly = (simulate(substitute(crash, {"bar.lateral_offset": c})) for c in (0.0, offset))
    # alike cars: what changes does so with the square of the offset, but for the bar's turning
    channels = [c for c in full.channels if c.endswith(("displacement", "velocity")) and not c.startswith("bar")]
    assert_alike(full, nearly, rtol=10.0 * offset**2 + 1e-9, channels=channels)
    assert 0.0 < abs(nearly.peak("bar.rotation").value) < 10.0 * offset


def test_full_overlap_is_the_limit_of_offset_for_unequal_sides() -> None:
    data = samples.crash_data(np.random.default_rng(5), wall=False, softening=False)
    data["bar"] = {"mass": 40.0, "inertia": 157.0, "rail_spacing": 1.1}
    full, nearly = (
        simulate(CrashScenario(**data | {"bar": data["bar"] | {"lateral_offset": c}}), throw=False) for c in (0.0, 1e-9)
    )
    assert_alike(full, nearly, rtol=1e-6)


def test_a_heavy_vehicle_that_stands_is_a_wall() -> None:
    members = {"pieces": [{"stiffness": 150e3, "until": 0.3}, {"stiffness": 550e3}]}
    rock = {"pieces": [{"stiffness": 1e9}]}
    car = {"mass": 1500.0, "speed": 15.0, "members": members}
    wall = simulate(CrashScenario(vehicle1=car, duration=0.1))
    block = {"mass": 1e12, "speed": 0.0, "members": rock}
    bar = {"mass": 1.0, "rail_spacing": 1.1, "speed": 0.0}
    stood = simulate(CrashScenario(vehicle1=car, vehicle2=block, bar=bar, duration=0.1))
    for channel in ("vehicle1.acceleration", "vehicle1.displacement"):
        assert stood.peak(channel).value == pytest.approx(wall.peak(channel).value, rel=1e-3)


@pytest.mark.parametrize("law", LAWS)
def test_critical_damping_is_nothing_special(law: str) -> None:
    def belt(ratio: float) -> Any:
        return simulate(substitute(load("paper-adult-full"), {"adult.restraint.damping_ratio": ratio})).peak(
            "adult.acceleration"
        )

    below, at, above = (belt(ratio).value for ratio in (1.0 - 1e-9, 1.0, 1.0 + 1e-9))
    assert below == pytest.approx(at, rel=1e-8)
    assert above == pytest.approx(at, rel=1e-8)


def test_plastic_along_its_own_slope_is_elastic_while_it_does_not_reload() -> None:
    def wall(**unloading: Any) -> CrashScenario:
        return CrashScenario(
            vehicle1={"mass": 1500.0, "speed": 10.0, "members": {"pieces": [{"stiffness": 200e3}], **unloading}}
        )

    elastic = simulate(wall())
    plastic = simulate(wall(unloading="plastic", unloading_stiffness=200e3))
    assert_alike(elastic, plastic, rtol=1e-9)
    assert plastic.vehicles["vehicle1"].residual_crush == pytest.approx(0.0, abs=1e-8)


def test_a_weightless_engine_between_two_springs_is_their_series() -> None:
    def chain(mass: float) -> NetworkScenario:
        return NetworkScenario(
            duration=0.05,
            masses=[{"name": "light", "mass": mass, "speed": 10.0}, {"name": "car", "mass": 1000.0, "speed": 10.0}],
            elements=[
                {"name": "front", "between": ["wall", "light"], "stiffness": 600e3},
                {"name": "rear", "between": ["light", "car"], "stiffness": 300e3},
            ],
        )

    rate = np.sqrt(200e3 / 1000.0)
    times = np.linspace(0.0, 0.05, 26)
    exact = 10.0 / rate * np.sin(rate * times)
    errors = [np.abs(simulate(chain(m)).at("car.displacement", times) - exact).max() for m in (1.0, 1e-2)]
    assert errors[1] < 0.02 * errors[0] < 1e-3
