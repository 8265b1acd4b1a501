"""Reading the ledger: runs, heads, events."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection

from orient.errors import ProjectError
from orient.store.connection import execute
from orient.store.digest import Content
from orient.store.stage_tables import STAGE_TABLES
from orient.values import Event, Outcome, Settings


@dataclass(frozen=True, slots=True)
class RunInfo:
    """One sealed run; `inputs` maps each role to the run that was read."""

    run_id: int
    stage: str
    version: int
    stage_version: int
    settings: Settings
    input_digest: str
    output_digest: str
    status: str
    summary: str
    error: str
    actor: str
    reason: str
    started_at: str
    tool_version: str
    inputs: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class NewRun:
    """A run that is to be stored. `expected_heads`: stage -> run_id that must still be current (None: no head).

    `content`: the rows of the outcome as they will be stored, if they are known already.
    `once`: if another command has stored the same run meanwhile, that one is taken and nothing is stored.
    """

    stage: str
    stage_version: int
    settings: Settings
    inputs: Mapping[str, int]
    input_digest: str
    outcome: Outcome
    expected_heads: Mapping[str, int | None]
    actor: str
    reason: str
    select: bool = True
    content: Content | None = None
    once: bool = False


RUNS = """
SELECT r.run_id, r.stage, r.version, r.stage_version, r.settings, r.input_digest, s.output_digest, s.status,
       s.summary, s.error, r.actor, r.reason, r.started_at, r.tool_version
FROM main.stage_run AS r JOIN main.run_seal AS s ON s.run_id = r.run_id
"""

INPUTS = "SELECT run_id, role, input_run_id FROM main.run_input"

HEADS = """
r.run_id IN (
    SELECT run_id FROM main.selection
    WHERE selection_id IN (SELECT max(selection_id) FROM main.selection GROUP BY stage)
)
"""


def runs_where(connection: Connection, condition: str, parameters: tuple[Any, ...] = ()) -> list[RunInfo]:
    """Sealed runs that fulfil an SQL condition on r (header) and s (seal), in the order of their numbers."""
    query = f"{RUNS} WHERE {condition} ORDER BY r.run_id"
    rows = execute(connection, query, parameters).fetchall()
    inputs = _inputs(connection, [row[0] for row in rows])
    return [_run_info(row, inputs.get(row[0], {})) for row in rows]


def _run_info(row: Sequence[Any], inputs: Mapping[str, int]) -> RunInfo:
    """`row`: the columns of RUNS, which are the fields but the last, with the settings as text."""
    values = [*row, inputs]
    values[4] = settings_from_json(row[4], row[0])
    return RunInfo(*values)


def _inputs(connection: Connection, run_ids: Sequence[int]) -> dict[int, dict[str, int]]:
    inputs: dict[int, dict[str, int]] = {}
    if run_ids:
        query = f"{INPUTS} WHERE run_id BETWEEN ? AND ? ORDER BY run_id, role"
        for run_id, role, input_run_id in execute(connection, query, (run_ids[0], run_ids[-1])):
            inputs.setdefault(run_id, {})[role] = input_run_id
    return inputs


def settings_from_json(text: str, run_id: int) -> dict[str, str | int | float | bool | None]:
    try:
        settings = json.loads(text)
    except (ValueError, TypeError, RecursionError):  # a damaged page gives a value of another type
        settings = None
    if not isinstance(settings, dict) or len(text) > 2**20:
        raise ProjectError(f"settings of run {run_id} are not valid.", "Check the project with: orient check")
    return settings


def heads(connection: Connection) -> dict[str, RunInfo]:
    """The current run of each stage, in the order of the stages."""
    found = {run.stage: run for run in runs_where(connection, HEADS)}
    order = {stage: place for place, stage in enumerate(STAGE_TABLES)}
    return {stage: found[stage] for stage in sorted(found, key=lambda stage: order.get(stage, len(order)))}


def events(connection: Connection, run_id: int) -> list[Event]:
    query = "SELECT severity, code, subject, message, value FROM main.run_event WHERE run_id = ? ORDER BY seq"
    return [Event(*row) for row in execute(connection, query, (run_id,))]
