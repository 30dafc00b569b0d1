"""Head-on crashes solved event by event: vehicles, adults and children in child seats.

The names below are loaded when they are first used, so that `import ridedown` and `ridedown --help` answer at once.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ridedown import catalogue, errors
    from ridedown.outcomes import Outcomes
    from ridedown.response import Response
    from ridedown.scenario import CrashScenario, NetworkScenario, SledScenario, load
    from ridedown.simulation import simulate, simulate_many

__version__ = "0.1.0"

__all__ = [
    "CrashScenario",
    "NetworkScenario",
    "Outcomes",
    "Response",
    "SledScenario",
    "__version__",
    "catalogue",
    "errors",
    "load",
    "simulate",
    "simulate_many",
]

_HOME = {
    "CrashScenario": "ridedown.scenario",
    "NetworkScenario": "ridedown.scenario",
    "Outcomes": "ridedown.outcomes",
    "Response": "ridedown.response",
    "SledScenario": "ridedown.scenario",
    "load": "ridedown.scenario",
    "simulate": "ridedown.simulation",
    "simulate_many": "ridedown.simulation",
}
_MODULES = ("catalogue", "errors")


def __getattr__(name: str) -> object:
    if name in _MODULES:
        return importlib.import_module(f"ridedown.{name}")
    if name in _HOME:
        value: object = getattr(importlib.import_module(_HOME[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'ridedown' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
