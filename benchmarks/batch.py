"""Many photos: two workers against one worker, and one worker against a plain loop in one process, as ratios.

Every block of generated photos is run by all candidates one after the other, in another order each time, so that a busy
machine slows all of them alike. Clusters are started before; their start is told apart. What a worker does for a photo
includes reading its numbers back and its row in the summary; the loop only runs the stages.
`make bench` writes it into docs/performance.md; alone it prints markdown:

    python -m benchmarks.batch [--photos 1000] [--block 100]
"""

import argparse
import contextlib
import os
import random
import shutil
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from orient.batch.cluster import Pool, local_workers
from orient.batch.coordinator import Plan, run_batch
from orient.batch.summary import open_summary
from orient.batch.values import Item, Order
from orient.batch.work_list import WorkList
from orient.intake.options import ReadOptions
from orient.intake.project_folder import read_project
from orient.pipeline.runner import create, run_stale
from orient.store.summary_engine import summary_place
from tests.cli.made_photo import MadePhoto

PHOTOS, BLOCK = 1000, 100
DIFFERENT = 20
"""Photos that differ; more are copies of them: making one costs as much as running it."""
SPEED_UP, OVERHEAD = 1.7, 1.2
COORDINATOR_S: list[float] = []
"""Processor time per photo of this process beside the workers: scheduler, client, summary."""
Candidate = Callable[[Sequence[Path]], None]


def measured(photos: int = PHOTOS, block: int = BLOCK) -> str:
    """The figures as markdown; see the module."""
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        place = Path(folder)
        models = _models(place)
        begun = time.perf_counter()
        pools = [stack.enter_context(local_workers(count, None)) for count in (1, 2)]
        start_s = (time.perf_counter() - begun) / 2
        candidates = {"loop": _loop, **{f"{pool.size} workers": _batch(pool, place) for pool in pools}}
        for candidate in candidates.values():
            _seconds(candidate, models[:8], place)  # imports, first touches
        times = _measure(candidates, [models[number % DIFFERENT] for number in range(block)], place, photos // block)
    head = f"{photos} photos in blocks of {block}; a cluster starts in {start_s:.1f} s."
    return "\n".join([head, "", *_table(times), ""])


def _models(place: Path) -> list[Path]:
    made = []
    for number in range(DIFFERENT):
        folder = MadePhoto(noise=0.5 + 0.05 * number).write(place / f"folder-{number}")
        made.append(place / f"model-{number}.sqlite")
        create(made[-1], read_project(folder, ReadOptions()), "benchmark")
    return made


def _measure(
    candidates: dict[str, Candidate], block: Sequence[Path], place: Path, blocks: int
) -> dict[str, list[float]]:
    """Seconds per photo of every candidate in every block."""
    chance = random.Random(7)
    times: dict[str, list[float]] = {name: [] for name in candidates}
    for _ in range(max(1, blocks)):
        for name in chance.sample(sorted(candidates), len(candidates)):
            times[name].append(_seconds(candidates[name], block, place) / len(block))
    return times


def _seconds(candidate: Candidate, block: Sequence[Path], place: Path) -> float:
    """Wall time for fresh copies of the block."""
    folder = Path(tempfile.mkdtemp(dir=place))
    photos = [Path(shutil.copy(model, folder / f"{number}.sqlite")) for number, model in enumerate(block)]
    os.sync()
    begun = time.perf_counter()
    candidate(photos)
    seconds = time.perf_counter() - begun
    shutil.rmtree(folder)
    return seconds


def _loop(photos: Sequence[Path]) -> None:
    for path in photos:
        results = run_stale(path, {}, "benchmark", lambda stage: None, lambda result: None)
        assert not any(result.failed for result in results)


def _batch(pool: Pool, place: Path) -> Candidate:
    summary = open_summary(summary_place(str(place / f"summary-{pool.size}.db")))

    def run(photos: Sequence[Path]) -> None:
        begun = time.process_time()
        items = tuple(Item(str(path)) for path in photos)
        codes: list[int] = []
        plan = Plan(items, {}, {})
        run_batch(WorkList(items, 0), plan, Order(), summary, pool, lambda ending: codes.append(ending.exit_code))
        assert codes == [0] * len(photos)
        COORDINATOR_S.append((time.process_time() - begun) / len(photos))

    return run


def _table(times: dict[str, list[float]]) -> list[str]:
    loop, one, two = (times[name] for name in ("loop", "1 workers", "2 workers"))
    speed_up = [slow / fast for slow, fast in zip(one, two, strict=True)]
    overhead = [worker / alone for worker, alone in zip(one, loop, strict=True)]
    own_ms = 1e3 * statistics.median(COORDINATOR_S)
    return [
        "| candidate | ms per photo, median |",
        "|---|---:|",
        *(f"| {name} | {1e3 * statistics.median(values):.1f} |" for name, values in times.items()),
        "",
        f"Processor time of scheduler, client and summary: {own_ms:.1f} ms per photo.",
        "",
        "| ratio | median | quartiles | target |",
        "|---|---:|---|---:|",
        _row("speed-up of two workers over one", speed_up, ">=", SPEED_UP),
        _row("one worker to the loop in one process", overhead, "<=", OVERHEAD),
    ]


def _row(name: str, ratios: list[float], sign: str, target: float) -> str:
    low, middle, high = statistics.quantiles(ratios, n=4) if len(ratios) > 1 else ratios * 3
    mark = "" if (middle >= target if sign == ">=" else middle <= target) else " **missed**"
    return f"| {name} | {middle:.2f} | {low:.2f} ... {high:.2f} | {sign} {target}{mark} |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m benchmarks.batch", description=__doc__)
    parser.add_argument("--photos", type=int, default=PHOTOS)
    parser.add_argument("--block", type=int, default=BLOCK)
    print(measured(**vars(parser.parse_args())))
