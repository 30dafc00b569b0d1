"""Who computes: threads of this machine, or the workers of a Dask cluster. What they compute does not depend on it."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, as_completed, wait
from itertools import count, islice
from types import TracebackType
from typing import Any, Self

from ridedown.errors import InvalidInput
from ridedown.studies.results.store import encode
from ridedown.studies.rows.crashes import Rows
from ridedown.studies.rows.plan import Floats, Function, Plan

Computed = tuple[int, bytes, int]
"""Number of a chunk, its Parquet file, and how many of its rows failed."""

_AHEAD = 2
"""Chunks given out beyond one for each worker, so that none waits."""

_PATIENCE = 10
"""s to wait for a scheduler to answer."""

_AGAIN = 5
"""Times that a task is given out anew, where the cluster loses its workers."""

Task = tuple[Callable[..., Any], *tuple[Any, ...]]
"""A function, and what it is called with."""


class Workers(ABC):
    """Who computes; let go of at the end of a `with`."""

    @abstractmethod
    def chunks(self, plan: Plan, numbers: Iterable[int]) -> Generator[Computed]:
        """The chunks of these numbers, as they are done; a few are given out at a time, so that memory does not grow."""

    def begun(self) -> Iterator[Computed]:
        """Chunks that are being computed when no more are asked for, where they have to be waited for anyway; none begins."""
        return iter(())

    @abstractmethod
    def rows(self, function: Function, pieces: Sequence[Mapping[str, Floats]]) -> list[Rows]:
        """The outcomes of pieces of rows, in their order."""

    @abstractmethod
    def close(self) -> None:
        """Let go of them; what has not begun is not computed."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def compute(plan: Plan, chunk: int) -> Computed:
    """Compute one chunk."""
    return (chunk, *encode(plan, chunk))


def outcomes(function: Function, columns: Mapping[str, Floats]) -> Rows:
    """Compute the outcomes of rows."""
    return function.rows(columns)


class Threads(Workers):
    """So many threads of this machine."""

    def __init__(self, threads: int) -> None:
        self._threads = threads
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="ridedown-study")
        self._running: set[Future[Computed]] = set()
        self._patient = True

    def chunks(self, plan: Plan, numbers: Iterable[int]) -> Generator[Computed]:
        """The chunks of these numbers, as they are done."""
        waiting = iter(numbers)
        while True:
            for chunk in islice(waiting, self._threads + _AHEAD - len(self._running)):
                self._running.add(self._pool.submit(compute, plan, chunk))
            if not self._running:
                return
            done, _ = wait(self._running, return_when=FIRST_COMPLETED)
            for future in done:
                self._running.discard(future)
                yield future.result()

    def begun(self) -> Iterator[Computed]:
        """Chunks that the threads are at, once they are done: the wait for a thread is not in vain."""
        left = {future for future in self._running if not future.cancel()}
        self._running.clear()
        try:
            for future in as_completed(left):
                yield future.result()
        except KeyboardInterrupt:
            self._patient = False
            raise

    def rows(self, function: Function, pieces: Sequence[Mapping[str, Floats]]) -> list[Rows]:
        """The outcomes of pieces of rows, in their order."""
        return list(self._pool.map(function.rows, pieces))

    def close(self) -> None:
        """Let go of the threads, once each has ended what it computes, or at once where that was asked for twice."""
        self._pool.shutdown(wait=self._patient, cancel_futures=True)


class Cluster(Workers):
    """The workers of a Dask scheduler at an address. One that is lost costs the tasks it had: they are given to others.

    Raises: InvalidInput where `distributed` is not installed, or no scheduler answers; later, where a task loses worker after
    worker.
    """

    def __init__(self, address: str) -> None:
        try:
            from dask.distributed import Client, KilledWorker  # noqa: PLC0415  an optional extra
            from dask.distributed import as_completed as as_done  # noqa: PLC0415
            from distributed.comm.addressing import get_address_host_port  # noqa: PLC0415
        except ImportError:
            raise InvalidInput(
                "--cluster: got no dask.distributed installed; need it. Install it with `pip install 'ridedown[cluster]'`."
            ) from None
        try:
            get_address_host_port(address)  # a Client of an address that is none hangs in its own end, then says so at length
            self._client = Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise InvalidInput(
                f'--cluster: got "{address}", where no Dask scheduler answers ({error}); need an address such as '
                '"tcp://host:8786". Start one with `dask scheduler`.'
            ) from None
        self._killed: type[Exception] = KilledWorker
        self._as_completed = as_done
        self._number = count()

    def chunks(self, plan: Plan, numbers: Iterable[int]) -> Generator[Computed]:
        """The chunks of these numbers, as they are done."""
        most = _AHEAD + 2 * sum(self._client.nthreads().values())
        tasks = ((chunk, (compute, plan.part(chunk), chunk)) for chunk in numbers)
        for _, computed in self._done(tasks, most):
            yield computed

    def rows(self, function: Function, pieces: Sequence[Mapping[str, Floats]]) -> list[Rows]:
        """The outcomes of pieces of rows, in their order."""
        tasks = ((piece, (outcomes, function, columns)) for piece, columns in enumerate(pieces))
        found: dict[int, Rows] = dict(self._done(tasks, len(pieces)))
        return [found[piece] for piece in range(len(pieces))]

    def close(self) -> None:
        """Let go of the scheduler, which forgets what was given out."""
        self._client.close()

    def _done(self, tasks: Iterator[tuple[int, Task]], most: int) -> Iterator[tuple[int, Any]]:
        """Each task's number and what it gave, as they are done; at most so many given out at a time."""
        running = self._as_completed(loop=self._client.loop)
        given: dict[Any, tuple[int, Task, int]] = {}

        def give(number: int, task: Task, again: int = 0) -> None:
            # a key of its own each time: Dask would answer a key that it knows with what it has
            future = self._client.submit(*task, key=f"ridedown-{os.getpid()}-{id(self)}-{next(self._number)}")
            given[future.key] = number, task, again
            running.add(future)

        for number, task in islice(tasks, most):
            give(number, task)
        for future in running:
            number, task, again = given.pop(future.key)
            try:
                found = future.result()
            except self._killed:
                if again == _AGAIN:
                    raise InvalidInput(
                        "--cluster: got a task lost with its workers, again and again; need workers that live. "
                        "Give each more memory; go on with --resume."
                    ) from None
                give(number, task, again + 1)
                continue
            yield number, found
            for another in islice(tasks, 1):
                give(*another)
