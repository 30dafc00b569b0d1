"""The JSON Schema of scenario files, for editors."""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

from ridedown.scenario.model import CrashScenario
from ridedown.scenario.networks import NetworkScenario


def json_schema() -> dict[str, Any]:
    """The JSON Schema of a scenario file, a crash or a network. Rules between fields are checked on loading only."""
    schema = TypeAdapter[CrashScenario | NetworkScenario](CrashScenario | NetworkScenario).json_schema()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "ridedown scenario",
        "description": "A head-on crash, or a network of masses. Quantities are SI numbers or text with a unit.",
        **schema,
    }
