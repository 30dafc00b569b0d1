"""An independent simulator of any scenario, slow and plain, to hold the product's solver against.

It works straight from the scenario's numbers, in absolute coordinates, with scipy's DOP853 between events. Of the
product it uses nothing but the scenario's fields: not the network, not the solver.

After each event *all* modes are found anew, by looking where each element stands a
tiny time later, at the first such time at which that is beyond doubt. So coincident events need no special care.

`coarse` is a second, quite different method: fixed steps, forces from the state alone, no events.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

from ridedown.scenario import Bar, CrashScenario, Crush, Member, NetworkScenario, Occupant, Restraint, Vehicle
from tests.independent_laws import ACCELERATION, GAP, LAWS, SPEED, TIME, At, Curve, Law, Mode

Floats = NDArray[np.float64]

States = Callable[[Any], Any]  # of a time or of times (T,): states (2n,) or (2n, T)

LATER = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)  # s: when to look again
STEPS_PER_RADIAN = 25.0  # so that DOP853's interpolant, of order 7, is as exact as its steps
NODES = np.cos(np.linspace(np.pi, 0.0, 11))  # Chebyshev-Lobatto, for everything looked at within a step
TO_CHEBYSHEV = np.linalg.inv(chebyshev.chebvander(NODES, len(NODES) - 1))
STEEPEST = 1.5  # rad: a bar turned this far is no crash any more
MOST_EVENTS = 3000


@dataclass
class Body:
    name: str
    inertia: float
    speed: float
    parent: str = ""
    vehicle: str = ""
    drive: Drive | None = None


@dataclass
class Drive:
    """A prescribed acceleration: a polynomial in (t - begins[i]) from each begins[i] on, coefficients in ascending powers."""

    begins: list[float]
    series: list[Floats]

    def at(self, times: Any, piece: int) -> Any:
        """Accelerations by one of the pieces, also beyond its ends."""
        return polynomial.polyval(times - self.begins[piece], self.series[piece])

    def piece(self, time: float) -> int:
        """The piece just after a time."""
        return int(np.searchsorted(self.begins, time, side="right")) - 1


@dataclass
class Element:
    name: str
    law: Law
    signs: dict[str, float]
    acts_on: tuple[str, ...]
    arm: float = 0.0


@dataclass
class System:
    """Bodies and elements, and their arrays: deflections are `signs x + arms tan(theta)`."""

    bodies: list[Body]
    elements: list[Element]
    duration: float
    conjugate: bool = True
    signs: Floats = field(init=False)
    arms: Floats = field(init=False)
    pull: Floats = field(init=False)  # acceleration of each body for a unit force of each element
    turn: int = field(init=False)

    def __post_init__(self) -> None:
        names = [body.name for body in self.bodies]
        self.turn = names.index("bar.rotation") if "bar.rotation" in names else -1
        self.signs = np.array([[e.signs.get(n, 0.0) for n in names] for e in self.elements])
        self.arms = np.array([e.arm for e in self.elements])
        acting = np.array([[e.signs.get(n, 0.0) * (n in e.acts_on) for n in names] for e in self.elements])
        if self.turn >= 0:
            acting[:, self.turn] = self.arms
        self.pull = -acting.T / np.array([body.inertia for body in self.bodies])[:, np.newaxis]
        driven = [i for i, body in enumerate(self.bodies) if body.drive is not None]
        self.driven = driven[0] if driven else -1
        self.drive = self.bodies[self.driven].drive if driven else None

    def stop_after(self, time: float) -> float:
        """When something is next done, by a clock, to an element or to the driven body; at most the duration."""
        stops = [stop for element in self.elements for stop in element.law.times]
        stops += self.drive.begins if self.drive is not None else []
        return min([stop for stop in stops if stop > time] + [self.duration])

    def regime(self, law: Floats, time: float) -> Regime:
        """What rules from a time on, until something switches."""
        return Regime(law, 0 if self.drive is None else self.drive.piece(time))

    def start(self) -> Floats:
        speeds = [body.speed for body in self.bodies]
        return np.array([0.0] * len(speeds) + speeds)

    def deflections(self, y: Floats) -> tuple[Floats, Floats]:
        """Of all elements, and their rates, at a state (2n,) or states (2n, T)."""
        n = len(self.bodies)
        d, v = self.signs @ y[:n], self.signs @ y[n:]
        if self.turn >= 0:
            tangent, rate = np.tan(y[self.turn]), y[n + self.turn]
            d = d + np.multiply.outer(self.arms, tangent)
            v = v + np.multiply.outer(self.arms, (1.0 + tangent**2) * rate)
        return d, v

    def forces(self, t: Any, y: Floats, regime: Regime) -> Floats:
        d, v = self.deflections(y)
        a, k, c, b, p, q = regime.law if y.ndim == 1 else regime.law[:, :, np.newaxis]
        out: Floats = (a + k * d + c * v + b * t) * (p + q * t)
        return out

    def accelerations(self, t: Any, y: Floats, regime: Regime) -> Floats:
        out: Floats = self.pull @ self.forces(t, y, regime)
        if self.turn >= 0 and self.conjugate:
            out[self.turn] *= 1.0 + np.tan(y[self.turn]) ** 2
        if self.drive is not None:
            out[self.driven] = self.drive.at(t, regime.drive)
        return out

    def slope(self, t: float, y: Floats, regime: Regime) -> Floats:
        return np.concatenate([y[len(self.bodies) :], self.accelerations(t, y, regime)])

    def rate(self) -> float:
        """Faster than anything swings [1/s]; dampers count only as far as they are no faster than the springs."""
        give = np.abs(self.pull[: len(self.bodies)].T * self.signs).sum(axis=1)
        if self.turn >= 0:
            give += np.abs(self.pull[self.turn] * self.arms)
        stiffness, damping = np.array([e.law.rates for e in self.elements]).T
        springs, dampers = sqrt(stiffness @ give), float(damping @ give)
        return max(springs, min(dampers, 3.0 * springs), 10.0)


class Regime(NamedTuple):
    """What rules while nothing switches."""

    law: Floats  # (6, m) a, k, c, b, p, q of every element
    drive: int  # piece of the prescribed acceleration


class Piece(NamedTuple):
    """Part of the trajectory on which nothing switches."""

    begin: float
    end: float
    states: States
    regime: Regime


class Happening(NamedTuple):
    time: float
    who: str
    before: str
    after: str


class Run:
    """What came of a simulation: channels by the product's names, extremes, events."""

    def __init__(self, system: System, pieces: list[Piece], events: list[Happening]) -> None:
        self.system, self.pieces, self.events = system, pieces, events
        self.end_time = pieces[-1].end
        self._sampled: dict[str, Floats] = {}

    @property
    def channels(self) -> list[str]:
        names = []
        for body in self.system.bodies:
            if body.name == "bar.rotation":
                names += ["bar.rotation", "bar.rotation_rate"]
                continue
            names += [f"{body.name}.{q}" for q in ("displacement", "velocity", "acceleration")]
            if body.parent:
                names += [f"{body.name}.{q}" for q in ("relative_displacement", "relative_velocity")]
            if body.vehicle:
                names += [f"{body.name}.{q}" for q in ("excursion", "excursion_velocity")]
        return names + [f"{e.name}.{q}" for e in self.system.elements for q in ("force", "deflection", "deflection_rate")]

    def at(self, channel: str, times: ArrayLike) -> Floats:
        """Values at the times asked for; at an event itself, those just after it."""
        times = np.atleast_1d(np.asarray(times, dtype=float))
        starts = [piece.begin for piece in self.pieces]
        where = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, len(starts) - 1)
        out = np.empty(times.shape)
        for i in np.unique(where):
            mine = where == i
            piece = self.pieces[i]
            out[mine] = self._values(channel, times[mine], piece.states(times[mine]), piece.regime)
        return out

    def maximum(self, channel: str) -> tuple[float, float]:
        """Largest value and its time; jumps count from both sides."""
        return self._largest(channel, 1.0)

    def minimum(self, channel: str) -> tuple[float, float]:
        """Smallest value and its time."""
        value, time = self._largest(channel, -1.0)
        return -value, time

    def peak(self, channel: str) -> tuple[float, float]:
        """The value of largest magnitude, with its sign, and its time."""
        return max(self.maximum(channel), self.minimum(channel), key=lambda extreme: abs(extreme[0]))

    def _largest(self, channel: str, sign: float) -> tuple[float, float]:
        if channel not in self._sampled:
            self._sampled[channel] = np.array([self._values(channel, *place) for place in self._looked_at])
        values = sign * self._sampled[channel]
        spans = np.ptp(values, axis=1)
        best, at = -inf, 0.0
        # between samples a step's polynomial rises by less than a good part of its range over the step
        for i in np.flatnonzero(values.max(axis=1) + spans >= values.max()):
            series = TO_CHEBYSHEV @ values[i]
            turns = chebyshev.chebroots(chebyshev.chebder(series)) if spans[i] > 0.0 else np.array([])
            turns = turns[(abs(turns.imag) < 1e-6) & (abs(turns.real) <= 1.0)].real
            points = np.concatenate([[-1.0, 1.0], turns])
            tops = chebyshev.chebval(points, series)
            if tops.max() > best:
                best = float(tops.max())
                begin, end = self.pieces[i].begin, self.pieces[i].end
                at = begin + 0.5 * (end - begin) * (1.0 + float(points[tops.argmax()]))
        return best, at

    @cached_property
    def _looked_at(self) -> list[tuple[Floats, Floats, Regime]]:
        """Of each piece some times, the states then (2n, T), and what rules."""
        spread = [(_inside(piece.begin, piece.end), piece) for piece in self.pieces]
        return [(times, piece.states(times), piece.regime) for times, piece in spread]

    def _values(self, channel: str, times: Floats, y: Floats, regime: Regime) -> Floats:
        system = self.system
        who, _, quantity = channel.rpartition(".")
        names = [body.name for body in system.bodies]
        n = len(names)
        if who in (elements := [e.name for e in system.elements]):
            i = elements.index(who)
            if quantity == "force":
                return np.asarray(system.forces(times, y, regime)[i])
            d, v = system.deflections(y)
            return np.asarray({"deflection": d, "deflection_rate": v}[quantity][i])
        if quantity in {"rotation", "rotation_rate"}:
            return np.asarray(y[system.turn + (0 if quantity == "rotation" else n)])
        i = names.index(who)
        if quantity == "acceleration":
            return np.asarray(system.accelerations(times, y, regime)[i])
        row = n if quantity.endswith("velocity") else 0
        frame = {"relative": system.bodies[i].parent, "excursion": system.bodies[i].vehicle}.get(quantity.split("_")[0])
        values: Floats = y[row + i] - (y[row + names.index(frame)] if frame else 0.0)
        return values


