"""Figures of an optimisation: the Pareto front with the chosen design, and all designs on parallel axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from numpy.typing import ArrayLike

from ridedown.report.study_axes import Bar, Floats, Quantity, done, limit_level, limit_upright, note, slug
from ridedown.report.style import FAINT, INK, PALETTE, WIDTH, Plot, broken, letters, new_axes, title_of


def front_plot(
    x: Quantity,
    y: Quantity,
    points: tuple[ArrayLike, ArrayLike],
    *,
    chosen: int | None = None,
    beside: Mapping[str, tuple[float, float]] | None = None,
    bound: tuple[ArrayLike, ArrayLike] | None = None,
    limits: tuple[Sequence[Bar], Sequence[Bar]] = ((), ()),
) -> Plot:
    """The designs of which none is better in one goal without being worse in the other: points (R,) and (R,), SI.

    chosen: the row that was chosen. beside: other designs by name, such as the one that is built. bound: the curve below which
    no design can be, (n,) and (n,). limits: on x, and on y.
    """
    across, up = x.shown(points[0]), y.shown(points[1])
    order = np.argsort(across)
    axes = new_axes(f"Pareto front: {y.name} against {x.name}", xlabel=x.label, ylabel=y.label)
    axes.step(across[order], up[order], where="post", color=PALETTE[0], linewidth=1.0, alpha=0.6)
    axes.plot(across, up, "o", color=PALETTE[0], markersize=4.5, label="front")
    text = (
        f"{y.label} against {x.label}: {across.size} designs of which none is better in one without being worse in the other."
    )
    if bound is not None:
        axes.plot(
            x.shown(bound[0]),
            y.shown(bound[1]),
            color=INK,
            linewidth=1.4,
            linestyle=(0, (5, 3)),
            label="no restraint can do better",
        )
        text += " Dashed: the least that any restraint could give."
    for k, (name, (a, b)) in enumerate((beside or {}).items()):
        axes.plot(x.shown(a), y.shown(b), "s", color=PALETTE[3 + k % 3], markersize=7.0, label=name, zorder=4)
        text += f" {name}: {x.text(a)}, {y.text(b)}."
    if chosen is not None:
        a, b = np.asarray(points[0])[chosen], np.asarray(points[1])[chosen]
        axes.plot(across[chosen], up[chosen], "D", color=PALETTE[1], markersize=9.0, label="chosen", zorder=5)
        at = float(across[chosen]), float(up[chosen])
        note(axes, f"{x.text(a)}, {y.text(b)}", at, ha="right" if at[0] > np.quantile(axes.get_xlim(), 0.7) else "left")
        text += f" Chosen: {x.text(a)}, {y.text(b)}."
    for limit in limits[0]:
        limit_upright(axes, x, limit)
    for limit in limits[1]:
        limit_level(axes, y, limit)
    return Plot(slug("front", y.name, x.name), title_of(axes), text, done(axes))


def parallel_plot(
    quantities: Sequence[Quantity], columns: Sequence[ArrayLike], *, chosen: int | None = None, shade: int = -1, title: str = ""
) -> Plot:
    """Designs as lines across upright axes, one a quantity: columns (R,) each, SI.

    shade: the quantity whose value gives a line its shade, the last if left out. chosen: the row drawn thick.
    """
    values = [np.asarray(column, dtype=np.float64) for column in columns]
    ends = [_ends(column) for column in values]
    parts = np.array([(column - low) / (high - low) for column, (low, high) in zip(values, ends, strict=True)])
    axes = new_axes(title or "Designs, parameter by parameter", xlabel="", ylabel="")
    axes.set_position((0.06, 0.19, 0.88, 0.68))
    places = [float(place) for place in range(len(quantities))]
    apart = min(0.86, 0.88 * WIDTH / max(1, len(quantities) - 1))  # inches
    names = [broken(quantity.name, ".", 3) for quantity in quantities]
    ends_said = [quantity.text(end) for quantity, pair in zip(quantities, ends, strict=True) for end in pair]
    size = min(letters(word, 0.97 * apart, 8.0) for word in (*names, *ends_said))

    colours = mpl.colormaps["cividis"](parts[shade])
    for row in np.argsort(-parts[shade]):
        axes.plot(places, parts[:, row], color=colours[row], linewidth=0.9, alpha=0.7)
    if chosen is not None:
        axes.plot(places, parts[:, chosen], color=PALETTE[1], linewidth=2.8, marker="o", markersize=5.0, zorder=5)
    for place, quantity, (low, high) in zip(places, quantities, ends, strict=True):
        axes.plot([place, place], [0.0, 1.0], color=FAINT, linewidth=0.9, zorder=1)  # no further: there are the words
        for height, value, va in ((1.0, high, "bottom"), (0.0, low, "top")):
            axes.annotate(
                quantity.text(value),
                (place, height),
                xytext=(0, 3 if va == "bottom" else -3),
                textcoords="offset points",
                ha="center",
                va=va,
                fontsize=size,
            )
    axes.set_xticks(places, names, fontsize=size)
    axes.tick_params(axis="x", pad=16, length=0)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.spines["bottom"].set_visible(False)
    axes.set_ylim(-0.06, 1.06)
    axes.grid(visible=False)
    labels = ", ".join(quantity.label for quantity in quantities)
    text = f"{parts.shape[1]} designs, each a line across {labels}; shade by {quantities[shade].name}."
    if chosen is not None:
        said = ", ".join(f"{q.name} {q.text(float(column[chosen]))}" for q, column in zip(quantities, values, strict=True))
        text += f" Chosen (thick): {said}."
    return Plot("parallel", title_of(axes), text, done(axes, legend=False))


def _ends(column: Floats) -> tuple[float, float]:
    low, high = float(np.nanmin(column)), float(np.nanmax(column))
    return (low, high) if high > low else (low - 0.5 * (abs(low) or 1.0), high + 0.5 * (abs(high) or 1.0))
