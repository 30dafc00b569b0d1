"""Figures of a sample: how an outcome is spread, with its limit and how likely that is exceeded."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from ridedown.report.study_axes import LIMIT, Bar, Quantity, done, finite, note, slug
from ridedown.report.style import INK, PALETTE, Plot, draw_line, new_axes, title_of

_BINS = 60


def distribution_plot(
    outcome: Quantity,
    values: ArrayLike,
    *,
    limits: Sequence[Bar] = (),
    said: Sequence[str] = (),
    quantiles: Mapping[float, float] | None = None,
) -> Plot:
    """A histogram of an outcome: values (R,), SI. limits: each with what is `said` of it; quantiles: share to value."""
    (known,) = finite(np.asarray(values, dtype=np.float64))
    shown = outcome.shown(known)
    axes = new_axes(f"Distribution of {outcome.name}", xlabel=outcome.label, ylabel=_density(outcome))
    if known.size and np.ptp(shown) > 0.0:
        low, high = np.quantile(shown, [0.0005, 0.9995])  # the last few of a long tail would leave no room for the rest
        inside = shown[(shown >= low) & (shown <= high)]
        counts, edges = np.histogram(inside, bins=min(_BINS, max(10, int(np.sqrt(inside.size)))))
        heights = counts / (known.size * np.diff(edges))
        bad = _beyond(outcome, edges, limits)
        axes.bar(
            edges[:-1],
            heights,
            np.diff(edges),
            align="edge",
            color=np.where(bad, LIMIT, PALETTE[0]),
            alpha=0.75,
            linewidth=0.3,
            edgecolor="white",
        )
    axes.set_ylim(0.0, 1.3 * axes.get_ylim()[1])  # room above for words
    _mark_quantiles(axes, outcome, quantiles or {})
    for k, limit in enumerate(limits):
        _mark_limit(axes, outcome, limit, said[k] if k < len(said) else "", k)
    text = f"Share of rows per unit of {outcome.label}, {known.size:,} rows."
    if known.size:
        text += f" Mean {outcome.text(float(known.mean()))}, standard deviation {outcome.text(float(known.std()))}."
    text += "".join(f" {100 * share:g} % are at most {outcome.text(value)}." for share, value in (quantiles or {}).items())
    text += "".join(
        f" Limit, {limit.words(outcome)}{f': {word}' if word else ''}."
        for limit, word in zip(limits, [*said, *[""] * len(limits)], strict=False)
    )
    return Plot(slug("distribution", outcome.name), title_of(axes), text, done(axes, legend=False))


def cumulative_plot(outcome: Quantity, values: ArrayLike, *, limits: Sequence[Bar] = (), said: Sequence[str] = ()) -> Plot:
    """The share of rows at or above each value, on a logarithmic scale, so that rare ones show: values (R,), SI."""
    (known,) = finite(np.asarray(values, dtype=np.float64))
    axes = new_axes(f"How often {outcome.name} is exceeded", xlabel=outcome.label, ylabel="share of rows above")
    rising = np.sort(known)
    share = 1.0 - np.arange(1, rising.size + 1) / (rising.size + 1.0)
    kept = (
        np.unique(
            np.concatenate((np.linspace(0, rising.size - 1, 400), rising.size - np.geomspace(1, rising.size, 200))).astype(int)
        )
        if rising.size
        else np.zeros(0, dtype=int)
    )
    draw_line(axes, outcome.shown(rising[kept]), share[kept], label="rows", index=0)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(lambda share, _: f"{100.0 * share:g} %")
    axes.yaxis.set_minor_formatter(lambda _share, _: "")
    axes.yaxis.set_label_coords(-0.088, 0.5)
    for k, limit in enumerate(limits):
        # low on the left, high on the right: where the curve, which falls, is not
        _mark_limit(axes, outcome, limit, said[k] if k < len(said) else "", k, falls=True)
    text = f"Share of rows with a larger {outcome.label}; the vertical axis is logarithmic. {known.size:,} rows."
    return Plot(slug("exceeded", outcome.name), title_of(axes), text, done(axes, legend=False))


def _density(outcome: Quantity) -> str:
    return f"share of rows per {outcome.read_in}" if outcome.read_in else "share of rows per unit"


def _beyond(outcome: Quantity, edges: np.ndarray, limits: Sequence[Bar]) -> np.ndarray:
    bad = np.zeros(edges.size - 1, dtype=np.bool_)
    for limit in limits:
        at = float(outcome.shown(limit.value))
        bad |= edges[:-1] >= at if limit.most else edges[1:] <= at
    return bad


def _mark_limit(axes: Axes, outcome: Quantity, limit: Bar, said: str, k: int, *, falls: bool = False) -> None:
    at = float(outcome.shown(limit.value))
    axes.axvline(at, color=LIMIT, linewidth=2.0)
    low, high = axes.get_xlim()
    axes.set_xlim(min(low, at - 0.03 * (high - low)), max(high, at + 0.03 * (high - low)))
    left = at > 0.5 * sum(axes.get_xlim())
    text = f"limit {outcome.text(limit.value)}" + (f"\n{said}" if said else "")
    low_down = falls and left
    axes.annotate(
        text, (at, 0.03 + 0.16 * k if low_down else 0.98 - 0.16 * k), xycoords=("data", "axes fraction"),
        xytext=(-5 if left else 5, 0), textcoords="offset points",
        ha="right" if left else "left", va="bottom" if low_down else "top", fontsize=9.0, color=LIMIT,
        bbox={"boxstyle": "square,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.8},
    )  # fmt: skip


def _mark_quantiles(axes: Axes, outcome: Quantity, quantiles: Mapping[float, float]) -> None:
    top = axes.get_ylim()[1]
    for share, value in quantiles.items():
        at = float(outcome.shown(value))
        axes.plot([at, at], [0.0, 0.05 * top], color=INK, linewidth=1.4, zorder=4)
        note(axes, f"{100 * share:g} %", (at, 0.05 * top))
