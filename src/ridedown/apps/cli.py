"""The command line: parse, call, show.

Everything that takes time to import is imported inside the command that needs it, so that `ridedown --help` answers
at once.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ridedown import __version__
from ridedown.errors import RidedownError

if TYPE_CHECKING:
    from ridedown.report.criteria import CriteriaReport
    from ridedown.response import Response
    from ridedown.studies.extraction.extract import Extraction

BAD_INPUT, STOPPED = 2, 3
"""Exit codes: something given cannot be used; the simulation, or a search, was stopped before its end."""

app = typer.Typer(
    name="ridedown",
    help="Head-on crashes solved event by event: vehicles, adults, and children in child seats.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,  # plain help: rich alone would take most of its time
    pretty_exceptions_enable=False,
)

Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")]
Out = Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Also write files to this folder.")]


def main() -> None:
    """Run the command line; the console script's entry point."""
    # Matrices are small here: further threads of linear algebra only wait for one another, and double the work of a fit.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")  # a terminal that cannot show a minus sign is no reason to stop
    app(prog_name="ridedown")


def _print_version(wanted: bool) -> None:  # noqa: FBT001  typer's callback
    if wanted:
        typer.echo(f"ridedown {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    _version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Take the options that belong to no command."""


@app.command()
def run(
    scenario: Annotated[str, typer.Argument(metavar="FILE-OR-NAME", help="A TOML or YAML file, or a catalogue name.")],
    as_json: Json = False,
    out: Out = None,
) -> None:
    """Simulate one scenario.

    Prints a summary: vehicles, occupants, energy, events, sources. With --out also writes an HTML
    page, figures and channels.
    """
    with _plain_errors():
        from ridedown.apps.output import check_folder
        from ridedown.scenario import load

        if out is not None:
            check_folder(out)
        loaded = load(scenario)

        # after what can be wrong with the input, for these take most of the time
        from ridedown.apps import show
        from ridedown.report.summary import run_data
        from ridedown.simulation import simulate

        _compile_if_cold()
        with show.working("simulating"):
            response = simulate(loaded, throw=False)
        if out is not None:
            _write_run(response, out)
        if as_json:
            show.as_json(run_data(response))
        else:
            show.run_summary(response)
            _say_written(out)
        if not response.completed:
            typer.echo(f"ridedown: stopped at {1e3 * response.end_time:.3f} ms: {response.status.sentence}.", err=True)
            raise typer.Exit(STOPPED)


@app.command()
def criteria(
    path: Annotated[
        str, typer.Argument(metavar="PATH", help="A test: NHTSA EV5 or ISO-MME (folder, zip), CSV, TSV or Parquet.")
    ],
    as_json: Json = False,
    out: Out = None,
) -> None:
    """Judge a measured crash test.

    Prints every criterion that its channels allow, beside the official results, verdicts, and the
    peaks of every channel. With --out also writes an HTML page with figures, and the same as PDF.
    """
    with _plain_errors():
        from ridedown.apps.measured import record_at
        from ridedown.apps.output import check_folder

        if out is not None:
            check_folder(out)
        record = record_at(path)

        from ridedown.apps import show
        from ridedown.apps.uncompiled import of_all_criteria
        from ridedown.report.criteria import CriteriaReport

        _compile(of_all_criteria(), "the criteria", "a few seconds")
        with show.working("computing the criteria"):
            report = CriteriaReport(record)
            data = report.as_json()
        if out is not None:
            _write_criteria(report, out)
        if as_json:
            show.as_json(data)
        else:
            show.criteria(report)
            _say_written(out)


@app.command()
def convert(
    source: Annotated[str, typer.Argument(metavar="IN", help="A test in any format, or a scenario (file or catalogue name).")],
    target: Annotated[str, typer.Argument(metavar="OUT", help="*.csv, *.tsv, *.parquet, or ISO-MME: *.zip or a folder.")],
) -> None:
    """Write a test, or a simulated crash, in another format.

    The name of OUT tells the format. Channels without a curve are left out, and said.
    """
    with _plain_errors():
        from ridedown.apps.convert import convert as converted

        done = converted(source, target, _simulated)
        if done.without_curve:
            typer.echo(f"ridedown: {done.without_curve} channels have no curve to read and are left out.", err=True)
        for sentence in done.remarks:
            typer.echo(f"ridedown: {' '.join(sentence.split())}", err=True)
        typer.echo(str(done))


@app.command()
def pulse(
    scenario: Annotated[str, typer.Argument(metavar="FILE-OR-NAME", help="A TOML or YAML file, or a catalogue name.")],
    vehicle: Annotated[str, typer.Option("--vehicle", help="1, 2 or, of a network, the name of a mass.")] = "1",
    as_json: Json = False,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Also write the pulse: *.k (LS-DYNA), *.csv, *.tsv, *.parquet.")
    ] = None,
    curve: Annotated[int, typer.Option("--curve", help="LCID of the LS-DYNA curve.")] = 1,
) -> None:
    """Show and export a vehicle's pulse.

    Prints its change of velocity, peak, OLC and the like. A sled's pulse is taken as prescribed,
    that of a crash is simulated.
    """
    with _plain_errors():
        from ridedown.apps.pulse import pulse as made

        made(scenario, vehicle, out, _simulated, as_json=as_json, curve=curve)


