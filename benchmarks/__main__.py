"""`make bench`: everything, in a quarter of an hour; `--only TEXT` for the rows whose name has it."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy is loaded: one thread for all candidates

import argparse
import sys
from pathlib import Path

from benchmarks import batch, ground, page, projects, solving, starting, storing
from benchmarks.measuring import OWN, Task, Timed, measure

ROOT = Path(__file__).parents[1]
SIZES = (100, 1000, 10_000, 100_000)


def main() -> int:
    parser = argparse.ArgumentParser(prog="make bench", description=__doc__)
    parser.add_argument("--only", default="", help="rows whose name contains this; nothing is written")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--budget-s", type=float, default=6.0, help="seconds for one row")
    chosen = parser.parse_args()
    done = []
    for group in (starting, storing, solving, ground):
        for task in group.tasks():
            if chosen.only in task.name:
                done += _measured(task, chosen.rounds, chosen.budget_s)
    if not chosen.only:
        page.write(done, [projects.measured(n) for n in SIZES], batch.measured(), ROOT)
        print("docs/performance.md and docs/figures/growth.svg are written.")
    wrong = [timed.task.name for timed in done if _differs(timed)]
    if wrong:
        print(f"RESULTS DIFFER: {', '.join(wrong)}", file=sys.stderr)
    return int(bool(wrong))


def _measured(task: Task, rounds: int, budget_s: float) -> list[Timed]:
    """The row, printed at once; nothing if the anchor is not installed."""
    try:
        timed = measure(task, rounds, budget_s)
    except ImportError as error:
        print(f"{task.name}: left out, {error.name} is not installed (pip install -e '.[bench]')")
        return []
    told = ", ".join(f"{name} {timed.ratios(name)[1]:.3g}" for name in timed.seconds if name != timed.anchor)
    print(f"{task.name}: {told} of {timed.anchor}", flush=True)
    return [timed]


def _differs(timed: Timed) -> bool:
    """Is a result of orient's, compiled or not, too far from the anchor's?"""
    own = [apart for name, apart in timed.apart.items() if name.startswith(OWN)]
    return bool(own) and max(own) > (timed.task.tolerance or 1.0)


if __name__ == "__main__":
    sys.exit(main())
