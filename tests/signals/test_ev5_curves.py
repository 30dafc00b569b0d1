from __future__ import annotations

import numpy as np
import pytest

from ridedown.errors import InvalidInput
from ridedown.signals.ev5_curves import Grid, read_curve

GRID = Grid(-2, 3, 1e-4)
VALUES = [0.5, -1.25, 3.0, 4.0, -5.5, 6.0]


def xy(first: int = -2, interval: float = 1e-4, values=VALUES, end: str = "\n") -> str:
    return "".join(f"{(first + i) * interval:.6f}\t{value:.6f}{end}" for i, value in enumerate(values))


def single(values=VALUES) -> str:
    return "".join(f"{value}\n" for value in values)


@pytest.mark.parametrize(
    "text", [xy(), single(), xy(end="\r\n"), xy(end="\r"), "\n" + xy() + "\n\n", single().replace("\n", "\r\n")]
)
def test_both_layouts_give_the_same_curve(text):
    curve = read_curve(text, GRID, "v1.001")
    assert curve.values.tolist() == VALUES
    assert (curve.start, curve.interval, curve.stamps, curve.remarks) == (-2e-4, 1e-4, None, ())


def test_a_curve_that_ends_early_is_said_and_not_filled():
    curve = read_curve(single(VALUES[:4]), GRID, "v1.001")
    assert curve.values.tolist() == VALUES[:4]
    assert curve.remarks == ("v1.001: ends early, 4 samples of the 6 that the header gives",)


def test_more_samples_than_the_header_gives_are_said():
    curve = read_curve(xy(values=[*VALUES, 7.0]), GRID, "v1.001")
    assert curve.values.size == 7
    assert "holds 7 samples; the header gives 6" in curve.remarks[0]


def test_times_that_contradict_the_header_count_and_are_said():
    curve = read_curve(xy(interval=1.25e-4), GRID, "v1.001")
    assert curve.interval == pytest.approx(1.25e-4)
    assert curve.start == pytest.approx(-2.5e-4)
    assert "from those of the header" in curve.remarks[0]


def test_times_shifted_by_one_sample_are_a_contradiction():
    curve = read_curve(xy(first=-1), GRID, "v1.001")
    assert curve.start == -1e-4
    assert len(curve.remarks) == 1


def test_the_rounding_of_printed_times_is_no_contradiction():
    grid = Grid(-1000, 2000, 80e-6 / 3)  # 37.5 kHz: no time but every third is a whole number of microseconds
    values = np.zeros(grid.count)
    curve = read_curve(xy(-1000, 80e-6 / 3, values), grid, "v1.001")
    assert curve.remarks == ()
    assert curve.interval == grid.interval


def test_times_alone_do_where_the_header_gives_none():
    curve = read_curve(xy(), None, "v1.001")
    assert curve.start == -2e-4
    assert curve.interval == pytest.approx(1e-4, rel=1e-12)


def test_uneven_times_are_kept_as_stamps():
    curve = read_curve("0.0\t1\n0.1\t2\n0.1\t3\n0.5\t4\n", None, "v1.001")
    assert curve.interval is None
    assert curve.stamps.tolist() == [0.0, 0.1, 0.1, 0.5]


def test_values_without_times_are_refused_where_the_header_gives_none():
    with pytest.raises(InvalidInput, match="need DELT and NFP"):
        read_curve(single(), None, "v1.001")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("0.0\t1\n0.1\n", 2),
        ("1\n2\n\n4\n", 3),
        ("1\t2\t3\n", 1),
        ("0.0\t1\n0.1\tx\n", 2),
        ("0.0\t1\nnan\t1\n", 2),
        ("0.1\t1\n0.0\t1\n", 2),
        ("", 1),
        ("\n\n1\n2\nabc\n", 5),
        ("a b\n", 1),
    ],
)
def test_a_wrong_line_is_named(text, line):
    with pytest.raises(InvalidInput, match=rf"^v1\.001:{line}: got "):
        read_curve(text, GRID, "v1.001")
