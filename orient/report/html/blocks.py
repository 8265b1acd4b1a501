"""What a report is made of: sections of paragraphs, tables, figures and notices. Nothing here knows HTML."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

FIRST_COLUMN = frozenset({0})


@dataclass(frozen=True, slots=True)
class Paragraph:
    """`look`: plain | note | heading."""

    kind: ClassVar[str] = "paragraph"
    text: str
    look: str = "plain"


@dataclass(frozen=True, slots=True)
class Table:
    """Cells as text; `words` are the columns of words, which stand to the left, all others are numbers."""

    kind: ClassVar[str] = "table"
    title: str
    headers: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: frozenset[int] = FIRST_COLUMN
    note: str = ""


@dataclass(frozen=True, slots=True)
class Facts:
    """Names and values, one below the other."""

    kind: ClassVar[str] = "facts"
    title: str
    pairs: Sequence[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Figure:
    """A picture as an SVG element that may stand in a page."""

    kind: ClassVar[str] = "figure"
    title: str
    svg: str
    note: str = ""


@dataclass(frozen=True, slots=True)
class Notice:
    """A finding: its kind in words, the sentence that is recorded, and what to do."""

    kind: ClassVar[str] = "notice"
    severity: str
    title: str
    recorded: str
    remedy: str = ""


Block = Paragraph | Table | Facts | Figure | Notice


@dataclass(frozen=True, slots=True)
class Section:
    """`key` is the place in the page that the list of contents points at."""

    key: str
    title: str
    blocks: Sequence[Block] = field(default_factory=tuple)
