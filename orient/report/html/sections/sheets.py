"""The map sheets on the digitiser: their polynomials, and the residual of every cross."""

from collections.abc import Sequence

from orient.report.html import kinds
from orient.report.html.blocks import Block, Paragraph, Section, Table
from orient.report.html.cells import digits, first_of, fixed, name, worst_of
from orient.report.html.evidence import Evidence
from orient.report.language import tr
from orient.values import Row

MOST_SHEETS, MOST_CROSSES = 12, 60
CROSS_WORDS = frozenset({0, 1, 6})


def section(evidence: Evidence) -> Section | None:
    sheets = evidence.rows("digitize", "sheet_transform")
    if not sheets:
        return None
    crosses = evidence.rows("digitize", "cross_residual")
    blocks: list[Block] = [_sheets(sheets)]
    for sheet in sheets[:MOST_SHEETS]:
        mine = [row for row in crosses if row["sheet"] == sheet["sheet"]]
        title = tr("Sheet {sheet}", sheet=name(sheet["sheet"]))
        blocks += [evidence.figure("sheet", title, part=str(sheet["sheet"])), _crosses(title, mine)]
    if left := first_of(MOST_SHEETS, len(sheets)):
        blocks.append(Paragraph(left, "note"))
    return Section("sheets", tr("Map sheets on the digitiser"), blocks)


def _sheets(rows: Sequence[Row]) -> Table:
    cells = [
        [
            name(row["sheet"]),
            str(row["degree"]),
            name(row["degree_chosen_by"]),
            str(row["n_crosses"]),
            str(row["redundancy"]),
            digits(row["sigma0_N_m"], 4),
            digits(row["sigma0_E_m"], 4),
        ]
        for row in rows
    ]
    headers = [tr("sheet"), tr("degree"), tr("chosen by"), tr("crosses"), "r", tr("σ0 north, m"), tr("σ0 east, m")]
    note = tr("Each coordinate is adjusted for itself; r = crosses minus coefficients, σ0 = √(Σv²/r).")
    return Table(tr("Polynomials of the sheets"), headers, cells, frozenset({0, 2}), note)


def _crosses(sheet: str, rows: Sequence[Row]) -> Table:
    ranked = sorted(rows, key=lambda row: (-_square(row), str(row["cross"])))[:MOST_CROSSES]
    cells = [
        [
            name(row["cross"]),
            kinds.word(row["role"]),
            fixed(row["v_N_m"], 2),
            fixed(row["v_E_m"], 2),
            fixed(row["redundancy_number"], 2),
            digits(row["probability"], 3),
            tr("suspect") if row["is_suspect"] else "",
        ]
        for row in ranked
    ]
    headers = [tr("cross"), tr("role"), tr("v north, m"), tr("v east, m"), "r", tr("probability"), ""]
    title = tr("{sheet}: crosses, polynomial minus given", sheet=sheet)
    return Table(title, headers, cells, CROSS_WORDS, worst_of(len(cells), len(rows)))


def _square(row: Row) -> float:
    return float(row["v_N_m"] or 0.0) ** 2 + float(row["v_E_m"] or 0.0) ** 2