@app.command()
def calibrate(
    path: Annotated[str, typer.Argument(metavar="FILE", help="A calibration: TOML or YAML (see docs/calibration.md).")],
    as_json: Json = False,
    out: Out = None,
) -> None:
    """Find a model's parameters from tests.

    Prints the parameters with their bands, how well each channel and number is met, what cannot be
    told apart, and predictions. Ctrl-C ends the search with the best so far. With --out also writes
    an HTML page, figures, results and the fitted scenarios.
    """
    with _plain_errors():
        from ridedown.apps.output import check_folder

        if out is not None:
            check_folder(out)
        _calibrate(path, as_json=as_json, out=out)


@app.command()
def extract(
    test: Annotated[
        str, typer.Argument(metavar="TEST", help="A wall test: NHTSA EV5 or ISO-MME (folder, zip), CSV, TSV or Parquet.")
    ],
    mass: Annotated[
        str | None, typer.Option("--mass", metavar="MASS", help='Such as "1719 kg"; the header\'s if left out.')
    ] = None,
    speed: Annotated[
        str | None, typer.Option("--speed", metavar="SPEED", help='Such as "57.09 km/h"; the header\'s if left out.')
    ] = None,
    channels: Annotated[
        str | None, typer.Option("--channels", metavar="A,B", help="Of the cabin along x; the two that agree best if left out.")
    ] = None,
    engine: Annotated[
        str | None, typer.Option("--engine", metavar="A,B", help="Of the engine along x; those by name if left out; or none.")
    ] = None,
    barrier: Annotated[
        str | None, typer.Option("--barrier", metavar="FILE", help="The force on the wall, where the test does not hold it.")
    ] = None,
    masses: Annotated[int | None, typer.Option("--masses", help="1, or 2: cabin and engine.")] = None,
    pieces: Annotated[int, typer.Option("--pieces", help="Of a curve, at most.")] = 8,
    seed: Annotated[int, typer.Option("--seed", help="Of the starts of the search.")] = 0,
    as_json: Json = False,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write the scenario to this file (*.toml).")] = None,
    report: Annotated[
        Path | None, typer.Option("--report", metavar="DIR", help="Write a page with figures, HTML and PDF, to this folder.")
    ] = None,
) -> None:
    """Find the front structure that reproduces a wall test.

    Force against deflection, unloading, restitution; with the force on the wall known, the engine's
    mass too. Prints the scenario, or writes it with --out, and what it reaches.
    """
    with _plain_errors():
        from ridedown.apps.extract import barrier_at, options, scenario_file
        from ridedown.apps.measured import record_at
        from ridedown.apps.output import check_folder

        if out is not None:
            scenario_file(out)
            check_folder(out.parent)
        if report is not None:
            check_folder(report)
        given = options(mass, speed, channels, engine)
        record, wall = record_at(test), barrier_at(barrier)

        from ridedown.apps import show
        from ridedown.studies.extraction.extract import STEPS
        from ridedown.studies.extraction.extract import extract as extracted

        _compile_if_cold()
        with show.progress("extracting", STEPS) as advance:
            found = extracted(record, **given, barrier=wall, masses=masses, pieces=pieces, seed=seed, advance=advance)
        _write_extraction(found, out, report)
        if as_json:
            show.as_json(found.as_json())
        else:
            _show_extraction(found, out)
            _say_written(report)


