"""The response of another scenario as a pulse: what a vehicle does in one crash, prescribed in a sled."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Discriminator, Field, Tag

from ridedown.errors import InvalidInput, UnknownName
from ridedown.network import Pulse
from ridedown.scenario.base import Check
from ridedown.scenario.model import CrashScenario
from ridedown.scenario.networks import NetworkScenario
from ridedown.scenario.pulse import BasePulse
from ridedown.scenario.quantities import Factor, Number, Refused
from ridedown.scenario.reading import is_network, mapping_of

Crash = CrashScenario | NetworkScenario

_NEEDED = "a crash or a network: a file, a catalogue name or a table"


def _read(value: object) -> object:
    """The mapping of a file or a catalogue name; a table and a scenario as they are."""
    if isinstance(value, str):
        try:
            value = mapping_of(value)
        except (InvalidInput, UnknownName) as problem:
            raise Refused(f'"{value}"', _NEEDED, str(problem)) from None
    if isinstance(value, Mapping):
        if "pulse" in value:
            raise Refused("a sled", _NEEDED, "Name the crash that the sled is to follow, or copy the sled's own pulse.")
        return dict(value)
    if not isinstance(value, Crash):
        raise Refused(type(value).__name__, _NEEDED)
    return value


def _which(value: Any) -> str:
    network = isinstance(value, NetworkScenario) or (isinstance(value, Mapping) and is_network(value))
    return "(networkscenario)" if network else "(crashscenario)"


def _vehicle(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, int | str):
        raise Refused("true" if value is True else str(value).lower(), "1, 2 or the name of a mass")
    return value


def _or_text(schema: dict[str, Any]) -> None:
    """Say that a file may name the scenario instead of holding it."""
    choices = schema.pop("oneOf", None) or schema.pop("anyOf")
    schema["anyOf"] = [{"type": "string", "description": "a file or a catalogue name"}, *choices]


class ScenarioPulse(BasePulse):
    """The solved motion of a vehicle in another scenario, exact: the polynomials of its phases, piece by piece.

    A file or a catalogue name is replaced by what it holds, so that the sled is complete in itself.
    """

    kind: Literal["scenario"]
    scenario: Annotated[
        Annotated[CrashScenario, Tag("(crashscenario)")] | Annotated[NetworkScenario, Tag("(networkscenario)")],
        Discriminator(_which),
        BeforeValidator(_read),
    ] = Field(description="a crash or a network: a file, a catalogue name or a table", json_schema_extra=_or_text)
    vehicle: Annotated[int | str, BeforeValidator(_vehicle)] = Field(1, description="1, 2 or, of a network, the name of a mass")
    scale: Factor = Field(1.0, description="factor on every acceleration, and on the initial speed")

    @property
    def body(self) -> str:
        """Name of the body whose motion it is."""
        return f"vehicle{self.vehicle}" if isinstance(self.vehicle, int) else self.vehicle

    def speed_of_body(self) -> float | None:
        """Its initial speed along its own forward direction [m/s]; None where there is no such body."""
        if isinstance(self.scenario, NetworkScenario):
            return next((float(mass.speed) for mass in self.scenario.masses if mass.name == self.body), None)
        found = {"vehicle1": self.scenario.vehicle1, "vehicle2": self.scenario.vehicle2}.get(self.body)
        return None if found is None else float(found.speed)

    def change(self) -> Number | None:
        """The body's initial speed [m/s]."""
        speed = self.speed_of_body()
        return None if speed is None else self.scale * speed

    def end(self) -> Number:
        """When the pulse is over [s]: the duration of the other scenario."""
        return self.scenario.duration

    def whole(self) -> float:
        """The duration of the other scenario [s]."""
        return float(self.scenario.duration)

    def checks(self) -> Iterator[Check]:
        """Rules between the fields."""
        if isinstance(self.scenario, NetworkScenario):
            known = [mass.name for mass in self.scenario.masses]
        else:
            known = ["1"] if self.scenario.vehicle2 is None else ["1", "2"]
        shown = str(self.vehicle) if isinstance(self.vehicle, int) else f'"{self.vehicle}"'
        yield Check(
            "scenario",
            _single(self.scenario),
            "a scenario of columns",
            "one crash",
            "Substitute in the sled, or make a sled of each.",
        )
        yield Check("vehicle", self.speed_of_body() is not None, shown, f"one of {', '.join(known)}")


def _single(scenario: Crash) -> bool:
    """Whether a scenario holds single values only, which have a hash."""
    try:
        hash(scenario)
    except TypeError:
        return False
    return True


def pieces_of(start: np.ndarray, length: np.ndarray, series: np.ndarray) -> Pulse:
    """The pulse that a solved acceleration is: (n,) starts and lengths of the phases [s], (n, order) series in SI.

    After the last phase there is no acceleration.
    """
    kept = length > 0.0
    own = series[kept][:, :-2]  # a channel has as many orders as the position, and of an acceleration the last two are none
    return Pulse(np.append(start[kept], start[-1] + length[-1]), np.vstack((own, np.zeros((1, own.shape[1])))))
