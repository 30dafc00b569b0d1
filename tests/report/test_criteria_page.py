"""The page of a test's criteria: whole by itself, with the figures and intervals that its channels allow."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.patches import Rectangle
from typer.testing import CliRunner

from ridedown.apps.cli import app
from ridedown.report.criteria import CriteriaReport, html, pdf
from ridedown.report.criteria_figures import occupant_plots, vehicle_plots
from ridedown.signals import TestRecord, TimeHistory
from ridedown.signals.ev5 import read_ev5
from ridedown.signals.record import ChannelInfo, Occupant, Vehicle
from tests.report.read_pdf import pages, sections, unpacked

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "nhtsa_v10146"


@pytest.fixture(scope="module")
def measured() -> CriteriaReport:
    if not DATA.is_dir():
        pytest.skip(f"measured test 10146 is not at {DATA}")
    return CriteriaReport(read_ev5(DATA))


@pytest.fixture(scope="module")
def page(measured: CriteriaReport) -> str:
    return html(measured)


def two_cars() -> TestRecord:
    """A driver in each of two cars, both in seat 01: half-sines of 60 and 80 g on their heads, one axis."""
    time = np.arange(-500, 1500) * 1e-4
    heads = {}
    infos = {}
    for car, peak in ((1, 60.0), (2, 80.0)):
        values = np.where((time >= 0.0) & (time <= 0.03), peak * np.sin(np.pi * time / 0.03), 0.0)
        for axis, factor in (("x", -1.0), ("y", 0.0), ("z", 0.0)):
            key = f"head {car} <{axis}>"
            heads[key] = TimeHistory(factor * values, "g", start=-0.05, interval=1e-4, name=key)
            infos[key] = ChannelInfo(key, location="head", quantity="acceleration", axis=axis, vehicle=car, occupant="01")
    return TestRecord(
        "t<1>&",
        vehicles=(Vehicle(1), Vehicle(2)),
        occupants=(Occupant("01", 1), Occupant("01", 2)),
        channels=infos,
        load=lambda info: heads[info.key],
    )


class _Page(HTMLParser):
    """Collects what a page refers to, its anchors, and whether its tags close."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.links += [value for name, value in attrs if name in {"src", "href"}]
        self.anchors += [value for name, value in attrs if name == "id"]
        if tag not in {"meta", "link", "img", "br"}:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def parsed(text: str) -> _Page:
    page = _Page()
    page.feed(text)
    assert page.open == []
    return page


def test_the_page_stands_alone(page):
    found = parsed(page)
    assert all(link.startswith(("data:", "#")) for link in found.links)
    assert {link[1:] for link in found.links if link.startswith("#")} <= set(found.anchors)
    assert len(set(found.anchors)) == len(found.anchors)


def test_the_page_has_pulse_velocity_crush_and_the_occupants(page):
    anchors = parsed(page).anchors
    for name in ("vehicle-1-pulse", "vehicle-1-velocity", "vehicle-1-crush"):
        assert name in anchors
    for seat in ("01", "02"):
        for part in ("head", "chest", "femurs", "chest-deflection"):
            assert f"occupant-{seat}-{part}" in anchors


def test_the_page_says_the_numbers_that_the_json_has(measured, page):
    text = re.sub(r"<[^>]+>", " ", re.sub(r'src="data:[^"]+"', "", page))
    data = measured.as_json()
    for occupant in data["occupants"]:
        assert f" {occupant['hic15']:.1f} " in text
        assert f" {occupant['clip_3ms_g']:.2f} " in text
    assert f" {data['vehicle']['delta_v_kmh']:.2f} " in text
    assert f" {1e3 * data['vehicle']['dynamic_crush_m']:.0f} " in text
    assert "no file" in text
    assert "passed" in text


