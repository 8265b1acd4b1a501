"""Made-up projects: one valid row for every table, a run of every stage."""

import hashlib
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from sqlalchemy import REAL, TEXT, CheckConstraint, Column, LargeBinary, Table

from orient.models import Base
from orient.store.digest import input_digest, output_digest
from orient.store.project import NewRun, Project, create_project
from orient.store.stage_tables import STAGE_TABLES
from orient.values import Blob, Event, Outcome, Scalar

INPUTS: dict[str, tuple[str, ...]] = {
    "photo": (),
    "readings": (),
    "sheet": (),
    "control": (),
    "model": (),
    "refine": ("photo", "readings"),
    "digitize": ("photo", "sheet"),
    "bl": ("photo", "control", "digitize"),
    "topocentric": ("photo", "bl"),
    "resection": ("photo", "refine", "topocentric", "digitize"),
    "covariance": ("photo", "refine", "topocentric", "resection"),
    "absolute": ("photo", "model", "topocentric"),
}
EVIDENCE: dict[str, tuple[str, ...]] = {"image": (), "seal": ("photo",), "verify": ("photo",)}
"""Stages that nothing reads."""
LEFT_EMPTY = {("comparator_reading", "col_px"), ("comparator_reading", "row_px"), ("graticule_cross", "E_m")}
EVENTS = (Event("info", "made", "p1", "made for a test", 0.1),)


def row_of(table: Table, seed: float = 0.5) -> dict[str, Scalar]:
    """One row that fulfils every constraint of the table."""
    words = _allowed_words(table)
    return {
        column.name: None if (table.name, column.name) in LEFT_EMPTY else _value(column, words, seed)
        for column in table.columns
        if column.name != "run_id"
    }


def _value(column: Column[object], words: Mapping[str, str], seed: float) -> Scalar:
    if column.name in words:
        return words[column.name]
    if isinstance(column.type, LargeBinary):
        return Blob(content := f"bytes of {seed}".encode(), lambda: content)
    if column.name == "sha256":
        return hashlib.sha256(str(seed).encode()).hexdigest()
    if isinstance(column.type, REAL):
        return seed
    return f"{column.name}" if isinstance(column.type, TEXT) else 1


def _allowed_words(table: Table) -> dict[str, str]:
    words = {}
    for constraint in table.constraints:
        if isinstance(constraint, CheckConstraint):
            match = re.match(r"(\w+) IN \('([^']*)'", str(constraint.sqltext))
            if match:
                words[match[1]] = match[2]
    return words


def outcome_of(stage: str, seed: float = 0.5) -> Outcome:
    tables = {name: [row_of(Base.metadata.tables[name], seed)] for name in STAGE_TABLES[stage]}
    return Outcome(tables, EVENTS, f"{stage} made with {seed}")


def new_run(project: Project, stage: str, seed: float = 0.5, outcome: Outcome | None = None) -> NewRun:
    heads = project.heads()
    inputs = {role: heads[role] for role in {**INPUTS, **EVIDENCE}[stage] if role in heads}
    outcome = outcome or outcome_of(stage, seed)
    digests = {role: run.output_digest for role, run in inputs.items()}
    basis = digests or {"content": output_digest(outcome.tables, outcome.events)}
    ids = {role: run.run_id for role, run in inputs.items()}
    settings = {"seed": seed}
    return NewRun(stage, 1, settings, ids, input_digest(stage, 1, settings, basis), outcome, ids, "tester", "a test")


def fill(project: Project, stages: Sequence[str] = tuple(INPUTS)) -> None:
    for stage in stages:
        project.append(new_run(project, stage))


def make_full(path: Path) -> Path:
    create_project(path, fill)
    return path


def readings(count: int) -> Outcome:
    row = row_of(Base.metadata.tables["comparator_reading"])
    rows = [{**row, "seq": seq, "point": f"p{seq}", "x_mm": seq * 0.001} for seq in range(1, count + 1)]
    return Outcome({"comparator_reading": rows}, (), f"{count} readings")
