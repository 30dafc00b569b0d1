"""The force laws: at every instant the force is what the law's definition says of deflection and rate so far."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ridedown import Response, simulate
from ridedown.network import Law, Network
from ridedown.scenario import NetworkScenario
from ridedown.solver import laws
from tests import samples
from tests.samples import examples

Floats = NDArray[np.float64]


def curve(network: Network, e: int, deflection: Floats) -> Floats:
    """Force on the loading curve of element e."""
    pieces = slice(int(network.piece_start[e]), int(network.piece_start[e + 1]))
    knots, forces, slopes = (x[pieces, 0] for x in (network.knot, network.force, network.slope))
    piece = np.clip(np.searchsorted(knots, deflection, side="right") - 1, 0, len(knots) - 1)
    force: Floats = forces[piece] + slopes[piece] * (deflection - knots[piece])
    return force


def plastic(network: Network, e: int, deflection: Floats) -> Floats:
    """Down from the largest deflection so far on a line, to nothing at the permanent set."""
    largest = np.maximum(np.maximum.accumulate(deflection), 0.0)
    line = network.stiffness[e, 0]
    top = curve(network, e, largest)
    touching = deflection > np.maximum(largest - top / line, 0.0)
    force: Floats = np.where(touching, top + line * (deflection - largest), 0.0)
    return force


def latched(response: Response, e: int, times: Floats) -> Floats:
    """The rate at which the slack was last taken up, v* of eq 16."""
    phases = response.phases
    closed = (phases.event_element == e) & (phases.event_before == laws.OPEN)
    at, rate = (
        phases.event_time[closed],
        response.at(f"{response.network.elements[e]}.deflection_rate", phases.event_time[closed]),
    )
    before = np.searchsorted(at, times, side="right") - 1
    return np.where(before >= 0, rate[np.maximum(before, 0)] if rate.size else 0.0, np.inf)


def defined(response: Response, e: int, times: Floats) -> Floats:
    """The force of element e by its law's definition."""
    network, name = response.network, response.network.elements[e]
    d, v = response.at(f"{name}.deflection", times), response.at(f"{name}.deflection_rate", times)
    law = network.law[e]
    k, c, stretch = network.stiffness[e, 0], network.damping[e, 0], d - network.slack[e, 0]
    if law == Law.LINEAR:
        return np.asarray(k * stretch + c * v)
    if law == Law.KELVIN_VOIGT:
        return np.where(stretch > 0.0, np.maximum(0.0, k * stretch + c * v), 0.0)
    if law == Law.THRESHOLD:  # eqs 13-18
        return np.where(stretch > 0.0, k * stretch + c * np.maximum(0.0, v - latched(response, e, times)), 0.0)
    if law == Law.PLASTIC:
        return plastic(network, e, d)
    return np.where(d > 0.0, curve(network, e, d), 0.0)


def assert_lawful(response: Response) -> None:
    times = np.unique(np.concatenate([np.linspace(0.0, response.end_time, 2001), response.phases.start]))
    for e, name in enumerate(response.network.elements):
        force, expected = response.at(f"{name}.force", times), defined(response, e, times)
        stiffest = max(response.network.stiffness[e, 0], *response.network.slope[:, 0], 0.0)
        size = max(np.abs(expected).max(), 1e4)
        wrong = np.abs(force - expected) > 1e-9 * size + 1e-11 * stiffest
        # on either side of a jump the force is one or the other, as rounding has it
        jumps = response.phases.event_time[response.phases.event_element == e]
        wrong &= ~np.any(np.abs(times[:, np.newaxis] - jumps) < 1e-9, axis=1)
        assert not wrong.any(), (name, times[wrong][:3], force[wrong][:3], expected[wrong][:3])


@examples(30)
@given(seed=st.integers(0, 10**6))
def test_every_law_in_any_crash(seed: int) -> None:
    assert_lawful(simulate(samples.crash(seed), throw=False))


@examples(30)
@given(seed=st.integers(0, 10**6))
def test_every_law_in_any_network(seed: int) -> None:
    assert_lawful(simulate(samples.network(seed), throw=False))


def one_mass(front: dict[str, Any], speed: float = 10.0, duration: float = 0.8) -> Response:
    """1000 kg onto an element at the wall."""
    elements = [{"name": "front", "between": ["wall", "m"], **front}]
    masses = [{"name": "m", "mass": 1000.0, "speed": speed}]
    return simulate(NetworkScenario(duration=duration, masses=masses, elements=elements))


def story(response: Response, who: str = "front") -> list[str]:
    return [event.what for event in response.events if event.who == who]


def test_an_elastic_curve_goes_up_and_back() -> None:
    front = {"pieces": [{"stiffness": 100e3, "until": 0.2}, {"stiffness": 300e3}]}
    response = one_mass(front)
    assert story(response) == ["contact", "on to piece 2", "back to piece 1", "contact lost"]
    work = 0.5 * 100e3 * 0.2**2
    rest = 0.5 * 1000.0 * 10.0**2 - work  # 1/2 k2 e^2 + F e
    beyond = (np.sqrt(20e3**2 + 2.0 * 300e3 * rest) - 20e3) / 300e3
    assert response.maximum("front.deflection").value == pytest.approx(0.2 + beyond, rel=1e-10)
    assert response.at("m.velocity", 0.8) == pytest.approx(-10.0, rel=1e-10)


