"""Processing treats a signal as the line through its values, exactly, and says honestly what it is afterwards."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from ridedown.errors import InvalidInput
from ridedown.signals import (
    Filter,
    TimeHistory,
    aligned,
    differentiated,
    filtered,
    integrated,
    mean,
    resampled,
    resultant,
    reversed_sign,
    trimmed,
    zeroed,
)

CFC60 = Filter(60, "SAE J211")


@st.composite
def uneven(draw: st.DrawFn, unit: str = "m/s2") -> TimeHistory:
    """A signal at stamps, jumps and repeated stamps among them."""
    steps = draw(st.lists(st.sampled_from([0.0, 0.25, 0.5, 1.0, 3.0]), min_size=1, max_size=12).filter(any))
    values = draw(st.lists(st.floats(-100.0, 100.0), min_size=len(steps) + 1, max_size=len(steps) + 1))
    return TimeHistory(values, unit, stamps=np.concatenate(([-1.0], -1.0 + np.cumsum(steps))))


def height(history: TimeHistory, time: float) -> float:
    """The line through the values at a time; at a jump the value after. One value at a time, in plain Python."""
    times, values = [float(t) for t in history.time], [float(v) for v in history.values]
    i = max(i for i, known in enumerate(times) if known <= time)
    if i == len(times) - 1:
        return values[i]
    return values[i] + (values[i + 1] - values[i]) * (time - times[i]) / (times[i + 1] - times[i])


# integrals and derivatives


@given(uneven())
def test_the_integral_is_the_area_under_the_lines(history):
    velocity = integrated(history, initial=2.0)
    assert velocity.unit == "m/s"
    assert velocity.values[0] == 2.0
    corners = sorted(set(history.time.tolist()))
    area = sum(quad(lambda t: height(history, t), a, b - 1e-12, epsabs=1e-11)[0] for a, b in pairwise(corners))
    assert velocity.values[-1] - 2.0 == pytest.approx(area, rel=1e-9, abs=1e-7)  # m/s, of up to 100 m/s2 over some seconds


@given(uneven(), st.floats(0.0, 1.0))
def test_the_integral_has_its_given_value_at_the_given_time(history, part):
    at = history.start + part * history.duration
    velocity = integrated(history, initial=5.0, at=at)
    before = trimmed(history, end=at) if at > history.start else None
    change = integrated(before).values[-1] if before is not None else 0.0
    assert velocity.values[0] + change == pytest.approx(5.0, abs=1e-9)


def test_integrals_are_in_si_whatever_the_unit():
    velocity = integrated(TimeHistory([-20.0, -20.0], "g", interval=0.1, code="10SECMRIRE00ACX0", filtered=CFC60), initial=15.0)
    assert velocity.values.tolist() == pytest.approx([15.0, 15.0 - 19.6133 * 1.0], rel=1e-15)
    assert (velocity.unit, velocity.code, velocity.filtered) == ("m/s", None, CFC60)
    assert integrated(velocity).unit == "m"
    assert integrated(TimeHistory([1.0, 1.0], "kN", interval=0.1)).unit == "N s"
    assert integrated(TimeHistory([1.0, 1.0], "deg/s", interval=0.1)).unit == "rad"


@given(st.lists(st.floats(-10.0, 10.0), min_size=3, max_size=3), st.lists(st.floats(0.1, 2.0), min_size=3, max_size=9))
def test_the_derivative_of_a_parabola_is_exact_on_any_times(coefficients, steps):
    time = np.cumsum(steps)
    history = TimeHistory(np.polyval(coefficients, time), "m", stamps=time)
    expected = np.polyval(np.polyder(np.array(coefficients)), time)
    slopes = differentiated(history)
    assert slopes.unit == "m/s"
    assert slopes.values == pytest.approx(expected, abs=1e-9 * (1.0 + np.abs(history.values).max() / min(steps)))


def test_the_derivative_of_the_integral_comes_back_with_second_order():
    def error(interval: float) -> float:
        time = np.arange(0.0, 0.1 + interval / 2, interval)
        pulse = TimeHistory(300.0 * np.sin(40.0 * time), "m/s2", interval=interval)
        return float(np.abs(differentiated(integrated(pulse)).values - pulse.values)[2:-2].max())

    assert error(1e-3) / error(5e-4) == pytest.approx(4.0, rel=0.05)


def test_two_values_have_the_slope_between_them():
    assert differentiated(TimeHistory([1.0, 2.0], "mm", interval=0.1)).values.tolist() == pytest.approx([0.01, 0.01])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: integrated(TimeHistory([1.0, 2.0], "Pa", interval=1.0)), "got 'Pa', a pressure; need a jerk, an acceleration"),
        (
            lambda: differentiated(TimeHistory([1.0, 2.0], "Pa", interval=1.0)),
            "got 'Pa', a pressure; need an acceleration, a speed",
        ),
        (lambda: integrated(TimeHistory([1.0, 2.0], "furlong", interval=1.0)), "got 'furlong'; need a unit that is known"),
        (lambda: integrated(TimeHistory([1.0], "g", interval=1.0)), "got one value; need two at least"),
        (lambda: differentiated(TimeHistory([1.0], "m", interval=1.0)), "got one value; need two at least"),
        (lambda: integrated(TimeHistory([1.0, 2.0], "g", interval=1.0), at=1.5), "at: got 1.5 s; need 0 .. 1 s"),
        (
            lambda: differentiated(TimeHistory([1.0, 2.0], "m", stamps=[0.5, 0.5])),
            "got a jump at 0.5 s; need one value at each time",
        ),
    ],
)
def test_integrals_and_derivatives_that_have_no_meaning_are_refused(call, message):
    with pytest.raises(InvalidInput, match=message):
        call()


# parts and grids


@given(uneven(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_two_parts_have_the_area_of_the_whole(history, one, other):
    a, b = sorted((history.start + one * history.duration, history.start + other * history.duration))
    if not history.start < a < b < history.end:
        return
    parts = [trimmed(history, end=a), trimmed(history, a, b), trimmed(history, b)]
    assert [part.start for part in parts] == [history.start, a, b]
    assert [part.end for part in parts] == [a, b, history.end]
    total = sum(integrated(part).values[-1] for part in parts)
    assert total == pytest.approx(integrated(history).values[-1], rel=1e-9, abs=1e-9)


def test_trimming_at_sample_times_keeps_the_grid_and_elsewhere_interpolates():
    history = TimeHistory(np.arange(11.0), "g", start=-0.5, interval=0.1, name="x", filtered=CFC60)
    part = trimmed(history, -0.2, 0.3)
    assert (part.interval, part.start, part.values.tolist()) == (0.1, -0.2, [3.0, 4.0, 5.0, 6.0, 7.0, 8.0])
    assert (part.name, part.filtered) == ("x", CFC60)
    cut = trimmed(history, -0.25, 0.31)
    assert cut.interval is None
    assert cut.time.tolist() == pytest.approx([-0.25, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.31])
    assert cut.values.tolist() == pytest.approx([2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 8.1])


def test_trimming_at_a_jump_starts_after_it_and_ends_before_it():
    step = TimeHistory([1.0, 1.0, 5.0, 5.0], "g", stamps=[0.0, 1.0, 1.0, 2.0])
    assert trimmed(step, 1.0).values.tolist() == [5.0, 5.0]
    assert trimmed(step, end=1.0).values.tolist() == [1.0, 1.0]
    assert trimmed(step, 0.5, 1.5).values.tolist() == [1.0, 1.0, 5.0, 5.0]


@given(uneven(), st.sampled_from([0.1, 0.3, 1.0]))
def test_resampling_reads_the_lines_and_puts_time_zero_on_the_grid(history, interval):
    even = resampled(history, interval) if history.duration > interval else None
    if even is None:
        return
    assert even.interval == interval
    expected = [height(history, min(max(time, history.start), history.end)) for time in even.time.tolist()]
    assert even.values.tolist() == pytest.approx(expected, abs=1e-9)
    assert np.abs(even.time / interval - np.round(even.time / interval)).max() < 1e-9
    assert even.start - interval < history.start <= even.start + 1e-6 * interval
    assert even.end <= history.end + 1e-6 * interval < even.end + interval * (1.0 + 1e-6)


def test_resampling_to_the_same_interval_changes_nothing():
    history = TimeHistory(np.random.default_rng(3).normal(size=3500), "g", start=-0.05, interval=1e-4)
    assert resampled(history, 1e-4).identical(history)


def test_a_lower_rate_needs_a_filter_of_a_tenth_of_it():
    raw = TimeHistory(np.zeros(1000), "g", interval=1e-4)
    with pytest.raises(InvalidInput, match=r"got 0.001 s for a signal that no filter is known of.*a class of 100 or lower"):
        resampled(raw, 1e-3)
    with pytest.raises(
        InvalidInput, match=r"got 0.001 s for CFC 180 \(SAE J211\), sampled every 0.0001 s; need a class of 100"
    ):
        resampled(filtered(raw, 180), 1e-3)
    assert len(resampled(filtered(raw, 60), 1e-3)) == 100
    assert len(resampled(filtered(filtered(raw, 60), 180), 1e-3)) == 100
    assert len(resampled(raw, 1e-3, allow_aliasing=True)) == 100


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda h: trimmed(h, -1.0), "start: got -1 s; need 0 .. 0.3 s, where pulse was recorded"),
        (lambda h: trimmed(h, 0.1, 0.4), "end: got 0.4 s; need 0 .. 0.3 s"),
        (lambda h: trimmed(h, 0.2, 0.1), "start: got 0.2 s with an end at 0.1 s; need a start before the end"),
        (lambda h: trimmed(h, float("nan")), "start: got nan s"),
        (lambda h: resampled(h, 0.0), "interval: got 0 s; need > 0 s"),
        (lambda h: resampled(h, float("nan")), "interval: got nan s; need > 0 s"),
        (lambda h: resampled(h, 1e-9), "interval: got 1e-09 s for 0.3 s; need at most 10000000 values"),
        (lambda h: resampled(trimmed(h, 0.1, 0.2), 7.0, allow_aliasing=True), "need a multiple of it within 0.1 .. 0.2 s"),
    ],
)
def test_parts_and_grids_outside_the_signal_are_refused(call, message):
    with pytest.raises(InvalidInput, match=message):
        call(TimeHistory([0.0, 1.0, 2.0, 3.0], "g", interval=0.1, name="pulse"))


def test_aligning_brings_signals_to_their_shared_time_at_the_finest_interval():
    slow = TimeHistory(np.arange(11.0), "g", start=-0.5, interval=0.1)
    fast = TimeHistory(np.arange(100.0), "g", start=-0.1, interval=0.01)
    one, other = aligned(slow, fast)
    assert np.array_equal(one.time, other.time)
    assert (one.interval, one.start, one.end) == (0.01, -0.1, 0.5)
    assert one.values.tolist() == pytest.approx(np.interp(one.time, slow.time, slow.values).tolist())
    assert aligned(slow, slow) == (slow, slow)
    with pytest.raises(InvalidInput, match="got no time that all share"):
        aligned(slow, TimeHistory([1.0, 1.0], "g", start=7.0, interval=0.1))
    with pytest.raises(InvalidInput, match="got signals with time stamps only"):
        aligned(TimeHistory([1.0, 1.0], "g", stamps=[0.0, 1.0]), TimeHistory([1.0, 1.0], "g", stamps=[0.0, 2.0]))


# offsets and signs


def test_the_offset_is_the_mean_before_time_zero_and_not_of_time_zero():
    history = TimeHistory([1.0, 3.0, 100.0, 200.0], "g", start=-2e-4, interval=1e-4)
    assert zeroed(history).values.tolist() == [-1.0, 1.0, 98.0, 198.0]
    assert zeroed(history, -1e-4, 1e-4).values.tolist() == [-50.5, -48.5, 48.5, 148.5]


def test_the_offset_of_uneven_values_is_their_mean_over_time():
    history = TimeHistory([0.0, 0.0, 4.0, 9.0], "g", stamps=[-3.0, -2.0, -1.0, 0.0])
    assert zeroed(history).values.tolist() == [-1.0, -1.0, 3.0, 8.0]


def test_no_values_before_the_impact_is_refused():
    with pytest.raises(InvalidInput, match="got 0 values from 0 s to 0 s; need two at least to tell an offset"):
        zeroed(TimeHistory([1.0, 2.0], "g", interval=0.1))


def test_reversing_the_sign_twice_changes_nothing():
    history = TimeHistory([1.0, -2.0], "g", interval=0.1, code="11HEAD0000H3ACX0")
    assert reversed_sign(history).values.tolist() == [-1.0, 2.0]
    assert reversed_sign(reversed_sign(history)).identical(history)


# several signals


def axes(**fields: object) -> list[TimeHistory]:
    return [TimeHistory([3.0, 1.0], "g", interval=0.1, name=axis, code=f"11HEAD0000H3AC{axis}A", **fields) for axis in "XYZ"]


def test_a_resultant_is_the_length_of_the_vector_and_has_its_own_code():
    length = resultant(*axes(filtered=CFC60))
    assert length.values.tolist() == pytest.approx([27.0**0.5, 3.0**0.5])
    assert (length.code, length.filtered, length.unit) == ("11HEAD0000H3ACRA", CFC60, "g")
    assert length.name == "resultant of X and Y and Z"


def test_a_resultant_of_different_places_has_no_code():
    x, y, _ = axes()
    assert resultant(x, y.renamed("y", code="11CHST0000H3ACYA")).code is None
    assert resultant(x, x).code is None


def test_the_mean_of_redundant_channels_keeps_unit_state_and_remarks():
    a = TimeHistory([1.0, 2.0], "g", interval=0.1, name="a", code="11HEAD0000H3ACX0", filtered=CFC60, remarks=("one",))
    b = TimeHistory([3.0, 6.0], "g", interval=0.1, name="b", filtered=CFC60, remarks=("one", "two"))
    both = mean(a, b)
    assert both.values.tolist() == [2.0, 4.0]
    assert (both.name, both.code, both.filtered, both.remarks) == ("mean of a and b", None, CFC60, ("one", "two"))


@pytest.mark.parametrize("together", [mean, resultant])
@pytest.mark.parametrize(
    ("other", "message"),
    [
        (TimeHistory([1.0, 2.0], "m/s2", interval=0.1, name="b"), "got a in 'g' and b in 'm/s2'; need one unit"),
        (TimeHistory([1.0, 2.0], "g", interval=0.2, name="b"), "got a and b at different times; need the same"),
        (TimeHistory([1.0, 2.0], "g", start=0.1, interval=0.1, name="b"), "got a and b at different times; need the same"),
        (TimeHistory([1.0, 2.0, 3.0], "g", interval=0.1, name="b"), "got a and b at different times; need the same"),
        (
            TimeHistory([1.0, 2.0], "g", interval=0.1, name="b", filtered=CFC60),
            r"got a \(no filter known\) and b \(CFC 60 \(SAE J211\)\); need the same filter",
        ),
    ],
)
def test_signals_that_are_not_alike_are_not_mixed(together, other, message):
    with pytest.raises(InvalidInput, match=message):
        together(TimeHistory([1.0, 2.0], "g", interval=0.1, name="a"), other)


@pytest.mark.parametrize("together", [mean, resultant])
def test_one_signal_is_not_several(together):
    with pytest.raises(InvalidInput, match="got 1 signals; need two at least"):
        together(TimeHistory([1.0, 2.0], "g", interval=0.1))
