"""One judge for every case (RELIABILITY.md 5): old or new, sound, told the truth, works again, nothing left beside.

The state of a project is its ledger: per run its stage, version and digests, and the selections that followed it.
"""

import os
import re
import shutil
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from orient.store.check import check_project
from tests.faults.operations import PROJECT, Operation
from tests.faults.victims import Ended, Fault, Victims

Group = tuple[object, ...]
State = tuple[int, tuple[Group, ...]] | None
"""Format number and runs; None: there is no file."""

RUNS = """
SELECT r.run_id, r.stage, r.version, r.input_digest, s.status, s.row_count, s.output_digest
FROM stage_run AS r LEFT JOIN run_seal AS s USING (run_id) ORDER BY r.run_id
"""
SELECTIONS = "SELECT after_run_id, stage, run_id FROM selection ORDER BY selection_id"
REPORTED = re.compile(r"^ *(\w+) +version (\d+)\b", re.MULTILINE)
NOTHING = "Nothing "
"""So begins every sentence about an unchanged file."""
MOST_LINES = 6
SIGNALLED = 128
"""Exit codes above it tell the signal that stopped the command."""


def state_of(path: Path) -> State:
    """Read without orient; what a killed command left must have been undone before."""
    if not path.exists():
        return None
    with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as bare:
        version = int(bare.execute("PRAGMA user_version").fetchone()[0])
        runs, selections = bare.execute(RUNS).fetchall(), bare.execute(SELECTIONS).fetchall()
    return version, tuple((*run, *(chosen[1:] for chosen in selections if chosen[0] == run[0])) for run in runs)


def is_sound_to_sqlite(path: Path) -> bool:
    with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as bare:
        whole = bare.execute("PRAGMA integrity_check").fetchall()
        return whole == [("ok",)] and bare.execute("PRAGMA foreign_key_check").fetchall() == []


@dataclass(frozen=True)
class Clean:
    """What the operation does when nothing disturbs it."""

    operation: Operation
    template: Path
    old: State
    new: State
    names: frozenset[str]
    seconds: float
    calls: str
    """One letter per call that changes a file; see fault_library.c."""

    @property
    def allowed(self) -> frozenset[State]:
        """Before, after, and after each of the runs that the command stores one by one."""
        old, new = self.old, self.new
        between: list[State] = []
        if old and new and old[0] == new[0]:
            between = [(new[0], new[1][:count]) for count in range(len(old[1]) + 1, len(new[1]))]
        return frozenset([old, new, *between])

    def scene(self, folder: Path) -> Path:
        """The folder, as it is before the operation."""
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.template, folder)
        return folder

    def words(self, folder: Path) -> tuple[object, ...]:
        return self.operation.words(folder)

    def moments(self, every: int = 1) -> list[int]:
        """Numbers of calls to disturb: all but those amid equal writes, of which only each 16th; of these each k-th."""
        calls = f" {self.calls} "
        places = range(1, len(self.calls) + 1)
        return [place for place in places if len(set(calls[place - 1 : place + 2])) > 1 or place % 16 == 0][::every]


def undisturbed(operation: Operation, templates: Path, folder: Path, victims: Victims, log: Path) -> Clean:
    """Run it once and look."""
    from tests.faults.power_cut import read_log

    template = templates / operation.template
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(template, folder)
    log.unlink(missing_ok=True)
    old = state_of(folder / operation.writes)
    ended = victims.run(*operation.words(folder), fault=Fault(str(folder), log=str(log)))
    assert ended.code == 0, ended
    new, names = state_of(folder / operation.writes), frozenset(path.name for path in folder.iterdir())
    calls = "".join(call.kind for call in read_log(log))
    return Clean(operation, template, old, new, names, ended.seconds, calls)


def check_told(clean: Clean, ended: Ended, now: State) -> None:
    """(c) the exit code and the words are true."""
    assert "Traceback" not in ended.err and "fault of orient" not in ended.err, ended
    assert len(ended.err.splitlines()) <= MOST_LINES, ended.err
    if ended.code == 0:
        assert now == clean.new, f"said it was done: {ended.out}"
    if ended.code > 0:
        assert ended.code in (1, 3, 130, 143), ended
        assert ended.err.startswith("orient: "), ended.err
    in_steps = clean.operation.name == "run"
    if NOTHING in ended.err and not in_steps:
        assert now == clean.old, f"said that nothing changed: {ended.err}"
    reported, stored = set(REPORTED.findall(ended.out)), _versions(now)
    if in_steps and ended.code > 0:
        new = stored - _versions(clean.old)
        assert reported <= new, f"reported and not stored: {ended}"
        # a signal may come after the commit of a step and before its line; the words say where to look
        assert len(new - reported) <= (ended.code > SIGNALLED), f"stored is not what was reported: {ended}"
    if in_steps or ended.code == 0:
        assert reported <= stored, f"reported and not stored: {ended.out}"


def _versions(state: State) -> set[tuple[str, str]]:
    return {(str(group[1]), str(group[2])) for group in state[1]} if state else set()


def recovered(path: Path) -> State:
    """(b) `check` undoes what is to be undone and finds everything sound."""
    if not path.exists():
        return None
    report = check_project(path)
    is_old = any("Run: orient upgrade" in line.hint for line in report.lines)
    assert report.ok or is_old, [line for line in report.lines if not line.ok]
    state = state_of(path)
    assert is_sound_to_sqlite(path)
    return state


def judge(clean: Clean, folder: Path, ended: Ended, victims: Victims) -> None:
    """All five questions about a command that ended in `folder`, with or without a fault."""
    path = folder / clean.operation.writes
    now = recovered(path)
    assert now in clean.allowed, f"(a) neither old nor new: {now}"
    check_told(clean, ended, now)
    if clean.operation.writes != PROJECT and (folder / PROJECT).exists():
        assert (folder / PROJECT).read_bytes() == (clean.template / PROJECT).read_bytes(), "the source was changed"
    _works_again(clean, folder, now, victims)


def _works_again(clean: Clean, folder: Path, now: State, victims: Victims) -> None:
    """(d) the same command works now, (e) and nothing is left beside the file."""
    path = folder / clean.operation.writes
    again = victims.run(*clean.words(folder))
    exists = clean.operation.makes_a_file and now is not None
    assert ("exists" in again.err) if exists else again.code == 0, f"(d) {again}"
    if exists:
        assert victims.run("select", path, "photo", 1, "-m", "next").code == 0
    state = recovered(path)
    assert state is not None
    if now == clean.old:
        assert state == clean.new, "(d) the next command came to another result"
    names = set(os.listdir(folder))  # noqa: PTH208
    assert names == clean.names, f"(e) left beside the file: {names ^ clean.names}"
