"""Figures of sensitivities: bars of indices with their intervals, effects, and a tornado."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Sized
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from ridedown.report.study_axes import Floats, Quantity, done, finite, listed, note, slug
from ridedown.report.style import HEIGHT, INK, PALETTE, WIDTH, Plot, new_axes, put_title, room_for_names, title_of
from ridedown.report.tables import number

_MOST = 15  # parameters that a figure shows
_SHARE = 0.1
"""Of all rows, those with the least and with the largest values of a parameter, which a tornado compares."""


@dataclass(frozen=True, slots=True)
class Interval:
    """A number and its interval."""

    value: float
    low: float
    high: float


def index_plot(outcome: str, first: Mapping[str, Interval], total: Mapping[str, Interval]) -> Plot:
    """Sobol indices by parameter, first and total, the largest above, with their intervals."""
    order = sorted(total, key=lambda name: -total[name].value)[:_MOST]
    axes = _bars(f"Sobol indices of {outcome}", "share of the variance of the outcome", order)
    for k, (found, label, hatch) in enumerate(
        ((total, "total: with every interaction", ""), (first, "first: by itself", "///"))
    ):
        _draw_bars(axes, [found[name] for name in order], index=k, shift=0.2 * (1 - 2 * k), label=label, hatch=hatch)
    axes.axvline(0.0, color=INK, linewidth=0.7)
    axes.axvline(1.0, color=INK, linewidth=0.7, linestyle=(0, (2, 2)))
    axes.legend(loc="lower right", fontsize=9.0, frameon=True, framealpha=0.85, edgecolor="none")
    said = "; ".join(f"{name} total {number(total[name].value, 3)}, first {number(first[name].value, 3)}" for name in order)
    text = f"Sobol indices of {outcome}, with intervals. {said}.{_left_out(total)}"
    return Plot(slug("sobol", outcome), title_of(axes), text, done(axes, legend=False))


def effect_plot(outcome: Quantity, sizes: Mapping[str, Interval], deviations: Mapping[str, float]) -> Plot:
    """Morris's elementary effects: mean size with its interval, and the deviation that tells of curves and interactions."""
    order = sorted(sizes, key=lambda name: -sizes[name].value)[:_MOST]
    axes = _bars(
        f"Elementary effects on {outcome.name}", f"effect over the parameter's range, {outcome.read_in or 'no unit'}", order
    )
    shown = [Interval(*(float(outcome.shown(x)) for x in (sizes[n].value, sizes[n].low, sizes[n].high))) for n in order]
    _draw_bars(axes, shown, index=0, shift=0.0, label="mean size", hatch="")
    places = np.arange(len(order))
    spread = [float(outcome.shown(deviations[name])) for name in order]
    axes.plot(spread, places, "D", color=PALETTE[1], markersize=5.5, label="deviation: curved, or interacting", zorder=4)
    axes.legend(loc="lower right", fontsize=9.0, frameon=True, framealpha=0.85, edgecolor="none")
    said = "; ".join(f"{name} {outcome.text(sizes[name].value)}" for name in order)
    text = f"Mean size of the change of {outcome.label} as a parameter goes through its range: {said}.{_left_out(sizes)}"
    return Plot(slug("effects", outcome.name), title_of(axes), text, done(axes, legend=False))


