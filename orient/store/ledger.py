"""Appending a run: header, inputs, rows, seal, selection. The caller owns the transaction."""

import os
import platform
import sqlite3
import sys
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from itertools import chain, starmap, zip_longest
from operator import eq

from sqlalchemy import Connection

import orient
from orient.store.chain import run_record_digest, selection_record_digest
from orient.store.connection import driver_of, execute, scalar
from orient.store.digest import OWN_CONTENT, Content, content_of, input_digest, plain_json
from orient.store.errors import ChangedMeanwhile, OurFault, StorageError
from orient.store.format import Format
from orient.store.plain import require_own_tables
from orient.store.rows import StoredTable, insert_rows, stored_tables
from orient.store.runs import NewRun, RunInfo, runs_where


def now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def tool_version() -> str:
    """What can change the last bits of a number: versions, and the processor by which BLAS chooses its code."""
    parts = (
        f"orient {orient.__version__}",
        f"Python {platform.python_version()}",
        f"SQLite {sqlite3.sqlite_version}",
        *(f"{name} {_version(name)}" for name in ("numpy", "scipy", "pyproj")),
        _processor(),
    )
    return ", ".join(parts)


@cache
def _version(name: str) -> str:
    return metadata.version(name)


def _processor() -> str:
    """x86_64 AVX512_SPR: the machine, its best vector unit as numpy sees it (if loaded), the BLAS code if forced."""
    unit = _vector_unit() if "numpy" in sys.modules else ""
    return " ".join(filter(None, [platform.machine(), unit, os.environ.get("OPENBLAS_CORETYPE")]))


@cache
def _vector_unit() -> str:
    import numpy as np

    found = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    return str(found[-1]) if found else ""


def append_all(connection: Connection, new: Sequence[NewRun], form: Format) -> list[RunInfo]:
    """Store the runs, all of them expecting the heads of now."""
    for run in new:
        check_heads(connection, run.expected_heads)
    return [same_run(connection, run) or append(connection, run, form) for run in new]


def append(connection: Connection, new: NewRun, form: Format) -> RunInfo:
    """Store one run and seal it. Before the seal all rows are read back and compared with what was meant."""
    require_own_tables(new.stage, new.outcome.tables)
    content = new.content or content_of(new.outcome.tables, new.outcome.events)
    run_id = _insert_header(connection, new)  # first: a read-only file is noticed here
    _insert_inputs(connection, run_id, new, content.digest)
    count = insert_rows(connection, run_id, content.tables, form)
    _compare(stored_tables(connection, run_id, new.stage, form), content)
    _seal(connection, run_id, new, count, content.digest)
    if new.select and not new.outcome.error:
        select(connection, new.stage, run_id, new.actor, new.reason)
    return runs_where(connection, "r.run_id = ?", (run_id,))[0]


def check_heads(connection: Connection, expected: Mapping[str, int | None]) -> None:
    """Refuse if a head is no longer the one that the caller has read."""
    query = "SELECT run_id FROM main.selection WHERE stage = ? ORDER BY selection_id DESC LIMIT 1"
    for stage, run_id in expected.items():
        if scalar(connection, query, (stage,)) != run_id:
            message = f"{stage} was changed meanwhile by another command; run again."
            raise ChangedMeanwhile(message, "Nothing was stored.")


def same_run(connection: Connection, new: NewRun) -> RunInfo | None:
    """The newest run of the stage, if it is what is to be stored `once`: same inputs and settings, same ending."""
    if not new.once:
        return None
    last = runs_where(connection, "r.run_id = (SELECT max(run_id) FROM main.stage_run WHERE stage = ?)", (new.stage,))
    return next((run for run in last if (run.input_digest, run.error) == (new.input_digest, new.outcome.error)), None)


def _insert_header(connection: Connection, new: NewRun) -> int:
    _require_texts(new.actor, new.reason)
    settings = plain_json(dict(new.settings))
    execute(
        connection,
        "INSERT INTO stage_run SELECT (SELECT coalesce(max(run_id), 0) + 1 FROM main.stage_run), ?, "
        "(SELECT coalesce(max(version), 0) + 1 FROM main.stage_run WHERE stage = ?), ?, ?, ?, ?, ?, ?, ?",
        (new.stage, new.stage, new.stage_version, settings, new.input_digest, new.actor, new.reason, tool_version(),
         now()),
    )  # fmt: skip
    return int(scalar(connection, "SELECT max(run_id) FROM main.stage_run"))


def _insert_inputs(connection: Connection, run_id: int, new: NewRun, own_digest: str) -> None:
    query = "SELECT output_digest FROM main.run_seal WHERE run_id = ?"
    digests = {role: str(scalar(connection, query, (input_id,))) for role, input_id in new.inputs.items()}
    basis = digests or {OWN_CONTENT: own_digest}
    if new.input_digest != input_digest(new.stage, new.stage_version, new.settings, basis):
        raise OurFault(f"the input digest of {new.stage} is not the digest of its inputs and settings")
    rows = [(run_id, role, input_id) for role, input_id in sorted(new.inputs.items())]
    driver_of(connection).executemany("INSERT INTO run_input VALUES (?, ?, ?)", rows)


def _compare(stored: Mapping[str, StoredTable], meant: Content) -> None:
    """Every value as meant; the types of stored values are those of their columns, the tables are STRICT."""
    for name, rows in meant.tables.items():
        pairs = zip_longest(chain.from_iterable(stored[name].chunks()), chain.from_iterable(rows.chunks()))
        if not all(starmap(eq, pairs)):
            raise StorageError("What was read back is not what was written. Nothing was stored.", "Check the disk.")


def _seal(connection: Connection, run_id: int, new: NewRun, count: int, digest: str) -> None:
    status = "failed" if new.outcome.error else "succeeded"
    seal = (run_id, status, count, digest, new.outcome.summary, new.outcome.error, now())
    execute(
        connection,
        "INSERT INTO run_seal (run_id, status, row_count, output_digest, summary, error, sealed_at, record_digest) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
        (*seal, run_record_digest(connection, seal)),
    )


def _require_texts(*values: object) -> None:
    """SQLite would make a text of a number, and the record would not have its digest any more."""
    if not all(isinstance(value, str) for value in values):
        raise OurFault(f"{values} are not all texts")


def select(connection: Connection, stage: str, run_id: int | None, actor: str, reason: str) -> str:
    """Make a run the current version of its stage, or none, by adding a row; the digest of that row."""
    _require_texts(actor, reason)
    last = scalar(connection, "SELECT coalesce(max(selection_id), 0) FROM main.selection")
    newest = scalar(connection, "SELECT max(run_id) FROM main.stage_run")
    row = (last + 1, stage, run_id, actor, reason, now(), newest)
    digest = selection_record_digest(connection, row)
    execute(
        connection,
        "INSERT INTO selection (selection_id, stage, run_id, actor, reason, selected_at, after_run_id, record_digest) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
        (*row, digest),
    )
    return digest
