"""ridedown study and ridedown query."""

from __future__ import annotations

import csv
import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ridedown.apps.cli import app

ROOT = Path(__file__).resolve().parents[2]

SWEEP = """
kind = "sweep"
name = "Belts"
outcomes = ["adult.excursion.max", "adult.hic15"]

[[scenarios]]
name = "full"
scenario = "paper-adult-full"

[[scenarios]]
name = "offset"
scenario = "paper-adult-offset"

[[parameters]]
name = "belt"
path = "adult.restraint.stiffness"
grid = { start = "60 kN/m", stop = "100 kN/m", count = 3 }
"""


def ran(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "belts.toml").write_text(SWEEP)
    result = ran("study", folder / "belts.toml", "--out", folder / "out", "--threads", 1)
    assert result.exit_code == 0, result.stderr
    return folder, result


def test_a_study_is_run_and_kept(made):
    folder, result = made
    assert "Belts" in result.stdout
    assert "offset.adult.hic15" in result.stdout
    assert (folder / "out" / "study.toml").read_text() == SWEEP
    assert [path.name for path in (folder / "out" / "chunks").iterdir()] == ["chunk-00000000.parquet"]


def test_json_is_what_resume_finds_there(made):
    folder, _ = made
    result = ran("study", folder / "belts.toml", "--out", folder / "out", "--resume", "--json")
    assert result.exit_code == 0
    summary = json.loads(result.stdout)
    assert (summary["rows"], summary["done"], summary["complete"], summary["failed"]) == (3, 3, True, [])
    reach = summary["outcomes"]["full.adult.excursion.max"]
    assert reach["unit"] == "m"
    assert 0.1 < reach["min"] < reach["mean"] < reach["max"] < 1.0


def test_query_prints_a_table_csv_or_json(made):
    folder, _ = made
    sql = 'SELECT belt, "full.adult.excursion.max" AS x FROM results ORDER BY row'
    assert "80000" in ran("query", folder / "out", sql).stdout
    rows = json.loads(ran("query", folder / "out", sql, "--json").stdout)
    assert [row["belt"] for row in rows] == [60e3, 80e3, 100e3]
    table = list(csv.DictReader(io.StringIO(ran("query", folder / "out", sql, "--csv").stdout)))
    assert [float(row["x"]) for row in table] == [row["x"] for row in rows]  # to the last digit


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("sweep", "swep"), "sweep"),
        (("hic15", "hic16"), "hic15"),
        (("stiffness", "stifness"), "stiffness"),
        (("kN/m", "kN"), "stiffness"),
        (("paper-adult-full", "paper-adult-ful"), "paper-adult-full"),
        (("count", "cuont"), "count"),
        (("count = 3", "count = 3.5"), "count"),
    ],
)
def test_mistakes_in_the_file_are_one_sentence_and_nothing_is_written(tmp_path, change, said):
    (tmp_path / "study.toml").write_text(SWEEP.replace(*change))
    result = ran("study", tmp_path / "study.toml", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert said in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    assert not result.stdout
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("option", [["--reusme"], ["--threads", "0"], ["--threads", "two"], ["--clustr", "x"]])
def test_options_mistyped(made, option):
    folder, _ = made
    result = ran("study", folder / "belts.toml", "--out", folder / "other", *option)
    assert result.exit_code == 2
    assert result.stderr
    assert not (folder / "other").exists()


def test_results_that_are_there_are_not_overwritten(made):
    folder, _ = made
    result = ran("study", folder / "belts.toml", "--out", folder / "out")
    assert result.exit_code == 2
    assert "--resume" in result.stderr


def test_bad_sql_is_one_sentence(made):
    folder, _ = made
    result = ran("query", folder / "out", "SELECT nothing FROM results")
    assert result.exit_code == 2
    assert len(result.stderr.strip().splitlines()) == 1
    both = ran("query", folder / "out", "SELECT 1", "--csv", "--json")
    assert both.exit_code == 2


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_cleanly_and_tells_how_to_go_on(tmp_path, number):
    (tmp_path / "long.toml").write_text(
        'kind = "sweep"\nscenario = "p1"\noutcomes = ["adult.excursion.max"]\n'
        'parameters = [\n{ path = "vehicle1.mass", grid = { start = "1 t", stop = "2 t", count = 2000 } },\n'
        '{ path = "adult.mass", grid = { start = "50 kg", stop = "100 kg", count = 1000 } },\n]\n'
    )
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"  # where the tests run in the background
    begun = f"{heard}; from ridedown.apps.cli import main; main()"
    command = [sys.executable, "-c", begun, "study", "long.toml", "--threads", "1"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True) as process:
        chunks = tmp_path / "long-results" / "chunks"
        while not (chunks.is_dir() and list(chunks.glob("chunk-*.parquet"))):
            assert process.poll() is None
            time.sleep(0.02)  # it needs the processor itself
        process.send_signal(number)
        _, stderr = process.communicate(timeout=60)
    assert process.returncode == 3
    assert "Traceback" not in stderr
    assert stderr.count("ridedown: stopping") == 1  # said at once
    assert "ridedown study long.toml --resume" in stderr
    assert not list(chunks.glob(".*"))


OPTIMISE = """
kind = "optimise"
scenario = "p1"
parameters = [{ path = "adult.restraint.stiffness", range = ["20 kN/m", "120 kN/m"] }]

[optimise]
objectives = [{ outcome = "adult.acceleration.peak" }]
constraints = [{ outcome = "adult.excursion.max", most = "250 mm" }]
candidates = 8
generations = 4
"""


def test_searches_and_bounds_are_shown(tmp_path):
    (tmp_path / "belt.toml").write_text(OPTIMISE)
    result = ran("study", tmp_path / "belt.toml", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    assert "The best design found" in result.stdout
    assert "at most 250 mm" in result.stdout
    assert "Mean" not in result.stdout
    result = ran("study", tmp_path / "belt.toml", "--out", tmp_path / "out", "--resume", "--json")
    said = json.loads(result.stdout)
    assert said["complete"]
    assert said["results"]["chosen"]["feasible"]
    (tmp_path / "bound.toml").write_text('kind = "bound"\nscenario = "sled-half-sine"\nbound = { excursions = [0.2, 0.3] }\n')
    result = ran("study", tmp_path / "bound.toml", "--out", tmp_path / "bound")
    assert result.exit_code == 0, result.stderr
    assert "10.99" in result.stdout
    assert "OLC of the pulse: 22.03 g" in result.stdout
