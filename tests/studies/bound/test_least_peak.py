"""The hull under the bound, and the search for what it misses."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown.scenario.pulse_motion import PulseMotion
from ridedown.scenario.pulse_shapes import through
from ridedown.studies.bound.lead import Lead, Unrestrained
from ridedown.studies.bound.least_peak import How, Room, _needed, _upper_hull, least_peak


@pytest.mark.parametrize("seed", range(10))
def test_the_hull_is_the_least_concave_function_above_the_points(seed):
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.0, 1.0, 40))
    y = rng.choice([rng.normal(size=40), x * (1.0 - x), np.round(rng.normal(size=40))])
    hull = _upper_hull(x, y)
    above = np.interp(x, x[hull], y[hull])
    chords = [np.max([y[i] + (y[j] - y[i]) * (p - x[i]) / (x[j] - x[i]) for i in range(k + 1) for j in range(k, 40) if i < j])
              for k, p in enumerate(x)]  # fmt: skip
    np.testing.assert_allclose(above, chords, atol=1e-12)


def test_three_places_of_a_parabola_need_its_second_derivative():
    s = np.array([0.01, 0.04, 0.13])
    assert _needed(s, 3.0 + 2.0 * s + 0.5 * 140.0 * s**2) == pytest.approx(140.0, rel=1e-12)


@pytest.mark.parametrize("width", [1e-3, 1e-5, 1e-7])
def test_a_spike_between_the_points_of_the_search_is_not_missed(width):
    # a blow of 2 m/s, as short as may be, on an occupant with little room: held after it for as long as it takes
    time, braking = [0.0, 0.0371, 0.0371, 0.0371 + width, 0.0371 + width, 0.1], [0.0, 0.0, 2.0 / width, 2.0 / width, 0.0, 0.0]
    lead = Lead.of(PulseMotion(*through(time, -np.array(braking)), end=0.1, speed=2.0))
    free = Unrestrained.of(lead, 0.0)
    assert free.last_contact(0.05) == 0.0371
    found = least_peak(Room(lead, free, 0.02, 0.0, 0.0371, np.inf))
    assert found.level == pytest.approx(2.0**2 / (2.0 * (0.02 + width)), rel=1e-9)  # v^2 / (2 (D + way)), way v width / 2
    assert [stage.how for stage in found.stages] == [How.FREE, How.HELD, How.CARRIED]
    assert found.stages[1].start == pytest.approx(0.0371, abs=1e-12)


def test_two_blows_are_held_one_after_the_other():
    time, braking = [0.0, 0.02, 0.02, 0.1, 0.1, 0.12], [200.0, 200.0, 0.0, 0.0, 200.0, 200.0]
    lead = Lead.of(PulseMotion(*through(time, -np.array(braking)), end=0.12, speed=8.0))
    found = least_peak(Room(lead, Unrestrained.of(lead, 0.0), 0.05, 0.0, 0.0, np.inf))
    assert [stage.how for stage in found.stages].count(How.HELD) == 2
