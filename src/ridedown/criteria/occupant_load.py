"""How hard a crash pulse is on an occupant that nobody has designed yet: occupant load criterion and vehicle pulse index.

Either sets a standard occupant in the car and asks what it must bear. Both take the pulse in the direction of its change of
velocity, so they do not depend on which way x points, nor on the car's speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria.braked import directions, ideal_restraints
from ridedown.criteria.checks import STANDARD_GRAVITY, Floats, from_time_zero, number, signal
from ridedown.criteria.spring import greatest_extensions
from ridedown.criteria.strung import Strung
from ridedown.errors import InvalidInput

FREE_FLIGHT = 0.065
"""m, of the occupant in the car before its restraint acts (Euro NCAP TB 027)."""
RESTRAINED = 0.235
"""m, that the restraint may use after it, 0.300 m in all (Euro NCAP TB 027)."""


_MOST_TURNS = 1e5  # rad of the spring's swing between two samples: beyond it there is a wrong unit, and every turn is looked at


@dataclass(frozen=True, slots=True)
class OLC:
    """Occupant load criterion: `value` [m/s2], None where the pulse does not bring the occupant so far.

    start, end: of the restrained part [s], each None where it is not reached. displacement: of the free occupant ahead of the
    car by the end of the record [m], which tells how far the pulse would take it.
    """

    value: float | None
    start: float | None
    end: float | None
    displacement: float

    @property
    def value_g(self) -> float | None:
        """The criterion [g], as it is quoted."""
        return None if self.value is None else self.value / STANDARD_GRAVITY


@dataclass(frozen=True, slots=True)
class VPI:
    """Vehicle pulse index: `value` [m/s2], None where the record ends before the occupant's peak.

    time: of the peak [s]. reached: the largest acceleration within the record [m/s2], the value where there is one.
    """

    value: float | None
    time: float
    reached: float

    @property
    def value_g(self) -> float | None:
        """The index [g]."""
        return None if self.value is None else self.value / STANDARD_GRAVITY


def olc(
    time: ArrayLike,
    acceleration: ArrayLike,
    *,
    free_flight: float = FREE_FLIGHT,
    restrained: float = RESTRAINED,
    start: float | None = None,
) -> OLC:
    """Occupant load criterion: the constant deceleration of an ideally restrained occupant.

    The occupant flies free until it is `free_flight` ahead of its place in the car (t1); from there it is braked at a constant
    rate until it has the car's velocity, just when it is `free_flight + restrained` ahead (t2). That rate is the criterion.
    With u the car's change of velocity and z its integral, z(t1) = 0.065 m and z(t2) - u(t2) (t2 - t1)/2 = 0.300 m; both are
    cubic between samples and solved there. The first t2 counts.

    time: (n,) [s]; acceleration: (n,) [m/s2] of the vehicle, or of the moving barrier, CFC 180; free_flight, restrained [m];
    start [s]: time zero, or the first sample if that is later, if left out.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), a length not above 0, a start outside the signal.

    References: Euro NCAP TB 027, "Assessment of the compatibility (MPDB)": OLC of the barrier, v0 and the integrals as above;
    L. Kuebler, S. Gargallo, K. Elsaesser, "Characterization and evaluation of frontal crash pulses with respect to occupant
    safety", Airbag 2008 (from memory).

    >>> found = olc([0.0, 0.06, 0.06, 0.10], [-50 * 9.80665, -50 * 9.80665, 0.0, 0.0])  # 50 g for 60 ms
    >>> f"{found.value_g:.3f} g from {1e3 * found.start:.2f} to {1e3 * found.end:.2f} ms"
    '62.724 g from 16.28 to 64.11 ms'
    """
    first = number(free_flight, "free_flight", "m", above=0.0)
    way = first + number(restrained, "restrained", "m", above=0.0)
    t1, t2, value, furthest = map(float, olc_of(_pulse(time, acceleration, start), first, way)[0])
    return OLC(_or_none(value), _or_none(t1), _or_none(t2), furthest)


def olc_of(pulses: Strung, free_flight: float = FREE_FLIGHT, way: float = FREE_FLIGHT + RESTRAINED) -> Floats:
    """OLC of R pulses end to end: t1 [s], t2 [s], the criterion [m/s2] and the furthest displacement [m], (R, 4).

    NaN for what is not reached.
    """
    found = np.empty((pulses.count, 4))
    ideal_restraints(pulses.time, _forward(pulses), pulses.starts, free_flight, way, found)
    return found


def vpi(
    time: ArrayLike,
    acceleration: ArrayLike,
    *,
    stiffness: float = 2500.0,
    slack: float = 0.03,
    mass: float = 1.0,
    start: float | None = None,
) -> VPI:
    """Vehicle pulse index: the peak acceleration of a mass that a spring with slack holds in the car.

    The mass is at rest in the car at the start, takes up the slack, stretches the spring, and may fly free and come back.
    Solved on every straight piece of the pulse in closed form, peaks and contacts located within it: no step in time.

    time: (n,) [s]; acceleration: (n,) [m/s2] of the vehicle; stiffness [N/m], slack [m] >= 0, mass [kg]: the standard's, or
    such as a restraint was fitted with; start [s]: time zero, or the first sample if that is later, if left out.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), a stiffness or mass not above 0, a negative slack,
    a start outside the signal.

    References: ISO/TR 12353-3:2013, "Road vehicles, Traffic accident analysis, Part 3: Guidelines for the interpretation of
    recorded crash pulse data to determine impact severity": 1 kg, 2500 N/m, 0.03 m (the clause is not known here).

    >>> found = vpi([0.0, 0.20], [-20 * 9.80665, -20 * 9.80665])  # E (1 + sqrt(1 + 2 w^2 s/E)), E = 20 g, w = 50 rad/s
    >>> f"{found.value:.2f} m/s2 at {1e3 * found.time:.1f} ms"
    '456.69 m/s2 at 66.0 ms'
    """
    k, m = number(stiffness, "stiffness", "N/m", above=0.0), number(mass, "mass", "kg", above=0.0)
    gap = number(slack, "slack", "m", above=math.nextafter(0.0, -1.0))
    value, when, reached = map(float, vpi_of(_pulse(time, acceleration, start), math.sqrt(k / m), gap)[0])
    return VPI(_or_none(value), when, reached)


def vpi_of(pulses: Strung, frequency: float = 50.0, slack: float = 0.03) -> Floats:
    """VPI of R pulses end to end: the index [m/s2], NaN where a record ends before the peak; its time [s]; the largest; (R, 3).

    frequency: sqrt(stiffness/mass) [rad/s].

    Raises: InvalidInput for samples so far apart that the spring does not feel what is between them.
    """
    longest = float(np.diff(pulses.time).max())
    if frequency * longest > _MOST_TURNS:
        raise InvalidInput(
            f"time: got {longest:g} s between two samples; need a pulse that a spring of {frequency:g} rad/s feels. "
            "Check the units of time, stiffness and mass."
        )
    found = np.empty((pulses.count, 5))
    greatest_extensions(pulses.time, _forward(pulses), pulses.starts, frequency, slack, found)
    extension, when, z, rate, holds = found.T
    reached = frequency * frequency * extension
    rising = (holds > 0.0) & (rate > 0.0) & (z - slack >= extension * (1.0 - 1e-9))  # to its largest, when the record ends
    return np.stack([np.where((extension > 0.0) & ~rising, reached, np.nan), when, reached], axis=1)


def _pulse(time: ArrayLike, acceleration: ArrayLike, start: float | None) -> Strung:
    """The pulse from its start on."""
    return Strung.one(*from_time_zero(*signal(time, acceleration), start))


def _forward(pulses: Strung) -> Floats:
    """The pulses' accelerations, each positive in the direction of its largest change of velocity."""
    sign = np.empty(pulses.count)
    directions(pulses.time, pulses.values, pulses.starts, sign)
    forward: Floats = pulses.values * np.repeat(sign, np.diff(pulses.starts))
    return forward


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else value
