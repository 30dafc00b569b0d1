"""Study files to start from: one of each kind, of the scenario that the page shows, with ranges around its own numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ridedown import catalogue
from ridedown.apps.web import maps
from ridedown.apps.web.requests import scenario_of
from ridedown.apps.web.sliders import sliders
from ridedown.errors import InvalidInput, UnknownName
from ridedown.report.lines import G
from ridedown.scenario import NetworkScenario, Scenario, dump
from ridedown.simulation import simulate_many

KINDS: Mapping[str, str] = {
    "sweep": "Every combination of two parameters",
    "sample": "What comes out where parameters are uncertain",
    "sensitivity": "Which parameter matters",
    "optimise": "The best compromise of two outcomes",
    "box": "How much room every parameter has",
    "bound": "The least that any restraint could give",
    "rare": "How likely a limit is exceeded that seldom is",
}
"""Kinds of studies with what they answer; `rare` is a sample in the file."""

_FIRST, _SECOND = r"(restraint|belt)\.stiffness$", r"(restraint|belt)\.slack$"
_OWN = r"(^vehicle1\.(mass|speed)$|^pulse\.(delta_v|duration)$|^bar\.overlap$|\.damping(_ratio)?$)"
_MASS = re.compile(r"\.mass$")
_WRITTEN = {
    "m": ("mm", 1e3), "m/s": ("km/h", 3.6), "m/s2": ("g", 1.0 / G), "N": ("kN", 1e-3), "N/m": ("kN/m", 1e-3), "s": ("ms", 1e3),
}  # fmt: skip
"""SI units to those that people write, and the factor."""


@dataclass(frozen=True, slots=True)
class _Number:
    """A number of the scenario that a study may vary: its path, value, unit and the ends of its slider, SI."""

    path: str
    value: float
    unit: str
    low: float
    high: float

    def around(self, share: float) -> tuple[float, float]:
        """So much below and above the value, within its slider; of zero, the lower part of the slider."""
        if self.value == 0.0:
            return self.low, self.low + share * (self.high - self.low)
        ends = sorted((self.value * (1.0 - share), self.value * (1.0 + share)))
        return max(ends[0], self.low), min(ends[1], self.high)


def study_file(message: Mapping[str, Any]) -> dict[str, Any]:
    """The text of a study of a `study` kind, one of KINDS, for the scenario of a request.

    Raises: InvalidInput, UnknownName.
    """
    kind = str(message.get("study"))
    if kind not in KINDS:
        raise UnknownName.among("study", kind[:50], KINDS)
    scenario = scenario_of(message)
    made = _bound(scenario) if kind == "bound" else _varied(kind, scenario)
    head = f'kind = "{"sample" if kind == "rare" else kind}"\nname = "{kind}"\n'
    named, table = _scenario(scenario, message)
    return {"kind": "study-file", "study": kind, "toml": f"{head}{named}{made}{table}"}


def _varied(kind: str, scenario: Scenario) -> str:
    numbers = _numbers(scenario)
    if len(numbers) < 2:
        raise InvalidInput("scenario: got one with fewer than two numbers; need two that can vary. Take another.")
    names, units = _outcomes(scenario)
    if kind in {"optimise", "box"}:  # of what a designer of restraints chooses
        own = [one for one in numbers if one.path.startswith(f"{names[0].partition('.')[0]}.") and not _MASS.search(one.path)]
        numbers = own if len(own) >= 2 else numbers
    makers: dict[str, Callable[[list[_Number], list[str], dict[str, float], dict[str, str]], str]] = {
        "sweep": _sweep,
        "sample": _sample,
        "sensitivity": _sensitivity,
        "optimise": _optimise,
        "box": _box,
        "rare": _rare,
    }
    found = simulate_many(scenario, {numbers[0].path: np.array([numbers[0].value])}, outcomes=names)
    values = {name: abs(float(found[name][0])) for name in names}
    if not all(np.isfinite(value) and value > 0.0 for value in values.values()):
        raise InvalidInput("scenario: got a crash without peaks to study; need one that ends. Change it in the Crash view.")
    return makers[kind](numbers, names, values, units)


def _sweep(numbers: list[_Number], names: list[str], _values: dict[str, float], _units: dict[str, str]) -> str:
    parts = [f"outcomes = {_list(names)}\n"]
    for one, count in zip(numbers[:2], (61, 41), strict=True):
        low, high = one.around(0.6)
        grid = f"grid = {{ start = {_text(low, one.unit)}, stop = {_text(high, one.unit)}, count = {count} }}"
        parts.append(_parameter(one, grid))
    return "".join(parts)


def _sample(numbers: list[_Number], names: list[str], values: dict[str, float], units: dict[str, str]) -> str:
    limits = _limits({name: 1.1 * values[name] for name in names}, units)
    drawn = "".join(_spread(one) for one in numbers[:4])
    return f"outcomes = {_list(names)}\n{limits}sample = {{ rows = 8192, seed = 0 }}\n{drawn}"


def _sensitivity(numbers: list[_Number], names: list[str], _values: dict[str, float], _units: dict[str, str]) -> str:
    ranged = "".join(_ranged(one, 0.2) for one in numbers[:5])
    return f'outcomes = {_list(names)}\nsensitivity = {{ method = "sobol", rows = 1024, seed = 0 }}\n{ranged}'


def _optimise(numbers: list[_Number], names: list[str], _values: dict[str, float], _units: dict[str, str]) -> str:
    goals = "".join(f'\n[[optimise.objectives]]\noutcome = "{name}"\n' for name in names)
    ranged = "".join(_ranged(one, 0.6) for one in numbers[:3])
    return f"{ranged}\n[optimise]\ncandidates = 60\ngenerations = 40\nseed = 0\n{goals}"


def _box(numbers: list[_Number], names: list[str], values: dict[str, float], units: dict[str, str]) -> str:
    limits = _limits({name: 1.1 * values[name] for name in names}, units)
    return f"{limits}box = {{ seed = 0 }}\n{''.join(_ranged(one, 0.4) for one in numbers[:3])}"


def _rare(numbers: list[_Number], names: list[str], values: dict[str, float], units: dict[str, str]) -> str:
    limits = _limits({names[0]: 1.35 * values[names[0]]}, units)
    drawn = "".join(_spread(one) for one in numbers[:3])
    return f"{limits}sample = {{ rare = true, rows = 4000, level_rows = 1000, seed = 0 }}\n{drawn}"


def _bound(scenario: Scenario) -> str:
    if isinstance(scenario, NetworkScenario):
        bodies = [one.name for one in scenario.masses]
        vehicle, occupants = next((name for name in bodies if name in {"vehicle", "body"}), bodies[0]), []
    else:
        vehicle, occupants = "vehicle1", [one.name for one in scenario.occupants if one.vehicle == 1]
    beside = f"occupants = {_list(occupants)}\n" if occupants else ""
    return f'\n[bound]\nvehicle = "{vehicle}"\ngrid = {{ start = "50 mm", stop = "400 mm", count = 15 }}\n{beside}'


def _numbers(scenario: Scenario) -> list[_Number]:
    """What may vary, the most telling first: the first occupant's stiffness and slack, then what a first look changes."""
    found = [
        _Number(one["path"], one["value"], one["unit"], one["low"], one["high"])
        for one in sliders(scenario)
        if one["first"] and not one["path"].startswith("duration")
    ]
    first = next((one for one in found if re.search(_FIRST, one.path)), None)
    second = next((one for one in found if re.search(_SECOND, one.path)), None)
    chosen = [one for one in (first, second) if one is not None]
    own = [one for one in found if re.search(_OWN, one.path)]
    return list(dict.fromkeys([*chosen, *own, *found]))


