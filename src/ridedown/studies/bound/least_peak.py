"""The least peak deceleration that keeps an occupant within its room, exactly: a convex hull, and the points where it is held.

With U the double integral of the occupant's deceleration u, the room asks `lead - forward <= U <= lead + rearward`, and a
restraint only brakes: U is nowhere below that of an unrestrained occupant. u <= A says that `U - A t^2/2` is concave. The
least concave function above what U must exceed is its upper hull, so a level A is possible if and only if that hull stays below
what U may not exceed; where it does not, three points of it tell a level that is needed (docs/bound.md has the proofs).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike

from ridedown.errors import RidedownError
from ridedown.studies.bound.lead import Floats, Lead, Unrestrained, crossing

_POINTS = 400  # of the first hull
_DENSE = 4000  # of the search for points that it misses
_EPS = 2.0**-52
_ROUNDS = 60
_APART = 1e-11  # of the whole time: points that are nearer are one


class How(StrEnum):
    """What an ideal restraint does for a time."""

    FREE = "free"
    """It does not act."""
    HELD = "held"
    """It brakes the occupant at the bound."""
    CARRIED = "carried"
    """It brakes the occupant as the vehicle brakes, at the full excursion."""


@dataclass(frozen=True, slots=True)
class Stage:
    """A part of the ideal history: what the restraint does, from when to when [s]. The last may go on for ever."""

    how: How
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class Proof:
    """Instants [s] at which the occupant's place alone shows that no restraint does better.

    At `front` it may not be beyond its excursion, at `rear` not behind its room (None: that does not matter), at `start` not
    ahead of an unrestrained occupant (or, of a second swing, not beyond its excursion).
    """

    start: float
    rear: float | None
    front: float


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """Where an occupant may be: from `rearward` behind its place to `forward` ahead of it.

    begin [s]: when a restraint can first act. stop [s]: until when it matters, which may be for ever.
    """

    lead: Lead
    free: Unrestrained
    forward: float
    rearward: float
    begin: float
    stop: float

    def floor(self, s: Floats) -> Floats:
        """What U must not be below, less its tangent at the beginning, against the time since then."""
        time = s + self.begin
        floor: Floats = np.maximum(self.lead.at(time) - self.forward, self.free.values(time)) - self._tangent(s)
        return floor

    def ceiling(self, s: Floats) -> Floats:
        """What U must not be above, in the same way."""
        ceiling: Floats = self.lead.at(s + self.begin) + self.rearward - self._tangent(s)
        return ceiling

    def over_free(self, s: float) -> float:
        """How far the excursion bids U be beyond that of an unrestrained occupant [m]."""
        time = s + self.begin
        return float(self.lead.at(time)) - self.forward - self.free.at(time)

    def floor_rate(self, s: float, *, on_lead: bool) -> float:
        """Rate of that part of the floor which the excursion makes, or else the unrestrained occupant [m/s]."""
        time = s + self.begin
        return (float(self.lead.rate(time)) if on_lead else self.free.rate(time)) - self.free.rate(self.begin)

    def ceiling_rate(self, s: float) -> float:
        """Rate of the ceiling [m/s]."""
        return float(self.lead.rate(s + self.begin)) - self.free.rate(self.begin)

    def _tangent(self, s: Floats) -> Floats:
        return self.free.at(self.begin) + self.free.rate(self.begin) * s

    def grid(self, last: float, count: int) -> Floats:
        """Times since the beginning, up to `last`: about so many in the pulse, the ends of its smooth parts among them."""
        kept = np.union1d(self.lead.cells, self.lead.start) - self.begin
        kept = kept[(kept > 0.0) & (kept < last)]
        if kept.size > count // 2:
            kept = kept[:: 1 + kept.size // (count // 2)]
        pulse = min(max(self.lead.end - self.begin, 0.0), last)
        even = np.append(np.linspace(0.0, pulse, count), np.linspace(pulse, last, count // 4))
        grid = np.union1d(kept, even)
        grid = grid[np.diff(grid, prepend=-last) > _APART * last]
        grid[-1] = last
        return grid


@dataclass(frozen=True, slots=True, eq=False)
class Least:
    """A level A [m/s2], the ideal history that keeps to it, and the proof that no lower one is possible (None where A is 0)."""

    level: float
    stages: tuple[Stage, ...]
    proof: Proof | None


def least_peak(room: Room) -> Least:
    """The least level, to rounding.

    A hull of few points gives a level that is needed; points where the continuous problem is not yet satisfied are put in,
    until there are none. Levels only rise, and converge as Newton's method does.
    """
    if room.forward + room.rearward == 0.0:
        return _carried(room)
    search = _Search(room, room.stop - room.begin if np.isfinite(room.stop) else _far(room))
    for _ in range(_ROUNDS):
        if search.settled():
            return search.result()
    raise RidedownError(f"bound: got no answer in {_ROUNDS} rounds; need one. Report this pulse and excursion.")


def _far(room: Room) -> float:
    """As long after the beginning as an occupant that is held evenly through the coast would be held, and more [s]."""
    lead, own = room.lead, room.free.rate(room.begin)
    last = 1.5 * max(lead.end - room.begin, 0.5 * lead.end)
    closing = lead.taken - own
    if not closing > 0.0:
        return last
    stop = room.begin - (float(lead.at(lead.end)) - lead.taken * (lead.end - room.begin) - room.free.at(room.begin))
    return max(last, 2.5 * (room.forward / closing + abs(stop / closing)))


def _carried(room: Room) -> Least:
    """With no room at all: as the vehicle brakes."""
    cells = room.lead.cells
    times = np.union1d(cells, np.linspace(0.0, room.lead.end, 200_001))
    times = times[times <= room.stop]
    braking = np.maximum(room.lead.braking(times), room.lead.braking(np.nextafter(times, 0.0)))
    k = int(np.argmax(braking))
    when = float(times[k])
    return Least(max(0.0, float(braking[k])), (Stage(How.CARRIED, 0.0, np.inf),), Proof(when, when, when))


@dataclass(frozen=True, slots=True, eq=False)
class _Arc:
    """U between two points of the hull, at which it is on the floor: there u is the level."""

    room: Room
    level: float
    ends: tuple[float, float]
    values: tuple[float, float]

    def below_floor(self, s: ArrayLike) -> Floats:
        """How far it is below what U must exceed [m]; what is no more than rounding is none."""
        time = np.asarray(s)
        off: Floats = self.room.floor(time) - self._at(time)
        return np.where(off > self._rounding(time, self.room.forward), off, np.minimum(off, 0.0))

    def above_ceiling(self, s: ArrayLike) -> Floats:
        """How far it is above what U may not exceed [m]; what is no more than rounding is none."""
        time = np.asarray(s)
        off: Floats = self._at(time) - self.room.ceiling(time)
        return np.where(off > self._rounding(time, self.room.rearward), off, np.minimum(off, 0.0))

    def highest(self, s: Floats, i: int) -> float:
        """Where the floor is highest above it, beside point i."""
        on_lead = self.room.over_free(float(s[i])) >= 0.0
        return _turn(lambda t: self.room.floor_rate(t, on_lead=on_lead) - self._rate(t), s, i)

    def nearest(self, s: Floats, i: int) -> float:
        """Where the ceiling is lowest above it, beside point i."""
        return _turn(lambda t: self.room.ceiling_rate(t) - self._rate(t), s, i)

    def _at(self, s: Floats) -> Floats:
        (p, q), (first, last) = self.ends, self.values
        share = (s - p) / (q - p)
        at: Floats = (1.0 - share) * first + share * last - 0.5 * self.level * (s - p) * (q - s)
        return at

    def _rate(self, s: float) -> float:
        (p, q), (first, last) = self.ends, self.values
        return (last - first) / (q - p) + self.level * (s - 0.5 * (p + q))

    def _rounding(self, s: Floats, room: float) -> Floats:
        lead = np.abs(self.room.lead.at(s + self.room.begin))
        rounding: Floats = 16.0 * _EPS * (lead + room + max(map(abs, self.values)))
        return rounding


class _Search:
    """Points, the level that they need, and the hull at that level."""

    def __init__(self, room: Room, last: float) -> None:
        self.room = room
        self.level = 0.0
        self.proof: tuple[float, float | None, float] | None = None
        self._spread(last)

    def _spread(self, last: float) -> None:
        self.last = last
        self.points = self.room.grid(last, _POINTS)
        self.dense = self.room.grid(last, _DENSE)

    def settled(self) -> bool:
        """One round; whether a further one would change nothing."""
        self._solve()
        coasts = not np.isfinite(self.room.stop) and self.room.lead.taken > self.room.free.rate(self.room.begin)
        if coasts and (self.level == 0.0 or self.hull[-2] < self.points.size - 2):
            self._spread(2.0 * self.last)  # held beyond the last point
            return False
        if self.level == 0.0:
            return True
        missed = [s for s in self._missed() if 0.0 < s < self.last]
        found = self._new(missed)
        self.points = np.union1d(self.points, found)
        return found.size == 0

    def _new(self, times: list[float]) -> Floats:
        """Those that are not among the points already, to rounding: two points as near would have no slope between them."""
        found = np.unique(times)
        after = np.clip(np.searchsorted(self.points, found), 1, self.points.size - 1)
        apart = np.minimum(np.abs(found - self.points[after - 1]), np.abs(self.points[after] - found))
        return found[apart > _APART * self.last]

    def _solve(self) -> None:
        """The level that the points need, by Newton's method: each level's hull shows the points that need most above it."""
        s = self.points
        floor, ceiling = self.room.floor(s), self.room.ceiling(s)
        rounding = 16.0 * _EPS * (np.abs(self.room.lead.at(s[1:] + self.room.begin)) + self.room.forward)
        needed = np.where(floor[1:] > rounding, 2.0 * floor[1:] / s[1:] ** 2, 0.0)
        k = int(np.argmax(needed))
        if needed[k] > self.level:
            self.level, self.proof = float(needed[k]), (0.0, None, float(s[1 + k]))
        while True:
            self.hull = _upper_hull(s, floor - 0.5 * self.level * s**2)
            if not np.isfinite(self.room.rearward):
                return
            b, over = self._highest(floor)
            if not over > 0.0:
                return
            right = int(np.searchsorted(self.hull, b))
            a, c = int(self.hull[right - 1]), int(self.hull[right])
            level = _needed(s[[a, b, c]], np.array([floor[a], ceiling[b], floor[c]]))
            if level <= self.level * (1.0 + 2.0 * _EPS):
                return
            self.level, self.proof = level, (float(s[a]), float(s[b]), float(s[c]))

    def _highest(self, floor: Floats) -> tuple[int, float]:
        """The point at which the hull is farthest above the ceiling, and how far [m]; 0 if it is nowhere."""
        place, most = 0, 0.0
        for p, q in self._chords():
            inside = np.arange(p + 1, q)
            ends = (float(self.points[p]), float(self.points[q])), (float(floor[p]), float(floor[q]))
            over = _Arc(self.room, self.level, *ends).above_ceiling(self.points[inside])
            if over.max() > most:
                place, most = int(inside[np.argmax(over)]), float(over.max())
        return place, most

    def _missed(self) -> Iterator[float]:
        """Times at which the hull of the points is not yet that of the continuous floor, or goes through the ceiling."""
        room, s, level, dense = self.room, self.points, self.level, self.dense
        sides = np.maximum(room.lead.braking(dense + room.begin), room.lead.braking(np.nextafter(dense + room.begin, 0.0)))
        steep = dense[(sides > level * (1.0 + 1e-9)) & ~self._held(dense) & self._on_lead(dense)]
        yield from steep  # a chord must span these: points nearer to them, until one does
        for side in ("left", "right"):
            beside = np.searchsorted(s, steep, side=side) - (side == "left")
            yield from 0.5 * (steep + s[np.clip(beside, 0, s.size - 1)])
        on_lead = self._on_lead(s)
        for k in np.flatnonzero(on_lead[1:] & ~on_lead[:-1]):  # a bend that no finite deceleration follows
            yield crossing(room.over_free, float(s[k]), float(s[k + 1]))
        floor = room.floor(s)
        for p, q in self._chords():
            arc = _Arc(room, level, (float(s[p]), float(s[q])), (float(floor[p]), float(floor[q])))
            ends = [arc.highest(s, i) for i in (p, q)]
            inside = np.concatenate((ends[:1], dense[(dense > ends[0]) & (dense < ends[1])], ends[1:]))
            ends.append(arc.highest(inside, int(np.argmax(arc.below_floor(inside)))))
            yield from (end for end in ends if arc.below_floor(end) > 0.0)
            if np.isfinite(room.rearward):
                near = arc.nearest(inside, int(np.argmax(arc.above_ceiling(inside))))
                if arc.above_ceiling(near) > 0.0:
                    yield near

    def _chords(self) -> list[tuple[int, int]]:
        """Pairs of points between which the hull is straight, and not because nothing lies between them."""
        return [(int(p), int(q)) for p, q in zip(self.hull[:-1], self.hull[1:], strict=True) if q > p + 1]

    def _held(self, times: Floats) -> np.ndarray:
        held = np.zeros(times.size, dtype=np.bool_)
        for p, q in self._chords():
            held |= (times >= self.points[p]) & (times <= self.points[q])
        return held

    def _on_lead(self, times: Floats) -> np.ndarray:
        room = self.room
        when = times + room.begin
        return np.asarray(room.lead.at(when) - room.forward > room.free.values(when))

    def result(self) -> Least:
        """The level with its history and proof."""
        begin = self.room.begin
        if self.level == 0.0:
            return Least(0.0, (Stage(How.FREE, 0.0, self.room.stop),), None)
        assert self.proof is not None
        start, rear, front = self.proof
        if rear is None and begin > 0.0 and self.room.ceiling(np.zeros(1))[0] == 0.0:
            rear = 0.0  # on its seat
        proof = Proof(start + begin, None if rear is None else rear + begin, front + begin)
        return Least(self.level, tuple(_merged(self._stages())), proof)

    def _stages(self) -> Iterator[Stage]:
        s, begin = self.points, self.room.begin
        if begin > 0.0:
            yield Stage(How.FREE, 0.0, begin)
        first, second = self.hull[:-1], self.hull[1:]
        carried = self._on_lead(0.5 * (s[first] + s[second]))
        for p, q, on_lead in zip(first.tolist(), second.tolist(), carried.tolist(), strict=True):
            how = How.HELD if q > p + 1 else How.CARRIED if on_lead else How.FREE
            yield Stage(how, float(s[p]) + begin, self.room.stop if q == s.size - 1 else float(s[q]) + begin)


def _turn(slope: Callable[[float], float], s: Floats, i: int) -> float:
    """Where a slope goes through zero beside point i."""
    return crossing(slope, float(s[max(i - 1, 0)]), float(s[min(i + 1, s.size - 1)]))


def _upper_hull(x: Floats, y: Floats) -> np.ndarray:
    """Indices of the points of the least concave function above all, first and last among them; x rises."""
    hull: list[int] = []
    xs, ys = x.tolist(), y.tolist()
    for i in range(len(xs)):
        while len(hull) > 1:
            j, k = hull[-1], hull[-2]
            if (ys[j] - ys[k]) * (xs[i] - xs[j]) > (ys[i] - ys[j]) * (xs[j] - xs[k]):
                break
            hull.pop()
        hull.append(i)
    return np.array(hull)


def _needed(s: Floats, u: Floats) -> float:
    """The least second derivative that takes a function to u[0] or more, u[1] or less and u[2] or more at these times."""
    return float(2.0 * ((u[2] - u[1]) / (s[2] - s[1]) - (u[1] - u[0]) / (s[1] - s[0])) / (s[2] - s[0]))


def _merged(stages: Iterator[Stage]) -> list[Stage]:
    """Stages with those of one kind that follow each other made one."""
    merged: list[Stage] = []
    for stage in stages:
        if merged and merged[-1].how is stage.how:
            merged[-1] = Stage(stage.how, merged[-1].start, stage.end)
        else:
            merged.append(stage)
    return merged