def tornado_plot(outcome: Quantity, parameters: Mapping[Quantity, ArrayLike], values: ArrayLike) -> Plot:
    """How far the mean of an outcome lies apart where each parameter is at its least and at its largest.

    parameters: columns (R,), SI; values (R,) of the outcome. A bar goes from the mean of the tenth of all rows with the least
    values of its parameter to that of the tenth with the largest.
    """
    results = np.asarray(values, dtype=np.float64)
    ends = {quantity: _ends(np.asarray(column, dtype=np.float64), results) for quantity, column in parameters.items()}
    order = sorted(ends, key=lambda quantity: -abs(ends[quantity][1] - ends[quantity][0]))[:_MOST]
    middle = float(np.nanmean(results))
    axes = _bars(f"Tornado of {outcome.name}", outcome.label, [quantity.name for quantity in order])
    at = float(outcome.shown(middle))
    for place, quantity in enumerate(order):
        low, high = (float(outcome.shown(end)) for end in ends[quantity][:2])
        axes.barh(
            place,
            low - at,
            0.55,
            left=at,
            color=PALETTE[5],
            edgecolor=INK,
            linewidth=0.4,
            label="least tenth of the parameter" if place == 0 else None,
        )
        axes.barh(
            place,
            high - at,
            0.55,
            left=at,
            color=PALETTE[1],
            hatch="///",
            edgecolor=INK,
            linewidth=0.4,
            label="largest tenth" if place == 0 else None,
        )
        # one on each side, even where both bars go the same way or have hardly any length: never one over the other
        (left, of_left), (right, of_right) = sorted(((low, ends[quantity][2]), (high, ends[quantity][3])))
        note(axes, quantity.text(of_left), (min(left, at), place), ha="right", va="center")
        note(axes, quantity.text(of_right), (max(right, at), place), ha="left", va="center")
    axes.axvline(at, color=INK, linewidth=0.9)
    axes.margins(x=_room_beside([quantity.text(end) for quantity in order for end in ends[quantity][2:]], axes))
    axes.legend(loc="lower right", fontsize=9.0, frameon=True, framealpha=0.85, edgecolor="none")
    said = "; ".join(
        f"{q.name} from {outcome.text(ends[q][0])} (at {q.text(ends[q][2])}) "
        f"to {outcome.text(ends[q][1])} (at {q.text(ends[q][3])})"
        for q in order
    )
    text = f"Mean of {outcome.label} in the tenth of rows with the least and with the largest values of each parameter: {said}."
    return Plot(slug("tornado", outcome.name), title_of(axes), text + _left_out(ends), done(axes, legend=False))


def _ends(column: Floats, results: Floats) -> tuple[float, float, float, float]:
    """Mean of the outcome at the least and the largest values, and the mean of those values."""
    x, y = finite(column, results)
    low, high = np.quantile(x, [_SHARE, 1.0 - _SHARE])
    least, most = x <= low, x >= high
    return float(y[least].mean()), float(y[most].mean()), float(x[least].mean()), float(x[most].mean())


def _room_beside(words: Sequence[str], axes: Axes) -> float:
    """Margin on each side of bars, in parts of their length, so that words have room beside them."""
    widest = 0.09 * max(map(len, words), default=0) + 0.1  # inches
    part = min(0.4, widest / (axes.get_position().width * WIDTH))
    return part / (1.0 - 2.0 * part)


def _bars(title: str, xlabel: str, names: Sequence[str]) -> Axes:
    axes = new_axes(title, xlabel=xlabel, ylabel="")
    figure = axes.get_figure()
    assert figure is not None
    height = max(HEIGHT, 1.5 + 0.32 * len(names))
    figure.set_size_inches(figure.get_size_inches()[0], height)  # type: ignore[union-attr]
    written, left, size = room_for_names(names)
    axes.set_position((left, 0.5 / height, 0.968 - left, 1.0 - 0.95 / height))
    axes.set_yticks(np.arange(len(names)), written, fontsize=size)
    put_title(axes, title, at=min(left, 0.105))
    axes.set_ylim(len(names) + 0.3, -0.6)  # room below for the legend
    axes.grid(visible=False, axis="y")
    return axes


def _draw_bars(axes: Axes, found: Sequence[Interval], *, index: int, shift: float, label: str, hatch: str) -> None:
    values = np.array([one.value for one in found])
    places = np.arange(values.size) - shift
    below = np.maximum(values - [one.low for one in found], 0.0)
    above = np.maximum([one.high for one in found] - values, 0.0)
    width = 0.36 if shift else 0.55
    colour = PALETTE[0] if index == 0 else PALETTE[5]
    axes.barh(
        places, values, width, color=colour, hatch=hatch, edgecolor="white" if not hatch else INK, linewidth=0.4, label=label
    )
    axes.errorbar(values, places, xerr=[below, above], fmt="none", ecolor=INK, elinewidth=1.1, capsize=3.0, zorder=4)


def _left_out(found: Sized) -> str:
    return f" The {_MOST} largest of {len(found)}." if len(found) > _MOST else ""


def idle_sentence(names: Sequence[str]) -> str:
    """What is said of parameters without effect; empty where there are none."""
    return f"Without any effect: {listed(names)}." if names else ""
