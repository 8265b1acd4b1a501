"""Which control points carry the resection: those left out by hand, by robust estimation, by data snooping."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from orient.errors import OrientError
from orient.pipeline.chain import Chain
from orient.pipeline.choice import Mask, choose_points, point_verdicts
from orient.pipeline.exclusions import by_hand
from orient.pipeline.frames import Frame
from orient.pipeline.observations import Observations
from orient.pipeline.tables import Array
from orient.pipeline.weights import ground_weights
from orient.solvers.common_unknowns import WhitenedCommon, whitened
from orient.solvers.critical_values import Limits, tau_limits, w_limits
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.reliability import Reliability, observation_tests, prediction_statistic
from orient.solvers.resection import Resection
from orient.solvers.resection_reliability import (
    Measured,
    View,
    control_blocks,
    of_all_elements,
    other_blocks,
    view_misfits,
)
from orient.solvers.snooping import Decision, Verdicts, fit_probability
from orient.values import Settings

AGREEING = 4
"""Points that a robust resection needs: three determine the photo, one checks it."""


@dataclass(frozen=True, slots=True)
class Solved:
    """One resection with what went into it: points, verticals, projectors and weights of its last round, in T'."""

    found: Resection
    control: Observations
    chain: Chain
    place: Array
    up: Array
    free: Array
    weight: Array


@dataclass(frozen=True, slots=True)
class Task:
    """The control of a photo, and how it is adjusted: `adjust` (places of the points that take part, where to begin).

    `unknowns`: elements less what is known of them, which the points have to determine.
    """

    frame: Frame
    control: Observations
    chain: Chain
    f_mm: float
    settings: Settings
    adjust: Callable[[Sequence[int], Solved | None], Solved]
    unknowns: int = 6

    @property
    def sigma0(self) -> float:
        return self.chain.sigma0

    def limits(self, found: Resection) -> Limits:
        """w with sigma0 a priori, or tau with sigma0 a posteriori; `auto` follows the setting `variance`.

        A photo that fits without any residual has no sigma0 a posteriori to test with.
        """
        test = str(self.settings["test"])
        if test == "auto":
            test = "tau" if self.settings["variance"] == "posteriori" else "w"
        if test == "w" or found.redundancy == 0 or found.vPv == 0:
            return w_limits(self.sigma0)
        return tau_limits(found.vPv, found.redundancy)


@dataclass(frozen=True, slots=True)
class Tested:
    """A resection with the tests of its observations."""

    solved: Solved
    limits: Limits
    reliability: Reliability


@dataclass(frozen=True, slots=True)
class Chosen:
    """The resection that counts, the places of the points that take part, and how it came to that.

    `decisions`: steps of the snooping, `proposed` or carried out; `by_hand`, `by_robust`: points left out before;
    `tested` None when there is no result.
    """

    solved: Solved
    inside: list[int]
    outside: list[int]
    by_hand: list[int]
    by_robust: list[int]
    decisions: tuple[Decision, ...]
    tested: Tested | None


def choose_control(task: Task) -> Chosen:
    """Adjust with all points but those excluded by hand; robust estimation and snooping as the settings ask.

    Without `reject` the decisions of the snooping are proposals: all points stay. RobustFailed when no set agrees.
    """
    hand = by_hand(task.settings, task.control.points, "control point")
    start = np.ones(len(task.control.points), dtype=np.bool_)
    start[hand] = False
    choice = choose_points(
        start,
        task.settings,
        lambda kept, first: _verdicts(task, kept, task.limits, None if first is None else first.solved),
        lambda candidates: _agreeing(task, candidates),
    )
    inside, outside = (np.flatnonzero(mask).tolist() for mask in (choice.kept, ~choice.kept))
    solved = task.adjust(inside, None) if choice.tested is None else choice.tested.solved
    return Chosen(solved, inside, outside, hand, choice.by_robust, choice.decisions, choice.tested)


