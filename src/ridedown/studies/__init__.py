"""Studies: what is learnt from many crashes.

`run_study` runs a study file and keeps its results; `query` asks them. `calibrate` finds a model's parameters from tests,
`extract` (in `ridedown.studies.extraction.extract`) a front structure from a wall test.
The names below are loaded when they are first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ridedown.studies.calibration.file import Calibration, load_calibration
    from ridedown.studies.calibration.fit import calibrate
    from ridedown.studies.calibration.fitted import Calibrated
    from ridedown.studies.execution import run_study
    from ridedown.studies.sql import query
    from ridedown.studies.study import Study, load_study

__all__ = ["Calibrated", "Calibration", "Study", "calibrate", "load_calibration", "load_study", "query", "run_study"]

_HOME = {
    "Calibrated": "calibration.fitted",
    "Calibration": "calibration.file",
    "Study": "study",
    "calibrate": "calibration.fit",
    "load_calibration": "calibration.file",
    "load_study": "study",
    "query": "sql",
    "run_study": "execution",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'ridedown.studies' has no attribute {name!r}")
    value: object = getattr(importlib.import_module(f"ridedown.studies.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
