"""Consoles of rich: one that folds sentences between words, one for files and other programs that folds nothing."""

import sys
import textwrap
from typing import TYPE_CHECKING, Any

from rich.console import Console

if TYPE_CHECKING:
    from rich.progress import Progress, ProgressColumn, SpinnerColumn

UNKNOWN_WIDTH, USUAL_WIDTH = 20, 80
"""A terminal that does not know its width says 0 or 1."""
HANGING = "  "


class PlainConsole(Console):
    """Nothing in a text is taken for markup; `width` columns, the terminal's own if None."""

    def __init__(self, width: int | None) -> None:
        super().__init__(width=width, highlight=False, markup=False, emoji=False)


class FoldedConsole(PlainConsole):
    """A sentence goes on in the next line, indented, instead of being broken where the terminal ends."""

    def __init__(self) -> None:
        super().__init__(None)
        if self.width < UNKNOWN_WIDTH:
            self.width = USUAL_WIDTH

    def print(self, *objects: Any, **options: Any) -> None:
        if len(objects) == 1 and isinstance(objects[0], str):
            objects = ("\n".join(folded(line, self.width) for line in objects[0].split("\n")),)
            options["soft_wrap"] = True
        super().print(*objects, **options)


def folded(line: str, width: int) -> str:
    """The line in pieces of at most `width` letters; a word that is longer stays whole, so that it can be copied."""
    if len(line) <= width:
        return line
    indent = line[: len(line) - len(line.lstrip(" "))]
    return textwrap.fill(
        line,
        width,
        subsequent_indent=indent + HANGING,
        break_long_words=False,
        break_on_hyphens=False,
        replace_whitespace=False,
    )


def moving_line(out: Console, *columns: "ProgressColumn", is_quiet: bool = False) -> "Progress":
    """Columns, what is going on, the time: a line that moves on a terminal and is gone at the end; else nothing."""
    from rich.progress import Progress, TextColumn, TimeElapsedColumn
    from rich.table import Column

    is_shown = sys.stdout is not None and sys.stdout.isatty() and not is_quiet
    # cropped, not shortened by an ellipsis, which ASCII does not have
    what = TextColumn("{task.description}", table_column=Column(no_wrap=True, overflow="crop"))
    return Progress(*columns, what, TimeElapsedColumn(), console=out, transient=True, disable=not is_shown)


def spinner(out: Console) -> "SpinnerColumn":
    """A small sign of life, in ASCII where the terminal knows no more."""
    from rich.progress import SpinnerColumn

    return SpinnerColumn("dots" if out.encoding.startswith("utf") else "line")
