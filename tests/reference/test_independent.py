"""The independent simulator against P1's reference answers, exact solutions, and a method without events."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from ridedown.scenario import CrashScenario, NetworkScenario
from tests import independent
from tests.independent_laws import Curve

VECTORS = Path(__file__).resolve().parents[3] / "shared" / "vectors" / "p1.npz"


@pytest.mark.skipif(not VECTORS.exists(), reason="the shared reference answers are not beside this repository")
def test_p1() -> None:
    vectors = np.load(VECTORS)
    nominal = [1500.0, 1500.0, 118.2e3, 465e3, 0.356, 98.1e3, 2801.0, 49e3, 939.0, 50e3, 500.0, 13.33]
    np.testing.assert_allclose(independent.p1_reference(nominal), vectors["nominal_outputs"], rtol=1e-12)
    for i in (0, 119, 151):
        answer = independent.p1_reference(vectors["params"][i])
        np.testing.assert_allclose(answer, vectors["outputs"][i], rtol=1e-12)


def test_two_masses_on_linear_elements_by_the_matrix_exponential() -> None:
    # Marzbanrad and Pahlavani's model of two masses
    network = NetworkScenario(
        duration=0.15,
        masses=[{"name": "m1", "mass": 800.0, "speed": 14.0}, {"name": "m2", "mass": 80.0, "speed": 14.0}],
        elements=[
            {"name": "front", "between": ["wall", "m1"], "stiffness": 1000.0, "damping": 10000.0},
            {"name": "belt", "between": ["m1", "m2"], "stiffness": 2860.0, "damping": 1100.0},
        ],
    )
    matrix = np.zeros((4, 4))
    matrix[:2, 2:] = np.eye(2)
    matrix[2] = np.array([-3860.0, 2860.0, -11100.0, 1100.0]) / 800.0
    matrix[3] = np.array([2860.0, -2860.0, 1100.0, -1100.0]) / 80.0
    times = np.linspace(0.0, 0.15, 31)
    exact = np.array([expm(matrix * t) @ [0.0, 0.0, 14.0, 14.0] for t in times])
    run = independent.simulate(network)
    assert not run.events
    np.testing.assert_allclose(run.at("m2.velocity", times), exact[:, 3], rtol=1e-12)
    np.testing.assert_allclose(run.at("m2.acceleration", times)[1:], (exact @ matrix[3])[1:], rtol=1e-12)
    np.testing.assert_allclose(run.at("belt.deflection", times)[1:], (exact[:, 1] - exact[:, 0])[1:], rtol=1e-11)


def test_an_elastic_wall_test_is_half_a_swing() -> None:
    car = CrashScenario(vehicle1={"mass": 1000.0, "speed": 10.0, "members": {"pieces": [{"stiffness": 200e3}]}})
    run = independent.simulate(car)
    rate = np.sqrt(400e3 / 1000.0)
    crush, at = run.maximum("vehicle1.displacement")
    assert crush == pytest.approx(10.0 / rate, rel=1e-13)
    assert at == pytest.approx(np.pi / 2.0 / rate, rel=1e-7)  # where a peak lies is half as well known as how high it is
    assert [event.time for event in run.events] == pytest.approx([np.pi / rate] * 2, rel=1e-12)
    assert run.at("vehicle1.velocity", 0.2)[0] == pytest.approx(-10.0, rel=1e-12)


def test_plastic_unloading_gives_the_work_back_that_its_line_holds() -> None:
    members = {"pieces": [{"stiffness": 200e3}], "unloading": "plastic", "unloading_stiffness": 2e6}
    run = independent.simulate(CrashScenario(vehicle1={"mass": 1000.0, "speed": 10.0, "members": members}))
    # the line's triangle against the curve's: F^2 / 2 ku against F^2 / 2 k
    assert run.at("vehicle1.velocity", 0.2)[0] == pytest.approx(-10.0 * np.sqrt(0.1), rel=1e-12)
    crush = run.maximum("vehicle1.displacement")[0]
    assert run.at("vehicle1.displacement", run.events[-1].time)[0] == pytest.approx(0.9 * crush, rel=1e-12)


PLASTIC: dict[str, Any] = {"unloading": "plastic", "unloading_stiffness": 5e6}
NEON = [[0.0, 13.18e3], [0.1171, 134.75e3], [0.2342, 145.71e3], [0.3513, 145.71e3], [0.4684, 336.12e3]]
STIFFENING = {"pieces": [{"stiffness": 118.2e3, "until": 0.356}, {"stiffness": 465e3}]}


def crash(law: str, *, coupled: bool, plastic: bool, offset: float, lever_arm: str) -> CrashScenario:
    belt = {"stiffness": 98.1e3, "damping_ratio": 0.5, "slack": 0.005, "law": law}
    return CrashScenario(
        duration=0.12,
        vehicle1={"mass": 1500.0, "speed": 13.33, "members": STIFFENING | (PLASTIC if plastic else {})},
        vehicle2={"mass": 2200.0, "speed": 9.0, "members": {"points": NEON} | (PLASTIC if plastic else {})},
        bar={"mass": 40.0, "inertia": 157.0, "rail_spacing": 1.1, "lateral_offset": offset, "lever_arm": lever_arm},
        occupants=[
            {"kind": "adult", "mass": 80.0, "restraint": belt, "coupled": coupled},
            {
                "kind": "child",
                "mass": 18.0,
                "vehicle": 2,
                "coupled": coupled,
                "restraint": belt | {"stiffness": 49e3},
                "seat": {"mass": 5.0, "restraint": belt | {"stiffness": 50e3}},
            },
        ],
    )


CASES = [
    crash("threshold", coupled=False, plastic=False, offset=0.8, lever_arm="printed"),
    crash("threshold", coupled=True, plastic=True, offset=0.8, lever_arm="work-conjugate"),
    crash("kelvin-voigt", coupled=True, plastic=True, offset=0.0, lever_arm="work-conjugate"),
    crash("linear", coupled=True, plastic=False, offset=0.4, lever_arm="work-conjugate"),
]
IDS = ["threshold, elastic, printed", "threshold, plastic, coupled", "full overlap, plastic", "linear"]


@pytest.mark.parametrize("scenario", CASES, ids=IDS)
def test_a_method_without_events_agrees(scenario: CrashScenario) -> None:
    run = independent.simulate(scenario)
    times, coarse = independent.coarse(scenario, step=8e-5)
    # Without events the error is of first order in the step, worst for the light bar that a member with f0 > 0 hits:
    # at most 2e-3 here, and 1e-4 with steps of 5e-6 s. A lost event or a wrong mode shows as 1e-2 and more.
    for channel, values in coarse.items():
        exact = run.at(channel, times)
        if np.abs(exact).max() < 1e-9:  # m, m/s, N: a bar that only rounding turns
            continue
        if channel.endswith("force"):  # a jump is a step late at most, so its area counts, not its height
            error = np.abs(exact - values).sum() / np.abs(values).sum()
        else:
            error = np.abs(exact - values).max() / np.abs(values).max()
        assert error < 3e-3, channel


@pytest.mark.parametrize("scenario", CASES[1:3], ids=IDS[1:3])
def test_momentum_is_kept(scenario: CrashScenario) -> None:
    run = independent.simulate(scenario)
    momentum = np.zeros(50)
    times = np.linspace(0.0, 0.12, 50)
    for body in run.system.bodies:
        if body.name != "bar.rotation":
            forward = -1.0 if body.name == "vehicle2" or body.vehicle == "vehicle2" else 1.0
            momentum += forward * body.inertia * run.at(f"{body.name}.velocity", times)
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-12, atol=1e-12 * 1500.0 * 13.33)


def test_elastic_parts_give_all_energy_back() -> None:
    # work-conjugate arms, no occupants: kinetic and spring energy add up at every moment
    scenario = CASES[3].model_copy(update={"occupants": ()})
    run = independent.simulate(scenario)
    times = np.linspace(0.0, 0.12, 41)
    energy = np.zeros(41)
    for body in run.system.bodies:
        rate = "bar.rotation_rate" if body.name == "bar.rotation" else f"{body.name}.velocity"
        energy += 0.5 * body.inertia * run.at(rate, times) ** 2
    for element in run.system.elements:
        law = element.law
        assert isinstance(law, Curve)
        for d, force, slope, end in zip(law.knots, law.forces, law.slopes, [*law.knots[1:], np.inf], strict=True):
            depth = np.clip(run.at(f"{element.name}.deflection", times), d, end) - d
            energy += force * depth + 0.5 * slope * depth**2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-12)
