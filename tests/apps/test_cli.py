from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib

import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

import ridedown
from ridedown import catalogue
from ridedown.apps import cli
from ridedown.apps.cli import STOPPED, app
from ridedown.scenario import load


def invoke(*arguments: str):
    return CliRunner().invoke(app, arguments)


def test_version():
    assert invoke("--version").stdout == f"ridedown {ridedown.__version__}\n"


def test_run_prints_what_it_comes_to():
    result = invoke("run", "paper-child-offset")
    assert result.exit_code == 0
    for words in ("vehicle2", "child", "Dynamic crush", "slack taken up", "unaccounted for"):
        assert words in result.stdout
    assert "Reconstructed, not published" in result.stdout
    assert result.stderr == "" or "compiling" in result.stderr


def test_run_prints_json_and_nothing_else():
    result = invoke("run", "example-offset", "--json")
    summary = json.loads(result.stdout)
    assert summary["status"]["completed"]
    assert len(summary["occupants"]) == 3
    assert summary["vehicles"]["vehicle1"]["delta_v"] < 0.0
    assert abs(summary["energy"]["residual"]) < 1e-9


@pytest.mark.parametrize("name", ["paper-child-offset", "neon-wall", "marzbanrad-5"])
def test_run_writes_a_folder(tmp_path, name):
    out = tmp_path / "out"
    result = invoke("run", name, "--out", str(out))
    assert result.exit_code == 0
    written = {path.name for path in out.iterdir()}
    assert {"index.html", "channels.csv", "channels.parquet", "summary.json", "scenario.toml", "report.pdf"} <= written
    assert {"acceleration.svg", "velocity.svg", "energy.svg"} <= written
    assert load(out / "scenario.toml") == load(name)
    header = (out / "channels.csv").read_text().splitlines()[0]
    assert header.startswith("time [s],")
    assert pq.read_table(out / "channels.parquet").column_names[0] == "time"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_every_entry_of_the_catalogue_runs_and_prints():
    for name in catalogue.names():
        assert invoke("run", name).exit_code == 0, name
        shown = invoke("catalogue", name)
        assert load(tomllib.loads(shown.stdout)) == load(name)


def test_catalogue_lists_every_entry_with_its_confidence():
    listed = invoke("catalogue").stdout
    for name in catalogue.names():
        row = next(line for line in listed.splitlines() if line.strip().startswith(name))
        assert catalogue.entry(name).confidence in row


def test_schema_is_json():
    assert json.loads(invoke("schema").stdout)["title"] == "ridedown scenario"


def test_a_run_that_stops_early_shows_its_part_and_says_why(tmp_path):
    file = tmp_path / "spins.toml"
    file.write_text(SPINNING_BAR)
    result = invoke("run", str(file), "--out", str(tmp_path / "out"))
    assert result.exit_code == STOPPED
    assert result.stderr.splitlines()[-1].startswith("ridedown: stopped at ")
    assert "bar turned" in result.stderr
    assert "The simulation stopped at" in result.stdout
    assert "The simulation stopped at" in (tmp_path / "out" / "index.html").read_text()


@pytest.mark.parametrize(("given", "used"), [(None, "1"), ("4", "4")])
def test_linear_algebra_has_one_thread_unless_it_is_told_otherwise(monkeypatch, given, used):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", given or "0")  # put back after the test, as it was
    if given is None:
        monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    monkeypatch.setattr(cli, "app", lambda **_: None)
    cli.main()
    assert os.environ["OPENBLAS_NUM_THREADS"] == used


def test_help_imports_nothing_heavy():
    code = (
        "import sys; sys.argv = ['ridedown', '--help']\n"
        "from ridedown.apps.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print([m for m in ('numpy', 'numba', 'pydantic', 'matplotlib', 'scipy', 'rich') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("name", ["p1", "example-offset", "sled-half-sine"])
def test_a_later_run_imports_only_what_it_shows(name):
    assert invoke("run", name).exit_code == 0  # what has to be compiled is
    code = (
        f"import sys; sys.argv = ['ridedown', 'run', '{name}']\n"
        "from ridedown.apps.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        f"print([m for m in {NOT_IN_A_RUN} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


NOT_IN_A_RUN = (
    *("numba", "scipy", "matplotlib", "pyarrow", "duckdb", "jinja2", "ruamel.yaml", "numpy.ma", "rich.progress"),
    *("ridedown.compiled.compiling", "ridedown.signals.formats", "ridedown.limits.measured", "ridedown.studies"),
    *("ridedown.report.criteria_tables", "ridedown.report.figures", "ridedown.apps.first_run"),
)


@pytest.mark.parametrize(("arguments", "code"), [(["run", "no-such"], 2), (["nonsense"], 2), (["--version"], 0)])
def test_exit_codes_of_the_process(arguments, code):
    done = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == code
    assert "Traceback" not in done.stderr


def test_a_terminal_without_unicode_is_no_reason_to_stop():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    done = subprocess.run([*COMMAND, "catalogue", "p1"], capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0


COMMAND = [sys.executable, "-m", "ridedown.apps.cli"]


SPINNING_BAR = """
[vehicle1]
mass = "1500 kg"
speed = "80 km/h"
members.pieces = [{ stiffness = "10 kN/m" }]
[vehicle2]
mass = "1500 kg"
speed = "80 km/h"
members.pieces = [{ stiffness = "10 kN/m" }]
[bar]
mass = "40 kg"
inertia = "1 kg m2"
rail_spacing = "0.1 m"
lateral_offset = "0.1 m"
lever_arm = "printed"
"""
