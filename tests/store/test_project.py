"""The public door: create, append, read, select, ask."""

import stat
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from orient.errors import OrientError, ProjectError, UsageError
from orient.store import ledger, watch
from orient.store.check import check_project
from orient.store.errors import Locked, OurFault, ReadOnly, Stopped, StorageError
from orient.store.plain import CHUNK
from orient.store.project import Project, create_project, open_project
from orient.store.rows import TOGETHER
from orient.store.runs import settings_from_json
from orient.store.stage_tables import STAGE_TABLES
from orient.values import Event, Outcome
from tests.promises import Promise
from tests.store.made import EVENTS, INPUTS, fill, new_run, outcome_of, readings


def lies_alone(path: Path) -> bool:
    return [file.name for file in path.parent.iterdir()] == [path.name]


def test_a_new_project_is_private_and_alone(tmp_path: Path) -> None:
    path = tmp_path / "new.orient"
    create_project(path)
    assert lies_alone(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    with open_project(path) as project:
        assert project.heads() == {}
        assert project.runs() == []


def test_an_existing_name_is_never_touched(tmp_path: Path) -> None:
    path = tmp_path / "new.orient"
    path.write_text("mine")
    with pytest.raises(UsageError, match="exists"):
        create_project(path)
    assert path.read_text() == "mine"


@pytest.mark.parametrize("name", ["", "missing/new.orient", "a\0b"])
def test_names_that_cannot_be_created(tmp_path: Path, name: str) -> None:
    with pytest.raises(OrientError):
        create_project(tmp_path / name if name else "")
    assert list(tmp_path.iterdir()) == []


def test_a_failed_creation_leaves_nothing(tmp_path: Path) -> None:
    def fail(project: Project) -> None:
        fill(project, ["photo"])
        raise OrientError("the input is wrong")

    with pytest.raises(OrientError, match="the input is wrong"):
        create_project(tmp_path / "new.orient", fail)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("reason", [7, True, None, b"a test"])
def test_a_reason_that_is_no_text_is_not_stored(tmp_path: Path, reason: object) -> None:
    """SQLite makes a text of a number; the digest of the selection would be that of the number."""
    path = tmp_path / "new.orient"
    create_project(path, lambda project: fill(project, ["photo"]))
    with open_project(path, "write") as project:
        with pytest.raises(OurFault, match="not all texts"):
            project.append(replace(new_run(project, "readings"), reason=reason))  # type: ignore[arg-type]
        with pytest.raises(OurFault, match="not all texts"):
            project.select("photo", 1, "tester", reason)  # type: ignore[arg-type]
    assert check_project(path).ok


@pytest.mark.parametrize(
    "name", ["a?b.db", "50%41.db", "x#y.db", "with space.db", "Höhe.db", "-lead", "two\nlines", "file:z.db", ":memory:"]
)
def test_the_very_name_is_used(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    create_project(path, lambda project: fill(project, ["photo"]))
    assert [file.name for file in tmp_path.iterdir()] == [name]
    with open_project(path, "write") as project:
        project.append(new_run(project, "readings"))
        assert list(project.heads()) == ["photo", "readings"]
    assert [file.name for file in tmp_path.iterdir()] == [name]


def test_every_stage_comes_back_as_it_was_stored(full: Path) -> None:
    with open_project(full) as project:
        heads = project.heads()
        assert list(heads) == list(INPUTS)
        for stage, run in heads.items():
            meant = {table: [dict(row) for row in rows] for table, rows in outcome_of(stage).tables.items()}
            assert project.read_tables(run.run_id) == meant
            assert project.events(run.run_id) == list(EVENTS)
            assert run == project.run(stage, 1) == project.find_run_by_digest(stage, run.input_digest)
            assert run.inputs == {role: heads[role].run_id for role in INPUTS[stage]}
            assert (run.version, run.status, run.settings, run.error) == (1, "succeeded", {"seed": 0.5}, "")


def test_a_failed_run_is_kept_but_moves_no_head(full: Path) -> None:
    with open_project(full, "write") as project:
        failed = Outcome(
            {}, (Event("error", "singular", "", "the points lie on a line"),), "", "the points lie on a line"
        )
        run = project.append(new_run(project, "resection", outcome=failed))
        assert (run.version, run.status, run.error) == (2, "failed", "the points lie on a line")
        assert project.heads()["resection"].version == 1
        assert project.find_run_by_digest("resection", run.input_digest) == project.run("resection", 1)
        with pytest.raises(UsageError, match="failed"):
            project.select("resection", 2, "tester", "try")


def test_selection_goes_back_and_is_audited(full: Path) -> None:
    with open_project(full, "write") as project:
        project.append(new_run(project, "photo", 0.25))
        assert project.heads()["photo"].version == 2
        project.select("photo", 1, "editor", "the camera was right")
        assert project.heads()["photo"].version == 1
        _, rows = project.query("SELECT actor, action, stage, version, reason FROM v_audit")
    assert [tuple(row) for row in rows[-3:]] == [
        ("tester", "run", "photo", 2, "a test"),
        ("tester", "select", "photo", 2, "a test"),
        ("editor", "select", "photo", 1, "the camera was right"),
    ]


def test_a_head_that_moved_meanwhile(full: Path) -> None:
    with open_project(full, "write") as project:
        new = new_run(project, "refine")
        project.append(new_run(project, "readings", 0.25))
        count = len(project.runs())
        with pytest.raises(ProjectError, match="readings was changed meanwhile"):
            project.append(new)
        assert len(project.runs()) == count


def test_several_runs_are_one_transaction(tmp_path: Path) -> None:
    path = tmp_path / "p.sqlite"
    create_project(path)
    with open_project(path, "write") as project:
        good, bad = new_run(project, "photo"), new_run(project, "control")
        worse = Outcome({"photo": [{"no": "photo"}]})
        with pytest.raises(OurFault, match="missing or unknown"):
            project.append_all([good, bad, new_run(project, "readings", outcome=readings(2)), _with(bad, worse)])
        assert project.runs() == []
        assert [run.run_id for run in project.append_all([good, bad])] == [1, 2]


def _with(new: ledger.NewRun, outcome: Outcome) -> ledger.NewRun:
    return replace(new, stage="photo", outcome=outcome)


def test_unknown_runs_say_what_exists(full: Path) -> None:
    with open_project(full) as project:
        with pytest.raises(UsageError, match="no version 7") as error:
            project.run("photo", 7)
        assert "versions 1" in error.value.hint
        with pytest.raises(UsageError, match="no run of stage") as error:
            project.run("nonsense", 1)
        assert "resection" in error.value.hint
        with pytest.raises(UsageError, match="no version"):
            project.run("photo", 2**63)
        with pytest.raises(UsageError, match="no run 99"):
            project.read_tables(99)


@pytest.mark.parametrize("stage", INPUTS)
def test_what_is_read_back_must_be_what_was_meant(
    stage: str, full: Path, monkeypatch: pytest.MonkeyPatch, promise: Promise
) -> None:
    """One value of each table in turn comes back from the disk as another: nothing is stored."""
    stored, kept = ledger.stored_tables, promise("F12")
    for table in STAGE_TABLES[stage]:

        def corrupted(*arguments: object, table: str = table) -> object:
            tables = stored(*arguments)  # type: ignore[arg-type]
            rows = [("other", *row[1:]) for some in tables[table].chunks() for row in some]
            return {**tables, table: SimpleNamespace(chunks=lambda: [rows])}

        with open_project(full, "write") as project, kept.trial(table):
            new = new_run(project, stage)
            with monkeypatch.context() as patch:
                patch.setattr(ledger, "stored_tables", corrupted)
                with pytest.raises(StorageError, match="read back"):
                    project.append(new)
            assert len(project.runs(stage)) == 1


@pytest.mark.parametrize("n", [1, TOGETHER - 1, TOGETHER, TOGETHER + 1, CHUNK, CHUNK + 3 * TOGETHER + 7])
def test_any_number_of_rows_comes_back(n: int, tmp_path: Path) -> None:
    """Some by one statement, the others one by one; columns without any value are not named to SQLite."""
    rows = [{**readings(1).tables["comparator_reading"][0], "seq": i, "x_mm": i / 7, "sigma": None} for i in range(n)]
    for row in rows[::3]:
        row["sigma"] = 0.5 if n > TOGETHER else None
    path = tmp_path / "p.sqlite"
    create_project(path, lambda project: fill(project, ["photo"]))
    with open_project(path, "write") as project:
        outcome = Outcome({"comparator_reading": rows}, EVENTS)
        run = project.append(new_run(project, "readings", outcome=outcome))
        assert project.read_tables(run.run_id)["comparator_reading"] == rows
        assert project.digest_problems(run.run_id) == []


def test_a_wrong_input_digest_is_refused(full: Path) -> None:
    with open_project(full, "write") as project:
        new = new_run(project, "refine")
        with pytest.raises(OurFault, match="input digest"):
            project.append(replace(new, input_digest="0" * 64))


def test_reading_mode_does_not_write(full: Path) -> None:
    with open_project(full) as project, pytest.raises(ReadOnly):
        project.append(new_run(project, "photo"))


@pytest.mark.parametrize(
    ("sql", "words"),
    [
        ("", "empty"),
        ("  -- nothing\n", "empty"),
        ("DELETE FROM photo", "Only questions"),
        ("WITH x AS (SELECT 1) DELETE FROM photo", "Only questions"),
        ("PRAGMA journal_mode=WAL", "Only questions"),
        ("ATTACH 'x' AS y", "Only questions"),
        ("SELECT 1; SELECT 2", "one statement"),
        ("SELECT nope", "no such column"),
        ("SELECT * FROM nope", "no such table"),
        ("SELECT load_extension('x')", "load_extension"),
        ("SELECT fts3_tokenizer('simple')", "fts3_tokenizer"),
        ("SELECT ?", r"binding.* 0 supplied\.\n"),
        ("SELECT zeroblob(2000000000)", "a value of the answer is too large"),
        ("EXPLAIN DELETE FROM photo", "Only questions"),
    ],
)
def test_questions_that_are_refused(full: Path, sql: str, words: str) -> None:
    for mode in ("read", "write"):
        with open_project(full, mode) as project, pytest.raises(UsageError, match=words):  # type: ignore[arg-type]
            project.query(sql)


@pytest.mark.parametrize(
    ("sql", "parameters", "rows"),
    [
        ("SELECT stage FROM v_current WHERE version = ?", (1,), len(INPUTS)),
        ("SELECT stage FROM v_current WHERE stage = :stage", {"stage": "bl"}, 1),
        ("/* ask */ WITH mine AS (SELECT stage FROM v_current) SELECT * FROM mine", (), len(INPUTS)),
        ("VALUES (1), (2)", (), 2),
        ("SELECT json_extract(settings, '$.seed') FROM stage_run", (), len(INPUTS)),
        ("SELECT value FROM json_each('[1, 2, 3]')", (), 3),
        ("SELECT name FROM pragma_table_info('selection')", (), 8),
        ("SELECT '%s' || '%', sqrt(4.0)", (), 1),
    ],
)
def test_questions_that_are_answered(full: Path, sql: str, parameters: object, rows: int) -> None:
    with open_project(full) as project:
        assert len(project.query(sql, parameters)[1]) == rows  # type: ignore[arg-type]
        assert len(project.query(sql, parameters, max_rows=1)[1]) == 1  # type: ignore[arg-type]


ENDLESS = "WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r) SELECT max(n) FROM r"


def test_a_question_without_end_is_stopped(full: Path) -> None:
    with open_project(full) as project:
        with pytest.raises(OrientError, match=r"longer than 0\.1 s"):
            project.query(ENDLESS, timeout_s=0.1)
        assert len(project.heads()) == len(INPUTS)


def test_a_stop_signal_ends_a_statement(full: Path) -> None:
    timer = threading.Timer(0.1, watch.STOP.set)
    timer.start()
    try:
        with open_project(full) as project, pytest.raises(Stopped, match="Nothing was stored"):
            project.query(ENDLESS)
    finally:
        timer.join()
        watch.STOP.clear()


def test_a_snapshot_is_one_moment(full: Path) -> None:
    with open_project(full) as reader, open_project(full, "write") as writer:
        with reader.snapshot():
            before = reader.heads()
            assert reader.heads() == before
        writer.append(new_run(writer, "photo", 0.25))
        assert reader.heads()["photo"].version == 2


def test_a_locked_project_says_so(full: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from orient.store import connection

    monkeypatch.setattr(connection, "BUSY_TIMEOUT_S", 0.1)
    with open_project(full, "write") as first, open_project(full, "write") as second:
        new = new_run(second, "photo", 0.25)
        gated = first._open_gate()
        gated.connection.execution_options(immediate=True)
        with gated.connection.begin(), pytest.raises(Locked, match="in use by another command"):
            second.append(new)
        assert second.append(new).version == 2


def test_a_reader_at_the_commit_only_delays(full: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from orient.store import connection

    monkeypatch.setattr(connection, "BUSY_TIMEOUT_S", 0.05)
    with open_project(full) as reader, open_project(full, "write") as writer:
        new = new_run(writer, "photo", 0.25)
        snapshot = reader.snapshot()
        snapshot.__enter__().exec_driver_sql("SELECT count(*) FROM photo").all()
        results: list[int] = []
        thread = threading.Thread(target=lambda: results.append(writer.append(new).version))
        thread.start()
        thread.join(0.3)
        assert thread.is_alive()
        snapshot.__exit__(None, None, None)
        thread.join(10)
    assert results == [2]


@pytest.mark.parametrize("is_committed", [True, False], ids=["stored", "not stored"])
def test_an_error_at_commit_is_looked_up(full: Path, monkeypatch: pytest.MonkeyPatch, is_committed: bool) -> None:
    import sqlite3

    from sqlalchemy import Connection
    from sqlalchemy.exc import OperationalError

    original = Connection.commit

    def failing(connection: Connection) -> None:
        (original if is_committed else Connection.rollback)(connection)
        error = sqlite3.OperationalError("disk I/O error")
        error.sqlite_errorname = "SQLITE_IOERR_DIR_FSYNC"
        raise OperationalError("COMMIT", None, error)

    with open_project(full, "write") as project:
        new = new_run(project, "photo", 0.25)
        monkeypatch.setattr(Connection, "commit", failing)
        if is_committed:
            assert project.append(new).version == 2
            assert "everything is stored" in project.warnings[-1]
        else:
            with pytest.raises(StorageError, match="IOERR_DIR_FSYNC"):
                project.append(new)
        assert len(project.runs("photo")) == 1 + is_committed


def test_the_file_is_never_opened_beside_sqlite(full: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Closing a file of our own drops SQLite's lock on it (RELIABILITY.md P1)."""

    def watched(opened: Callable[..., object]) -> Callable[..., object]:
        def look(file: object, *arguments: object, **options: object) -> object:
            if str(file) == str(full):
                raise AssertionError("the project file is opened while a connection is open")
            return opened(file, *arguments, **options)

        return look

    with open_project(full, "write") as project:
        for name in ("builtins.open", "io.open", "os.open"):
            module, function = name.split(".")
            monkeypatch.setattr(name, watched(getattr(sys.modules[module], function)))
        project.append(new_run(project, "photo", 0.25))
        project.heads()
        project.query("SELECT * FROM v_stale")
        project.select("photo", 1, "tester", "back")
    monkeypatch.undo()


def test_a_second_door_to_the_same_file_does_not_drop_the_lock(full: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path, *_: object) -> object:
        raise AssertionError(f"{path} is opened while a connection is open")

    with open_project(full, "write") as first:
        monkeypatch.setattr("orient.store.preflight._read_header", refuse)
        with open_project(full) as second:
            assert second.heads() == first.heads()


def test_a_closed_project_is_closed(full: Path) -> None:
    with open_project(full) as project:
        pass
    with pytest.raises(OurFault, match="closed"):
        project.heads()


@pytest.mark.parametrize("text", ["{", "[1]", "null", 2.5, None, b"{}\xff", "[" * 20_000], ids=str)
def test_settings_that_a_damaged_page_gives_are_named(text: object) -> None:
    with pytest.raises(ProjectError, match="settings of run 3 are not valid"):
        settings_from_json(text, 3)  # type: ignore[arg-type]
