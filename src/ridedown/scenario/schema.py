"""The JSON Schema of scenario files, for editors."""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

from ridedown.scenario.kinds import Scenario


def json_schema() -> dict[str, Any]:
    """The JSON Schema of a scenario file: a crash, a network or a sled. Rules between fields are checked on loading only."""
    schema = TypeAdapter[Scenario](Scenario).json_schema()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "ridedown scenario",
        "description": "A head-on crash, a network of masses, or a sled. Quantities are SI numbers or text with a unit.",
        **schema,
    }
