"""`orient batch` from what was asked to the exit code."""

import sys
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from orient.batch.cluster import Pool, in_process, local_workers, usual_workers, workers_of
from orient.batch.coordinator import Plan, planned, run_batch
from orient.batch.summary import Done, Summary, open_summary, settings_text
from orient.batch.telling import Tally, report, show_plan, stopped_line
from orient.batch.values import Order
from orient.batch.work_list import STANDARD_INPUT, WorkList, work_list
from orient.store.summary_engine import SummaryPlace, summary_place

SUMMARY_NAME = "orient-summary.db"


@dataclass(frozen=True, slots=True)
class Wish:
    """What the user asked for. `workers` 0: in this process; None: one per processor."""

    places: tuple[str, ...]
    order: Order
    pattern: str = "*.sqlite"
    is_recursive: bool = False
    source: str = ""
    summary: str = ""
    workers: int | None = None
    memory_mib: int | None = None
    scheduler: str = ""
    retry_failed: bool = False


def carry_out(wish: Wish, dry_run: bool, as_json: bool) -> int:
    """Do it, or only say what would be done; the exit code."""
    work = work_list(wish.places, wish.pattern, wish.is_recursive, wish.source)
    place = summary_place(wish.summary or _usual_summary(wish.places[0]))
    settings = settings_text(wish.order.settings)
    if dry_run:
        show_plan(work, planned(work, _known(place), settings, wish.retry_failed), as_json)
        return 0
    if wish.source:
        Path(wish.places[0]).mkdir(exist_ok=True)
    summary = open_summary(place)
    try:
        plan = planned(work, summary.done(), settings, wish.retry_failed)
        with Tally(len(plan.to_do), is_quiet=as_json) as tally:
            batch_id = _work(wish, work, plan, summary, tally) if plan.to_do else None
    finally:
        summary.close()
    return report(batch_id, work, plan, tally, place.shown, as_json)


def _usual_summary(place: str) -> str:
    """Beside the projects: in their folder, in the folder of the list, here for standard input."""
    if place == STANDARD_INPUT:
        return SUMMARY_NAME
    path = Path(place)
    return str((path.parent if path.is_file() else path) / SUMMARY_NAME)


def _known(place: SummaryPlace) -> dict[str, Done]:
    """What an existing summary knows; a dry run makes none."""
    if not place.exists:
        return {}
    summary = open_summary(place, make=False)
    try:
        return summary.done() if summary.has_tables() else {}
    finally:
        summary.close()


def _work(wish: Wish, work: WorkList, plan: Plan, summary: Summary, tally: Tally) -> int:
    kept: list[int] = []
    with _pool(wish) as pool:
        try:
            return run_batch(work, plan, wish.order, summary, pool, tally.tell, kept.append)
        except BaseException:
            ended = kept[0] if kept else len(tally.ended)
            print(stopped_line(ended, len(plan.to_do), summary.shown), file=sys.stderr)
            raise


def _pool(wish: Wish) -> AbstractContextManager[Pool]:
    if wish.scheduler:
        return workers_of(wish.scheduler)
    if wish.workers == 0:
        return nullcontext(in_process())
    return local_workers(wish.workers or usual_workers(), wish.memory_mib)