def _outcomes(scenario: Scenario) -> tuple[list[str], dict[str, str]]:
    """Two outcomes that contradict each other, as a map has them: a peak acceleration, and how far that body gets."""
    known = {one["name"]: one["unit"] for one in maps.outcomes(scenario)}
    peak = next(name for name in known if name.endswith(".acceleration.peak"))
    body = peak.removesuffix(".acceleration.peak")
    far = next(name for name in (f"{body}.excursion.max", f"{body}.displacement.max") if name in known)
    return [peak, far], known


def _parameter(one: _Number, rest: str) -> str:
    return f'\n[[parameters]]\npath = "{one.path}"\n{rest}\n'


def _ranged(one: _Number, share: float) -> str:
    low, high = one.around(share)
    return _parameter(one, f"range = [{_text(low, one.unit)}, {_text(high, one.unit)}]")


def _spread(one: _Number) -> str:
    """Normal with a tenth of the value as its deviation, cut off before what no such number may be."""
    if one.value <= 0.0:
        return _ranged(one, 0.3)
    low, high = (_text(end * one.value, one.unit) for end in (0.5, 1.5))
    mean, deviation = _text(one.value, one.unit), _text(0.1 * one.value, one.unit)
    kind = f'kind = "truncated-normal", mean = {mean}, sd = {deviation}, lower = {low}, upper = {high}'
    if one.value * 1.5 > one.high:
        return _ranged(one, 0.2)
    return _parameter(one, f"distribution = {{ {kind} }}")


def _limits(most: Mapping[str, float], units: Mapping[str, str]) -> str:
    said = ", ".join(f'{{ outcome = "{name}", most = {_text(value, units[name])} }}' for name, value in most.items())
    return f"limits = [{said}]\n"


def _text(value: float, unit: str) -> str:
    """A value as a file has it, to three digits: with the unit that people read, bare where there is none."""
    shown, factor = _WRITTEN.get(unit, (unit, 1.0))
    number = f"{float(f'{factor * value:.3g}'):.12g}"
    return f'"{number} {shown}"' if shown else number


def _list(names: list[str]) -> str:
    return "[" + ", ".join(f'"{name}"' for name in names) + "]"


def _scenario(scenario: Scenario, message: Mapping[str, Any]) -> tuple[str, str]:
    """How the file names the scenario: by its name in the catalogue, or, where it differs from it, written out at the end."""
    name = message.get("scenario")
    if message.get("toml") is None and not message.get("values") and name in catalogue.names():
        return f'scenario = "{name}"\n', ""
    heads = re.compile(r"^(\[\[?)([A-Za-z])", re.MULTILINE)
    return "", "\n# the scenario as the Crash view has it\n[scenario]\n" + heads.sub(r"\1scenario.\2", dump(scenario))
