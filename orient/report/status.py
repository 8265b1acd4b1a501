"""`status` and `log`. Both must start fast: nothing here imports NumPy, Alembic or the models."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from orient.pipeline.registry import ALL_STAGES, BY_NAME, FINAL_STAGES, IMAGE, is_optional
from orient.report.findings import (
    UNUSED_DATA,
    Finding,
    Verdict,
    findings,
    grave_first,
    later_failures,
    print_findings,
    remedy_of,
    verdict,
)
from orient.report.findings import as_json as findings_as_json
from orient.report.text import cell, console, print_json, print_table, printable
from orient.report.verify import known_verdicts, status_line
from orient.store.project import open_project
from orient.values import Scalar
from orient.words import typed

if TYPE_CHECKING:
    from orient.store.project import Project

STATUS = "SELECT stage, version, is_stale, why FROM v_stale"
CURRENT = "SELECT stage, version, status, selected_at, actor, summary FROM v_current"
LOG = "SELECT at, actor, action, stage, version, status, reason, summary FROM v_audit"
WAITS_FOR = "waits for "
MINUTE = len("2026-01-01T00:00")


@dataclass(frozen=True, slots=True)
class Standing:
    """Where a project stands: the verdict, what is current, and what a reader must know first.

    `stages`: stage, version, state, told, remedy of each that exists or is wanted; `verified`: what is known of each.
    """

    verdict: Verdict
    findings: list[Finding]
    stages: list[dict[str, object]]
    verified: list[dict[str, Scalar]]
    warnings: list[str]


def standing(project: "Project") -> Standing:
    """One moment of an open project."""
    with project.snapshot():
        stale = {row[0]: (bool(row[2]), row[3]) for row in project.query(STATUS)[1]}
        current = {row[0]: row for row in project.query(CURRENT)[1]}
        failed = _last_failures(project)
        found, verified = current_findings(project), known_verdicts(project)
    stages = [_stage_status(name, current, stale, failed) for name in (*ALL_STAGES, IMAGE)]
    known = [entry for entry in stages if entry["state"] != "absent" and not _can_be_left_out(entry)]
    states = {str(entry["stage"]): str(entry["state"]) for entry in known}
    return Standing(verdict(states, found, FINAL_STAGES), found, known, verified, project.warnings)


def show_status(path: Path, as_json: bool) -> None:
    """The verdict and the problems of what is current; then every stage."""
    with open_project(path, "read") as project:
        now = standing(project)
    if as_json:
        content = {
            "project": str(path),
            "verdict": now.verdict.word,
            "sentence": now.verdict.sentence,
            "findings": findings_as_json(now.findings),
            "stages": now.stages,
            "verification": now.verified,
        }
        print_json(content)
        return
    out = console()
    out.print(f"{printable(str(path))}: {now.verdict.sentence}")
    print_findings([finding for finding in now.findings if finding.severity != "info"], with_stage=True)
    rows = [[cell(entry[key]) for key in ("stage", "version", "state", "told")] for entry in now.stages]  # type: ignore[arg-type]
    print_table(["stage", "version", "state", "result"], rows, [False, True, False, False])
    versions = {str(entry["stage"]): entry["version"] for entry in now.stages if entry["version"] is not None}
    for entry in now.stages:
        if entry["remedy"]:
            out.print(f"{entry['stage']}: {printable(str(entry['remedy']))}", soft_wrap=True)
    if verified := status_line(now.verified, versions):
        out.print(printable(verified), soft_wrap=True)
    for warning in now.warnings:
        out.print(f"note: {printable(warning)}")
    if any(entry["state"] in ("stale", "to compute") for entry in now.stages):
        out.print(f"Next: orient run {printable(typed(path))}")


def current_findings(project: "Project") -> list[Finding]:
    """What failed after the current version of a stage; then the findings of the current versions, the grave ones
    first, then those nearest to the result.

    What a later stage says again in other words (points without control) is told once, by the later stage.
    """
    heads = project.heads()
    last: dict[tuple[str, str], Finding] = {}
    for name in reversed(ALL_STAGES):
        for finding in findings(name, project.events(heads[name].run_id)) if name in heads else ():
            what = "" if finding.code in UNUSED_DATA else finding.subject or finding.message
            last.setdefault((finding.code, what), finding)
    return [*later_failures(project), *grave_first(last.values())]


def _stage_status(
    name: str,
    current: dict[str, tuple[object, ...]],
    stale: dict[str, tuple[bool, str]],
    failed: dict[str, tuple[str, str]],
) -> dict[str, object]:
    entry: dict[str, object] = {"stage": name, "version": None, "state": "absent", "told": "", "remedy": ""}
    if name in current:
        _, version, _, _, _, summary = current[name]
        entry.update(version=version, state="current", told=summary)
    is_stale, why = stale.get(name, (False, ""))
    if is_stale:
        entry.update(state="stale" if name in current else "to compute", told=why)
    elif name not in current and name in BY_NAME:
        missing = BY_NAME[name].missing(set(current))
        entry.update(state="waiting", told=f"{WAITS_FOR}{missing}")
    if name in failed and entry["state"] not in ("current", "waiting"):
        told, remedy = failed[name]
        entry.update(state="failed", told=told, remedy=remedy)
    return entry


def _can_be_left_out(entry: dict[str, object]) -> bool:
    return entry["state"] == "waiting" and is_optional(str(entry["stage"]), str(entry["told"]).removeprefix(WAITS_FOR))


def _last_failures(project: "Project") -> dict[str, tuple[str, str]]:
    """Error of the last run of each stage that failed then, and what to do about it."""
    last = {run.stage: run for run in project.runs()}
    failed = {stage: run for stage, run in last.items() if run.status == "failed"}
    return {stage: (run.error, remedy_of(project.events(run.run_id))) for stage, run in failed.items()}


def show_log(path: Path, as_json: bool) -> None:
    with open_project(path, "read") as project:
        columns, rows = project.query(LOG)
    if as_json:
        print_json([dict(zip(columns, row, strict=True)) for row in rows])
        return
    shown = [[cell(value) for value in row] for row in _without_own_selections(rows)]
    print_table(list(columns), shown, [column == "version" for column in columns])


def _without_own_selections(rows: Sequence[Sequence[Scalar]]) -> list[list[Scalar]]:
    """Rows for people: a run that becomes current at once is one line; time to the minute."""
    shown: list[list[Scalar]] = []
    for before, row in zip([None, *rows], rows, strict=False):
        repeats = before is not None and row[2] == "select" and (before[2], *before[3:5]) == ("run", *row[3:5])
        if not repeats:
            shown.append([str(row[0])[:MINUTE].replace("T", " "), *row[1:]])
    return shown
