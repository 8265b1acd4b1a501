"""Look at the file and at what lies beside it before connecting: some files hurt when SQLite opens them.

No connection to the file may be open in this process: closing a file drops SQLite's lock on it (RELIABILITY.md P1).
"""

import os
import stat
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from orient.errors import ProjectError, UsageError
from orient.store.errors import Corrupt, Unreadable
from orient.store.format import Format
from orient.words import typed

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

Journal = Literal["none", "hot", "stale", "live"]

SQLITE_MAGIC = b"SQLite format 3\x00"
JOURNAL_MAGIC = bytes.fromhex("d9d505f920a163d7")
RESERVED_BYTE = 0x40000001
"""SQLite's writer holds a lock on this byte of the file."""

KNOWN_APPLICATIONS = {
    0x47504B47: "GeoPackage",
    0x47503130: "GeoPackage 1.0",
    0x4D504258: "MBTiles",
    0x0F055111: "Fossil",
    0: "unnamed",
}
NETWORK_FILE_SYSTEMS = frozenset({"nfs", "nfs4", "cifs", "smb3", "smbfs", "fuse.sshfs", "9p", "afs", "ncpfs"})


OPEN_FILES: Counter[tuple[int, int]] = Counter()
"""Device and inode of the files this process is connected to: they have passed and must not be opened beside SQLite."""


@dataclass(frozen=True, slots=True)
class Preflight:
    """A file that may be connected to: its real path, its size, the state of a journal beside it, remarks."""

    path: Path
    size: int
    journal: Journal
    warnings: tuple[str, ...] = field(default=())


def preflight(path: str | os.PathLike[str], form: Format, any_version: bool = False) -> Preflight:
    """Refuse by name what is not a healthy project of this format; `any_version` lets older formats through."""
    real = real_path(path)
    is_written = True
    if not is_open_here(real):
        header, is_written = _read_header(real)
        _check_header(header, real)
        _check_identity(header, real, form, any_version)
    warnings = []
    links = real.stat().st_nlink
    if links > 1:
        warnings.append(f"{real} has {links} names (hard links); an upgrade or a copy separates them.")
    if is_on_network(real):
        warnings.append(f"{real} lies on a network file system, whose locks cannot be trusted.")
    return Preflight(real, real.stat().st_size, _side_files(real, is_written), tuple(warnings))


def is_open_here(path: Path) -> bool:
    return OPEN_FILES[identity(path)] > 0


def identity(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_dev, status.st_ino


def real_path(path: str | os.PathLike[str]) -> Path:
    """The absolute path of a regular file, symbolic links followed once."""
    text = os.fspath(path)
    if not text:
        raise UsageError("The name of the project is empty.", "Give the name of a file.")
    if "\0" in text:
        raise UsageError("The name of the project contains a zero byte.", "Give the name of a file.")
    absolute = Path(os.path.abspath(text))  # noqa: PTH100  (resolve() would follow links before they are looked at)
    try:
        real = absolute.resolve(strict=True)
        mode = real.lstat().st_mode
    except FileNotFoundError:
        hint = f"Create one with: orient new {typed(text)} --from FOLDER"
        raise UsageError(f"no such project: {text}.", hint) from None
    except (RuntimeError, OSError) as error:
        raise _unreadable(f"{text} cannot be opened", error) from None
    if not stat.S_ISREG(mode):
        raise ProjectError(f"{text} is not a regular file.", "Give the name of a project file.")
    return real


def _unreadable(what: str, error: Exception) -> Unreadable:
    hint = "Ask for the right to read it and to search its folder." if isinstance(error, PermissionError) else ""
    return Unreadable(f"{what}: {_reason(error)}.", hint)


def _reason(error: Exception) -> str:
    loops = isinstance(error, RuntimeError) or getattr(error, "errno", None) == 40
    return "too many links" if loops else str(getattr(error, "strerror", None) or error)


def _read_header(path: Path) -> tuple[bytes, bool]:
    """The first 100 bytes, and whether another process is writing now."""
    try:
        with path.open("rb") as file:
            return file.read(100), _is_being_written(file.fileno())
    except OSError as error:
        raise _unreadable(f"{path} cannot be read", error) from None


def _is_being_written(descriptor: int) -> bool:
    if fcntl is None:
        return False
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB, 1, RESERVED_BYTE)
    except OSError:
        return True
    return False


