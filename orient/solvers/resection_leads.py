"""Where the starts of a resection lead, found for all of them at once by the lean Gauss-Newton."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from orient.solvers.batch_iteration import Photos, gauss_newton
from orient.solvers.resection_result import Task
from orient.solvers.start_values import Candidate, first_alike

MOST_POINTS = 1000
MOST_ITERATIONS = 20
SAME_LEAD = 1e-6


@dataclass(frozen=True, slots=True)
class Lead:
    """Where a start leads (the start itself, if that is no orientation), and the first start that leads there."""

    start: Candidate
    first: int


def leads_of(task: Task, candidates: Sequence[Candidate]) -> list[Lead]:
    """Orientations by full control points, no more than about 1000 and as if without errors: one for each start."""
    at = np.flatnonzero(task.full)
    at = at[:: -(-len(at) // MOST_POINTS)]
    p, image, ground = len(candidates), task.problem.image[at], task.problem.known.given[at]
    rotations = np.array([one.rotation for one in candidates]).reshape(-1, 3, 3)
    stations = np.array([one.station for one in candidates]).reshape(-1, 3)
    starts = Photos(
        image=np.broadcast_to(image, (p, *image.shape)),
        ground=np.broadcast_to(ground, (p, *ground.shape)),
        f=np.full(p, task.problem.f_mm),
        rotation=rotations,
        station=stations,
    )
    found = gauss_newton(starts, MOST_ITERATIONS)
    good = np.flatnonzero(found.converged)
    rotations[good], stations[good] = found.rotation[good], found.station[good]
    firsts = np.arange(p)
    firsts[good] = good[first_alike(rotations[good], stations[good], ground, SAME_LEAD, len(good))]
    leads = zip(candidates, rotations, stations, firsts.tolist(), strict=True)
    return [Lead(replace(one, rotation=R, station=S), first) for one, R, S, first in leads]
