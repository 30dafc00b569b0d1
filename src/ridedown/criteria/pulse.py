"""What a crash pulse does to the vehicle: change of velocity, crush, time to rest, rebound, equivalent square waves.

Signs follow SAE J211: x points forward, so a vehicle that brakes has negative acceleration and its speed is positive. What
integrates a signal begins at time zero, the first contact, or at the first sample where that is later, unless told otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ridedown.criteria.checks import STANDARD_GRAVITY, from_time_zero, number, signal
from ridedown.criteria.motion import Motion


@dataclass(frozen=True, slots=True)
class Peak:
    """A value of largest magnitude, with its sign, in its SI unit, and when [s]."""

    value: float
    time: float

    @property
    def value_g(self) -> float:
        """An acceleration [g]."""
        return self.value / STANDARD_GRAVITY


def peak(time: ArrayLike, values: ArrayLike) -> Peak:
    """The value of largest magnitude of a channel, with its sign, and when it is first reached.

    time: (n,) [s]; values: (n,), of any unit. Between samples the signal is straight, so a sample is the peak.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`).

    >>> peak([0.0, 0.01, 0.02], [0.0, -1923.0, 310.0])  # femur force, N: compression is negative
    Peak(value=-1923.0, time=0.01)
    """
    times, numbers = signal(time, values, "values")
    i = int(np.argmax(np.abs(numbers)))
    return Peak(float(numbers[i]), float(times[i]))


def delta_v(time: ArrayLike, acceleration: ArrayLike, *, start: float | None = None) -> Peak:
    """Change of velocity: of all changes from the start on, the one of largest magnitude, with its sign [m/s], and when.

    In a crash with rebound it is reached when the vehicle leaves the obstacle, not when it stops. Exact over the signal that is
    straight between its samples: the velocity turns where the acceleration goes through zero.

    time: (n,) [s]; acceleration: (n,) [m/s2]; start [s]: time zero, or the first sample if that is later, if left out.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), or a start outside it.

    References: SAE J211-1 (signs).

    >>> change = delta_v([0.0, 0.10, 0.10, 0.15], [-150.0, -150.0, 2.0, 2.0])  # braked at 150 m/s2 for 100 ms
    >>> round(change.value, 6), round(change.time, 6)
    (-15.0, 0.1)
    """
    times, change = _motion(time, acceleration, 0.0, start).velocity_turns()
    i = int(np.argmax(np.abs(change)))
    return Peak(float(change[i]), float(times[i]))


def time_to_zero_velocity(
    time: ArrayLike, acceleration: ArrayLike, speed: float, *, start: float | None = None
) -> float | None:
    """When a vehicle that had a speed at the start first stands still [s, on the signal's clock]; None if it does not.

    time: (n,) [s]; acceleration: (n,) [m/s2], negative when braking; speed > 0 [m/s]; start [s]: see `delta_v`.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), a speed not above 0, a start outside the signal.

    >>> round(time_to_zero_velocity([0.0, 0.10], [-200.0, -200.0], 15.0), 6)
    0.075
    """
    return _motion(time, acceleration, _speed(speed), start).first_stop()


def dynamic_crush(time: ArrayLike, acceleration: ArrayLike, speed: float, *, start: float | None = None) -> Peak | None:
    """Dynamic crush against a rigid wall: the distance gone from contact to standstill [m], and when; None without standstill.

    The acceleration's double integral from the speed at contact. What it measures is the way of the accelerometer, so it is the
    crush of what lies ahead of it only where the obstacle does not move.

    time: (n,) [s]; acceleration: (n,) [m/s2], negative when braking; speed > 0 [m/s]; start [s]: see `delta_v`.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), a speed not above 0, a start outside the signal.

    References: M. Huang, "Vehicle Crash Mechanics", CRC Press, 2002 (dynamic crush by double integration).

    >>> crush = dynamic_crush([0.0, 0.10], [-200.0, -200.0], 15.0)  # v^2 / 2a
    >>> round(crush.value, 6), round(crush.time, 6)
    (0.5625, 0.075)
    """
    motion = _motion(time, acceleration, _speed(speed), start)
    stop = motion.first_stop()
    return None if stop is None else Peak(motion.at(stop)[2], stop)


def coefficient_of_restitution(
    time: ArrayLike, acceleration: ArrayLike, speed: float, *, start: float | None = None
) -> float | None:
    """Rebound against a rigid wall: the largest speed backwards over the speed at contact; None where it does not come to rest.

    0 where it stays. A record that ends in the rebound gives what was reached by then.

    time: (n,) [s]; acceleration: (n,) [m/s2], negative when braking; speed > 0 [m/s]; start [s]: see `delta_v`.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), a speed not above 0, a start outside the signal.

    >>> round(coefficient_of_restitution([0.0, 0.09], [-200.0, -200.0], 15.0), 6)  # 3 m/s back
    0.2
    """
    motion = _motion(time, acceleration, _speed(speed), start)
    if motion.first_stop() is None:
        return None
    # forwards again later is drift or braking on the ground, not rebound; the first stop makes the least velocity <= 0
    return max(0.0, -float(motion.velocity_turns()[1].min()) / speed)


def average_square_wave(time: ArrayLike, acceleration: ArrayLike, speed: float, *, start: float | None = None) -> float | None:
    """Average square wave [m/s2]: the constant deceleration that takes the same *time* to standstill, v0/tm; None without one.

    time: (n,) [s]; acceleration: (n,) [m/s2], negative when braking; speed > 0 [m/s]; start [s]: see `delta_v`.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), a speed not above 0, a start outside the signal.

    References: M. Huang, "Vehicle Crash Mechanics", CRC Press, 2002 (ASW).

    >>> round(average_square_wave([0.0, 0.05, 0.05, 0.15], [-100.0, -100.0, -200.0, -200.0], 15.0), 6)
    150.0
    """
    motion = _motion(time, acceleration, _speed(speed), start)
    stop = motion.first_stop()
    return None if stop is None else speed / (stop - float(motion.time[0]))


def equivalent_square_wave(
    time: ArrayLike, acceleration: ArrayLike, speed: float, *, start: float | None = None
) -> float | None:
    """Equivalent square wave [m/s2]: the constant deceleration that takes the same *way* to standstill, v0^2/(2C).

    None without a standstill. For C see `dynamic_crush`.

    time: (n,) [s]; acceleration: (n,) [m/s2], negative when braking; speed > 0 [m/s]; start [s]: see `delta_v`.

    Raises: InvalidInput for a signal that is not one (see `checks.signal`), a speed not above 0, a start outside the signal.

    References: M. Huang, "Vehicle Crash Mechanics", CRC Press, 2002 (ESW).

    >>> round(equivalent_square_wave([0.0, 0.10], [-200.0, -200.0], 15.0), 6)
    200.0
    """
    crush = dynamic_crush(time, acceleration, speed, start=start)
    return None if crush is None else speed * speed / (2.0 * crush.value)


def _speed(speed: float) -> float:
    return number(speed, "speed", "m/s", above=0.0)


def _motion(time: ArrayLike, acceleration: ArrayLike, speed: float, start: float | None) -> Motion:
    return Motion.of(*from_time_zero(*signal(time, acceleration), start), speed)
