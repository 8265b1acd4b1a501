"""Where the result comes from: versions, inputs, settings, software, digests, verification, and all runs before."""

from collections.abc import Mapping

from orient import __version__
from orient.report.html import kinds
from orient.report.html.blocks import Block, Facts, Paragraph, Section, Table
from orient.report.html.cells import digits, in_full, joined, moment, name
from orient.report.html.evidence import Evidence
from orient.report.language import tr
from orient.store.project import RunInfo
from orient.values import Scalar

MOST = 200
LAST_RECORDS = """
SELECT (SELECT record_digest FROM run_seal ORDER BY run_id DESC LIMIT 1),
       (SELECT record_digest FROM selection ORDER BY selection_id DESC LIMIT 1)
"""
RUN_WORDS = frozenset({0, 2, 3, 4, 5})


def section(evidence: Evidence) -> Section:
    blocks: list[Block] = [
        Paragraph(
            tr("The report shows these versions and nothing else; each was computed from the versions beside it.")
        ),
        _versions(evidence),
        _parameters(evidence),
        _digests(evidence),
        *_operations(evidence),
        *_verification(evidence),
        _history(evidence),
        Facts(tr("This report"), _report_facts(evidence)),
    ]
    return Section("provenance", tr("Provenance"), blocks)


def _versions(evidence: Evidence) -> Table:
    by_id = {run.run_id: run for run in evidence.all_runs}
    cells = [
        [
            f"{run.stage} ({kinds.stage(run.stage)})",
            str(run.version),
            kinds.word(run.status) if _is_current(run, evidence) else tr("not current"),
            ", ".join(f"{by_id[i].stage} {by_id[i].version}" for i in run.inputs.values()),
            name(run.actor),
            moment(run.started_at),
            name(run.summary or run.error),
        ]
        for run in evidence.runs.values()
    ]
    headers = [
        tr("stage"),
        tr("version"),
        tr("state"),
        tr("computed from"),
        tr("by"),
        tr("when"),
        tr("result, as recorded"),
    ]
    return Table(tr("Versions"), headers, cells, frozenset({0, 2, 3, 4, 5, 6}))


def _is_current(run: RunInfo, evidence: Evidence) -> bool:
    head = evidence.heads.get(run.stage)
    return run.status == "failed" or (head is not None and head.run_id == run.run_id)


def _parameters(evidence: Evidence) -> Table:
    cells = [
        [f"{run.stage} {run.version}", name(key), _setting(value)]
        for run in evidence.runs.values()
        for key, value in sorted(run.settings.items())
    ]
    headers = [tr("version"), tr("parameter"), tr("value")]
    return Table(tr("Parameters of every version"), headers, cells, frozenset({0, 1, 2}))


def _setting(value: Scalar | bool) -> str:
    if isinstance(value, bool):
        return tr("yes") if value else tr("no")
    return "–" if value is None or value == "" else in_full(value)


def _digests(evidence: Evidence) -> Table:
    cells = [
        [
            f"{run.stage} {run.version}",
            str(run.stage_version),
            run.input_digest,
            run.output_digest,
            name(run.tool_version),
        ]
        for run in evidence.runs.values()
    ]
    headers = [
        tr("version"),
        tr("of the computation"),
        tr("sha256 of inputs and settings"),
        tr("sha256 of the result"),
        tr("software"),
    ]
    return Table(tr("Digests and software"), headers, cells, frozenset({0, 2, 3, 4}))


def _operations(evidence: Evidence) -> list[Block]:
    rows = evidence.rows("bl", "crs_operation")
    if not rows:
        return []
    cells = [
        [
            name(row["source"]),
            name(row["source_crs"]),
            name(row["target_crs"]),
            name(row["name"]),
            digits(row["accuracy_m"], 3),
            tr("yes") if row["is_ballpark"] else tr("no"),
            joined([name(row["definition"]), name(row["grids"]), f"PROJ {row['proj_version']}"]),
        ]
        for row in rows[:MOST]
    ]
    headers = [
        tr("list"), tr("source system"), tr("target system"), tr("operation"), tr("accuracy, m"),
        tr("datum shift unknown"), tr("definition"),
    ]  # fmt: skip
    return [Table(tr("Coordinate operations"), headers, cells, frozenset({0, 1, 2, 3, 5, 6}))]


def _verification(evidence: Evidence) -> list[Block]:
    shown = {(run.stage, run.version) for run in evidence.runs.values()}
    rows = [row for row in evidence.verified if (row["stage"], row["version"]) in shown]
    if not rows:
        return [Paragraph(tr("No version of this report has been verified (orient verify)."))]
    return [
        Table(tr("Verification"), _verified_headers(), [_verified(row) for row in rows], frozenset({0, 1, 2, 3, 5}))
    ]


def _verified_headers() -> list[str]:
    return [
        tr("version"),
        tr("verified"),
        tr("by"),
        tr("verdict"),
        tr("largest relative difference"),
        tr("second engine"),
    ]


def _verified(row: Mapping[str, Scalar]) -> list[str]:
    still = kinds.word(row["verdict"]) if row["is_same_run"] else tr("what was verified is no longer what is stored")
    return [
        f"{row['stage']} {row['version']}",
        moment(str(row["verified_at"])),
        name(row["actor"]),
        still,
        digits(row["largest_difference"], 2),
        name(row["second_engine"] or "–"),
    ]


def _history(evidence: Evidence) -> Table:
    """Every run, the newest first: who did what, when and why."""
    newest = list(reversed(evidence.all_runs))[:MOST]
    cells = [
        [
            moment(run.started_at),
            str(run.version),
            run.stage,
            kinds.word(run.status),
            name(run.actor),
            name(run.reason),
        ]
        for run in newest
    ]
    headers = [tr("when"), tr("version"), tr("stage"), tr("state"), tr("by"), tr("reason, as recorded")]
    total = len(evidence.all_runs)
    note = "" if total <= MOST else tr("The {shown} newest of {total} are shown.", shown=MOST, total=total)
    return Table(tr("All runs of the project"), headers, cells, RUN_WORDS, note)


def _report_facts(evidence: Evidence) -> list[tuple[str, str]]:
    runs, selections = evidence.project.query(LAST_RECORDS)[1][0]
    return [
        (tr("made by"), f"orient {__version__}"),
        (tr("last record of the runs (chained sha256)"), name(runs)),
        (tr("last record of the selections (chained sha256)"), name(selections)),
    ]