def test_the_windows_of_hic_are_shaded_where_they_were_found(measured):
    driver = measured.found.occupants[0]
    head = next(plot for plot in occupant_plots(measured.have, driver, "occupant 01") if plot.name == "occupant-01-head")
    bands = {
        str(patch.get_label()).split()[0]: (patch.get_x(), patch.get_x() + patch.get_width())
        for patch in head.figure.axes[0].patches
        if isinstance(patch, Rectangle)
    }
    for key, label in (("hic15", "HIC15"), ("hic36", "HIC36")):
        found = driver.findings[key]
        assert bands[label] == pytest.approx((1e3 * found.start, 1e3 * found.end), rel=1e-12)


def test_the_clip_is_shaded_where_it_is_exceeded_for_3_ms_in_all(measured):
    driver = measured.found.occupants[0]
    chest = next(plot for plot in occupant_plots(measured.have, driver, "occupant 01") if plot.name == "occupant-01-chest")
    areas = [one for one in chest.figure.axes[0].collections if isinstance(one, PolyCollection)]
    width = sum(np.ptp(np.asarray(path.vertices)[:, 0]) for area in areas for path in area.get_paths())
    assert width == pytest.approx(3.0, abs=0.21)  # ms: each stretch is drawn to whole samples, 0.1 ms apart


def test_the_velocity_drawn_passes_zero_when_the_vehicle_stands(measured):
    vehicle = measured.found.vehicles[0]
    velocity = next(plot for plot in vehicle_plots(measured.have, vehicle) if plot.name == "vehicle-1-velocity")
    line = velocity.figure.axes[0].lines[0]
    time, values = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    assert values[0] == pytest.approx(57.09, rel=1e-12)  # km/h, the header's speed
    crossing = np.interp(0.0, values[:1000][::-1], time[:1000][::-1])
    assert crossing == pytest.approx(1e3 * vehicle.time_to_zero_velocity, abs=0.01)  # ms


def test_two_occupants_of_one_seat_in_two_cars_are_told_apart():
    report = CriteriaReport(two_cars())
    text = html(report)
    anchors = parsed(text).anchors
    assert {"occupant-01-of-vehicle-1-head", "occupant-01-of-vehicle-2-head"} <= set(anchors)
    assert len(set(anchors)) == len(anchors)
    first, second = report.as_json()["occupants"]
    # a half-sine twice as long in time scales nothing: HIC goes with the peak to the 2.5th
    assert second["hic15"] / first["hic15"] == pytest.approx((80.0 / 60.0) ** 2.5, rel=1e-6)


def test_names_from_a_file_are_no_markup():
    text = html(CriteriaReport(two_cars()))
    assert "t&lt;1&gt;&amp;" in text
    assert "<x>" not in text


def test_a_record_without_anything_to_judge_has_a_page_too():
    record = TestRecord.of([TimeHistory([0.0, 1.0], "V", interval=1e-4, name="trigger")], identifier="empty")
    text = html(CriteriaReport(record))
    parsed(text)
    assert "trigger" in text
    assert "Channels" in sections(unpacked(pdf(CriteriaReport(record))))


def test_the_same_on_paper(measured):
    text = unpacked(pdf(measured))
    assert {"Criteria", "Regulations", "Figures", "Not computed", "Channels", "Notes"} <= set(sections(text))
    assert 7 <= pages(text) <= 11


def test_the_folder_has_the_page_each_figure_and_the_json(tmp_path):
    if not DATA.is_dir():
        pytest.skip(f"measured test 10146 is not at {DATA}")
    out = tmp_path / "out"
    result = CliRunner().invoke(app, ["criteria", str(DATA), "--out", str(out), "--json"])
    assert result.exit_code == 0
    written = {path.name for path in out.iterdir()}
    assert {"index.html", "report.pdf", "criteria.json", "vehicle-1-pulse.svg", "occupant-02-head.svg"} <= written
    assert json.loads((out / "criteria.json").read_text(encoding="utf-8")) == json.loads(result.stdout)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
