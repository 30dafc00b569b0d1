"""How every figure looks: size, palette, axes, and how it becomes a file or part of a page."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

# Okabe and Ito, "Color Universal Design" (2008): told apart with any common colour blindness. Their yellow is left out:
# it is too pale for a line on white.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: tuple[Any, ...] = ("-", (0, (5, 3)), (0, (1.5, 1.5)), (0, (6, 2.5, 1.2, 2.5)))
"""Line styles that go with the colours: readable in black and white, and of two lines that coincide both show."""

WIDTH, HEIGHT = 7.2, 3.9  # inches
_AXES = (0.105, 0.125, 0.868, 0.765)  # left, bottom, width, height, in parts of the figure
_LEGEND_INSIDE = 5  # a legend of more lines would cover them: it goes beside the axes
INK, GRID, FAINT = "#222222", "#e3e3e3", "#8a8a8a"

_STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial", "Helvetica"],
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titlepad": 15.0,
    "axes.formatter.useoffset": False,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "lines.linewidth": 1.8,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "savefig.facecolor": "white",
    # text stays text: small files that can be searched; the same run gives the same bytes
    "svg.fonttype": "none",
    "text.parse_math": False,
    "svg.hashsalt": "ridedown",
}


@dataclass(frozen=True)
class Plot:
    """A finished figure: the file's stem, its title, what it shows in words, and the drawing."""

    name: str
    title: str
    description: str
    figure: Figure

    @cached_property
    def svg(self) -> bytes:
        """The drawing as SVG."""
        return self._save("svg", metadata={"Date": None, "Creator": "ridedown", "Title": self.title})

    def png(self, dpi: int = 150) -> bytes:
        """The drawing as PNG at `dpi` dots per inch."""
        return self._save("png", dpi=dpi, metadata={"Title": self.title})

    def data_uri(self) -> str:
        """The drawing for the `src` of an HTML image, so that a page needs no other file."""
        return "data:image/svg+xml;base64," + base64.b64encode(self.svg).decode("ascii")

    def _save(self, kind: str, **options: Any) -> bytes:
        buffer = io.BytesIO()
        with mpl.rc_context(_STYLE):
            self.figure.savefig(buffer, format=kind, **options)
        return buffer.getvalue()


def new_axes(title: str, *, xlabel: str, ylabel: str) -> Axes:
    """Empty axes on a figure of their own, in the house style; never through pyplot, which keeps figures alive."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(WIDTH, HEIGHT))
        FigureCanvasAgg(figure)
        # fixed places: a layout engine would take most of the time that a figure costs
        axes = figure.add_axes(_AXES)
        axes.set_title(title)
        axes.set_xlabel(xlabel)
        axes.set_ylabel(ylabel)
        axes.yaxis.set_label_coords(-0.088, 0.5)
    return axes


def draw_line(axes: Axes, x: Any, y: Any, *, label: str, index: int, dash: int | None = None) -> None:
    """A line in the colour of `index`; its dashes follow the index too unless `dash` is given."""
    style = DASHES[(index if dash is None else dash) % len(DASHES)]
    axes.plot(x, y, color=PALETTE[index % len(PALETTE)], linestyle=style, linewidth=_STYLE["lines.linewidth"], label=label)


def mark_point(axes: Axes, x: float, y: float, *, index: int) -> None:
    """A dot in the colour of `index`, at a peak."""
    axes.plot([x], [y], "o", color=PALETTE[index % len(PALETTE)], markersize=5.0, zorder=3)


def mark_times(axes: Axes, times_ms: Sequence[float]) -> None:
    """Mark moments, in order, with thin lines, numbered from 1 above the axes; where they crowd, `3-5` in one place."""
    if not times_ms:
        return
    upright = axes.get_xaxis_transform()  # x in data, y in parts of the axes' height
    axes.vlines(times_ms, 0.0, 1.0, transform=upright, colors=FAINT, linewidths=0.5, linestyles=(0, (1, 2)), zorder=1)
    low, high = axes.get_xlim()
    widest = 2 * len(str(len(times_ms))) + 1  # characters in a label such as 13-24
    for first, last in _groups(times_ms, 0.011 * widest * (high - low)):
        text = f"{first + 1}" if first == last else f"{first + 1}–{last + 1}"
        axes.annotate(
            text, (times_ms[first], 1.0), xycoords=("data", "axes fraction"), xytext=(0, 2), textcoords="offset points",
            ha="center", va="bottom", fontsize=7.5, color=FAINT,
        )  # fmt: skip


def _groups(times: Sequence[float], apart: float) -> list[tuple[int, int]]:
    """First and last index of each run of times in which all are within `apart` of the first."""
    starts = [0]
    for i, time in enumerate(times):
        if time - times[starts[-1]] > apart:
            starts.append(i)
    return list(zip(starts, [*(start - 1 for start in starts[1:]), len(times) - 1], strict=True))


def finish(axes: Axes) -> Figure:
    """Put the zero line and the legend in; returns the figure."""
    axes.axhline(0.0, color=INK, linewidth=0.7, zorder=1)
    handles, _ = axes.get_legend_handles_labels()
    if len(handles) > _LEGEND_INSIDE:
        left, bottom, width, height = _AXES
        axes.set_position((left, bottom, 0.72 * width, height))
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=_STYLE["legend.fontsize"], frameon=False)
    elif len(handles) > 1:
        axes.legend(loc="best", fontsize=_STYLE["legend.fontsize"], frameon=True, framealpha=0.85, edgecolor="none")
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    return figure
