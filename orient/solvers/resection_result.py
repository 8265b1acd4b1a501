"""What a resection hands back: the orientation with its whole proof, or how and why it ended without one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import partials_aok, project
from orient.solvers import functional_iteration
from orient.solvers.camera_unknowns import separability, strongest_partner
from orient.solvers.functional_iteration import Iterated, Step, Termination
from orient.solvers.ground_points import undetermined_points
from orient.solvers.resection_problem import Orientation, Quality, ResectionEquations, ResectionProblem
from orient.solvers.start_values import Candidate

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
Refined = Iterated[Orientation, ResectionEquations]

NO_HEIGHT, WEAK_HEIGHT = 1e-12, 1e-6
"""Singular value ratios of a point's own unknowns: none at all; enough to spoil an adjustment that did not converge."""
READING_SHARE = 1e-4
INSEPARABLE = 5e-4
"""sqrt(1 - R^2) of a camera element below which the others explain it: flat ground seen vertically, some sigmas of
tilt. 20 m of relief below 1.5 km have 2e-3."""

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
    """Approximations and corrections of one iteration; `ground` and its corrections (n, 3), None if all fixed.

    `common` and its corrections (k,): of the common unknowns, as corrections of their a-priori values. `camera` and its
    corrections (m,): elements of the interior orientation.
    """

    rotation: FloatArray
    station: FloatArray
    ground: FloatArray | None
    common: FloatArray
    correction_rotation: FloatArray
    correction_station: FloatArray
    correction_ground: FloatArray | None
    correction_common: FloatArray
    camera: FloatArray
    correction_camera: FloatArray
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
class Start:
    """A candidate for the start, and the number of the end it led to; None if it was not refined.

    Not refined are candidates near a better one, and those that fit worse than the best ones.
    """

    candidate: Candidate
    end: int | None


@dataclass(frozen=True, slots=True)
class End:
    """One of the places where the adjustment ended: the first is that of the result, valid ones by v'Pv follow."""

    rotation: FloatArray
    station: FloatArray
    vPv: float
    n_in_front: int
    iterations: int
    termination: Termination
    is_as_good: bool


