"""One crash or a hundred thousand, on one thread or more, in any order: every crash comes out the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import Outcomes, Response, catalogue, load, simulate, simulate_many, simulation
from ridedown.scenario import parameters, substitute
from tests import samples
from tests.samples import examples

RNG = np.random.default_rng(2024)


def outcome(response: Response, name: str) -> float:
    """An outcome of `simulate_many`, as the response of one crash has it."""
    stem, kind = name.rsplit(".", 1)
    energy = response.energy
    if stem == "energy":
        return energy.initial if kind == "initial" else energy.final
    if kind == "final":
        return float(response.at(stem, response.end_time))
    if kind == "absorbed":
        return energy.elements[stem].absorbed
    if kind in {"residual", "paid_out"}:
        kept = np.maximum(response.phases.set, 0.0) if kind == "residual" else response.phases.payout
        return float(kept[response.network.elements.index(stem)])
    find = {"peak": response.peak, "max": response.maximum, "min": response.minimum}
    extremum = find[kind.removesuffix("_time")](stem)
    if kind.endswith("_time"):
        return extremum.time
    return abs(extremum.value) if kind == "peak" else extremum.value


def assert_same(response: Response, outcomes: Outcomes, row: int = 0) -> None:
    """Values to 1e-12 of their size, work to 1e-9 of the crash's energy (in tables its series is cut to the forces' order).

    The time of a peak is that of one as high, for there may be several.
    """
    assert outcomes.status[row] == response.status.value
    assert outcomes.time[row] == pytest.approx(response.end_time, rel=1e-14)
    for name, column in outcomes.items():
        scale = max(abs(outcome(response, name)), 1e-3)
        if name.endswith(".absorbed"):
            scale = 1e3 * response.energy.initial
        if name.endswith("_time"):
            channel = name.rsplit(".", 1)[0]
            peak = response.peak(channel).value
            near = np.clip(column[row] + np.array([-1e-9, 0.0, 1e-9]), 0.0, response.end_time)  # a jump has two sides
            assert np.abs(np.abs(response.at(channel, near)) - abs(peak)).min() <= 1e-6 * max(abs(peak), 1e-3), name
        else:
            assert column[row] == pytest.approx(outcome(response, name), rel=0.0, abs=1e-12 * scale), name


@pytest.mark.parametrize("name", catalogue.names())
def test_every_catalogue_entry(name: str) -> None:
    scenario = load(name)
    number = parameters(scenario)[0]
    response = simulate(scenario)
    outcomes = simulate_many(scenario, {number.path: [number.value]})
    assert_same(response, outcomes)


@examples(15)
@given(seed=st.integers(0, 10**6))
def test_any_crash(seed: int) -> None:
    scenario = samples.crash(seed)
    response = simulate(scenario, throw=False)
    assert_same(response, simulate_many(scenario, {"vehicle1.mass": scenario.vehicle1.mass}))


@examples(15)
@given(seed=st.integers(0, 10**6))
def test_any_network(seed: int) -> None:
    scenario = samples.network(seed)
    response = simulate(scenario, throw=False)
    assert_same(response, simulate_many(scenario, {"duration": scenario.duration}))


def table(rows: int) -> dict[str, np.ndarray]:
    """P1 with everything that occupants and cars are made of spread by a fifth, and some rows that turn the bar over."""
    spread = {
        number.path: number.value * RNG.uniform(0.8, 1.2, rows) for number in parameters(load("p1")) if number.value > 0.0
    }
    del spread["duration"]
    spread["bar.inertia"][::50] = 20.0
    return spread


def equal(one: Outcomes, other: Outcomes, rows: np.ndarray) -> None:
    """`one` has the rows of `other`, bit for bit."""
    for name in one:
        np.testing.assert_array_equal(one[name], other[name][rows], err_msg=name)
    np.testing.assert_array_equal(one.status, other.status[rows])
    np.testing.assert_array_equal(one.time, other.time[rows])
    np.testing.assert_array_equal(one.steps, other.steps[rows])


def test_neighbours_do_not_matter() -> None:
    rows = 5000
    columns, order = table(rows), RNG.permutation(rows)
    whole = simulate_many(load("p1"), columns)
    assert 0 < (~whole.completed).sum() < rows / 2
    equal(simulate_many(load("p1"), {path: column[order] for path, column in columns.items()}), whole, order)
    few = RNG.choice(rows, 45, replace=False)
    equal(simulate_many(load("p1"), {path: column[few] for path, column in columns.items()}), whole, few)
    for row in few[:5]:
        equal(
            simulate_many(load("p1"), {path: column[row : row + 1] for path, column in columns.items()}), whole, few[few == row]
        )


def test_threads_do_not_matter() -> None:
    columns = table(5000)
    one, two, all_cores = (simulate_many(load("p1"), columns, threads=threads) for threads in (1, 2, None))
    equal(one, two, np.arange(5000))
    equal(one, all_cores, np.arange(5000))


@pytest.mark.parametrize("paths", [["vehicle1.mass", "adult.restraint.stiffness"], ["adult.restraint.stiffness"]])
def test_nor_does_it_matter_how_many_are_lowered_at_a_time(monkeypatch: pytest.MonkeyPatch, paths: list[str]) -> None:
    whole = table(2500)
    columns = {path: whole[path] for path in paths} | {"vehicle2.speed": np.array(12.0)}
    sampled: dict[str, Any] = {"samples": ["adult.acceleration"], "times": np.linspace(0.0, 0.2, 9)}
    one = simulate_many(load("p1"), columns, **sampled, threads=2)
    monkeypatch.setattr(simulation, "_SPAN", 700)
    equal(simulate_many(load("p1"), columns, **sampled, threads=2), one, np.arange(2500))
    monkeypatch.setattr(simulation, "_SAMPLES", 9 * 901)
    few = simulate_many(load("p1"), columns, **sampled, threads=3)
    equal(few, one, np.arange(2500))
    np.testing.assert_array_equal(few.samples["adult.acceleration"], one.samples["adult.acceleration"])


def test_a_row_that_fails_does_not_touch_the_others() -> None:
    rows = 200
    columns = table(rows)
    well = simulate_many(load("p1"), columns)
    for path, bad in (("bar.mass", 1e-300), ("vehicle1.speed", 1e100), ("bar.inertia", 1e-3)):
        spoilt = {**columns, path: columns[path].copy()}
        spoilt[path][7::40] = bad
        others = np.setdiff1d(np.arange(rows), np.arange(7, rows, 40))
        ill = simulate_many(load("p1"), spoilt)
        for name in well:
            np.testing.assert_array_equal(ill[name][others], well[name][others], err_msg=name)


def test_nor_do_occupants_that_fail_in_vehicles_solved_once() -> None:
    stiffness = np.linspace(20e3, 200e3, 40)
    failing = np.array([7, 20, 39])
    spoilt = stiffness.copy()
    spoilt[failing] = 1e300
    well, ill = (simulate_many(load("p1"), {"adult.restraint.stiffness": column}) for column in (stiffness, spoilt))
    assert np.flatnonzero(~ill.completed).tolist() == failing.tolist()
    others = np.setdiff1d(np.arange(40), failing)
    for name in well:
        np.testing.assert_array_equal(ill[name][others], well[name][others], err_msg=name)
    for row in failing:
        alone = simulate_many(load("p1"), {"adult.restraint.stiffness": spoilt[row]})
        equal(alone, ill, np.array([row]))


def test_rows_are_those_of_single_crashes() -> None:
    columns = table(30)
    outcomes = simulate_many(load("p1"), columns)
    for row in range(0, 30, 6):
        values = {path: float(column[row]) for path, column in columns.items()}
        assert_same(simulate(substitute(load("p1"), values), throw=False), outcomes, row)
