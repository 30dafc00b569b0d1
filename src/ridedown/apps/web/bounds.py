"""The least that any restraint could give, for every crash of a map: what physics leaves of it to gain.

Each crash has its own vehicle's pulse, and the bound within the excursion that its occupant uses, or within one room for all.
Where neither axis changes the pulse there is one pulse for the whole map. Else bounds are solved on a coarse grid of crashes
and drawn between them; what is said of the crash that is chosen is solved for itself.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from ridedown.apps.web.crash import Frame, finite
from ridedown.apps.web.maps import Floats, allowed_rows, axes, concerned, outcomes, solved
from ridedown.apps.web.requests import number
from ridedown.errors import InvalidInput, RidedownError
from ridedown.motion import motion_of
from ridedown.response import Response
from ridedown.scenario import Scenario, substitute
from ridedown.simulation import simulate
from ridedown.studies.bound import Limiting, gap_of

SIDE = 100
"""Crashes along each side of what is drawn."""

_NODES = (1, 9, 7)  # pulses along an axis that changes them: where none does, one, both
_EXCURSIONS = (17, 5, 1)  # at which the bound of each pulse is solved
_LONGEST = 5.0  # m
_NEAR_ZERO = 0.05


def bound_map(scenario: Scenario, message: Mapping[str, Any]) -> Frame:
    """The least peaks for the crashes of a map, `x` by `y`; `room` [m]: the excursion allowed, that of each crash if left out.

    Arrays: `x` (n,), `y` (n,); `least` (n, n) [m/s2] and `excursion` (n, n) [m], a row for each y, NaN where there is none.

    Raises: InvalidInput, UnknownName, naming the field.
    """
    outcome, body, room = _asked(scenario, message)
    (first, x), (second, y) = axes(scenario, message, SIDE)
    own = concerned(scenario, {outcome, first, second})
    table = {first: np.tile(x, SIDE), second: np.repeat(y, SIDE)}
    allowed, _ = allowed_rows(scenario, table)
    excursion = solved(own, table, allowed, f"{body}.excursion.max", threads=1).reshape(SIDE, SIDE)
    within = np.maximum(excursion, 0.0) if room is None else np.where(np.isfinite(excursion), room, np.nan)
    least = _least(own, body, ((first, x), (second, y)), within) if np.isfinite(within).any() else within
    arrays: dict[str, NDArray[Any]] = {"x": x, "y": y, "least": finite(least), "excursion": finite(excursion)}
    return {"kind": "bound", "body": body, "room": room}, arrays


def bound_here(scenario: Scenario, message: Mapping[str, Any]) -> dict[str, Any]:
    """The crash of the scenario beside its bound, SI: peak, excursion, the least peak `within` the room, or that excursion.

    `outcome`: the peak that a map shows, whichever way it points. `needs`: the least excursion for its peak. `rearward`: the
    room behind that it used, and the bound has. `holds`: whether it was where the proof needs it to be, so that its peak
    cannot be below the bound.

    Raises: InvalidInput, UnknownName, naming the field.
    """
    _, body, room = _asked(scenario, message)
    response = simulate(scenario, throw=False)
    found = gap_of(response, body)
    bound = found.bound if room is None else _limiting(response, body, found.design.rearward).bound(room)
    return {
        "kind": "bound-here",
        "body": body,
        "room": room,
        "outcome": abs(response.peak(f"{body}.acceleration").value),
        "peak": found.design.peak,
        "excursion": found.design.excursion,
        "rearward": found.design.rearward,
        "within": bound.excursion,
        "least": bound.peak,
        "needs": found.least_excursion,
        "holds": found.holds,
    }


def _asked(scenario: Scenario, message: Mapping[str, Any]) -> tuple[str, str, float | None]:
    """Outcome, body and room of a request. Raises: InvalidInput where the outcome has no bound."""
    outcome = str(message.get("outcome"))[:200]
    body = next((one["bound"] for one in outcomes(scenario) if one["name"] == outcome), None)
    if body is None:
        raise InvalidInput(f"outcome: got {outcome}, which has no bound; need an occupant's peak acceleration. Choose one.")
    return outcome, body, None if message.get("room") is None else number(message, "room", 0.0, _LONGEST)


def _changes_pulse(scenario: Scenario, path: str) -> bool:
    """Whether a parameter has a part in the vehicles' motion: all have but those of occupants who push on nothing."""
    return not any(one.name == path.partition(".")[0] and not one.coupled for one in getattr(scenario, "occupants", ()))


