"""Criteria as outcomes: those of the sampled channels are those of the exact response."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown import criteria, load, simulate
from ridedown.criteria import roadside
from ridedown.errors import InvalidInput
from ridedown.limits.simulated import ResponseEvidence
from ridedown.scenario import substitute
from ridedown.studies.rows.outcomes import CRITERIA, compute, wanted_of

OFFSETS = np.array([0.0, 0.4, 0.886])
STIFFNESSES = np.array([40e3, 98.1e3, 98.1e3])
STEP = 1e-4

EXACT = {
    "clip_3ms": lambda time, a: criteria.clip(time, a).value,
    "clip_3ms_cumulative": lambda time, a: criteria.clip(time, a, cumulative=True).value,
    "hic15": lambda time, a: criteria.hic(time, a).value,
    "hic36": lambda time, a: criteria.hic(time, a, max_window=0.036).value,
    "severity_index": criteria.severity_index,
    "olc": lambda time, a: criteria.olc(time, a).value,
    "vpi": lambda time, a: criteria.vpi(time, a).value,
    "asi": lambda time, a: criteria.asi(time, a).value,
    "asi_1998": lambda time, a: criteria.asi(time, a, edition="EN 1317-1:1998").value,
    "thiv": lambda time, a: criteria.thiv(time, a).value,
    "phd": lambda time, a: criteria.phd(time, a).value,
    "occupant_impact_velocity": lambda time, a: criteria.occupant_impact_velocity(time, a).value,
    "ridedown_acceleration": lambda time, a: roadside.occupant_ridedown_acceleration(time, a, 0.0 * a).forward.value,
}


def table():
    return {"bar.lateral_offset": OFFSETS, "adult.restraint.stiffness": STIFFNESSES}


@pytest.fixture(scope="module")
def responses():
    crash = load("p1")
    pairs = zip(OFFSETS, STIFFNESSES, strict=True)
    rows = ({"bar.lateral_offset": offset, "adult.restraint.stiffness": stiffness} for offset, stiffness in pairs)
    return [simulate(substitute(crash, row)) for row in rows]


@pytest.mark.parametrize("key", CRITERIA)
def test_a_sampled_criterion_is_that_of_the_exact_response(responses, key):
    body = "vehicle1" if CRITERIA[key].of_vehicle else "adult"
    name = f"{body}.{key}"
    found, status = compute(load("p1"), table(), wanted_of(load("p1"), [name]), step=STEP)
    assert (status == 0).all()
    for row, response in enumerate(responses):
        if CRITERIA[key].of_vehicle:
            pulse = ResponseEvidence(response).pulse("vehicle1")
            exact = EXACT[key](pulse.time, pulse.acceleration)
        else:
            exact = EXACT[key](*response.history(f"{body}.acceleration", 1e-8).si)
        assert found[name][row] == pytest.approx(exact, rel=2e-4)  # of sampling at 0.1 ms, as the docs say


def test_finer_samples_come_nearer(responses):
    exact = criteria.clip(*responses[1].history("adult.acceleration", 1e-8).si).value
    want = wanted_of(load("p1"), ["adult.clip_3ms"])
    errors = [
        abs(compute(load("p1"), table(), want, step=step)[0]["adult.clip_3ms"][1] / exact - 1.0) for step in (2e-3, 1e-4, 1e-5)
    ]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-6


def test_change_of_velocity_and_crush_are_exact(responses):
    names = ["vehicle1.delta_v", "vehicle2.delta_v", "vehicle1.dynamic_crush"]
    found, _ = compute(load("p1"), table(), wanted_of(load("p1"), names), step=STEP)
    for row, response in enumerate(responses):
        vehicle = response.vehicles["vehicle1"]
        assert found["vehicle1.delta_v"][row] == pytest.approx(abs(vehicle.delta_v), rel=1e-10)
        assert found["vehicle1.dynamic_crush"][row] == pytest.approx(vehicle.dynamic_crush.value, rel=1e-10)
        assert found["vehicle2.delta_v"][row] == pytest.approx(abs(response.vehicles["vehicle2"].delta_v), rel=1e-10)


def test_what_is_the_same_in_every_row_is_found_once():
    """The vehicles', where only restraints vary; beside the same rows with vehicles that differ by a trillionth."""
    names = ["vehicle1.olc", "vehicle2.asi", "adult.hic15", "adult.acceleration.peak", "vehicle1.dynamic_crush"]
    alike = {"adult.restraint.stiffness": np.linspace(40e3, 120e3, 40)}
    each = alike | {"vehicle1.mass": 1500.0 * (1.0 + 1e-12 * np.arange(40) / 40)}
    want = wanted_of(load("p1"), names)
    (once, _), (apart, _) = (compute(load("p1"), rows, want, step=STEP) for rows in (alike, each))
    for name in names:
        np.testing.assert_allclose(once[name], apart[name], rtol=1e-9)
        assert (np.ptp(once[name]) == 0.0) == name.startswith("vehicle")


def test_no_value_where_the_pulse_never_stops_the_criterions_occupant():
    soft = {"vehicle1.speed": np.array([0.5])}
    found, _ = compute(load("example-wall"), soft, wanted_of(load("example-wall"), ["vehicle1.olc"]), step=STEP)
    assert np.isnan(found["vehicle1.olc"]).all()


def test_durations_that_differ_are_refused_with_criteria():
    want = wanted_of(load("p1"), ["adult.hic15"])
    with pytest.raises(InvalidInput, match="duration"):
        compute(load("p1"), {"duration": np.array([0.1, 0.2])}, want, step=STEP)
