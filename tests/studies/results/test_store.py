"""Results are whole or not there, whatever ends the run; a resumed study is an uninterrupted one, bit for bit."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from ridedown.errors import InvalidInput
from ridedown.studies.results.sql import query
from ridedown.studies.results.store import Store, read_manifest
from ridedown.studies.running import workers
from ridedown.studies.running.execution import Progress, Stopped
from tests.studies.small import SWEEP, contents, run, small

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run(tmp_path_factory.mktemp("whole") / "out")


def test_a_row_has_inputs_outcomes_and_status(whole):
    table = pq.read_table(sorted((whole / "chunks").iterdir()))
    assert table.column_names == [
        "row", "adult.restraint.stiffness", "bar.lateral_offset",
        "adult.excursion.max", "child.acceleration.peak", "adult.clip_3ms", "status", "why",
    ]  # fmt: skip
    assert table["row"].to_pylist() == list(range(120))
    assert set(table["status"].to_pylist()) == {"completed"}
    assert table["bar.lateral_offset"].to_pylist()[:10] == table["bar.lateral_offset"].to_pylist()[10:20]  # the last is fastest
    assert read_manifest(whole)["rows"] == 120


@pytest.mark.parametrize("threads", [2, 5])
def test_threads_change_no_bit(whole, tmp_path, threads):
    assert contents(run(tmp_path / "out", threads=threads)) == contents(whole)


def test_chunks_change_no_number_but_for_rounding(whole, tmp_path):
    other = run(tmp_path / "out", chunk_rows=50)  # enough rows for occupants to be solved apart from their vehicles
    both = [query(folder, "SELECT * FROM results ORDER BY row").to_pydict() for folder in (whole, other)]
    for name, column in both[0].items():
        if name in {"status", "why"}:
            assert column == both[1][name]
        else:
            assert column == pytest.approx(both[1][name], rel=1e-12)


def test_killed_at_any_moment_and_resumed_it_is_the_same_bit_for_bit(whole, tmp_path):
    folder = tmp_path / "out"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)])}
    for kills, after in enumerate((1, 2, 2)):  # chunks that a run is left to write
        command = [sys.executable, "-m", "tests.studies.small", str(folder), *(["resume"] if kills else [])]
        with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment, cwd=ROOT) as process:
            assert process.stdout is not None
            for _ in range(after + 1):
                assert process.stdout.readline()
            process.send_signal(signal.SIGKILL)
            assert process.wait() == -signal.SIGKILL
        done = contents(folder)
        for name in done:
            if name.endswith(".parquet") and not name.startswith("."):
                assert done[name] == contents(whole)[name]
    seen: list[Progress] = []
    run(folder, resume=True, report=seen.append)
    assert contents(folder) == contents(whole)
    assert seen[0].before >= 16 * 5  # the chunks that were there were not computed again
    assert seen[-1].before + seen[-1].done == 120
    assert (folder / "manifest.json").read_bytes() == (whole / "manifest.json").read_bytes()


def test_interrupted_it_says_how_far_it_came(tmp_path):
    def interrupt(progress):
        if progress.done >= 32:
            raise KeyboardInterrupt

    with pytest.raises(Stopped) as stopped:
        run(tmp_path / "out", report=interrupt)
    done = stopped.value.progress.done
    assert 32 <= done <= 64  # two more were given out, and what of them was begun is kept as well
    assert len(contents(tmp_path / "out")) == done / 16


def test_interrupted_it_keeps_what_its_threads_are_at_and_begins_no_more(whole, tmp_path, monkeypatch):
    begun, go_on = [], threading.Event()
    real = workers.compute

    def slow(plan, chunk):
        begun.append(chunk)
        if chunk:
            assert go_on.wait(30)
        return real(plan, chunk)

    def interrupt(progress):
        if progress.done:
            while len(begun) < 3:  # both threads are at another chunk
                time.sleep(0.001)
            threading.Timer(0.1, go_on.set).start()
            raise KeyboardInterrupt

    monkeypatch.setattr(workers, "compute", slow)
    with pytest.raises(Stopped) as stopped:
        run(tmp_path / "out", threads=2, report=interrupt)
    assert stopped.value.progress.done == 48
    assert sorted(begun) == [0, 1, 2]
    assert {name: contents(whole)[name] for name in contents(tmp_path / "out")} == contents(tmp_path / "out")


def test_a_file_that_is_cut_short_or_another_studys_counts_as_missing(whole, tmp_path):
    folder = run(tmp_path / "out")
    first, second, third = sorted((folder / "chunks").iterdir())[:3]
    first.write_bytes(first.read_bytes()[:-9])
    second.write_bytes(b"")
    third.write_bytes((folder / "chunks" / "chunk-00000004.parquet").read_bytes())
    (folder / "chunks" / ".chunk-00000005.parquet.partial").write_bytes(b"half")
    seen: list[Progress] = []
    run(folder, resume=True, report=seen.append)
    assert seen[-1].done == 48
    assert contents(folder) == contents(whole)


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_loses_nothing_written(whole, tmp_path, monkeypatch, code):
    written = []
    real = os.fsync

    def full(descriptor):
        written.append(descriptor)
        if len(written) > 12:
            raise OSError(code, os.strerror(code))
        real(descriptor)

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        with pytest.raises(InvalidInput, match=r"full disk.*--resume"):
            run(tmp_path / "out")
    there = contents(tmp_path / "out")
    assert 0 < len(there) < 8
    assert not [name for name in there if name.startswith(".")]
    run(tmp_path / "out", resume=True)
    assert contents(tmp_path / "out") == contents(whole)


@pytest.mark.parametrize("code", [errno.EACCES, errno.EROFS])
def test_a_folder_that_may_not_be_written_is_said_so(tmp_path, monkeypatch, code):
    def refuse(*_args, **_options):
        raise OSError(code, os.strerror(code), "x")

    with monkeypatch.context() as patched:
        patched.setattr(Path, "mkdir", refuse)
        with pytest.raises(InvalidInput, match=r"--out: got .*may not be written"):
            run(tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_place_of_the_folder(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(InvalidInput, match="--out"):
        run(tmp_path / "out")
    assert (tmp_path / "out").read_text() == "mine"


def test_results_are_not_overwritten(whole):
    before = contents(whole)
    with pytest.raises(InvalidInput, match="--resume"):
        run(whole)
    assert contents(whole) == before


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"scenario": "paper-adult-offset", "outcomes": ["adult.excursion.max"]}, "outcomes was"),
        ({"outcomes": ["adult.excursion.max"]}, "outcomes was"),
        ({"parameters": [SWEEP["parameters"][0]]}, "parameters was"),
        (
            {"parameters": [SWEEP["parameters"][0], {"path": "bar.lateral_offset", "values": [0.0, 0.1]}]},
            r"parameters.1.values was null and is \[0.0, 0.1\]",
        ),
        ({"step": "0.2 ms"}, "step was 0.0001 and is 0.0002"),
    ],
)
def test_a_changed_study_is_not_gone_on_with(whole, change, said):
    with pytest.raises(InvalidInput, match=f"--resume.*{said}"):
        run(whole, study={**SWEEP, **change}, resume=True)


def test_another_versions_results_are_not_gone_on_with(tmp_path):
    folder = run(tmp_path / "out")
    manifest = json.loads((folder / "manifest.json").read_text())
    (folder / "manifest.json").write_text(json.dumps({**manifest, "ridedown": "0.0.9"}))
    with pytest.raises(InvalidInput, match=r"ridedown = 0\.0\.9"):
        run(folder, resume=True)
    (folder / "manifest.json").write_text(json.dumps({**manifest, "format": 99}))
    with pytest.raises(InvalidInput, match="format 99"):
        run(folder, resume=True)


def test_two_processes_do_not_write_one_folder(tmp_path):
    loaded, plan = small()
    with Store.opened(tmp_path / "out", loaded, plan, resume=False), pytest.raises(InvalidInput, match="another process"):
        run(tmp_path / "out", resume=True)


def test_failed_rows_stay_with_why(tmp_path):
    study = {
        "kind": "sweep",
        "scenario": "example-offset",
        "outcomes": ["vehicle1.acceleration.peak", "driver.hic15"],
        "parameters": [
            {"path": "vehicle2.members.points.1.0", "values": [0.25, 0.6]},  # which is beyond the next point
            {"path": "bar.inertia", "values": [157.0, 1e-6]},  # a bar that light is beyond the solver
        ],
    }
    folder = run(tmp_path / "out", study=study)
    asked = 'SELECT status, why, "vehicle1.acceleration.peak" AS peak, "driver.hic15" AS hic FROM results ORDER BY row'
    whole, turned, *refused = query(folder, asked).to_pylist()
    assert (whole["status"], whole["why"]) == ("completed", None)
    assert whole["peak"] > 0.0
    assert whole["hic"] > 0.0
    assert (turned["status"], turned["peak"], turned["hic"]) == ("too-many-steps", None, None)
    assert "more steps than" in turned["why"]
    for row in refused:
        assert (row["status"], row["peak"], row["hic"]) == ("refused", None, None)
        assert row["why"].startswith("vehicle2.members.points.2.0: need ")


def test_a_parameter_without_effect_is_said(tmp_path):
    study = {
        "kind": "sweep",
        "scenario": "p1",
        "outcomes": ["adult.excursion.max"],
        "parameters": [
            {"path": "child.restraint.stiffness", "values": ["40 kN/m", "60 kN/m"]},
            {"path": "adult.restraint.stiffness", "values": ["40 kN/m", "60 kN/m"]},
        ],
    }
    remarks = read_manifest(run(tmp_path / "out", study=study))["remarks"]
    assert len(remarks) == 1
    assert remarks[0].startswith("child.restraint.stiffness has no effect")
