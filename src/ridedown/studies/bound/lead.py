"""A pulse as an occupant meets it: how far a free body is ahead of its place in the vehicle, and what a seat behind it does.

`lead(t)` is the double integral of the vehicle's deceleration: the excursion of a body that nothing holds. The speed of the
crash cancels. After its end a pulse is over, and the vehicle goes on at the velocity it then has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ridedown.scenario.pulse_motion import PulseMotion

Floats = NDArray[np.float64]

_XTOL, _RTOL = 1e-300, 8.9e-16  # as near as numbers of double precision come


@dataclass(frozen=True, slots=True, eq=False)
class Lead:
    """The lead of a free body [m] as a polynomial on each of P pieces, continuous with its rate.

    start: (P,) [s], the first at 0, rising; the last piece is straight and goes on for ever. series: (P, K), ascending powers
    of the time since the piece's start. cells: (C + 1,) [s], from 0 to the end of the pulse; between two of them the vehicle
    brakes all the time, or never does.
    """

    start: Floats
    series: Floats
    cells: Floats

    @classmethod
    def of(cls, motion: PulseMotion) -> Lead:
        """The lead that a vehicle's motion gives."""
        start = motion.starts
        length = np.diff(np.append(start, motion.end))
        braking = -motion.series[: start.size]
        orders = np.arange(braking.shape[1])
        series = np.zeros((start.size + 1, braking.shape[1] + 2))
        series[:-1, 2:] = braking / ((orders + 1.0) * (orders + 2.0))
        powers = length[:, None] ** np.arange(series.shape[1])
        slopes = (braking / (orders + 1.0) * powers[:, 1:-1]).sum(axis=1)
        series[1:, 1] = np.cumsum(slopes)
        moved = (series[:-1] * powers).sum(axis=1)
        series[1:, 0] = np.cumsum(moved)
        turns = [s + root for s, h, d in zip(start, length, braking, strict=True) for root in _zeros(d, h)]
        return cls(np.append(start, motion.end), series, np.union1d(np.append(start, motion.end), turns))

    @property
    def end(self) -> float:
        """When the pulse is over [s]."""
        return float(self.start[-1])

    @property
    def taken(self) -> float:
        """The velocity that the pulse takes from the vehicle in all [m/s]."""
        return float(self.series[-1, 1])

    def at(self, times: ArrayLike) -> Floats:
        """The lead [m] at times [s] not below 0."""
        return self._polynomial(times, self.series)

    def rate(self, times: ArrayLike) -> Floats:
        """Its rate [m/s]: the velocity that the vehicle has lost."""
        return self._polynomial(times, self.series[:, 1:] * np.arange(1, self.series.shape[1]))

    def braking(self, times: ArrayLike) -> Floats:
        """The vehicle's deceleration [m/s2]; at a jump, just after it."""
        orders = np.arange(2, self.series.shape[1])
        return self._polynomial(times, self.series[:, 2:] * orders * (orders - 1))

    def _polynomial(self, times: ArrayLike, series: Floats) -> Floats:
        time = np.asarray(times, dtype=np.float64)
        piece = np.maximum(np.searchsorted(self.start, time, side="right") - 1, 0)
        since, own = time - self.start[piece], series[piece]
        value: Floats = own[..., -1]
        for order in range(series.shape[1] - 2, -1, -1):
            value = value * since + own[..., order]
        return value

    def first_reach(self, level: float, free: Unrestrained) -> float | None:
        """When the excursion of an unrestrained occupant first comes up to a level above 0 [s]; None if it never does."""

        def over(time: float) -> float:
            return float(self.at(time)) - free.at(time) - level

        def rate(time: float) -> float:
            return float(self.rate(time)) - free.rate(time)

        bounds = np.union1d(self.cells, free.start[np.isfinite(free.start)])
        last = self.end
        if (final := rate(last)) > 0.0:  # it flies on
            bounds = np.append(bounds, last + max(0.0, -over(last)) / final * (1.0 + 1e-9) + 1e-9)
        tops = self.at(bounds) - np.array([free.at(t) for t in bounds]) - level
        for low, high, top in zip(bounds[:-1], bounds[1:], tops[1:], strict=True):
            if top < 0.0 and rate(low) > 0.0 > rate(high):  # turns round within
                turn = crossing(rate, float(low), float(high))
                if over(turn) >= 0.0:
                    return crossing(over, float(low), turn)
            if top >= 0.0:
                return crossing(over, float(low), float(high))
        return None


