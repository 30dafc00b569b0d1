"""Channel classes have the gain that the formulas give, shift nothing in time, and leave a constant as it is."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter

from ridedown.errors import InvalidInput, UnknownName
from ridedown.signals import Filter, TimeHistory, filtered
from ridedown.signals.filters import CLASSES, CORNERS, coefficients, mirrored

VECTORS = Path(__file__).resolve().parents[3] / "shared" / "vectors" / "criteria.json"
STANDARDS = tuple(CORNERS)
RATE = 10_000.0


def sine(frequency: float, seconds: float = 2.0, rate: float = RATE) -> TimeHistory:
    count = round(seconds * rate)
    return TimeHistory(np.sin(2.0 * np.pi * frequency * np.arange(count) / rate), "g", interval=1.0 / rate)


def gain_and_delay(history: TimeHistory, frequency: float) -> tuple[float, float]:
    """Amplitude and delay [s] of a sine in the middle half of a signal, which is a whole number of its periods."""
    quarter = len(history) // 4
    part = slice(quarter, 3 * quarter)
    turn = np.exp(-2j * np.pi * frequency * history.time[part])
    wave = 2j * np.mean(history.values[part] * turn)
    return float(np.abs(wave)), float(-np.angle(wave) / (2.0 * np.pi * frequency))


def exact_gain(cfc: float, frequency: float, standard: str, rate: float = RATE) -> float:
    """Of the bilinear transform of a Butterworth pair of poles, passed twice: from its squared gain, without coefficients."""
    corner = math.tan(math.pi * cfc * CORNERS[standard] / rate)
    return 1.0 / (1.0 + (math.tan(math.pi * frequency / rate) / corner) ** 4)


@pytest.mark.skipif(not VECTORS.exists(), reason="the shared check vectors are not beside this repository")
def test_the_gains_of_a_sine_are_those_of_the_check_vectors():
    wanted = json.loads(VECTORS.read_text(encoding="utf-8"))["cfc_gain_of_a_sine"]
    assert len(wanted) == 16
    for case, gains in wanted.items():
        cfc, frequency = map(float, re.fullmatch(r"CFC(\d+)@(\d+)Hz", case).groups())
        for name, gain in gains.items():
            standard = "SAE J211" if name.startswith("J211") else "ISO 6487"
            measured, delay = gain_and_delay(filtered(sine(frequency), cfc, standard=standard), frequency)
            assert measured == pytest.approx(float(gain), abs=1e-9), case  # of the sine's amplitude of 1; the bar is 1e-4
            assert abs(delay) < 1e-9  # s


@pytest.mark.parametrize("standard", STANDARDS)
@pytest.mark.parametrize("cfc", [*CLASSES, 13, 100, 333.3])
@pytest.mark.parametrize("frequency", [10.0, 50.0, 165.0, 500.0, 1650.0])
def test_the_gain_is_that_of_four_poles_at_any_class(cfc, frequency, standard):
    measured, delay = gain_and_delay(filtered(sine(frequency), cfc, standard=standard), frequency)
    assert measured == pytest.approx(exact_gain(cfc, frequency, standard), abs=1e-9)
    if measured > 1e-3:
        assert abs(delay) < 1e-9


@pytest.mark.parametrize("standard", STANDARDS)
@pytest.mark.parametrize("cfc", CLASSES)
def test_it_is_six_decibels_down_at_the_corner_of_one_pass_and_three_at_five_thirds_of_the_class(cfc, standard):
    assert exact_gain(cfc, cfc * CORNERS[standard], standard, rate=1e6) == pytest.approx(0.5, rel=1e-9)
    assert 20.0 * math.log10(exact_gain(cfc, cfc * 5.0 / 3.0, standard, rate=1e6)) == pytest.approx(-3.0, abs=0.04)


@given(st.floats(-1e6, 1e6), st.integers(1, 300), st.sampled_from(CLASSES), st.sampled_from(STANDARDS))
def test_a_constant_stays_that_constant(level, count, cfc, standard):
    history = TimeHistory(np.full(count, level), "g", interval=1e-4)
    assert filtered(history, cfc, standard=standard).values == pytest.approx(np.full(count, level), rel=1e-15, abs=0)


@pytest.mark.parametrize("standard", STANDARDS)
def test_a_symmetric_pulse_stays_symmetric_and_keeps_its_area(standard):
    values = np.zeros(2001)
    values[900:1101] = np.sin(np.linspace(0.0, np.pi, 201))
    smooth = filtered(TimeHistory(values, "g", interval=1e-4), 60, standard=standard).values
    assert smooth == pytest.approx(smooth[::-1], abs=1e-12)
    assert smooth.argmax() == 1000
    assert smooth.sum() == pytest.approx(values.sum(), rel=1e-9)


@pytest.mark.parametrize("standard", STANDARDS)
def test_time_reversed_is_filtered_alike_away_from_the_ends(standard):
    values = np.random.default_rng(1).normal(size=4000)
    one = filtered(TimeHistory(values, "g", interval=1e-4), 180, standard=standard).values
    other = filtered(TimeHistory(values[::-1], "g", interval=1e-4), 180, standard=standard).values[::-1]
    assert one[500:-500] == pytest.approx(other[500:-500], abs=1e-12)


def test_a_slope_goes_on_through_the_ends_where_iso_mirrors_them():
    ramp = TimeHistory(np.linspace(0.0, 35.0, 3501), "g", interval=1e-4)
    assert filtered(ramp, 180, standard="ISO 6487").values == pytest.approx(ramp.values, abs=2e-3)
    # J211 starts level, from the mean of ten samples: it errs at the ends, by as much as the slope runs in the start-up time
    assert np.abs(filtered(ramp, 180).values - ramp.values).max() > 5e-3


def test_the_start_is_the_mean_of_the_first_ten_samples():
    values = np.zeros(2000)
    values[0] = 10.0  # a first sample that is off would start a filter that takes it for the level at 10
    assert np.abs(filtered(TimeHistory(values, "g", interval=1e-4), 60).values[:5]).max() < 1.5


def by_difference_equation(values: list[float], cfc: float, interval: float, standard: str, beyond: int) -> list[float]:
    """As the standards write it, sample by sample, with the signal carried on by `beyond` mirrored samples at each end."""
    n = len(values)
    long = [2.0 * values[0] - values[i] for i in range(beyond, 0, -1)] + values
    long += [2.0 * values[-1] - values[n - 1 - i] for i in range(1, beyond + 1)]
    a0, a1, a2, b1, b2 = coefficients(cfc, interval, standard=standard)
    for _ in range(2):
        x1 = x2 = y1 = y2 = sum(long[:10]) / len(long[:10])
        out = []
        for x in long:
            y = a0 * x + a1 * x1 + a2 * x2 + b1 * y1 + b2 * y2
            x1, x2, y1, y2 = x, x1, y, y1
            out.append(y)
        long = out[::-1]
    return long[beyond : beyond + n]


@pytest.mark.parametrize(
    ("standard", "rate", "count", "beyond"),
    [
        ("SAE J211", 10_000.0, 700, 0),
        ("ISO 6487", 10_000.0, 700, 100),  # 0.01 s are 100 samples
        ("ISO 6487", 20_000.0, 700, 200),  # 0.01 s are more
        ("ISO 6487", 12_345.6, 700, 124),  # 123.456 samples, rounded up
        ("ISO 6487", 2_000.0, 700, 100),  # 100 samples are more
        ("ISO 6487", 10_000.0, 31, 30),  # as far as a short signal goes
    ],
)
def test_it_is_the_difference_equation_of_the_standard_with_its_start_and_its_mirroring(standard, rate, count, beyond):
    values = np.random.default_rng(7).normal(size=count).cumsum().tolist()
    expected = by_difference_equation(values, 180, 1.0 / rate, standard, beyond)
    smooth = filtered(TimeHistory(values, "g", interval=1.0 / rate), 180, standard=standard)
    assert smooth.values == pytest.approx(np.array(expected), abs=1e-11)  # of values of some 10


def test_mirrored_points_are_turned_about_the_ends():
    values = np.array([1.0, 4.0, 9.0, 16.0])
    assert mirrored(values, 3).tolist() == [-14.0, -7.0, -2.0, 1.0, 4.0, 9.0, 16.0, 23.0, 28.0, 31.0]
    assert mirrored(values, 0).tolist() == values.tolist()


@pytest.mark.parametrize("standard", STANDARDS)
@pytest.mark.parametrize("count", [1, 2, 3, 9, 50])
def test_short_signals_are_filtered_too(count, standard):
    smooth = filtered(TimeHistory(np.arange(float(count)), "g", interval=1e-4), 1000, standard=standard)
    assert len(smooth) == count
    assert np.isfinite(smooth.values).all()


@pytest.mark.parametrize("standard", STANDARDS)
@pytest.mark.parametrize("cfc", [*CLASSES, 333.3])
def test_coefficients_are_those_of_a_butterworth_filter_with_that_corner(cfc, standard):
    numerator, denominator = butter(2, cfc * CORNERS[standard], fs=RATE)
    a0, a1, a2, b1, b2 = coefficients(cfc, 1.0 / RATE, standard=standard)
    assert (a0, a1, a2) == pytest.approx(tuple(numerator), rel=1e-12)
    assert (1.0, -b1, -b2) == pytest.approx(tuple(denominator), rel=1e-12)


def test_the_state_says_what_a_signal_went_through():
    history = TimeHistory(np.zeros(100), "g", interval=1e-4, code="11HEAD0000H3ACX0", name="head x")
    once = filtered(history, 1000)
    assert once.filtered == Filter(1000, "SAE J211")
    assert once.code == "11HEAD0000H3ACXA"
    twice = filtered(once, 180, standard="ISO 6487")
    assert str(twice.filtered) == "CFC 180 (ISO 6487) after CFC 1000 (SAE J211)"
    assert twice.code == "11HEAD0000H3ACXC"
    assert filtered(history, 100).code == "11HEAD0000H3ACXS"  # a class without a letter of its own
    assert (twice.name, twice.unit, history.filtered) == ("head x", "g", None)


@pytest.mark.parametrize(
    ("cfc", "interval", "message"),
    [
        (1000, 1.1e-4, "got class 1000 for a signal sampled at 9090.91 Hz; need 10000 Hz at least"),
        (0, 1e-4, "cfc: got 0 Hz; need > 0 Hz"),
        (-60, 1e-4, "cfc: got -60 Hz; need > 0 Hz"),
        (math.nan, 1e-4, "cfc: got nan Hz; need > 0 Hz"),
    ],
)
def test_a_class_that_the_rate_or_the_standard_does_not_allow_is_refused(cfc, interval, message):
    with pytest.raises(InvalidInput, match=message):
        filtered(TimeHistory(np.zeros(20), "g", interval=interval), cfc)


def test_ten_times_the_class_is_enough_though_the_interval_is_rounded():
    assert filtered(TimeHistory(np.zeros(20), "g", interval=1.00000005e-4), 1000).filtered == Filter(1000, "SAE J211")


def test_uneven_times_and_unknown_standards_are_refused_with_what_to_do():
    with pytest.raises(InvalidInput, match=r"a filter needs an even interval\. Use ridedown.signals.resampled first"):
        filtered(TimeHistory([0.0, 1.0], "g", stamps=[0.0, 0.1]), 60)
    with pytest.raises(UnknownName, match="Did you mean 'SAE J211'"):
        filtered(TimeHistory([0.0, 1.0], "g", interval=1e-4), 60, standard="SAE J212")
