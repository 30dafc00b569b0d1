"""`ridedown pulse`: what it prints, the files it writes, and that they read back; `ridedown run` of a sled."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ridedown import load, simulate
from ridedown.apps.cli import app
from ridedown.scenario import SledScenario
from ridedown.scenario.lowering import pulse_of
from ridedown.scenario.pulse_motion import PulseMotion
from ridedown.signals import read

G = 9.80665


def invoke(*arguments: str):
    return CliRunner().invoke(app, arguments)


def keyword(path: Path) -> tuple[int, np.ndarray, np.ndarray]:
    """Number, abscissas and ordinates of the curve in a keyword file, by its fixed columns."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("$")]
    assert lines[0] == "*KEYWORD"
    assert lines[1] == "*DEFINE_CURVE_TITLE"
    assert lines[-1] == "*END"
    rows = [(float(line[:20]), float(line[20:40])) for line in lines[4:-1]]
    assert all(len(line) == 40 for line in lines[4:-1])
    return int(lines[3][:10]), *np.array(rows).T


def motion(name: str) -> PulseMotion:
    sled = load(name)
    assert isinstance(sled, SledScenario)
    return PulseMotion.of(pulse_of(sled), end=float(sled.duration), speed=float(sled.initial_speed))


def test_a_pulse_in_numbers():
    result = invoke("pulse", "sled-fmvss-208", "--json")
    assert result.exit_code == 0, result.stderr
    data = json.loads(result.stdout)
    change = 2 / np.pi * 17.2 * G * 0.125
    assert data["delta_v"] == pytest.approx(-change, rel=1e-6)
    assert data["peak"] == pytest.approx(-17.2 * G, rel=1e-12)
    assert data["peak_time"] == pytest.approx(0.0625)
    assert data["displacement"] == pytest.approx(change * 0.125 / 2, rel=1e-9)
    assert data["time_to_rest"] == pytest.approx(0.125, abs=1e-5)
    assert data["esw"] == pytest.approx(change / 0.125, rel=1e-6)  # v0^2 / (2 v0 T/2)
    assert 15 * G < data["olc"] < 20 * G


def test_a_pulse_as_a_table():
    result = invoke("pulse", "sled-trapezoid")
    assert result.exit_code == 0, result.stderr
    for text in ("Delta-v, km/h", "OLC, g", "Equivalent square wave, g", "as prescribed"):
        assert text in result.stdout


@pytest.mark.parametrize("name", ["sled-fmvss-208", "sled-trapezoid", "sled-r129-frontal"])
def test_a_keyword_file_reads_back(tmp_path, name):
    out = tmp_path / "pulse.k"
    result = invoke("pulse", name, "--out", str(out), "--curve", "7")
    assert result.exit_code == 0, result.stderr
    number, time, value = keyword(out)
    assert number == 7
    assert (np.diff(time) > 0).all()
    found = motion(name)
    fine = np.linspace(0.0, found.end, 3000)
    off = np.interp(fine, time / 1e3, value * 1e3) - found.at(fine)[0]  # ms to s; mm/ms2 to m/s2
    assert np.abs(off).max() <= 1.01e-4 * np.abs(value * 1e3).max()


def test_a_jump_in_a_keyword_file_rises_at_once(tmp_path):
    scenario = tmp_path / "square.toml"
    scenario.write_text('[pulse]\nkind = "square"\npeak = "20 g"\nduration = "100 ms"\n')
    assert invoke("pulse", str(scenario), "--out", str(tmp_path / "s.k")).exit_code == 0
    _, time, value = keyword(tmp_path / "s.k")
    np.testing.assert_allclose(time, [0.0, 100.0, 100.000001, 200.0], rtol=1e-12)
    np.testing.assert_allclose(value, [-20 * G / 1e3, -20 * G / 1e3, 0.0, 0.0], rtol=1e-11)


@pytest.mark.parametrize("suffix", ["csv", "tsv", "parquet"])
def test_a_table_reads_back_and_can_be_a_pulse_again(tmp_path, suffix):
    out = tmp_path / f"pulse.{suffix}"
    assert invoke("pulse", "sled-half-sine", "--out", str(out)).exit_code == 0
    record, found = read(out), motion("sled-half-sine")
    for what, column in zip(("acceleration", "velocity", "displacement"), range(3), strict=True):
        history = record.history(f"vehicle1.{what}")
        np.testing.assert_allclose(history.values, found.at(history.time)[column], rtol=0, atol=1e-9)
    again = load({
        "pulse": {"kind": "measured", "file": str(out), "channels": "vehicle1.acceleration", "cfc": "none"},
        "speed": "50 km/h",
        "occupants": [o.model_dump(exclude_none=True) for o in load("sled-half-sine").occupants],
    })  # fmt: skip
    one, other = simulate(load("sled-half-sine")), simulate(again)
    assert other.peak("adult.acceleration").value == pytest.approx(one.peak("adult.acceleration").value, rel=1e-3)


