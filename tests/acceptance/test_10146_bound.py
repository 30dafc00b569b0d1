"""NHTSA test 10146: how far the driver's restraint was from the least that any restraint could give on that pulse.

The vehicle is the mean of channels 94 and 100 (right rear crossmember), the driver's chest channel 13, both CFC 60, both along
x of their own body: the dummy's pitch is left out. Excursion is the double integral of their difference from first contact,
the chest taken to start at rest in its place.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ridedown import criteria
from ridedown.criteria import STANDARD_GRAVITY
from ridedown.criteria.moving import integral
from ridedown.signals import filtered, mean, trimmed
from ridedown.signals.ev5 import read_ev5
from ridedown.studies.bound import Design, Limiting, gap

DATA = Path(__file__).parents[3] / "shared" / "data" / "nhtsa_v10146"

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="the measured crash, shared/data/nhtsa_v10146, is not at hand")


@pytest.fixture(scope="module")
def measured():
    record = read_ev5(DATA)
    vehicle = mean(*(filtered(record.history(number), 60) for number in (94, 100)))
    return vehicle, filtered(record.history(13), 60)


def test_how_far_the_drivers_restraint_was_from_the_limit(measured, capsys):
    vehicle, chest = (trimmed(history, 0.0, 0.15) for history in measured)
    time, braking = chest.time, -chest.converted("m/s2").values
    excursion = integral(time, integral(time, -braking - vehicle.converted("m/s2").values))
    farthest = int(np.argmax(excursion))
    assert excursion[:farthest].min() > -1e-4  # m: it goes forward, and not back first
    clip = criteria.clip(*chest.si).value

    limiting = Limiting(measured[0])
    found = gap(limiting, Design("driver's chest", float(braking.max()), float(excursion[farthest])))
    with capsys.disabled():
        print(
            f"\n10146, driver: chest x {found.design.peak / STANDARD_GRAVITY:.1f} g "
            f"(3 ms clip {clip / STANDARD_GRAVITY:.1f} g) "
            f"within {1e3 * found.design.excursion:.0f} mm; least possible {found.bound.peak_g:.1f} g, "
            f"{100.0 * found.ratio:.0f} % of it ({100.0 * found.bound.peak / clip:.0f} % of the clip)"
        )
    assert found.design.excursion == pytest.approx(0.2715, abs=5e-4)
    assert found.bound.peak_g == pytest.approx(15.98, abs=0.02)
    assert found.ratio == pytest.approx(0.408, abs=0.002)


def test_the_occupant_load_criterion_of_a_measured_pulse_is_a_bound(measured):
    vehicle = measured[0]
    found = criteria.olc(*vehicle.si)
    bound = Limiting(vehicle, rearward=np.inf, slack=0.065).bound(0.3)
    assert bound.peak == pytest.approx(found.value, rel=1e-12)
    assert bound.stages[0].end == pytest.approx(found.start, rel=1e-12)
    assert bound.stages[1].end == pytest.approx(found.end, rel=1e-6)
