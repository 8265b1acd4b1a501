"""A resection's numbers as rows of the project file, in the frame of T'."""

from collections.abc import Mapping, Sequence
from typing import Any

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
from orient.pipeline.tables import (
    COVARIANCE_PARTS,
    UPPER_3,
    Array,
    by_names,
    columns,
    joined,
    named,
    named_packed_rows,
    nullable,
    or_none,
    rows_at,
)
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.resection import Resection
from orient.units import DEGREES_PER_RADIAN
from orient.values import Columns, Row

ANGLES_AOK = ("alpha", "omega", "kappa")
ANGLES_OPK = ("omega", "phi", "kappa")
ROTATIONS = ("rotation_1", "rotation_2", "rotation_3")
STATION = ("X_S", "Y_S", "Z_S")
QUATERNION = ("q_w", "q_x", "q_y", "q_z")
Rows = list[dict[str, str | int | float | None]]
Table = dict[str, Any]
"""A table by column."""


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
        "image_residual": joined(
            [
                _control_residuals(found, control),
                *(_other_residuals(found, frame, points, interior) for points in others),
            ]
        ),
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


def _control_residuals(found: Resection, control: Observations) -> Table:
    return {
        "point": list(control.points),
        "role": ["control"] * len(control.points),
        **by_names(("x_mm", "y_mm"), found.measured),
        **by_names(("vx_mm", "vy_mm"), found.residuals),
        **by_names(("redundancy_x", "redundancy_y"), found.redundancy_numbers),
        "depth_m": -found.zs,
    }


def _other_residuals(found: Resection, frame: Frame, check: Observations, interior: CameraUnknowns | None) -> Table:
    """Computed minus measured at check or excluded points; partly given ones cannot be compared."""
    full = np.flatnonzero(check.known == "XYZ").tolist()
    computed, zs = project(frame.right_handed(check.ground[full]), found.station, found.rotation, found.f_mm)
    measured = check.image[full]
    residuals = computed - measured
    if interior is not None:
        rows = rows_at(check.image_rows, full)
        moved = measured - columns(rows, "x_mm", "y_mm")
        lens = camera_equations(interior.at(found.camera), (), computed, measured_of(rows))
        measured, residuals = lens.measured + moved, lens.misclosure - moved
    return {
        "point": [check.points[index] for index in full],
        "role": ["check" if check.roles[index] == "check" else "excluded" for index in full],
        **by_names(("x_mm", "y_mm"), measured),
        **by_names(("vx_mm", "vy_mm"), residuals),
        **by_names(("redundancy_x", "redundancy_y"), nullable(np.full_like(residuals, np.nan))),
        "depth_m": -zs,
    }


def _adjusted_rows(found: Resection, frame: Frame, control: Observations) -> Sequence[Row]:
    if found.iterations[-1].ground is None:
        return []
    place, cofactor = frame.right_handed(found.ground), frame.right_handed_matrix(found.ground_cofactors)
    moved = place - control.ground
    keys = [f"q_{part}" for part in COVARIANCE_PARTS]
    return Columns(
        {
            "point": list(control.points),
            **by_names(("X_m", "Y_m", "Z_m"), place),
            **by_names(("dX_m", "dY_m", "dZ_m"), moved),
            **by_names(keys, cofactor[:, UPPER_3[0], UPPER_3[1]]),
        }
    )
