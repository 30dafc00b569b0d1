"""What the upper neck of a dummy takes: axial force and bending together.

Signs as in SAE J211 and J1733: axial force positive in tension, moment positive in flexion (chin towards the chest). Filter
measured channels to class 600.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.criteria.checks import Floats, signal
from ridedown.errors import InvalidInput, UnknownName


@dataclass(frozen=True, slots=True)
class NeckIntercepts:
    """Critical axial forces [N] and moments [N m], all positive: where Nij of one load alone is 1."""

    tension: float
    compression: float
    flexion: float
    extension: float


NECK_INTERCEPTS: Mapping[str, NeckIntercepts] = {
    "Hybrid III 50": NeckIntercepts(6806.0, 6160.0, 310.0, 135.0),
    "Hybrid III 05": NeckIntercepts(4287.0, 3880.0, 155.0, 67.0),
    "Hybrid III 05 out of position": NeckIntercepts(3880.0, 3880.0, 155.0, 61.0),
    "Hybrid III 6 year old": NeckIntercepts(2800.0, 2800.0, 93.0, 37.0),
    "Hybrid III 3 year old": NeckIntercepts(2120.0, 2120.0, 68.0, 27.0),
    "CRABI 12 month": NeckIntercepts(1460.0, 1460.0, 43.0, 17.0),
}
"""By dummy, as FMVSS 208 has them: S6.6 (50th), S15.3.6 (5th), S25.4 (5th out of position), S23.5 (6 years), S21.5 (3 years),
S19.4 (12 months). The first three were checked against public programs that apply the standard; the children's are from memory
of the rule and of Eppinger et al., 2000. In the standard the children's dummies are tested out of position only."""

CONDYLE_LEVER = 0.01778
"""m, from the upper neck load cell to the occipital condyle of the Hybrid III 50th and 5th (0.7 in). Euro NCAP Technical
Bulletin 021, version 4.0.2, read at second hand in the package pyisomme."""


@dataclass(frozen=True, slots=True)
class NeckMode:
    """The largest Nij of one way of loading, and its time [s]; zero at no time where it never happens."""

    value: float
    time: float | None


@dataclass(frozen=True, slots=True)
class Nij:
    """Neck injury criterion, of no unit, its time [s], the loading then, and the largest of each of the four loadings."""

    value: float
    time: float
    loading: str
    tension_flexion: NeckMode
    tension_extension: NeckMode
    compression_flexion: NeckMode
    compression_extension: NeckMode


@dataclass(frozen=True, slots=True)
class NeckForces:
    """Peak tension and compression [N], both as positive numbers (0 where it never is), and their times [s]."""

    tension: float
    tension_time: float
    compression: float
    compression_time: float


def condyle_moment(moment: ArrayLike, shear: ArrayLike, *, lever: float = CONDYLE_LEVER) -> Floats:
    """Flexion moment about the occipital condyle [N m], (n,), of that at the load cell: M - lever F, shear force F [N] along x.

    >>> condyle_moment([10.0], [500.0])
    array([1.11])

    References: SAE J1733, Sign Convention for Vehicle Crash Testing; FMVSS 208 S6.6 takes the moment at the occipital condyle.
    """
    shear, moment = np.asarray(shear, dtype=np.float64), np.asarray(moment, dtype=np.float64)
    if shear.shape != moment.shape:
        raise InvalidInput(f"shear: got shape {shear.shape}; need {moment.shape}, one for each moment. Check what was read.")
    result: Floats = moment - lever * shear
    return result


