"""Occupants solved apart from vehicles that move the same in every row, against all solved together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ridedown import load, simulate_many
from ridedown.network import Channel, Family
from ridedown.outcomes import Outcomes, wanted
from ridedown.scenario import lower, substitute
from ridedown.solver import solve
from ridedown.solver.apart import apart
from ridedown.status import Status

ROWS = 64


def is_apart(scenario: Any, table: dict[str, Any], outcomes: list[str] | None = None) -> bool:
    network = lower(substitute(scenario, table)).widened(ROWS)
    return apart(network, wanted(network, outcomes).tracked) is not None


def both_ways(
    monkeypatch: pytest.MonkeyPatch, scenario: Any, table: dict[str, Any], **options: Any
) -> tuple[Outcomes, Outcomes]:
    one = simulate_many(scenario, table, **options)
    monkeypatch.setattr(solve, "_WORTH_IT", 10**9)
    return one, simulate_many(scenario, table, **options)


def assert_alike(one: Outcomes, other: Outcomes) -> None:
    np.testing.assert_array_equal(one.status, other.status)
    np.testing.assert_allclose(one.time, other.time, rtol=1e-13)
    for name in other:
        # an elastic member absorbs nothing in the end, to round-off of what it took
        scale = np.abs(other["energy.initial" if name.endswith(".absorbed") else name]).max()
        # when a flat top is reached is known only to the root of its height's error
        tolerance = 1e-4 if name.endswith("_time") else 1e-9 * scale
        np.testing.assert_allclose(one[name], other[name], rtol=0.0, atol=tolerance, err_msg=name)
    for name, values in other.samples.items():
        np.testing.assert_allclose(one.samples[name], values, rtol=0.0, atol=1e-9 * np.nanmax(np.abs(values)), err_msg=name)


def spread(low: float, high: float) -> np.ndarray:
    return np.linspace(low, high, ROWS)


@pytest.mark.parametrize(
    ("name", "table"),
    [
        ("p1", {"adult.restraint.stiffness": spread(20e3, 120e3), "child.seat.restraint.slack": spread(0.0, 0.03)}),
        ("example-offset", {"child.restraint.damping_ratio": spread(0.1, 0.9)}),
        ("paper-adult-offset", {"adult.mass": spread(50.0, 110.0)}),
    ],
)
def test_the_same_as_all_together(monkeypatch: pytest.MonkeyPatch, name: str, table: dict[str, Any]) -> None:
    scenario = load(name)
    assert is_apart(scenario, table)
    person = scenario.occupants[0].name
    sampled = [f"{person}.velocity", "vehicle1.acceleration", f"{person}.excursion"]
    usual = list(simulate_many(scenario, {}))
    one, other = both_ways(
        monkeypatch, scenario, table, outcomes=usual, samples=sampled, times=np.linspace(0.0, float(scenario.duration), 41)
    )
    assert_alike(one, other)


def test_what_moves_the_same_in_every_row_has_one_number() -> None:
    """Of a vehicle's last speed, a study of occupants would otherwise rank what round-off is due to."""
    scenario, outcomes = load("p1"), ["vehicle1.velocity.final", "vehicle1.displacement.final", "child.velocity.final"]
    many = simulate_many(scenario, {"adult.restraint.stiffness": spread(20e3, 120e3)}, outcomes=outcomes)
    for name in outcomes:
        assert np.ptp(many[name]) == 0.0, name


