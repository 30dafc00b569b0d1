"""HIC15, HIC36, and the continuous and cumulative 3 ms clip of a record of 3001 samples: time and value.

    python benchmarks/criteria.py                      ridedown beside a straightforward numpy implementation
    python benchmarks/criteria.py --pyisomme PYTHON    and beside pyisomme, in an environment of its own (it pins numpy 1.26)

Times are medians of warm calls in one process and thread. The numpy implementation takes windows from sample to sample, every
width in turn, and the clips from whole samples: what a careful engineer writes in ten minutes.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ridedown import criteria

Floats = NDArray[np.float64]

NAMES = ("HIC15", "HIC36", "3 ms clip, continuous [g]", "3 ms clip, cumulative [g]")
RATE = 10_000  # Hz
G0 = criteria.STANDARD_GRAVITY

# Run by the other interpreter: reads the pulses, prints median seconds and values for each.
PYISOMME = """
import json, sys, time
import numpy as np, pandas as pd
from pyisomme.calculate import calculate_hic, calculate_xms
from pyisomme.channel import Channel
from importlib.metadata import version
pulses = np.load(sys.argv[1])
out = {}
for name in pulses.files:
    times = np.arange(pulses[name].size) / 10000.0
    channel = Channel("11HEAD0000H3ACRA", pd.DataFrame(pulses[name], index=times), unit="m/s^2")
    calls = (lambda: calculate_hic(channel, 15), lambda: calculate_hic(channel, 36),
             lambda: calculate_xms(channel, 3, "S"), lambda: calculate_xms(channel, 3, "C"))
    seconds, values = [], []
    for index, call in enumerate(calls):
        spent = []
        for _ in range(2):
            begin = time.perf_counter()
            result = call()
            spent.append(time.perf_counter() - begin)
        value = float(result.get_data()[0])
        seconds.append(sorted(spent)[0])
        values.append(value)
    out[name] = [seconds, values]
print(json.dumps({"version": version("pyisomme"), "numpy": np.__version__, "pulses": out}))
"""


def pulses() -> dict[str, Floats]:
    """Resultants [m/s2], 3001 samples at 10 kHz: a long and a short half-sine, and one as it is measured, with noise."""
    i = np.arange(3001)
    long = 50.0 * np.sin(np.pi * np.clip((i - 200) / 600, 0.0, 1.0))
    short = 100.0 * np.sin(np.pi * np.clip((i - 200) / 100, 0.0, 1.0))
    noise = np.random.default_rng(1).normal(0.0, 0.5, i.size)
    measured = np.abs(long + 12.0 * np.sin(i / 17.0) * np.exp(-(((i - 500) / 150.0) ** 2)) + noise)
    return {"half-sine 50 g 60 ms": long * G0, "half-sine 100 g 10 ms": short * G0, "with noise": measured * G0}


def numpy_hic(a: Floats, window: float) -> float:
    """HIC over pairs of samples, acceleration [m/s2] at RATE."""
    velocity = np.concatenate(([0.0], np.cumsum((a[1:] + a[:-1]) / (2.0 * RATE * G0))))
    best = 0.0
    for n in range(1, round(window * RATE) + 1):
        gain = (velocity[n:] - velocity[:-n]).max()
        best = max(best, n / RATE * (max(gain, 0.0) * RATE / n) ** 2.5)
    return best


def numpy_clip(a: Floats, *, cumulative: bool) -> float:
    """3 ms clip [g] from whole samples."""
    n = round(0.003 * RATE)
    if cumulative:
        return float(np.sort(np.abs(a))[-n - 1]) / G0
    return float(np.lib.stride_tricks.sliding_window_view(np.abs(a), n + 1).min(axis=1).max()) / G0


def clock(call: Callable[[], float], times: int) -> tuple[float, float]:
    """Median seconds of a warm call, and its value."""
    value = call()
    spent = []
    for _ in range(times):
        begin = time.perf_counter()
        call()
        spent.append(time.perf_counter() - begin)
    return float(np.median(spent)), value


def ours(a: Floats) -> Sequence[Callable[[], float]]:
    """The four criteria by ridedown."""
    t = np.arange(a.size) / RATE
    return (
        lambda: criteria.hic(t, a).value,
        lambda: criteria.hic(t, a, max_window=0.036).value,
        lambda: criteria.clip(t, a).value_g,
        lambda: criteria.clip(t, a, cumulative=True).value_g,
    )


def plain(a: Floats) -> Sequence[Callable[[], float]]:
    """The four criteria in numpy."""
    return (
        lambda: numpy_hic(a, 0.015),
        lambda: numpy_hic(a, 0.036),
        lambda: numpy_clip(a, cumulative=False),
        lambda: numpy_clip(a, cumulative=True),
    )


def pyisomme(python: str | None) -> dict[str, tuple[list[float], list[float]]]:
    """Its seconds and values for each pulse; empty, with a word why, where it cannot be had."""
    if python is None:
        print("pyisomme: not measured; give --pyisomme the interpreter of an environment that has it.")
        return {}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "pulses.npz"
        np.savez(file, **pulses())
        done = subprocess.run([python, "-c", PYISOMME, str(file)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        print(f"pyisomme: not measured; {python} says: {(done.stderr.strip().splitlines() or ['nothing'])[-1]}")
        return {}
    found = json.loads(done.stdout.strip().splitlines()[-1])
    print(f"pyisomme {found['version']} with numpy {found['numpy']}, the better of two calls")
    return {name: (row[0], row[1]) for name, row in found["pulses"].items()}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pyisomme", metavar="PYTHON", help="interpreter of an environment with pyisomme")
    options = parser.parse_args()
    print(f"Python {sys.version.split()[0]}, numpy {np.__version__}; medians of warm calls, milliseconds and (value)")
    theirs = pyisomme(options.pyisomme)
    for pulse, a in pulses().items():
        columns = {
            "ridedown": [clock(call, 300) for call in ours(a)],
            "numpy": [clock(call, 20) for call in plain(a)],
        }
        if pulse in theirs:
            columns["pyisomme"] = list(zip(*theirs[pulse], strict=True))
        print(f"\n{pulse:28s}" + "".join(f"{name:>24s}" for name in columns))
        for k, name in enumerate(NAMES):
            print(f"  {name:26s}" + "".join(f"{1e3 * rows[k][0]:12.3f} ({rows[k][1]:8.3f})" for rows in columns.values()))
        print(
            "  all four"
            + " " * 18
            + "".join(f"{1e3 * sum(row[0] for row in rows):12.3f}" + " " * 11 for rows in columns.values())
        )


if __name__ == "__main__":
    main()
