"""The absolute orientation of each zone solved again by scipy, from the same observations by other equations."""

from collections.abc import Mapping

import numpy as np

from orient.geometry.rotation import matrix_from_quaternion
from orient.pipeline.absolute_zone import Zone, control_errors, zones_of
from orient.pipeline.agreement import (
    BOTH_SIGMAS,
    SIGMAS,
    VALUE,
    Agreement,
    Solved,
    cofactor_gap,
    largest,
    relative,
    turned_apart,
)
from orient.pipeline.frames import Frame, frame_of
from orient.pipeline.ground import ground_of
from orient.pipeline.tables import Array, columns, number, required, single
from orient.solvers.absolute_orientation import origin_by_centre
from orient.solvers.absolute_problem import Similarity
from orient.solvers.independent_absolute import ModelObservations, solve_model_independently
from orient.solvers.independent_algebra import MINPACK
from orient.solvers.independent_resection import MAX_UNKNOWNS
from orient.solvers.packed import unpack_upper
from orient.values import Row, Settings, Tables

ROUNDING = 1e-9
"""sigma0, in metres or in standard deviations, below which it is rounding."""


def absolute_again(inputs: Mapping[str, Tables], settings: Settings, stored: Tables) -> Solved:
    """Rotation, scale, position, cofactors and sigma0 of every zone against the second engine's."""
    ground = ground_of(single(inputs["photo"], "photo"))
    frame = frame_of(single(inputs["topocentric"], "topocentric_frame"), ground)
    agreements: list[Agreement] = []
    left_out = []
    for zone in zones_of(inputs["model"], inputs["topocentric"], frame, settings):
        solved = _zone(zone, frame, settings, stored)
        agreements += solved.agreements
        left_out += [f"zone {zone.name}: {solved.left_out}"] if solved.left_out else []
    return Solved(agreements, "; ".join(left_out))


def _zone(zone: Zone, frame: Frame, settings: Settings, stored: Tables) -> Solved:
    (row,) = (row for row in stored["absolute_orientation"] if row["zone"] == zone.name)
    R, H, X0 = _elements(row, frame)
    given = _observations(zone, frame, settings, stored, Similarity(R, H, X0))
    if given.n_unknowns > MAX_UNKNOWNS:
        return Solved(left_out=f"{given.n_unknowns} unknowns are too many for a dense system ({MAX_UNKNOWNS})")
    try:
        found = solve_model_independently(given, R, H, X0)
    except np.linalg.LinAlgError:
        return Solved(left_out="the covariance of the model is singular")
    if not found.converged:
        return Solved(left_out="the second engine did not converge")
    scale = number(row, "variance_scale") or 1.0
    sigma = np.sqrt(scale * np.diag(found.Q))
    J = origin_by_centre(Similarity(found.rotation, found.H, found.centre), found.model_centre)
    gaps = {
        "rotation": (largest(turned_apart(R, found.rotation) / sigma[:3]), SIGMAS),
        "scale": (abs(float(np.log(H / found.H))) / float(sigma[3]), SIGMAS),
        "position": (largest((X0 + R @ found.model_centre / H - found.centre) / sigma[4:]), SIGMAS),
        "cofactor": (cofactor_gap(_stored_Q(zone, frame, stored), J @ found.Q @ J.T), BOTH_SIGMAS),
    }
    if row["sigma0"] is not None:
        sigma0 = (found.vPv / required(row, "redundancy")) ** 0.5
        gaps["sigma0"] = (relative(required(row, "sigma0"), sigma0, ROUNDING), VALUE)
    return Solved([Agreement(MINPACK, zone.name, name, *value) for name, value in gaps.items()])


def _elements(row: Row, frame: Frame) -> tuple[Array, float, Array]:
    """Stored R, H, X0, right-handed."""
    quaternion, X0 = columns([row], "q_w", "q_x", "q_y", "q_z")[0], columns([row], "X_0_m", "Y_0_m", "Z_0_m")[0]
    return matrix_from_quaternion(quaternion), required(row, "H"), frame.right_handed(X0)


def _observations(zone: Zone, frame: Frame, settings: Settings, stored: Tables, view: Similarity) -> ModelObservations:
    """The control that carried the zone, height-only points set on their surface where the stored result puts them."""
    rows = stored["absolute_residual"]
    carried = {row["point"] for row in rows if row["zone"] == zone.name and row["role"] == "control"}
    keep = [place for place, point in enumerate(zone.control_points) if point in carried]
    errors = control_errors(zone, settings).at(keep)
    zone = zone.of_control(keep)
    if frame.origin is not None and zone.has_height_only:
        computed = view.centre + view.t * zone.control_model @ view.rotation.T
        zone, _ = zone.on_their_height(frame.right_handed(computed), frame)
    return ModelObservations(
        zone.control_model,
        frame.right_handed(zone.control_ground),
        frame.right_handed_matrix(zone.control_known),
        frame.right_handed_matrix(errors.ground),
        errors.model,
    )


def _stored_Q(zone: Zone, frame: Frame, stored: Tables) -> Array:
    """Stored cofactors of r, H, X0, in the axes of the solver."""
    rows = [row for row in stored["absolute_cofactor"] if row["zone"] == zone.name and row["unknowns"] == "rotation"]
    turn = np.eye(7)
    turn[4:, 4:] = frame.partner
    return np.asarray(turn @ unpack_upper(np.array([required(row, "value") for row in rows])) @ turn.T)
