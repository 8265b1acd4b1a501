"""Small linear adjustments whose tests can be computed densely, as blocks of observations."""

import numpy as np
from numpy.typing import NDArray

from orient.solvers.critical_values import Limits, w_limits
from orient.solvers.reliability import Blocks, observation_tests, prediction_statistic
from orient.solvers.snooping import Verdicts, fit_probability

FloatArray = NDArray[np.float64]


def blocks_of(A: FloatArray, L: FloatArray, weight: FloatArray | None = None) -> Blocks:
    """Equations v = A x + L in blocks: A (n, k, u), L (n, k), weights (n, k, k); v at the least squares solution."""
    n, k, u = A.shape
    P = np.tile(np.eye(k), (n, 1, 1)) if weight is None else weight
    root = np.linalg.cholesky(P).transpose(0, 2, 1)
    white, free = (root @ A).reshape(-1, u), (root @ L[:, :, None]).ravel()
    x = -np.linalg.lstsq(white, free, rcond=None)[0]
    return Blocks(root, np.linalg.inv(root), A, A @ x + L)


def solution(A: FloatArray, L: FloatArray) -> FloatArray:
    u = A.shape[2]
    return np.asarray(-np.linalg.lstsq(A.reshape(-1, u), L.ravel(), rcond=None)[0])


def judged(A: FloatArray, L: FloatArray, kept: NDArray[np.bool_], limits: Limits | None = None) -> Verdicts[FloatArray]:
    """The verdicts of an adjustment of unit weight without some blocks."""
    limits = w_limits(1.0) if limits is None else limits
    x = solution(A[kept], L[kept])
    inside = blocks_of(A[kept], L[kept])
    tests = observation_tests([inside], limits, A.shape[2])
    outside = Blocks(
        np.tile(np.eye(A.shape[1]), (int((~kept).sum()), 1, 1)), np.zeros(0), A[~kept], A[~kept] @ x + L[~kept]
    )
    statistic, worst, probability = np.full(len(A), np.nan), np.full(len(A), -1), np.full(len(A), np.nan)
    w = np.nan_to_num(np.abs(tests.tests[0].w))
    statistic[kept], worst[kept] = w.max(axis=1), w.argmax(axis=1)
    redundancy = int(kept.sum()) * A.shape[1] - A.shape[2]
    if (~kept).any():
        T, freedom = prediction_statistic(outside, tests, limits)
        probability[~kept] = fit_probability(T, freedom, redundancy, limits)

    def twin(point: int) -> tuple[int, float] | None:
        from orient.solvers.reliability import most_correlated

        place = (0, int(np.flatnonzero(kept).tolist().index(point)), int(worst[point]))
        near = most_correlated(tests.tests, [place]).get(place)
        return None if near is None else (int(np.flatnonzero(kept)[near.partner[1]]), near.rho)

    return Verdicts(x, redundancy, statistic, worst, limits.critical, np.full(len(A), A.shape[1]), probability, twin)
