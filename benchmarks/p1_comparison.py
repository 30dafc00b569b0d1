"""P1 by ridedown and by what users would pick instead, side by side in one run: speed, error, ratios."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import multiprocessing
import os
import platform
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray

import ridedown
from benchmarks import p1, p1_reference
from benchmarks.peers import scipy_p1

Floats = NDArray[np.float64]
Solve = Callable[[Floats], Floats]

VECTORS = p1.ROOT.parent / "shared" / "vectors" / "p1.npz"
RIDEDOWN, HEYOKA, SCIPY = "ridedown", "heyoka", "scipy RK45"


@dataclass
class Contender:
    """One method on so many threads, and what was measured of it."""

    name: str
    threads: int
    crashes: int  # in one repeat
    solve: Solve
    how: str
    cpu_time: Callable[[], float] = time.process_time  # of all that work for it [s]
    error: float = float("nan")
    rates: list[float] = field(default_factory=list)
    busy: list[float] = field(default_factory=list)

    def run(self, params: Floats) -> None:
        """Take the time of one repeat, and how many cores it kept busy."""
        start, cpu = time.perf_counter(), self.cpu_time()
        self.solve(params[: self.crashes])
        seconds = time.perf_counter() - start
        self.rates.append(self.crashes / seconds)
        self.busy.append((self.cpu_time() - cpu) / seconds)


def compare(*, repeats: int) -> None:
    """Measure all methods, in turn within each repeat, and print what came out."""
    params, expected, where = _reference()
    with ExitStack() as stack:
        contenders = [*_ridedown(), *_heyoka(stack), _scipy()]
        fresh = p1_reference.random_sets(max(c.crashes for c in contenders), seed=1)
        print(f"P1 on {_machine()}")
        print(f"crashes a second: medians of {repeats} repeats, all methods in turn within each")
        print(f"worst error: largest relative error of any outcome over {where}\n", flush=True)
        for contender in contenders:  # which also warms it up
            contender.error = _worst_error(contender.solve(params), expected)
        for _ in range(repeats):
            for contender in contenders:
                contender.run(fresh)
    _print_table(contenders)
    _print_ratios({(c.name, c.threads): c for c in contenders})


def _reference() -> tuple[Floats, Floats, str]:
    """200 parameter sets, their outcomes by other methods, and where those are from."""
    if VECTORS.exists():
        with np.load(VECTORS) as vectors:
            return vectors["params"], vectors["outputs"], f"the 200 reference sets of {VECTORS.name}"
    params = p1_reference.random_sets(200)
    outputs, _ = p1_reference.solve(params)
    return params, outputs, "200 sets by p1_reference.py (the reference file is not here)"


def _worst_error(outputs: Floats, expected: Floats) -> float:
    return float(np.abs(outputs / expected - 1.0).max())


def _ridedown() -> Iterator[Contender]:
    how = f"simulate_many, version {ridedown.__version__}"
    for threads in (1, 2):
        yield Contender(RIDEDOWN, threads, 24_576 * threads, partial(_solve_ridedown, threads), how)


def _solve_ridedown(threads: int, params: Floats) -> Floats:
    return p1.solve(params, threads=threads)[0]


def _scipy() -> Contender:
    return Contender(SCIPY, 1, 40, scipy_p1.solve, f"solve_ivp, rtol {scipy_p1.TOLERANCE:.0e}")


def _heyoka(stack: ExitStack) -> Iterator[Contender]:
    if importlib.util.find_spec("heyoka") is None:
        print("heyoka is not installed, so the strongest peer is missing below. To add it: pip install '.[benchmark]'\n")
        return
    from benchmarks.peers import heyoka_p1  # noqa: PLC0415  (not always there)

    how = f"batches of {heyoka_p1.LANES}, terminal events, tol {heyoka_p1.TOLERANCE:.0e}"
    yield Contender(HEYOKA, 1, 4_000, heyoka_p1.Heyoka().solve, how)
    pair = stack.enter_context(_Pair())
    yield Contender(HEYOKA, 2, 8_000, pair.solve, how, pair.cpu_time)


class _Pair(AbstractContextManager["_Pair"]):
    """Heyoka in two processes of its own: Python calls every step, and its lock lets one thread run at a time."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.workers = [ProcessPoolExecutor(1, mp_context=context, initializer=_prepare) for _ in range(2)]
        self.spent = 0.0

    def solve(self, params: Floats) -> Floats:
        halves = np.array_split(params, len(self.workers))
        jobs = [worker.submit(_solve_heyoka, half) for worker, half in zip(self.workers, halves, strict=True)]
        outputs, spent = zip(*(job.result() for job in jobs), strict=True)
        self.spent += sum(spent)
        return np.concatenate(outputs)

    def cpu_time(self) -> float:
        return self.spent

    def __exit__(self, *_: object) -> None:
        for worker in self.workers:
            worker.shutdown()


_worker: dict[str, Solve] = {}  # in a worker process: its solver, compiled once


def _prepare() -> None:
    from benchmarks.peers import heyoka_p1  # noqa: PLC0415

    _worker["solve"] = heyoka_p1.Heyoka().solve


def _solve_heyoka(params: Floats) -> tuple[Floats, float]:
    before = time.process_time()
    outputs = _worker["solve"](params)
    return outputs, time.process_time() - before


def _print_table(contenders: list[Contender]) -> None:
    print(f"{'method':<12}{'threads':>8}{'cores busy':>12}{'crashes/s':>12}{'us/crash':>10}{'worst error':>13}  how")
    for c in contenders:
        rate, busy = median(c.rates), median(c.busy)
        print(f"{c.name:<12}{c.threads:>8}{busy:>12.2f}{rate:>12,.0f}{1e6 / rate:>10.1f}{c.error:>13.1e}  {c.how}")
    if any(median(c.busy) < 0.9 * c.threads for c in contenders):
        print("\nThe machine had other work: fewer cores were busy than there were threads. Measure again when idle.")


def _print_ratios(by: dict[tuple[str, int], Contender]) -> None:
    print()
    for threads in (1, 2):
        for peer in (HEYOKA, SCIPY):
            if (peer, threads) in by:
                ours, theirs = by[RIDEDOWN, threads].rates, by[peer, threads].rates
                ratios = [a / b for a, b in zip(ours, theirs, strict=True)]
                spread = f"{min(ratios):.1f} to {max(ratios):.1f}"
                word = "thread" if threads == 1 else "threads"
                print(f"ridedown / {peer}, {threads} {word}: {median(ratios):.1f} ({spread})")


def _machine() -> str:
    model = platform.processor() or platform.machine()
    if Path("/proc/cpuinfo").exists():
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), model)
    versions = [f"{name} {_version(name)}" for name in ("numpy", "numba", "scipy", "heyoka")]
    return f"{model}, {os.cpu_count()} cores; Python {platform.python_version()}, {', '.join(versions)}"


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"
