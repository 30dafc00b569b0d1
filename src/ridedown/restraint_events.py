"""What happens to a restraint on a reel, a bag or a padded surface, in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ridedown.network import Action, Network
from ridedown.solver.phases import Phases
from ridedown.solver.reel import CLIPPED, FREE, HELD_1, HELD_2, OPEN, SLIPPING_1, SLIPPING_2, UNLOADING

INSTANT = 1e-12
"""Changes no further apart [s] are one event."""

_HELD = {HELD_1: 0, HELD_2: 1}
_SLIPPING = {SLIPPING_1: 0, SLIPPING_2: 1}


def timer_event(network: Network, timer: int) -> str:
    """What a timer does."""
    action, value = Action(int(network.timer_action[timer])), float(network.timer_value[timer, 0])
    if action == Action.LOCK:
        return "retractor locks"
    if action == Action.STAGE_2:
        return f"load limiter goes on to stage 2, {_kn(network.limit[1, network.timer_element[timer], 0])}"
    if action == Action.FILL:
        return "bag fires" if value > 0.0 else "bag full"
    return f"pretensioner {1 + action - Action.PULL_1} {'fires' if value > 0.0 else 'has ended'}"


def mode_event(network: Network, phases: Phases, e: int, time: float, modes: Sequence[int], *, belt: bool) -> str:
    """What it means that restraint e went through these modes at one instant, empty where it says nothing.

    `belt`: it pulls, where others are pressed.
    """
    pieces = int(network.piece_start[e + 1] - network.piece_start[e])
    after_pieces = [mode - pieces for mode in modes]
    was, now = after_pieces[0], after_pieces[-1]
    gives = list(dict.fromkeys(mode for mode in after_pieces[1:] if mode in _HELD))
    if gives and was not in _HELD:
        # also where a pretensioner holds its force for no time at all: the occupant pulls harder still, or gives way to it
        return _stall(network, e, gives) if _rose(phases, e, time) else _pull_on(gives)
    if was == now:
        return ""
    if now in _SLIPPING or now in _HELD:
        return _gives(network, e, now)
    if (was in _SLIPPING or was in _HELD) and modes[-1] != OPEN:
        return _holds(network, e, was, rising=_rises(phases, e, time))
    return _along_curve(modes[0], modes[-1], pieces, belt=belt)


def _along_curve(before: int, after: int, pieces: int, *, belt: bool) -> str:
    """A change that leaves the reel as it is."""
    was, now = before - pieces, after - pieces
    closes = before == OPEN or was == FREE
    if after == OPEN:
        what = "" if was == FREE else "slack again" if belt else "contact lost"
    elif now == CLIPPED:
        what = f"damping outweighs the spring: no {'pull' if belt else 'push'}"
    elif was == CLIPPED:
        what = "pulls again" if belt else "pushes again"
    elif closes:
        what = "slack taken up" if belt else "contact"
        what += " again, on its unloading line" if now == UNLOADING else ""
    elif UNLOADING in {now, was}:
        what = "starts to unload" if now == UNLOADING else "loads on"
    else:
        what = f"on to piece {after}" if after > before else f"back to piece {after}"
    return what


def _stall(network: Network, e: int, held: Sequence[int]) -> str:
    """Pretensioners stall, of one stall force if both do at one instant."""
    force = _kn(network.stall[_HELD[held[0]], e, 0])
    return f"pretensioner {_HELD[held[0]] + 1} stalls at {force}" if len(held) == 1 else f"both pretensioners stall at {force}"


def _pull_on(held: Sequence[int]) -> str:
    """Pretensioners that were stalled pull again."""
    return f"pretensioner {_HELD[held[0]] + 1} pulls on" if len(held) == 1 else "both pretensioners pull on"


def _gives(network: Network, e: int, mode: int) -> str:
    """The reel gives way: a pretensioner stalls, or the limiter slips."""
    if mode in _HELD:
        return _stall(network, e, [mode])
    stage = _SLIPPING[mode]
    force = _kn(network.limit[stage, e, 0])
    return f"load limiter, stage {stage + 1}, {force}" if _two_stages(network, e) else f"load limiter, {force}"


def _holds(network: Network, e: int, mode: int, *, rising: bool) -> str:
    """The reel gives no more: the occupant slows down and the force falls, or it cannot and the force rises."""
    if mode in _HELD:
        return f"belt holds against pretensioner {_HELD[mode] + 1}" if rising else _pull_on([mode])
    if not rising:
        return "load limiter holds"
    stage = _SLIPPING[mode]
    out = f"{1e3 * float(network.payout[stage, e, 0]):.0f} mm let out"
    last = stage == 1 or not _two_stages(network, e) or network.payout[0, e, 0] == network.payout[1, e, 0]
    return f"load limiter stops hard, {out}" if last else f"load limiter, end of stage 1, {out}"


def _two_stages(network: Network, e: int) -> bool:
    return bool(network.limit[1, e, 0] < 1e300)


def _rises(phases: Phases, e: int, time: float) -> bool:
    """Whether the force of restraint e rises just after a time: over the first microsecond, for at its top its rate is zero."""
    phase = max(int(phases.start.searchsorted(time, side="right")) - 1, 0)
    since = min(1e-6, float(phases.length[phase]))
    powers = since ** np.arange(1, phases.force.shape[1])
    return bool(phases.force[phase, 1:, e] @ powers > 0.0)


def _rose(phases: Phases, e: int, time: float) -> bool:
    """Whether the force of restraint e rose just before a time, over the last microsecond; from the start on, it did."""
    phase = int(phases.start.searchsorted(time - INSTANT)) - 1
    if phase < 0:
        return True
    end = float(phases.length[phase])
    ends = np.vander([end, max(end - 1e-6, 0.0)], phases.force.shape[1], increasing=True)
    here, before = ends @ phases.force[phase, :, e]
    return bool(here > before)


def _kn(force: float) -> str:
    return f"{1e-3 * float(force):.1f} kN"
