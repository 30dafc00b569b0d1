"""The network: what the solver sees of a crash, as flat arrays.

A network knows nothing of vehicles or people. It has *coordinates* (the displacement of a mass, or the rotation of a bar)
and *elements* (force laws). Every number may be a single value or a column, one value per crash:

    q_i      coordinate i, relative to its parent coordinate (to the ground where parent = -1)
    d_e      deflection of element e:  d_e = sum_i term_sign q_i + arm_e tan(theta)
    f_e      its force, by its law, from d_e and d_e'
    X_i''    absolute acceleration of body i:  inertia_i X_i'' = -sum_e reaction_sign f_e
    theta''  rotation of a bar:  inertia theta'' = -s sum_e arm_e f_e,  s = 1 (as the paper prints it, eq 4)
             or s = sec^2(theta) (work-conjugate: the moment that the deflections of eqs 7-8 imply)

Occupants hang on their vehicle as relative coordinates, so that a belt's slack is met without cancellation. One body may be
driven: it follows a prescribed acceleration (`Pulse`), whatever pushes on it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Number = float | NDArray[np.float64]
"""One value, or a column with one value per crash."""

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Law(IntEnum):
    """The force laws, by what the solver does with them."""

    LINEAR = 0  # k (d - slack) + c v, both ways, always engaged
    KELVIN_VOIGT = 1  # max(0, k (d - slack) + c v) beyond the slack
    THRESHOLD = 2  # k (d - slack) + c max(0, v - v*) beyond the slack (paper, eqs 13-18)
    ELASTIC = 3  # piecewise-linear curve, compression only, back along itself
    PLASTIC = 4  # the same, unloading on a line to a permanent set
    RESTRAINT = 5  # a curve with slack, damping and unloading, on a reel or filling with time


class Action(IntEnum):
    """What a timer does to its restraint."""

    LOCK = 0  # the reel, free before, is locked
    PULL_1 = 1  # the first pretensioner pulls at the timer's value from now on [m/s]
    PULL_2 = 2  # the second
    STAGE_2 = 3  # the load limiter goes on to its second stage
    FILL = 4  # the fill changes at the timer's value from now on [1/s]


@dataclass(frozen=True, slots=True)
class Linear:
    """Spring and damper in parallel, pulling and pushing: `k (d - slack) + c v`. [N/m, N s/m, m]"""

    stiffness: Number
    damping: Number = 0.0
    slack: Number = 0.0


@dataclass(frozen=True, slots=True)
class KelvinVoigt:
    """A tie that can only pull: `max(0, k (d - slack) + c v)` for `d > slack`. [N/m, N s/m, m]"""

    stiffness: Number
    damping: Number = 0.0
    slack: Number = 0.0


@dataclass(frozen=True, slots=True)
class Threshold:
    """The paper's restraint (eqs 13-18): `k (d - slack) + c max(0, v - v*)` for `d > slack`.

    `v*` is the relative velocity at the instant that the slack is taken up, each time it is. [N/m, N s/m, m]
    """

    stiffness: Number
    damping: Number = 0.0
    slack: Number = 0.0


@dataclass(frozen=True, slots=True)
class Curve:
    """A crushing member: force against deflection in linear pieces, zero for `d <= 0`.

    Piece i starts at deflection `knots[i]` (the first at 0) with force `forces[i]` and rises by `slopes[i]`; the last goes
    on for ever. `unloading` is None for a member that comes back along its curve, or the stiffness of the line on which a
    plastic one unloads and reloads. [m, N, N/m]
    """

    knots: tuple[Number, ...]
    forces: tuple[Number, ...]
    slopes: tuple[Number, ...]
    unloading: Number | None = None


@dataclass(frozen=True, slots=True)
class Timer:
    """Something done to a restraint at a time [s]; `value` as its action says."""

    action: Action
    time: Number
    value: Number = 0.0


@dataclass(frozen=True, slots=True)
class Restraint:
    """A belt on its reel, a bag, a padded surface: something that holds an occupant. [m, N, N/m, N s/m, s]

        e = d - slack + w                      elongation, or penetration; w: what the reel has taken in
        f = fill (curve(e) + damping d')       never less than zero, and zero until e > 0, or its permanent set

    Curve: piece i starts at elongation `knots[i]` (the first at 0) with force `forces[i]` and rises by `slopes[i]`; the last
    goes on for ever. `unloading`: None to come back along it, or the stiffness of the line down to a permanent set and up
    again.

    Reel: `free` until an `Action.LOCK` timer, it gives whatever is asked with no force, and takes it in again. A pretensioner
    pulls at the rate that its timers set, while the force is below its stall force `stalls[n]`; at that force it holds the
    belt or pulls no faster than keeps it there. A load limiter lets out belt at the force `limits[0]`; when it has let out
    `payouts[0]` in all, or at an `Action.STAGE_2` timer, the force is `limits[1]`; when it has let out `payouts[1]` in all, it
    stops for good. Infinite where there is none. While it slips or is held, the reel lies where curve(e) + damping d' is just
    that force; with e = 0 where the damper alone gives more. Pieces that start below such a force must rise.

    Fill: 1; or 0 at first if `empty`, and then as `Action.FILL` timers say.
    """

    knots: tuple[Number, ...]
    forces: tuple[Number, ...]
    slopes: tuple[Number, ...]
    slack: Number = 0.0
    damping: Number = 0.0
    unloading: Number | None = None
    limits: tuple[Number, Number] = (np.inf, np.inf)
    payouts: tuple[Number, Number] = (np.inf, np.inf)
    stalls: tuple[Number, Number] = (np.inf, np.inf)
    free: bool = False
    empty: bool = False
    timers: tuple[Timer, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Pulse:
    """The acceleration of a driven body: `amplitude p(time / length)`, p a polynomial on each of P pieces.

    start: (P,) where each piece starts, in units of `length`; the first at 0, rising. The last piece goes on for ever.
    series: (P, D) coefficients of p on each piece, in ascending powers of time / length - start; D at most 15.
    amplitude [m/s2], length [s]: single values, or columns, so that one shape serves crashes of any severity and duration.
    """

    start: Floats
    series: Floats
    amplitude: Number = 1.0
    length: Number = 1.0


NUMBERS = (
    "inertia", "rate", "arm", "stiffness", "damping", "slack", "knot", "force", "slope", "limit", "payout", "stall",
    "timer_time", "timer_value", "pulse_amplitude", "pulse_length", "duration",
)  # fmt: skip
"""The fields of a `Network` that have a value for each crash, on their last axis."""


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """A crash as flat arrays: n coordinates, m elements, p curve pieces and t timers in all, R crashes
    (see the module's text).

    Arrays of numbers have the crash as their last axis; SI units.
    """

    # structure
    coordinates: tuple[str, ...]
    parent: Ints  # (n,) coordinate this one is relative to, -1 = ground
    is_rotation: NDArray[np.bool_]  # (n,)
    conjugate: bool  # lever arm law of the bars: work-conjugate, or as printed
    elements: tuple[str, ...]
    law: Ints  # (m,) of Law
    term_start: Ints  # (m + 1,) terms of element e: term_start[e] .. term_start[e + 1]
    term_coordinate: Ints
    term_sign: Floats
    lever: Ints  # (m,) rotation coordinate that element e has an arm on, -1 = none
    reaction_start: Ints  # (m + 1,) bodies that element e acts on
    reaction_coordinate: Ints
    reaction_sign: Floats
    piece_start: Ints  # (m + 1,) curve pieces of element e
    driven: int  # coordinate with a prescribed acceleration, -1 = none
    pulse_start: Floats  # (P,) its pieces (see `Pulse`)
    pulse_end: Floats  # (P,) up to when each may be used: beyond the start of the next, where they overlap
    pulse_series: Floats  # (P, D)
    free: NDArray[np.bool_]  # (m,) restraints whose reel is free at first
    empty: NDArray[np.bool_]  # (m,) restraints whose fill is 0 at first
    timer_element: Ints  # (t,)
    timer_action: Ints  # (t,) of Action
    # numbers
    inertia: Floats  # (n, R) kg, or kg m2
    rate: Floats  # (n, R) initial rate of each coordinate, m/s or rad/s
    arm: Floats  # (m, R) m
    stiffness: Floats  # (m, R) N/m; of a curve, its unloading line, 0 = back along the curve
    damping: Floats  # (m, R) N s/m
    slack: Floats  # (m, R) m
    knot: Floats  # (p, R) m
    force: Floats  # (p, R) N
    slope: Floats  # (p, R) N/m
    limit: Floats  # (2, m, R) N, of a load limiter's stages
    payout: Floats  # (2, m, R) m, in all, at which each ends
    stall: Floats  # (2, m, R) N, of two pretensioners
    timer_time: Floats  # (t, R) s
    timer_value: Floats  # (t, R)
    pulse_amplitude: Floats  # (R,) m/s2
    pulse_length: Floats  # (R,) s
    duration: Floats  # (R,) s

    @property
    def size(self) -> int:
        """How many crashes the columns hold."""
        return int(self.duration.size)

    def coordinate(self, name: str) -> int:
        """Index of the coordinate of that name."""
        return self.coordinates.index(name)

    def chain(self, coordinate: int) -> list[int]:
        """The coordinate and those it hangs on, outward to the ground; their sum is the absolute displacement."""
        links = []
        while coordinate >= 0:
            links.append(coordinate)
            coordinate = int(self.parent[coordinate])
        return links

    def rows(self, rows: Ints) -> Network:
        """The same network with these of its crashes."""
        numbers: dict[str, Any] = {name: getattr(self, name)[..., rows] for name in NUMBERS}
        return replace(self, **numbers)

    def widened(self, size: int) -> Network:
        """The same network with every column of that length, where it holds a single crash."""
        if self.size == size:
            return self

        def wide(column: Floats) -> Floats:
            return np.repeat(column, size, axis=-1)

        numbers: dict[str, Any] = {name: wide(getattr(self, name)) for name in NUMBERS}
        return replace(self, **numbers)
