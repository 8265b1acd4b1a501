"""Stored rows against recomputed rows, value by value: every bit, or 1e-9 of the scale of the number."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from orient.pipeline.verify_scale import Scales
from orient.store.format import current_format
from orient.values import Row, Scalar, Tables

TOLERANCE = 1e-9
LONGEST_TEXT = 200
WORDS_OF_SOFTWARE = {"message", "summary", "error", "proj_version"}
"""Texts with rounded numbers or versions in them: compared only where every bit is."""
PATH = "iteration"
"""In names of tables and columns that tell the way to the solution: of two equally good starts, rounding picks one."""
ABSENT = "no such row"
LARGEST = 1e15


@dataclass(frozen=True, slots=True)
class Difference:
    """Two values that are not the same; `size` relative to their scale, None if they are not two numbers."""

    place: str
    stored: str
    recomputed: str
    size: float | None = None

    @property
    def rank(self) -> float:
        return LARGEST if self.size is None else self.size


@dataclass(slots=True)
class Comparison:
    """What was compared; `refused` differences are more than is allowed, `accepted` is the largest of the others."""

    n_values: int = 0
    n_identical: int = 0
    refused: list[Difference] = field(default_factory=list)
    accepted: Difference | None = None

    @property
    def largest(self) -> Difference | None:
        return max(self.refused, key=lambda difference: difference.rank) if self.refused else self.accepted

    def add(self, difference: Difference, is_allowed: bool) -> None:
        if not is_allowed:
            self.refused.append(difference)
        elif self.accepted is None or difference.rank > self.accepted.rank:
            self.accepted = difference


@dataclass(frozen=True)
class _Table:
    """One table on both sides; `exact`: bits decide; `is_older`: columns empty as stored did not exist then."""

    name: str
    stored: Sequence[Row]
    again: Sequence[Row]
    exact: bool
    is_older: bool

    @cached_property
    def scales(self) -> Scales:
        return Scales(self.again)

    @cached_property
    def key(self) -> tuple[str, ...]:
        return tuple(name for name in current_format().tables[self.name].key if name != "run_id")

    @cached_property
    def columns(self) -> list[str]:
        names = list(self.again[0] if self.again else self.stored[0])
        if not self.exact:
            names = [name for name in names if name not in WORDS_OF_SOFTWARE and PATH not in name]
        if self.is_older:
            names = [name for name in names if any(row[name] is not None for row in self.stored)]
        return [name for name in names if name not in self.key]

    def place(self, row: Row, column: str) -> str:
        key = " ".join(f"{name}={row[name]}" for name in self.key)
        return f"{self.name} {key}: {column}" if key else f"{self.name}: {column}"

    def compare(self, found: Comparison) -> None:
        stored = {tuple(row[name] for name in self.key): row for row in self.stored}
        again = {tuple(row[name] for name in self.key): row for row in self.again}
        for key, row in stored.items():
            if key in again:
                self._compare_row(row, again[key], found)
            else:
                found.add(Difference(self.place(row, "row"), "a row", ABSENT), is_allowed=False)
        for key, row in again.items():
            if key not in stored:
                found.add(Difference(self.place(row, "row"), ABSENT, "a row"), is_allowed=False)

    def _compare_row(self, stored: Row, again: Row, found: Comparison) -> None:
        found.n_values += len(self.columns)
        for column in self.columns:
            if same_bits(stored[column], again[column]):
                found.n_identical += 1
                continue
            size = self._size(stored[column], again[column], again, column)
            difference = Difference(self.place(again, column), _text(stored[column]), _text(again[column]), size)
            found.add(difference, is_allowed=not self.exact and size is not None and size <= TOLERANCE)

    def _size(self, stored: Scalar, again: Scalar, row: Row, column: str) -> float | None:
        if not (isinstance(stored, float) and isinstance(again, float)):
            return None
        scale = max(abs(stored), abs(again), self.scales.of(row, column))
        return min(abs(stored - again) / scale, LARGEST) if scale else 0.0


def compare(stored: Tables, again: Tables, *, exact: bool, is_older: bool = False) -> Comparison:
    """Every value of a run; `again` has the columns of the current format.

    `exact`: two values are the same if all their bits are. Else a number may differ by 1e-9 of its scale
    (`verify_scale`), and sentences and iterations are left out. `is_older`: the run comes from an older version of its
    stage; tables and columns that it could not know are left out too.
    """
    found = Comparison()
    for name in sorted({*stored, *again}):
        mine, other = stored.get(name, ()), again.get(name, ())
        if (mine or other) and (mine or not is_older) and (exact or PATH not in name):
            _Table(name, mine, other, exact, is_older).compare(found)
    return found


def same_bits(one: Scalar, other: Scalar) -> bool:
    """Floats through `float.hex`, so that -0.0 is not 0.0; anything else by type and value."""
    if isinstance(one, float) and isinstance(other, float):
        return one.hex() == other.hex()
    return type(one) is type(other) and one == other


def _text(value: Scalar) -> str:
    return repr(value)[:LONGEST_TEXT] if value is not None else "NULL"


def seal_row(status: str, summary: str, error: str) -> Mapping[str, Sequence[Row]]:
    """What the seal says of a result, as a table to compare."""
    return {"run_seal": [{"status": status, "summary": summary, "error": error}]}
