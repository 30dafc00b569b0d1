"""Showing things in a terminal: tables and JSON on stdout, progress on stderr.

What a plain run does not show is imported where it is shown.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import typer
from rich import box
from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

from ridedown import catalogue
from ridedown.report import summary
from ridedown.report.jsontext import json_text
from ridedown.report.tables import Column, Table
from ridedown.response import Response

if TYPE_CHECKING:
    from rich.progress import Progress

    from ridedown.report.criteria import CriteriaReport

_EVENTS_SHOWN = 40
_PIPE_WIDTH = 120
"""Columns where the output is no terminal and so has no width of its own."""
_UNBOUND = 10_000


def console(*, stderr: bool = False) -> Console:
    """A console on stdout or stderr; without colours or markup of its own in the text it is given."""
    stream = sys.stderr if stderr else sys.stdout
    return Console(stderr=stderr, highlight=False, markup=False, width=None if stream.isatty() else _PIPE_WIDTH)


@contextmanager
def working(what: str) -> Iterator[None]:
    """Say on stderr what is going on, while it is."""
    with console(stderr=True).status(Text(what)):
        yield


@contextmanager
def progress(what: str, steps: int) -> Iterator[Callable[[str], None]]:
    """A progress bar on stderr; call what it yields with the name of each step done."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn  # noqa: PLC0415

    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=steps)
        yield lambda step: bar.update(task, advance=1, description=step)


@contextmanager
def searching(what: str) -> Iterator[Callable[[str, int, float], None]]:
    """Say on stderr how a search goes: call what it yields with what is done, candidates tried and the least misfit."""
    with console(stderr=True).status(Text(what)) as status:
        yield lambda stage, tried, best: status.update(
            Text(f"{what}: {stage}, {tried} candidates{f', misfit {best:.4g}' if math.isfinite(best) else ''}; Ctrl-C ends it")
        )


def rows_bar(rows: int) -> Progress:
    """A bar on stderr for so many rows, with one task; start and stop it."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn  # noqa: PLC0415

    bar = Progress(
        BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}"), console=console(stderr=True), transient=True
    )
    bar.add_task("", total=rows)
    return bar


def catalogue_list() -> None:
    """Print every entry of the catalogue: name, how sure its numbers are, what it is."""
    from ridedown.studies.file.study import load_study  # noqa: PLC0415  a fifth of a second that only this list needs

    entries = [catalogue.entry(name) for name in catalogue.names()]
    columns = (Column("Name", numeric=False), Column("Confidence", numeric=False), Column("What", numeric=False))
    rows = tuple((entry.name, entry.confidence, entry.description) for entry in entries)
    tables(Table(f"{len(rows)} published scenarios and examples", columns, rows))
    studies = tuple((name, load_study(name).study.description) for name in catalogue.studies())
    tables(Table(f"{len(studies)} studies", (Column("Name", numeric=False), Column("What", numeric=False)), studies))
    note("ridedown catalogue NAME prints one; ridedown run NAME simulates a scenario, ridedown study NAME runs a study.")


def as_json(value: Any) -> None:
    """Print as JSON."""
    typer.echo(json_text(value))


def run_summary(response: Response) -> None:
    """Print what a run comes to."""
    scenario = response.scenario
    note(f"{scenario.name or 'A crash'}. {scenario.description}".strip())
    for text in summary.notes(response):
        note(text)
    console().print()
    events, sources = summary.events(response), summary.sources(response)
    shown = events.rows[:_EVENTS_SHOWN]
    if len(shown) < len(events.rows):
        events = Table(f"The first {len(shown)} of {len(events.rows)} events", events.columns, shown)
    tables(
        *summary.result_tables(response),
        events,
        Table(sources.caption, sources.columns[:2], tuple(r[:2] for r in sources.rows)),
    )


def criteria(report: CriteriaReport) -> None:
    """Print what the criteria of a test come to."""
    from ridedown.report import criteria_tables  # noqa: PLC0415

    note(report.title)
    if report.description:
        note(report.description)
    console().print()
    tables(*report.tables)
    tables(*criteria_tables.verdict_tables(report.assessments), upright_only=True)
    tables(*report.channel_tables)
    for text in report.notes:
        note(text)


def note(text: str) -> None:
    """Print a line below the tables."""
    console().print(Text(text), soft_wrap=not sys.stdout.isatty())


def tables(*shown: Table, upright_only: bool = False) -> None:
    """Print tables, leaving out those with no row; wide ones of few rows on their side, unless they are of sentences."""
    out = console()
    for table in shown:
        if table.rows:
            upright = _rich(table)
            # results by body are wide and few: better on their side than squeezed
            turn = not upright_only and len(table.rows) < len(table.columns) and _width(upright, out) > out.width
            out.print(_rich(table.turned()) if turn else upright)
            out.print()


def _width(table: RichTable, out: Console) -> int:
    """Columns that a table takes where nothing holds it in."""
    return out.measure(table, options=out.options.update(max_width=_UNBOUND)).maximum


def _rich(table: Table) -> RichTable:
    made = RichTable(title=Text(table.caption), title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
    for column in table.columns:
        title = f"{column.title}\n{column.unit}" if column.unit else column.title
        made.add_column(Text(title), justify="right" if column.numeric else "left", overflow="fold")
    for row in table.rows:
        made.add_row(*(Text(cell) for cell in row))
    return made
