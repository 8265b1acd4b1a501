"""x = -f xs/zs, y = -f ys/zs, (xs, ys, zs) = R'(P - S): the exterior orientation R, S of one photo from control."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry.collinearity import image_ray, project
from orient.solvers import functional_iteration
from orient.solvers.camera_unknowns import CameraUnknowns, separability
from orient.solvers.common_unknowns import CommonUnknowns, whitened
from orient.solvers.element_observations import ElementObservation, Misclosure
from orient.solvers.engines import Engine
from orient.solvers.functional_iteration import Iterated, Step, Termination, condition_ratio
from orient.solvers.ground_points import ground_knowledge, onto_rays, undetermined_points
from orient.solvers.resection_checks import check_control
from orient.solvers.resection_leads import leads_of
from orient.solvers.resection_problem import Orientation, ResectionEquations, ResectionProblem
from orient.solvers.resection_result import (
    INSEPARABLE,
    NO_HEIGHT,
    WEAK_HEIGHT,
    Alternative,
    IterationRecord,
    Refined,
    Resection,
    Task,
    resection_result,
)
from orient.solvers.resection_starts import is_same_place, starts_and_ends
from orient.solvers.start_values import Candidate, Method, distinct, start_candidates

__all__ = ["Alternative", "IterationRecord", "Resection", "resect"]

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

NEARLY_AS_GOOD = 4.0
UNLIKELY = 13.8
"""2 ln 1000: v'Pv / sigma0^2 that an orientation loses against one that is a thousand times more likely."""
FAR_BETTER = 100.0
FITS, HOPELESS = 0.005, 0.05
ROUNDING_SHARE = 1e-10
LEAD_TO_END = 0.001
"""Between the lead of several starts and their one end: rotation [rad], station [distance]."""
MANY_POINTS = 2000
"""From so many points on, the iterations begin where a part of the points leads."""


def resect(
    image: FloatArray,
    image_cofactor: FloatArray,
    ground: FloatArray,
    f_mm: float,
    *,
    ground_free: FloatArray | None = None,
    ground_weight: FloatArray | None = None,
    common: CommonUnknowns | None = None,
    start_mask: BoolArray | None = None,
    approximate_station: FloatArray | None = None,
    fixed_station: FloatArray | None = None,
    observed: Sequence[ElementObservation] = (),
    interior: CameraUnknowns | None = None,
    start: tuple[FloatArray, FloatArray] | None = None,
    camera_above: FloatArray | None = None,
    names: Sequence[str] | None = None,
    sigma0_mm: float = 0.0,
    engine: Engine = Engine.ZLATANOV,
    tolerance: float = 1e-10,
    max_iterations: int = 50,
) -> Resection:
    """v = B_e de + B_p (G dc + dp) - H dc + L, v_p = dp + t, v_c = dc + c, v'Pv -> min: R, S from control points.

    `image` (n, 2) [mm] refined, principal point at 0; `image_cofactor` (n, 2, 2) = covariance / sigma0^2; `ground`
    (n, 3) [m], right-handed; `ground_free` D (n, 3, 3): projector onto the unknown directions of each point (zeros:
    errorless; identity: weighted; up up': height unknown; I - up up': plan unknown); `ground_weight` W (n, 3, 3):
    inverse covariance times sigma0^2 of the given coordinates, zero in directions of which nothing is known;
    `common`: unknowns c that shift many points together, P = given + G c + p, such as the polynomial of a map sheet;
    `ground_free` and `ground_weight` are then those of the point's own part p.
    `start_mask` (n,): points with three known coordinates, by default those whose D has no part without weight.
    `camera_above` (3,): up vector; the camera must then be above the mean ground. `names` only serve the messages.
    `engine`: Algorithm Z with the last steps by QR, or QR throughout.
    `fixed_station` (3,): the projection centre, known without error. `observed`: coordinates of the station or angles
    that are known with a standard deviation. `interior`: elements of the camera that are unknowns too, with or without
    a standard deviation a priori; v is then that of `orient.geometry.camera`, and `image` and `f_mm` (of the camera a
    priori) only serve the start. They are released when the orientation with the given camera is found. An element
    without standard deviation that the others explain (f and the height over flat ground) ends in SINGULAR.
    `start` (R, S): an orientation from which alone the adjustment begins.

    `sigma0_mm`: standard deviation of unit weight a priori, by which two fits are told apart; 0: by their ratio alone.

    No approximations are needed: several closed forms give starts (`start_candidates`), the best distinct
    ones are refined, and the valid one (converged, all points in front, camera above) with the smallest v'Pv is the
    result; `approximate_station` picks among those that fit equally well. The other valid ones are `alternatives`;
    `starts` and `ends` are all that was tried and where it led. Starts that the lean Gauss-Newton with about 1000 of
    the full points leads to one place have one end, if that is near this place (control that is sure and even) and
    has redundancy; from 2000 points on the iterations with all points begin there.
    Without a valid one the best is returned with its termination. Control that cannot determine a photo at all
    (fewer than three full points, points on a line, coinciding points) raises GeometryError.
    r = 2n + rank W + rank C + known elements - unknown elements - rank D - rank C. Source: seed 004, equations (3)-(5)
    corrected, with ground observations.
    """
    names = names or [str(i + 1) for i in range(len(image))]
    known = ground_knowledge(ground, ground_free, ground_weight)
    full = known.free_rank == known.weight_rank
    full = full if start_mask is None else full & start_mask
    origin = ground.mean(axis=0)
    problem = ResectionProblem(
        image=image,
        image_cofactor=image_cofactor,
        known=replace(known, given=ground - origin),
        f_mm=f_mm,
        shared=whitened(common, len(image)),
        engine=engine,
        interior=interior,
        observed=[replace(one, misclosure=_about(one.misclosure, origin)) for one in observed],
        is_station_fixed=fixed_station is not None,
    )
    check_control(image, image_cofactor, known, full, names, len(problem.unknowns), problem.n_known)
    task = Task(problem, origin, full, camera_above, names, tolerance, max_iterations, sigma0_mm)
    near = approximate_station if fixed_station is None else fixed_station
    near = None if near is None else near - origin
    starts = _starts(task, near, start)
    worth = _worth_refining(task, starts)
    refined = _all_refined(task, worth)
    best, alternatives = _choose(task, refined, near)
    tried, ends = starts_and_ends(task, starts, worth, refined, best, alternatives)
    return resection_result(task, best, alternatives, tried, ends)