def _inside(begin: float, end: float) -> Floats:
    out: Floats = begin + 0.5 * (end - begin) * (1.0 + NODES)
    out[-1] = end
    return out


def simulate(scenario: CrashScenario | NetworkScenario, *, rtol: float = 1e-13, atol: float = 1e-14) -> Run:
    """Solve a scenario with located events; accurate to about 1e-12 of each channel's size."""
    return march(build(scenario), rtol=rtol, atol=atol)


def march(system: System, *, rtol: float = 1e-13, atol: float = 1e-14) -> Run:
    """Solve a system, whose laws keep what they remember in the end."""
    y, t = system.start(), 0.0
    events: list[Happening] = []
    modes = _settle(system, t, y, [Mode("open") for _ in system.elements])
    pieces: list[Piece] = []
    while t < system.duration:
        phase, y, arrived = _phase(system, modes, t, y, rtol=rtol, atol=atol)
        pieces += phase
        t = pieces[-1].end
        if not arrived:
            break  # the bar has turned too far
        after = _settle(system, t, y, modes)
        changed = zip(system.elements, modes, after, strict=True)
        events += [Happening(t, e.name, a.name, b.name) for e, a, b in changed if a.name != b.name]
        modes = after
        if len(events) > MOST_EVENTS:
            raise RuntimeError(f"more than {MOST_EVENTS} events by {t} s")
    return Run(system, pieces, events)


