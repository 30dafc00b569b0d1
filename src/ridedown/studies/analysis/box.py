"""A solution box: for each parameter a range of its own, such that any combination within the ranges holds every limit.

Whoever works on one parameter is then free within its range, whatever the others do. The box is grown and trimmed by sampling,
with all bad designs found kept in mind, and is then verified by rows that had no part in finding it: where none of n rows is
bad, the share of bad designs in the box is less than 1 - (1 - confidence)^(1/n), at that confidence.

References:
    M. Zimmermann, J. E. von Hoessle, Computing solution spaces for robust design, Int. J. Numer. Methods Eng. 94, 2013.
    J. Fender, L. Graff, H. Harbrecht, M. Zimmermann, Identifying key parameters for design improvement in high-dimensional
        systems with uncertainty, J. Mech. Des. 136, 2014.
    C. J. Clopper, E. S. Pearson, The use of confidence or fiducial limits, Biometrika 26, 1934 (no failures in n trials).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ridedown.errors import InvalidInput
from ridedown.studies.analysis.designs import Random, Seed, Sobol, seed_of
from ridedown.studies.analysis.evaluation import BATCH, Evaluator, Floats, Limit, Progress, Runs, check_count, check_share
from ridedown.studies.analysis.goals import checked_ranges

Size = Literal["volume", "shortest-side"]

_ATTEMPTS = 12
_STARTS = 20
_CONSOLIDATIONS = 20
_WIDENINGS = 4
_DECADES = 3.0  # how near to a face of the box rows are put, down to a thousandth of a side
_ORDERS = 12  # in which bad designs are cut away, of which the best is kept
_MOST_BAD = 4000  # bad designs kept in mind: those nearest to the box


@dataclass(frozen=True, slots=True)
class SolutionBox:
    """The box: least and largest value of each parameter, SI.

    share: of the volume of the ranges. bad_share: the share of designs in the box that break a limit is less than this, at the
    confidence; found by `verified` rows of which none was bad. free: parameters whose range the box fills, those without effect
    among them. binding: the limits that designs just outside the box break. Where no box was found, `ranges` is empty.
    """

    ranges: Mapping[str, tuple[float, float]]
    share: float
    bad_share: float
    confidence: float
    verified: int
    free: tuple[str, ...]
    binding: tuple[str, ...]
    evaluations: int
    failed: int
    seed: int
    warnings: tuple[str, ...]


def solution_box(
    evaluator: Evaluator,
    ranges: Mapping[str, tuple[float, float]],
    limits: Sequence[Limit],
    *,
    size: Size = "volume",
    bad_share: float = 0.01,
    confidence: float = 0.95,
    rows: int = 256,
    rounds: int = 80,
    seed: Seed = None,
    batch: int = BATCH,
    progress: Progress | None = None,
) -> SolutionBox:
    """The largest box found within the ranges (least, largest; SI) in which every limit holds. A failed row counts as bad.

    size: what is to be large, the volume or the shortest side, both of the ranges. rows, rounds: of the search. bad_share: what
    verification is to rule out, at the confidence.

    Raises: InvalidInput, UnknownName.

    >>> ranges = {"a": (0.0, 1.0), "b": (0.0, 1.0)}
    >>> found = solution_box(lambda t: {"sum": t["a"] + t["b"]}, ranges, [Limit("sum", most=1.0)], seed=0)
    >>> found.share > 0.23, found.bad_share <= 0.01
    (True, True)
    """
    if not limits:
        raise InvalidInput("limits: got none; need at least one. Name what must hold.")
    if size not in get_args(Size):
        raise InvalidInput(f"size: got {size!r}; need volume or shortest-side.")
    check_count(rows, "rows", 16)
    check_count(rounds, "rounds")
    check_share(bad_share, "bad_share")
    check_share(confidence, "confidence")
    names, low, high = checked_ranges(ranges)
    fixed = seed_of(seed)
    outcomes = [limit.outcome for limit in limits]
    total = rows * (rounds * 3 // 2 + 2 * _STARTS + 9 * len(names) + 1) + _needed(bad_share, confidence, 1)
    runs = Runs(evaluator, outcomes, batch=batch, total=total, progress=progress)
    search = _Search(runs, names, low, high, tuple(limits), size, rows, np.random.default_rng(fixed))
    box = search.grown(rounds, fixed)
    if box is None:
        none = ("No design was found that holds every limit.",)
        return SolutionBox({}, 0.0, 1.0, confidence, 0, (), (), runs.done, runs.failed, fixed, none)
    verified = 0
    for attempt in range(1, _ATTEMPTS + 1):
        # An attempt that comes after others may be lucky: each is given its part of the doubt, a (1/2 + 1/6 + 1/12 + ...) = a.
        needed = _needed(bad_share, confidence, attempt)
        unit = Random(len(names), int(np.random.SeedSequence([fixed, attempt]).generate_state(1, np.uint64)[0] >> 1))
        if not search.tried(box, unit.rows(0, needed)):
            verified = needed
            break
        box = search.trimmed(box)
    sides = np.clip(low + box * (high - low), low, high)
    doubt = (1.0 - confidence) / (attempt * (attempt + 1))
    return SolutionBox(
        {name: (float(sides[0, i]), float(sides[1, i])) for i, name in enumerate(names)},
        float(np.prod(box[1] - box[0])),
        1.0 - doubt ** (1.0 / verified) if verified else 1.0,
        confidence,
        verified,
        tuple(name for i, name in enumerate(names) if box[0, i] == 0.0 and box[1, i] == 1.0),
        search.binding(box),
        runs.done,
        runs.failed,
        fixed,
        () if verified else (f"Bad designs were found in the box at every one of {_ATTEMPTS} verifications. Take more rows.",),
    )


def _needed(bad_share: float, confidence: float, attempt: int) -> int:
    """Rows without a bad one that rule out a share of bad designs, at the attempt's part of the doubt."""
    doubt = (1.0 - confidence) / (attempt * (attempt + 1))
    return int(np.ceil(np.log(doubt) / np.log1p(-bad_share)))


