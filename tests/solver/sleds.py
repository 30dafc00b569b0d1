"""Sleds put together by hand: one mass, held by restraints, in a vehicle on a prescribed pulse."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ridedown.network import Builder, Network, Pulse, Restraint, channels
from ridedown.network.builder import AnyLaw
from ridedown.solver.phases import Phases
from ridedown.solver.solve import solve_one

MASS = 78.0  # kg
SPEED = 15.0  # m/s


def points(times: ArrayLike, accelerations: ArrayLike) -> Pulse:
    """A pulse that is straight between points [s, m/s2]."""
    start, values = np.asarray(times, dtype=float), np.asarray(accelerations, dtype=float)
    series = np.zeros((start.size, 2))
    series[:, 0] = values
    series[:-1, 1] = np.diff(values) / np.diff(start)
    return Pulse(start, series)


def constant(deceleration: float) -> Pulse:
    return Pulse(np.zeros(1), np.array([[-deceleration]]))


CAR = points([0.0, 0.02, 0.05, 0.07, 0.1, 0.12], [0.0, -150.0, -250.0, -300.0, -100.0, 0.0])


def sled(*laws: AnyLaw, pulse: Pulse = CAR, duration: float = 0.2, speed: float = SPEED) -> Network:
    builder = Builder()
    car = builder.driven("vehicle1", pulse, speed=speed)
    body = builder.body("driver", mass=MASS, speed=speed, parent=car)
    for n, law in enumerate(laws):
        builder.element(f"driver.{n}", law, deflection={body: 1.0, car: -1.0})
    return builder.build(duration=duration)


def spring(stiffness: float, **more: object) -> Restraint:
    """A restraint of one piece."""
    return Restraint((0.0,), (0.0,), (stiffness,), **more)


class Solved:
    """A solved network, by channel name."""

    def __init__(self, network: Network) -> None:
        self.network = network
        self.phases: Phases
        self.phases, self.stop = solve_one(network)
        self._channels = channels(network)

    def series(self, channel: str) -> np.ndarray:
        return self.phases.series(self._channels[channel])

    def at(self, channel: str, times: ArrayLike) -> np.ndarray:
        return self.phases.at(self.series(channel), np.asarray(times, dtype=float))

    def largest(self, channel: str) -> tuple[float, float]:
        return self.phases.largest(self.series(channel), 1)

    @property
    def changes(self) -> list[tuple[int, int]]:
        """Modes before and after, in order, without those that were left at once."""
        return list(zip(self.phases.event_before.tolist(), self.phases.event_after.tolist(), strict=True))

    @property
    def times(self) -> list[float]:
        return [float(time) for time in self.phases.event_time]
