"""Every kind of scenario."""

from __future__ import annotations

from typing import TypeVar

from ridedown.scenario.model import CrashScenario
from ridedown.scenario.networks import NetworkScenario
from ridedown.scenario.sled import SledScenario

Scenario = CrashScenario | NetworkScenario | SledScenario

S = TypeVar("S", bound=Scenario)
"""One kind of scenario: what is put in comes out."""
