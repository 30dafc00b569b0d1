from __future__ import annotations

from html.parser import HTMLParser

import pytest

from ridedown.report import summary
from ridedown.report.figures import plots
from ridedown.report.run import html
from ridedown.report.tables import NONE, Column, Table, number
from ridedown.scenario import load
from ridedown.simulation import simulate

VOID = {"meta", "link", "img", "br"}


class Page(HTMLParser):
    """Checks that tags close in order, and collects what a page points to and what describes its images."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.targets: list[str] = []
        self.alts: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.scopes: list[str] = []
        self.lang = ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        if tag not in VOID:
            self.open.append(tag)
        if tag == "html":
            self.lang = values["lang"]
        if tag == "img":
            self.alts.append(values["alt"])
        if tag == "th":
            self.scopes.append(values["scope"])
        if "id" in values:
            self.ids.append(values["id"])
        for key in ("src", "href"):
            if key in values:
                (self.links if values[key].startswith("#") else self.targets).append(values[key])

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture(scope="module", params=["p1", "example-wall", "navigator-neon", "marzbanrad-5"])
def response(request):
    return simulate(load(request.param))


def test_the_page_stands_alone_and_is_accessible(response):
    drawn = plots(response)
    text = html(response, drawn)
    page = Page(text)
    assert page.lang == "en"
    assert all(target.startswith("data:") for target in page.targets)
    assert "url(" not in text
    assert "@import" not in text
    assert len(page.alts) == len(drawn)
    assert all(len(alt) > 20 for alt in page.alts)
    assert {link.removeprefix("#") for link in page.links} <= set(page.ids)
    assert len(set(page.ids)) == len(page.ids)
    assert set(page.scopes) == {"col", "row"}
    for source in response.sources:
        assert source.confidence in text


def test_figures_name_their_axes_and_units(response):
    for plot in plots(response):
        (axes,) = plot.figure.axes
        assert "," in axes.get_ylabel()
        assert axes.get_xlabel() in {"time, ms", "deflection, mm"}
        assert axes.lines
        assert plot.svg.startswith(b"<?xml")


def test_the_same_run_gives_the_same_bytes():
    crash = load("paper-adult-full")
    first, second = (simulate(crash) for _ in range(2))
    assert html(first, plots(first)) == html(second, plots(second))


def test_what_the_user_wrote_is_escaped():
    wall = load("example-wall").model_copy(update={"name": "<script>alert(1)</script>", "description": 'a "b" & <c>'})
    crash = simulate(wall)
    text = html(crash, plots(crash))
    assert "<script>" not in text
    assert "&lt;script&gt;" in text


def test_tables_agree_with_the_response(response):
    for name, result in response.vehicles.items():
        row = next(row for row in summary.vehicles(response).rows if row[0] == name)
        assert row[4] == number(result.peak_acceleration.value / 9.80665)
    events = summary.events(response)
    assert [row[0] for row in events.rows] == [str(i) for i in range(1, len(response.events) + 1)]


def test_columns_in_which_no_row_has_anything_are_left_out():
    table = Table("", (Column("a"), Column("b"), Column("c")), (("1", NONE, "2"), ("3", NONE, NONE)))
    assert table.without_empty_columns() == Table("", (Column("a"), Column("c")), (("1", "2"), ("3", NONE)))
