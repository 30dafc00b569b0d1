"""Vehicles that the paper's may have been: the calibration file says what is free in them; scenarios that have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ridedown.errors import InvalidInput
from ridedown.paper.cases import Case, G
from ridedown.paper.numbers import ACCELERATION, PRINTED, Printed
from ridedown.scenario import CrashScenario, load, substitute
from ridedown.studies import Calibration, load_calibration

FILE = Path(__file__).with_name("identify.toml")
"""Eight unknowns for ten numbers, within the bounds of what a car may be. Everything else is as in the catalogue: what is
printed, what the numbers cannot tell, and what a wider search left at its bound (docs/decisions/paper-vehicle.md)."""

_OFFSET = "bar.lateral_offset"


def calibration_to(target: Sequence[float] | None = None) -> Calibration:
    """The calibration to the paper's ten numbers, or to ten others in the order and the units of `PRINTED`.

    Raises: InvalidInput for a target that is not ten positive numbers.
    """
    calibration, _ = load_calibration(FILE)
    if target is None:
        return calibration
    wanted = np.asarray(target, dtype=np.float64)
    if wanted.shape != (len(PRINTED),) or not (np.isfinite(wanted) & (wanted > 0.0)).all():
        raise InvalidInput(f"target: got {target!r}; need {len(PRINTED)} positive numbers. Give them in the order of PRINTED.")
    values = {(p.case.scenario, outcome_of(p)): float(value) * _unit(p) for p, value in zip(PRINTED, wanted, strict=True)}
    cases = []
    for case in calibration.cases:
        targets = [
            one if one.value is None else one.model_copy(update={"value": values[case.scenario, one.outcome]})
            for one in case.targets
        ]
        cases.append(case.model_copy(update={"targets": tuple(targets)}))
    return calibration.model_copy(update={"cases": tuple(cases)})


def outcome_of(printed: Printed) -> str:
    """The outcome that a number of the paper is."""
    return f"{printed.channel}.peak"


def _unit(printed: Printed) -> float:
    return G if printed.quantity == ACCELERATION else 1.0


def scenario_of(case: Case) -> CrashScenario:
    """The catalogue's scenario of one of the paper's cases."""
    scenario = load(case.scenario)
    assert isinstance(scenario, CrashScenario)
    return scenario


def with_vehicle(scenario: CrashScenario, values: Mapping[str, float]) -> CrashScenario:
    """One of the paper's scenarios with a candidate's vehicles and bar, by the unknowns' names, in place of the catalogue's."""
    table = {path: values[unknown.name] for unknown in calibration_to().parameters for path in unknown.paths}
    if scenario.bar is None or scenario.bar.lateral_offset == 0.0:
        del table[_OFFSET]
    return substitute(scenario, table)
