"""OPK list, elements, residuals and points as CSV, each with `FILE-metadata.json` beside it (W3C, CSV on the Web)."""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from orient.export import Format, Made, Options
from orient.export.csv_metadata import BESIDE, Column, Table, metadata
from orient.export.elements import PARAMETERS, UNITS, covariance_rows
from orient.export.solved import Solved, project_axes, read_solved, right_handed_axes, stored_covariance
from orient.geometry.rotation import near_blind_opk, opk_by_rotation, opk_from_matrix
from orient.pipeline.tables import Array
from orient.report.csv_text import csv_pieces
from orient.report.rows import PagedRows
from orient.values import Scalar

OPK_PARAMETERS = ("X0", "Y0", "Z0", "omega", "phi", "kappa")
OPK_CONVENTION = (
    "image = M (ground - X0), M = M_kappa M_phi M_omega, M' = R_omega(X) R_phi(Y) R_kappa(Z): omega about X, phi about "
    "the turned Y, kappa about the turned Z; image x right, y up, camera looking along -z; X east, Y north, Z up"
)


def make(path: Path, form: Format, ending: str, name: str, options: Options) -> Made:
    """The table as CSV; its metadata name it, and hold the sha256 of its bytes."""
    solved = read_solved(path, form)
    table = BUILDERS[form.name](solved)
    digest = hashlib.sha256()
    for piece in _pieces(table):
        digest.update(piece)
    return Made(_pieces(table), {BESIDE: metadata(solved, table, name, digest.hexdigest())})


def _pieces(table: Table) -> Iterator[bytes]:
    names = [column.name for column in table.columns]
    return (piece.encode("utf-8") for piece in csv_pieces(names, table.rows))


def _opk(solved: Solved) -> Table:
    """One row for the photo; no covariance of the angles near their blind view."""
    is_blind = near_blind_opk(solved.rotation)
    place = np.concatenate([solved.station, np.degrees(opk_from_matrix(solved.rotation))])
    covariance = None if is_blind else _opk_covariance(solved)
    row, photo = solved.orientation, solved.photo
    sigmas: Sequence[Scalar] = [None] * 6
    packed: Sequence[Scalar] = [None] * 21
    if covariance is not None:
        in_degrees = np.sqrt(np.diag(covariance)) * np.array([1.0, 1.0, 1.0, *[180.0 / np.pi] * 3])
        sigmas, packed = in_degrees.tolist(), covariance[np.triu_indices(6)].tolist()
    earth = [row["B_S_deg"], row["L_S_deg"], row["H_S_m"]]
    values = [
        photo["name"],
        photo["image_file"],
        solved.f_mm,
        *place.tolist(),
        *sigmas,
        *earth,
        *packed,
        OPK_CONVENTION,
    ]
    return Table(_opk_columns(), [values], right_handed_axes(solved), OPK_PARAMETERS, UNITS, covariance)


def _opk_covariance(solved: Solved) -> Array:
    """(6, 6) of X0, Y0, Z0 [m], omega, phi, kappa [rad] = J C J', J from r by d(opk)/dr."""
    J = np.zeros((6, 6))
    J[:3, 3:] = np.eye(3)
    J[3:, :3] = opk_by_rotation(solved.rotation)
    return np.asarray(J @ solved.covariance @ J.T)


def _opk_columns() -> list[Column]:
    units = dict(zip(OPK_PARAMETERS, UNITS, strict=True))
    shown = [
        *((f"{name}_m", "m") for name in OPK_PARAMETERS[:3]),
        *((f"{name}_deg", "deg") for name in OPK_PARAMETERS[3:]),
    ]
    columns = [
        Column("photo", "name of the photo"),
        Column("image", "image file"),
        Column("f_mm", "focal length", "mm"),
    ]
    columns += [Column(name, "projection centre" if unit == "m" else "angle", unit) for name, unit in shown]
    columns += [Column(f"sigma_{name}", "standard deviation", unit) for name, unit in shown]
    columns += [
        Column("B_S_deg", "latitude of the projection centre; empty for local ground", "deg"),
        Column("L_S_deg", "longitude of the projection centre", "deg"),
        Column("H_S_m", "ellipsoidal height of the projection centre", "m"),
    ]
    for i, first in enumerate(OPK_PARAMETERS):
        for second in OPK_PARAMETERS[i:]:
            columns.append(Column(f"cov_{first}_{second}", "covariance", f"{units[first]} {units[second]}"))
    return [*columns, Column("convention", "what the angles mean")]


