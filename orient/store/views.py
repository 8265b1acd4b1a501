"""What views.sql says about its views, for docs/schema.md and the ready-made questions."""

import re
from dataclasses import dataclass

from orient.store.guards import VIEWS_FILE

VIEW_LINE = re.compile(r"-- (v_\w+): (.+)")
COLUMN_LINE = re.compile(r"--   (\w+): (.+)")


@dataclass(frozen=True, slots=True)
class ViewText:
    """A view: the question it answers and the meaning of its columns, in order."""

    name: str
    question: str
    columns: dict[str, str]


def view_texts() -> list[ViewText]:
    """All views in the order of views.sql."""
    views: list[ViewText] = []
    for line in VIEWS_FILE.read_text(encoding="utf-8").splitlines():
        if match := VIEW_LINE.fullmatch(line):
            views.append(ViewText(match[1], match[2], {}))
        elif match := COLUMN_LINE.fullmatch(line):
            views[-1].columns[match[1]] = match[2]
    return views
