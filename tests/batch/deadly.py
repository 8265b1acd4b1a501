"""The work on a chunk with a photo that kills its worker, as a crash in a library or a lack of memory does."""

import os
import signal
from collections.abc import Sequence

from orient.batch import photo_task
from orient.batch.values import Ending, Item, Order


def work_through(items: Sequence[Item], order: Order) -> list[Ending]:
    if any(item.path.endswith("P001.sqlite") for item in items):
        os.kill(os.getpid(), signal.SIGKILL)
    return photo_task.work_through(items, order)
