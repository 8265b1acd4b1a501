"""A full disk, a read-only file or folder: one clear sentence, exit code 3, the file unchanged."""

import ctypes
import os
import resource
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create, run_stale
from orient.store.check import check_project
from tests.cli.commands import SPACE, Said, orient_process

PR_CAPBSET_DROP, CAP_DAC_OVERRIDE = 24, 1
PAGE = 4096


def _done(path: Path) -> Path:
    create(path, read_project(SPACE, ReadOptions()), "test")
    _run(path)
    return path


def _run(path: Path) -> int:
    results = run_stale(path, {}, "test", lambda stage: None, lambda result: None)
    return sum(result.computed for result in results)


@pytest.fixture(scope="module")
def done_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return _done(tmp_path_factory.mktemp("done") / "photo.sqlite")


def limited(size: int, *words: object) -> Said:
    return orient_process(*words, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))


ROOM = {"no room at all": 0, "room for some pages": 10 * PAGE}


@pytest.mark.parametrize("room", ROOM)
def test_no_space_during_run(room: str, tmp_path: Path) -> None:
    path = tmp_path / "photo.sqlite"
    create(path, read_project(SPACE, ReadOptions()), "test")
    said = limited(path.stat().st_size + ROOM[room], "run", path)
    assert said.code == 3
    assert said.err.splitlines()[0] == f"orient: No space left while writing {path}. Nothing of this step was stored."
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert check_project(path).ok
    assert _run(path) > 0


def test_no_space_leaves_the_file_as_it_was(done_once: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(done_once, tmp_path / "photo.sqlite"))
    before = path.read_bytes()
    said = limited(len(before), "covariance", path, "--pairs")
    assert said.code == 3
    assert said.err.startswith(f"orient: No space left while writing {path}.")
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_no_space_for_new(tmp_path: Path) -> None:
    said = limited(20 * PAGE, "new", tmp_path / "photo.sqlite", "--from", SPACE)
    assert said.code == 3
    assert "No space left" in said.err
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def closed(done_once: Path, tmp_path: Path) -> Iterator[Path]:
    """A folder with a project 0444."""
    shutil.copy(done_once, tmp_path / "photo.sqlite")
    (tmp_path / "photo.sqlite").chmod(0o444)
    yield tmp_path
    tmp_path.chmod(0o755)


def without_privilege() -> None:
    """In the new process: root loses the right to write what its modes forbid (CAP_DAC_OVERRIDE)."""
    if os.geteuid() == 0:
        ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0)


def bound(*words: object) -> Said:
    """The command of someone whom modes bind."""
    return orient_process(*words, preexec_fn=without_privilege)


@pytest.fixture(scope="module")
def modes_bind(tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("modes") / "closed"
    path.touch(0o444)
    ended = subprocess.run(["sh", "-c", ': >> "$0"', str(path)], preexec_fn=without_privilege, check=False,
                           capture_output=True)  # fmt: skip
    if ended.returncode == 0:
        pytest.skip("root cannot give up its privilege here, and modes do not bind root")


READING = (("status",), ("show", "resection"), ("sql", "residuals"), ("log",), ("diff", "resection", "1", "1"))


@pytest.mark.usefixtures("modes_bind")
@pytest.mark.parametrize("words", READING, ids=lambda words: words[0])
def test_a_read_only_project_can_be_read(words: tuple[str, ...], closed: Path) -> None:
    closed.chmod(0o555)
    command, *rest = words
    said = bound(command, closed / "photo.sqlite", *rest)
    assert (said.code, said.err) == (0, "")
    assert said.out


@pytest.mark.usefixtures("modes_bind")
@pytest.mark.parametrize("mode", [0o555, 0o777], ids=["folder too", "file only"])
def test_a_read_only_project_is_not_written(mode: int, closed: Path) -> None:
    closed.chmod(mode)
    path = closed / "photo.sqlite"
    before = path.read_bytes()
    for words in (("resection", path, "--again"), ("run", path), ("select", path, "photo", "1", "-m", "x")):
        said = bound(*words)
        assert said.code == 3
        assert "cannot be written" in said.err
        assert len(said.err.splitlines()) <= 2
    assert path.read_bytes() == before
    assert [file.name for file in closed.iterdir()] == [path.name]


@pytest.mark.usefixtures("modes_bind")
def test_no_project_in_a_read_only_folder(closed: Path) -> None:
    closed.chmod(0o555)
    said = bound("new", closed / "other.sqlite", "--from", SPACE)
    assert said.code == 3
    assert "cannot be written" in said.err
