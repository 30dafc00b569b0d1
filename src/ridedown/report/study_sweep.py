"""Figures of a sweep: an outcome over one parameter, a contour map over two, and the carpet that two of them span."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from ridedown.report.study_axes import (
    LIMIT,
    Bar,
    Floats,
    Quantity,
    done,
    done_above,
    finite,
    limit_level,
    limit_upright,
    slug,
)  # fmt: skip
from ridedown.report.style import HEIGHT, PALETTE, WIDTH, Plot, draw_line, letters, new_axes, title_of
from ridedown.report.tags import Tag, place_tags

_LEVELS = 9  # contours
_ROUNDING = 1e-12  # of the largest: values that differ by less are the same
_EDGE, _APART = 24.0, 46.0  # between the middle of a label and the edge of the axes, and of two labels, pixels
_LINES = 7  # lines of a carpet each way; levels in between are left out
_WORDS = "#005A8E", "#00684C"  # of a carpet: the colours of its lines, darker, so that small letters are legible
_MAP = "cividis"  # even to the eye, with or without colour vision, and in grey


def line_plot(
    parameter: Quantity, outcome: Quantity, values: ArrayLike, results: ArrayLike, *, limits: Sequence[Bar] = (), held: str = ""
) -> Plot:
    """An outcome against the one parameter that varies: values and results (R,), SI."""
    x, y = finite(np.asarray(values, dtype=np.float64), np.asarray(results, dtype=np.float64))
    order = np.argsort(x)
    x, y = x[order], y[order]
    axes = new_axes(f"{outcome.name} over {parameter.name}", xlabel=parameter.label, ylabel=outcome.label)
    draw_line(axes, parameter.shown(x), outcome.shown(y), label=outcome.name, index=0)
    if x.size <= 60:
        axes.plot(parameter.shown(x), outcome.shown(y), "o", color=PALETTE[0], markersize=3.5)
    low, high = int(np.argmin(y)), int(np.argmax(y))
    for limit in limits:
        limit_level(axes, outcome, limit)
    said = (
        f"{outcome.label} against {parameter.label}. Least {outcome.text(y[low])} at {parameter.text(x[low])}, "
        f"largest {outcome.text(y[high])} at {parameter.text(x[high])}."
    )
    return Plot(slug("line", outcome.name), title_of(axes), said + _kept(outcome, y, limits) + held, done(axes))


def map_plot(
    x: Quantity,
    y: Quantity,
    outcome: Quantity,
    columns: ArrayLike,
    rows: ArrayLike,
    grid: ArrayLike,
    *,
    limits: Sequence[Bar] = (),
    held: str = "",
) -> Plot:
    """A contour map of an outcome over two parameters: columns (X,), rows (Y,), grid (Y, X), SI; NaN where a row failed.

    A limit is a thick line, and what breaks it is hatched.
    """
    across, up = x.shown(columns), y.shown(rows)
    values = np.ma.masked_invalid(outcome.shown(grid))
    axes = new_axes(f"{outcome.name}", xlabel=x.label, ylabel=y.label)
    axes.grid(visible=False)
    flat = not _varies(values.compressed(), outcome)
    if not flat:
        filled = axes.contourf(across, up, values, levels=_LEVELS, cmap=_MAP)
        low, high = np.asarray(filled.levels)[[0, -1]]
        if values.min() < low or values.max() > high:  # by a last bit, which would leave those places white
            values = np.ma.masked_invalid(np.clip(outcome.shown(grid), low, high))
            filled.remove()
            filled = axes.contourf(across, up, values, levels=filled.levels, cmap=_MAP)
        lines = axes.contour(across, up, values, levels=filled.levels, colors="white", linewidths=0.6)
        figure = axes.get_figure()
        assert figure is not None
        axes.set_position((0.105, 0.125, 0.745, 0.765))
        places = _label_places(axes, lines.allsegs)
        for label in axes.clabel(lines, fontsize=8.0, fmt="%.4g", colors="black", manual=places) if places else ():
            label.set_bbox({"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.8})
        bar = figure.colorbar(filled, cax=figure.add_axes((0.875, 0.125, 0.022, 0.765)))
        bar.set_label(outcome.label, fontsize=letters(outcome.label, 0.97 * HEIGHT, 9.0))
        bar.ax.tick_params(labelsize=8.0)
        for limit in limits:
            _draw_limit(axes, across, up, values, float(outcome.shown(limit.value)), most=limit.most)
        if limits:
            words = "; ".join(limit.words(outcome) for limit in limits)
            said = f"limit {words}; beyond is hatched"
            axes.annotate(
                said, (1.0, 1.0), xycoords="axes fraction", xytext=(0, 2), textcoords="offset points",
                ha="right", va="bottom", fontsize=letters(said, 0.745 * WIDTH, 8.5), color=LIMIT,
            )  # fmt: skip
    plain = np.asarray(grid, dtype=np.float64)
    said = f"{outcome.label} over {x.label} and {y.label}."
    if not flat:
        j, i = np.unravel_index(int(np.nanargmin(plain)), plain.shape)
        at = np.asarray(columns)[i], np.asarray(rows)[j]
        least, largest = outcome.text(plain[j, i]), outcome.text(float(np.nanmax(plain)))
        said += f" Least {least} at {x.text(at[0])} and {y.text(at[1])}, largest {largest}."
    else:
        said += f" The same everywhere: {outcome.text(float(np.nanmean(plain)))}." if values.count() else " No row has it."
    return Plot(slug("map", outcome.name), f"Map of {outcome.name}", said + _kept(outcome, plain, limits) + held, done(axes))


def _varies(values: Floats, outcome: Quantity) -> bool:
    """Whether values (n,), as they are read, differ by more than rounding: a map of that would show a pattern of nothing."""
    if not values.size:
        return False
    largest = float(np.abs(values).max())
    return bool(largest > outcome.nothing and np.ptp(values) > _ROUNDING * largest)


def _label_places(axes: Axes, contours: Sequence[Sequence[Floats]]) -> list[tuple[float, float]]:
    """Where contours are labelled: near their middles, within the axes, and apart; one that has no such place has no label.

    contours: the pieces of each, (n, 2), in the units of the axes.
    """
    frame = axes.get_window_extent()
    low, high = np.array((frame.x0, frame.y0)) + _EDGE, np.array((frame.x1, frame.y1)) - _EDGE
    taken: list[Floats] = []
    for pieces in contours:
        paths = [_evenly(np.asarray(axes.transData.transform(piece))) for piece in pieces if len(piece) > 1]
        if not paths:
            continue
        path = max(paths, key=lambda one: float(np.hypot(*np.diff(one, axis=0).T).sum()))
        for k in np.argsort(np.abs(np.arange(len(path)) - 0.5 * len(path)), kind="stable"):
            place = path[k]
            if (place > low).all() and (place < high).all() and all(np.hypot(*(place - one)) > _APART for one in taken):
                taken.append(place)
                break
    return [(float(x), float(y)) for x, y in (axes.transData.inverted().transform(place) for place in taken)]


def _evenly(path: Floats, count: int = 101) -> Floats:
    """Points on a line (n, 2), evenly far along it, (count, 2)."""
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))))
    at = np.linspace(0.0, along[-1], count)
    return np.column_stack([np.interp(at, along, column) for column in path.T])


def _draw_limit(axes: Axes, across: Floats, up: Floats, values: Any, level: float, *, most: bool) -> None:
    low, high = float(values.min()), float(values.max())
    beyond = [level, max(high, level) + 1.0] if most else [min(low, level) - 1.0, level]
    if (high > level) if most else (low < level):
        axes.contourf(across, up, values, levels=beyond, colors="none", hatches=["///"])
    if low < level < high:
        axes.contour(across, up, values, levels=[level], colors=[LIMIT], linewidths=2.6)


def carpet_plot(
    one: Quantity,
    other: Quantity,
    x: Quantity,
    y: Quantity,
    levels: tuple[ArrayLike, ArrayLike],
    grids: tuple[ArrayLike, ArrayLike],
    *,
    limits: tuple[Sequence[Bar], Sequence[Bar]] = ((), ()),
    held: str = "",
) -> Plot:
    """Two outcomes against each other, with lines along which one parameter, and the other, stays the same.

    levels: of the parameters, (I,) and (J,); grids: of the outcomes x and y, (I, J) each, SI. limits: on x, and on y.
    """
    first, second = (np.asarray(level, dtype=np.float64) for level in levels)
    across, up = x.shown(grids[0]), y.shown(grids[1])
    axes = new_axes(f"{y.name} against {x.name}", xlabel=x.label, ylabel=y.label)
    families = (
        [(across[i], up[i], one.text(first[i], unit=False)) for i in _some(first.size)],
        [(across[:, j], up[:, j], other.text(second[j], unit=False)) for j in _some(second.size)],
    )
    for n, (quantity, lines) in enumerate(zip((one, other), families, strict=True)):
        for k, (line_x, line_y, _) in enumerate(lines):
            draw_line(axes, line_x, line_y, label=f"same {quantity.label}" if k == 0 else "_", index=2 * n, dash=n)
    axes.margins(0.14)
    axes.autoscale_view()
    for limit in limits[0]:
        limit_upright(axes, x, limit)
    for limit in limits[1]:
        limit_level(axes, y, limit)
    broken = np.zeros(across.shape, dtype=np.bool_)
    for grid, bars in zip(grids, limits, strict=True):
        for limit in bars:
            broken |= limit.broken(grid)
    said = f"{y.label} against {x.label}, along lines of equal {one.label} (solid) and equal {other.label} (dashed)."
    if any(limits):
        known = np.isfinite(across) & np.isfinite(up)
        said += f" {int((known & ~broken).sum())} of {int(known.sum())} designs keep to the limits, which are drawn in."
    figure = done_above(axes)
    tags = [_tags(axes, lines, _WORDS[n]) for n, lines in enumerate(families)]
    left_out = place_tags(axes, tags)
    for quantity, size, family in zip((one, other), (first.size, second.size), tags, strict=True):
        if len(family) < size:
            said += f" {len(family)} of {size} values of {quantity.name} are drawn."
        if unnamed := sum(tag in left_out for tag in family):
            said += f" There is no room to name {unnamed} of the {len(family)} lines of equal {quantity.name}."
    return Plot(slug("carpet", y.name, x.name), title_of(axes), said + held, figure)


def _some(count: int) -> NDArray[np.int64]:
    return np.unique(np.linspace(0, count - 1, min(count, _LINES)).round().astype(np.int64))


def _tags(axes: Axes, lines: Sequence[tuple[Floats, Floats, str]], colour: str) -> list[Tag]:
    """The names of lines, at those of their ends that lie further apart in the picture."""
    ahead = [Tag(text, x, y, colour) for x, y, text in lines]
    back = [Tag(text, x[::-1], y[::-1], colour) for x, y, text in lines]
    return ahead if _spread(axes, ahead) >= _spread(axes, back) else back


def _spread(axes: Axes, tags: Sequence[Tag]) -> float:
    """How far apart the ends of lines lie in the picture, least first: what there is room for."""
    ends = []
    for tag in tags:
        known = np.flatnonzero(np.isfinite(tag.x) & np.isfinite(tag.y))
        if known.size:
            ends.append((tag.x[known[-1]], tag.y[known[-1]]))
    if len(ends) < 2:
        return 0.0
    return float(np.hypot(*np.diff(axes.transData.transform(ends), axis=0).T).min())


def _kept(outcome: Quantity, values: Floats, limits: Sequence[Bar]) -> str:
    known = values[np.isfinite(values)]
    return "".join(
        f" Limit, {limit.words(outcome)}: {int((~limit.broken(known)).sum()):,} of {known.size:,} rows keep to it."
        for limit in limits
    )
