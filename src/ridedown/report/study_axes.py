"""What the figures of studies share: quantities in the units that people read, and a limit drawn in."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from ridedown.criteria import STANDARD_GRAVITY
from ridedown.report.style import INK, PALETTE, put_title, room_for_ticks, title_of

Floats = NDArray[np.float64]

_READ: Mapping[str, tuple[str, float]] = {
    "m": ("mm", 1e3),
    "s": ("ms", 1e3),
    "m/s": ("km/h", 3.6),
    "m/s2": ("g", 1.0 / STANDARD_GRAVITY),
    "N": ("kN", 1e-3),
    "N/m": ("kN/m", 1e-3),
    "N s/m": ("kN s/m", 1e-3),
    "J": ("kJ", 1e-3),
    "rad": ("degrees", 180.0 / np.pi),
}
"""SI units to those that are drawn, and the factor."""

_WHOLE, _POWERS, _SMALL = 9999.5, 1e7, 1e-3
"""From where to where numbers have all their digits before the point; below what those with a unit have four decimals."""

_TWO_BESIDE = 42  # characters: entries of a legend that are no longer go two in a row

LIMIT = PALETTE[1]
"""Colour of a limit, in every figure."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A parameter or an outcome: its name, its SI unit, and how it is read.

    >>> Quantity("adult.excursion.max", "m").label
    'adult.excursion.max, mm'
    """

    name: str
    unit: str = ""

    @property
    def read_in(self) -> str:
        """The unit that it is read in; empty for a plain number."""
        return _READ.get(self.unit, (self.unit, 1.0))[0]

    @property
    def scale(self) -> float:
        """What a value in SI is multiplied with."""
        return _READ.get(self.unit, (self.unit, 1.0))[1]

    @property
    def nothing(self) -> float:
        """The size, as it is read, below which a value with a unit is rounding, told as 0.0000; 0 of a plain number."""
        return 0.5e-4 if self.read_in else 0.0

    @property
    def label(self) -> str:
        """Name and unit, as an axis has them."""
        return f"{self.name}, {self.read_in}" if self.read_in else self.name

    def shown(self, values: ArrayLike) -> Floats:
        """Values in the unit that is read."""
        scaled: Floats = self.scale * np.asarray(values, dtype=np.float64)
        return scaled

    def text(self, value: float, *, unit: bool = True) -> str:
        """One value in words, to four digits, and where it has a unit to no more than four decimals.

        >>> Quantity("speed", "m/s").text(13.333), Quantity("way", "m").text(20.0), Quantity("turn", "rad").text(-1e-17)
        ('48 km/h', '20000 mm', '0.0000 degrees')
        """
        scaled = self.scale * value
        size = abs(scaled)
        text = f"{scaled:.0f}" if _WHOLE <= size < _POWERS else f"{scaled:.4g}"
        if self.read_in and 0.0 < size < _SMALL:
            text = f"{scaled if size >= self.nothing else 0.0:.4f}"
        text = text.replace("-", "\u2212")
        return f"{text} {self.read_in}" if unit and self.read_in else text


@dataclass(frozen=True, slots=True)
class Bar:
    """A limit on an outcome, in SI: at most, or at least, so much."""

    value: float
    most: bool = True

    def broken(self, values: ArrayLike) -> NDArray[np.bool_]:
        """Which values break it."""
        given = np.asarray(values, dtype=np.float64)
        found: NDArray[np.bool_] = given > self.value if self.most else given < self.value
        return found

    def words(self, quantity: Quantity) -> str:
        """The limit as it is said."""
        return f"{'at most' if self.most else 'at least'} {quantity.text(self.value)}"


def slug(*parts: str) -> str:
    """Names as part of a file's name.

    >>> slug("map", "adult.excursion.max")
    'map-adult-excursion-max'
    """
    return re.sub(r"[^a-z0-9]+", "-", "-".join(parts).lower()).strip("-")


def limit_upright(axes: Axes, quantity: Quantity, limit: Bar) -> None:
    """A limit on the horizontal axis, and the side of it that is not allowed."""
    at = float(quantity.shown(limit.value))
    low, high = axes.get_xlim()
    low, high = min(low, at - 0.02 * (high - low)), max(high, at + 0.02 * (high - low))
    axes.axvspan(*((at, high) if limit.most else (low, at)), color=LIMIT, alpha=0.08, linewidth=0.0)
    axes.axvline(at, color=LIMIT, linewidth=1.6, label=f"limit, {limit.words(quantity)}")
    axes.set_xlim(low, high)


def limit_level(axes: Axes, quantity: Quantity, limit: Bar) -> None:
    """The same on the vertical axis."""
    at = float(quantity.shown(limit.value))
    low, high = axes.get_ylim()
    low, high = min(low, at - 0.02 * (high - low)), max(high, at + 0.02 * (high - low))
    axes.axhspan(*((at, high) if limit.most else (low, at)), color=LIMIT, alpha=0.08, linewidth=0.0)
    axes.axhline(at, color=LIMIT, linewidth=1.6, label=f"limit, {limit.words(quantity)}")
    axes.set_ylim(low, high)


def done(axes: Axes, *, legend: bool = True) -> Figure:
    """The figure of axes that are finished; with a legend where there is anything to tell apart."""
    if legend and len(axes.get_legend_handles_labels()[0]) > 1:
        axes.legend(loc="best", fontsize=9.0, frameon=True, framealpha=0.85, edgecolor="none")
    room_for_ticks(axes)
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    return figure


def done_above(axes: Axes) -> Figure:
    """The figure of axes that are finished; the legend is below the title, so that it hides nothing."""
    figure = done(axes, legend=False)
    labels = axes.get_legend_handles_labels()[1]
    columns = 2 if max(map(len, labels), default=0) <= _TWO_BESIDE else 1
    rows = -(-len(labels) // columns)
    title = title_of(axes)
    place = axes.get_position()
    put_title(axes, title, pads=(8.0 + 15.0 * rows, 6.0 + 15.0 * rows))
    axes.set_position((place.x0, 0.125, place.width, 0.765 - 0.055 * rows))
    legend = axes.legend(
        loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncols=columns, fontsize=9.0, frameon=False, handletextpad=0.5,
        columnspacing=1.5, borderaxespad=0.0, markerscale=1.3,
    )  # fmt: skip
    for handle in legend.legend_handles:
        if handle is not None:
            handle.set_alpha(1.0)
    return figure


def note(axes: Axes, text: str, at: tuple[float, float], *, colour: str = INK, ha: str = "left", va: str = "bottom") -> None:
    """A word beside a place, in the units of the axes."""
    axes.annotate(
        text, at, xytext=(4 if ha == "left" else -4, 3 if va == "bottom" else -3), textcoords="offset points",
        color=colour, fontsize=8.5, ha=ha, va=va,
        bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
    )  # fmt: skip


def finite(*columns: Floats) -> tuple[Floats, ...]:
    """Columns without the rows in which any of them has no value."""
    good = np.all([np.isfinite(column) for column in columns], axis=0)
    return tuple(column[good] for column in columns)


def listed(names: Sequence[str]) -> str:
    """Names in a sentence."""
    return ", ".join(names)
