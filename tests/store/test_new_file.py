"""A file has its name when it is whole, and nothing lies beside it, wherever a stop arrives."""

import errno
import os
from pathlib import Path

import pytest

from orient.store import new_file
from orient.store.new_file import make_file


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
