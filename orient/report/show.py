"""`show STAGE`: findings first, then the numbers, for a person; or everything as JSON."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from orient.errors import UsageError
from orient.pipeline.registry import ABOUT_RUNS, ALL_STAGES, EVIDENCE, FINAL_STAGES, IMAGE, MANIFEST, how_to_get
from orient.report.absolute import absolute_lines, absolute_tables, absolute_zones
from orient.report.budget import budget_lines, budget_tables
from orient.report.covariance import covariance_lines, covariance_tables
from orient.report.current import last_failure
from orient.report.findings import as_json as findings_as_json
from orient.report.findings import findings, later_failures, print_findings, remedy_of
from orient.report.orientation import Shown, iteration_table, orientation_lines, orientation_tables
from orient.report.reliability import reliability_tables, test_lines
from orient.report.sections import SECTIONS, Section
from orient.report.text import cell, console, print_json, print_table, printable
from orient.report.verify import known_verdicts, verified_line
from orient.store.project import Project, RunInfo, open_project
from orient.values import Row, Tables
from orient.words import typed

SHOWN_ROWS = 25
NOT_SHOWN = ("equation", "camera_equation", "external_reliability", "cycle_residual", "iteration_parameter")
"""Large tables that only the JSON holds."""
SHOWN_STAGES = (*ALL_STAGES, IMAGE, *ABOUT_RUNS)
TEXT_HEADERS = ("reading", "point", "action", "by", "reason", "")


def show_stage(path: Path, stage: str, version: int | None, as_json: bool) -> bool:
    """Print one version of a stage, or of the orientation; False if that version failed and is no result."""
    if stage not in ("", *SHOWN_STAGES):
        raise UsageError(f'there is no stage "{stage}"', f"Stages are {', '.join(SHOWN_STAGES)}.")
    with open_project(path, "read") as project, project.snapshot():
        stage = stage or _final_stage(project)
        run = project.run(stage, version) if version else project.heads().get(stage) or _last(project, stage)
        if run is None:
            raise UsageError(f"{stage} has no current version", _remedy(stage, path, project))
        tables = project.read_columns(run.run_id, () if as_json else NOT_SHOWN)
        events = project.events(run.run_id)
        verdict = next((row for row in known_verdicts(project) if _is_about(row, run)), None)
        stale = _why_stale(project, run)
        later = [] if version else [finding for finding in later_failures(project) if finding.stage == stage]
    if as_json:
        events_shown = [asdict(event) for event in events]
        content = {
            "run": asdict(run),
            "events": events_shown,
            "tables": {name: list(rows) for name, rows in tables.items()},
            "verification": verdict,
            "later_failures": findings_as_json(later),
            "stale": stale,
        }
        print_json(content)
        return run.status == "succeeded"
    _print_head(run, remedy_of(events))
    if stale:
        console().print(f"  OUT OF DATE: {printable(stale)}; run: orient run {printable(typed(path))}", soft_wrap=True)
    if verdict is not None:
        console().print(f"  {printable(verified_line(verdict))}", soft_wrap=True)
    print_findings([*later, *findings(run.stage, events)])
    _print_numbers(stage, tables)
    return run.status == "succeeded"


def _final_stage(project: Project) -> str:
    """The stage that holds the orientation of this project; the first of them while there is none."""
    heads = project.heads()
    return next((stage for stage in FINAL_STAGES if stage in heads), FINAL_STAGES[0])


def _print_numbers(stage: str, tables: Tables) -> None:
    if stage == "resection":
        _print_resection(tables)
    if stage == "absolute":
        _print_absolute(tables)
    for text in [*budget_lines(tables), *covariance_lines(tables)] if stage == "covariance" else ():
        console().print(text, soft_wrap=True)
    for section in SECTIONS.get(stage, ()):
        _print_section(section, tables.get(section.source, ()))
    _print_tests(tables, with_lines=stage not in ("resection", "absolute"))
    if stage == "covariance":
        _print_tables([*budget_tables(tables), *covariance_tables(tables, SHOWN_ROWS)])
    if stage == "photo":
        _print_record(tables["photo"][0])


def _is_about(verdict: Row, run: RunInfo) -> bool:
    return (verdict["stage"], verdict["version"]) == (run.stage, run.version)


def _why_stale(project: Project, run: RunInfo) -> str:
    """Why the current version of a stage is no result of today's inputs; empty for all that is."""
    asked = "SELECT why FROM v_stale WHERE is_stale AND stage = ? AND version = ?"
    rows = project.query(asked, (run.stage, run.version))[1]
    return str(rows[0][0]) if rows else ""


