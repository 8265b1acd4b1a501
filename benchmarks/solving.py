"""Resections: one photo, weighted control, many photos, growth."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

import orient
from benchmarks import peers
from benchmarks.measuring import Task, compiled
from benchmarks.peers import Orientation
from benchmarks.scenes import F_MM, POINT_SIGMA_M, SIGMA_MM, Photo, photo, photos
from orient.solvers.batch_iteration import BatchResection
from orient.solvers.lean_resection import LeanResection, lean_resection
from orient.solvers.resection import resect
from orient.solvers.resection_batch import resection_batch
from orient.solvers.resection_result import Resection

Array = NDArray[np.float64]
TARGETS = {6: 1.2, 20: 1.2, 100: 1.0, 1000: 0.5, 10_000: 0.3, 100_000: 0.5, 1_000_000: None}
COMPILED = {10_000: 0.04, 100_000: 0.04}
WEIGHTED = {20: 0.25, 100: 0.06, 1000: 0.07, 10_000: None}
MANY = 10_000


def tasks() -> Iterator[Task]:
    yield from map(_single, TARGETS)
    yield from map(_from_nothing, (6, 20, 100))
    yield from map(_weighted, WEIGHTED)
    yield from map(_full_covariance, (100, 300))
    yield _batch()
    yield from (_pipeline_solver(n) for n in (10, 100, 1000, 10_000, 100_000))


def _orientation(found: LeanResection | BatchResection | Resection) -> Orientation:
    return Orientation(found.rotation, found.station, SIGMA_MM**2 * found.Q, found.vPv)


def _numbers(found: Orientation) -> list[Array]:
    """R, S, standard deviations of r and S, correlations, v'v."""
    covariance = found.covariance.reshape(-1, 6, 6)
    sigmas = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    correlations = covariance / sigmas[:, :, None] / sigmas[:, None]
    kinds = (found.rotation, found.station, sigmas[:, :3], sigmas[:, 3:], correlations, found.vv)
    return [np.ravel(kind) for kind in kinds]


def _single(n: int) -> Task:
    one = photo(n)

    def own() -> Orientation:
        return _orientation(lean_resection(one.image, one.ground, F_MM, one.R0, one.S0))

    def by_numba() -> Orientation:
        found = resection_batch(one.image[None], one.ground[None], F_MM, one.R0[None], one.S0[None], compiled=True)
        return _orientation(found)

    def checked() -> Orientation:
        return _orientation(orient.resection(one.image, one.ground, F_MM, one.R0, one.S0))

    rough = (one.image, one.ground, one.R0, one.S0)
    candidates: dict[str, Callable[[], object]] = {"orient": own, "orient, arguments checked": checked}
    if n >= 10_000:
        candidates |= compiled(by_numba)
    candidates["PoseLib + covariance"] = partial(peers.poselib_refined, *rough)
    if n <= 1000:
        candidates["OpenCV LM + covariance"] = partial(peers.opencv_refined, *rough)
    name, line = f"resection, n = {n}", ("lean resection", n)
    note = "by the solver, and by `orient.resection`, which looks at its arguments first"
    return Task(name, candidates, TARGETS[n], 1e-5, line, note, numba_target=COMPILED.get(n), compared=_numbers)


def _from_nothing(n: int) -> Task:
    one = photo(n)

    def own() -> Orientation:
        return _orientation(resection_batch(one.image[None], one.ground[None], F_MM))

    anchor = {"OpenCV SQPNP + LM + covariance": partial(peers.opencv_from_nothing, one.image, one.ground)}
    return Task(f"no starting values, n = {n}", {"orient": own, **anchor}, 1.5, 1e-4, compared=_numbers)


def _weighted(n: int) -> Task:
    one, S = photo(n), _cofactors(n)

    def own() -> Orientation:
        return _orientation(lean_resection(one.image, one.given, F_MM, one.R0, one.S0, S))

    anchor = {"GTSAM + marginal": partial(peers.gtsam_weighted, one.image, one.given, one.R0, one.S0)}
    name, line = f"weighted control, n = {n}", ("weighted control", n)
    return Task(name, {"orient": own, **anchor}, WEIGHTED[n], 1e-4, line, compared=_numbers)


def _cofactors(n: int) -> Array:
    return np.tile(np.diag(POINT_SIGMA_M**2) / SIGMA_MM**2, (n, 1, 1))


def _full_covariance(n: int) -> Task:
    one, S = photo(n), _cofactors(n)

    def own() -> Array:
        return SIGMA_MM**2 * lean_resection(one.image, one.given, F_MM, one.R0, one.S0, S).joint_cofactors

    dense = partial(peers.dense_weighted, one.image, one.given, one.R0, one.S0)
    name = f"weighted control + full (6+3n)^2 covariance, n = {n}"
    return Task(name, {"orient": own, "dense normal equations": dense}, 0.04 if n == 100 else None, 1e-6)


def _batch() -> Task:
    image, ground, R0, S0 = photos(MANY, 12)

    def own(compiled: bool) -> Orientation:
        return _orientation(resection_batch(image, ground, F_MM, R0, S0, compiled=compiled))

    def loop() -> Orientation:
        found = [peers.poselib_refined(*each) for each in zip(image, ground, R0, S0, strict=True)]
        return Orientation(*map(np.array, zip(*found, strict=True)))

    candidates = {"orient": partial(own, False), **compiled(partial(own, True)), "loop over PoseLib + covariance": loop}
    return Task(f"{MANY} photos x 12 points", candidates, 0.08, 1e-5, numba_target=0.025, compared=_numbers)


def _pipeline_solver(n: int) -> Task:
    """The solver behind `orient resection`: starts, iterations, cofactors, redundancy numbers of every point."""
    one: Photo = photo(n)
    cofactor = np.tile(np.eye(2), (n, 1, 1))

    def full() -> Orientation:
        return _orientation(resect(one.image, cofactor, one.ground, F_MM))

    def lean() -> Orientation:
        return _orientation(lean_resection(one.image, one.ground, F_MM, one.R0, one.S0))

    note = "all starts, all iterations and all tests' numbers are kept; informs only"
    name = f"full adjustment without start against the lean one, n = {n}"
    line, candidates = ("full adjustment", n), {"orient": full, "its own lean resection": lean}
    return Task(name, candidates, None, 1e-5, line, note, compared=_numbers)
