"""A resection's numbers as rows of the project file, in the frame of T'."""

from collections.abc import Mapping, Sequence

import numpy as np

from orient.geometry.camera import camera_equations
from orient.geometry.collinearity import project
from orient.geometry.rotation import (
    aok_by_rotation,
    aok_from_matrix,
    near_blind_aok,
    near_blind_opk,
    opk_by_rotation,
    opk_from_matrix,
    quaternion_from_matrix,
)
from orient.pipeline.camera import measured_of
from orient.pipeline.frames import Frame
from orient.pipeline.observations import Observations
from orient.pipeline.tables import COVARIANCE_PARTS, UPPER_3, Array, columns, named, named_packed_rows, or_none
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.resection import Resection
from orient.units import DEGREES_PER_RADIAN
from orient.values import Row

ANGLES_AOK = ("alpha", "omega", "kappa")
ANGLES_OPK = ("omega", "phi", "kappa")
ROTATIONS = ("rotation_1", "rotation_2", "rotation_3")
STATION = ("X_S", "Y_S", "Z_S")
QUATERNION = ("q_w", "q_x", "q_y", "q_z")
Rows = list[dict[str, str | int | float | None]]


def result_tables(
    found: Resection,
    frame: Frame,
    control: Observations,
    others: Sequence[Observations],
    sigma0: float,
    use_posteriori: bool,
    interior: CameraUnknowns | None = None,
) -> Mapping[str, Sequence[Row]]:
    """Orientation, angles, cofactors, residuals and adjusted ground points.

    `others`: check points and excluded control points, which take no part.
    """
    scale = found.vPv / found.redundancy if use_posteriori else sigma0**2
    return {
        "orientation": [_orientation_row(found, frame, sigma0, scale, use_posteriori)],
        "orientation_angle": _angle_rows(found, frame, scale),
        "cofactor": _cofactor_rows(found, frame),
        "image_residual": [
            *_control_residuals(found, control),
            *(row for points in others for row in _other_residuals(found, frame, points, interior)),
        ],
        "adjusted_point": _adjusted_rows(found, frame, control),
    }


def _orientation_row(found: Resection, frame: Frame, sigma0: float, scale: float, use_posteriori: bool) -> Row:
    station = frame.right_handed(found.station)
    return {
        "frame": frame.kind,
        **named(("X_S_m", "Y_S_m", "Z_S_m"), station),
        **named(QUATERNION, quaternion_from_matrix(found.rotation)),
        "f_mm": found.f_mm,
        **_place_on_earth(station, frame),
        "n_control": len(found.residuals),
        "n_equations": found.n_equations,
        "n_unknowns": found.n_unknowns,
        "redundancy": found.redundancy,
        "vPv": found.vPv,
        "sigma0_apriori_mm": sigma0,
        "sigma0_mm": (found.vPv / found.redundancy) ** 0.5 if found.redundancy else None,
        "variance_scale": scale,
        "variance_basis": "a posteriori" if use_posteriori else "a priori",
        "condition_ratio": found.condition_ratio,
        "iterations": len(found.iterations),
        "termination": found.termination.value,
    }


def _place_on_earth(station: Array, frame: Frame) -> dict[str, float | None]:
    keys = ("B_S_deg", "L_S_deg", "H_S_m", "X_G_m", "Y_G_m", "Z_G_m")
    if frame.origin is None:
        return dict.fromkeys(keys)
    geographic = frame.geographic(station[None, :])
    degrees = geographic[0] * [DEGREES_PER_RADIAN, DEGREES_PER_RADIAN, 1.0]
    return {**named(keys, np.concatenate([degrees, frame.geocentric(geographic)[0]]))}


def _angle_rows(found: Resection, frame: Frame, scale: float) -> Rows:
    turns = {"ground": np.eye(3)}
    if frame.origin is not None:
        turns["geocentric"] = frame.geocentric_from_right_handed()
    return [row for name, turn in turns.items() for row in _triples(found, name, turn, scale)]


