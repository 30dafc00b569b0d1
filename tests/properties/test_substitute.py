"""`substitute` looks only at what it changed, and refuses just what a file with the same numbers would be refused for."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import catalogue
from ridedown.errors import InvalidInput
from ridedown.scenario import Scenario, broken_rules, dump, load, quantities, substitute
from ridedown.scenario.places import Place, place_at, places, replaced
from tests.samples import examples

SCENARIOS = {name: load(name) for name in catalogue.names()}
PLACES = {name: dict(places(scenario, everything=True)) for name, scenario in SCENARIOS.items()}

# Times what a field holds, or a number of its own: many keep every rule, many break one between fields, some the field's own.
FACTORS = (0.0, 1e-3, 0.5, 1.0, 1.25, 2.0, 10.0, 1e4, -1.0)


@st.composite
def changes(draw: st.DrawFn) -> tuple[str, dict[str, float]]:
    """A scenario of the catalogue, and numbers to put in it."""
    name = draw(st.sampled_from(sorted(SCENARIOS)))
    paths = draw(st.lists(st.sampled_from(sorted(PLACES[name])), min_size=1, max_size=3, unique=True))
    return name, {path: draw(st.sampled_from(FACTORS)) * (_held(PLACES[name][path]) or 1.0) for path in paths}


def _held(place: Place) -> float:
    return 1.0 if place.value is None else float(np.ravel(place.value)[0])


def in_a_file(scenario: Scenario, values: dict[str, float]) -> Scenario:
    """The scenario of a file with these numbers in it, read and validated from the beginning. Raises: InvalidInput.

    Of two that replace each other (damping and its ratio) a file has the last, but both have to be within their bounds.
    """
    known = dict(places(scenario, everything=True))
    changed: Any = scenario
    for path, value in values.items():
        if not known[path].quantity.holds(value):
            raise InvalidInput(path)
        changed = replaced(changed, known[path].steps, value)
    return load(tomllib.loads(dump(changed)))


@given(changes())
@examples(400)
def test_refused_is_what_a_file_is_refused_for(change: tuple[str, dict[str, float]]) -> None:
    name, values = change
    try:
        expected: Scenario | None = in_a_file(SCENARIOS[name], values)
    except InvalidInput:
        expected = None
    if expected is None:
        with pytest.raises(InvalidInput):
            substitute(SCENARIOS[name], values)
    else:
        assert substitute(SCENARIOS[name], values) == expected


@given(changes(), changes())
@examples(200)
def test_so_it_is_of_one_that_was_substituted_before(
    first: tuple[str, dict[str, float]], then: tuple[str, dict[str, float]]
) -> None:
    name, values = first
    second = {path: value for path, value in then[1].items() if path in PLACES[name]}
    try:
        once = substitute(SCENARIOS[name], values)
    except InvalidInput:
        return
    try:
        expected: Scenario | None = in_a_file(once, second)
    except InvalidInput:
        expected = None
    if expected is None:
        with pytest.raises(InvalidInput):
            substitute(once, second)
    else:
        assert substitute(once, second) == expected


@given(changes(), st.lists(st.sampled_from(FACTORS), min_size=2, max_size=6))
@examples(100)
def test_rows_are_refused_as_single_values_are(change: tuple[str, dict[str, float]], factors: list[float]) -> None:
    name, values = change
    columns = {path: value * np.array(factors) for path, value in values.items()}
    found = broken_rules(SCENARIOS[name], columns)
    if any("in every row" in rule for rule in found):
        return  # a rule of tables alone: all rows of a sled share the shape of its pulse
    broken = np.any([np.zeros(len(factors), dtype=np.bool_), *found.values()], axis=0)
    for row in range(len(factors)):
        alone = {path: float(column[row]) for path, column in columns.items()}
        try:
            substitute(SCENARIOS[name], alone)
        except InvalidInput:
            assert broken[row], alone
        else:
            assert not broken[row], alone


@pytest.mark.parametrize("name", sorted(SCENARIOS))
def test_a_path_leads_where_the_list_of_all_says(name: str) -> None:
    scenario = SCENARIOS[name]
    for path, place in PLACES[name].items():
        assert place_at(scenario, path) == place
        for wrong in (f"{path}.0", f"{path}.", f".{path}", path[:-1], path.rpartition(".")[0], path.replace("0", "9", 1)):
            assert place_at(scenario, wrong) == PLACES[name].get(wrong)
    assert quantities(scenario) == {path: place.quantity for path, place in PLACES[name].items()}


def test_what_was_never_validated_is_looked_at_as_a_whole() -> None:
    """`model_copy` validates nothing: a broken rule elsewhere is found when a number is put in, unless that mends it."""
    crash = SCENARIOS["p1"]
    belt = crash.occupants[0].restraint.model_copy(update={"damping": 5.0, "damping_ratio": 0.5})
    adult = crash.occupants[0].model_copy(update={"restraint": belt})
    broken = crash.model_copy(update={"occupants": (adult, *crash.occupants[1:])})
    for _ in range(2):
        with pytest.raises(InvalidInput, match=r"adult\.restraint\.damping_ratio: got both"):
            substitute(broken, {"vehicle1.mass": 1000.0})
    mended = substitute(broken, {"adult.restraint.damping_ratio": 0.5})
    assert substitute(mended, {"vehicle1.mass": 1000.0}).vehicle1.mass == 1000.0
