"""Which figures a search has, drawn from the rows that it kept: an optimum, a solution box, rare events."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations, islice
from typing import Any, Protocol

import numpy as np

from ridedown.report.study_axes import Bar, Floats, Quantity
from ridedown.report.study_designs import Truths, box_plot, progress_plot, rare_plot, slice_plot, tried_plot
from ridedown.report.study_found import Found
from ridedown.report.style import Plot
from ridedown.studies.file.study import LoadedStudy
from ridedown.studies.running.searches import designs_tried

_MOST_PAIRS = 6
_MOST_PARAMETERS = 6


class Rows(Protocol):
    """The rows that are kept."""

    parameters: list[Quantity]
    outcomes: list[Quantity]

    def every(self, *quantities: Quantity) -> list[Floats]:
        """Columns in the order of the rows, (R,) each; NaN where a row has none."""
        ...


def search_plots(loaded: LoadedStudy, kept: Rows, found: Found) -> Iterator[Plot]:
    """The figures of a search that is finished; a front has its own."""
    results = found.results
    if results.get("box") is not None:
        yield from _box(results, kept)
    elif results.get("rare"):
        yield from _rare(results, kept)
    elif results.get("chosen") is not None and not results.get("front"):
        yield from _optimum(loaded, results, kept)


def _optimum(loaded: LoadedStudy, results: Mapping[str, Any], kept: Rows) -> Iterator[Plot]:
    columns = dict(zip(_names(kept), kept.every(*kept.parameters, *kept.outcomes), strict=True))
    tried = designs_tried(loaded, {one.name: one.unit for one in kept.outcomes}, columns)
    aim = results["objectives"][0]
    goal = Quantity(aim["words"], aim["unit"])
    value = float(results["chosen"]["objectives"][goal.name])
    units = {one.name: one for one in kept.parameters}
    finite = np.where(np.isfinite(tried.goal), tried.goal, np.nan)
    for name, column in islice(tried.parameters.items(), _MOST_PARAMETERS):
        at = float(results["chosen"]["parameters"][name]), value
        yield tried_plot(units[name], goal, column, finite, tried.held, at)
    if tried.held.any():
        rows = tried.rows * np.arange(1, tried.goal.size + 1)
        yield progress_plot(goal, rows, tried.goal, tried.held, largest=aim["sense"] == "max")


def _box(results: Mapping[str, Any], kept: Rows) -> Iterator[Plot]:
    of = {one.name: one for one in (*kept.parameters, *kept.outcomes)}
    sides, ranges = _ends(results["box"]["ranges"], of), _ends(results["ranges"], of)
    yield box_plot(sides, ranges)
    limits = results["limits"]
    bounded = list(dict.fromkeys(of[one["outcome"]] for one in limits))
    columns = dict(zip([*sides, *bounded], kept.every(*sides, *bounded), strict=True))
    broken = {_words(one, of): _broken(one, columns[of[one["outcome"]]]) for one in limits}
    for x, y in islice(combinations(sides, 2), _MOST_PAIRS):
        inside = np.ones(columns[x].size, dtype=np.bool_)
        for other, (low, high) in sides.items():
            if other not in {x, y}:
                inside &= (columns[other] >= low) & (columns[other] <= high)
        yield slice_plot(
            x,
            y,
            (columns[x][inside], columns[y][inside]),
            {words: which[inside] for words, which in broken.items()},
            (sides[x], sides[y]),
            (ranges[x], ranges[y]),
        )


def _rare(results: Mapping[str, Any], kept: Rows) -> Iterator[Plot]:
    of = {one.name: one for one in (*kept.parameters, *kept.outcomes)}
    start = 0
    for limit in results["limits"]:
        # each limit is searched for after the one before, in rows of its own
        rows = slice(start, start + limit["evaluations"])
        start = rows.stop
        if not limit["likeliest"]:
            continue
        outcome = of[limit["outcome"]]
        *columns, values = (column[rows] for column in kept.every(*kept.parameters, outcome))
        by = dict(zip(kept.parameters, columns, strict=True))
        beyond, words, likeliest = _broken(limit, values), _words(limit, of), limit["likeliest"]
        if len(by) == 1:  # against what it comes to
            (x,) = kept.parameters
            yield rare_plot(x, outcome, (by[x], values), beyond, (float(likeliest[x.name]), _bar(limit).value), words)
        for x, y in islice(combinations(kept.parameters, 2), _MOST_PAIRS):
            at = float(likeliest[x.name]), float(likeliest[y.name])
            yield rare_plot(x, y, (by[x], by[y]), beyond, at, words)


def _ends(given: Mapping[str, Any], of: Mapping[str, Quantity]) -> dict[Quantity, tuple[float, float]]:
    return {of[name]: (float(low), float(high)) for name, (low, high) in given.items()}


def _names(kept: Rows) -> list[str]:
    return [one.name for one in (*kept.parameters, *kept.outcomes)]


def _bar(limit: Mapping[str, Any]) -> Bar:
    most = limit["most"] is not None
    return Bar(float(limit["most"] if most else limit["least"]), most=most)


def _words(limit: Mapping[str, Any], of: Mapping[str, Quantity]) -> str:
    return f"{limit['outcome']} {_bar(limit).words(of[limit['outcome']])}"


def _broken(limit: Mapping[str, Any], values: Floats) -> Truths:
    """Which rows break a limit; one that failed has no value, and does not hold it."""
    found: Truths = _bar(limit).broken(values) | np.isnan(values)
    return found
