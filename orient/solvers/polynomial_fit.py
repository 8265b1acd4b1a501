"""The polynomial of a map sheet: digitiser (X, Y) -> (B, L) or (N, E), from the crosses of its graticule or grid."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry import polynomial
from orient.solvers.linear_adjustment import adjust, weakest_unknown
from orient.solvers.outlier_test import LEVEL, ShiftTest, mean_shift_test
from orient.solvers.polynomial_degree import (
    HIGHEST_DEGREE,
    Crosses,
    Rule,
    along_principal_axes,
    choose_degree,
    condition_ratio,
    design,
    frame,
    term_names,
    terms,
)
from orient.words import counted

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]

LINE_RATIO = 1e-3
"""Width to length of the crosses below which they are one line: a quarter of a millimetre on half a metre of paper."""
SINGULAR_RATIO = 1e-4
"""Singular-value ratio that is lost in the reading error of a map: refused."""
BY_TEST = Rule()


@dataclass(frozen=True, slots=True)
class SheetFit:
    """u = (X - X0)/scale, v = (Y - Y0)/scale; coordinate = sum of c_jk u^j v^k, order `exponents(degree)`.

    Two columns are B, L [deg] or N, E [m]. `residuals_m`, `redundancy_numbers` (1 - leverage) and `shift` have one row
    for each cross given, also for those that do not carry the fit: their redundancy number is NaN, their test None.
    """

    degree: int
    degree_chosen_by: str
    centre_mm: Vector
    scale_mm: float
    coefficients: Vector
    cofactor: Vector
    condition_ratio: float
    redundancy: int
    sigma0: Vector | None
    sigma0_m: Vector | None
    is_fit: Mask
    residuals_m: Vector
    redundancy_numbers: Vector
    shift: ShiftTest


@dataclass(frozen=True, slots=True)
class SheetPrediction:
    """Covariance of a point = rows Q rows' sigma0^2 (`cofactor` sigma0^2) + gradient Sigma_XY gradient' (reading).

    values (k, 2); gradient (k, 2, 2) = d(coordinate)/d(X, Y) per mm; rows (k, m) of the design; cofactor (k,)
    """

    values: Vector
    gradient: Vector
    rows: Vector
    cofactor: Vector


@dataclass(frozen=True, slots=True)
class Suspect:
    """A cross that the others contradict, named with the numbers of the moment at which it was found."""

    index: int
    statistic: float
    probability: float
    corrected_probability: float


def fit_sheet(crosses: Crosses, rule: Rule = BY_TEST, is_fit: Mask | None = None) -> SheetFit:
    """B = sum a_jk u^j v^k, L = sum b_jk u^j v^k (or N, E): least squares over the crosses, v = polynomial - given.

    `is_fit` (n,): crosses that carry the fit, all by default.

    Refuses (GeometryError) too few crosses, crosses on one line or on a curve of the degree, two crosses in one place.
    Source: seed 004, equation (1).
    """
    used = np.ones(len(crosses.XY), dtype=np.bool_) if is_fit is None else is_fit.astype(np.bool_)
    carrying = crosses.only(used)
    _refuse_few(len(carrying.XY), rule.degree, crosses.title)
    _refuse_repeated(carrying)
    _refuse_line(carrying)
    degree = choose_degree(carrying, rule)
    ratio = condition_ratio(carrying.XY, degree)
    _refuse_curve(carrying, degree, ratio)
    return _fit(crosses, carrying, degree, used, rule, ratio)


def predict(fit: SheetFit, XY: Vector) -> SheetPrediction:
    """Coordinates of digitised points XY (k, 2) [mm], with everything that their covariance needs."""
    u, v = ((XY - fit.centre_mm) / fit.scale_mm).T
    rows = polynomial.design(u, v, fit.degree)
    by_uv = polynomial.gradient(u, v, fit.degree)
    gradient = np.einsum("kmi,mc->kci", by_uv, fit.coefficients) / fit.scale_mm
    cofactor = np.einsum("km,mj,kj->k", rows, fit.cofactor, rows)
    return SheetPrediction(polynomial.values(u, v, fit.coefficients), gradient, rows, cofactor)


def suspects(
    crosses: Crosses, rule: Rule = BY_TEST, is_fit: Mask | None = None
) -> tuple[tuple[Suspect, ...], SheetFit]:
    """Bad crosses, the worst first, and the fit without them. Arguments as `fit_sheet`.

    The cross with the most improbable shift is named when its probability times the number of crosses is below 1 %;
    then the sheet is fitted without it (and its degree chosen anew unless given), while a redundancy of two remains.
    """
    found: list[Suspect] = []
    fit = fit_sheet(crosses, rule, is_fit)
    while (suspect := _worst(fit)) is not None:
        found.append(suspect)
        try:
            fit = fit_sheet(crosses, rule, fit.is_fit & (np.arange(len(crosses.XY)) != suspect.index))
        except GeometryError:
            # without this cross the sheet is not determined: name it, but keep the fit that exists
            break
    return tuple(found), fit


def _worst(fit: SheetFit) -> Suspect | None:
    worst = fit.shift.worst()
    if worst is None or worst[1] >= LEVEL:
        return None
    index, corrected = worst
    return Suspect(index, fit.shift.statistic[index] or 0.0, fit.shift.probability[index] or 0.0, corrected)


def _fit(crosses: Crosses, carrying: Crosses, degree: int, used: Mask, rule: Rule, ratio: float) -> SheetFit:
    centre, scale = frame(carrying.XY)
    F = design((crosses.XY - centre) / scale, degree)
    # numbers such as 6 213 023 m would cost digits in the coefficients of small terms
    origin = np.mean(carrying.target, axis=0)
    adjustment = adjust(term_names(degree), F[used], origin - carrying.target, rule.engine)
    residuals = F @ adjustment.X - (crosses.target - origin)
    coefficients = adjustment.X + np.outer(np.arange(F.shape[1]) == 0, origin)
    redundancy = int(used.sum()) - F.shape[1]
    return SheetFit(
        degree=degree,
        degree_chosen_by=rule.chosen_by,
        centre_mm=centre,
        scale_mm=scale,
        coefficients=coefficients,
        cofactor=adjustment.Q_x,
        condition_ratio=ratio,
        redundancy=redundancy,
        sigma0=_sigma0(residuals[used], redundancy),
        sigma0_m=_sigma0(residuals[used] * carrying.metres_per_unit, redundancy),
        is_fit=used,
        residuals_m=residuals * crosses.metres_per_unit,
        redundancy_numbers=_spread(adjustment.redundancy_numbers, used),
        shift=_shift(residuals[used], carrying, adjustment.redundancy_numbers, redundancy, used),
    )


def _shift(residuals: Vector, carrying: Crosses, numbers: Vector, redundancy: int, used: Mask) -> ShiftTest:
    # one mean factor for the sheet: residuals stay a projection of the errors, as the F distribution demands
    factor = np.mean(carrying.metres_per_unit, axis=0)
    test = mean_shift_test(residuals * factor, numbers, redundancy, carrying.rounding_m)
    if used.all():
        return test
    statistic, probability = iter(test.statistic), iter(test.probability)
    return ShiftTest(
        tuple(next(statistic) if is_used else None for is_used in used.tolist()),
        tuple(next(probability) if is_used else None for is_used in used.tolist()),
    )


def _sigma0(residuals: Vector, redundancy: int) -> Vector | None:
    if redundancy < 1:
        return None
    return np.asarray(np.sqrt(np.sum(residuals**2, axis=0) / redundancy))


def _spread(values: Vector, used: Mask) -> Vector:
    spread = np.full(len(used), np.nan)
    spread[used] = values
    return spread


def _refuse_few(n: int, degree: int | None, title: str) -> None:
    if degree is not None and not 1 <= degree <= HIGHEST_DEGREE:
        raise GeometryError(f"{title}: degree {degree} is not in 1 ... {HIGHEST_DEGREE}")
    needed = terms(degree) if degree is not None else terms(1) + 1
    if n >= needed:
        return
    crosses = f"{title}: {counted(n, 'cross', 'crosses')}"
    if degree is None:
        raise GeometryError(
            f"{crosses}; {needed} are needed to fit degree 1 with a check",
            "Measure more crosses" + (", or give degree = 1 to do without a check." if n == 3 else "."),
        )
    raise GeometryError(
        f"{crosses}; degree {degree} needs {needed}",
        "Measure more crosses or give a lower degree.",
    )


def _refuse_repeated(crosses: Crosses) -> None:
    in_order = crosses.XY[np.lexsort(crosses.XY.T)]
    if not (in_order[1:] == in_order[:-1]).all(axis=1).any():
        return
    first: dict[tuple[float, ...], str] = {}
    for label, place in zip(crosses.names, map(tuple, crosses.XY.tolist()), strict=True):
        if place in first:
            raise GeometryError(
                f"{crosses.title}: crosses {first[place]} and {label} have the same X, Y",
                "Remove or measure again one of them.",
            )
        first[place] = label


def _refuse_line(crosses: Crosses) -> None:
    along = along_principal_axes(crosses.XY)
    length, width = np.max(along, axis=0) - np.min(along, axis=0)
    if width < LINE_RATIO * length:
        raise GeometryError(
            f"{crosses.title}: the crosses lie on one line (off by {width:.3g} mm in {length:.4g} mm)",
            "Measure crosses on both sides of the line.",
        )


def _refuse_curve(crosses: Crosses, degree: int, ratio: float) -> None:
    XY = crosses.XY
    if degree > 1 and ratio < SINGULAR_RATIO:
        centre, scale = frame(XY)
        term = weakest_unknown(term_names(degree), design((XY - centre) / scale, degree))
        raise GeometryError(
            f"{crosses.title}: the {len(XY)} crosses lie on one curve of degree {degree} (such as {degree} straight "
            f"rows), so that degree {degree} is not determined: its term {term} depends on those before it",
            "Give a lower degree or measure crosses off the curve.",
        )
