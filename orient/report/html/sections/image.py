"""From the comparator to image coordinates: fiducial marks, and every correction in its own column."""

from orient.report.html.blocks import Block, Section, Table
from orient.report.html.cells import digits, fixed, micrometres, name, rms, worst_of
from orient.report.html.evidence import Evidence
from orient.report.language import tr

MOST = 50
CORRECTIONS = ("dx_distortion_mm", "dy_distortion_mm", "dx_refraction_mm", "dy_refraction_mm", "dx_curvature_mm",
               "dy_curvature_mm")  # fmt: skip
LARGEST = f"""
ORDER BY dx_distortion_mm * dx_distortion_mm + dy_distortion_mm * dy_distortion_mm
       + dx_refraction_mm * dx_refraction_mm + dy_refraction_mm * dy_refraction_mm DESC, point
LIMIT {MOST}
"""


def section(evidence: Evidence) -> Section | None:
    if "refine" not in evidence.runs:
        return None
    blocks = [*_interior(evidence), *_corrections(evidence)]
    return Section("image", tr("Image coordinates and their corrections"), blocks) if blocks else None


def _interior(evidence: Evidence) -> list[Block]:
    found = evidence.one("refine", "interior_orientation")
    if found is None:
        return []
    parameters = [
        [name(row["name"]), digits(row["value"], 12), digits(row["sigma"], 4)]
        for row in evidence.rows("refine", "interior_parameter")
    ]
    marks = evidence.rows("refine", "fiducial_residual")
    cells = [
        [
            name(row["mark"]),
            fixed(row["x_mm"], 4),
            fixed(row["y_mm"], 4),
            micrometres(row["vx_mm"]),
            micrometres(row["vy_mm"]),
        ]
        for row in marks
    ]
    told = tr(
        "{marks} marks, redundancy {r}, σ0 = √(Σv²/r) = {sigma0} µm.",
        marks=found["n_marks"],
        r=found["redundancy"],
        sigma0=micrometres(found["sigma0_mm"]),
    )
    x, y = (micrometres(rms(float(row[column] or 0.0) for row in marks)) for column in ("vx_mm", "vy_mm"))
    of_marks = tr("RMS = √(Σv²/{n}): v_x {x} µm, v_y {y} µm.", n=len(marks), x=x, y=y)
    title = tr("Interior orientation: {transformation}", transformation=name(found["transformation"]))
    return [
        Table(title, [tr("parameter"), tr("value"), "σ"], parameters, note=told),
        Table(
            tr("Fiducial marks: transformed minus calibrated"),
            [tr("mark"), "x, mm", "y, mm", "v_x, µm", "v_y, µm"],
            cells,
            note=of_marks,
        ),
    ]


def _corrections(evidence: Evidence) -> list[Block]:
    rows = evidence.rows("refine", "image_point", tail=LARGEST)
    used = [column for column in CORRECTIONS if any(row[column] for row in rows)]
    if not rows:
        return []
    cells = [
        [name(row["point"]), str(row["n_cycles"]), fixed(row["x_mm"], 5), fixed(row["y_mm"], 5)]
        + [micrometres(row[column]) for column in used]
        for row in rows
    ]
    told = {"distortion": tr("distortion"), "refraction": tr("refraction"), "curvature": tr("earth curvature")}
    headers = [tr("point"), tr("readings"), "x, mm", "y, mm"]
    headers += [f"{column[:2]} {told[column[3:-3]]}, µm" for column in used]
    total = evidence.count("refine", "image_point")
    return [Table(tr("Image points and their corrections"), headers, cells, note=worst_of(len(cells), total))]
