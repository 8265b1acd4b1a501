"""`show STAGE`: findings first, then the numbers, for a person; or everything as JSON."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from orient.errors import UsageError
from orient.pipeline.registry import ALL_STAGES, BY_NAME
from orient.report.findings import findings, print_findings
from orient.report.orientation import iteration_table, orientation_lines, orientation_tables
from orient.report.sections import SECTIONS, Section
from orient.report.text import cell, console, print_table, printable
from orient.store.project import Project, RunInfo, open_project
from orient.values import Row, Tables

SHOWN_ROWS = 25


def show_stage(path: Path, stage: str, version: int | None, as_json: bool) -> bool:
    """Print one version of a stage; False if that version failed and is no result."""
    if stage not in ALL_STAGES:
        raise UsageError(f'there is no stage "{stage}"', f"Stages are {', '.join(ALL_STAGES)}.")
    with open_project(path, "read") as project, project.snapshot():
        run = project.run(stage, version) if version else project.heads().get(stage) or _last(project, stage)
        if run is None:
            raise UsageError(f"{stage} has no current version", _remedy(stage, path))
        tables, events = project.read_tables(run.run_id), project.events(run.run_id)
    if as_json:
        content = {"run": asdict(run), "events": [asdict(event) for event in events], "tables": tables}
        print(json.dumps(content, indent=2, allow_nan=False))
        return run.status == "succeeded"
    _print_head(run)
    print_findings(findings(run.stage, events))
    if stage == "resection":
        _print_resection(tables)
    for section in SECTIONS.get(stage, ()):
        _print_section(section, tables.get(section.source, ()))
    if stage == "photo":
        _print_record(tables["photo"][0])
    return run.status == "succeeded"


def _last(project: Project, stage: str) -> RunInfo | None:
    """The last run of a stage that never succeeded."""
    return next(iter(project.runs(stage)[-1:]), None)


def _remedy(stage: str, path: Path) -> str:
    return f"Run: orient run {path}" if stage in BY_NAME else f"Add it: orient add {path} {stage} FILE -m why"


def _print_head(run: RunInfo) -> None:
    out = console()
    when = run.started_at[:16].replace("T", " ")
    out.print(f"{run.stage} version {run.version}, {when} UTC by {printable(run.actor)}: {printable(run.reason)}")
    if run.status == "failed":
        out.print(f"  FAILED, this is not a result: {printable(run.error)}")
    elif run.summary:
        out.print(f"  {printable(run.summary)}")


def _print_resection(tables: Tables) -> None:
    out = console()
    if "orientation" not in tables:
        _print_iterations(tables)
        return
    for text in orientation_lines(tables):
        out.print(text, soft_wrap=True)
    for title, headers, rows in orientation_tables(tables, SHOWN_ROWS):
        out.print(f"\n{title}")
        print_table(headers, rows, [i > 0 for i in range(len(headers))])


def _print_iterations(tables: Tables) -> None:
    """All that a failed resection has to show."""
    if tables.get("iteration"):
        title, headers, rows = iteration_table(tables["iteration"])
        console().print(f"\n{title}")
        print_table(headers, rows, [True] * len(headers))


def _print_section(section: Section, rows: Sequence[Row]) -> None:
    """A table without the columns that are empty throughout."""
    used = [column for column in section.columns if any(row[column[0]] is not None for row in rows)]
    if not used:
        return
    out = console()
    out.print(f"\n{section.title}")
    cells = [[cell(row[name], decimals) for name, decimals in used] for row in rows[:SHOWN_ROWS]]
    numeric = [any(isinstance(row[name], int | float) for row in rows) for name, _ in used]
    print_table([name for name, _ in used], cells, numeric)
    if len(rows) > SHOWN_ROWS:
        more = len(rows) - SHOWN_ROWS
        out.print(f'... {more} more rows: --json, or orient sql PROJECT "SELECT * FROM {section.source}"')


def _print_record(row: Row) -> None:
    known = [[name, cell(value)] for name, value in row.items() if value is not None]
    print_table(["photo", ""], known, [False, False])
