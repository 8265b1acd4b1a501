"""Which photos: folders, lists, patterns, names of the same file."""

import os
from pathlib import Path

import pytest

from orient.batch.work_list import work_list
from orient.errors import UsageError


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """a.sqlite, b.sqlite, deep/c.sqlite, other.txt, a hidden file; the working folder is elsewhere."""
    folder = tmp_path / "photos"
    (folder / "deep").mkdir(parents=True)
    for name in ("b.sqlite", "a.sqlite", "deep/c.sqlite", ".hidden.sqlite", "other.txt"):
        (folder / name).write_text("x")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    return folder


def names(*places: object, pattern: str = "*.sqlite", recursive: bool = False) -> list[str]:
    return [Path(item.path).name for item in work_list([str(p) for p in places], pattern, recursive).items]


def test_folder_in_the_order_of_names(place: Path) -> None:
    assert names(place) == ["a.sqlite", "b.sqlite"]


def test_recursive(place: Path) -> None:
    assert names(place, recursive=True) == ["a.sqlite", "b.sqlite", "c.sqlite"]


def test_pattern(place: Path) -> None:
    assert names(place, pattern="*.txt") == ["other.txt"]


@pytest.mark.parametrize(
    ("lines", "expected"),
    [
        ("a.sqlite\n", ["a.sqlite"]),
        ("# comment\n\n  b.sqlite  \r\na.sqlite", ["b.sqlite", "a.sqlite"]),
        ("\ufeffa.sqlite\n", ["a.sqlite"]),
        ("*.sqlite\ndeep/c.sqlite\n", ["a.sqlite", "b.sqlite", "c.sqlite"]),
        ("a.sqlite\na.sqlite\n./a.sqlite\n", ["a.sqlite"]),
        ("missing.sqlite\n", ["missing.sqlite"]),
        ("deep\n", ["deep"]),
    ],
    ids=["one", "comments, blanks, CRLF", "BOM", "pattern", "thrice", "missing file is kept", "folder is kept"],
)
def test_list_is_relative_to_itself(place: Path, lines: str, expected: list[str]) -> None:
    (place / "list.txt").write_bytes(lines.encode())
    assert names(place / "list.txt") == expected


def test_given_files_and_patterns(place: Path) -> None:
    assert names(place / "b.sqlite", place / "*" / "c.sqlite") == ["b.sqlite", "c.sqlite"]


def test_links_are_one_photo(place: Path) -> None:
    (place / "link.sqlite").symlink_to(place / "a.sqlite")
    os.link(place / "b.sqlite", place / "z.sqlite")
    work = work_list([str(place), str(place / "deep" / ".." / "a.sqlite")], "*.sqlite", False)
    assert [Path(item.path).name for item in work.items] == ["a.sqlite", "b.sqlite"]
    assert work.repeated == 3


def test_a_name_with_pattern_signs_is_a_name(place: Path) -> None:
    (place / "p[1].sqlite").write_text("x")
    (place / "list.txt").write_text("p[1].sqlite\n")
    assert names(place / "list.txt") == ["p[1].sqlite"]


def test_a_pipe_is_not_opened(place: Path) -> None:
    os.mkfifo(place / "pipe.sqlite")
    assert "pipe.sqlite" in names(place)


def test_folders_with_photo_toml(place: Path, tmp_path: Path) -> None:
    for name in ("P2", "P1", "empty"):
        (tmp_path / "survey" / name).mkdir(parents=True)
    for name in ("P2", "P1"):
        (tmp_path / "survey" / name / "photo.toml").write_text("")
    work = work_list([str(place)], "*.sqlite", False, str(tmp_path / "survey"))
    assert [(Path(item.path).name, Path(item.source).name) for item in work.items] == [
        ("P1.sqlite", "P1"), ("P2.sqlite", "P2"), ("a.sqlite", ""), ("b.sqlite", "")
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("nowhere", "there is no file or folder nowhere"),
        ("no*.sqlite", "there is no file or folder no*.sqlite"),
        ("../empty", "there is no *.sqlite in ../empty"),
        ("../folder", "holds photo.toml but no project"),
        ("../binary", "neither a project nor a list"),
    ],
    ids=["missing", "pattern without match", "empty folder", "folder of lists", "binary file"],
)
def test_refused_before_anything_begins(place: Path, tmp_path: Path, given: str, said: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "photo.toml").write_text("")
    (tmp_path / "binary").write_bytes(b"\x00\x01\x02")
    with pytest.raises(UsageError, match=r".*") as refused:
        names(given)
    assert said in refused.value.message