def _elements(solved: Solved) -> Table:
    """Rows of the covariance first, then every angle and what belongs to the station."""
    rows = covariance_rows(solved)
    nothing: list[Scalar] = [None] * 6
    row = solved.orientation
    for angle in solved.current.tables["resection"]["orientation_angle"]:
        name = f"{angle['triple']}_{angle['angle']}" + ("_geocentric" if angle["frame"] == "geocentric" else "")
        rows.append([name, "deg", angle["value_deg"], angle["sigma_deg"], *nothing])
    rows += [[name, "1", row[name], None, *nothing] for name in ("q_w", "q_x", "q_y", "q_z")]
    places = {"B_S_deg": "deg", "L_S_deg": "deg", "H_S_m": "m", "X_G_m": "m", "Y_G_m": "m", "Z_G_m": "m"}
    rows += [[name, unit, row[name], None, *nothing] for name, unit in places.items() if row[name] is not None]
    rows.append(["f_mm", "mm", solved.f_mm, None, *nothing])
    camera = solved.current.tables["resection"].get("camera_element", ())
    rows += [[f"camera_{one['unknown']}", one["unit"], one["value"], one["sigma"], *nothing] for one in camera]
    columns = [
        Column("element", "name; rotation_1, 2, 3: small rotation about the ground axes X, Y, Z"),
        Column("unit", "unit of value and sigma; a covariance has the product of two units"),
        Column("value", "value"),
        Column("sigma", "standard deviation; empty where none is stored"),
        *(Column(f"cov_{name}", f"covariance with {name}") for name in PARAMETERS),
    ]
    return Table(columns, rows, project_axes(solved), PARAMETERS, UNITS, stored_covariance(solved))


RESIDUALS = {
    "point": ("name of the point", ""),
    "role": ("control, check or excluded", ""),
    "x_mm": ("measured x, from the principal point", "mm"),
    "y_mm": ("measured y", "mm"),
    "vx_mm": ("computed minus measured", "mm"),
    "vy_mm": ("computed minus measured", "mm"),
    "redundancy_x": ("redundancy number; empty if not control", ""),
    "redundancy_y": ("redundancy number; empty if not control", ""),
    "depth_m": ("distance from the plane through the projection centre parallel to the image", "m"),
}


def _residuals(solved: Solved) -> Table:
    sql = (
        f"SELECT {', '.join(RESIDUALS)} FROM image_residual WHERE run_id = :resection AND point > :after ORDER BY point"
    )
    return _plain_table(solved, RESIDUALS, sql, ("resection",))


GIVEN = {
    "point": ("name of the point", ""),
    "role": ("control or check", ""),
    "weighting": ("fixed: without error; weighted", ""),
    "B_deg": ("latitude as given; empty for local ground", "deg"),
    "L_deg": ("longitude as given", "deg"),
    "H_m": ("ellipsoidal height as given", "m"),
}
PLACED = {
    "X_m": ("given, X of the project's frame", "m"),
    "Y_m": ("given, Y of the project's frame", "m"),
    "Z_m": ("given, Z of the project's frame", "m"),
    "cov_XX_m2": ("covariance of the given coordinates; empty if without error", "m2"),
    "cov_XY_m2": ("covariance", "m2"),
    "cov_XZ_m2": ("covariance", "m2"),
    "cov_YY_m2": ("covariance", "m2"),
    "cov_YZ_m2": ("covariance", "m2"),
    "cov_ZZ_m2": ("covariance", "m2"),
}
BY_RAY = {
    "dX_m": ("image ray at the height of the point minus given, X in the horizon of the point", "m"),
    "dY_m": ("image ray minus given, Y", "m"),
    "sigma_X_m": ("standard deviation of a new reading of the point on the ground", "m"),
    "sigma_Y_m": ("standard deviation", "m"),
    "ellipse_a_m": ("semi-major axis of its standard error ellipse (39 %)", "m"),
    "ellipse_b_m": ("semi-minor axis", "m"),
    "ellipse_azimuth_deg": ("direction of the semi-major axis from X towards Y", "deg"),
}


def _points(solved: Solved) -> Table:
    columns = [*(f"g.{name}" for name in GIVEN), *(f"t.{name}" for name in PLACED), *(f"c.{name}" for name in BY_RAY)]
    sql = f"""
        SELECT {", ".join(columns)} FROM geographic_point AS g
        LEFT JOIN topocentric_point AS t ON t.run_id = :topocentric AND t.point = g.point
        LEFT JOIN ground_covariance AS c ON c.run_id = :covariance AND c.point = g.point
        WHERE g.run_id = :bl AND g.point > :after ORDER BY g.point
    """
    return _plain_table(solved, GIVEN | PLACED | BY_RAY, sql, ("bl", "topocentric", "covariance"))


def _plain_table(solved: Solved, columns: Mapping[str, tuple[str, str]], sql: str, stages: Sequence[str]) -> Table:
    """A table of the project as it is; the covariance of the six elements goes beside it."""
    described = [Column(name, text, unit) for name, (text, unit) in columns.items()]
    rows = PagedRows(solved.current.path, sql, {stage: solved.current.runs[stage].run_id for stage in stages})
    return Table(described, rows, project_axes(solved), PARAMETERS, UNITS, stored_covariance(solved))


BUILDERS: Mapping[str, Callable[[Solved], Table]] = {
    "opk": _opk,
    "elements": _elements,
    "residuals": _residuals,
    "points": _points,
}
