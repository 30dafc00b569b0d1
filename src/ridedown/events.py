"""The events of a crash in words: who, what, when."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

from ridedown.network import Law, Network
from ridedown.restraint_events import INSTANT, mode_event, timer_event
from ridedown.solver import laws
from ridedown.solver.phases import Phases

_TIMER = -1  # the mode before, of what a timer did; the mode after is the timer's number


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened at a time [s]: to which element, and what."""

    time: float
    who: str
    what: str


def events_of(network: Network, phases: Phases, *, belts: Collection[str] = ()) -> tuple[Event, ...]:
    """The events of a solved crash, in order; `belts` names the elements that pull where others are pressed.

    Several changes of one element at one instant are one event: a belt that slips from taut through clipped to slack has gone
    slack. What a timer does is an event of its own.
    """
    changes: list[_Change] = []
    logged = (phases.event_time, phases.event_element, phases.event_before, phases.event_after)
    for time, e, before, after in zip(*(column.tolist() for column in logged), strict=True):
        same = None if before == _TIMER else _same_instant(changes, time, e)
        if same is None:
            changes.append(_Change(time, e, [before, after]))
        else:
            same.modes.append(after)
    found = []
    law = [Law(number) for number in network.law.tolist()]
    for time, e, modes in changes:
        name, before, after = network.elements[e], modes[0], modes[-1]
        if before == _TIMER:
            what = timer_event(network, after)
        elif law[e] is Law.RESTRAINT:
            what = mode_event(network, phases, e, time, modes, belt=name in belts)
        else:
            what = _what(network, law[e], e, before, after) if before != after else ""
        if what:
            found.append(Event(time, name, what))
    return tuple(found)


class _Change(NamedTuple):
    """All that happened to one element at one instant: the modes it went through, from the first to the last."""

    time: float
    element: int
    modes: list[int]


def _same_instant(changes: list[_Change], time: float, element: int) -> _Change | None:
    """An element's change at this instant, if there is one."""
    for change in reversed(changes):
        if time - change.time > INSTANT:
            return None
        if change.element == element and change.modes[0] != _TIMER:
            return change
    return None


def _what(network: Network, law: Law, e: int, before: int, after: int) -> str:
    if law is Law.ELASTIC or law is Law.PLASTIC:
        return _curve_event(int(network.piece_start[e + 1] - network.piece_start[e]), before, after)
    if before == laws.OPEN:
        return "slack taken up"
    if after == laws.OPEN:
        return "slack again"
    if law is Law.THRESHOLD:
        return "damping ends" if after == laws.UNDAMPED else "damping sets in"
    return "damping outweighs the spring: no pull" if after == laws.CLIPPED else "pulls again"


def _curve_event(pieces: int, before: int, after: int) -> str:
    unloading = pieces + 1
    if after == laws.OPEN:
        return "contact lost"
    if after == unloading:
        return "contact again, on its unloading line" if before == laws.OPEN else "starts to unload"
    if before == laws.OPEN:
        return "contact"
    if before == unloading:
        return "crushes on"
    return f"on to piece {after}" if after > before else f"back to piece {after}"
