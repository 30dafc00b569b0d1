"""The page in real Chromium: every view and control, the address that holds its state, accessibility, no request elsewhere."""

from __future__ import annotations

import re
import socket as sockets
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from ridedown.motion import motion_of
from ridedown.scenario import dump, load, substitute
from ridedown.signals import read, write
from ridedown.simulation import simulate
from ridedown.studies import calibrate
from ridedown.studies.bound import Limiting, gap_of
from ridedown.studies.calibration.of_test import calibration_of_test
from ridedown.studies.calibration.wording import in_words
from tests.apps.web.running import Running, running
from tests.studies.calibration.synthetic import sled_test

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Locator, Page

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # playwright's own pipes, on the way out

G = 9.80665
READY = ".status.ready"
PATIENCE = 120e3  # ms for a page to show something, on a machine that is busy with other tests
PHONE = {"width": 390, "height": 844}
VIEWS = ("crash", "map", "test", "paper", "study")
SHOWN = {"crash": ".results table", "map": ".map canvas", "test": ".drop", "paper": ".plot >> nth=13", "study": ".study-new"}
"""What is there once a view is."""


class Watched:
    """Pages of one test, of which every complaint and every request elsewhere is noted."""

    def __init__(self, browser: Browser, server: Running) -> None:
        self.browser, self.server = browser, server
        self.troubles: list[str] = []
        self.contexts: list[Any] = []

    def open(self, hash_: str = "", wait: str = ".results table", **options: Any) -> Page:
        context = self.browser.new_context(**{"viewport": {"width": 1400, "height": 1000}, "accept_downloads": True, **options})
        self.contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.on("console", self._hear)
        page.on("pageerror", lambda error: self.troubles.append(str(error)))
        page.on("request", lambda request: self._note(request.url))
        page.on("websocket", lambda made: self._note(made.url))
        page.goto(f"{self.server.address}/{hash_}")
        page.wait_for_selector(READY)
        page.wait_for_selector(wait)
        return page

    def _hear(self, said: ConsoleMessage) -> None:
        if said.type in {"error", "warning"}:
            self.troubles.append(f"{said.type}: {said.text}")

    def _note(self, url: str) -> None:
        own = (self.server.address, self.server.address.replace("http", "ws"), f"blob:{self.server.address}")
        if not url.startswith(own):
            self.troubles.append(f"request to {url}")


@pytest.fixture
def watched(browser: Browser, server: Running) -> Iterator[Watched]:
    made = Watched(browser, server)
    yield made
    for context in made.contexts:
        context.close()
    assert made.troubles == []


def slide(page: Page, path: str, value: float) -> None:
    """Drag a slider to a value."""
    page.locator(f'[id="s-{path}"]').evaluate(
        "(input, value) => { input.value = value; input.dispatchEvent(new Event('input', { bubbles: true })); }", value
    )


def settled(page: Page) -> None:
    """Wait until the tables are those of the curves, and the address holds the state."""
    page.wait_for_timeout(250)
    page.wait_for_selector(".results:not(.stale)")


def number(text: str) -> float:
    return float(re.sub(r"[^0-9.−-]", "", text).replace("−", "-"))


def legend(page: Page, title: str) -> dict[str, float]:
    """The values beside the lines of a plot, at the moment chosen."""
    found = {}
    for item in page.locator(".plot", has_text=title).first.locator(".legend li").all():
        value = item.locator("b").inner_text()
        found[item.inner_text().replace(value, "").strip()] = number(value)
    return found


def test_what_it_shows_is_what_the_library_returns(watched: Watched) -> None:
    page = watched.open("#/crash?s=example-offset&t=0.08")
    slide(page, "vehicle1.mass", 1050.0)
    slide(page, "bar.overlap", 0.45)
    settled(page)
    response = simulate(substitute(load("example-offset"), {"vehicle1.mass": 1050.0, "bar.overlap": 0.45}))
    for who, shown in legend(page, "Acceleration").items():
        # the curve's value at the last of its times that is not after the moment: half a millisecond before it at most
        near = response.at(f"{who}.acceleration", [0.0795, 0.08]) / G
        assert min(near) - 0.06 <= shown <= max(near) + 0.06
    said = page.locator(".plot", has_text="Acceleration").first.locator("[role=img]").get_attribute("aria-label") or ""
    peak = response.peak("driver.acceleration")
    assert re.search(rf"driver −{abs(peak.value) / G:.1f} g at", said), said
    row = page.locator(".verdicts tr", has_text="FMVSS 208").first.inner_text()
    clip = watched_clip(response)
    assert f"{clip:.2f}"[:4] in row
    energy = page.locator("section[aria-label='Where the energy went'] h2").inner_text()
    assert number(energy.removesuffix(" kJ went")) == pytest.approx(response.energy.initial / 1e3, rel=1e-3)


