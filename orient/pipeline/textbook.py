"""The correction equations of one iteration of a stored resection, in named unknowns, as a page of a textbook has them.

Unknowns: the small rotation r about grid east, grid north and up, X_S, Y_S, Z_S in the stored frame, elements of the
camera, then what points share (interior orientation, sheets). Ground points that are unknown are taken out of the
equations of their two image coordinates: P* = P - P B M^+ B'P, M = D (B'PB + W) D.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orient.errors import OrientError, UsageError
from orient.geometry.rotation import aok_from_matrix, rotation_exp
from orient.pipeline.camera import unit_of
from orient.pipeline.frames import Frame
from orient.pipeline.resection import adjusted_again
from orient.pipeline.resection_blunders import Solved
from orient.pipeline.tables import Array
from orient.solvers.resection import IterationRecord
from orient.solvers.resection_problem import ImageEquations, Orientation, ResectionProblem
from orient.solvers.textbook import Group
from orient.units import wrap_half_turn
from orient.values import Row, Settings, Tables

ROTATION = ("r_E", "r_N", "r_U")
STATION = ("X_S", "Y_S", "Z_S")
SAME = 1e-9
"""Largest difference to what was stored, as part of the value: other software can differ in the last digits."""
MEANT_WEIGHT = 1e-12


@dataclass(frozen=True, slots=True)
class Page:
    """The equations of one iteration: groups of two for each point, then those of what is known beforehand.

    `before`, `after`: rotation (3, 3) and the other unknowns (u - 3,), `after` as the program went on, with all digits;
    `is_damped`: the program took another step than the whole one. `has_ground`: unknown ground points were taken out.
    """

    unknowns: Sequence[str]
    units: Sequence[str]
    points: Sequence[str]
    groups: Sequence[Group]
    priors: Sequence[str]
    prior_groups: Sequence[Group]
    rotation: Array
    values: Array
    rotation_after: Array
    values_after: Array
    vPv: float
    damping: float
    has_ground: bool


def page(inputs: Mapping[str, Tables], settings: Settings, stored: Tables, iteration: int) -> Page:
    """Iteration `iteration` (from 1) of the resection whose tables are `stored`, computed again and compared with them.

    UsageError if there is no such iteration; OrientError if this software does not come to the stored numbers.
    """
    count = len(stored.get("iteration", ()))
    if not 1 <= iteration <= count:
        told = f"there are 1 ... {count}" if count else "this version has none"
        raise UsageError(f"there is no iteration {iteration}", f"{told[0].upper()}{told[1:]}.")
    solved, frame = adjusted_again(inputs, settings)
    records = solved.found.iterations
    if len(records) != count:
        raise _other_numbers()
    record = records[iteration - 1]
    _compare(record, frame, stored["iteration_parameter"], iteration)
    return _page(solved, frame, record)


def _other_numbers() -> OrientError:
    return OrientError(
        "this software does not come to the stored iterations", "See how far they differ: orient verify PROJECT"
    )


def _compare(record: IterationRecord, frame: Frame, rows: Sequence[Row], iteration: int) -> None:
    """The six elements before and after, against the stored rows."""
    found = {str(row["unknown"]): row for row in rows if row["iteration"] == iteration and row["point"] == ""}
    angles = aok_from_matrix(record.rotation)
    turned = aok_from_matrix(rotation_exp(record.correction_rotation) @ record.rotation)
    steps = [wrap_half_turn(float(new - old)) for old, new in zip(angles, turned, strict=True)]
    station, step = frame.right_handed(record.station), frame.right_handed(record.correction_station)
    names = ("alpha", "omega", "kappa", *STATION)
    for name, value, change in zip(names, [*angles, *station], [*steps, *step], strict=True):
        scale = max(abs(float(value)), 1.0)
        for ours, key in ((value, "approximation"), (change, "correction")):
            if abs(float(ours) - float(found[name][key] or 0.0)) > SAME * scale:
                raise _other_numbers()


def _page(solved: Solved, frame: Frame, record: IterationRecord) -> Page:
    problem = _problem_of(solved, record)
    state = _state(problem, solved, record)
    image = problem.image_equations(state)
    weights = np.asarray(np.linalg.inv(problem.image_cofactor), dtype=np.float64)
    by_common = _by_common(problem, image)
    design = np.concatenate([_in_stored_frame(problem, image.by_elements, frame), by_common], axis=2)
    free_term, reduced, has_ground = _without_ground(problem, state, image, weights)
    groups = [Group(design[i], free_term[i], reduced[i]) for i in range(len(design))]
    priors, prior_groups = _priors(problem, state, solved, frame)
    camera = () if problem.interior is None else problem.interior.names
    units = [unit_of(name, problem.interior.camera) for name in camera] if problem.interior is not None else []
    common = solved.chain.unknowns
    shift = np.array([one.value for one in common])
    free = [i for i in problem.free.tolist() if i >= 3]
    values = np.concatenate([frame.right_handed(record.station), record.camera[: len(camera)]])
    steps = np.concatenate([frame.right_handed(record.correction_station), record.correction_camera[: len(camera)]])
    chosen = [i - 3 for i in free]
    names = [*STATION, *camera]
    before = np.concatenate([values[chosen], shift + record.common])
    return Page(
        unknowns=[*ROTATION, *(names[i] for i in chosen), *(one.name for one in common)],
        units=["rad"] * 3 + [["m", "m", "m", *units][i] for i in chosen] + [one.unit for one in common],
        points=solved.control.points,
        groups=groups,
        priors=priors,
        prior_groups=prior_groups,
        rotation=record.rotation,
        values=before,
        rotation_after=rotation_exp(record.correction_rotation) @ record.rotation,
        values_after=before + np.concatenate([steps[chosen], record.correction_common]),
        vPv=record.vPv,
        damping=record.damping,
        has_ground=has_ground,
    )


def _problem_of(solved: Solved, record: IterationRecord) -> ResectionProblem:
    """The adjustment as it was in this iteration: the camera keeps its given values until it is released."""
    problem = solved.found.problem
    if problem.interior is None or record.correction_camera.any():
        return problem
    return replace(problem, interior=problem.interior.without())


def _state(problem: ResectionProblem, solved: Solved, record: IterationRecord) -> Orientation:
    """The approximations about the solver's origin of the ground."""
    origin = solved.found.ground - solved.found.state.ground
    ground = problem.known.given if record.ground is None else record.ground - origin
    camera = record.camera if problem.interior is not None and problem.interior.names else record.camera[:0]
    z = problem.common.inverse @ record.common
    return Orientation(record.rotation, record.station - origin[0], ground, z, camera)


