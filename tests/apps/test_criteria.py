"""`ridedown criteria`: small tests with known answers, the measured test 10146, and input that is none."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ridedown.apps.cli import app
from ridedown.errors import InvalidInput
from ridedown.signals import Filter, TestRecord, TimeHistory, write
from ridedown.signals.record import ChannelInfo, Occupant, OfficialResult, Vehicle

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "nhtsa_v10146"

G = 9.80665


def invoke(*arguments: str):
    return CliRunner().invoke(app, arguments)


def sled() -> TestRecord:
    """A constant 30 g on the vehicle from 14 m/s until it stands, and 50 g on the driver's chest for 20 ms; 10 kHz."""
    time = np.arange(-500, 2000) * 1e-4
    pulse = np.where((time >= 0.0) & (time < 0.05), -30.0, 0.0)
    chest = np.where((time >= 0.03) & (time <= 0.05), -50.0, 0.0)
    still = np.zeros_like(time)
    curves = {
        "pulse": (pulse, "10VEHC000000ACXC", "vehicle", "acceleration", "x"),
        "chest x": (chest, "11CHST0000H3ACXC", "chest", "acceleration", "x"),
        "chest y": (still, "11CHST0000H3ACYC", "chest", "acceleration", "y"),
        "chest z": (still, "11CHST0000H3ACZC", "chest", "acceleration", "z"),
    }
    histories = {
        name: TimeHistory(values, "g", start=-0.05, interval=1e-4, name=name, code=code, filtered=Filter(180))
        for name, (values, code, *_) in curves.items()
    }
    infos = {
        name: ChannelInfo(
            name, n, name, location=place, quantity=kind, axis=axis, unit="g", vehicle=1, code=code,
            occupant="01" if place == "chest" else None,
        )
        for n, (name, (_, code, place, kind, axis)) in enumerate(curves.items(), 1)
    }  # fmt: skip
    infos["lost"] = ChannelInfo("lost", 5, "head x", status="no file", readable=False)

    def load(info: ChannelInfo) -> TimeHistory:
        if info.key not in histories:
            raise InvalidInput(f"{info.key}: got no file; need one. Fetch it.")
        return histories[info.key]

    official = {"CLIP3M": OfficialResult(48.0, "g"), "HIC": OfficialResult(100.0, ""), "TTI": OfficialResult(12.0, "")}
    return TestRecord(
        "sled7",
        "A sled",
        vehicles=(Vehicle(1, "sled", 1000.0, 14.0),),
        occupants=(Occupant("01", 1, "Hybrid III", "50", official),),
        channels=infos,
        load=load,
    )


@pytest.fixture
def packed(tmp_path) -> Path:
    path = Path(tmp_path, "sled7.zip")
    left_out = write(sled(), path)
    assert len(left_out) == 1
    return path


def test_json_has_the_shape_of_its_documentation_and_known_values(packed):
    data = json.loads(invoke("criteria", str(packed), "--json").stdout)
    vehicle, driver = data["vehicle"], data["occupants"][0]
    # 500 samples of 30 g and one interval's ramp at the start and the end, each half: 50 ms in all; the filter keeps the area
    assert vehicle["delta_v_kmh"] == pytest.approx(3.6 * 30 * G * 0.05, rel=1e-3)
    assert vehicle["dynamic_crush_m"] == pytest.approx(14.0**2 / (2 * 30 * G), rel=1e-3)
    assert vehicle["time_to_zero_velocity_s"] == pytest.approx(14.0 / (30 * G), rel=1e-3)
    assert {"olc_g", "vpi_ms2", "peak_g"} <= set(vehicle)
    assert driver["seat"] == "01"
    assert driver["hic15"] is None
    assert "no channel for head" in driver["not_computed"]["hic15"]
    assert {"hic36", "clip_3ms_g", "chest_deflection_mm", "femur_n"} <= set(driver)
    assert driver["official"] == {"CLIP3M": 48.0, "HIC": 100.0, "TTI": 12.0}


def test_what_is_official_stands_beside_ours_with_the_difference(packed):
    driver = json.loads(invoke("criteria", str(packed), "--json").stdout)["occupants"][0]
    clip = next(one for one in driver["compared"] if one["official_name"] == "CLIP3M")
    assert clip["value"] == driver["clip_3ms_g"] > 49.0
    assert clip["difference"] == pytest.approx(driver["clip_3ms_g"] - 48.0, rel=1e-12)
    # an official HIC without its interval could be either, and there is no head to compute it from
    assert [
        (one["criterion"], one["value"], one["official"]) for one in driver["compared"] if one["official_name"] == "HIC"
    ] == [
        ("hic15", None, 100.0),
        ("hic36", None, 100.0),
    ]


def test_what_is_official_is_shown_where_the_channels_do_not_allow_it(packed):
    lines = invoke("criteria", str(packed)).stdout.splitlines()
    hic = next(line for line in lines if line.strip().startswith("HIC15"))
    assert "100" in hic
    assert any("TTI (no criterion here)" in line and "12" in line for line in lines)


def test_every_channel_has_its_peaks(packed):
    channels = json.loads(invoke("criteria", str(packed), "--json").stdout)["channels"]
    assert [one["name"] for one in channels] == ["pulse", "chest x", "chest y", "chest z"]
    chest = channels[1]
    assert (chest["unit"], chest["smallest"], chest["smallest_time_s"], chest["largest"]) == ("g", -50.0, 0.03, 0.0)