def nij(
    time: ArrayLike,
    axial: ArrayLike,
    moment: ArrayLike,
    *,
    dummy: str = "Hybrid III 50",
    intercepts: NeckIntercepts | None = None,
) -> Nij:
    """Neck injury criterion: the largest of |F|/F_critical + |M|/M_critical, each with the intercept of its sign at that time.

    Between two samples the sum is convex, so its maximum is at a sample; that of one loading alone may also be where force or
    moment changes sign, which is solved for.

    Parameters: time [s]; axial force [N], tension positive; moment about the occipital condyle [N m], flexion positive (see
    `condyle_moment`), (n,); dummy: one of NECK_INTERCEPTS; intercepts: instead of the dummy's.

    >>> found = nij([0.0, 0.05, 0.1], [0.0, 1361.2, 0.0], [0.0, -27.0, 0.0])  # 0.2 + 0.2
    >>> round(found.value, 6), found.time, found.loading
    (0.4, 0.05, 'tension-extension')

    Raises: InvalidInput; UnknownName for a dummy without intercepts.

    References:
        FMVSS 208 (49 CFR 571.208), S6.6(a). R. Eppinger, E. Sun, S. Kuppa, R. Saul, Supplement: Development of Improved Injury
        Criteria for the Assessment of Advanced Automotive Restraint Systems - II, NHTSA, 2000, chapter S2.
    """
    if intercepts is None:
        if dummy not in NECK_INTERCEPTS:
            raise UnknownName.among("dummy", dummy, NECK_INTERCEPTS)
        intercepts = NECK_INTERCEPTS[dummy]
    for field in fields(intercepts):
        if not 0.0 < getattr(intercepts, field.name) < np.inf:
            raise InvalidInput(f"intercepts.{field.name}: got {getattr(intercepts, field.name):g}; need > 0. Give magnitudes.")
    times, force = signal(time, axial, "axial")
    _, bending = signal(time, moment, "moment")
    times, (force, bending) = _with_crossings(times, (force, bending))
    pull, push = np.maximum(force, 0.0) / intercepts.tension, np.maximum(-force, 0.0) / intercepts.compression
    bow, arch = np.maximum(bending, 0.0) / intercepts.flexion, np.maximum(-bending, 0.0) / intercepts.extension
    modes = {
        "tension-flexion": np.where((force >= 0.0) & (bending >= 0.0), pull + bow, 0.0),
        "tension-extension": np.where((force >= 0.0) & (bending <= 0.0), pull + arch, 0.0),
        "compression-flexion": np.where((force <= 0.0) & (bending >= 0.0), push + bow, 0.0),
        "compression-extension": np.where((force <= 0.0) & (bending <= 0.0), push + arch, 0.0),
    }
    found = [_mode(times, values) for values in modes.values()]
    worst = int(np.argmax([mode.value for mode in found]))
    at = found[worst].time
    return Nij(found[worst].value, float(times[0]) if at is None else at, list(modes)[worst], *found)


def neck_forces(time: ArrayLike, axial: ArrayLike) -> NeckForces:
    """Peak tension and peak compression of the upper neck.

    Parameters: time [s]; axial force [N], tension positive, (n,).

    >>> neck_forces([0.0, 0.05, 0.1], [0.0, 1500.0, -300.0])
    NeckForces(tension=1500.0, tension_time=0.05, compression=300.0, compression_time=0.1)

    Raises: InvalidInput.

    References: FMVSS 208 (49 CFR 571.208), S6.6(b) and (c).
    """
    times, force = signal(time, axial, "axial")
    high, low = int(force.argmax()), int(force.argmin())
    return NeckForces(max(float(force[high]), 0.0), float(times[high]), max(-float(force[low]), 0.0), float(times[low]))


def _mode(times: Floats, values: Floats) -> NeckMode:
    at = int(values.argmax())
    return NeckMode(float(values[at]), float(times[at])) if values[at] > 0.0 else NeckMode(0.0, None)


def _with_crossings(times: Floats, channels: tuple[Floats, Floats]) -> tuple[Floats, tuple[Floats, Floats]]:
    """The same signals with a sample wherever one of them goes through zero between two."""
    extra = [times]
    for values in channels:
        k = np.flatnonzero((values[:-1] * values[1:] < 0.0) & (times[1:] > times[:-1]))
        extra.append(times[k] + (times[k + 1] - times[k]) * (values[k] / (values[k] - values[k + 1])))
    at = np.concatenate(extra[1:])
    if at.size == 0:
        return times, channels
    at = np.unique(at)
    before = np.searchsorted(times, at, side="left")
    at, before = at[(at > times[before - 1]) & (at < times[before])], before[(at > times[before - 1]) & (at < times[before])]
    merged = np.insert(times, before, at)
    first, second = (np.insert(v, before, _between(times, v, at, before)) for v in channels)
    return merged, (first, second)


def _between(times: Floats, values: Floats, at: Floats, before: NDArray[np.intp]) -> Floats:
    left, right = values[before - 1], values[before]
    here: Floats = left + (right - left) * ((at - times[before - 1]) / (times[before] - times[before - 1]))
    # What rounding leaves of a zero would count as the other loading.
    here[(left * right < 0.0) & (np.abs(here) <= 1e-12 * np.maximum(np.abs(left), np.abs(right)))] = 0.0
    return here
