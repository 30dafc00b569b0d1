"""What the ribs of a dummy take: how far the sternum goes in, and how fast while it is in.

The transducer's sign follows SAE J211 and J1733: a sternum that goes in moves backward, so compression is negative. Filter
measured channels to class 180 for the viscous criterion (UN R94) and to class 600 for the deflection (SAE J211).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria.checks import number, signal
from ridedown.criteria.pulse import Peak
from ridedown.errors import InvalidInput, UnknownName


@dataclass(frozen=True, slots=True)
class ViscousCriterion:
    """The largest product of compression and its velocity [m/s], and its time [s]."""

    value: float
    time: float


@dataclass(frozen=True, slots=True)
class ChestConstants:
    """Of a dummy: the scaling factor, and the depth [m] that a deflection is divided by."""

    factor: float
    depth: float


CHEST_CONSTANTS: Mapping[str, ChestConstants] = {
    "Hybrid III 50": ChestConstants(1.3, 0.229),
    "Hybrid III 05": ChestConstants(1.3, 0.187),
    "Hybrid III 95": ChestConstants(1.3, 0.254),
    "Hybrid III 10 year old": ChestConstants(1.3, 0.166),
    "Hybrid III 6 year old": ChestConstants(1.3, 0.143),
    "Hybrid III 3 year old": ChestConstants(1.3, 0.122),
    "ES-2 50": ChestConstants(1.0, 0.140),
    "ES-2re 50": ChestConstants(1.0, 0.140),
    "WorldSID 50": ChestConstants(1.0, 0.170),
    "SID-IIs 05": ChestConstants(1.0, 0.138),
}
"""By dummy. For the Hybrid III 50th, UN R94 (Annex 4): VC = 1.3 V C with C = D/0.229 m. The others as Euro NCAP's Technical
Bulletin 021, Data Acquisition and Injury Calculation, version 4.0.2, has them, read at second hand in the package pyisomme."""


def chest_deflection(time: ArrayLike, deflection: ArrayLike) -> Peak:
    """The largest deflection of the sternum relative to the spine, in magnitude, with the sign that was recorded.

    Laboratories differ in the sign of this channel. The rebound of a rib cage stays far below its compression, so that the
    largest magnitude is the compression under either sign.

    Parameters: time [s] and deflection [m], (n,).

    >>> chest_deflection([0.0, 0.05, 0.1], [0.0, -0.032, 0.001])
    Peak(value=-0.032, time=0.05)

    Raises: InvalidInput.

    References: FMVSS 208 (49 CFR 571.208), S6.4: compressive deflection of the sternum relative to the spine.
    """
    times, values = signal(time, deflection, "deflection")
    at = int(np.abs(values).argmax())
    return Peak(float(values[at]), float(times[at]))


def viscous_criterion(
    time: ArrayLike,
    deflection: ArrayLike,
    *,
    dummy: str = "Hybrid III 50",
    factor: float | None = None,
    depth: float | None = None,
) -> ViscousCriterion:
    """Viscous criterion: the largest of factor V D/depth, compression times its velocity, while the two have one sign.

    The velocity is the regulation's own difference of four samples, V_i = [8 (D_i+1 - D_i-1) - (D_i+2 - D_i-2)]/(12 dt), which
    needs even sampling and two samples on either side. Only the way in counts: on the way out V D is negative.

    Parameters: time [s] and deflection [m] of either sign, (n,); dummy: one of CHEST_CONSTANTS; factor, depth [m]: instead of
    the dummy's.

    >>> import numpy as np
    >>> t = np.linspace(0.0, 0.1, 101)
    >>> vc = viscous_criterion(t, -0.05 * np.sin(np.pi * t / 0.1))  # 1.3 (0.05^2/0.229) (pi/0.1)/2
    >>> round(vc.value, 4), round(vc.time, 4)
    (0.2229, 0.025)

    Raises:
        InvalidInput: a bad signal, fewer than five samples, or samples that are not evenly spaced.
        UnknownName: a dummy without constants.

    References:
        I. V. Lau, D. C. Viano, The viscous criterion - bases and applications of an injury severity index for soft tissues,
        SAE 861882, 1986. UN Regulation No. 94, Annex 4 (formula). SAE J1727, Injury Calculations Guidelines.
    """
    times, values = signal(time, deflection, "deflection")
    steps = np.diff(times)
    if times.size < 5:
        raise InvalidInput(f"time: got {times.size} samples; need >= 5 for the velocity of deformation. Record longer.")
    if steps.min() <= 0.0 or steps.max() - steps.min() > 1e-3 * steps.mean():
        raise InvalidInput(
            f"time: got steps of {steps.min():g} .. {steps.max():g} s; need even sampling for the velocity of deformation. "
            "Resample the signal first."
        )
    if factor is None or depth is None:
        constants = _constants(dummy)
        factor, depth = constants.factor if factor is None else factor, constants.depth if depth is None else depth
    factor, depth = number(factor, "factor", "", above=0.0), number(depth, "depth", "m", above=0.0)
    velocity = (8.0 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / (12.0 * steps.mean())
    product = factor * velocity * values[2:-2] / depth
    at = int(product.argmax())
    return ViscousCriterion(max(float(product[at]), 0.0), float(times[at + 2]))


def _constants(dummy: str) -> ChestConstants:
    if dummy not in CHEST_CONSTANTS:
        raise UnknownName.among("dummy", dummy, CHEST_CONSTANTS)
    return CHEST_CONSTANTS[dummy]
