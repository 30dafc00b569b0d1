"""Where chunks are computed: threads of this machine, or a Dask cluster. Results do not depend on it.

Chunks go out a few at a time and are written as they come back, so that memory does not grow with the study.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ridedown.errors import InvalidInput
from ridedown.simulation import workers
from ridedown.studies.file.study import LoadedStudy, Study, load_study
from ridedown.studies.results.findings import finite, results_of
from ridedown.studies.results.store import Store, encode
from ridedown.studies.rows.bounding import LeastPeaks
from ridedown.studies.rows.effects import remarks_on
from ridedown.studies.rows.plan import Asked, Plan, plan_of
from ridedown.studies.running.kept import Kept
from ridedown.studies.running.searches import check_search, found_by_search

Computed = tuple[int, bytes, int]
"""Number of a chunk, its Parquet file, and how many of its rows failed."""

_AHEAD = 2
"""Chunks given out beyond one for each worker, so that none waits."""

_PATIENCE = 10
"""s to wait for a scheduler to answer."""

_AGAIN = 5
"""Times that a chunk is given out anew, where the cluster loses its workers."""


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
    if isinstance(plan.design, Asked):
        if cluster is not None:
            kind = loaded.study.kind
            raise InvalidInput(f'--cluster: got kind = "{kind}", whose rows follow from one another; need none. Leave it out.')
        return _run_search(loaded, plan, folder, resume=resume, threads=count, report=report)
    with Store.opened(folder, loaded, plan, resume=resume) as store:
        store.remark(list if isinstance(plan.function, LeastPeaks) else partial(remarks_on, plan))
        missing = store.missing()
        before = plan.rows - sum(stop - start for start, stop in map(plan.span, missing))
        progress = Progress(plan.rows, before, 0, 0)
        computed = on_threads(plan, missing, count) if cluster is None else on_cluster(plan, missing, cluster)
        try:
            if report is not None:
                report(progress)
            for chunk, data, failed in computed:
                store.write(chunk, data)
                start, stop = plan.span(chunk)
                progress = Progress(plan.rows, before, progress.done + stop - start, progress.failed + failed)
                if report is not None:
                    report(progress)
        except KeyboardInterrupt:
            raise Stopped(progress) from None
        finally:
            computed.close()
        store.finish(results_of(loaded, plan, folder))
    return folder


def _run_search(loaded: LoadedStudy, plan: Plan, folder: Path, *, resume: bool, threads: int, report: Report | None) -> Path:
    """Search, and keep every row that is asked for. What was kept before is asked for again, and not computed."""

    def told(before: int, done: int, failed: int) -> None:
        if report is not None:
            report(Progress(max(plan.rows, before + done), before, done, failed))

    with Store.opened(folder, loaded, plan, resume=resume) as store, Kept(store, plan, threads, told) as kept:
        store.remark(partial(remarks_on, plan))
        told(0, 0, 0)
        try:
            results = found_by_search(loaded, plan, kept)
        except KeyboardInterrupt:
            raise Stopped(Progress(plan.rows, 0, kept.written, kept.failed)) from None
        store.grown(*kept.end())
        store.finish(finite(results))
    return folder


def _check(loaded: LoadedStudy, plan: Plan) -> None:
    """Have what is wrong with a study said before the first row, and before anything is written."""
    check_search(loaded, plan)
    if isinstance(plan.function, LeastPeaks):
        plan.function.check()


def compute(plan: Plan, chunk: int) -> Computed:
    """Compute one chunk."""
    return (chunk, *encode(plan, chunk))


def on_threads(plan: Plan, chunks: Iterable[int], threads: int) -> Generator[Computed]:
    """The chunks, computed by this many threads, as they are done."""
    waiting = iter(chunks)
    pool = ThreadPoolExecutor(threads, thread_name_prefix="ridedown-study")
    running: set[Future[Computed]] = set()
    try:
        while True:
            for chunk in _some(waiting, threads + _AHEAD - len(running)):
                running.add(pool.submit(compute, plan, chunk))
            if not running:
                return
            done, running = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _some(waiting: Iterator[int], count: int) -> Iterator[int]:
    for _ in range(count):
        try:
            yield next(waiting)
        except StopIteration:
            return


def on_cluster(plan: Plan, chunks: Iterable[int], address: str) -> Generator[Computed]:
    """The chunks, computed by the workers of a Dask scheduler, as they are done.

    A worker that is lost costs the chunks it had; they are given to others.

    Raises: InvalidInput where `distributed` is not installed, no scheduler answers, or a chunk loses worker after worker.
    """
    try:
        from dask.distributed import Client, KilledWorker, as_completed  # noqa: PLC0415  an optional extra
    except ImportError:
        raise InvalidInput(
            "--cluster: got no dask.distributed installed; need it. Install it with `pip install 'ridedown[cluster]'`."
        ) from None
    try:
        client = Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InvalidInput(
            f'--cluster: got "{address}", where no Dask scheduler answers ({error}); need an address such as '
            '"tcp://host:8786". Start one with `dask scheduler`.'
        ) from None
    with client:
        waiting = iter(chunks)
        running = as_completed(loop=client.loop)

        def give(chunk: int, again: int = 0) -> None:
            # a key of its own each time: Dask would answer a key that it knows with what it has
            key = f"ridedown-{plan.hash[:12]}-{chunk}-{os.getpid()}-{again}"
            future = client.submit(compute, plan.part(chunk), chunk, key=key)
            told[future.key] = chunk, again
            running.add(future)

        told: dict[Any, tuple[int, int]] = {}
        for chunk in _some(waiting, _AHEAD + 2 * sum(client.nthreads().values())):
            give(chunk)
        for future in running:
            chunk, again = told.pop(future.key)
            try:
                computed: Computed = future.result()
            except KilledWorker:
                if again == _AGAIN:
                    raise InvalidInput(
                        f"--cluster: got chunk {chunk} lost with its workers, again and again; need workers that live. "
                        "Give each more memory; go on with --resume."
                    ) from None
                give(chunk, again + 1)
                continue
            yield computed
            for another in _some(waiting, 1):
                give(another)