def measured(
    task: Task, at: Sequence[int], place: Array, free: Array, weight: Array, shared: WhitenedCommon
) -> Measured:
    """Points of the control as the solver takes them."""
    frame, control = task.frame, task.control
    turned = [frame.right_handed_matrix(matrix) if free.any() else None for matrix in (free, weight)]
    return Measured(
        control.image[at],
        control.image_covariance[at] / task.sigma0**2,
        ground_knowledge(frame.right_handed(place), *turned),
        shared.by_ground,
        shared.by_image,
        None if task.chain.camera is None else task.chain.camera.of(at),
    )


def whitened_common(task: Task, at: Sequence[int]) -> WhitenedCommon:
    """What these points share, in the solver's frame."""
    return whitened(task.chain.at(at).in_solver(task.control.comparator[at], task.frame), len(at))


def _verdicts(
    task: Task, kept: Mask, limits_of: Callable[[Resection], Limits], near: Solved | None = None
) -> Verdicts[Tested] | None:
    inside, outside = np.flatnonzero(kept).tolist(), np.flatnonzero(~kept).tolist()
    try:
        solved = task.adjust(inside, near)
    except OrientError:
        if kept.all():
            raise
        return None
    if solved.found.termination != "CONVERGED":
        return None
    limits = limits_of(solved.found)
    shared = whitened_common(task, inside)
    points = measured(task, inside, solved.place, solved.free, solved.weight, shared)
    blocks = control_blocks(solved.found, points, shared, task.frame.partner)
    reliability = observation_tests(blocks, limits, len(solved.found.problem.free))
    reliability = of_all_elements(solved.found, reliability)
    tested, r = Tested(solved, limits, reliability), solved.found.redundancy
    probability = _fit(task, solved.found, outside, limits, reliability, len(kept))
    return point_verdicts(tested, r, blocks[0], reliability, limits, inside, probability)


def _fit(task: Task, found: Resection, at: list[int], limits: Limits, reliability: Reliability, n: int) -> Array:
    """(n,) chance of so large a misfit of the points that take no part; NaN elsewhere."""
    probability = np.full(n, np.nan)
    if at:
        shared = whitened_common(task, at)
        others = task.control.at(at)
        own = None if task.chain.shared is None else task.chain.shared.own[at]
        free, weight = ground_weights(others.rows, str(task.settings["control"]), task.sigma0, own).at(others.up)
        points = measured(task, at, others.ground, free, weight, shared)
        T, freedom = prediction_statistic(other_blocks(found, points, shared), reliability, limits)
        probability[at] = fit_probability(T, freedom, found.redundancy, limits)
    return probability


def _agreeing(task: Task, start: Mask) -> Mask:
    """Least trimmed squares from three-point resections; then all others that fit."""
    from orient.solvers.consensus import Trimmed, all_agreeing, least_trimmed
    from orient.solvers.robust_resection import triple_misfits

    at = np.flatnonzero(start)
    some = task.control.at(at.tolist())
    free, weight = ground_weights(some.rows, str(task.settings["control"]), task.sigma0).at(some.up)
    points = measured(task, at.tolist(), some.ground, free, weight, whitened(None, len(at)))

    def misfits(chosen: Mask) -> Array | None:
        try:
            found = task.adjust(at[chosen].tolist(), None).found
        except OrientError:
            return None
        if found.termination != "CONVERGED":
            return None
        return view_misfits(View(found.rotation, found.station, found.f_mm, found.camera), points) / task.sigma0**2

    starts = [T / task.sigma0**2 for T in triple_misfits(points, some.known == "XYZ", task.f_mm)]
    freedom = 2 + points.ground.weight_rank - points.ground.free_rank
    agreeing = max(AGREEING, task.unknowns // 2 + 1)
    trimmed = least_trimmed(starts, freedom, task.unknowns, agreeing, misfits)
    whole = np.zeros_like(start)
    whole[at] = trimmed.agreeing
    limits = w_limits(task.sigma0 * trimmed.scale)
    return all_agreeing(lambda kept: _verdicts(task, kept, lambda found: limits), Trimmed(whole, trimmed.scale), start)
