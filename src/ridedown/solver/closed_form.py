"""The paper's analytic solution (eqs 25-33): an occupant on an engaged, linear restraint, forced by its vehicle.

An independent check on the event-exact solver: no step control, no events, no quadrature. It holds as long as the
restraint stays in one linear phase. A threshold restraint starts one when its slack is taken up, and another, with
`damping=0` and the state reached, when the relative velocity falls back to `v*` (eqs 17-18).

The vehicle's displacement is a polynomial on each of its pieces, so eqs 26, 32 and 33 are polynomials too, and
Duhamel's integral (eqs 27, 29) of a polynomial has an exact form. For the state `z = (x, v)` with
`z' = A z + sum_n b_n t^n` it reads

    z(t) = phi_0(A t) z(0) + sum_n n! t^(n+1) phi_(n+1)(A t) b_n,    phi_0 = exp,    phi_k(Z) = Z phi_(k+1)(Z) + I / k!

`phi_0` is eq 27's `exp(-xi omega t) (a sin + b cos)`, and what that turns into at and beyond critical damping. The
particular polynomial found by comparing coefficients is the same recurrence read upwards in k, which loses all digits
where `omega t` is small and has no answer at `k = 0`; read downwards it contracts.

Read differently from the print: `c_c = 2 m omega` and `omega_d = omega sqrt(1 - xi^2)` (below eq 29), `cos(omega_d t)`
outside the integrals of eq 29, `f_2` on the right of eq 31, and any state at the start where eq 28 has `x = 0`.

References
----------
"Simple and effective method to predict the occupant dynamic response under sudden impulse loads", section 3.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import ceil, comb, factorial

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from ridedown.errors import InvalidInput

Floats = NDArray[np.float64]

_SERIES_TERMS = 20  # beyond the highest phi wanted: with |A t| <= 1 the first term left out is below 1e-19 of the sum


@dataclass(frozen=True, slots=True, eq=False)
class VehicleMotion:
    """A vehicle's displacement as a piecewise polynomial.

    Parameters
    ----------
    breaks
        (n + 1,) times at which the pieces start, and the last one ends [s]
    coefficients
        (n, degree + 1) ascending powers of the time since each piece's start [m, m/s, m/s2, ...]

    Raises
    ------
    InvalidInput
        The shapes do not fit, or the breaks are out of order.
    """

    breaks: Floats
    coefficients: Floats

    def __post_init__(self) -> None:
        breaks, coefficients = np.asarray(self.breaks, dtype=float), np.asarray(self.coefficients, dtype=float)
        if coefficients.ndim != 2 or breaks.shape != (len(coefficients) + 1,):
            raise InvalidInput(
                f"breaks, coefficients: got shapes {breaks.shape}, {coefficients.shape}; need (n + 1,) and (n, degree + 1)."
            )
        if not np.all(np.diff(breaks) > 0.0):
            raise InvalidInput("breaks: got times out of order; need each later than the one before.")
        object.__setattr__(self, "breaks", breaks)
        object.__setattr__(self, "coefficients", coefficients)

    def displacement(self, times: ArrayLike) -> Floats:
        """The vehicle's displacement `x_p` [m], in the shape of `times` [s]."""
        return self._at(times, self.coefficients)

    def velocity(self, times: ArrayLike) -> Floats:
        """The vehicle's velocity [m/s], in the shape of `times` [s]."""
        return self._at(times, _derivative(self.coefficients))

    def _at(self, times: ArrayLike, coefficients: Floats) -> Floats:
        times = np.asarray(times, dtype=float)
        piece = np.clip(np.searchsorted(self.breaks, times, side="right") - 1, 0, len(coefficients) - 1)
        columns = np.moveaxis(coefficients[piece], -1, 0)
        return np.asarray(polynomial.polyval(times - self.breaks[piece], columns, tensor=False), dtype=float)


@dataclass(frozen=True, slots=True)
class Tie:
    """An engaged restraint: `k (delta - slack) + c (delta' - v_star)` (eqs 13 and 16)."""

    stiffness: float
    """`k` [N/m]"""
    damping: float
    """`c` [N s/m]"""
    slack: float
    """`delta*` [m]"""
    v_star: float = 0.0
    """Relative velocity at the instant that the slack was taken up [m/s]; 0 for a damper without threshold."""


@dataclass(frozen=True, slots=True)
class State:
    """Absolute displacement [m] and velocity [m/s] of a body at the instant that the phase starts."""

    displacement: float
    velocity: float


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Absolute displacement [m], velocity [m/s] and acceleration [m/s2] of a body at the times asked for, each (T,)."""

    displacement: Floats
    velocity: Floats
    acceleration: Floats


def adult_forcing(vehicle: VehicleMotion, tie: Tie, times: ArrayLike) -> Floats:
    """`f(t)` of eq 26 [N]: what the vehicle's motion does to an adult, in the shape of `times` [s]."""
    # eq. 26
    velocity, displacement = vehicle.velocity(times), vehicle.displacement(times)
    return tie.damping * (velocity + tie.v_star) + tie.stiffness * (displacement + tie.slack)


