"""Channels: the quantities of a network by name, as sums of terms that the solver knows.

<body>.displacement | velocity | acceleration                absolute, along the body's own forward direction
<body>.relative_displacement | relative_velocity             to the body it hangs on (a child to its seat)
<body>.excursion | excursion_velocity                        to the vehicle it hangs on in the end
<bar> | <bar>_rate                                           rotation of a bar and its rate
<element>.force | deflection | deflection_rate
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache

from ridedown.errors import UnknownName
from ridedown.network.model import Network


class Family(IntEnum):
    """What a term reads: coordinate or element `index`, and which of its series."""

    POSITION = 0
    RATE = 1
    ACCELERATION = 2  # absolute, of a body
    DEFLECTION = 3
    DEFLECTION_RATE = 4
    FORCE = 5


Term = tuple[Family, int, float]
"""Family, index, weight."""


@dataclass(frozen=True, slots=True)
class Channel:
    """A named quantity: `constant + sum of weight * series` over its terms."""

    name: str
    unit: str
    terms: tuple[Term, ...]
    constant: float = 0.0


_ABSOLUTE = {
    "displacement": (Family.POSITION, "m"),
    "velocity": (Family.RATE, "m/s"),
    "acceleration": (Family.ACCELERATION, "m/s2"),
}
_RELATIVE = {"relative_displacement": (Family.POSITION, "m"), "relative_velocity": (Family.RATE, "m/s")}
_EXCURSION = {"excursion": (Family.POSITION, "m"), "excursion_velocity": (Family.RATE, "m/s")}
_ELEMENT = {
    "force": (Family.FORCE, "N"),
    "deflection": (Family.DEFLECTION, "m"),
    "deflection_rate": (Family.DEFLECTION_RATE, "m/s"),
}


def channels(network: Network) -> dict[str, Channel]:
    """Every channel of a network, by name."""
    chains = tuple(tuple(network.chain(i)) for i in range(len(network.coordinates)))
    return dict(_channels_of(network.coordinates, chains, tuple(network.is_rotation.tolist()), network.elements))


@lru_cache(64)
def _channels_of(
    coordinates: tuple[str, ...], chains: tuple[tuple[int, ...], ...], is_rotation: tuple[bool, ...], elements: tuple[str, ...]
) -> dict[str, Channel]:
    """The channels of every network of one structure, whose crashes are many."""
    found: list[Channel] = []
    for i, (body, chain) in enumerate(zip(coordinates, chains, strict=True)):
        if is_rotation[i]:
            found.append(Channel(body, "rad", ((Family.POSITION, i, 1.0),)))
            found.append(Channel(f"{body}_rate", "rad/s", ((Family.RATE, i, 1.0),)))
            continue
        links = [(_ABSOLUTE, chain)]
        if len(chain) > 1:
            links += [(_RELATIVE, chain[:1]), (_EXCURSION, chain[:-1])]
        for quantities, added_up in links:
            for quantity, (family, unit) in quantities.items():
                # an acceleration is absolute already; displacements and velocities add up along the chain
                added = (i,) if family == Family.ACCELERATION else added_up
                found.append(Channel(f"{body}.{quantity}", unit, tuple((family, link, 1.0) for link in added)))
    for e, element in enumerate(elements):
        for quantity, (family, unit) in _ELEMENT.items():
            found.append(Channel(f"{element}.{quantity}", unit, ((family, e, 1.0),)))
    return {channel.name: channel for channel in found}


def find(known: dict[str, Channel], name: str) -> Channel:
    """The channel of that name. Raises: UnknownName, with the nearest."""
    if name not in known:
        raise UnknownName.among("channel", name, known)
    return known[name]
