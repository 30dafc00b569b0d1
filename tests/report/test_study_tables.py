"""A study's numbers in the units that people read, whatever is computed in SI."""

from __future__ import annotations

import pytest

from ridedown.report.study_axes import Quantity
from ridedown.report.study_tables import number_tables, sensitivity_tables


def estimate(value):
    return {"value": value, "low": 0.9 * value, "high": 1.1 * value}


REACH = {
    "adult.clip_3ms": {"unit": "m/s2", "min": 196.133, "mean": 294.1995, "max": 392.266},
    "adult.excursion.max": {"unit": "m", "min": 0.1, "mean": None, "max": 20.0},
    "adult.hic15": {"unit": "", "min": 70.0, "mean": 80.0, "max": 90.0},
}
LIMIT = {"outcome": "adult.clip_3ms", "most": 313.8128, "least": None, "exceeded": 5, "rows": 20}
FAILED = [{"rows": 1, "status": "refused", "why": "because"}]


def test_a_sample_is_told_in_g_and_mm_and_percent():
    quantiles = [{"share": share, **estimate(value)} for share, value in ((0.05, 196.133), (0.5, 294.1995))]
    results = {
        "kind": "sample", "design": "sobol", "seed": 3, "outcomes": {"adult.clip_3ms": {"quantiles": quantiles}},
        "limits": [LIMIT | {"probability": estimate(0.25)}],
    }  # fmt: skip
    tables = number_tables({"done": 20, "outcomes": REACH, "results": results, "failed": FAILED})
    assert [table.rows for table in tables] == [
        (
            ("adult.clip_3ms", "g", "20", "30", "40"),
            ("adult.excursion.max", "mm", "100", "–", "20000"),
            ("adult.hic15", "–", "70", "80", "90"),
        ),
        (("adult.clip_3ms", "at most 32 g", "5", "20", "25", "22.5", "27.5"),),
        (("adult.clip_3ms", "g", "20", "30"),),
        (("1", "refused", "because"),),
    ]


def test_rows_that_were_not_drawn_have_a_share_and_no_probability():
    summary = {"done": 20, "outcomes": REACH, "results": {"kind": "sweep", "limits": [LIMIT]}, "failed": []}
    _, limits = number_tables(summary)
    assert limits.rows == (("adult.clip_3ms", "at most 32 g", "5", "20", "25"),)
    assert limits.columns[-1].title == "Share"
    assert sensitivity_tables(summary) == ()


def test_a_row_that_failed_does_not_hold_a_limit():
    results = {"kind": "sweep", "limits": [LIMIT | {"failed": 10}]}
    _, limits = number_tables({"done": 20, "outcomes": REACH, "results": results, "failed": []})
    assert limits.rows == (("adult.clip_3ms", "at most 32 g", "5", "10", "50"),)


def test_effects_are_in_the_unit_of_their_outcome_and_indices_are_shares():
    effects = [{"parameter": "belt", "mean_size": estimate(0.1), "deviation": 0.02}]
    indices = [{"parameter": "belt", "first": estimate(-1e-5), "total": estimate(0.5)}]
    outcomes = {"adult.excursion.max": {"effects": effects, "indices": indices}}
    found = {"outcomes": REACH, "results": {"method": "morris", "outcomes": outcomes}}
    (table,) = sensitivity_tables(found)
    assert table.rows == (("belt", "100", "90", "110", "20"),)
    assert {column.unit for column in table.columns[1:]} == {"mm"}
    (table,) = sensitivity_tables(found | {"results": {"method": "sobol", "outcomes": outcomes}})
    assert table.rows == (("belt", "0.000", "0.000", "0.000", "0.500", "0.450", "0.550"),)


@pytest.mark.parametrize(
    ("unit", "value", "text"),
    [("m", 55.0, "55000 mm"), ("m", 1.055e-7, "0.0001 mm"), ("rad", -1e-18, "0.0000 degrees"), ("", 1.055e-7, "1.055e−07")],
)
def test_numbers_have_no_powers_of_ten_where_they_are_of_a_size_to_read(unit, value, text):
    assert Quantity("x", unit).text(value) == text