@dataclass(frozen=True, slots=True)
class Resection:
    """The adjusted exterior orientation with its whole proof; a result only if `termination` is CONVERGED.

    Q (6+m, 6+m): cofactors of r_X, r_Y, r_Z [rad], X_S, Y_S, Z_S [m] and the elements of the camera, `unknowns`, with
    zeros for a fixed station; v = computed - measured [mm], `computed` as it would be measured with the adjusted
    common unknowns; `equations` (n, 2, 9): partials by alpha, omega, kappa, X_S, Y_S, Z_S, X, Y, Z at the solution. NaN
    in Q and the redundancy numbers when the geometry is singular; `undetermined` names the combination of unknowns that
    is not determined, or hardly (condition ratio below 1e-4). `ground` (n, 3) and its cofactors hold the share of the
    common unknowns; `common` (k,): their adjusted corrections c; `joint_cofactors` (6+m+k, 6+m+k) of the elements and
    c. `camera` (m,): adjusted elements of the interior orientation, `camera_equations` (n, 2, m) their partials;
    `known_redundancy` (k,): of what is known a priori of these, then of the exterior orientation. `problem`, `state`
    and `linear` are what was adjusted, its solution about the centroid of the ground and the last equations, `rim`
    (q+u, q+u) cofactors of z and the elements that are adjusted: what an error budget asks for.
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
    measured: FloatArray
    computed: FloatArray
    zs: FloatArray
    unknowns: tuple[str, ...]
    Q: FloatArray
    camera: FloatArray
    camera_equations: FloatArray
    known_redundancy: FloatArray
    equations: FloatArray
    free_terms: FloatArray
    redundancy_numbers: FloatArray
    ground_redundancy: FloatArray
    condition_ratio: float
    iterations: tuple[IterationRecord, ...]
    ground: FloatArray
    ground_cofactors: FloatArray
    common: FloatArray
    joint_cofactors: FloatArray
    common_redundancy: FloatArray
    undetermined: str
    weak: tuple[tuple[str, str, float], ...]
    alternatives: tuple[Alternative, ...]
    starts: tuple[Start, ...]
    ends: tuple[End, ...]
    problem: ResectionProblem
    state: Orientation
    linear: ResectionEquations
    rim: FloatArray

    @property
    def is_ambiguous(self) -> bool:
        """Does another orientation fit as well? Always asked for three points, which leave up to four."""
        return any(alternative.is_as_good for alternative in self.alternatives)


@dataclass(frozen=True, slots=True)
class Task:
    """The problem about the centroid of the ground, so that large coordinates keep their digits."""

    problem: ResectionProblem
    origin: FloatArray
    full: BoolArray
    camera_above: FloatArray | None
    names: Sequence[str]
    tolerance: float
    max_iterations: int
    sigma0_mm: float = 0.0

    @property
    def n_equations(self) -> int:
        own = self.problem.known.weight_rank.sum() + self.problem.common.rank + self.problem.n_known
        return 2 * len(self.problem.image) + int(own)

    @property
    def n_unknowns(self) -> int:
        return len(self.problem.unknowns) + int(self.problem.known.free_rank.sum() + self.problem.common.rank)

    @property
    def redundancy(self) -> int:
        return self.n_equations - self.n_unknowns

    @property
    def reading_noise(self) -> float:
        """v'Pv of reading errors of f / 10 000, which no judgement of a fit should be finer than."""
        weights = 1 / np.diagonal(self.problem.image_cofactor, axis1=1, axis2=2)
        return float(np.sum(weights)) * (READING_SHARE * self.problem.f_mm) ** 2


def resection_result(
    task: Task,
    end: tuple[Refined, Termination],
    alternatives: tuple[Alternative, ...],
    starts: tuple[Start, ...],
    ends: tuple[End, ...],
) -> Resection:
    """Everything that the adjustment found, about the origin of the given ground."""
    iterated, termination = end
    problem, state, linear = task.problem, iterated.state, iterated.linear
    f_mm = problem.focal_length(state)
    _, zs = project(state.ground, state.station, state.rotation, f_mm)
    image = problem.image_equations(state)
    by_aok = image.by_computed @ partials_aok(state.ground, state.station, state.rotation, f_mm)
    is_singular = termination is Termination.SINGULAR
    is_weak = is_singular or iterated.condition_ratio < functional_iteration.WEAK_RATIO
    undetermined = _undetermined(task, iterated) if is_weak else ""
    Q, quality = _quality(problem, iterated, termination)
    return Resection(
        termination=termination,
        message=_message(task, iterated, termination, undetermined),
        rotation=state.rotation,
        station=state.station + task.origin,
        f_mm=f_mm,
        vPv=linear.vPv,
        n_equations=task.n_equations,
        n_unknowns=task.n_unknowns,
        redundancy=task.redundancy,
        residuals=image.free_term,
        measured=image.measured,
        computed=image.measured + image.free_term,
        zs=zs,
        unknowns=problem.all_unknowns,
        Q=Q,
        camera=state.camera,
        camera_equations=image.by_elements[:, :, len(problem.unknowns) - len(state.camera) :],
        known_redundancy=quality.of_elements,
        equations=by_aok,
        free_terms=image.free_term,
        redundancy_numbers=quality.image,
        ground_redundancy=quality.ground,
        condition_ratio=iterated.condition_ratio,
        iterations=_records(task, iterated),
        ground=state.ground + task.origin,
        ground_cofactors=quality.Q_P,
        common=problem.common.factor @ state.common,
        joint_cofactors=problem.to_named @ quality.rim @ problem.to_named.T,
        common_redundancy=quality.common,
        undetermined=undetermined,
        weak=functional_iteration.strong_correlations(Q, problem.all_unknowns),
        alternatives=alternatives,
        starts=starts,
        ends=ends,
        problem=problem,
        state=state,
        linear=linear,
        rim=quality.rim,
    )


