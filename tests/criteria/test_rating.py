"""The rating of ISO/TS 18571: its parts where they are known in closed form, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from ridedown.criteria.rating import GRADES, rating
from ridedown.errors import InvalidInput

TIME = np.linspace(0.0, 0.1, 1001)
PULSE = 400.0 * np.sin(np.pi * TIME / 0.1) ** 2


def test_a_curve_agrees_with_itself_in_all_parts() -> None:
    found = rating((TIME, PULSE), (TIME, PULSE))
    assert (found.value, found.corridor, found.phase, found.magnitude, found.slope) == (1.0,) * 5
    assert found.grade == "excellent"
    assert (found.start, found.end) == pytest.approx((0.0, 0.1))


def test_the_corridor_of_a_constant_distance_is_known() -> None:
    found = rating((TIME, PULSE), (TIME, PULSE + 40.0))  # 10 % of the peak; corridors at 5 and 50 %
    assert found.corridor == pytest.approx(((0.5 - 0.1) / (0.5 - 0.05)) ** 2, rel=1e-6)
    assert (found.phase, found.slope) == pytest.approx((1.0, 1.0), abs=1e-9)
    assert found.magnitude < 1.0


def test_within_the_inner_corridor_nothing_is_lost() -> None:
    assert rating((TIME, PULSE), (TIME, PULSE + 19.0)).corridor == 1.0


def test_the_phase_is_the_share_of_the_allowed_shift_that_is_left() -> None:
    narrow = 400.0 * np.exp(-(((TIME - 0.05) / 0.008) ** 2))
    late = 400.0 * np.exp(-(((TIME - 0.055) / 0.008) ** 2))
    found = rating((TIME, narrow), (TIME, late))
    assert found.phase == pytest.approx(1.0 - 50.0 / (0.2 * 1001), rel=1e-6)  # 50 of 200.2 samples
    assert found.magnitude > 0.99
    assert found.slope > 0.99
    assert found.shift == pytest.approx(0.005)
    assert found.value == pytest.approx(0.4 * found.corridor + 0.2 * (found.phase + found.magnitude + found.slope), rel=1e-12)


def test_the_opposite_curve_is_poor() -> None:
    found = rating((TIME, PULSE), (TIME, -PULSE))
    assert found.grade == "poor"
    assert found.value < GRADES[2][0]


def test_curves_of_other_sampling_are_read_off_at_10_khz() -> None:
    knots = np.array([0.0, 0.02, 0.05, 0.1])
    shape = np.array([0.0, 300.0, 100.0, 0.0])
    fine = np.linspace(-0.01, 0.12, 5000)
    found = rating((knots, shape), (fine, np.interp(fine, knots, shape)))
    assert found.value > 0.999
    assert (found.start, found.end) == pytest.approx((0.0, 0.1))


def test_anything_with_si_is_a_curve() -> None:
    class Curve:
        si = TIME, PULSE

    assert rating(Curve(), (TIME, PULSE)).value == 1.0


def test_an_interval_can_be_chosen_within_both() -> None:
    found = rating((TIME, PULSE), (TIME, PULSE), start=0.02, end=0.08)
    assert (found.start, found.end) == pytest.approx((0.02, 0.08))
    with pytest.raises(InvalidInput, match=r"reference: got a curve from 0 to 0.1 s; need one that covers -0.01"):
        rating((TIME, PULSE), (TIME, PULSE), start=-0.01)


@pytest.mark.parametrize("dead", ["reference", "candidate"])
def test_a_curve_that_never_moves_has_no_rating(dead: str) -> None:
    flat = (TIME, np.full(TIME.size, 3.0))
    pair = (flat, (TIME, PULSE)) if dead == "reference" else ((TIME, PULSE), flat)
    with pytest.raises(InvalidInput, match=f"{dead}: got a curve that is 3"):
        rating(*pair)


def test_a_shared_interval_that_is_too_short_or_too_long_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"end: got an interval of 0.005 s"):
        rating((TIME, PULSE), (TIME, PULSE), start=0.0, end=0.005)
    with pytest.raises(InvalidInput, match=r"need 0\.01 \.\. 2 s"):
        rating(([0.0, 9.0], [0.0, 1.0]), ([0.0, 9.0], [0.0, 1.0]))


def test_a_late_pulse_after_a_flat_start_gives_no_warning() -> None:
    late = np.where(TIME > 0.085, 400.0 * np.sin(np.pi * (TIME - 0.085) / 0.015), 0.0)
    found = rating((TIME, late), (TIME, 0.9 * late))
    assert 0.8 < found.value < 1.0
