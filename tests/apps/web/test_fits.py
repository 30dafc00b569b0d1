"""Restraints fitted to a measured test from the page: what the library finds, one a session, cancelled, bounded, kept."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ridedown.apps.web import fits
from ridedown.apps.web.fits import Fits
from ridedown.apps.web.uploads import Uploads
from ridedown.errors import InvalidInput, UnknownName
from ridedown.scenario import load
from ridedown.scenario.reading import table_in
from ridedown.signals import read, write
from ridedown.simulation import simulate
from ridedown.studies import calibrate
from ridedown.studies.calibration.of_test import TEMPLATES, calibration_of_test, fittable
from tests.apps.web.running import Running
from tests.studies.calibration.synthetic import sled_test

PLAIN = {
    "template": "spring and damper",
    "free": {"stiffness": [10e3, 500e3], "damping ratio": [0.0, 1.0]},
    "held": {"slack": 0.01},
    "mass": 78.0,
    "end": 0.15,
    "effort": "quick",
}


@pytest.fixture
def table(tmp_path: Path) -> bytes:
    """A loose table: an occupant's acceleration and the vehicle's, with no word on which is which."""
    path = tmp_path / "sled 7.csv"
    write(sled_test(), path)
    return path.read_bytes()


def ended(held: Fits, key: str) -> tuple[dict[str, Any], Mapping[str, Any]]:
    while True:
        told = held.answer({"action": "look", "fit": key}, None)
        header, arrays = told if isinstance(told, tuple) else (told, {})
        if header["ended"]:
            return header, arrays
        time.sleep(0.02)


def test_what_can_be_fitted_is_suggested(measured: Path) -> None:
    found = fittable(read(measured))
    assert [(one.key, one.seat, one.mass) for one in found[:2]] == [("13", "01", 78.0), ("59", "02", 49.0)]
    assert {one.key for one in found} == {"1", "13", "20", "47", "59", "66"}
    for kind in TEMPLATES.values():
        for number in kind.numbers:
            assert number.low <= number.value <= number.high
            assert not number.by_ratio or number.low > 0.0


def test_a_fit_of_the_page_is_that_of_the_library(server: Running, measured: Path) -> None:
    test = json.loads(server.request("POST", "/upload", measured.read_bytes(), x_filename="v10146.zip").content)["test"]
    with server.socket() as socket:
        suggested = socket.ask("fit", lane="fit", action="suggest", test=test)
        assert suggested["channels"][0]["key"] == "13"
        assert [one["name"] for one in suggested["templates"]] == list(TEMPLATES)
        told = socket.ask("fit", lane="fit", action="start", test=test, channel="13", **PLAIN)
        while not told["ended"]:
            time.sleep(0.1)
            told = socket.ask("fit", lane="fit", action="look", fit=told["fit"])
    assert told["trouble"] == ""
    expected = calibrate(
        calibration_of_test(
            read(measured),
            "13",
            "spring and damper",
            free={"stiffness": (10e3, 500e3), "damping ratio": (0.0, 1.0)},
            held={"slack": 0.01},
            effort="quick",
        )
    )
    result, channel = told["result"], expected.channels[0]
    assert result["values"] == expected.values
    assert result["rating"] == channel.rating.value
    assert result["peak_error"] == channel.peak_error
    assert result["warnings"] == list(expected.warnings)
    rows = (channel.measured, channel.model, channel.low, channel.high, channel.wide_low, channel.wide_high)
    for row, exact in zip(told["values"], rows, strict=True):
        np.testing.assert_allclose(row, exact, rtol=3e-7, atol=1e-5)
    scenario = server.request("GET", f"/fit/{told['fit']}/scenario.toml")
    assert scenario.status == 200
    assert scenario.content.decode() == result["toml"]
    fitted = load(table_in(Path("fitted.toml"), result["toml"], ""))
    assert fitted.occupants[0].restraint.stiffness == pytest.approx(expected.values["stiffness"])
    assert fitted.occupants[0].restraint.slack == pytest.approx(0.01)
    assert simulate(fitted).completed
    report = server.request("GET", f"/fit/{told['fit']}/report.html")
    assert report.status == 200
    assert b"ISO/TS 18571" in report.content
    assert server.request("GET", f"/fit/{told['fit']}/report.pdf").content.startswith(b"%PDF-")
    assert server.request("GET", f"/fit/{told['fit']}/else").status == 404
    assert server.request("GET", "/fit/nothing/scenario.toml").status == 404


def test_a_loose_table_is_fitted_on_the_pulse_that_is_named(table: bytes) -> None:
    uploads = Uploads()
    held = Fits(uploads)
    test = uploads.add(table, "sled 7.csv")["test"]
    suggested = held.answer({"action": "suggest", "test": test}, None)
    assert isinstance(suggested, dict)
    assert [one["key"] for one in suggested["channels"]] == ["sled x", "chest x"]
    asked = {"test": test, "channel": "chest x", **PLAIN}
    with pytest.raises(InvalidInput, match="pulse"):
        held.answer({"action": "start", **asked}, None)
    told = held.answer({"action": "start", **asked, "pulse": "sled x"}, None)
    assert isinstance(told, dict)
    header, _ = ended(held, told["fit"])
    assert header["trouble"] == ""
    assert set(header["result"]["values"]) == {"stiffness", "damping ratio"}


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"channel": "nothing"}, UnknownName, "channel"),
        ({"pulse": "chest x"}, InvalidInput, "which is fitted"),
        ({"template": "rope"}, UnknownName, "template"),
        ({"mass": -1.0}, InvalidInput, "mass"),
        ({"mass": "heavy"}, InvalidInput, "mass"),
        ({"end": 0.0}, InvalidInput, "end"),
        ({"effort": "endless"}, UnknownName, "effort"),
        ({"effort": ["quick"]}, UnknownName, "effort"),
        ({"free": {}}, InvalidInput, "free"),
        ({"free": {"stifness": [1.0, 2.0]}}, UnknownName, "stiffness"),
        ({"free": {"stiffness": [1.0]}}, InvalidInput, "stiffness"),
        ({"free": {"stiffness": [1.0, "x"]}}, InvalidInput, "stiffness"),
        ({"free": {"stiffness": [1.0, 1e300]}}, InvalidInput, "stiffness"),
        ({"free": ["stiffness"]}, InvalidInput, "parameters"),
        ({"held": {"slack": -1.0}}, InvalidInput, "slack"),
        ({"pulse": "chest y"}, UnknownName, "channel"),
        ({"action": "explode"}, UnknownName, "action"),
        ({"test": "0123"}, UnknownName, "Drop the file again"),
    ],
)
def test_what_cannot_be_fitted_is_refused(table: bytes, change: dict[str, Any], error: type[Exception], words: str) -> None:
    uploads = Uploads()
    test = uploads.add(table, "sled 7.csv")["test"]
    asked = {"action": "start", "test": test, "channel": "chest x", "pulse": "sled x", **PLAIN}
    with pytest.raises(error, match=words):
        Fits(uploads).answer(asked | change, None)


def test_bounds_that_cannot_be_are_told_by_the_fit(table: bytes) -> None:
    uploads = Uploads()
    held = Fits(uploads)
    test = uploads.add(table, "t.csv")["test"]
    asked = {"test": test, "channel": "chest x", "pulse": "sled x", **PLAIN}
    told = held.answer({"action": "start", **asked, "free": {"stiffness": [5e5, 1e4]}}, None)
    assert isinstance(told, dict)
    header, _ = ended(held, told["fit"])
    assert "bounds" in header["trouble"]
    with pytest.raises(InvalidInput, match="without a result"):
        held.report(told["fit"], "report.html")


LONG = PLAIN | {"template": "belt and airbag", "free": None, "held": None, "effort": "thorough"}


def started(held: Fits, test: str, owner: object, **change: Any) -> str:
    free = {one.name: [one.low, one.high] for one in TEMPLATES["belt and airbag"].numbers}
    asked = LONG | {"free": free, "channel": "chest x", "pulse": "sled x", **change}
    told = held.answer({"action": "start", "test": test, **asked}, owner)
    assert isinstance(told, dict)
    return str(told["fit"])


def test_one_a_session_a_few_at_once_and_cancelled_with_the_best_so_far(table: bytes) -> None:
    uploads = Uploads()
    held = Fits(uploads)
    test = uploads.add(table, "t.csv")["test"]
    one, other, third = object(), object(), object()
    first = started(held, test, one)
    assert started(held, test, one) == first  # the same again is the same
    with pytest.raises(InvalidInput, match="second one"):
        started(held, test, one, mass=80.0)
    second = started(held, test, other, mass=81.0)
    with pytest.raises(InvalidInput, match="other pages"):
        started(held, test, third, mass=82.0)
    for key in (first, second):
        held.answer({"action": "cancel", "fit": key}, None)
        header, arrays = ended(held, key)
        assert header["trouble"] == ""
        assert header["result"]["interrupted"]
        assert "Interrupted" in header["result"]["warnings"][0]
        assert arrays["values"].shape[0] == 6
    assert held._kept[first].found.calibration.cases == ()  # the test is not kept with it


def test_a_fit_that_takes_too_long_ends_with_the_best_so_far(table: bytes) -> None:
    uploads = Uploads()
    held = Fits(uploads, seconds=0.0)
    test = uploads.add(table, "t.csv")["test"]
    header, _ = ended(held, started(held, test, None))
    assert header["result"]["interrupted"]
    assert not header["cancelled"]


def test_old_fits_are_forgotten(table: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fits, "MOST_KEPT", 2)
    uploads = Uploads()
    held = Fits(uploads, seconds=0.0)
    test = uploads.add(table, "t.csv")["test"]
    keys = []
    for mass in (70.0, 71.0, 72.0):
        keys.append(started(held, test, None, mass=mass))
        ended(held, keys[-1])
    with pytest.raises(UnknownName, match="Start it again"):
        held.answer({"action": "look", "fit": keys[0]}, None)
    assert ended(held, keys[-1])