@pytest.mark.parametrize("f0", [0.0, 5e3])
def test_a_plastic_curve_keeps_its_set(f0: float) -> None:
    front = {"initial_force": f0, "pieces": [{"stiffness": 100e3}], "unloading": "plastic", "unloading_stiffness": 1e6}
    response = one_mass(front)
    assert story(response) == ["contact", "starts to unload", "contact lost"]
    top = (np.sqrt(f0**2 + 100e3 * 1000.0 * 10.0**2) - f0) / 100e3
    force = f0 + 100e3 * top
    assert response.maximum("front.deflection").value == pytest.approx(top, rel=1e-10)
    assert response.phases.set[0] == pytest.approx(top - force / 1e6, rel=1e-10)
    given_back = 0.5 * force**2 / 1e6
    assert response.at("m.velocity", 0.8) == pytest.approx(-np.sqrt(2.0 * given_back / 1000.0), rel=1e-10)


def test_a_plastic_curve_is_met_again_where_it_was_left_and_crushed_on() -> None:
    # m rebounds from the front, is met by a faster m2, and pushed back on the unloading line and beyond
    front = {"pieces": [{"stiffness": 100e3}], "unloading": "plastic", "unloading_stiffness": 1e6}
    response = simulate(
        NetworkScenario(
            duration=0.4,
            masses=[{"name": "m", "mass": 1000.0, "speed": 10.0}, {"name": "m2", "mass": 3000.0, "speed": 10.0}],
            elements=[
                {"name": "front", "between": ["wall", "m"], **front},
                {"name": "tow", "between": ["m", "m2"], "law": "kelvin-voigt", "stiffness": 300e3, "slack": 1.5},
            ],
        )
    )
    whole = ["contact", "starts to unload", "contact lost", "contact again, on its unloading line", "crushes on"]
    assert story(response)[:5] == whole
    times = {what: next(e.time for e in response.events if (e.who, e.what) == ("front", what)) for what in whole}
    left, met, on = (times[what] for what in whole[2:])
    d_left, d_met, d_on = response.at("front.deflection", [left, met, on])
    assert d_met == pytest.approx(d_left, rel=1e-10)
    assert d_on == pytest.approx(float(response.at("front.deflection", times["starts to unload"])), rel=1e-10)
    assert_lawful(response)


def test_a_set_below_zero_is_none() -> None:
    # f0 alone would unload past where the member began
    front = {"initial_force": 50e3, "pieces": [{"stiffness": 1e3}], "unloading": "plastic", "unloading_stiffness": 100e3}
    response = one_mass(front, speed=1.0)
    assert response.phases.set[0] < 0.0
    assert response.maximum("front.deflection").value < 0.02
    lost = response.events[-1]
    assert lost.what == "contact lost"
    assert response.at("front.deflection", lost.time) == pytest.approx(0.0, abs=1e-14)
    assert response.energy.residual == pytest.approx(0.0, abs=1e-12)


def test_a_belt_that_its_damper_outweighs_does_not_push() -> None:
    response = one_mass({"law": "kelvin-voigt", "stiffness": 100e3, "damping": 12e3, "slack": 0.05})
    assert story(response) == ["slack taken up", "damping outweighs the spring: no pull", "slack again"]
    assert response.minimum("front.force").value == pytest.approx(0.0, abs=1e-9)  # N, of 120 kN: where the event is found
    closed = response.events[0]
    assert closed.time == pytest.approx(0.005, rel=1e-14)
    assert response.at("front.force", closed.time) == pytest.approx(12e3 * 10.0, rel=1e-10)  # c v at once
    assert response.at("front.force", closed.time - 1e-9) == 0.0


def test_the_paper_s_damper_counts_from_the_speed_at_which_the_slack_was_taken_up() -> None:
    response = one_mass({"law": "threshold", "stiffness": 100e3, "damping": 12e3, "slack": 0.05})
    # the mass only slows down, so that v never exceeds v* and the damper never acts
    assert [what for what in story(response) if what != "damping ends"] == ["slack taken up", "slack again"]
    assert response.at("m.velocity", 0.8) == pytest.approx(-10.0, rel=1e-10)
    assert response.energy.elements["front"].dissipated == pytest.approx(0.0, abs=1e-4)  # of 50 kJ


def test_the_paper_s_damper_latches_anew_each_time() -> None:
    # in a car that swings to and fro, the seat throws the rider into the belt again
    response = simulate(
        NetworkScenario(
            duration=2.0,
            masses=[{"name": "car", "mass": 1e5, "speed": 10.0}, {"name": "rider", "mass": 75.0, "speed": 10.0}],
            elements=[
                {"name": "swing", "between": ["wall", "car"], "stiffness": 4e7},
                {
                    "name": "belt",
                    "between": ["car", "rider"],
                    "law": "threshold",
                    "stiffness": 80e3,
                    "damping": 2e3,
                    "slack": 0.1,
                },
                {"name": "seat", "between": ["rider", "car"], "pieces": [{"stiffness": 80e3}]},
            ],
        )
    )
    taken_up = [e.time for e in response.events if e.what == "slack taken up"]
    assert len(taken_up) >= 2
    speeds = response.at("belt.deflection_rate", taken_up)
    assert np.ptp(speeds) > 0.1
    assert_lawful(response)


def test_a_linear_tie_pushes_as_well_as_pulls() -> None:
    response = one_mass({"law": "linear", "stiffness": 100e3, "damping": 1e3, "slack": 0.05})
    assert response.events == ()
    assert response.at("front.force", 0.0) == pytest.approx(-5e3 + 10e3)
    assert response.minimum("front.force").value < 0.0
