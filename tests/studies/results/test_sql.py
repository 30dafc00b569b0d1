"""SQL over results: reads, and nothing else; what is wrong is said in one sentence."""

from __future__ import annotations

import pytest

from ridedown.errors import InvalidInput
from ridedown.studies import query
from tests.studies.small import SWEEP, run


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return run(tmp_path_factory.mktemp("it's") / "out", study={**SWEEP, "outcomes": ["adult.excursion.max"]})


def test_results_and_columns(folder):
    softest = query(folder, 'SELECT "adult.restraint.stiffness" AS k FROM results ORDER BY "adult.excursion.max" DESC LIMIT 1')
    assert softest.to_pylist() == [{"k": 20e3}]
    assert query(folder, "SELECT name, unit FROM columns WHERE role = 'outcome'").to_pylist() == [
        {"name": "adult.excursion.max", "unit": "m"}
    ]
    assert query(folder, "WITH first AS (FROM results LIMIT 7) SELECT count(*) AS n FROM first")["n"].to_pylist() == [7]
    assert query(folder, "DESCRIBE results").num_rows == 6


@pytest.mark.parametrize(
    ("sql", "said"),
    [
        ("selec 1", "syntax error"),
        ("", "0 statements"),
        ("SELECT 1; SELECT 2", "2 statements"),
        ("SELECT count(*) FROM resuls", '"results"'),
        ('SELECT "adult.excursion.mx" FROM results', '"adult.excursion.max"'),
        ("SELECT max(adult.excursion.max) FROM results", "double quotes"),
        ("DROP VIEW results", "need a SELECT"),
        ("COPY results TO 'x.csv'", "need a SELECT"),
        ("ATTACH 'x.db'", "need a SELECT"),
        ("SET enable_external_access = true", "need a SELECT"),
        ("INSERT INTO columns VALUES ('a', 'b', 'c')", "need a SELECT"),
        ("SELECT * FROM read_csv('/etc/hostname')", "Cannot access file"),
        ("SELECT * FROM '/etc/hostname'", "/etc/hostname"),
        ("SELECT 1 / 'x' FROM results", "Could not convert"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(folder, sql, said):
    with pytest.raises(InvalidInput) as refused:
        query(folder, sql)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)
    assert "LINE 1" not in str(refused.value)


def test_a_folder_without_results(tmp_path):
    with pytest.raises(InvalidInput, match=r"manifest\.json"):
        query(tmp_path, "SELECT 1")
    with pytest.raises(InvalidInput, match=r"manifest\.json"):
        query(tmp_path / "none", "SELECT 1")
