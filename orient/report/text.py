"""Plain text for people: terminal-safe strings, and tables by rich that survive without colour and Unicode."""

import json
import re
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from orient.values import Scalar

if TYPE_CHECKING:
    from rich.console import Console

CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2066-\u2069\ufeff]")
MISSING = "-"
GAP, NARROWEST_TEXT = 3, 24
"""Between two columns: a blank on each side of the invisible rule."""
PIPE_WIDTH = 10_000
"""Width when the output goes to a file or another program: rows are never folded there."""


def printable(text: str) -> str:
    """Text without control codes: a name in a stranger's file must not steer the terminal."""
    safe = CONTROL.sub(lambda match: match.group().encode("unicode_escape").decode("ascii"), text)
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    return safe.encode(encoding, "backslashreplace").decode(encoding)


def one_line(text: str) -> str:
    return printable(text.replace("\n", "\\n").replace("\t", " "))


def cell(value: Scalar | bytes, decimals: int | None = None) -> str:
    """A value for a table, bytes by their number; without `decimals` a number is shown with ten significant digits."""
    if value is None:
        return MISSING
    if isinstance(value, bytes):
        return f"{len(value)} bytes"
    if isinstance(value, float):
        return f"{value:.10g}" if decimals is None else f"{value:.{decimals}f}"
    return one_line(str(value))


def number(value: object) -> float:
    """A column that must hold a number."""
    if not isinstance(value, int | float):
        raise TypeError(f"a number was expected, not {value!r}")
    return float(value)


def print_json(content: object) -> None:
    """For programs: with all digits; docs/json.md lists the keys."""
    print(json.dumps(content, indent=2, allow_nan=False))


def console() -> "Console":
    """Standard output: folded at words to the width of the terminal, unfolded into a file; no markup in names."""
    from orient.report.terminal import FoldedConsole, PlainConsole

    if sys.stdout is not None and sys.stdout.isatty():
        return FoldedConsole()
    return PlainConsole(PIPE_WIDTH)


def print_table(headers: Sequence[str], rows: Sequence[Sequence[str]], numeric: Sequence[bool]) -> None:
    """A table with numbers to the right; what is too wide for the terminal comes as one record below the other.

    The last column may be folded if it is text; a number or a name is never broken.
    """
    from rich import box
    from rich.table import Table

    out = console()
    widths = [max(len(row[i]) for row in [headers, *rows]) for i in range(len(headers))]
    gaps = GAP * (len(headers) - 1)
    may_fold = not numeric[-1] and out.width - sum(widths[:-1]) - gaps >= NARROWEST_TEXT
    if sum(widths) + gaps > out.width and not may_fold:
        _print_records(out, headers, rows)
        return
    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for i, (header, is_number) in enumerate(zip(headers, numeric, strict=True)):
        justify: Literal["right", "left"] = "right" if is_number else "left"
        shown.add_column(header, justify=justify, overflow="fold", no_wrap=i < len(headers) - 1)
    for row in rows:
        shown.add_row(*row)
    out.print(shown)


def _print_records(out: "Console", headers: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    width = max(len(header) for header in headers)
    for number, row in enumerate(rows, 1):
        out.print(f"-- {number}")
        for header, value in zip(headers, row, strict=True):
            out.print(f"{header:<{width}}  {value}", soft_wrap=True)


def print_answer(columns: Sequence[str], rows: Sequence[Sequence[Scalar]]) -> None:
    """The answer of an SQL question."""
    numeric = [any(isinstance(row[i], int | float) for row in rows) for i in range(len(columns))]
    cells = [[cell(value) for value in row] for row in rows]
    print_table([one_line(column) for column in columns], cells, numeric)
