"""SQLite's errors as sentences for people, by error name and never by message text (RELIABILITY.md 4.6)."""

import errno
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy.exc import DBAPIError, StatementError

from orient.errors import OrientError, ProjectError
from orient.store.errors import (
    Corrupt,
    DiskFull,
    Hostile,
    Locked,
    NeedsRecovery,
    OurFault,
    OutOfMemory,
    ReadOnly,
    Replaced,
    Stopped,
    StorageError,
)
from orient.store.watch import Watch

NO_SPACE = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
NO_RIGHT = (errno.EROFS, errno.EACCES, errno.EPERM)
BUSY = ("SQLITE_BUSY", "SQLITE_LOCKED")
WAITED_S = 30
LARGEST_VALUE = 64 * 2**20
"""Bytes; a smaller file cannot hold a value that passes the limit of the connection."""
NOTHING_STORED = "Nothing of this step was stored."
"""True also for a command of several steps, of which the first ones are stored and were reported."""
REPORT = "This is a mistake in orient; please report it."


@contextmanager
def translated(path: Path, watch: Watch) -> Iterator[None]:
    """Errors of SQLite, and those that SQLite provokes in Python, leave as `OrientError`."""
    try:
        yield
    except OrientError:
        raise
    except DBAPIError as error:
        raise explain(error.orig or error, path, watch) from error
    except (sqlite3.Error, MemoryError, UnicodeError, OverflowError, RecursionError) as error:
        raise explain(error, path, watch) from error
    except StatementError as error:
        raise explain(error.orig or error, path, watch) from error


@contextmanager
def disk_errors(path: Path) -> Iterator[None]:
    """Errors of the system while files are made, named or read leave as `OrientError` about `path`."""
    try:
        yield
    except OSError as error:
        raise explain_os(error, path) from error


def explain_os(error: OSError, path: Path) -> OrientError:
    """The `OrientError` for an error of the system at `path`."""
    if error.errno in NO_SPACE:
        return _disk_full(path, "")
    if error.errno in NO_RIGHT:
        return _read_only(path, "")
    return _storage(path, error.strerror or type(error).__name__)


def error_name(error: BaseException) -> str:
    """SQLite's extended error name, e.g. SQLITE_IOERR_WRITE; empty if the error is not SQLite's."""
    original = error.orig if isinstance(error, DBAPIError) else error
    return str(getattr(original, "sqlite_errorname", "") or "")


def is_busy(error: BaseException) -> bool:
    return error_name(error).startswith(BUSY)


def explain(error: BaseException, path: Path, watch: Watch) -> OrientError:
    """The `OrientError` for an error that came out of SQLite while `path` was open."""
    if isinstance(error, MemoryError):
        return _no_memory(path, watch)
    if isinstance(error, UnicodeDecodeError):
        return Corrupt(f"{path} is damaged (text that is not UTF-8).", "Use a backup. Nothing was changed.")
    if isinstance(error, UnicodeEncodeError):
        return OrientError("A text cannot be stored: it is not valid Unicode.", "Check the names in the input.")
    if isinstance(error, OverflowError):
        return OrientError("A number is too large to be stored as a whole number.", "Check the input.")
    name = error_name(error)
    if not name and "not UTF-8" not in str(error) and "decode" not in str(error):
        return OurFault(f"{path}: {type(error).__name__}: {error}", REPORT)
    return _by_name(name, error, path, watch)


def _by_name(name: str, error: BaseException, path: Path, watch: Watch) -> OrientError:
    if name.startswith("SQLITE_INTERRUPT"):
        return _interrupted(path, watch)
    for prefixes, build in TABLE:
        if name.startswith(prefixes):
            return build(path, name)
    is_our_sql = name in ("SQLITE_ERROR", "SQLITE_RANGE", "SQLITE_MISUSE", "SQLITE_MISMATCH") and watch.phase != "setup"
    if name.startswith("SQLITE_CONSTRAINT") or is_our_sql:
        return OurFault(f"{path} refused a statement ({name}: {error}).", REPORT)
    return Corrupt(f"{path} is damaged ({error}).", "Use a backup. Nothing was changed.")


def _interrupted(path: Path, watch: Watch) -> OrientError:
    if watch.is_stopped:
        return Stopped("Stopped. Nothing was stored.")
    return _hostile(path, "something that takes too long to read")


def _hostile(path: Path, what: str) -> ProjectError:
    return Hostile(f"{path} contains content orient never writes ({what}). It was not opened.")


def _no_memory(path: Path, watch: Watch) -> OrientError:
    """While a large file is examined, a value of its own that passes all limits; else the machine's memory is full."""
    size = path.stat().st_size if path.exists() else 0
    if watch.phase == "setup" and size > LARGEST_VALUE:
        return _hostile(path, "a value too large for memory")
    message = f"not enough memory for {path} ({size / 1e6:.1f} MB). {NOTHING_STORED}"
    return OutOfMemory(message, "Give fewer points, or a machine with more memory.")


def _locked(path: Path, name: str) -> ProjectError:
    return Locked(f"{path} is in use by another command (waited {WAITED_S} s). {NOTHING_STORED}", "Run it again.")


def _disk_full(path: Path, name: str) -> ProjectError:
    return DiskFull(f"No space left while writing {path}. {NOTHING_STORED}", "Free some space and run again.")


def _needs_recovery(path: Path, name: str) -> ProjectError:
    return NeedsRecovery(
        f"{path}: an interrupted command must be undone first, but the folder is read-only.",
        "Copy the project and its -journal file to a writable folder.",
    )


def replaced(path: Path, name: str = "") -> ProjectError:
    message = f"{path} was replaced or removed while this command worked (an upgrade?)."
    return Replaced(f"{message} {NOTHING_STORED}", "Run it again.")


def _read_only(path: Path, name: str) -> ProjectError:
    return ReadOnly(f"{path} cannot be written (read-only file or folder). Reading commands work.", "Copy it to write.")


def _storage(path: Path, name: str) -> ProjectError:
    return StorageError(
        f"The disk reported an error at {path} ({name.removeprefix('SQLITE_')}). {NOTHING_STORED}",
        "Check it with: orient check",
    )


def _too_big(path: Path, name: str) -> ProjectError:
    return _hostile(path, "a value too large" if name == "SQLITE_TOOBIG" else "an action that is not allowed")


TABLE = (
    (BUSY, _locked),
    (("SQLITE_FULL", "SQLITE_IOERR_WRITE"), _disk_full),
    (("SQLITE_READONLY_ROLLBACK", "SQLITE_READONLY_RECOVERY"), _needs_recovery),
    (("SQLITE_READONLY_DBMOVED",), replaced),
    (("SQLITE_READONLY", "SQLITE_CANTOPEN", "SQLITE_PERM"), _read_only),
    (("SQLITE_IOERR",), _storage),
    (("SQLITE_TOOBIG", "SQLITE_AUTH", "SQLITE_NOMEM"), _too_big),
)
"""First match wins; what no line names is damage."""
