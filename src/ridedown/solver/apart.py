"""Occupants solved apart from their vehicles: where they do not push back, and only they differ, the vehicles are solved once.

In a table of crashes in which restraints vary, every row has the same vehicles' motion. It is solved for once; each row then
is the occupants alone, in vehicles driven by that motion, which is polynomials already. Nothing is lost: the rows differ from
those solved whole by round-off and the truncation of a step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.network import Family, Network
from ridedown.network.model import NUMBERS, Floats, Ints
from ridedown.solver.phases import Phases
from ridedown.solver.workspace import Tracked

_OF_MOTION = (Family.POSITION, Family.RATE, Family.ACCELERATION)
_OF_COORDINATE = ("inertia", "rate")
_OF_ELEMENTS = ("arm", "stiffness", "damping", "slack", "limit", "payout", "stall")
_OF_PIECES = ("knot", "force", "slope")


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part of a network: its coordinates, elements and tracked quantities, by their numbers in the whole."""

    coordinates: Ints
    elements: Ints
    quantities: Ints


@dataclass(frozen=True, slots=True, eq=False)
class Apart:
    """The vehicles of a network, and the occupants of each that has some: that vehicle's coordinate comes first."""

    vehicles: Part
    occupants: tuple[Part, ...]


def apart(network: Network, tracked: Tracked) -> Apart | None:
    """How to solve the vehicles once and the occupants for themselves; None where that cannot be, or gains nothing."""
    if network.driven >= 0:
        return None
    heavy = _moved_together(network)
    riders = np.flatnonzero(~heavy)
    if not riders.size:
        return None
    carrier = np.array([next((link for link in network.chain(i) if heavy[link]), -1) for i in range(heavy.size)])
    if (network.parent[carrier[riders]] >= 0).any():
        return None
    of_element = np.array([_carrier_of(network, e, heavy, carrier) for e in range(len(network.elements))], dtype=np.int64)
    of_quantity = np.array(
        [_group_of(tracked, k, heavy, carrier, of_element) for k in range(tracked.sense.size)], dtype=np.int64
    )
    if (of_element == _MIXED).any() or (of_quantity == _MIXED).any():
        return None
    vehicles = Part(np.flatnonzero(heavy), np.flatnonzero(of_element == _VEHICLES), np.flatnonzero(of_quantity == _VEHICLES))
    if not _same_in_all_rows(network, vehicles):
        return None
    return Apart(
        vehicles,
        tuple(
            Part(
                np.concatenate(([c], riders[carrier[riders] == c])),
                np.flatnonzero(of_element == c),
                np.flatnonzero(of_quantity == c),
            )
            for c in np.unique(carrier[riders])
        ),
    )


_VEHICLES, _MIXED = -1, -2


def _moved_together(network: Network) -> NDArray[np.bool_]:
    """The coordinates that hang on the ground, and all those on whose motion theirs depends."""
    heavy = network.parent < 0
    while True:
        before = heavy.copy()
        for e in range(len(network.elements)):
            acts_on = network.reaction_coordinate[network.reaction_start[e] : network.reaction_start[e + 1]]
            if network.lever[e] >= 0 or heavy[acts_on].any():
                heavy[network.term_coordinate[network.term_start[e] : network.term_start[e + 1]]] = True
        for i in np.flatnonzero(heavy):
            heavy[network.chain(int(i))] = True
        if (heavy == before).all():
            return heavy


def _carrier_of(network: Network, e: int, heavy: NDArray[np.bool_], carrier: Ints) -> int:
    """The vehicle whose occupants an element holds, or that it belongs to the vehicles."""
    terms = network.term_coordinate[network.term_start[e] : network.term_start[e + 1]]
    if heavy[terms].all():
        return _VEHICLES
    found = set(carrier[terms].tolist())
    return _MIXED if heavy[terms].any() or len(found) > 1 else int(found.pop())


def _group_of(tracked: Tracked, k: int, heavy: NDArray[np.bool_], carrier: Ints, of_element: Ints) -> int:
    """The group that knows all terms of a tracked quantity; a vehicle's own motion is known to its occupants too."""
    groups, vehicles = set(), set()
    for n in range(tracked.start[k], tracked.start[k + 1]):
        index = int(tracked.item[n])
        if tracked.family[n] not in _OF_MOTION:
            groups.add(int(of_element[index]))
        elif heavy[index]:
            vehicles.add(index)
        else:
            groups.add(int(carrier[index]))
    if not groups:
        return _VEHICLES
    if len(groups) > 1 or (groups != {_VEHICLES} and vehicles - groups):
        return _MIXED
    return groups.pop()


def _same_in_all_rows(network: Network, part: Part) -> bool:
    """Whether the columns of a part hold one number each; where they do not, the first two rows tell most often."""
    tables = [(getattr(network, name), part.coordinates) for name in _OF_COORDINATE]
    tables += [(getattr(network, name), part.elements) for name in _OF_ELEMENTS]
    tables += [(getattr(network, name), _pieces(network, part.elements)) for name in _OF_PIECES]
    tables += [(network.duration[np.newaxis], np.zeros(1, dtype=np.int64))]
    return all(_same(table, rows, end) for end in (2, network.size) for table, rows in tables)