def _quality(problem: ResectionProblem, iterated: Refined, termination: Termination) -> tuple[FloatArray, Quality]:
    """Q and what follows from it; NaN where the equations are singular or not finite."""
    n, u, k, q = len(problem.image), len(problem.unknowns), *problem.common.factor.shape
    if termination in (Termination.SINGULAR, Termination.NOT_FINITE):
        shapes = ((q + u, q + u), (n, 3, 3), (n, 2), (n,), (k,), (problem.n_known,))
        size = len(problem.all_unknowns)
        return np.full((size, size), np.nan), Quality(*(np.full(shape, np.nan) for shape in shapes))
    Q = functional_iteration.cofactor_matrix(iterated.linear)
    return problem.of_all(Q), problem.quality(iterated.state, iterated.linear, Q)


def _undetermined(task: Task, iterated: Refined) -> str:
    points = undetermined_points(iterated.linear.points, task.problem.known, WEAK_HEIGHT)
    if len(points):
        return f"the ground position of point {task.names[points[0]]}"
    unknowns = task.problem.unknowns
    combination = functional_iteration.undetermined_combination(iterated.linear, unknowns)
    units = [f"lengths in units of {iterated.linear.distance:.6g} m"]
    if task.problem.interior is not None:
        units.append("the camera's in units that move the image by f")
    return f"{combination} (angles in rad, {', '.join(units)})"


def _message(task: Task, iterated: Refined, termination: Termination, undetermined: str) -> str:
    if not undetermined or termination is Termination.CONVERGED:
        return MESSAGES[termination]
    degree = "Undetermined" if termination is Termination.SINGULAR else "Hardly determined"
    return f"{_inseparable(task, iterated) or MESSAGES[termination]} {degree}: {undetermined}."


def _inseparable(task: Task, iterated: Refined) -> str:
    """Names the element of the camera that the others explain best, and what it is confused with."""
    interior, linear = task.problem.interior, iterated.linear
    if interior is None or not np.isfinite(linear.vPv):
        return ""
    free = np.flatnonzero(np.isinf(interior.cofactors)) + len(linear.triangle) - len(interior.names)
    alone = separability(linear.triangle)
    weakest = min(free, key=lambda i: float(alone[i]), default=None)
    if weakest is None or alone[weakest] >= INSEPARABLE:
        return ""
    partner, correlation = strongest_partner(linear.triangle, int(weakest))
    names = task.problem.unknowns
    return f"{names[weakest]} and {names[partner]} cannot be separated (correlation {abs(correlation):.3f})."


def _records(task: Task, iterated: Refined) -> tuple[IterationRecord, ...]:
    states = [*(step.state for step in iterated.steps), iterated.state]
    return tuple(_record(task, step, after) for step, after in zip(iterated.steps, states[1:], strict=True))


def _record(task: Task, step: Step[Orientation], after: Orientation) -> IterationRecord:
    has_unknown_points = len(task.problem.known.unknown) > 0 or bool(task.problem.common.by_ground.any())
    factor = task.problem.common.factor
    corrections = task.problem.of_all(step.corrections)
    return IterationRecord(
        rotation=step.state.rotation,
        station=step.state.station + task.origin,
        ground=step.state.ground + task.origin if has_unknown_points else None,
        common=factor @ step.state.common,
        correction_rotation=corrections[:3],
        correction_station=corrections[3:6],
        correction_ground=after.ground - step.state.ground if has_unknown_points else None,
        correction_common=factor @ (after.common - step.state.common),
        camera=step.state.camera,
        correction_camera=corrections[6:],
        vPv=step.vPv,
        max_scaled_step=step.max_scaled_step,
        damping=step.damping,
    )
