"""The exterior orientation in every angle convention, with the full covariance matrix and correlations of each."""

from collections.abc import Sequence

import numpy as np

from orient.report.html import kinds
from orient.report.html.blocks import Block, Facts, Paragraph, Section, Table
from orient.report.html.cells import fixed, joined, micrometres
from orient.report.html.evidence import Evidence
from orient.report.html.matrices import GREEK, Matrix, matrices, matrix_of, matrix_tables
from orient.report.language import mark, tr
from orient.report.orientation import ANGLE_ORDER
from orient.units import RADIANS_PER_DEGREE, format_dms
from orient.values import Row

STATION = {"X_S": "X_S_m", "Y_S": "Y_S_m", "Z_S": "Z_S_m"}
DEFINITIONS = {
    "aok": mark("α, ω, κ (Lobanov): R = A_α(Y) A_ω(X) A_κ(Z)"),
    "opk": mark("ω, φ, κ (photogrammetric): R = R_ω(X) R_φ(Y) R_κ(Z)"),
}
AXES = {
    "ground": mark("about the axes of the ground: east, north, up of T′ (local ground: X, Y, Z)"),
    "geocentric": mark("about the geocentric axes X, Y, Z"),
}
GON_PER_DEGREE = 400.0 / 360.0
ANGLE_WORDS = frozenset({0, 1, 2})


def section(evidence: Evidence) -> Section | None:
    found, photo = evidence.one("resection", "orientation"), evidence.photo
    if found is None or photo is None:
        return None
    angles = evidence.rows("resection", "orientation_angle")
    stored = matrix_of(evidence, "rotation")
    blocks: list[Block] = [
        Paragraph(_summary(found)),
        _elements(found, angles, stored),
        Facts(tr("The same station and rotation in other systems"), _other_places(found)),
        _angles(angles),
        Paragraph(_definitions(), "note"),
    ]
    for matrix in matrices(evidence, found, photo, stored):
        blocks += matrix_tables(matrix)
    return Section("orientation", tr("Exterior orientation"), blocks)


def _summary(found: Row) -> str:
    counts = tr(
        "{n} equations, {u} unknowns, redundancy r = {r}; {control} control points, {iterations} iterations.",
        n=found["n_equations"],
        u=found["n_unknowns"],
        r=found["redundancy"],
        control=found["n_control"],
        iterations=found["iterations"],
    )
    if found["sigma0_mm"] is None:
        return joined([counts, tr("Without redundancy σ0 is unknown; covariances use its value a priori.")])
    told = tr(
        "σ0 = {found} µm a posteriori, {apriori} µm a priori; all covariances are scaled by σ0 {basis}.",
        found=micrometres(found["sigma0_mm"], 3),
        apriori=micrometres(found["sigma0_apriori_mm"], 3),
        basis=kinds.word(found["variance_basis"]),
    )
    return joined([counts, told])


def _elements(found: Row, angles: Sequence[Row], stored: Matrix) -> Table:
    sigma = dict(zip(stored.names, np.sqrt(np.diag(stored.values)), strict=True))
    cells = [[f"{name}, m", fixed(found[column], 4), fixed(float(sigma[name]), 4)] for name, column in STATION.items()]
    cells += [
        [GREEK[str(row["angle"])] + ", " + tr("deg"), fixed(row["value_deg"], 7), fixed(row["sigma_deg"], 7)]
        for row in _ordered(angles)
        if (row["triple"], row["frame"]) == ("aok", "ground")
    ]
    title = tr("Elements of the exterior orientation ({frame})", frame=kinds.frame(found["frame"]))
    return Table(title, [tr("element"), tr("value"), "σ"], cells)


def _other_places(found: Row) -> list[tuple[str, str]]:
    quaternion = ", ".join(fixed(found[name], 12) for name in ("q_w", "q_x", "q_y", "q_z"))
    pairs = [(tr("quaternion w, x, y, z (image to ground)"), quaternion)]
    if found["B_S_deg"] is None:
        return pairs
    latitude, longitude = (format_dms(float(found[name] or 0.0), 4) for name in ("B_S_deg", "L_S_deg"))
    geocentric = ", ".join(fixed(found[name], 4) for name in ("X_G_m", "Y_G_m", "Z_G_m"))
    return [
        (tr("latitude B, longitude L (degrees, minutes, seconds)"), f"{latitude}, {longitude}"),
        (tr("latitude B, longitude L, deg"), f"{fixed(found['B_S_deg'], 9)}, {fixed(found['L_S_deg'], 9)}"),
        (tr("ellipsoidal height H, m"), fixed(found["H_S_m"], 4)),
        (tr("geocentric X, Y, Z, m"), geocentric),
        *pairs,
    ]


def _ordered(rows: Sequence[Row]) -> list[Row]:
    """Ground before geocentric, aok before opk; the angles in the order in which they turn."""
    return sorted(
        rows,
        key=lambda row: (
            row["frame"] != "ground",
            str(row["triple"]),
            ANGLE_ORDER[str(row["triple"])].index(str(row["angle"])),
        ),
    )


def _angles(rows: Sequence[Row]) -> Table:
    cells = [
        [
            str(row["triple"]),
            tr("ground") if row["frame"] == "ground" else tr("geocentric"),
            GREEK[str(row["angle"])],
            fixed(row["value_deg"], 7),
            format_dms(float(row["value_deg"] or 0.0), 3),
            fixed(float(row["value_deg"] or 0.0) * GON_PER_DEGREE, 7),
            fixed(float(row["value_deg"] or 0.0) * RADIANS_PER_DEGREE, 9),
            tr("near its blind view") if row["near_blind"] else fixed(row["sigma_deg"], 7),
        ]
        for row in _ordered(rows)
    ]
    headers = [tr("triple"), tr("axes"), tr("angle"), tr("deg"), "° ′ ″", tr("gon"), tr("rad"), tr("σ, deg")]
    return Table(tr("The rotation in every angle convention"), headers, cells, ANGLE_WORDS)


def _definitions() -> str:
    triples = "; ".join(f"{name}: {tr(told)}" for name, told in DEFINITIONS.items())
    axes = "; ".join(tr(told) for told in AXES.values())
    return triples + ". " + tr("Axes: {axes}.", axes=axes)
