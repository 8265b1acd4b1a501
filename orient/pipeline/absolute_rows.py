"""An absolute orientation's numbers as rows of the project file, in the frame of T'."""

from collections.abc import Mapping, Sequence

import numpy as np

from orient.geometry.rotation import quaternion_from_matrix
from orient.geometry.similarity import fixed_axes_from_matrix
from orient.pipeline.absolute_equations import equation_rows
from orient.pipeline.absolute_zone import Errors, Zone, known_directions
from orient.pipeline.frames import Frame
from orient.pipeline.tables import Array, columns, covariance_columns, named, named_packed_rows, or_none
from orient.solvers.absolute_points import ground_points
from orient.solvers.absolute_result import AbsoluteIteration, AbsoluteOrientation
from orient.solvers.absolute_small_angles import SMALL_ANGLE_ELEMENTS, SmallAngleOrientation
from orient.solvers.absolute_views import ElementView, element_view
from orient.units import DEGREES_PER_RADIAN, wrap_half_turn
from orient.values import Row

UP = ("up_X", "up_Y", "up_Z")
QUATERNION = ("q_w", "q_x", "q_y", "q_z")
ANGLE_NAMES = ("xi", "eta", "theta")
UNITS = {"H": "model/m", "t": "m/model", "T_X": "model", "T_Y": "model", "T_Z": "model"}
ELEMENT_VIEWS = ("homothety", "joint", "scale")
COFACTOR_VIEWS = ("rotation", *ELEMENT_VIEWS)
Rows = list[dict[str, str | int | float | None]]