def _triples(found: Resection, frame_name: str, turn: Array, scale: float) -> Rows:
    """Both triples of the rotation seen from a frame; `turn` takes the solver's axes to that frame."""
    rotation = turn @ found.rotation
    rotational = turn @ found.Q[:3, :3] @ turn.T
    systems = (
        ("aok", ANGLES_AOK, aok_from_matrix, aok_by_rotation, near_blind_aok),
        ("opk", ANGLES_OPK, opk_from_matrix, opk_by_rotation, near_blind_opk),
    )
    rows: Rows = []
    for triple, angle_names, angles_of, jacobian_of, near_blind in systems:
        blind = near_blind(rotation)
        jacobian = jacobian_of(rotation)
        sigmas = np.sqrt(scale * np.diag(jacobian @ rotational @ jacobian.T)) * DEGREES_PER_RADIAN
        for name, value, sigma in zip(angle_names, angles_of(rotation), sigmas, strict=True):
            rows.append(
                {
                    "triple": triple,
                    "frame": frame_name,
                    "angle": name,
                    "value_deg": float(value) * DEGREES_PER_RADIAN,
                    "sigma_deg": None if blind else or_none(float(sigma)),
                    "near_blind": int(blind),
                }
            )
    return rows


def _cofactor_rows(found: Resection, frame: Frame) -> Rows:
    camera = found.unknowns[6:]
    to_stored = np.eye(len(found.Q))
    to_stored[3:6, 3:6] = frame.partner
    rotation = to_stored @ found.Q @ to_stored.T
    rows = _packed_rows("rotation", (*ROTATIONS, *STATION, *camera), rotation)
    if near_blind_aok(found.rotation):
        return rows
    to_angles = np.eye(len(found.Q))
    to_angles[:3, :3] = aok_by_rotation(found.rotation)
    return rows + _packed_rows("aok", (*ANGLES_AOK, *STATION, *camera), to_angles @ rotation @ to_angles.T)


def _packed_rows(unknowns: str, unknown_names: Sequence[str], matrix: Array) -> Rows:
    return [{"unknowns": unknowns, **row} for row in named_packed_rows(matrix, unknown_names)]


def _control_residuals(found: Resection, control: Observations) -> Rows:
    return [
        {
            "point": point,
            "role": "control",
            **named(("x_mm", "y_mm"), found.measured[index]),
            **named(("vx_mm", "vy_mm"), found.residuals[index]),
            **named(("redundancy_x", "redundancy_y"), found.redundancy_numbers[index]),
            "depth_m": -float(found.zs[index]),
        }
        for index, point in enumerate(control.points)
    ]


def _other_residuals(found: Resection, frame: Frame, check: Observations, interior: CameraUnknowns | None) -> Rows:
    """Computed minus measured at check or excluded points; partly given ones cannot be compared."""
    full = [index for index, known in enumerate(check.known) if known == "XYZ"]
    if not full:
        return []
    computed, zs = project(frame.right_handed(check.ground[full]), found.station, found.rotation, found.f_mm)
    measured = check.image[full]
    residuals = computed - measured
    if interior is not None:
        rows = [check.image_rows[index] for index in full]
        moved = measured - columns(rows, "x_mm", "y_mm")
        lens = camera_equations(interior.at(found.camera), (), computed, measured_of(rows))
        measured, residuals = lens.measured + moved, lens.misclosure - moved
    return [
        {
            "point": check.points[index],
            "role": "check" if check.roles[index] == "check" else "excluded",
            **named(("x_mm", "y_mm"), measured[row]),
            **named(("vx_mm", "vy_mm"), residuals[row]),
            "redundancy_x": None,
            "redundancy_y": None,
            "depth_m": -float(zs[row]),
        }
        for row, index in enumerate(full)
    ]


def _adjusted_rows(found: Resection, frame: Frame, control: Observations) -> Rows:
    if found.iterations[-1].ground is None:
        return []
    place, cofactor = frame.right_handed(found.ground), frame.right_handed_matrix(found.ground_cofactors)
    moved = place - control.ground
    keys = [f"q_{part}" for part in COVARIANCE_PARTS]
    return [
        {
            "point": point,
            **named(("X_m", "Y_m", "Z_m"), place[index]),
            **named(("dX_m", "dY_m", "dZ_m"), moved[index]),
            **named(keys, cofactor[index][UPPER_3]),
        }
        for index, point in enumerate(control.points)
    ]
