"""`ridedown calibrate`: what it prints and writes, and what it does with a file that cannot be used."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ridedown import studies
from ridedown.apps.cli import STOPPED, app
from ridedown.scenario import load
from ridedown.signals import write
from ridedown.simulation import simulate
from ridedown.studies.calibration import fit
from tests.studies.calibration.synthetic import TRUE, record

ROOT = Path(__file__).parents[2]
FILE = """
title = "Belt"
search = { effort = "quick" }
[[cases]]
name = "sled 7"
scenario = "paper-adult-full"
record = "sled7.csv"
targets = [{ channel = "adult.acceleration", measured = "adult.acceleration", cfc = 60, window = ["0 ms", "150 ms"] }]
[[parameters]]
name = "stiffness"
paths = ["adult.restraint.stiffness"]
bounds = ["10 kN/m", "300 kN/m"]
scale = "log"
[[parameters]]
name = "slack"
paths = ["adult.restraint.slack"]
bounds = ["0 mm", "100 mm"]
[[parameters]]
name = "damping"
paths = ["adult.restraint.damping_ratio"]
bounds = [0, 1]
[[predict]]
name = "offset"
scenario = "paper-adult-offset"
targets = [{ outcome = "adult.excursion.max" }, { channel = "adult.acceleration", cfc = 60 }]
"""


def invoke(*arguments: object):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def file(tmp_path):
    write(record(TRUE, noise=10.0), tmp_path / "sled7.csv")
    path = tmp_path / "belt.toml"
    path.write_text(FILE)
    return path


def test_it_prints_and_writes_what_it_finds(file, tmp_path):
    out = tmp_path / "out"
    result = invoke("calibrate", file, "--out", out)
    assert result.exit_code == 0, result.stderr
    for words in ("stiffness", "95 % band", "ISO/TS 18571", "Predicted numbers", "Correlations"):
        assert words in result.stdout
    written = {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file()}
    assert {
        "index.html",
        "report.pdf",
        "calibration.json",
        "parameters.json",
        "correlations.svg",
        "scenarios/offset.toml",
    } <= written
    assert (out / "report.pdf").read_bytes().startswith(b"%PDF-")
    page = (out / "index.html").read_text()
    assert page.count("<img") == 4  # measured against model, predicted, residuals, correlations
    assert "http" not in page.replace("http://www.w3.org", "")
    again = load(out / "scenarios" / "sled-7.toml")
    data = json.loads((out / "calibration.json").read_text())
    assert again.occupants[0].restraint.stiffness == data["parameters"]["stiffness"]["value"]
    predicted = data["predictions"]["numbers"][0]
    ours = simulate(load(out / "scenarios" / "offset.toml")).maximum("adult.excursion").value
    assert ours == pytest.approx(predicted["model"], rel=1e-9)
    assert "Calibration: Belt" in [source.title for source in again.sources]


def test_json_is_all_that_is_printed(file):
    data = json.loads(invoke("calibrate", file, "--json").stdout)
    assert data["parameters"]["stiffness"]["low"] < TRUE["adult.restraint.stiffness"] < data["parameters"]["stiffness"]["high"]
    assert data["channels"][0]["rating"] > 0.95
    assert not data["interrupted"]


def test_an_interrupted_search_shows_the_best_so_far(file, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(fit, "least_squares", interrupted)
    result = invoke("calibrate", file)
    assert result.exit_code == STOPPED
    assert "interrupted" in result.stderr
    assert "stiffness" in result.stdout


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("sled7.csv", "sled8.csv", "sled8.csv"),
        ("paper-adult-full", "paper-adult-ful", "paper-adult-full"),
        ("bounds = [0, 1]", "bounds = [1, 0]", "parameters.2.bounds"),
        ("[[parameters]]", "[[parameter]]", "parameters"),
        ("10 kN/m", "10 kN/s", "parameters.0.bounds.0"),
        ("[[cases]]", "[cases", "line"),
    ],
)
def test_a_file_that_cannot_be_used_is_one_sentence(file, old, new, words):
    file.write_text(file.read_text().replace(old, new))
    result = invoke("calibrate", file)
    assert result.exit_code == 2
    assert len(result.stderr.strip().splitlines()) == 1
    assert words in result.stderr


def test_two_wall_tests_predict_the_crash_of_the_pair():
    found = studies.calibrate(ROOT / "docs" / "examples" / "navigator-neon.toml")
    assert all(number.met for number in found.numbers if number.fitted)
    predicted = {number.name: number for number in found.numbers if not number.fitted}
    change = {name: predicted[f"{name}.velocity.change"] for name in ("vehicle1", "vehicle2")}
    # the pair's momentum is kept, the bar of 20 kg aside, so that the changes are in the ratio of the masses
    assert change["vehicle2"].model / change["vehicle1"].model == pytest.approx(2873.0 / 1378.0, rel=0.01)
    assert change["vehicle2"].low < change["vehicle2"].model < change["vehicle2"].high
    for number in predicted.values():
        assert 0.0 < number.high - number.low < 0.5 * abs(number.model)
    assert found.parameter("Neon, force").high / found.parameter("Neon, force").low < 1.5
