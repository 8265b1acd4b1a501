"""The residual of each control, check and excluded point, by coordinates, in the image and on the ground."""

from collections.abc import Mapping, Sequence

from orient.report.html.blocks import Block, Section, Table
from orient.report.html.cells import digits, fixed, micrometres, name, rms, worst_of
from orient.report.html.evidence import Evidence
from orient.report.html.sections.meaning import across_m, length_mm
from orient.report.language import mark, tr, trn
from orient.values import Row, Scalar

MOST = 50
COLUMNS = ("point", "role", "x_mm", "y_mm", "vx_mm", "vy_mm", "redundancy_x", "redundancy_y", "depth_m")
TITLES = {
    "control": mark("Control points: residuals, computed minus measured"),
    "check": mark("Check points: residuals, computed minus measured"),
    "excluded": mark("Excluded points: what their residuals would be"),
}


def section(evidence: Evidence) -> Section | None:
    found, photo = evidence.one("resection", "orientation"), evidence.photo
    if found is None or photo is None:
        return None
    every = evidence.rows("resection", "image_residual", COLUMNS)
    ground = {row["point"]: row for row in evidence.rows("covariance", "ground_covariance", ("point", "dX_m", "dY_m"))}
    blocks: list[Block] = []
    for role, title in TITLES.items():
        rows = [row for row in every if row["role"] == role]
        if rows:
            blocks.append(_table(tr(title), rows, float(found["f_mm"] or 1.0), photo["pixel_size_mm"], ground))
    return Section("residuals", tr("Residuals of every point"), [*blocks, *_known(evidence)])


def _table(title: str, rows: Sequence[Row], f_mm: float, pixel: object, ground: Mapping[Scalar, Row]) -> Table:
    """The largest first."""
    ranked = sorted(rows, key=lambda row: (-length_mm(row), str(row["point"])))[:MOST]
    cells = [[*_image_cells(row, pixel), *_ground_cells(row, f_mm, ground.get(row["point"]))] for row in ranked]
    pixels = [] if pixel is None else [tr("|v|, px")]
    headers = [
        tr("point"), "x, mm", "y, mm", "v_x, µm", "v_y, µm", tr("|v|, µm"), *pixels, "r_x", "r_y",
        tr("|v| across the ray, m"), "dX, m", "dY, m",
    ]  # fmt: skip
    counted = trn("{n} point", "{n} points", len(rows))
    return Table(f"{title} ({counted})", headers, cells, note=_note(rows, len(cells)))


def _image_cells(row: Row, pixel: object) -> list[str]:
    length = length_mm(row)
    in_pixels = [digits(length / pixel, 3)] if isinstance(pixel, float) else []
    return [
        name(row["point"]),
        fixed(row["x_mm"], 4),
        fixed(row["y_mm"], 4),
        micrometres(row["vx_mm"]),
        micrometres(row["vy_mm"]),
        micrometres(length),
        *in_pixels,
        fixed(row["redundancy_x"], 2),
        fixed(row["redundancy_y"], 2),
    ]


def _ground_cells(row: Row, f_mm: float, place: Row | None) -> list[str]:
    moved = (None, None) if place is None else (place["dX_m"], place["dY_m"])
    return [digits(across_m(row, f_mm), 3), *(digits(value, 3) for value in moved)]


def _note(rows: Sequence[Row], shown: int) -> str:
    """Root mean squares with their divisor, and what the columns are."""
    x, y, length = (rms(values) for values in (_of(rows, "vx_mm"), _of(rows, "vy_mm"), map(length_mm, rows)))
    told = tr(
        "RMS = √(Σv²/{n}): v_x {x} µm, v_y {y} µm, length {length} µm.",
        n=len(rows),
        x=micrometres(x),
        y=micrometres(y),
        length=micrometres(length),
    )
    columns = tr(
        "r: redundancy number, the share of an error that shows in the residual. |v| across the ray: |v| times depth "
        "/ f. "
        "dX, dY: where the ray meets the height of the point, minus the given place, with the error of the latter in "
        "it."
    )
    return " ".join(part for part in (worst_of(shown, len(rows)), told, columns) if part)


def _of(rows: Sequence[Row], column: str) -> list[float]:
    return [float(row[column] or 0.0) for row in rows]


def _known(evidence: Evidence) -> list[Block]:
    rows = evidence.rows("resection", "known_residual")
    if not rows:
        return []
    cells = [
        [
            name(row["quantity"]),
            name(row["unit"]),
            digits(row["sigma"], 4),
            digits(row["v"], 5),
            fixed(row["redundancy_number"], 3),
        ]
        for row in rows
    ]
    headers = [tr("quantity"), tr("unit"), tr("σ a priori"), "v", "r"]
    title = tr("What was known of the camera's place and attitude: adjusted minus known")
    return [Table(title, headers, cells, frozenset({0, 1}))]
