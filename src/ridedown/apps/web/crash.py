"""One crash for the page: every curve on one grid of times, the events, and what the animation is drawn from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ridedown.apps.web.geometry import geometry
from ridedown.report.lines import against_time, vehicles
from ridedown.response import Response

Frame = tuple[dict[str, Any], dict[str, NDArray[Any]]]
"""Header and arrays (see `frames`)."""

_POINTS = 400
"""Evenly spaced times, and two at every event beside: finer than a screen is wide."""
_MOST_EVENTS = 400


def curves(response: Response) -> Frame:
    """The curves of a response: `time` (T,) [s] as doubles, `values` (C, T) in SI as floats, and the figures they belong to.

    Figures name their lines by the row of `values`, with the factor from SI to the figure's unit.
    """
    row: dict[str, int] = {}
    figures = [
        {
            "name": kind.name,
            "title": kind.title,
            "label": kind.ylabel,
            "unit": kind.unit,
            "scale": kind.scale,
            "lines": [
                {"label": line.label, "row": row.setdefault(line.channel, len(row)), "colour": line.index} for line in lines
            ],
        }
        for kind, lines in against_time(response)
    ]
    for channel in _drawn(response):
        row.setdefault(channel, len(row))
    times = response.drawing_times(response.end_time / _POINTS) if response.end_time > 0.0 else np.zeros(1)
    header = {
        "kind": "curves",
        "completed": response.completed,
        "status": response.status.sentence,
        "end": response.end_time,
        "name": response.scenario.name,
        "description": response.scenario.description,
        "figures": figures,
        "channels": list(row),
        "units": [response.unit(channel) for channel in row],
        "events": [{"time": event.time, "who": event.who, "what": event.what} for event in response.events[:_MOST_EVENTS]],
        "geometry": geometry(response.scenario),
    }
    return header, {"time": times, "values": finite(response.sampled(row, times))}


def finite(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """As floats; what has no finite value, or is too large for a float, is NaN, which a curve leaves out."""
    with np.errstate(over="ignore"):
        small = values.astype(np.float32)
    small[~np.isfinite(small)] = np.nan
    return small


def _drawn(response: Response) -> Iterator[str]:
    """The channels that the animation needs beside those of the figures."""
    known = {*response.network.coordinates, *response.network.elements}
    moving = [("bar", "bar.displacement"), ("bar.rotation", "bar.rotation")]
    for name in vehicles(response.scenario):
        moving += [(f"{name}.{side}", f"{name}.{side}.deflection") for side in ("right", "left")]
    moving += [(f"{one.name}.seat", f"{one.name}.seat.excursion") for one in getattr(response.scenario, "occupants", ())]
    return (channel for of, channel in moving if of in known)
