"""A project of an older format walks to the newest one: same rows, same digests."""

import gzip
import hashlib
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from orient.errors import OrientError, ProjectError
from orient.models import SCHEMA_VERSION
from orient.pipeline.registry import BY_NAME
from orient.pipeline.runner import run_stale
from orient.store import creation, schema_files
from orient.store.check import check_project
from orient.store.digest import output_digest
from orient.store.project import open_project
from orient.store.upgrade import upgrade_project

DATA = Path(__file__).parents[1] / "data"
OLD = DATA / "format-1" / "calgary-27.sqlite.gz"
LATER = sorted(path for path in DATA.glob("format-*/*.sqlite.gz") if path != OLD)
MODEL_ROW = {"zone": "z", "point": "p", "x": 1.0, "y": 2.0, "z": 3.0}
NO_COVARIANCE = dict.fromkeys(("cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz"))


@pytest.fixture
def old(tmp_path: Path) -> Path:
    path = tmp_path / "photo.sqlite"
    path.write_bytes(gzip.decompress(OLD.read_bytes()))
    return path


def seals(path: Path) -> list[tuple[object, ...]]:
    query = "SELECT run_id, status, row_count, output_digest, record_digest FROM run_seal ORDER BY run_id"
    with closing(sqlite3.connect(path)) as connection:
        return connection.execute(query).fetchall()


def test_an_older_format_is_named_with_its_remedy(old: Path) -> None:
    with pytest.raises(ProjectError, match="has format 1") as error:
        open_project(old)
    assert error.value.hint.startswith("Run: orient upgrade photo.sqlite")


def test_an_old_project_walks_to_the_newest_format(old: Path) -> None:
    content, sealed = old.read_bytes(), seals(old)
    done = upgrade_project(old)
    assert (done.before, done.after) == (1, SCHEMA_VERSION)
    assert done.backup is not None and done.backup.read_bytes() == content
    assert seals(old) == sealed
    assert {status for _, status, *_ in sealed} == {"succeeded", "failed"}
    assert check_project(old).ok
    with open_project(old) as project:
        model = project.read_tables(project.heads()["model"].run_id)["model_point"]
        run = project.heads()["model"]
    assert [(row["zone"], row["point"], row["cov_xx"]) for row in model] == [
        ("north", "100", None), ("north", "102", None), ("south", "105", None),
    ]  # fmt: skip
    assert output_digest({"model_point": model}) == run.output_digest


@pytest.mark.parametrize("packed", LATER, ids=lambda path: f"{path.parent.name}-{path.name.split('.')[0]}")
def test_every_old_file_walks_to_the_newest_format(packed: Path, tmp_path: Path) -> None:
    """Same content in the backup, same seals, every digest right; what is current stays current."""
    path = tmp_path / "photo.sqlite"
    path.write_bytes(gzip.decompress(packed.read_bytes()))
    content, sealed = path.read_bytes(), seals(path)
    done = upgrade_project(path)
    assert (f"format-{done.before}", done.after) == (packed.parent.name, SCHEMA_VERSION)
    assert done.backup is not None and done.backup.read_bytes() == content
    assert seals(path) == sealed and len(sealed) > 4
    assert check_project(path).ok


@pytest.mark.parametrize(
    ("packed", "kept"),
    [(OLD, set[str]()), (DATA / "format-2" / "calgary-28.sqlite.gz", {"refine"})],
    ids=["format 1", "format 2"],
)
def test_an_upgraded_project_computes_only_what_changed_since(packed: Path, kept: set[str], tmp_path: Path) -> None:
    """A stage of the same version and settings, whose inputs were not computed again, keeps its result."""
    old = tmp_path / "photo.sqlite"
    old.write_bytes(gzip.decompress(packed.read_bytes()))
    upgrade_project(old)
    with open_project(old) as project:
        before = project.heads()
    results = run_stale(old, {}, "test", lambda stage: None, lambda result: None)
    again: set[str] = set()
    for stage in (stage for stage in BY_NAME.values() if stage.name != "digitize"):  # it waits for a sheet
        head = before.get(stage.name)
        is_the_same = head is not None and head.stage_version == stage.version
        has_more = head is None or not set(stage.settings) <= {*head.settings, *stage.formerly}
        if not is_the_same or has_more or again.intersection(stage.inputs):
            again.add(stage.name)
    waiting = {result.stage for result in results if result.waits_for}
    assert {result.stage for result in results if result.computed} == again - waiting
    assert "resection" in again and {*before} & {*BY_NAME} - again == kept


def test_columns_of_a_later_format_without_values_do_not_change_a_digest() -> None:
    """The digest is that of format 1: columns zone, point, x, y, z, as written out here."""
    written = (
        '["s:output",{"model_point":{"columns":["s:point","s:x","s:y","s:z","s:zone"],'
        '"rows":[["s:p","f:0x1.0000000000000p+0","f:0x1.0000000000000p+1","f:0x1.8000000000000p+1","s:z"]]}}]'
    )
    assert (
        output_digest({"model_point": [{**MODEL_ROW, **NO_COVARIANCE}]}) == hashlib.sha256(written.encode()).hexdigest()
    )
    some = output_digest({"model_point": [{**MODEL_ROW, **dict.fromkeys(NO_COVARIANCE, 0.0)}]})
    assert some != output_digest({"model_point": [{**MODEL_ROW, **NO_COVARIANCE}]})


def test_the_migration_in_work_is_what_the_models_ask_for() -> None:
    folder = creation.migrations_folder()
    before = schema_files.frozen_tables([(folder / name).read_text("utf-8") for name in schema_files.BEFORE])
    text = schema_files.migration_ddl(before, schema_files.models_ddl())
    assert (folder / schema_files.IN_WORK).read_text("utf-8") == text, "run: make schema"


def test_a_changed_table_is_rebuilt_with_its_rows_and_a_new_one_is_made() -> None:
    before = {"a": "CREATE TABLE a (\n\tx INTEGER NOT NULL, \n\ty REAL\n)\n STRICT"}
    wider = "CREATE TABLE a (\n\tx INTEGER NOT NULL, \n\ty REAL, \n\tz REAL CHECK (z IS NULL OR y > 0)\n)\n STRICT"
    after = {"a": (wider, ["CREATE INDEX ix_a ON a (x)"]), "b": ("CREATE TABLE b (\n\tx TEXT\n)\n STRICT", [])}
    text = schema_files.migration_ddl(before, after)
    with closing(sqlite3.connect(":memory:")) as connection:
        connection.executescript(f"{before['a']}; INSERT INTO a VALUES (1, 2.5); CREATE INDEX ix_a ON a (y)")
        connection.executescript(text)
        assert connection.execute("SELECT * FROM a").fetchall() == [(1, 2.5, None)]
        assert connection.execute("SELECT sql FROM sqlite_schema WHERE name = 'a'").fetchone() == (wider,)
        names = connection.execute("SELECT name FROM sqlite_schema ORDER BY name").fetchall()
    assert names == [("a",), ("b",), ("ix_a",)]
    with pytest.raises(OrientError, match="tables cannot go: a"):
        schema_files.migration_ddl(before, {})
