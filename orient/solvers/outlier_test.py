"""Is one observation wrong? Tests of a shift in the mean of a single observation of a linear adjustment.

The residual that is tested is compared with a sigma to which the tested observation itself does not contribute
(externally studentised), so that a gross error cannot hide behind the spread it makes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

LEVEL = 0.01
"""Chance that a list without any gross error has one named, all its observations together (Bonferroni)."""

SMALLEST_REDUNDANCY_NUMBER = 1e-9
"""Below this share the residual is rounding noise: the observation is not checked by the others."""


@dataclass(frozen=True, slots=True)
class ShiftTest:
    """One test per observation; None where the others do not check it.

    statistic    F of the hypothesis that only this observation is wrong
    probability  chance of so large a statistic without an error
    """

    statistic: tuple[float | None, ...]
    probability: tuple[float | None, ...]

    def worst(self) -> tuple[int, float] | None:
        """Index and Bonferroni probability of the most improbable observation; None if none can be tested."""
        tested = [(p, i) for i, p in enumerate(self.probability) if p is not None]
        if not tested:
            return None
        # with probabilities that underflow to equal values the larger statistic decides
        probability, index = min(tested, key=lambda pair: (pair[0], -(self.statistic[pair[1]] or 0.0)))
        return index, bonferroni(probability, len(tested))


def mean_shift_test(residuals: Vector, redundancy_numbers: Vector, redundancy: int, noise: float = 0.0) -> ShiftTest:
    """F = (|v_i|^2 / (k r_i)) / s_i^2, s_i^2 = (sum |v|^2 - |v_i|^2/r_i) / (k (r - 1)), is F(k, k (r - 1)).

    Observation i has k coordinates with the same design and the same standard deviation; the alternative lets all its
    k coordinates have any error. v_i v_i'/r_i is what the error takes from the sum of squares, so s_i is the sigma of
    the adjustment without observation i, and F is the likelihood ratio test of the alternative.

    residuals (n, k), redundancy_numbers (n,) = 1 - leverage, redundancy r = n - u of one coordinate; `noise` is the
    rounding error of a residual, below which s_i is not believed. Without a rest of redundancy (r < 2), or for an
    observation with leverage 1, there is no test: None.

    Source: R. D. Cook, S. Weisberg, Residuals and Influence in Regression, 1982, 2.2.2 (k = 1: squared externally
    studentised residual); W. Baarda 1968 for the known sigma.
    """
    n, k = residuals.shape
    if redundancy < 2:
        return ShiftTest((None,) * n, (None,) * n)
    is_tested = redundancy_numbers > SMALLEST_REDUNDANCY_NUMBER
    share = np.sum(residuals**2, axis=1) / np.where(is_tested, redundancy_numbers, 1.0)
    freedom = k * (redundancy - 1)
    rest = np.maximum(np.sum(residuals**2) - share, 0.0) / freedom
    statistic = share / k / np.maximum(rest, max(noise, 1e-150) ** 2)
    probability = f_probability(statistic, k, freedom)
    return ShiftTest(_or_none(statistic, is_tested), _or_none(probability, is_tested))


def f_probability(statistic: Vector, numerator: int, denominator: int) -> Vector:
    """P(F > statistic) of the F distribution."""
    from scipy.special import fdtrc

    return np.asarray(fdtrc(numerator, denominator, statistic), dtype=np.float64)


def t_probability(statistic: Vector, freedom: Vector) -> Vector:
    """P(|t| > statistic) of Student's distribution, `statistic` >= 0."""
    from scipy.special import stdtr

    return np.asarray(2.0 * stdtr(freedom, -statistic), dtype=np.float64)


def bonferroni(probability: float, tests: int) -> float:
    """Bound of the chance that one of `tests` tests without an error is so improbable."""
    return min(1.0, probability * tests)


def _or_none(values: Vector, is_known: NDArray[np.bool_]) -> tuple[float | None, ...]:
    return tuple(value if known else None for value, known in zip(values.tolist(), is_known.tolist(), strict=True))