def _about(misclosure: Misclosure, origin: FloatArray) -> Misclosure:
    """The same observation for a station that is counted from `origin`."""
    return lambda rotation, station: misclosure(rotation, station + origin)


def _starts(task: Task, near: FloatArray | None, start: tuple[FloatArray, FloatArray] | None) -> list[Candidate]:
    """The given start alone, the rotation at a fixed station, or what three points each say."""
    if start is not None:
        station, n = start[1] - task.origin, int(task.full.sum())
        return [Candidate(start[0], station, 0.0, n, all_in_front=True, triple=(), method=Method.GIVEN)]
    problem, full = task.problem, task.full
    starts = start_candidates(problem.image[full], problem.known.given[full], problem.f_mm, near)
    if problem.is_station_fixed:
        starts = [one for one in starts if one.method is Method.STATION and not one.is_reversed][:1]
    if not starts:
        raise GeometryError(
            "No three control points give a start: every triangle is nearly a line.",
            "Measure control points that are spread over the photo.",
        )
    return starts


def _worth_refining(task: Task, starts: Sequence[Candidate]) -> list[Candidate]:
    """The best distinct starts; two with points behind the camera too, to tell wrong axes from a bad fit.

    Where one fits already, those that miss by a twentieth of the image's spread are passed over: three-point starts
    near a rival that fits too would be better than that.
    """
    ground, image = task.problem.known.given, task.problem.image[task.full]
    spread = float(np.sqrt(np.mean(np.sum((image - image.mean(axis=0)) ** 2, axis=1))))
    if starts[0].all_in_front and starts[0].rms_mm < FITS * spread:
        starts = [start for start in starts if start.all_in_front and start.rms_mm < HOPELESS * spread]
    in_front = [start for start in starts if start.all_in_front]
    behind = sorted((start for start in starts if not start.all_in_front), key=lambda start: start.rms_mm)
    return distinct(in_front, ground) + distinct(behind, ground, limit=2)


