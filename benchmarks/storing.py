"""Rows into project files and out of them, new files, the pipeline of a small photo; against plain sqlite3."""

import sqlite3
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np
from sqlalchemy import Connection

from benchmarks.measuring import WALL, Task
from benchmarks.scenes import F_MM, photo
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create, run_stale
from orient.solvers.lean_resection import lean_resection
from orient.store import ledger
from orient.store.digest import content_of, input_digest, rows_digest
from orient.store.format import Format
from orient.store.project import NewRun, create_project, create_project_with, open_project
from orient.store.runs import RunInfo
from orient.values import Columns, InputTables, Outcome

SAMPLE = Path(__file__).parents[1] / "sample_projects" / "calgary-28"
LARGE = 200_000
NAMES = ("point", "kind", "cycle", "x_mm", "y_mm", "col_px", "row_px", "sigma")
STRICT = ("PRAGMA synchronous = EXTRA", "PRAGMA foreign_keys = ON", "PRAGMA recursive_triggers = ON")
"""What orient sets too: durable, and with all guards at work."""
Commit = list[tuple[str, list[tuple[object, ...]]]]
"""Rows by table, in the order in which they are stored."""


def tasks() -> Iterator[Task]:
    folder = Path(tempfile.mkdtemp(prefix="orient-bench-"))
    for n in (1000, 10_000, LARGE):
        yield _insert(folder, n)
    yield _read(folder)
    yield from _small_photo(folder)


def _readings(n: int) -> Columns:
    xy = np.random.default_rng(2).uniform(-100, 100, (n, 2))
    names = [f"P{i:07}" for i in range(n)]
    nothing = [None] * n
    columns = (names, ["point"] * n, [1] * n, xy[:, 0], xy[:, 1], nothing, nothing, nothing)
    return Columns({"seq": list(range(1, n + 1)), **dict(zip(NAMES, columns, strict=True))})


def _run(rows: Columns) -> NewRun:
    content = content_of({"comparator_reading": rows})
    digest = input_digest("readings", 1, {}, {"content": content.digest})
    outcome = Outcome({"comparator_reading": rows})
    return NewRun("readings", 1, {}, {}, digest, outcome, {}, "bench", "bench", content=content)


def _fresh(folder: Path) -> Callable[[], Path]:
    numbers = count()
    return lambda: folder / f"{next(numbers)}-{id(numbers)}.sqlite"


def _insert(folder: Path, n: int) -> Task:
    """A list of n readings, from arrays to a durable commit; the same table, triggers and checks by hand."""
    rows, name = _readings(n), _fresh(folder)
    tuples = [(1, *row.values()) for row in rows]
    empty = folder / f"empty-{n}.sqlite"
    create_project(empty)
    template = empty.read_bytes()

    def own() -> None:
        path = name()
        path.write_bytes(template)
        with open_project(path, "write") as project:
            project.append(_run(rows))
        path.unlink()

    def by_hand() -> None:
        path = name()
        path.write_bytes(template)
        connection = sqlite3.connect(path, isolation_level=None)
        for pragma in STRICT:
            connection.execute(pragma)
        connection.execute("BEGIN IMMEDIATE")
        connection.execute("INSERT INTO stage_run VALUES (1, 'readings', 1, 1, '{}', '', '', '', '', '')")
        connection.executemany(f"INSERT INTO comparator_reading VALUES ({', '.join('?' * 10)})", tuples)
        connection.execute("COMMIT")
        connection.close()
        path.unlink()

    def digest() -> None:
        rows_digest(content_of({"comparator_reading": rows}).tables)

    note = "orient also casts and examines the values, makes the digest (timed alone beside it) and reads all rows back"
    candidates = {"orient": own, "orient, the digest alone": digest, "sqlite3.executemany": by_hand}
    return Task(f"insert {n} rows", candidates, None, None, ("insert rows", n), note, WALL)


def _read(folder: Path) -> Task:
    path = folder / "read.sqlite"
    create_project_with(path, [_run(_readings(LARGE))])

    def own() -> object:
        with open_project(path, "read") as project:
            by_name = project.read_columns(1)["comparator_reading"].by_name
        return np.column_stack([by_name["x_mm"], by_name["y_mm"]])

    def by_hand() -> object:
        connection = sqlite3.connect(path)
        cursor = connection.execute("SELECT * FROM comparator_reading WHERE run_id = 1 ORDER BY seq")
        x = {name: place for place, (name, *_) in enumerate(cursor.description)}["x_mm"]
        found = np.array([row[x : x + 2] for row in cursor.fetchall()])
        connection.close()
        return found

    return Task(f"read {LARGE} rows with all columns", {"orient": own, "sqlite3": by_hand}, 1.05, 1e-15, clock=WALL)