def watched_clip(response: Any) -> float:
    from ridedown.criteria import clip  # noqa: PLC0415

    return clip(*response.history("driver.acceleration").si).value / G


def test_every_slider_redraws_every_plot(watched: Watched) -> None:
    page = watched.open()
    said = page.locator(".plot [role=img]").evaluate_all("all => all.map((one) => one.ariaLabel)")
    assert len(said) == 7
    slide(page, "vehicle2.speed", 20.0)
    settled(page)
    page.wait_for_function(  # those out of sight follow when the hand rests
        "said => [...document.querySelectorAll('.plot [role=img]')].every((one, i) => one.ariaLabel !== said[i])", arg=said
    )
    assert page.evaluate("performance.getEntriesByName('ridedown:redraw').length") >= 1


NOTE_LINES = """
window.lines = [];
for (const name of ["moveTo", "lineTo"]) {
  const draw = Path2D.prototype[name];
  Path2D.prototype[name] = function (x, y) {
    if (!this.points) lines.push((this.points = []));
    this.points.push([x, y]);
    draw.call(this, x, y);
  };
}
"""


def test_lines_go_through_few_points_and_past_none(watched: Watched, server: Running) -> None:
    """Every line of the first figure, drawn through a part of its points, is within a quarter of a pixel of all others."""
    page = watched.open()
    page.add_init_script(NOTE_LINES)
    page.reload()
    page.wait_for_selector(".results table")
    drawn = [np.array(line) for line in page.evaluate("lines")]
    with server.socket() as socket:
        answer = socket.ask("simulate", scenario="example-offset")
    time, figure = answer["time"], answer["figures"][0]
    assert figure["title"] == "Acceleration"
    for line, (x, y) in zip(figure["lines"], (each.T for each in drawn), strict=False):
        values = answer["values"][line["row"]]
        assert x.size < 0.3 * time.size, line
        across = (time - time[0]) * (x[-1] - x[0]) / (time[-1] - time[0]) + x[0]
        corner = np.clip(np.searchsorted(across, x - 1e-6), 0, time.size - 1)
        single = np.diff(x, prepend=-1.0, append=1e6).clip(0.0) > 1e-3  # of a jump either side could be meant
        single = single[:-1] & single[1:]
        up, zero = np.polyfit(values[corner[single]], y[single], 1)
        np.testing.assert_allclose(up * values[corner[single]] + zero, y[single], atol=1e-3)  # pixels: corners are points
        off = np.abs(np.interp(across, x, y) - (up * values + zero))
        steep = np.abs(np.gradient(np.interp(across, x, y))) > 20.0  # beside a jump no height is meant
        assert off[~steep].max() < 0.26, line


def test_a_pinned_run_of_the_same_numbers_lies_under_the_curves(watched: Watched) -> None:
    page = watched.open("#/crash?s=example-offset&pin.s=example-offset")
    page.add_init_script(NOTE_LINES)
    page.reload()
    page.wait_for_selector(".results table")
    settled(page)
    drawn = [np.array(line) for line in page.evaluate("lines")]
    both = [i for i in range(len(drawn) - 9) if all(np.array_equal(drawn[i + k], drawn[i + 5 + k]) for k in range(5))]
    assert len(both) >= 2  # accelerations and velocities, of five bodies each


def test_numbers_are_typed_with_units(watched: Watched) -> None:
    page = watched.open()
    field = page.get_by_label("vehicle1, speed, typed, km/h")
    for text, shown in (("64", "64"), ("20 m/s", "72"), ("5 kg", "72"), ("nonsense", "72")):
        field.fill(text)
        field.press("Enter")
        page.wait_for_timeout(50)
        assert field.input_value() == shown
    settled(page)
    assert "v.vehicle1.speed=20" in page.url
    page.get_by_role("button", name="vehicle1, speed: as in the scenario").click()
    assert field.input_value() == "50"
    settled(page)
    assert "v.vehicle1.speed" not in page.url


def test_what_is_refused_is_said_beside_its_slider(watched: Watched) -> None:
    page = watched.open("#/crash?s=example-restraints")
    field = page.get_by_label("driver, shoulder-belt, load limiter, force, typed, kN")
    field.fill("1")
    field.press("Enter")
    page.wait_for_selector(".slider .refused")
    assert "need more than pretensioners.0.stall_force" in page.locator(".slider .refused").inner_text()
    page.get_by_role("button", name="Reset all").click()
    page.wait_for_selector(".slider .refused", state="detached")