def test_drivers_of_both_cars(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = load("p1")
    second = plain.occupants[0].model_copy(update={"name": "other", "vehicle": 2})
    scenario = plain.model_copy(update={"occupants": (*plain.occupants, second)})
    table = {"other.restraint.stiffness": spread(30e3, 90e3), "adult.restraint.slack": spread(0.0, 0.05)}
    assert is_apart(scenario, table)
    assert_alike(*both_ways(monkeypatch, scenario, table))


def test_belts_on_reels_and_several_masses(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load("example-restraints")
    table = {"driver.shoulder-belt.load_limiter.force": spread(2.5e3, 6e3)}
    if is_apart(scenario, table):
        assert_alike(*both_ways(monkeypatch, scenario, table))
    free = scenario.model_copy(
        update={"occupants": tuple(one.model_copy(update={"coupled": False}) for one in scenario.occupants)}
    )
    assert is_apart(free, table)
    assert_alike(*both_ways(monkeypatch, free, table))


def alike(scenario: Any, table: dict[str, Any]) -> list[str]:
    """The coordinates that are solved once."""
    network = lower(substitute(scenario, table)).widened(ROWS)
    parts = apart(network, wanted(network, None).tracked)
    return [] if parts is None else [network.coordinates[i] for i in parts.alike.coordinates]


def test_an_occupant_who_is_the_same_in_every_row_is_solved_once(monkeypatch: pytest.MonkeyPatch) -> None:
    scenario = load("p1")
    for name, other in (("adult", "child"), ("child", "adult")):
        table = {f"{name}.restraint.stiffness": spread(20e3, 120e3)}
        assert other in alike(scenario, table)
        assert name not in alike(scenario, table)
        sampled = [f"{name}.velocity", f"{other}.velocity"]
        options = {"outcomes": list(simulate_many(scenario, {})), "samples": sampled, "times": np.linspace(0.0, 0.2, 41)}
        with monkeypatch.context() as patch:
            assert_alike(*both_ways(patch, scenario, table, **options))
    nobody = {"adult.restraint.stiffness": np.full(ROWS, 9e4)}
    assert {"adult", "child", "child.seat"} <= set(alike(scenario, nobody))
    assert_alike(*both_ways(monkeypatch, scenario, nobody))


def test_a_quantity_of_two_occupants_of_whom_one_differs() -> None:
    network = lower(substitute(load("p1"), {"adult.restraint.stiffness": spread(20e3, 120e3)})).widened(ROWS)
    adult, child = network.coordinates.index("adult"), network.coordinates.index("child")
    between = Channel("between", "m", ((Family.POSITION, adult, 1.0), (Family.POSITION, child, -1.0)))
    parts = apart(network, solve.tracked([(between, 0)]))
    assert parts is not None
    assert {adult, child} <= set(parts.occupants[0].coordinates.tolist())


def test_a_timer_that_differs_is_a_difference(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = load("p1")
    driver = load("example-restraints").occupants[0].model_copy(update={"coupled": False})
    scenario = plain.model_copy(update={"occupants": (driver, plain.occupants[1])})
    table = {"driver.shoulder-belt.lock_time": spread(0.0, 0.012)}
    assert "child" in alike(scenario, table)
    assert "driver.chest" not in alike(scenario, table)
    assert_alike(*both_ways(monkeypatch, scenario, table))


def test_not_where_the_vehicles_differ_from_row_to_row() -> None:
    scenario = load("p1")
    assert not is_apart(scenario, {"vehicle1.mass": spread(1400.0, 1600.0)})
    assert is_apart(scenario, {"vehicle1.mass": np.full(ROWS, 1400.0), "adult.restraint.slack": spread(0.0, 0.1)})
    assert not is_apart(scenario, {"duration": spread(0.1, 0.2)})


def test_not_where_an_occupant_pushes_back() -> None:
    plain = load("p1")
    heavy = plain.model_copy(update={"occupants": tuple(o.model_copy(update={"coupled": True}) for o in plain.occupants)})
    assert not is_apart(heavy, {"adult.restraint.slack": spread(0.0, 0.1)})
    one = plain.model_copy(update={"occupants": (plain.occupants[0].model_copy(update={"coupled": True}), plain.occupants[1])})
    assert not is_apart(one, {"adult.restraint.slack": spread(0.0, 0.1)})  # the vehicles differ, by way of the adult
    assert is_apart(one, {"child.restraint.slack": spread(0.0, 0.1)})


def test_not_in_a_sled() -> None:
    assert not is_apart(load("sled-fmvss-208"), {"adult.restraint.slack": spread(0.0, 0.1)})


def test_rows_that_stop_early_are_as_far_as_they_came(monkeypatch: pytest.MonkeyPatch) -> None:
    table = {"adult.restraint.stiffness": np.where(np.arange(ROWS) == 5, 1e290, 98e3)}
    one, other = both_ways(monkeypatch, load("p1"), table)
    assert one.status[5] != Status.COMPLETED.value
    np.testing.assert_array_equal(one.status, other.status)
    for name in other:
        np.testing.assert_array_equal(one[name][5], other[name][5])
