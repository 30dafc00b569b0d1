"""Substituting a value is the same as loading a file with that value in it, for one crash or for many."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np
import pytest

from ridedown import catalogue
from ridedown.errors import InvalidInput, UnknownName
from ridedown.network import Network
from ridedown.network.model import NUMBERS
from ridedown.scenario import CrashScenario, broken_rules, load, lower, parameters, substitute

Change = Callable[..., dict[str, Any]]


def _assert_same(one: Network, other: Network, row: int = 0) -> None:
    """That a network of one crash equals a row of another."""
    for field in fields(Network):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if field.name in NUMBERS:
            a, b = a[..., 0], b[..., row]
        np.testing.assert_array_equal(a, b, err_msg=field.name)


@pytest.mark.parametrize(
    ("path", "in_file", "values"),
    [
        ("vehicle1.mass", "vehicle1.mass", [1000.0, 2000.0]),
        ("vehicle1.speed", "vehicle1.speed", [0.0, 20.0]),
        ("vehicle1.members.pieces.0.stiffness", "vehicle1.members.pieces.0.stiffness", [0.0, 2e5]),
        ("vehicle1.members.pieces.0.until", "vehicle1.members.pieces.0.until", [0.1, 0.4]),
        ("vehicle1.members.initial_force", "vehicle1.members.initial_force", [0.0, 2e4]),
        ("vehicle2.members.points.1.0", "vehicle2.members.points.1.0", [0.1, 0.4]),
        ("vehicle2.members.points.1.1", "vehicle2.members.points.1.1", [0.0, 2e5]),
        ("bar.mass", "bar.mass", [10.0, 50.0]),
        ("bar.inertia", "bar.inertia", [10.0, 50.0]),
        ("bar.lateral_offset", "bar.lateral_offset", [0.0, -0.4]),
        ("bar.speed", "bar.speed", [0.0, -0.4]),
        ("adult.mass", "occupants.0.mass", [50.0, 90.0]),
        ("adult.restraint.stiffness", "occupants.0.restraint.stiffness", [5e4, 9e4]),
        ("adult.restraint.damping_ratio", "occupants.0.restraint.damping_ratio", [0.1, 1.5]),
        ("adult.restraint.slack", "occupants.0.restraint.slack", [0.0, 0.1]),
        ("child.seat.mass", "occupants.1.seat.mass", [3.0, 9.0]),
        ("child.seat.restraint.damping", "occupants.1.seat.restraint.damping", [0.0, 9.0]),
        ("duration", "duration", [0.1, 0.3]),
    ],
)
def test_columns_lower_as_files_with_those_values(crash: Change, path: str, in_file: str, values: list[float]) -> None:
    many = lower(substitute(load(crash()), {path: values}))
    assert many.size == len(values)
    for row, value in enumerate(values):
        one = lower(load(crash(in_file, value)))
        _assert_same(one, many, row)
        _assert_same(lower(substitute(load(crash()), {path: value})), one)


@pytest.mark.parametrize("name", catalogue.names())
def test_every_parameter_can_be_set_to_what_it_is(name: str) -> None:
    scenario = load(name)
    listed = parameters(scenario)
    assert len({parameter.path for parameter in listed}) == len(listed)
    again = substitute(scenario, {parameter.path: parameter.value for parameter in listed})
    assert again == scenario
    columns = substitute(scenario, {parameter.path: np.full(3, parameter.value) for parameter in listed})
    _assert_same(lower(scenario), lower(columns), row=2)


def test_parameters_have_values_and_units(crash: Change) -> None:
    found = {parameter.path: parameter for parameter in parameters(load(crash()))}
    assert found["vehicle1.members.pieces.0.stiffness"][1:] == (100e3, "N/m")
    assert found["child.seat.restraint.damping"][1:] == (500.0, "N s/m")
    assert found["adult2.restraint.damping_ratio"][1:] == (0.5, "")
    assert not any(path.startswith(("vehicle1.right", "occupants")) for path in found)


def test_members_set_both_sides_and_right_or_left_one(crash: Change) -> None:
    scenario = load(crash())
    assert isinstance(scenario, CrashScenario)
    both = substitute(scenario, {"vehicle1.members.pieces.0.stiffness": 3.0})
    right = substitute(scenario, {"vehicle1.right.pieces.0.stiffness": 3.0})
    assert both.vehicle1.alike
    assert not right.vehicle1.alike
    assert [p.path for p in parameters(right) if p.value == 3.0] == ["vehicle1.right.pieces.0.stiffness"]
    again = substitute(right, {"vehicle1.members.pieces.0.stiffness": 4.0})
    assert [p.path for p in parameters(again) if p.value == 4.0] == [
        "vehicle1.right.pieces.0.stiffness",
        "vehicle1.left.pieces.0.stiffness",
    ]


def test_stiffness_takes_the_damping_with_it_only_where_that_is_a_ratio(crash: Change) -> None:
    scenario = load(crash())
    softer = {"adult.restraint.stiffness": 98.1e3 / 4, "child.seat.restraint.stiffness": 1e4}
    before, after = lower(scenario), lower(substitute(scenario, softer))
    ratio = after.damping[:, 0] / np.where(before.damping[:, 0] > 0, before.damping[:, 0], 1.0)
    names = before.elements
    assert ratio[names.index("adult.restraint")] == pytest.approx(0.5, rel=1e-15)
    assert ratio[names.index("child.seat.restraint")] == 1.0


def test_the_other_way_of_giving_a_number_is_replaced(crash: Change) -> None:
    scenario = load(crash())
    damped = substitute(scenario, {"adult.restraint.damping": 100.0})
    assert lower(damped).damping[lower(damped).elements.index("adult.restraint"), 0] == 100.0
    shifted = substitute(scenario, {"bar.width": 1.8, "bar.overlap": [0.6, 1.0]})
    np.testing.assert_allclose(lower(shifted).arm[0], [-0.91, -0.55], rtol=1e-12)


def test_a_single_value_may_have_a_unit(crash: Change) -> None:
    scenario = substitute(load(crash()), {"vehicle1.speed": "36 km/h", "adult.mass": np.array(75.0)})
    assert isinstance(scenario, CrashScenario)
    assert (scenario.vehicle1.speed, scenario.occupants[0].mass) == (10.0, 75.0)


def test_the_scenario_itself_stays_as_it_was(crash: Change) -> None:
    scenario = load(crash())
    column = np.array([1.0, 2.0])
    substitute(scenario, {"vehicle1.mass": column})
    assert scenario == load(crash())


def test_the_caller_may_change_the_column_afterwards(crash: Change) -> None:
    column = np.array([1.0, 2.0])
    many = substitute(load(crash()), {"vehicle1.mass": column})
    column[:] = -1.0
    assert lower(many).inertia[0].tolist() == [1.0, 2.0]


def test_networks(network: Change) -> None:
    many = lower(substitute(load(network()), {"m1.mass": [700.0, 900.0], "front.stiffness": 5.0, "wall-m1.points.1.1": [1, 2]}))
    np.testing.assert_array_equal(many.inertia[0], [700, 900])
    np.testing.assert_array_equal(many.stiffness[0], [5, 5])
    np.testing.assert_array_equal(many.slope[0], [2, 4])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"vehicle1.mass": [1.0, 0.0, -1.0]}, "vehicle1.mass: got 0 kg in row 1; need > 0 kg."),
        ({"vehicle1.mass": [1.0, np.nan]}, "vehicle1.mass: got nan in row 1; need a finite number"),
        ({"vehicle1.mass": -3}, "vehicle1.mass: got -3 kg; need > 0 kg."),
        ({"vehicle1.mass": np.inf}, "vehicle1.mass: got inf; need"),
        ({"vehicle1.mass": "3 m"}, 'vehicle1.mass: got "3 m", a length; need a mass'),
        ({"vehicle1.mass": True}, "vehicle1.mass: got true; need a mass"),
        ({"vehicle1.mass": [True, False]}, "vehicle1.mass: got an array of shape (2,) and type bool"),
        ({"vehicle1.mass": [[1.0]]}, "vehicle1.mass: got an array of shape (1, 1)"),
        ({"vehicle1.mass": ["a"]}, "vehicle1.mass: got an array of shape (1,) and type <U1"),
        ({"vehicle1.mass": [1.0, 2.0], "bar.mass": [1.0]}, "bar.mass: got 1 rows; need 2, as in vehicle1.mass."),
        (
            {"vehicle2.members.points.0.0": [0.0, 0.1]},
            "vehicle2.members.points.0.0: got 0.1 m in row 1; need the first point at deflection 0 m.",
        ),
        ({"bar.overlap": [1.0, 0.5]}, "bar.width: got nothing in row 1; need the vehicle width"),
        ({"child.restraint.slack": [-0.1]}, "child.restraint.slack: got -0.1 m in row 0; need >= 0 m."),
        ({"vehicle1.right.unloading_stiffness": 1e9}, "vehicle1.right.unloading_stiffness: got a value with elastic"),
    ],
)
def test_values_pass_the_same_rules_row_by_row(crash: Change, values: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInput) as error:
        substitute(load(crash()), values)
    assert str(error.value).startswith(message)


def test_rules_between_fields_hold_in_every_row(crash: Change) -> None:
    data = crash("vehicle1.members.unloading", "plastic")
    data["vehicle1"]["members"]["unloading_stiffness"] = 4e5
    scenario = load(data)
    fine = {"vehicle1.members.pieces.1.stiffness": [4e5, 6e5], "vehicle1.members.unloading_stiffness": [4e5, 7e5]}
    assert lower(substitute(scenario, fine)).size == 2
    with pytest.raises(InvalidInput, match=r"^vehicle1\.members\.unloading_stiffness: got 400000 N/m in row 1"):
        substitute(scenario, {**fine, "vehicle1.members.unloading_stiffness": 4e5})
    level = load(crash("bar", {"mass": 40, "rail_spacing": 1.1}))
    with pytest.raises(InvalidInput, match=r"^bar\.inertia: got nothing with unequal arms in row 1; need"):
        substitute(level, {"bar.lateral_offset": [0.0, 0.1]})
    three = crash("vehicle1.members.pieces.1.until", 0.5)
    three["vehicle1"]["members"]["pieces"].append({"stiffness": 1})
    with pytest.raises(InvalidInput, match=r"^vehicle1\.members\.pieces\.1\.until: got 0\.5 m in row 1; need more than"):
        substitute(load(three), {"vehicle1.members.pieces.0.until": [0.1, 0.5]})


@pytest.mark.parametrize(
    ("path", "nearest"),
    [
        ("vehicle1.mas", "vehicle1.mass"),
        ("adult.restraint.stifness", "adult.restraint.stiffness"),
        ("vehicle1.members.pieces.7.stiffness", "vehicle1.members.pieces.0.stiffness"),
    ],
)
def test_an_unknown_path_offers_the_nearest(crash: Change, path: str, nearest: str) -> None:
    with pytest.raises(UnknownName, match=f"Did you mean .*'{nearest}'"):
        substitute(load(crash()), {path: 1.0})


def test_no_rows_are_no_crashes(crash: Change) -> None:
    assert lower(substitute(load(crash()), {"vehicle1.mass": np.empty(0)})).size == 0


@pytest.mark.parametrize(
    ("source", "path"),
    [
        ("p1", "vehicle1.mass"),
        ("sled-trapezoid", "pulse.fall"),
        ({"pulse": {"kind": "tipped-equivalent-square-wave", "speed": 15, "crush": 0.62, "time": 0.09}}, "pulse.crush"),
    ],
)
def test_no_rows_break_no_rule(source: str | dict[str, Any], path: str) -> None:
    assert [p.value for p in parameters(substitute(load(source), {path: np.empty(0)})) if np.size(p.value) == 0] != []
    assert broken_rules(load(source), {path: np.empty(0)}) == {}


def test_rules_between_fields_are_not_asked_of_rows_that_are_out_of_bounds() -> None:
    table = {"pulse.fall": np.array([0.9, 0.1, 0.1]), "adult.mass": np.array([80.0, 80.0, 0.0])}
    broken = broken_rules(load("sled-trapezoid"), table)
    assert [mask.tolist() for need, mask in broken.items() if need.startswith("adult.mass")] == [[False, False, True]]
    assert all(not mask[2] for need, mask in broken.items() if need.startswith("pulse"))
    alone = broken_rules(load("sled-trapezoid"), {"pulse.fall": np.array([0.1]), "adult.mass": np.array([0.0])})
    assert [mask.tolist() for mask in alone.values()] == [[True]]
