"""From starts to the solution: which adjustments are run, which end is the answer, and does its mirror fit better."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orient.solvers import functional_iteration
from orient.solvers.absolute_cofactors import turned
from orient.solvers.absolute_problem import UNKNOWNS, AbsoluteEquations, AbsoluteProblem, Similarity
from orient.solvers.absolute_result import OtherOrientation
from orient.solvers.absolute_start import may_be_mirrored, start_values, tilted_starts
from orient.solvers.engines import Engine
from orient.solvers.functional_iteration import WEAK_RATIO, Iterated, Termination

FloatArray = NDArray[np.float64]
Refined = Iterated[Similarity, AbsoluteEquations]
End = tuple[Refined, Termination]

SINGULAR_AT_END = 1e-6
"""Condition ratio at which steps of a singular control fade below the tolerance and look like convergence."""
SETTLING_STEPS = 20
BRIEF_ITERATIONS, KEPT_STARTS = 8, 6
SAME_PLACE = 1e-2
SAME_SOLUTION = 1e-5
NEARLY_AS_GOOD = 4.0
FAR_BETTER = 100.0
FIT_SHARE = 1e-6
"""Misclosure, as share of the extent of the control, that no judgement of a fit should be finer than."""
MIRROR = np.diag([1.0, -1.0, 1.0])


@dataclass(frozen=True, slots=True)
class Task:
    """The problem about the centres of model and ground, so that large coordinates keep their digits."""

    problem: AbsoluteProblem
    model_centre: FloatArray
    ground_centre: FloatArray
    n_equations: int
    names: Sequence[str]
    tolerance: float
    max_iterations: int

    def origin(self, state: Similarity) -> FloatArray:
        """X0: where the origin of the model lies on the ground."""
        return np.asarray(self.ground_centre + state.centre - state.t * state.rotation @ self.model_centre)

    def noise(self, state: Similarity) -> float:
        """v'Pv of misclosures of a millionth of the extent."""
        total = self.problem.weight(state.rotation, state.t).trace(self.problem.known)
        return total * (FIT_SHARE * self.problem.extent) ** 2


def all_ends(task: Task) -> list[End]:
    """The adjustment from the promising starts; from tilted ones when the others lead nowhere."""
    ends = [_refined(task, start) for start in _promising(task, start_values(task.problem))]
    if not any(end[1] is Termination.CONVERGED for end in ends):
        ends += [_refined(task, start) for start in _promising(task, tilted_starts(task.problem))]
    return ends


def _promising(task: Task, starts: Sequence[Similarity]) -> list[Similarity]:
    """The starts whose first iterations come nearest to the control, one for each place they lead to."""
    if len(starts) <= KEPT_STARTS:
        return list(starts)
    brief = replace(task, max_iterations=min(task.max_iterations, BRIEF_ITERATIONS))
    ends = [_refined(brief, start)[0] for start in starts]
    order = np.argsort([end.linear.vPv for end in ends], kind="stable")
    kept: list[int] = []
    for index in order.tolist():
        if not any(_is_same(ends[index].state, ends[other].state, SAME_PLACE) for other in kept):
            kept.append(index)
    return [starts[index] for index in kept[:KEPT_STARTS]]


def _refined(task: Task, start: Similarity) -> End:
    """The adjustment from one start, and how it ends when a nearly singular end is called by its name."""
    iterated = _iterated(task, start)
    if iterated.termination is Termination.SINGULAR:
        settled = _settled(task.problem, iterated)
        if functional_iteration.condition_ratio(settled.linear.triangle) < SINGULAR_AT_END:
            return settled, Termination.SINGULAR
        # only the start was singular: the control is not
        iterated = _iterated(task, settled.state)
    converged = iterated.termination is Termination.CONVERGED
    ended = iterated.termination in (Termination.MAX_ITERATIONS, Termination.NO_DESCENT)
    if iterated.condition_ratio < (SINGULAR_AT_END if converged else WEAK_RATIO) and (converged or ended):
        return iterated, Termination.SINGULAR
    return iterated, iterated.termination


def _iterated(task: Task, start: Similarity) -> Refined:
    polish = None if task.problem.engine is Engine.QR else replace(task.problem, engine=Engine.QR)
    return functional_iteration.iterate(
        task.problem, start, polish=polish, tolerance=task.tolerance, max_iterations=task.max_iterations
    )