def _same(table: Floats, rows: Ints, end: int) -> bool:
    if table.strides[-1] == 0:  # a number that stands for all columns
        return True
    part = table[..., rows, :end]
    return bool((part == part[..., :1]).all())


def _pieces(network: Network, elements: Ints) -> Ints:
    ranges = [np.arange(network.piece_start[e], network.piece_start[e + 1]) for e in elements]
    return np.concatenate([np.zeros(0, dtype=np.int64), *ranges])


def network_of(network: Network, part: Part, phases: Phases | None = None) -> Network:
    """A part as a network of its own: the vehicles in a single row, or, on their phases, the occupants of one in all rows."""
    place, of_element = _places(len(network.coordinates), part.coordinates), _places(len(network.elements), part.elements)
    pieces = _pieces(network, part.elements)
    timers = np.flatnonzero(np.isin(network.timer_element, part.elements))
    terms, reactions = (_rows(start, part.elements) for start in (network.term_start, network.reaction_start))
    size = network.size if phases else 1
    numbers: dict[str, Any] = {name: _part_of(getattr(network, name), part.elements, size) for name in _OF_ELEMENTS}
    numbers |= {name: _part_of(getattr(network, name), pieces, size) for name in _OF_PIECES}
    numbers |= {name: _part_of(getattr(network, name), part.coordinates, size) for name in _OF_COORDINATE}
    numbers |= {name: _part_of(getattr(network, name), timers, size) for name in ("timer_time", "timer_value")}
    numbers |= {name: getattr(network, name)[:size] for name in ("pulse_amplitude", "pulse_length", "duration")}
    assert set(numbers) == set(NUMBERS)
    smaller = replace(
        network,
        coordinates=tuple(network.coordinates[i] for i in part.coordinates),
        parent=place[network.parent[part.coordinates]],
        is_rotation=network.is_rotation[part.coordinates],
        elements=tuple(network.elements[e] for e in part.elements),
        law=network.law[part.elements],
        term_start=_starts(network.term_start, part.elements),
        term_coordinate=place[network.term_coordinate[terms]],
        term_sign=network.term_sign[terms],
        lever=place[network.lever[part.elements]],
        reaction_start=_starts(network.reaction_start, part.elements),
        reaction_coordinate=place[network.reaction_coordinate[reactions]],
        reaction_sign=network.reaction_sign[reactions],
        piece_start=_starts(network.piece_start, part.elements),
        free=network.free[part.elements],
        empty=network.empty[part.elements],
        timer_element=of_element[network.timer_element[timers]],
        timer_action=network.timer_action[timers],
        **numbers,
    )
    return smaller if phases is None else _driven(smaller, network, part, phases)


def _part_of(table: Floats, rows: Ints, size: int) -> Floats:
    """Those rows of a table, of so many columns."""
    if table.strides[-1] != 0:
        return table[..., rows, :size]
    part = table[..., rows, :1]
    return np.broadcast_to(part, (*part.shape[:-1], size))


def _driven(smaller: Network, network: Network, part: Part, phases: Phases) -> Network:
    """The occupants' vehicle, first of their coordinates, follows the acceleration that was solved for."""
    vehicle = int(_moved_together(network)[: part.coordinates[0]].sum())
    orders = np.arange(2, phases.position.shape[1])
    series = phases.position[:, 2:, vehicle] * (orders * (orders - 1))
    inertia = smaller.inertia.copy()
    inertia[0] = 0.0
    one = np.ones(smaller.size)
    return replace(
        smaller, driven=0, pulse_start=phases.start, pulse_series=series, pulse_amplitude=one, pulse_length=one, inertia=inertia
    )


def _rows(start: Ints, elements: Ints) -> Ints:
    ranges = [np.arange(start[e], start[e + 1]) for e in elements]
    return np.concatenate([np.zeros(0, dtype=np.int64), *ranges])


def _starts(start: Ints, elements: Ints) -> Ints:
    return np.cumsum([0, *(start[e + 1] - start[e] for e in elements)], dtype=np.int64)


def tracked_of(network: Network, tracked: Tracked, part: Part) -> Tracked:
    """The quantities that a part knows, in its own numbers."""
    kept = _rows(tracked.start, part.quantities)
    size = max(len(network.coordinates), len(network.elements))
    coordinate, element = (_places(size, numbers) for numbers in (part.coordinates, part.elements))
    return Tracked(
        start=_starts(tracked.start, part.quantities),
        family=tracked.family[kept],
        item=np.where(np.isin(tracked.family[kept], _OF_MOTION), coordinate[tracked.item[kept]], element[tracked.item[kept]]),
        weight=tracked.weight[kept],
        sense=tracked.sense[part.quantities],
        sample_time=tracked.sample_time,
    )


def _places(size: int, numbers: Ints) -> Ints:
    """Where each of the whole's numbers stands in a part, -1 where it is not in it; one more, -1, for "none"."""
    place = np.full(size + 1, -1, dtype=np.int64)
    place[numbers] = np.arange(numbers.size)
    return place
