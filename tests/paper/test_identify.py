"""The paper's vehicles are found again, by a search whose seed counts; those of the catalogue meet the numbers."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from ridedown.errors import InvalidInput
from ridedown.paper import cases
from ridedown.paper.candidates import UNKNOWNS, crash, scenario_of, values_of, with_vehicle
from ridedown.paper.identify import MOST_CRUSH, NEAR, identify
from ridedown.paper.numbers import PRINTED, headlines
from ridedown.paper.reproduce import reproduce
from ridedown.scenario import load, parameters, substitute
from ridedown.simulation import simulate
from ridedown.studies.search import Effort, runs

LITTLE = Effort(restarts=1, sample=64, population=16, generations=6, patience=6)
SOME = Effort(restarts=3, sample=256, population=64, generations=150, patience=40)

A_PAIR = np.array([8e3, 0.33, 420e3, 0.45, 600e3, 1500.0, 40e3, 0.9])  # values of the unknowns, in their order


@pytest.fixture(scope="module")
def found():
    return identify(seed=0)


@pytest.fixture(scope="module")
def catalogue():
    return reproduce()


def test_the_catalogues_vehicles_meet_all_ten_numbers_within_the_rounding_of_the_print(catalogue):
    assert max(abs(h.error) for h in catalogue.headlines) <= NEAR
    assert [(h.case, h.quantity, h.ours) for h in catalogue.headlines if not h.rounds_to_print] == []


def test_every_trend_holds_for_the_catalogues_vehicles(catalogue):
    assert [t.trend for t in catalogue.trends if not t.holds] == []


def test_the_catalogues_members_are_not_deflected_farther_than_a_car_has_room(catalogue):
    crush = max(v.dynamic_crush.value for r in catalogue.responses.values() for v in r.vehicles.values())
    assert crush <= 1.01 * MOST_CRUSH


def test_the_papers_ten_numbers_are_met_and_every_trend_holds(found):
    assert found.complete
    assert found.within == len(PRINTED)
    assert found.worst <= NEAR
    assert found.trends_hold


def test_what_is_found_is_what_the_catalogue_holds_rounded(found):
    there = {p.path: p.value for p in parameters(scenario_of(cases.ADULT_OFFSET))}
    for unknown in UNKNOWNS:
        for path in unknown.paths:
            # an initial force of some kN is the least certain of them
            assert found.values[unknown.name] == pytest.approx(there[path], rel=0.03, abs=300.0 if unknown.unit == "N" else 0.0)


def test_the_file_that_comes_back_says_reconstruction_and_gives_the_numbers_found(found):
    assert "reconstruction" in found.toml
    again = simulate(load(tomllib.loads(found.toml)))
    assert again.maximum("adult.relative_displacement").value == pytest.approx(found.table[2].ours, rel=1e-12)
    assert again.maximum("child.relative_displacement").value == pytest.approx(found.table[8].ours, rel=1e-12)


def test_numbers_made_from_a_pair_of_cars_are_met_again():
    target = crash(A_PAIR[None]).numbers[0]
    found = identify(target.tolist(), seed=1, effort=SOME)
    assert found.within == len(PRINTED)
    assert found.worst < 0.02


def test_the_same_seed_finds_the_same_vehicles_on_any_number_of_threads():
    assert identify(seed=0, effort=LITTLE, threads=1).values == identify(seed=0, effort=LITTLE, threads=2).values


def test_nought_is_a_seed_like_another():
    assert identify(seed=0, effort=LITTLE).values == identify(seed=np.random.default_rng(0), effort=LITTLE).values
    assert identify(seed=0, effort=LITTLE).values != identify(seed=1, effort=LITTLE).values


def test_a_table_of_candidates_gives_what_the_papers_cases_give_one_by_one():
    responses = {case.scenario: simulate(with_vehicle(scenario_of(case), A_PAIR)) for case in cases.ALL}
    one_by_one = [h.ours for h in headlines(responses)]
    np.testing.assert_allclose(crash(A_PAIR[None]).numbers[0], one_by_one, rtol=1e-10)


def test_masses_inertia_and_forces_times_a_factor_give_the_same_numbers():
    crash_of_paper = scenario_of(cases.ADULT_OFFSET)
    heavy = ("vehicle1.mass", "vehicle2.mass", "bar.mass", "bar.inertia", "initial_force", "stiffness")
    scaled = {
        p.path: 1.7 * p.value for p in parameters(crash_of_paper) if p.path.endswith(heavy) and not p.path.startswith("adult")
    }
    assert len(scaled) == 10
    for channel in ("adult.relative_displacement", "adult.acceleration"):
        ours, same = (simulate(s).peak(channel).value for s in (crash_of_paper, substitute(crash_of_paper, scaled)))
        assert same == pytest.approx(ours, rel=1e-9)


def test_the_unit_cube_spans_the_bounds():
    np.testing.assert_allclose(values_of(np.zeros(len(UNKNOWNS))), [u.lower for u in UNKNOWNS])
    np.testing.assert_allclose(values_of(np.ones(len(UNKNOWNS))), [u.upper for u in UNKNOWNS])


@pytest.mark.parametrize("dimensions", [2, 5])
def test_the_search_finds_the_bottom_of_a_curved_valley(dimensions):
    def rosenbrock(points):
        x = 4.0 * points - 2.0
        return (100.0 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1.0 - x[:, :-1]) ** 2).sum(axis=1)

    effort = Effort(restarts=4, sample=128, population=32, generations=600, patience=60)
    best = min(runs(rosenbrock, dimensions, effort, np.random.default_rng(3)), key=lambda run: run.value)
    np.testing.assert_allclose(4.0 * best.best - 2.0, 1.0, atol=1e-3)


def test_the_search_finds_a_corner_of_the_box_and_passes_by_what_cannot_be():
    def objective(points):
        return np.where(points[:, 0] > 0.7, np.inf, points.sum(axis=1))

    found = next(runs(objective, 3, Effort(sample=32, population=24), np.random.default_rng(0)))
    np.testing.assert_allclose(found.best, 0.0, atol=1e-6)


@pytest.mark.parametrize("target", [[0.27] * 9, [0.0] * 10, [float("nan")] * len(PRINTED)])
def test_a_target_that_is_no_target_is_refused(target):
    with pytest.raises(InvalidInput, match="target"):
        identify(target)
