"""Benchmark problem P1, an offset crash with an adult and a child, through the same `simulate_many` that users call.

    python benchmarks/p1.py --params IN.npz --out OUT.npz     outcomes of the parameter sets of a file
    python benchmarks/p1.py                                   speed and error beside scipy and heyoka, in one run

`IN.npz` holds `params` (N, 12), SI, in the order M1, M2, k1, k2, ds, ka, ca, kc, cc, ks, cs, v0; `OUT.npz` gets
`outputs` (N, 6): largest adult |acceleration| and excursion, child |acceleration| and displacement relative to the
seat, vehicle 1 |acceleration| and displacement.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

import ridedown
from ridedown.errors import InvalidInput

Floats = NDArray[np.float64]

# column of the parameter sets -> the places in the scenario that it fills
PATHS: tuple[tuple[str, ...], ...] = (
    ("vehicle1.mass",),
    ("vehicle2.mass",),
    ("vehicle1.members.pieces.0.stiffness", "vehicle2.members.pieces.0.stiffness"),
    ("vehicle1.members.pieces.1.stiffness", "vehicle2.members.pieces.1.stiffness"),
    ("vehicle1.members.pieces.0.until", "vehicle2.members.pieces.0.until"),
    ("adult.restraint.stiffness",),
    ("adult.restraint.damping",),
    ("child.restraint.stiffness",),
    ("child.restraint.damping",),
    ("child.seat.restraint.stiffness",),
    ("child.seat.restraint.damping",),
    ("vehicle1.speed", "vehicle2.speed"),
)
OUTCOMES = (
    "adult.acceleration.peak",
    "adult.excursion.max",
    "child.acceleration.peak",
    "child.relative_displacement.max",
    "vehicle1.acceleration.peak",
    "vehicle1.displacement.max",
)
ROOT = Path(__file__).resolve().parents[1]


def solve(params: Floats, *, threads: int | None = None) -> tuple[Floats, dict[str, int]]:
    """Outcomes (N, 6) of parameter sets (N, 12), and how many crashes stopped early, by why."""
    table = {path: params[:, i] for i, paths in enumerate(PATHS) for path in paths}
    outcomes = ridedown.simulate_many(ridedown.load("p1"), table, outcomes=OUTCOMES, threads=threads)
    outputs = np.empty((len(params), len(OUTCOMES)))
    for i, name in enumerate(OUTCOMES):
        outputs[:, i] = outcomes[name]
    return outputs, outcomes.failures()


def solve_file(source: Path, target: Path, *, threads: int | None) -> int:
    """Read `params`, write `outputs`; the exit code."""
    params = read_params(source)
    if target.is_dir() or not target.parent.is_dir():
        raise InvalidInput(f"--out: got {target}; need a file in a folder that exists. Make the folder first.")
    solve(params[:1], threads=threads)  # compiles the kernels, where this is the first run
    start = time.perf_counter()
    outputs, failures = solve(params, threads=threads)
    seconds = time.perf_counter() - start
    partial = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        with partial.open("wb") as file:
            np.savez(file, outputs=outputs)
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)
    rate = len(params) / seconds
    print(f"{len(params)} crashes in {seconds:.2f} s, {rate:,.0f} a second{peak_memory()}", file=sys.stderr)
    for why, count in failures.items():
        print(f"{count} crashes stopped early, and only their first part counts: {why}.", file=sys.stderr)
    return 3 if failures else 0


def read_params(source: Path) -> Floats:
    """`params` (N, 12) of a file. Raises: InvalidInput."""
    try:
        with np.load(source) as arrays:
            params = np.asarray(arrays["params"], dtype=np.float64)
    except (OSError, KeyError, ValueError, TypeError, EOFError, BadZipFile) as error:
        raise InvalidInput(f"--params: got {source}; need an .npz file with numbers in `params`. ({error})") from None
    if params.ndim != 2 or params.shape[1] != len(PATHS) or not len(params):
        raise InvalidInput(f"--params: got `params` of shape {params.shape}; need (N, 12), N of 1 or more.")
    return params


def peak_memory() -> str:
    """The most memory that this process has held, as a clause, where the system tells."""
    if importlib.util.find_spec("resource") is None:
        return ""
    import resource  # noqa: PLC0415  (not on every system)

    unit = 1 if sys.platform == "darwin" else 1024
    return f", {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6:.0f} MB of memory at most"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what the command line asks for; the exit code."""
    parser = argparse.ArgumentParser(description="Benchmark problem P1. Without arguments: the comparison with peers.")
    parser.add_argument("--params", type=Path, metavar="IN.npz", help="parameter sets, `params` (N, 12)")
    parser.add_argument("--out", type=Path, metavar="OUT.npz", help="where `outputs` (N, 6) go")
    parser.add_argument("--threads", type=int, help="threads for --params; all cores if left out")
    parser.add_argument("--repeats", type=int, default=7, help="repeats of the comparison (7)")
    given = parser.parse_args(arguments)
    if (given.params is None) != (given.out is None):
        parser.error("give --params and --out together")
    try:
        if given.params is not None:
            return solve_file(given.params, given.out, threads=given.threads)
        sys.path.insert(0, str(ROOT))  # a script is given its own folder only
        from benchmarks.p1_comparison import compare  # noqa: PLC0415

        compare(repeats=max(1, given.repeats))
    except InvalidInput as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
