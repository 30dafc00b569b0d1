"""A solved crash as it comes from the solver: polynomials, phase by phase, and what is asked of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ridedown.network import Channel, Family, Network
from ridedown.network.model import Floats, Ints
from ridedown.solver import polynomial
from ridedown.solver.layout import DEGREE
from ridedown.solver.workspace import Results


@dataclass(frozen=True, slots=True, eq=False)
class Phases:
    """n phases of one crash, each a power series in the time since its start, degree DEGREE; axes (phase, order, index)."""

    start: Floats  # (n,) s
    length: Floats  # (n,) s
    position: Floats  # (n, DEGREE + 1, coordinates)
    deflection: Floats  # (n, DEGREE + 1, elements)
    force: Floats  # (n, DEGREE + 1, elements)
    event_time: Floats  # (k,)
    event_element: Ints
    event_before: Ints  # mode, see laws.py and restraint.py; -1 where a timer went off
    event_after: Ints  # mode, or the timer's number
    set: Floats  # (elements,) permanent set at the end, m
    reel: Floats  # (elements,) belt that a restraint's reel has taken in by the end, m; negative where it let out more
    payout: Floats  # (elements,) belt that its load limiter let out, m
    chains: tuple[list[int], ...]  # of each coordinate, those that add up to its absolute displacement

    @property
    def end(self) -> float:
        """Time reached [s]."""
        return float(self.start[-1] + self.length[-1]) if self.start.size else 0.0

    def series(self, channel: Channel) -> Floats:
        """Coefficients of a channel, (n, DEGREE + 1), ascending powers of the time since the phase's start."""
        total = np.zeros((self.start.size, DEGREE + 1))
        total[:, 0] = channel.constant
        for family, index, weight in channel.terms:
            if family == Family.FORCE:
                total += weight * self.force[:, :, index]
            elif family >= Family.DEFLECTION:
                total += weight * _differentiated(self.deflection[:, :, index], family - Family.DEFLECTION)
            elif family == Family.ACCELERATION:
                total += weight * _differentiated(self.position[:, :, self.chains[index]].sum(axis=2), 2)
            else:
                total += weight * _differentiated(self.position[:, :, index], int(family))
        return total

    def at(self, series: Floats, time: Floats) -> Floats:
        """Values of a series at times [s] within the crash; at an event, those just after it."""
        phase = np.clip(np.searchsorted(self.start, time, side="right") - 1, 0, self.start.size - 1)
        local = time - self.start[phase]
        value: Floats = series[phase, DEGREE]
        for order in range(DEGREE - 1, -1, -1):
            value = value * local + series[phase, order]
        return value

    def largest(self, series: Floats, sense: int) -> tuple[float, float]:
        """The largest (sense 1), smallest (-1) or farthest from zero (0) value of a series, with its sign, and its time [s]."""
        best, where = -np.inf, (0, 0.0)
        sign_of_best = 1.0
        room = np.zeros(polynomial.WORK_SHAPE)
        for sign in (1.0, -1.0):
            if sense * sign < 0.0:
                continue
            scaled = sign * series * self._powers
            bounds = scaled[:, 0] + np.maximum(scaled[:, 1:], 0.0).sum(axis=1)  # no phase goes higher than its own
            for phase in range(self.start.size):
                if bounds[phase] > best:
                    peak, fraction = polynomial.maximum(scaled[phase], best, room)
                    if fraction >= 0.0:
                        best, where, sign_of_best = peak, (phase, fraction), sign
        phase, fraction = where
        return float(sign_of_best * best), float(self.start[phase] + fraction * self.length[phase])

    def first_fall(self, series: Floats) -> float | None:
        """The first time [s] at which a series that starts positive turns negative, or None."""
        scaled = series * self._powers
        floors = scaled[:, 0] + np.minimum(scaled[:, 1:], 0.0).sum(axis=1)
        room = np.zeros(polynomial.WORK_SHAPE)
        for phase in np.flatnonzero(floors <= 0.0):
            if scaled[phase, 0] < 0.0:
                return float(self.start[phase])
            root = polynomial.first_root(scaled[phase], room) if scaled[phase].any() else polynomial.NO_ROOT
            if root <= 1.0:
                return float(self.start[phase] + root * self.length[phase])
        return None

    @property
    def _powers(self) -> Floats:
        """Powers of each phase's length, (n, DEGREE + 1)."""
        powers: Floats = self.length[:, None] ** np.arange(DEGREE + 1)
        return powers

    def integral_of_product(self, first: Floats, second: Floats) -> float:
        """The integral over the whole crash of the product of two series, exact."""
        half = 0.5 * self.length[:, None]
        local = half * (1.0 + _NODES)
        return float(np.sum(_horner(first, local) * _horner(second, local) * _WEIGHTS * half))

    def integral(self, series: Floats) -> float:
        """The integral of a series over the whole crash."""
        orders = np.arange(1, DEGREE + 2)
        return float(np.sum(series * self.length[:, None] ** orders / orders))


# Gauss-Legendre, exact for the product of two series of degree DEGREE
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(DEGREE + 1)


def _horner(series: Floats, local: Floats) -> Floats:
    value = np.repeat(series[:, DEGREE : DEGREE + 1], local.shape[1], axis=1)
    for order in range(DEGREE - 1, -1, -1):
        value = value * local + series[:, order : order + 1]
    return value


def _differentiated(series: Floats, times: int) -> Floats:
    for _ in range(times):
        shifted = np.zeros_like(series)
        shifted[:, :-1] = series[:, 1:] * np.arange(1, series.shape[1])
        series = shifted
    return series


def phases_of(network: Network, count: int, kept: Floats, log: Floats, results: Results) -> Phases:
    """The phases in the solver's record (see `workspace.Record`), of the one crash of the results."""
    n, m = len(network.coordinates), len(network.elements)
    kept = kept[:count]
    changes = log[1 : 1 + int(log[0, 0])]
    changes = changes[np.argsort(changes[:, 0], kind="stable")]  # timers that waited are noted late
    whole = changes[:, 1:].astype(np.int64)
    phases = Phases(
        start=kept[:, 0, 0],
        length=kept[:, 0, 1],
        position=kept[:, 1:, :n],
        deflection=kept[:, 1:, n : n + m],
        force=kept[:, 1:, n + m : n + 2 * m],
        event_time=changes[:, 0],
        event_element=whole[:, 0],
        event_before=whole[:, 1],
        event_after=whole[:, 2],
        set=results.set[:, 0],
        reel=results.reel[:, 0],
        payout=results.payout[:, 0],
        chains=tuple(network.chain(i) for i in range(n)),
    )
    return phases if count else _first_instant(network, phases)


def _first_instant(network: Network, phases: Phases) -> Phases:
    """A phase of no length at time 0, for a crash that could not take its first step: bodies move, nothing pushes yet."""
    orders = phases.position.shape[1]
    position, deflection = (np.zeros((1, orders, len(names))) for names in (network.coordinates, network.elements))
    position[0, 1] = network.rate[:, 0]
    for e in range(len(network.elements)):
        terms = slice(int(network.term_start[e]), int(network.term_start[e + 1]))
        deflection[0, 1, e] = network.term_sign[terms] @ network.rate[network.term_coordinate[terms], 0]
    return replace(
        phases,
        start=np.zeros(1),
        length=np.zeros(1),
        position=position,
        deflection=deflection,
        force=np.zeros_like(deflection),
    )
