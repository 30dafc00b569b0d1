"""Evidence of a simulated crash: its vehicles and occupants are lumped masses, and say no more than a mass can."""

from __future__ import annotations

import numpy as np

from ridedown.limits.evidence import CannotJudge, Person, Pulse, Signals
from ridedown.response import Response

_NO_PART = {
    "head": "a lumped occupant has no head",
    "chest deflection": "a lumped occupant has no ribs to deflect",
    "chest deflection, class 180": "a lumped occupant has no ribs to deflect",
    "neck axial force": "a lumped occupant has no neck",
    "neck shear force": "a lumped occupant has no neck",
    "neck moment": "a lumped occupant has no neck",
    "left femur": "a lumped occupant has no legs",
    "right femur": "a lumped occupant has no legs",
}


class ResponseEvidence:
    """The channels of a response by their meaning: the chest of an occupant is its whole mass, along x only.

    An occupant of several bodies has a head and a chest where they are called so.
    """

    simulated = True

    def __init__(self, response: Response) -> None:
        self.response = response
        self.title = response.scenario.name or "a scenario"
        self.people = tuple(
            Person(name, result.vehicle, child=result.kind == "child", lumped=not result.bodies, simulated=True)
            for name, result in response.occupants.items()
        )
        self.vehicles = tuple(response.vehicles)
        self._pulses: dict[str, Pulse] = {}

    def signals(self, person: Person, measure: str) -> Signals:
        """The occupant's acceleration for the chest, or that of its body so called. Raises: CannotJudge."""
        bodies = self.response.occupants[person.name].bodies
        if measure in bodies:
            channel = f"{person.name}.{measure}.acceleration"
            time, values = self.response.history(channel).si
            return Signals(time, values[np.newaxis, :], (channel,), (f"the acceleration of the body {measure}, along x",))
        if bodies and measure in {"head", "chest"}:
            raise CannotJudge(f"this occupant has no body called {measure}")
        if measure != "chest":
            raise CannotJudge(_NO_PART[measure])
        channel = f"{person.name}.acceleration"
        time, values = self.response.history(channel).si
        return Signals(time, values[np.newaxis, :], (channel,), ("the acceleration of the whole lumped mass, along x",))

    def pulse(self, vehicle: str) -> Pulse:
        """The vehicle's own acceleration, unfiltered: what is simulated has no noise to filter.

        Before contact there is none, so that one which begins with a jump begins at zero.
        """
        if vehicle not in self._pulses:  # a dozen criteria ask for it
            channel = f"{vehicle}.acceleration"
            time, values = self.response.history(channel).si
            if values[0] != 0.0:
                time, values = np.concatenate((time[:1], time)), np.concatenate(([0.0], values))
            self._pulses[vehicle] = Pulse(time, values, values, (channel,))
        return self._pulses[vehicle]

    def across(self, vehicle: str, what: str) -> Signals:
        """Zero: the simulated crash is head-on, and nothing in it moves to the side, up or about the vertical."""
        time = self.pulse(vehicle).time
        return Signals(time, np.zeros((1, time.size)), (), (f"{what}: none, the simulated crash is along x",))

    def speed(self, vehicle: str) -> float:
        """The vehicle's speed at contact [m/s]."""
        return self.response.vehicles[vehicle].speed

    def crush(self, vehicle: str) -> tuple[float, float] | None:
        """The largest deflection of the vehicle's front [m] and its time [s], exact; None on a sled, which has no front."""
        crush = self.response.vehicles[vehicle].dynamic_crush
        return None if crush is None else (crush.value, crush.time)
