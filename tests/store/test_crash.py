"""Killed, crowded, out of space: the file is old or new, and says the truth (RELIABILITY.md 5)."""

import hashlib
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from orient.errors import ProjectError
from orient.store.check import check_project
from orient.store.project import create_project, open_project
from tests.store.made import INPUTS, fill, new_run, readings

ROOT = Path(__file__).parents[2]
SPAWN = multiprocessing.get_context("spawn")

APPEND_FOR_EVER = """
import sys
from orient.store.project import open_project
from tests.store.made import new_run, readings
with open_project(sys.argv[1], "write") as project:
    new = new_run(project, "readings", outcome=readings(20_000))
    print("ready", flush=True)
    while True:
        project.append(new)
        print("stored", flush=True)
"""


def test_ten_kills_leave_a_sound_project(tmp_path: Path) -> None:
    path = tmp_path / "killed.orient"
    create_project(path, lambda project: fill(project, ["photo"]))
    moments = random.Random(20_000)
    reported = 0
    for _ in range(10):
        child = subprocess.Popen(
            [sys.executable, "-c", APPEND_FOR_EVER, str(path)], cwd=ROOT, stdout=subprocess.PIPE, text=True
        )
        assert child.stdout is not None and child.stdout.readline() == "ready\n"
        time.sleep(moments.uniform(0.0, 0.6))
        child.send_signal(signal.SIGKILL)
        reported += child.communicate()[0].count("stored")
        with open_project(path) as project:
            stored = len(project.runs("readings"))
        assert stored >= reported
        reported = stored
    report = check_project(path)
    assert report.ok, report.lines
    with open_project(path, "write") as project:
        project.append(new_run(project, "readings", outcome=readings(3)))
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def append_five(path: Path, seed: float) -> None:
    with open_project(path, "write") as project:
        for step in range(5):
            project.append(new_run(project, "control", seed + step))


def test_four_writers_at_once(tmp_path: Path) -> None:
    path = tmp_path / "crowded.orient"
    create_project(path)
    writers = [SPAWN.Process(target=append_five, args=(path, 10.0 * number)) for number in range(4)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join(60)
    assert [writer.exitcode for writer in writers] == [0, 0, 0, 0]
    with open_project(path) as project:
        assert [run.version for run in project.runs("control")] == list(range(1, 21))
    assert check_project(path).ok


def create_one(path: Path, seed: float) -> None:
    try:
        create_project(path, lambda project: [project.append(new_run(project, "photo", seed)), time.sleep(0.2)][0])
    except ProjectError as error:
        sys.exit(3 if "exists" in error.message else 4)


def test_of_two_creations_exactly_one_wins(tmp_path: Path) -> None:
    path = tmp_path / "wanted.orient"
    both = [SPAWN.Process(target=create_one, args=(path, seed)) for seed in (1.0, 2.0)]
    for process in both:
        process.start()
    for process in both:
        process.join(60)
    assert sorted(str(process.exitcode) for process in both) == ["0", "3"]
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert check_project(path).ok


LIMITED = """
import os, resource, sys
from orient.store.errors import DiskFull
from orient.store.project import open_project
from tests.store.made import new_run, readings
with open_project(sys.argv[1], "write") as project:
    new = new_run(project, "readings", outcome=readings(20_000))
    limit = os.path.getsize(sys.argv[1]) + 20_000
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    try:
        project.append(new)
    except DiskFull:
        print("full", flush=True)
    project.append(new_run(project, "control", 0.25))
    print("small", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="no file-size limit")
def test_no_space_left(full: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, str(full)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.stdout.split() == ["full", "small"], done.stderr
    assert check_project(full).ok
    with open_project(full) as project:
        assert len(project.runs()) == len(INPUTS) + 1
    assert [file.name for file in full.parent.iterdir()] == [full.name]


def test_replaced_while_open(full: Path) -> None:
    other = full.with_name("other")
    other.write_bytes(full.read_bytes())
    before = hashlib.sha256(other.read_bytes()).hexdigest()
    with open_project(full, "write") as project:
        new = new_run(project, "photo", 0.25)
        other.replace(full)
        with pytest.raises(ProjectError, match="was replaced"):
            project.append(new)
    assert hashlib.sha256(full.read_bytes()).hexdigest() == before
