"""The oriented photo as every export needs it: elements with covariance, camera, points, and where it comes from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orient import __version__
from orient.export import Format
from orient.geometry.camera import Camera
from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline.camera import adjusted_camera, given_camera
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import Ground, ground_of
from orient.pipeline.ground_budget import ELEMENTS, right_handed_cofactors
from orient.pipeline.interior_unknowns import image_shift, interior_unknowns
from orient.pipeline.tables import Array, columns, number, required, single
from orient.report.current import Current, read_current
from orient.report.findings import as_json
from orient.values import Row

OPTIONAL = ("readings", "control", "bl", "covariance")
EVIDENCE = (
    "comparator_reading", "cycle_residual", "control_point", "observation_test", "point_test", "external_reliability",
    "equation", "camera_equation", "iteration_parameter", "resection_start", "start_residual", "error_budget",
    "ground_covariance_image", "ground_covariance_pair", "focal_sum",
)  # fmt: skip
"""Tables with rows for every point that no export shows."""
POINTS = (
    "image_point", "geographic_point", "topocentric_point", "image_residual", "adjusted_point", "ground_covariance",
)  # fmt: skip
"""Tables of the points; a format that is streamed reads them a page at a time."""


@dataclass(frozen=True, slots=True)
class Solved:
    """The orientation in the right-handed partner of the stored frame (east, north, up, or local).

    `covariance` (6, 6): of the small rotation r [rad] about the ground axes and the projection centre [m].
    """

    current: Current
    photo: Row
    frame: Frame
    ground: Ground
    station: Array
    rotation: Array
    covariance: Array
    camera: Camera

    @property
    def orientation(self) -> Row:
        """The stored row."""
        return single(self.current.tables["resection"], "orientation")

    @property
    def f_mm(self) -> float:
        return required(self.orientation, "f_mm")


@dataclass(frozen=True, slots=True)
class SolvedPoints:
    """Points of the photo with three coordinates: where they are on the ground, and where they were measured.

    `ground` (n, 3): adjusted where the adjustment moved them, right-handed. `frame_xy` (n, 2) [mm]: measured, through
    the adjusted interior orientation; `image` (n, 2) [mm]: the same, corrected, from the principal point.
    """

    names: Sequence[str]
    roles: Sequence[str]
    ground: Array
    frame_xy: Array
    image: Array


def read_solved(path: Path, form: Format) -> Solved:
    """The current results; refused where they are missing, out of date or failed."""
    otherwise = "an export would mix versions"
    leave_out = {*EVIDENCE, *(POINTS if form.is_streamed else ())}
    current = read_current(path, form.stages, f"the export {form.name}", otherwise, OPTIONAL, leave_out)
    tables = current.tables
    photo = single(tables["photo"], "photo")
    ground = ground_of(photo)
    frame = frame_of(single(tables["topocentric"], "topocentric_frame"), ground)
    row = single(tables["resection"], "orientation")
    packed = [entry for entry in tables["resection"]["cofactor"] if entry["unknowns"] == "rotation"]
    Q = right_handed_cofactors(packed, frame)[:ELEMENTS, :ELEMENTS]
    adjusted = adjusted_camera(photo, tables["photo"], tables["resection"])
    return Solved(
        current=current,
        photo=photo,
        frame=frame,
        ground=ground,
        station=frame.right_handed(columns([row], "X_S_m", "Y_S_m", "Z_S_m")[0]),
        rotation=matrix_from_quaternion(columns([row], "q_w", "q_x", "q_y", "q_z")[0]),
        covariance=required(row, "variance_scale") * Q,
        camera=given_camera(photo, tables["photo"]) if adjusted is None else adjusted[0],
    )


def solved_points(solved: Solved) -> SolvedPoints:
    """Control, excluded and check points with a full ground position, in the order of the residuals."""
    tables = solved.current.tables
    image = {str(row["point"]): row for row in tables["refine"]["image_point"]}
    given = {str(row["point"]): row for row in tables["topocentric"]["topocentric_point"]}
    moved = {str(row["point"]): row for row in tables["resection"].get("adjusted_point", ())}
    chosen = [row for row in tables["resection"]["image_residual"] if str(row["point"]) in image]
    names = [str(row["point"]) for row in chosen]
    rows = [image[name] for name in names]
    adjusted = tables["resection"].get("adjusted_interior", ())
    interior = interior_unknowns(tables["refine"]) if adjusted else None
    comparator = columns(rows, "x_comparator_mm", "y_comparator_mm")
    shift = image_shift(interior, adjusted, comparator)
    stored = columns([moved.get(name, given[name]) for name in names], "X_m", "Y_m", "Z_m")
    return SolvedPoints(
        names=names,
        roles=[str(row["role"]) for row in chosen],
        ground=solved.frame.right_handed(stored),
        frame_xy=columns(rows, "x_frame_mm", "y_frame_mm") + shift,
        image=columns(rows, "x_mm", "y_mm") + shift,
    )


def stored_covariance(solved: Solved) -> Array:
    """(6, 6) of X_S, Y_S, Z_S [m] in the project's own frame, then of the rotation about right-handed axes [rad]."""
    turn = np.zeros((6, 6))
    turn[:3, 3:], turn[3:, :3] = solved.frame.partner, np.eye(3)
    return np.asarray(turn @ solved.covariance @ turn.T)


