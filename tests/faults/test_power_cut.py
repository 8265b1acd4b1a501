"""Power cuts (F4): what a real command wrote is replayed up to a random call, unsynced sectors are lost at random.

That the simulator can find something is shown by the same commands with weaker syncing: OFF must corrupt files, FULL
must lose what was reported as stored.
"""

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random

import pytest

from orient.errors import OrientError
from tests.faults.operations import PROJECT, Operation, each
from tests.faults.oracle import Clean, recovered
from tests.faults.power_cut import Call, cut, read_log, write_out
from tests.faults.victims import Fault, Victims
from tests.promises import Promise

pytestmark = pytest.mark.usefixtures("preloaded")

CleanOf = Callable[[str], Clean]


@dataclass(frozen=True)
class Recorded:
    """All calls of one undisturbed command in `folder`."""

    clean: Clean
    folder: Path
    calls: Sequence[Call]


def record(clean: Clean, folder: Path, victims: Victims, synchronous: str | None = None) -> Recorded:
    clean.scene(folder)
    log = folder.with_name(f"{folder.name}.log")
    log.unlink(missing_ok=True)
    fault = Fault(str(folder), log=str(log), synchronous=synchronous)
    assert victims.run(*clean.words(folder), fault=fault).code == 0
    return Recorded(clean, folder, read_log(log))


def what_is_wrong(recorded: Recorded, at: int, chance: Random, is_acknowledged: bool) -> str:
    """Cut before call `at` and look; empty if nothing is wrong."""
    clean, folder = recorded.clean, recorded.folder
    write_out(cut(recorded.calls, at, folder, clean.template, chance), folder)
    try:
        now = recovered(folder / clean.operation.writes)
    except (AssertionError, OrientError) as error:
        return f"corrupt: {str(error)[:200]}"
    if now not in clean.allowed:
        return "corrupt: neither old nor new"
    if clean.operation.writes != PROJECT and (folder / PROJECT).exists():
        assert (folder / PROJECT).read_bytes() == (clean.template / PROJECT).read_bytes()
    return "lost" if is_acknowledged and now != clean.new else ""


def cuts(recorded: Recorded, count: int, seed: int, is_acknowledged: bool = False) -> list[str]:
    """What was wrong after each of `count` cuts at random calls, or after the command had said that it was done."""
    chance, end = Random(seed), len(recorded.calls)
    places = [end if is_acknowledged else chance.randint(0, end) for _ in range(count)]
    return [what_is_wrong(recorded, at, chance, is_acknowledged) for at in places]


def judge_cuts(recorded: Recorded, count: int, acknowledged: int, promise: Promise, seed: int) -> None:
    kept = promise("F4")
    found = cuts(recorded, count, seed) + cuts(recorded, acknowledged, seed + 1, is_acknowledged=True)
    for number, wrong in enumerate(found):
        with kept.trial(f"{recorded.clean.operation}, cut {number} of seed {seed}"):
            assert not wrong, wrong


@pytest.mark.parametrize("name", ["add", "new"])
def test_some_cuts(name: str, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    judge_cuts(record(clean(name), tmp_path / "scene", victims), 25, 10, promise, seed=600)


@pytest.mark.slow
@pytest.mark.parametrize("operation", each("check"))
def test_cuts(operation: Operation, clean: CleanOf, victims: Victims, tmp_path: Path, promise: Promise) -> None:
    count = 600 if operation.name == "run" else 200
    judge_cuts(record(clean(operation.name), tmp_path / "scene", victims), count, 200, promise, seed=200)


def test_without_syncing_the_simulator_finds_corruption(clean: CleanOf, victims: Victims, tmp_path: Path) -> None:
    weak = record(clean("add"), tmp_path / "scene", victims, synchronous="OFF")
    assert "s" not in {call.kind for call in weak.calls}
    assert sum(wrong.startswith("corrupt") for wrong in cuts(weak, 30, seed=409)) > 3


def test_with_less_syncing_the_simulator_finds_a_lost_commit(clean: CleanOf, victims: Victims, tmp_path: Path) -> None:
    weak = record(clean("add"), tmp_path / "scene", victims, synchronous="FULL")
    assert "lost" in cuts(weak, 20, seed=95, is_acknowledged=True)
    assert not any(wrong.startswith("corrupt") for wrong in cuts(weak, 20, seed=96))


def test_the_simulator_keeps_all_that_was_synced(clean: CleanOf, victims: Victims, tmp_path: Path) -> None:
    whole = record(clean("add"), tmp_path / "scene", victims)
    after = {path.name: path.read_bytes() for path in (tmp_path / "scene").iterdir()}
    found = cut(whole.calls, len(whole.calls), tmp_path / "scene", whole.clean.template, Random(1))
    assert {Path(name).name: content for name, content in found.items()} == after
    shutil.rmtree(tmp_path / "scene")