def test_the_address_is_the_state(watched: Watched) -> None:
    page = watched.open("#/crash?s=example-offset")
    page.get_by_role("button", name="Pin this run").click()
    slide(page, "driver.restraint.slack", 0.04)
    page.get_by_role("button", name="child", exact=True).click()
    page.get_by_label("every number").check()
    page.get_by_label("Time", exact=True).focus()
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    settled(page)
    page.wait_for_selector("th:has-text('Pinned')")

    def state(of: Page) -> list[Any]:
        return [
            of.locator("input[type=range]").evaluate_all("all => all.map((one) => [one.id, one.value])"),
            of.locator(".time output").inner_text(),
            of.locator(".tabs [aria-pressed=true]").all_inner_texts(),
            of.locator(".verdicts").inner_text(),
            of.locator(".plot [role=img]").evaluate_all("all => all.map((one) => one.ariaLabel)"),
        ]

    other = watched.open("#" + page.url.partition("#")[2], wait="th:has-text('Pinned')")
    settled(other)
    assert state(other) == state(page)
    assert other.url == page.url
    page.reload()
    page.wait_for_selector("th:has-text('Pinned')")
    settled(page)
    assert state(page) == state(other)


def test_back_and_forward(watched: Watched) -> None:
    page = watched.open()
    page.get_by_role("button", name="Paper").click()
    page.wait_for_selector(SHOWN["paper"])
    page.wait_for_timeout(300)
    page.go_back()
    page.wait_for_selector(".crash")
    page.go_forward()
    page.wait_for_selector(SHOWN["paper"])


def test_forward_soon_after_back_finds_what_lay_ahead(watched: Watched) -> None:
    page = watched.open()
    page.get_by_role("button", name="Paper").click()
    page.wait_for_selector(SHOWN["paper"])
    settled_address = "() => new Promise((done) => setTimeout(() => done(location.hash), 400))"
    ahead = page.evaluate(settled_address)
    for pause in range(100, 140, 2):  # ms: the address is written 120 ms after what it holds has changed
        page.evaluate("(pause) => { history.back(); setTimeout(() => history.forward(), pause); }", pause)
        assert page.evaluate(settled_address) == ahead, f"{pause} ms"
    page.wait_for_selector(SHOWN["paper"])


def test_time_is_scrubbed_played_and_stepped(watched: Watched) -> None:
    page = watched.open("#/crash?s=example-offset&t=0.05")
    line = page.locator(".moment").first
    before = line.evaluate("one => one.style.transform")
    page.get_by_role("button", name="To the next event").click()
    assert line.evaluate("one => one.style.transform") != before
    shown = page.locator(".time output").inner_text()
    response = simulate(load("example-offset"))
    following = next(event.time for event in response.events if event.time > 0.05)
    assert number(shown.removesuffix(" ms")) == pytest.approx(1e3 * following, abs=0.06)
    page.get_by_role("button", name="Play").click()
    page.wait_for_timeout(400)
    page.get_by_role("button", name="Stop").click()
    assert page.locator(".time output").inner_text() != shown
    area = page.locator(".plot .u-over").first
    box = area.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    assert number(page.locator(".time output").inner_text().removesuffix(" ms")) == pytest.approx(100.0, abs=1.0)


def test_events_are_listed_and_lead_to_their_time(watched: Watched) -> None:
    page = watched.open("#/crash?s=p1")
    events = simulate(load("p1")).events
    page.locator("summary", has_text=f"{len(events)} events").click()
    page.wait_for_selector(".events li")
    listed = page.locator(".events li").all_inner_texts()
    assert listed == [f"{1e3 * event.time:.2f} ms {event.who}: {event.what}" for event in events]
    page.locator(".events button").nth(3).click()
    assert page.locator(".time output").inner_text() == f"{1e3 * events[3].time:.1f} ms"


def test_the_map_goes_where_it_is_clicked(watched: Watched) -> None:
    page = watched.open("#/map?s=example-offset", wait=SHOWN["map"])
    canvas = page.locator(".map canvas")
    box = canvas.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.7 * box["width"], box["y"] + 0.3 * box["height"])
    page.wait_for_timeout(300)
    found = re.search(r"v\.driver\.restraint\.stiffness=([\d.]+)&v\.driver\.restraint\.slack=([\d.]+)", page.url)
    assert found is not None
    here = page.locator(".panel [role=status] b").inner_text()
    values = {"driver.restraint.stiffness": float(found[1]), "driver.restraint.slack": float(found[2])}
    peak = abs(simulate(substitute(load("example-offset"), values)).peak("driver.acceleration").value) / G
    assert number(here.removesuffix(" g")) == pytest.approx(peak, rel=2e-3)  # between the crashes of the map
    canvas.focus()
    page.keyboard.press("ArrowLeft")
    page.wait_for_timeout(300)
    assert found[0] not in page.url
    page.get_by_label("Outcome").select_option("driver.excursion.max")
    page.wait_for_selector("figcaption:has-text('driver, excursion, mm')")
    page.get_by_label("Limit, mm").fill("300")
    page.get_by_label("Limit, mm").press("Enter")
    page.wait_for_selector(".map .legend:has-text('limit 300 mm')")
    page.get_by_role("button", name="See this crash").click()
    page.wait_for_selector(".results table")