def _all_refined(task: Task, worth: Sequence[Candidate]) -> list[tuple[Refined, Termination]]:
    """The adjustment from each start; one for all starts with the same lead, where that is near its end.

    That of many points begins at the lead.
    """
    if task.problem.is_station_fixed or task.redundancy == 0:  # a place that no lead keeps; every end is told
        return [_refined(task, one) for one in worth]
    are_many = len(task.problem.image) >= MANY_POINTS
    if len(worth) == 1 and not are_many:
        return [_refined(task, worth[0])]
    leads = leads_of(task, worth)
    ends: list[tuple[Refined, Termination]] = []
    for number, (start, lead) in enumerate(zip(worth, leads, strict=True)):
        begin = lead.start if are_many else start
        end = ends[lead.first] if lead.first < number else _refined(task, begin)
        is_own = lead.first == number and begin is start
        ends.append(end if is_own or _ends_near(task, end, lead.start) else _refined(task, start))
    return ends


def _ends_near(task: Task, end: tuple[Refined, Termination], lead: Candidate) -> bool:
    """Is the lead about where its adjustment ends? Else errors of the control or what else is known decide the way."""
    iterated, termination = end
    state, distance = _end_with_given_camera(task, iterated), iterated.linear.distance
    turned = np.linalg.norm(state.rotation - lead.rotation) / np.sqrt(2)
    moved = np.linalg.norm(state.station - lead.station) / distance
    return termination is Termination.CONVERGED and bool(max(turned, moved) < LEAD_TO_END)


def _end_with_given_camera(task: Task, iterated: Refined) -> Orientation:
    """Where the elements of the camera were released, or the end: a lead knows nothing of them."""
    interior = task.problem.interior
    if interior is None:
        return iterated.state
    given = [step.state for step in iterated.steps if np.array_equal(step.state.camera, interior.apriori)]
    return given[-1] if given else iterated.state


def _refined(task: Task, candidate: Candidate) -> tuple[Refined, Termination]:
    """The adjustment from one start, and how it ends when the camera's place is judged too."""
    problem = task.problem
    rays = image_ray(problem.image, candidate.rotation, problem.f_mm)
    ground = onto_rays(problem.known, ~task.full, candidate.station, rays)
    start = Orientation(candidate.rotation, candidate.station, ground, np.zeros(problem.common.rank))
    if problem.interior is None:
        iterated = _iterated(task, problem, start)
        return iterated, _termination(task, iterated)
    given_camera = replace(problem, interior=problem.interior.without())
    first = _iterated(task, given_camera, start)
    if first.termination is not Termination.CONVERGED:
        first = replace(first, state=start, steps=())
    released = replace(first.state, camera=problem.interior.apriori)
    linear = problem.linearise(released)
    steps = tuple(_with_known_camera(step, problem.interior.apriori) for step in first.steps)
    if first.termination is Termination.CONVERGED and _is_inseparable(problem, linear):
        iterated = Iterated(Termination.SINGULAR, released, linear, condition_ratio(linear.triangle), steps)
        return iterated, Termination.SINGULAR
    iterated = _iterated(task, problem, released)
    iterated = replace(iterated, steps=(*steps, *iterated.steps))
    return iterated, _termination(task, iterated)


def _iterated(task: Task, problem: ResectionProblem, start: Orientation) -> Refined:
    polish = None if problem.engine is Engine.QR else replace(problem, engine=Engine.QR)
    return functional_iteration.iterate(
        problem, start, polish=polish, tolerance=task.tolerance, max_iterations=task.max_iterations
    )


def _with_known_camera(step: Step[Orientation], camera: FloatArray) -> Step[Orientation]:
    """A step before the camera was released: its elements had their values a priori and were not corrected."""
    corrections = np.concatenate([step.corrections, np.zeros(len(camera))])
    return replace(step, state=replace(step.state, camera=camera), corrections=corrections)


def _is_inseparable(problem: ResectionProblem, linear: ResectionEquations) -> bool:
    """Is there an element of the camera, free of any knowledge a priori, that all the others explain?"""
    if problem.interior is None or not np.isfinite(linear.vPv):
        return False
    free = np.flatnonzero(np.isinf(problem.interior.cofactors))
    first = len(problem.unknowns) - len(problem.interior.names)
    return bool(np.any(separability(linear.triangle)[first + free] < INSEPARABLE))


