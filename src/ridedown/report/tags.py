"""Words at the ends of lines that never lie over each other: each at its end, or a little away with a leader line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation, Text
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_AWAY = (5.0, 9.0, 14.0, 20.0, 26.0, 32.0, 40.0, 50.0)  # from the end of the line to the word, pixels
_TURNS = (0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2, 1.6, -1.6, 2.0, -2.0)  # from the direction that the line ends in, radians
_APART = 2.0  # between two words, pixels: another font may be wider
_LEADER = 12.0  # further away than this a word has a line to it, pixels
_ROUNDS = 6
_STEP = 3.0  # between the points that stand for a line, pixels
# so many pixels further away a word rather goes than to be turned aside by a radian, to cover a point of a line, or to have
# its leader line cross one
_TURNED, _COVERED, _CROSSED = 9.0, 8.0, 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Tag:
    """A word and the line that it names: x and y in the units of the axes, (n,). It goes to the last place that is known."""

    text: str
    x: Floats
    y: Floats
    colour: str


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle, in pixels."""

    left: float
    bottom: float
    right: float
    top: float

    def overlaps(self, other: Box) -> bool:
        """Whether any of it lies in another.

        >>> Box(0, 0, 2, 2).overlaps(Box(1, 1, 3, 3)), Box(0, 0, 2, 2).overlaps(Box(2, 0, 3, 2))
        (True, False)
        """
        return self.left < other.right and other.left < self.right and self.bottom < other.top and other.bottom < self.top

    def within(self, other: Box) -> bool:
        """Whether all of it lies in another."""
        across = self.left >= other.left and self.right <= other.right
        return across and self.bottom >= other.bottom and self.top <= other.top

    @property
    def middle(self) -> Floats:
        """Its middle, (2,)."""
        return np.array([0.5 * (self.left + self.right), 0.5 * (self.bottom + self.top)])

    def count(self, points: Floats) -> int:
        """How many of the points (P, 2) lie in it."""
        x, y = points[:, 0], points[:, 1]
        return int(((x > self.left) & (x < self.right) & (y > self.bottom) & (y < self.top)).sum())


def place_tags(axes: Axes, families: Sequence[Sequence[Tag]]) -> tuple[Tag, ...]:
    """Put each word where it covers no other, and as little of the lines as can be; returns those that found no place.

    families: lines of one kind, in order. A word is nearer to the end of its own line than to that of another of its kind, so
    that it is never read as the name of that. To be called last: the limits of the axes and their place in the figure must stay
    as they are from here on.
    """
    frame = axes.get_window_extent()
    area = Box(frame.x0 + 1.0, frame.y0 + 1.0, frame.x1 - 1.0, frame.y1 - 1.0)
    shapes = [np.asarray(line.get_transform().transform(line.get_xydata())) for line in axes.get_lines()]
    lines = np.concatenate([np.zeros((0, 2)), *(points_along(shape) for shape in shapes)])
    words: list[_Word] = []
    for family in families:
        paths = {k: _path(axes, tag) for k, tag in enumerate(family)}
        ends = np.array([path[-1] for path in paths.values() if len(path)])
        for k in _outside_in(len(family)):
            if len(paths[k]):
                text = _written(axes, family[k])
                words.append(_Word(family[k], paths[k], ends, text, _size(axes, text)))
    places = _arranged(words, area, lines)
    for k, word in enumerate(words):
        if k not in places:
            word.text.remove()
            continue
        word.text.set_position(tuple((places[k].middle - word.path[-1]) * 72.0 / axes.figure.dpi))
        assert word.text.arrow_patch is not None
        word.text.arrow_patch.set_visible(bool(len(_leader(word.path[-1], places[k]))))
    return tuple(word.tag for k, word in enumerate(words) if k not in places)


@dataclass(frozen=True, slots=True, eq=False)
class _Word:
    """A word to be placed: its line (n, 2), the ends of all lines of the kind (m, 2), and its width and height, in pixels."""

    tag: Tag
    path: Floats
    ends: Floats
    text: Annotation
    size: tuple[float, float]


def _outside_in(count: int) -> list[int]:
    """The first and the last, then what lies halfway between: where there is no room for all, those that are left tell most.

    >>> _outside_in(5)
    [0, 4, 2, 1, 3]
    """
    order, gaps = [0, count - 1][:count], [(0, count - 1)]
    while gaps:
        low, high = gaps.pop(0)
        if high - low > 1:
            middle = (low + high) // 2
            order.append(middle)
            gaps += [(low, middle), (middle, high)]
    return order


def _path(axes: Axes, tag: Tag) -> Floats:
    """A line in pixels where it is known, (n, 2)."""
    known = np.isfinite(tag.x) & np.isfinite(tag.y)
    return np.asarray(axes.transData.transform(np.column_stack((tag.x[known], tag.y[known]))))


