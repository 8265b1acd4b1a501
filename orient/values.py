"""What travels between the floors: rows, events, outcomes. Imports nothing of orient."""

import hashlib
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Self, overload

Scalar = str | int | float | None
Row = Mapping[str, Scalar]
"""One row of a project table, keyed by column name, without `run_id`."""
Tables = Mapping[str, Sequence[Row]]
"""The rows of one run, keyed by table name."""
Settings = Mapping[str, str | int | float | bool | None]


class Columns(Sequence[Row]):
    """Rows of a large table, kept by column: a list or an array of floats for each name, all of one length.

    A masked array stands for floats of which some are not known. To a reader it is a sequence of rows like any other;
    the store takes the columns as they are.
    """

    __slots__ = ("by_name",)

    def __init__(self, by_name: Mapping[str, Any]) -> None:
        self.by_name = by_name
        if len({len(values) for values in by_name.values()}) > 1:
            raise ValueError("columns of one table have different lengths")

    def __len__(self) -> int:
        return len(next(iter(self.by_name.values()), ()))

    @overload
    def __getitem__(self, place: int) -> Row: ...
    @overload
    def __getitem__(self, place: slice) -> "Columns": ...
    def __getitem__(self, place: int | slice) -> "Row | Columns":
        if isinstance(place, slice):
            return Columns({name: values[place] for name, values in self.by_name.items()})
        place = range(len(self))[place]
        return {name: as_list(values[place : place + 1])[0] for name, values in self.by_name.items()}

    def at(self, places: Sequence[int]) -> "Columns":
        """The rows at these places."""
        return Columns({name: _at(values, places) for name, values in self.by_name.items()})

    def __iter__(self) -> Iterator[Row]:
        plain = [as_list(values) for values in self.by_name.values()]
        return (dict(zip(self.by_name, row, strict=True)) for row in zip(*plain, strict=True))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and list(self) == list(other)

    __hash__ = None  # type: ignore[assignment]


def _at(values: Any, places: Sequence[int]) -> Any:
    if hasattr(values, "dtype"):
        return values[places]
    some = [values[place] for place in places]
    return array(values.typecode, some) if isinstance(values, array) else some


def as_list(values: Any) -> Sequence[Scalar]:
    """A column as Python numbers and words, whether it is an array or a list."""
    return values.tolist() if hasattr(values, "tolist") else values  # type: ignore[no-any-return]


Severity = Literal["info", "warning", "error"]


class Blob(str):
    """Bytes of a row, told by their number and SHA-256: "5 bytes, sha256 2cf24d...". Digests go over this text.

    `read` fetches the bytes when the row is stored, so that an image need not fit into memory; None for a stored row.
    """

    __slots__ = ("read",)
    read: Callable[[], bytes] | None

    def __new__(cls, content: bytes, read: Callable[[], bytes] | None = None) -> Self:
        blob = super().__new__(cls, f"{len(content)} bytes, sha256 {hashlib.sha256(content).hexdigest()}")
        blob.read = read
        return blob


@dataclass(frozen=True, slots=True)
class Event:
    """A remark, warning or error of a run (the seed's table `er`).

    `code` is a stable word for programs (`cycle_outlier`), `subject` the point, sheet or unknown that is meant,
    `value` a number that belongs to the message (or None).
    """

    severity: Severity
    code: str
    subject: str
    message: str
    value: float | None = None


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a stage hands to the runner: rows to store, events, one line for people.

    `error` is empty for a result; otherwise it is the sentence that says why there is none. A failed outcome is
    stored too, with its iterations and events, but no head moves to it.
    """

    tables: Tables
    events: Sequence[Event] = ()
    summary: str = ""
    error: str = ""
    hint: str = ""


@dataclass(frozen=True, slots=True)
class InputTables:
    """One version of one input stage, read from files and found good."""

    stage: str
    tables: Tables
    events: Sequence[Event] = ()
    files: Sequence[str] = field(default=())