def test_the_map_shows_what_physics_allows(watched: Watched) -> None:
    page = watched.open("#/map?s=example-offset&v.driver.restraint.slack=0.03", wait=SHOWN["map"])
    page.wait_for_selector(".map .legend:has-text('within the excursion that each crash has')")
    response = simulate(substitute(load("example-offset"), {"driver.restraint.slack": 0.03}))
    found = gap_of(response, "driver")
    design = f"This design {found.design.peak / G:.1f} g"
    within = f"{1e3 * found.design.excursion:.0f} mm"
    page.wait_for_selector(f".physics:has-text('{design}, physics allows {found.bound.peak_g:.1f} g within {within}.')")
    assert f"{1.0 / found.ratio:.2f} times the least possible" in page.locator(".physics").inner_text()
    page.get_by_label("Excursion allowed, mm").fill("250")
    page.get_by_label("Excursion allowed, mm").press("Enter")
    page.wait_for_selector(".map .legend:has-text('excursion of 250 mm')")
    least = Limiting(motion_of(response, "vehicle1"), horizon=response.end_time).bound(0.25)
    page.wait_for_selector(f".physics:has-text('{design}, physics allows {least.peak_g:.1f} g within 250 mm.')")
    assert f"The design uses {within}: more than is allowed" in page.locator(".physics").inner_text()
    page.wait_for_url(re.compile("room=0.25"))
    other = watched.open("#" + page.url.partition("#")[2], wait=".map .legend:has-text('excursion of 250 mm')")
    other.wait_for_selector(".physics:has-text('more than is allowed')")
    assert other.locator(".physics").inner_text() == page.locator(".physics").inner_text()
    page.get_by_label("Outcome").select_option("driver.excursion.max")
    page.wait_for_selector(".physics:has-text('does not apply to this outcome')")
    page.get_by_label("What physics allows").uncheck()
    page.wait_for_url(re.compile("bound=0"))
    assert page.locator(".physics").inner_text().strip() == "What physics allows"


def test_a_measured_test_is_dropped_and_becomes_a_sled(watched: Watched, measured: Path, tmp_path: Path) -> None:
    page = watched.open("#/test", wait=SHOWN["test"])
    hostile = tmp_path / "evil.zip"
    hostile.write_bytes(b"PK\x03\x04" + bytes(100))
    page.locator(".drop input").set_input_files(hostile)
    page.wait_for_selector(".refused")
    watched.troubles = [said for said in watched.troubles if "422" not in said]  # the browser's own word of the answer
    page.locator(".drop input").set_input_files(measured)
    page.wait_for_selector("h2:has-text('CAMRY')")
    rows = page.locator("tr", has_text="HIC15").all_inner_texts()
    assert any("139.8" in row and "140" in row for row in rows)  # ours beside the laboratory's
    page.get_by_label("Find channels").fill("head x")
    page.locator(".chooser li input").first.check()
    page.get_by_role("button", name="CFC 1000").click()
    page.wait_for_selector(".legend li >> nth=2")
    page.wait_for_timeout(300)
    other = watched.open("#" + page.url.partition("#")[2], wait=".legend li >> nth=2")
    assert other.locator(".legend li").all_inner_texts() == page.locator(".legend li").all_inner_texts()
    page.get_by_role("button", name="Use as pulse").click()
    page.wait_for_selector(".results:not(.stale) table")
    assert legend(page, "Velocity")["vehicle1"] != 0.0
    settled(page)
    again = watched.open("#" + page.url.partition("#")[2])  # the whole pulse is in the address
    assert again.locator(".plot [role=img]").first.get_attribute("aria-label") == page.locator(
        ".plot [role=img]"
    ).first.get_attribute("aria-label")


def search_of(page: Page) -> Locator:
    """The choice of how hard to search."""
    return page.get_by_role("combobox", name="Search")


def shown_fit(page: Page) -> list[Any]:
    """What a fit shows of its result."""
    return [
        page.locator(".calibrate dl").inner_text(),
        page.locator(".calibrate table", has_text="95 % band").inner_text(),
        page.locator(".calibrate .note").all_inner_texts(),
        page.locator(".calibrate .plot [role=img]").get_attribute("aria-label"),
    ]


@pytest.fixture
def dropped(watched: Watched, measured: Path) -> Page:
    """The Test view with test 10146 in it, and what it can be fitted with."""
    page = watched.open("#/test", wait=SHOWN["test"])
    page.locator(".drop input").set_input_files(measured)
    page.wait_for_selector("h2:has-text('CAMRY')")
    page.get_by_role("button", name="Calibrate against it").click()
    page.wait_for_selector(".calibrate table")
    return page


