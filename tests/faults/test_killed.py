"""Killed at any time and at any write: the project is as before or as after, and the next command goes on (F1, F2)."""

import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest

from tests.cli.commands import start
from tests.faults.operations import PROJECT, QUICK, Operation, each
from tests.faults.oracle import Clean, judge
from tests.faults.victims import KILLED, Ended, Fault, Victims
from tests.promises import Promise

CleanOf = Callable[[str], Clean]
STOPPED = b"orient: stopped; no step is stored by half: orient log PROJECT tells what is stored\n"


def kill_at_random(clean: Clean, count: int, folder: Path, victims: Victims, promise: Promise, seed: int) -> None:
    """One kill in each of `count` equal parts of the time that the command takes, at a random place of it."""
    kept, chance = promise("F1"), Random(seed)
    for part in range(count):
        moment = (part + chance.random()) * clean.seconds / count
        clean.scene(folder)
        ended = victims.killed_after(moment, *clean.words(folder))
        with kept.trial(f"{clean.operation} killed after {moment:.4f} s (seed {seed})"):
            judge(clean, folder, ended, victims)


def test_random_kills_of_run(clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    kill_at_random(clean("run"), 10, tmp_path / "scene", victims, promise, seed=585)


@pytest.mark.slow
@pytest.mark.parametrize("operation", each())
def test_random_kills(operation: Operation, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    count = 200 if operation.name == "run" else 40
    kill_at_random(clean(operation.name), count, tmp_path / "scene", victims, promise, seed=200)


def kill_at_calls(clean: Clean, moments: list[int], folder: Path, victims: Victims, promise: Promise) -> None:
    kept = promise("F2")
    for at in moments:
        clean.scene(folder)
        ended = victims.run(*clean.words(folder), fault=Fault(str(folder), at))
        with kept.trial(f"{clean.operation} killed at its call {at} ({clean.calls[at - 1]})"):
            assert ended.code == KILLED
            judge(clean, folder, ended, victims)


@pytest.mark.usefixtures("preloaded")
def test_kill_at_each_fifth_write_of_run(clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    run = clean("run")
    kill_at_calls(run, run.moments(every=5), tmp_path / "scene", victims, promise)


@pytest.mark.slow
@pytest.mark.usefixtures("preloaded")
@pytest.mark.parametrize("operation", each("check"))
def test_kill_at_each_write(
    operation: Operation, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    kill_at_calls(clean(operation.name), clean(operation.name).moments(), tmp_path / "scene", victims, promise)


@pytest.mark.usefixtures("preloaded")
def test_the_library_sees_every_operation_write(clean: CleanOf) -> None:
    """Without this a library that strikes nothing would pass all loops."""
    for name in QUICK:
        assert {"c", "w", "s", "u"} <= set(clean(name).calls), name
    assert clean("check").calls == ""


def hot_scenes(clean: Clean, folder: Path, victims: Victims, count: int) -> list[Path]:
    """Folders in which a killed command left a hot journal, or a whole one: its last calls before the end."""
    folder.mkdir(parents=True)
    places = [place for place, call in enumerate(clean.calls, 1) if call in "su"]
    scenes = []
    for at in places[:: max(1, len(places) // count)]:
        scene = clean.scene(folder / f"killed-{at}")
        victims.run(*clean.words(scene), fault=Fault(str(scene), at))
        if Path(f"{scene / PROJECT}-journal").exists():
            scenes.append(scene)
    return scenes


FAULTS = {"killed": 0, "EIO": 5, "ENOSPC": 28}


def fail_while_recovering(
    clean: Clean, scene: Path, folder: Path, every: int, victims: Victims, promise: Promise
) -> int:
    """Faults in the command that finds the journal of a killed one; how many were tried."""
    kept, tried = promise("F2"), 0
    for what, error in FAULTS.items():
        for at in range(1, 400, every):
            shutil.rmtree(folder, ignore_errors=True)
            shutil.copytree(scene, folder)
            ended = victims.run("check", folder / PROJECT, fault=Fault(str(folder), at, error, forever=bool(error)))
            if ended.code == 0:
                break
            tried += 1
            with kept.trial(f"{scene.name}, its recovery {what} at call {at}"):
                assert ended.code in (KILLED, 3) and "Traceback" not in ended.err, ended
                assert "fault of orient" not in ended.err, ended
                judge(clean, folder, Ended(KILLED, "", "", 0.0), victims)
    return tried


@pytest.mark.usefixtures("preloaded")
@pytest.mark.parametrize(
    ("name", "scenes", "every"),
    [
        ("select", 2, 3),
        pytest.param("run", 6, 1, marks=pytest.mark.slow),
        pytest.param("verify", 4, 1, marks=pytest.mark.slow),
    ],
)
def test_faults_while_an_interrupted_command_is_undone(
    name: str, scenes: int, every: int, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    found = hot_scenes(clean(name), tmp_path / "killed", victims, scenes)
    assert found, "no kill left a journal"
    tried = [fail_while_recovering(clean(name), hot, tmp_path / "scene", every, victims, promise) for hot in found]
    assert sum(tried) >= 3


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_stop_at_any_time(number: int, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    for name in ("run", "new", "verify"):
        stop_at_random(clean(name), 3, number, tmp_path / "scene", victims, promise)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("operation", each())
def test_stop_of_each_operation(
    operation: Operation, number: int, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    stop_at_random(clean(operation.name), 15, number, tmp_path / "scene", victims, promise)


def stop_at_random(clean: Clean, count: int, number: int, folder: Path, victims: Victims, promise: Promise) -> None:
    kept, chance = promise("F9"), Random(number)
    for part in range(count):
        moment = (part + chance.random()) * clean.seconds / count
        clean.scene(folder)
        started = victims.start(*clean.words(folder))
        time.sleep(moment)
        asked = time.monotonic()
        started.send(number)
        ended = started.ended()
        seconds = time.monotonic() - asked
        kept.largest("s to the end", seconds)
        with kept.trial(f"{clean.operation} stopped by {number} after {moment:.4f} s"):
            assert seconds < 1.0
            assert ended.code in (0, 128 + number, -number), ended
            judge(clean, folder, ended, victims)


def wait_until_it_listens(process: int) -> None:
    """Until the command has its handler of SIGTERM, which Python alone does not have."""
    caught = 0
    while not caught >> (signal.SIGTERM - 1) & 1:
        time.sleep(0.01)
        status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
        caught = int(status.split("SigCgt:")[1].split()[0], 16)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="no /proc to see when the command listens")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["SIGINT", "SIGTERM"])
def test_two_signals_stop_a_real_process_once(
    number: int, code: int, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """A second signal does not disturb the tidying; this is the program itself, with its start."""
    run = clean("run")
    folder = run.scene(tmp_path / "scene")
    child = start(*run.words(folder))
    wait_until_it_listens(child.pid)
    child.send_signal(number)
    child.send_signal(number)
    _, err = child.communicate(timeout=30)
    with promise("F9").trial("two signals"):
        assert (child.returncode, err) in ((code, STOPPED), (0, b"")), err
        judge(run, folder, Ended(child.returncode, "", err.decode(), 0.0), victims)
