"""How the adjustment converged: curves, and approximation and correction of every element."""

from collections.abc import Sequence

from orient.report.html.blocks import Block, Paragraph, Section, Table
from orient.report.html.cells import digits, first_of, fixed, name
from orient.report.html.evidence import Evidence
from orient.report.language import tr
from orient.values import Row

MOST = 120
OF_ELEMENTS = "AND point = '' ORDER BY iteration, rowid"


def section(evidence: Evidence) -> Section | None:
    steps = evidence.rows("resection", "iteration")
    if not steps:
        return None
    parameters = evidence.rows("resection", "iteration_parameter", tail=OF_ELEMENTS)
    note = tr("Each curve falls until only rounding is left; a correction of zero has no place on a logarithmic axis.")
    blocks: list[Block] = [
        evidence.figure("iterations", tr("Iterations"), note),
        step_table(steps),
        parameter_table(parameters),
        *_starts(evidence),
    ]
    return Section("iterations", tr("Iterations"), blocks)


def step_table(steps: Sequence[Row]) -> Table:
    cells = [
        [
            str(row["iteration"]),
            digits(row["vPv"], 8),
            f"{float(row['max_scaled_step'] or 0.0):.2e}",
            digits(row["damping"], 2),
        ]
        for row in steps[:MOST]
    ]
    headers = [tr("iteration"), "v′Pv", tr("largest scaled step"), tr("damping")]
    note = tr("v′Pv at the approximations of the iteration, in mm² of the image (model: weights as stated).")
    return Table(tr("Steps"), headers, cells, frozenset(), note)


def parameter_table(parameters: Sequence[Row]) -> Table:
    cells = [
        [
            str(row["iteration"]),
            name(row["unknown"]),
            name(row["unit"]),
            digits(row["approximation"], 12),
            f"{float(row['correction'] or 0.0):+.6e}",
        ]
        for row in parameters[:MOST]
    ]
    headers = [tr("iteration"), tr("element"), tr("unit"), tr("approximation"), tr("correction")]
    title = tr("Approximation and correction of every element")
    return Table(title, headers, cells, frozenset({1, 2}), first_of(len(cells), len(parameters)))


def _starts(evidence: Evidence) -> list[Block]:
    """Where the start values led: a reader must see that no other orientation fits as well."""
    rows = evidence.rows("resection", "resection_solution")
    if not rows:
        return []
    cells = [
        [
            str(row["solution"]),
            name(row["termination"]),
            tr("yes") if row["is_as_good"] else tr("no"),
            *(fixed(row[column], 2) for column in ("X_S_m", "Y_S_m", "Z_S_m")),
            digits(row["vPv"], 6),
            f"{row['n_in_front']}/{row['n_points']}",
        ]
        for row in rows[:MOST]
    ]
    headers = [
        tr("solution"), tr("end"), tr("as good"), "X_S, m", "Y_S, m", "Z_S, m", "v′Pv", tr("points in front")
    ]  # fmt: skip
    return [
        Paragraph(
            tr("The adjustment was started from several places; these are the distinct orientations it ended in.")
        ),
        Table(tr("Where the starts led"), headers, cells, frozenset({1, 2})),
    ]
