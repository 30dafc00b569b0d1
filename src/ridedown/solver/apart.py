"""What is the same in every row solved once: vehicles whose occupants do not push back, and the occupants that do not differ.

In a table of crashes in which some restraints vary, every row has the same vehicles' motion, and whoever else sits in them
fares the same. These are solved for once; each row then is the other occupants alone, in vehicles driven by that motion, which
is polynomials already. Nothing is lost: the rows differ from those solved whole by round-off and the truncation of a step.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.network import Family, Network
from ridedown.network.model import NUMBERS, Floats, Ints
from ridedown.solver.merge import merged
from ridedown.solver.phases import Phases
from ridedown.solver.workspace import Tracked

_OF_MOTION = (Family.POSITION, Family.RATE, Family.ACCELERATION)
_OF_COORDINATE = ("inertia", "rate")
_OF_ELEMENTS = ("arm", "stiffness", "damping", "slack", "limit", "payout", "stall")
_OF_PIECES = ("knot", "force", "slope")
_OF_TIMERS = ("timer_time", "timer_value")


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A part of a network: its coordinates, elements and tracked quantities, by their numbers in the whole."""

    coordinates: Ints
    elements: Ints
    quantities: Ints


@dataclass(frozen=True, slots=True, eq=False)
class Apart:
    """How a network comes apart.

    vehicles: what moves whoever sits in it; alike: the same, with the occupants that are the same in every row; occupants: the
    others, by the vehicle that carries them, whose coordinate comes first.
    """

    vehicles: Part
    alike: Part
    occupants: tuple[Part, ...]


_ALIKE, _MIXED = -1, -2


def apart(network: Network, tracked: Tracked) -> Apart | None:
    """What to solve once, and which occupants in every row; None where that cannot be, or gains nothing."""
    if network.driven >= 0:
        return None
    heavy = _moved_together(network)
    carrier = np.array([next((link for link in network.chain(i) if heavy[link]), -1) for i in range(heavy.size)])
    tied = any(heavy[_terms(network, e)].any() != heavy[_terms(network, e)].all() for e in range(len(network.elements)))
    if tied or heavy.all() or (network.parent[carrier[~heavy]] >= 0).any():
        return None
    vehicles = _part_for(network, heavy)
    if not _same_in_all_rows(network, vehicles):
        return None
    alike = heavy | _alike(network, heavy)
    parts = _parts(network, tracked, vehicles, alike, carrier)
    if parts is None and (alike != heavy).any():  # a quantity is of two occupants, of whom one differs
        parts = _parts(network, tracked, vehicles, heavy, carrier)
    return parts


def _parts(network: Network, tracked: Tracked, vehicles: Part, alike: NDArray[np.bool_], carrier: Ints) -> Apart | None:
    """The parts, where those coordinates are the same in every row; None where an element or a quantity is of two of them."""
    group = np.where(alike, _ALIKE, carrier)
    of_element = np.array([_group_of_element(network, e, group) for e in range(len(network.elements))], dtype=np.int64)
    of_quantity = np.array(
        [_group_of_quantity(tracked, k, vehicles, group, of_element) for k in range(tracked.sense.size)], dtype=np.int64
    )
    if (of_element == _MIXED).any() or (of_quantity == _MIXED).any():
        return None
    return Apart(
        vehicles,
        Part(np.flatnonzero(alike), np.flatnonzero(of_element == _ALIKE), np.flatnonzero(of_quantity == _ALIKE)),
        tuple(
            Part(
                np.concatenate(([c], np.flatnonzero(group == c))),
                np.flatnonzero(of_element == c),
                np.flatnonzero(of_quantity == c),
            )
            for c in np.unique(group[group != _ALIKE])
        ),
    )


def _moved_together(network: Network) -> NDArray[np.bool_]:
    """The coordinates that hang on the ground, and all those on whose motion theirs depends."""
    heavy = network.parent < 0
    while True:
        before = heavy.copy()
        for e in range(len(network.elements)):
            acts_on = network.reaction_coordinate[network.reaction_start[e] : network.reaction_start[e + 1]]
            if network.lever[e] >= 0 or heavy[acts_on].any():
                heavy[_terms(network, e)] = True
        for i in np.flatnonzero(heavy):
            heavy[network.chain(int(i))] = True
        if (heavy == before).all():
            return heavy


