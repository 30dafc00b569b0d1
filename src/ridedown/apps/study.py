"""Design studies: run, shown as they go, and asked by SQL."""

from __future__ import annotations

import io
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any, Self

import pyarrow as pa
import pyarrow.csv
import typer

from ridedown.apps import show
from ridedown.criteria import STANDARD_GRAVITY
from ridedown.errors import InvalidInput
from ridedown.report.tables import Column, Table
from ridedown.studies.file.study import LoadedStudy, load_study
from ridedown.studies.results.findings import kept_bound
from ridedown.studies.results.sql import query as rows_for
from ridedown.studies.results.summary import summary_of
from ridedown.studies.rows.plan import plan_of
from ridedown.studies.running.execution import Progress, Stopped, run_plan

_EVERY = 10.0
"""s between two lines of progress, where there is no terminal to draw on."""

_SHOWN = 1000
"""Rows of a query that a table on the screen has at most."""


def study(
    file: str,
    out: Path | None,
    *,
    resume: bool,
    cluster: str | None,
    threads: int | None,
    as_json: bool,
    compile_if_cold: Callable[[], None],
) -> bool:
    """Run a study and print what it comes to; whether it came to its end. Raises: InvalidInput, UnknownName."""
    loaded = load_study(file)
    plan = plan_of(loaded)
    folder = Path(f"{Path(file).stem}-results") if out is None else out
    compile_if_cold()
    try:
        with _terminated_as_interrupted(), _Shown(plan.rows) as shown:
            run_plan(loaded, plan, folder, resume=resume, threads=threads, cluster=cluster, report=shown)
    except Stopped as stopped:
        done = stopped.progress.before + stopped.progress.done
        of = "" if loaded.searches else f" of {plan.rows:,}"  # how many a search asks for is known at its end
        typer.echo(f"ridedown: stopped with {done:,}{of} rows kept in {folder}. {_how_to_go_on(file, out)}", err=True)
        return False
    summary = summary_of(folder)
    _write_page(loaded, folder, summary)
    if as_json:
        show.as_json(summary)
    else:
        _show(loaded, summary, folder)
    failed = sum(one["rows"] for one in summary["failed"])
    if failed == summary["rows"]:
        typer.echo(f"ridedown: all {failed:,} rows failed: {summary['failed'][0]['why']}.", err=True)
    return bool(failed < summary["rows"])


def _write_page(loaded: LoadedStudy, folder: Path, summary: dict[str, Any]) -> None:
    from ridedown.report.study import page_of  # noqa: PLC0415  draws, which takes a second to load

    try:
        page_of(loaded, folder, summary).write(folder)
    except OSError as error:
        raise InvalidInput(
            f"{folder}: got a page that cannot be written ({error.strerror}); need room. The rows are kept."
        ) from None


def query(folder: Path, sql: str, *, as_json: bool, as_csv: bool) -> None:
    """Print what SQL says of the results in a folder. Raises: InvalidInput."""
    if as_json and as_csv:
        raise InvalidInput("--csv: got --json and --csv; need one of them. Take one out.")
    found = rows_for(folder, sql)
    if as_json:
        show.as_json(found.to_pylist())
    elif as_csv:
        sink = io.BytesIO()
        pyarrow.csv.write_csv(found, sink)
        typer.echo(sink.getvalue().decode(), nl=False)
    else:
        _table(found)


def _table(found: pa.Table) -> None:
    numeric = [pa.types.is_floating(field.type) or pa.types.is_integer(field.type) for field in found.schema]
    columns = tuple(Column(name, numeric=number) for name, number in zip(found.column_names, numeric, strict=True))
    rows = tuple(tuple(_cell(value) for value in row.values()) for row in found.slice(0, _SHOWN).to_pylist())
    show.tables(Table(f"{found.num_rows:,} rows" if found.num_rows != 1 else "1 row", columns, rows))
    if not rows:
        show.note("No rows.")
    if found.num_rows > _SHOWN:
        show.note(f"The first {_SHOWN:,} of {found.num_rows:,} rows; --csv prints all.")


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _show(loaded: LoadedStudy, summary: dict[str, Any], folder: Path) -> None:
    study = loaded.study
    show.note(f"{study.name or 'A study'}. {study.description}".strip())
    for remark in summary["remarks"]:
        show.note(remark)
    show.console().print()
    if study.bound is not None:
        _show_bound(loaded, folder)
    elif loaded.searches:
        _show_found(folder, summary)
    else:
        _show_rows(summary)
    show.note(f'Kept in {folder}: ridedown query {folder} "SELECT * FROM results LIMIT 5"')


