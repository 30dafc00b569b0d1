from __future__ import annotations

import json
import re

import pytest
from typer.testing import CliRunner

from ridedown.apps.cli import app
from ridedown.paper.numbers import ACCELERATION, DISPLACEMENT, PRINTED
from ridedown.paper.reproduce import reproduce


@pytest.fixture(scope="module")
def reproduction():
    return reproduce()


def test_the_ten_numbers_are_the_papers():
    assert [(p.figure, p.case.title, p.quantity, p.value) for p in PRINTED] == [
        (8, "adult, full", DISPLACEMENT, 0.27),
        (10, "adult, full", ACCELERATION, 40.0),
        (8, "adult, offset", DISPLACEMENT, 0.22),
        (10, "adult, offset", ACCELERATION, 30.0),
        (13, "adult, full, damping 10 % of critical", ACCELERATION, 50.0),
        (16, "adult, full, k = 19.62 kN/m, 50 % of its critical", ACCELERATION, 30.0),
        (17, "child, full", DISPLACEMENT, 0.18),
        (19, "child, full", ACCELERATION, 47.0),
        (17, "child, offset", DISPLACEMENT, 0.14),
        (19, "child, offset", ACCELERATION, 36.0),
    ]


def test_every_number_is_within_three_percent(reproduction):
    errors = {f"fig {h.figure}, {h.case}, {h.quantity}": h.error for h in reproduction.headlines}
    assert {what: error for what, error in errors.items() if abs(error) > 0.03} == {}


def test_every_trend_holds(reproduction):
    assert [t.trend for t in reproduction.trends if not t.holds] == []


def test_every_figure_has_a_trend(reproduction):
    assert {t.figure for t in reproduction.trends} == set(range(6, 20))


def test_the_command_prints_the_agreed_json():
    printed = json.loads(CliRunner().invoke(app, ["paper", "--json"]).stdout)
    assert set(printed) == {"numbers", "trends"}
    assert len(printed["numbers"]) == 10
    for row in printed["numbers"]:
        assert set(row) == {"figure", "case", "quantity", "paper", "ours", "error"}
        assert row["error"] == pytest.approx(row["ours"] / row["paper"] - 1, rel=1e-12)
    for row in printed["trends"]:
        assert set(row) == {"figure", "trend", "holds"}
        assert isinstance(row["holds"], bool)


def test_the_command_says_reconstruction_and_writes_all_figures(tmp_path):
    out = tmp_path / "paper"
    result = CliRunner().invoke(app, ["paper", "--out", str(out)])
    assert result.exit_code == 0
    assert "reconstruction" in result.stdout
    figures = [f"figure-{number:02d}.svg" for number in range(6, 20)]
    assert sorted(path.name for path in out.iterdir()) == sorted([*figures, "index.html", "paper.json"])
    page = (out / "index.html").read_text(encoding="utf-8")
    assert "reconstruction" in page
    for number in range(6, 20):
        assert f"Figure {number}." in (out / f"figure-{number:02d}.svg").read_text(encoding="utf-8")
        assert re.search(rf'<figure id="figure-{number:02d}"><img [^>]*alt="Figure {number}\.', page)
