"""Files that appear under their name only when they are whole."""

import os
import secrets
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from orient.errors import ProjectError, UsageError
from orient.store.errors import ReadOnly

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PREFIX, SUFFIX = ".orient-", ".new"
SIDE_FILES = ("-journal", "-wal", "-shm")
LONGEST_NAME = 240
"""Bytes; file systems take 255, a journal beside it needs some."""


def new_name(path: str | os.PathLike[str], replace: bool = False) -> Path:
    """The absolute path of a new project; an existing name is a `ProjectError`, unless it may be replaced."""
    text = os.fspath(path)
    if not text or "\0" in text:
        raise UsageError("The name of the project is empty or contains a zero byte.", "Give the name of a file.")
    target = Path(os.path.abspath(text))  # noqa: PTH100  (links are not followed: a new file takes exactly this name)
    if target.name.endswith(SIDE_FILES):
        raise UsageError(f"{text}: such a name belongs to SQLite's own files beside a project.", "Give another name.")
    if len(os.fsencode(target.name)) > LONGEST_NAME:
        raise UsageError(f"the name {target.name[:40]}... is too long.", "Give a shorter one.")
    if os.path.lexists(target) and not replace:
        raise ProjectError(f"{text} exists.", "Give a new name.")
    if not target.parent.is_dir():
        raise ProjectError(f"the folder {target.parent} does not exist.", "Create it first.")
    return target


def make_file(target: Path, write: Callable[[Path], None], mode: int = 0o600, replace: bool = False) -> None:
    """Let `write` fill a temporary file in the same folder, then give it its name; no trace if anything fails."""
    with temporary_file(target.parent, mode) as temporary:
        write(temporary)
        try:
            give_name(temporary, target, replace)
        except FileExistsError:
            raise ProjectError(f"{target} exists.", "Give a new name.") from None


@contextmanager
def temporary_file(folder: Path, mode: int = 0o600) -> Iterator[Path]:
    """An empty file that is gone afterwards, with its journal; what killed commands left in the folder goes before.

    The lock says that its maker lives. It is closed last: closing a file drops SQLite's own locks on it.
    """
    _sweep(folder)
    path = folder / f"{PREFIX}{secrets.token_hex(8)}{SUFFIX}"
    descriptor = _created(path, mode)
    try:
        with suppress(OSError):
            _lock(descriptor)
        yield path
    finally:
        _remove(path)
        os.close(descriptor)


def _created(path: Path, mode: int) -> int:
    flags = os.O_CREAT | os.O_EXCL | os.O_RDWR | getattr(os, "O_NOFOLLOW", 0)
    try:
        return os.open(path, flags, mode)
    except OSError as error:
        raise ReadOnly(f"{path.parent} cannot be written: {error.strerror}.", "Choose another folder.") from None


def _sweep(folder: Path) -> None:
    """Remove temporary files whose maker was killed: nobody holds their lock."""
    for left in folder.glob(f"{PREFIX}*{SUFFIX}"):
        with suppress(OSError):
            descriptor = os.open(left, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))
            try:
                _lock(descriptor)
                _remove(left)
            finally:
                os.close(descriptor)


def _lock(descriptor: int) -> None:
    """Raise OSError if another command holds the file; where there are no such locks nothing is swept."""
    if fcntl is None:
        raise OSError("no locks")
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _remove(path: Path) -> None:
    for leftover in (Path(f"{path}-journal"), path):
        leftover.unlink(missing_ok=True)


def give_name(temporary: Path, target: Path, replace: bool = False) -> None:
    """Take the name only if nobody has it (FileExistsError): of two commands at once exactly one wins.

    With `replace` the name changes hands in one step.
    """
    if replace:
        temporary.replace(target)
    else:
        try:
            os.link(temporary, target)
        except FileExistsError:
            raise
        except OSError:  # no hard links on this file system: reserve the name, then replace the reservation
            os.close(os.open(target, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
            temporary.replace(target)
    sync_folder(target.parent)


def sync_folder(folder: Path) -> None:
    """Make the new name survive a power cut, where the system can."""
    with suppress(OSError):  # a folder cannot be opened on Windows
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
