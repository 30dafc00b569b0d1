"""Every scenario lowers to the network that its equations say."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ridedown.network import Law, Network
from ridedown.scenario import load, lower

Change = Callable[..., dict[str, Any]]


def _terms(network: Network, element: str) -> tuple[dict[str, float], dict[str, float], float, str | None]:
    """Deflection terms in relative coordinates, reactions, arm and lever of an element, by name."""
    e = network.elements.index(element)
    names = network.coordinates
    terms = slice(network.term_start[e], network.term_start[e + 1])
    moved = slice(network.reaction_start[e], network.reaction_start[e + 1])
    return (
        {names[i]: float(s) for i, s in zip(network.term_coordinate[terms], network.term_sign[terms], strict=True)},
        {names[i]: float(s) for i, s in zip(network.reaction_coordinate[moved], network.reaction_sign[moved], strict=True)},
        float(network.arm[e, 0]),
        None if network.lever[e] < 0 else names[network.lever[e]],
    )


def test_p1_is_the_benchmark_problem() -> None:
    network = lower(load("p1"))
    assert network.coordinates == ("vehicle1", "vehicle2", "bar", "bar.rotation", "adult", "child.seat", "child")
    assert network.elements == (
        "vehicle1.right",
        "vehicle1.left",
        "vehicle2.right",
        "vehicle2.left",
        "adult.restraint",
        "child.restraint",
        "child.seat.restraint",
    )
    assert not network.conjugate
    assert network.size == 1
    np.testing.assert_array_equal(network.inertia[:, 0], [1500, 1500, 40, 157, 80, 5, 18])
    # rates are relative to the parent: occupants start with their vehicle
    np.testing.assert_array_equal(network.rate[:, 0], [13.33, 13.33, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(network.parent, [-1, -1, -1, -1, 0, 0, 5])
    np.testing.assert_array_equal(network.stiffness[4:, 0], [98.1e3, 49e3, 50e3])
    np.testing.assert_array_equal(network.damping[4:, 0], [2801, 939, 500])
    np.testing.assert_array_equal(network.slack[4:, 0], [0.005] * 3)
    np.testing.assert_array_equal(network.law, [Law.ELASTIC] * 4 + [Law.KELVIN_VOIGT] * 3)
    np.testing.assert_array_equal(network.knot[:, 0], [0, 0.356] * 4)
    np.testing.assert_array_equal(network.slope[:, 0], [118.2e3, 465e3] * 4)
    np.testing.assert_allclose(network.force[:, 0], [0, 118.2e3 * 0.356] * 4, rtol=1e-15)
    assert network.duration[0] == 0.2


def test_p1_deflections_have_the_signs_of_eqs_7_and_8() -> None:
    network = lower(load("p1"))
    long, short = pytest.approx(0.55 + 0.443, rel=1e-15), pytest.approx(0.55 - 0.443, rel=1e-12)
    one, two = {"vehicle1": 1.0, "bar": -1.0}, {"vehicle2": 1.0, "bar": 1.0}
    for element, terms, arm in (
        ("vehicle1.right", one, -1 * 0.993),
        ("vehicle1.left", one, 0.107),
        ("vehicle2.right", two, -1 * 0.993),
        ("vehicle2.left", two, 0.107),
    ):
        got_terms, reactions, got_arm, lever = _terms(network, element)
        assert (got_terms, reactions, lever) == (terms, terms, "bar.rotation")
        assert got_arm == pytest.approx(arm, rel=1e-12)
        assert abs(got_arm) in (long, short)


def test_uncoupled_occupants_do_not_push_back_but_a_child_pushes_its_seat(crash: Change) -> None:
    network = lower(load(crash()))
    assert _terms(network, "adult.restraint")[:2] == ({"adult": 1.0}, {"adult": 1.0})
    assert _terms(network, "child.restraint")[:2] == ({"child": 1.0}, {"child": 1.0, "child.seat": -1.0})
    assert _terms(network, "child.seat.restraint")[:2] == ({"child.seat": 1.0}, {"child.seat": 1.0})
    assert _terms(network, "adult2.restraint")[:2] == ({"adult2": 1.0}, {"adult2": 1.0, "vehicle2": -1.0})
    assert network.parent[network.coordinate("adult2")] == network.coordinate("vehicle2")


def test_a_coupled_child_pushes_the_vehicle_by_way_of_the_seat(crash: Change) -> None:
    network = lower(load(crash("occupants.1.coupled", value=True)))
    assert _terms(network, "child.restraint")[1] == {"child": 1.0, "child.seat": -1.0}
    assert _terms(network, "child.seat.restraint")[1] == {"child.seat": 1.0, "vehicle1": -1.0}


def test_a_wall_test_has_no_bar() -> None:
    network = lower(load("neon-wall"))
    assert network.coordinates == ("vehicle1",)
    assert _terms(network, "vehicle1.left") == ({"vehicle1": 1.0}, {"vehicle1": 1.0}, 0.0, None)
    np.testing.assert_array_equal(network.law, [Law.PLASTIC] * 2)


def test_a_bar_without_inertia_cannot_turn(crash: Change) -> None:
    data = crash("bar", {"mass": 40, "rail_spacing": 1.1})
    network = lower(load(data))
    assert "bar.rotation" not in network.coordinates
    assert _terms(network, "vehicle1.right")[3] is None


def test_the_bar_starts_with_the_mean_speed_of_two_equal_bumpers(crash: Change) -> None:
    network = lower(load(crash()))
    assert network.rate[network.coordinate("bar"), 0] == pytest.approx((48 / 3.6 - 10) / 2, rel=1e-15)
    network = lower(load(crash("bar.speed", "-1 m/s")))
    assert network.rate[network.coordinate("bar"), 0] == -1.0


def test_lever_arm_law(crash: Change) -> None:
    assert lower(load(crash())).conjugate
    assert not lower(load(crash("bar.lever_arm", "printed"))).conjugate


@pytest.mark.parametrize(
    ("name", "law"), [("linear", Law.LINEAR), ("kelvin-voigt", Law.KELVIN_VOIGT), ("threshold", Law.THRESHOLD)]
)
def test_restraint_laws(crash: Change, name: str, law: Law) -> None:
    network = lower(load(crash("occupants.0.restraint.law", name)))
    e = network.elements.index("adult.restraint")
    assert network.law[e] == law
    assert network.slack[e, 0] == 0.005


def test_networks(network: Change) -> None:
    lowered = lower(load(network()))
    assert lowered.coordinates == ("m1", "m2")
    assert lowered.elements == ("front", "m1-m2", "wall-m1")
    assert _terms(lowered, "front")[:2] == ({"m1": 1.0}, {"m1": 1.0})
    assert _terms(lowered, "m1-m2")[:2] == ({"m1": -1.0, "m2": 1.0}, {"m1": -1.0, "m2": 1.0})
    np.testing.assert_array_equal(lowered.law, [Law.LINEAR, Law.THRESHOLD, Law.ELASTIC])
    np.testing.assert_array_equal(lowered.rate[:, 0], [14, 14])
    np.testing.assert_array_equal(lowered.slope[:, 0], [1e5, 0])


def test_importing_scenarios_loads_nothing_slow() -> None:
    code = (
        "import sys, ridedown.scenario\n"
        "slow = {'numba', 'scipy', 'matplotlib', 'ruamel.yaml', 'pyarrow'} & set(sys.modules)\n"
        "sys.exit(', '.join(slow) or None)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
