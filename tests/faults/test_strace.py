"""The same at the border of the kernel: strace kills or fails system calls of the real program, without our library."""

import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from tests.cli.commands import ENTRY, ROOT
from tests.faults.operations import PROJECT
from tests.faults.oracle import Clean, judge
from tests.faults.victims import Ended, Victims
from tests.promises import Promise

pytestmark = pytest.mark.slow

CleanOf = Callable[[str], Clean]
INJECTIONS = {
    "kill": ("signal=KILL", "F2"),
    "EIO": ("error=EIO", "F3"),
    "ENOSPC": ("error=ENOSPC", "F5"),
}
CALLS = {"pwrite64": range(1, 40, 3), "fdatasync": range(1, 8), "unlink": range(1, 3), "openat": range(1, 8)}


@cache
def can_trace() -> bool:
    strace = shutil.which("strace")
    return strace is not None and subprocess.run([strace, "-o", "/dev/null", "true"], check=False).returncode == 0


def traced(injection: str, folder: Path, words: tuple[object, ...]) -> Ended:
    """The command under strace; only calls on the project, its journal and the folder are struck."""
    names = [str(folder), str(folder / PROJECT), str(folder / f"{PROJECT}-journal")]
    only = [part for name in names for part in ("-P", name)]
    command = ["strace", "-f", "-qq", "-o", "/dev/null", *only, "-e", injection, sys.executable, "-c", ENTRY]
    begun = time.monotonic()
    done = subprocess.run([*command, *map(str, words)], cwd=ROOT, capture_output=True, text=True, check=False)
    return Ended(done.returncode, done.stdout, done.stderr, time.monotonic() - begun)


@pytest.mark.parametrize("what", INJECTIONS)
@pytest.mark.parametrize("call", CALLS)
def test_system_calls(call: str, what: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    effect, name = INJECTIONS[what]
    kept, one = promise(name), clean("bl")
    if not can_trace():
        pytest.skip("no strace, or no right to trace (apt-get install strace)")
    struck = 0
    for number in CALLS[call]:
        folder = one.scene(tmp_path / "scene")
        ended = traced(f"inject={call}:{effect}:when={number}", folder, one.words(folder))
        struck += ended.code != 0
        with kept.trial(f"{what} at {call} {number}"):
            assert ended.code in (0, 3, -9, 137), ended
            judge(one, folder, Ended(-9, "", "", 0.0) if ended.code == 137 else ended, victims)
    assert struck
