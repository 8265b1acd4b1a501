"""Where chunks are worked through: in this process, on a local cluster, or on the workers of a given scheduler."""

import logging
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any

from orient.batch.photo_task import work_through
from orient.batch.scratch import scratch_folder
from orient.batch.values import LOST_CODE, Ending, Item, Order, Refusal
from orient.errors import NotInstalled, OrientError, UsageError

Chunks = Sequence[Sequence[Item]]

WITHOUT = ", or --workers 0 to work in this process."
LOOPBACK = "127.0.0.1"
CLOSE_S, ANSWER_S = 5, 10
WORKER_DEATHS = 1
"""A chunk is given to another worker once before its photos are suspected."""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NUMBA_NUM_THREADS")
ONE_THREAD = dict.fromkeys(THREADS, 1)
"""A worker is one process with one thread: BLAS threads of several workers would only get in each other's way."""

LOCAL_CONFIG = {
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.scheduler.allowed-failures": WORKER_DEATHS,
    "distributed.nanny.pre-spawn-environ": ONE_THREAD,
    "distributed.worker.multiprocessing-method": "spawn",
    "distributed.worker.profile.enabled": False,
    "distributed.worker.memory.monitor-interval": "500ms",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.scheduler.active-memory-manager.start": False,
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.diagnostics.nvml": False,
    "distributed.deploy.lost-worker-timeout": "1 day",
}
"""Nobody looks at profiles and monitors. `lost-worker-timeout`: a worker that is being started again after its death is
not given up for good."""

LOST = Refusal(
    "the worker ended while it worked on this photo (killed, or out of memory), more than once.",
    "Try it alone: orient run PROJECT; or with more memory: --memory-mib.",
    LOST_CODE,
)


@dataclass(frozen=True, slots=True)
class Pool:
    """What works through chunks: its name for people, how many chunks at once, and the work itself."""

    name: str
    size: int
    work: Callable[[Chunks, Order], Iterator[list[Ending]]]


def in_process() -> Pool:
    """Without a cluster, in the order of the list."""
    return Pool("this process", 1, lambda chunks, order: (work_through(chunk, order) for chunk in chunks))


@contextmanager
def local_workers(count: int, memory_mib: int | None) -> Iterator[Pool]:
    """Worker processes on this machine, reachable over loopback and with this batch's own certificate only."""
    distributed = _distributed()
    import dask

    with ExitStack() as stack:
        scratch = stack.enter_context(scratch_folder())
        stack.enter_context(dask.config.set({**LOCAL_CONFIG, "temporary-directory": scratch}))
        stack.enter_context(_quiet())
        cluster = distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            host=LOOPBACK,
            dashboard_address=f"{LOOPBACK}:0",
            scheduler_kwargs={"dashboard": False},
            security=True,
            local_directory=scratch,
            silence_logs=logging.CRITICAL,
            memory_limit="auto" if memory_mib is None else memory_mib * 2**20,
            preload=["orient.batch.worker"],
        )
        stack.callback(_end_workers)
        stack.callback(_close, cluster)
        yield _pool_of(stack, distributed.Client(cluster, set_as_default=False), f"{count} on this machine", count)


@contextmanager
def workers_of(address: str) -> Iterator[Pool]:
    """The workers of a scheduler that is there already; nobody else is talked to."""
    distributed = _distributed()
    with ExitStack() as stack:
        stack.enter_context(_quiet())
        try:
            client = distributed.Client(address, timeout=ANSWER_S, set_as_default=False)
        except (OSError, TimeoutError, ValueError, TypeError, RuntimeError) as error:
            raise UsageError(f"no scheduler answers at {address} ({error}).", "Start one: dask scheduler") from None
        pool = _pool_of(stack, client, address, 1)
        _check_workers(client, address)
        yield replace(pool, size=len(client.nthreads()))


def _pool_of(stack: ExitStack, client: Any, name: str, size: int) -> Pool:
    stack.callback(_close, client)
    return Pool(name, size, lambda chunks, order: _endings(client, chunks, order))


def _close(opened: Any) -> None:
    """Politely; what does not answer in time is ended by others."""
    with suppress(TimeoutError):
        opened.close(timeout=CLOSE_S)


def _end_workers() -> None:
    """No worker outlives its batch. Killing one is safe: a project is as before or after each of its steps."""
    for child in multiprocessing.active_children():
        child.kill()
        child.join(CLOSE_S)


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise NotInstalled("the workers of batch need", [str(error.name)], "batch", WITHOUT) from None
    _broken_sockets_are_errors()
    return distributed


def _broken_sockets_are_errors() -> None:
    """The command line ends by SIGPIPE as other programs do; a worker that dies must not end the batch so."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)


@contextmanager
def _quiet() -> Iterator[None]:
    """What befalls a worker is told by the rows of its photos, not by log lines."""
    loggers = [logging.getLogger(name) for name in ("distributed", "tornado", "asyncio")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _check_workers(client: Any, address: str) -> None:
    """At least one worker, and all of them with the same orient: two versions could give two kinds of numbers."""
    from orient.batch.worker import version

    try:
        client.wait_for_workers(1, timeout=ANSWER_S)
    except TimeoutError:
        raise UsageError(f"the scheduler at {address} has no workers.", f"Start some: dask worker {address}") from None
    try:
        found = set(client.run(version).values())
    except Exception as error:
        hint = "Install this version of orient there."
        raise UsageError(f"the workers of {address} cannot work for orient: {error}.", hint) from None
    if found != {version()}:
        there = ", ".join(sorted(found))
        raise UsageError(f"the workers of {address} have other versions: {there}.", f"Here it is {version()}.")


def _endings(client: Any, chunks: Chunks, order: Order) -> Iterator[list[Ending]]:
    """Endings of chunks as they come. Photos whose worker died are worked on again at the end, one at a time.

    A chunk that only waited at a worker that died is suspected too; alone, the guilty photo is found.
    """
    suspects: list[Item] = []
    chunk_of = {_submitted(client, chunk, order): chunk for chunk in chunks}
    try:
        for future in _completed(client, list(chunk_of)):
            chunk = chunk_of.pop(future)
            if _is_finished(client, future):
                yield future.result()
            else:
                suspects += chunk
        for item in suspects:
            chunk_of[alone := _submitted(client, [item], order)] = [item]
            for future in _completed(client, [alone]):
                yield future.result() if _is_finished(client, future) else [_failed(item, future.exception())]
            del chunk_of[alone]
    finally:
        with suppress(Exception):  # the scheduler may be gone
            client.cancel(list(chunk_of))


def _completed(client: Any, futures: Sequence[Any]) -> Any:
    return _distributed().as_completed(futures, loop=client.loop)


def _is_finished(client: Any, future: Any) -> bool:
    while future.status in ("lost", "pending"):  # its worker died before the result was fetched: dask works again
        for _ in _completed(client, [future]):
            pass
    if future.status not in ("finished", "error"):
        raise OrientError("the scheduler went away.", "What is done stays done: give the same command again.")
    return bool(future.status == "finished")


def _submitted(client: Any, chunk: Sequence[Item], order: Order) -> Any:
    return client.submit(work_through, chunk, order, pure=False)


def _failed(item: Item, error: BaseException) -> Ending:
    from distributed.scheduler import KilledWorker

    if isinstance(error, KilledWorker):
        return Ending(item.path, LOST.exit_code, LOST.message, LOST.hint)
    return Ending(item.path, LOST_CODE, f"the worker failed: {type(error).__name__}: {error}", "Look at its log.")


def usual_workers() -> int:
    """One worker for each processor that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
