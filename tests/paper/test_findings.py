"""The findings about the founding paper that docs/theory.md lists."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ridedown import catalogue, load, simulate
from ridedown.paper.numbers import PRINTED
from ridedown.scenario import lower, substitute

G = 9.81


def test_the_printed_damping_is_not_half_of_critical():
    critical = 2.0 * math.sqrt(98.1e3 * 80.0)
    assert critical == pytest.approx(5603.0, abs=1.0)
    assert 2540.0 / critical == pytest.approx(0.453, abs=5e-4)
    network = lower(load("paper-adult-full"))
    assert network.damping[network.elements.index("adult.restraint"), 0] == pytest.approx(critical / 2.0)


@pytest.mark.parametrize(
    ("law", "stiffness", "ratio", "printed", "bound"),
    [
        ("kelvin-voigt", 98.1e3, 0.1, 50.0, 41.9),
        ("kelvin-voigt", 19.62e3, 0.5, 30.0, 21.3),
        ("threshold", 98.1e3, 0.1, 50.0, 47.6),
        ("threshold", 19.62e3, 0.5, 30.0, 21.3),
    ],
)
def test_without_rebound_the_printed_peaks_are_out_of_reach(law, stiffness, ratio, printed, bound):
    """The hardest stop without rebound is at once, against something rigid: the occupant then meets its restraint at v0."""
    restraint = {"stiffness": stiffness, "slack": 0.005, "damping_ratio": ratio, "law": law}
    members = {"pieces": [{"stiffness": 1e9}], "unloading": "plastic", "unloading_stiffness": 1e17}
    wall = {
        "vehicle1": {"mass": 1500.0, "speed": 13.33, "members": members},
        "occupants": [{"kind": "adult", "mass": 80.0, "restraint": restraint}],
    }
    peak = abs(simulate(load(wall)).peak("adult.acceleration").value) / G
    assert peak <= 1.002 * bound
    assert bound < 0.97 * printed
    if law == "kelvin-voigt":
        assert peak == pytest.approx(bound, rel=0.01)


def test_the_printed_damper_fits_better_than_kelvin_voigt():
    def worst(law):
        errors = []
        for name, channel, printed in (
            ("paper-adult-full", "adult.acceleration", 40.0),
            ("paper-child-full", "child.acceleration", 47.0),
            ("paper-child-offset", "child.acceleration", 36.0),
        ):
            scenario = load(name)
            occupants = tuple(
                o.model_copy(update={"restraint": o.restraint.model_copy(update={"law": law})}) for o in scenario.occupants
            )
            occupants = tuple(
                o
                if o.seat is None
                else o.model_copy(
                    update={"seat": o.seat.model_copy(update={"restraint": o.seat.restraint.model_copy(update={"law": law})})}
                )
                for o in occupants
            )
            response = simulate(scenario.model_copy(update={"occupants": occupants}))
            errors.append(abs(abs(response.peak(channel).value) / G / printed - 1.0))
        return max(errors)

    assert worst("threshold") <= 0.03
    assert worst("kelvin-voigt") > 0.05


@pytest.mark.parametrize("name", ["paper-adult-offset", "paper-child-full"])
def test_only_ratios_of_force_to_mass_matter(name):
    scenario = load(name)
    double = {"bar.mass": 2.0 * scenario.bar.mass, "bar.inertia": 2.0 * scenario.bar.inertia}
    for vehicle in ("vehicle1", "vehicle2"):
        given = getattr(scenario, vehicle)
        double[f"{vehicle}.mass"] = 2.0 * given.mass
        for side in ("right", "left"):
            member = getattr(given, side)
            double[f"{vehicle}.{side}.initial_force"] = 2.0 * member.initial_force
            for i, piece in enumerate(member.pieces):
                double[f"{vehicle}.{side}.pieces.{i}.stiffness"] = 2.0 * piece.stiffness
    one, other = simulate(scenario), simulate(substitute(scenario, double))
    body = scenario.occupants[0].name
    times = np.linspace(0.0, 0.2, 201)
    np.testing.assert_allclose(
        other.at(f"{body}.acceleration", times), one.at(f"{body}.acceleration", times), rtol=0, atol=1e-5 * 40 * G
    )


def test_the_seat_is_damped_by_its_own_mass():
    network = lower(load("paper-child-full"))
    seat = network.elements.index("child.seat.restraint")
    assert network.damping[seat, 0] == pytest.approx(0.5 * 2.0 * math.sqrt(50e3 * 5.0))  # 500 N s/m
    response = simulate(load("paper-child-full"))
    to_seat = response.maximum("child.relative_displacement").value
    assert to_seat == pytest.approx(0.18, rel=0.03)
    assert response.maximum("child.excursion").value > 1.5 * to_seat


def test_every_scenario_of_the_paper_says_reconstruction():
    names = [name for name in catalogue.names() if name.startswith("paper-")]
    assert len(names) >= 10
    for name in names:
        assert "reconstruction" in load(name).description
        assert catalogue.entry(name).confidence == "reconstructed"


def test_the_ten_numbers_are_there():
    assert len(PRINTED) == 10