def test_a_restraint_is_fitted_to_a_measured_test(watched: Watched, dropped: Page, measured: Path) -> None:
    page = dropped
    page.get_by_role("button", name="Calibrate", exact=True).click()
    page.wait_for_selector(".calibrate .results")
    expected = calibrate(calibration_of_test(read(measured), "13"))
    channel = expected.channels[0]
    assert channel.rating is not None
    assert channel.rating.value >= 0.90
    figures = page.locator(".calibrate dl").inner_text()
    assert f"{channel.rating.value:.3f}, {channel.rating.grade}" in figures
    assert f"{channel.peak_error:.2%}".replace("%", " %").replace("-", "−") in figures
    rows = page.locator(".calibrate table", has_text="95 % band").locator("tbody tr").all_inner_texts()
    for parameter, row in zip(expected.parameters, rows, strict=True):
        for value in (parameter.value, parameter.low, parameter.high):
            assert in_words(value, parameter.unit) in row
    assert page.locator(".calibrate .note").all_inner_texts() == list(expected.warnings)
    assert any("cannot be told apart" in note for note in expected.warnings)
    with page.expect_download() as waiting:
        page.get_by_role("link", name="Scenario file").click()
    [name] = expected.scenarios
    assert Path(waiting.value.path()).read_text(encoding="utf-8") == expected.toml(name)
    with page.expect_download() as waiting:
        page.get_by_role("link", name="HTML report").click()
    assert b"ISO/TS 18571" in Path(waiting.value.path()).read_bytes()
    with page.expect_download() as waiting:
        page.get_by_role("link", name="PDF report").click()
    assert Path(waiting.value.path()).read_bytes().startswith(b"%PDF-")
    page.wait_for_timeout(300)
    other = watched.open("#" + page.url.partition("#")[2], wait=".calibrate .results")  # the address finds the fit again
    assert shown_fit(other) == shown_fit(page)
    page.get_by_role("button", name="Open the fitted scenario in Crash").click()
    page.wait_for_selector(".results:not(.stale) table")
    said = page.locator(".plot", has_text="Acceleration").first.locator("[role=img]").get_attribute("aria-label") or ""
    peak = simulate(expected.scenarios[name]).peak("driver.acceleration")
    assert re.search(rf"driver −{abs(peak.value) / G:.1f} g at", said), said


def test_what_is_fitted_is_chosen(watched: Watched, dropped: Page, measured: Path) -> None:
    page = dropped
    page.get_by_role("combobox", name="Restraint").select_option("spring and damper")
    page.get_by_label("Measured acceleration").select_option("59")
    assert page.get_by_label("Occupant’s mass, kg").input_value() == "49"
    page.get_by_label("Pulse of the vehicle").select_option("94")
    search_of(page).select_option("quick")
    page.get_by_label("slack, free").uncheck()
    for label, text, shown in (
        ("slack, held at, mm", "1.5 cm", "15"),
        ("stiffness, from, kN/m", "20", "20"),
        ("damping ratio, to, %", "80", "80"),
        ("damping ratio, from, %", "nonsense", "0"),
        ("Occupant’s mass, kg", "52", "52"),
        ("End of the fit, ms", "120", "120"),
    ):
        page.get_by_label(label).fill(text)
        page.get_by_label(label).press("Enter")
        assert page.get_by_label(label).input_value() == shown
    page.get_by_role("button", name="Calibrate", exact=True).click()
    page.wait_for_selector(".calibrate .results")
    expected = calibrate(
        calibration_of_test(
            read(measured), "59", "spring and damper", free={"stiffness": (20e3, 500e3), "damping ratio": (0.0, 0.8)},
            held={"slack": 0.015}, mass=52.0, pulse="94", end=0.12, effort="quick",
        )
    )  # fmt: skip
    rows = page.locator(".calibrate table", has_text="95 % band").locator("tbody tr").all_inner_texts()
    assert [row.split("\t")[:2] for row in rows] == [[p.name, in_words(p.value, p.unit)] for p in expected.parameters]
    page.wait_for_timeout(300)
    other = watched.open("#" + page.url.partition("#")[2], wait=".calibrate .results")
    assert search_of(other).input_value() == "quick"
    for label in ("slack, held at, mm", "stiffness, from, kN/m", "Occupant’s mass, kg", "End of the fit, ms"):
        assert other.get_by_label(label).input_value() == page.get_by_label(label).input_value()
    other.get_by_label("slack, free").check()  # what was fitted is no longer what is chosen
    other.wait_for_selector(".calibrate .results", state="detached")
    other.get_by_label("stiffness, from, kN/m").fill("900")
    other.get_by_label("stiffness, from, kN/m").press("Enter")
    other.get_by_role("button", name="Calibrate", exact=True).click()
    other.wait_for_selector(".calibrate .refused:has-text('bounds')")


