"""Opening a file of unknown origin does nothing to anybody, soon and in little memory (RELIABILITY.md 3.3, 6.2).

Every file of the corpus meets every command in a process of its own, with 200 MB beyond what the process has, and is
killed if it does not end.
"""

import shutil
import signal
import sqlite3
import stat
import subprocess
import sys
import threading
from contextlib import suppress
from hashlib import sha256
from pathlib import Path

import pytest

from tests.faults.victims import Ended, Fault, Victims
from tests.hostile.corpus import AIMED, CORPUS, HARMLESS, HUGE, LETTER, VICTIM
from tests.promises import Promise

MORE_BYTES = 200 * 2**20
SLOWEST_S, HANGS_S = 3.0, 60.0
BYTES_PER_S = 50 * 10**6
"""A copy of a large file takes its time."""
COPY = "copy.sqlite"
COMMANDS: dict[str, tuple[str, ...]] = {
    "status": ("status", "P"),
    "log": ("log", "P"),
    "show": ("show", "P", "photo"),
    "sql": ("sql", "P", "SELECT * FROM v_current"),
    "select": ("select", "P", "photo", "1", "-m", "x"),
    "check": ("check", "P"),
    "upgrade": ("upgrade", "P"),
    "backup": ("backup", "P", "COPY"),
    "receive": ("receive", "P", "COPY"),
    "seal": ("seal", "P", "-o", "COPY"),
}
QUICK = ("status", "select", "check", "receive")
EXAMINING = ("check", "backup", "receive", "seal")
"""Commands that look at every byte: none of them calls a file of the corpus sound."""
ALLOWED_CODES = (0, 1, 2, 3)


def scene(folder: Path, full: Path, name: str) -> Path:
    """The hostile file and, beside it, a file that it may aim at."""
    folder.mkdir()
    path = Path(shutil.copy(full, folder / "stranger.sqlite"))
    (folder / VICTIM).write_text(LETTER)
    {**CORPUS, **HUGE}[name](path)
    return path


def content(folder: Path) -> dict[str, str]:
    """What lies in the folder; a large file by its size and times."""
    found = {}
    for path in sorted(folder.iterdir()):
        state = path.lstat()
        if stat.S_ISREG(state.st_mode) and state.st_size < 5 * 10**7:
            found[path.name] = sha256(path.read_bytes()).hexdigest()
        else:
            found[path.name] = f"{state.st_mode} {state.st_size} {state.st_mtime_ns if state.st_size else 0}"
    return found


def ended(victims: Victims, words: list[str]) -> Ended:
    """The command, killed when it hangs."""
    started = victims.start(*words, fault=Fault(more_memory=MORE_BYTES))
    timer = threading.Timer(HANGS_S, lambda: started.send(signal.SIGKILL))
    timer.start()
    try:
        return started.ended()
    finally:
        timer.cancel()


def judge(command: str, name: str, said: Ended, folder: Path, before: dict[str, str]) -> None:
    assert said.code in ALLOWED_CODES, said
    assert "Traceback" not in said.err
    assert "\x1b" not in said.out + said.err
    assert (folder / VICTIM).read_text() == LETTER
    size = sum(path.lstat().st_size for path in folder.iterdir())
    assert said.seconds < SLOWEST_S + size / BYTES_PER_S, f"{said.seconds:.1f} s"
    made = {COPY} if said.code == 0 and command in ("backup", "receive", "seal") else set()
    after = content(folder)
    assert after.keys() == before.keys() | made, after.keys()
    is_received = (command, name) == ("receive", "D16 WAL")
    if command in EXAMINING and name not in HARMLESS and not is_received:
        assert said.code != 0, said.out
    if said.code:
        assert said.err.startswith(("orient: ", "Usage: ")), said.err
        assert {key: after[key] for key in before} == before


@pytest.mark.parametrize("name", CORPUS)
def test_no_file_of_the_corpus_harms(
    name: str, full_once: Path, tmp_path: Path, victims: Victims, promise: Promise
) -> None:
    try_commands(QUICK, name, full_once, tmp_path, victims, promise)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*CORPUS, *HUGE])
def test_no_file_harms_any_command(
    name: str, full_once: Path, tmp_path: Path, victims: Victims, promise: Promise
) -> None:
    try_commands(tuple(COMMANDS), name, full_once, tmp_path, victims, promise)


def try_commands(
    commands: tuple[str, ...], name: str, full: Path, tmp_path: Path, victims: Victims, promise: Promise
) -> None:
    """A file that is refused unchanged serves for the next command too."""
    harm, soon = promise("S1"), promise("S2")
    side = promise("S5") if "journal" in name or "log" in name or "beside" in name else None
    declares = promise("S6") if "MB" in name or "million" in name or "D26" in name else None
    runs = promise("S4") if name.startswith(("view", "trigger", "D22", "check", "default", "generated")) else None
    folder = tmp_path / "scene"
    path = scene(folder, full, name)
    for command in commands:
        before = content(folder)
        placed = [{"P": str(path), "COPY": str(folder / COPY)}.get(word, word) for word in COMMANDS[command]]
        said = ended(victims, placed)
        for kept in (harm, soon, side, declares, runs):
            if kept is not None:
                with kept.trial(f"{name}, {command}"):
                    judge(command, name, said, folder, before)
        soon.largest("seconds", said.seconds)
        if said.code == 0:
            shutil.rmtree(folder)
            path = scene(folder, full, name)


def test_the_super_journal_is_a_real_one(full_once: Path, tmp_path: Path) -> None:
    """Opened without orient's look at it, an SQLite before 2026 deletes the victim; a later one leaves it."""
    folder = tmp_path / "scene"
    path = scene(folder, full_once, "super-journal")
    code = "import sqlite3, sys; sqlite3.connect(sys.argv[1]).execute('SELECT count(*) FROM sqlite_schema').fetchone()"
    subprocess.run([sys.executable, "-c", code, str(path)], check=False, capture_output=True)
    if (folder / VICTIM).exists():
        pytest.skip(f"SQLite {sqlite3.sqlite_version} no longer deletes what a journal names")
    assert not (folder / VICTIM).exists()


def test_the_stray_log_is_a_real_one(full_once: Path, tmp_path: Path) -> None:
    """Opened without orient's look beside it, the content is another and integrity_check says ok."""
    folder = tmp_path / "scene"
    path = scene(folder, full_once, "stray log")
    connection = sqlite3.connect(path)
    with suppress(sqlite3.Error):
        assert connection.execute("SELECT name FROM photo").fetchone() == ("replaced by a stray log",)
        assert connection.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    connection.close()


def test_every_aimed_file_is_another_than_the_sound_one(full_once: Path, tmp_path: Path) -> None:
    sound = content(scene_of_nothing(tmp_path / "sound", full_once))
    for number, name in enumerate(AIMED):
        folder = tmp_path / str(number)
        scene(folder, full_once, name)
        assert content(folder) != sound, name
        shutil.rmtree(folder)


def scene_of_nothing(folder: Path, full: Path) -> Path:
    folder.mkdir()
    shutil.copy(full, folder / "stranger.sqlite")
    (folder / VICTIM).write_text(LETTER)
    return folder
