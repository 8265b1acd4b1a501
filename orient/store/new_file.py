"""Files that appear under their name only when they are whole."""

import errno
import os
import secrets
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from orient.errors import OrientError, UsageError
from orient.store.error_map import NO_SPACE, disk_errors
from orient.store.errors import ReadOnly, StorageError
from orient.store.preflight import is_open_here
from orient.words import typed

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

PREFIX, SUFFIX = ".orient-", ".new"
SIDE_FILES = ("-journal", "-wal", "-shm")
NO_LINKS = (errno.EPERM, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK, errno.EXDEV)
NO_SYNC = (errno.EINVAL, errno.EBADF, errno.EROFS)
LONGEST_NAME = 240
"""Bytes; file systems take 255, a journal beside it needs some."""


def new_name(path: str | os.PathLike[str], replace: bool = False) -> Path:
    """The absolute path of a new project; an existing name is a `UsageError`, unless it may be replaced."""
    target = name_in_folder(path, "the project")
    if target.name.endswith(SIDE_FILES):
        raise UsageError(
            f"{os.fspath(path)}: such a name belongs to SQLite's own files beside a project.", "Give another name."
        )
    if os.path.lexists(target) and not replace:
        raise UsageError(f"{os.fspath(path)} exists.", "Give a new name.")
    return target


def name_in_folder(path: str | os.PathLike[str], what: str) -> Path:
    """The absolute path of a file to be written, in a folder that is there; links are not followed."""
    text = os.fspath(path)
    if not text or "\0" in text:
        raise UsageError(f"the name of {what} is empty or contains a zero byte", "Give the name of a file.")
    if text.endswith(os.sep):
        raise UsageError(f"{text} is the name of a folder", "Give the name of a file.")
    target = absolute(text)
    if len(os.fsencode(target.name)) > LONGEST_NAME:
        raise UsageError(f"the name {target.name[:40]}... is too long", "Give a shorter one.")
    _require_folder(target.parent)
    return target


def absolute(name: str) -> Path:
    """Exactly this name, links are not followed."""
    try:
        return Path(os.path.abspath(name))  # noqa: PTH100  (Path.absolute keeps ..)
    except FileNotFoundError:
        raise UsageError("the current folder is gone", "Change to another one, or give absolute names.") from None


def _require_folder(folder: Path) -> None:
    try:
        is_folder = stat.S_ISDIR(folder.stat().st_mode)
    except FileNotFoundError:
        raise UsageError(f"the folder {folder} does not exist", "Create it first.") from None
    except NotADirectoryError:
        is_folder = False
    except OSError as error:
        raise UsageError(f"the folder {folder} cannot be used: {error.strerror}", "Choose another folder.") from None
    if not is_folder:
        raise UsageError(f"{folder} is no folder", "Give the name of a file in a folder.")


def make_file(target: Path, write: Callable[[Path], None], mode: int = 0o600, replace: bool = False) -> None:
    """Let `write` fill a temporary file in the same folder, then give it its name; no trace if anything fails."""
    with disk_errors(target), temporary_file(target.parent, mode) as temporary:
        try:
            write(temporary)
            give_name(temporary, target, replace)
        except FileExistsError:
            raise UsageError(f"{target} exists.", "Give a new name.") from None
        except OrientError as error:
            error.message = error.message.replace(str(temporary), str(target))
            raise


@contextmanager
def temporary_file(folder: Path, mode: int = 0o600) -> Iterator[Path]:
    """An empty file that is gone afterwards, with its journal; what killed commands left in the folder goes before.

    The lock says that its maker lives. It is closed last: closing a file drops SQLite's own locks on it.
    """
    sweep(folder)
    is_done = False
    while not is_done:
        path, descriptor = folder / f"{PREFIX}{secrets.token_hex(8)}{SUFFIX}", None
        try:  # before the file is there: a stop can arrive at once
            descriptor = _created(path, mode)
            with suppress(OSError):
                _lock(descriptor, patiently=True)
            if os.fstat(descriptor).st_nlink:  # else another command swept it away before it was locked
                yield path
                is_done = True
        finally:
            with suppress(OSError):  # a disk that fails keeps it; the next command sweeps it away
                _remove(path)
            if descriptor is not None:
                os.close(descriptor)


def _created(path: Path, mode: int) -> int:
    flags = os.O_CREAT | os.O_EXCL | os.O_RDWR | getattr(os, "O_NOFOLLOW", 0)
    try:
        return os.open(path, flags, mode)
    except OSError as error:
        if error.errno in NO_SPACE:
            raise
        raise ReadOnly(f"{path.parent} cannot be written: {error.strerror}.", "Choose another folder.") from None


def sweep(folder: Path) -> None:
    """Remove temporary files whose maker was killed: nobody holds their lock. What cannot be read stays."""
    found: list[Path] = []
    with suppress(OSError):
        found.extend(folder.glob(f"{PREFIX}*{SUFFIX}"))
    for left in found:
        with suppress(OSError):
            if is_open_here(left):  # another name of a project that this process has open: closing drops its locks
                continue
            descriptor = os.open(left, os.O_RDWR | getattr(os, "O_NOFOLLOW", 0))
            try:
                _lock(descriptor)
                _remove(left)
            finally:
                os.close(descriptor)


def _lock(descriptor: int, patiently: bool = False) -> None:
    """Raise OSError if another command holds the file; where there are no such locks nothing is swept."""
    if fcntl is None:
        raise OSError("no locks")
    fcntl.flock(descriptor, fcntl.LOCK_EX if patiently else fcntl.LOCK_EX | fcntl.LOCK_NB)


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
        except OSError as error:
            if error.errno not in NO_LINKS:
                raise
            _replace_reservation(temporary, target)
    sync_name(target)


def _replace_reservation(temporary: Path, target: Path) -> None:
    """Where there are no hard links: reserve the name, then replace the reservation."""
    try:
        os.close(os.open(target, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        temporary.replace(target)
    except FileExistsError:
        raise
    except BaseException:  # a stop too
        if temporary.exists() and target.exists() and not target.stat().st_size:
            target.unlink()
        raise


def sync_content(path: Path) -> None:
    """Make the content of a file survive a power cut; no connection to it may be open, its locks would be dropped."""
    with path.open("r+b") as file:
        os.fsync(file.fileno())


def sync_name(path: Path) -> None:
    """Make the name of a file survive a power cut, where the system can; the file itself was synced before."""
    try:
        descriptor = os.open(path.parent, os.O_RDONLY)
    except OSError:  # a folder cannot be opened on Windows
        return
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in NO_SYNC:
            message = f"{path} is written, but the disk reported an error at its folder ({error.strerror})."
            raise StorageError(message, f"Check it with: orient check {typed(path.name)}") from error
    finally:
        os.close(descriptor)
