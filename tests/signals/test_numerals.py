from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown.errors import InvalidInput
from ridedown.signals.numerals import lines_of, numbers_of


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=50))
def test_what_repr_writes_is_read_bit_for_bit(values):
    read = numbers_of([repr(value) for value in values], "f")
    assert read.tobytes() == np.array(values, dtype=np.float64).tobytes()


@pytest.mark.parametrize(
    "bad",
    [
        "nan",
        "inf",
        "-Infinity",
        "1_0",
        "1,5",
        "1e999",
        "",
        "  ",
        "0x10",
        "1 2",
        "٣",
        "--1",
        "\x1c1",
        "1\xa0",
        "1e",
        "1d5",
        "9" * 61,
    ],
)
def test_what_is_no_finite_number_is_refused_with_its_line(bad):
    with pytest.raises(InvalidInput, match=r"^v1\.001:12: got "):
        numbers_of(["1.0", "2", bad, "4"], "v1.001", first=10)


def test_one_long_line_does_not_cost_memory_for_all():
    lines = ["1"] * 100_000 + ["1" * 1_000_000]  # side by side this would be 400 GB
    with pytest.raises(InvalidInput, match=":100001:"):
        numbers_of(lines, "f")


def test_lines_end_in_any_of_the_ways_they_are_met():
    assert lines_of("a\nb\r\nc\rd\r\r\ne\x0cf\x85g\u2028h") == ["a", "b", "c", "d", "e\x0cf\x85g\u2028h"]
