"""The numbers of a scenario as sliders: what to call them, where they are put, and how far they go."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from ridedown.scenario import Parameter, Scenario, parameters

_USUAL = {
    "kg": 100.0,
    "m": 0.2,
    "m/s": 15.0,
    "N": 50e3,
    "N/m": 200e3,
    "N s/m": 3e3,
    "kg m2": 150.0,
    "m/s2": 300.0,
    "s": 0.05,
    "": 1.0,
}
"""Where a slider ends whose value is zero, SI."""

_FRACTIONS = {"overlap": (0.1, 1.0), "damping_ratio": (0.0, 1.5), "scale": (0.5, 1.5)}
_SPEED = (0.0, 120.0 / 3.6)  # m/s
_LONGEST = (0.02, 0.5)  # s
_OFFSET = (-2.0, 2.0)  # m
_MORE = 2.5  # times the value, where nothing else is known

# What a first look at a scenario changes, by the end of the path; the rest is there behind a button.
_FIRST = re.compile(
    r"(^duration|\.(mass|speed|overlap|lateral_offset|slack|damping|damping_ratio|stiffness|until|fire_time|pull_in|force|"
    r"stall_force|gap|fill_time|venting|delta_v|duration|peak|scale|unloading_stiffness|initial_force))$"
)


def sliders(scenario: Scenario) -> list[dict[str, Any]]:
    """Every number of a scenario: path, group, label, value, unit (SI), the ends of its slider, and whether it comes first."""
    found = []
    for parameter in parameters(scenario):
        low, high = _ends(parameter)
        group, label = _words(parameter.path)
        found.append(
            {
                "path": parameter.path,
                "group": group,
                "label": label,
                "value": _value(parameter),
                "unit": parameter.unit,
                "low": low,
                "high": high,
                "first": bool(_FIRST.search(parameter.path)) and ".points." not in parameter.path,
            }
        )
    return found


def ends(scenario: Scenario) -> dict[str, tuple[float, float]]:
    """The ends of every slider, by path."""
    return {parameter.path: _ends(parameter) for parameter in parameters(scenario)}


def _value(parameter: Parameter) -> float:
    return float(np.ravel(parameter.value)[0])


def _ends(parameter: Parameter) -> tuple[float, float]:
    """A slider's ends: the value lies within."""
    name, value, unit = parameter.path.rpartition(".")[2], _value(parameter), parameter.unit
    if name in _FRACTIONS:
        low, high = _FRACTIONS[name]
    elif unit == "m/s":
        low, high = _SPEED
    elif parameter.path == "duration":
        low, high = _LONGEST
    elif name == "lateral_offset":
        low, high = _OFFSET
    elif unit == "kg":
        low, high = 0.4 * value, _MORE * value
    elif value > 0.0:
        low, high = 0.0 if name in {"slack", "gap", "damping", "venting", "fire_time"} else 0.1 * value, _MORE * value
    else:
        low, high = min(0.0, _MORE * value), _USUAL.get(unit, 1.0) if value == 0.0 else 0.0
    return _rounded(min(low, value), -1), _rounded(max(high, value), +1)


def _rounded(value: float, sense: int) -> float:
    """The value to two digits, outwards: ends that can be read."""
    if value == 0.0:
        return 0.0
    step = 10.0 ** (np.floor(np.log10(abs(value))) - 1.0)
    return float((np.ceil if sense > 0 else np.floor)(value / step * (1.0 - sense * 1e-12)) * step)


def _words(path: str) -> tuple[str, str]:
    """The group and the label of a path.

    >>> _words("driver.belt.pretensioners.0.fire_time")
    ('driver', 'belt, pretensioner 1, fire time')
    """
    first, _, rest = path.partition(".")
    if not rest:
        return "scenario", first
    words: list[str] = []
    for part in rest.split("."):
        if part.isdecimal() and words:
            words[-1] = f"{words[-1].removesuffix('s')} {int(part) + 1}"
        else:
            words.append(part.replace("_", " "))
    return first, ", ".join(words)
