"""The exterior orientation in every angle convention, with the full covariance matrix and correlations of each."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from orient.geometry.rotation import (
    aok_by_rotation,
    matrix_from_quaternion,
    near_blind_aok,
    near_blind_opk,
    opk_by_rotation,
)
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.tables import Array
from orient.report.html import kinds
from orient.report.html.blocks import Block, Facts, Paragraph, Section, Table
from orient.report.html.cells import digits, fixed, joined, micrometres, scientific
from orient.report.html.evidence import Evidence
from orient.report.language import mark, tr
from orient.solvers.packed import unpack_upper
from orient.units import RADIANS_PER_DEGREE, format_dms
from orient.values import Row

GREEK = {"alpha": "α", "omega": "ω", "phi": "φ", "kappa": "κ"}
STATION = {"X_S": "X_S_m", "Y_S": "Y_S_m", "Z_S": "Z_S_m"}
ROTATION = ("rotation_1", "rotation_2", "rotation_3")
ELEMENTS = 6
ANGLE_ORDER = {"aok": ("alpha", "omega", "kappa"), "opk": ("omega", "phi", "kappa")}
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
JACOBIANS: dict[str, Callable[[Array], Array]] = {"aok": aok_by_rotation, "opk": opk_by_rotation}
BLIND: dict[str, Callable[[Array], bool]] = {"aok": near_blind_aok, "opk": near_blind_opk}


@dataclass(frozen=True, slots=True)
class Matrix:
    """A covariance matrix (u, u) with the names and units of its parameters, in their order."""

    title: str
    names: Sequence[str]
    units: Sequence[str]
    values: Array


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
    for matrix in _matrices(evidence, found, photo, stored):
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


# ---------------------------------------------------------------------------------------------- covariance


def matrix_of(evidence: Evidence, unknowns: str) -> Matrix:
    """The stored cofactors times the variance scale; the elements of the camera follow in their own units."""
    found = evidence.one("resection", "orientation")
    rows = [row for row in evidence.rows("resection", "cofactor") if row["unknowns"] == unknowns]
    scale = float(found["variance_scale"] or 0.0) if found else 0.0
    values = scale * unpack_upper(np.array([float(row["value"] or 0.0) for row in rows]))
    names = [str(row["unknown_j"]) for row in rows if row["i"] == 1]
    of_camera = {str(row["unknown"]): str(row["unit"]) for row in evidence.rows("resection", "camera_element")}
    units = ["rad" if i < 3 else of_camera.get(name, "m") for i, name in enumerate(names)]
    return Matrix("", names, units, values)


def _matrices(evidence: Evidence, found: Row, photo: Row, stored: Matrix) -> list[Matrix]:
    """One for each convention that is not near its blind view, and that of the small rotation, which always holds."""
    title = tr("small rotation about the axes east, north, up (local: X, Y, Z), then the station")
    names = ["r_E", "r_N", "r_U", *stored.names[3:]]
    matrices = [Matrix(title, names, stored.units, stored.values)]
    row = evidence.one("topocentric", "topocentric_frame")
    if row is None:
        return matrices
    frame = frame_of(row, ground_of(photo))
    turns = {"ground": np.eye(3)} if frame.origin is None else {
        "ground": np.eye(3), "geocentric": frame.geocentric_from_right_handed()
    }  # fmt: skip
    rotation = matrix_from_quaternion([float(found[name] or 0.0) for name in ("q_w", "q_x", "q_y", "q_z")])
    return matrices + [
        in_convention(stored, triple, name, turn @ rotation, turn, frame)
        for name, turn in turns.items()
        for triple in ANGLE_ORDER
        if not BLIND[triple](turn @ rotation)
    ]


def in_convention(stored: Matrix, triple: str, axes: str, rotation: Array, turn: Array, frame: Frame) -> Matrix:
    """J C J' of the small rotation's matrix; `turn` takes the right-handed ground axes to those of the convention.

    Geocentric angles come with the geocentric station, those about the ground axes with X_S, Y_S, Z_S.
    """
    J = np.eye(len(stored.values))
    J[:3, :3] = JACOBIANS[triple](rotation) @ turn
    station = list(stored.names[3:ELEMENTS])
    if axes == "geocentric":
        J[3:ELEMENTS, 3:ELEMENTS] = turn @ frame.partner
        station = ["X_G", "Y_G", "Z_G"]
    names = [*(GREEK[angle] for angle in ANGLE_ORDER[triple]), *station, *stored.names[ELEMENTS:]]
    title = triple + ", " + (tr("ground") if axes == "ground" else tr("geocentric"))
    return Matrix(title, names, stored.units, J @ stored.values @ J.T)


def matrix_tables(matrix: Matrix) -> list[Block]:
    """Covariance and correlation, with the order of the parameters and their units in the headers."""
    headers = ["", *(f"{name}, {unit}" for name, unit in zip(matrix.names, matrix.units, strict=True))]
    covariance = [[headers[i + 1], *(scientific(float(value)) for value in row)] for i, row in enumerate(matrix.values)]
    sigma = np.sqrt(np.diag(matrix.values))
    correlation = [
        [
            matrix.names[i],
            digits(float(sigma[i]), 5),
            *(_correlation(matrix.values[i, j], sigma[i] * sigma[j]) for j in range(len(sigma))),
        ]
        for i in range(len(sigma))
    ]
    order = ", ".join(headers[1:])
    note = tr("Order and units of the parameters: {order}. The unit of an element is the product of both.", order=order)
    return [
        Table(tr("Covariance matrix: {parameters}", parameters=matrix.title), headers, covariance, note=note),
        Table(
            tr("Standard deviations and correlations: {parameters}", parameters=matrix.title),
            ["", "σ", *matrix.names],
            correlation,
        ),
    ]


def _correlation(covariance: float, product: float) -> str:
    return f"{covariance / product:+.4f}" if product > 0 and math.isfinite(product) else "–"
