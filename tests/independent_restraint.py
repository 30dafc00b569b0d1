"""The restraint law of the independent simulator: webbing on a reel, a bag that fills, a padded surface.

The reel is a thing of friction: how fast it turns follows from the force on it, and the force from how far it has turned.
With a pull rate R(T) that falls with the force T in steps (each pretensioner drops out at its stall force, the load limiter
turns backwards at any speed), the reel either turns at one of the rates, or holds the force at one of the steps, whichever
keeps both true a moment later. This is decided from the state and the reel's position alone, by no account of what
happened before.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

from ridedown import network
from ridedown.network import Action
from tests.independent_laws import GAP, SPEED, At, Law, Mode

EVEN = 1e-12  # m: as near as the belt let out has to come to where a stage ends


class Line(NamedTuple):
    """A straight part of the curve: `force + slope e` for elongations between `low` and `high`."""

    name: str
    low: float
    high: float
    force: float
    slope: float

    def at(self, e: float) -> float:
        return self.force + self.slope * e


@dataclass
class Restraint(Law):
    """`law`: a `network.Restraint` of single numbers, which stand for nothing but themselves."""

    law: Any
    w: float = 0.0  # what the reel has taken in by `since`
    out: float = 0.0  # what the load limiter has let out by then
    top: float = 0.0  # largest elongation
    stage: int = 0
    free: bool = False
    fill: float = 1.0
    fill_rate: float = 0.0
    since: float = 0.0
    pulls: list[float] = field(default_factory=lambda: [0.0, 0.0])
    done: int = 0  # timers

    def __post_init__(self) -> None:
        self.free, self.fill = self.law.free, 0.0 if self.law.empty else 1.0
        self.timers = sorted(self.law.timers, key=lambda timer: float(timer.time))
        self.times = tuple(float(timer.time) for timer in self.timers)
        self.rates = max([*map(abs, self.law.slopes), self.law.unloading or 0.0]), float(self.law.damping)

    # the curve

    def lines(self) -> list[Line]:
        """The parts of the curve, from where it is slack up: from zero, or from the permanent set, by the unloading line."""
        law = self.law
        ends = (*law.knots[1:], inf)
        pieces = [
            Line(f"piece {i}", low, high, force - slope * low, slope)
            for i, (low, high, force, slope) in enumerate(zip(law.knots, ends, law.forces, law.slopes, strict=True))
        ]
        if law.unloading is None or self.top <= 0.0:
            return pieces
        here = next(line for line in pieces if self.top <= line.high)
        force, slope = here.at(self.top), float(law.unloading)
        rest = max(self.top - force / slope, 0.0)
        above = [line._replace(low=max(line.low, self.top)) for line in pieces if line.high > self.top]
        return [Line("unloading", rest, self.top, force - slope * self.top, slope), *above]

    def at_elongation(self, e: float) -> tuple[Line, float]:
        """The part of the curve there, and how far away another is, in roundings."""
        lines = self.lines()
        away = min(min(abs(e - line.low), abs(e - line.high)) for line in lines) / GAP
        return next(line for line in lines if e <= line.high), away

    def at_force(self, force: float) -> tuple[Line, float]:
        """The part of the curve that rises to this force."""
        lines = [line for line in self.lines() if line.slope > 0.0]
        away = min(min(abs(force - line.at(line.low)), abs(force - line.at(line.high))) for line in lines)
        return next(line for line in lines if force <= line.at(line.high)), away / self._rounding

    @property
    def _rounding(self) -> float:
        stiffness, damping = self.rates
        return stiffness * GAP + damping * SPEED or 1.0

    def tension(self, e: float, v: float) -> float:
        """Of the full bag, or the belt; what is slack has no damper either."""
        if e <= self.lines()[0].low:
            return 0.0
        force: float = self.at_elongation(e)[0].at(e) + self.law.damping * v
        return max(0.0, force)

    # modes

    def mode(self, at: At) -> tuple[Mode, float]:
        if self.free:
            return Mode("free", reel=("free",)), inf
        steps, rates = self._steps()
        margin = inf
        for i, (level, rate) in enumerate(zip(steps, rates, strict=False)):
            force = self.tension(self._elongation(at, rate), at.v)
            margin = min(margin, abs(force - level) / self._rounding)
            if force < level:
                return self._turning(at, rate, steps[i - 1] if i else 0.0, level, margin)
            if i + 1 == len(rates):
                return self._holding(at, level, (rate, -inf), margin)
            beyond = self.tension(self._elongation(at, rates[i + 1]), at.v)
            margin = min(margin, abs(beyond - level) / self._rounding)
            if beyond <= level:
                return self._holding(at, level, (rate, rates[i + 1]), margin)
        return self._turning(at, rates[-1], steps[-1] if steps else 0.0, inf, margin)

    def _steps(self) -> tuple[list[float], list[float]]:
        """The forces at which the pull rate drops, and the rates below each; above the last too, but for a load limiter."""
        pulling = sorted((float(stall), rate) for stall, rate in zip(self.law.stalls, self.pulls, strict=True) if rate > 0.0)
        steps, rates = [], [sum((rate for _, rate in pulling), 0.0)]
        for n, (stall, _) in enumerate(pulling):
            if stall < inf:
                steps.append(stall)
                rates.append(sum((rate for _, rate in pulling[n + 1 :]), 0.0))
        limit = float(self.law.limits[self.stage]) if self.stage < 2 else inf
        if limit < inf:
            steps.append(limit)
        return steps, rates

    def _elongation(self, at: At, rate: float) -> float:
        e: float = at.d - self.law.slack + self.w + rate * (at.t - self.since)
        return e

    def _turning(self, at: At, rate: float, low: float, high: float, margin: float) -> tuple[Mode, float]:
        """The reel turns at a rate, or stands, while the force is between two steps."""
        e = self._elongation(at, rate)
        begin = -self.law.slack + self.w - rate * self.since  # e = begin + d + rate t
        reel = ("turns", rate)
        slack = self.lines()[0].low
        margin = min(margin, abs(e - slack) / GAP)
        if e <= slack:
            return Mode("open", guards=((slack - begin, -1.0, 0.0, -rate),), reel=reel), margin
        line, away = self.at_elongation(e)
        margin = min(margin, away)
        c = float(self.law.damping)
        tension = (line.force + line.slope * begin, line.slope, c, line.slope * rate)
        guards: list[tuple[float, ...]] = []
        if line.high < inf:
            guards.append((line.high - begin, -1.0, 0.0, -rate))
        loading = self.law.unloading is not None and line.name.startswith("piece")
        # what unloads on a line leaves the curve as soon as it turns; all else where the part ends
        guards.append((rate, 0.0, 1.0) if loading else (begin - line.low, 1.0, 0.0, rate))
        force = line.at(e) + c * at.v
        margin = min(margin, abs(force) / self._rounding)
        if force <= 0.0:
            guards.append(tuple(-term for term in tension))
            return Mode(f"{line.name}, clipped, {rate:g}", guards=tuple(guards), reel=reel), margin
        guards.append(tension)
        if high < inf:
            guards.append((high - tension[0], *(-term for term in tension[1:])))
        if low > 0.0:
            guards.append((tension[0] - low, *tension[1:]))
        share = (self.fill - self.fill_rate * self.since, self.fill_rate)
        return Mode(f"{line.name}, {rate:g}", (*tension, *share), tuple(guards), reel), margin

    def _holding(self, at: At, level: float, rates: tuple[float, float], margin: float) -> tuple[Mode, float]:
        """The reel turns as it has to for the force to stay at a level, between two rates."""
        c = float(self.law.damping)
        most, least = rates
        name = "lets out" if least == -inf else "holds"
        from_curve = level - c * at.v
        guards: list[tuple[float, ...]]
        if c > 0.0:
            margin = min(margin, abs(from_curve) / self._rounding)
        if from_curve <= 0.0:  # the damper alone would do more: the belt just touches
            guards = [(-level, 0.0, c)]
            elongation = (self.lines()[0].low, 0.0)
            reel: tuple[object, ...] = (name, *elongation, most)
        else:
            line, away = self.at_force(from_curve)
            elongation = ((level - line.force) / line.slope, -c / line.slope)  # of 1 and v
            # until the fixed reel, or the one that turns at the lesser rate, would leave the level
            guards = [(line.slope * most, 0.0, line.slope, 0.0, c)]
            if least > -inf:
                guards.append((-line.slope * least, 0.0, -line.slope, 0.0, -c))
            if c > 0.0:
                margin = min(margin, away)
                name = f"{name} on {line.name}"
                loading = self.law.unloading is not None and line.name.startswith("piece")
                low = (elongation[0] - line.low, 0.0, elongation[1])
                guards.append((0.0, 0.0, 0.0, 0.0, elongation[1]) if loading else low)
                if line.high < inf:
                    guards.append((line.high - elongation[0], 0.0, -elongation[1]))
            reel = (name.split(" on ")[0], *elongation, most)
        if least == -inf:
            # out + most (t - since) - (e - d + slack - w) reaches the end of the stage
            end = float(self.law.payouts[self.stage])
            if end < inf:
                left = end - self.out + most * self.since + elongation[0] + self.law.slack - self.w
                guards.append((left, -1.0, elongation[1], -most))
        return Mode(f"{name} {level:g}", (level,), tuple(guards), reel), margin

    # memory

    def remember(self, mode: Mode, at: At) -> None:
        passed = at.t - self.since
        match mode.reel:
            case ("turns", float(rate)):
                self.w += rate * passed
            case (("lets out" | "holds") as what, float(e), float(per_rate), float(most)):
                before, self.w = self.w, e + per_rate * at.v - at.d + self.law.slack
                if what == "lets out":
                    self.out += most * passed - (self.w - before)
            case ("free",):
                self.w = min(0.0, self.law.slack - at.d)
            case ():  # before the start
                pass
            case unknown:
                raise ValueError(unknown)
        self.fill += self.fill_rate * passed
        self.since = at.t
        if not self.free:
            self.top = max(self.top, self._elongation(at, 0.0))
        self._ends_of_stages(at)
        while self.done < len(self.timers) and self.times[self.done] <= at.t:
            self._do(self.timers[self.done], at)
            self.done += 1

    def _do(self, timer: network.Timer, at: At) -> None:
        match timer.action:
            case Action.LOCK:
                self.free = False
            case Action.PULL_1 | Action.PULL_2:
                self.pulls[0 if timer.action is Action.PULL_1 else 1] = float(timer.value)
            case Action.STAGE_2:
                if self.stage == 0:
                    self.stage = 1
                    self._give(at)
                    self._ends_of_stages(at)
            case Action.FILL:
                self.fill_rate = float(timer.value)

    def _ends_of_stages(self, at: At) -> None:
        while self.stage < 2 and self.out >= self.law.payouts[self.stage] - EVEN:
            self.stage += 1
            self._give(at)

    def _give(self, at: At) -> None:
        """A lower stage lets out at once what takes the force down to it, or all that it may."""
        limit = float(self.law.limits[self.stage]) if self.stage < 2 else inf
        e = self._elongation(at, 0.0)
        if self.free or self.tension(e, at.v) <= limit:
            return
        from_curve = limit - float(self.law.damping) * at.v
        then = self.lines()[0].low
        if from_curve > 0.0:
            line, _ = self.at_force(from_curve)
            then = (from_curve - line.force) / line.slope
        length = min(e - then, float(self.law.payouts[self.stage]) - self.out)
        self.w -= length
        self.out += length
