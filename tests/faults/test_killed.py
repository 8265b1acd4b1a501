"""Killed, stopped, crowded: the project is as before or as after, and the next command goes on (RELIABILITY.md 5)."""

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.registry import STAGES
from orient.pipeline.runner import create, run_stale
from orient.store.check import check_project
from orient.store.project import open_project
from tests.cli.commands import ROOT, SPACE, orient_process, start

KILLS = 20
SLOWEST_STOP_S = 1.0


@pytest.fixture(scope="module")
def fresh_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fresh") / "photo.sqlite"
    create(path, read_project(SPACE, ReadOptions()), "test")
    return path


@pytest.fixture
def fresh(fresh_once: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(fresh_once, tmp_path / "photo.sqlite"))


@pytest.fixture(scope="module")
def run_seconds(fresh_once: Path, tmp_path_factory: pytest.TempPathFactory) -> float:
    """How long the process `orient run` takes here."""
    path = Path(shutil.copy(fresh_once, tmp_path_factory.mktemp("timed") / "photo.sqlite"))
    begun = time.monotonic()
    assert orient_process("run", path).code == 0
    return time.monotonic() - begun


class Victims:
    """Commands that start at once, to be killed (see kill_server.py)."""

    def __init__(self) -> None:
        self.server = subprocess.Popen(
            [sys.executable, "-m", "tests.faults.kill_server"],
            cwd=ROOT,
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._answer() == "ready"

    def _answer(self) -> str:
        assert self.server.stdout is not None
        return self.server.stdout.readline().strip()

    def start(self, *words: object) -> int:
        assert self.server.stdin is not None
        self.server.stdin.write(json.dumps([str(word) for word in words]) + "\n")
        self.server.stdin.flush()
        return int(self._answer())

    def ended(self) -> int:
        return int(self._answer())

    def seconds(self, *words: object) -> float:
        """How long the command takes when nobody kills it."""
        begun = time.monotonic()
        self.start(*words)
        assert self.ended() == 0
        return time.monotonic() - begun

    def killed_after(self, seconds: float, *words: object) -> int:
        child = self.start(*words)
        time.sleep(seconds)
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
        return self.ended()

    def close(self) -> None:
        self.server.communicate(timeout=30)


@pytest.fixture(scope="module")
def victims() -> Iterator[Victims]:
    server = Victims()
    yield server
    server.close()


def moments(seed: int, count: int, seconds: float) -> Iterator[float]:
    """One moment in each of `count` equal parts of the time, at a random place of it."""
    chance = random.Random(seed)
    return ((part + chance.random()) * seconds / count for part in range(count))


def end(child: "subprocess.Popen[bytes]", number: int) -> tuple[int, str]:
    child.send_signal(number)
    _, err = child.communicate(timeout=30)
    return child.returncode, err.decode("utf-8", "replace")


def run_on(path: Path) -> int:
    """`orient run` in this process; how many stages it had to compute."""
    results = run_stale(path, {}, "after the kill", lambda stage: None, lambda result: None)
    assert [result.stage for result in results if result.failed or result.waits_for not in ("", "model")] == []
    return sum(result.computed for result in results)


def test_kill_during_run(fresh_once: Path, victims: Victims, tmp_path: Path) -> None:
    path = Path(shutil.copy(fresh_once, tmp_path / "photo.sqlite"))
    seconds = victims.seconds("run", path)
    left_to_do, killed = set(), 0
    for index, moment in enumerate(moments(585, KILLS, seconds)):
        shutil.copy(fresh_once, path)
        killed += victims.killed_after(moment, "run", path) == -signal.SIGKILL
        if index in (0, KILLS // 2):
            checked = orient_process("check", path)
            assert (checked.code, checked.err) == (0, "")
        else:
            assert check_project(path).ok
        left_to_do.add(run_on(path))
        assert [file.name for file in tmp_path.iterdir()] == [path.name], f"killed after {moment:.3f} s"
    assert check_project(path).ok
    assert killed > KILLS // 2
    assert len(left_to_do) > 2, "the kills came at too few stages"


def test_kill_during_new_leaves_a_whole_project_or_none(victims: Victims, tmp_path: Path) -> None:
    path = tmp_path / "photo.sqlite"
    seconds = victims.seconds("new", path, "--from", SPACE)
    whole = 0
    for moment in moments(28, KILLS, 1.1 * seconds):
        path.unlink(missing_ok=True)
        victims.killed_after(moment, "new", path, "--from", SPACE)
        if path.exists():
            whole += 1
            assert check_project(path).ok
            with open_project(path) as project:
                assert set(project.heads()) == {"photo", "readings", "sheet", "control"}
    assert whole < KILLS
    path.unlink(missing_ok=True)
    assert victims.seconds("new", path, "--from", SPACE) > 0
    # a killed `new` can leave its unfinished file under a hidden name of its own, never under the project's name
    assert [file.name for file in tmp_path.iterdir() if not file.name.startswith(".")] == [path.name]


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["SIGINT", "SIGTERM"])
def test_stop_during_run(number: int, code: int, fresh: Path, run_seconds: float) -> None:
    for share in (0.35, 0.8):
        child = start("run", fresh)
        time.sleep(share * run_seconds)
        asked = time.monotonic()
        ended, err = end(child, number)
        assert time.monotonic() - asked < SLOWEST_STOP_S
        assert (ended, err) in ((code, "orient: stopped; nothing was stored by the interrupted step\n"), (0, ""))
        assert check_project(fresh).ok
        assert [file.name for file in fresh.parent.iterdir()] == [fresh.name]
    run_on(fresh)


def test_two_signals_stop_once(fresh: Path, run_seconds: float) -> None:
    child = start("run", fresh)
    time.sleep(0.4 * run_seconds)
    child.send_signal(signal.SIGINT)
    ended, err = end(child, signal.SIGINT)
    assert (ended, "Traceback" in err) == (130, False)


def test_two_runs_at_once(fresh: Path) -> None:
    first, second = start("run", fresh), start("run", fresh)
    said = [child.communicate(timeout=60) for child in (first, second)]
    assert all(b"Traceback" not in err and b"fault of orient" not in err for _, err in said)
    assert {first.returncode, second.returncode} <= {0, 3}
    assert 0 in (first.returncode, second.returncode)
    run_on(fresh)
    assert check_project(fresh).ok
    with open_project(fresh) as project:
        assert set(project.heads()) >= {stage.name for stage in STAGES if not stage.wanted_with}
    assert [file.name for file in fresh.parent.iterdir()] == [fresh.name]


def test_two_new_of_one_name_at_once(tmp_path: Path) -> None:
    path = tmp_path / "photo.sqlite"
    children = [start("new", path, "--from", SPACE) for _ in range(2)]
    said = [child.communicate(timeout=60) for child in children]
    assert sorted(child.returncode for child in children) == [0, 3]
    (loser,) = (err.decode() for child, (_, err) in zip(children, said, strict=True) if child.returncode == 3)
    assert loser.startswith(f"orient: {path} exists.")
    assert check_project(path).ok
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