def _phase(
    system: System, modes: list[Mode], t: float, y: Floats, *, rtol: float, atol: float
) -> tuple[list[Piece], Floats, bool]:
    """The steps up to the next event or stop, the state there, and whether it was reached."""
    law, guards = _arrays(modes)
    regime = system.regime(law, t)
    longest = 1.0 / (STEPS_PER_RADIAN * system.rate())
    stop = system.stop_after(t)
    march = DOP853(lambda t, y: system.slope(t, y, regime), t, y, stop, max_step=longest, rtol=rtol, atol=atol)
    pieces: list[Piece] = []
    while march.status == "running":
        complaint = march.step()
        if complaint:
            raise RuntimeError(complaint)
        begin, states = float(march.t_old or 0.0), march.dense_output()
        switched, end = _first_fall(system, guards, states, regime, begin, float(march.t))
        pieces.append(Piece(begin, end, states, regime))
        if switched:
            return pieces, states(end), True
        if system.turn >= 0 and abs(march.y[system.turn]) > STEEPEST:
            return pieces, march.y, False
    return pieces, march.y, True


def _arrays(modes: list[Mode]) -> tuple[Floats, Floats]:
    """Forces (6, m), and guards (G, 6): element, g0, gd, gv, gt, ga."""
    whole = (0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    guards = [(i, *guard, *(0.0,) * (5 - len(guard))) for i, mode in enumerate(modes) for guard in mode.guards]
    return np.array([(*mode.force, *whole[len(mode.force) :]) for mode in modes]).T, np.array(guards).reshape(-1, 6)


def _settle(system: System, t: float, y: Floats, modes: list[Mode]) -> list[Mode]:
    """The modes just after this state. `modes`: those until now."""
    d, v = system.deflections(y)
    for i, (element, mode) in enumerate(zip(system.elements, modes, strict=True)):
        element.law.remember(mode, At(d[i], v[i], t))
    trial = modes
    for _ in range(20):
        regime = system.regime(_arrays(trial)[0], t)
        found: list[Mode | None] = [None] * len(modes)
        for later in (0.0, *LATER):
            d, v = system.deflections(_a_little_later(system, t, y, regime, later))
            for i, element in enumerate(system.elements):
                if found[i] is None:
                    mode, margin = element.law.mode(At(d[i], v[i], t + later))
                    if margin > 1.0 or later == LATER[-1]:
                        found[i] = mode
        settled = [mode for mode in found if mode is not None]
        if settled == trial:
            return settled
        trial = settled
    raise RuntimeError("no set of modes agrees with itself")


def _a_little_later(system: System, t: float, y: Floats, regime: Regime, h: float) -> Floats:
    k1 = system.slope(t, y, regime)
    k2 = system.slope(t + h / 2.0, y + h / 2.0 * k1, regime)
    k3 = system.slope(t + h / 2.0, y + h / 2.0 * k2, regime)
    k4 = system.slope(t + h, y + h * k3, regime)
    return y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


def _first_fall(system: System, guards: Floats, states: States, regime: Regime, begin: float, end: float) -> tuple[bool, float]:
    """Whether a guard falls below zero within the step, and when the first does (else the end of the step)."""
    which = guards[:, 0].astype(int)

    swings = bool(guards[:, 5].any())

    def values(times: Any) -> Floats:
        y = states(times)
        d, v = system.deflections(y)
        columns = guards.T[..., np.newaxis] if d.ndim > 1 else guards.T
        out: Floats = columns[1] + columns[2] * d[which] + columns[3] * v[which] + columns[4] * times
        if swings:  # of elements that have no arm on the bar
            out += columns[5] * (system.signs @ system.accelerations(times, y, regime))[which]
        return out

    def one(guard: int, time: float) -> float:
        return float(values(time)[guard])

    times = _inside(begin, end)
    sampled = values(times)
    first = inf
    for g in np.flatnonzero(sampled.min(axis=1) < np.ptp(sampled, axis=1)):
        deep = np.abs(guards[g, 2:]) @ (GAP, SPEED, TIME, ACCELERATION)
        first = min(first, _falls(partial(one, int(g)), times, sampled[g], deep))
    return first < inf, min(first, end)


def _falls(guard: Callable[[float], float], times: Floats, sampled: Floats, deep: float) -> float:
    """When a guard sampled within a step falls deeper than `deep` below zero, or infinity."""
    last = len(times) - 1
    for i in range(1, last + 1):
        right, depth = times[i], sampled[i]
        if depth >= -deep and i < last and depth <= min(sampled[i - 1], sampled[i + 1]):
            bounds = (times[i - 1], times[i + 1])
            dip = minimize_scalar(guard, bounds=bounds, method="bounded", options={"xatol": 1e-12})
            right, depth = float(dip.x), float(dip.fun)
        if depth < -deep:
            left = float(times[i - 1])
            return left if sampled[i - 1] <= 0.0 else float(brentq(guard, left, right, xtol=1e-16, rtol=1e-15))
    return inf


def coarse(scenario: CrashScenario | NetworkScenario, *, step: float = 1e-5) -> tuple[Floats, dict[str, Floats]]:
    """Fixed steps of RK4, each element's mode from the state alone, no events: good to about 1e-4.

    Returns times (T,) and, by channel, displacements, velocities and forces (T,).
    """
    system = build(scenario)
    laws = [element.law for element in system.elements]
    count = round(system.duration / step)
    y = system.start()
    states, forces = np.empty((count + 1, len(y))), np.empty((count + 1, len(laws)))

    def law_at(y: Floats) -> Regime:
        d, v = system.deflections(y)
        return Regime(_arrays([law.mode(At(d[i], v[i]))[0] for i, law in enumerate(laws)])[0], 0)

    for j in range(count + 1):
        d, v = system.deflections(y)
        for i, law in enumerate(laws):
            law.remember(law.mode(At(d[i], v[i]))[0], At(d[i], v[i]))
        states[j], forces[j] = y, system.forces(0.0, y, law_at(y))
        k1 = system.slope(0.0, y, law_at(y))
        y2 = y + step / 2.0 * k1
        k2 = system.slope(0.0, y2, law_at(y2))
        y3 = y + step / 2.0 * k2
        k3 = system.slope(0.0, y3, law_at(y3))
        y4 = y + step * k3
        y = y + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + system.slope(0.0, y4, law_at(y4)))
    n = len(system.bodies)
    out = {f"{e.name}.force": forces[:, i] for i, e in enumerate(system.elements)}
    out |= {f"{body.name}.displacement": states[:, i] for i, body in enumerate(system.bodies)}
    out |= {f"{body.name}.velocity": states[:, n + i] for i, body in enumerate(system.bodies)}
    return np.arange(count + 1.0) * step, out


