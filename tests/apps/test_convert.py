"""`ridedown convert`: between all formats and back, from scenarios, and what it refuses."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ridedown import load, simulate
from ridedown.apps.cli import app
from ridedown.signals import TestRecord, TimeHistory, read, write

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "nhtsa_v10146"
NAMES = ("one.csv", "two.tsv", "three.parquet", "four.zip", "five")


def invoke(*arguments: str):
    return CliRunner().invoke(app, arguments)


def small() -> TestRecord:
    time = np.arange(100) * 1e-4
    curves = [
        TimeHistory(np.sin(700.0 * time) / 3.0, "g", interval=1e-4, name="chest x", code="11CHST0000H3ACX0"),
        TimeHistory(-1000.0 * np.exp(-time), "N", interval=1e-4, name="femur", code="11FEMRLE00H3FOZ0"),
    ]
    return TestRecord.of(curves, identifier="sled7", title="A sled")


def curves_of(path: Path) -> dict[str, TimeHistory]:
    return {info.name: history for info, history in read(path).readable()}


@pytest.mark.parametrize("start", NAMES)
@pytest.mark.parametrize("end", NAMES)
def test_a_test_goes_from_any_format_to_any_other_bit_for_bit(tmp_path, start, end):
    first, second = tmp_path / "in" / start, tmp_path / end
    first.parent.mkdir()
    write(small(), first)
    result = invoke("convert", str(first), str(second))
    assert result.exit_code == 0, result.stderr
    assert "2 of 2 channels" in result.stdout
    there, back = small(), curves_of(second)
    assert set(back) == set(there.channels)
    assert all(there.history(name).identical(history) for name, history in back.items())


def test_a_conversion_may_be_done_again(tmp_path):
    write(small(), tmp_path / "in.csv")
    for name in NAMES:
        for _ in range(2):
            assert invoke("convert", str(tmp_path / "in.csv"), str(tmp_path / name)).exit_code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(("in.csv", *NAMES))


@pytest.mark.parametrize("name", NAMES)
def test_what_is_of_another_kind_is_left_as_it_is(tmp_path, name):
    write(small(), tmp_path / "in.csv")
    taken = tmp_path / name
    taken.write_text("dear diary\n" * 3)
    result = invoke("convert", str(tmp_path / "in.csv"), str(taken))
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert taken.read_text() == "dear diary\n" * 3
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted({"in.csv", name})


@pytest.mark.parametrize("name", ["sled.csv", "sled.parquet", "sled"])
def test_a_folder_with_other_things_in_it_is_left_as_it_is(tmp_path, name):
    write(small(), tmp_path / "in.csv")
    folder = tmp_path / name
    folder.mkdir()
    (folder / "film.mp4").write_bytes(b"film")
    assert invoke("convert", str(tmp_path / "in.csv"), str(folder)).exit_code == 2
    assert [path.name for path in folder.iterdir()] == ["film.mp4"]


@pytest.mark.parametrize("name", ["sled.xlsx", "sled.EV5", "sled.mme", "sled.txt", ""])
def test_a_name_that_tells_no_format_is_refused_with_those_that_do(tmp_path, name):
    write(small(), tmp_path / "in.csv")
    result = invoke("convert", str(tmp_path / "in.csv"), str(tmp_path / name) if name else "")
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["in.csv"]


def test_a_folder_may_have_a_dot_in_its_name_if_it_ends_in_a_slash(tmp_path):
    write(small(), tmp_path / "in.csv")
    assert invoke("convert", str(tmp_path / "in.csv"), f"{tmp_path / 'sled.7'}/").exit_code == 0
    assert len(curves_of(tmp_path / "sled.7")) == 2


@pytest.mark.parametrize("source", ["no-such-test", "none.csv", "example-wal", "", "a\0b", "x" * 5000])
def test_a_source_that_is_not_there_writes_nothing(tmp_path, source):
    result = invoke("convert", source, str(tmp_path / "out.csv"))
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_holds_the_test_itself_is_not_written_over(tmp_path):
    write(small(), tmp_path / "sled7")
    within = tmp_path / "sled7" / "Channel"
    result = invoke("convert", str(tmp_path / "sled7" / "sled7.mme"), str(tmp_path / "sled7"))
    assert result.exit_code == 2
    assert "holds the test itself" in result.stderr
    assert len(list(within.iterdir())) == 3


def test_a_scenario_that_stops_early_writes_nothing(tmp_path):
    (tmp_path / "spins.toml").write_text(SPINNING_BAR)
    result = invoke("convert", str(tmp_path / "spins.toml"), str(tmp_path / "out.csv"))
    assert result.exit_code == 2
    assert "bar turned" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["spins.toml"]


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_is_simulated_and_its_response_written(tmp_path, name):
    assert invoke("convert", "example-wall", str(tmp_path / name)).exit_code == 0
    response = simulate(load("example-wall"))
    chest = curves_of(tmp_path / name)["adult.acceleration"]
    assert chest.code is not None
    assert chest.code.startswith("11CHST")
    assert np.array_equal(chest.values, response.at("adult.acceleration", response.times()))
    np.testing.assert_allclose(chest.time, response.times(), rtol=0.0, atol=1e-12)  # s


def test_a_scenario_in_a_file_is_taken_too(tmp_path):
    (tmp_path / "mine.toml").write_text(invoke("catalogue", "example-wall").stdout)
    assert invoke("convert", str(tmp_path / "mine.toml"), str(tmp_path / "mine.csv")).exit_code == 0
    assert "vehicle1.acceleration" in curves_of(tmp_path / "mine.csv")


@pytest.mark.parametrize("name", NAMES)
def test_10146_is_written_and_what_has_no_file_is_said(tmp_path, name):
    if not DATA.is_dir():
        pytest.skip(f"measured test 10146 is not at {DATA}")
    result = invoke("convert", str(DATA), str(tmp_path / name))
    assert result.exit_code == 0
    assert "604 channels have no curve" in result.stderr
    assert "30 of 634 channels" in result.stdout
    if name in {"one.csv", "two.tsv", "three.parquet"}:
        assert "no place for vehicles" in result.stderr
    else:
        assert len(result.stderr.splitlines()) == 1
    original = {info.name: history for info, history in read(DATA).readable()}
    back = curves_of(tmp_path / name)
    assert len(back) == 30
    assert all(np.array_equal(original[key].values, history.values) for key, history in back.items())


@pytest.mark.parametrize("name", NAMES)
def test_10146_is_judged_alike_in_every_format(tmp_path, name):
    """Which of the redundant sensors make the pulse, and whom a channel belongs to, must not change with the file's format."""
    if not DATA.is_dir():
        pytest.skip(f"measured test 10146 is not at {DATA}")
    assert invoke("convert", str(DATA), str(tmp_path / name)).exit_code == 0
    first, second = (json.loads(invoke("criteria", str(path), "--json").stdout) for path in (DATA, tmp_path / name))
    for key in ("olc_g", "vpi_ms2", "peak_g"):
        assert second["vehicle"][key] == pytest.approx(first["vehicle"][key], rel=1e-9)
    for one, other in zip(first["occupants"], second["occupants"], strict=True):
        for key in ("seat", "hic15", "hic36", "clip_3ms_g", "chest_deflection_mm", "femur_n"):
            assert other[key] == one[key]


def test_a_test_of_the_database_is_not_written_over_by_itself(tmp_path):
    if not DATA.is_dir():
        pytest.skip(f"measured test 10146 is not at {DATA}")
    copy = tmp_path / "v10146"
    shutil.copytree(DATA, copy)
    before = sorted(path.name for path in copy.iterdir())
    assert invoke("convert", str(copy), str(copy)).exit_code == 2
    assert sorted(path.name for path in copy.iterdir()) == before
    assert [path.name for path in tmp_path.iterdir()] == ["v10146"]


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
