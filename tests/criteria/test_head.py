"""HIC, severity index and clips of pulses whose answer can be written down."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ridedown import criteria
from ridedown.errors import InvalidInput
from tests.samples import examples

Floats = NDArray[np.float64]
G0 = 9.80665
A = 60.0  # g, the peak of every pulse here

SQUARE = ([0.0, 0.010, 0.010, 0.030], [A, A, 0.0, 0.0])


def pulse(signal: tuple[list[float], list[float]]) -> tuple[Floats, Floats]:
    """Times [s] and acceleration [m/s2] from g."""
    return np.array(signal[0]), np.array(signal[1]) * G0


def sampled(shape: str, duration: float, *, rate: float, peak: float = A, lead: float = 0.005) -> tuple[Floats, Floats]:
    time = np.arange(round((duration + 4.0 * lead) * rate) + 1) / rate
    k = np.clip((time - lead) / duration, 0.0, 1.0)
    return time, peak * G0 * {"half-sine": np.sin(np.pi * k), "haversine": np.sin(np.pi * k) ** 2}[shape]


def test_hic_of_a_square_shorter_than_the_window_is_that_of_the_square() -> None:
    found = criteria.hic(*pulse(SQUARE))
    assert found.value == pytest.approx(A**2.5 * 0.010, rel=1e-13)
    assert (found.start, found.end) == pytest.approx((0.0, 0.010), abs=1e-12)


def test_hic_of_a_square_longer_than_the_window_is_that_of_the_window() -> None:
    found = criteria.hic([0.0, 0.020], [A * G0, A * G0])
    assert found.value == pytest.approx(A**2.5 * 0.015, rel=1e-13)
    assert found.duration == pytest.approx(0.015, rel=1e-12)


@pytest.mark.parametrize("duration", [0.008, 0.060])
def test_hic_of_a_triangle(duration: float) -> None:
    # mean over a centred share s of the base is A (1 - s/2): s (1 - s/2)^2.5 is largest at s = 4/7
    share = min(4.0 / 7.0, 0.015 / duration)
    found = criteria.hic([0.0, 0.5 * duration, duration], [0.0, A * G0, 0.0])
    assert found.value == pytest.approx(A**2.5 * duration * share * (1.0 - 0.5 * share) ** 2.5, rel=1e-13)
    assert found.start == pytest.approx(0.5 * duration * (1.0 - share), rel=1e-6)


@pytest.mark.parametrize("duration", [0.008, 0.040])
def test_hic_of_a_half_sine(duration: float) -> None:
    # a(t2) = 0.6 of the mean: x cos x = 0.6 sin x with x = pi/2 of the window's share of the duration
    x = 1.0
    for _ in range(60):
        x -= (x * math.cos(x) - 0.6 * math.sin(x)) / (0.4 * math.cos(x) - x * math.sin(x))
    x = min(x, 0.5 * math.pi * 0.015 / duration)
    expected = A**2.5 * (2.0 * x / math.pi) * duration * (math.sin(x) / x) ** 2.5
    found = criteria.hic(*sampled("half-sine", duration, rate=1e6))
    assert found.value == pytest.approx(expected, rel=1e-6)
    assert found.duration == pytest.approx(2.0 * x / math.pi * duration, rel=1e-4)


def test_hic_of_a_haversine() -> None:
    # the mean of sin^2 over a centred window of half width x [rad] is (1 + sin 2x / 2x)/2
    x = np.linspace(0.3, 1.4, 200_001)
    expected = A**2.5 * 0.008 * float((2.0 * x / math.pi * (0.5 + np.sin(2.0 * x) / (4.0 * x)) ** 2.5).max())
    assert criteria.hic(*sampled("haversine", 0.008, rate=1e6)).value == pytest.approx(expected, rel=1e-6)


def test_hic_spans_two_pulses_where_that_is_worse_than_either() -> None:
    both = ([0.0, 0.004, 0.004, 0.008, 0.008, 0.012, 0.012, 0.030], [A, A, 0.0, 0.0, A, A, 0.0, 0.0])
    found = criteria.hic(*pulse(both))
    assert found.value == pytest.approx(A**2.5 * 0.012 * (2.0 / 3.0) ** 2.5, rel=1e-13)
    assert found.duration == pytest.approx(0.012, rel=1e-12)


def test_hic_of_two_pulses_further_apart_than_the_window_is_that_of_the_worse() -> None:
    apart = ([0.0, 0.004, 0.004, 0.012, 0.012, 0.017, 0.017, 0.030], [A, A, 0.0, 0.0, A, A, 0.0, 0.0])
    found = criteria.hic(*pulse(apart))
    assert found.value == pytest.approx(A**2.5 * 0.005, rel=1e-13)
    assert (found.start, found.end) == pytest.approx((0.012, 0.017))


def test_a_negative_spike_counts_with_its_sign_only_where_asked() -> None:
    spike = ([0.0, 0.0045, 0.0045, 0.0055, 0.0055, 0.010, 0.010, 0.030], [A, A, -A, -A, A, A, 0.0, 0.0])
    assert criteria.hic(*pulse(spike), signed=True).value == pytest.approx(A**2.5 * 0.010 * 0.8**2.5, rel=1e-13)
    assert criteria.hic(*pulse(spike)).value == pytest.approx(A**2.5 * 0.010, rel=1e-13)


def test_braking_along_one_axis_counts_by_its_magnitude() -> None:
    time, a = pulse(SQUARE)
    assert criteria.hic(time, -a) == criteria.hic(time, a)
    assert criteria.hic(time, -a, signed=True).value == 0.0


def test_hic_of_a_pulse_that_ends_the_record() -> None:
    # a ramp to A at the end T: (1 - s) (1 + s)^2.5 / 2^2.5 is largest where the window begins at s = 3/7
    found = criteria.hic([0.0, 0.020], [0.0, A * G0])
    assert found.value == pytest.approx(A**2.5 * 0.020 * 4.0 / 7.0 * (5.0 / 7.0) ** 2.5, rel=1e-13)
    assert (found.start, found.end) == pytest.approx((0.020 * 3.0 / 7.0, 0.020), rel=1e-6)


def test_hic_of_nothing_is_nothing() -> None:
    assert criteria.hic([0.0, 0.1], [0.0, 0.0]) == criteria.HIC(0.0, 0.0, 0.0)


def test_hic_over_pairs_of_samples_skips_what_lies_between() -> None:
    time, a = [0.0, 0.004, 0.008], [0.0, A * G0, 0.0]
    assert criteria.hic(time, a, sampled=True).value == pytest.approx(A**2.5 * 0.008 * 0.5**2.5, rel=1e-13)
    assert criteria.hic(time, a).value > 1.3 * criteria.hic(time, a, sampled=True).value


def test_a_window_of_whole_samples_is_not_lost_to_rounding() -> None:
    time = 0.1 + np.arange(400) / 10_000.0  # 150 samples apart, times differ from 0.015 by 1e-17 either way
    a = np.full(400, A * G0)
    assert criteria.hic(time, a, sampled=True).value == pytest.approx(A**2.5 * 0.015, rel=1e-12)


@pytest.mark.parametrize("size", [1e-30, 1e-3, 1e6])
def test_hic_goes_with_the_size_to_the_power_of_two_and_a_half(size: float) -> None:
    time, a = sampled("half-sine", 0.02, rate=1e4)
    assert criteria.hic(time, size * a).value == pytest.approx(size**2.5 * criteria.hic(time, a).value, rel=1e-12)


def test_severity_index_in_closed_form() -> None:
    assert criteria.severity_index(*pulse(SQUARE)) == pytest.approx(A**2.5 * 0.010, rel=1e-14)
    assert criteria.severity_index([0.0, 0.03, 0.06], [0.0, A * G0, 0.0]) == pytest.approx(A**2.5 * 0.06 / 3.5, rel=1e-14)
    assert criteria.severity_index([0.0, 0.06], [A * G0, -A * G0]) == pytest.approx(A**2.5 * 0.06 / 3.5, rel=1e-14)
    mean = math.gamma(1.75) / (math.sqrt(math.pi) * math.gamma(2.25))  # of sin^2.5 over half a turn
    assert criteria.severity_index(*sampled("half-sine", 0.02, rate=1e6)) == pytest.approx(A**2.5 * 0.02 * mean, rel=1e-6)


@pytest.mark.parametrize("share", [0.0, 1e-9, 0.01, 0.0499, 0.0501, 0.2, 1.0])
def test_severity_index_of_a_slope_however_slight(share: float) -> None:
    one, other = 50.0 * (1.0 - share), 50.0 * (1.0 + share)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    expected = 0.5 * float(np.sum(weights * (50.0 + 50.0 * share * nodes) ** 2.5))
    assert criteria.severity_index([0.0, 1.0], [one * G0, other * G0]) == pytest.approx(
        expected, rel=2e-9 if share == 1.0 else 1e-14
    )


CLIPS = {
    "square": (SQUARE, A, A),
    "triangle": (([0.0, 0.03, 0.06], [0.0, A, 0.0]), A * 0.95, A * 0.95),
    "lopsided triangle": (([0.0, 0.01, 0.06], [0.0, A, 0.0]), A * 0.95, A * 0.95),
    "two triangles": (([0.0, 0.03, 0.06, 0.09, 0.12], [0.0, A, 0.0, A, 0.0]), A * 0.95, A * 0.975),
    "a ramp that ends the record": (([0.0, 0.06], [0.0, A]), A * 0.95, A * 0.95),
    "two short squares": (([0.0, 0.002, 0.002, 0.01, 0.01, 0.012], [A, A, 0.0, 0.0, A, A]), 0.0, A),
    "a short square on a step": (([0.0, 0.001, 0.001, 0.01, 0.01, 0.02], [A, A, 20.0, 20.0, 0.0, 0.0]), 20.0, 20.0),
    "a notch": (([0.0, 0.010, 0.011, 0.012, 0.022], [A, A, 30.0, A, A]), A, A),
    "a notch within 3 ms": (([0.0, 0.001, 0.002, 0.003, 0.004, 0.005], [0.0, A, 30.0, A, 0.0, 0.0]), 30.0, 30.0),
    "a negative spike": (([0.0, 0.01, 0.02, 0.03, 0.04, 0.06], [0.0, 0.0, -A, 0.0, 20.0, 0.0]), A * 0.85, A * 0.85),
    "through zero": (([0.0, 0.02], [A, -A]), A * 0.7, A * 0.85),
}


@pytest.mark.parametrize("name", CLIPS)
def test_clip_in_closed_form(name: str) -> None:
    signal, continuous, cumulative = CLIPS[name]
    assert criteria.clip(*pulse(signal)).value_g == pytest.approx(continuous, rel=1e-13, abs=1e-13)
    assert criteria.clip(*pulse(signal), cumulative=True).value_g == pytest.approx(cumulative, rel=1e-13)


def test_clip_says_when() -> None:
    time, a = pulse(([0.0, 0.01, 0.06], [0.0, A, 0.0]))
    held = criteria.clip(time, a)
    assert (held.start, held.end) == pytest.approx((0.0095, 0.0125))
    apart = criteria.clip(*pulse(([0.0, 0.03, 0.06, 0.09, 0.12], [0.0, A, 0.0, A, 0.0])), cumulative=True)
    assert (apart.start, apart.end) == pytest.approx((0.02925, 0.09075))


@pytest.mark.parametrize("duration", [0.001, 0.010, 0.060])
def test_clip_of_another_duration(duration: float) -> None:
    found = criteria.clip([0.0, 0.03, 0.06], [0.0, A * G0, 0.0], duration=duration)
    assert found.value_g == pytest.approx(A * (1.0 - duration / 0.06), rel=1e-13, abs=1e-12)


def test_clip_of_half_sine_and_haversine() -> None:
    for cumulative in (False, True):
        half_sine = criteria.clip(*sampled("half-sine", 0.03, rate=1e5), cumulative=cumulative)
        assert half_sine.value_g == pytest.approx(A * math.cos(math.pi * 0.05), rel=1e-7)
        haversine = criteria.clip(*sampled("haversine", 0.03, rate=1e5), cumulative=cumulative)
        assert haversine.value_g == pytest.approx(A * math.cos(math.pi * 0.05) ** 2, rel=1e-7)


def test_a_record_shorter_than_the_clip_is_refused() -> None:
    with pytest.raises(InvalidInput, match=r"time: got a signal of 0.002 s; need >= 0.003 s"):
        criteria.clip([0.0, 0.002], [1.0, 1.0])
    assert criteria.clip([0.0, 0.003], [5.0, 4.0]).value == 4.0  # just as long: the whole


@pytest.mark.parametrize("window", [0.0, -1.0, math.nan, math.inf, "15 ms"])
def test_windows_are_above_nothing(window: float) -> None:
    with pytest.raises(InvalidInput, match="max_window"):
        criteria.hic([0.0, 1.0], [1.0, 1.0], max_window=window)
    with pytest.raises(InvalidInput, match="duration"):
        criteria.clip([0.0, 1.0], [1.0, 1.0], duration=window)


def test_an_absurd_acceleration_is_no_infinite_hic() -> None:
    with pytest.raises(InvalidInput, match="Check its unit"):
        criteria.hic([0.0, 0.01], [1e200, 1e200])


@examples(100)
@given(st.lists(st.floats(-80.0, 80.0), min_size=2, max_size=60), st.integers(1, 70))
def test_hic_by_sum_is_the_best_of_all_sums(levels: list[float], longest: int) -> None:
    a = np.array(levels)
    n = a.size
    best = max(
        k * 1e-3 * float(np.abs(a[i : i + k]).mean()) ** 2.5
        for k in range(1, min(longest, n - 1) + 1)
        for i in range(n - k)
    )  # fmt: skip
    found = criteria.hic_by_sum(np.arange(n) * 1e-3, a * G0, max_window=longest * 1e-3)
    assert found.value == pytest.approx(best, rel=1e-9, abs=1e-12)


def test_hic_by_sum_takes_the_last_sample_for_nothing() -> None:
    # it lasts to a sample that the record does not have
    assert criteria.hic_by_sum([0.0, 0.01, 0.02], [0.0, 0.0, A * G0]).value == 0.0