def _check_header(header: bytes, path: Path) -> None:
    if not header:
        raise ProjectError(f"{path} is empty.", "Create a project under a new name with: orient new")
    if header[:16] != SQLITE_MAGIC:
        raise ProjectError(f"{path} is not an orient project (not an SQLite file).")
    if len(header) < 100:
        raise Corrupt(f"{path} is damaged (truncated).", "Use a backup.")
    page_size = int.from_bytes(header[16:18], "big")
    is_power = page_size == 1 or (page_size >= 512 and page_size & (page_size - 1) == 0)
    if not is_power or header[20] != 0 or header[21:24] != b"\x40\x20\x20":
        raise Corrupt(f"{path}: damaged header.", "Use a backup.")


def _check_identity(header: bytes, path: Path, form: Format, any_version: bool) -> None:
    application = int.from_bytes(header[68:72], "big")
    if application != form.application_id:
        name = KNOWN_APPLICATIONS.get(application)
        known = f" = {name}" if name else ""
        raise ProjectError(f"{path} belongs to another program (application_id 0x{application:08x}{known}).")
    if header[18:20] == b"\x02\x02":
        raise ProjectError(
            f"{path}: another program changed this file to WAL mode.",
            f"Run: orient receive {typed(path.name)} COPY",
        )
    if header[18:20] != b"\x01\x01":
        raise Corrupt(f"{path}: damaged header.", "Use a backup.")
    if int.from_bytes(header[56:60], "big") != 1:
        raise ProjectError(f"{path} was not written by orient (text encoding).")
    _check_version(int.from_bytes(header[60:64], "big", signed=True), path, form, any_version)


def _check_version(version: int, path: Path, form: Format, any_version: bool) -> None:
    if version > form.version:
        message = f"{path} was written by a newer orient (format {version}, this one knows {form.version})."
        raise ProjectError(message, _way_back(path, form.version))
    if version < 1:
        raise ProjectError(f"{path} has an unknown format ({version}).", "Use a backup.")
    if version < form.version and not any_version:
        raise ProjectError(f"{path} has format {version}.", f"Run: orient upgrade {typed(path.name)} (keeps a backup)")


def _way_back(path: Path, version: int) -> str:
    """There is no downgrade; an upgrade has kept the file as it was before."""
    for older in range(version, 0, -1):
        kept = path.with_name(f"{path.name}.bak-{older:04d}")
        if kept.is_file():
            return f"Upgrade orient, or go back to what the upgrade kept: {kept.name}"
    return "Upgrade orient."


def _side_files(path: Path, is_written: bool) -> Journal:
    for tail in ("-wal", "-shm"):
        if os.path.lexists(f"{path}{tail}"):
            raise ProjectError(
                f"a {tail} file lies beside {path}.",
                "Close the other program, or move it away: it does not belong here.",
            )
    return _journal_state(Path(f"{path}-journal"), is_written)


def _journal_state(journal: Path, is_written: bool) -> Journal:
    """none, stale (harmless), live (of a running command) or hot (of a killed one: SQLite will undo it)."""
    try:
        mode = journal.lstat().st_mode
    except FileNotFoundError:
        return "none"
    if not stat.S_ISREG(mode):
        raise ProjectError(f"{journal} is not a regular file.", "It was not written by orient; move it away.")
    head, tail = _ends(journal)
    if tail == JOURNAL_MAGIC:
        raise ProjectError(
            f"the file {journal.name} names another file. It was not written by orient and could delete that file.",
            "Move it away if you do not know it.",
        )
    if is_written:
        return "live"  # its first bytes are written last
    return "hot" if head == JOURNAL_MAGIC else "stale"


def _ends(journal: Path) -> tuple[bytes, bytes]:
    try:
        with journal.open("rb") as file:
            head = file.read(8)
            size = file.seek(0, os.SEEK_END)
            file.seek(max(0, size - 8))
            return head, file.read(8) if size > 8 else b""
    except FileNotFoundError:  # the command that wrote it has just finished
        return b"", b""
    except OSError as error:
        raise _unreadable(f"{journal} cannot be read", error) from None


def is_on_network(path: Path) -> bool:
    """True if the mount table says so; False where there is no mount table."""
    best, kind = "", ""
    with suppress(OSError):
        for line in Path("/proc/mounts").read_text(encoding="utf-8", errors="replace").splitlines():
            fields = line.split(" ")
            mount = fields[1].replace("\\040", " ") if len(fields) > 2 else ""
            if len(mount) >= len(best) and f"{path}/".startswith(mount.rstrip("/") + "/"):
                best, kind = mount, fields[2]
    return kind in NETWORK_FILE_SYSTEMS