def _alike(network: Network, heavy: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The coordinates of occupants that are the same in every row, with all that they depend on."""
    found = np.zeros_like(heavy)
    left = ~heavy
    while left.any():
        one = np.zeros_like(heavy)
        one[np.flatnonzero(left)[0]] = True
        _join(network, one, ~heavy)
        left &= ~one
        if _same_in_all_rows(network, _part_for(network, one)):
            found |= one
    return found


def _join(network: Network, one: NDArray[np.bool_], within: NDArray[np.bool_]) -> None:
    """Add to some coordinates those within others that an element or their parents tie to them."""
    links = [_terms(network, e) for e in range(len(network.elements))]
    links += [np.array(network.chain(int(i)), dtype=np.int64) for i in np.flatnonzero(within)]
    while True:
        before = one.copy()
        for link in links:
            own = link[within[link]]
            if one[own].any():
                one[own] = True
        if (one == before).all():
            return


def _terms(network: Network, e: int) -> Ints:
    """The coordinates on which an element's deflection depends."""
    return network.term_coordinate[network.term_start[e] : network.term_start[e + 1]]


def _part_for(network: Network, coordinates: NDArray[np.bool_]) -> Part:
    """Those coordinates with the elements that depend on nothing else, and no quantities."""
    elements = [e for e in range(len(network.elements)) if coordinates[_terms(network, e)].all()]
    return Part(np.flatnonzero(coordinates), np.array(elements, dtype=np.int64), np.zeros(0, dtype=np.int64))


def _group_of_element(network: Network, e: int, group: Ints) -> int:
    """What an element belongs to: the vehicle whose occupants it holds, or what is alike in every row."""
    found = set(group[_terms(network, e)].tolist())
    return found.pop() if len(found) == 1 else _MIXED


def _group_of_quantity(tracked: Tracked, k: int, vehicles: Part, group: Ints, of_element: Ints) -> int:
    """The group that knows all terms of a tracked quantity; a vehicle's own motion is known to its occupants too."""
    groups, carriers = set(), set()
    for n in range(tracked.start[k], tracked.start[k + 1]):
        index = int(tracked.item[n])
        if tracked.family[n] not in _OF_MOTION:
            groups.add(int(of_element[index]))
        elif index in vehicles.coordinates:
            carriers.add(index)
        else:
            groups.add(int(group[index]))
    if not groups:
        return _ALIKE
    if len(groups) > 1 or (groups != {_ALIKE} and carriers - groups):
        return _MIXED
    return groups.pop()


def _same_in_all_rows(network: Network, part: Part) -> bool:
    """Whether the columns of a part hold one number each; where they do not, the first two rows tell most often."""
    tables = [(getattr(network, name), part.coordinates) for name in _OF_COORDINATE]
    tables += [(getattr(network, name), part.elements) for name in _OF_ELEMENTS]
    tables += [(getattr(network, name), _pieces(network, part.elements)) for name in _OF_PIECES]
    tables += [(getattr(network, name), _timers(network, part.elements)) for name in _OF_TIMERS]
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


def _timers(network: Network, elements: Ints) -> Ints:
    return np.flatnonzero(np.isin(network.timer_element, elements))


def alike_of(network: Network, parts: Apart) -> Network:
    """What is alike in every row, as a network of its own, of a single row."""
    return _network_of(network, parts.alike, 1)


def occupants_of(network: Network, parts: Apart, part: Part, phases: Phases) -> Network:
    """Occupants in all rows, as a network of its own.

    Their vehicle, the first of its coordinates, follows the acceleration that it has in the phases of what is alike.
    """
    smaller = _network_of(network, part, network.size)
    vehicle = np.searchsorted(parts.alike.coordinates, part.coordinates[0])
    orders = np.arange(2, phases.position.shape[1])
    of_vehicles = np.isin(parts.alike.elements[phases.event_element], parts.vehicles.elements)
    start, end, series = merged(
        phases, phases.position[:, 2:, vehicle] * (orders * (orders - 1)), phases.event_time[of_vehicles]
    )
    inertia = smaller.inertia.copy()
    inertia[0] = 0.0
    one = np.ones(smaller.size)
    return replace(
        smaller,
        driven=0,
        pulse_start=start,
        pulse_end=end,
        pulse_series=series,
        pulse_amplitude=one,
        pulse_length=one,
        inertia=inertia,
    )


def _network_of(network: Network, part: Part, size: int) -> Network:
    """A part of a network, with so many of its rows."""
    place, of_element = _places(len(network.coordinates), part.coordinates), _places(len(network.elements), part.elements)
    pieces = _pieces(network, part.elements)
    timers = _timers(network, part.elements)
    terms, reactions = (_rows(start, part.elements) for start in (network.term_start, network.reaction_start))
    numbers: dict[str, Any] = {name: _part_of(getattr(network, name), part.elements, size) for name in _OF_ELEMENTS}
    numbers |= {name: _part_of(getattr(network, name), pieces, size) for name in _OF_PIECES}
    numbers |= {name: _part_of(getattr(network, name), part.coordinates, size) for name in _OF_COORDINATE}
    numbers |= {name: _part_of(getattr(network, name), timers, size) for name in _OF_TIMERS}
    numbers |= {name: getattr(network, name)[:size] for name in ("pulse_amplitude", "pulse_length", "duration")}
    assert set(numbers) == set(NUMBERS)
    return replace(
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


def _part_of(table: Floats, rows: Ints, size: int) -> Floats:
    """Those rows of a table, of so many columns."""
    if table.strides[-1] != 0:
        return table[..., rows, :size]
    part = table[..., rows, :1]
    return np.broadcast_to(part, (*part.shape[:-1], size))


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
