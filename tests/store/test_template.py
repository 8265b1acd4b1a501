"""A new project from its schema text: what the migrations build, and with runs what is stored through the file."""

import sqlite3
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from orient.store import ledger, project
from orient.store.check import check_project
from orient.store.connection import execute
from orient.store.creation import fill_empty_file, format_of
from orient.store.digest import input_digest, output_digest
from orient.store.errors import OurFault
from orient.store.format import current_format
from orient.store.project import NewRun, are_small, create_project, create_project_with, open_project
from orient.store.template import empty_project
from orient.values import Event, Outcome
from tests.store.made import outcome_of, readings

COUNTERS = (slice(24, 28), slice(92, 100))
"""Of the header: how often the file was changed, and by which SQLite last."""


@pytest.fixture(autouse=True)
def _one_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ledger, "now", lambda: "2026-01-01T00:00:00.000Z")


def list_of(stage: str, outcome: Outcome) -> NewRun:
    digest = input_digest(stage, 1, {}, {"content": output_digest(outcome.tables, outcome.events)})
    return NewRun(stage, 1, {}, {}, digest, outcome, {}, "tester", "a test")


def lists() -> list[NewRun]:
    return [list_of("photo", outcome_of("photo")), list_of("readings", readings(200))]


def content(path: Path) -> bytes:
    """The bytes of a file but its counters."""
    file = bytearray(path.read_bytes())
    for counter in COUNTERS:
        file[counter] = bytes(counter.stop - counter.start)
    return bytes(file)


def test_the_template_is_what_the_migrations_build(tmp_path: Path) -> None:
    form = current_format()
    built, written = tmp_path / "built.sqlite", tmp_path / "written.sqlite"
    built.touch()
    fill_empty_file(built, form.version, form.application_id)
    create_project(written)
    told = [format_of(path, form.version, form.application_id, form.head) for path in (built, written)]
    assert told[0] == told[1]
    heads = [path.read_bytes()[:100] for path in (built, written)]
    assert heads[0][60:72] == heads[1][60:72]  # user_version, incremental vacuum, application_id


def test_runs_in_memory_are_those_through_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    create_project_with(tmp_path / "memory.sqlite", lists())
    monkeypatch.setattr(project, "MOST_IN_MEMORY", 0)
    create_project_with(tmp_path / "file.sqlite", lists())
    assert content(tmp_path / "memory.sqlite") == content(tmp_path / "file.sqlite")
    assert check_project(tmp_path / "memory.sqlite").ok


def test_what_is_kept_stays_empty(tmp_path: Path) -> None:
    for name in ("before", "after"):
        create_project(tmp_path / f"{name}.sqlite")
        create_project_with(tmp_path / f"{name}-lists.sqlite", lists())
    assert (tmp_path / "before.sqlite").read_bytes() == (tmp_path / "after.sqlite").read_bytes()
    assert (tmp_path / "before-lists.sqlite").read_bytes() == (tmp_path / "after-lists.sqlite").read_bytes()


@pytest.mark.parametrize(
    ("statement", "told"),
    [
        ("INSERT INTO alembic_version VALUES ('0001')", "by orient upgrade only"),
        ("DELETE FROM alembic_version", "not authorized"),
        ("ATTACH ':memory:' AS other", "not authorized"),
    ],
)
def test_guards_and_authorizer_hold_in_memory(statement: str, told: str) -> None:
    with pytest.raises(sqlite3.DatabaseError, match=told), empty_project(current_format()) as connection:
        execute(connection, statement)


def test_an_error_leaves_nothing_in_memory(tmp_path: Path) -> None:
    create_project_with(tmp_path / "before.sqlite", lists())
    outcome = readings(3)
    wrong = [{**row, "kind": "cloud"} for row in outcome.tables["comparator_reading"]]
    refused = list_of("readings", Outcome({"comparator_reading": wrong}))
    with pytest.raises(OurFault) as told:
        create_project_with(tmp_path / "wrong.sqlite", [*lists(), refused])
    assert f"{tmp_path / 'wrong.sqlite'} refused a statement (SQLITE_CONSTRAINT_CHECK" in told.value.message
    create_project_with(tmp_path / "after.sqlite", lists())
    with pytest.raises(OurFault, match='does not write table "clouds"'):
        unknown = Outcome({"clouds": [{"seq": 1}]})
        create_project_with(tmp_path / "wrong.sqlite", [replace(lists()[1], outcome=unknown)])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["after.sqlite", "before.sqlite"]
    assert (tmp_path / "before.sqlite").read_bytes() == (tmp_path / "after.sqlite").read_bytes()


def test_one_is_kept_until_an_error() -> None:
    form = current_format()
    with empty_project(form) as first:
        pass
    with empty_project(form) as second:
        assert second is first
    with pytest.raises(ZeroDivisionError), empty_project(form):
        raise ZeroDivisionError
    with empty_project(form) as third:
        assert third is not first


def test_each_thread_has_its_own(tmp_path: Path) -> None:
    paths = [tmp_path / f"{number}.sqlite" for number in range(8)]
    with ThreadPoolExecutor(4) as threads:
        list(threads.map(lambda path: create_project_with(path, lists()), paths))
    assert len({path.read_bytes() for path in paths}) == 1
    with open_project(paths[0]) as one:
        assert list(one.heads()) == ["photo", "readings"]


def test_only_few_rows_are_kept_in_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(project, "MOST_IN_MEMORY", 200)
    assert are_small([list_of("readings", readings(200))])
    assert not are_small([list_of("readings", readings(201))])
    assert not are_small([list_of("readings", readings(150)), list_of("readings", readings(51))])
    assert not are_small([list_of("readings", Outcome({}, (Event("info", "told", "", ""),) * 201))])
    assert not are_small([list_of("image", outcome_of("image"))])  # with bytes