class _Search:
    """The search in the unit cube. A box is (2, d): least and largest of each side."""

    def __init__(
        self,
        runs: Runs,
        names: tuple[str, ...],
        low: Floats,
        high: Floats,
        limits: tuple[Limit, ...],
        size: str,
        rows: int,
        rng: np.random.Generator,
    ) -> None:
        self._runs, self._names, self._low, self._high = runs, names, low, high
        self._limits, self._size, self._rows, self._rng = limits, size, rows, rng
        self._bad = np.empty((0, len(names)))
        self._broken = np.empty((0, len(limits)), dtype=np.bool_)
        self._good = np.empty((0, len(names)))
        self._idle = np.zeros(len(names), dtype=np.bool_)

    def _excesses(self, unit: Floats) -> Floats:
        """How far designs (R, d) are beyond each limit, in parts of its bound, (R, q); infinite where a row failed."""
        values = self._low + unit * (self._high - self._low)
        found = self._runs({name: values[:, i] for i, name in enumerate(self._names)})
        excess = np.stack([limit.excess(found[limit.outcome]) / (abs(limit.bound) or 1.0) for limit in self._limits], axis=1)
        return np.where(np.isnan(excess), np.inf, excess)

    def _excess(self, unit: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """How far designs (R, d) are beyond the worst limit, and which they break (R, q)."""
        excess = self._excesses(unit)
        return excess.max(axis=1), excess > 0.0

    def _add(self, unit: Floats, broken: NDArray[np.bool_]) -> None:
        bad = broken.any(axis=1)
        self._bad = np.concatenate([self._bad, unit[bad]])
        self._good = np.concatenate([self._good, unit[~bad]])
        self._broken = np.concatenate([self._broken, broken[bad]])

    def tried(self, box: Floats, unit: Floats) -> int:
        """Number of bad designs among rows of the unit cube put into the box; they are kept in mind."""
        rows = box[0] + unit * (box[1] - box[0])
        _, broken = self._excess(rows)
        self._add(rows, broken)
        return int(broken.any(axis=1).sum())

    def grown(self, rounds: int, seed: int) -> Floats | None:
        """The largest box found that holds no bad design known; None where every design is bad."""
        start = self._start(seed)
        if start is None:
            return None
        self._idle = self._without_effect()
        box, reach = np.stack([start, start]), 0.25
        box[:, self._idle] = [[0.0], [1.0]]
        for _ in range(rounds):
            # Farther out than the box, so that it can grow, but not so far that nearly all is bad: toward the end, its sides
            # become exact.
            wide = np.stack([np.maximum(box[0] - reach, 0.0), np.minimum(box[1] + reach, 1.0)])
            around = wide[0] + self._rng.random((self._rows, len(start))) * (wide[1] - wide[0])
            rows = np.concatenate([around, box[0] + self._edges(self._rows // 2) * (box[1] - box[0])])
            _, broken = self._excess(rows)
            self._add(rows, broken)
            box = self._best_within(wide, box)
            share = float(broken[: self._rows].any(axis=1).mean())
            reach = float(np.clip(reach * (0.8 if share > 0.4 else 1.25 if share < 0.2 else 1.0), 1e-3, 0.5))
        return self._consolidated(self._widened(self._consolidated(box)))

    def _consolidated(self, box: Floats) -> Floats:
        """The box trimmed until rows in it, many of them near its edges and corners, show no bad design."""
        for _ in range(_CONSOLIDATIONS):
            if not self.tried(box, self._edges(self._rows)):
                break
            box = self.trimmed(box)
        return box

    def _widened(self, box: Floats) -> Floats:
        """The box with each face moved out as far as no bad design is found: cutting may have taken more than it had to."""
        for i in range(box.shape[1]):
            for side in (0, 1):
                for _ in range(_WIDENINGS):
                    wider = self._moved_out(box, i, side)
                    added = wider.copy()
                    added[1 - side, i] = box[side, i]
                    if added[0, i] == added[1, i]:
                        break
                    if not self.tried(added, self._edges(self._rows)):
                        box = wider
                        break
        return box

    def _moved_out(self, box: Floats, i: int, side: int) -> Floats:
        """The box with one face moved out to the first bad design known, or to the end of the range."""
        beside = (self._bad > box[0]) & (self._bad < box[1])
        beside[:, i] = True
        met = self._bad[beside.all(axis=1), i]
        wider = box.copy()
        if side:
            wider[1, i] = met[met >= box[1, i]].min(initial=1.0)
        else:
            wider[0, i] = met[met <= box[0, i]].max(initial=0.0)
        return wider

    def _edges(self, rows: int) -> Floats:
        """Rows of the unit cube whose coordinates are near an end as likely as not: limits are mostly broken there first."""
        unit = self._rng.random((rows, len(self._names)))
        near = self._rng.random(unit.shape) < 0.5
        depth = 10.0 ** (-_DECADES * self._rng.random(unit.shape))
        return np.where(near, np.where(unit < 0.5, depth, 1.0 - depth), unit)

    def _without_effect(self) -> NDArray[np.bool_]:
        """Which parameters change nothing, (d,): these fill their range, and are never cut."""
        rows = self._rng.random((self._rows, len(self._names)))
        excess = self._excesses(rows)
        found = np.zeros(len(self._names), dtype=np.bool_)
        for i in range(len(self._names)):
            other = rows.copy()
            other[:, i] = self._rng.random(self._rows)
            found[i] = np.array_equal(self._excesses(other), excess)
        return found

    def _start(self, seed: int) -> Floats | None:
        """The design with the most room to the limits, of some all over the ranges and then ever nearer to the best."""
        rows = Sobol(len(self._names), seed).rows(0, 4 * self._rows)
        reach = 0.5
        best, least = None, np.inf
        for turn in range(_STARTS):
            excess, broken = self._excess(rows)
            self._add(rows, broken)
            place = int(np.argmin(excess))
            if excess[place] < least:
                best, least = rows[place], float(excess[place])
            if best is None:
                return None
            if least <= 0.0 and turn >= _STARTS // 2:
                break
            reach *= 0.8
            rows = np.clip(best + reach * (2.0 * self._rng.random((self._rows, best.size)) - 1.0), 0.0, 1.0)
        return best if least <= 0.0 else None

    def _measure(self, box: Floats) -> float:
        """How large a box is. Of the other measure a little, so that a side that costs nothing is not left short."""
        sides = box[1] - box[0]
        root = float(np.prod(sides) ** (1.0 / sides.size))
        return root if self._size == "volume" else float(sides.min()) + 1e-3 * root

    def trimmed(self, box: Floats) -> Floats:
        """The largest part found of a box that holds no bad design known."""
        return self._best_within(box, box)

    def _best_within(self, wide: Floats, now: Floats) -> Floats:
        """The best box without a bad design within a wide one, by cutting bad designs away in several orders.

        A cut is made where it leaves the most, and always leaves a design that is known to be good. Orders: the nearest to the
        middle first, which decide the most, and by chance.
        """
        good = self._good[((self._good >= now[0]) & (self._good <= now[1])).all(axis=1)]
        inside = (self._bad > wide[0]).all(axis=1) & (self._bad < wide[1]).all(axis=1)
        bad = self._bad[inside]
        middle = now.mean(axis=0)
        near = np.abs((bad - middle) / (wide[1] - wide[0])).max(axis=1)
        order = np.argsort(near, kind="stable")[:_MOST_BAD]
        bad, near = bad[order], near[order]
        best, most = now, self._measure(now) if not self._holds_bad(now) else -1.0
        if not len(good):
            return best
        central = good[int(np.argmin(np.abs(good - middle).max(axis=1)))]
        for turn in range(_ORDERS):
            blur = 0.0 if turn == 0 else self._rng.choice([0.1, 0.3, 1.0])
            keys = near * (1.0 + blur * self._rng.standard_normal(near.size))
            keep = central if turn % 2 == 0 else good[int(self._rng.integers(len(good)))]
            found = self._cut(wide, bad[np.argsort(keys, kind="stable")], keep)
            if found is not None and self._measure(found) > most:
                best, most = found, self._measure(found)
        return best

    def _holds_bad(self, box: Floats) -> bool:
        return bool(((self._bad > box[0]) & (self._bad < box[1])).all(axis=1).any())

    def _cut(self, wide: Floats, bad: Floats, keep: Floats) -> Floats | None:
        """The wide box with each bad design in turn cut away, on the side of the point that is kept."""
        box = wide.copy()
        while len(bad):
            bad = bad[((bad > box[0]) & (bad < box[1])).all(axis=1)]
            if not len(bad):
                break
            point = bad[0]
            cuts = []
            for i in range(keep.size):
                if point[i] == keep[i] or self._idle[i]:
                    continue
                cut = box.copy()
                cut[int(point[i] > keep[i]), i] = point[i]
                cuts.append(cut)
            if not cuts:
                return None
            box = max(cuts, key=self._measure)
        return box

    def binding(self, box: Floats) -> tuple[str, ...]:
        """The limits that known designs just outside the box break, and within it in all but one parameter."""
        room = 0.02
        near = (self._bad >= box[0] - room) & (self._bad <= box[1] + room)
        within = (self._bad >= box[0]) & (self._bad <= box[1])
        beside = near.all(axis=1) & (within.sum(axis=1) >= len(self._names) - 1)
        return tuple(limit.rule for i, limit in enumerate(self._limits) if self._broken[beside, i].any())
