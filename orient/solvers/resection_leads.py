"""Where the starts of a resection lead, found for all of them at once by the lean Gauss-Newton."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from orient.solvers.batch_iteration import Photos, gauss_newton
from orient.solvers.resection_result import Task
from orient.solvers.start_values import Candidate

MOST_POINTS = 1000
MOST_ITERATIONS = 20


def leads_of(task: Task, candidates: Sequence[Candidate]) -> list[Candidate | None]:
    """The orientation by full control points without errors that each start leads to; None if it is none.

    It takes no more than about 1000 of the points. Two starts with one lead have one end.
    """
    if len(candidates) < 2 and task.full.sum() <= MOST_POINTS:
        return [None] * len(candidates)
    at = np.flatnonzero(task.full)
    at = at[:: -(-len(at) // MOST_POINTS)]
    p, image, ground = len(candidates), task.problem.image[at], task.problem.known.given[at]
    starts = Photos(
        image=np.broadcast_to(image, (p, *image.shape)),
        ground=np.broadcast_to(ground, (p, *ground.shape)),
        f=np.full(p, task.problem.f_mm),
        rotation=np.array([one.rotation for one in candidates]),
        station=np.array([one.station for one in candidates]),
    )
    found = gauss_newton(starts, MOST_ITERATIONS)
    return [
        replace(one, rotation=R, station=S) if converged else None
        for one, R, S, converged in zip(candidates, found.rotation, found.station, found.converged, strict=True)
    ]
