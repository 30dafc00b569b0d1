"""A run as a folder of files: one HTML page, figures, channels, the scenario as read."""

from __future__ import annotations

from pathlib import Path

from ridedown.report import summary
from ridedown.report.figures import plots
from ridedown.report.jsontext import json_text
from ridedown.report.page import render
from ridedown.report.style import Plot
from ridedown.response import Response
from ridedown.scenario import dump


def write(response: Response, folder: Path) -> None:
    """Write page, figures, channels (CSV, Parquet), summary (JSON) and scenario (TOML) into an existing folder."""
    drawn = plots(response)
    for plot in drawn:
        (folder / f"{plot.name}.svg").write_bytes(plot.svg)
    (folder / "index.html").write_text(html(response, drawn), encoding="utf-8")
    (folder / "summary.json").write_text(json_text(summary.run_data(response)) + "\n", encoding="utf-8")
    (folder / "scenario.toml").write_text(dump(response.scenario), encoding="utf-8")
    response.to_csv(folder / "channels.csv")
    response.to_parquet(folder / "channels.parquet")


def html(response: Response, drawn: tuple[Plot, ...]) -> str:
    """The page of a run."""
    return render(
        "ridedown.report",
        "run.html",
        title=response.scenario.name or "A crash",
        description=response.scenario.description,
        status=f"{1e3 * response.end_time:g} ms simulated, {len(response.events)} events; g = {summary.G} m/s²",
        notes=summary.notes(response),
        results=summary.result_tables(response),
        plots=drawn,
        events=summary.events(response),
        sources=summary.sources(response),
        scenario=dump(response.scenario),
    )
