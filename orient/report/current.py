"""The current results of some stages, all of one moment: what a picture or an export is made from."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from orient.errors import OrientError, UsageError
from orient.pipeline.registry import how_to_get
from orient.report.findings import Finding
from orient.values import Tables
from orient.words import typed

if TYPE_CHECKING:
    from orient.store.project import Project, RunInfo


@dataclass(frozen=True, slots=True)
class Current:
    """Tables and runs of the current results by stage, and the findings of everything that is current."""

    path: Path
    tables: Mapping[str, Tables]
    runs: Mapping[str, "RunInfo"]
    findings: Sequence[Finding]

    @property
    def versions(self) -> dict[str, int]:
        """Version of each stage."""
        return {stage: run.version for stage, run in self.runs.items()}


def read_current(
    path: Path,
    stages: Sequence[str],
    what: str,
    otherwise: str,
    with_: Sequence[str] = (),
    leave_out: Collection[str] = (),
) -> Current:
    """Tables of `stages`, refused where one is missing or out of date, and of those `with_` that are current.

    `what` needs them; `otherwise` says what a mixture would do. `leave_out`: large tables that it does not read.
    """
    from orient.report.status import current_findings
    from orient.store.project import open_project

    with open_project(path, "read") as project, project.snapshot():
        stale = _stale(project)
        beside = [stage for stage in with_ if stage not in stale and stage not in stages]
        runs = fresh_heads(project, stages, what, otherwise, beside)
        tables = {stage: project.read_columns(run.run_id, leave_out) for stage, run in runs.items()}
        return Current(project.path, tables, runs, current_findings(project))


def fresh_heads(
    project: "Project", stages: Sequence[str], what: str, otherwise: str, with_: Sequence[str] = ()
) -> dict[str, "RunInfo"]:
    """The current runs of `stages`, and of those `with_` that exist; refused where one is missing or out of date."""
    heads, path = project.heads(), project.path
    missing = [stage for stage in stages if stage not in heads]
    if missing:
        failed = next((stage for stage in missing if last_failure(project.runs(stage))), "")
        hint = f"It failed: orient show {typed(path)} {failed}" if failed else how_to_get(missing, heads, typed(path))
        raise UsageError(f"{what} needs {', '.join(missing)}", hint)
    read = [*stages, *(stage for stage in with_ if stage in heads)]
    stale = _stale(project)
    if stale.intersection(read):
        listed = ", ".join(stage for stage in read if stage in stale)
        raise OrientError(f"the results are out of date ({listed}); {otherwise}", f"Run: orient run {typed(path)}")
    return {stage: heads[stage] for stage in read}


def last_failure(runs: "Sequence[RunInfo]") -> "RunInfo | None":
    """The last of a stage's runs if it failed: told where no version is current. What was withdrawn is no failure."""
    return next((run for run in runs[-1:] if run.status == "failed"), None)


def _stale(project: "Project") -> set[str]:
    return {str(row[0]) for row in project.query("SELECT stage FROM v_stale WHERE is_stale")[1]}
