"""The catalogue: every entry loads, lowers, and says where its numbers come from."""

from __future__ import annotations

import re

import numpy as np
import pytest

from ridedown import catalogue
from ridedown.errors import UnknownName
from ridedown.scenario import CrashScenario, NetworkScenario, load, lower


def _crash(name: str) -> CrashScenario:
    scenario = load(name)
    assert isinstance(scenario, CrashScenario)
    return scenario


def test_the_names() -> None:
    assert set(catalogue.names()) >= {
        "paper-adult-full",
        "paper-adult-offset",
        "paper-child-full",
        "paper-child-offset",
        "paper-adult-full-damping-10",
        "paper-adult-full-damping-20",
        "paper-adult-full-damping-50",
        "paper-adult-full-stiffness-19.62",
        "paper-adult-full-stiffness-39.24",
        "paper-adult-full-stiffness-98.1",
        "marzbanrad-2",
        "marzbanrad-5",
        "navigator-neon",
        "neon-wall",
        "expedition-wall",
        "p1",
        "example-offset",
        "example-restraints",
    }


@pytest.mark.parametrize("name", catalogue.names())
def test_every_entry_loads_and_lowers_and_names_its_sources(name: str) -> None:
    entry = catalogue.entry(name)
    scenario = load(name)
    assert scenario.name == entry.name == name
    assert scenario.description == entry.description
    assert scenario.sources
    assert entry.confidence in catalogue.CONFIDENCE
    assert max(catalogue.CONFIDENCE.index(s.confidence) for s in scenario.sources) == catalogue.CONFIDENCE.index(
        entry.confidence
    )
    network = lower(scenario)
    assert network.size == 1
    assert all(np.isfinite(column).all() for column in (network.inertia, network.slope, network.damping, network.rate))


def test_an_unknown_name_offers_the_nearest() -> None:
    with pytest.raises(UnknownName, match="Did you mean 'navigator-neon'"):
        catalogue.entry("navigator-neons")


@pytest.mark.parametrize("name", [name for name in catalogue.names() if name.startswith(("paper-", "p1"))])
def test_the_papers_vehicle_is_called_a_reconstruction_wherever_it_shows(name: str) -> None:
    entry = catalogue.entry(name)
    assert entry.confidence == "reconstructed"
    assert "reconstruction" in entry.description.lower()
    assert any("reconstruction" in source["note"] for source in entry.sources)


def test_the_papers_scenarios_share_their_vehicles() -> None:
    scenarios = [_crash(name) for name in catalogue.names() if name.startswith("paper-")]
    assert all((s.vehicle1, s.vehicle2) == (scenarios[0].vehicle1, scenarios[0].vehicle2) for s in scenarios)
    assert all(s.bar is not None and s.bar.lever_arm == "printed" for s in scenarios)
    for scenario in scenarios:
        assert scenario.bar is not None
        assert scenario.vehicle1.speed == 13.33
        assert (scenario.bar.lateral_offset != 0.0) == scenario.name.endswith("offset")


def test_the_papers_series_change_one_number() -> None:
    base = _crash("paper-adult-full").occupants[0].restraint
    for percent in (10, 20, 50):
        restraint = _crash(f"paper-adult-full-damping-{percent}").occupants[0].restraint
        assert restraint == base.model_copy(update={"damping_ratio": percent / 100})
    for stiffness in ("19.62", "39.24", "98.1"):
        restraint = _crash(f"paper-adult-full-stiffness-{stiffness}").occupants[0].restraint
        assert restraint == base.model_copy(update={"stiffness": float(stiffness) * 1000})


def test_marzbanrads_five_masses() -> None:
    scenario = load("marzbanrad-5")
    assert isinstance(scenario, NetworkScenario)
    assert [body.mass for body in scenario.masses] == [300, 120, 150, 700, 80]
    assert all(body.speed == 14.0 for body in scenario.masses)
    assert len(scenario.elements) == 9
    assert lower(scenario).damping.max() == 8648277.61


@pytest.mark.parametrize(
    ("name", "rebound", "crush", "tolerance"),
    [("neon-wall", 0.17, 0.736, 0.01), ("expedition-wall", 0.13, 0.672, 0.03)],
)
def test_unloading_gives_the_rebound_of_the_wall_test(name: str, rebound: float, crush: float, tolerance: float) -> None:
    """By energy alone: the curve takes up m v^2/2 at the crush C, and its line gives back F(C)^2/(2 ku) a member."""
    scenario = _crash(name)
    network = lower(scenario)
    knot, force, slope = network.knot[:7, 0], network.force[:7, 0], network.slope[:7, 0]
    deflection = np.linspace(0.0, 1.0, 200_001)
    piece = np.searchsorted(knot, deflection, side="right") - 1
    total = 2 * (force[piece] + slope[piece] * (deflection - knot[piece]))
    work = np.concatenate([[0.0], np.cumsum((total[1:] + total[:-1]) / 2 * np.diff(deflection))])
    energy = scenario.vehicle1.mass * scenario.vehicle1.speed**2 / 2
    at = int(np.searchsorted(work, energy))
    given_back = 2 * (total[at] / 2) ** 2 / (2 * network.stiffness[0, 0])
    # the stiffness is printed to seven digits
    assert np.sqrt(given_back / energy) == pytest.approx(rebound, rel=1e-6)
    # the tables were fitted to these very tests; the residual is the fit's, not ours
    assert deflection[at] == pytest.approx(crush, rel=tolerance)


def test_the_pair_is_the_wall_tests_members_in_heavier_cars() -> None:
    pair, neon, expedition = _crash("navigator-neon"), _crash("neon-wall"), _crash("expedition-wall")
    assert pair.vehicle2 is not None
    assert pair.vehicle1.right == expedition.vehicle1.right
    assert pair.vehicle2.right == neon.vehicle1.right
    # totals of the whole front: each member carries half
    assert neon.vehicle1.right.points is not None
    assert neon.vehicle1.right.points[1] == (0.1171, 134.75e3 / 2)


def test_entries_are_told_apart_by_name_only() -> None:
    assert len(set(catalogue.names())) == len(catalogue.names())
    assert all(re.fullmatch(r"[a-z0-9.-]+", name) for name in catalogue.names())
