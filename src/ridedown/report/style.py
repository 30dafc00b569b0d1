"""How every figure looks: size, palette, axes, and how it becomes a file or part of a page."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

# Okabe and Ito, "Color Universal Design" (2008): told apart with any common colour blindness. Their yellow is left out:
# it is too pale for a line on white.
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
DASHES: tuple[Any, ...] = ("-", (0, (5, 3)), (0, (1.5, 1.5)), (0, (6, 2.5, 1.2, 2.5)))
"""Line styles that go with the colours: readable in black and white, and of two lines that coincide both show."""

WIDTH, HEIGHT = 7.2, 3.9  # inches
_AXES = (0.105, 0.125, 0.868, 0.765)  # left, bottom, width, height, in parts of the figure
_REGULAR, _BOLD = 0.61, 0.68  # width of a character of a name, in parts of the size of its letters
_LEAST_TITLE = 9.0  # points: before it is smaller it is in two lines
_LONG_NAME = 26  # characters: a longer one is in two lines beside its bar
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
        left, bottom, width, height = _AXES
        put_title(axes, title)
        axes.set_xlabel(xlabel, fontsize=letters(xlabel, (width + 2.0 * (1.0 - left - width)) * WIDTH))
        axes.set_ylabel(ylabel, fontsize=letters(ylabel, (height + 2.0 * (1.0 - bottom - height)) * HEIGHT))
        axes.yaxis.set_label_coords(-0.088, 0.5)
    return axes


def put_title(axes: Axes, title: str, *, pads: tuple[float, float] = (15.0, 3.0), at: float = _AXES[0]) -> None:
    """Title of axes, in two lines where one is too long.

    pads: how far above the axes it is, in one line and in two [pt]; at: where it begins, in parts of the figure's width.
    """
    room = (0.975 - at) * WIDTH
    if letters(title, room, 11.0, bold=True) < _LEAST_TITLE:
        title = broken(title, " ", 2)
    lines = title.count("\n") + 1
    place = axes.get_position()
    axes.set_title(
        title, x=(at - place.x0) / place.width, fontsize=letters(title, room, 11.0 if lines == 1 else 9.5, bold=True),
        pad=pads[lines - 1], fontweight="bold", loc="left",
    )  # fmt: skip


def title_of(axes: Axes) -> str:
    """The title in one line."""
    return axes.get_title(loc="left").replace("\n", " ")


def broken(name: str, after: str, most: int) -> str:
    r"""A name in lines, `most` at most, broken after a character so that the longest line is as short as can be.

    >>> broken("driver.restraints.belt.second_force", ".", 2)
    'driver.restraints.\nbelt.second_force'
    """
    ends = [k + 1 for k, character in enumerate(name) if character == after]
    cuts = [chosen for count in range(most) for chosen in combinations(ends, count)]
    ways = ["\n".join(name[a:b].strip() for a, b in pairwise((0, *chosen, len(name)))) for chosen in cuts]
    return min(ways, key=lambda way: (max(len(line) for line in way.split("\n")), way.count("\n")))


def room_for_ticks(axes: Axes) -> None:
    """Make the axes narrower where numbers would lie over the label at the left edge of the figure, or reach over the right."""
    figure = axes.get_figure()
    assert figure is not None
    assert isinstance(figure.canvas, FigureCanvasAgg)
    renderer = figure.canvas.get_renderer()  # type: ignore[no-untyped-call]
    place = axes.get_position()
    beyond = max((box.x1 for box in _numbers(axes.xaxis, renderer)), default=0.0) + 2.0 - figure.bbox.width
    if beyond > 0.0:
        axes.set_position((place.x0, place.y0, place.width - beyond / figure.bbox.width, place.height))
    numbers = [box.x0 for box in _numbers(axes.yaxis, renderer)]
    label = axes.yaxis.label.get_window_extent(renderer)
    if not axes.get_ylabel() or not numbers or label.x1 + 2.0 <= min(numbers):
        return
    aside = (label.x1 + 2.0 - min(numbers)) / figure.bbox.width
    place = axes.get_position()
    edge = label.x1 / figure.bbox.width
    axes.set_position((place.x0 + aside, place.y0, place.width - aside, place.height))
    axes.yaxis.set_label_coords((edge - place.x0 - aside) / (place.width - aside), 0.5)


def _numbers(axis: Axis, renderer: Any) -> list[Any]:
    """Where the numbers of an axis are that are seen, pixels."""
    low, high = sorted(axis.get_view_interval())
    ticks = zip(axis.get_majorticklocs(), axis.get_majorticklabels(), strict=True)
    return [text.get_window_extent(renderer) for at, text in ticks if low <= at <= high and text.get_text()]


def letters(text: str, room: float, size: float = 10.0, *, bold: bool = False) -> float:
    """Size of letters [pt] with which a text fits into its room [inches]: the one given, or smaller.

    >>> letters("peak, g", 3.0), round(letters("driver.chest.acceleration.peak against driver.restraint.stiffness", 3.0), 1)
    (10.0, 5.4)
    """
    longest = max((len(line) for line in text.split("\n")), default=0)
    return min(size, 72.0 * room / max(1.0, (_BOLD if bold else _REGULAR) * longest))


def room_for_names(names: Sequence[str]) -> tuple[list[str], float, float]:
    """Names beside upright axes: as they are written, long ones in two lines, the part of a figure's width that they take, two
    fifths at most, and the size of their letters [pt].
    """
    names = [broken(name, ".", 2) if len(name) > _LONG_NAME else name for name in names]
    longest = max((len(line) for name in names for line in name.split("\n")), default=0)
    widest = _REGULAR * longest * 10.0 / 72.0  # inches
    most = 0.37 * WIDTH
    return names, 0.03 + min(widest, most) / WIDTH, min(10.0, 10.0 * most / max(widest, most))


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
