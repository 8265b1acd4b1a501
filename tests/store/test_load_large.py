"""A large project stays usable: the curve of `status` and `log`, `check` of 500 MB, exports that stream.

Work is counted in operations of SQLite, memory in bytes, time in seconds of the processor: a busy machine changes none.
"""

import json
import os
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from benchmarks.projects import write
from orient.export import BY_NAME, Options, make
from orient.report.status import CURRENT, LOG, STATUS
from orient.store.digest import input_digest, output_digest
from orient.store.project import NewRun, Project, create_project, open_project
from orient.values import Columns, Outcome
from tests.promises import Promise
from tests.store.test_load import with_versions, work_of

pytestmark = pytest.mark.slow

VERSIONS = (1, 10, 100, 1000)
LARGE_BYTES, ROWS_AT_ONCE = 500 * 10**6, 500_000
CHECK_S, OPEN_S, CHECK_BYTES = 60.0, 1.0, 400 * 2**20
POINTS, GROWTH_BYTES = (5_000, 20_000), 1.5e6
ORIENT = "from orient.cli.main import run; run()"
MEASURED = """
import json, re, resource, sys
from orient.cli.main import run
try:
    run()
finally:
    used = resource.getrusage(resource.RUSAGE_SELF)
    peak = re.search(r"VmHWM:\\s*(\\d+)", open("/proc/self/status").read())  # ru_maxrss may be that of the parent
    print(json.dumps([used.ru_utime + used.ru_stime, int(peak[1]) * 1024]))
"""


@pytest.mark.parametrize("name", ["status", "current", "log"])
def test_work_with_the_number_of_versions(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, promise: Promise
) -> None:
    """Never more than in proportion to the versions; 1000 versions add less than 30 000 times 100 operations."""
    sql = {"status": STATUS, "current": CURRENT, "log": LOG}[name]
    curve = [work_of(sql, with_versions(tmp_path / f"{n}.sqlite", n), monkeypatch) for n in VERSIONS]
    print(name, dict(zip(VERSIONS, (100 * count for count in curve), strict=True)))
    kept = promise("L1")
    with kept.trial(f"{name}: {curve} hundred operations for {VERSIONS} versions"):
        added = [count - curve[0] for count in curve[1:]]
        assert added[2] <= 11.5 * max(added[1], 5)
    kept.largest(f"operations of {name} with 1000 versions", 100 * curve[-1])


def test_check_of_500_megabytes(tmp_path: Path, promise: Promise) -> None:
    path = _large(tmp_path / "large.sqlite")
    size = path.stat().st_size
    begin = time.process_time()
    with open_project(path, "read") as project:
        project.query(STATUS)
    opened = time.process_time() - begin
    begin = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", MEASURED, "check", str(path)], capture_output=True, text=True)
    wall = time.perf_counter() - begin
    seconds, memory = json.loads(done.stdout.splitlines()[-1])
    print(f"{size / 1e6:.0f} MB: opened in {opened:.2f} s, check {seconds:.1f} s, {wall:.1f} s of the clock")
    kept = promise("L2")
    with kept.trial("sound"):
        assert done.returncode == 0, done.stdout + done.stderr
        assert size >= LARGE_BYTES
    with kept.trial(f"opened in {opened:.2f} s, checked in {seconds:.1f} s"):
        assert opened < OPEN_S
        assert seconds < CHECK_S
    kept.largest("s of check", seconds)
    kept.largest("s on the clock", wall)
    with promise("L3").trial(f"check used {memory / 2**20:.0f} MB"):
        assert memory < CHECK_BYTES
    promise("L3").largest("MB of check", memory / 2**20)


@pytest.mark.parametrize("name", ["residuals", "points"])
def test_exports_stream(name: str, tmp_path: Path, promise: Promise) -> None:
    """Four times the points: the same memory, but for what the allocator rounds."""
    few, many = (_peak_of_export(_oriented(tmp_path / str(n), n), name) for n in POINTS)
    with promise("L3").trial(f"{name}: {few / 1e6:.1f} MB for {POINTS[0]} points, {many / 1e6:.1f} MB for {POINTS[1]}"):
        assert many < few + GROWTH_BYTES


def _large(path: Path) -> Path:
    """Versions of readings until the file is large."""

    def fill(project: Project) -> None:
        project.let_spill()
        number = 0
        while path_of(project).stat().st_size < LARGE_BYTES:
            number += 1
            project.append(_readings(number))

    def path_of(project: Project) -> Path:
        return project.path

    create_project(path, fill)
    return path


def _readings(number: int) -> NewRun:
    n, rng = ROWS_AT_ONCE, np.random.default_rng(number)
    nothing = [None] * n
    rows = Columns(
        {"seq": list(range(n)), "point": [f"P{i:06}" for i in range(n)], "kind": ["point"] * n, "cycle": [1] * n,
         "x_mm": rng.uniform(-100, 100, n), "y_mm": rng.uniform(-100, 100, n), "col_px": nothing, "row_px": nothing,
         "sigma": nothing}
    )  # fmt: skip
    tables = {"comparator_reading": rows}
    digest = input_digest("readings", 1, {}, {"content": output_digest(tables)})
    return NewRun("readings", 1, {}, {}, digest, Outcome(tables), {}, "tester", "load")


def _oriented(folder: Path, n: int) -> Path:
    folder.mkdir()
    path = folder / "project.sqlite"
    for words in (["new", str(path), "--from", str(write(folder / "input", n))], ["run", str(path)]):
        subprocess.run([sys.executable, "-c", ORIENT, *words], check=True, capture_output=True, env={**os.environ})
    return path


def _peak_of_export(path: Path, name: str) -> int:
    form = BY_NAME[name]
    make(path, form, ".csv", "points.csv", Options())  # what is imported and kept by then does not count
    tracemalloc.start()
    for _ in make(path, form, ".csv", "points.csv", Options()).content:
        pass
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak
