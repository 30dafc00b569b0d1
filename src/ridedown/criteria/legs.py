"""What the legs of a dummy take: axial force in the femur, bending and axial force in the tibia.

Signs as in SAE J211 and J1733: a femur and a tibia that are pushed together have negative axial force. Filter measured
channels to class 600.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria.checks import number, signal
from ridedown.criteria.pulse import Peak
from ridedown.errors import UnknownName


@dataclass(frozen=True, slots=True)
class TibiaIndex:
    """Tibia index, of no unit, and its time [s]."""

    value: float
    time: float


@dataclass(frozen=True, slots=True)
class TibiaLimits:
    """Critical bending moment [N m] and critical compressive force [N]."""

    moment: float
    force: float


TIBIA_LIMITS: Mapping[str, TibiaLimits] = {
    "Hybrid III 50": TibiaLimits(225.0, 35_900.0),
    "Hybrid III 05": TibiaLimits(115.0, 22_900.0),
}
"""By dummy. The 50th's stand in UN R94, Annex 4; both in Euro NCAP Technical Bulletin 021, version 4.0.2, read at second hand
in the package pyisomme."""


def femur_force(time: ArrayLike, axial: ArrayLike) -> Peak:
    """Peak compressive axial force of a femur [N], with its sign: negative; zero where the femur is never compressed.

    Parameters: time [s]; axial force [N], compression negative, (n,).

    >>> femur_force([0.0, 0.05, 0.1], [0.0, -1923.0, 2500.0])
    Peak(value=-1923.0, time=0.05)

    Raises: InvalidInput.

    References: FMVSS 208 (49 CFR 571.208), S6.5; SAE J211-1 and J1733 for the sign.
    """
    times, force = signal(time, axial, "axial")
    at = int(force.argmin())
    return Peak(min(float(force[at]), 0.0), float(times[at]))


def tibia_index(
    time: ArrayLike,
    moment_x: ArrayLike,
    moment_y: ArrayLike,
    axial: ArrayLike,
    *,
    dummy: str = "Hybrid III 50",
    limits: TibiaLimits | None = None,
) -> TibiaIndex:
    """Tibia index: the largest of |M_R/M_critical| + |F_z/F_critical|, M_R the resultant of the moments about x and y.

    The regulation speaks of the compressive force and takes its magnitude; so does this, for tension too. Between two samples
    the sum is convex, so its maximum is at a sample.

    Parameters: time [s]; moments [N m] and axial force [N] at one end of the tibia, (n,); dummy: one of TIBIA_LIMITS; limits:
    instead of the dummy's.

    >>> found = tibia_index([0.0, 0.05], [0.0, 27.0], [0.0, 36.0], [0.0, -3590.0])  # 45/225 + 0.1
    >>> round(found.value, 6), found.time
    (0.3, 0.05)

    Raises: InvalidInput; UnknownName for a dummy without limits.

    References: UN Regulation No. 94, Annex 4, tibia index.
    """
    if limits is None:
        if dummy not in TIBIA_LIMITS:
            raise UnknownName.among("dummy", dummy, TIBIA_LIMITS)
        limits = TIBIA_LIMITS[dummy]
    critical = number(limits.moment, "limits.moment", "N m", above=0.0), number(limits.force, "limits.force", "N", above=0.0)
    times, about_x = signal(time, moment_x, "moment_x")
    _, about_y = signal(time, moment_y, "moment_y")
    _, force = signal(time, axial, "axial")
    index = np.hypot(about_x, about_y) / critical[0] + np.abs(force) / critical[1]
    at = int(index.argmax())
    return TibiaIndex(float(index[at]), float(times[at]))
