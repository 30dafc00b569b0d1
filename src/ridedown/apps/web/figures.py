"""The founding paper for the page: figures 6 to 19 as curves, its numbers beside ours, its trends."""

from __future__ import annotations

import numpy as np

from ridedown.apps.web.crash import Frame, finite
from ridedown.apps.web.results import table_of
from ridedown.paper import reproduce
from ridedown.paper.figures import FIGURES
from ridedown.paper.page import numbers_table, trends_table

_POINTS = 400


def paper_figures() -> Frame:
    """Arrays: `time` (T,) [s] and `values` (C, T) in each figure's own unit."""
    found = reproduce.reproduce()
    end = min(response.end_time for response in found.responses.values())
    times = np.linspace(0.0, end, _POINTS + 1)
    rows: list[np.ndarray[tuple[int], np.dtype[np.float64]]] = []
    figures = []
    for figure in FIGURES:
        lines = []
        for index, case in enumerate(figure.cases):
            lines.append({"label": case.label, "row": len(rows), "colour": index, "scenario": case.scenario})
            rows.append(figure.quantity.scale * found.responses[case.scenario].at(figure.channel, times))
        figures.append(
            {
                "name": f"figure-{figure.number}",
                "title": f"Figure {figure.number}. {figure.title}",
                "label": figure.quantity.label,
                "unit": figure.quantity.label.partition(", ")[2],
                "scale": 1.0,
                "lines": lines,
            }
        )
    tables = [table_of(numbers_table(found.headlines)), table_of(trends_table(found.trends))]
    return {"kind": "paper", "end": end, "figures": figures, "tables": tables}, {
        "time": times,
        "values": finite(np.array(rows)),
    }