def _termination(task: Task, iterated: Refined) -> Termination:
    state, converged = iterated.state, iterated.termination is Termination.CONVERGED
    if len(undetermined_points(iterated.linear.points, task.problem.known, NO_HEIGHT if converged else WEAK_HEIGHT)):
        return Termination.SINGULAR
    if not converged:
        return iterated.termination
    if _is_inseparable(task.problem, iterated.linear):
        return Termination.SINGULAR
    if np.any(project(state.ground, state.station, state.rotation, task.problem.f_mm)[1] >= 0):
        return Termination.BEHIND_CAMERA
    if task.camera_above is not None and task.camera_above @ (state.station - state.ground.mean(axis=0)) <= 0:
        return Termination.BELOW_GROUND
    return Termination.CONVERGED


def _choose(
    task: Task, refined: Sequence[tuple[Refined, Termination]], near: FloatArray | None
) -> tuple[tuple[Refined, Termination], tuple[Alternative, ...]]:
    """The solution, and the other valid ones by growing v'Pv.

    A singular end that fits as well as the best valid one wins over it: the control does not tell them apart. So
    does one behind the camera or below the ground that alone fits: the axes of the data are wrong. And so does one
    without an end that fits better: in the weakest geometry (a plane seen straight on through a long lens) the best
    place is no minimum of the linearised equations.
    """
    ranked = sorted(refined, key=lambda end: end[0].linear.vPv)
    valid = _distinct_solutions([end for end in ranked if end[1] is Termination.CONVERGED])
    misplaced = [end for end in ranked if end[1] in (Termination.BEHIND_CAMERA, Termination.BELOW_GROUND)]
    if not valid:
        return _least_bad(ranked), ()
    if misplaced and FAR_BETTER * (misplaced[0][0].linear.vPv + task.reading_noise) < valid[0][0].linear.vPv:
        return misplaced[0], ()
    unfinished = [end for end in ranked if end[1] in (Termination.NO_DESCENT, Termination.MAX_ITERATIONS)]
    if unfinished and _leaves_doubt(task, unfinished[0][0].linear.vPv, valid[0][0].linear.vPv):
        return unfinished[0], ()
    limit = _nearly_as_good(task, valid[0][0].linear.vPv)
    as_good = [end for end in valid if end[0].linear.vPv <= limit]
    # without redundancy everything fits, with it a camera that ran into a point is no rival of one that fits far better
    share = 1.0 if task.redundancy == 0 else ROUNDING_SHARE
    fits = NEARLY_AS_GOOD * valid[0][0].linear.vPv + share * task.reading_noise
    singular = [end for end in ranked if end[1] is Termination.SINGULAR and end[0].linear.vPv <= fits]
    best = singular[0] if singular else valid[0]
    if near is not None:
        best = min([*as_good, *singular], key=lambda end: float(np.linalg.norm(end[0].state.station - near)))
    others = [end[0] for end in valid if end is not best]
    return best, tuple(
        Alternative(o.state.rotation, o.state.station + task.origin, o.linear.vPv, is_as_good=o.linear.vPv <= limit)
        for o in others
    )


def _leaves_doubt(task: Task, unfinished: float, valid: float) -> bool:
    """Does an end that is none (v'Pv `unfinished`) fit better than the best valid one; without redundancy, as well?"""
    if task.redundancy == 0:
        return task.sigma0_mm > 0 and unfinished <= _nearly_as_good(task, valid)
    return _nearly_as_good(task, unfinished) < valid


def _nearly_as_good(task: Task, vPv: float) -> float:
    """v'Pv up to which another orientation fits as well as the best one."""
    if task.redundancy == 0 and task.sigma0_mm == 0:
        return np.inf
    likely = vPv + UNLIKELY * task.sigma0_mm**2
    return max(NEARLY_AS_GOOD * vPv, likely, ROUNDING_SHARE * task.reading_noise)


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
        if not any(is_same_place(end[0], other[0]) for other in kept):
            kept.append(end)
    return kept