def trace_tables(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> Mapping[str, Sequence[Row]]:
    """Iterations: stored for a failure too."""
    return {
        "absolute_iteration": [_iteration_row(zone, number, it) for number, it in enumerate(found.iterations, 1)],
        "absolute_iteration_parameter": [
            row for number, it in enumerate(found.iterations, 1) for row in _parameter_rows(zone, number, it, frame)
        ],
    }


def result_tables(
    zone: Zone, found: AbsoluteOrientation, frame: Frame, errors: Errors, use_posteriori: bool
) -> Mapping[str, Sequence[Row]]:
    """Everything of one zone as the adjustment saw it: the control that took part, heights on their surface."""
    # with unit weights nothing is known of sigma0 beforehand: without redundancy there are no standard deviations
    scale = found.vPv / found.redundancy if use_posteriori else (1.0 if errors.unit == "1" else None)
    views = {name: _stored(element_view(found, name), frame) for name in COFACTOR_VIEWS}
    return {
        "absolute_orientation": [_orientation_row(zone, found, frame, errors, scale, use_posteriori)],
        "absolute_element": [row for name in ELEMENT_VIEWS for row in _element_rows(zone, name, views[name], scale)],
        "absolute_cofactor": [row for name in COFACTOR_VIEWS for row in _cofactor_rows(zone, name, views[name])],
        "absolute_equation": equation_rows(zone, found, frame),
        "absolute_residual": [*_control_residuals(zone, found, frame), *_other_residuals(zone, found, frame)],
        "absolute_alternative": _alternative_rows(zone, found, frame),
        "model_ground_point": _ground_rows(zone, found, frame, scale),
    }


def small_angle_rows(zone: Zone, small: SmallAngleOrientation, frame: Frame) -> Rows:
    """The elements of (111), the rigorous ones and their difference."""
    elements, rigorous = _swapped(small.elements, frame, 0), _swapped(small.rigorous, frame, 0)
    return [
        {
            "zone": zone.name,
            "unknown": name,
            "unit": _unit(name),
            "value": float(value) * _factor(name),
            "rigorous": float(right) * _factor(name),
            "difference": float(value - right) * _factor(name),
        }
        for name, value, right in zip(SMALL_ANGLE_ELEMENTS, elements, rigorous, strict=True)
    ]


def _orientation_row(
    zone: Zone, found: AbsoluteOrientation, frame: Frame, errors: Errors, scale: float | None, use_posteriori: bool
) -> Row:
    words = zone.known_words
    return {
        "zone": zone.name,
        "frame": frame.kind,
        **named(("X_0_m", "Y_0_m", "Z_0_m"), frame.right_handed(found.X0)),
        "H": found.H,
        "t": found.t,
        **named(QUATERNION, quaternion_from_matrix(found.rotation)),
        "n_full": words.count("XYZ"),
        "n_plan": words.count("plan"),
        "n_height": words.count("height"),
        "n_equations": found.n_equations,
        "n_unknowns": found.n_unknowns,
        "redundancy": found.redundancy,
        "vPv": found.vPv,
        "vPv_mirrored": or_none(found.vPv_mirrored),
        "sigma0": found.sigma0,
        "sigma0_unit": errors.unit,
        "variance_scale": scale,
        "variance_basis": "a posteriori" if use_posteriori else ("a priori" if scale is not None else "unknown"),
        "condition_ratio": found.condition_ratio,
        "iterations": len(found.iterations),
        "termination": found.termination.value,
    }


def _stored(view: ElementView, frame: Frame) -> ElementView:
    """A view with the translation in the axes of the stored frame."""
    at = 0 if view.names[0] == "X_0" else 4
    P = np.eye(7)
    P[at : at + 3, at : at + 3] = frame.partner
    return ElementView(view.names, _swapped(view.values, frame, at), np.asarray(P @ view.Q @ P.T), view.near_blind)


def _swapped(values: Array, frame: Frame, at: int) -> Array:
    """Values with the three numbers from `at` on in the axes of the stored frame."""
    return np.concatenate([values[:at], frame.right_handed(values[at : at + 3]), values[at + 3 :]])


def _element_rows(zone: Zone, name: str, view: ElementView, scale: float | None) -> Rows:
    sigmas = np.full(7, np.nan) if scale is None else view.standard_deviations(scale)
    return [
        {
            "zone": zone.name,
            "view": name,
            "unknown": unknown,
            "unit": _unit(unknown),
            "value": float(value) * _factor(unknown),
            "sigma": None if view.near_blind and unknown in ANGLE_NAMES else or_none(float(sigma) * _factor(unknown)),
            "near_blind": int(view.near_blind),
        }
        for unknown, value, sigma in zip(view.names, view.values, sigmas, strict=True)
    ]


def _unit(unknown: str) -> str:
    return "deg" if unknown in ANGLE_NAMES else UNITS.get(unknown, "m")


def _factor(unknown: str) -> float:
    return DEGREES_PER_RADIAN if unknown in ANGLE_NAMES else 1.0


def _cofactor_rows(zone: Zone, name: str, view: ElementView) -> Rows:
    """Packed by the papers' index IJ; no rows for a view in its blind position."""
    if view.near_blind:
        return []
    head = {"zone": zone.name, "unknowns": name}
    return [{**head, **row} for row in named_packed_rows(view.Q, view.names)]


def _iteration_row(zone: Zone, number: int, record: AbsoluteIteration) -> Row:
    return {
        "zone": zone.name,
        "iteration": number,
        "vPv": float(record.vPv),
        "max_scaled_step": float(record.max_scaled_step),
        "damping": float(record.damping),
        **named(QUATERNION, quaternion_from_matrix(record.rotation)),
    }


def _parameter_rows(zone: Zone, number: int, record: AbsoluteIteration, frame: Frame) -> Rows:
    """Approximation and correction of xi, eta, theta, H, X_0, Y_0, Z_0 (seed 000)."""
    before, after = fixed_axes_from_matrix(record.rotation), fixed_axes_from_matrix(record.following_rotation)
    steps = [wrap_half_turn(float(new - old)) for old, new in zip(before, after, strict=True)]
    values = [*before, record.H, *frame.right_handed(record.X0)]
    corrections = [*steps, record.correction_H, *frame.right_handed(record.correction_X0)]
    unknowns = (*ANGLE_NAMES, "H", "X_0", "Y_0", "Z_0")
    return [
        {
            "zone": zone.name,
            "iteration": number,
            "unknown": unknown,
            "unit": "rad" if unknown in ANGLE_NAMES else _unit(unknown),
            "approximation": float(value),
            "correction": float(correction),
        }
        for unknown, value, correction in zip(unknowns, values, corrections, strict=True)
    ]


def _control_residuals(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> Rows:
    gaps, of_ground = frame.right_handed(found.residuals), frame.right_handed(found.ground_residuals)
    redundancy = found.redundancy_numbers @ np.abs(frame.partner)
    known = zone.known_words
    return [
        {
            "zone": zone.name,
            "point": point,
            "role": "control",
            "known": known[row],
            **_by_known(("vX_m", "vY_m", "vZ_m"), gaps[row], known[row], zone.control_up[row]),
            **_by_known(("v_ground_X_m", "v_ground_Y_m", "v_ground_Z_m"), of_ground[row], "XYZ", zone.control_up[row]),
            **named(("v_model_x", "v_model_y", "v_model_z"), found.model_residuals[row]),
            **_redundancy(redundancy[row], known[row]),
        }
        for row, point in enumerate(zone.control_points)
    ]


def _other_residuals(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> Rows:
    """Computed minus given at the check points and those left out, in the coordinates that were given."""
    roles = {index: zone.role(index) for index in range(len(zone.rows))}
    check = [
        (index, row) for index, row in enumerate(zone.rows) if row is not None and roles[index] in ("check", "excluded")
    ]
    if not check:
        return []
    given, up = columns([row for _, row in check], "X_m", "Y_m", "Z_m"), columns([r for _, r in check], *UP)
    known = [str(row["known"]) for _, row in check]
    computed = frame.right_handed(ground_points(found, zone.model[[index for index, _ in check]])[0])
    gaps = known_directions(known, up) @ (computed - given)[:, :, None]
    empty = ("v_ground_X_m", "v_ground_Y_m", "v_ground_Z_m", "v_model_x", "v_model_y", "v_model_z")
    return [
        {
            "zone": zone.name,
            "point": zone.points[index],
            "role": roles[index],
            "known": known[row],
            **_by_known(("vX_m", "vY_m", "vZ_m"), gaps[row, :, 0], known[row], up[row]),
            **dict.fromkeys((*empty, "redundancy_X", "redundancy_Y", "redundancy_Z")),
        }
        for row, (index, _) in enumerate(check)
    ]


def _by_known(keys: Sequence[str], values: Array, known: str, up: Array) -> dict[str, float | None]:
    """X, Y of a plan-only point; of a height-only point the part along its own vertical."""
    x, y, z = (float(value) for value in values)
    parts = {"plan": (x, y, None), "height": (None, None, float(values @ up))}.get(known, (x, y, z))
    return dict(zip(keys, parts, strict=True))


def _redundancy(numbers: Array, known: str) -> dict[str, float | None]:
    x, y, z = (float(value) for value in numbers)
    parts = {"plan": (x, y, None), "height": (None, None, x + y + z)}.get(known, (x, y, z))
    return dict(zip(("redundancy_X", "redundancy_Y", "redundancy_Z"), parts, strict=True))


def _alternative_rows(zone: Zone, found: AbsoluteOrientation, frame: Frame) -> Rows:
    return [
        {
            "zone": zone.name,
            "number": number,
            **named(("X_0_m", "Y_0_m", "Z_0_m"), frame.right_handed(other.X0)),
            "H": other.H,
            **named(QUATERNION, quaternion_from_matrix(other.rotation)),
            "tilt_deg": float(np.arccos(np.clip(other.rotation[2, 2], -1.0, 1.0))) * DEGREES_PER_RADIAN,
            "vPv": other.vPv,
            "is_as_good": int(other.is_as_good),
        }
        for number, other in enumerate(found.alternatives, 1)
    ]


def _ground_rows(zone: Zone, found: AbsoluteOrientation, frame: Frame, scale: float | None) -> Rows:
    """All points of the zone on the ground, with the covariance of the elements and of their own model coordinates."""
    place = {index: number for number, index in enumerate(zone.control)}
    number_of = [place.get(index) for index in range(len(zone.points))]
    ground, Q = ground_points(found, zone.model, zone.model_covariance, number_of)
    stored, cofactors = frame.right_handed(ground), frame.right_handed_matrix(Q)
    degrees = np.full_like(stored, np.nan)
    if frame.origin is not None:
        degrees = frame.geographic(stored) * [DEGREES_PER_RADIAN, DEGREES_PER_RADIAN, 1.0]
    return [
        {
            "zone": zone.name,
            "point": point,
            "role": zone.role(index),
            **named(("X_m", "Y_m", "Z_m"), stored[index]),
            **{key: or_none(value) for key, value in named(("B_deg", "L_deg", "H_m"), degrees[index]).items()},
            **covariance_columns(None if scale is None else scale * cofactors[index]),
        }
        for index, point in enumerate(zone.points)
    ]