def harness_forcing(harness: Tie) -> float:
    """`f_1` of eq 32 [N]: constant, from the harness between child and seat."""
    # eq. 32
    return harness.damping * harness.v_star + harness.stiffness * harness.slack


def seat_forcing(vehicle: VehicleMotion, seat: Tie, harness: Tie, times: ArrayLike) -> Floats:
    """`f_2(t)` of eq 33 [N]: what the vehicle's motion does to a child's seat, in the shape of `times` [s]."""
    # eq. 33
    return adult_forcing(vehicle, seat, times) - harness_forcing(harness)


def adult(vehicle: VehicleMotion, mass: float, tie: Tie, *, engaged_at: float, start: State, times: ArrayLike) -> Motion:
    """Motion of an adult on an engaged restraint: eq 25 solved by eqs 27-29, exact to round-off.

    Parameters
    ----------
    vehicle
        motion of the vehicle that the occupant rides in
    mass
        `m_o` [kg]
    tie
        the restraint; under, at or above critical damping, or none
    engaged_at
        when the phase starts [s]
    start
        the occupant at that instant
    times
        (T,) times asked for, none before `engaged_at` [s]

    Raises
    ------
    InvalidInput
        A time lies before the phase or outside the vehicle's motion, or `mass` is not positive.

    Examples
    --------
    A car stopping at 100 m/s2 from 10 m/s, an undamped belt of 10 rad/s without slack: twice the car's deceleration.

    >>> car = VehicleMotion(np.array([0.0, 0.4]), np.array([[0.0, 10.0, -50.0]]))
    >>> belt = Tie(stiffness=8000.0, damping=0.0, slack=0.0)
    >>> rider = adult(car, 80.0, belt, engaged_at=0.0, start=State(0.0, 10.0), times=[np.pi / 10])
    >>> round(float(rider.acceleration[0]), 6)
    -200.0
    """
    # eq. 25, with eq. 26 on its right
    forcing = _vehicle_forcing(vehicle, tie)[:, np.newaxis, :]
    stiffness, damping = np.array([[tie.stiffness]]), np.array([[tie.damping]])
    (motion,) = _respond([mass], stiffness, damping, forcing, vehicle.breaks, engaged_at, [start], times)
    return motion


def child_in_seat(
    vehicle: VehicleMotion,
    child_mass: float,
    harness: Tie,
    *,
    seat_mass: float,
    seat: Tie,
    engaged_at: float,
    child_start: State,
    seat_start: State,
    times: ArrayLike,
) -> tuple[Motion, Motion]:
    """Motions of a child and of its seat, harness and seat restraint both engaged: eqs 30-33, exact to round-off.

    Parameters
    ----------
    vehicle
        motion of the vehicle that the seat stands in
    child_mass
        `m_co` [kg]
    harness
        the restraint between child and seat
    seat_mass
        `m_s` [kg]
    seat
        the restraint between seat and vehicle
    engaged_at
        when the phase starts, that is when the later of the two engages [s]
    child_start
        the child at that instant
    seat_start
        the seat at that instant
    times
        (T,) times asked for, none before `engaged_at` [s]

    Raises
    ------
    InvalidInput
        A time lies before the phase or outside the vehicle's motion, or a mass is not positive.
    """
    # eq. 30 (child) and eq. 31 (seat), with eqs. 32 and 33 on the right
    forcing = np.zeros((len(vehicle.coefficients), 2, vehicle.coefficients.shape[1]))
    forcing[:, 0, 0] = harness_forcing(harness)
    forcing[:, 1, :] = _vehicle_forcing(vehicle, seat)
    forcing[:, 1, 0] -= harness_forcing(harness)
    stiffness = _chain(harness.stiffness, seat.stiffness)
    damping = _chain(harness.damping, seat.damping)
    masses, starts = [child_mass, seat_mass], [child_start, seat_start]
    child, in_seat = _respond(masses, stiffness, damping, forcing, vehicle.breaks, engaged_at, starts, times)
    return child, in_seat


def _chain(harness: float, seat: float) -> Floats:
    return np.array([[harness, -harness], [-harness, harness + seat]])


def _vehicle_forcing(vehicle: VehicleMotion, tie: Tie) -> Floats:
    """Coefficients (n, degree + 1) of eq 26 on each piece."""
    forcing = tie.damping * _derivative(vehicle.coefficients) + tie.stiffness * vehicle.coefficients
    forcing[:, 0] += tie.damping * tie.v_star + tie.stiffness * tie.slack
    return forcing


def _derivative(coefficients: Floats) -> Floats:
    """Of polynomials along the last axis, with a zero in place of the power that drops out."""
    slopes = np.zeros_like(coefficients)
    slopes[..., :-1] = coefficients[..., 1:] * np.arange(1, coefficients.shape[-1])
    return slopes


