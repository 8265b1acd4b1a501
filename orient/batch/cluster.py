"""Where chunks are worked through: in this process, on a local cluster, or on the workers of a given scheduler."""

import logging
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from typing import Any

from orient.batch.photo_task import work_through
from orient.batch.scratch import scratch_folder
from orient.batch.values import LOST_CODE, Ending, Item, Order, Refusal
from orient.errors import OrientError, UsageError

Chunks = Sequence[Sequence[Item]]

INSTALL = "pip install 'orient[batch]', or --workers 0 to work in this process."
LOOPBACK = "127.0.0.1"
CLOSE_S, ANSWER_S = 5, 10
WORKER_DEATHS = 3
ONE_THREAD = {
    f"{name}_NUM_THREADS": 1 for name in ("OMP", "OPENBLAS", "MKL", "BLIS", "VECLIB_MAXIMUM", "NUMEXPR", "NUMBA")
}
"""A worker is one process with one thread: BLAS threads of several workers would only get in each other's way."""

LOCAL_CONFIG = {
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
    "distributed.scheduler.allowed-failures": WORKER_DEATHS,
    "distributed.nanny.pre-spawn-environ": ONE_THREAD,
    "distributed.worker.multiprocessing-method": "spawn",
    "distributed.worker.memory.target": False,
    "distributed.worker.memory.spill": False,
    "distributed.diagnostics.nvml": False,
}
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
        stack.enter_context(dask.config.set(LOCAL_CONFIG))
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
        stack.callback(cluster.close, timeout=CLOSE_S)
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
    stack.callback(client.close, timeout=CLOSE_S)
    return Pool(name, size, lambda chunks, order: _endings(client, chunks, order))


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise UsageError(f"batch needs the package {error.name} for its workers.", INSTALL) from None
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
    """Endings of chunks as they come. A chunk whose worker died again and again goes on photo by photo."""
    chunk_of = {_submitted(client, chunk, order): chunk for chunk in chunks}
    coming = _distributed().as_completed(list(chunk_of), loop=client.loop)
    try:
        for future in coming:
            chunk = chunk_of.pop(future)
            if future.status == "finished":
                yield future.result()
            elif future.status != "error":
                raise OrientError("the scheduler went away.", "What is done stays done: give the same command again.")
            elif len(chunk) > 1:
                singles = {_submitted(client, [item], order): [item] for item in chunk}
                chunk_of |= singles
                coming.update(list(singles))
            else:
                yield [_failed(chunk[0], future.exception())]
    finally:
        client.cancel(list(chunk_of))


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
