"""`orient check`: everything that can be known about the health of a project file, line by line."""

import os
import sqlite3
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import Connection

from orient.errors import OrientError, ProjectError, UsageError
from orient.store import images, verify
from orient.store.error_map import translated
from orient.store.errors import Corrupt, DiskFull, Locked, OutOfMemory, ReadOnly, Stopped, Unreadable
from orient.store.fingerprint import check_pages
from orient.store.format import Format, current_format
from orient.store.gate import Gated, pass_gate, recover, require_writable, tidy
from orient.store.preflight import Preflight, preflight
from orient.words import counted

OLDEST_SQLITE = (3, 37, 0)
SAFE_SQLITE = (3, 50, 2)
SHOWN = 5
"""Problems that one line names."""


@dataclass(frozen=True, slots=True)
class CheckLine:
    """One thing that was looked at; `hint` says what to do, where something special is to be done."""

    name: str
    ok: bool
    detail: str
    hint: str = ""


@dataclass(slots=True)
class CheckReport:
    """All lines; `ok` only if every line is."""

    lines: list[CheckLine] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        return all(line.ok for line in self.lines)

    def add(self, name: str, ok: bool, detail: str, hint: str = "") -> None:
        self.lines.append(CheckLine(name, ok, detail, hint))


def check_project(path: str | os.PathLike[str], progress: verify.Progress | None = None) -> CheckReport:
    """Check a project from its first byte to its last digest; removes a stale journal if the file can be written.

    A missing file is a `UsageError`, one that may not be read an `Unreadable`; everything else that is wrong is a line
    of the report. `progress(done, total)` is told the rows whose digests were made.
    """
    form = current_format()
    report = CheckReport()
    report.add(*_library())
    try:
        look = preflight(path, form)
        report.add("file", True, f"an orient project of format {form.version}, {look.size} bytes")
        _check_open_file(report, look, form, progress)
    except (UsageError, Unreadable, Stopped, Locked, DiskFull, OutOfMemory):
        raise  # they say nothing about the file
    except OrientError as error:
        report.add("file", False, error.message, error.hint)
    return report


def _library() -> tuple[str, bool, str]:
    version = sqlite3.sqlite_version
    if sqlite3.sqlite_version_info < OLDEST_SQLITE:
        return "SQLite", False, f"{version} is too old, orient needs 3.37"
    note = "" if sqlite3.sqlite_version_info >= SAFE_SQLITE else " (older than 3.50.2: has known faults; update it)"
    return "SQLite", True, version + note


def _check_open_file(report: CheckReport, look: Preflight, form: Format, progress: verify.Progress | None) -> None:
    for warning in look.warnings:
        report.add("place", True, warning)
    if look.journal == "hot":
        recover(look)
        report.add("journal", True, "an interrupted command was undone; nothing of it is stored")
    gated = pass_gate(look, "read", form, with_checks=False)
    try:
        report.add("schema", True, f"{len(form.objects)} objects as orient makes them")
        with translated(look.path, gated.watch), gated.begin():
            _check_pages(report, gated.connection, look.path)
            _check_ledger(report, gated.connection, form, progress)
    finally:
        gated.close()
    _tidy_journal(report, look, form)


def _check_pages(report: CheckReport, connection: Connection, path: Path) -> None:
    try:
        check_pages(connection, path, thorough=True)
    except Corrupt as error:
        report.add("pages", False, error.message)
    else:
        report.add("pages", True, "integrity_check and foreign_key_check are clean")
    # the open transaction holds the lock that keeps writers from the file while its size is looked at
    pages, page_size = (
        connection.exec_driver_sql(f"PRAGMA {name}").scalar_one() for name in ("page_count", "page_size")
    )
    expected, size = pages * page_size, path.stat().st_size
    if size != expected:
        report.add(
            "size", False, f"the file has {size} bytes, its pages {expected}: something was added behind its end"
        )


def _check_ledger(report: CheckReport, connection: Connection, form: Format, progress: verify.Progress | None) -> None:
    runs = connection.exec_driver_sql("SELECT count(*) FROM main.stage_run").scalar_one()
    parts: tuple[tuple[str, Callable[[], Iterable[str]], str], ...] = (
        ("seals", lambda: verify.unsealed_runs(connection), f"{counted(runs, 'run')}, all sealed"),
        ("numbers", lambda: verify.broken_sequences(connection), "runs, versions and selections have no gap"),
        ("rows", lambda: verify.strange_rows(connection), "every row belongs to the stage of its run"),
        ("digests", lambda: verify.broken_runs(connection, form, progress), "all inputs and results as sealed"),
        ("selections", lambda: verify.broken_selections(connection), "all name results of their stage"),
        *_attached(connection),
    )
    for name, find, clean in parts:
        problems = list(_readable(find))
        shown = "; ".join(problems[:SHOWN]) + (f"; and {len(problems) - SHOWN} more" if len(problems) > SHOWN else "")
        report.add(name, not problems, shown or clean)


def _attached(connection: Connection) -> Iterator[tuple[str, Callable[[], Iterable[str]], str]]:
    """Lines about an image and a manifest, where there is one."""
    embedded = "SELECT count(*) FROM main.image WHERE n_parts > 0"
    if connection.exec_driver_sql("SELECT count(*) FROM main.image").scalar_one():
        count = connection.exec_driver_sql(embedded).scalar_one()
        told = "as its SHA-256 says" if count else "known by its SHA-256 only"
        yield "image", lambda: images.broken_images(connection), told
    if connection.exec_driver_sql("SELECT count(*) FROM main.sealed_file").scalar_one():
        yield "manifest", lambda: images.broken_manifests(connection), "tells the digests of the ledger"


def _readable(find: Callable[[], Iterable[str]]) -> Iterator[str]:
    found = verify.guarded(lambda: list(find()))
    yield from [found] if isinstance(found, str) else found


def _tidy_journal(report: CheckReport, look: Preflight, form: Format) -> None:
    if look.journal != "stale" or not report.ok:
        return
    gated: Gated | None = None
    with suppress(ReadOnly, Locked):
        require_writable(look.path)
        gated = pass_gate(look, "write", form, with_checks=False)
        with translated(look.path, gated.watch):
            tidy(gated, form)
        report.add("journal", True, "a stale journal of an interrupted command was removed")
    if gated is not None:
        gated.close()


def verify_runs(connection: Connection, form: Format, path: Path) -> None:
    """After a recovery: pages and every digest, or a `ProjectError` with the first thing that is wrong."""
    check_pages(connection, path, thorough=True)
    for problem in verify.all_problems(connection, form):
        raise ProjectError(f"{path}: {problem}.", "Use a backup.")
