"""Where the starts of a resection lead, found for all of them at once by the lean Gauss-Newton."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orient.solvers.batch_iteration import Photos, gauss_newton
from orient.solvers.resection_result import Task
from orient.solvers.start_values import Candidate, first_alike

MOST_POINTS = 1000
MOST_ITERATIONS = 20
SAME_LEAD = 1e-6
UNEVEN, ENOUGH_POINTS = 10.0, 500
"""Largest over smallest variance of points from which the sure ones may have rivals of their own; not among so many."""


@dataclass(frozen=True, slots=True)
class Lead:
    """Where a start leads (the start itself, if that is no orientation), and the first start that leads there."""

    start: Candidate
    first: int


def leads_of(task: Task, candidates: Sequence[Candidate]) -> list[Lead]:
    """Orientations by full control points, no more than about 1000 and as if without errors: one for each start.

    Of few points that are far from equally sure there is no lead but the start itself: those that count have others.
    """
    at = np.flatnonzero(task.full)
    if len(at) < ENOUGH_POINTS and _are_uneven(task, at, candidates[0].station):
        return [Lead(one, number) for number, one in enumerate(candidates)]
    at = at[:: -(-len(at) // MOST_POINTS)]
    p, image, ground = len(candidates), task.problem.image[at], task.problem.known.given[at]
    starts = Photos(
        image=np.broadcast_to(image, (p, *image.shape)),
        ground=np.broadcast_to(ground, (p, *ground.shape)),
        f=np.full(p, task.problem.f_mm),
        rotation=np.array([one.rotation for one in candidates]).reshape(-1, 3, 3),
        station=np.array([one.station for one in candidates]).reshape(-1, 3),
    )
    found = gauss_newton(starts, MOST_ITERATIONS)
    good = np.flatnonzero(found.converged)
    firsts = np.arange(p)
    firsts[good] = good[first_alike(found.rotation[good], found.station[good], ground, SAME_LEAD, len(good))]
    leads = list(candidates)
    for k in good.tolist():
        leads[k] = replace(candidates[k], rotation=found.rotation[k], station=found.station[k])
    return list(map(Lead, leads, firsts.tolist()))


def _are_uneven(task: Task, at: NDArray[np.intp], station: NDArray[np.float64]) -> bool:
    """By the variances in the image of reading and control together, seen from about the right distance."""
    problem, known = task.problem, task.problem.known
    per_metre = problem.f_mm / np.linalg.norm(known.given[at].mean(axis=0) - station)
    variances = np.trace(problem.image_cofactor[at], axis1=1, axis2=2) / 2
    weighted = np.flatnonzero(known.weight_rank[at])
    if len(weighted):
        roots = np.linalg.svd(known.weight_root[at[weighted]], compute_uv=False)
        least = roots[np.arange(len(weighted)), known.weight_rank[at[weighted]] - 1]
        variances[weighted] += (per_metre / least) ** 2
    return bool(np.max(variances) > UNEVEN * np.min(variances))
