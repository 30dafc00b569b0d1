"""Few straight lines for many samples: what they keep, on synthetic signals and on a measured crash."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ridedown.scenario import load
from ridedown.scenario.pulse_reduction import reduced
from ridedown.signals import filtered, mean, read

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "nhtsa_v10146"


def motion(time, value):
    """Velocity and displacement at the samples of a signal that is straight between them, from rest."""
    h = np.diff(time)
    v = np.concatenate(([0.0], np.cumsum(h * (value[1:] + value[:-1]) / 2)))
    return v, np.concatenate(([0.0], np.cumsum(h * v[:-1] + h * h * (2 * value[:-1] + value[1:]) / 6)))


def errors(time, value):
    """Knots, and by how much velocity and displacement are off at every sample."""
    knots, values = reduced(time, value)
    found, true = motion(time, np.interp(time, knots, values)), motion(time, value)
    return knots, values, found[0] - true[0], found[1] - true[1]


def bumps(seed: int, *, noise: float = 0.0, count: int = 1501):
    rng = np.random.default_rng(seed)
    time = np.linspace(0.0, 0.15, count)
    value = np.zeros(count)
    for _ in range(6):
        centre, width, height = rng.uniform(0.01, 0.12), rng.uniform(0.003, 0.03), rng.uniform(-300, 60)
        value += height * np.exp(-(((time - centre) / width) ** 2))
    return time, value + noise * rng.normal(size=count)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("noise", [0.0, 40.0])
def test_the_motion_is_kept(seed, noise):
    time, value = bumps(seed, noise=noise)
    knots, values, v, x = errors(time, value)
    change = np.abs(motion(time, value)[0]).max()
    assert np.isin(knots, time).all()
    assert abs(v[-1]) <= 1e-12 * change
    assert abs(x[-1]) <= 1e-12
    assert np.abs(v).max() <= 1e-3 * change
    assert np.abs(x).max() <= 1e-4
    assert np.abs(values).max() == pytest.approx(np.abs(value).max(), rel=5e-3)
    assert knots.size < (60 if noise == 0.0 else 600)


def test_straight_lines_are_found_again():
    time = np.linspace(0.0, 0.1, 1001)
    value = np.interp(time, [0.0, 0.013, 0.05, 0.1], [-20.0, -250.0, -180.0, 0.0])
    knots, values = reduced(time, value)
    np.testing.assert_allclose(knots, [0.0, 0.013, 0.05, 0.1], atol=2.5e-4)
    np.testing.assert_allclose(values, [-20.0, -250.0, -180.0, 0.0], atol=3.0)


def test_jumps_stay_jumps():
    time = np.concatenate((np.linspace(0.0, 0.05, 101), np.linspace(0.05, 0.1, 101)))
    value = np.concatenate((np.full(101, -100.0), np.linspace(-300.0, 0.0, 101)))
    knots, values = reduced(time, value)
    np.testing.assert_allclose(knots, [0.0, 0.05, 0.05, 0.1], atol=1e-15)
    np.testing.assert_allclose(values, [-100.0, -100.0, -300.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_a_few_samples_are_kept(count):
    time, value = bumps(3, count=count)
    knots, _, v, x = errors(time, value)
    assert knots.size <= count
    assert abs(v[-1]) < 1e-12
    assert np.abs(x).max() <= 1e-4


def test_noise_is_reduced_too_within_its_bounds():
    time, value = bumps(1, noise=2000.0)
    _, _, v, x = errors(time, value)
    assert np.abs(v).max() <= 1e-3 * np.abs(motion(time, value)[0]).max()
    assert np.abs(x).max() <= 1e-4


# a measured crash


@pytest.fixture(scope="module")
def camry():
    """The filtered pulse of test 10146 from time zero on, its speed, and what it is reduced to."""
    if not DATA.is_dir():
        pytest.skip("the measured crash, shared/data/nhtsa_v10146, is not at hand")
    record = read(DATA)
    time, value = mean(*(filtered(record.history(key), 60) for key in (94, 99))).si
    scenario = load({"pulse": {"kind": "measured", "file": str(DATA), "channels": [94, 99]}})
    found = scenario.pulse.recorded()
    return time[time >= 0], value[time >= 0], scenario, found


def test_10146_has_few_knots_and_keeps_its_motion(camry):
    time, value, scenario, found = camry
    assert scenario.initial_speed * 3.6 == pytest.approx(57.09, rel=1e-12)
    assert scenario.duration == pytest.approx(0.2999)
    assert found.time.size <= 36
    (v, x), (true_v, true_x) = motion(time, np.interp(time, found.time, found.value)), motion(time, value)
    change = np.abs(true_v).max()
    assert change * 3.6 == pytest.approx(67.1, abs=0.2)
    assert abs(v[-1] - true_v[-1]) <= 1e-6 * change
    assert np.abs(v - true_v).max() <= 1e-3 * change
    assert np.abs(x - true_x).max() <= 1e-4
    crush = (scenario.initial_speed * time + x).max()
    assert crush == pytest.approx(0.737, abs=1e-3)
    assert crush == pytest.approx((scenario.initial_speed * time + true_x).max(), abs=1e-4)


@pytest.mark.parametrize(
    ("stiffness", "ratio", "slack"),
    [(98.1e3, 0.5, 0.005), (40e3, 0.1, 0.03), (60e3, 0.2, 0.02), (150e3, 0.0, 0.01), (300e3, 0.3, 0.0)],
)
def test_10146_an_occupants_peaks_hardly_move(camry, stiffness, ratio, slack):
    """An oscillator of 80 kg by another solver, on all samples and on the knots."""
    time, value, _, found = camry
    whole = _peaks(time, value, stiffness, ratio, slack)
    few = _peaks(found.time, found.value, stiffness, ratio, slack)
    np.testing.assert_allclose(few, whole, rtol=1e-3)


def _peaks(time, value, stiffness, ratio, slack, mass=80.0):
    damping = 2 * ratio * np.sqrt(stiffness * mass)

    def force(d, v):
        return np.where(d > slack, np.maximum(0.0, stiffness * (d - slack) + damping * v), 0.0)

    def rates(t, y):
        return [y[1], -float(force(*y)) / mass - np.interp(t, time, value)]

    run = solve_ivp(rates, (0.0, 0.15), [0.0, 0.0], max_step=5e-4, rtol=1e-8, atol=1e-11)
    return force(*run.y).max() / mass, run.y[0].max()
