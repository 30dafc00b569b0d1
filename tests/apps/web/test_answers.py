"""What the server answers is what the library returns."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import ridedown
from ridedown.apps.web.frames import decode, encode
from ridedown.apps.web.sliders import sliders
from ridedown.limits import assess
from ridedown.scenario import dump, load, parameters, substitute
from ridedown.signals import read
from ridedown.simulation import simulate, simulate_many
from ridedown.studies.sled_of_test import sled_of_test
from tests.apps.web.running import Running

SINGLE = 2.0**-23
"""Relative precision of a float, in which curves are sent."""

VALUES = {"vehicle1.mass": 1050.0, "bar.overlap": 0.45, "driver.restraint.slack": 0.035}


def test_frames_come_back_as_they_were() -> None:
    arrays = {"a": np.arange(5, dtype=np.float32), "b": np.array([[1.5, -2.5]]), "none": np.zeros((0, 3), dtype=np.float32)}
    header, back = decode(encode({"id": 7, "words": "Größe"}, arrays))
    assert header == {"id": 7, "words": "Größe"}
    for name, array in arrays.items():
        assert back[name].dtype == array.dtype
        np.testing.assert_array_equal(back[name], array)


@pytest.mark.parametrize("name", ridedown.catalogue.names())
def test_every_number_of_every_scenario_has_a_slider_that_holds_it(name: str) -> None:
    scenario = load(name)
    found = sliders(scenario)
    assert [one["path"] for one in found] == [one.path for one in parameters(scenario)]
    for one in found:
        assert one["low"] <= one["value"] <= one["high"]
        assert one["low"] < one["high"]


@pytest.mark.parametrize("name", ["example-offset", "example-restraints", "marzbanrad-5", "sled-r129-frontal"])
def test_curves_are_those_of_the_library(server: Running, name: str) -> None:
    values = VALUES if name == "example-offset" else {}
    with server.socket() as socket:
        found = socket.ask("simulate", scenario=name, values=values)
    response = simulate(substitute(load(name), values))
    assert found["end"] == response.end_time
    assert [(e["time"], e["who"], e["what"]) for e in found["events"]] == [(e.time, e.who, e.what) for e in response.events]
    for i, channel in enumerate(found["channels"]):
        exact = response.at(channel, found["time"])
        np.testing.assert_allclose(
            found["values"][i], exact, rtol=2 * SINGLE, atol=SINGLE * np.abs(exact).max(), err_msg=channel
        )
    drawn = {found["channels"][line["row"]] for figure in found["figures"] for line in figure["lines"]}
    assert {c for c in response.channels if c.endswith(".acceleration") and "seat" not in c and "bar" not in c} >= {
        c for c in drawn if c.endswith(".acceleration")
    }


def test_verdicts_are_those_of_the_library(server: Running) -> None:
    with server.socket() as socket:
        found = socket.ask("results", lane="results", scenario="example-offset", values=VALUES)
    response = simulate(substitute(load("example-offset"), VALUES))
    for rule in ("FMVSS 208", "UN R44"):
        expected = [
            (one.subject, one.shown(one.value), one.shown(one.limit)) for one in assess(response, rule).judgements if one.value
        ]
        assert [(v["subject"], v["value"], v["limit"]) for v in found["verdicts"] if v["regulation"] == rule] == expected
    peaks = {one["channel"]: (one["value"], one["time"]) for one in found["peaks"]}
    top = response.peak("driver.acceleration")
    assert peaks["driver.acceleration"] == (top.value, top.time)
    assert found["energy"]["initial"] == response.energy.initial


def test_a_map_is_simulate_many(server: Running) -> None:
    message = {"x": "vehicle1.mass", "y": "driver.restraint.stiffness", "outcome": "driver.acceleration.peak", "side": 12}
    with server.socket() as socket:
        found = socket.ask("map", lane="map", scenario="example-offset", **message)
    x, y = found["x"], found["y"]
    table = {"vehicle1.mass": np.tile(x, 12), "driver.restraint.stiffness": np.repeat(y, 12)}
    many = simulate_many(load("example-offset"), table, outcomes=["driver.acceleration.peak"])
    # without the occupants who push on nothing steps are others: equal to what a float holds
    np.testing.assert_allclose(found["outcome"].ravel(), np.abs(many["driver.acceleration.peak"]), rtol=4 * SINGLE)


def test_the_paper_is_drawn(server: Running) -> None:
    with server.socket() as socket:
        found = socket.ask("paper", lane="paper")
    assert [one["name"] for one in found["figures"]] == [f"figure-{n}" for n in range(6, 20)]
    line = found["figures"][4]["lines"][0]
    peak = simulate(load("paper-adult-full")).peak("adult.acceleration").value / 9.81
    assert np.abs(found["values"][line["row"]]).max() == pytest.approx(abs(peak), rel=1e-3)  # on a grid of 0.5 ms


def test_a_file_of_ones_own(server: Running) -> None:
    text = dump(substitute(load("p1"), {"adult.mass": 71.0}))
    with server.socket() as socket:
        found = socket.ask("describe", toml=text)
        assert found["toml"] == text
        curves = socket.ask("simulate", toml=text)
    assert curves["completed"]


@pytest.mark.parametrize(
    ("kind", "begins"),
    [
        ("scenario", b'name = "p1"'),
        ("csv", b"time [s],"),
        ("isomme", b"PK"),
        ("report", b"<!doctype html"),
        ("pdf", b"%pdf-1.7"),
    ],
)
def test_exports(server: Running, kind: str, begins: bytes) -> None:
    answer = server.request("POST", f"/export/{kind}", json.dumps({"scenario": "p1", "values": {"adult.mass": 71.0}}))
    assert answer.status == 200
    assert answer.content[: len(begins)].lower() == begins.lower()
    assert answer.headers["content-disposition"].startswith('attachment; filename="p1')
    if kind == "scenario":
        assert "71 kg" in answer.content.decode()


def test_a_measured_test(server: Running, measured: Path) -> None:
    answer = server.request("POST", "/upload", measured.read_bytes(), x_filename="v10146.zip")
    found = json.loads(answer.content)
    assert found["title"].startswith("2018 TOYOTA CAMRY") or "CAMRY" in found["title"].upper()
    hic = [v for v in found["verdicts"] if v["regulation"] == "FMVSS 208" and v["criterion"] == "HIC15"]
    assert hic[0]["value"] == pytest.approx(140.0, abs=1.5)  # the laboratory's, to which it is compared elsewhere
    with server.socket() as socket:
        drawn = socket.ask("channels", lane="channels", test=found["test"], channels=["94", "99"], cfc=60)
        curves = socket.ask("simulate", toml=found["sled"])
    assert np.nanmin(drawn["values"][0]) == pytest.approx(-39.0, abs=5.0)  # g
    start = curves["values"][curves["channels"].index("vehicle1.velocity")]
    assert start[0] * 3.6 == pytest.approx(57.09, abs=0.01)
    assert start[0] - start.min() == pytest.approx((57.09 + 9.5) / 3.6, rel=0.02)


def test_the_sled_of_a_test_keeps_its_change_of_velocity(measured: Path) -> None:
    sled = sled_of_test(read(measured))
    assert sled.speed == pytest.approx(57.09 / 3.6, rel=1e-6)
    assert len(sled.pulse.points) < 400
    assert sled.pulse.change() == pytest.approx((57.09 + 9.5) / 3.6, rel=0.02)


def test_the_newest_of_a_lane_wins(server: Running) -> None:
    with server.socket() as socket:
        last = 0
        for i in range(60):
            last = socket.send("simulate", scenario="example-offset", values={"vehicle1.mass": 1000.0 + i})
        answered: list[int] = []
        while not answered or answered[-1] != last:
            answered.append(socket.receive()[0]["id"])
    assert answered == sorted(answered)
    assert len(answered) < 60


def test_lanes_do_not_wait_for_each_other(server: Running) -> None:
    with server.socket() as socket:
        slow = socket.send(
            "map", lane="map", scenario="example-restraints", side=200, outcome="vehicle1.velocity.change",
            x="vehicle1.mass", y="vehicle1.speed",
        )  # fmt: skip
        quick = socket.send("simulate", scenario="p1")
        assert socket.receive()[0]["id"] == quick
        assert socket.receive()[0]["id"] == slow
