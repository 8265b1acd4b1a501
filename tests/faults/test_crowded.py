"""Several commands at once, readers that stay long: all finish or are told to wait, none is half-written (F6, F7)."""

import multiprocessing
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from orient.errors import UsageError
from orient.pipeline.registry import STAGES
from orient.store.check import check_project
from orient.store.project import create_project, open_project
from tests.cli.commands import ROOT
from tests.faults.operations import COPY, PROJECT
from tests.faults.oracle import Clean, recovered, state_of
from tests.faults.victims import Fault, Victims
from tests.promises import Promise
from tests.store.made import new_run, readings

CleanOf = Callable[[str], Clean]
SPAWN = multiprocessing.get_context("spawn")


def append_some(path: Path, seed: float, count: int, rows: int) -> None:
    """`count` times: read the head, then write what depends on it."""
    with open_project(path, "write") as project:
        for step in range(count):
            outcome = readings(rows) if rows else None
            project.append(new_run(project, "readings" if rows else "control", seed + step, outcome))


@pytest.mark.parametrize(
    ("writers", "count", "rows"),
    [
        (4, 5, 0),
        pytest.param(2, 25, 0, marks=pytest.mark.slow),
        pytest.param(8, 25, 0, marks=pytest.mark.slow),
        pytest.param(8, 6, 20_000, marks=pytest.mark.slow),
    ],
)
def test_writers_at_once(writers: int, count: int, rows: int, tmp_path: Path, promise: Promise) -> None:
    path, kept = tmp_path / "crowded.orient", promise("F6")
    create_project(path)
    all_of_them = [SPAWN.Process(target=append_some, args=(path, 100.0 * n, count, rows)) for n in range(writers)]
    for writer in all_of_them:
        writer.start()
    for writer in all_of_them:
        writer.join(400)
    with open_project(path) as project:
        versions = [run.version for run in project.runs()]
    for number in range(1, writers * count + 1):
        with kept.trial(f"{number} of {writers} writers x {count}"):
            assert versions[number - 1 : number] == [number]
    assert [writer.exitcode for writer in all_of_them] == [0] * writers
    assert check_project(path).ok
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("count", [2, pytest.param(8, marks=pytest.mark.slow)])
def test_the_same_command_at_once(
    count: int, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """`run` beside `run`: who comes second uses the first one's results, or is told to run again."""
    run, folder, kept = clean("run"), tmp_path / "scene", promise("F6")
    run.scene(folder)
    ended = [started.ended() for started in [victims.start(*run.words(folder)) for _ in range(count)]]
    for one in ended:
        with kept.trial(f"one of {count} runs"):
            assert "Traceback" not in one.err and "fault of orient" not in one.err
            assert one.code == 0 or (one.code == 3 and "run again" in one.err), one
    assert 0 in [one.code for one in ended]
    assert victims.run(*run.words(folder)).code == 0
    assert recovered(folder / PROJECT) is not None
    with open_project(folder / PROJECT) as project:
        assert set(project.heads()) >= {stage.name for stage in STAGES if not stage.wanted_with} - {"digitize"}
    assert {path.name for path in folder.iterdir()} == run.names


@pytest.mark.parametrize("name", ["new", "backup", "receive"])
def test_of_several_that_make_one_name_exactly_one_wins(
    name: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    one, folder, kept = clean(name), tmp_path / "scene", promise("F6")
    one.scene(folder)
    ended = [started.ended() for started in [victims.start(*one.words(folder)) for _ in range(4)]]
    with kept.trial(f"4 x {name}"):
        assert sorted(each.code for each in ended) == [0, 2, 2, 2]
        assert all(each.err.startswith(f"orient: {folder / COPY} exists.") for each in ended if each.code)
        assert state_of(folder / COPY) == one.new
        assert {path.name for path in folder.iterdir()} == one.names


@pytest.mark.slow
def test_different_commands_at_once(clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    """Everything that works on a finished project, at the same time, ten times."""
    names, kept = ("add", "refine", "bl", "resection", "select", "verify", "check", "backup", "receive"), promise("F6")
    folder = clean("add").scene(tmp_path / "scene")
    for turn in range(10):
        (folder / COPY).unlink(missing_ok=True)
        ended = [started.ended() for started in [victims.start(*clean(name).words(folder)) for name in names]]
        for name, one in zip(names, ended, strict=True):
            with kept.trial(f"{name} in turn {turn}"):
                assert "Traceback" not in one.err and "fault of orient" not in one.err, one
                refusals = ("run again", "is stale", "exists", "changed while it was read", "-journal")
                assert one.code == 0 or any(refusal in one.err for refusal in refusals), one
        assert victims.run("run", folder / PROJECT).code == 0
        assert recovered(folder / PROJECT) is not None


# ------------------------------------------------------------------------------------------ slow readers


@contextmanager
def reader(path: Path) -> Iterator[sqlite3.Connection]:
    """Another program that has begun to read and does not end."""
    with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True, isolation_level=None)) as bare:
        bare.execute("BEGIN")
        bare.execute("SELECT count(*) FROM stage_run").fetchall()
        yield bare


def release_after(seconds: float, connection: sqlite3.Connection) -> threading.Thread:
    thread = threading.Timer(seconds, connection.execute, ("ROLLBACK",))
    thread.start()
    return thread


@pytest.mark.parametrize(
    ("timeout_s", "held_s"), [(0.3, 1.5), pytest.param(30.0, 40.0, marks=pytest.mark.slow)], ids=["short", "40 s"]
)
def test_a_commit_waits_for_a_slow_reader(
    timeout_s: float, held_s: float, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """The reader stays longer than SQLite's own patience: the commit is repeated with the numbers in memory."""
    select, kept = clean("select"), promise("F7")
    folder = select.scene(tmp_path / "scene")
    path = folder / PROJECT
    with closing(sqlite3.connect(path, check_same_thread=False, isolation_level=None)) as bare:
        bare.execute("BEGIN")
        bare.execute("SELECT count(*) FROM stage_run").fetchall()
        timer = release_after(held_s, bare)
        with kept.trial(f"a reader for {held_s} s"):
            ended = victims.run(*select.words(folder), fault=Fault(patience_s=(timeout_s, 60.0)))
            assert (ended.code, ended.err) == (0, "")
            assert ended.seconds > timeout_s
        timer.join()
    assert recovered(path) == select.new


def test_a_reader_without_end_is_named(clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    select, kept = clean("select"), promise("F7")
    folder = select.scene(tmp_path / "scene")
    with kept.trial("a reader without end"):
        with reader(folder / PROJECT):
            ended = victims.run(*select.words(folder), fault=Fault(patience_s=(0.2, 1.0)))
        assert ended.code == 3
        assert ended.err.startswith(f"orient: {folder / PROJECT} is in use by another command (waited")
        assert recovered(folder / PROJECT) == select.old
        assert {path.name for path in folder.iterdir()} == select.names


READING = (
    ("status",), ("show", "resection"), ("log",), ("check",), ("sql", "SELECT 1"), ("diff", "photo", "1", "1"),
)  # fmt: skip

WRITE_LONG = """
import sys
from orient.store.project import open_project
from tests.store.made import new_run, readings
with open_project(sys.argv[1], "write") as project:
    new = new_run(project, "readings", outcome=readings(int(sys.argv[2])))
    from orient.store import ledger
    seal = ledger._seal
    def slow(*arguments):
        print("written", flush=True)
        sys.stdin.readline()
        seal(*arguments)
    ledger._seal = slow
    project.append(new)
    print("stored", flush=True)
"""


@pytest.mark.parametrize("rows", [20_000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_a_long_write_does_not_stop_readers(
    rows: int, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """All rows are written, nothing is committed: every reading command works and sees the state before."""
    kept, folder = promise("F7"), clean("check").scene(tmp_path / "scene")
    path = folder / PROJECT
    before = state_of(path)
    words = [sys.executable, "-c", WRITE_LONG, str(path), str(rows)]
    writer = subprocess.Popen(words, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert writer.stdout is not None and writer.stdout.readline() == "written\n"
    for name, *more in READING:
        with kept.trial(f"{name} beside a write of {rows} rows"):
            ended = victims.run(name, path, *more)
            assert (ended.code, ended.err) == (0, ""), ended
            kept.largest("s of a reader", ended.seconds)
    assert state_of(path) == before
    out, _ = writer.communicate("\n", timeout=120)
    assert out == "stored\n"
    assert check_project(path).ok


def create_one(path: Path, seed: float) -> None:
    try:
        create_project(path, lambda project: [project.append(new_run(project, "photo", seed)), time.sleep(0.2)][0])
    except UsageError as error:
        sys.exit(2 if "exists" in error.message else 4)


def test_of_two_slow_creations_exactly_one_wins(tmp_path: Path, promise: Promise) -> None:
    path = tmp_path / "wanted.orient"
    both = [SPAWN.Process(target=create_one, args=(path, seed)) for seed in (1.0, 2.0)]
    for process in both:
        process.start()
    for process in both:
        process.join(60)
    with promise("F6").trial("two creations"):
        assert sorted(str(process.exitcode) for process in both) == ["0", "2"]
        assert [file.name for file in tmp_path.iterdir()] == [path.name]
        assert check_project(path).ok
