"""A study run, and its results kept: rows that are fixed beforehand chunk by chunk, those of a search as it asks for them.

Chunks go out a few at a time and are written as they come back, so that memory does not grow with the study.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ridedown.simulation import workers
from ridedown.studies.file.study import LoadedStudy, Study, load_study
from ridedown.studies.results.findings import finite, results_of
from ridedown.studies.results.store import Store
from ridedown.studies.rows.bounding import LeastPeaks
from ridedown.studies.rows.effects import remarks_on
from ridedown.studies.rows.plan import Asked, Plan, plan_of
from ridedown.studies.running.kept import Kept
from ridedown.studies.running.searches import check_search, found_by_search
from ridedown.studies.running.workers import Cluster, Threads, Workers


@dataclass(frozen=True)
class Progress:
    """How far a study is: rows in all, done before this run, done now, and those of now that failed."""

    rows: int
    before: int
    done: int
    failed: int


Report = Callable[[Progress], None]


class Stopped(KeyboardInterrupt):
    """The run was interrupted; `progress` says how far it came."""

    def __init__(self, progress: Progress) -> None:
        super().__init__("interrupted")
        self.progress = progress


def run_study(
    source: str | os.PathLike[str] | Mapping[str, Any] | Study | LoadedStudy,
    out: str | os.PathLike[str],
    *,
    resume: bool = False,
    threads: int | None = None,
    cluster: str | None = None,
    report: Report | None = None,
) -> Path:
    """Run a study, of a file or a mapping of the same shape, and keep its results in the folder `out`.

    resume: go on with a study that was stopped; chunks that are there are not computed again. threads: as many as the machine
    has cores if left out. cluster: the address of a Dask scheduler, to compute there. Results depend on neither. report: told
    how far the study is, after each chunk.

    Returns: the folder.

    Raises: InvalidInput, UnknownName; Stopped where it was interrupted.
    """
    loaded = load_study(source)
    plan = plan_of(loaded)
    return run_plan(loaded, plan, Path(out), resume=resume, threads=threads, cluster=cluster, report=report)


def run_plan(
    loaded: LoadedStudy,
    plan: Plan,
    folder: Path,
    *,
    resume: bool = False,
    threads: int | None = None,
    cluster: str | None = None,
    report: Report | None = None,
) -> Path:
    """Compute what is missing of a plan and keep it. See `run_study`."""
    count = workers(threads)
    _check(loaded, plan)
    with Threads(count) if cluster is None else Cluster(cluster) as crew:
        run = _search if isinstance(plan.design, Asked) else _go_through
        run(loaded, plan, folder, crew, resume=resume, report=report)
    return folder


def _go_through(loaded: LoadedStudy, plan: Plan, folder: Path, crew: Workers, *, resume: bool, report: Report | None) -> None:
    """Compute the chunks that are missing, and keep each as it is done."""
    with Store.opened(folder, loaded, plan, resume=resume) as store:
        store.remark(list if isinstance(plan.function, LeastPeaks) else partial(remarks_on, plan))
        missing = store.missing()
        before = plan.rows - sum(stop - start for start, stop in map(plan.span, missing))
        progress = Progress(plan.rows, before, 0, 0)
        computed = crew.chunks(plan, missing)

        def keep(chunk: int, data: bytes, failed: int) -> None:
            nonlocal progress
            store.write(chunk, data)
            start, stop = plan.span(chunk)
            progress = Progress(plan.rows, before, progress.done + stop - start, progress.failed + failed)

        try:
            if report is not None:
                report(progress)
            for one in computed:
                keep(*one)
                if report is not None:
                    report(progress)
        except KeyboardInterrupt:
            for one in crew.begun():
                keep(*one)
            raise Stopped(progress) from None
        finally:
            computed.close()
        store.finish(results_of(loaded, plan, folder))


def _search(loaded: LoadedStudy, plan: Plan, folder: Path, crew: Workers, *, resume: bool, report: Report | None) -> None:
    """Search, and keep every row that is asked for. What was kept before is asked for again, and not computed."""

    def told(before: int, done: int, failed: int) -> None:
        if report is not None:
            report(Progress(max(plan.rows, before + done), before, done, failed))

    with Store.opened(folder, loaded, plan, resume=resume) as store:
        kept = Kept(store, plan, crew, told)
        store.remark(partial(remarks_on, plan))
        told(0, 0, 0)
        try:
            results = found_by_search(loaded, plan, kept)
        except KeyboardInterrupt:
            raise Stopped(Progress(plan.rows, 0, kept.written, kept.failed)) from None
        store.grown(*kept.end())
        store.finish(finite(results))


def _check(loaded: LoadedStudy, plan: Plan) -> None:
    """Have what is wrong with a study said before the first row, and before anything is written."""
    check_search(loaded, plan)
    if isinstance(plan.function, LeastPeaks):
        plan.function.check()
