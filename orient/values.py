"""What travels between the floors: rows, events, outcomes. Imports nothing of orient."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

Scalar = str | int | float | None
Row = Mapping[str, Scalar]
"""One row of a project table, keyed by column name, without `run_id`."""
Tables = Mapping[str, Sequence[Row]]
"""The rows of one run, keyed by table name."""
Settings = Mapping[str, str | int | float | bool | None]

Severity = Literal["info", "warning", "error"]


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
