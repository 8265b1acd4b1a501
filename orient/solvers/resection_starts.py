"""Which start led to which end of a resection: the record that lets a stranger judge the choice."""

from collections.abc import Sequence

import numpy as np

from orient.geometry.collinearity import project
from orient.solvers.functional_iteration import Termination
from orient.solvers.resection_result import Alternative, End, Refined, Start, Task
from orient.solvers.start_values import Candidate

Trial = tuple[Refined, Termination]

SAME_SOLUTION = 1e-5


def starts_and_ends(
    task: Task,
    candidates: Sequence[Candidate],
    worth: Sequence[Candidate],
    trials: Sequence[Trial],
    best: Trial,
    alternatives: Sequence[Alternative],
) -> tuple[tuple[Start, ...], tuple[End, ...]]:
    """All candidates, best first, and the distinct ends of those `worth` refining (one trial each).

    The end of the result is the first; the valid others follow, then those that are no result, each by v'Pv.
    """
    kept: list[Trial] = []
    order = sorted(trials, key=lambda trial: (trial is not best, trial[1] is not Termination.CONVERGED, _vPv(trial)))
    for trial in order:
        if _place_of(trial, kept) is None:
            kept.append(trial)
    led_to = {id(one): _place_of(trial, kept) for one, trial in zip(worth, trials, strict=True)}
    starts = [Start(one.at(one.station + task.origin), led_to.get(id(one))) for one in candidates]
    as_good = [alternative.vPv for alternative in alternatives if alternative.is_as_good]
    return tuple(starts), tuple(_end(task, trial, trial is best or _vPv(trial) in as_good) for trial in kept)


def is_same_place(one: Refined, other: Refined) -> bool:
    """Are two ends the same orientation: within 1e-5 rad, and 1e-5 of the distance to the ground?"""
    turned = np.linalg.norm(one.state.rotation - other.state.rotation)
    moved = np.linalg.norm(one.state.station - other.state.station) / other.linear.distance
    return bool(max(turned, moved) <= SAME_SOLUTION)


def _vPv(trial: Trial) -> float:
    return trial[0].linear.vPv


def _place_of(trial: Trial, kept: Sequence[Trial]) -> int | None:
    """Number of the end that a trial shares."""
    for number, other in enumerate(kept):
        if trial[1] is other[1] and is_same_place(trial[0], other[0]):
            return number
    return None


def _end(task: Task, trial: Trial, is_as_good: bool) -> End:
    iterated, termination = trial
    state = iterated.state
    with np.errstate(all="ignore"):
        zs = project(state.ground, state.station, state.rotation, task.problem.focal_length(state))[1]
    return End(
        rotation=state.rotation,
        station=state.station + task.origin,
        vPv=iterated.linear.vPv,
        n_in_front=int(np.count_nonzero(zs < 0)),
        iterations=len(iterated.steps),
        termination=termination,
        is_as_good=is_as_good,
    )
