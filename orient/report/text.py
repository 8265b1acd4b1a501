"""Plain text for people: terminal-safe strings, and tables by rich that survive without colour and Unicode."""

import re
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from orient.values import Scalar

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2066-\u2069\ufeff]")
MISSING = "-"
NARROWEST = 60
PIPE_WIDTH = 10_000
"""Width when the output goes to a file or another program: rows are never folded there."""


def printable(text: str) -> str:
    """Text without control codes: a name in a stranger's file must not steer the terminal."""
    safe = CONTROL.sub(lambda match: match.group().encode("unicode_escape").decode("ascii"), text)
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    return safe.encode(encoding, "backslashreplace").decode(encoding)


def one_line(text: str) -> str:
    return printable(text.replace("\n", "\\n").replace("\t", " "))


def cell(value: Scalar, decimals: int | None = None) -> str:
    """A value for a table; without `decimals` a number is shown with eight significant digits."""
    if value is None:
        return MISSING
    if isinstance(value, float):
        return f"{value:.8g}" if decimals is None else f"{value:.{decimals}f}"
    return one_line(str(value))


def console() -> "Console":
    """Standard output: as wide as the terminal, or unfolded into a file; markup in names is never interpreted."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else PIPE_WIDTH
    out = Console(width=width, highlight=False, markup=False, emoji=False)
    if out.width < NARROWEST:  # a terminal that does not know its width says 0
        out.width = NARROWEST
    return out


def table(headers: Sequence[str], rows: Sequence[Sequence[str]], numeric: Sequence[bool]) -> "Table":
    """A table with numbers to the right."""
    from rich import box
    from rich.table import Table

    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for header, is_number in zip(headers, numeric, strict=True):
        shown.add_column(header, justify="right" if is_number else "left", overflow="fold")
    for row in rows:
        shown.add_row(*row)
    return shown


def answer_table(columns: Sequence[str], rows: Sequence[Sequence[Scalar]]) -> "Table":
    """The answer of an SQL question."""
    numeric = [any(isinstance(row[i], int | float) for row in rows) for i in range(len(columns))]
    cells = [[cell(value) for value in row] for row in rows]
    return table([one_line(column) for column in columns], cells, numeric)
