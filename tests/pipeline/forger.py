"""A careful forger: changes a stored value past the guards and makes every digest fit again, so that `check` passes."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

from sqlalchemy import Connection, create_engine
from sqlalchemy.pool import StaticPool

from orient.store.chain import run_record_digest, selection_record_digest
from orient.store.digest import OWN_CONTENT, input_digest, rows_digest
from orient.store.format import current_format
from orient.store.rows import stored_tables
from orient.store.runs import settings_from_json


def forge(path: Path, change: Callable[[sqlite3.Connection], Any], *, careful: bool = True) -> None:
    """Apply `change` without the triggers; `careful`: then all digests and both chains anew."""
    with closing(sqlite3.connect(path, isolation_level=None)) as bare:
        bare.execute("PRAGMA synchronous = OFF")
        bare.execute("BEGIN")
        triggers = bare.execute("SELECT name, sql FROM sqlite_schema WHERE type = 'trigger' ORDER BY rowid").fetchall()
        for name, _ in triggers:
            bare.execute(f"DROP TRIGGER {name}")
        change(bare)
        bare.commit()
        if careful:
            engine = create_engine("sqlite://", creator=lambda: bare, poolclass=StaticPool)
            with engine.connect() as connection:
                _all_digests(connection)
                connection.commit()
        if not bare.in_transaction:
            bare.execute("BEGIN")
        for _, sql in triggers:
            bare.execute(sql)
        bare.commit()


def _all_digests(connection: Connection) -> None:
    form = current_format()
    for run_id, stage, version, settings in _all(
        connection, "SELECT run_id, stage, stage_version, settings FROM stage_run ORDER BY run_id"
    ):
        output = rows_digest(stored_tables(connection, run_id, stage, form))
        inputs = dict(
            _all(
                connection,
                "SELECT i.role, s.output_digest FROM run_input AS i JOIN run_seal AS s ON s.run_id = i.input_run_id "
                f"WHERE i.run_id = {run_id}",
            )
        )
        digest = input_digest(stage, version, settings_from_json(settings, run_id), inputs or {OWN_CONTENT: output})
        connection.exec_driver_sql("UPDATE stage_run SET input_digest = ? WHERE run_id = ?", (digest, run_id))
        connection.exec_driver_sql("UPDATE run_seal SET output_digest = ? WHERE run_id = ?", (output, run_id))
        seal = _all(
            connection,
            "SELECT run_id, status, row_count, output_digest, summary, error, sealed_at FROM run_seal "
            f"WHERE run_id = {run_id}",
        )[0]
        record = run_record_digest(connection, seal)
        connection.exec_driver_sql("UPDATE run_seal SET record_digest = ? WHERE run_id = ?", (record, run_id))
    for row in _all(
        connection,
        "SELECT selection_id, stage, run_id, actor, reason, selected_at, after_run_id FROM selection "
        "ORDER BY selection_id",
    ):
        record = selection_record_digest(connection, row)
        connection.exec_driver_sql("UPDATE selection SET record_digest = ? WHERE selection_id = ?", (record, row[0]))


def _all(connection: Connection, sql: str) -> list[tuple[Any, ...]]:
    return [tuple(row) for row in connection.exec_driver_sql(sql).all()]
