from __future__ import annotations

import numpy as np
import pytest

from ridedown.report.study_axes import Bar, Quantity, limit_level, limit_upright, slug
from ridedown.report.style import new_axes


@pytest.mark.parametrize(
    ("unit", "value", "text"),
    [
        ("m/s2", 98.0665, "10 g"),
        ("m", 0.25, "250 mm"),
        ("N/m", 98.1e3, "98.1 kN/m"),
        ("kg", 78.0, "78 kg"),
        ("", 0.5, "0.5"),
        ("m/s", -10.0, "−36 km/h"),
    ],
)
def test_quantities_are_read_in_the_units_of_the_trade(unit, value, text):
    assert Quantity("a", unit).text(value) == text


def test_a_limit_says_which_values_break_it():
    values = [1.0, 2.0, 3.0, np.nan]
    assert Bar(2.0).broken(values).tolist() == [False, False, True, False]
    assert Bar(2.0, most=False).broken(values).tolist() == [True, False, False, False]
    assert Bar(0.25).words(Quantity("x", "m")) == "at most 250 mm"
    assert Bar(0.25, most=False).words(Quantity("x", "m")) == "at least 250 mm"


@pytest.mark.parametrize("most", [True, False])
def test_a_limit_outside_the_axes_is_brought_into_view(most):
    axes = new_axes("", xlabel="", ylabel="")
    axes.plot([0.0, 100.0], [0.0, 100.0])
    limit_upright(axes, Quantity("x", "m"), Bar(0.3, most=most))
    limit_level(axes, Quantity("y", "m"), Bar(-0.3, most=most))
    assert axes.get_xlim()[1] > 300.0
    assert axes.get_ylim()[0] < -300.0


def test_file_names():
    assert slug("map", "full.adult.clip_3ms") == "map-full-adult-clip-3ms"
