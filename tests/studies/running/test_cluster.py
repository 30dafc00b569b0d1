"""The same study on a Dask cluster: the same bits, a lost worker or not."""

from __future__ import annotations

import os
import signal
import threading
import time
from dataclasses import dataclass, replace

import pytest

from ridedown.errors import InvalidInput
from ridedown.studies import run_study
from ridedown.studies.file.study import load_study
from ridedown.studies.results.store import read_manifest
from ridedown.studies.rows.plan import plan_of
from ridedown.studies.running import kept, workers
from ridedown.studies.running.execution import run_plan
from tests.studies.running.test_kinds import BOUND, BOX, FRONT, OPTIMISE, RARE, Failing, made
from tests.studies.small import contents, run

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")

pytestmark = [
    # of distributed itself: sockets and loops that it closes as it ends
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]


def test_no_scheduler_is_said_so(tmp_path, monkeypatch):
    monkeypatch.setattr(workers, "_PATIENCE", 1)
    with pytest.raises(InvalidInput, match=r"--cluster: got .*no Dask scheduler answers"):
        run(tmp_path / "out", cluster="tcp://127.0.0.1:1")


@pytest.mark.parametrize("address", ["localhost", "tcp://localhost", "foo://host:8786", ""])
def test_an_address_that_is_none_is_refused_at_once(tmp_path, address, monkeypatch):
    made = []
    monkeypatch.setattr("dask.distributed.Client", lambda *_, **__: made.append(1))
    with pytest.raises(InvalidInput, match=r'--cluster: got .*need an address such as "tcp://host:8786"'):
        run(tmp_path / "out", cluster=address)
    assert made == []


@pytest.fixture(scope="module")
def cluster():
    """Two workers; one that is lost is started anew."""
    with cluster_of(2) as made:
        yield made


@pytest.fixture
def address(cluster):
    """Of its scheduler, once it has both workers."""
    with distributed.Client(cluster, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)
    return cluster.scheduler_address


def cluster_of(count):
    """Processes of this machine."""
    return distributed.LocalCluster(
        n_workers=count, threads_per_worker=1, processes=True, dashboard_address=":0", memory_limit=0
    )


def kill_one(cluster):
    """What kills a worker when the first row has been computed, and whether it has."""
    killed = threading.Event()

    def report(progress):
        if progress.done and not killed.is_set():
            killed.set()
            os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
            time.sleep(0.1)

    return report, killed


def test_a_cluster_gives_the_same_bits_even_if_a_worker_is_killed(tmp_path, cluster, address):
    whole = contents(run(tmp_path / "here"))
    report, killed = kill_one(cluster)
    run(tmp_path / "there", cluster=address, report=report)
    assert killed.is_set()
    assert contents(tmp_path / "there") == whole


SEARCHES = {"one": OPTIMISE, "several": FRONT, "box": BOX, "rare": RARE}


@pytest.mark.parametrize("study", [*SEARCHES.values(), BOUND], ids=[*SEARCHES, "bound"])
def test_every_kind_keeps_the_same_bytes_on_a_cluster(tmp_path, study, address, monkeypatch):
    monkeypatch.setattr(kept, "_PIECE", 16)  # so that a request of these small searches is several tasks
    here, there = run_study(study, tmp_path / "here"), run_study(study, tmp_path / "there", cluster=address)
    assert made(there) == made(here)


def test_a_search_outlives_a_worker(tmp_path, cluster, address):
    whole = made(run_study(OPTIMISE, tmp_path / "here"))
    report, killed = kill_one(cluster)
    run_study(OPTIMISE, tmp_path / "there", cluster=address, report=report)
    assert killed.is_set()
    assert made(tmp_path / "there") == whole


def test_a_search_that_broke_off_here_is_gone_on_with_on_a_cluster(tmp_path, address):
    loaded = load_study(FRONT)
    plan = replace(plan_of(loaded), chunk_rows=32)
    whole, broken = run_plan(loaded, plan, tmp_path / "whole"), tmp_path / "broken"
    failing = Failing(plan.function, read_manifest(whole)["rows"] // 2)
    with pytest.raises(OSError, match="unplugged"):
        run_plan(loaded, replace(plan, function=failing), broken)
    assert 0 < len(contents(broken)) < len(contents(whole))
    before = []
    run_plan(loaded, plan, broken, resume=True, cluster=address, report=lambda progress: before.append(progress.before))
    assert before[-1] > 0
    assert made(broken) == made(whole)


@dataclass(frozen=True)
class Deadly:
    """A function that takes the worker with it."""

    home: int

    @property
    def units(self):
        return plan_of(load_study(OPTIMISE)).function.units

    def rows(self, columns):
        if os.getpid() != self.home:
            os.kill(os.getpid(), signal.SIGKILL)
        return plan_of(load_study(OPTIMISE)).function.rows(columns)


def test_a_task_that_loses_worker_after_worker_is_said_so(tmp_path, monkeypatch):
    monkeypatch.setattr(workers, "_AGAIN", 0)
    loaded = load_study(OPTIMISE)
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), cluster_of(1) as cluster:
        plan = replace(plan_of(loaded), function=Deadly(os.getpid()))
        with pytest.raises(InvalidInput, match="lost with its workers"):
            run_plan(loaded, plan, tmp_path / "out", cluster=cluster.scheduler_address)
