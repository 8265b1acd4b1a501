"""The ledger as two chains: each run and each selection carries a digest over itself and the entry before.

So a changed actor, reason, time, summary or order is found by `orient check`, and not only changed numbers.
"""

from collections.abc import Sequence

from sqlalchemy import Connection

from orient.store.connection import execute, scalar
from orient.store.digest import record_digest
from orient.values import Scalar

HEADER = """
SELECT run_id, stage, version, stage_version, settings, input_digest, actor, reason, tool_version, started_at
FROM main.stage_run WHERE run_id = ?
"""
INPUTS = "SELECT role, input_run_id FROM main.run_input WHERE run_id = ? ORDER BY role"
BEFORE = "SELECT record_digest FROM main.run_seal WHERE run_id < ? ORDER BY run_id DESC LIMIT 1"
SELECTED_BEFORE = "SELECT record_digest FROM main.selection WHERE selection_id < ? ORDER BY selection_id DESC LIMIT 1"


def run_record_digest(connection: Connection, seal: Sequence[Scalar]) -> str:
    """Digest over header, inputs and seal; `seal` = run_id ... sealed_at, in stored order without the digest."""
    run_id = seal[0]
    header = execute(connection, HEADER, (run_id,)).fetchone()
    inputs = execute(connection, INPUTS, (run_id,)).fetchall()
    before = scalar(connection, BEFORE, (run_id,))
    return record_digest("run", list(header), [list(row) for row in inputs], list(seal), before)


def selection_record_digest(connection: Connection, row: Sequence[Scalar]) -> str:
    """Digest over a selection; `row` = selection_id ... after_run_id, in stored order without the digest."""
    before = scalar(connection, SELECTED_BEFORE, (row[0],))
    return record_digest("selection", list(row), before)
