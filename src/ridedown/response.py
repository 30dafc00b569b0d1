"""What comes back from a crash: every channel as an exact function of time, peaks, events, balances."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown import recording
from ridedown.balance import EnergyBalance, MomentumBalance, energy_balance, momentum_balance
from ridedown.errors import InvalidInput
from ridedown.events import Event, events_of
from ridedown.forcing import forcing_channels
from ridedown.network import Action, Channel, Law, Network, channels
from ridedown.network.channels import find
from ridedown.scenario import (
    AnyRestraint,
    Belt,
    CrashScenario,
    NetworkScenario,
    Restraint,
    Scenario,
    SledScenario,
    Source,
    centre_of_mass,
    total_forces,
)
from ridedown.signals.history import TimeHistory
from ridedown.signals.record import TestRecord
from ridedown.solver.phases import Phases
from ridedown.solver.sampling import sampled
from ridedown.status import Status

if TYPE_CHECKING:
    import pyarrow as pa

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Extremum:
    """A largest or smallest value of a channel, in its SI unit, and its time [s]."""

    value: float
    time: float


@dataclass(frozen=True, slots=True)
class VehicleResult:
    """One vehicle, SI, along its own forward direction.

    delta_v: velocity at the end less that at the start. dynamic_crush: the largest deflection of either member, with its time.
    residual_crush: the larger permanent set. displacement: the farthest forward. peak_acceleration: the value of largest
    magnitude, negative when braking. time_to_rest: when the velocity first falls to zero, None if it never does.
    On a sled, whose motion is prescribed, mass and crush are None.
    """

    mass: float | None
    speed: float
    delta_v: float
    dynamic_crush: Extremum | None
    residual_crush: float | None
    displacement: Extremum
    peak_acceleration: Extremum
    time_to_rest: float | None


@dataclass(frozen=True, slots=True)
class BodyResult:
    """One body of an occupant, SI. excursion: relative to the vehicle."""

    mass: float
    peak_acceleration: Extremum
    excursion: Extremum
    time_to_rest: float | None


@dataclass(frozen=True, slots=True)
class OccupantResult:
    """One occupant, SI. excursion: relative to the vehicle; relative_displacement: of a child, to its seat.

    restraint_force: of all that holds it together. Of an occupant of several bodies the motion is that of its centre of mass,
    and `bodies` has each of them.
    """

    kind: str
    vehicle: str
    mass: float
    peak_acceleration: Extremum
    excursion: Extremum
    relative_displacement: Extremum
    restraint_force: Extremum
    time_to_rest: float | None
    bodies: dict[str, BodyResult]


@dataclass(frozen=True, slots=True)
class RestraintResult:
    """One restraint of an occupant or of its seat, SI.

    kind: as the scenario has it, "lumped" for one spring and damper. travel: the largest deflection, relative to what holds it,
    the slack or gap included. absorbed: work done on it. pulled_in, paid_out: belt that its pretensioners took in, and that its
    load limiter let out; None where there is no reel.
    """

    occupant: str
    kind: str
    force: Extremum
    travel: Extremum
    absorbed: float
    pulled_in: float | None
    paid_out: float | None


@dataclass(frozen=True, slots=True)
class MassResult:
    """One mass of a network scenario, SI."""

    mass: float
    speed: float
    delta_v: float
    displacement: Extremum
    peak_acceleration: Extremum


class Response:
    """The exact response of one crash: piecewise polynomials between located events.

    >>> from ridedown import load, simulate
    >>> response = simulate(load("p1"))
    >>> round(response.maximum("adult.excursion").value, 6)  # m
    0.207102
    >>> response.at("vehicle1.velocity", [0.0, 0.05]).round(3)  # m/s
    array([13.33 , 10.262])
    """

    def __init__(self, scenario: Scenario, network: Network, phases: Phases, status: Status) -> None:
        self.scenario = scenario
        self.network = network
        self.phases = phases
        self.status = status

    def __repr__(self) -> str:
        ended = f"{1e3 * self.end_time:.6g} ms, {self.phases.start.size} phases, {len(self.events)} events"
        return f"<Response of {self.scenario.name or 'a scenario'}: {ended}>"

    @property
    def completed(self) -> bool:
        """Whether the crash was solved to its end."""
        return self.status is Status.COMPLETED

    @property
    def end_time(self) -> float:
        """Time reached [s]: the scenario's duration, unless stopped before."""
        return self.phases.end

    # channels

    @cached_property
    def _motions_and_forces(self) -> dict[str, Channel]:
        """The channels that follow from the network alone."""
        known = channels(self.network)
        if not isinstance(self.scenario, NetworkScenario):
            known.update(total_forces(self.scenario.occupants, self.network))
            known.update(centre_of_mass(self.scenario.occupants, self.network))
        return known

    @cached_property
    def _channels(self) -> dict[str, Channel]:
        """All channels."""
        known = dict(self._motions_and_forces)
        if not isinstance(self.scenario, NetworkScenario):
            known.update(forcing_channels(self.scenario, self.network, self.phases, known))
        return known

    def _channel(self, name: str) -> Channel:
        """The channel of that name. Raises: UnknownName, with the nearest."""
        return self._motions_and_forces.get(name) or find(self._channels, name)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of all channels (see `ridedown.network.channels`)."""
        return tuple(self._channels)

    def unit(self, channel: str) -> str:
        """SI unit of a channel."""
        return self._channel(channel).unit

    def at(self, channel: str, times: ArrayLike) -> Floats:
        """A channel at times [s] between 0 and `end_time`, of the times' shape; at an event, the value just after it.

        Raises: UnknownName, with the nearest channels; InvalidInput for a time outside the response.
        """
        return self.phases.at(self._series(channel), self._within(times))

    def sampled(self, names: Iterable[str], times: ArrayLike) -> Floats:
        """Several channels at the same times (T,) [s], shape (C, T): what `at` gives of each, in a fraction of the time.

        >>> from ridedown import load, simulate
        >>> response = simulate(load("p1"))
        >>> response.sampled(["adult.excursion", "child.excursion"], [0.0, 0.1]).shape
        (2, 2)

        Raises: UnknownName, with the nearest channels; InvalidInput for a time outside the response.
        """
        return sampled(self.phases, [self._channel(name) for name in names], self._within(times))

    def _within(self, times: ArrayLike) -> Floats:
        times = np.asarray(times, dtype=np.float64)
        slack = 1e-12 * max(self.end_time, 1.0)
        if times.size and not (times.min() >= -slack and times.max() <= self.end_time + slack):
            raise InvalidInput(
                f"times: got {times.min():g} .. {times.max():g} s; need 0 .. {self.end_time:g} s. Ask within the response."
            )
        return times

    def _series(self, channel: str) -> Floats:
        return self.phases.series(self._channel(channel))

    def table(self, times: ArrayLike | None = None) -> dict[str, Floats]:
        """Every channel at times [s], under its name, with the times themselves as "time"; at every 0.1 ms if left out."""
        grid = self.times() if times is None else np.asarray(times, dtype=np.float64)
        return {"time": grid, **{name: self.at(name, grid) for name in self.channels}}

    def times(self, step: float = 1e-4) -> Floats:
        """Evenly spaced times [s] from 0 to the end, `step` apart at most."""
        return np.linspace(0.0, self.end_time, max(2, math.ceil(self.end_time / step - 1e-9) + 1))

    def drawing_times(self, step: float = 5e-4) -> Floats:
        """Times [s] for a curve: evenly spaced, with two at every phase's boundary, so that steps are drawn upright."""
        starts = self.phases.start[1:]
        before = np.nextafter(starts, 0.0)
        return np.unique(np.concatenate((self.times(step), before, starts)))

    def history(self, channel: str, tolerance: float = 1e-6) -> TimeHistory:
        """A channel as a time history: straight between its stamps to within `tolerance` times its peak.

        Its largest and smallest value are among the values, exact; a jump is two equal stamps. Criteria take it as they take a
        measured signal: `criteria.clip(*response.history("adult.acceleration").si)`.

        Raises: UnknownName, with the nearest channels; InvalidInput for a tolerance that is not > 0.
        """
        time, values = recording.knots(self.phases, self._series(channel), tolerance)
        code = recording.code_of(channel, recording.places_of(self.scenario))
        return TimeHistory(values, self.unit(channel), stamps=time, name=channel, code=code)

    # peaks

    def maximum(self, channel: str) -> Extremum:
        """The largest value of a channel and when, exact."""
        return self._extremum(channel, 1)

    def minimum(self, channel: str) -> Extremum:
        """The smallest value of a channel and when, exact."""
        return self._extremum(channel, -1)

    def peak(self, channel: str) -> Extremum:
        """The value of largest magnitude, with its sign, and when, exact."""
        return self._extremum(channel, 0)

    def _extremum(self, channel: str, sense: int) -> Extremum:
        return Extremum(*self.phases.largest(self._series(channel), sense))

    def time_to_rest(self, body: str) -> float | None:
        """When a body's velocity first falls below zero [s], or None if it does not."""
        return self.phases.first_fall(self._series(f"{body}.velocity"))

    # what happened

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """What happened, in order: contacts, knees, slack taken up, and the like."""
        return events_of(self.network, self.phases, belts=self._belts)

    @property
    def _belts(self) -> set[str]:
        """Elements that are belts."""
        if isinstance(self.scenario, NetworkScenario):
            return set()
        held = [pair for occupant in self.scenario.occupants for pair in occupant.held_by()]
        return {name for name, restraint in held if isinstance(restraint, Belt)}

    @cached_property
    def final_rate(self) -> Floats:
        """Rates of the network's coordinates at the end, (n,)."""
        powers = self.phases.length[-1] ** np.arange(self.phases.position.shape[1] - 1)
        orders = np.arange(1, self.phases.position.shape[1])
        rate: Floats = np.einsum("ji,j->i", self.phases.position[-1, 1:, :], orders * powers)
        return rate

    @cached_property
    def energy(self) -> EnergyBalance:
        """Where the energy went, element by element, and what does not add up."""
        return energy_balance(self.network, self.phases, self.final_rate)

    @cached_property
    def momentum(self) -> MomentumBalance:
        """Momentum along vehicle 1's forward direction, and what does not add up."""
        roots = [self.network.coordinates[i] for i in np.flatnonzero(self.network.parent < 0)]
        against = "vehicle2" if isinstance(self.scenario, CrashScenario) else None
        direction = {name: -1.0 if name == against else 1.0 for name in roots}
        return momentum_balance(self.network, self.phases, self.final_rate, direction)

    @cached_property
    def restitution(self) -> float | None:
        """Coefficient of restitution: speed of separation over closing speed, None while still in contact or for a network."""
        scenario = self.scenario
        if not isinstance(scenario, CrashScenario) or self.events_pending:
            return None
        names = [name for name in ("vehicle1", "vehicle2") if name in self.network.coordinates]
        closing = sum(self._start(f"{name}.velocity") for name in names)
        parting = -sum(self._end(f"{name}.velocity") for name in names)
        return parting / closing if closing > 0.0 else None

    @property
    def events_pending(self) -> bool:
        """Whether a front member still pushes at the end."""
        return any(
            self._end(f"{name}.force") > 0.0
            for e, name in enumerate(self.network.elements)
            if self.network.law[e] in {Law.ELASTIC, Law.PLASTIC}
        )

    @cached_property
    def vehicles(self) -> dict[str, VehicleResult]:
        """Each vehicle's outcome; empty for a network scenario."""
        if isinstance(self.scenario, SledScenario):
            return {"vehicle1": self._vehicle("vehicle1", None, self._start("vehicle1.velocity"))}
        if not isinstance(self.scenario, CrashScenario):
            return {}
        given = {"vehicle1": self.scenario.vehicle1, "vehicle2": self.scenario.vehicle2}
        return {
            name: self._vehicle(name, float(vehicle.mass), float(vehicle.speed))
            for name, vehicle in given.items()
            if vehicle is not None
        }

    def _vehicle(self, name: str, mass: float | None, speed: float) -> VehicleResult:
        members = [e for e in self.network.elements if e in {f"{name}.right", f"{name}.left"}]
        crushes = [self.maximum(f"{member}.deflection") for member in members]
        permanent = [max(float(self.phases.set[self.network.elements.index(member)]), 0.0) for member in members]
        return VehicleResult(
            mass=mass,
            speed=speed,
            delta_v=self._end(f"{name}.velocity") - speed,
            dynamic_crush=max(crushes, key=lambda peak: peak.value, default=None),
            residual_crush=max(permanent, default=None),
            displacement=self.maximum(f"{name}.displacement"),
            peak_acceleration=self.peak(f"{name}.acceleration"),
            time_to_rest=self.time_to_rest(name),
        )

    @cached_property
    def occupants(self) -> dict[str, OccupantResult]:
        """Each occupant's outcome; empty for a network scenario."""
        if isinstance(self.scenario, NetworkScenario):
            return {}
        return {
            occupant.name: OccupantResult(
                kind=occupant.kind,
                vehicle=f"vehicle{occupant.vehicle}",
                mass=float(occupant.whole_mass),
                peak_acceleration=self.peak(f"{occupant.name}.acceleration"),
                excursion=self.maximum(f"{occupant.name}.excursion"),
                relative_displacement=self.maximum(f"{occupant.name}.relative_displacement"),
                restraint_force=self.maximum(f"{occupant.name}.restraint.force"),
                time_to_rest=self.time_to_rest(occupant.name),
                bodies={
                    body.name: self._body(name, float(body.mass))
                    for name, body in zip(occupant.mass_names, occupant.bodies, strict=False)
                },
            )
            for occupant in self.scenario.occupants
        }

    def _body(self, name: str, mass: float) -> BodyResult:
        return BodyResult(
            mass=mass,
            peak_acceleration=self.peak(f"{name}.acceleration"),
            excursion=self.maximum(f"{name}.excursion"),
            time_to_rest=self.time_to_rest(name),
        )

    @cached_property
    def restraints(self) -> dict[str, RestraintResult]:
        """What each restraint did, by the name of its element; empty for a network scenario."""
        if isinstance(self.scenario, NetworkScenario):
            return {}
        return {
            name: self._restraint(name, occupant.name, restraint)
            for occupant in self.scenario.occupants
            for name, restraint in occupant.held_by()
        }

    def _restraint(self, name: str, occupant: str, restraint: Restraint | AnyRestraint) -> RestraintResult:
        e = self.network.elements.index(name)
        paid_out = float(self.phases.payout[e]) if isinstance(restraint, Belt) else None
        return RestraintResult(
            occupant=occupant,
            kind="lumped" if isinstance(restraint, Restraint) else restraint.kind,
            force=self.maximum(f"{name}.force"),
            travel=self.maximum(f"{name}.deflection"),
            absorbed=self.energy.elements[name].absorbed,
            pulled_in=None if paid_out is None else float(self.phases.reel[e]) + paid_out + self._given_freely(name),
            paid_out=paid_out,
        )

    def _given_freely(self, belt: str) -> float:
        """Belt that a reel gave before it locked [m]."""
        e = self.network.elements.index(belt)
        locks = self.network.timer_time[(self.network.timer_element == e) & (self.network.timer_action == Action.LOCK), 0]
        if locks.size == 0 or locks[0] > self.end_time:
            return 0.0
        return max(float(self.at(f"{belt}.deflection", locks[0])) - float(self.network.slack[e, 0]), 0.0)

    @cached_property
    def masses(self) -> dict[str, MassResult]:
        """Each mass of a network scenario; empty for a crash."""
        if not isinstance(self.scenario, NetworkScenario):
            return {}
        return {
            body.name: MassResult(
                mass=float(body.mass),
                speed=float(body.speed),
                delta_v=self._end(f"{body.name}.velocity") - float(body.speed),
                displacement=self.peak(f"{body.name}.displacement"),
                peak_acceleration=self.peak(f"{body.name}.acceleration"),
            )
            for body in self.scenario.masses
        }

    def _start(self, channel: str) -> float:
        return float(self.at(channel, 0.0))

    def _end(self, channel: str) -> float:
        return float(self.at(channel, self.end_time))

    # what it rests on, and taking it elsewhere

    @property
    def sources(self) -> tuple[Source, ...]:
        """The publications that the scenario's numbers rest on, each with how sure it is."""
        return self.scenario.sources

    def summary(self) -> dict[str, Any]:
        """Everything but the channels, as plain data for JSON; SI units."""
        return {
            "name": self.scenario.name,
            "description": self.scenario.description,
            "status": {"completed": self.completed, "sentence": self.status.sentence, "end_time": self.end_time},
            "vehicles": {name: asdict(result) for name, result in self.vehicles.items()},
            "occupants": {name: asdict(result) for name, result in self.occupants.items()},
            "restraints": {name: asdict(result) for name, result in self.restraints.items()},
            "masses": {name: asdict(result) for name, result in self.masses.items()},
            "restitution": self.restitution,
            "energy": asdict(self.energy),
            "momentum": asdict(self.momentum),
            "events": [asdict(event) for event in self.events],
            "sources": [source.model_dump() for source in self.sources],
        }

    def to_arrow(self, times: ArrayLike | None = None, names: Iterable[str] | None = None) -> pa.Table:
        """The channels as an Arrow table; each column's unit is in its field's metadata."""
        import pyarrow as pa  # noqa: PLC0415  slow to import, and few runs need it

        data = self.table(times)
        chosen = list(data) if names is None else ["time", *names]
        fields = [
            pa.field(name, pa.float64(), metadata={"unit": "s" if name == "time" else self.unit(name)}) for name in chosen
        ]
        return pa.table([data[name] for name in chosen], schema=pa.schema(fields))

    def to_csv(self, path: str | Path, times: ArrayLike | None = None) -> None:
        """Write the channels, one column each, its unit in the header: `time [s],vehicle1.displacement [m],...`."""
        data = self.table(times)
        units = ("s" if name == "time" else self.unit(name) for name in data)
        header = ",".join(f"{name} [{unit}]" for name, unit in zip(data, units, strict=True))
        rows = np.column_stack(list(data.values()))
        with Path(path).open("w", encoding="utf-8", newline="\n") as file:
            file.write(header + "\n")
            np.savetxt(file, rows, fmt="%.12g", delimiter=",")

    def to_record(self, step: float = 1e-4) -> TestRecord:
        """The channels as a test record, sampled evenly, `step` [s] apart at most, with ISO-MME channel codes.

        Write it with `ridedown.signals.write`, and a laboratory's own tools open it.
        """
        units = {name: self.unit(name) for name in self.channels}
        return recording.record_of(self.scenario, units, self.times(step), self.at)

    def to_parquet(self, path: str | Path, times: ArrayLike | None = None) -> None:
        """Write the channels to a Parquet file (zstd), units in the columns' metadata."""
        import pyarrow.parquet as pq  # noqa: PLC0415

        pq.write_table(self.to_arrow(times), str(path), compression="zstd")
