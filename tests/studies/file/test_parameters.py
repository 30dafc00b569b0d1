"""What varies in a study: paths, units, grids, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown import load
from ridedown.errors import InvalidInput, UnknownName
from ridedown.studies.file.parameters import StudyParameter, resolve


def resolved(*given, **scenarios):
    return resolve(tuple(StudyParameter.model_validate(one) for one in given), scenarios or {"": load("p1")})


def test_values_carry_units_and_a_grid_its_ends():
    belt, speed, offset = resolved(
        {"path": "adult.restraint.stiffness", "values": ["20 kN/m", 98_100.0]},
        {"name": "speed", "paths": ["vehicle1.speed", "vehicle2.speed"], "grid": {"start": "36 km/h", "stop": 20, "count": 3}},
        {"path": "bar.lateral_offset", "grid": {"start": "1 mm", "stop": "1 m", "count": 4, "spacing": "log"}},
    )
    np.testing.assert_array_equal(belt.levels, [20e3, 98.1e3])
    np.testing.assert_array_equal(speed.levels, [10.0, 15.0, 20.0])
    np.testing.assert_allclose(offset.levels, [1e-3, 1e-2, 1e-1, 1.0], rtol=1e-14)
    assert (offset.levels[0], offset.levels[-1]) == (1e-3, 1.0)
    assert (belt.name, speed.name, belt.unit) == ("adult.restraint.stiffness", "speed", "N/m")
    assert speed.targets == {"": ("vehicle1.speed", "vehicle2.speed")}


def test_a_path_goes_to_every_scenario_that_has_it_and_with_a_name_before_to_that_one():
    scenarios = {"full": load("paper-adult-full"), "offset": load("paper-adult-offset"), "wall": load("example-wall")}
    everywhere, one = resolved(
        {"path": "bar.mass", "values": [40, 50]}, {"path": "offset.bar.lateral_offset", "values": [0.0, 0.8]}, **scenarios
    )
    assert everywhere.targets == {"full": ("bar.mass",), "offset": ("bar.mass",)}  # a wall has no bar
    assert one.targets == {"offset": ("bar.lateral_offset",)}


BELT = {"path": "adult.restraint.stiffness", "values": [1e4, 2e4]}
REFUSED = [
    ([{"path": "adult.restraint.stiffness"}], ["values", "nothing"]),
    ([{"values": [1, 2]}], ["path"]),
    ([BELT | {"grid": {"start": 1, "stop": 2, "count": 2}}], ["values and grid"]),
    ([BELT | {"values": []}], ["empty"]),
    ([BELT | {"value": [1]}], ["value", "values"]),
    ([BELT | {"values": ["20 kg"]}], ["values.0", "20 kg", "a stiffness"]),
    ([BELT | {"values": ["20 kN/m", "-20 kN/m"]}], ["values.1", ">= 0"]),
    ([BELT | {"values": None, "grid": {"start": 1, "stop": 2, "count": 1}}], ["count"]),
    ([BELT | {"values": None, "grid": {"start": 1, "stop": 1, "count": 5}}], ["stop"]),
    ([BELT | {"values": None, "grid": {"start": 0, "stop": 1, "count": 5, "spacing": "log"}}], ["start", "log"]),
    ([BELT | {"values": None, "range": [2, 1]}], ["range"]),
    ([BELT | {"name": "status"}], ["status"]),
    ([BELT | {"name": "Row"}], ["Row"]),
    ([BELT, BELT], ["a second time"]),
    ([BELT | {"name": "k"}, {"name": "K", "path": "adult.mass", "values": [1, 2]}], ['"K" beside "k"']),
    ([BELT, BELT | {"name": "again"}], ["sets too"]),
    ([{"paths": ["adult.restraint.stiffness", "adult.mass"], "values": [1, 2]}], ["a stiffness", "a mass"]),
]


@pytest.mark.parametrize(("given", "said"), REFUSED, ids=[f"{i}-{said[0]}" for i, (_, said) in enumerate(REFUSED)])
def test_refused_in_one_sentence(given, said):
    with pytest.raises(InvalidInput) as refused:
        resolved(*given)
    for words in said:
        assert words in str(refused.value)


def test_the_nearest_path_is_offered():
    with pytest.raises(UnknownName, match=r"adult\.restraint\.stiffness"):
        resolved({"path": "adult.restraint.stifness", "values": [1, 2]})
