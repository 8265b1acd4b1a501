"""One bad file of each kind among good ones: it is a row with its reason and exit code, and the rest is done."""

import os
import shutil
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from orient.batch import photo_task
from orient.batch.photo_task import work_through
from orient.batch.values import Item, Order
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create
from orient.store import connection
from tests.batch.reading import assert_each_ended_once, latest, versions
from tests.cli.commands import orient, orient_process
from tests.cli.made_photo import GROUND, MadePhoto
from tests.faults.privilege import like_anybody
from tests.faults.privilege import modes_bind as modes_bind

Spoil = Callable[[Path], None]


def damaged(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[4096:60_000] = os.urandom(60_000 - 4096)
    path.write_bytes(content)


def hostile(path: Path) -> None:
    with closing(sqlite3.connect(path)) as base:
        base.execute("CREATE TRIGGER evil AFTER INSERT ON run_seal BEGIN SELECT 1; END")


def foreign(path: Path) -> None:
    path.unlink()
    with closing(sqlite3.connect(path)) as base:
        base.execute("CREATE TABLE t (x)")


def empty(path: Path) -> None:
    path.write_bytes(b"")


def text(path: Path) -> None:
    path.write_text("not a project")


def folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def loop(path: Path) -> None:
    path.unlink()
    path.symlink_to(path)


def pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def missing(path: Path) -> None:
    path.unlink()


def wal(path: Path) -> None:
    Path(f"{path}-wal").write_bytes(b"")


def in_a_line(path: Path) -> None:
    """Control on one straight line: no orientation."""
    seen = GROUND[:5].copy()
    seen[:, :] = GROUND[0] + [[step * 150.0, step * 100.0, step * 20.0] for step in range(5)]
    _made_anew(path, MadePhoto(seen=seen))


def without_control(path: Path) -> None:
    """Readings only: `orient run` computes what it can, but there is no orientation."""
    folder = MadePhoto().write(path.parent.parent / "no-control")
    for name in ("control.csv", "control.toml"):
        (folder / name).unlink()
    path.unlink()
    create(path, read_project(folder, ReadOptions()), "made")


def _made_anew(path: Path, photo: MadePhoto) -> None:
    path.unlink()
    create(path, read_project(photo.write(path.parent.parent / "spoilt"), ReadOptions()), "made")


KINDS = {
    damaged: (3, "damaged"),
    hostile: (3, ""),
    foreign: (3, "belongs to another program"),
    empty: (3, "is empty"),
    text: (3, "not an orient project"),
    folder: (3, "is not a regular file"),
    loop: (3, "too many links"),
    pipe: (3, "is not a regular file"),
    missing: (2, "no such project"),
    wal: (3, "-wal file lies beside"),
    in_a_line: (1, "resection"),
    without_control: (1, "not oriented: bl waits for control or digitize"),
}


@pytest.fixture
def few(projects: Path) -> Path:
    for path in sorted(projects.iterdir())[3:]:
        path.unlink()
    return projects


@pytest.mark.parametrize("spoil", KINDS, ids=lambda spoil: spoil.__name__)
def test_one_bad_file(spoil: Spoil, few: Path) -> None:
    code, said = KINDS[spoil]
    bad = few / "P001.sqlite"
    spoil(bad)
    places = few.parent / "list.txt"
    places.write_text("".join(f"projects/P{number:03}.sqlite\n" for number in range(3)))
    done = orient("batch", places, "--workers", "0")
    assert (done.code, done.err) == (1, "")
    found = latest(few.parent / "orient-summary.db")
    row = found.pop("P001.sqlite")
    assert row["exit_code"] == code
    assert said in row["error"]
    assert (row["x_s_m"], row["verdict"] in (None, "failed", "incomplete")) == (None, True)
    assert f"(exit code {code})" in done.out
    assert {row["exit_code"] for row in found.values()} == {0}
    if spoil is not without_control:
        assert orient("run", bad).code == code


def test_all_kinds_at_once_on_workers(projects: Path) -> None:
    """Through real workers: nothing of it stops or kills one."""
    names = sorted(path.name for path in projects.iterdir())
    spoilt = dict(zip(names, [kind for kind in KINDS if kind is not missing], strict=False))
    places = projects.parent / "list.txt"
    places.write_text("".join(f"projects/{name}\n" for name in names))
    for name, kind in spoilt.items():
        kind(projects / name)
    done = orient_process("batch", places, "--workers", "2")
    assert (done.code, done.err) == (1, "")
    found = latest(projects.parent / "orient-summary.db")
    assert {name: row["exit_code"] for name, row in found.items()} == {
        name: KINDS[spoilt[name]][0] if name in spoilt else 0 for name in names
    }


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Another command that holds the lock."""
    with closing(sqlite3.connect(path, isolation_level=None)) as base:
        base.execute("BEGIN IMMEDIATE")
        yield


def test_locked_is_tried_again_by_the_next_batch(few: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection, "BUSY_TIMEOUT_S", 0.2)
    names = {path.name for path in few.iterdir()}
    with writing(few / "P001.sqlite"):
        done = orient("batch", few, "--workers", "0")
    assert done.code == 1
    row = latest(few / "orient-summary.db")["P001.sqlite"]
    assert (row["exit_code"], "is in use by another command" in row["error"]) == (3, True)
    assert orient("batch", few, "--workers", "0").code == 0
    assert_each_ended_once(few, few / "orient-summary.db", names)


def test_what_the_data_refused_is_tried_again_when_asked_or_mended(few: Path) -> None:
    bad = few / "P001.sqlite"
    in_a_line(bad)
    assert orient("batch", few, "--workers", "0").code == 1
    again = orient("batch", few, "--workers", "0")
    assert (again.code, "resection" in again.out) == (1, True)
    assert "Nothing to do: 3 photos: 2 done before, 1 refused before." in again.out.splitlines()
    asked = orient("batch", few, "--workers", "0", "--retry-failed")
    assert (asked.code, "Batch 2" in asked.out, "2 done before" in asked.out) == (1, True, True)
    assert versions(bad)["resection"] == 1  # the same failure is not stored twice
    mended = MadePhoto().write(few.parent / "mended")
    for name in ("readings", "control"):
        assert orient("add", bad, name, *sorted(mended.glob(f"{name}.*")), "-m", "mended").code == 0
    done = orient("batch", few, "--workers", "0")
    assert (done.code, "Batch 3" in done.out) == (0, True)


@pytest.mark.usefixtures("modes_bind")
def test_what_may_not_be_read_is_a_row(few: Path) -> None:
    (few / "closed").mkdir(mode=0o000)
    (few / "P001.sqlite").chmod(0o000)
    (few / "P002.sqlite").chmod(0o400)
    done = orient_process("batch", few, "--workers", "0", "--recursive", preexec_fn=like_anybody)
    (few / "closed").chmod(0o700)
    assert (done.code, done.err) == (1, "")
    found = latest(few / "orient-summary.db")
    told = {"closed": "cannot be read: Permission denied", "P001.sqlite": "cannot be read: Permission denied",
            "P002.sqlite": "cannot be written"}  # fmt: skip
    assert {name: row["exit_code"] for name, row in found.items()} == {"P000.sqlite": 0, **dict.fromkeys(told, 3)}
    for name, said in told.items():
        assert said in found[name]["error"]


def test_folders_become_projects_and_bad_ones_rows(folders_once: Path, tmp_path: Path) -> None:
    folders = Path(shutil.copytree(folders_once, tmp_path / "folders"))
    for path in sorted(folders.iterdir())[3:]:
        shutil.rmtree(path)
    (folders / "P001" / "photo.toml").write_text("[photo]\nname = ")
    done = orient("batch", tmp_path / "projects", "--from", folders, "--workers", "0")
    found = latest(tmp_path / "projects" / "orient-summary.db")
    assert done.code == 1
    assert {name: row["exit_code"] for name, row in found.items()} == {
        "P000.sqlite": 0, "P001.sqlite": 1, "P002.sqlite": 0
    }  # fmt: skip
    assert "photo.toml" in found["P001.sqlite"]["error"]
    shutil.copy(folders_once / "P001" / "photo.toml", folders / "P001")
    assert orient("batch", tmp_path / "projects", "--from", folders, "--workers", "0").code == 0


def test_a_fault_of_our_own_is_a_row(few: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = photo_task._run

    def faulty(path: str, order: Order) -> object:
        if path.endswith("P001.sqlite"):
            raise ZeroDivisionError("division")
        return real(path, order)

    monkeypatch.setattr(photo_task, "_run", faulty)
    items = [Item(str(path)) for path in sorted(few.iterdir())]
    endings = work_through(items, Order())
    assert [ending.exit_code for ending in endings] == [0, 70, 0]
    assert "ZeroDivisionError: division" in endings[1].message