def test_a_fit_is_watched_and_cancelled_with_the_best_so_far(dropped: Page) -> None:
    page = dropped
    search_of(page).select_option("thorough")
    page.get_by_label("Occupant’s mass, kg").fill("77")
    page.get_by_role("button", name="Calibrate", exact=True).click()
    page.wait_for_selector(".calibrate progress")
    page.wait_for_selector(".calibrate [role=status]:has-text('searching')")
    assert page.get_by_role("combobox", name="Restraint").is_disabled()
    page.get_by_role("button", name="Cancel, keep the best so far").click()
    page.wait_for_selector(".calibrate [role=status]:has-text('the best so far')")
    assert "Interrupted" in page.locator(".calibrate .note").first.inner_text()
    assert page.get_by_role("button", name="Calibrate", exact=True).is_enabled()


def test_a_fit_that_is_gone_is_said(watched: Watched, dropped: Page) -> None:
    dropped.wait_for_timeout(300)
    address = "#" + dropped.url.partition("#")[2].partition("&fit=")[0]
    page = watched.open(address + '&fit={"key":"0123"}', wait=".calibrate .refused")
    assert "Start it again" in page.locator(".calibrate .refused").inner_text()
    for nonsense in ("{", "7", '{"mass":"x","bounds":[1],"held":{"a":null},"channel":7}'):
        again = watched.open(f"{address}&fit={nonsense}", wait=".calibrate table")
        assert again.get_by_label("Occupant’s mass, kg").input_value() == "78"


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_loose_table_is_a_test_too(watched: Watched, tmp_path: Path, suffix: str) -> None:
    table = tmp_path / f"sled 7{suffix}"
    write(sled_test(), table)
    page = watched.open("#/test", wait=SHOWN["test"])
    page.locator(".drop input").set_input_files(table)
    page.wait_for_selector("h2:has-text('sled 7')")
    assert page.locator(".chooser li").count() == 2
    page.get_by_role("button", name="CFC 180").click()
    page.wait_for_selector(".legend li:has-text('chest x')")
    assert page.get_by_role("button", name="Use as pulse").is_disabled()  # nothing says which channel is the vehicle's
    page.get_by_role("button", name="Calibrate against it").click()
    page.wait_for_selector(".calibrate table")
    page.get_by_label("Measured acceleration").select_option("chest x")
    assert page.get_by_label("Pulse of the vehicle").input_value() == "sled x"
    page.get_by_role("combobox", name="Restraint").select_option("spring and damper")
    search_of(page).select_option("quick")
    page.get_by_role("button", name="Calibrate", exact=True).click()
    page.wait_for_selector(".calibrate .results")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_accessibility_of_a_fit(watched: Watched, dropped: Page, scheme: str) -> None:
    from axe_playwright_python.sync_playwright import Axe  # noqa: PLC0415

    search_of(dropped).select_option("quick")
    dropped.get_by_role("button", name="Calibrate", exact=True).click()
    dropped.wait_for_selector(".calibrate .results")
    dropped.wait_for_timeout(300)
    page = watched.open("#" + dropped.url.partition("#")[2], wait=".calibrate .results", color_scheme=scheme)
    found = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"]})
    assert found.violations_count == 0, found.generate_report()
    phone = watched.open("#" + dropped.url.partition("#")[2], wait=".calibrate .results", color_scheme=scheme, viewport=PHONE)
    assert phone.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


def test_a_test_that_is_gone_is_said(watched: Watched) -> None:
    page = watched.open("#/test?test=0123456789&channel=1", wait=".refused")
    assert "Drop the file again" in page.locator(".refused").inner_text()


def test_a_scenario_of_ones_own_and_a_hostile_one(watched: Watched, tmp_path: Path) -> None:
    own, hostile = tmp_path / "own.toml", tmp_path / "hostile.toml"
    own.write_text(dump(substitute(load("p1"), {"adult.mass": 66.0})))
    hostile.write_text('[pulse]\nkind = "measured"\nfile = "/etc/passwd"\nchannels = "1"\n')
    page = watched.open()
    page.locator(".file input").set_input_files(own)
    page.wait_for_selector("#scenario option:has-text('your own file')", state="attached")
    page.wait_for_selector('[id="s-adult.mass"]')
    assert page.locator('[id="s-adult.mass"]').input_value() == "66"
    page.locator(".file input").set_input_files(hostile)
    page.wait_for_selector(".refused:has-text('no files are opened here')")


