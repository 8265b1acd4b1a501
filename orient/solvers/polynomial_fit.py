"""The polynomial of a map sheet: digitiser (X, Y) -> (B, L) or (N, E), from the crosses of its graticule or grid."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry import polynomial
from orient.solvers.outlier_test import LEVEL, ShiftTest, mean_shift_test
from orient.solvers.polynomial_degree import (
    F_TEST,
    HIGHEST_DEGREE,
    choose_degree,
    condition_ratio,
    design,
    frame,
    rounding_m,
    terms,
)

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]

LINE_RATIO = 1e-3
"""Width to length of the crosses below which they are one line: a quarter of a millimetre on half a metre of paper."""
SINGULAR_RATIO = 1e-4
"""Singular-value ratio that is lost in the reading error of a map: refused."""


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


def fit_sheet(
    XY: Vector,
    target: Vector,
    metres_per_unit: Vector,
    degree: int | None = None,
    is_fit: Mask | None = None,
    *,
    choice: str = F_TEST,
    sheet: str = "",
    names: Sequence[str] = (),
) -> SheetFit:
    """B = sum a_jk u^j v^k, L = sum b_jk u^j v^k (or N, E): least squares over the crosses, by QR.

    XY (n, 2) digitiser [mm]; target (n, 2) B, L [deg] or N, E [m]; metres_per_unit (n, 2) ground metres per unit of the
    target at each cross (M rho, N cos B rho; ones for a grid); `is_fit` (n,) crosses that carry the fit, all by
    default; `sheet`, `names` for the messages. v = polynomial - given.

    Without a `degree` it is chosen by `choice`: "f-test" or "leave-one-out" (`polynomial_degree`).

    Refuses (GeometryError) too few crosses, crosses on one line or on a curve of the degree, two crosses in one place.
    Source: seed 004, equation (1).
    """
    used = np.ones(len(XY), dtype=np.bool_) if is_fit is None else is_fit.astype(np.bool_)
    labels = tuple(names) or tuple(str(i + 1) for i in range(len(XY)))
    title = f"sheet {sheet}" if sheet else "the sheet"
    _refuse_few(int(used.sum()), degree, title)
    _refuse_repeated(XY[used], [label for label, is_used in zip(labels, used, strict=True) if is_used], title)
    _refuse_line(XY[used], title)
    chosen = degree if degree is not None else choose_degree(XY[used], target[used], metres_per_unit[used], choice)
    _refuse_curve(XY[used], chosen, title)
    return _fit(XY, target, metres_per_unit, chosen, used, choice if degree is None else "given")


def predict(fit: SheetFit, XY: Vector) -> SheetPrediction:
    """Coordinates of digitised points XY (k, 2) [mm], with everything that their covariance needs."""
    u, v = ((XY - fit.centre_mm) / fit.scale_mm).T
    rows = polynomial.design(u, v, fit.degree)
    by_uv = polynomial.gradient(u, v, fit.degree)
    gradient = np.einsum("kmi,mc->kci", by_uv, fit.coefficients) / fit.scale_mm
    cofactor = np.einsum("km,mj,kj->k", rows, fit.cofactor, rows)
    return SheetPrediction(rows @ fit.coefficients, gradient, rows, cofactor)


def suspects(
    XY: Vector,
    target: Vector,
    metres_per_unit: Vector,
    degree: int | None = None,
    is_fit: Mask | None = None,
    *,
    choice: str = F_TEST,
    sheet: str = "",
    names: Sequence[str] = (),
) -> tuple[tuple[Suspect, ...], SheetFit]:
    """Bad crosses, the worst first, and the fit without them. Arguments as `fit_sheet`.

    The cross with the most improbable shift is named when its probability times the number of crosses is below 1 %;
    then the sheet is fitted without it (and its degree chosen anew unless given), while a redundancy of two remains.
    """
    used = np.ones(len(XY), dtype=np.bool_) if is_fit is None else is_fit.astype(np.bool_)
    found: list[Suspect] = []
    fit = fit_sheet(XY, target, metres_per_unit, degree, used, choice=choice, sheet=sheet, names=names)
    while (suspect := _worst(fit)) is not None:
        found.append(suspect)
        used = used & (np.arange(len(XY)) != suspect.index)
        try:
            fit = fit_sheet(XY, target, metres_per_unit, degree, used, choice=choice, sheet=sheet, names=names)
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


def _fit(XY: Vector, target: Vector, metres_per_unit: Vector, degree: int, used: Mask, chosen_by: str) -> SheetFit:
    centre, scale = frame(XY[used])
    F = design((XY - centre) / scale, degree)
    # numbers such as 6 213 023 m would cost digits in the coefficients of small terms
    origin = np.mean(target[used], axis=0)
    Q_factor, R_factor = np.linalg.qr(F[used])
    R_inverse = np.linalg.solve(R_factor, np.eye(len(R_factor)))
    coefficients = R_inverse @ (Q_factor.T @ (target[used] - origin))
    residuals = F @ coefficients - (target - origin)
    coefficients[0] += origin
    redundancy = int(used.sum()) - F.shape[1]
    leverage = np.sum(Q_factor**2, axis=1)
    return SheetFit(
        degree=degree,
        degree_chosen_by=chosen_by,
        centre_mm=centre,
        scale_mm=scale,
        coefficients=coefficients,
        cofactor=R_inverse @ R_inverse.T,
        condition_ratio=condition_ratio(XY[used], degree),
        redundancy=redundancy,
        sigma0=_sigma0(residuals[used], redundancy),
        sigma0_m=_sigma0(residuals[used] * metres_per_unit[used], redundancy),
        is_fit=used,
        residuals_m=residuals * metres_per_unit,
        redundancy_numbers=_spread(1.0 - leverage, used),
        shift=_shift(residuals[used], target[used], metres_per_unit[used], 1.0 - leverage, redundancy, used),
    )


def _shift(
    residuals: Vector, target: Vector, metres_per_unit: Vector, numbers: Vector, redundancy: int, used: Mask
) -> ShiftTest:
    # one mean factor for the sheet: residuals stay a projection of the errors, as the F distribution demands
    factor = np.mean(metres_per_unit, axis=0)
    test = mean_shift_test(residuals * factor, numbers, redundancy, rounding_m(target, metres_per_unit))
    place = np.cumsum(used) - 1
    return ShiftTest(
        tuple(test.statistic[k] if is_used else None for k, is_used in zip(place, used, strict=True)),
        tuple(test.probability[k] if is_used else None for k, is_used in zip(place, used, strict=True)),
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
    if degree is None:
        raise GeometryError(
            f"{title}: {n} crosses; {needed} are needed to fit degree 1 with a check",
            "Measure more crosses" + (", or give degree = 1 to do without a check." if n == 3 else "."),
        )
    raise GeometryError(
        f"{title}: {n} crosses; degree {degree} needs {needed}", "Measure more crosses or give a lower degree."
    )


def _refuse_repeated(XY: Vector, labels: Sequence[str], title: str) -> None:
    first: dict[tuple[float, ...], str] = {}
    for label, place in zip(labels, map(tuple, XY.tolist()), strict=True):
        if place in first:
            raise GeometryError(
                f"{title}: crosses {first[place]} and {label} have the same X, Y",
                "Remove or measure again one of them.",
            )
        first[place] = label


def _refuse_line(XY: Vector, title: str) -> None:
    centred = XY - np.mean(XY, axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2].T
    length, width = np.max(along, axis=0) - np.min(along, axis=0)
    if width < LINE_RATIO * length:
        raise GeometryError(
            f"{title}: the crosses lie on one line (off by {width:.3g} mm in {length:.4g} mm)",
            "Measure crosses on both sides of the line.",
        )


def _refuse_curve(XY: Vector, degree: int, title: str) -> None:
    if degree > 1 and condition_ratio(XY, degree) < SINGULAR_RATIO:
        raise GeometryError(
            f"{title}: the {len(XY)} crosses lie on one curve of degree {degree} (such as {degree} straight rows), "
            f"so that degree {degree} is not determined",
            "Give a lower degree or measure crosses off the curve.",
        )
