"""Checks damaged files one after the other in one process, which may not use more than 512 MB beyond what it has.

`python -m tests.hostile.mutation_worker BASE FOLDER SEED FIRST COUNT` prints one JSON object. The number of the file in
work stands in FOLDER/number, for the case that the process dies; a file that hangs ends it after a minute.
"""

import faulthandler
import json
import random
import resource
import sys
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path

from orient.errors import OrientError
from orient.store.check import check_project
from orient.store.copies import receive_project
from tests.store.mutations import KINDS, content_of

MORE_BYTES = 512 * 2**20
HANGS_S = 60
EACH_RECEIVED = 25


@dataclass
class Tally:
    """What became of the files: found or harmless; `silent`, `uncaught` and `lost` name the numbers of failures."""

    found: int = 0
    harmless: int = 0
    received: int = 0
    silent: list[str] = field(default_factory=list)
    uncaught: list[str] = field(default_factory=list)
    lost: list[str] = field(default_factory=list)
    slowest_s: float = 0.0
    more_mb: float = 0.0
    lines: dict[str, int] = field(default_factory=dict)


def damaged(original: bytes, seed: int, number: int) -> tuple[str, bytes]:
    """File `number` of a seed; the same at every run."""
    content, kind = bytearray(original), KINDS[number % len(KINDS)]
    kind(content, random.Random(f"{seed} {number}"))
    return f"{kind.__name__} {seed} {number}", bytes(content)


def work(base: Path, folder: Path, seed: int, first: int, count: int) -> Tally:
    original, meant = base.read_bytes(), content_of(base)
    path, tally = folder / "damaged.sqlite", Tally()
    assert check_project(base).ok
    peak = peak_mb()
    limit_memory()
    for number in range(first, first + count):
        (folder / "number").write_text(str(number))
        name, content = damaged(original, seed, number)
        path.write_bytes(content)
        faulthandler.dump_traceback_later(HANGS_S, exit=True)
        _try(path, name, content, meant, tally)
        if number % EACH_RECEIVED == 0:
            _receive(path, name, meant, tally)
        faulthandler.cancel_dump_traceback_later()
    tally.more_mb = peak_mb() - peak
    return tally


def _try(path: Path, name: str, content: bytes, meant: object, tally: Tally) -> None:
    started = time.monotonic()
    try:
        report = check_project(path)
    except Exception as error:
        tally.uncaught.append(f"{name}: {type(error).__name__}: {error}")
        return
    tally.slowest_s = max(tally.slowest_s, time.monotonic() - started)
    tally.found, tally.harmless = tally.found + (not report.ok), tally.harmless + report.ok
    first = next((line.name for line in report.lines if not line.ok), "none")
    tally.lines[first] = tally.lines.get(first, 0) + 1
    if not path.exists() or path.read_bytes() != content:
        tally.lost.append(name)
    if report.ok and content_of(path) != meant:
        tally.silent.append(name)


def _receive(path: Path, name: str, meant: object, tally: Tally) -> None:
    """A clean copy of a damaged file has the content that was meant, or there is none."""
    target = path.with_name("received.sqlite")
    try:
        receive_project(path, target)
    except OrientError:
        return
    except Exception as error:
        tally.uncaught.append(f"{name}, received: {type(error).__name__}: {error}")
        return
    tally.received += 1
    if content_of(target) != meant:
        tally.silent.append(f"{name}, received")
    target.unlink()


def peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def limit_memory() -> None:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    size = pages * resource.getpagesize() + MORE_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (size, size))


if __name__ == "__main__":
    base, folder, seed, first, count = sys.argv[1:]
    print(json.dumps(asdict(work(Path(base), Path(folder), int(seed), int(first), int(count)))))
