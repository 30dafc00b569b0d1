"""`ridedown extract` as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from ridedown.apps.cli import app
from ridedown.apps.extract import options
from ridedown.errors import InvalidInput
from ridedown.scenario import load
from ridedown.signals import write
from tests.report.read_pdf import sections, unpacked
from tests.studies.extraction import walls


@pytest.fixture(scope="module")
def wall_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A made wall test as a table."""
    path = tmp_path_factory.mktemp("wall") / "wall.csv"
    record = walls.record(walls.one_mass(), barrier=False)
    write(record, path)
    return path


NEEDED = ["--mass", "1500 kg", "--speed", "54 km/h", "--channels", "seat_crossmember_left, seat_crossmember_right"]


def test_writes_a_scenario_that_runs_and_a_page(wall_file: Path, tmp_path: Path) -> None:
    out, page = tmp_path / "new" / "front.toml", tmp_path / "page"
    result = CliRunner().invoke(app, ["extract", str(wall_file), *NEEDED, "--out", str(out), "--report", str(page)])
    assert result.exit_code == 0, result.stderr
    assert load(out).vehicle1.mass == 1500.0
    assert sorted(file.name for file in page.iterdir()) == [
        "cabin-acceleration.svg",
        "displacement.svg",
        "extract.json",
        "force-crush.svg",
        "index.html",
        "report.pdf",
        "scenario.toml",
        "velocity.svg",
    ]
    html = (page / "index.html").read_text(encoding="utf-8")
    assert "Force against crush" in html
    assert 'src="data:image/svg+xml' in html
    assert {"Results", "Figures", "Notes", "Scenario"} <= set(sections(unpacked((page / "report.pdf").read_bytes())))
    assert (page / "scenario.toml").read_text(encoding="utf-8") == out.read_text(encoding="utf-8")
    again = CliRunner().invoke(app, ["extract", str(wall_file), *NEEDED, "--out", str(out)])
    assert again.exit_code == 0  # a scenario is replaced by a scenario


def test_prints_the_scenario_where_no_file_is_named(wall_file: Path) -> None:
    result = CliRunner().invoke(app, ["extract", str(wall_file), *NEEDED])
    assert result.exit_code == 0, result.stderr
    assert "[vehicle1]" in result.stdout
    assert "Measured and reached" in result.stdout


def test_json(wall_file: Path) -> None:
    result = CliRunner().invoke(app, ["extract", str(wall_file), *NEEDED, "--json"])
    data = json.loads(result.stdout)
    assert abs(data["one_mass"]["crush_error"]) < 0.02
    assert data["two_masses"] is None
    assert data["one_mass"]["barrier_rating"] is None
    assert "[vehicle1]" in data["scenario"]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["--out", "front.txt"], "--out: got"),
        (["--mass", "heavy"], "mass: got"),
        (["--mass", "20 km/h"], "mass: got"),
        (["--channels", ","], "channels: got"),
        (["--masses", "2"], "masses: got 2"),
        (["--barrier", "no.csv"], "no.csv"),
    ],
)
def test_what_cannot_be_is_said_in_one_sentence(wall_file: Path, given: list[str], said: str) -> None:
    kept = [] if given[0] in NEEDED else list(NEEDED)
    if not kept:
        at = NEEDED.index(given[0])
        kept = NEEDED[:at] + NEEDED[at + 2 :]
    result = CliRunner().invoke(app, ["extract", str(wall_file), *kept, *given])
    assert result.exit_code == 2
    assert said in result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""


def test_never_writes_over_what_is_no_scenario(wall_file: Path, tmp_path: Path) -> None:
    other = tmp_path / "pyproject.toml"
    other.write_text('[project]\nname = "mine"\n', encoding="utf-8")
    result = CliRunner().invoke(app, ["extract", str(wall_file), *NEEDED, "--out", str(other)])
    assert result.exit_code == 2
    assert "is no scenario file" in result.stderr
    assert other.read_text(encoding="utf-8").startswith("[project]")


def test_options_with_and_without_units() -> None:
    assert options("1719 kg", "36 km/h", None, None) == {"mass": 1719.0, "speed": 10.0, "channels": (), "engine": None}
    assert options("1719", "10", "94, 99", "none") == {"mass": 1719.0, "speed": 10.0, "channels": ("94", "99"), "engine": ()}
    with pytest.raises(InvalidInput, match="speed: got"):
        options(None, "fast", None, None)