def _settled(problem: AbsoluteProblem, singular: Refined) -> Refined:
    """The least v'Pv that a singular state leads to when what is not determined stays as it is."""
    state, linear = singular.state, singular.linear
    for _ in range(SETTLING_STEPS):
        step = -np.linalg.lstsq(linear.triangle, linear.rho, rcond=SINGULAR_AT_END)[0]
        following, _ = problem.corrected(state, linear, linear.scales * step)
        after = problem.linearise(following)
        if not after.vPv < linear.vPv:
            break
        state, linear = following, after
    return replace(singular, state=state, linear=linear)


def choose(task: Task, ends: Sequence[End]) -> tuple[End, tuple[OtherOrientation, ...]]:
    """The solution and the other ones: smallest v'Pv, upright if that fits; the smaller tilt of two that fit alike.

    A singular end that fits as well as the best valid one wins over it: the control does not tell them apart.
    """
    ranked = sorted(ends, key=lambda end: end[0].linear.vPv)
    valid = _distinct([end for end in ranked if end[1] is Termination.CONVERGED])
    if not valid:
        telling = [end for end in ranked if end[1] is Termination.SINGULAR]
        return (telling or ranked)[0], ()
    noise = task.noise(valid[0][0].state)
    fits = NEARLY_AS_GOOD * valid[0][0].linear.vPv + noise
    singular = [end for end in ranked if end[1] is Termination.SINGULAR and end[0].linear.vPv <= fits]
    if singular:
        return singular[0], ()
    alike = [end for end in valid if end[0].linear.vPv <= valid[0][0].linear.vPv + noise]
    upright = [end for end in valid if end[0].state.rotation[2, 2] > 0]
    best = max(alike, key=_uprightness)
    if upright and _uprightness(best) <= 0 and upright[0][0].linear.vPv <= FAR_BETTER * best[0].linear.vPv + noise:
        best = upright[0]
    others = [end[0] for end in valid if end is not best]
    return best, tuple(_other(task, end, is_as_good=end.linear.vPv <= fits) for end in others)


def _uprightness(end: End) -> float:
    """r22 = c3, the cosine of the tilt of the model's Z axis."""
    return float(end[0].state.rotation[2, 2])


def _other(task: Task, end: Refined, is_as_good: bool) -> OtherOrientation:
    return OtherOrientation(end.state.rotation, end.state.H, task.origin(end.state), end.linear.vPv, is_as_good)


def _distinct(ranked: Sequence[End]) -> list[End]:
    """Different starts mostly end in the same place; the first of each place is kept."""
    kept: list[End] = []
    for end in ranked:
        if not any(_is_same(end[0].state, other[0].state, SAME_SOLUTION) for other in kept):
            kept.append(end)
    return kept


def _is_same(one: Similarity, other: Similarity, limit: float) -> bool:
    with np.errstate(all="ignore"):
        turned_by = np.linalg.norm(one.rotation - other.rotation)
        return bool(max(turned_by, abs(np.log(one.H / other.H))) <= limit)


def mirrored_vPv(task: Task, end: End) -> float:
    """The smallest v'Pv that the mirrored model leaves; NaN when an upright fit leaves no reason to ask."""
    iterated, termination = end
    fits = task.n_equations == UNKNOWNS or iterated.linear.vPv <= FAR_BETTER * task.noise(iterated.state)
    fits = fits or not may_be_mirrored(task.problem)
    if termination is not Termination.CONVERGED or (fits and _uprightness(end) > 0):
        return np.nan
    problem = task.problem
    cofactor = None if problem.model_cofactor is None else turned(MIRROR, problem.model_cofactor)
    mirrored = replace(task, problem=replace(problem, model=problem.model @ MIRROR, model_cofactor=cofactor))
    starts = _promising(mirrored, start_values(mirrored.problem))
    return min((_refined(mirrored, start)[0].linear.vPv for start in starts[:2]), default=np.nan)


def is_mirrored(task: Task, end: End, vPv_mirrored: float, allowed: bool) -> bool:
    """Does the mirrored model fit far better, or, when the model is turned upside down, as well?"""
    iterated, _ = end
    if np.isnan(vPv_mirrored):
        return False
    noise, vPv = task.noise(iterated.state), iterated.linear.vPv
    if FAR_BETTER * (vPv_mirrored + noise) < vPv:
        return True
    as_well = vPv_mirrored <= NEARLY_AS_GOOD * vPv + noise
    return bool(_uprightness(end) < 0 and as_well and not allowed)
