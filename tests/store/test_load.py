"""Many versions and many rows: `status` and `log` read the ledger only, and `check` keeps its memory.

Counted are operations of SQLite, which no busy machine can change, and bytes of memory; never seconds.
"""

import sqlite3
import tracemalloc
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from orient.report.status import CURRENT, LOG, STATUS
from orient.store import connection as module
from orient.store.check import check_project
from orient.store.connection import CACHE_SIZE, SPILL_PAGES, let_spill, room_to_append, scalar
from orient.store.digest import input_digest, output_digest
from orient.store.project import NewRun, Project, create_project, open_project
from orient.values import Columns, Outcome
from tests.store.made import make_full, new_run, readings

STEP = 100


@contextmanager
def counted(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """Number of times that SQLite has done STEP operations, on all connections opened inside."""
    total = [0]

    def hardened(*arguments: object) -> sqlite3.Connection:
        opened = original(*arguments)  # type: ignore[arg-type]

        def tick() -> bool:
            total[0] += 1
            return False

        opened.set_progress_handler(tick, STEP)
        return opened

    original = module.hardened
    monkeypatch.setattr(module, "hardened", hardened)
    yield total
    monkeypatch.undo()


def work_of(sql: str, path: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    with counted(monkeypatch) as total, open_project(path, "read") as project:
        before = total[0]
        project.query(sql)
        return total[0] - before


def with_rows(path: Path, count: int) -> Path:
    make_full(path)
    with open_project(path, "write") as project:
        project.append(new_run(project, "readings", outcome=readings(count)))
    return path


def with_versions(path: Path, count: int) -> Path:
    """`count` further versions of the photo, each of a few rows."""
    make_full(path)
    with open_project(path, "write") as project:
        for number in range(count):
            project.append(new_run(project, "photo", seed=1.0 + number))
    return path


@pytest.mark.parametrize("sql", [STATUS, CURRENT, LOG], ids=["stale", "current", "log"])
def test_the_ledger_does_not_grow_with_the_rows(sql: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = work_of(sql, with_rows(tmp_path / "few.sqlite", 10), monkeypatch)
    many = work_of(sql, with_rows(tmp_path / "many.sqlite", 5000), monkeypatch)
    assert many <= few + 2  # the handler's own phase


@pytest.mark.parametrize("sql", [STATUS, CURRENT, LOG], ids=["stale", "current", "log"])
def test_work_is_at_most_linear_in_the_versions(sql: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    base, some, many = (
        work_of(sql, with_versions(tmp_path / f"{count}.sqlite", count), monkeypatch) for count in (0, 60, 240)
    )
    assert many - base <= 4.4 * max(some - base, 5)


def test_check_reads_in_portions(tmp_path: Path) -> None:
    """100 000 rows of 10 columns are 80 MB as Python objects; a portion is 4096 of them."""
    n = 100_000
    names = [f"P{i:06}" for i in range(n)]
    x = np.random.default_rng(1).uniform(-100, 100, n)
    nothing = [None] * n
    rows = Columns(
        {"seq": list(range(n)), "point": names, "kind": ["point"] * n, "cycle": [1] * n, "x_mm": x, "y_mm": x,
         "col_px": nothing, "row_px": nothing, "sigma": nothing}
    )  # fmt: skip

    def fill(project: Project) -> None:
        tables = {"comparator_reading": rows}
        digest = input_digest("readings", 1, {}, {"content": output_digest(tables)})
        project.append(NewRun("readings", 1, {}, {}, digest, Outcome(tables), {}, "tester", "load"))

    path = tmp_path / "large.sqlite"
    create_project(path, fill)
    seen: list[tuple[int, int]] = []
    tracemalloc.start()
    report = check_project(path, lambda done, total: seen.append((done, total)))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert report.ok and len(seen) > n / 5000 and seen[-1] == (n, n)
    assert peak < 20e6


def test_a_large_append_is_not_kept_in_memory(tmp_path: Path) -> None:
    create_project(tmp_path / "p.sqlite")
    with open_project(tmp_path / "p.sqlite", "write") as project, project.snapshot() as connection:
        assert connection.exec_driver_sql("SELECT 1").scalar() == 1
        driver = connection.connection.driver_connection
        assert isinstance(driver, sqlite3.Connection)
        driver.set_authorizer(None)
        assert driver.execute("PRAGMA cache_spill").fetchone()[0] == SPILL_PAGES


@pytest.mark.parametrize("may_spill", [False, True])
def test_the_page_cache_is_large_only_while_rows_are_appended(tmp_path: Path, may_spill: bool) -> None:
    """As large as an append may grow before it spills; nothing more where it may spill at once."""
    create_project(tmp_path / "p.sqlite")
    with open_project(tmp_path / "p.sqlite", "write") as project, project.snapshot() as connection:
        if may_spill:
            let_spill(connection)
        pages = scalar(connection, "PRAGMA page_size"), scalar(connection, "PRAGMA cache_spill")
        with room_to_append(connection):
            size = scalar(connection, "PRAGMA cache_size")
        assert scalar(connection, "PRAGMA cache_size") == CACHE_SIZE
        assert size == (pages[1] if may_spill else SPILL_PAGES)
        assert not may_spill or size * pages[0] <= -CACHE_SIZE * 1024
