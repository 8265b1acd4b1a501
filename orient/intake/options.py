"""How input files are to be read."""

from dataclasses import dataclass
from typing import Literal

MAX_ROWS = 1_000_000


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """What the user said about the form of the files; every default is the documented format (docs/input.md)."""

    decimal: Literal["point", "comma"] = "point"
    encoding: str = "utf-8"
    ignore_columns: bool = False
    max_rows: int = MAX_ROWS
