"""Where energy and momentum went, and whether they add up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ridedown.network import Action, Channel, Family, Law, Network
from ridedown.network.model import Floats
from ridedown.outcomes import kinetic_energy
from ridedown.solver.phases import Phases


@dataclass(frozen=True, slots=True)
class ElementEnergy:
    """The energy of one element [J].

    absorbed: work done on it, the integral of its force over its deflection. stored: what it could still give back at the end.
    dissipated: the rest, counting in what a linear tie with slack, which starts out pushing, held at the start; negative where
    a pretensioner or a bag that fills put in more than was lost. left_out: work that the model does not book on any body, as
    that of a belt on a car taken to be too heavy to notice (`coupled = false`), or of the printed lever arm law, whose moment
    is not work-conjugate (eq 4).
    """

    absorbed: float
    stored: float
    dissipated: float
    left_out: float


@dataclass(frozen=True, slots=True)
class EnergyBalance:
    """Kinetic energy at the start and the end [J], each element's share, and what does not add up.

    residual: initial - final - sum(absorbed + left_out), over the initial energy.
    """

    initial: float
    final: float
    elements: dict[str, ElementEnergy]
    residual: float


@dataclass(frozen=True, slots=True)
class MomentumBalance:
    """Momentum along vehicle 1's forward direction [kg m/s], at the start and the end.

    external: impulse of the wall. left_out: impulse of restraints whose reaction the vehicle is taken not to notice.
    residual: initial + external + left_out - final, over the sum of the bodies' initial |momentum|.
    """

    initial: float
    final: float
    external: float
    left_out: float
    residual: float


def energy_balance(network: Network, phases: Phases, rate: Floats) -> EnergyBalance:
    """The energy balance of a solved crash; `rate` (n,) is that of the coordinates at the end."""
    elements = {}
    lost = 0.0
    for e, name in enumerate(network.elements):
        force = phases.series(Channel("", "N", ((Family.FORCE, e, 1.0),)))
        own = phases.series(Channel("", "m/s", ((Family.DEFLECTION_RATE, e, 1.0),)))
        absorbed = phases.integral_of_product(force, own)
        left_out = phases.integral_of_product(force, _booked_rate(network, phases, e, own) - own)
        stored = _stored(network, phases, e)
        elements[name] = ElementEnergy(absorbed, stored, absorbed + _stored_at_start(network, e) - stored, left_out)
        lost += absorbed + left_out
    initial = float(kinetic_energy(network, network.rate)[0])
    final = float(kinetic_energy(network, rate[:, None])[0])
    return EnergyBalance(initial, final, elements, (initial - final - lost) / initial if initial > 0.0 else 0.0)


def _booked_rate(network: Network, phases: Phases, e: int, own: Floats) -> Floats:
    """The rate at which element e's force does work on the bodies it acts on, per unit of force."""
    own_terms = range(network.term_start[e], network.term_start[e + 1])
    reactions = range(network.reaction_start[e], network.reaction_start[e + 1])
    total = np.zeros_like(own)
    for r in reactions:
        for link in network.chain(int(network.reaction_coordinate[r])):
            total += network.reaction_sign[r] * _rate(phases, link)
    lever = int(network.lever[e])
    if lever >= 0 and network.conjugate:
        total += own  # the lever's part of the deflection rate: all of it less the displacements'
        for t in own_terms:
            total -= network.term_sign[t] * _rate(phases, int(network.term_coordinate[t]))
    elif lever >= 0:
        total += network.arm[e, 0] * _rate(phases, lever)  # eq 4 as printed
    return total


def _rate(phases: Phases, coordinate: int) -> Floats:
    return phases.series(Channel("", "", ((Family.RATE, coordinate, 1.0),)))


def _stored_at_start(network: Network, e: int) -> float:
    """The energy that an element holds undeflected: that of a linear tie, engaged on either side of its slack."""
    return 0.5 * float(network.stiffness[e, 0] * network.slack[e, 0] ** 2) if network.law[e] == Law.LINEAR else 0.0


