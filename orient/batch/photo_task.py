"""The work on a chunk of photos: paths in, endings out. Runs in a worker; knows nothing of the cluster."""

import os
import socket
import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from orient.batch.numbers import ending_of
from orient.batch.values import Ending, Item, Order
from orient.errors import OrientError, UsageError
from orient.pipeline.runner import create, run_stale_in
from orient.store.errors import ChangedMeanwhile, Stopped
from orient.store.project import open_project
from orient.values import Scalar
from orient.words import typed

OUR_FAULT = 70
TRIES = 3
"""A project that another command changes meanwhile is taken up again; what that command stored is then known."""

ONE_AT_A_TIME = threading.Lock()
"""A worker with several threads works through one chunk at a time: the limits of SQLite hold for a whole process."""


def work_through(items: Sequence[Item], order: Order) -> list[Ending]:
    """Run each photo; one that fails is an ending with its reason, and the next one follows."""
    with ONE_AT_A_TIME:
        return [work_on(item, order) for item in items]


def work_on(item: Item, order: Order) -> Ending:
    """One photo: made from its folder if need be, everything stale computed, its numbers read back."""
    begun = time.perf_counter()
    try:
        ending = _ending(item, order)
    except Stopped:
        raise
    except OrientError as error:
        ending = Ending(item.path, error.exit_code, error.message, error.hint)
    except MemoryError:
        ending = Ending(item.path, 1, "not enough memory for this project", "Give fewer points, or more memory.")
    except Exception as error:
        said = f"this is a fault of orient itself: {type(error).__name__}: {error}"
        ending = Ending(
            item.path, OUR_FAULT, said, f"Please report it with the output of: orient run {typed(item.path)}"
        )
    where: dict[str, Scalar] = {"host": socket.gethostname(), "duration_s": time.perf_counter() - begun}
    numbers = {**ending.numbers, **where, "file_stamp": file_stamp(item.path)}
    return replace(ending, numbers=numbers)


def file_stamp(path: str) -> str:
    """Changes with every write to the file, also with one that sets the old time again; empty without a file."""
    try:
        status = Path(path).stat()
    except OSError:
        return ""
    return f"{status.st_size} {status.st_mtime_ns} {status.st_ctime_ns} {status.st_ino}"


def _ending(item: Item, order: Order) -> Ending:
    if item.refusal is not None:
        return Ending(item.path, item.refusal.exit_code, item.refusal.message, item.refusal.hint)
    if item.source:
        _make(item, order)
    for _ in range(TRIES - 1):
        try:
            return _run(item.path, order)
        except ChangedMeanwhile:
            continue
    return _run(item.path, order)


def _make(item: Item, order: Order) -> None:
    """A project that exists, also since a moment, stays as it is."""
    from orient.intake.project_folder import read_project

    path = Path(item.path)
    if os.path.lexists(path):
        return
    inputs = read_project(Path(item.source), order.reading)
    try:
        create(path, inputs, order.reason)
    except UsageError:
        if not os.path.lexists(path):
            raise


def _run(path: str, order: Order) -> Ending:
    with open_project(path, "write") as project:
        results = run_stale_in(project, order.settings, order.reason)
        return ending_of(project, path, results)