def _last(project: Project, stage: str) -> RunInfo | None:
    """The last run of a stage without a current version: one that failed, or one about other runs."""
    runs = project.runs(stage)
    return next(iter(runs[-1:]), None) if stage in ABOUT_RUNS else last_failure(runs)


def _remedy(stage: str, path: Path, project: Project) -> str:
    if runs := project.runs(stage):
        last = runs[-1].version
        back = f"orient select {typed(path)} {stage} {last} -m why"
        return f"It was withdrawn. See it: --version {last}; have it back: {back}"
    if stage == EVIDENCE:
        return f"Run: orient verify {typed(path)}"
    if stage in (IMAGE, MANIFEST):
        return f"Run: orient seal {typed(path)} -o SEALED --image FILE"
    return how_to_get([stage], project.heads(), typed(path))


def _print_head(run: RunInfo, remedy: str) -> None:
    out = console()
    when = run.started_at[:16].replace("T", " ")
    out.print(f"{run.stage} version {run.version}, {when} UTC by {printable(run.actor)}: {printable(run.reason)}")
    if run.status == "failed" and run.stage == EVIDENCE:
        out.print(f"  NOT VERIFIED: {printable(run.error)}")
    elif run.status == "failed":
        out.print(f"  FAILED, this is not a result: {printable(run.error)}")
    elif run.summary:
        out.print(f"  {printable(run.summary)}")
    if remedy:
        out.print(f"    -> {printable(remedy)}", soft_wrap=True)


def _print_resection(tables: Tables) -> None:
    out = console()
    if "orientation" not in tables:
        _print_iterations(tables)
        return
    for text in (*orientation_lines(tables), *test_lines(tables)):
        out.print(text, soft_wrap=True)
    _print_tables(orientation_tables(tables, SHOWN_ROWS))


def _print_tables(shown: Sequence[Shown]) -> None:
    """Tables of cells, the first column and those of TEXT_HEADERS to the left."""
    for title, headers, rows in shown:
        console().print(f"\n{title}")
        print_table(headers, rows, [i > 0 and header not in TEXT_HEADERS for i, header in enumerate(headers)])


def _print_absolute(tables: Tables) -> None:
    """Zone after zone; a failure has iterations only."""
    out = console()
    for zone in absolute_zones(tables):
        for text in absolute_lines(zone, tables):
            out.print(text, soft_wrap=True)
        for title, headers, rows in absolute_tables(zone, tables, SHOWN_ROWS):
            out.print(f"\n{title}")
            print_table(headers, rows, [i > 0 for i in range(len(headers))])


def _print_tests(tables: Tables, with_lines: bool) -> None:
    """Exclusions and reliability of any stage that has them."""
    out = console()
    if with_lines and tables.get("adjustment_test"):
        out.print()
    for text in test_lines(tables) if with_lines else ():
        out.print(text, soft_wrap=True)
    for title, headers, rows in reliability_tables(tables, SHOWN_ROWS):
        out.print(f"\n{title}")
        print_table(headers, rows, [header not in TEXT_HEADERS for header in headers])


def _print_iterations(tables: Tables) -> None:
    """All that a failed resection has to show."""
    if tables.get("iteration"):
        title, headers, rows = iteration_table(tables["iteration"])
        console().print(f"\n{title}")
        print_table(headers, rows, [True] * len(headers))


def _print_section(section: Section, rows: Sequence[Row]) -> None:
    """A table without the columns that are empty throughout."""
    rows = [row for row in rows if not section.only or row[section.only] is not None]
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
