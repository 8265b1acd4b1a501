"""How sure ground points are: over the frame, point by point, and what must not be left out of the matrix."""

from orient.report.html import kinds
from orient.report.html.blocks import Block, Figure, Section, Table
from orient.report.html.cells import digits, fixed, name, worst_of
from orient.report.html.evidence import Evidence
from orient.report.language import mark, tr

MOST = 50
LEAST_SURE = f"ORDER BY ellipse_a_m DESC, point LIMIT {MOST}"
SEES_GROUND = "sigma_X_m IS NOT NULL"
USES = {
    "six elements": mark("all six elements, full matrix"),
    "standard deviations only": mark("standard deviations only"),
    "position only": mark("position only"),
    "angles only": mark("angles only"),
}


def section(evidence: Evidence) -> Section | None:
    total = evidence.count("covariance", "ground_covariance")
    seen = evidence.count("covariance", "ground_accuracy", SEES_GROUND)
    if not total and not seen:
        return None
    blocks: list[Block] = [*_map(evidence, seen), *_ellipses(evidence, total), *_points(evidence, total)]
    return Section("accuracy", tr("Ground accuracy"), [*blocks, *_uses(evidence)])


def _map(evidence: Evidence, seen: int) -> list[Figure]:
    if not seen:
        return []
    note = tr("√((σX² + σY²)/2) of a new point that is read once at this place of the frame, at the mean height.")
    return [evidence.figure("accuracy", tr("Map of the ground accuracy over the frame"), note)]


def _ellipses(evidence: Evidence, total: int) -> list[Figure]:
    if not total:
        return []
    note = tr("A standard ellipse holds the true place with 39 % probability; 2.45 times its axes with 95 %.")
    return [evidence.figure("ellipses", tr("Error ellipses on the ground"), note)]


def _points(evidence: Evidence, total: int) -> list[Table]:
    rows = evidence.rows("covariance", "ground_covariance", tail=LEAST_SURE)
    if not rows:
        return []
    cells = [
        [
            name(row["point"]),
            kinds.word(row["role"]),
            *(fixed(row[column], 3) for column in ("X_m", "Y_m", "Z_m")),
            *(digits(row[column], 4) for column in ("dX_m", "dY_m", "sigma_X_m", "sigma_Y_m")),
            *(digits(row[column], 4) for column in ("ellipse_a_m", "ellipse_b_m")),
            fixed(row["ellipse_azimuth_deg"], 1),
        ]
        for row in rows
    ]
    headers = [
        tr("point"), tr("role"), "X, m", "Y, m", "Z, m", "dX, m", "dY, m", "σX, m", "σY, m", "a, m", "b, m",
        tr("azimuth, deg"),
    ]  # fmt: skip
    note = tr(
        "dX, dY: where the ray meets the height of the point, minus the given place. a, b: semi-axes, σ all parts."
    )
    title = tr("Ground points, the least sure first")
    shown = worst_of(len(cells), total)
    return [Table(title, headers, cells, frozenset({0, 1}), f"{shown} {note}".strip())]


def _uses(evidence: Evidence) -> list[Table]:
    rows = {str(row["elements"]): row for row in evidence.rows("covariance", "element_use")}
    cells = [
        [tr(told), digits(rows[key]["sigma_m"], 4), digits(rows[key]["factor"], 4)]
        for key, told in USES.items()
        if key in rows
    ]
    if not cells:
        return []
    note = tr("Use all six elements with the full matrix: less of it gives other standard deviations on the ground.")
    headers = [tr("elements used"), tr("σ on the ground, m"), tr("factor")]
    return [Table(tr("The part of the orientation, if less of the matrix were used"), headers, cells, note=note)]
