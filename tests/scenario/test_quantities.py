"""Units are read exactly, and what is no quantity of the right kind is refused in one sentence."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from ridedown.scenario.quantities import DIMENSIONS, Quantity, Refused, read, write
from ridedown.units import (
    ACCELERATION,
    DAMPING,
    FORCE,
    FRACTION,
    INERTIA,
    LENGTH,
    MASS,
    SPEED,
    STIFFNESS,
    TIME,
    Dimension,
)

finite = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("1500 kg", MASS, 1500.0),
        ("1.5 t", MASS, 1500.0),
        ("5 mm", LENGTH, 0.005),
        ("356mm", LENGTH, 0.356),
        ("1 in", LENGTH, 0.0254),
        ("200 ms", TIME, 0.2),
        ("20 µs", TIME, 20e-6),
        ("36 km/h", SPEED, 10.0),
        ("36 km / h", SPEED, 10.0),
        ("30 mph", SPEED, 13.4112),
        ("40 kN", FORCE, 40e3),
        ("98.1 kN/m", STIFFNESS, 98100.0),
        ("98.1 N/mm", STIFFNESS, 98100.0),
        ("2801 N s/m", DAMPING, 2801.0),
        ("2801 N*s/m", DAMPING, 2801.0),
        ("2801 N·s/m", DAMPING, 2801.0),
        ("2.801 kN s/m", DAMPING, 2801.0),
        ("157 kg m^2", INERTIA, 157.0),
        ("157 kg m²", INERTIA, 157.0),
        ("157 kg*m2", INERTIA, 157.0),
        ("1 g", ACCELERATION, 9.80665),
        ("9.81 m/s²", ACCELERATION, 9.81),
        ("50 %", FRACTION, 0.5),
        ("0.5", FRACTION, 0.5),
        ("1e-3 m", LENGTH, 0.001),
        (".5 m", LENGTH, 0.5),
        ("+5. m", LENGTH, 5.0),
        ("  5 m ", LENGTH, 5.0),
    ],
)
def test_text_with_a_unit(text: str, dimension: Dimension, value: float) -> None:
    assert read(text, dimension) == value


@pytest.mark.parametrize(
    ("value", "dimension", "words"),
    [
        ("40 kN", STIFFNESS, 'got "40 kN", a force; need a stiffness such as "98.1 kN/m".'),
        ("40 g", MASS, "an acceleration"),
        ("5 m s", TIME, 'unknown unit "m s"'),
        ("98 KN/m", STIFFNESS, 'Did you mean "kN/m"?'),
        ("5 parsecs", LENGTH, "Units known"),
        ("98100", STIFFNESS, "text without a unit"),
        ("1,5 t", MASS, "decimal point"),
        ("1,500 kg", MASS, "decimal point"),
        ("1.2.3 m", LENGTH, "need a length"),
        ("nan m", LENGTH, "need a length"),
        ("inf m", LENGTH, "need a length"),
        ("", LENGTH, "need a length"),
        ("m", LENGTH, "need a length"),
        ("1e400 m", LENGTH, "finite"),
        ("1e999999999 m", LENGTH, "need a length"),
        ("9" * 5000 + " m", LENGTH, "need a length"),
        ("٣ m", LENGTH, "need a length"),
        (True, MASS, "got true"),
        (None, MASS, "got nothing"),
        ([1], MASS, "got a list"),
        ({}, MASS, "got a table"),
        (math.nan, MASS, "got nan; need a finite number"),
        (-math.inf, MASS, "got -inf; need a finite number"),
        (10**400, MASS, "finite"),
        (1 + 2j, MASS, "need a mass"),
        (np.bool_(True), MASS, "need a mass"),
    ],
)
def test_refused(value: object, dimension: Dimension, words: str) -> None:
    with pytest.raises(Refused) as refused:
        read(value, dimension)
    assert words in str(refused.value)
    assert len(str(refused.value)) < 250


@pytest.mark.parametrize("value", [3, 3.0, np.float64(3), np.float32(3), np.int64(3), Fraction(3)])
def test_bare_numbers_are_si(value: object) -> None:
    number = read(value, SPEED)
    assert type(number) is float
    assert number == 3.0


@given(finite, st.sampled_from(DIMENSIONS))
@example(5e-324, MASS)
@example(-0.0, LENGTH)
def test_what_is_written_reads_back_as_the_same_float(value: float, dimension: Dimension) -> None:
    assert read(write(value, dimension), dimension) == value


@given(st.data(), st.decimals(-(10**6), 10**6, places=3), st.sampled_from(DIMENSIONS))
def test_every_unit_scales_exactly(data: st.DataObject, number: object, dimension: Dimension) -> None:
    unit = data.draw(st.sampled_from(sorted(dimension.units)))
    expected = float(Fraction(str(number)) * dimension.units[unit])
    assert read(f"{number} {unit}", dimension) == expected
    assert read(f"{number}{unit}", dimension) == expected


@given(st.data(), st.sampled_from(DIMENSIONS), st.sampled_from(DIMENSIONS))
def test_units_of_another_dimension_are_refused_by_its_name(data: st.DataObject, one: Dimension, other: Dimension) -> None:
    unit = data.draw(st.sampled_from(sorted(other.units)))
    if one is other or not unit:
        return
    with pytest.raises(Refused, match=other.called):
        read(f"3 {unit}", one)


@given(st.text(max_size=80))
def test_any_text_is_a_finite_number_or_refused(text: str) -> None:
    try:
        number = read(text, LENGTH)
    except Refused:
        return
    assert math.isfinite(number)


def test_no_unit_means_two_things() -> None:
    units = [unit for dimension in DIMENSIONS for unit in dimension.units]
    assert len(units) == len(set(units))


def test_bounds_hold_for_values_and_columns_alike() -> None:
    quantity = Quantity(TIME, above=0.0, most=10.0)
    assert quantity.rule == "> 0 s and <= 10 s"
    values = np.array([-1.0, 0.0, 1e-9, 10.0, 10.1])
    column = quantity.holds(values)
    assert [bool(quantity.holds(float(value))) for value in values] == list(np.asarray(column))
    assert list(np.asarray(column)) == [False, False, True, True, False]
    with pytest.raises(Refused, match=r"got 0 s; need > 0 s and <= 10 s\."):
        quantity.read(0)
    with pytest.raises(Refused, match='got "11 s"; need'):
        quantity.read("11 s")
