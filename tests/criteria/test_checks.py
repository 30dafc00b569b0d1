"""What is no signal is refused, by every criterion, with a sentence that says where and why."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from ridedown import criteria
from ridedown.errors import InvalidInput

FUNCTIONS: dict[str, Callable[[Any, Any], object]] = {
    "hic": criteria.hic,
    "clip": criteria.clip,
    "cumulative clip": lambda t, a: criteria.clip(t, a, cumulative=True),
    "severity_index": criteria.severity_index,
    "peak": criteria.peak,
    "delta_v": criteria.delta_v,
    "dynamic_crush": lambda t, a: criteria.dynamic_crush(t, a, 10.0),
    "time_to_zero_velocity": lambda t, a: criteria.time_to_zero_velocity(t, a, 10.0),
    "coefficient_of_restitution": lambda t, a: criteria.coefficient_of_restitution(t, a, 10.0),
    "average_square_wave": lambda t, a: criteria.average_square_wave(t, a, 10.0),
    "equivalent_square_wave": lambda t, a: criteria.equivalent_square_wave(t, a, 10.0),
    "olc": criteria.olc,
    "vpi": criteria.vpi,
    "energy_split": lambda t, a: criteria.energy_split((t, a), (t, a), 10.0),
    "ridedown_efficiency": lambda t, a: criteria.ridedown_efficiency((t, a), (t, a), 10.0),
}

WRONG: dict[str, tuple[Any, Any, str]] = {
    "a NaN": ([0.0, 0.1, 0.2], [1.0, math.nan, 1.0], "got nan at sample 1; need finite numbers"),
    "an infinity": ([0.0, 0.1, 0.2], [1.0, 1.0, -math.inf], "got -inf at sample 2; need finite numbers"),
    "a NaN in the time": ([0.0, math.nan, 0.2], [1.0, 1.0, 1.0], "time: got nan at sample 1"),
    "unequal lengths": ([0.0, 0.1, 0.2], [1.0, 1.0], "got 2 values; need 3, one for each time"),
    "falling time": (
        [0.0, 0.2, 0.1],
        [1.0, 1.0, 1.0],
        "time: got 0.2 s and then 0.1 s at sample 2; need times that never fall",
    ),
    "one sample": ([0.0], [1.0], "time: got 1 samples; need >= 2"),
    "no sample": ([], [], "time: got 0 samples; need >= 2"),
    "no duration": ([0.1, 0.1], [1.0, 2.0], "time: got a signal that lasts 0 s; need > 0 s"),
    "two columns": ([0.0, 0.1], [[1.0, 2.0], [1.0, 2.0]], "got an array of shape \\(2, 2\\); need shape \\(n,\\)"),
    "a number": (0.0, 1.0, "got an array of shape \\(\\); need shape \\(n,\\)"),
    "text": (["now", "then"], [1.0, 1.0], "time: got list; need numbers"),
}


@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("what", WRONG)
def test_what_is_no_signal_is_refused(function: str, what: str) -> None:
    time, values, message = WRONG[what]
    with pytest.raises(InvalidInput, match=message):
        FUNCTIONS[function](time, values)


@pytest.mark.parametrize("function", FUNCTIONS)
def test_signals_come_in_any_kind_of_array_and_stay_as_they_are(function: str) -> None:
    time, values = np.linspace(0.0, 0.2, 41), -150.0 * np.ones(41)
    expected = FUNCTIONS[function](time, values)
    kept = time.copy(), values.copy()
    time.setflags(write=False)
    values.setflags(write=False)
    assert FUNCTIONS[function](time, values) == expected
    assert FUNCTIONS[function](list(time), tuple(values)) == expected
    assert FUNCTIONS[function](np.repeat(time, 2)[::2], np.repeat(values, 3)[::3]) == expected
    assert FUNCTIONS[function](time, values.astype(np.int64)) == expected
    np.testing.assert_array_equal((time, values), kept)


@pytest.mark.parametrize("function", FUNCTIONS)
def test_values_at_one_instant_between_two_others_have_no_duration(function: str) -> None:
    jump = FUNCTIONS[function]([0.0, 0.1, 0.1, 0.2], [-100.0, -100.0, -200.0, -200.0])
    assert FUNCTIONS[function]([0.0, 0.1, 0.1, 0.1, 0.1, 0.2], [-100.0, -100.0, 9e3, -9e3, -200.0, -200.0]) == jump
