"""ASI, THIV, PHD and the flail-space criteria: closed forms, brute force, and what a record may lack."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from ridedown.criteria.checks import STANDARD_GRAVITY
from ridedown.criteria.roadside import asi, occupant_impact_velocity, occupant_ridedown_acceleration, phd, thiv
from ridedown.errors import InvalidInput, UnknownName

G = STANDARD_GRAVITY
NEW, OLD = "EN 1317-1:2010", "EN 1317-1:1998"


def half_sine(peak: float, duration: float, rate: float = 10_000.0, length: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    time = np.arange(round(length * rate) + 1) / rate
    return time, np.where(time <= duration, peak * np.sin(np.pi * time / duration), 0.0)


# ASI


@pytest.mark.parametrize("edition", [NEW, OLD])
def test_a_constant_acceleration_has_the_asi_of_its_share_of_the_limits(edition: str) -> None:
    time = np.linspace(0.0, 0.2, 201)
    found = asi(time, np.full(201, -6.0 * G), np.full(201, 3.0 * G), np.full(201, 2.0 * G), edition=edition)
    assert found.value == pytest.approx(math.hypot(0.5, 1.0 / 3.0, 0.2), rel=1e-9)


def test_asi_of_1998_of_a_square_pulse_shorter_than_the_window_is_its_share_of_50_ms() -> None:
    found = asi([0.0, 0.1, 0.1, 0.13, 0.13, 0.3], [0.0, 0.0, -20 * G, -20 * G, 0.0, 0.0], edition=OLD)
    assert found.value == pytest.approx(20.0 / 12.0 * 0.030 / 0.050, rel=1e-9)


def test_asi_of_1998_of_a_half_sine_is_the_mean_about_its_peak() -> None:
    duration, window = 0.1, 0.05
    mean = 15.0 * duration / (math.pi * window) * 2.0 * math.sin(math.pi * window / (2.0 * duration))
    found = asi(*half_sine(-15.0 * G, duration), edition=OLD)
    assert found.value == pytest.approx(mean / 12.0, rel=1e-5)
    assert found.time == pytest.approx(0.05, abs=1e-4)


def test_asi_of_2010_of_a_square_pulse_is_the_area_of_the_impulse_response() -> None:
    # x through the filter at the middle of a square of width w: the integral of its impulse response over +- w/2
    w = 2.0 * math.pi * 13.0 * (math.sqrt(2.0) - 1.0) ** -0.25 / math.sqrt(2.0)
    width = 0.030
    area = 1.0 - math.exp(-w * width / 2.0) * math.cos(w * width / 2.0)
    found = asi([0.0, 0.1, 0.1, 0.13, 0.13, 0.3], [0.0, 0.0, -20 * G, -20 * G, 0.0, 0.0])
    assert found.value == pytest.approx(20.0 / 12.0 * area, rel=1e-5)
    assert found.time == pytest.approx(0.115, abs=2e-4)


@pytest.mark.parametrize("edition", [NEW, OLD])
def test_asi_does_not_depend_on_the_sampling_rate(edition: str) -> None:
    values = [asi(*half_sine(-15.0 * G, 0.09, rate), edition=edition).value for rate in (1_000.0, 3_333.0, 10_000.0, 20_000.0)]
    assert values == pytest.approx([values[-1]] * 4, rel=1e-3)


def test_asi_adds_axes_at_the_same_time_only() -> None:
    time = [0.0, 0.1, 0.1, 0.2, 0.2, 0.3]
    found = asi(time, [-12 * G, -12 * G, 0, 0, 0, 0], [0, 0, 0, 0, 9 * G, 9 * G], edition=OLD)
    assert found.value == pytest.approx(1.0, rel=1e-9)


def test_a_pulse_that_ends_the_record_has_its_asi() -> None:
    assert asi([0.0, 0.1, 0.1, 0.15], [0.0, 0.0, -12 * G, -12 * G], edition=OLD).value == pytest.approx(1.0, rel=1e-9)


def test_a_record_shorter_than_50_ms_has_no_asi_of_1998() -> None:
    with pytest.raises(InvalidInput, match=r"need >= 0\.05 s"):
        asi([0.0, 0.04], [1.0, 1.0], edition=OLD)
    assert asi([0.0, 0.04], [12 * G, 12 * G]).value == pytest.approx(1.0, rel=1e-9)


def test_another_edition_is_told_the_nearest() -> None:
    with pytest.raises(UnknownName, match="EN 1317-1:2010"):
        asi([0.0, 1.0], [0.0, 0.0], edition="EN 1317-1:2011")


# the free flight


@given(st.floats(20.0, 400.0))
def test_under_constant_deceleration_the_head_arrives_as_a_stone_falls(a: float) -> None:
    found = thiv([0.0, 0.5], [-a, -a])
    assert found.time == pytest.approx(math.sqrt(1.2 / a), rel=1e-12)
    assert found.value == pytest.approx(math.sqrt(1.2 * a), rel=1e-12)


def test_half_sine_contact_is_where_the_free_path_meets_the_interior() -> None:
    peak, duration = 150.0, 0.15
    k = math.pi / duration

    def path(t: float) -> float:
        return peak / k * t - peak / k**2 * math.sin(k * t)

    contact = brentq(lambda t: path(t) - 0.6, 0.01, duration)
    found = thiv(*half_sine(-peak, duration))
    assert found.time == pytest.approx(contact, abs=1e-6)
    assert found.value == pytest.approx(peak / k * (1.0 - math.cos(k * contact)), rel=1e-5)


def test_whichever_surface_is_nearer_in_time_is_hit() -> None:
    ahead = occupant_impact_velocity([0.0, 0.5], [-100.0, -100.0], [40.0, 40.0])
    assert ahead.time == pytest.approx(math.sqrt(0.012))
    assert (ahead.forward, ahead.lateral) == pytest.approx((100 * math.sqrt(0.012), -40 * math.sqrt(0.012)))
    aside = occupant_impact_velocity([0.0, 0.5], [-10.0, -10.0], [60.0, 60.0])
    assert aside.time == pytest.approx(0.1)
    assert (aside.value, aside.lateral) == pytest.approx((6.0, -6.0))


def test_the_side_that_y_counts_from_does_not_matter() -> None:
    one = thiv([0.0, 0.5], [-30.0, -30.0], [60.0, 20.0], [0.5, 2.0])
    other = thiv([0.0, 0.5], [-30.0, -30.0], [-60.0, -20.0], [-0.5, -2.0])
    assert one.value == pytest.approx(other.value, rel=1e-12)
    assert one.lateral == pytest.approx(-other.lateral, rel=1e-12)


def test_a_double_pulse_is_flown_through_and_the_second_is_the_ridedown() -> None:
    time = [0.0, 0.05, 0.05, 0.2, 0.2, 0.23, 0.23, 0.3]
    forward = [-100.0, -100.0, 0.0, 0.0, -80.0, -80.0, 0.0, 0.0]
    found = occupant_impact_velocity(time, forward)
    assert (found.time, found.value) == pytest.approx((0.145, 5.0), rel=1e-12)
    ride = occupant_ridedown_acceleration(time, forward)
    assert ride.value == pytest.approx(80.0, rel=1e-9)
    assert ride.forward.start == pytest.approx(0.2, abs=1e-9)


def test_a_spike_shorter_than_10_ms_counts_by_its_share() -> None:
    time = [0.0, 0.2, 0.2, 0.202, 0.202, 0.3]
    after = phd(time, [-100.0, -100.0, -600.0, -600.0, 0.0, 0.0])
    assert after.value == pytest.approx((8.0 * 100.0 + 2.0 * 600.0) / 10.0, rel=1e-9)
    assert after.end == pytest.approx(0.202, abs=1e-9)


def test_phd_is_the_resultant_and_the_ridedown_the_larger_axis() -> None:
    channels = [0.0, 0.3], [-100.0, -100.0], [30.0, 30.0]
    assert phd(*channels).value == pytest.approx(math.hypot(100.0, 30.0), rel=1e-9)
    assert occupant_ridedown_acceleration(*channels).value == pytest.approx(100.0, rel=1e-9)


def test_no_contact_says_so_with_none() -> None:
    weak = [0.0, 0.3], [-1.0, -1.0]
    assert thiv(*weak).value is None
    assert occupant_impact_velocity(*weak).time is None
    assert phd(*weak).value is None
    assert occupant_ridedown_acceleration(*weak).value is None


def test_less_than_10_ms_after_contact_is_no_ridedown() -> None:
    record = [0.0, math.sqrt(0.012) + 0.0099], [-100.0, -100.0]
    assert thiv(*record).value is not None
    assert phd(*record).value is None


def test_the_flight_begins_at_time_zero_of_a_record_with_a_lead() -> None:
    lead = thiv([-0.05, 0.0, 0.0, 0.3], [5.0, 5.0, -100.0, -100.0])
    assert lead.time == pytest.approx(math.sqrt(0.012), rel=1e-12)
    later = thiv([1.0, 1.3], [-100.0, -100.0])
    assert later.time == pytest.approx(1.0 + math.sqrt(0.012), rel=1e-12)


def test_a_head_ahead_of_a_turning_car_is_swept_aside() -> None:
    # The car spins about its sensor; the head, 1.2 m ahead of it, stays: it meets the side at 1.2 sin(w t) = 0.3.
    rate = 3.0
    found = thiv([0.0, 0.5], [0.0, 0.0], None, [rate, rate], head=(1.2, 0.0))
    assert found.time == pytest.approx(math.asin(0.25) / rate, rel=1e-9)
    assert found.value == pytest.approx(1.2 * rate, rel=1e-9)


def test_a_contact_out_and_back_between_two_steps_is_not_missed() -> None:
    # a falls from A to -A over T and on: the free path turns back at T, at A T^2/6, beyond 0.6 m for some microseconds only,
    # and T lies in the middle of a step of a millisecond
    turn = 0.1005
    a = 6.0 * (0.6 + 1e-8) / turn**2
    found = occupant_impact_velocity([0.0, 2.0 * turn], [-a, 3.0 * a])
    assert found.time == pytest.approx(turn, abs=2e-5)
    assert found.time < turn
    assert occupant_impact_velocity([0.0, 2.0 * turn], [-a * 0.999, 3.0 * a * 0.999]).time is None


@settings(max_examples=40, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-300, 100), st.floats(-150, 150), st.floats(-6, 6)), min_size=4, max_size=8),
    st.floats(-0.5, 1.0),
)
def test_the_solved_contact_is_the_one_a_fine_march_finds(
    knots: list[tuple[float, float, float]], ahead_of_sensor: float
) -> None:
    time = np.linspace(0.0, 0.25, len(knots))
    ax, ay, yaw = (np.array(column) for column in zip(*knots, strict=True))
    found = thiv(time, ax, ay, yaw, head=(ahead_of_sensor, 0.0))
    fine = np.linspace(0.0, 0.25, 100_001)
    step = fine[1]
    a, b, w = (np.interp(fine, time, column) for column in (ax, ay, yaw))

    def summed(values: np.ndarray) -> np.ndarray:
        return np.concatenate(([0.0], np.cumsum(0.5 * step * (values[1:] + values[:-1]))))

    psi = summed(w)
    vx, vy = summed(a * np.cos(psi) - b * np.sin(psi)), summed(a * np.sin(psi) + b * np.cos(psi))
    dx, dy = ahead_of_sensor - summed(vx), -summed(vy)
    x, y = np.cos(psi) * dx + np.sin(psi) * dy - ahead_of_sensor, -np.sin(psi) * dx + np.cos(psi) * dy
    beyond = (x >= 0.6) | (np.abs(y) >= 0.3)
    if not beyond.any():
        assert found.time is None or found.time > 0.25 - 1e-4 or max(x.max() / 0.6, np.abs(y).max() / 0.3) > 1.0 - 1e-6
        return
    first = int(beyond.argmax())
    assert found.time is not None
    assert (
        found.time == pytest.approx(fine[first], abs=2.0 * step) or max(x[first - 1] / 0.6, abs(y[first - 1]) / 0.3) > 1 - 1e-6
    )
    relative = math.hypot(
        -np.cos(psi[first]) * vx[first] - np.sin(psi[first]) * vy[first] + w[first] * y[first],
        np.sin(psi[first]) * vx[first] - np.cos(psi[first]) * vy[first] - w[first] * (x[first] + ahead_of_sensor),
    )
    assert found.value == pytest.approx(relative, rel=1e-3, abs=2e-3)


@pytest.mark.parametrize("field", ["ahead", "aside"])
def test_a_free_space_of_nothing_is_refused(field: str) -> None:
    with pytest.raises(InvalidInput, match=f"{field}: got 0 m"):
        thiv([0.0, 0.3], [-1.0, -1.0], **{field: 0.0})


def test_bad_channels_are_named() -> None:
    with pytest.raises(InvalidInput, match=r"^lateral: got nan"):
        thiv([0.0, 0.1], [0.0, 0.0], [0.0, math.nan])
    with pytest.raises(InvalidInput, match=r"^yaw_rate: got 3 values"):
        thiv([0.0, 0.1], [0.0, 0.0], None, [0.0, 0.0, 0.0])
