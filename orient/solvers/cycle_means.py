"""Means of readings in cycles, the sigma of a reading from their spread, and readings that differ from the others."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.solvers.outlier_test import LEVEL, t_probability

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]
Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class CycleMeans:
    """Per point (k): `points` in order of appearance, means (k, 2), n_used (k,), sigma_point (k,) of one reading
    from the point's own cycles (NaN for one). Per reading (n): point_index, deviations (n, 2) = mean - reading,
    statistic and probability (None for a reading without a partner), is_outlier, is_used.

    sigma_xy (2,): standard deviation of one reading in x and in y from all points; sigma: both together;
    redundancy: readings minus points, for each coordinate. The sigmas are None without repeated readings.
    """

    points: tuple[str, ...]
    means: Vector
    n_used: Numbers
    sigma_point: Vector
    point_index: Numbers
    deviations: Vector
    statistic: tuple[float | None, ...]
    probability: tuple[float | None, ...]
    is_outlier: Mask
    is_used: Mask
    sigma_xy: Vector | None
    sigma: float | None
    redundancy: int


@dataclass(frozen=True, slots=True)
class _Spread:
    """Counts, means and sums of squared deviations of the points from the readings that `is_used` marks."""

    counts: Numbers
    means: Vector
    squares: Vector


def cycle_means(points: Sequence[str], xy: Vector, *, reject: bool = False) -> CycleMeans:
    """t = |mean - reading| / (s sqrt(1 - 1/n)), s from all OTHER points, is Student's t; the worst of x and y counts.

    points (n,) name of the point of each reading, xy (n, 2) readings, any unit; a point may have any number of
    cycles. s^2 = sum of squared deviations / sum (n - 1) over the other points, separately for x and y, so that a
    gross error does not raise the sigma it is measured with. A reading is an outlier when its probability times the
    number of tested coordinates is below 1 %. The worst reading of a point is named first and its point tested again
    without it; of two readings that differ both are named, because nothing tells which one is right.

    With `reject` outliers do not enter the mean where at least two readings of the point are left; else all stay.
    A single point in cycles has no others to compare with: no test.
    Source: R. D. Cook, S. Weisberg, Residuals and Influence in Regression, 1982, 2.2 (one-way layout, leverage 1/n).
    """
    names, index = _numbered(points)
    statistic, probability, is_outlier = _find_outliers(index, len(names), xy)
    is_used = _used(index, len(names), is_outlier) if reject else np.ones(len(xy), dtype=np.bool_)
    spread = _spread(index, len(names), xy, is_used)
    freedom = spread.counts - 1
    redundancy = int(freedom.sum())
    own = np.sqrt(spread.squares.sum(axis=1) / np.where(freedom > 0, 2 * freedom, 1))
    return CycleMeans(
        points=names,
        means=spread.means,
        n_used=spread.counts,
        sigma_point=np.where(freedom > 0, own, np.nan),
        point_index=index,
        deviations=spread.means[index] - xy,
        statistic=statistic,
        probability=probability,
        is_outlier=is_outlier,
        is_used=is_used,
        sigma_xy=np.sqrt(spread.squares.sum(axis=0) / redundancy) if redundancy else None,
        sigma=float(np.sqrt(spread.squares.sum() / (2 * redundancy))) if redundancy else None,
        redundancy=redundancy,
    )


def _numbered(points: Sequence[str]) -> tuple[tuple[str, ...], Numbers]:
    number: dict[str, int] = {}
    index = np.array([number.setdefault(point, len(number)) for point in points], dtype=np.int64)
    return tuple(number), index


def _spread(index: Numbers, n_points: int, xy: Vector, is_used: Mask) -> _Spread:
    counts = np.bincount(index[is_used], minlength=n_points)
    # reduced to the first reading of each point: equal readings give an exact zero
    first = np.zeros((n_points, 2))
    first[index[::-1]] = xy[::-1]
    reduced = xy - first[index]
    means = np.column_stack([_sums(index, n_points, reduced[:, c], is_used) for c in (0, 1)])
    means /= np.maximum(counts, 1)[:, None]
    squared = (means[index] - reduced) ** 2
    squares = np.column_stack([_sums(index, n_points, squared[:, c], is_used) for c in (0, 1)])
    return _Spread(counts, first + means, squares)


def _sums(index: Numbers, n_points: int, values: Vector, is_used: Mask) -> Vector:
    return np.asarray(np.bincount(index[is_used], weights=values[is_used], minlength=n_points), dtype=np.float64)


def _find_outliers(
    index: Numbers, n_points: int, xy: Vector
) -> tuple[tuple[float | None, ...], tuple[float | None, ...], Mask]:
    """Worst first: each round names at most one reading of a point, or both of the last two."""
    n = len(index)
    statistic, probability = np.full(n, np.nan), np.full(n, np.nan)
    is_outlier, is_pair = np.zeros(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
    tests = 2 * int(np.sum(np.bincount(index, minlength=n_points)[index] > 1))
    while True:
        t, p = _studentized(index, n_points, xy, ~is_outlier, is_pair)
        tested = ~is_outlier & ~is_pair & np.isfinite(p)
        statistic[tested], probability[tested] = t[tested], p[tested]
        bad = tested & (p * tests < LEVEL)
        if not bad.any():
            return _or_none(statistic), _or_none(probability), is_outlier | is_pair
        counts = np.bincount(index[~is_outlier], minlength=n_points)[index]
        # at the critical value rounding may part the two readings of a pair
        is_pair |= np.isin(index, index[bad & (counts == 2)]) & ~is_outlier
        is_outlier |= _worst_of_each_point(index, n_points, t, bad & (counts > 2))


def _studentized(index: Numbers, n_points: int, xy: Vector, is_active: Mask, is_pair: Mask) -> tuple[Vector, Vector]:
    """The larger t of x and y and its probability for each active reading; NaN where there is no test."""
    spread = _spread(index, n_points, xy, is_active)
    # two readings that differ tell nothing about the sigma of good ones
    differs = np.bincount(index[is_pair], minlength=n_points) > 0
    freedom = np.where(differs, 0, np.maximum(spread.counts - 1, 0))
    squares = np.where(differs[:, None], 0.0, spread.squares)
    rest_freedom = (freedom.sum() - freedom)[index]
    rest = np.maximum(squares.sum(axis=0) - squares, 0.0)[index]
    count = spread.counts[index]
    is_tested = (count > 1) & (rest_freedom > 0)
    share = np.where(is_tested, 1.0 - 1.0 / np.maximum(count, 2), 1.0)
    sigma = np.sqrt(rest / np.maximum(rest_freedom, 1)[:, None])
    # coordinates are not resolved below their rounding error
    sigma = np.maximum(sigma, 16.0 * np.finfo(np.float64).eps * max(float(np.max(np.abs(xy), initial=0.0)), 1e-300))
    t = np.max(np.abs(spread.means[index] - xy) / (sigma * np.sqrt(share)[:, None]), axis=1)
    p = t_probability(t, np.maximum(rest_freedom, 1).astype(np.float64))
    return np.where(is_tested, t, np.nan), np.where(is_tested, p, np.nan)


def _worst_of_each_point(index: Numbers, n_points: int, t: Vector, candidates: Mask) -> Mask:
    largest = np.full(n_points, -np.inf)
    np.maximum.at(largest, index[candidates], t[candidates])
    worst = np.zeros(len(index), dtype=np.bool_)
    rows = np.flatnonzero(candidates & (t == largest[index]))
    # of equal ones the first
    worst[rows[np.unique(index[rows], return_index=True)[1]]] = True
    return worst


def _used(index: Numbers, n_points: int, is_outlier: Mask) -> Mask:
    remaining = np.bincount(index[~is_outlier], minlength=n_points)
    return ~is_outlier | (remaining < 2)[index]


def _or_none(values: Vector) -> tuple[float | None, ...]:
    return tuple(None if np.isnan(value) else float(value) for value in values)
