"""The summary of batches: made, asked what is done, given what has ended. One writer, one transaction per chunk."""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from sqlalchemy import Connection, Engine, Table, delete, func, insert, inspect, select, text, update
from sqlalchemy.exc import SQLAlchemyError

from orient.batch.tables import BATCH, COVARIANCE, FINDING, FORMAT, LATEST, METADATA, PHOTO, STAGE, SUMMARY_VERSION
from orient.batch.values import Ending, Refusal
from orient.errors import ProjectError
from orient.store.ledger import now
from orient.store.summary_engine import SummaryPlace, summary_engine
from orient.values import Scalar

CHILDREN = (COVARIANCE, STAGE, FINDING)
NO_CODE = "\0"


@dataclass(frozen=True, slots=True)
class Done:
    """What the last batch has left of a photo."""

    batch_id: int
    exit_code: int
    refusal: Refusal
    file_stamp: str
    settings: str
    tool_version: str


class Summary:
    """An open summary. Every method is one transaction; errors of the database leave as `ProjectError`."""

    def __init__(self, engine: Engine, shown: str) -> None:
        self.shown = shown
        self._engine = engine

    def close(self) -> None:
        self._engine.dispose()

    def has_tables(self) -> bool:
        with self._transaction() as connection:
            return bool(inspect(connection).has_table(FORMAT.name))

    def prepare(self) -> None:
        """Make the tables if there are none; a format that this version does not know is refused."""
        with self._transaction() as connection:
            if not inspect(connection).has_table(FORMAT.name):
                METADATA.create_all(connection)
                connection.execute(text(LATEST))
                connection.execute(insert(FORMAT).values(version=SUMMARY_VERSION))
            version = connection.execute(select(FORMAT.c.version)).scalar()
        if version != SUMMARY_VERSION:
            known = f"format {version}, this one knows {SUMMARY_VERSION}"
            raise ProjectError(f"{self.shown} was written by another version of orient ({known}).", "Give another.")

    def done(self) -> dict[str, Done]:
        """The last ending of every photo, by path."""
        last = select(PHOTO.c.path_digest, func.max(PHOTO.c.batch_id).label("batch_id")).group_by(PHOTO.c.path_digest)
        newest = last.subquery()
        is_newest = (PHOTO.c.path_digest == newest.c.path_digest) & (PHOTO.c.batch_id == newest.c.batch_id)
        query = select(
            PHOTO.c.path, PHOTO.c.batch_id, PHOTO.c.exit_code, PHOTO.c.error, PHOTO.c.hint, PHOTO.c.file_stamp,
            BATCH.c.settings, BATCH.c.tool_version,
        ).join(newest, is_newest).join(BATCH, BATCH.c.batch_id == PHOTO.c.batch_id)  # fmt: skip
        with self._transaction() as connection:
            return {row[0]: _done(*row[1:]) for row in connection.execute(query)}

    def begin(self, facts: Mapping[str, Scalar]) -> int:
        """A new batch; its number."""
        with self._transaction() as connection:
            row = {"state": "running", "started_at": now(), "ended_at": None, **facts}
            return int(connection.execute(insert(BATCH).values(row)).inserted_primary_key[0])  # type: ignore[index]

    def store(self, batch_id: int, endings: Sequence[Ending]) -> None:
        """The endings of one chunk, all or none. A photo that ended before in this batch is replaced."""
        with self._transaction() as connection:
            _forget(connection, batch_id, [path_digest(ending.path) for ending in endings])
            keys = [_insert_photo(connection, batch_id, ending) for ending in endings]
            for table, field in ((COVARIANCE, "covariances"), (STAGE, "stages"), (FINDING, "findings")):
                _insert_children(connection, table, keys, [getattr(ending, field) for ending in endings])

    def end(self, batch_id: int, state: str) -> int:
        """Close the batch; how many photos ended in it."""
        counted = select(func.count()).select_from(PHOTO).where(PHOTO.c.batch_id == batch_id)
        with self._transaction() as connection:
            connection.execute(update(BATCH).where(BATCH.c.batch_id == batch_id).values(state=state, ended_at=now()))
            return int(connection.execute(counted).scalar_one())

    @contextmanager
    def _transaction(self) -> Iterator[Connection]:
        try:
            with self._engine.begin() as connection:
                yield connection
        except SQLAlchemyError as error:
            said = str(getattr(error, "orig", None) or error).strip().partition("\n")[0]
            hint = "What is done stays done: give the same command again when the database answers."
            raise ProjectError(f"the summary {self.shown} cannot be used: {said}", hint) from error


def open_summary(place: SummaryPlace, make: bool = True) -> Summary:
    """The summary at this place; `make`: with its tables, made if there are none."""
    summary = Summary(summary_engine(place), place.shown)
    try:
        if make:
            summary.prepare()
    except BaseException:
        summary.close()
        raise
    return summary


def path_digest(path: str) -> str:
    return hashlib.sha256(os.fsencode(path)).hexdigest()


def stored_path(path: str) -> str:
    """The path as text: bytes that are no text are written as \\xNN."""
    return os.fsencode(path).decode("utf-8", "backslashreplace")


def settings_text(settings: Mapping[str, object]) -> str:
    return json.dumps(dict(settings), sort_keys=True)


def _done(batch_id: int, exit_code: int, error: str, hint: str, stamp: str, settings: str, version: str) -> Done:
    return Done(batch_id, exit_code, Refusal(error, hint, exit_code), stamp or "", settings, version)


def _forget(connection: Connection, batch_id: int, digests: Sequence[str]) -> None:
    mine = (PHOTO.c.batch_id == batch_id) & PHOTO.c.path_digest.in_(digests)
    for table in CHILDREN:
        connection.execute(delete(table).where(table.c.photo_id.in_(select(PHOTO.c.photo_id).where(mine))))
    connection.execute(delete(PHOTO).where(mine))


def _insert_photo(connection: Connection, batch_id: int, ending: Ending) -> int:
    row = {
        **ending.numbers,
        "batch_id": batch_id,
        "path_digest": path_digest(ending.path),
        "path": stored_path(ending.path),
        "ended_at": now(),
        "exit_code": ending.exit_code,
        "error": ending.message,
        "hint": ending.hint,
    }
    clean = {name: _clean(value) for name, value in row.items()}
    return int(connection.execute(insert(PHOTO).values(clean)).inserted_primary_key[0])  # type: ignore[index]


def _insert_children(
    connection: Connection, table: Table, keys: Sequence[int], rows: Sequence[Sequence[Mapping[str, Scalar]]]
) -> None:
    all_rows = [
        {"photo_id": key, **{name: _clean(value) for name, value in row.items()}}
        for key, own in zip(keys, rows, strict=True)
        for row in own
    ]
    if all_rows:
        connection.execute(insert(table), all_rows)


def _clean(value: Scalar) -> Scalar:
    """Text that every database takes: no zero byte, no half of a character."""
    if isinstance(value, str):
        return value.replace(NO_CODE, "").encode("utf-8", "backslashreplace").decode("utf-8")
    return value
