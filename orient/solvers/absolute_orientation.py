"""X_G = R x/H + X0: seven elements of the exterior (absolute) orientation of a model from control points."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from orient.geometry.rotation import cross_matrix
from orient.solvers import functional_iteration
from orient.solvers.absolute_checks import cause, check_counts, check_problem, check_shapes, known_rank
from orient.solvers.absolute_problem import ELEMENTS, UNKNOWNS, AbsoluteProblem, Fit, Similarity
from orient.solvers.absolute_result import AbsoluteIteration, AbsoluteOrientation, OtherOrientation
from orient.solvers.absolute_search import FAR_BETTER, End, Refined, Task, all_ends, choose, is_mirrored, mirrored_vPv
from orient.solvers.engines import Engine
from orient.solvers.functional_iteration import WEAK_RATIO, Step, Termination

FloatArray = NDArray[np.float64]

MESSAGES = {
    Termination.CONVERGED: "The absolute orientation converged.",
    Termination.MAX_ITERATIONS: "The absolute orientation did not converge within the allowed iterations.",
    Termination.SINGULAR: "The control does not determine the orientation of the model.",
    Termination.DIVERGED: "The absolute orientation diverged.",
    Termination.NO_DESCENT: "The absolute orientation found no step that lowers v'Pv.",
    Termination.NOT_FINITE: "The absolute orientation met numbers that are not finite.",
}
MIRRORED = (
    "The control fits the mirrored model (sqrt(v'Pv/n) = {mirrored:.3g} against {found:.3g}): "
    "model and ground are of opposite handedness, or X and Y are exchanged."
)
UPSIDE_DOWN = (
    "On this flat control the best fit turns the model upside down, and the mirrored model fits upright as well: "
    "X and Y may be exchanged, or model and ground may be of opposite handedness."
)


def orient_model(
    model: FloatArray,
    ground: FloatArray,
    *,
    known: FloatArray | None = None,
    ground_cofactor: FloatArray | None = None,
    model_cofactor: FloatArray | None = None,
    names: Sequence[str] | None = None,
    allow_upside_down: bool = False,
    engine: Engine = Engine.ZLATANOV,
    tolerance: float = 1e-10,
    max_iterations: int = 50,
) -> AbsoluteOrientation:
    """v = B d(r, H, X0) + L, v'Pv -> min, X_G = R x/H + X0: absolute orientation of one zone of a model.

    `model` (n, 3) in its own unit and `ground` (n, 3) [m], both right-handed, of the n control points. `known` K
    (n, 3, 3): projector onto the known directions of each ground point: I full, I - up up' plan only, up up' height
    only (the rest of `ground` may be any finite number). `ground_cofactor` Q_G and `model_cofactor` Q_x, covariance /
    sigma0^2: (n, 3, 3) per point, or (3n, 3n) when points are correlated. Without a model cofactor the model is
    errorless and the ground has unit weights (the papers' case); with one and without the other the ground is
    errorless. `names` only serve the messages. Separate zones are separate calls.

    No approximations are needed: three full points off a line give the closed form; less gives starts at every
    30 degrees, of which the smallest v'Pv with r22 > 0 is kept (H > 0 always). Two full points and a height have two
    exact solutions: the one with the smaller tilt is the result, the other one of the `alternatives`.
    Singular control ends SINGULAR with the combination of unknowns and the layout in words; control that can be seen
    to be too little beforehand raises GeometryError. Mirrored control (`is_mirrored`) is no result; a model that flat
    control turns upside down is not either, unless `allow_upside_down`.
    Sources: seed 000, (2)-(8) corrected; seed 002, (108)-(110); start values EQUATIONS 1.4.
    """
    names = names or [str(i + 1) for i in range(len(model))]
    known = np.broadcast_to(np.eye(3), (len(model), 3, 3)) if known is None else known
    check_shapes((model, ground, known, ground_cofactor, model_cofactor), names)
    check_counts(known, names)
    Q_G = _ground_cofactor(len(model), ground_cofactor, model_cofactor)
    task = _centred(model, ground, known, Q_G, model_cofactor, names, tolerance, max_iterations)
    weight = check_problem(task.problem, names)
    constant = weight if model_cofactor is None else None
    task = replace(task, problem=replace(task.problem, constant_weight=constant, engine=engine))
    ends = all_ends(task)
    best, alternatives = choose(task, ends)
    return _result(task, best, alternatives, len(ends), allow_upside_down)


def _ground_cofactor(n: int, ground: FloatArray | None, model: FloatArray | None) -> FloatArray:
    if ground is not None:
        return ground
    return np.zeros((n, 3, 3)) if model is not None else np.tile(np.eye(3), (n, 1, 1))


def _centred(
    model: FloatArray,
    ground: FloatArray,
    known: FloatArray,
    ground_cofactor: FloatArray,
    model_cofactor: FloatArray | None,
    names: Sequence[str],
    tolerance: float,
    max_iterations: int,
) -> Task:
    K = 0.5 * (known + known.transpose(0, 2, 1))
    model_centre = model.mean(axis=0)
    # the mean of what is known in each direction: assumed heights must not move the centre
    ground_centre = np.linalg.pinv(K.sum(axis=0)) @ (K @ ground[:, :, None]).sum(axis=0)[:, 0]
    arms = K @ (ground - ground_centre)[:, :, None]
    extent = float(np.sqrt(np.sum(arms**2) / len(arms)))
    problem = AbsoluteProblem(model - model_centre, ground - ground_centre, K, ground_cofactor, model_cofactor, extent)
    n_equations = int(known_rank(K).sum())
    return Task(problem, model_centre, ground_centre, n_equations, names, tolerance, max_iterations)


def _result(
    task: Task,
    end: End,
    alternatives: tuple[OtherOrientation, ...],
    tried: int,
    allow_upside_down: bool,
) -> AbsoluteOrientation:
    iterated, termination = end
    state = iterated.state
    fit = None if termination is Termination.NOT_FINITE else task.problem.fit(state)
    Q, Q_X0, numbers, with_model = _quality(task, state, fit, iterated, termination)
    is_weak = termination is Termination.SINGULAR or iterated.condition_ratio < WEAK_RATIO
    undetermined = _undetermined(task, iterated) if is_weak and fit else ""
    why = cause(task.problem, state, task.names) if is_weak and fit else ""
    vPv_mirrored = mirrored_vPv(task, end)
    mirrored = is_mirrored(task, end, vPv_mirrored, allow_upside_down)
    nothing = np.full_like(task.problem.model, np.nan)
    return AbsoluteOrientation(
        termination=termination,
        message=_message(task, end, undetermined, why, vPv_mirrored if mirrored else None),
        rotation=state.rotation,
        H=state.H,
        X0=task.origin(state),
        vPv=iterated.linear.vPv,
        n_equations=task.n_equations,
        n_unknowns=UNKNOWNS,
        residuals=fit.misclosures if fit else nothing,
        model_residuals=fit.model_residuals if fit else nothing,
        ground_residuals=fit.ground_residuals if fit else nothing,
        redundancy_numbers=numbers,
        Q=Q_X0,
        Q_centred=Q,
        model_centre=task.model_centre,
        ground_centre=task.ground_centre + state.centre,
        elements_with_model=with_model,
        condition_ratio=iterated.condition_ratio,
        iterations=_records(task, iterated),
        undetermined=undetermined,
        cause=why,
        weak=functional_iteration.strong_correlations(Q, ELEMENTS),
        alternatives=alternatives,
        candidates_tried=tried,
        vPv_mirrored=vPv_mirrored,
        is_mirrored=mirrored,
    )


def _quality(
    task: Task, state: Similarity, fit: Fit | None, iterated: Refined, termination: Termination
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Q about the centre and of X0, redundancy numbers, elements with model; NaN where the control is singular."""
    n = len(task.problem.model)
    if fit is None or termination is Termination.SINGULAR:
        square = np.full((UNKNOWNS, UNKNOWNS), np.nan)
        return square, square, np.full((n, 3), np.nan), np.full((n, UNKNOWNS, 3), np.nan)
    Q = functional_iteration.cofactor_matrix(iterated.linear)
    J = origin_by_centre(state, task.model_centre)
    with_model = task.problem.elements_with_model(state, fit, Q)
    return Q, np.asarray(J @ Q @ J.T), task.problem.redundancy_numbers(fit, Q), with_model


def origin_by_centre(state: Similarity, model_centre: FloatArray) -> FloatArray:
    """d(r, H, X0)/d(r, ln H, C) (7, 7): dH = H d ln H, dX0 = dC + [a]x r + a d ln H, a = t R x_centre."""
    a = state.t * state.rotation @ model_centre
    J = np.eye(UNKNOWNS)
    J[3, 3] = state.H
    J[4:, :3] = cross_matrix(a)
    J[4:, 3] = a
    return J


def _undetermined(task: Task, iterated: Refined) -> str:
    combination = functional_iteration.undetermined_combination(iterated.linear, ELEMENTS)
    unit = f"{task.problem.extent:.6g} m"
    return f"{combination} (about the centre of the control; angles in rad, H relative, lengths in units of {unit})"


def _message(task: Task, end: End, undetermined: str, why: str, vPv_mirrored: float | None) -> str:
    iterated, termination = end
    if vPv_mirrored is not None:
        if FAR_BETTER * (vPv_mirrored + task.noise(iterated.state)) < iterated.linear.vPv:
            mirrored, found = np.sqrt(np.array([vPv_mirrored, iterated.linear.vPv]) / task.n_equations)
            return MIRRORED.format(mirrored=mirrored, found=found)
        return UPSIDE_DOWN
    words = [MESSAGES[termination]]
    if termination is Termination.SINGULAR:
        words += [f"{why[0].upper()}{why[1:]}."] if why else []
        words += [f"Undetermined: {undetermined}."]
    return " ".join(words)


def _records(task: Task, iterated: Refined) -> tuple[AbsoluteIteration, ...]:
    states = [*(step.state for step in iterated.steps), iterated.state]
    return tuple(_record(task, step, after) for step, after in zip(iterated.steps, states[1:], strict=True))


def _record(task: Task, step: Step[Similarity], after: Similarity) -> AbsoluteIteration:
    X0 = task.origin(step.state)
    return AbsoluteIteration(
        rotation=step.state.rotation,
        following_rotation=after.rotation,
        H=step.state.H,
        X0=X0,
        correction_rotation=step.corrections[:3],
        correction_H=after.H - step.state.H,
        correction_X0=task.origin(after) - X0,
        vPv=step.vPv,
        max_scaled_step=step.max_scaled_step,
        damping=step.damping,
    )