def _show_rows(summary: dict[str, Any]) -> None:
    """Print the reach of every outcome, and what the study says."""
    from ridedown.report.study_tables import number_tables, sensitivity_tables  # noqa: PLC0415  draws, which takes a second to load

    show.tables(*number_tables(summary), *sensitivity_tables(summary))


def _show_bound(loaded: LoadedStudy, folder: Path) -> None:
    """Print the least peaks, and the designs beside them."""
    from ridedown.report import study_bound  # noqa: PLC0415  draws, which takes a second to load

    found = kept_bound(loaded, folder)
    show.tables(study_bound.curve_table(found), study_bound.table(found))
    parts = study_bound.history_in_words(found.ideal)
    show.note(f"The ideal restraint within {1e3 * found.ideal.excursion:.0f} mm has {found.ideal.peak_g:.2f} g: {parts}.")
    if said := study_bound.beside_in_words(found):
        show.note(said)
    if found.olc is not None:
        show.note(f"OLC of the pulse: {found.olc / STANDARD_GRAVITY:.2f} g.")


def _show_found(folder: Path, summary: dict[str, Any]) -> None:
    """Print what a search found."""
    from ridedown.report.study_found import Found  # noqa: PLC0415  draws, which takes a second to load
    from ridedown.report.study_tables import failed_table  # noqa: PLC0415

    found = Found(folder)
    show.tables(*found.tables, failed_table(summary))
    for note in found.notes:
        show.note(note)


def _how_to_go_on(file: str, out: Path | None) -> str:
    return f"To go on: ridedown study {file}{'' if out is None else f' --out {out}'} --resume"


@contextmanager
def _terminated_as_interrupted() -> Iterator[None]:
    """Take a polite request to end, as batch systems send before they kill, for Ctrl-C; of either say that it was heard.

    Chunks that are begun are ended and kept: with many criteria that takes some seconds.
    """
    heard = False

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        nonlocal heard
        if not heard:
            heard = True
            typer.echo("ridedown: stopping once what is begun is kept; Ctrl-C once more stops at once", err=True)
        raise KeyboardInterrupt

    numbers = [signal.SIGTERM]
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not where it is ignored, as in the background
        numbers.append(signal.SIGINT)
    before = {number: signal.signal(number, interrupt) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class _Shown:
    """Progress on stderr: a bar on a terminal, else a line now and then."""

    def __init__(self, rows: int) -> None:
        self.rows = rows
        self.began = self.said = time.monotonic()
        self.bar: Any = None

    def __enter__(self) -> Self:
        if sys.stderr.isatty():
            self.bar = show.rows_bar(self.rows)
            self.bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.stop()

    def __call__(self, progress: Progress) -> None:
        words = self._words(progress)
        if self.bar is not None:
            self.bar.update(self.bar.task_ids[0], completed=progress.before + progress.done, description=words)
        elif time.monotonic() - self.said >= _EVERY:
            self.said = time.monotonic()
            typer.echo(f"{progress.before + progress.done:,} of {self.rows:,} rows; {words}", err=True)

    def _words(self, progress: Progress) -> str:
        seconds = time.monotonic() - self.began
        rate = progress.done / seconds if seconds > 0.0 else 0.0
        left = progress.rows - progress.before - progress.done
        ahead = f", {_spoken(left / rate)} left" if rate > 0.0 and left else ""
        return f"{rate:,.0f} rows a second{ahead}, {progress.failed:,} failed"


def _spoken(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {rest:02} s" if minutes else f"{rest} s"