def _written(axes: Axes, tag: Tag) -> Annotation:
    last = np.flatnonzero(np.isfinite(tag.x) & np.isfinite(tag.y))[-1]
    return axes.annotate(
        tag.text, (float(tag.x[last]), float(tag.y[last])), xytext=(0.0, 0.0), textcoords="offset points",
        ha="center", va="center", color=tag.colour, fontsize=8.5,
        arrowprops={"arrowstyle": "-", "color": tag.colour, "linewidth": 0.6, "shrinkA": 0.0, "shrinkB": 1.0},
        bbox={"boxstyle": "square,pad=0.05", "facecolor": "white", "edgecolor": "none", "alpha": 0.75},
    )  # fmt: skip


def _size(axes: Axes, text: Annotation) -> tuple[float, float]:
    canvas = axes.figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    renderer = canvas.get_renderer()  # type: ignore[no-untyped-call]
    extent = Text.get_window_extent(text, renderer)  # of the word without its leader line
    return float(extent.width), float(extent.height)


def _arranged(words: Sequence[_Word], area: Box, lines: Floats) -> dict[int, Box]:
    """Where each word goes, by its number.

    One after the other takes the best place that is left; those that find none come first in the next round.
    """
    order, most = list(range(len(words))), dict[int, Box]()
    for _ in range(_ROUNDS):
        places, leaders = dict[int, Box](), np.zeros((0, 2))
        for k in order:
            place = _best(words[k], area, list(places.values()), (lines, leaders))
            if place is not None:
                places[k] = place
                leaders = np.concatenate((leaders, _leader(words[k].path[-1], place)))
        if len(places) > len(most):
            most = places
        if len(most) == len(words):
            break
        order = [k for k in order if k not in places] + [k for k in order if k in places]
    return most


def _best(word: _Word, area: Box, taken: Sequence[Box], drawn: tuple[Floats, Floats]) -> Box | None:
    """The place that costs least of those within the area that touch no word, and whose leader line touches no other.

    drawn: points of lines, and of leader lines, (P, 2) each.
    """
    lines, leaders = drawn
    best, least = None, np.inf
    for place, cost in _places(word.path, word.size):
        if cost >= least or not place.within(area) or not _nearest(place, word):
            continue
        if any(place.overlaps(other) for other in taken) or place.count(leaders):
            continue
        leader = _leader(word.path[-1], place)
        if any(other.count(leader) for other in taken) or _touching(leader, leaders):
            continue
        whole = cost + _COVERED * place.count(lines) + _CROSSED * _touching(leader, lines)
        if whole < least:
            best, least = place, whole
    return best


def _nearest(place: Box, word: _Word) -> bool:
    """Whether no other line of the kind ends nearer to the middle of the place; some end in one point."""
    away = np.hypot(*(word.ends - place.middle).T)
    own = float(np.hypot(*(word.path[-1] - place.middle)))
    return bool(own <= away.min() + 0.5)


def _touching(leader: Floats, others: Floats) -> int:
    """How many points of a leader line touch others; where it begins it may."""
    away = leader[2:]
    if not len(away) or not len(others):
        return 0
    return int((np.abs(away[:, None, :] - others[None, :, :]).max(axis=2) < _STEP).any(axis=1).sum())


def _places(path: Floats, size: tuple[float, float]) -> Iterator[tuple[Box, float]]:
    """Places for a word about the end of a line, and what each costs for being away and aside."""
    end = path[-1]
    # of the last stretch that a word is long, not of the last step: that may be a kink
    far = path[np.hypot(*(path - end).T) > size[0]]
    way = end - (far[-1] if len(far) else path[0])
    ahead = float(np.arctan2(way[1], way[0])) if way.any() else 0.0
    half = 0.5 * np.array(size) + 0.5 * _APART
    for turn in _TURNS:
        to = np.array([np.cos(ahead + turn), np.sin(ahead + turn)])
        for away in _AWAY:
            low, high = end + to * (away + np.abs(to) @ half) - half, end + to * (away + np.abs(to) @ half) + half
            yield Box(*map(float, (*low, *high))), away + _TURNED * abs(turn)


def _leader(end: Floats, box: Box) -> Floats:
    """Points along the line from the end of a line to its word, (P, 2); none where they are next to each other."""
    nearest = np.clip(end, (box.left, box.bottom), (box.right, box.top))
    if np.hypot(*(nearest - end)) <= _LEADER:
        return np.zeros((0, 2))
    return points_along(np.array([end, nearest]))[1:]


def points_along(path: Floats) -> Floats:
    """Points that stand for a line, (P, 2), none further from the next than a few pixels; it is broken where it has no value.

    >>> points_along(np.array([[0.0, 0.0], [6.0, 0.0]])).tolist()
    [[0.0, 0.0], [6.0, 0.0], [3.0, 0.0]]
    """
    pieces = [path[np.isfinite(path).all(axis=1)]]
    for one, other in pairwise(path):
        length = float(np.hypot(*(other - one)))
        if np.isfinite(length) and length > _STEP:
            parts = np.arange(_STEP, length, _STEP)[:, None] / length
            pieces.append(one + parts * (other - one))
    found: Floats = np.concatenate(pieces)
    return found
