"""What a batch says: a moving line on a terminal, nothing elsewhere, and at the end the counts and what failed."""

import json
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from orient.batch.coordinator import Plan
from orient.batch.values import Ending, Item
from orient.batch.work_list import WorkList
from orient.report.text import console, one_line, print_json, printable

SHOWN = 20
VERDICTS = ("good", "doubtful", "stale")


class Tally:
    """Counts the endings as they come, and shows how far the batch is."""

    def __init__(self, total: int, is_quiet: bool = False) -> None:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        hidden = is_quiet or not sys.stdout.isatty()
        self._bar = Progress(*columns, console=console(), transient=True, disable=hidden)
        self._task = self._bar.add_task("photos", total=total)
        self.ended: dict[str, Ending] = {}

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: Any) -> None:
        self._bar.stop()

    def tell(self, ending: Ending) -> None:
        self.ended[ending.path] = ending
        failed = len(self.failed)
        self._bar.update(self._task, advance=1, description=f"photos, {failed} failed" if failed else "photos")

    @property
    def failed(self) -> list[Ending]:
        return [ending for ending in self.ended.values() if ending.is_failed]


def stopped_line(kept: int, total: int, shown: str) -> str:
    return f"stopped: {kept} of {total} photos have ended and are kept in {printable(shown)}; go on later"


def report(batch_id: int | None, work: WorkList, plan: Plan, tally: Tally, shown: str, as_json: bool) -> int:
    """The last words; the exit code: 1 if a photo has no result."""
    failures = [*_refused_before(plan), *tally.failed]
    counts = _counts(plan, tally)
    if as_json:
        print_json(_content(batch_id, work, counts, failures, shown))
    else:
        _print(batch_id, work, counts, failures, shown)
    return int(bool(failures))


def show_plan(work: WorkList, plan: Plan, as_json: bool) -> None:
    """`--dry-run`: what would be done with each photo, and why not."""
    states = [(item, *_state(item, plan)) for item in work.items]
    if as_json:
        rows = [{"path": item.path, "state": state, "why": why} for item, state, why in states]
        print(json.dumps(rows, indent=2))
        return
    out = console()
    for item, state, why in states:
        out.print(f"{state:<8} {_near(item.path)}{': ' if why else ''}{one_line(why)}", soft_wrap=True)
    out.print(f"{len(work.items)} photos, {len(plan.to_do)} to do; nothing was done (--dry-run).")


def _state(item: Item, plan: Plan) -> tuple[str, str]:
    if last := plan.done.get(item.path):
        return "done", f"batch {last.batch_id}, unchanged since"
    if last := plan.refused.get(item.path):
        return "refused", f"batch {last.batch_id}: {last.refusal.message} (again with --retry-failed)"
    return "to do", f"made from {item.source}" if item.source and not Path(item.path).exists() else ""


def _near(path: str) -> str:
    """The path as a user here would type it."""
    here = Path.cwd()
    return printable(str(Path(path).relative_to(here)) if Path(path).is_relative_to(here) else path)


def _refused_before(plan: Plan) -> list[Ending]:
    return [
        Ending(path, last.exit_code, last.refusal.message, last.refusal.hint) for path, last in plan.refused.items()
    ]


def _counts(plan: Plan, tally: Tally) -> dict[str, int]:
    """All but "computed" add up to the number of photos."""
    verdicts = Counter(str(ending.numbers.get("verdict")) for ending in tally.ended.values() if not ending.is_failed)
    computed = sum(bool(ending.numbers.get("n_computed")) for ending in tally.ended.values())
    return {
        **{verdict: verdicts[verdict] for verdict in VERDICTS},
        "failed": len(tally.failed),
        "computed": computed,
        "done_before": len(plan.done),
        "refused_before": len(plan.refused),
    }


def _content(
    batch_id: int | None, work: WorkList, counts: dict[str, int], failures: Sequence[Ending], shown: str
) -> dict[str, object]:
    told = [
        {"path": ending.path, "exit_code": ending.exit_code, "error": ending.message, "hint": ending.hint}
        for ending in failures
    ]
    return {"summary": shown, "batch": batch_id, "photos": len(work.items), **counts, "failures": told}


def _print(
    batch_id: int | None, work: WorkList, counts: dict[str, int], failures: Sequence[Ending], shown: str
) -> None:
    out = console()
    name = "Nothing to do" if batch_id is None else f"Batch {batch_id}"
    told = [f"{count} {word.replace('_', ' ')}" for word, count in counts.items() if count and word != "computed"]
    out.print(f"{name}: {len(work.items)} photos: {', '.join(told)}.")
    if work.repeated:
        out.print(f"note: {work.repeated} names stood for a file that was on the list already")
    for ending in failures[:SHOWN]:
        why = f"{one_line(ending.message)} (exit code {ending.exit_code})"
        out.print(f"  {_near(ending.path)}: {why}", soft_wrap=True)
        if ending.hint:
            out.print(f"    -> {one_line(ending.hint)}", soft_wrap=True)
    if len(failures) > SHOWN:
        out.print(f"  ... and {len(failures) - SHOWN} more")
    out.print(f"Summary: {printable(shown)}", soft_wrap=True)