def build(scenario: CrashScenario | NetworkScenario) -> System:
    """The scenario's bodies and elements, read off its fields."""
    return _network(scenario) if isinstance(scenario, NetworkScenario) else _crash(scenario)


def _network(scenario: NetworkScenario) -> System:
    bodies = [Body(m.name, m.mass, m.speed) for m in scenario.masses]
    elements = []
    for e in scenario.elements:
        signs = {name: sign for name, sign in zip(e.between, (-1.0, 1.0), strict=True) if name != "wall"}
        law = _curve(e) if isinstance(e, Crush) else LAWS[e.law](e.stiffness, e.damping, e.slack)
        elements.append(Element(e.name, law, signs, tuple(signs)))
    return System(bodies, elements, scenario.duration)


def _crash(scenario: CrashScenario) -> System:
    cars = {"vehicle1": scenario.vehicle1} | ({"vehicle2": scenario.vehicle2} if scenario.vehicle2 else {})
    bodies = [Body(name, car.mass, car.speed) for name, car in cars.items()]
    bar = scenario.bar
    arms = {("vehicle1", "right"): 0.0, ("vehicle1", "left"): 0.0}
    if bar is not None:
        assert scenario.vehicle2 is not None
        speed = (scenario.vehicle1.speed - scenario.vehicle2.speed) / 2.0 if bar.speed is None else bar.speed
        bodies.append(Body("bar", bar.mass, speed))
        if bar.inertia is not None:
            bodies.append(Body("bar.rotation", bar.inertia, 0.0))
        l1, l2, l3, l4 = _arm_lengths(bar)
        sides = [(car, side) for car in cars for side in ("right", "left")]
        arms = dict(zip(sides, (-l2, l1, -l3, l4), strict=True))
    elements = []
    for (car, side), arm in arms.items():
        signs = {car: 1.0} | ({"bar": -1.0 if car == "vehicle1" else 1.0} if bar is not None else {})
        turns = bar is not None and bar.inertia is not None
        acts_on = (*signs, "bar.rotation")
        elements.append(Element(f"{car}.{side}", _curve(getattr(cars[car], side)), signs, acts_on, arm if turns else 0.0))
    for occupant in scenario.occupants:
        _seat_occupant(occupant, bodies, elements, cars)
    return System(bodies, elements, scenario.duration, bar is None or bar.lever_arm == "work-conjugate")


