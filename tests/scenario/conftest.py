"""Mappings of the shape of scenario files, to be changed by the tests."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

Change = Callable[..., dict[str, Any]]

LEAVE_OUT = object()


def changed(data: dict[str, Any], path: str, value: object) -> dict[str, Any]:
    """The data with the value put at the path, or with that path taken out."""
    node: Any = data
    *way, last = [int(part) if part.isdigit() else part for part in path.split(".")]
    for part in way:
        node = node[part] if isinstance(part, int) else node.setdefault(part, {})
    if value is LEAVE_OUT:
        del node[last]
    else:
        node[last] = value
    return data


def _crash() -> dict[str, Any]:
    knees = [{"stiffness": "100 kN/m", "until": "300 mm"}, {"stiffness": "400 kN/m"}]
    points = [["0 m", "10 kN"], ["0.3 m", "100 kN"]]
    belt = {"stiffness": "98.1 kN/m", "slack": "5 mm", "damping_ratio": "50 %"}
    seat = {"mass": "5 kg", "restraint": {"stiffness": "50 kN/m", "damping": 500}}
    return {
        "vehicle1": {"mass": "1500 kg", "speed": "48 km/h", "members": {"initial_force": "5 kN", "pieces": knees}},
        "vehicle2": {"mass": "1200 kg", "speed": "36 km/h", "members": {"points": points}},
        "bar": {"mass": "40 kg", "inertia": 157, "rail_spacing": "1.1 m", "lateral_offset": "0.5 m"},
        "occupants": [
            {"kind": "adult", "mass": 80, "restraint": belt},
            {"kind": "child", "mass": 18, "restraint": dict(belt), "seat": seat},
            {"kind": "adult", "vehicle": 2, "mass": 70, "restraint": dict(belt), "coupled": True},
        ],
    }


def _network() -> dict[str, Any]:
    return {
        "masses": [{"name": "m1", "mass": 800, "speed": "14 m/s"}, {"name": "m2", "mass": 80, "speed": "14 m/s"}],
        "elements": [
            {"name": "front", "between": ["wall", "m1"], "stiffness": "1 kN/m", "damping": "10 kN s/m"},
            {"between": ["m1", "m2"], "law": "threshold", "stiffness": 2860, "slack": "5 mm"},
            {"between": ["wall", "m1"], "law": "curve", "points": [[0, 0], [0.5, "50 kN"]]},
        ],
    }


@pytest.fixture
def crash() -> Change:
    """Builds the data of an offset crash, with one path changed."""
    return lambda path=None, value=None: _crash() if path is None else changed(_crash(), path, value)


@pytest.fixture
def network() -> Change:
    """Builds the data of a network, with one path changed."""
    return lambda path=None, value=None: _network() if path is None else changed(_network(), path, value)
