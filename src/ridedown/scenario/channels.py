"""Channels that belong to an occupant as a whole: what all its restraints do together, and how its bodies move on the mean."""

from __future__ import annotations

from collections.abc import Iterable

from ridedown.network import Channel, Family, Network, channels
from ridedown.network.channels import Term
from ridedown.scenario.occupant import Occupant
from ridedown.scenario.restraints import Contact


def total_forces(occupants: Iterable[Occupant], network: Network) -> dict[str, Channel]:
    """`<occupant>.restraint.force` and `<occupant>.seat.restraint.force` [N], where there are several restraints.

    The sum of their forces, positive where it holds the occupant back; a seat back pushes the other way.
    """
    found = {}
    for occupant in occupants:
        held = [(occupant.name, occupant.restraints)]
        if occupant.seat is not None:
            held.append((f"{occupant.name}.seat", occupant.seat.restraints))
        for name, restraints in held:
            terms: tuple[Term, ...] = tuple(
                (
                    Family.FORCE,
                    network.elements.index(f"{name}.{one.name}"),
                    one.direction if isinstance(one, Contact) else 1.0,
                )
                for one in restraints
            )
            if terms:
                found[f"{name}.restraint.force"] = Channel(f"{name}.restraint.force", "N", terms)
    return found


def centre_of_mass(occupants: Iterable[Occupant], network: Network) -> dict[str, Channel]:
    """`<occupant>.acceleration`, `.excursion` and all other motions of the centre of mass of an occupant of several bodies."""
    known = channels(network)
    found = {}
    for occupant in occupants:
        if not occupant.bodies:
            continue
        first, whole = occupant.mass_names[0], float(occupant.whole_mass)
        for quantity in [name.removeprefix(f"{first}.") for name in known if name.startswith(f"{first}.")]:
            name = f"{occupant.name}.{quantity}"
            parts = [
                (known[f"{own}.{quantity}"], float(body.mass) / whole)
                for own, body in zip(occupant.mass_names, occupant.bodies, strict=True)
            ]
            terms = tuple((family, i, share * weight) for part, share in parts for family, i, weight in part.terms)
            found[name] = Channel(name, parts[0][0].unit, terms)
    return found
