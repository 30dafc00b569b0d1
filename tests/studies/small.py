"""A study of a few thousand rows in many small chunks, and one that is told where to stop; for tests of the store."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

from ridedown.studies.file.study import load_study
from ridedown.studies.rows.plan import plan_of
from ridedown.studies.running import execution

SWEEP = {
    "kind": "sweep",
    "scenario": "p1",
    "outcomes": ["adult.excursion.max", "child.acceleration.peak", "adult.clip_3ms"],
    "parameters": [
        {"path": "adult.restraint.stiffness", "grid": {"start": "20 kN/m", "stop": "120 kN/m", "count": 12}},
        {"path": "bar.lateral_offset", "grid": {"start": 0.0, "stop": "0.8 m", "count": 10}},
    ],
}
CHUNK_ROWS = 16


def small(study=SWEEP, chunk_rows=CHUNK_ROWS):
    """The study loaded, and its plan with chunks as small as that."""
    loaded = load_study(study)
    return loaded, replace(plan_of(loaded), chunk_rows=chunk_rows)


def run(folder, *, threads=1, resume=False, study=SWEEP, chunk_rows=CHUNK_ROWS, **more):
    """Run it into a folder."""
    loaded, plan = small(study, chunk_rows)
    return execution.run_plan(loaded, plan, Path(folder), threads=threads, resume=resume, **more)


def contents(folder):
    """Every chunk's bytes by its name."""
    return {path.name: path.read_bytes() for path in (Path(folder) / "chunks").iterdir()}


def slowly(progress):
    """Say how far it is, and let a test catch up."""
    print(progress.done, flush=True)
    time.sleep(0.05)


if __name__ == "__main__":  # for a test to kill
    run(sys.argv[1], resume=sys.argv[2:] == ["resume"], report=slowly)