@pytest.mark.parametrize(
    ("name", "begins"),
    [("Scenario", "name ="), ("CSV", "time [s],"), ("ISO-MME", "PK"), ("HTML report", "<!doctype"), ("PDF report", "%PDF-1.7")],
)
def test_files_are_saved(watched: Watched, name: str, begins: str) -> None:
    page = watched.open("#/crash?s=p1&v.adult.mass=66")
    with page.expect_download() as waiting:
        page.locator(".actions").get_by_role("button", name=name, exact=True).click()
    assert Path(waiting.value.path()).read_bytes()[: len(begins)].decode("latin-1").lower() == begins.lower()


STUDY_DONE = ".study-head [role=status]:has-text('; done')"
FIGURES = {
    "sweep": ["Outcomes against each other", "Maps"],
    "sample": ["Distributions", "How often a limit is exceeded", "What the outcomes go with"],
    "sensitivity": ["Sensitivities", "What the outcomes go with"],
    "optimise": ["What was found", "Pareto front"],
    "box": ["What was found"],
    "bound": ["Limiting performance", "Numbers"],
    "rare": ["What was found"],
}
"""Of each kind of study, some headings that its figures and tables are under."""


def downloaded(page: Page, name: str) -> bytes:
    with page.expect_download() as waiting:
        page.get_by_role("link", name=name, exact=True).click()
    return Path(waiting.value.path()).read_bytes()


@pytest.mark.parametrize("kind", FIGURES)
def test_every_kind_of_study_is_started_watched_seen_and_downloaded(watched: Watched, kind: str) -> None:
    page = watched.open("#/study?s=sled-half-sine&v.adult.mass=70", wait=SHOWN["study"])
    page.get_by_role("radio", name=re.compile(f"^{kind} ")).check()
    page.wait_for_function("kind => document.querySelector('textarea').value.includes(`name = \"${kind}\"`)", arg=kind)
    assert 'mass = "70 kg"' in page.locator("textarea").input_value()  # the crash as the other views have it
    page.get_by_role("button", name="Start", exact=True).click()
    page.wait_for_selector(STUDY_DONE)
    for heading in FIGURES[kind]:
        page.wait_for_selector(f".study-part h3:has-text('{heading}')")
    drawn = page.locator(".drawn img")
    assert drawn.count() >= (0 if kind in {"box", "rare"} else 1)
    assert drawn.evaluate_all("all => all.every((one) => one.complete && one.naturalWidth > 0 && one.alt.length > 40)")
    assert page.locator(".study-part table tbody tr").count() >= 1
    assert downloaded(page, "Download Parquet")[:4] == b"PAR1"
    html = downloaded(page, "HTML report").decode()
    assert html.count("data:image/svg") == drawn.count()
    assert downloaded(page, "PDF report")[:8] == b"%PDF-1.7"
    page.wait_for_url(re.compile("study="))
    other = watched.open("#" + page.url.partition("#")[2], wait=".study-part table")  # the address has the study
    assert other.locator(".study-part h3").all_inner_texts() == page.locator(".study-part h3").all_inner_texts()


LONG_SWEEP = """kind = "sweep"
name = "long"
scenario = "p1"
outcomes = ["adult.clip_3ms", "adult.acceleration.peak"]
parameters = [
    { path = "adult.restraint.stiffness", grid = { start = "40 kN/m", stop = "120 kN/m", count = 400 } },
    { path = "vehicle1.speed", grid = { start = "30 km/h", stop = "64 km/h", count = 320 } },
]
"""
LONG_SEARCH = """kind = "optimise"
name = "search"
scenario = "p1"
parameters = [
    { path = "adult.restraint.stiffness", range = ["40 kN/m", "120 kN/m"] },
    { path = "adult.restraint.slack", range = ["0 mm", "60 mm"] },
]
[optimise]
candidates = 1000
generations = 400
objectives = [{ outcome = "adult.acceleration.peak" }, { outcome = "adult.excursion.max" }]
"""


@pytest.mark.parametrize(("text", "stopped"), [(LONG_SWEEP, ".drawn img"), (LONG_SEARCH, "text=a search that has not ended")])
def test_a_study_is_cancelled_and_resumed(watched: Watched, text: str, stopped: str) -> None:
    page = watched.open("#/study?s=p1", wait=SHOWN["study"])
    page.locator("textarea").fill(text)
    page.get_by_role("button", name="Start", exact=True).click()
    page.wait_for_selector("[aria-label='The study that runs'] :text('rows a second')")
    page.get_by_role("button", name="New study").click()
    page.wait_for_selector("text=Another study runs")
    assert page.get_by_role("button", name="Start", exact=True).is_disabled()
    page.locator(".kept button").first.click()
    page.get_by_role("button", name="Cancel").click()
    page.wait_for_selector("text=cancelled; what is done is kept")
    assert "stopped" in page.locator(".kept button").first.inner_text()
    page.wait_for_selector(stopped)  # of what there is, figures where they mean something
    page.get_by_role("button", name="Resume").click()
    if text == LONG_SWEEP:
        page.wait_for_selector(STUDY_DONE)
        page.wait_for_selector(".drawn img")
    else:  # it would go on for a minute
        page.wait_for_selector("[aria-label='The study that runs'] :text('rows a second')")
        page.get_by_role("button", name="Cancel").click()
        page.wait_for_selector("text=cancelled; what is done is kept")


