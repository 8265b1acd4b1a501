"""`orient backup`, `receive` and `seal`: a copy gets its name only after every digest in it was found good."""

import hashlib
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from sqlalchemy import Connection

from orient.errors import OrientError, ProjectError
from orient.store import verify
from orient.store.connection import compact_into, let_spill, open_engine
from orient.store.error_map import NO_SPACE, translated
from orient.store.fingerprint import check_fingerprint, check_pages
from orient.store.format import Format, current_format
from orient.store.gate import recover
from orient.store.new_file import SIDE_FILES, make_file, new_name, temporary_file
from orient.store.preflight import preflight, real_path
from orient.store.project import Project, open_project
from orient.store.watch import Watch

CHUNK = 2**20
WAL, ROLLBACK = b"\x02\x02", b"\x01\x01"
VERSIONS = slice(18, 20)
"""Bytes of the header that say how the file is written: rollback journal or write-ahead log."""


@dataclass(frozen=True, slots=True)
class Copied:
    """A verified copy: where it is, how big, how many sealed runs it holds, and the SHA-256 of the whole file."""

    path: Path
    size: int
    runs: int
    sha256: str


def backup_project(
    source: str | os.PathLike[str], target: str | os.PathLike[str], progress: verify.Progress | None = None
) -> Copied:
    """A copy of one moment of a project, with the rights of the source; a damaged project is refused by name.

    Other commands may go on reading and writing meanwhile. An existing `target` is never touched.
    """
    form = current_format()
    look = preflight(source, form)
    name = new_name(target)
    if look.journal == "hot":
        recover(look)
    runs: list[int] = []

    def write(temporary: Path) -> None:
        copy_pages(look.path, temporary)
        runs.append(_verified(temporary, form, look.path, progress))

    make_file(name, write, look.path.stat().st_mode & 0o777)
    return _copied(name, runs[0])


def receive_project(
    stranger: str | os.PathLike[str], target: str | os.PathLike[str], progress: verify.Progress | None = None
) -> Copied:
    """A clean copy of a file of unknown origin: same runs, nothing else; what is not sound is refused by name.

    SQLite never opens the stranger's file itself: its bytes are copied first, a file that another program left in
    WAL mode is set back, schema, pages and all digests of the copy are examined, and what was found good is written
    anew, without the free pages in which older content may hide. Side files are refused: what they hold is not
    sealed.
    """
    form = current_format()
    source, name = real_path(stranger), new_name(target)
    _refuse_side_files(source)
    runs: list[int] = []

    def write(temporary: Path) -> None:
        with temporary_file(name.parent) as raw:
            _copy_bytes(source, raw)
            _set_rollback_mode(raw)
            _verified_stranger(raw, form, source, progress)
            with translated(name, Watch()):
                compact_into(raw, temporary)
            runs.append(_verified(temporary, form, source, None))

    make_file(name, write)
    return _copied(name, runs[0])


def seal_project(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    add: Callable[[Project], None],
    progress: verify.Progress | None = None,
    replace: bool = False,
) -> Copied:
    """A compacted copy of one moment, to which `add` appends what goes along before it is verified and named."""
    form = current_format()
    name = new_name(target, replace)
    with open_project(source) as project:  # undoes what was interrupted, refuses what is not sound at first sight
        path = project.path

    def write(temporary: Path) -> None:
        with translated(path, Watch()):
            compact_into(path, temporary)
        with Project(preflight(temporary, form), "write", form, with_checks=False) as copy:
            copy.let_spill()
            add(copy)
        runs.append(_verified(temporary, form, path, progress))

    runs: list[int] = []
    make_file(name, write, path.stat().st_mode & 0o777, replace)
    return _copied(name, runs[0])


def copy_pages(source: Path, target: Path) -> None:
    """Copy through SQLite, from a second connection that only reads (a writing one would wait for itself)."""
    readers, writers = open_engine(source, "read", Watch()), open_engine(target, "write", Watch())
    try:
        with translated(source, Watch()), readers.connect() as reader, writers.connect() as writer:
            let_spill(writer)
            into = writer.connection.driver_connection
            reader.connection.driver_connection.backup(into)  # type: ignore[union-attr]
    finally:
        readers.dispose()
        writers.dispose()


def _verified(path: Path, form: Format, told: Path, progress: verify.Progress | None) -> int:
    """The number of sealed runs of a copy in which schema, pages and digests are good; `told` is named if not."""
    watch = Watch()
    engine = open_engine(path, "read", watch)
    try:
        with translated(path, watch), engine.connect() as connection, connection.begin():
            check_fingerprint(connection, form, told)
            check_pages(connection, told, thorough=True)
            for problem in verify.all_problems(connection, form, progress):
                raise ProjectError(f"{told}: {problem}.", "No copy was made. See everything with: orient check")
            return _count_runs(connection)
    finally:
        engine.dispose()


def _count_runs(connection: Connection) -> int:
    return int(connection.exec_driver_sql("SELECT count(*) FROM main.run_seal").scalar_one())


def _verified_stranger(raw: Path, form: Format, source: Path, progress: verify.Progress | None) -> None:
    """The same examination, preceded by that of the header; messages name the file that was sent."""
    with _told_as(source, raw):
        preflight(raw, form)
        _verified(raw, form, source, progress)


@contextmanager
def _told_as(name: Path, temporary: Path) -> Iterator[None]:
    """Messages name the file that the user knows."""
    try:
        yield
    except OrientError as error:
        error.message = error.message.replace(str(temporary), str(name))
        raise


def _refuse_side_files(source: Path) -> None:
    for tail in SIDE_FILES:
        if os.path.lexists(f"{source}{tail}"):
            raise ProjectError(
                f"a {tail} file lies beside {source}: the project was copied while a program had it open.",
                "Ask for a copy made with: orient backup",
            )


def _copy_bytes(source: Path, target: Path) -> None:
    """The very bytes; a file that grows or changes meanwhile is refused."""
    try:
        with source.open("rb") as reader, target.open("r+b") as writer:
            before = os.fstat(reader.fileno())
            shutil.copyfileobj(reader, writer, CHUNK)
            after = os.fstat(reader.fileno())
    except OSError as error:
        if error.errno in NO_SPACE:
            raise
        raise ProjectError(f"{source} cannot be copied: {error.strerror}.") from None
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
        raise ProjectError(f"{source} changed while it was read.", "Try again.")


def _set_rollback_mode(path: Path) -> None:
    """A file in WAL mode without its log holds everything in its pages; only two bytes of the header say otherwise."""
    with path.open("r+b") as file:
        header = file.read(VERSIONS.stop)
        if header[VERSIONS] == WAL:
            file.seek(VERSIONS.start)
            file.write(ROLLBACK)


def _copied(path: Path, runs: int) -> Copied:
    digest = hashlib.sha256()
    with path.open("rb") as file:
        for chunk in iter(partial(file.read, CHUNK), b""):
            digest.update(chunk)
    return Copied(path, path.stat().st_size, runs, digest.hexdigest())
