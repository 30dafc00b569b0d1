"""The paper's closed form against scipy, against textbook solutions, and against its own eq 29 as printed."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from itertools import pairwise
from math import factorial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from ridedown.errors import InvalidInput
from ridedown.solver import closed_form
from ridedown.solver.closed_form import Motion, State, Tie, VehicleMotion

Floats = NDArray[np.float64]
CRITERIA = Path(__file__).resolve().parents[3] / "shared" / "vectors" / "criteria.json"
MASS = 80.0
STIFFNESS = 98.1e3
CRITICAL = 2.0 * np.sqrt(STIFFNESS * MASS)


def braking(pieces: int = 7, degree: int = 9, seed: int = 5) -> VehicleMotion:
    """A car that brakes from 13.33 m/s in 0.12 s, unevenly: smooth to the first derivative at the breaks only."""
    random = np.random.default_rng(seed)
    breaks = np.concatenate([[0.0], np.sort(random.uniform(0.0, 0.12, pieces - 1)), [0.12]])
    coefficients = np.zeros((pieces, degree + 1))
    position, speed = 0.0, 13.33
    for row, length in zip(coefficients, np.diff(breaks), strict=True):
        row[2:] = -random.uniform(20.0, 160.0) * random.normal(1.0, 0.3, degree - 1) / length ** np.arange(degree - 1)
        row[2:] /= np.arange(2, degree + 1) ** 3
        row[:2] = position, speed
        position = float(np.polyval(row[::-1], length))
        speed = float(np.polyval(np.polyder(row[::-1]), length))
    return VehicleMotion(breaks, coefficients)


def by_scipy(
    car: VehicleMotion,
    masses: Floats,
    stiffness: Floats,
    damping: Floats,
    forcing: Callable[[float, int], Floats],
    engaged_at: float,
    starts: Sequence[State],
    times: Floats,
) -> Floats:
    """`M x'' + C x' + K x = F(t)` by DOP853, restarted at each break of the car's motion: (3, bodies, T)."""
    n = len(masses)
    out = np.empty((3, n, len(times)))

    def slope(t: float, z: Floats, piece: int) -> Floats:
        x, v = z[:n], z[n:]
        return np.concatenate([v, (forcing(t, piece) - stiffness @ x - damping @ v) / masses])

    z = np.array([s.displacement for s in starts] + [s.velocity for s in starts])
    for piece, (begin, b) in enumerate(pairwise(car.breaks)):
        a = max(begin, engaged_at)
        if a >= b:
            continue
        inside = np.flatnonzero((times >= a) & (times <= b))
        stops = np.union1d(times[inside], [b])
        run = solve_ivp(slope, (a, b), z, "DOP853", stops, args=(piece,), max_step=5e-4, rtol=1e-12, atol=1e-13)
        for j, at in enumerate(inside):
            out[0, :, at], out[1, :, at] = run.y[:n, j], run.y[n:, j]
            out[2, :, at] = slope(times[at], run.y[:, j], piece)[n:]
        z = run.y[:, -1]
    return out


def piece_of(car: VehicleMotion, piece: int) -> VehicleMotion:
    """One piece alone, so that a derivative is not read across a break."""
    return VehicleMotion(car.breaks[piece : piece + 2], car.coefficients[piece : piece + 1])


def assert_motion(motion: Motion, expected: Floats, tolerance: float) -> None:
    for ours, theirs in zip((motion.displacement, motion.velocity, motion.acceleration), expected, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=tolerance * np.abs(theirs).max())


@pytest.mark.parametrize(
    "ratio",
    [0.0, 0.1, 0.5, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 3.0, 50.0],
    ids=["undamped", "10 %", "50 %", "just under critical", "critical", "just over critical", "overdamped", "stiff"],
)
def test_adult_agrees_with_scipy(ratio: float) -> None:
    car = braking()
    tie = Tie(STIFFNESS, ratio * CRITICAL, slack=0.005, v_star=0.4)
    start = State(float(car.displacement(0.011)) + 0.005, 13.33)
    times = np.linspace(0.011, 0.12, 400)
    motion = closed_form.adult(car, MASS, tie, engaged_at=0.011, start=start, times=times)
    expected = by_scipy(
        car,
        np.array([MASS]),
        np.array([[tie.stiffness]]),
        np.array([[tie.damping]]),
        lambda t, piece: np.array([closed_form.adult_forcing(piece_of(car, piece), tie, t)]),
        0.011,
        [start],
        times,
    )
    # scipy reads its answers off an interpolant, which the stiff case (3500 1/s) strains: 1.3e-10 with steps of 0.5 ms
    assert_motion(motion, expected[:, 0], 1e-9 if ratio > 10.0 else 2e-12)


