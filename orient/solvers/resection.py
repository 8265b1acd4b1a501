"""x = -f xs/zs, y = -f ys/zs, (xs, ys, zs) = R'(P - S): the exterior orientation R, S of one photo from control."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry.collinearity import image_ray, partials_aok, project
from orient.solvers import functional_iteration
from orient.solvers.functional_iteration import Iterated, Step, Termination
from orient.solvers.ground_points import ground_knowledge, onto_rays, undetermined_points
from orient.solvers.resection_checks import check_control
from orient.solvers.resection_problem import ELEMENTS, Orientation, ResectionEquations, ResectionProblem
from orient.solvers.start_values import Candidate, distinct, start_candidates

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Refined = Iterated[Orientation, ResectionEquations]

SAME_SOLUTION = 1e-5
NEARLY_AS_GOOD = 4.0
FAR_BETTER = 100.0
NO_HEIGHT, WEAK_HEIGHT = 1e-12, 1e-6
"""Singular value ratios of a point's own unknowns: none at all; enough to spoil an adjustment that did not converge."""
READING_SHARE = 1e-4
ROUNDING_SHARE = 1e-10

MESSAGES = {
    Termination.CONVERGED: "The resection converged.",
    Termination.MAX_ITERATIONS: "The resection did not converge within the allowed iterations.",
    Termination.SINGULAR: "The control does not determine the orientation.",
    Termination.DIVERGED: "The resection diverged.",
    Termination.NO_DESCENT: "The resection found no step that lowers v'Pv.",
    Termination.NOT_FINITE: "The resection met numbers that are not finite.",
    Termination.BEHIND_CAMERA: "The orientation that fits has control points behind the camera; are axes exchanged?",
    Termination.BELOW_GROUND: "The orientation that fits has the camera below the ground; are axes exchanged?",
}


@dataclass(frozen=True, slots=True)
class IterationRecord:
    """Approximations and corrections of one iteration; `ground` and its corrections (n, 3), None if all fixed."""

    rotation: FloatArray
    station: FloatArray
    ground: FloatArray | None
    correction_rotation: FloatArray
    correction_station: FloatArray
    correction_ground: FloatArray | None
    vPv: float
    max_scaled_step: float
    damping: float


@dataclass(frozen=True, slots=True)
class Alternative:
    """Another orientation in which the adjustment converged with all points in front; `is_as_good`: by v'Pv alone."""

    rotation: FloatArray
    station: FloatArray
    vPv: float
    is_as_good: bool


@dataclass(frozen=True, slots=True)
class Resection:
    """The adjusted exterior orientation with its whole proof; a result only if `termination` is CONVERGED.

    Q (6, 6): cofactors of r_X, r_Y, r_Z [rad], X_S, Y_S, Z_S [m]; v = computed - measured [mm]; `equations` (n, 2, 9):
    partials by alpha, omega, kappa, X_S, Y_S, Z_S, X, Y, Z at the solution. NaN in Q and the redundancy numbers when
    the geometry is singular, `undetermined` then names the combination of unknowns.
    """

    termination: Termination
    message: str
    rotation: FloatArray
    station: FloatArray
    f_mm: float
    vPv: float
    n_equations: int
    n_unknowns: int
    redundancy: int
    residuals: FloatArray
    computed: FloatArray
    zs: FloatArray
    Q: FloatArray
    equations: FloatArray
    free_terms: FloatArray
    redundancy_numbers: FloatArray
    ground_redundancy: FloatArray
    condition_ratio: float
    iterations: tuple[IterationRecord, ...]
    ground: FloatArray
    ground_cofactors: FloatArray
    undetermined: str
    weak: tuple[tuple[str, str, float], ...]
    alternatives: tuple[Alternative, ...]
    candidates_tried: int

    @property
    def is_ambiguous(self) -> bool:
        """Does another orientation fit as well? Always asked for three points, which leave up to four."""
        return any(alternative.is_as_good for alternative in self.alternatives)


