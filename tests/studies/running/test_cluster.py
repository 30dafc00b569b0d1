"""The same study on a Dask cluster: the same bits, a lost worker or not."""

from __future__ import annotations

import os
import signal
import threading
import time

import pytest

from ridedown.errors import InvalidInput
from ridedown.studies.running import execution
from tests.studies.small import contents, run

distributed = pytest.importorskip("distributed")

pytestmark = [
    # of distributed itself: sockets and loops that it closes as it ends
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]


def test_no_scheduler_is_said_so(tmp_path, monkeypatch):
    monkeypatch.setattr(execution, "_PATIENCE", 1)
    with pytest.raises(InvalidInput, match=r"--cluster: got .*no Dask scheduler answers"):
        run(tmp_path / "out", cluster="tcp://127.0.0.1:1")


def test_a_cluster_gives_the_same_bits_even_if_a_worker_is_killed(tmp_path):
    whole = contents(run(tmp_path / "here"))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit=0
    ) as cluster:
        killed = threading.Event()

        def kill_one(progress):
            if progress.done and not killed.is_set():
                killed.set()
                os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)
                time.sleep(0.1)

        run(tmp_path / "there", cluster=cluster.scheduler_address, report=kill_one)
        assert killed.is_set()
    assert contents(tmp_path / "there") == whole
