"""A file has its name when it is whole, and nothing lies beside it, wherever a stop arrives."""

import errno
import os
from pathlib import Path

import pytest

from orient.errors import UsageError
from orient.store import new_file
from orient.store.new_file import make_file, new_name


def write(temporary: Path) -> None:
    temporary.write_text("whole")


def _stop(*given: object, **named: object) -> None:
    raise KeyboardInterrupt


def _no_links(*given: object) -> None:
    raise OSError(errno.EPERM, "no hard links here")


def test_a_stop_just_after_the_file_is_made_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    created = new_file._created

    def stopped(path: Path, mode: int) -> int:
        os.close(created(path, mode))
        raise KeyboardInterrupt

    monkeypatch.setattr(new_file, "_created", stopped)
    with pytest.raises(KeyboardInterrupt):
        make_file(tmp_path / "new", write)
    assert list(tmp_path.iterdir()) == []


def test_a_stop_while_waiting_for_the_lock_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(new_file, "_lock", _stop)
    with pytest.raises(KeyboardInterrupt):
        make_file(tmp_path / "new", write)
    assert list(tmp_path.iterdir()) == []


def test_a_stop_before_a_reserved_name_is_taken_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", _no_links)
    monkeypatch.setattr(Path, "replace", _stop)
    with pytest.raises(KeyboardInterrupt):
        make_file(tmp_path / "new", write)
    assert list(tmp_path.iterdir()) == []


def test_a_stop_after_a_reserved_name_is_taken_leaves_the_whole_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = Path.replace

    def stopped(path: Path, target: Path) -> None:
        replace(path, target)
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "link", _no_links)
    monkeypatch.setattr(Path, "replace", stopped)
    with pytest.raises(KeyboardInterrupt):
        make_file(tmp_path / "new", write)
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("new", "whole")]


def test_a_reserved_name_of_somebody_else_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "link", _no_links)
    (tmp_path / "new").touch()
    with pytest.raises(Exception, match="exists"):
        make_file(tmp_path / "new", write)
    assert [path.name for path in tmp_path.iterdir()] == ["new"]


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("file/new", "is no folder"),
        ("missing/new", "does not exist"),
        ("new/", "is the name of a folder"),
        ("", "empty"),
    ],
)
def test_names_that_no_file_can_have(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, told: str) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()
    with pytest.raises(UsageError, match=told):
        new_name(name)


def test_a_current_folder_that_is_gone_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    with pytest.raises(UsageError, match="the current folder is gone"):
        new_name("new")
