"""The network: what the solver sees of a crash, as flat arrays.

A network knows nothing of vehicles or people. It has *coordinates* (the displacement of a mass, or the rotation of a bar)
and *elements* (force laws). Every number may be a single value or a column, one value per crash:

    q_i      coordinate i, relative to its parent coordinate (to the ground where parent = -1)
    d_e      deflection of element e:  d_e = sum_i term_sign q_i + arm_e tan(theta)
    f_e      its force, by its law, from d_e and d_e'
    X_i''    absolute acceleration of body i:  inertia_i X_i'' = -sum_e reaction_sign f_e
    theta''  rotation of a bar:  inertia theta'' = -s sum_e arm_e f_e,  s = 1 (as the paper prints it, eq 4)
             or s = sec^2(theta) (work-conjugate: the moment that the deflections of eqs 7-8 imply)

Occupants hang on their vehicle as relative coordinates, so that a belt's slack is met without cancellation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum

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


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """A crash as flat arrays: n coordinates, m elements, p curve pieces in all, R crashes (see the module's text).

    Arrays of numbers have shape (n, R), (m, R), (p, R) or (R,); SI units.
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
    # numbers
    inertia: Floats  # (n, R) kg, or kg m2
    rate: Floats  # (n, R) initial rate of each coordinate, m/s or rad/s
    arm: Floats  # (m, R) m
    stiffness: Floats  # (m, R) N/m; of a plastic curve, its unloading line
    damping: Floats  # (m, R) N s/m
    slack: Floats  # (m, R) m
    knot: Floats  # (p, R) m
    force: Floats  # (p, R) N
    slope: Floats  # (p, R) N/m
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

    def widened(self, size: int) -> Network:
        """The same network with every column of that length, where it holds a single crash."""
        if self.size == size:
            return self

        def wide(column: Floats) -> Floats:
            return np.repeat(column, size, axis=-1)

        return replace(
            self,
            inertia=wide(self.inertia),
            rate=wide(self.rate),
            arm=wide(self.arm),
            stiffness=wide(self.stiffness),
            damping=wide(self.damping),
            slack=wide(self.slack),
            knot=wide(self.knot),
            force=wide(self.force),
            slope=wide(self.slope),
            duration=wide(self.duration),
        )