def test_child_and_seat_agree_with_scipy() -> None:
    car = braking(seed=6)
    harness = Tie(49e3, 939.0, slack=0.005, v_star=0.7)
    seat = Tie(50e3, 500.0, slack=0.004, v_star=0.5)
    starts = [State(0.22, 13.3), State(0.215, 12.6)]
    times = np.linspace(0.02, 0.12, 300)
    child, seat_motion = closed_form.child_in_seat(
        car,
        18.0,
        harness,
        seat_mass=5.0,
        seat=seat,
        engaged_at=0.02,
        child_start=starts[0],
        seat_start=starts[1],
        times=times,
    )

    def forcing(t: float, piece: int) -> Floats:
        return np.array(
            [closed_form.harness_forcing(harness), closed_form.seat_forcing(piece_of(car, piece), seat, harness, t)]
        )

    expected = by_scipy(
        car,
        np.array([18.0, 5.0]),
        np.array([[49e3, -49e3], [-49e3, 99e3]]),
        np.array([[939.0, -939.0], [-939.0, 1439.0]]),
        forcing,
        0.02,
        starts,
        times,
    )
    assert_motion(child, expected[:, 0], 2e-12)
    assert_motion(seat_motion, expected[:, 1], 2e-12)


def test_a_child_on_a_rigid_harness_is_an_adult() -> None:
    # two masses that cannot part move as one: the 2-degree-of-freedom system against the single one
    car = braking()
    seat = Tie(50e3, 500.0, slack=0.005, v_star=0.3)
    start, times = State(0.1, 12.0), np.linspace(0.01, 0.12, 50)
    child, _ = closed_form.child_in_seat(
        car,
        18.0,
        Tie(5e8, 5e4, slack=0.0),
        seat_mass=5.0,
        seat=seat,
        engaged_at=0.01,
        child_start=start,
        seat_start=start,
        times=times,
    )
    together = closed_form.adult(car, 23.0, seat, engaged_at=0.01, start=start, times=times)
    # the harness still gives by about force / stiffness = 2e4 N / 5e8 N/m = 4e-5 m
    np.testing.assert_allclose(child.displacement, together.displacement, rtol=0.0, atol=1e-4)


def test_constant_deceleration_with_slack() -> None:
    """The vector of the field: a_max = E (1 + sqrt(1 + 2 w^2 s / E)), d_max = s + a_max / w^2."""
    g, level, frequency, slack = 9.80665, 20.0, 6.0, 0.05
    brake, rate = level * g, 2.0 * np.pi * frequency
    car = VehicleMotion(np.array([0.0, 0.3]), np.array([[0.0, 30.0, -brake / 2.0]]))
    engaged_at = np.sqrt(2.0 * slack / brake)
    start = State(30.0 * engaged_at, 30.0)
    tie = Tie(MASS * rate**2, 0.0, slack)
    peak = brake * (1.0 + np.sqrt(1.0 + 2.0 * rate**2 * slack / brake))
    # relative motion from v = sqrt(2 s E) and d = s: the peak is where tan(w t) = -v w / E, in the second quadrant
    at = engaged_at + (np.pi - np.arctan(rate * np.sqrt(2.0 * slack * brake) / brake)) / rate
    motion = closed_form.adult(car, MASS, tie, engaged_at=engaged_at, start=start, times=[at])
    excursion = motion.displacement - car.displacement([at])
    np.testing.assert_allclose(-motion.acceleration, peak, rtol=1e-13)
    np.testing.assert_allclose(excursion, slack + peak / rate**2, rtol=1e-13)
    if not CRITERIA.exists():
        pytest.skip("the shared check vectors are not beside this repository")
    case = "E=20 g, f=6 Hz, s=0.05 m"
    vector = json.loads(CRITERIA.read_text())["restrained_occupant_under_constant_deceleration"][case]
    assert -motion.acceleration[0] / g == pytest.approx(vector["a_max_g"], abs=5e-4)  # g, as printed
    assert excursion[0] == pytest.approx(vector["d_max_m"], abs=5e-5)  # m, as printed


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0, 2.0])
def test_free_vibration_in_a_standing_car(ratio: float) -> None:
    """Textbook solutions, one per kind of damping, of an occupant thrown at a car that stands."""
    car = VehicleMotion(np.array([0.0, 1.0]), np.zeros((1, 3)))
    mass, rate, speed = 2.0, 30.0, 5.0
    tie = Tie(mass * rate**2, 2.0 * ratio * mass * rate, slack=0.0)
    t = np.linspace(0.0, 1.0, 101)
    decay = ratio * rate
    if ratio < 1.0:
        damped = rate * np.sqrt(1.0 - ratio**2)
        expected = speed / damped * np.exp(-decay * t) * np.sin(damped * t)
    elif ratio == 1.0:
        expected = speed * t * np.exp(-rate * t)
    else:
        root = rate * np.sqrt(ratio**2 - 1.0)
        expected = speed / (2.0 * root) * (np.exp((root - decay) * t) - np.exp((-root - decay) * t))
    motion = closed_form.adult(car, mass, tie, engaged_at=0.0, start=State(0.0, speed), times=t)
    np.testing.assert_allclose(motion.displacement, expected, rtol=0.0, atol=1e-13 * np.abs(expected).max())