def test_a_channel_that_is_damaged_is_named_and_the_rest_goes_on(tmp_path):
    folder = tmp_path / "sled7"
    write(sled(), folder)
    broken = folder / "Channel" / "sled7.004"
    broken.write_bytes(broken.read_bytes() + b"rubbish\n")
    result = invoke("criteria", str(folder), "--json")
    data = json.loads(result.stdout)
    assert result.exit_code == 0
    assert [one["key"] for one in data["unusable"]] == ["4"]
    assert "sled7.004" in data["unusable"][0]["reason"]
    assert data["occupants"][0]["clip_3ms_g"] is None
    assert data["vehicle"]["delta_v_kmh"] > 0.0


@pytest.mark.parametrize("suffix", ["csv", "tsv", "parquet"])
def test_a_table_is_judged_by_the_codes_of_its_channels(tmp_path, packed, suffix):
    table = tmp_path / f"sled7.{suffix}"
    write(sled(), table)
    ours = json.loads(invoke("criteria", str(table), "--json").stdout)["occupants"][0]
    packed_ones = json.loads(invoke("criteria", str(packed), "--json").stdout)["occupants"][0]
    assert ours["clip_3ms_g"] == packed_ones["clip_3ms_g"]


def test_verdicts_name_the_limit_and_the_margin(packed):
    verdicts = json.loads(invoke("criteria", str(packed), "--json").stdout)["regulations"]["FMVSS 208"]
    chest = next(one for one in verdicts if one["criterion"] == "chest_3ms")
    assert (chest["verdict"], chest["limit"]) == ("passed", pytest.approx(60.0))
    assert chest["margin"] == pytest.approx(60.0 - chest["value"])
    assert next(one for one in verdicts if one["criterion"] == "hic15")["verdict"] == "not judged"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("none.csv", None, "no file or folder"),
        ("empty.csv", b"", "empty.csv"),
        ("rubbish.EV5", b"\x00\x01\x02", "rubbish"),
        ("bad.zip", b"PK\x03\x04 and no more", "bad.zip"),
        ("crash.toml", b"[vehicle1]\n", "ridedown run"),
    ],
)
def test_what_is_no_test_ends_in_one_sentence_and_nothing_written(tmp_path, name, content, said):
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    out = tmp_path / "out"
    result = invoke("criteria", str(path), "--out", str(out))
    assert result.exit_code == 2
    assert result.stdout == ""
    assert len(result.stderr.splitlines()) == 1
    assert said in result.stderr
    assert not out.exists()


def test_a_scenario_by_its_name_is_sent_to_run():
    result = invoke("criteria", "example-wall")
    assert result.exit_code == 2
    assert "ridedown run" in result.stderr


def test_run_prints_the_criteria_of_its_occupants():
    shown = invoke("run", "example-offset").stdout
    assert "Criteria of the occupants" in shown
    data = json.loads(invoke("run", "example-offset", "--json").stdout)
    occupants = data["criteria"]["occupants"]
    assert [one["seat"] for one in occupants] == list(data["occupants"])
    for one in occupants:
        peak_g = abs(data["occupants"][one["seat"]]["peak_acceleration"]["value"]) / G
        assert 0.9 * peak_g < one["clip_3ms_g"] <= peak_g
        assert one["lumped"]
        assert f"{one['clip_3ms_g']:.1f}" in shown


def test_run_of_a_network_has_no_occupants_to_judge():
    assert json.loads(invoke("run", "marzbanrad-5", "--json").stdout)["criteria"] == {"occupants": []}


# the measured test


@pytest.fixture(scope="module")
def measured():
    if not DATA.is_dir():
        pytest.skip(f"measured test 10146 is not at {DATA}")
    result = invoke("criteria", str(DATA), "--json")
    assert result.exit_code == 0
    return json.loads(result.stdout)


def test_10146_agrees_with_its_header(measured):
    driver, passenger = measured["occupants"]
    for occupant, hic in ((driver, 140), (passenger, 335)):
        assert round(occupant["hic15"]) == hic
        parts = {(one["official_name"], one["part"]): one for one in occupant["compared"]}
        # printed to 1, 1 g and 1 N; exact intervals begin up to 0.1 ms earlier, those of the sum do not (docs/criteria.md)
        assert abs(parts["HIC", "value"]["difference"]) <= 0.5
        assert abs(parts["CLIP3M", "value"]["difference"]) <= 0.5
        assert abs(parts["LFEM", "value"]["difference"]) <= 0.5
        assert abs(parts["RFEM", "value"]["difference"]) <= 0.5
        assert abs(parts["T1", "start"]["difference"]) <= 0.1
        assert abs(parts["T2", "end"]["difference"]) <= 0.1
        assert round(parts["HIC", "value"]["sum_of_samples"]) == hic
        for part in (parts["T1", "start"], parts["T2", "end"]):
            assert part["sum_of_samples"] == pytest.approx(part["official"], abs=1e-9)
        assert occupant["sum_of_samples"]["hic15"]["interval_s"] == pytest.approx(
            [1e-3 * parts["T1", "start"]["official"], 1e-3 * parts["T2", "end"]["official"]], abs=1e-12
        )


def test_10146_tells_of_every_channel(measured):
    assert len(measured["channels"]) == 30
    assert len(measured["unusable"]) == 604
    assert all("no file" in one["reason"] for one in measured["unusable"])
    assert next(one for one in measured["channels"] if one["key"] == "96")["status"] == "questionable"
    assert any("curve 96" in problem and "ends early" in problem for problem in measured["problems"])
