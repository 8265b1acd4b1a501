"""A result is gone with its worker when that dies before it was fetched: dask works on the chunk again."""

import time
from collections.abc import Iterator
from typing import Any

import psutil
import pytest

from orient.batch import cluster

WORK_S = 0.5


@pytest.fixture
def client() -> Iterator[Any]:
    """One worker and a client that is not the default one, as in a batch."""
    distributed = pytest.importorskip("distributed")
    import dask

    quick = {"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": []}
    with (
        dask.config.set(quick),
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as workers,
        distributed.Client(workers, set_as_default=False) as client,
    ):
        yield client


def test_lost_result_is_waited_for(client: Any) -> None:
    future = client.submit(_slow_square, 7, pure=False)
    assert future.result() == 49
    (worker,) = client.run(_process_number).values()
    psutil.Process(worker).kill()
    give_up = time.monotonic() + 60
    while future.status == "finished":
        assert time.monotonic() < give_up
        time.sleep(0.01)
    assert cluster._is_finished(client, future)
    assert future.result() == 49


def _slow_square(x: int) -> int:
    time.sleep(WORK_S)
    return x * x


def _process_number() -> int:
    import os

    return os.getpid()
