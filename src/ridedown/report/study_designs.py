"""Figures of single designs: those that a search tried, the box that it found, the rows of a rare event."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import ArrayLike, NDArray

from ridedown.report.study_axes import Floats, Quantity, done, done_above, note, slug
from ridedown.report.style import FAINT, INK, PALETTE, Plot, new_axes, put_title, room_for_names, title_of

Truths = NDArray[np.bool_]

_HELD, _BROKEN = PALETTE[0], PALETTE[1]
_HALF_A_WORD = 16.0  # per cent of the axes
_MOST_DRAWN = 700
"""Points of one kind that a figure has, evenly taken of more: a file stays small, and a picture legible."""


def tried_plot(
    x: Quantity, goal: Quantity, across: ArrayLike, up: ArrayLike, held: Truths, chosen: tuple[float, float]
) -> Plot:
    """What every design that was tried comes to, against one of its parameters: (D,) and (D,), SI.

    held: (D,), which designs hold all that is asked for; chosen: the best of them, or the nearest where none does.
    """
    axes = new_axes(f"{goal.name} against {x.name}", xlabel=x.label, ylabel=goal.label)
    _points(axes, x.shown(across), goal.shown(up), [("holds all constraints", held), ("breaks one", ~held)])
    at = float(x.shown(chosen[0])), float(goal.shown(chosen[1]))
    axes.plot(*at, "D", color=PALETTE[4], markeredgecolor=INK, markersize=9.0, label="chosen", zorder=5)
    _within(axes, goal.shown(up)[held] if held.any() else goal.shown(up), at[1])
    note(axes, f"{x.text(chosen[0])}, {goal.text(chosen[1])}", at, ha="right" if at[0] > np.mean(axes.get_xlim()) else "left")
    text = (
        f"{goal.label} of {held.size:,} designs tried against {x.label}; {int(held.sum()):,} hold all constraints. "
        f"Chosen: {x.text(chosen[0])}, {goal.text(chosen[1])}."
    )
    return Plot(slug("tried", x.name), title_of(axes), text, done(axes))


def progress_plot(goal: Quantity, rows: ArrayLike, up: ArrayLike, held: Truths, *, largest: bool = False) -> Plot:
    """The best design so far that holds all constraints, as rows are computed: rows (D,), what each comes to (D,), SI."""
    worst = -np.inf if largest else np.inf
    best = (np.maximum if largest else np.minimum).accumulate(np.where(held, np.asarray(up, dtype=np.float64), worst))
    known = np.isfinite(best)
    axes = new_axes(f"{goal.name}: the best so far", xlabel="rows computed", ylabel=goal.label)
    axes.locator_params(axis="x", nbins=6)
    axes.xaxis.set_major_formatter("{x:,.0f}")
    axes.step(np.asarray(rows)[known], goal.shown(best[known]), where="post", color=_HELD, linewidth=1.8)
    text = f"The best {goal.name} so far against the rows computed"
    if known.any():
        text += f": from {goal.text(best[known][0])} to {goal.text(best[-1])}."
    return Plot("progress", title_of(axes), text, done(axes))


def box_plot(sides: Mapping[Quantity, tuple[float, float]], ranges: Mapping[Quantity, tuple[float, float]]) -> Plot:
    """The solution box, a bar for each parameter within its range: sides and ranges in SI."""
    axes = new_axes("Solution box", xlabel="part of the range, %", ylabel="")
    names, left, size = room_for_names([of.label for of in sides])
    axes.set_position((left, 0.125, 0.94 - left, 0.765))
    said = []
    for place, (of, (low, high)) in enumerate(sides.items()):
        least, most = ranges[of]
        start, end = (100.0 * (side - least) / (most - least) for side in (low, high))
        axes.barh(place, 100.0, height=0.34, color="#eeeeee", edgecolor=FAINT, linewidth=0.8)
        axes.barh(place, end - start, left=start, height=0.34, color=_HELD)
        middle = float(np.clip(0.5 * (start + end), _HALF_A_WORD, 100.0 - _HALF_A_WORD))
        axes.text(middle, place - 0.32, f"{of.text(low, unit=False)} to {of.text(high)}", ha="center", va="center")
        for at, value, ha in ((0.0, least, "left"), (100.0, most, "right")):
            axes.text(at, place + 0.31, of.text(value, unit=False), ha=ha, va="center", fontsize=8.5)
        said.append(f"{of.name} {of.text(low)} to {of.text(high)} of {of.text(least)} to {of.text(most)}")
    axes.set_yticks(range(len(sides)), names, fontsize=size)
    put_title(axes, "Solution box", at=min(left, 0.105))
    axes.set_xlim(-1.0, 101.0)
    axes.set_ylim(len(sides) - 0.4, -0.7)  # the first on top
    axes.grid(visible=False, axis="y")
    return Plot("box", title_of(axes), "; ".join(said) + ".", done(axes, legend=False))


def slice_plot(
    x: Quantity,
    y: Quantity,
    points: tuple[ArrayLike, ArrayLike],
    broken: Mapping[str, Truths],
    sides: tuple[tuple[float, float], tuple[float, float]],
    ranges: tuple[tuple[float, float], tuple[float, float]],
) -> Plot:
    """A cut through a solution box: rows whose other parameters lie within it, (R,) and (R,), SI, with its sides.

    broken: by the words of each limit, which rows break it, (R,).
    """
    axes = new_axes(f"A cut through the box: {y.name} against {x.name}", xlabel=x.label, ylabel=y.label)
    across, up = x.shown(points[0]), y.shown(points[1])
    free = np.ones(across.size, dtype=np.bool_)
    groups: list[tuple[str, Truths]] = []
    for words, which in broken.items():
        groups.append((f"breaks {words}", which & free))
        free &= ~which
    _points(axes, across, up, [("holds all limits", free), *groups])
    (x0, x1), (y0, y1) = x.shown(sides[0]), y.shown(sides[1])
    axes.add_patch(Rectangle((x0, y0), x1 - x0, y1 - y0, fill=False, edgecolor=INK, linewidth=2.0, zorder=5, label="box"))
    for set_ends, (least, most) in ((axes.set_xlim, x.shown(ranges[0])), (axes.set_ylim, y.shown(ranges[1]))):
        room = 0.03 * (most - least)
        set_ends(least - room, most + room)
    wide, high = (f"{of.text(ends[0])} to {of.text(ends[1])}" for of, ends in zip((x, y), sides, strict=True))
    text = f"{y.label} against {x.label}, {across.size:,} rows with all others in the box, which is {wide} by {high}."
    return Plot(slug("slice", y.name, x.name), title_of(axes), text, done_above(axes))


def rare_plot(
    x: Quantity, y: Quantity, points: tuple[ArrayLike, ArrayLike], beyond: Truths, likeliest: tuple[float, float], limit: str
) -> Plot:
    """The rows drawn about a rare event, two parameters against each other, (R,) and (R,), SI, and the likeliest beyond.

    beyond: (R,), which rows exceed the limit.
    """
    axes = new_axes(f"{limit}: {y.name} against {x.name}", xlabel=x.label, ylabel=y.label)
    across, up = x.shown(points[0]), y.shown(points[1])
    _points(axes, across, up, [("within the limit", ~beyond), ("beyond it", beyond)])
    at = float(x.shown(likeliest[0])), float(y.shown(likeliest[1]))
    axes.plot(*at, "D", color=PALETTE[4], markeredgecolor=INK, markersize=9.0, label="the likeliest beyond it", zorder=5)
    text = (
        f"{across.size:,} rows drawn where {limit}, {int(beyond.sum()):,} of them beyond it; the likeliest such row has "
        f"{x.name} {x.text(likeliest[0])} and {y.name} {y.text(likeliest[1])}."
    )
    return Plot(slug("rare", limit, y.name, x.name), title_of(axes), text, done_above(axes))


_MARKS = ("o", "x", "^", "s", "v", "+")
_COLOURS = (_HELD, _BROKEN, PALETTE[3], PALETTE[2], PALETTE[4], PALETTE[5])
"""Of the groups of points, in order: told apart without colour as well."""


def _points(axes: Axes, across: Floats, up: Floats, groups: Sequence[tuple[str, Truths]]) -> None:
    for k, (label, which) in enumerate(groups):
        rows = np.flatnonzero(which & np.isfinite(across) & np.isfinite(up))
        if not rows.size:
            continue
        rows = rows[:: -(-rows.size // _MOST_DRAWN)]
        mark = _MARKS[k % len(_MARKS)]
        axes.plot(
            across[rows], up[rows], mark, color=_COLOURS[k % len(_COLOURS)], markersize=3.2 if mark == "o" else 4.2,
            markeredgewidth=0.0 if mark == "o" else 0.9, alpha=0.6, linestyle="none", label=label, zorder=3 if k == 0 else 2,
        )  # fmt: skip


def _within(axes: Axes, good: Floats, chosen: float) -> None:
    """Show the designs that count, and as much again beyond them: the worst of those tried would press the others flat."""
    values = good[np.isfinite(good)]
    if not values.size:
        return
    low, high = min(float(values.min()), chosen), max(float(np.quantile(values, 0.98)), chosen)
    room = (high - low) or abs(high) or 1.0
    before = axes.get_ylim()
    axes.set_ylim(max(before[0], low - 0.6 * room), min(before[1], high + 0.6 * room))
