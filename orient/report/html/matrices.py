"""The covariance matrix of the orientation in every angle convention, and its tables."""

import math
from collections.abc import Callable, Mapping, Sequence
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
from orient.report.html.blocks import Block, Table
from orient.report.html.cells import MISSING, digits, scientific
from orient.report.html.evidence import Evidence
from orient.report.language import tr
from orient.report.orientation import ANGLE_ORDER
from orient.solvers.packed import unpack_upper
from orient.values import Row

GREEK = {"alpha": "α", "omega": "ω", "phi": "φ", "kappa": "κ"}
ELEMENTS = 6
JACOBIANS: Mapping[str, Callable[[Array], Array]] = {"aok": aok_by_rotation, "opk": opk_by_rotation}
BLIND: Mapping[str, Callable[[Array], bool]] = {"aok": near_blind_aok, "opk": near_blind_opk}


@dataclass(frozen=True, slots=True)
class Matrix:
    """A covariance matrix (u, u) with the names and units of its parameters, in their order."""

    title: str
    names: Sequence[str]
    units: Sequence[str]
    values: Array


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


def matrices(evidence: Evidence, found: Row, photo: Row, stored: Matrix) -> list[Matrix]:
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
    return f"{covariance / product:+.4f}" if product > 0 and math.isfinite(product) else MISSING