@dataclass(frozen=True, slots=True, eq=False)
class Unrestrained:
    """How far an occupant that only the seat behind it pushes is behind a free one [m], against time: 0, or less.

    Off the seat it flies free; where it comes up against the seat it stays there, without bounce, until the vehicle brakes.
    start: (M,) [s]; value (M,) [m] and slope (M,) [m/s] there, from where on it is straight; seated: (M,) whether it follows
    the seat instead.
    """

    lead: Lead
    room: float
    start: Floats
    value: Floats
    slope: Floats
    seated: NDArray[np.bool_]

    @classmethod
    def of(cls, lead: Lead, room: float) -> Unrestrained:
        """The occupant with this room behind it [m], which may be infinite."""
        middle = 0.5 * (lead.cells[:-1] + lead.cells[1:])
        braking = lead.braking(middle)
        stages: list[_Stage] = [(0.0, 0.0, 0.0, room == 0.0 and braking[0] <= 0.0)]
        if np.isinf(room):
            return cls(lead, room, np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(1, dtype=np.bool_))
        for low, high, brakes in zip(lead.cells[:-1], lead.cells[1:], braking > 0.0, strict=True):
            stages += cls._within(lead, room, stages[-1], float(low), float(high), brakes=bool(brakes))
        if not stages[-1][3] and lead.taken < stages[-1][2]:  # drifts back after the pulse
            stages += _landing(lead, room, stages[-1], lead.end, np.inf, brakes=False)
        start, value, slope, seated = zip(*stages, strict=True)
        return cls(lead, room, np.array(start), np.array(value), np.array(slope), np.array(seated))

    @staticmethod
    def _within(lead: Lead, room: float, last: _Stage, low: float, high: float, *, brakes: bool) -> list[_Stage]:
        if last[3]:
            return [(low, float(lead.at(low)) + room, float(lead.rate(low)), False)] if brakes else []
        return _landing(lead, room, last, low, high, brakes=brakes)

    def last_contact(self, before: float) -> float:
        """When it last leaves or meets the seat, up to a time [s]; 0 if it does not. Any occupant is then where it is."""
        return float(self.start[max(int(np.searchsorted(self.start, before, side="right")) - 1, 0)])

    def at(self, time: float) -> float:
        """The way behind the free occupant, as the double integral of its deceleration [m]."""
        i = int(np.searchsorted(self.start, time, side="right")) - 1
        if self.seated[i]:
            return float(self.lead.at(time)) + self.room
        return float(self.value[i] + self.slope[i] * (time - self.start[i]))

    def rate(self, time: float) -> float:
        """Its rate [m/s]."""
        i = int(np.searchsorted(self.start, time, side="right")) - 1
        return float(self.lead.rate(time)) if self.seated[i] else float(self.slope[i])

    def follows_seat(self, times: Floats) -> NDArray[np.bool_]:
        """Whether it is on the seat and moves with it, at times [s]."""
        found: NDArray[np.bool_] = self.seated[np.searchsorted(self.start, times, side="right") - 1]
        return found

    def values(self, times: Floats) -> Floats:
        """`at` of many times."""
        i = np.searchsorted(self.start, times, side="right") - 1
        flying = self.value[i] + self.slope[i] * (times - self.start[i])
        if not self.seated.any():
            return flying
        return np.where(self.seated[i], self.lead.at(times) + self.room, flying)


_Stage = tuple[float, float, float, bool]


def _landing(lead: Lead, room: float, last: _Stage, low: float, high: float, *, brakes: bool) -> list[_Stage]:
    """The stage that begins where a flying occupant lands on the seat between two times, if it does."""
    start, value, slope, _ = last

    def gap(time: float) -> float:
        return float(lead.at(time)) + room - value - slope * (time - start)

    def closing(time: float) -> float:
        return float(lead.rate(time)) - slope

    if np.isinf(high):
        return [(t := low + gap(low) / -closing(low), float(lead.at(t)) + room, lead.taken, False)]
    least = high
    if brakes:  # the gap is convex
        if closing(low) >= 0.0:
            return []
        least = crossing(closing, low, high) if closing(high) > 0.0 else high
    if gap(least) >= 0.0:
        return []
    landed = crossing(gap, low, least) if gap(low) > 0.0 else low
    return [(landed, float(lead.at(landed)) + room, float(lead.rate(landed)), not brakes)]


def crossing(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function goes through zero between two times of opposite sign, to the last digit; else the end nearer to it."""
    first, last = function(low), function(high)
    if first == 0.0 or last == 0.0 or (first > 0.0) == (last > 0.0):
        return low if abs(first) <= abs(last) else high
    from scipy.optimize import brentq  # noqa: PLC0415  slow to import

    return float(brentq(function, low, high, xtol=_XTOL, rtol=_RTOL, maxiter=300))


def _zeros(series: Floats, length: float) -> list[float]:
    """Where a polynomial of ascending powers is zero inside (0, length)."""
    if series.size == 1:
        return []
    if not series[2:].any():
        place = -series[0] / series[1] if series[1] != 0.0 else -1.0
        return [float(place)] if 0.0 < place < length else []
    scaled = series * length ** np.arange(series.size)
    scaled = scaled[: 1 + np.flatnonzero(np.abs(scaled) > 1e-18 * np.abs(scaled).max())[-1]] if scaled.any() else scaled[:1]
    roots = np.polynomial.polynomial.polyroots(scaled) if scaled.size > 1 else np.zeros(0)
    places = roots.real[np.abs(roots.imag) < 1e-6]
    return [float(length * place) for place in places if 0.0 < place < 1.0]
