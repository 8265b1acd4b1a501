"""The same resection with some of its points: from many points, the way from a rough start needs only a part."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from orient.solvers.ground_points import GroundKnowledge
from orient.solvers.resection_problem import ResectionProblem
from orient.solvers.resection_result import Task

MANY_POINTS = 2000
"""From so many points on, starts are led to their ends with a sample."""
SAMPLE = 1000


def sample_of(task: Task) -> Task | None:
    """The task with every k-th point, at least `SAMPLE` of them; None for a photo without many points.

    A photo whose sample has fewer than `SAMPLE` / 2 full control points is not sampled.
    """
    n = len(task.problem.image)
    if n < MANY_POINTS:
        return None
    at = np.arange(0, n, n // SAMPLE)
    if np.count_nonzero(task.full[at]) < SAMPLE // 2:
        return None
    names = [task.names[i] for i in at.tolist()]
    return replace(task, problem=_problem_at(task.problem, at), full=task.full[at], names=names)


def _problem_at(problem: ResectionProblem, at: NDArray[np.intp]) -> ResectionProblem:
    known, common = problem.known, problem.common
    return replace(
        problem,
        image=problem.image[at],
        image_cofactor=problem.image_cofactor[at],
        known=GroundKnowledge(
            known.given[at], known.free[at], known.weight_root[at], known.free_rank[at], known.weight_rank[at]
        ),
        shared=replace(common, by_ground=common.by_ground[at], by_image=common.by_image[at]),
        interior=None if problem.interior is None else problem.interior.of(at),
    )
