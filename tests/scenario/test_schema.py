"""The JSON Schema says what files may hold."""

from __future__ import annotations

import json
import re

from ridedown.scenario import CrashScenario, NetworkScenario, json_schema
from ridedown.scenario.quantities import DIMENSIONS, Quantity


def test_it_is_json_and_names_every_field() -> None:
    schema = json.loads(json.dumps(json_schema()))
    definitions = schema["$defs"]
    for model in (CrashScenario, NetworkScenario):
        definition = definitions[model.__name__]
        assert set(definition["properties"]) == set(model.model_fields)
        assert definition["additionalProperties"] is False
    assert definitions["Vehicle"]["required"] == ["mass", "speed"]
    assert "default" not in definitions["Vehicle"]["properties"]["right"]


def test_quantities_are_numbers_or_text_with_a_unit() -> None:
    mass = json_schema()["$defs"]["Vehicle"]["properties"]["mass"]
    number, text = mass["anyOf"]
    assert number == {"type": "number", "exclusiveMinimum": 0.0}
    assert re.search(text["pattern"], "1500 kg")
    assert not re.search(text["pattern"], "1500 m")


def test_every_example_matches_its_pattern() -> None:
    for dimension in DIMENSIONS:
        pattern = Quantity(dimension).__get_pydantic_json_schema__(None, None)["anyOf"][1]["pattern"]
        assert re.search(pattern, dimension.example)
        assert all(re.search(pattern, f"1.5e3 {unit}") for unit in dimension.units)


def test_restraints_are_told_apart_by_their_kind() -> None:
    definitions = json_schema()["$defs"]
    choices = definitions["Occupant"]["properties"]["restraints"]["items"]["oneOf"]
    kinds = [definitions[choice["$ref"].rsplit("/", 1)[1]]["properties"]["kind"] for choice in choices]
    assert [kind.get("const", kind.get("enum")) for kind in kinds] == [
        "belt",
        "airbag",
        ["knee_bolster", "dashboard", "wheel", "seat_back"],
    ]
