"""What travels between the floors: rows, events, outcomes. Imports nothing of orient."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, Self

Scalar = str | int | float | None
Row = Mapping[str, Scalar]
"""One row of a project table, keyed by column name, without `run_id`."""
Tables = Mapping[str, Sequence[Row]]
"""The rows of one run, keyed by table name."""
Settings = Mapping[str, str | int | float | bool | None]

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
