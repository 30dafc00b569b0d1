"""Sleds against other solvers and closed forms: an occupant on a prescribed pulse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ridedown import criteria, load, simulate, simulate_many
from ridedown.scenario import SledScenario
from ridedown.scenario.lowering import pulse_of
from ridedown.scenario.pulse_motion import PulseMotion

SLEDS = ["sled-fmvss-208", "sled-half-sine", "sled-trapezoid"]


def scipys(sled: SledScenario) -> tuple[float, float]:
    """Peak acceleration [m/s2] and excursion [m] of the paper's adult, by an adaptive Runge-Kutta with events."""
    occupant = sled.occupants[0]
    k, m, slack = occupant.restraint.stiffness, occupant.mass, occupant.restraint.slack
    c = occupant.restraint.coefficient(m)
    motion = PulseMotion.of(pulse_of(sled), end=sled.duration, speed=float(sled.initial_speed))

    def vehicle(t):
        return float(motion.at(t)[0])

    def taut(t, y):
        return y[0] - slack

    taut.terminal, taut.direction = True, 1.0  # type: ignore[attr-defined]
    options: dict[str, Any] = {"rtol": 1e-10, "atol": 1e-12, "max_step": 1e-3, "method": "DOP853"}
    free = solve_ivp(lambda t, y: [y[1], -vehicle(t)], (0.0, sled.duration), [0.0, 0.0], events=taut, **options)
    latched = free.y[1, -1]

    def force(d, v):
        return k * (d - slack) + c * np.maximum(0.0, v - latched)

    def held(t, y):
        return [y[1], -vehicle(t) - force(*y) / m]

    def slack_again(t, y):
        return y[0] - slack

    slack_again.terminal, slack_again.direction = True, -1.0  # type: ignore[attr-defined]
    run = solve_ivp(held, (free.t[-1], sled.duration), free.y[:, -1], events=slack_again, dense_output=True, **options)
    assert run.sol is not None
    fine = run.sol(np.linspace(run.t[0], run.t[-1], 40001))
    return float(force(*fine).max() / m), float(fine[0].max())


@pytest.mark.parametrize("name", SLEDS)
def test_another_solver_gives_the_same_peaks(name):
    sled = load(name)
    assert isinstance(sled, SledScenario)
    response = simulate(sled)
    peak, excursion = scipys(sled)
    assert abs(response.peak("adult.acceleration").value) == pytest.approx(peak, rel=1e-6)
    assert response.maximum("adult.excursion").value == pytest.approx(excursion, rel=1e-6)


@pytest.mark.parametrize("name", [*SLEDS, "sled-r129-frontal"])
def test_energy_and_momentum_add_up(name):
    response = simulate(load(name))
    assert abs(response.energy.residual) < 1e-10  # the solver's own tolerance
    assert abs(response.momentum.residual) < 1e-10


def test_the_vehicle_index_is_a_sled_with_a_unit_mass():
    """ISO/TR 12353-3: 1 kg on a spring of 2500 N/m with 30 mm slack."""
    unit = {"name": "unit", "kind": "adult", "mass": 1, "restraint": {"stiffness": 2500, "slack": 0.03, "law": "kelvin-voigt"}}
    points = [[0.0, 0.0], [0.02, -180.0], [0.05, -260.0], [0.06, -310.0], [0.1, 0.0]]
    response = simulate(load({"pulse": {"kind": "points", "points": points}, "occupants": [unit]}))
    time, value = np.array(points).T
    index = criteria.vpi(np.append(time, 0.2), np.append(value, 0.0))
    assert -response.minimum("unit.acceleration").value == pytest.approx(index.value, rel=1e-9)


def test_constant_deceleration_with_slack():
    """A square pulse A: contact at sqrt(2 A s), then d'' = A - w2 (d - s): s + A/w2 (1 + sqrt(1 + 2 s w2/A))."""
    rate, slack, stiffness, mass = 150.0, 0.03, 60e3, 75.0
    adult = {"kind": "adult", "mass": mass, "restraint": {"stiffness": stiffness, "slack": slack, "law": "kelvin-voigt"}}
    sled = load({"pulse": {"kind": "square", "peak": rate, "duration": 0.15}, "occupants": [adult]})
    w2 = stiffness / mass
    assert simulate(sled).maximum("adult.excursion").value == pytest.approx(
        slack + rate / w2 * (1 + np.sqrt(1 + 2 * slack * w2 / rate)), rel=1e-10
    )


def test_many_are_as_each_alone():
    sled = load("sled-half-sine")
    changes, lengths = np.array([10.0, 13.0, 16.0]), np.array([0.08, 0.1, 0.13])
    names = ["adult.acceleration.peak", "adult.excursion.max", "vehicle1.displacement.max"]
    many = simulate_many(sled, {"pulse.delta_v": changes, "pulse.duration": lengths}, outcomes=names)
    for row, (change, length) in enumerate(zip(changes, lengths, strict=True)):
        pulse = {"kind": "half-sine", "delta_v": float(change), "duration": float(length)}
        alone = simulate(load({"pulse": pulse, "occupants": [o.model_dump(exclude_none=True) for o in sled.occupants]}))
        assert many[names[0]][row] == pytest.approx(abs(alone.peak("adult.acceleration").value), rel=1e-10)
        assert many[names[1]][row] == pytest.approx(alone.maximum("adult.excursion").value, rel=1e-10)
        assert many[names[2]][row] == pytest.approx(change * length / 2, rel=1e-9)  # half a half-sine's way, by symmetry
