"""A resection solved again: by scipy with all its unknowns, its pose by OpenCV and PoseLib where they are there."""

from collections.abc import Mapping, Sequence

import numpy as np

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
from orient.pipeline.tables import Array, required, single
from orient.pipeline.verify_observations import ResectionCase, resection_observations
from orient.solvers import foreign_engines
from orient.solvers.foreign_engines import ForeignPose, can_solve, solve_by_others
from orient.solvers.independent_algebra import MINPACK
from orient.solvers.independent_resection import MAX_UNKNOWNS, ResectionObservations, solve_independently
from orient.solvers.packed import unpack_upper
from orient.values import Settings, Tables

WORSE = 1.0
"""v'Pv / sigma0^2 above the minimum from which a pose is another one, not the same found less sharply."""


def resection_again(inputs: Mapping[str, Tables], settings: Settings, stored: Tables) -> Solved:
    """Station, rotation, camera, cofactors and sigma0 against the second engine's; the pose against others'."""
    row = single(stored, "orientation")
    case = resection_observations(inputs, settings, stored)
    given = case.given
    counts = (int(required(row, "n_equations")), int(required(row, "n_unknowns")))
    if counts != (given.n_equations, given.n_unknowns):
        stated = f"n = {given.n_equations}, u = {given.n_unknowns}, stored n = {counts[0]}, u = {counts[1]}"
        return Solved(left_out=f"the second engine counts otherwise: {stated}")
    if given.n_unknowns > MAX_UNKNOWNS:
        return Solved(left_out=f"{given.n_unknowns} unknowns are too many for a dense system ({MAX_UNKNOWNS})")
    found = solve_independently(given, case.station, case.rotation, case.camera)
    if not found.converged:
        return Solved(left_out="the second engine did not converge")
    variance = required(row, "variance_scale")
    sigma = np.sqrt(variance * np.diag(found.Q))
    # what is fixed has no standard deviation: there a difference counts in metres
    units = np.where(sigma > 0, sigma, 1.0)
    gaps = {
        "station": (largest((case.station - found.station) / units[3:6]), SIGMAS),
        "rotation": (largest(turned_apart(case.rotation, found.rotation) / units[:3]), SIGMAS),
        "cofactor": (cofactor_gap(_stored_Q(stored, case), found.Q), BOTH_SIGMAS),
    }
    if given.n_camera:
        gaps["camera"] = (largest((case.camera - found.camera) / units[6:]), SIGMAS)
    if row["sigma0_mm"] is not None:
        sigma0 = (found.vPv / required(row, "redundancy")) ** 0.5
        gaps["sigma0"] = (relative(required(row, "sigma0_mm"), sigma0, _rounding(given)), VALUE)
    own = [Agreement(MINPACK, "", name, *value) for name, value in gaps.items()]
    others, remarks = _by_others(case, found.vPv, variance, units)
    return Solved([*own, *others], remarks=remarks)


def _by_others(case: ResectionCase, vPv: float, variance: float, units: Array) -> tuple[list[Agreement], Sequence[str]]:
    """Poses by other programs; one that ended in a worse place says nothing about ours, and that is said."""
    if not can_solve(case.given):
        return [], ()
    agreements, remarks = [], []
    poses = solve_by_others(case.given, case.station, case.rotation)
    if not poses:
        remarks.append("OpenCV and PoseLib could check the pose too: pip install 'orient[engines]'")
    for pose in poses:
        if _vPv(case.given, pose) > vPv + WORSE * variance:
            remarks.append(f"{pose.engine} ended in another orientation, which fits worse")
            continue
        allowed = foreign_engines.ALLOWED
        station = largest((case.station - pose.station) / units[3:6])
        rotation = largest(turned_apart(case.rotation, pose.rotation) / units[:3])
        agreements += [
            Agreement(pose.engine, "", name, gap, SIGMAS, allowed)
            for name, gap in (("station", station), ("rotation", rotation))
        ]
    return agreements, remarks


def _vPv(given: ResectionObservations, pose: ForeignPose) -> float:
    """The sum of squares that a pose leaves, with equal weights; infinite behind the camera."""
    in_camera = (given.ground - pose.station) @ pose.rotation
    if not (in_camera[:, 2] < 0).all():
        return float("inf")
    v = -given.f_mm * in_camera[:, :2] / in_camera[:, 2:] - given.image
    return float(np.sum(v**2) / given.image_cofactor[0, 0, 0])


def _stored_Q(stored: Tables, case: ResectionCase) -> Array:
    """Stored cofactors of rotation, station and camera, in the axes of the solver."""
    packed = [required(row, "value") for row in stored["cofactor"] if row["unknowns"] == "rotation"]
    turn = np.eye(case.given.n_elements)
    turn[3:6, 3:6] = case.partner
    return np.asarray(turn @ unpack_upper(np.array(packed)) @ turn.T)


def _rounding(given: ResectionObservations) -> float:
    """sigma0 that rounding of the image coordinates alone makes: the scale below which it says nothing."""
    return float(np.max(np.abs(given.image))) * 1e-9