def _stored(network: Network, phases: Phases, e: int) -> float:
    """The energy that an element could still give back at the end."""
    end = phases.length[-1]
    powers = end ** np.arange(phases.force.shape[1])
    force = float(phases.force[-1, :, e] @ powers)
    deflection = float(phases.deflection[-1, :, e] @ powers)
    if network.law[e] == Law.RESTRAINT:
        return _stored_in_restraint(network, phases, e, deflection)
    law, stiffness = network.law[e], float(network.stiffness[e, 0])
    if law in {Law.LINEAR, Law.KELVIN_VOIGT, Law.THRESHOLD}:
        stretch = deflection - float(network.slack[e, 0])
        return 0.5 * stiffness * stretch**2 if law == Law.LINEAR or stretch > 0.0 else 0.0
    if deflection <= 0.0:
        return 0.0
    if law == Law.PLASTIC:
        given_back = min(force / stiffness, deflection)  # down the unloading line, as far as the member pushes
        return force * given_back - 0.5 * stiffness * given_back**2 if force > 0.0 else 0.0
    return _under_curve(network, e, deflection)[0]


def _stored_in_restraint(network: Network, phases: Phases, e: int, deflection: float) -> float:
    """What a restraint could give back at the end, with its reel where it is and its bag as full as it is."""
    elongation = deflection - float(network.slack[e, 0]) + float(phases.reel[e])
    if elongation <= 0.0:
        return 0.0
    energy, force = _under_curve(network, e, elongation)
    line = float(network.stiffness[e, 0])
    if line > 0.0:
        force = max(min(force, line * (elongation - float(phases.set[e]))), 0.0)
        given_back = min(force / line, elongation)
        energy = force * given_back - 0.5 * line * given_back**2
    return fill_at(network, e, phases.end) * energy


def fill_at(network: Network, e: int, time: float) -> float:
    """How full the bag of restraint e is at a time [s], 0 to 1; 1 for what is no bag."""
    if not network.empty[e]:
        return 1.0
    own = [t for t in np.flatnonzero(network.timer_element == e) if network.timer_action[t] == Action.FILL]
    starts = sorted((float(network.timer_time[t, 0]), float(network.timer_value[t, 0])) for t in own)
    ends = [start for start, _ in starts[1:]] + [np.inf]
    return sum(rate * max(min(time, end) - start, 0.0) for (start, rate), end in zip(starts, ends, strict=True))


def _under_curve(network: Network, e: int, deflection: float) -> tuple[float, float]:
    """Energy under the curve of element e up to a deflection > 0, and the force there."""
    pieces = range(network.piece_start[e], network.piece_start[e + 1])
    knots = [float(network.knot[p, 0]) for p in pieces]
    total = force = 0.0
    for p, start, stop in zip(pieces, knots, [*knots[1:], np.inf], strict=True):
        width = min(deflection, stop) - start
        if width > 0.0:
            force = float(network.force[p, 0]) + float(network.slope[p, 0]) * width
            total += 0.5 * width * (float(network.force[p, 0]) + force)
    return total, force


def momentum_balance(network: Network, phases: Phases, rate: Floats, direction: dict[str, float]) -> MomentumBalance:
    """The momentum balance; `direction` gives +1 or -1 for each body that hangs on the ground, by name."""
    sign = np.zeros(len(network.coordinates))
    for i, is_rotation in enumerate(network.is_rotation):
        if not is_rotation:
            sign[i] = direction[network.coordinates[network.chain(i)[-1]]]
    weight = sign * network.inertia[:, 0]
    chains = [network.chain(i) for i in range(len(network.coordinates))]
    start = np.array([network.rate[chain, 0].sum() for chain in chains])
    end = np.array([rate[chain].sum() for chain in chains])

    external = left_out = 0.0
    for e in range(len(network.elements)):
        impulse = phases.integral(phases.series(Channel("", "N", ((Family.FORCE, e, 1.0),))))
        reactions = range(network.reaction_start[e], network.reaction_start[e + 1])
        net = -impulse * sum(network.reaction_sign[r] * sign[network.reaction_coordinate[r]] for r in reactions)
        if _reaches_ground(network, e):
            external += net
        else:
            left_out += net
    initial, final = float(weight @ start), float(weight @ end)
    scale = float(np.abs(weight * start).sum())
    residual = (initial + external + left_out - final) / scale if scale > 0.0 else 0.0
    return MomentumBalance(initial, final, float(external), float(left_out), float(residual))


def _reaches_ground(network: Network, e: int) -> bool:
    """Whether an element's other end is the ground: its deflection is the absolute displacement of one body."""
    terms = slice(int(network.term_start[e]), int(network.term_start[e + 1]))
    coordinates = network.term_coordinate[terms]
    return len(coordinates) >= 1 and set(network.chain(int(coordinates.max()))) == set(coordinates.tolist())