def _seat_occupant(occupant: Occupant, bodies: list[Body], elements: list[Element], cars: dict[str, Vehicle]) -> None:
    car, name = f"vehicle{occupant.vehicle}", occupant.name
    speed = cars[car].speed
    if occupant.seat is None:
        acts_on = (name, car) if occupant.coupled else (name,)
        bodies.append(Body(name, occupant.mass, speed, car, car))
        elements.append(Element(f"{name}.restraint", _tie(occupant.restraint, occupant.mass), {name: 1.0, car: -1.0}, acts_on))
        return
    seat = f"{name}.seat"
    bodies.append(Body(seat, occupant.seat.mass, speed, car, car))
    bodies.append(Body(name, occupant.mass, speed, seat, car))
    harness, mounting = _tie(occupant.restraint, occupant.mass), _tie(occupant.seat.restraint, occupant.seat.mass)
    elements.append(Element(f"{name}.restraint", harness, {name: 1.0, seat: -1.0}, (name, seat)))
    acts_on = (seat, car) if occupant.coupled else (seat,)
    elements.append(Element(f"{seat}.restraint", mounting, {seat: 1.0, car: -1.0}, acts_on))


def _arm_lengths(bar: Bar) -> tuple[float, float, float, float]:
    if bar.arms is not None:
        return bar.arms.l1, bar.arms.l2, bar.arms.l3, bar.arms.l4
    across = bar.lateral_offset if bar.overlap is None else (1.0 - bar.overlap) * (bar.width or 0.0)
    shift = (across or 0.0) / 2.0
    assert bar.rail_spacing is not None
    near, far = bar.rail_spacing / 2.0 - shift, bar.rail_spacing / 2.0 + shift
    return near, far, far, near


