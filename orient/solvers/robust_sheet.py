"""The crosses of a sheet that agree on one polynomial, when many of them may be wrong."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from orient.errors import GeometryError
from orient.solvers.consensus import BREAKDOWN, all_agreeing, least_trimmed, samples
from orient.solvers.critical_values import w_limits
from orient.solvers.polynomial_degree import Crosses, Rule, terms
from orient.solvers.polynomial_fit import SheetFit, fit_sheet, predict
from orient.solvers.snooping import Verdicts

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]

GRAPHIC_SIGMA_MM = 0.2
"""Error of a cross on a paper map, read by hand, where none is stated; five times that is no cross any more."""
HIGHEST = 3


def agreeing_crosses(crosses: Crosses, rule: Rule, sigma_mm: float | None) -> Mask:
    """Crosses (n,) that agree: least trimmed squares of the polynomial, from affine fits of triples of crosses.

    `sigma_mm` of one cross, 0.2 mm if not known. Without a degree the highest up to 3 that 60 % of them determine
    is taken at first, then the one that the rule finds on those that agree. Raises RobustFailed when more than 40 %
    contradict, or when none agree within five sigmas.
    """
    n = len(crosses.XY)
    first = rule.degree if rule.degree is not None else _highest(n - int(BREAKDOWN * n))
    agreeing = _agreeing(crosses, replace(rule, degree=first), sigma_mm)
    if rule.degree is not None:
        return agreeing
    chosen = fit_sheet(crosses, rule, agreeing).degree
    return agreeing if chosen == first else _agreeing(crosses, replace(rule, degree=chosen), sigma_mm)


def _agreeing(crosses: Crosses, rule: Rule, sigma_mm: float | None) -> Mask:
    n, m = len(crosses.XY), terms(rule.degree or 1)

    def fitted(chosen: Mask, of_rule: Rule = rule) -> SheetFit | None:
        try:
            return fit_sheet(crosses, of_rule, chosen)
        except GeometryError:
            return None

    def misfits(chosen: Mask, of_rule: Rule = rule) -> Vector | None:
        fit = fitted(chosen, of_rule)
        return None if fit is None else np.sum((fit.residuals_m / sigma_m) ** 2, axis=1)

    def judge(kept: Mask) -> Verdicts[SheetFit] | None:
        fit = fitted(kept)
        return None if fit is None else _verdicts(fit, crosses.XY, kept, sigma_m * trimmed.scale)

    affine = replace(rule, degree=1)
    sigma_m = (sigma_mm or GRAPHIC_SIGMA_MM) * _metres_per_mm(crosses.XY, crosses.target * crosses.metres_per_unit)
    triples = (np.isin(np.arange(n), triple) for triple in samples(range(n), terms(1)))
    starts = [T for triple in triples if (T := misfits(triple, affine)) is not None]
    trimmed = least_trimmed(starts, np.full(n, 2), 2 * m, m + 1, misfits)
    return all_agreeing(judge, trimmed, np.ones(n, dtype=np.bool_))


def _verdicts(fit: SheetFit, XY: Vector, kept: Mask, sigma_m: float) -> Verdicts[SheetFit]:
    """w of the crosses that carry the fit, chance of the misfit of the others."""
    limits = w_limits(1.0)
    numbers = np.where(fit.redundancy_numbers > 1e-9, fit.redundancy_numbers, np.nan)
    statistic = np.max(np.abs(fit.residuals_m), axis=1) / (sigma_m * np.sqrt(numbers))
    spread = sigma_m**2 * (1.0 + predict(fit, XY).cofactor)
    chance = np.asarray(chdtrc(2, np.sum(fit.residuals_m**2, axis=1) / spread))
    n = len(XY)
    return Verdicts(
        fit,
        2 * fit.redundancy,
        np.where(kept, statistic, np.nan),
        np.argmax(np.abs(fit.residuals_m), axis=1),
        limits.critical,
        np.full(n, 2),
        np.where(kept, np.nan, chance),
        lambda point: None,
    )


def _highest(h: int) -> int:
    """The highest degree up to 3 that h crosses determine with a redundancy of two crosses."""
    return max(degree for degree in range(1, HIGHEST + 1) if degree == 1 or terms(degree) + 2 <= h)


def _metres_per_mm(XY: Vector, metres: Vector) -> float:
    """Scale of the map: median ratio of distances between crosses, which some wrong ones do not move."""
    i, j = np.triu_indices(len(XY), 1)
    paper, ground = (np.linalg.norm(points[i] - points[j], axis=1) for points in (XY, metres))
    return float(np.median(ground / paper))
