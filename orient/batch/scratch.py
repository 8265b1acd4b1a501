"""A folder for the workers' own files, gone afterwards; what a killed batch has left goes with the next one."""

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PREFIX = "orient-batch-"
ALIVE = "alive"
"""The batch holds a lock on this file as long as it lives."""


@contextmanager
def scratch_folder() -> Iterator[str]:
    if fcntl is not None:
        _sweep(Path(tempfile.gettempdir()))
    with (
        tempfile.TemporaryDirectory(prefix=PREFIX, ignore_cleanup_errors=True) as folder,
        open(Path(folder, "new"), "w") as file,
    ):
        if fcntl is not None:
            fcntl.flock(file, fcntl.LOCK_EX)
        Path(folder, "new").rename(Path(folder, ALIVE))  # with its lock: nobody sees it without
        yield folder


def _sweep(base: Path) -> None:
    """Remove our own folders whose batch was killed: nobody holds their lock."""
    for left in base.glob(f"{PREFIX}*"):
        with suppress(OSError):
            status = left.lstat()
            if stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid():
                _remove_if_dead(left)


def _remove_if_dead(folder: Path) -> None:
    with open(folder / ALIVE) as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        shutil.rmtree(folder, ignore_errors=True)
