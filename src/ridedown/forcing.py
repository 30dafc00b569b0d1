"""The paper's forcing functions f(t) and f_2(t) (eqs 26, 32, 33): what the vehicle's motion does to the occupant."""

from __future__ import annotations

from ridedown.network import Channel, Family, Law, Network
from ridedown.network.channels import Term
from ridedown.scenario import CrashScenario, SledScenario
from ridedown.solver import laws
from ridedown.solver.phases import Phases


def forcing_channels(
    scenario: CrashScenario | SledScenario, network: Network, phases: Phases, known: dict[str, Channel]
) -> dict[str, Channel]:
    """`<adult>.forcing` = f(t) and `<child>.seat.forcing` = f_2(t) [N], for all times.

    Of occupants whose restraint is one spring and damper, for that is what the paper's equations have.

    `v*` is the relative velocity at which the slack was first taken up: zero for laws that have none, and where it never was.
    """
    found = {}
    for occupant in scenario.occupants:
        if occupant.restraint is None or (occupant.seat is not None and occupant.seat.restraint is None):
            continue
        vehicle = f"vehicle{occupant.vehicle}"
        if occupant.seat is None:
            name, constant = occupant.name, 0.0
        else:
            name = f"{occupant.name}.seat"
            constant = -_own_part(network, phases, known, f"{occupant.name}.restraint")  # f_1, eq 32
        e = network.elements.index(f"{name}.restraint")
        k, c = float(network.stiffness[e, 0]), float(network.damping[e, 0])
        i = network.coordinate(vehicle)
        terms: tuple[Term, ...] = ((Family.RATE, i, c), (Family.POSITION, i, k))
        constant += _own_part(network, phases, known, f"{name}.restraint")  # eqs 26, 33
        found[f"{name}.forcing"] = Channel(f"{name}.forcing", "N", terms, constant)
    return found


def _own_part(network: Network, phases: Phases, known: dict[str, Channel], element: str) -> float:
    """What a restraint adds by itself, c v* + k delta*."""
    e = network.elements.index(element)
    k, c, slack = (float(x[e, 0]) for x in (network.stiffness, network.damping, network.slack))
    return c * _latched(network, phases, known, e) + k * slack


def _latched(network: Network, phases: Phases, known: dict[str, Channel], e: int) -> float:
    """v*: the relative velocity at the instant that the slack was first taken up."""
    taken_up = (phases.event_element == e) & (phases.event_before == laws.OPEN)
    if network.law[e] != Law.THRESHOLD or not taken_up.any():
        return 0.0
    rate = phases.series(known[f"{network.elements[e]}.deflection_rate"])
    return float(phases.at(rate, phases.event_time[taken_up][:1])[0])
