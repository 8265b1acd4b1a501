"""100 000 damaged files: refused or found by `check`; never a crash, a hang, a lost file or more than 512 MB."""

import json
import os
import shutil
import sqlite3
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import pytest

from tests.cli.commands import ROOT
from tests.promises import Promise

SEED = 100_000
WORKERS = 2
AT_ONCE = 2_000
PAGE_SIZES = (512, 4096)
"""Small pages are full pages: most bytes matter. 4096 is what orient makes."""
TRIED = {"some": 200, "all": 100_000}


@pytest.fixture(scope="session")
def bases(full_once: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("bases")
    made = []
    for size in PAGE_SIZES:
        path = Path(shutil.copy(full_once, folder / f"{size}.sqlite"))
        with closing(sqlite3.connect(path)) as connection:
            connection.execute(f"PRAGMA page_size = {size}")
            connection.execute("VACUUM")
        made.append(path)
    return made


@pytest.mark.slow
def test_100_000_damaged_files(bases: list[Path], tmp_path: Path, promise: Promise) -> None:
    try_many(TRIED["all"], AT_ONCE, bases, tmp_path, promise)


def test_some_damaged_files_in_processes_of_their_own(bases: list[Path], tmp_path: Path, promise: Promise) -> None:
    try_many(TRIED["some"], TRIED["some"] // 4, bases, tmp_path, promise)


def try_many(count: int, at_once: int, bases: list[Path], tmp_path: Path, promise: Promise) -> None:
    def portion(number: int) -> dict[str, object]:
        folder = tmp_path / str(number)
        folder.mkdir()
        return worker(bases[number % len(bases)], folder, number * at_once, at_once)

    with ThreadPoolExecutor(WORKERS) as pool:
        tallies = list(pool.map(portion, range(count // at_once)))
    kept, content = promise("S3"), promise("F11")
    for tally in tallies:
        told = [*texts(tally, "dead"), *texts(tally, "uncaught"), *texts(tally, "lost")]
        kept.count += at_once
        kept.failed += told
        content.count += at_once
        content.failed += texts(tally, "silent")
        kept.largest("seconds", float(str(tally.get("slowest_s", 0))))
        kept.largest("MB more", float(str(tally.get("more_mb", 0))))
    found, harmless = total(tallies, "found"), total(tallies, "harmless")
    print(f"{found} found, {harmless} harmless, {total(tallies, 'received')} received")
    where: Counter[str] = Counter()
    for tally in tallies:
        where.update(tally.get("lines", {}))  # type: ignore[call-overload]
    print("first fault in", dict(where))
    assert found > count / 3
    assert harmless > 0


def worker(base: Path, folder: Path, first: int, count: int) -> dict[str, object]:
    """The tally of one process; `dead` tells the file at which it died."""
    words = [base, folder, SEED, first, count]
    ended = subprocess.run(
        [sys.executable, "-m", "tests.hostile.mutation_worker", *map(str, words)],
        cwd=ROOT,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    if ended.returncode:
        number = (folder / "number").read_text() if (folder / "number").exists() else "the first"
        return {"dead": [f"{base.name}, seed {SEED}, file {number}: exit {ended.returncode}: {ended.stderr[-500:]}"]}
    return dict(json.loads(ended.stdout))


def texts(tally: dict[str, object], key: str) -> list[str]:
    found = tally.get(key, [])
    return [str(text) for text in found] if isinstance(found, list) else []


def total(tallies: Iterable[dict[str, object]], key: str) -> int:
    return sum(int(str(tally.get(key, 0))) for tally in tallies)
