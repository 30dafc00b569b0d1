"""A calibration made of a measured test alone: an occupant on the test's own pulse, held by a restraint of a usual kind, fitted
to one measured acceleration.

What `ridedown calibrate` takes as a file is made here from few choices: which channel, which kind of restraint, what is free.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from ridedown import units
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import substitute
from ridedown.signals.record import ChannelInfo, TestRecord
from ridedown.studies.calibration.file import Calibration
from ridedown.studies.sled_of_test import sled_of_test

CFC = 60.0
"""Channel frequency class that the model and the measured channel are compared in."""
END = 0.150
"""s: how far a fit goes where nothing else is said: a frontal crash is over then."""

_AFTER = 0.020  # s simulated beyond the fit's end: the filter looks ahead
_PEAK = 0.01  # of the measured peak: how near the model's is asked to be, as one more number
_MASSES: Mapping[tuple[str, int], float] = MappingProxyType(
    {("Hybrid III", 5): 49.0, ("Hybrid III", 50): 78.0, ("Hybrid III", 95): 101.0}
)
"""Whole masses of dummies [kg], by kind and percentile."""
_USUAL_MASS = 78.0
_NAMES = {"01": "driver", "02": "passenger"}


@dataclass(frozen=True, slots=True)
class FreeNumber:
    """A number of a restraint that a fit may find, SI: its path within the occupant, and the bounds suggested for it.

    value: what it is held at where it is not free, unless another is given.
    """

    name: str
    path: str
    unit: str
    low: float
    high: float
    value: float
    by_ratio: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Template:
    """A usual kind of restraint: the occupant's table with it, as in a scenario file, and its numbers to fit."""

    name: str
    what: str
    occupant: Mapping[str, Any]
    numbers: tuple[FreeNumber, ...]


_BELT: Mapping[str, Any] = {
    "kind": "belt",
    "stiffness": "60 kN/m",
    "slack": "60 mm",
    "damping": "1 kN s/m",
    "pretensioners": [{"fire_time": "12 ms", "pull_in": "50 mm", "duration": "8 ms", "stall_force": "1.5 kN"}],
    "load_limiter": {"force": "8 kN"},
}
_AIRBAG: Mapping[str, Any] = {
    "kind": "airbag",
    "fire_time": "15 ms",
    "fill_time": "30 ms",
    "gap": "100 mm",
    "stiffness": "60 kN/m",
    "venting": "1 kN s/m",
}
_OF_BELT = (
    FreeNumber("belt stiffness", "belt.stiffness", "N/m", 20e3, 500e3, 60e3, by_ratio=True),
    FreeNumber("belt slack", "belt.slack", "m", 0.0, 0.150, 0.060),
    FreeNumber("belt damping", "belt.damping", "N s/m", 50.0, 5e3, 1e3, by_ratio=True),
    FreeNumber("limiter force", "belt.load_limiter.force", "N", 2e3, 20e3, 8e3, by_ratio=True),
)
_OF_AIRBAG = (
    FreeNumber("airbag gap", "airbag.gap", "m", 0.0, 0.300, 0.100),
    FreeNumber("airbag fill time", "airbag.fill_time", "s", 0.010, 0.090, 0.030),
    FreeNumber("airbag stiffness", "airbag.stiffness", "N/m", 5e3, 500e3, 60e3, by_ratio=True),
    FreeNumber("airbag venting", "airbag.venting", "N s/m", 50.0, 5e3, 1e3, by_ratio=True),
)

TEMPLATES: Mapping[str, Template] = MappingProxyType(
    {
        template.name: template
        for template in (
            Template(
                "belt and airbag",
                "a belt with pretensioner and load limiter, and an airbag that fills",
                {"kind": "adult", "restraints": [_BELT, _AIRBAG]},
                (*_OF_BELT, *_OF_AIRBAG),
            ),
            Template(
                "belt",
                "a belt with pretensioner and load limiter",
                {"kind": "adult", "restraints": [_BELT]},
                _OF_BELT,
            ),
            Template(
                "spring and damper",
                "one spring and one damper after a slack, as in the founding paper",
                {"kind": "adult", "restraint": {"stiffness": "60 kN/m", "slack": "20 mm", "damping_ratio": "20 %"}},
                (
                    FreeNumber("stiffness", "restraint.stiffness", "N/m", 10e3, 500e3, 60e3, by_ratio=True),
                    FreeNumber("slack", "restraint.slack", "m", 0.0, 0.150, 0.020),
                    FreeNumber("damping ratio", "restraint.damping_ratio", "", 0.0, 1.0, 0.2),
                ),
            ),
        )
    }
)
"""The kinds of restraint that a test can be fitted with, the fullest first."""


@dataclass(frozen=True, slots=True)
class Fittable:
    """A measured acceleration that an occupant can be fitted to; mass [kg]: that of the dummy, or a usual one."""

    key: str
    label: str
    seat: str
    unit: str
    mass: float


def fittable(record: TestRecord) -> tuple[Fittable, ...]:
    """The channels of a test that an occupant can be fitted to, the best first: accelerations along x of chest, pelvis and head
    where the record says what its channels are, else every acceleration.
    """
    told = [info for part in ("chest", "pelvis", "head") for info in _along_x(record, part)]
    found = told or [info for info in record.channels.values() if info.readable and is_acceleration(info)]
    return tuple(
        Fittable(info.key, info.name or info.key, info.occupant or "", info.unit, _mass(record, info)) for info in found
    )


def is_acceleration(info: ChannelInfo) -> bool:
    """Whether a channel is in a unit of acceleration."""
    return units.is_known(info.unit) and units.dimension(info.unit) is units.ACCELERATION


def calibration_of_test(
    record: TestRecord,
    channel: str,
    template: str = "belt and airbag",
    *,
    free: Mapping[str, tuple[float, float]] | None = None,
    held: Mapping[str, float] | None = None,
    mass: float | None = None,
    pulse: str = "",
    end: float = END,
    effort: Literal["quick", "normal", "thorough"] = "normal",
) -> Calibration:
    """The calibration of a restraint to one channel of a test: what `calibrate` takes.

    channel: a measured acceleration of the occupant along x. template: one of TEMPLATES. free: bounds (SI) of the numbers to
    find, by name; all, within the bounds suggested, if left out. held: values (SI) of the others. mass [kg] of the occupant.
    pulse: a channel of the vehicle, where the record does not say which it is. end [s]: of what is fitted, from time 0 on.

    Raises: UnknownName for a channel, template or number that there is not; InvalidInput for what cannot be fitted.
    """
    if template not in TEMPLATES:
        raise UnknownName.among("template", template[:60], TEMPLATES)
    kind, info = TEMPLATES[template], record.channel(channel)
    if not is_acceleration(info):
        raise InvalidInput(f"channel: got {info.key[:60]!r} in {info.unit!r}; need an acceleration. Choose another channel.")
    if pulse and record.channel(pulse).key == info.key:
        raise InvalidInput(f"pulse: got {info.key[:60]!r}, which is fitted; need a channel of the vehicle. Name another one.")
    numbers = {number.name: number for number in kind.numbers}
    bounds = {name: (one.low, one.high) for name, one in numbers.items()} if free is None else dict(free)
    for name in (*bounds, *(held or {})):
        if name not in numbers:
            raise UnknownName.among("parameter", name[:60], numbers)
    if not bounds:
        raise InvalidInput("parameters: got none that is free; need one at least. Free one.")
    who = _NAMES.get(info.occupant or "", "occupant")
    occupant = {**kind.occupant, "name": who, "mass": _mass(record, info) if mass is None else float(mass)}
    sled = sled_of_test(record, pulse=pulse, occupant=occupant)
    history = record.history(info)
    last = min(float(end), sled.duration, history.end)
    if not last > 0.0:
        raise InvalidInput(f"end: got {1e3 * last:g} ms; need a time after 0, within the recording. Choose a later one.")
    values = {f"{who}.{numbers[name].path}": value for name, value in (held or {}).items() if name not in bounds}
    values["duration"] = min(sled.duration, round(last + _AFTER, 9))
    peak = _PEAK * float(np.abs(history.si[1]).max())
    target = {"channel": f"{who}.acceleration", "measured": info.key, "cfc": CFC, "window": [0.0, last]}
    return Calibration.model_validate(
        {
            "title": f"{record.identifier}: {info.name or info.key}",
            "description": f"Held by {kind.what}, on the pulse of the test.",
            "cases": [
                {
                    "name": who,
                    "scenario": substitute(sled, values),
                    "record": record,
                    "targets": [target | ({"peak": peak} if peak > 0.0 else {})],
                }
            ],
            "parameters": [
                {
                    "name": name,
                    "paths": [f"{who}.{numbers[name].path}"],
                    "bounds": list(ends),
                    "scale": "log" if numbers[name].by_ratio else "linear",
                }
                for name, ends in bounds.items()
            ],
            "search": {"effort": effort},
        }
    )


def _along_x(record: TestRecord, part: str) -> Iterable[ChannelInfo]:
    found = record.find(location=part, quantity="acceleration", axis="x")
    return sorted((info for info in found if info.occupant), key=lambda info: (info.occupant or "", info.redundant))


def _mass(record: TestRecord, info: ChannelInfo) -> float:
    """The mass of the dummy that a channel is of, where the record names it [kg]."""
    for occupant in record.occupants:
        if occupant.seat == info.occupant and info.vehicle in {None, occupant.vehicle} and occupant.percentile.isdecimal():
            return _MASSES.get((occupant.dummy, int(occupant.percentile)), _USUAL_MASS)
    return _USUAL_MASS
