"""The global test, the test of each observation with the smallest error it would find, and the points left out."""

from collections.abc import Sequence

from orient.report.html import kinds
from orient.report.html.blocks import Block, Paragraph, Section, Table
from orient.report.html.cells import MICROMETRES, digits, fixed, name
from orient.report.html.evidence import Evidence
from orient.report.language import tr
from orient.values import Row

MOST = 50
TESTED = ("resection", "digitize", "absolute")
WEAKEST = f"""
ORDER BY kind = 'coefficient',
         CASE verdict WHEN 'suspect' THEN 0 WHEN 'not checked' THEN 1 WHEN 'hardly checked' THEN 2 ELSE 3 END,
         abs(coalesce(bias_to_noise, 0)) DESC, part, point, axis
LIMIT {MOST}
"""


def section(evidence: Evidence) -> Section | None:
    blocks: list[Block] = []
    for stage in TESTED:
        tests = evidence.rows(stage, "adjustment_test")
        if tests:
            blocks.append(_global(stage, tests))
        blocks += [*_exclusions(stage, evidence), *_observations(stage, evidence)]
    if not blocks:
        return None
    told = tr(
        "A reading is suspect if its test value exceeds the limit (α0 = 0.001). MDB is the smallest error that this "
        "test "
        "finds with a power of 80 %; BNR says what it would do to the unknowns if it is not found, in units of their "
        "precision; the ground column, by how much it would move a ground point."
    )
    return Section("reliability", tr("Reliability"), [Paragraph(told), *blocks])


def _global(stage: str, rows: Sequence[Row]) -> Table:
    cells = [
        [
            " ".join(name(row[key]) for key in ("part", "component") if row[key]) or kinds.stage(stage),
            str(row["redundancy"]),
            fixed(row["statistic"], 2),
            fixed(row["lower"], 2),
            fixed(row["upper"], 2),
            digits(row["probability"], 3),
            "–" if row["verdict"] is None else kinds.word(row["verdict"]),
            f"|{row['test']}|",
            fixed(row["critical"], 2),
        ]
        for row in rows
    ]
    headers = [
        tr("adjustment"), "r", "v′Pv/σ0²", tr("accepted from"), tr("accepted to"), tr("probability"),
        tr("global test"), tr("test"),
        tr("limit"),
    ]  # fmt: skip
    title = tr("Global test (5 %): {stage}", stage=kinds.stage(stage))
    return Table(title, headers, cells, frozenset({0, 6, 7}))


def _exclusions(stage: str, evidence: Evidence) -> list[Block]:
    rows = evidence.rows(stage, "exclusion")
    if not rows:
        return []
    cells = [
        [
            f"{name(row['part'])} {name(row['point'])}".strip(),
            kinds.word(row["action"]),
            kinds.word(row["decided_by"]),
            name(row["reason"]),
        ]
        for row in rows[:MOST]
    ]
    headers = [tr("point"), tr("decision"), tr("decided"), tr("reason, as recorded")]
    return [Table(tr("Points left out, or proposed for it"), headers, cells, frozenset({0, 1, 2, 3}))]


def _observations(stage: str, evidence: Evidence) -> list[Block]:
    rows = evidence.rows(stage, "observation_test", tail=WEAKEST)
    if not rows:
        return []
    cells = [
        [
            f"{name(kinds.word(row['part']))} {name(row['point'])} {name(row['axis'])}".strip(),
            *_size(row, "v"),
            fixed(row["share"], 2),
            fixed(row["w"], 2),
            *_size(row, "smallest_error"),
            fixed(row["bias_to_noise"], 1),
            digits(row["ground_shift_m"], 3),
            fixed(row["rho"], 2),
            kinds.word(row["verdict"]),
        ]
        for row in rows
    ]
    headers = [tr("reading"), "v", tr("share"), "w, τ", "MDB", "BNR", tr("ground, m"), "ρ", tr("verdict")]
    total = evidence.count(stage, "observation_test")
    note = "" if total <= len(rows) else tr("The {shown} weakest of {total} are shown.", shown=len(rows), total=total)
    title = tr("Each observation: {stage}", stage=kinds.stage(stage))
    return [Table(title, headers, cells, frozenset({0, 8}), note)]


def _size(row: Row, column: str) -> list[str]:
    """Image coordinates in micrometres, all others in their own unit."""
    value = row[column]
    if value is None:
        return [digits(None)]
    if row["unit"] == "mm":
        return [f"{MICROMETRES * float(value):.1f} µm"]
    return [f"{digits(value, 3)} {name(row['unit'])}".removesuffix(" 1")]
