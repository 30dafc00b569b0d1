"""A run as a folder of files: one HTML page, the same as PDF, figures, channels, the scenario as read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from ridedown.report import summary
from ridedown.report.figures import plots
from ridedown.report.jsontext import json_text
from ridedown.report.page import render
from ridedown.report.pdf import Document, Part
from ridedown.report.pdf import pdf as set_on_paper
from ridedown.report.style import Plot
from ridedown.response import Response
from ridedown.scenario import dump

_MOST_EVENTS = 500
"""On paper: ten pages. The HTML page has all."""


def write(response: Response, folder: Path) -> None:
    """Write page, PDF, figures, channels (CSV, Parquet), summary (JSON) and scenario (TOML) into an existing folder."""
    drawn = plots(response)
    for plot in drawn:
        (folder / f"{plot.name}.svg").write_bytes(plot.svg)
    (folder / "index.html").write_text(html(response, drawn), encoding="utf-8")
    (folder / "report.pdf").write_bytes(pdf(response, drawn))
    (folder / "summary.json").write_text(json_text(summary.run_data(response)) + "\n", encoding="utf-8")
    (folder / "scenario.toml").write_text(dump(response.scenario), encoding="utf-8")
    response.to_csv(folder / "channels.csv")
    response.to_parquet(folder / "channels.parquet")


def html(response: Response, drawn: tuple[Plot, ...]) -> str:
    """The page of a run."""
    return render(
        "ridedown.report",
        "run.html",
        title=_title(response),
        description=response.scenario.description,
        status=_status(response),
        notes=summary.notes(response),
        results=summary.result_tables(response),
        plots=drawn,
        events=summary.events(response),
        sources=summary.sources(response),
        scenario=dump(response.scenario),
    )


def pdf(response: Response, drawn: tuple[Plot, ...]) -> bytes:
    """The same on paper, A4."""
    events = summary.events(response)
    shown = replace(events, rows=events.rows[:_MOST_EVENTS])
    cut = f"The first {_MOST_EVENTS:,} of {len(events.rows):,}; the HTML page has all." if shown != events else ""
    numbered = "Numbers above a figure are those of the events in the table below it. A braking body has negative acceleration."
    parts = (
        Part("Results", tables=summary.result_tables(response)),
        Part("Figures", words=(numbered,), plots=drawn),
        Part("Events", words=(cut,) if cut else (), tables=(shown,)),
        Part("Sources", tables=(summary.sources(response),)),
        Part("Scenario", text=dump(response.scenario)),
    )
    return set_on_paper(
        Document(_title(response), response.scenario.description, _status(response), summary.notes(response), parts)
    )


def _title(response: Response) -> str:
    return response.scenario.name or "A crash"


def _status(response: Response) -> str:
    return f"{1e3 * response.end_time:g} ms simulated, {len(response.events)} events; g = {summary.G} m/s²"