def _respond(
    masses: list[float],
    stiffness: Floats,
    damping: Floats,
    forcing: Floats,
    breaks: Floats,
    start_time: float,
    start: list[State],
    times: ArrayLike,
) -> list[Motion]:
    """Solve `M x'' + C x' + K x = F(t)`, F (n, bodies, degree + 1) polynomial on each piece; one motion per body."""
    times = _checked_times(times, start_time, breaks)
    if not all(mass > 0.0 for mass in masses):
        raise InvalidInput(f"mass: got {min(masses)} kg; need > 0 kg.")
    per_mass = 1.0 / np.array(masses)
    springs, dampers = per_mass[:, np.newaxis] * stiffness, per_mass[:, np.newaxis] * damping
    bodies = len(masses)

    # Velocities are divided by the fastest rate, so that |A| is of its size and not of its square.
    rate = max(float(np.sqrt(np.linalg.norm(springs, np.inf))), float(np.linalg.norm(dampers, np.inf))) or 1.0
    matrix = np.block([[np.zeros((bodies, bodies)), rate * np.eye(bodies)], [-springs / rate, -dampers]])
    pushes = np.concatenate([np.zeros_like(forcing), per_mass[:, np.newaxis] * forcing / rate], axis=1)

    state = np.array([s.displacement for s in start] + [s.velocity / rate for s in start])
    states = np.empty((len(times), 2 * bodies))
    rates = np.empty_like(states)
    for begin, end, origin, push in _steps(breaks, pushes, start_time, float(np.linalg.norm(matrix, np.inf))):
        inside = (times >= begin) & (times <= end)
        local = _shifted(push, begin - origin)
        reached = _advance(matrix, local, state, np.append(times[inside] - begin, end - begin))
        states[inside], state = reached[:-1], reached[-1]
        applied = polynomial.polyval(times[inside] - begin, local.T)
        rates[inside] = states[inside] @ matrix.T + applied.T
    return [Motion(states[:, i], rate * states[:, bodies + i], rate * rates[:, bodies + i]) for i in range(bodies)]


def _checked_times(times: ArrayLike, start_time: float, breaks: Floats) -> Floats:
    times = np.atleast_1d(np.asarray(times, dtype=float))
    if not breaks[0] <= start_time <= breaks[-1]:
        raise InvalidInput(f"engaged_at: got {start_time} s; need a time within the vehicle's motion.")
    if times.size and not (times.min() >= start_time and times.max() <= breaks[-1]):
        raise InvalidInput(
            f"times: got {times.min()} .. {times.max()} s; need {start_time} .. {breaks[-1]} s."
            " Ask within the phase and the vehicle's motion."
        )
    return times


def _steps(breaks: Floats, pushes: Floats, start_time: float, size: float) -> list[tuple[float, float, float, Floats]]:
    """Spans (begin, end, its piece's origin and polynomials) from the start on, cut to `size (end - begin) <= 1`."""
    steps = []
    for origin, end, push in zip(breaks[:-1], breaks[1:], pushes, strict=True):
        begin = max(start_time, origin)
        if begin < end:
            cuts = np.linspace(begin, end, 1 + ceil(size * (end - begin)) if size > 0.0 else 2)
            steps += [(a, b, origin, push) for a, b in pairwise(cuts)]
    return steps


def _shifted(coefficients: Floats, offset: float) -> Floats:
    """The same polynomials (rows) in powers of `t - offset`."""
    binomials, powers = _binomials(coefficients.shape[1])
    shifted: Floats = coefficients @ (binomials * offset**powers)
    return shifted


@lru_cache(maxsize=8)
def _binomials(size: int) -> tuple[Floats, NDArray[np.int64]]:
    """`n over j` and `n - j`, zero where j > n."""
    over = np.array([[comb(n, j) for j in range(size)] for n in range(size)], dtype=float)
    n, j = np.indices((size, size))
    return over, np.maximum(n - j, 0)


def _advance(matrix: Floats, push: Floats, state: Floats, times: Floats) -> Floats:
    """States (T, d) at `times` (T,) after `state`, under `z' = matrix z + push(t)`, as the module's text says."""
    degree = push.shape[1] - 1
    scaled = times[:, np.newaxis, np.newaxis] * matrix
    identity = np.eye(len(matrix))
    top = degree + 1 + _SERIES_TERMS
    phi = np.broadcast_to(identity / factorial(top), scaled.shape)
    reached = np.zeros((len(times), len(matrix)))
    for k in range(top - 1, -1, -1):
        phi = scaled @ phi + identity / factorial(k)
        if 1 <= k <= degree + 1:
            reached += (factorial(k - 1) * times**k)[:, np.newaxis] * (phi @ push[:, k - 1])
    return reached + phi @ state
