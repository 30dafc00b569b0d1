"""The first run on a machine: what it needs is compiled side by side, in as many processes as there are processors."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process

from ridedown.compiled import build

_MOST_PROCESSES = 4  # there are not many more long kernels than that


def compile_side_by_side(kernels: Sequence[str]) -> None:
    """Compile kernels and keep them. What cannot be done so is compiled when it is called."""
    processes = min(_processors(), _MOST_PROCESSES, len(kernels))
    if processes < 2:
        # here, and all of them: one that this run does not call would be said to be compiled at every run
        for name in kernels:
            build(name)
        return
    try:
        with ProcessPoolExecutor(processes, get_context("spawn"), _begin) as pool:
            for done in [pool.submit(build, name) for name in kernels]:
                done.result()
    except (OSError, ImportError, BrokenProcessPool):  # no processes can be started here, or one was ended
        return


def _begin() -> None:
    """As each of the processes begins: an interrupt ends it, and so does the end of the process that started it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
