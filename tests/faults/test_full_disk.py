"""No room: a limit on the file, on its pages, a disk that is really full: named, unchanged, usable afterwards (F5)."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.commands import ROOT
from tests.faults.operations import OPERATIONS, PROJECT, Operation, each
from tests.faults.oracle import Clean, judge
from tests.faults.victims import Fault, Victims
from tests.promises import Promise

CleanOf = Callable[[str], Clean]
PAGE = 4096
ROOM_PAGES = {"no room at all": 0, "room for some pages": 6}
SMALLEST = 20 * PAGE
"""Of a file that is made; the texts of the command, which the limit binds too, need some room."""


@pytest.mark.parametrize("room", ROOM_PAGES)
@pytest.mark.parametrize("operation", each("check"))
def test_a_file_that_may_not_grow(
    operation: Operation, room: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """RLIMIT_FSIZE: the system refuses a write in the middle."""
    one = clean(operation.name)
    folder = one.scene(tmp_path / "scene")
    size = SMALLEST if one.operation.makes_a_file else (folder / PROJECT).stat().st_size
    ended = victims.run(*one.words(folder), fault=Fault(file_size=size + ROOM_PAGES[room] * PAGE))
    with promise("F5").trial(f"{operation}, {room}"):
        assert (ended.code, "No space left while writing" in ended.err) in ((3, True), (0, False)), ended
        assert ended.code == 3 or (not one.operation.makes_a_file and operation.name != "run")
        judge(one, folder, ended, victims)


@pytest.mark.parametrize("operation", each("check"))
def test_a_budget_of_pages(
    operation: Operation, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise
) -> None:
    """SQLite's own limit: the transaction is rolled back inside SQLite."""
    one = clean(operation.name)
    folder = one.scene(tmp_path / "scene")
    pages = 20 if one.operation.makes_a_file else (folder / PROJECT).stat().st_size // PAGE
    ended = victims.run(*one.words(folder), fault=Fault(max_pages=pages))
    with promise("F5").trial(f"{operation}, {pages} pages"):
        assert ended.code in (0, 3), ended
        assert ended.code == 0 or "No space left while writing" in ended.err, ended
        judge(one, folder, ended, victims)


@pytest.mark.slow
def test_a_disk_that_is_full(tmp_path: Path, promise: Promise) -> None:
    kept = promise("F5")
    if shutil.which("unshare") is None or subprocess.run(["unshare", "--mount", "true"], check=False).returncode:
        pytest.skip("no right to mount a small disk (unshare --mount)")
    disk = tmp_path / "disk"
    disk.mkdir()
    words = ["unshare", "--mount", sys.executable, "-m", "tests.faults.full_disk", str(disk)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    for what, wrong in lines:
        with kept.trial(what):
            assert not wrong, wrong
    assert sum(what.endswith(": 3") for what, _ in lines) > len(OPERATIONS), "the disk was not full often enough"
