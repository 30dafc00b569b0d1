"""The criteria of a measured test as a folder of files: one HTML page, the same as PDF, figures, and the numbers as JSON."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ridedown.limits import Assessment, CrashCriteria, Evidence, criteria_of, evidence
from ridedown.report import criteria_channels
from ridedown.report import criteria_tables as tables
from ridedown.report.jsontext import json_text
from ridedown.report.page import render
from ridedown.report.pdf import Document, Part
from ridedown.report.pdf import pdf as set_on_paper
from ridedown.report.style import Plot
from ridedown.report.tables import Table
from ridedown.signals.record import TestRecord


class CriteriaReport:
    """What the criteria of a test come to, computed once for the terminal, the JSON and the page."""

    def __init__(self, record: TestRecord) -> None:
        self.record = record
        self.have: Evidence = evidence(record)
        self.found: CrashCriteria = criteria_of(self.have)

    @cached_property
    def channels(self) -> criteria_channels.Channels:
        """Every channel's peaks, or why it could not be used."""
        return criteria_channels.channels_of(self.record)

    @cached_property
    def assessments(self) -> tuple[Assessment, ...]:
        """The test before the regulations that find anything to judge in it."""
        return tables.verdicts(self.have)

    @property
    def title(self) -> str:
        """What was tested."""
        return self.found.title or "A test"

    @property
    def description(self) -> str:
        """Where it comes from: date, laboratory, format."""
        record = self.record
        parts = (record.date.isoformat() if record.date else "", record.laboratory, record.format)
        return ", ".join(part for part in parts if part)

    @property
    def tables(self) -> tuple[Table, ...]:
        """The criteria in the order to read them in: occupants, vehicles, what could not be computed."""
        made = (
            *(tables.occupant_table(occupant, self.found) for occupant in self.found.occupants),
            tables.vehicle_table(self.found),
            tables.missing_table(self.found),
        )
        return tuple(table for table in made if table.rows)

    @property
    def channel_tables(self) -> tuple[Table, Table]:
        """The channels that could not be used, and the peaks of the others."""
        return criteria_channels.unusable_table(self.channels), criteria_channels.peaks_table(self.channels)

    @property
    def notes(self) -> tuple[str, ...]:
        """What was found wrong with the files, and how each pulse was made."""
        found = self.found
        problems = (f"{problem.rstrip('.')}." for problem in self.record.problems)
        return (*problems, *tables.occupant_notes(found), *tables.pulse_notes(found))

    def as_json(self) -> dict[str, Any]:
        """Everything as plain data for JSON."""
        return tables.as_json(self.found, self.channels, self.assessments, self.record.problems)


SIGNS = (
    "Signs as in SAE J211: x forward, a braking car negative. Channels are filtered to the class that SAE J211 names for their "
    "place. Differences are ours less the official value."
)
CAUTION = (
    "Check the text in force before you rely on a verdict: limits and clauses are as ridedown knows them, some from memory."
)


@dataclass(frozen=True, slots=True)
class _Section:
    """Part of the page: an anchor, a heading, a table, figures."""

    anchor: str
    title: str
    table: Table
    plots: tuple[Plot, ...]


def write(report: CriteriaReport, folder: Path) -> None:
    """Write the page, the same as PDF, each figure and `criteria.json` into an existing folder."""
    sections = _sections(report)
    for section in sections:
        for plot in section.plots:
            (folder / f"{plot.name}.svg").write_bytes(plot.svg)
    (folder / "index.html").write_text(_html(report, sections), encoding="utf-8")
    (folder / "report.pdf").write_bytes(_pdf(report, sections))
    (folder / "criteria.json").write_text(json_text(report.as_json()) + "\n", encoding="utf-8")


def html(report: CriteriaReport) -> str:
    """The page of a test."""
    return _html(report, _sections(report))


def _html(report: CriteriaReport, sections: tuple[_Section, ...]) -> str:
    missing = tables.missing_table(report.found)
    return render(
        "ridedown.report",
        "criteria.html",
        title=report.title,
        description=report.description,
        signs=SIGNS,
        caution=CAUTION,
        sections=sections,
        verdicts=tables.verdict_tables(report.assessments),
        missing=[missing] if missing.rows else [],
        channels=[table for table in report.channel_tables if table.rows],
        notes=report.notes,
    )


def pdf(report: CriteriaReport) -> bytes:
    """The same on paper, A4: the numbers first, what was found wrong with the files last."""
    return _pdf(report, _sections(report))


def _pdf(report: CriteriaReport, sections: tuple[_Section, ...]) -> bytes:
    missing = tables.missing_table(report.found)
    parts = (
        Part("Criteria", tables=tuple(one.table for one in sections if one.table.rows)),
        Part("Regulations", (CAUTION,) if report.assessments else (), tables.verdict_tables(report.assessments)),
        Part("Figures", plots=tuple(plot for one in sections for plot in one.plots)),
        Part("Not computed", tables=(missing,) if missing.rows else ()),
        Part("Channels", tables=tuple(table for table in report.channel_tables if table.rows)),
        Part("Notes", words=report.notes),
    )
    shown = tuple(part for part in parts if part.words or part.tables or part.plots)
    return set_on_paper(Document(report.title, report.description, SIGNS, (), shown))


def _sections(report: CriteriaReport) -> tuple[_Section, ...]:
    from ridedown.report.criteria_figures import occupant_plots, vehicle_plots  # noqa: PLC0415  draws, which JSON needs not

    have, found = report.have, report.found
    vehicles = tuple(plot for vehicle in found.vehicles for plot in vehicle_plots(have, vehicle))
    made = [_Section("vehicles", "Vehicles", tables.vehicle_table(found), vehicles)]
    for number, occupant in enumerate(found.occupants, 1):
        table = tables.occupant_table(occupant, found)
        plots = occupant_plots(have, occupant, tables.occupant_name(occupant, found))
        made.append(_Section(f"occupant-{number}", table.caption, table, plots))
    return tuple(section for section in made if section.table.rows or section.plots)
