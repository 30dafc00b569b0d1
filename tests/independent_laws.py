"""The force laws of the independent simulator, each by its definition.

Every law is, in every mode, affine in deflection, rate and time, times a share that may grow evenly with time:
`f = (a + k d + c v + b t)(p + q t)`, with guards `g = g0 + gd d + gv v + gt t + ga d''` that are positive while the mode
holds. What a tuple leaves off at its end is zero, and p is one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

import numpy as np

# m, m/s, s, m/s2: below this, rounding decides on which side of a boundary a state lies
GAP, SPEED, TIME, ACCELERATION = 2e-14, 1e-12, 1e-15, 1e-9


class Mode(NamedTuple):
    """A law while it stays on one straight piece."""

    name: str
    force: tuple[float, ...] = (0.0, 0.0, 0.0)  # a, k, c, b, p, q
    guards: tuple[tuple[float, ...], ...] = ()  # g0, gd, gv, gt, ga
    reel: tuple[object, ...] = ()  # what a restraint's reel does in it, for its memory


class At(NamedTuple):
    """Deflection and its rate, and the time."""

    d: float
    v: float
    t: float = 0.0


class Law(ABC):
    """A force law and what it remembers."""

    rates: tuple[float, float] = (0.0, 0.0)  # the largest stiffness and damping, for the choice of the step
    times: tuple[float, ...] = ()  # when something is done to it

    @abstractmethod
    def mode(self, at: At) -> tuple[Mode, float]:
        """The mode at a state, and how many times the rounding error the state is away from another."""

    def remember(self, mode: Mode, at: At) -> None:  # noqa: B027 -- most laws have no memory
        """Take note of the state at an event; `mode` is the one until then."""


@dataclass
class Linear(Law):
    k: float
    c: float
    s: float

    def __post_init__(self) -> None:
        self.rates = self.k, self.c

    def mode(self, _at: At) -> tuple[Mode, float]:
        return Mode("linear", (-self.k * self.s, self.k, self.c)), inf


@dataclass
class KelvinVoigt(Law):
    k: float
    c: float
    s: float

    def __post_init__(self) -> None:
        self.rates = self.k, self.c

    def mode(self, at: At) -> tuple[Mode, float]:
        gap = at.d - self.s
        pull = self.k * gap + self.c * at.v
        margin = abs(gap) / GAP
        if gap <= 0.0:
            return Mode("open", guards=((self.s, -1.0, 0.0),)), margin
        line = (-self.k * self.s, self.k, self.c)
        margin = min(margin, abs(pull) / (self.k * GAP + self.c * SPEED or 1.0))
        if pull > 0.0:
            return Mode("taut", line, (line, (-self.s, 1.0, 0.0))), margin
        return Mode("clipped", guards=((self.k * self.s, -self.k, -self.c), (-self.s, 1.0, 0.0))), margin


@dataclass
class Threshold(Law):
    k: float
    c: float
    s: float
    v_star: float = 0.0

    def __post_init__(self) -> None:
        self.rates = self.k, self.c

    def remember(self, mode: Mode, at: At) -> None:
        if mode.name == "open":  # if it closes now, then at this speed (below eq 18)
            self.v_star = at.v

    def mode(self, at: At) -> tuple[Mode, float]:
        d, v = at.d, at.v
        margin = abs(d - self.s) / GAP
        if d <= self.s:
            return Mode("open", guards=((self.s, -1.0, 0.0),)), margin
        beyond = (-self.s, 1.0, 0.0)
        margin = min(margin, abs(v - self.v_star) / SPEED)
        if v > self.v_star:
            force = (-self.k * self.s - self.c * self.v_star, self.k, self.c)
            return Mode("damped", force, (beyond, (-self.v_star, 0.0, 1.0))), margin
        return Mode("undamped", (-self.k * self.s, self.k, 0.0), (beyond, (self.v_star, 0.0, -1.0))), margin


@dataclass
class Curve(Law):
    """Piecewise linear, no tension; `unloading` None is elastic."""

    knots: list[float]
    forces: list[float]
    slopes: list[float]
    unloading: float | None = None
    top: float = 0.0  # deflection from which it last unloaded

    def __post_init__(self) -> None:
        self.rates = max([*map(abs, self.slopes), self.unloading or 0.0]), 0.0

    def remember(self, mode: Mode, at: At) -> None:
        if mode.name.startswith("piece"):
            self.top = max(self.top, at.d)

    def mode(self, at: At) -> tuple[Mode, float]:
        d = at.d
        if self.unloading is not None and d < self.top:
            return self._off_the_curve(d, self.unloading)
        away = abs(d - np.array(self.knots)).min() / GAP
        if self.unloading is not None:
            away = min(away, abs(d - self.top) / GAP)
        if d <= 0.0:
            return Mode("off", guards=((0.0, -1.0, 0.0),)), away
        i = int(np.searchsorted(self.knots, d)) - 1
        slope = self.slopes[i]
        guards = [(-self.knots[i], 1.0, 0.0)]
        if i + 1 < len(self.knots):
            guards.append((self.knots[i + 1], -1.0, 0.0))
        if self.unloading is not None:
            guards.append((0.0, 0.0, 1.0))
        return Mode(f"piece{i}", (self.forces[i] - slope * self.knots[i], slope, 0.0), tuple(guards)), away

    def _off_the_curve(self, d: float, slope: float) -> tuple[Mode, float]:
        i = max(int(np.searchsorted(self.knots, self.top)) - 1, 0)
        force = self.forces[i] + self.slopes[i] * (self.top - self.knots[i])
        rest = max(self.top - force / slope, 0.0)
        away = min(abs(d - rest), abs(d - self.top)) / GAP
        if d <= rest:
            return Mode("slack", guards=((rest, -1.0, 0.0),)), away
        line = (force - slope * self.top, slope, 0.0)
        return Mode("line", line, ((-rest, 1.0, 0.0), (self.top, -1.0, 0.0))), away


LAWS: dict[str, Callable[[float, float, float], Law]] = {
    "linear": Linear,
    "kelvin-voigt": KelvinVoigt,
    "threshold": Threshold,
}