def test_a_study_that_cannot_be_is_said(watched: Watched) -> None:
    page = watched.open("#/study", wait=SHOWN["study"])
    page.locator("textarea").fill('kind = "sweep"\nscenario = "/etc/passwd"')
    page.get_by_role("button", name="Start", exact=True).click()
    page.wait_for_selector(".study-new .refused")
    page.get_by_role("button", name="As it was").click()
    assert "example-offset" in page.locator("textarea").input_value()
    gone = watched.open("#/study?study=nothing-123", wait=".refused")
    assert "no study nothing-123" in gone.locator(".refused").inner_text()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_study_with_its_figures_is_accessible(watched: Watched, scheme: str) -> None:
    from axe_playwright_python.sync_playwright import Axe  # noqa: PLC0415

    with watched.server.socket() as socket:
        text = socket.ask("study-file", lane="study-file", scenario="sled-half-sine", study="bound")["toml"]
        name = socket.ask("study", lane="study", action="start", toml=text)["running"]["name"]
        while not socket.ask("study", lane="study", action="list")["running"]["ended"]:
            pass
    page = watched.open(f"#/study?study={name}", wait=".drawn img", color_scheme=scheme)
    found = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"]})
    assert found.violations_count == 0, found.generate_report()
    page.set_viewport_size(PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    ground = page.locator(".drawn img").first.get_attribute("src") or ""
    assert ("%23181f29" in ground) == (scheme == "dark")  # drawn on the card's own ground


def test_it_goes_on_when_the_server_comes_back(browser: Browser) -> None:
    with sockets.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    context = browser.new_context()
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    with running("--port", str(port)) as server:
        page.goto(f"{server.address}/#/crash?s=p1")
        page.wait_for_selector(f"{READY} >> visible=true")
        page.wait_for_selector(".results table")
    page.wait_for_selector(".status.lost")
    slide(page, "adult.mass", 100.0)  # asked for while nobody answers
    with running("--port", str(port)):
        page.wait_for_selector(READY)
        settled(page)
        response = simulate(substitute(load("p1"), {"adult.mass": 100.0}))
        said = page.locator(".plot [role=img]").first.get_attribute("aria-label") or ""
        assert f"adult −{abs(response.peak('adult.acceleration').value) / G:.1f} g" in said
    context.close()


def test_a_cold_start_is_said(browser: Browser, tmp_path: Path) -> None:
    with running("--port", "0", environment={"RIDEDOWN_CACHE_DIR": str(tmp_path)}) as server:
        context = browser.new_context()
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.goto(server.address)
        page.wait_for_selector(".banner:has-text('being compiled')")
        context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("view", VIEWS)
def test_accessibility(watched: Watched, view: str, scheme: str) -> None:
    from axe_playwright_python.sync_playwright import Axe  # noqa: PLC0415

    page = watched.open(f"#/{view}?s=example-restraints&t=0.07", wait=SHOWN[view], color_scheme=scheme)
    found = Axe().run(page, options={"runOnly": ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"]})
    assert found.violations_count == 0, found.generate_report()


@pytest.mark.parametrize("view", VIEWS)
def test_phone_width(watched: Watched, view: str) -> None:
    page = watched.open(f"#/{view}", wait=SHOWN[view], viewport=PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


def test_themes(watched: Watched) -> None:
    page = watched.open()
    paper = "getComputedStyle(document.body).backgroundColor"
    system = page.evaluate(paper)
    page.get_by_role("button", name="Theme").click()
    page.get_by_role("button", name="Theme").click()
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    assert page.evaluate(paper) != system
    page.reload()
    page.wait_for_selector(READY)
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"


def test_with_the_keyboard_alone(watched: Watched) -> None:
    page = watched.open()
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "To the content"
    reached = set()
    for _ in range(90):
        page.keyboard.press("Tab")
        reached.add(
            page.evaluate("document.activeElement.id || document.activeElement.ariaLabel || document.activeElement.textContent")
        )
    assert {"Map", "scenario", "s-vehicle1.mass", "s-bar.overlap", "Pin this run", "Time"} <= reached
    page.locator('[id="s-vehicle1.mass"]').focus()
    before = page.url
    page.keyboard.press("ArrowRight")
    settled(page)
    assert page.url != before
