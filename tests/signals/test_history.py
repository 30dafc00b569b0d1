"""A time history is immutable, knows exactly when each value was taken, and refuses what is no signal."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown.errors import InvalidInput
from ridedown.signals import Filter, TimeHistory


def test_values_and_stamps_cannot_be_written_and_are_not_the_callers_own():
    values, stamps = np.array([1.0, 2.0]), np.array([0.0, 0.1])
    history = TimeHistory(values, "g", stamps=stamps)
    values[0] = stamps[0] = 99.0
    assert history.values.tolist() == [1.0, 2.0]
    assert history.time.tolist() == [0.0, 0.1]
    with pytest.raises(ValueError, match="read-only"):
        history.values[0] = 5.0
    with pytest.raises(ValueError, match="read-only"):
        history.time[0] = 5.0
    with pytest.raises(FrozenInstanceError):
        history.unit = "N"  # type: ignore[misc]


@given(st.integers(-5000, 5000), st.sampled_from([1e-4, 5e-5, 8e-5, 1e-3, 1 / 30_000, 1e-6]))
def test_the_value_of_index_zero_is_at_zero_exactly(first, interval):
    history = TimeHistory(np.zeros(10_001), "g", start=first * interval, interval=interval)
    assert history.time[0] == history.start
    if -10_000 <= first <= 0:
        assert history.time[-first] == 0.0


def test_times_of_ten_kilohertz_are_the_doubles_nearest_to_the_decimals():
    history = TimeHistory(np.zeros(3500), "g", start=-0.05, interval=1e-4)
    assert history.time.tolist() == [float(f"{i / 10_000:.4f}") for i in range(-500, 3000)]
    assert (history.start, history.end, history.sampling_rate) == (-0.05, 0.2999, 10_000.0)
    assert history.duration == pytest.approx(0.3499, rel=1e-15)


def test_a_start_between_two_multiples_of_the_interval_is_kept():
    history = TimeHistory([0.0, 0.0], "g", start=0.00123, interval=0.001)
    assert history.time.tolist() == [0.00123, 0.00223]


def test_stamps_give_the_start_and_the_end():
    history = TimeHistory([1.0, 2.0, 3.0], "g", stamps=[0.1, 0.2, 0.2])
    assert (history.start, history.end, len(history)) == (0.1, 0.2, 3)


def test_si_is_what_criteria_take():
    time, values = TimeHistory([1.0, -2.0], "g", interval=0.5).si
    assert time.tolist() == [0.0, 0.5]
    assert values.tolist() == [9.80665, -19.6133]


def test_units_are_spelled_alike_and_unknown_ones_kept_but_not_converted():
    assert TimeHistory([1.0], "G'S", interval=1.0).unit == "g"
    odd = TimeHistory([1.0], "furlong", interval=1.0)
    assert odd.unit == "furlong"
    with pytest.raises(InvalidInput, match="got 'furlong'; need a unit that is known"):
        odd.si  # noqa: B018
    with pytest.raises(InvalidInput, match="to be converted to 'N'"):
        TimeHistory([1.0], "g", interval=1.0).converted("N")


def test_what_is_said_of_a_signal_goes_along_when_it_is_converted_and_renamed():
    state = Filter(180, "SAE J211")
    history = TimeHistory([1.0], "g", interval=1.0, name="a", code="11HEAD0000H3ACXC", filtered=state, remarks=("odd",))
    other = history.converted("m/s2").renamed("b")
    assert (other.name, other.code, other.filtered, other.remarks) == ("b", "11HEAD0000H3ACXC", state, ("odd",))
    assert history.renamed("c", code="11HEAD0000H3ACYC").code == "11HEAD0000H3ACYC"
    assert "CFC 180 (SAE J211)" in repr(other)


def test_identical_means_bit_for_bit():
    history = TimeHistory([1.0, 2.0], "g", interval=0.1)
    assert history.identical(TimeHistory([1.0, 2.0], "g", stamps=[0.0, 0.1]))
    assert not history.identical(TimeHistory([1.0, math.nextafter(2.0, 3.0)], "g", interval=0.1))
    assert not history.identical(TimeHistory([1.0, 2.0], "g", interval=math.nextafter(0.1, 1.0)))
    assert not history.identical(TimeHistory([1.0, 2.0], "m/s2", interval=0.1))
    assert not history.identical(TimeHistory([1.0, 2.0], "g", interval=0.1, filtered=Filter(60)))


def test_the_rate_of_uneven_times_is_refused_with_what_to_do():
    with pytest.raises(InvalidInput, match=r"got stamps; need an even interval. Use ridedown.signals.resampled"):
        TimeHistory([1.0, 2.0], "g", stamps=[0.0, 0.1]).sampling_rate  # noqa: B018


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"values": [], "interval": 0.1}, "values: got no value; need one at least"),
        ({"values": [1.0, math.nan], "interval": 0.1}, "values: got nan at value 1; need finite numbers"),
        ({"values": [math.inf], "interval": 0.1}, "values: got inf at value 0; need finite numbers"),
        ({"values": [[1.0]], "interval": 0.1}, r"values: got an array of shape \(1, 1\); need shape \(n,\)"),
        ({"values": ["a"], "interval": 0.1}, "values: got list; need numbers"),
        ({"values": [1.0]}, "got neither an interval nor stamps; need one of them"),
        ({"values": [1.0], "interval": 0.1, "stamps": [0.0]}, "got both an interval and stamps; need one of them"),
        ({"values": [1.0], "interval": 0.0}, "interval: got 0 s; need > 0 s"),
        ({"values": [1.0], "interval": -0.1}, "interval: got -0.1 s; need > 0 s"),
        ({"values": [1.0], "interval": math.nan}, "interval: got nan s; need > 0 s"),
        ({"values": [1.0], "interval": 0.1, "start": math.inf}, "start: got inf s; need a time near the recording"),
        ({"values": [1.0], "interval": 1e-300, "start": 1.0}, "interval: got 1e-300 s; need > 0 s, and no less than 1e-12 s"),
        ({"values": [1.0], "interval": 1e-9, "start": 1e8}, r"start: got 1e\+08 s; need a time near the recording"),
        ({"values": [1.0, 2.0], "stamps": [-1e308, 1e308]}, r"need times within 1e\+12 s of zero"),
        ({"values": [1.0, 2.0], "stamps": [0.0]}, "stamps: got 1 times; need 2, one for each value"),
        ({"values": [1.0, 2.0], "stamps": [0.1, 0.0]}, "got 0.1 s and then 0 s at value 1; need times that never fall"),
        ({"values": [1.0, 2.0], "stamps": [0.1, math.nan]}, "stamps: got nan at value 1; need finite numbers"),
    ],
)
def test_what_is_no_signal_is_refused_in_one_sentence(arguments, message):
    with pytest.raises(InvalidInput, match=message):
        TimeHistory(unit="g", **arguments)
