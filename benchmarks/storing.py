"""Rows into project files and out of them, new files, the pipeline of a small photo; against plain sqlite3."""

import sqlite3
import tempfile
from collections.abc import Callable, Iterator, Mapping
from itertools import count
from pathlib import Path

import numpy as np

from benchmarks.measuring import WALL, Task
from benchmarks.scenes import F_MM, photo
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create, run_stale
from orient.solvers.lean_resection import lean_resection
from orient.store.digest import content_of, input_digest, rows_digest
from orient.store.project import NewRun, Project, create_project, open_project
from orient.values import Columns, InputTables, Outcome

SAMPLE = Path(__file__).parents[1] / "sample_projects" / "calgary-28"
LARGE = 200_000
NAMES = ("point", "kind", "cycle", "x_mm", "y_mm", "col_px", "row_px", "sigma")
DURABLE = "PRAGMA synchronous = EXTRA"
Rows = dict[str, list[tuple[object, ...]]]


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
        for pragma in (DURABLE, "PRAGMA foreign_keys = ON", "PRAGMA recursive_triggers = ON"):
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
    create_project(path, lambda project: _append(project, _run(_readings(LARGE))))

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


def _append(project: Project, run: NewRun) -> None:
    project.append(run)


def _small_photo(folder: Path) -> Iterator[Task]:
    """The rows of a whole small photo: stored in one new file, then computed and stored stage by stage."""
    name, inputs = _fresh(folder), read_project(SAMPLE, ReadOptions())
    done = folder / "done.sqlite"
    _pipeline(done, inputs)
    stages, rows = _rows_of(done)
    total = sum(len(values) for values in rows.values())

    def new_file() -> None:
        path = name()
        create(path, inputs, "bench")
        path.unlink()

    def new_by_hand() -> None:
        _by_hand(name(), {table: values for table, values in rows.items() if table in inputs_of(inputs)}, commits=1)

    def own() -> None:
        path = name()
        _pipeline(path, inputs)
        path.unlink()

    one = photo(8)

    def by_hand() -> None:
        lean_resection(one.image, one.ground, F_MM, one.R0, one.S0)
        _by_hand(name(), rows, commits=stages)

    yield Task(
        "new file with the lists of a small photo",
        {"orient": new_file, "sqlite3 by hand": new_by_hand},
        2.5,
        None,
        clock=WALL,
    )
    note = f"{total} rows, {stages} durable commits on both sides, a lean solver beside sqlite3"
    name_of = "pipeline of a small photo in one process, new file included"
    yield Task(name_of, {"orient": own, "sqlite3 by hand + lean solver": by_hand}, 4.0, None, note=note, clock=WALL)


def inputs_of(inputs: list[InputTables]) -> set[str]:
    return {table for given in inputs for table in given.tables}


def _pipeline(path: Path, inputs: list[InputTables]) -> None:
    create(path, inputs, "bench")
    run_stale(path, {}, "bench", lambda stage: None, lambda result: None)


def _rows_of(path: Path) -> tuple[int, Rows]:
    """Number of commits that made the file, and all its rows by table."""
    connection = sqlite3.connect(path)
    tables = [row[0] for row in connection.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")]
    rows = {table: connection.execute(f'SELECT * FROM "{table}"').fetchall() for table in tables}
    commits = 1 + sum(
        1 for row in rows["stage_run"] if row[1] in ("refine", "bl", "topocentric", "resection", "covariance")
    )
    connection.close()
    return commits, {table: values for table, values in rows.items() if values}


def _by_hand(path: Path, rows: Mapping[str, list[tuple[object, ...]]], commits: int) -> None:
    """The same rows in plain tables without keys, checks or triggers."""
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute("BEGIN")
    for table, values in rows.items():
        connection.execute(f'CREATE TABLE "{table}" ({", ".join(f"c{i}" for i in range(len(values[0])))})')
    parts = np.array_split(list(rows), commits)
    for number, part in enumerate(parts):
        if number:
            connection.execute("BEGIN")
        for table in part.tolist():
            marks = ", ".join("?" * len(rows[table][0]))
            connection.executemany(f'INSERT INTO "{table}" VALUES ({marks})', rows[table])
        connection.execute("COMMIT")
    connection.close()
    path.unlink()