def _by_common(problem: ResectionProblem, image: ImageEquations) -> Array:
    """(n, 2, k): by the named common unknowns c = F z; they must be determined one by one by their own covariance."""
    k, q = problem.common.factor.shape
    if q < k:
        raise OrientError(
            "the common unknowns of this adjustment depend on each other: a page cannot name them one by one",
            "Take them as known: orient resection PROJECT --interior fixed --correlation point",
        )
    by_z = image.by_ground @ problem.common.by_ground - problem.common.by_image
    return np.asarray(by_z @ problem.common.inverse)


def _in_stored_frame(problem: ResectionProblem, by_elements: Array, frame: Frame) -> Array:
    """The columns of X_S, Y_S, Z_S in the order of the stored frame."""
    if problem.is_station_fixed:
        return by_elements
    turned = by_elements.copy()
    turned[:, :, 3:6] = frame.right_handed(by_elements[:, :, 3:6])
    return turned


def _without_ground(
    problem: ResectionProblem, state: Orientation, image: ImageEquations, weights: Array
) -> tuple[Array, Array, bool]:
    """l* (n, 2), P* (n, 2, 2): the same normal equations without the unknown ground points.

    P* = P - P B M^+ B'P and P* l* = P l - P B M^+ (B'P l + W t), t = adjusted minus given.
    """
    known = problem.known
    if not len(known.unknown):
        return image.free_term, weights, False
    D, W = known.free, known.weight_root.transpose(0, 2, 1) @ known.weight_root
    shift = state.ground - known.given - problem.common.shift(state.common)
    B = image.by_ground
    PB = weights @ B
    M = np.linalg.pinv(D @ (B.transpose(0, 2, 1) @ PB + W) @ D, rcond=MEANT_WEIGHT, hermitian=True)
    reduced = weights - PB @ M @ PB.transpose(0, 2, 1)
    right = (weights @ image.free_term[:, :, None]) - PB @ M @ (
        PB.transpose(0, 2, 1) @ image.free_term[:, :, None] + W @ shift[:, :, None]
    )
    reduced = 0.5 * (reduced + reduced.transpose(0, 2, 1))
    free_term = np.linalg.pinv(reduced, rcond=MEANT_WEIGHT, hermitian=True) @ right
    return free_term[:, :, 0], reduced, True


def _priors(
    problem: ResectionProblem, state: Orientation, solved: Solved, frame: Frame
) -> tuple[list[str], list[Group]]:
    """What is known of camera, station and angles (each with p = 1 after division by its sigma), and of c."""
    design, free_term = problem.known_equations(state)
    k = problem.common.factor.shape[0]
    u = design.shape[1]
    if not problem.is_station_fixed:
        design = design.copy()
        design[:, 3:6] = frame.right_handed(design[:, 3:6])
    groups = [
        Group(np.concatenate([row, np.zeros(k)])[None, :], np.array([value]), np.eye(1))
        for row, value in zip(design, free_term, strict=True)
    ]
    names = [f"{name} known" for name in _known_names(problem)]
    if k:
        inverse = problem.common.inverse
        c = problem.common.factor @ state.common
        rows = np.concatenate([np.zeros((k, u)), np.eye(k)], axis=1)
        groups.append(Group(rows, c, inverse.T @ inverse))
        names += [f"{one.subject} {one.name}" for one in solved.chain.unknowns]
    return names, groups


def _known_names(problem: ResectionProblem) -> list[str]:
    interior = problem.interior
    of_camera = [] if interior is None else [interior.names[i] for i in interior.observed]
    return [*of_camera, *(one.name for one in problem.observed)]
