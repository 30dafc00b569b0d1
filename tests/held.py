"""Occupants held in a vehicle, driven or crashing, drawn at random: as a network, and for the independent simulator.

Many numbers are drawn from a few round ones, so that timers, knees and forces often coincide, as they do in real input.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ridedown.network import Action, Builder, Curve, Linear, Network, Pulse, Restraint, Timer
from ridedown.network.builder import AnyLaw
from tests import independent, independent_laws
from tests.independent import Body, Drive, Element, System
from tests.independent_restraint import Restraint as Held

CAR = "vehicle1"
HEAVY = 1200.0  # kg


@dataclass(frozen=True)
class Part:
    """A force law between bodies: its deflection is the sum of their displacements by sign."""

    name: str
    law: AnyLaw
    signs: dict[str, float]


@dataclass(frozen=True)
class Case:
    """car: the pulse of a driven vehicle, or the front of one of 1200 kg that meets a wall and feels its occupants."""

    car: Pulse | Curve
    speed: float
    masses: dict[str, float]
    parts: tuple[Part, ...]
    duration: float

    def nudged(self) -> Case:
        """The same with its last mass a trace heavier."""
        last = list(self.masses)[-1]
        return replace(self, masses=self.masses | {last: self.masses[last] * (1.0 + 1e-13)})


def as_network(case: Case) -> Network:
    builder = Builder()
    if isinstance(case.car, Pulse):
        bodies = {CAR: builder.driven(CAR, case.car, speed=case.speed)}
    else:
        bodies = {CAR: builder.body(CAR, mass=HEAVY, speed=case.speed)}
        builder.element("front", case.car, deflection={bodies[CAR]: 1.0})
    for name, mass in case.masses.items():
        bodies[name] = builder.body(name, mass=mass, speed=case.speed, parent=bodies[CAR])
    for part in case.parts:
        builder.element(part.name, part.law, deflection={bodies[name]: sign for name, sign in part.signs.items()})
    return builder.build(duration=case.duration)


def as_system(case: Case) -> System:
    elements = [Element(part.name, _independent(part.law), part.signs, tuple(part.signs)) for part in case.parts]
    if isinstance(case.car, Pulse):
        car = Body(CAR, np.inf, case.speed, drive=_drive(case.car))
    else:
        car = Body(CAR, HEAVY, case.speed)
        elements.append(Element("front", _independent(case.car), {CAR: 1.0}, (CAR,)))
    return System(
        [car, *(Body(name, mass, case.speed, CAR, CAR) for name, mass in case.masses.items())], elements, case.duration
    )


def _drive(pulse: Pulse) -> Drive:
    length, amplitude = float(pulse.length), float(pulse.amplitude)
    powers = length ** np.arange(pulse.series.shape[1])
    return Drive([length * float(start) for start in pulse.start], [amplitude * row / powers for row in pulse.series])


def _independent(law: AnyLaw) -> independent_laws.Law:
    match law:
        case Restraint():
            return Held(law)
        case Curve():
            return independent_laws.Curve(list(law.knots), list(law.forces), list(law.slopes), law.unloading)
        case Linear():
            return independent_laws.Linear(law.stiffness, law.damping, law.slack)
    raise TypeError(type(law))


def run(case: Case) -> independent.Run:
    return independent.march(as_system(case))


def random_case(seed: int) -> Case:
    rng = np.random.default_rng(seed)
    names = ["driver"] if rng.random() < 0.5 else ["driver.pelvis", "driver.chest", "driver.head"][: rng.integers(2, 4)]
    masses = {name: float(rng.choice([5.0, 20.0, 35.0, 78.0]) * rng.choice([1.0, rng.uniform(0.8, 1.2)])) for name in names}
    parts = []
    for i, (name, mass) in enumerate(masses.items()):
        kinds = [_belt, *rng.choice([_belt, _bag, _surface], rng.integers(0, 3))] if i < 2 else [_bag]
        for n, kind in enumerate(kinds):
            parts.append(Part(f"{name}.{n}", kind(rng, mass), {name: 1.0, CAR: -1.0}))
        if rng.random() < 0.3:
            parts.append(Part(f"{name}.back", _surface(rng, mass), {name: -1.0, CAR: 1.0}))
    for first, second in pairwise(names):
        stiffness = float(rng.choice([20e3, 50e3, 200e3]))
        parts.append(Part(f"{first}-{second}", Linear(stiffness, float(rng.choice([0.0, 300.0]))), {first: -1.0, second: 1.0}))
    car = _pulse(rng) if rng.random() < 0.7 else Curve((0.0, 0.2), (50e3, 150e3), (500e3, 300e3), rng.choice([None, 5e6]))
    return Case(car, 15.0, masses, tuple(parts), float(rng.choice([0.1, 0.15])))


def _pulse(rng: np.random.Generator) -> Pulse:
    if rng.random() < 0.4:  # a haversine to the tenth power of time, then nothing, or its last value for ever
        series = np.zeros((2, 9))
        for power, (number, factorial) in enumerate(((2.0, 2.0), (4.0, -24.0), (6.0, 720.0), (8.0, -40320.0))):
            series[0, 2 * (power + 1)] = 0.5 * (2.0 * np.pi) ** number / factorial
        series[0, :] *= -1.0
        series[1, 0] = -rng.choice([0.0, 0.05])
        scale = float(rng.choice([100.0, 200.0, 300.0]))
        return Pulse(np.array([0.0, 0.5]), series, scale, float(rng.choice([0.08, 0.1, rng.uniform(0.07, 0.14)])))
    count = rng.integers(3, 7)
    times = np.concatenate([[0.0], np.sort(rng.choice(np.arange(0.01, 0.12, 0.01), count - 1, replace=False))])
    levels = -rng.choice([0.0, 100.0, 150.0, 250.0, 350.0, rng.uniform(0.0, 300.0)], count)
    if rng.random() < 0.2:
        levels[rng.integers(count)] *= -1.0
    series = np.zeros((count, 2))
    series[:, 0] = levels
    series[:-1, 1] = np.diff(levels) / np.diff(times)
    series[-1, 0] *= rng.choice([0.0, 1.0])
    return Pulse(times, series)


def _curve(rng: np.random.Generator, stiffness: float) -> dict[str, object]:
    """A curve from zero that rises, of one to three pieces, with or without an unloading line."""
    count = rng.integers(1, 4)
    knots = (0.0, *np.cumsum(rng.choice([0.01, 0.03, 0.05], count - 1)).tolist())
    slopes = tuple((stiffness * rng.choice([0.3, 1.0, 1.0, 2.0], count)).tolist())
    forces = (0.0, *np.cumsum(np.diff(knots) * slopes[:-1]).tolist())
    unloading = None if rng.random() < 0.5 else float(max(slopes) * rng.choice([1.0, 1.5, 4.0]))
    return {"knots": knots, "forces": forces, "slopes": slopes, "unloading": unloading}


def _damping(rng: np.random.Generator, stiffness: float, mass: float) -> float:
    return float(rng.choice([0.0, 0.0, 0.1, 0.5]) * 2.0 * np.sqrt(stiffness * mass))


def _surface(rng: np.random.Generator, mass: float) -> Restraint:
    stiffness = float(rng.choice([20e3, 60e3, 150e3]))
    return Restraint(
        **_curve(rng, stiffness), slack=float(rng.choice([0.0, 0.05, 0.1])), damping=_damping(rng, stiffness, mass)
    )


def _bag(rng: np.random.Generator, mass: float) -> Restraint:
    fire, fill = rng.choice([0.0, 0.01, 0.02, rng.uniform(0.0, 0.03)]), rng.choice([0.02, 0.03, rng.uniform(0.005, 0.04)])
    timers = (Timer(Action.FILL, float(fire), float(1.0 / fill)), Timer(Action.FILL, float(fire + fill), 0.0))
    stiffness = float(rng.choice([10e3, 40e3, 80e3]))
    gap, damping = float(rng.choice([0.0, 0.05, 0.12])), _damping(rng, stiffness, mass)
    return Restraint(**_curve(rng, stiffness), slack=gap, damping=damping, empty=True, timers=timers)


def _belt(rng: np.random.Generator, mass: float) -> Restraint:
    stiffness = float(rng.choice([40e3, 60e3, 100e3]))
    timers = []
    lock = float(rng.choice([0.005, 0.01, rng.uniform(0.0, 0.02)]))
    if free := rng.random() < 0.5:
        timers.append(Timer(Action.LOCK, lock))
    limits, payouts, stage_2 = _limiter(rng)
    timers += stage_2
    stalls = [np.inf, np.inf]
    for n, action in enumerate((Action.PULL_1, Action.PULL_2)[: rng.integers(0, 3)]):
        fire = float((lock if free else 0.0) + rng.choice([0.0, 0.002, 0.006, rng.uniform(0.0, 0.02)]))
        duration = float(rng.choice([0.005, 0.01, 0.02]))
        timers += [Timer(action, fire, float(rng.choice([0.02, 0.08, 0.15]) / duration)), Timer(action, fire + duration, 0.0)]
        if min(limits) < np.inf or rng.random() < 0.7:
            stalls[n] = float(rng.choice([800.0, 1500.0, rng.uniform(500.0, 1800.0)]))
    slack, damping = float(rng.choice([0.0, 0.02, 0.05])), _damping(rng, stiffness, mass)
    reel = {"limits": limits, "payouts": payouts, "stalls": tuple(stalls), "free": free, "timers": tuple(timers)}
    return Restraint(**_curve(rng, stiffness), slack=slack, damping=damping, **reel)


def _limiter(rng: np.random.Generator) -> tuple[tuple[float, float], tuple[float, float], list[Timer]]:
    limit = float(rng.choice([2000.0, 3000.0, 5000.0, rng.uniform(1900.0, 6000.0)]))
    end = float(rng.choice([0.1, 0.2, np.inf]))
    second = float(rng.choice([1900.0, 3000.0, 4500.0]))
    match rng.integers(4):
        case 0:
            return (np.inf, np.inf), (np.inf, np.inf), []
        case 1:
            return (limit, np.inf), (end, np.inf), []
        case 2:
            return (limit, second), (float(rng.choice([0.02, 0.05, 0.08])), end), []
        case _:
            return (limit, second), (end, end), [Timer(Action.STAGE_2, float(rng.choice([0.03, 0.05, 0.07])))]
