"""A batch from its list to its summary: what is done already is left out, the rest is chunked, every ending kept."""

import socket
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from orient.batch.cluster import Pool
from orient.batch.photo_task import file_stamp
from orient.batch.summary import Done, Summary, settings_text, stored_path
from orient.batch.values import Ending, Item, Order
from orient.batch.work_list import WorkList
from orient.batch.worker import version
from orient.pipeline.runner import current_user

LARGEST_CHUNK = 8
CHUNKS_PER_WORKER = 8
"""Small enough that a killed worker costs little and all end at about the same time, large beside 2 ms per task."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What is to be done, and what an earlier batch has done or refused and is as it was."""

    to_do: tuple[Item, ...]
    done: dict[str, Done]
    refused: dict[str, Done]


def planned(work: WorkList, before: dict[str, Done], settings: str, retry_failed: bool) -> Plan:
    """A photo is done if its file is as the last batch left it, with these settings and this version.

    What the data or the geometry refused (exit code 1) is refused again unless `retry_failed`; what failed by the
    surroundings (locked, unreadable, lost) is always tried again.
    """
    done, refused, to_do = {}, {}, []
    for item in work.items:
        last = before.get(stored_path(item.path))
        if last is None or not _is_as_it_was(item, last, settings):
            to_do.append(item)
        elif last.exit_code == 0:
            done[item.path] = last
        elif last.exit_code == 1 and not retry_failed:
            refused[item.path] = last
        else:
            to_do.append(item)
    return Plan(tuple(to_do), done, refused)


def _is_as_it_was(item: Item, last: Done, settings: str) -> bool:
    now = file_stamp(item.path)
    return now != "" and (now, settings, version()) == (last.file_stamp, last.settings, last.tool_version)


def run_batch(
    work: WorkList,
    plan: Plan,
    order: Order,
    summary: Summary,
    pool: Pool,
    tell: Callable[[Ending], None],
    tell_kept: Callable[[int], None] = lambda kept: None,
) -> int:
    """Work through what is to be done; the number of the batch. Whatever stops it, what has ended is kept.

    `tell` hears each ending; `tell_kept` at the end how many are in the summary: a stop may come in between.
    """
    batch_id = summary.begin(_facts(work, plan, order, pool))
    state = "stopped"
    try:
        for endings in pool.work(chunks(plan.to_do, pool.size), order):
            summary.store(batch_id, endings)
            for ending in endings:
                tell(ending)
        state = "finished"
    finally:
        tell_kept(summary.end(batch_id, state))
    return batch_id


def chunks(items: Sequence[Item], workers: int) -> list[Sequence[Item]]:
    """At most `LARGEST_CHUNK` photos each, and enough of them that all workers end at about the same time."""
    size = min(LARGEST_CHUNK, max(1, len(items) // (workers * CHUNKS_PER_WORKER)))
    return [items[start : start + size] for start in range(0, len(items), size)]


def _facts(work: WorkList, plan: Plan, order: Order, pool: Pool) -> dict[str, str | int]:
    return {
        "actor": current_user(),
        "host": socket.gethostname(),
        "workers": pool.name,
        "reason": order.reason,
        "settings": settings_text(order.settings),
        "tool_version": version(),
        "n_photos": len(work.items),
        "n_done_before": len(plan.done) + len(plan.refused),
    }
