"""Studies: what is learnt from many crashes.

`run_study` runs a study file and keeps its results; `query` asks them. `calibrate` finds a model's parameters from tests,
`extract` (in `ridedown.studies.extraction.extract`) a front structure from a wall test.
The names below are loaded when they are first used.

A study goes from the top of this list to `results`; each folder imports from those after it only.

    running        rows given to threads or a cluster, and searches, whose rows follow from one another
    results        the folder that keeps rows; SQL over it; what a finished study says
    rows           which rows a study has, and what is computed of each
    file           the study file: scenarios, parameters, outcomes, limits, options of each kind
    analysis       samples, rare events, sensitivity, optima, fronts, boxes: of any function of named columns, crashes or not
    bound          limiting performance: the least peak that any restraint could give
    distributions  what a parameter may be distributed like

    calibration    parameters found from tests
    extraction     a front structure from a wall test
    sled_of_test   a measured test as a sled to begin from
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ridedown.studies.calibration.file import Calibration, load_calibration
    from ridedown.studies.calibration.fit import calibrate
    from ridedown.studies.calibration.fitted import Calibrated
    from ridedown.studies.file.study import Study, load_study
    from ridedown.studies.results.sql import query
    from ridedown.studies.running.execution import run_study

__all__ = ["Calibrated", "Calibration", "Study", "calibrate", "load_calibration", "load_study", "query", "run_study"]

_HOME = {
    "Calibrated": "calibration.fitted",
    "Calibration": "calibration.file",
    "Study": "file.study",
    "calibrate": "calibration.fit",
    "load_calibration": "calibration.file",
    "load_study": "file.study",
    "query": "results.sql",
    "run_study": "running.execution",
}


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'ridedown.studies' has no attribute {name!r}")
    value: object = getattr(importlib.import_module(f"ridedown.studies.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
