"""Units convert exactly, are understood as test files spell them, and are refused where they could mean two things."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ridedown import units
from ridedown.errors import InvalidInput

every_unit = [unit for dimension in units.DIMENSIONS for unit in dimension.units]


def test_no_unit_belongs_to_two_dimensions():
    assert len(every_unit) == len(set(every_unit))


@pytest.mark.parametrize("dimension", units.DIMENSIONS, ids=lambda dimension: dimension.called)
def test_each_dimension_has_its_own_si_unit_of_size_one(dimension):
    assert dimension.units[dimension.unit] == 1


# Sizes from the SI brochure and the definitions of 1901 and 1959, written out by hand here.
@pytest.mark.parametrize(
    ("value", "unit", "to", "expected"),
    [
        (40.0, "g", "m/s2", 392.266),
        (-20.0, "g", "m/s2", -196.133),
        (9.80665, "m/s2", "g", 1.0),
        (57.09, "km/h", "m/s", 57.09 / 3.6),
        (15.0, "m/s", "km/h", 54.0),
        (35.0, "mph", "km/h", 56.32704),
        (356.0, "mm", "m", 0.356),
        (1000.0, "lbf", "N", 4448.2216152605),
        (100.0, "lbf in", "N m", 11.2984829027617),
        (30.0, "psi", "kPa", 206.84271879505083),
        (180.0, "deg", "rad", math.pi),
        (500.0, "deg/s", "rad/s", 500.0 * math.pi / 180.0),
        (57.0, "N m", "kN m", 0.057),
        (1.2, "ms", "s", 0.0012),
        (50.0, "%", "", 0.5),
    ],
)
def test_values_convert(value, unit, to, expected):
    assert units.convert(value, unit, to) == pytest.approx(expected, rel=5e-16)


def test_values_without_a_target_become_si_and_keep_their_shape():
    values = np.array([[1.0, 2.0], [3.0, 4.0]])
    assert units.convert(values, "mm").tolist() == [[0.001, 0.002], [0.003, 0.004]]


def test_converting_to_the_same_unit_gives_a_new_array_of_the_same_values():
    values = np.array([1.1, 2.2])
    same = units.convert(values, "N", "N")
    assert same is not values
    assert same.tolist() == values.tolist()


@given(st.sampled_from(every_unit), st.floats(-1e9, 1e9))
def test_a_value_goes_to_si_and_back_within_two_last_digits(unit, value):
    si = units.dimension(unit).unit
    back = units.convert(units.convert(value, unit), si, unit)
    assert back == pytest.approx(value, rel=5e-16, abs=1e-300)


@given(st.sampled_from(every_unit), st.integers(-10_000, 10_000))
def test_whole_numbers_convert_to_the_nearest_double(unit, value):
    size = units.size(unit)
    if max(size.numerator, size.denominator) < 2**39:  # then the product is exact, and the quotient rounded once
        assert float(units.convert(value, unit)) == float(Fraction(value) * size)


# As NHTSA headers, ISO-MME files and laboratories' tables spell them.
@pytest.mark.parametrize(
    ("written", "unit"),
    [
        ("G'S", "g"),
        ("G", "g"),
        ("g", "g"),
        ("M/S2", "m/s2"),
        ("m/s²", "m/s2"),
        ("m/s^2", "m/s2"),
        ("m/(s*s)", "m/s2"),
        ("M/S", "m/s"),
        ("KM/H", "km/h"),
        ("KPH", "km/h"),
        ("NWT", "N"),
        ("KN", "kN"),
        ("N·m", "N m"),
        ("Nm", "N m"),
        ("N*m", "N m"),
        ("NWM", "N m"),
        ("MM", "mm"),
        ("mm/s", "mm/s"),
        ("MM/S", "mm/s"),
        ("KG", "kg"),
        ("DEG/S", "deg/s"),
        ("°/s", "deg/s"),
        ("DPS", "deg/s"),
        ("RAD/S", "rad/s"),
        ("SEC", "s"),
        ("µs", "us"),
        (" mm ", "mm"),
        ("KPA", "kPa"),
        ("-", ""),
        ("1", ""),
    ],
)
def test_units_are_understood_as_test_files_spell_them(written, unit):
    assert units.is_known(written)
    assert units.spelled(written) == unit
    assert units.recognised(written) == unit


@pytest.mark.parametrize("written", ["nm", "mn", "kn", "mN", "mPa", "MS2", "T", "IN", "BAR", "furlong", "m" * 100, "G'"])
def test_what_could_mean_two_things_or_nothing_is_not_known(written):
    assert not units.is_known(written)
    assert units.recognised(written) == written
    with pytest.raises(InvalidInput, match=r"^unit: got .*; need a unit that is known"):
        units.spelled(written)


def test_every_unit_in_the_table_is_spelled_as_itself():
    assert [units.spelled(unit) for unit in every_unit] == every_unit


def test_an_unknown_unit_is_answered_with_the_nearest():
    with pytest.raises(InvalidInput, match=r"got 'km/hr'; need .*Did you mean 'km/h'\?$"):
        units.convert(1.0, "km/hr", "m/s")


def test_two_dimensions_do_not_convert():
    with pytest.raises(InvalidInput, match=r"got 'g', an acceleration, to be converted to 'N', a force; need an acceleration"):
        units.convert(1.0, "g", "N")
