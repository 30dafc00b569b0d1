"""From what the user wrote to what the solver sees: a scenario becomes a network.

Pure arithmetic on the scenario's numbers, so that columns (see `substitute`) lower like single values.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

from ridedown import network
from ridedown.errors import InvalidInput
from ridedown.network import Builder, Network
from ridedown.scenario.bar import Bar
from ridedown.scenario.kinds import Scenario
from ridedown.scenario.lowering_occupant import TIES, Tied, lower_occupant
from ridedown.scenario.member import ForceDeflection
from ridedown.scenario.model import CrashScenario
from ridedown.scenario.networks import WALL, Crush, NetworkScenario, Tie
from ridedown.scenario.pulse_solved import ScenarioPulse, pieces_of
from ridedown.scenario.sled import SledScenario
from ridedown.scenario.vehicle import Vehicle


def lower(scenario: Scenario) -> Network:
    """The network of a scenario: its bodies and elements in a fixed order, SI.

    Bodies are named `vehicle1`, `vehicle2`, `bar`, `bar.rotation`, `<occupant>` or `<occupant>.<body>`, and
    `<occupant>.seat`; elements `vehicle1.right`, `vehicle1.left`, `vehicle2.right`, `vehicle2.left`, `<occupant>.restraint` or
    `<occupant>.<restraint>`, `<occupant>.<joint>` and the same of `<occupant>.seat`. In a network scenario both keep the
    names given there. A sled's vehicle is `vehicle1`.
    """
    builder = Builder()
    if isinstance(scenario, NetworkScenario):
        _lower_network(builder, scenario)
    elif isinstance(scenario, SledScenario):
        _lower_sled(builder, scenario)
    else:
        _lower_crash(builder, scenario)
    return builder.build(duration=scenario.duration)


def _lower_crash(builder: Builder, scenario: CrashScenario) -> None:
    vehicle1, vehicle2, bar = scenario.vehicle1, scenario.vehicle2, scenario.bar
    bodies = [builder.body("vehicle1", mass=vehicle1.mass, speed=vehicle1.speed)]
    if vehicle2 is None or bar is None:
        for side, curve in zip(("right", "left"), _curves(vehicle1), strict=True):
            builder.element(f"vehicle1.{side}", curve, deflection={bodies[0]: 1.0})
    else:
        bodies.append(builder.body("vehicle2", mass=vehicle2.mass, speed=vehicle2.speed))
        _lower_front(builder, bodies[0], bodies[1], vehicle1, vehicle2, bar)
    for occupant in scenario.occupants:
        vehicle = vehicle1 if occupant.vehicle == 1 or vehicle2 is None else vehicle2
        lower_occupant(builder, occupant, bodies[occupant.vehicle - 1], vehicle.speed)


def _lower_sled(builder: Builder, scenario: SledScenario) -> None:
    speed = scenario.initial_speed
    vehicle = builder.driven("vehicle1", pulse_of(scenario), speed=speed)
    for occupant in scenario.occupants:
        lower_occupant(builder, occupant, vehicle, speed)


def pulse_of(scenario: SledScenario) -> network.Pulse:
    """The acceleration of a sled's vehicle. Another scenario's is solved for, once for all that ask."""
    pulse = scenario.pulse
    if not isinstance(pulse, ScenarioPulse):
        return pulse.lowered()
    return replace(_solved(pulse.scenario, pulse.body), amplitude=pulse.scale)


@lru_cache(32)
def _solved(scenario: CrashScenario | NetworkScenario, body: str) -> network.Pulse:
    from ridedown.solver.solve import solve_one  # noqa: PLC0415  compiles the solver, which no other pulse needs

    crash = lower(scenario)
    phases, stop = solve_one(crash)
    if stop:
        raise InvalidInput(
            f"pulse.scenario: got a crash that stopped at {1e3 * phases.end:.3f} ms; need one that is solved to its end. "
            "Run it by itself to see why."
        )
    channel = network.channels(crash)[f"{body}.acceleration"]
    return pieces_of(phases.start, phases.length, phases.series(channel))


def _lower_front(builder: Builder, body1: int, body2: int, vehicle1: Vehicle, vehicle2: Vehicle, bar: Bar) -> None:
    """The bar and the four members that press on it."""
    # Both bumpers, of equal mass, are joined at contact, and keep their momentum.
    speed = (vehicle1.speed - vehicle2.speed) / 2 if bar.speed is None else bar.speed
    middle = builder.body("bar", mass=bar.mass, speed=speed)
    turn = None
    if bar.inertia is not None:
        turn = builder.bar("bar.rotation", inertia=bar.inertia, conjugate=bar.lever_arm == "work-conjugate")
    l1, l2, l3, l4 = bar.lengths()
    # eqs 7-8: d11 = x1 - x - l2 tan, d12 = x1 - x + l1 tan, d21 = x2 + x - l3 tan, d22 = x2 + x + l4 tan
    for name, body, sign, vehicle, arms in (
        ("vehicle1", body1, -1.0, vehicle1, (-l2, l1)),
        ("vehicle2", body2, 1.0, vehicle2, (-l3, l4)),
    ):
        for side, curve, arm in zip(("right", "left"), _curves(vehicle), arms, strict=True):
            lever = None if turn is None else (turn, arm)
            builder.element(f"{name}.{side}", curve, deflection={body: 1.0, middle: sign}, lever=lever)


def _lower_network(builder: Builder, scenario: NetworkScenario) -> None:
    bodies = {body.name: builder.body(body.name, mass=body.mass, speed=body.speed) for body in scenario.masses}
    for element in scenario.elements:
        signs = zip(element.between, (-1.0, 1.0), strict=True)
        deflection = {bodies[body]: sign for body, sign in signs if body != WALL}
        builder.element(element.name, _element(element), deflection=deflection)


def _element(element: Tie | Crush) -> Tied | network.Curve:
    if isinstance(element, Crush):
        return _curve(element)
    return TIES[element.law](element.stiffness, element.damping, element.slack)


def _curves(vehicle: Vehicle) -> tuple[network.Curve, network.Curve]:
    right = _curve(vehicle.right)
    return right, right if vehicle.alike else _curve(vehicle.left)


def _curve(member: ForceDeflection) -> network.Curve:
    knots, forces, slopes = member.curve()
    return network.Curve(knots, forces, slopes, member.unloading_stiffness)