def _least(scenario: Scenario, body: str, grid: tuple[tuple[str, Floats], tuple[str, Floats]], within: Floats) -> Floats:
    """The least peaks (ny, nx) within excursions (ny, nx), drawn between those that are solved.

    Along an axis that changes the pulse, some pulses are; for each, excursions from the least to the largest met with it.
    """
    (first, x), (second, y) = grid
    changes = [_changes_pulse(scenario, path) for path in (second, first)]  # in the order of the array's axes
    count = _NODES[sum(changes)]
    known: NDArray[np.bool_] = np.isfinite(within)
    up, across = (
        _places(np.asarray(known.any(axis=1 - axis)), count if changed else 1) for axis, changed in enumerate(changes)
    )
    same = tuple(axis for axis, changed in enumerate(changes) if not changed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a line on which no crash can be has no excursions
        low, high = (np.broadcast_to(of(within, axis=same, keepdims=True), within.shape) for of in (np.nanmin, np.nanmax))
    steps = np.linspace(0.0, 1.0, _EXCURSIONS[sum(changes)]) if np.nanmax(high - low) > 0.0 else np.zeros(1)
    crashes = {
        (j, i): response
        for j in up
        for i in across
        if (response := _solved(scenario, {first: float(x[i]), second: float(y[j])})) is not None
    }
    behind = max((_behind(response, body) for response in crashes.values()), default=0.0)
    found = np.full((up.size, across.size, steps.size), np.nan)
    for (j, i), response in crashes.items():
        if np.isfinite(low[j, i]):
            at = low[j, i] + steps * (high[j, i] - low[j, i])
            found[np.searchsorted(up, j), np.searchsorted(across, i)] = _peaks(response, body, behind, at)
    found = _along(x[across], _along(y[up], found, y, axis=0), x, axis=1)
    return _between(found, within, low, high)


def _places(known: NDArray[np.bool_], count: int) -> NDArray[np.int64]:
    """So many places, evenly from the first to the last that is known; of one the middle."""
    places = np.flatnonzero(known)
    some = [places.size // 2] if count == 1 else np.linspace(0, places.size - 1, count).round().astype(np.int64)
    return np.unique(places[some])


def _solved(scenario: Scenario, values: Mapping[str, float]) -> Response | None:
    """A crash, or None where its numbers break a rule."""
    try:
        return simulate(substitute(scenario, values), throw=False)
    except RidedownError:
        return None


def _peaks(response: Response, body: str, behind: float, excursions: Floats) -> Floats:
    """The least peaks within excursions, (E,); 0 where nothing brakes the vehicle."""
    try:
        return _limiting(response, body, behind).peaks(excursions)
    except RidedownError:
        return np.zeros(excursions.size)


def _limiting(response: Response, body: str, behind: float) -> Limiting:
    vehicle = response.occupants[body.partition(".")[0]].vehicle
    return Limiting(motion_of(response, vehicle), rearward=behind, horizon=response.end_time)


def _behind(response: Response, body: str) -> float:
    """How far behind its place a body was before it was farthest forward [m]: of the whole map the most counts."""
    farthest = response.maximum(f"{body}.excursion").time
    time, place = response.history(f"{body}.excursion").si
    return max(0.0, -float(place[time <= farthest].min()))


def _along(nodes: Floats, values: Floats, fine: Floats, *, axis: int) -> Floats:
    """Values at nodes along an axis of an array drawn at finer places, as far as there are values.

    Peaks grow as the square of a speed: it is their root that is smooth and nearly straight.
    """
    if nodes.size == 1:
        return np.repeat(values, fine.size, axis=axis)
    lines = np.moveaxis(values, axis, 0)
    drawn = np.full((fine.size, *lines.shape[1:]), np.nan)
    for place in np.ndindex(*lines.shape[1:]):
        line = lines[(slice(None), *place)]
        good = np.isfinite(line)
        if good.sum() >= 2:
            drawn[(slice(None), *place)] = PchipInterpolator(nodes[good], np.sqrt(line[good]), extrapolate=False)(fine) ** 2
    return np.moveaxis(drawn, 0, axis)


def _between(peaks: Floats, within: Floats, low: Floats, high: Floats) -> Floats:
    """Peaks (ny, nx, E), evenly from the low to the high excursion of each crash, at its own excursion (ny, nx).

    An occupant held evenly over the way of the car and its own has a peak whose inverse is straight in the excursion.
    """
    last = peaks.shape[-1] - 1
    if last == 0:
        return np.where(np.isfinite(within), peaks[..., 0], np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.nan_to_num(last * (within - low) / (high - low))
    k = np.clip(place.astype(np.int64), 0, last - 1)
    part = place - k
    lower, upper = (np.take_along_axis(peaks, (k + step)[..., None], axis=-1)[..., 0] for step in (0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / ((1.0 - part) / lower + part / upper)
    straight = upper < _NEAR_ZERO * lower  # of a peak that vanishes, its inverse does not help
    return np.where(np.isfinite(within), np.where(straight, (1.0 - part) * lower + part * upper, inverse), np.nan)