def _small_photo(folder: Path) -> Iterator[Task]:
    """A small photo: its lists, then all that its stages store, as one new file; last the stages computed too."""
    name, inputs = _fresh(folder), read_project(SAMPLE, ReadOptions())
    done, empty = folder / "done.sqlite", folder / "empty.sqlite"
    with _told_runs() as runs:
        _pipeline(done, inputs)
    create_project(empty)
    lists, *stages = _commits_of(done, len(inputs))
    everything = [row for commit in (lists, *stages) for row in commit]
    one = photo(8)

    def file_of_lists() -> None:
        path = name()
        create(path, inputs, "bench")
        path.unlink()

    def file_of_everything() -> None:
        path = name()
        create_project_with(path, runs)
        path.unlink()

    def pipeline() -> None:
        path = name()
        _pipeline(path, inputs)
        path.unlink()

    def task(what: str, own: Callable[[], None], commits: Sequence[Commit], solve: bool, target: float) -> Task:
        def by_hand(template: bytes) -> None:
            if solve:
                lean_resection(one.image, one.ground, F_MM, one.R0, one.S0)
            _by_hand(name(), template, commits)

        n_rows = sum(len(rows) for commit in commits for _, rows in commit)
        note = (
            f"{n_rows} rows in {len(commits)} durable commits; by hand into the same tables with their keys, checks "
            "and guards (orient's empty file copied), or into bare columns; nothing is cast, digested or read back"
        )
        kinds = {"sqlite3 by hand, same tables": empty.read_bytes(), "sqlite3 by hand, bare columns": b""}
        others = {kind: partial(by_hand, template) for kind, template in kinds.items()}
        return Task(what, {"orient": own, **others}, target, None, note=note, clock=WALL)

    yield task("new file with the lists of a small photo", file_of_lists, [lists], False, 2.5)
    yield task("new file with everything of a small photo", file_of_everything, [everything], False, 2.5)
    yield task("pipeline of a small photo, new file included", pipeline, [lists, *stages], True, 4.0)


def _pipeline(path: Path, inputs: list[InputTables]) -> None:
    create(path, inputs, "bench")
    run_stale(path, {}, "bench", lambda stage: None, lambda result: None)


@contextmanager
def _told_runs() -> Iterator[list[NewRun]]:
    """The runs that are appended meanwhile, as they would be appended to a file without any."""
    runs: list[NewRun] = []
    append = ledger.append

    def told(connection: Connection, new: NewRun, form: Format) -> RunInfo:
        runs.append(replace(new, expected_heads={}, content=None))
        return append(connection, new, form)

    ledger.append = told
    try:
        yield runs
    finally:
        ledger.append = append


def _commits_of(path: Path, n_lists: int) -> list[Commit]:
    """The rows of the file run by run; the lists are one commit, each stage is another."""
    connection = sqlite3.connect(path)
    tables = [row[0] for row in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")]
    last = ("run_seal", "selection")
    order = ["stage_run", *(name for name in tables if name not in ("stage_run", "alembic_version", *last)), *last]
    runs = [row[0] for row in connection.execute("SELECT run_id FROM stage_run ORDER BY run_id")]
    by_run = [
        [(table, connection.execute(f"SELECT * FROM {table} WHERE run_id = ?", (run,)).fetchall()) for table in order]
        for run in runs
    ]
    connection.close()
    filled = [[(table, rows) for table, rows in run if rows] for run in by_run]
    return [[row for run in filled[:n_lists] for row in run], *filled[n_lists:]]


def _by_hand(path: Path, template: bytes, commits: Sequence[Commit]) -> None:
    """The same rows in a copy of the file `template`; without one in tables without keys, checks or triggers."""
    path.write_bytes(template)
    connection = sqlite3.connect(path, isolation_level=None)
    for pragma in STRICT:
        connection.execute(pragma)
    made: set[str] = set()
    for commit in commits:
        connection.execute("BEGIN IMMEDIATE")
        for table, rows in commit:
            if not template and table not in made:
                connection.execute(f'CREATE TABLE "{table}" ({", ".join(f"c{i}" for i in range(len(rows[0])))})')
                made.add(table)
            connection.executemany(f'INSERT INTO "{table}" VALUES ({", ".join("?" * len(rows[0]))})', rows)
        connection.execute("COMMIT")
    connection.close()
    path.unlink()
