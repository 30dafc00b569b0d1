"""From occupants and what restrains them to bodies and elements of a network."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ridedown import network
from ridedown.network import Action, Builder, Timer
from ridedown.scenario.occupant import Occupant, Restraint
from ridedown.scenario.quantities import Number
from ridedown.scenario.restraints import Airbag, AnyRestraint, Belt, Contact, LoadLimiter

Tied = network.Linear | network.KelvinVoigt | network.Threshold

TIES: dict[str, type[Tied]] = {
    "linear": network.Linear,
    "kelvin-voigt": network.KelvinVoigt,
    "threshold": network.Threshold,
}
"""The laws of springs and dampers, by their names in files."""

_PULLS = (Action.PULL_1, Action.PULL_2)


def lower_occupant(builder: Builder, occupant: Occupant, vehicle: int, speed: Number) -> None:
    """Add an occupant of a vehicle, its seat and all that holds them; `vehicle` is the vehicle's body, `speed` its speed."""
    name, seat = occupant.name, occupant.seat
    holder = vehicle
    if seat is not None:
        holder = builder.body(f"{name}.seat", mass=seat.mass, speed=speed, parent=vehicle)
    masses: list[Number] = [body.mass for body in occupant.bodies] or [occupant.whole_mass]
    bodies = {
        body: (builder.body(body, mass=mass, speed=speed, parent=holder), mass)
        for body, mass in zip(occupant.mass_names, masses, strict=True)
    }
    # what the vehicle is taken not to notice; a child always pushes its seat
    light = seat is None and not occupant.coupled
    _hold(builder, name, occupant.restraint, occupant.restraints, bodies, holder, light=light)
    for joint in occupant.joints:
        first, second = (bodies[f"{name}.{body}"][0] for body in joint.between)
        law = network.Linear(joint.stiffness, joint.damping)
        builder.element(f"{name}.{joint.name}", law, deflection={first: -1.0, second: 1.0})
    if seat is not None:
        chair = {f"{name}.seat": (holder, seat.mass)}
        _hold(builder, f"{name}.seat", seat.restraint, seat.restraints, chair, vehicle, light=not occupant.coupled)


def _hold(
    builder: Builder,
    name: str,
    lumped: Restraint | None,
    restraints: Iterable[AnyRestraint],
    bodies: Mapping[str, tuple[int, Number]],
    holder: int,
    *,
    light: bool,
) -> None:
    """Add the restraints between the bodies (index and mass) called `name` and what holds them."""
    if lumped is not None:
        body, mass = bodies[name]
        law = TIES[lumped.law](lumped.stiffness, lumped.coefficient(mass), lumped.slack)
        builder.element(f"{name}.restraint", law, deflection={body: 1.0, holder: -1.0}, acts_on=(body,) if light else None)
    for one in restraints:
        body, mass = bodies[name if one.on is None else f"{name}.{one.on}"]
        sign = one.direction if isinstance(one, Contact) else 1.0
        builder.element(
            f"{name}.{one.name}",
            restraint_law(one, mass),
            deflection={body: sign, holder: -sign},
            acts_on=(body,) if light else None,
        )


def restraint_law(restraint: AnyRestraint, mass: Number) -> network.Restraint:
    """The force law of a restraint on a mass [kg]."""
    knots, forces, slopes = restraint.curve()
    own: dict[str, Any] = {"damping": restraint.coefficient(mass), "unloading": restraint.unloading_stiffness}
    if isinstance(restraint, Belt):
        own |= {"slack": restraint.slack, **_reel(restraint)}
    elif isinstance(restraint, Airbag):
        own |= {"slack": restraint.gap, "empty": True, "timers": _filling(restraint)}
    else:
        own |= {"slack": restraint.gap}
    return network.Restraint(knots, forces, slopes, **own)


def _reel(belt: Belt) -> dict[str, Any]:
    stalls: list[Number] = [np.inf, np.inf]
    timers = [] if belt.lock_time is None else [Timer(Action.LOCK, belt.lock_time)]
    for n, (one, pull) in enumerate(zip(belt.pretensioners, _PULLS, strict=False)):
        stalls[n] = np.inf if one.stall_force is None else one.stall_force
        timers.append(Timer(pull, one.fire_time, one.pull_in / one.duration))
        timers.append(Timer(pull, one.fire_time + one.duration, 0.0))
    limits, payouts = ((np.inf, np.inf), (np.inf, np.inf)) if belt.load_limiter is None else _stages(belt.load_limiter)
    if belt.load_limiter is not None and belt.load_limiter.switch_time is not None:
        timers.append(Timer(Action.STAGE_2, belt.load_limiter.switch_time))
    return {
        "limits": limits,
        "payouts": payouts,
        "stalls": tuple(stalls),
        "free": belt.lock_time is not None,
        "timers": tuple(timers),
    }


def _stages(limiter: LoadLimiter) -> tuple[tuple[Number, Number], tuple[Number, Number]]:
    """Force of each stage, and the payout in all at which each ends. An infinite force is a hard stop."""
    end: Number = np.inf if limiter.max_payout is None else limiter.max_payout
    if limiter.second_force is None:
        return (limiter.force, np.inf), (end, np.inf)
    # a first stage that ends at a time stops for good where the belt is all out before
    first = end if limiter.switch_payout is None else limiter.switch_payout
    return (limiter.force, limiter.second_force), (first, end)


def _filling(bag: Airbag) -> tuple[Timer, Timer]:
    return (
        Timer(Action.FILL, bag.fire_time, 1.0 / bag.fill_time),
        Timer(Action.FILL, bag.fire_time + bag.fill_time, 0.0),
    )