def test_a_table_of_a_pulse_that_jumps_keeps_its_velocity(tmp_path):
    scenario, out = tmp_path / "square.toml", tmp_path / "square.csv"
    scenario.write_text('[pulse]\nkind = "square"\npeak = "20 g"\nduration = "60 ms"\n')
    assert invoke("pulse", str(scenario), "--out", str(out)).exit_code == 0
    acceleration, velocity = (read(out).history(f"vehicle1.{what}") for what in ("acceleration", "velocity"))
    taken = np.trapezoid(acceleration.values, acceleration.time)
    assert taken == pytest.approx(velocity.values[-1] - velocity.values[0], rel=1e-12)
    assert taken == pytest.approx(-20 * G * 0.06, rel=1e-12)


def test_the_pulse_of_a_crash(tmp_path):
    out = tmp_path / "p1.csv"
    result = invoke("pulse", "p1", "--vehicle", "2", "--out", str(out))
    assert result.exit_code == 0, result.stderr
    history = read(out).history("vehicle2.acceleration")
    np.testing.assert_allclose(history.values, simulate(load("p1")).at("vehicle2.acceleration", history.time), atol=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("sled-fmvss-208", "--vehicle", "2"), "vehicle: no 'vehicle2'"),
        (("p1", "--vehicle", "3"), "vehicle: no 'vehicle3'. Did you mean"),
        (("sled-fmvs-208",), "Did you mean 'sled-fmvss-208'"),
        (("sled-fmvss-208", "--out", "pulse.xlsx"), "need *.k (LS-DYNA)"),
        (("sled-fmvss-208", "--out", "pulse.k", "--curve", "0"), "curve: got 0"),
    ],
)
def test_what_is_refused(tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    result = invoke("pulse", *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["diary.k", "diary.csv"])
def test_what_is_of_another_kind_is_left_as_it_is(tmp_path, name):
    (tmp_path / name).write_text("dear diary\n" * 3)
    assert invoke("pulse", "sled-half-sine", "--out", str(tmp_path / name)).exit_code == 2
    assert (tmp_path / name).read_text() == "dear diary\n" * 3


def test_a_run_of_a_sled(tmp_path):
    result = invoke("run", "sled-fmvss-208", "--out", str(tmp_path / "out"))
    assert result.exit_code == 0, result.stderr
    assert "Vehicle, as prescribed" in result.stdout
    assert "taken by the vehicle, whose motion is prescribed" in result.stdout
    assert "still in contact" not in result.stdout
    data = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert data["vehicles"]["vehicle1"]["dynamic_crush"] is None
    assert data["vehicles"]["vehicle1"]["displacement"]["value"] == pytest.approx(data["pulse"]["displacement"], rel=1e-9)
    assert data["restitution"] is None
    assert load(tmp_path / "out" / "scenario.toml") == load("sled-fmvss-208")
    page = (tmp_path / "out" / "index.html").read_text()
    assert "Vehicle, as prescribed" in page
    assert {"acceleration.svg", "excursion.svg", "restraint-force.svg", "energy.svg"} <= {
        p.name for p in (tmp_path / "out").iterdir()
    }


def test_a_sled_goes_to_a_laboratory_format(tmp_path):
    assert invoke("convert", "sled-half-sine", str(tmp_path / "sled.zip")).exit_code == 0
    record = read(tmp_path / "sled.zip")
    assert record.vehicles[0].speed == pytest.approx(50 / 3.6, rel=1e-6)
    assert invoke("criteria", str(tmp_path / "sled.zip")).exit_code == 0
    code = record.channel("vehicle1.acceleration").code
    pulse = {"kind": "measured", "file": str(tmp_path / "sled.zip"), "channels": code}
    again = load({"pulse": pulse, "occupants": [o.model_dump(exclude_none=True) for o in load("sled-half-sine").occupants]})
    assert again.initial_speed == pytest.approx(50 / 3.6, rel=1e-6)
    one, other = simulate(load("sled-half-sine")), simulate(again)
    assert other.peak("adult.acceleration").value == pytest.approx(one.peak("adult.acceleration").value, rel=5e-3)  # CFC 60
