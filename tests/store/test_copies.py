"""backup and receive: a copy is whole, verified and private, or there is none; the original is never touched."""

import hashlib
import os
import re
import stat
import threading
import time
from pathlib import Path

import pytest

from orient.errors import OrientError, ProjectError, UsageError
from orient.store.check import check_project
from orient.store.copies import backup_project, receive_project
from orient.store.new_file import PREFIX, SUFFIX, temporary_file
from orient.store.project import open_project
from tests.store.test_opening import ACCEPTED, NEEDS_DIGEST, REFUSED, leave_hot_journal, unguarded, wal_mode

WITHOUT_A_FILE = ("D1 missing", "D9 folder", "D9 fifo", "D9 socket", "D10 dangling link", "D10 loop")


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def beside(path: Path) -> set[str]:
    return {entry.name for entry in path.parent.iterdir()}


def content(path: Path) -> list[tuple[int, str, str]]:
    with open_project(path) as project:
        return project.query("SELECT run_id, record_digest, output_digest FROM run_seal ORDER BY run_id")[1]  # type: ignore[return-value]


def test_a_backup_is_the_project(full: Path) -> None:
    before = sha256(full)
    copied = backup_project(full, full.with_name("copy.orient"))
    assert check_project(copied.path).ok
    assert content(copied.path) == content(full)
    assert (copied.sha256, copied.size) == (sha256(copied.path), copied.path.stat().st_size)
    assert copied.runs == len(content(full))
    assert sha256(full) == before
    assert beside(full) == {full.name, "copy.orient"}


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o400])
def test_a_backup_has_the_rights_of_its_source(full: Path, mode: int) -> None:
    full.chmod(mode)
    copied = backup_project(full, full.with_name("copy.orient"))
    assert stat.S_IMODE(copied.path.stat().st_mode) == mode & ~_umask()


def _umask() -> int:
    now = os.umask(0)
    os.umask(now)
    return now


def test_a_received_file_is_private(full: Path) -> None:
    full.chmod(0o666)
    copied = receive_project(full, full.with_name("copy.orient"))
    assert stat.S_IMODE(copied.path.stat().st_mode) == 0o600


@pytest.mark.parametrize("copy", [backup_project, receive_project])
def test_an_existing_name_is_never_touched(full: Path, copy) -> None:  # type: ignore[no-untyped-def]
    target = full.with_name("copy.orient")
    target.write_text("mine")
    with pytest.raises(UsageError, match="exists"):
        copy(full, target)
    with pytest.raises(UsageError, match="exists"):
        copy(full, full)
    assert target.read_text() == "mine"


@pytest.mark.parametrize("copy", [backup_project, receive_project])
@pytest.mark.parametrize("name", NEEDS_DIGEST)
def test_what_check_finds_is_not_copied(full: Path, name: str, copy) -> None:  # type: ignore[no-untyped-def]
    damage, words = NEEDS_DIGEST[name]
    damage(full)
    before = sha256(full)
    with pytest.raises(ProjectError) as error:
        copy(full, full.with_name("copy.orient"))
    assert re.search(words, error.value.message), error.value.message
    assert beside(full) == {full.name}
    assert sha256(full) == before


@pytest.mark.parametrize("name", [name for name in REFUSED if name != "D16 WAL"])
def test_no_stranger_gets_in(full: Path, tmp_path_factory: pytest.TempPathFactory, name: str) -> None:
    damage, words = REFUSED[name]
    damage(full)
    before = beside(full)
    target = tmp_path_factory.mktemp("mine") / "copy.orient"
    started = time.monotonic()
    with pytest.raises(OrientError) as error:
        receive_project(full, target)
    told = f"a -journal file lies beside|{words}" if "journal" in name else words
    assert re.search(told, error.value.message), error.value.message
    assert time.monotonic() - started < 3
    assert list(target.parent.iterdir()) == []
    assert beside(full) == before


@pytest.mark.parametrize("name", [name for name in ACCEPTED if "journal" not in name])
def test_what_can_be_opened_can_be_received(full: Path, tmp_path_factory: pytest.TempPathFactory, name: str) -> None:
    expected = content(full)
    ACCEPTED[name](full)
    copied = receive_project(full, tmp_path_factory.mktemp("mine") / "copy.orient")
    assert content(copied.path) == expected


def test_a_file_in_WAL_mode_is_received(full: Path) -> None:
    expected = content(full)
    wal_mode(full)
    before = sha256(full)
    with pytest.raises(ProjectError) as error:
        open_project(full)
    assert error.value.hint == "Run: orient receive house.orient COPY"
    copied = receive_project(full, full.with_name("copy.orient"))
    assert content(copied.path) == expected
    assert sha256(full) == before


def test_what_was_deleted_by_a_stranger_does_not_travel(full: Path) -> None:
    """Free pages keep what a row once said; the clean copy has none."""
    secret = "a sentence that nobody should read" * 20
    columns = "999, stage, run_id, actor"
    rest = "selected_at, after_run_id, record_digest"
    unguarded(
        "PRAGMA secure_delete = OFF",
        f"INSERT INTO selection SELECT {columns}, '{secret}', {rest} FROM selection LIMIT 1",
        "DELETE FROM selection WHERE selection_id = 999",
    )(full)
    assert secret.encode() in full.read_bytes()
    copied = receive_project(full, full.with_name("copy.orient"))
    assert secret.encode() not in copied.path.read_bytes()


def test_a_backup_during_writing_is_one_moment(full: Path) -> None:
    stop = threading.Event()

    def write() -> None:
        while not stop.is_set():
            with open_project(full, "write") as project:
                project.select("photo", 1, "other", "again")

    writer = threading.Thread(target=write)
    writer.start()
    try:
        for number in range(5):
            assert check_project(backup_project(full, full.with_name(f"copy{number}")).path).ok
    finally:
        stop.set()
        writer.join()


def test_a_backup_undoes_what_was_interrupted(full: Path, tmp_path: Path) -> None:
    expected = content(full)
    (tmp_path / "other").mkdir()
    path = leave_hot_journal(full, tmp_path / "other")
    with pytest.raises(ProjectError, match="a -journal file lies beside"):
        receive_project(path, tmp_path / "received.orient")
    copied = backup_project(path, tmp_path / "copy.orient")
    assert content(copied.path) == expected


def test_what_a_killed_command_left_goes_with_the_next_one(full: Path) -> None:
    dead = full.with_name(f"{PREFIX}00{SUFFIX}")
    dead.write_bytes(b"half")
    Path(f"{dead}-journal").write_bytes(b"half")
    with temporary_file(full.parent) as living:
        backup_project(full, full.with_name("copy.orient"))
        assert living.exists()
    assert beside(full) == {full.name, "copy.orient"}


@pytest.mark.parametrize("name", ["house.orient-wal", "house.orient-journal", "other-shm", "a" * 300])
def test_names_that_would_hurt_another_project_are_refused(full: Path, name: str) -> None:
    for copy in (backup_project, receive_project):
        with pytest.raises(UsageError, match=r"belongs to SQLite|too long"):
            copy(full, full.with_name(name))
    assert check_project(full).ok
