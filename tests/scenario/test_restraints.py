"""Belts, airbags, surfaces and occupants of several masses: what is filled in, refused, and lowered."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import numpy as np
import pytest

from ridedown.errors import InvalidInput
from ridedown.network import Action, Law, Network
from ridedown.scenario import Contact, CrashScenario, dump, load, lower, parameters, substitute, total_forces
from tests.scenario.conftest import LEAVE_OUT, changed

INF = np.inf


def _data() -> dict[str, Any]:
    belt = {
        "kind": "belt",
        "slack": "20 mm",
        "pieces": [{"stiffness": "50 kN/m", "until": "60 mm"}, {"stiffness": "90 kN/m"}],
        "lock_time": "5 ms",
        "pretensioners": [
            {"fire_time": "10 ms", "pull_in": "80 mm", "duration": "10 ms", "stall_force": "1.5 kN"},
            {"fire_time": "16 ms", "pull_in": "30 mm", "duration": "6 ms", "stall_force": "2 kN"},
        ],
        "load_limiter": {"force": "4 kN", "second_force": "2.5 kN", "switch_payout": "100 mm", "max_payout": "300 mm"},
    }
    bag = {"kind": "airbag", "fire_time": "12 ms", "fill_time": "25 ms", "gap": "100 mm", "stiffness": "20 kN/m", "venting": 90}
    knees = {"kind": "knee_bolster", "gap": "80 mm", "points": [[0, 0], ["50 mm", "5 kN"]], "damping_ratio": "10 %"}
    back = {
        "kind": "seat_back",
        "name": "seat_back2",
        "stiffness": "40 kN/m",
        "unloading": "plastic",
        "unloading_stiffness": "90 kN/m",
    }
    driver = {"name": "driver", "kind": "adult", "mass": 75, "restraints": [belt, bag, knees, back]}
    seat = {"mass": 5, "restraints": [{"kind": "belt", "name": "isofix", "stiffness": 1e5, "damping": 300}]}
    child = {"kind": "child", "mass": 18, "seat": seat, "restraints": [{"kind": "belt", "name": "harness", "stiffness": 5e4}]}
    members = {"pieces": [{"stiffness": "300 kN/m"}]}
    return {"vehicle1": {"mass": 1400, "speed": "50 km/h", "members": members}, "occupants": [driver, child]}


def _several() -> dict[str, Any]:
    data = _data()
    data["occupants"][0] = {
        "name": "driver",
        "kind": "adult",
        "bodies": [{"name": "pelvis", "mass": 40}, {"name": "chest", "mass": 30}, {"name": "head", "mass": 5}],
        "joints": [
            {"name": "spine", "between": ["pelvis", "chest"], "stiffness": 2e4, "damping": 100},
            {"between": ["chest", "head"], "stiffness": 3e3},
        ],
        "restraints": [
            {"kind": "belt", "on": "chest", "stiffness": 6e4, "damping_ratio": 0.1},
            {"kind": "belt", "on": "pelvis", "stiffness": 8e4},
            {"kind": "seat_back", "on": "head", "stiffness": 1e4},
        ],
    }
    return data


def _row(network: Network, element: str) -> dict[str, Any]:
    """What the network says of one element."""
    e = network.elements.index(element)
    names, terms = network.coordinates, slice(network.term_start[e], network.term_start[e + 1])
    moved = slice(network.reaction_start[e], network.reaction_start[e + 1])
    return {
        "terms": {names[i]: s for i, s in zip(network.term_coordinate[terms], network.term_sign[terms], strict=True)},
        "moved": {names[i]: s for i, s in zip(network.reaction_coordinate[moved], network.reaction_sign[moved], strict=True)},
        "law": network.law[e],
        "slack": network.slack[e, 0],
        "damping": network.damping[e, 0],
        "unloading": network.stiffness[e, 0],
        "limits": tuple(network.limit[:, e, 0]),
        "payouts": tuple(network.payout[:, e, 0]),
        "stalls": tuple(network.stall[:, e, 0]),
        "free": bool(network.free[e]),
        "empty": bool(network.empty[e]),
        "timers": [
            (Action(network.timer_action[t]), network.timer_time[t, 0], network.timer_value[t, 0])
            for t in np.flatnonzero(network.timer_element == e)
        ],
    }


def test_a_belt_lowers_to_a_curve_on_a_reel() -> None:
    belt = _row(lower(load(_data())), "driver.belt")
    assert belt["law"] == Law.RESTRAINT
    assert belt["terms"] == belt["moved"] == {"driver": 1.0}
    assert (belt["slack"], belt["free"], belt["empty"]) == (0.02, True, False)
    assert belt["limits"] == (4000.0, 2500.0)
    assert belt["payouts"] == (0.1, 0.3)
    assert belt["stalls"] == (1500.0, 2000.0)
    assert belt["timers"] == [
        (Action.LOCK, 0.005, 0.0),
        (Action.PULL_1, 0.010, pytest.approx(8.0)),
        (Action.PULL_1, pytest.approx(0.020), 0.0),
        (Action.PULL_2, 0.016, pytest.approx(5.0)),
        (Action.PULL_2, pytest.approx(0.022), 0.0),
    ]


@pytest.mark.parametrize(
    ("limiter", "limits", "payouts", "timers"),
    [
        (LEAVE_OUT, (INF, INF), (INF, INF), []),
        ({"force": 4e3}, (4e3, INF), (INF, INF), []),
        ({"force": 4e3, "max_payout": 0.2}, (4e3, INF), (0.2, INF), []),
        ({"force": 4e3, "second_force": 5e3, "switch_payout": 0.1}, (4e3, 5e3), (0.1, INF), []),
        ({"force": 4e3, "second_force": 3e3, "switch_time": 0.05}, (4e3, 3e3), (INF, INF), [0.05]),
        ({"force": 4e3, "second_force": 3e3, "switch_time": 0.05, "max_payout": 0.2}, (4e3, 3e3), (0.2, 0.2), [0.05]),
    ],
)
def test_stages_of_a_load_limiter(limiter: object, limits: object, payouts: object, timers: list[float]) -> None:
    belt = _row(lower(load(changed(_data(), "occupants.0.restraints.0.load_limiter", limiter))), "driver.belt")
    assert (belt["limits"], belt["payouts"]) == (limits, payouts)
    assert [time for action, time, _ in belt["timers"] if action is Action.STAGE_2] == timers


def test_a_plain_belt_has_nothing_on_its_reel() -> None:
    belt = _row(lower(load(_data())), "child.harness")
    assert (belt["free"], belt["timers"], belt["limits"], belt["stalls"]) == (False, [], (INF, INF), (INF, INF))


def test_an_airbag_is_empty_and_fills() -> None:
    bag = _row(lower(load(_data())), "driver.airbag")
    assert (bag["slack"], bag["damping"], bag["empty"], bag["free"]) == (0.1, 90.0, True, False)
    assert bag["timers"] == [(Action.FILL, 0.012, pytest.approx(40.0)), (Action.FILL, pytest.approx(0.037), 0.0)]


def test_surfaces_are_met_forwards_and_the_seat_back_rearwards() -> None:
    network = lower(load(_data()))
    knees, back = _row(network, "driver.knee_bolster"), _row(network, "driver.seat_back2")
    assert knees["terms"] == {"driver": 1.0}
    assert back["terms"] == {"driver": -1.0}
    assert (knees["slack"], back["slack"], back["unloading"]) == (0.08, 0.0, 90e3)
    assert knees["damping"] == pytest.approx(2 * 0.1 * (1e5 * 75) ** 0.5)  # of its first piece and the mass it acts on


def test_a_child_is_held_to_its_seat_and_the_seat_to_the_vehicle() -> None:
    network = lower(load(_data()))
    assert _row(network, "child.harness")["moved"] == {"child": 1.0, "child.seat": -1.0}
    assert _row(network, "child.seat.isofix")["moved"] == {"child.seat": 1.0}
    coupled = lower(load(changed(_data(), "occupants.1.coupled", value=True)))
    assert _row(coupled, "child.seat.isofix")["moved"] == {"child.seat": 1.0, "vehicle1": -1.0}


def test_several_masses_hang_on_the_vehicle_and_are_joined() -> None:
    network = lower(load(_several()))
    bodies = ("driver.pelvis", "driver.chest", "driver.head")
    assert network.coordinates[1:4] == bodies
    assert [network.inertia[network.coordinate(body), 0] for body in bodies] == [40, 30, 5]
    assert all(network.parent[network.coordinate(body)] == 0 for body in bodies)
    assert _row(network, "driver.belt")["terms"] == {"driver.chest": 1.0}
    assert _row(network, "driver.belt")["damping"] == pytest.approx(2 * 0.1 * (6e4 * 30) ** 0.5)
    assert _row(network, "driver.belt2")["terms"] == {"driver.pelvis": 1.0}
    assert _row(network, "driver.seat_back")["terms"] == {"driver.head": -1.0}
    spine = _row(network, "driver.spine")
    assert (spine["law"], spine["slack"]) == (Law.LINEAR, 0.0)
    assert spine["terms"] == spine["moved"] == {"driver.pelvis": -1.0, "driver.chest": 1.0}
    assert "driver.chest-head" in network.elements


def test_the_mass_of_several_bodies_is_their_sum() -> None:
    scenario = load(_several())
    assert isinstance(scenario, CrashScenario)
    assert scenario.occupants[0].mass is None
    assert scenario.occupants[0].whole_mass == 75.0


def test_the_force_of_all_restraints_counts_the_seat_back_the_other_way() -> None:
    scenario = load(_data())
    assert isinstance(scenario, CrashScenario)
    network = lower(scenario)
    terms = total_forces(scenario.occupants, network)["driver.restraint.force"].terms
    assert {network.elements[e]: weight for _, e, weight in terms} == {
        "driver.belt": 1.0,
        "driver.airbag": 1.0,
        "driver.knee_bolster": 1.0,
        "driver.seat_back2": -1.0,
    }


REFUSED: list[tuple[str, object, str, str]] = [
    # path in the first occupant, value, field in the message, words in the message
    ("restraints.0.kind", "blet", "restraints.0.kind", 'got "blet"; need one of "belt", "airbag"'),
    ("restraints.0.kind", LEAVE_OUT, "restraints.0.kind", "got nothing"),
    ("restraints.0.slakc", 1, "restraints.0.slakc", 'Did you mean "slack"?'),
    ("restraints.0.pretensioners.0.pullin", 1, "restraints.0.pretensioners.0.pullin", 'Did you mean "pull_in"?'),
    ("restraints.0.gap", 1, "restraints.0.gap", "an unknown key"),
    ("restraints.0.stiffness", 1e5, "restraints.0.pieces", "both stiffness and pieces"),
    ("restraints.0.pieces", LEAVE_OUT, "restraints.0.stiffness", "a stiffness, pieces or points"),
    ("restraints.0.initial_force", 5, "restraints.0.initial_force", "an unknown key"),
    ("restraints.2.points", [[0, 10], [0.1, 500]], "restraints.2.points.0.1", "rest on a jump"),
    ("restraints.2.points", [[0, 0]], "restraints.2.damping_ratio", "begins flat"),
    ("restraints.0.damping_ratio", 50, "restraints.0.damping_ratio", '"50 %" or 0.5'),
    ("restraints.0.load_limiter.force", "1.8 kN", "restraints.0.load_limiter.force", "more than pretensioners.1.stall_force"),
    ("restraints.0.load_limiter.force", "2 kN", "restraints.0.load_limiter.force", "got 2000 N; need more than"),
    ("restraints.0.load_limiter.second_force", 1e3, "restraints.0.load_limiter.second_force", "pretensioners.0.stall_force"),
    ("restraints.0.load_limiter.second_force", LEAVE_OUT, "restraints.0.load_limiter.switch_payout", "a switch without"),
    ("restraints.0.load_limiter.switch_payout", LEAVE_OUT, "restraints.0.load_limiter.second_force", "nothing switches to"),
    ("restraints.0.load_limiter.switch_time", 0.05, "restraints.0.load_limiter.switch_time", "both switch_payout and"),
    ("restraints.0.load_limiter.max_payout", "90 mm", "restraints.0.load_limiter.max_payout", "more than switch_payout"),
    ("restraints.0.load_limiter.max_payout", "100 mm", "restraints.0.load_limiter.max_payout", "more than switch_payout"),
    ("restraints.0.load_limiter.force", 0, "restraints.0.load_limiter.force", "need > 0 N"),
    ("restraints.0.pretensioners.0.stall_force", LEAVE_OUT, "restraints.0.pretensioners.0.stall_force", "with a load limiter"),
    ("restraints.0.pretensioners.0.fire_time", "4 ms", "restraints.0.pretensioners.0.fire_time", "lock_time or later"),
    ("restraints.0.pretensioners.0.fire_time", "-1 ms", "restraints.0.pretensioners.0.fire_time", "need >= 0 s"),
    ("restraints.0.pretensioners.0.duration", 0, "restraints.0.pretensioners.0.duration", "need > 0 s"),
    (
        "restraints.0.pretensioners",
        [{"fire_time": 0.01, "pull_in": 0.1, "duration": 0.01}] * 3,
        "restraints.0.pretensioners",
        "at most two",
    ),
    ("restraints.0.pieces.1.stiffness", 0, "restraints.0.pieces.1.stiffness", "a force that rises"),
    ("restraints.1.fill_time", "0 ms", "restraints.1.fill_time", "ends after it begins"),
    ("restraints.1.fill_time", "-5 ms", "restraints.1.fill_time", "need > 0 s"),
    ("restraints.1.fire_time", "-5 ms", "restraints.1.fire_time", "need >= 0 s"),
    ("restraints.1.fill_time", LEAVE_OUT, "restraints.1.fill_time", "need a time"),
    ("restraints.2.gap", "-5 mm", "restraints.2.gap", "need >= 0 m"),
    ("restraints.0.on", "chest", "restraints.0.on", "there is a single mass"),
    ("restraints.1.name", "seat_back2", "restraints.3.name", "a second time"),
    ("restraints.1.name", "mass", "restraints.1.name", "the name of a field"),
    ("restraints", [], "restraint", "a list of restraints"),
    ("restraint", {"stiffness": 1e5}, "restraints", "both restraint and restraints"),
    ("joints", [{"between": ["a", "b"], "stiffness": 1}], "joints", "without bodies"),
    ("mass", LEAVE_OUT, "mass", "need a mass"),
]

REFUSED_OF_SEVERAL: list[tuple[str, object, str, str]] = [
    ("mass", 75, "mass", "both bodies and mass"),
    ("bodies", [{"name": "pelvis", "mass": 40}], "bodies", "two or three bodies"),
    ("bodies.1.name", "pelvis", "bodies.1.name", "a second time"),
    ("bodies.0.name", "spine", "joints.0.name", "a second time"),
    ("restraints.0.on", LEAVE_OUT, "restraints.0.on", "got nothing; need one of pelvis, chest, head"),
    ("restraints.0.on", "ches", "restraints.0.on", 'got "ches"'),
    ("joints.0.between", ["pelvis", "arm"], "joints.0.between.1", 'got "arm"'),
    ("joints.0.between", ["chest", "chest"], "joints.0.between", "two different bodies"),
    ("joints.0.stiffness", "1 kN", "joints.0.stiffness", "need a stiffness"),
]


def _refusal(data: dict[str, Any], path: str, value: object) -> str:
    with pytest.raises(InvalidInput) as error:
        load(changed(data, f"occupants.0.{path}", value))
    return str(error.value)


@pytest.mark.parametrize(("path", "value", "field", "words"), REFUSED)
def test_what_cannot_be_is_refused(path: str, value: object, field: str, words: str) -> None:
    message = _refusal(_data(), path, value)
    assert message.startswith(f"occupants.0.{field}: got ")
    assert re.search(r"; need .*[.?]$", message)
    assert words in message


@pytest.mark.parametrize(("path", "value", "field", "words"), REFUSED_OF_SEVERAL)
def test_what_cannot_be_of_several_masses_is_refused(path: str, value: object, field: str, words: str) -> None:
    message = _refusal(_several(), path, value)
    assert message.startswith(f"occupants.0.{field}: got ")
    assert words in message


def test_a_body_that_nothing_holds_is_refused() -> None:
    data = _several()
    del data["occupants"][0]["joints"]
    del data["occupants"][0]["restraints"][2]
    with pytest.raises(InvalidInput, match=r'^occupants\.0\.bodies\.2: got "head", held by nothing; need a joint'):
        load(data)


def test_several_masses_have_no_lumped_restraint() -> None:
    data = _several()
    data["occupants"][0]["restraint"] = {"stiffness": 1e5}
    del data["occupants"][0]["restraints"]
    with pytest.raises(InvalidInput, match=r"^occupants\.0\.restraint: got one restraint for several bodies"):
        load(data)


def test_points_may_end_flat_beyond_the_limiters_force_only() -> None:
    data = changed(_data(), "occupants.0.restraints.0.pieces", LEAVE_OUT)
    belt = data["occupants"][0]["restraints"][0]
    load(changed(data, "occupants.0.restraints.0.points", [[0, 0], [0.1, 4001.0]]))
    belt["points"] = [[0, 0], [0.1, 4000.0]]
    with pytest.raises(InvalidInput, match=r"^occupants\.0\.restraints\.0\.points\.1\.1: got webbing"):
        load(data)
    del belt["load_limiter"], belt["pretensioners"]
    load(data)  # a belt with neither may do as it likes


@pytest.mark.parametrize("data", [_data(), _several()])
def test_dumps_load_back_equal(data: dict[str, Any]) -> None:
    scenario = load(data)
    assert load(tomllib.loads(dump(scenario))) == scenario


def test_every_number_has_a_path_by_the_names_of_restraints_and_bodies() -> None:
    found = {parameter.path: parameter.value for parameter in parameters(load(_data()))}
    assert found["driver.belt.load_limiter.force"] == 4000.0
    assert found["driver.belt.pretensioners.1.fire_time"] == 0.016
    assert found["driver.airbag.gap"] == 0.1
    assert found["driver.knee_bolster.points.1.1"] == 5000.0
    assert found["child.seat.isofix.damping"] == 300.0
    several = {parameter.path: parameter.value for parameter in parameters(load(_several()))}
    assert several["driver.chest.mass"] == 30.0
    assert several["driver.spine.stiffness"] == 2e4
    assert several["driver.belt2.stiffness"] == 8e4
    assert not any("restraints" in path or "bodies" in path for path in (*found, *several))


PATHS = {
    "driver.belt.load_limiter.force": ("restraints.0.load_limiter.force", [3000.0, 5000.0]),
    "driver.belt.load_limiter.switch_payout": ("restraints.0.load_limiter.switch_payout", [0.05, 0.2]),
    "driver.belt.pretensioners.0.fire_time": ("restraints.0.pretensioners.0.fire_time", [0.006, 0.02]),
    "driver.belt.pretensioners.1.pull_in": ("restraints.0.pretensioners.1.pull_in", [0.01, 0.1]),
    "driver.belt.pieces.0.stiffness": ("restraints.0.pieces.0.stiffness", [1e4, 8e4]),
    "driver.belt.lock_time": ("restraints.0.lock_time", [0.0, 0.009]),
    "driver.airbag.fill_time": ("restraints.1.fill_time", [0.01, 0.04]),
    "driver.airbag.venting": ("restraints.1.venting", [0.0, 500.0]),
    "driver.knee_bolster.damping_ratio": ("restraints.2.damping_ratio", [0.0, 0.5]),
    "driver.knee_bolster.points.1.1": ("restraints.2.points.1.1", [3e3, 9e3]),
    "driver.mass": ("mass", [50.0, 100.0]),
}


@pytest.mark.parametrize("path", PATHS)
def test_columns_lower_as_files_with_those_values(path: str) -> None:
    in_file, values = PATHS[path]
    many = lower(substitute(load(_data()), {path: values}))
    for row, value in enumerate(values):
        one = lower(load(changed(_data(), f"occupants.0.{in_file}", value)))
        for name in ("slack", "damping", "slope", "force", "limit", "payout", "stall", "timer_time", "timer_value", "inertia"):
            np.testing.assert_allclose(getattr(one, name)[..., 0], getattr(many, name)[..., row], rtol=1e-15, err_msg=name)


def test_columns_are_refused_by_the_first_row_that_cannot_be() -> None:
    with pytest.raises(InvalidInput, match=r"^driver\.belt\.load_limiter\.force: got 1900 N in row 2; need more than"):
        substitute(load(_data()), {"driver.belt.load_limiter.force": [4e3, 3e3, 1900.0]})
    with pytest.raises(InvalidInput, match=r"^driver\.belt\.pretensioners\.0\.fire_time: got 0\.004 s in row 1"):
        substitute(load(_data()), {"driver.belt.pretensioners.0.fire_time": [0.01, 0.004]})
    with pytest.raises(InvalidInput, match=r"^driver\.belt\.pieces\.0\.stiffness: got webbing.* in row 0"):
        substitute(load(_data()), {"driver.belt.pieces.0.stiffness": [0.0, 1e4]})


def test_contacts_have_a_direction() -> None:
    assert Contact(kind="seat_back", stiffness=1).direction == -1.0
    assert Contact(kind="wheel", stiffness=1).direction == 1.0