@app.command()
def study(
    file: Annotated[str, typer.Argument(metavar="FILE-OR-NAME", help="A study: TOML or YAML, or a catalogue name.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Where results are kept; FILE-results if left out.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with a study that was stopped.")] = False,
    cluster: Annotated[
        str | None, typer.Option("--cluster", metavar="ADDRESS", help="Compute on a Dask cluster, such as tcp://host:8786.")
    ] = None,
    threads: Annotated[
        int | None, typer.Option("--threads", help="Threads on this machine; one for each core if left out.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Run a design study: very many crashes, kept in a folder.

    Ctrl-C stops it; --resume goes on where it was. Results can be asked by SQL: ridedown query.
    """
    with _plain_errors():
        from ridedown.apps.study import study as made

        if not made(
            file, out, resume=resume, cluster=cluster, threads=threads, as_json=as_json, compile_if_cold=_compile_if_cold
        ):
            raise typer.Exit(STOPPED)


@app.command()
def query(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Results of ridedown study.")],
    sql: Annotated[
        str, typer.Argument(metavar="SQL", help='Such as: SELECT count(*) FROM results WHERE "adult.excursion.max" > 0.3')
    ],
    as_json: Json = False,
    as_csv: Annotated[bool, typer.Option("--csv", help="Print CSV instead of a table.")] = False,
) -> None:
    """Ask the results of a study by SQL.

    Tables: results (a row for each crash: parameters, outcomes, status, why) and columns (names and
    units). Values are SI. Only reads.
    """
    with _plain_errors():
        from ridedown.apps.study import query as asked

        asked(folder, sql, as_json=as_json, as_csv=as_csv)


@app.command()
def paper(
    as_json: Json = False,
    out: Out = None,
    identify: Annotated[
        bool, typer.Option("--identify", help="Find the unstated vehicle again from the ten numbers (up to 2 min).")
    ] = False,
) -> None:
    """Reproduce the founding paper.

    Prints its ten numbers beside ours and its trends, held or not. With --out also writes
    figures 6 to 19 and an HTML page.
    """
    with _plain_errors():
        from ridedown.apps.output import check_folder

        if out is not None:
            check_folder(out)
        if identify:
            _identify(as_json=as_json, out=out)
        else:
            _reproduce(as_json=as_json, out=out)


@app.command()
def serve(
    port: Annotated[int, typer.Option("--port", help="Port; 0 for any that is free.")] = 8137,
    host: Annotated[
        str, typer.Option("--host", help="Address to listen on; others than this machine need a token.")
    ] = "127.0.0.1",
    studies: Annotated[
        Path | None, typer.Option("--studies", metavar="DIR", help="Where studies started on the page are kept; none without.")
    ] = None,
    open_browser: Annotated[bool, typer.Option("--open", help="Also open the page in a browser.")] = False,
) -> None:
    """Serve the live page: turn a knob, watch the crash.

    Prints the address to open. Ctrl-C ends it.
    """
    with _plain_errors():
        from ridedown.apps.output import check_folder
        from ridedown.apps.web.serve import serve as served
        from ridedown.apps.web.studies import Studies

        if studies is not None:
            check_folder(studies, option="--studies")
        served(host, port, say=typer.echo, studies=Studies(studies), open_browser=open_browser)


@app.command()
def catalogue(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Print this scenario and its sources.")] = None,
) -> None:
    """List the published scenarios and studies, or print one."""
    with _plain_errors():
        if name is None:
            from ridedown.apps import show

            show.catalogue_list()
        else:
            from ridedown.catalogue import entry, studies
            from ridedown.scenario import dump, load

            kept = studies().get(name)
            typer.echo(dump(load(entry(name).data)) if kept is None else kept.read_text(encoding="utf-8"), nl=False)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scenario files."""
    with _plain_errors():
        from ridedown.apps import show
        from ridedown.scenario import json_schema

        show.as_json(json_schema())


@contextmanager
def _plain_errors() -> Iterator[None]:
    """Turn what a user can mend into one sentence on stderr and exit code 2."""
    try:
        yield
    except RidedownError as error:
        _refuse(str(error))
    except BrokenPipeError:
        raise  # the reader has gone: typer ends the program quietly
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        _refuse(f"{where}{error.strerror or error}.")


def _compile_if_cold() -> None:
    from ridedown.apps import uncompiled

    _compile(uncompiled.of_a_run(), "the solver", "ten to thirty seconds")


def _compile(missing: list[str], what: str, time_it_takes: str) -> None:
    from ridedown.compiled import can_be_kept

    if missing and can_be_kept(missing[0]):
        from ridedown.apps.first_run import compile_side_by_side

        typer.echo(f"compiling {what}, once; {time_it_takes}", err=True)
        compile_side_by_side(missing)
    elif missing:
        why = "the folder to keep it in cannot be written (RIDEDOWN_CACHE_DIR names another)"
        typer.echo(f"compiling {what}, {time_it_takes} each time: {why}", err=True)


def _refuse(sentence: str) -> None:
    typer.echo(f"ridedown: {' '.join(sentence.split())}", err=True)
    raise typer.Exit(BAD_INPUT)


def _say_written(out: Path | None) -> None:
    if out is not None:
        typer.echo(f"Written to {out}: open {out / 'index.html'}")


def _simulated(scenario: str) -> Response:
    from ridedown.apps import show
    from ridedown.scenario import load
    from ridedown.simulation import simulate

    loaded = load(scenario)
    _compile_if_cold()
    with show.working("simulating"):
        return simulate(loaded, throw=False)


def _write_criteria(report: CriteriaReport, out: Path) -> None:
    from ridedown.apps import show
    from ridedown.apps.output import staged
    from ridedown.report.criteria import write

    with show.working("drawing"), staged(out) as stage:
        write(report, stage)


def _write_run(response: Response, out: Path) -> None:
    from ridedown.apps import show
    from ridedown.apps.output import staged
    from ridedown.report.run import write

    with show.working("drawing"), staged(out) as stage:
        write(response, stage)


def _show_extraction(found: Extraction, out: Path | None) -> None:
    from ridedown.apps import show
    from ridedown.report import extract as page

    show.tables(*page.tables(found))
    for sentence in page.notes(found):
        show.note(sentence)
    for warning in found.warnings:
        typer.echo(f"ridedown: warning: {' '.join(warning.split())}", err=True)
    if out is None:
        typer.echo(f"\n{found.toml}", nl=False)
    else:
        typer.echo(f"Written to {out}: ridedown run {out}")


def _write_extraction(found: Extraction, out: Path | None, report: Path | None) -> None:
    from ridedown.apps import show
    from ridedown.apps.output import staged

    if report is not None:
        from ridedown.report.extract import write

        with show.working("drawing"), staged(report) as stage:
            write(found, stage)
    if out is not None:
        with staged(out.parent) as stage:
            (stage / out.name).write_text(found.toml, encoding="utf-8")


def _reproduce(*, as_json: bool, out: Path | None) -> None:
    from ridedown.apps import show
    from ridedown.apps.output import staged
    from ridedown.paper import reproduce
    from ridedown.paper.page import numbers_table, trends_table

    _compile_if_cold()
    with show.progress("simulating the paper", reproduce.STEPS) as advance:
        reproduction = reproduce.reproduce(advance)
    if out is not None:
        from ridedown.paper.files import write

        with show.working("drawing"), staged(out) as stage:
            write(reproduction, stage)
    if as_json:
        show.as_json(reproduction.to_dict())
        return
    show.tables(numbers_table(reproduction.headlines), trends_table(reproduction.trends))
    show.note("The vehicle is a reconstruction: the paper does not print its data.")
    _say_written(out)


def _calibrate(path: str, *, as_json: bool, out: Path | None) -> None:
    from ridedown.apps import show
    from ridedown.apps.output import staged
    from ridedown.report import calibration as report
    from ridedown.report import calibration_tables
    from ridedown.studies import calibrate, load_calibration

    load_calibration(path)  # what is wrong with the file is said before the solver is compiled
    _compile_if_cold()
    with show.searching("calibrating") as progress:
        found = calibrate(path, progress=progress)
    if out is not None:
        with show.working("drawing"), staged(out) as stage:
            report.write(found, stage)
    if as_json:
        show.as_json(found.as_json())
    else:
        if found.calibration.title:
            show.note(f"{found.calibration.title}. {found.calibration.description}".strip() + "\n")
        show.tables(*calibration_tables.tables(found), calibration_tables.correlations(found))
        for warning in found.warnings:
            show.note(f"Note: {warning}")
        _say_written(out)
    if found.interrupted:
        typer.echo("ridedown: interrupted: these are the best parameters so far.", err=True)
        raise typer.Exit(STOPPED)


def _identify(*, as_json: bool, out: Path | None) -> None:
    from ridedown.apps import show
    from ridedown.apps.output import staged
    from ridedown.paper.identify import identify
    from ridedown.paper.page import numbers_table

    _compile_if_cold()
    with show.working("identifying the vehicle from the ten numbers; up to two minutes"):
        found = identify()
    if out is not None:
        with staged(out) as stage:
            (stage / "identified.toml").write_text(found.toml, encoding="utf-8")
    if as_json:
        show.as_json({"numbers": [headline.to_dict() for headline in found.table], "scenario": found.toml})
        return
    show.tables(numbers_table(found.table))
    show.note("The vehicle found, a reconstruction: other vehicles of the same ratios of force to mass do as well.\n")
    typer.echo(found.toml, nl=False)
    if out is not None:
        typer.echo(f"\nWritten to {out / 'identified.toml'}")


if __name__ == "__main__":
    main()
