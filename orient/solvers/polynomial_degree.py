"""Which degree a sheet's polynomial deserves: by an F test of its gain, or by predicting each cross from the others."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry import polynomial
from orient.solvers.outlier_test import SMALLEST_REDUNDANCY_NUMBER, f_probability

Vector = NDArray[np.float64]

F_TEST = "f-test"
LEAVE_ONE_OUT = "leave-one-out"
CHOICES = (F_TEST, LEAVE_ONE_OUT)
HIGHEST_DEGREE = 5
DEGREE_LEVEL = 0.05
"""A higher degree is taken when its gain would come by chance in less than one of 20 sheets."""
WEAK_RATIO = 1e-3
"""Singular-value ratio below which a degree is not taken unless it is given."""


@dataclass(frozen=True, slots=True)
class DegreeChoice:
    """The degree by each rule, and the root mean square prediction error [m] of the degrees that were tried."""

    f_test: int
    leave_one_out: int
    prediction_m: dict[int, float]

    def by(self, choice: str) -> int:
        return self.leave_one_out if choice == LEAVE_ONE_OUT else self.f_test


def degree_choices(XY: Vector, target: Vector, metres_per_unit: Vector) -> DegreeChoice:
    """Both choices for the crosses XY (n, 2) [mm] with target and metres_per_unit (n, 2), at least four crosses."""
    factor = np.mean(metres_per_unit, axis=0)
    noise = rounding_m(target, metres_per_unit)
    errors = _prediction_errors(XY, target * factor)
    rms = {degree: float(np.sqrt(np.mean(np.sum(e**2, axis=1)))) for degree, e in errors.items()}
    return DegreeChoice(_by_f_test(XY, target * factor, noise), _by_leave_one_out(errors, noise), rms)


def choose_degree(XY: Vector, target: Vector, metres_per_unit: Vector, choice: str = F_TEST) -> int:
    """The degree by one of the two rules; arguments as `degree_choices`.

    f-test: goes up from 1 as long as F = ((V_d - V_e)/(2 (m_e - m_d))) / (V_e/(2 r_e)) of the next degree e, both
    coordinates together, is improbable (5 %); ends after two steps that gain nothing.

    leave-one-out: PRESS_d = sum over the crosses of (e_i/(1 - h_i))^2, h the diagonal of the hat matrix. The smallest
    PRESS names the best degree; taken is the LOWEST degree whose PRESS exceeds it by no more than one standard error
    of the difference, sqrt(n) std_i(difference of cross i): of equals the one with fewer coefficients.

    Both try only degrees that leave a redundancy of two crosses and that the crosses determine well (singular-value
    ratio 1e-3); leave-one-out also demands that no cross carries a coefficient alone (h_i = 1: it cannot be predicted).
    Source: D. M. Allen 1974 (PRESS); L. Breiman et al. 1984 (one standard error).
    """
    factor = np.mean(metres_per_unit, axis=0)
    noise = rounding_m(target, metres_per_unit)
    if choice == LEAVE_ONE_OUT:
        return _by_leave_one_out(_prediction_errors(XY, target * factor), noise)
    return _by_f_test(XY, target * factor, noise)


def prediction_errors(XY: Vector, target_m: Vector, degree: int) -> Vector | None:
    """e_i/(1 - h_i) (n, 2) [m]: polynomial of all OTHER crosses minus given, without n adjustments.

    None where a cross carries a coefficient alone (1 - h_i = 0).
    """
    Q_factor, residuals = _projected(XY, target_m, degree)
    remainder = 1.0 - np.sum(Q_factor**2, axis=1)
    if np.min(remainder) <= SMALLEST_REDUNDANCY_NUMBER:
        return None
    return np.asarray(residuals / remainder[:, None])


def _by_f_test(XY: Vector, target_m: Vector, noise: float) -> int:
    chosen, idle = 1, 0
    square = _sum_of_squares(XY, target_m, chosen)
    for degree in range(2, HIGHEST_DEGREE + 1):
        if idle == 2 or not _is_candidate(XY, degree):
            break
        redundancy = len(XY) - terms(degree)
        candidate = _sum_of_squares(XY, target_m, degree)
        added = 2 * (terms(degree) - terms(chosen))
        rest = max(candidate / (2 * redundancy), noise**2)
        gain = np.asarray(max(square - candidate, 0.0) / added / rest)
        if f_probability(gain, added, 2 * redundancy) < DEGREE_LEVEL:
            chosen, square, idle = degree, candidate, 0
        else:
            idle += 1
    return chosen


def _by_leave_one_out(errors: dict[int, Vector], noise: float) -> int:
    """The lowest degree within one standard error of the smallest PRESS; squares below rounding are all the same."""
    if not errors:
        return 1
    squares = {degree: np.maximum(np.sum(e**2, axis=1), 2.0 * noise**2) for degree, e in errors.items()}
    best = min(squares, key=lambda degree: float(np.sum(squares[degree])))
    for degree, square in squares.items():
        excess = square - squares[best]
        if np.sum(excess) <= np.sqrt(len(excess)) * np.std(excess, ddof=1):
            return degree
    return best


def _prediction_errors(XY: Vector, target_m: Vector) -> dict[int, Vector]:
    """Prediction errors of every degree that may be chosen, lowest first."""
    errors: dict[int, Vector] = {}
    for degree in range(1, HIGHEST_DEGREE + 1):
        if degree > 1 and not _is_candidate(XY, degree):
            break
        e = prediction_errors(XY, target_m, degree)
        if e is None:
            break
        errors[degree] = e
    return errors


def _is_candidate(XY: Vector, degree: int) -> bool:
    return len(XY) - terms(degree) >= 2 and condition_ratio(XY, degree) >= WEAK_RATIO


def _sum_of_squares(XY: Vector, target_m: Vector, degree: int) -> float:
    return float(np.sum(_projected(XY, target_m, degree)[1] ** 2))


def _projected(XY: Vector, target_m: Vector, degree: int) -> tuple[Vector, Vector]:
    """Q (n, m) of the design matrix, and the residuals v = polynomial - given (n, 2)."""
    centre, scale = frame(XY)
    Q_factor = np.linalg.qr(design((XY - centre) / scale, degree))[0]
    centred = target_m - np.mean(target_m, axis=0)
    return Q_factor, Q_factor @ (Q_factor.T @ centred) - centred


def design(uv: Vector, degree: int) -> Vector:
    return polynomial.design(uv[:, 0], uv[:, 1], degree)


def terms(degree: int) -> int:
    """Coefficients of one coordinate, (d + 1)(d + 2)/2."""
    return (degree + 1) * (degree + 2) // 2


def frame(XY: Vector) -> tuple[Vector, float]:
    """Middle of the extent of the crosses and half its longer side [mm]."""
    low, high = np.min(XY, axis=0), np.max(XY, axis=0)
    return (low + high) / 2.0, float(np.max(high - low)) / 2.0


def rounding_m(target: Vector, metres_per_unit: Vector) -> float:
    """Rounding error of a residual [m]."""
    return float(np.max(np.abs(target * metres_per_unit))) * 32.0 * np.finfo(np.float64).eps


def condition_ratio(XY: Vector, degree: int) -> float:
    """Smallest to largest singular value of the design matrix on the principal axes of the crosses."""
    singular = np.linalg.svd(design(_principal_axes(XY), degree), compute_uv=False)
    return float(singular[-1] / singular[0])


def _principal_axes(XY: Vector) -> Vector:
    """Crosses along their principal axes, each axis stretched to -1 ... 1: a narrow strip is not a weak sheet."""
    centred = XY - np.mean(XY, axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2].T
    return np.asarray(along / np.max(np.abs(along), axis=0))
