"""What a road restraint system does to whoever is in the vehicle that meets it: ASI, THIV, PHD and the flail-space criteria.

Accelerations are the vehicle's, at its centre of gravity, in its own directions: x forward, y to the side, z vertical (SAE
J211; a braking car has negative x). The results are magnitudes and do not depend on which side y counts as positive, as long
as the yaw rate turns x towards y. All is exact for signals that are straight between their samples; no sampling rate is
assumed. Filter measured channels to channel class 180 first, as both standards ask.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria.checks import STANDARD_GRAVITY, Floats, from_time_zero, number, signal
from ridedown.criteria.flail import Contact, contacts
from ridedown.criteria.moving import first_largest, largest_mean, lowpassed, refined
from ridedown.errors import InvalidInput, UnknownName

ASI_LIMITS_G = (12.0, 9.0, 10.0)
"""Threshold accelerations of ASI along x, y and z, in g."""

THRESHOLDS = tuple(STANDARD_GRAVITY * limit for limit in ASI_LIMITS_G)
"""The same in m/s2."""

ASI_WINDOW = 0.050
"""s, the moving mean of EN 1317-1:1998."""

ASI_CUTOFF = 13.0
"""Hz, the low-pass of EN 1317-1:2010."""

ASI_EDITIONS = ("EN 1317-1:2010", "EN 1317-1:1998")

HEAD_AHEAD, HEAD_ASIDE = 0.6, 0.3
"""m, the free space of the flail-space models, forward and to either side."""

AFTER_CONTACT_WINDOW = 0.010
"""s, the moving mean of PHD and of the ridedown acceleration."""

# Between samples a low-passed signal is not straight; 0.1 ms apart it is to 1e-5 of its peak at 13 Hz.
FINE = 1e-4


@dataclass(frozen=True, slots=True)
class ASI:
    """Acceleration severity index, of no unit, its time [s] (the middle of the 50 ms for 1998), and the edition."""

    value: float
    time: float
    edition: str


@dataclass(frozen=True, slots=True)
class HeadImpact:
    """Theoretical head impact: velocity [m/s], time of flight and contact [s], along x and y. All None if it never happens."""

    value: float | None
    time: float | None
    forward: float | None
    lateral: float | None


@dataclass(frozen=True, slots=True)
class OccupantImpact:
    """Occupant impact velocity [m/s]: the larger of |forward| and |lateral|, both signed as the occupant moves; time [s].

    All None where the occupant never reaches the interior.
    """

    value: float | None
    time: float | None
    forward: float | None
    lateral: float | None


@dataclass(frozen=True, slots=True)
class AfterContact:
    """Largest 10 ms mean [m/s2] after contact and its window [s]; None without a contact, or with less than 10 ms after it."""

    value: float | None
    start: float | None
    end: float | None


@dataclass(frozen=True, slots=True)
class Ridedown:
    """Occupant ridedown acceleration [m/s2]: the larger of `forward` and `lateral`, each with its 10 ms window."""

    value: float | None
    forward: AfterContact
    lateral: AfterContact


def asi(
    time: ArrayLike,
    forward: ArrayLike,
    lateral: ArrayLike | None = None,
    vertical: ArrayLike | None = None,
    *,
    edition: Literal["EN 1317-1:2010", "EN 1317-1:1998"] = "EN 1317-1:2010",
) -> ASI:
    """Acceleration severity index: the largest of sqrt((ax/12 g)^2 + (ay/9 g)^2 + (az/10 g)^2).

    The accelerations are means over a moving 50 ms (1998) or go through a phaseless four-pole Butterworth low-pass whose gain
    is 1/sqrt(2) at 13 Hz (2010). An axis left out counts as zero, which makes the index smaller: it is complete with three.
    The low-pass takes the signal to stay at its end values outside the record; one that begins at contact with a jump should
    begin with a sample of zero at the same time.

    Parameters: time [s], (n,); forward, lateral, vertical acceleration [m/s2], (n,).

    >>> round(asi([0.0, 0.2], [-120.0, -120.0]).value, 4)  # a constant 12.24 g along x
    1.0197
    >>> step = [0.0, 0.0, -117.6798, -117.6798]  # 12 g from 0.1 s on
    >>> round(asi([0.0, 0.1, 0.1, 0.3], step, edition="EN 1317-1:1998").value, 9)
    1.0

    Raises:
        InvalidInput: a bad signal (see `ridedown.criteria.checks.signal`), or shorter than 50 ms for the edition of 1998.
        UnknownName: another edition.

    References:
        EN 1317-1:1998 and EN 1317-1:2010, Road restraint systems - Part 1: Terminology and general criteria for test methods.
        The texts were not at hand: window, limits and cut-off are as the handbook of the program DIAdem has them (ChnASICalc).
    """
    times, values = _channels(time, forward=forward, lateral=lateral, vertical=vertical)
    scaled = values / np.array(THRESHOLDS)[:, np.newaxis]
    if edition == "EN 1317-1:1998":
        best = largest_mean(times, scaled, ASI_WINDOW)
        if best is None:
            raise too_short(times)
        return ASI(best.value, 0.5 * (best.start + best.end), edition)
    if edition != "EN 1317-1:2010":
        raise UnknownName.among("edition", str(edition), ASI_EDITIONS)
    fine, through = refined(times, scaled, FINE)
    index = np.sqrt((lowpassed(fine, through, ASI_CUTOFF) ** 2).sum(axis=0))
    at = first_largest(index)
    return ASI(float(index[at]), float(fine[at]), edition)


def too_short(times: Floats) -> InvalidInput:
    """What to say of a signal that is shorter than the moving mean of EN 1317-1:1998."""
    return InvalidInput(
        f"time: got a signal of {times[-1] - times[0]:g} s; need >= {ASI_WINDOW:g} s, the mean's window. "
        "Record longer, or use the edition of 2010."
    )


def thiv(
    time: ArrayLike,
    forward: ArrayLike,
    lateral: ArrayLike | None = None,
    yaw_rate: ArrayLike | None = None,
    *,
    ahead: float = HEAD_AHEAD,
    aside: float = HEAD_ASIDE,
    head: tuple[float, float] = (0.0, 0.0),
    start: float | None = None,
) -> HeadImpact:
    """Theoretical head impact velocity: how fast a freely flying head meets the interior, 0.6 m ahead or 0.3 m aside of it.

    The head keeps the velocity that the centre of gravity had at `start`; the vehicle brakes, drifts and yaws under it. The
    time of contact is solved for, not sampled.

    Parameters: time [s]; forward, lateral acceleration [m/s2] and yaw_rate [rad/s], (n,), zero where left out; ahead, aside:
    the free space [m]; head: where the head is, forward and to the side of the sensor [m]; start: first contact with the
    obstacle [s], time zero if left out, or the first sample where that is later.

    >>> impact = thiv([0.0, 0.3], [-100.0, -100.0])  # 0.6 = 100 t^2/2
    >>> round(impact.time, 6), round(impact.value, 6)
    (0.109545, 10.954451)

    Raises: InvalidInput.

    References:
        EN 1317-1:2010, Road restraint systems - Part 1 (not at hand); AASHTO, Manual for Assessing Safety Hardware, 2009,
        Appendix F, Determination of THIV, PHD, and ASI, which describes the same model. The equations here are plain kinematics
        of a free point seen from a turning frame.
    """
    _, _, contact = _fly(time, forward, lateral, yaw_rate, ahead, aside, head, start)
    if contact is None:
        return HeadImpact(None, None, None, None)
    return HeadImpact(contact.speed, contact.time, contact.forward_velocity, contact.lateral_velocity)


def phd(
    time: ArrayLike,
    forward: ArrayLike,
    lateral: ArrayLike | None = None,
    yaw_rate: ArrayLike | None = None,
    *,
    ahead: float = HEAD_AHEAD,
    aside: float = HEAD_ASIDE,
    head: tuple[float, float] = (0.0, 0.0),
    start: float | None = None,
) -> AfterContact:
    """Post-impact head deceleration: after its contact (see `thiv`) the head stays put and shares the vehicle's acceleration.

    The largest resultant of the means of forward and lateral acceleration over 10 ms that begin at the contact or later.
    Parameters as for `thiv`.

    >>> after = phd([0.0, 0.3], [-100.0, -100.0])
    >>> round(after.value, 6), round(after.start, 6)
    (100.0, 0.109545)

    Raises: InvalidInput.

    References: as for `thiv`.
    """
    times, values, contact = _fly(time, forward, lateral, yaw_rate, ahead, aside, head, start)
    return _after(times, values[:2], contact)


def occupant_impact_velocity(
    time: ArrayLike,
    forward: ArrayLike,
    lateral: ArrayLike | None = None,
    *,
    ahead: float = HEAD_AHEAD,
    aside: float = HEAD_ASIDE,
    start: float | None = None,
) -> OccupantImpact:
    """Occupant impact velocity of the flail-space model: relative to the vehicle, where 0.6 m ahead or 0.3 m aside is reached.

    Whichever is reached first ends the flight, and both components are taken then. The model has no yaw. Where neither is
    reached the manuals take the vehicle's change of velocity instead; that is for the caller to decide, and all is None here.

    Parameters: as for `thiv`.

    >>> impact = occupant_impact_velocity([0.0, 0.3], [-100.0, -100.0], [20.0, 20.0])
    >>> round(impact.time, 6), round(impact.value, 6), round(impact.lateral, 6)
    (0.109545, 10.954451, -2.19089)

    Raises: InvalidInput.

    References:
        J. D. Michie, Collision risk assessment based on occupant flail-space model, Transportation Research Record 796, 1981.
        AASHTO, Manual for Assessing Safety Hardware (MASH), 2nd edition, 2016, Appendix A (from memory).
    """
    _, _, contact = _fly(time, forward, lateral, None, ahead, aside, (0.0, 0.0), start)
    if contact is None:
        return OccupantImpact(None, None, None, None)
    u, v = contact.forward_velocity, contact.lateral_velocity
    return OccupantImpact(max(abs(u), abs(v)), contact.time, u, v)


def occupant_ridedown_acceleration(
    time: ArrayLike,
    forward: ArrayLike,
    lateral: ArrayLike | None = None,
    *,
    ahead: float = HEAD_AHEAD,
    aside: float = HEAD_ASIDE,
    start: float | None = None,
) -> Ridedown:
    """Occupant ridedown acceleration of the flail-space model: the largest 10 ms mean, along x and along y, after the contact.

    Parameters: as for `thiv`.

    >>> ride = occupant_ridedown_acceleration([0.0, 0.3], [-100.0, -100.0])
    >>> round(ride.value, 6), ride.lateral.value
    (100.0, 0.0)

    Raises: InvalidInput.

    References: as for `occupant_impact_velocity`.
    """
    times, values, contact = _fly(time, forward, lateral, None, ahead, aside, (0.0, 0.0), start)
    along, across = (_after(times, values[axis : axis + 1], contact) for axis in (0, 1))
    sizes = [part.value for part in (along, across) if part.value is not None]
    return Ridedown(max(sizes) if sizes else None, along, across)


def _channels(time: ArrayLike, **channels: ArrayLike | None) -> tuple[Floats, Floats]:
    """The times, (n,), and the channels, (k, n); one that is left out is zero. The first must be there."""
    rows = []
    for name, values in channels.items():
        times, row = signal(time, np.zeros(np.shape(time)) if values is None else values, name)
        rows.append(row)
    return times, np.stack(rows)


def _fly(
    time: ArrayLike,
    forward: ArrayLike,
    lateral: ArrayLike | None,
    yaw_rate: ArrayLike | None,
    ahead: float,
    aside: float,
    head: tuple[float, float],
    start: float | None,
) -> tuple[Floats, Floats, Contact | None]:
    """The channels from `start` on, (3, n), and the occupant's contact."""
    times, values = _channels(time, forward=forward, lateral=lateral, yaw_rate=yaw_rate)
    ahead, aside = number(ahead, "ahead", "m", above=0.0), number(aside, "aside", "m", above=0.0)
    offset = number(head[0], "head", "m"), number(head[1], "head", "m")
    cut = [from_time_zero(times, row, start) for row in values]
    times, values = cut[0][0], np.stack([row for _, row in cut])
    found = contacts(times, values, np.array([0, times.size]), ahead, aside, offset)[0]
    return times, values, None if np.isnan(found[0]) else Contact(*map(float, found))


def _after(times: Floats, values: Floats, contact: Contact | None) -> AfterContact:
    best = None if contact is None else largest_mean(times, values, AFTER_CONTACT_WINDOW, contact.time)
    return AfterContact(None, None, None) if best is None else AfterContact(best.value, best.start, best.end)