def test_nothing_holds_a_loose_occupant() -> None:
    car = braking()
    times = np.linspace(0.0, 0.12, 9)
    motion = closed_form.adult(car, MASS, Tie(0.0, 0.0, 0.005), engaged_at=0.0, start=State(1.0, 13.0), times=times)
    np.testing.assert_allclose(motion.displacement, 1.0 + 13.0 * times, rtol=1e-15)
    assert not motion.acceleration.any()


def equation_29(car: VehicleMotion, mass: float, tie: Tie, speed: float, time: float, nodes: int = 40) -> float:
    """The paper's eq 29, as printed but for `cos(omega_d t)`, its integrals by Gauss-Legendre on each piece."""
    rate = np.sqrt(tie.stiffness / mass)
    ratio = tie.damping / (2.0 * mass * rate)
    damped = rate * np.sqrt(1.0 - ratio**2)
    points, weights = np.polynomial.legendre.leggauss(nodes)
    with_cosine = with_sine = 0.0
    for a, b in pairwise(np.minimum(car.breaks, time)):
        if a >= b:
            continue
        tau = (a + b) / 2.0 + (b - a) / 2.0 * points
        force = closed_form.adult_forcing(car, tie, tau) * np.exp(ratio * rate * tau) * weights * (b - a) / 2.0
        with_cosine += force @ np.cos(damped * tau)
        with_sine += force @ np.sin(damped * tau)
    fade = np.exp(-ratio * rate * time)
    # eq. 29
    return float(
        fade * speed / damped * np.sin(damped * time)
        + fade * np.sin(damped * time) / (mass * damped) * with_cosine
        - fade * np.cos(damped * time) / (mass * damped) * with_sine
    )


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.5, 0.9])
def test_equation_29_reduces_to_duhamel(ratio: float) -> None:
    car, tie = braking(), Tie(STIFFNESS, ratio * CRITICAL, slack=0.005)
    times = np.linspace(0.001, 0.12, 25)
    motion = closed_form.adult(car, MASS, tie, engaged_at=0.0, start=State(0.0, 13.33), times=times)
    printed = [equation_29(car, MASS, tie, 13.33, t) for t in times]
    np.testing.assert_allclose(motion.displacement, printed, rtol=1e-12)


def test_pieces_may_be_split_anywhere() -> None:
    car = braking(pieces=1, degree=8)
    half = 0.06
    taylor = [np.polyval(np.polyder(car.coefficients[0, ::-1], n), half) / factorial(n) for n in range(9)]
    split = VehicleMotion(np.array([0.0, half, 0.12]), np.array([car.coefficients[0], taylor]))
    tie, times = Tie(STIFFNESS, 0.5 * CRITICAL, 0.005), np.linspace(0.0, 0.12, 40)
    start = State(0.0, 13.33)
    whole, halves = (closed_form.adult(m, MASS, tie, engaged_at=0.0, start=start, times=times) for m in (car, split))
    np.testing.assert_allclose(halves.acceleration, whole.acceleration, rtol=0.0, atol=1e-12 * np.ptp(whole.acceleration))


def test_forcing_functions() -> None:
    car = VehicleMotion(np.array([0.0, 1.0, 2.0]), np.array([[0.0, 2.0], [2.0, 1.0]]))
    seat, harness = Tie(10.0, 3.0, 0.5, 0.25), Tie(7.0, 2.0, 0.1, 0.4)
    expected = [3 * 2.25 + 10 * 1.5, 3 * 1.25 + 10 * 3.0]
    np.testing.assert_allclose(closed_form.adult_forcing(car, seat, [0.5, 1.5]), expected)
    assert closed_form.harness_forcing(harness) == pytest.approx(2 * 0.4 + 7 * 0.1)
    np.testing.assert_allclose(
        closed_form.seat_forcing(car, seat, harness, 0.5), closed_form.adult_forcing(car, seat, 0.5) - 1.5
    )


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"times": [0.0]}, "times: got"),
        ({"times": [0.2]}, "times: got"),
        ({"engaged_at": 0.5}, "engaged_at: got"),
        ({"mass": 0.0}, "mass: got 0.0 kg"),
    ],
)
def test_what_cannot_be_answered_is_refused(change: dict[str, Any], words: str) -> None:
    arguments: dict[str, Any] = {"mass": MASS, "engaged_at": 0.01, "times": [0.05]} | change
    with pytest.raises(InvalidInput, match=words):
        closed_form.adult(braking(), tie=Tie(1.0, 1.0, 0.0), start=State(0.0, 1.0), **arguments)


def test_shapes_and_order_of_pieces_are_checked() -> None:
    with pytest.raises(InvalidInput, match="shapes"):
        VehicleMotion(np.array([0.0, 1.0]), np.zeros((2, 3)))
    with pytest.raises(InvalidInput, match="order"):
        VehicleMotion(np.array([0.0, 1.0, 0.5]), np.zeros((2, 3)))
