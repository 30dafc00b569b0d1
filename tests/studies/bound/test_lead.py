"""The lead of a free occupant, and what a seat behind it does."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown.scenario.pulse_motion import PulseMotion
from ridedown.scenario.pulse_shapes import half_sine, through
from ridedown.studies.bound.lead import Lead, Unrestrained


def motion(times, accelerations):
    return PulseMotion(*through(times, accelerations), end=times[-1], speed=10.0)


def test_lead_is_the_way_that_the_vehicle_stays_behind_its_first_speed():
    start, series = half_sine()
    pulse = PulseMotion(0.1 * start, -200.0 * series / 0.1 ** np.arange(series.shape[1]), end=0.1, speed=12.0)
    lead, times = Lead.of(pulse), np.linspace(0.0, 0.1, 1001)
    acceleration, velocity, displacement = pulse.at(times)
    np.testing.assert_allclose(lead.at(times), 12.0 * times - displacement, atol=1e-15)
    np.testing.assert_allclose(lead.rate(times), 12.0 - velocity, atol=1e-14)
    np.testing.assert_allclose(lead.braking(times[:-1]), -acceleration[:-1], atol=1e-11)
    assert lead.taken == pytest.approx(200.0 * 0.1 * 2.0 / np.pi, rel=1e-14)
    assert lead.at(0.3) == pytest.approx(lead.at(0.1) + 0.2 * lead.taken, rel=1e-14)


def test_cells_end_where_the_vehicle_stops_braking_and_begins_again():
    lead = Lead.of(motion([0.0, 0.02, 0.06, 0.1], [-100.0, 100.0, -300.0, 0.0]))
    np.testing.assert_allclose(lead.cells, [0.0, 0.01, 0.02, 0.03, 0.06, 0.1], rtol=1e-12)


def test_an_unrestrained_occupant_flies_free_in_a_braking_vehicle():
    lead = Lead.of(motion([0.0, 0.1], [-100.0, -200.0]))
    free = Unrestrained.of(lead, 0.0)
    assert not free.seated.any()
    assert not free.values(np.linspace(0.0, 1.0, 11)).any()


def test_a_seat_takes_the_occupant_along_while_the_vehicle_speeds_up():
    lead = Lead.of(motion([0.0, 0.02, 0.02, 0.1], [50.0, 50.0, -200.0, -200.0]))  # 1 m/s faster, then braked
    free, times = Unrestrained.of(lead, 0.0), np.linspace(0.0, 0.2, 201)
    expected = np.where(times <= 0.02, -25.0 * times**2, -0.01 - 1.0 * (times - 0.02))
    np.testing.assert_allclose(free.values(times), expected, atol=1e-15)
    assert not Unrestrained.of(lead, np.inf).values(times).any()


@pytest.mark.parametrize("room", [0.0, 0.003])
@pytest.mark.parametrize("seed", range(20))
def test_the_seat_is_never_gone_through_and_lands_without_bounce(seed, room):
    rng = np.random.default_rng(seed)
    lead = Lead.of(motion(np.sort(np.append(rng.uniform(0.0, 0.1, 7), [0.0, 0.1])), rng.uniform(-200.0, 150.0, 9)))
    free, times = Unrestrained.of(lead, room), np.linspace(0.0, 0.3, 30_001)
    gap = lead.at(times) + room - free.values(times)
    assert gap.min() >= -1e-15
    # small steps of the same: fly, and stop on the seat
    way, rate, worst, h = 0.0, 0.0, 0.0, times[1]
    for time, ceiling in zip(times[1:], lead.at(times[1:]) + room, strict=True):
        way += h * rate
        if way > ceiling:
            rate, way = min(rate, float(lead.rate(time))), float(ceiling)
        worst = max(worst, abs(way - free.at(float(time))))
    assert worst < 2e-4  # m, of steps of 10 us


def test_when_an_excursion_is_first_reached():
    lead = Lead.of(motion([0.0, 0.1], [-100.0, -100.0]))
    free = Unrestrained.of(lead, 0.0)
    assert lead.first_reach(0.05, free) == pytest.approx(np.sqrt(0.001), rel=1e-14)
    assert lead.first_reach(1.5, free) == pytest.approx(0.2, rel=1e-14)  # 10 m/s after 0.5 m in 100 ms
    there_and_back = Lead.of(motion([0.0, 0.05, 0.05, 0.15], [-100.0, -100.0, 100.0, 100.0]))
    own = Unrestrained.of(there_and_back, np.inf)
    assert there_and_back.first_reach(0.2499, own) is not None  # it turns round at 0.25 m
    assert there_and_back.first_reach(0.2501, own) is None