@dataclass(frozen=True, slots=True)
class _Task:
    """The problem about the centroid of the ground, so that large coordinates keep their digits."""

    problem: ResectionProblem
    origin: FloatArray
    full: BoolArray
    camera_above: FloatArray | None
    names: Sequence[str]
    tolerance: float
    max_iterations: int

    @property
    def n_equations(self) -> int:
        return 2 * len(self.problem.image) + int(self.problem.known.weight_rank.sum())

    @property
    def n_unknowns(self) -> int:
        return 6 + int(self.problem.known.free_rank.sum())

    @property
    def redundancy(self) -> int:
        return self.n_equations - self.n_unknowns

    @property
    def reading_noise(self) -> float:
        """v'Pv of reading errors of f / 10 000, which no judgement of a fit should be finer than."""
        weights = 1 / np.diagonal(self.problem.image_cofactor, axis1=1, axis2=2)
        return float(np.sum(weights)) * (READING_SHARE * self.problem.f_mm) ** 2


def resect(
    image: FloatArray,
    image_cofactor: FloatArray,
    ground: FloatArray,
    f_mm: float,
    *,
    ground_free: FloatArray | None = None,
    ground_weight: FloatArray | None = None,
    start_mask: BoolArray | None = None,
    approximate_station: FloatArray | None = None,
    camera_above: FloatArray | None = None,
    names: Sequence[str] | None = None,
    tolerance: float = 1e-10,
    max_iterations: int = 50,
) -> Resection:
    """v = B_e de + B_p dP + L, v_P = dP + t, v'Pv -> min: exterior orientation R, S from control points.

    `image` (n, 2) [mm] refined, principal point at 0; `image_cofactor` (n, 2, 2) = covariance / sigma0^2; `ground`
    (n, 3) [m], right-handed; `ground_free` D (n, 3, 3): projector onto the unknown directions of each point (zeros:
    errorless; identity: weighted; up up': height unknown; I - up up': plan unknown); `ground_weight` W (n, 3, 3):
    inverse covariance times sigma0^2 of the given coordinates, zero in directions of which nothing is known.
    `start_mask` (n,): points with three known coordinates, by default those whose D has no part without weight.
    `camera_above` (3,): up vector; the camera must then be above the mean ground. `names` only serve the messages.

    No approximations are needed: every exact three-point resection of spread triples is a start, the best distinct
    ones are refined, and the valid one (converged, all points in front, camera above) with the smallest v'Pv is the
    result; `approximate_station` picks among those that fit equally well. The other valid ones are `alternatives`.
    Without a valid one the best is returned with its termination. Control that cannot determine a photo at all
    (fewer than three full points, points on a line, coinciding points) raises GeometryError.
    r = 2n + rank W - 6 - rank D. Source: seed 004, equations (3)-(5) corrected, with ground observations.
    """
    names = names or [str(i + 1) for i in range(len(image))]
    known = ground_knowledge(ground, ground_free, ground_weight)
    full = known.free_rank == known.weight_rank
    full = full if start_mask is None else full & start_mask
    check_control(image, image_cofactor, known, full, names)
    origin = ground.mean(axis=0)
    problem = ResectionProblem(image, image_cofactor, replace(known, given=ground - origin), f_mm)
    task = _Task(problem, origin, full, camera_above, names, tolerance, max_iterations)
    near = None if approximate_station is None else approximate_station - origin
    starts = start_candidates(image[full], problem.known.given[full], f_mm, near)
    if not starts:
        raise GeometryError(
            "No three control points give a start: every triangle is nearly a line.",
            "Measure control points that are spread over the photo.",
        )
    refined = [_refined(task, candidate) for candidate in _worth_refining(task, starts)]
    best, alternatives = _choose(task, refined, near)
    return _result(task, best, alternatives, len(starts))


def _worth_refining(task: _Task, starts: Sequence[Candidate]) -> list[Candidate]:
    """The best distinct starts; two with points behind the camera too, to tell wrong axes from a bad fit."""
    ground = task.problem.known.given
    in_front = [start for start in starts if start.all_in_front]
    behind = sorted((start for start in starts if not start.all_in_front), key=lambda start: start.rms_mm)
    return distinct(in_front, ground) + distinct(behind, ground, limit=2)