def provenance(solved: Solved, axes: str) -> dict[str, object]:
    """What an export comes from: photo, versions with their digests, adjustment, findings. No time of its own.

    `axes`: what X, Y, Z mean in it.
    """
    row, runs = solved.orientation, solved.current.runs
    sigma0 = number(row, "sigma0_mm")
    return {
        "made_by": f"orient {__version__}",
        "photo": str(solved.photo["name"]),
        "versions": {stage: run.version for stage, run in runs.items()},
        "output_digests": {stage: run.output_digest for stage, run in runs.items()},
        "computed_with": runs["resection"].tool_version,
        "computed_at": runs["resection"].started_at,
        "sigma0_apriori_mm": required(row, "sigma0_apriori_mm"),
        "sigma0_mm": sigma0,
        "redundancy": int(required(row, "redundancy")),
        "variance_basis": str(row["variance_basis"]),
        "findings": as_json(solved.current.findings),
        "notes": [axes, *notes(solved)],
    }


def notes(solved: Solved) -> list[str]:
    """What a reader of the numbers must know about heights and scales."""
    told = [height_in_words(solved)]
    told.append(f"Standard deviations and covariances are scaled by sigma0 {solved.orientation['variance_basis']}.")
    problems = sum(finding.is_problem for finding in solved.current.findings)
    if problems:
        told.append(f"The result has {problems} findings that put it in doubt: read them before a number is used.")
    return told


def right_handed_axes(solved: Solved) -> str:
    """X, Y, Z of formats that know right-handed systems only."""
    if solved.frame.is_local:
        swapped = " X and Y have changed places: the project's are left-handed." if solved.frame.is_left_handed else ""
        return f"X, Y, Z are the local Cartesian metres of the project, right-handed with Z up.{swapped}"
    return f"X, Y, Z are grid east, grid north, up in metres, right-handed and Cartesian, {_origin(solved)}"


def project_axes(solved: Solved) -> str:
    """X, Y, Z as the project has them."""
    turns = "rotation_1, 2, 3 turn about the right-handed axes"
    if solved.frame.is_local:
        hand = "left" if solved.frame.is_left_handed else "right"
        return f"X, Y, Z are the local Cartesian metres of the project, {hand}-handed with Z up; {turns}."
    return f"X, Y, Z are T': grid north, grid east, up; {turns} grid east, grid north, up; {_origin(solved)}"


def _origin(solved: Solved) -> str:
    origin = solved.frame.origin
    if origin is None:
        return ""
    B, L = np.degrees([origin.B, origin.L])
    return (
        f"with the origin B {B:.9f}, L {L:.9f} deg, H {origin.H:.3f} m on {solved.ground.description}; grid north lies "
        f"{np.degrees(solved.frame.gamma):+.9f} deg east of north."
    )


def height_in_words(solved: Solved) -> str:
    if solved.frame.is_local:
        return "Z is the height of the project's local system."
    return "H is the height above the ellipsoid; heights above the sea level need the geoid's height taken off."


def ground_frame(solved: Solved) -> Mapping[str, object]:
    """The right-handed frame in numbers, with the way to geocentric axes."""
    frame = solved.frame
    if frame.origin is None:
        return {"kind": "local Cartesian, right-handed"}
    origin = frame.origin
    place = frame.geocentric(np.array([[origin.B, origin.L, origin.H]]))[0]
    B, L = np.degrees([origin.B, origin.L]).tolist()
    return {
        "kind": "grid east, grid north, up",
        "ground": solved.ground.description,
        "a_m": solved.ground.figure.a_m,
        "inverse_flattening": solved.ground.figure.inverse_flattening,
        "origin_B_deg": B,
        "origin_L_deg": L,
        "origin_H_m": origin.H,
        "gamma_deg": float(np.degrees(frame.gamma)),
        "origin_geocentric_m": place.tolist(),
        "geocentric_from_ground": frame.geocentric_from_right_handed().tolist(),
    }
