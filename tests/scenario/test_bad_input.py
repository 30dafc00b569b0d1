"""Bad input ends in one clear sentence: `<field path>: got <value>; need <rule>. <what to change>`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import pytest

from ridedown.errors import InvalidInput
from ridedown.scenario import CrashScenario, Member, Vehicle, load

Change = Callable[..., dict[str, Any]]

CRASH: list[tuple[str, object, str, str]] = [
    # path, value, field in the message, words in the message
    ("vehicle1.mass", -1, "vehicle1.mass", "got -1 kg; need > 0 kg"),
    ("vehicle1.mass", 0, "vehicle1.mass", "need > 0 kg"),
    ("vehicle1.mass", math.nan, "vehicle1.mass", "got nan; need a finite number"),
    ("vehicle1.mass", math.inf, "vehicle1.mass", "got inf"),
    ("vehicle1.mass", True, "vehicle1.mass", "got true"),
    ("vehicle1.mass", None, "vehicle1.mass", 'got nothing; need a mass such as "1500 kg"'),
    ("vehicle1.mass", "1500", "vehicle1.mass", "without a unit"),
    ("vehicle1.mass", [1], "vehicle1.mass", "got a list"),
    ("vehicle1.maas", 1, "vehicle1.maas", 'Did you mean "mass"?'),
    ("vehicle1.speed", "-48 km/h", "vehicle1.speed", "both have positive speeds"),
    ("vehicle1", 5, "vehicle1", "got 5; need a table"),
    ("vehcle1", {}, "vehcle1", 'Did you mean "vehicle1"?'),
    ("xyzzy", {}, "xyzzy", "need one of bar, collision"),
    ("vehicle1.members.initial_force", -5, "vehicle1.members.initial_force", "got -5 N; need >= 0 N"),
    (
        "vehicle1.members.pieces.0.stiffness",
        "40 kN",
        "vehicle1.members.pieces.0.stiffness",
        "a force; need a stiffness",
    ),
    ("vehicle1.members.pieces.0.stiffness", -1, "vehicle1.members.pieces.0.stiffness", "need >= 0 N/m"),
    ("vehicle1.members.pieces.0.stifness", 1, "vehicle1.members.pieces.0.stifness", 'Did you mean "stiffness"?'),
    ("vehicle1.members.pieces.0.until", 0, "vehicle1.members.pieces.0.until", "need > 0 m"),
    ("vehicle1.members.pieces.1.until", "1 m", "vehicle1.members.pieces.1.until", "none on the last piece"),
    (
        "vehicle1.members.pieces",
        [{"stiffness": 1, "until": 0.3}, {"stiffness": 1, "until": 0.2}, {"stiffness": 1}],
        "vehicle1.members.pieces.1.until",
        "got 0.2 m; need more than pieces.0.until",
    ),
    (
        "vehicle1.members.pieces",
        [{"stiffness": 1}, {"stiffness": 1}],
        "vehicle1.members.pieces.0.until",
        "the deflection where this piece ends",
    ),
    ("vehicle1.members.pieces", [], "vehicle1.members.pieces", "at least one piece"),
    ("vehicle1.members.pieces", 3, "vehicle1.members.pieces", "need a list"),
    ("vehicle1.members", {}, "vehicle1.members.pieces", "got nothing; need at least one piece"),
    ("vehicle1.members.points", [[0, 0]], "vehicle1.members.points", "both pieces and points"),
    ("vehicle1.right", {"pieces": [{"stiffness": 1}]}, "vehicle1.right", "both members and right"),
    ("vehicle1.members", None, "vehicle1.members", "got nothing; need a table of the longitudinal members"),
    ("vehicle2.members", {"points": []}, "vehicle2.members.points", "an empty list"),
    ("vehicle2.members.points", [[0.1, 0]], "vehicle2.members.points.0.0", "first point at deflection 0 m"),
    ("vehicle2.members.points", [[0, 1], [0.2, 2], [0.2, 3]], "vehicle2.members.points.2.0", "more than points.1.0"),
    ("vehicle2.members.points", [[0, 1, 2]], "vehicle2.members.points.0", "a list of 2"),
    ("vehicle2.members.points", [[0]], "vehicle2.members.points.0.1", "one more entry"),
    ("vehicle2.members.points.1.1", -1, "vehicle2.members.points.1.1", "push, not pull"),
    ("vehicle2.members.points.1.1", "100 m", "vehicle2.members.points.1.1", "a length; need a force"),
    ("vehicle2.members.initial_force", 5, "vehicle2.members.initial_force", "both points and initial_force"),
    ("vehicle1.members.unloading", "plasic", "vehicle1.members.unloading", 'Did you mean "plastic"?'),
    ("vehicle1.members.unloading", "plastic", "vehicle1.members.unloading_stiffness", "got nothing"),
    ("vehicle1.members.unloading_stiffness", 1e9, "vehicle1.members.unloading_stiffness", "with elastic unloading"),
    ("bar.mass", 0, "bar.mass", "need > 0 kg"),
    ("bar.inertia", 0, "bar.inertia", "need > 0 kg m2"),
    ("bar.inertia", None, "bar.inertia", "unequal arms"),
    ("bar.overlap", "60 %", "bar.overlap", "both lateral_offset and overlap"),
    ("bar.overlap", 60, "bar.overlap", '"60 %" or 0.6'),
    ("bar.arms", {"l1": 1, "l2": 1, "l3": 1, "l4": 1}, "bar.rail_spacing", "both arms and rail_spacing"),
    ("bar.rail_spacing", None, "bar.rail_spacing", "or the four arms"),
    ("bar.lever_arm", "workconjugate", "bar.lever_arm", 'Did you mean "work-conjugate"?'),
    ("bar", None, "bar", "a bumper bar between the two vehicles"),
    ("vehicle2", None, "bar", "a bar with a rigid wall"),
    ("collision.kind", "wall", "collision.kind", '"wall" with a vehicle2'),
    ("collision.kind", "tree", "collision.kind", 'one of "vehicle", "wall"'),
    ("collision", {}, "collision.kind", "got nothing"),
    ("occupants", 5, "occupants", "need a list"),
    ("occupants.0", 5, "occupants.0", "need a table"),
    ("occupants.0.kind", "adlut", "occupants.0.kind", 'Did you mean "adult"?'),
    ("occupants.0.kind", "child", "occupants.0.seat", "a seat for a child"),
    ("occupants.1.kind", "adult", "occupants.1.seat", "none"),
    ("occupants.0.vehicle", 3, "occupants.0.vehicle", "one of 1, 2"),
    ("occupants.0.vehicle", True, "occupants.0.vehicle", "need 1 or 2"),
    ("occupants.0.name", "a b", "occupants.0.name", "a name of letters"),
    ("occupants.0.name", "a.b", "occupants.0.name", "a name of letters"),
    ("occupants.0.name", "bar", "occupants.0.name", "a reserved name"),
    ("occupants.0.name", 3, "occupants.0.name", "need text"),
    ("occupants.0.coupled", "yes", "occupants.0.coupled", "true or false"),
    ("occupants.0.restraint", None, "occupants.0.restraint", "need a table"),
    ("occupants.0.restraint.slack", -0.01, "occupants.0.restraint.slack", "got -0.01 m; need >= 0 m"),
    ("occupants.1.seat.restraint.damping", -5, "occupants.1.seat.restraint.damping", "need >= 0 N s/m"),
    ("occupants.0.restraint.damping", 5, "occupants.0.restraint.damping_ratio", "both damping and damping_ratio"),
    ("occupants.0.restraint.damping_ratio", 50, "occupants.0.restraint.damping_ratio", '"50 %" or 0.5'),
    ("occupants.0.restraint.law", "maxwell", "occupants.0.restraint.law", "kelvin-voigt"),
    ("duration", 0, "duration", "need > 0 s and <= 10 s"),
    ("duration", "20 s", "duration", "need > 0 s and <= 10 s"),
    ("sources", [{"title": "x"}], "sources.0.confidence", '"primary"'),
    ("sources", [{"title": "x", "confidence": "primary", "year": "2011"}], "sources.0.year", "a whole number"),
    ("name", 5, "name", "need text"),
]

NETWORK: list[tuple[str, object, str, str]] = [
    ("elements.0.stiffness", "4 N", "elements.0.stiffness", "a force; need a stiffness"),
    ("elements.0.stiffness", None, "elements.0.stiffness", "need a stiffness"),
    ("elements.0.stifness", 3, "elements.0.stifness", 'Did you mean "stiffness"?'),
    ("elements.0.damping", -3, "elements.0.damping", "need >= 0 N s/m"),
    ("elements.0.between", ["wall", "m3"], "elements.0.between.1", 'got "m3"; need one of wall, m1, m2'),
    ("elements.0.between", ["m1", "m1"], "elements.0.between", "two different bodies"),
    ("elements.0.between", ["m1"], "elements.0.between.1", "one more entry"),
    ("elements.0.between", "m1", "elements.0.between", "need a list"),
    ("elements.0.law", "linaer", "elements.0.law", 'Did you mean "linear"?'),
    ("elements.0.name", "m1", "elements.0.name", "a second time"),
    ("elements.0", 4, "elements.0", "need a table"),
    ("elements.2.points", [[0, 0], [0, 1]], "elements.2.points.1.0", "more than points.0.0"),
    ("elements.2.stiffness", 1, "elements.2.stiffness", "an unknown key"),
    ("elements.2.points", None, "elements.2.pieces", "at least one piece"),
    ("elements", [], "elements", "at least one entry"),
    ("masses", [], "masses", "at least one entry"),
    ("masses.0.mass", -1, "masses.0.mass", "need > 0 kg"),
    ("masses.0.name", "wall", "masses.0.name", "a reserved name"),
    ("masses.1.name", "m1", "masses.1.name", "a second time"),
    ("vehicle3", 1, "vehicle3", "an unknown key"),
]


def _sentence(data: object) -> str:
    with pytest.raises(InvalidInput) as error:
        load(data)
    return str(error.value)


@pytest.mark.parametrize(("path", "value", "field", "words"), CRASH)
def test_a_crash_is_refused(crash: Change, path: str, value: object, field: str, words: str) -> None:
    message = _sentence(crash(path, value))
    assert message.startswith(f"{field}: got ")
    assert re.search(r"; need .*[.?]$", message)
    assert words in message
    assert "\n" not in message


@pytest.mark.parametrize(("path", "value", "field", "words"), NETWORK)
def test_a_network_is_refused(network: Change, path: str, value: object, field: str, words: str) -> None:
    message = _sentence(network(path, value))
    assert message.startswith(f"{field}: got ")
    assert words in message


@pytest.mark.parametrize(("stiffness", "ok"), [(4e5, True), (3.9e5, False), (0.0, False)])
def test_plastic_unloading_is_at_least_as_stiff_as_the_stiffest_piece(crash: Change, stiffness: float, ok: bool) -> None:
    data = crash("vehicle1.members.unloading", "plastic")
    data["vehicle1"]["members"]["unloading_stiffness"] = stiffness
    if ok:
        load(data)
    else:
        assert _sentence(data).startswith("vehicle1.members.unloading_stiffness: got ")


def test_one_side_alone_is_refused(crash: Change) -> None:
    data = crash()
    data["vehicle1"]["left"] = data["vehicle1"].pop("members")
    assert _sentence(data).startswith("vehicle1.right: got nothing; need the right member as well as the left.")


def test_an_occupant_of_a_vehicle_that_is_not_there(crash: Change) -> None:
    data = crash()
    del data["vehicle2"], data["bar"]
    assert _sentence(data).startswith("occupants.2.vehicle: got 2; need")


def test_two_occupants_of_one_name(crash: Change) -> None:
    data = crash("occupants.0.name", "sam")
    data["occupants"][1]["name"] = "sam"
    assert _sentence(data).startswith('occupants.1.name: got "sam" a second time; need')


def test_overlap_needs_the_width(crash: Change) -> None:
    data = crash("bar.overlap", 0.6)
    del data["bar"]["lateral_offset"]
    assert _sentence(data).startswith("bar.width: got nothing; need")
    data["bar"]["width"] = 1.8
    load(data)


def test_a_wrong_element_law_is_named_by_its_own_path(network: Change) -> None:
    assert _sentence(network("elements.1.slack", "-1 mm")).startswith('elements.1.slack: got "-1 mm"; need >= 0 m.')


def test_several_things_wrong_make_one_sentence_about_an_unknown_key(crash: Change) -> None:
    data = crash("vehicle1.mass", -1)
    data["vehicle2"]["sped"] = data["vehicle2"].pop("speed")
    assert _sentence(data) == 'vehicle2.sped: got an unknown key; need a key of this table. Did you mean "speed"?'


@pytest.mark.parametrize("data", [{}, {1: 2}, {"a": 1}, {"elements": []}])
def test_what_is_no_scenario_at_all(data: dict[Any, Any]) -> None:
    assert ": got " in _sentence(data)


def test_python_objects_are_refused_alike() -> None:
    with pytest.raises(InvalidInput, match=r"^mass: got -1 kg; need > 0 kg"):
        Vehicle(mass=-1, speed=0, members={"pieces": [{"stiffness": 1}]})
    with pytest.raises(InvalidInput, match=r"^vehicle1\.mass: got nothing"):
        CrashScenario.model_validate({"vehicle1": {"speed": 0, "members": Member(points=[(0, 0)])}})