def _refined(task: _Task, candidate: Candidate) -> tuple[Refined, Termination]:
    """The adjustment from one start, and how it ends when the camera's place is judged too."""
    problem = task.problem
    rays = image_ray(problem.image, candidate.rotation, problem.f_mm)
    ground = onto_rays(problem.known, ~task.full, candidate.station, rays)
    start = Orientation(candidate.rotation, candidate.station, ground)
    iterated = functional_iteration.iterate(
        problem, start, tolerance=task.tolerance, max_iterations=task.max_iterations
    )
    return iterated, _termination(task, iterated)


def _termination(task: _Task, iterated: Refined) -> Termination:
    state, converged = iterated.state, iterated.termination is Termination.CONVERGED
    if len(undetermined_points(iterated.linear.points, task.problem.known, NO_HEIGHT if converged else WEAK_HEIGHT)):
        return Termination.SINGULAR
    if not converged:
        return iterated.termination
    if np.any(project(state.ground, state.station, state.rotation, task.problem.f_mm)[1] >= 0):
        return Termination.BEHIND_CAMERA
    if task.camera_above is not None and task.camera_above @ (state.station - state.ground.mean(axis=0)) <= 0:
        return Termination.BELOW_GROUND
    return Termination.CONVERGED


def _choose(
    task: _Task, refined: Sequence[tuple[Refined, Termination]], near: FloatArray | None
) -> tuple[tuple[Refined, Termination], tuple[Alternative, ...]]:
    """The solution, and the other valid ones by growing v'Pv.

    A singular end that fits as well as the best valid one wins over it: the control does not tell them apart. So
    does one behind the camera or below the ground that alone fits: the axes of the data are wrong.
    """
    ranked = sorted(refined, key=lambda end: end[0].linear.vPv)
    valid = _distinct_solutions([end for end in ranked if end[1] is Termination.CONVERGED])
    misplaced = [end for end in ranked if end[1] in (Termination.BEHIND_CAMERA, Termination.BELOW_GROUND)]
    if not valid:
        return _least_bad(ranked), ()
    if misplaced and FAR_BETTER * (misplaced[0][0].linear.vPv + task.reading_noise) < valid[0][0].linear.vPv:
        return misplaced[0], ()
    limit = np.inf if task.redundancy == 0 else NEARLY_AS_GOOD * valid[0][0].linear.vPv
    limit = max(limit, ROUNDING_SHARE * task.reading_noise)
    as_good = [end for end in valid if end[0].linear.vPv <= limit]
    fits = NEARLY_AS_GOOD * valid[0][0].linear.vPv + task.reading_noise
    singular = [end for end in ranked if end[1] is Termination.SINGULAR and end[0].linear.vPv <= fits]
    best = singular[0] if singular else valid[0]
    if near is not None:
        best = min([*as_good, *singular], key=lambda end: float(np.linalg.norm(end[0].state.station - near)))
    others = [end[0] for end in valid if end is not best]
    return best, tuple(
        Alternative(o.state.rotation, o.state.station + task.origin, o.linear.vPv, is_as_good=o.linear.vPv <= limit)
        for o in others
    )


def _least_bad(ranked: Sequence[tuple[Refined, Termination]]) -> tuple[Refined, Termination]:
    """Among ends without a valid one: the one that says most about the cause, then the smallest v'Pv."""
    telling = (Termination.SINGULAR, Termination.BELOW_GROUND, Termination.BEHIND_CAMERA, Termination.MAX_ITERATIONS)
    for termination in telling:
        for end in ranked:
            if end[1] is termination:
                return end
    return ranked[0]


def _distinct_solutions(ranked: Sequence[tuple[Refined, Termination]]) -> list[tuple[Refined, Termination]]:
    """Different starts mostly end in the same place; the first of each place is kept."""
    kept: list[tuple[Refined, Termination]] = []
    for end in ranked:
        if not any(_is_same_place(end[0], other[0]) for other in kept):
            kept.append(end)
    return kept