def _tie(restraint: Restraint, mass: float) -> Law:
    damping = restraint.damping or 0.0
    if restraint.damping_ratio is not None:
        damping = 2.0 * restraint.damping_ratio * sqrt(restraint.stiffness * mass)
    return LAWS[restraint.law](restraint.stiffness, damping, restraint.slack)


def _curve(member: Member | Crush) -> Curve:
    line = member.unloading_stiffness if member.unloading == "plastic" else None
    if member.points is not None:
        d, f = np.array(member.points, dtype=float).T
        return Curve(list(d), list(f), [*(np.diff(f) / np.diff(d)), 0.0], line)
    pieces = member.pieces or ()
    knots = [0.0, *(piece.until or 0.0 for piece in pieces[:-1])]
    slopes = [piece.stiffness for piece in pieces]
    rises = [s * (b - a) for s, a, b in zip(slopes, knots, knots[1:], strict=False)]
    return Curve(knots, list((member.initial_force or 0.0) + np.cumsum([0.0, *rises])), slopes, line)


def p1_scenario(params: ArrayLike) -> CrashScenario:
    """Benchmark problem P1 for one set (12,): M1, M2, k1, k2, ds, ka, ca, kc, cc, ks, cs, v0, SI."""
    m1, m2, k1, k2, knee, ka, ca, kc, cc, ks, cs, v0 = (float(p) for p in np.asarray(params))

    def restraint(k: float, c: float) -> dict[str, object]:
        return {"stiffness": k, "damping": c, "slack": 0.005, "law": "kelvin-voigt"}

    members = {"pieces": [{"stiffness": k1, "until": knee}, {"stiffness": k2}]}
    return CrashScenario(
        duration=0.2,
        vehicle1={"mass": m1, "speed": v0, "members": members},
        vehicle2={"mass": m2, "speed": v0, "members": members},
        bar={"mass": 40.0, "inertia": 157.0, "rail_spacing": 1.1, "lateral_offset": 0.886, "lever_arm": "printed"},
        occupants=[
            {"kind": "adult", "mass": 80.0, "restraint": restraint(ka, ca)},
            {
                "kind": "child",
                "mass": 18.0,
                "restraint": restraint(kc, cc),
                "seat": {"mass": 5.0, "restraint": restraint(ks, cs)},
            },
        ],
    )


def p1_reference(params: ArrayLike) -> Floats:
    """P1's six outcomes (6,) for one set (12,), by `simulate`."""
    run = simulate(p1_scenario(params))
    signed = [
        -run.minimum("adult.acceleration")[0],
        run.maximum("adult.excursion")[0],
        -run.minimum("child.acceleration")[0],
        run.maximum("child.relative_displacement")[0],
        -run.minimum("vehicle1.acceleration")[0],
        run.maximum("vehicle1.displacement")[0],
    ]
    return np.array(signed)
