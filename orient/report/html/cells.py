"""Values as the text of a report: the same on every machine, whatever its terminal can show."""

import math
from collections.abc import Iterable, Sequence

from orient.report.language import tr
from orient.report.text import CONTROL, number
from orient.units import DEGREES_PER_RADIAN

MISSING = "–"
MICROMETRES = 1000.0
MINUTE = len("2026-01-01T00:00")
LONGEST = 400
ROUNDED = 6
"""Up to so many digits a number keeps its last zeros: they are known."""


def name(value: object) -> str:
    """A text of the file in one line, without control codes."""
    if value is None:
        return MISSING
    safe = CONTROL.sub(lambda match: match.group().encode("unicode_escape").decode("ascii"), str(value))
    line = safe.replace("\n", "\\n").replace("\t", " ")
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"


def fixed(value: object, decimals: int) -> str:
    """A number with fixed decimals; a dash for what is not known."""
    return MISSING if value is None else f"{number(value):.{decimals}f}"


def digits(value: object, count: int = 4) -> str:
    """A number with `count` significant digits; exponents only where they are needed."""
    if value is None or not math.isfinite(number(value)):
        return MISSING
    size = abs(number(value))
    if size == 0 or count > ROUNDED:
        return f"{number(value):.{count}g}"
    if 10**count <= size < 1e9:
        return f"{number(value):.0f}"
    return f"{number(value):#.{count}g}".rstrip(".")


def scientific(value: float) -> str:
    return f"{value:.4e}"


def micrometres(value: object, decimals: int = 2) -> str:
    return MISSING if value is None else f"{MICROMETRES * number(value):.{decimals}f}"


def in_full(value: object) -> str:
    """A value with all its digits, as it is stored."""
    return repr(value) if isinstance(value, float) else name(value)


def degrees(radians: float) -> float:
    return radians * DEGREES_PER_RADIAN


def moment(text: str) -> str:
    """A stored time to the minute."""
    return f"{text[:MINUTE].replace('T', ' ')} UTC"


def rms(values: Iterable[float]) -> float | None:
    """sqrt(sum v^2 / n): the divisor is the number of values; None of none."""
    squares = [value * value for value in values]
    return math.sqrt(math.fsum(squares) / len(squares)) if squares else None


def worst_of(shown: int, total: int) -> str:
    """What a table says of itself when it does not show everything; empty if it does."""
    return "" if shown >= total else tr("The {shown} largest of {total} are shown.", shown=shown, total=total)


def first_of(shown: int, total: int) -> str:
    return "" if shown >= total else tr("The first {shown} of {total} are shown.", shown=shown, total=total)


def joined(parts: Sequence[str]) -> str:
    return " ".join(part for part in parts if part)