def _is_same_place(one: Refined, other: Refined) -> bool:
    turned = np.linalg.norm(one.state.rotation - other.state.rotation)
    moved = np.linalg.norm(one.state.station - other.state.station) / other.linear.scales[3]
    return bool(max(turned, moved) <= SAME_SOLUTION)


def _result(
    task: _Task, end: tuple[Refined, Termination], alternatives: tuple[Alternative, ...], tried: int
) -> Resection:
    iterated, termination = end
    problem, state, linear = task.problem, iterated.state, iterated.linear
    computed, zs = project(state.ground, state.station, state.rotation, problem.f_mm)
    undetermined = _undetermined(task, iterated) if termination is Termination.SINGULAR else ""
    Q, image_redundancy, ground_redundancy, Q_P = _quality(problem, iterated, termination)
    return Resection(
        termination=termination,
        message=_message(termination, undetermined),
        rotation=state.rotation,
        station=state.station + task.origin,
        f_mm=problem.f_mm,
        vPv=linear.vPv,
        n_equations=task.n_equations,
        n_unknowns=task.n_unknowns,
        redundancy=task.redundancy,
        residuals=computed - problem.image,
        computed=computed,
        zs=zs,
        Q=Q,
        equations=partials_aok(state.ground, state.station, state.rotation, problem.f_mm),
        free_terms=computed - problem.image,
        redundancy_numbers=image_redundancy,
        ground_redundancy=ground_redundancy,
        condition_ratio=iterated.condition_ratio,
        iterations=_records(task, iterated),
        ground=state.ground + task.origin,
        ground_cofactors=Q_P,
        undetermined=undetermined,
        weak=functional_iteration.strong_correlations(Q, ELEMENTS),
        alternatives=alternatives,
        candidates_tried=tried,
    )


def _quality(
    problem: ResectionProblem, iterated: Refined, termination: Termination
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Q, redundancy numbers of image and ground, Q_P; NaN where the equations are singular or not finite."""
    n = len(problem.image)
    if termination in (Termination.SINGULAR, Termination.NOT_FINITE):
        return np.full((6, 6), np.nan), np.full((n, 2), np.nan), np.full(n, np.nan), np.full((n, 3, 3), np.nan)
    Q = functional_iteration.cofactor_matrix(iterated.linear)
    return Q, *problem.redundancy_numbers(iterated.state, iterated.linear, Q)


def _undetermined(task: _Task, iterated: Refined) -> str:
    points = undetermined_points(iterated.linear.points, task.problem.known, WEAK_HEIGHT)
    if len(points):
        return f"the ground position of point {task.names[points[0]]}"
    combination = functional_iteration.undetermined_combination(iterated.linear, ELEMENTS)
    return f"{combination} (angles in rad, lengths in units of {iterated.linear.scales[3]:.6g} m)"


def _message(termination: Termination, undetermined: str) -> str:
    return f"{MESSAGES[termination]} Undetermined: {undetermined}." if undetermined else MESSAGES[termination]


def _records(task: _Task, iterated: Refined) -> tuple[IterationRecord, ...]:
    states = [*(step.state for step in iterated.steps), iterated.state]
    return tuple(_record(task, step, after) for step, after in zip(iterated.steps, states[1:], strict=True))


def _record(task: _Task, step: Step[Orientation], after: Orientation) -> IterationRecord:
    has_unknown_points = len(task.problem.known.unknown) > 0
    return IterationRecord(
        rotation=step.state.rotation,
        station=step.state.station + task.origin,
        ground=step.state.ground + task.origin if has_unknown_points else None,
        correction_rotation=step.corrections[:3],
        correction_station=step.corrections[3:],
        correction_ground=after.ground - step.state.ground if has_unknown_points else None,
        vPv=step.vPv,
        max_scaled_step=step.max_scaled_step,
        damping=step.damping,
    )
