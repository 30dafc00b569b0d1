"""The events of a crash in words: who, what, when."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from ridedown.network import Law, Network
from ridedown.restraint_events import mode_event, timer_event
from ridedown.solver import laws
from ridedown.solver.phases import Phases

_TIMER = -1  # the mode before, of what a timer did; the mode after is the timer's number
_INSTANT = 1e-12  # s: changes no further apart are one event


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
    changes: list[tuple[float, int, int, int]] = []
    for time, e, before, after in zip(
        phases.event_time, phases.event_element, phases.event_before, phases.event_after, strict=True
    ):
        same = None if before == _TIMER else _same_instant(changes, float(time), int(e))
        if same is None:
            changes.append((float(time), int(e), int(before), int(after)))
        else:
            changes[same] = (changes[same][0], int(e), changes[same][2], int(after))
    found = []
    for time, e, before, after in changes:
        name = network.elements[e]
        if before == _TIMER:
            what = timer_event(network, after)
        elif network.law[e] == Law.RESTRAINT:
            what = mode_event(network, phases, e, time, before, after, belt=name in belts) if before != after else ""
        else:
            what = _what(network, e, before, after) if before != after else ""
        if what:
            found.append(Event(time, name, what))
    return tuple(found)


def _same_instant(changes: list[tuple[float, int, int, int]], time: float, element: int) -> int | None:
    """Where an element's change at this instant stands in the list, if there is one."""
    for k in range(len(changes) - 1, -1, -1):
        if time - changes[k][0] > _INSTANT:
            return None
        if changes[k][1] == element and changes[k][2] != _TIMER:
            return k
    return None


def _what(network: Network, e: int, before: int, after: int) -> str:
    law = network.law[e]
    if law in {Law.ELASTIC, Law.PLASTIC}:
        return _curve_event(int(network.piece_start[e + 1] - network.piece_start[e]), before, after)
    if before == laws.OPEN:
        return "slack taken up"
    if after == laws.OPEN:
        return "slack again"
    if law == Law.THRESHOLD:
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
