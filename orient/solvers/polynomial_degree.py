"""Which degree a sheet's polynomial deserves: by an F test of its gain, or by predicting each cross from the others."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from orient.geometry import polynomial
from orient.solvers.engines import Engine
from orient.solvers.linear_adjustment import LinearAdjustment, adjust
from orient.solvers.outlier_test import SMALLEST_REDUNDANCY_NUMBER, f_probability

Vector = NDArray[np.float64]
ByDegree = Callable[[int], LinearAdjustment]

F_TEST = "f-test"
LEAVE_ONE_OUT = "leave-one-out"
HIGHEST_DEGREE = 5
DEGREE_LEVEL = 0.05
"""A higher degree is taken when its gain would come by chance in less than one of 20 sheets."""
WEAK_RATIO = 1e-3
"""Singular-value ratio below which a degree is not taken unless it is given."""


@dataclass(frozen=True, slots=True)
class Crosses:
    """What is known of the crosses of a sheet.

    XY (n, 2) digitiser [mm]; target (n, 2) B, L [deg] or N, E [m]; metres_per_unit (n, 2) ground metres per unit of the
    target at each cross (M rho, N cos B rho; ones for a grid); `sheet`, `names` (n,) for the messages.
    """

    XY: Vector
    target: Vector
    metres_per_unit: Vector
    sheet: str = ""
    names: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        return f"sheet {self.sheet}" if self.sheet else "the sheet"

    def only(self, chosen: NDArray[np.bool_]) -> "Crosses":
        """The crosses of a mask (n,); those without a name keep their number as one."""
        names = self.names or tuple(str(i + 1) for i in range(len(self.XY)))
        kept = tuple(compress(names, chosen.tolist()))
        return Crosses(self.XY[chosen], self.target[chosen], self.metres_per_unit[chosen], self.sheet, kept)

    @property
    def target_m(self) -> Vector:
        """The target in metres, by one mean factor for the sheet (n, 2)."""
        return np.asarray(self.target * np.mean(self.metres_per_unit, axis=0))

    @property
    def rounding_m(self) -> float:
        """Rounding error of a residual [m]."""
        return float(np.max(np.abs(self.target * self.metres_per_unit))) * 32.0 * np.finfo(np.float64).eps


@dataclass(frozen=True, slots=True)
class Rule:
    """How a sheet is fitted: a given degree, else what chooses it ("f-test" or "leave-one-out"), and the engine."""

    degree: int | None = None
    choice: str = F_TEST
    engine: Engine = Engine.ZLATANOV

    @property
    def chosen_by(self) -> str:
        return self.choice if self.degree is None else "given"


@dataclass(frozen=True, slots=True)
class DegreeChoice:
    """The degree by each rule, and the root mean square prediction error [m] of the degrees that were tried."""

    f_test: int
    leave_one_out: int
    prediction_m: dict[int, float]

    def by(self, choice: str) -> int:
        return self.leave_one_out if choice == LEAVE_ONE_OUT else self.f_test


def degree_choices(crosses: Crosses, engine: Engine = Engine.ZLATANOV) -> DegreeChoice:
    """Both choices for at least four crosses."""
    adjusted = _by_degree(crosses, engine)
    errors = _all_prediction_errors(crosses, adjusted)
    rms = {degree: float(np.sqrt(np.mean(np.sum(e**2, axis=1)))) for degree, e in errors.items()}
    return DegreeChoice(_by_f_test(crosses, adjusted), _by_leave_one_out(errors, crosses.rounding_m), rms)


def choose_degree(crosses: Crosses, rule: Rule) -> int:
    """The degree of the rule, or by its choice, for at least four crosses.

    f-test: goes up from 1 as long as F = ((V_d - V_e)/(2 (m_e - m_d))) / (V_e/(2 r_e)) of the next degree e, both
    coordinates together, is improbable (5 %); ends after two steps that gain nothing.

    leave-one-out: PRESS_d = sum over the crosses of (e_i/(1 - h_i))^2, h the diagonal of the hat matrix. The smallest
    PRESS names the best degree; taken is the LOWEST degree whose PRESS exceeds it by no more than one standard error
    of the difference, sqrt(n) std_i(difference of cross i): of equals the one with fewer coefficients.

    Both try only degrees that leave a redundancy of two crosses and that the crosses determine well (singular-value
    ratio 1e-3); leave-one-out also demands that no cross carries a coefficient alone (h_i = 1: it cannot be predicted).
    Source: D. M. Allen 1974 (PRESS); L. Breiman et al. 1984 (one standard error).
    """
    if rule.degree is not None:
        return rule.degree
    adjusted = _by_degree(crosses, rule.engine)
    if rule.choice == LEAVE_ONE_OUT:
        return _by_leave_one_out(_all_prediction_errors(crosses, adjusted), crosses.rounding_m)
    return _by_f_test(crosses, adjusted)


def prediction_errors(adjustment: LinearAdjustment) -> Vector | None:
    """e_i/(1 - h_i) (n, 2) [m]: polynomial of all OTHER crosses minus given, without n adjustments.

    None where a cross carries a coefficient alone (1 - h_i = 0).
    """
    remainder = adjustment.redundancy_numbers
    if np.min(remainder) <= SMALLEST_REDUNDANCY_NUMBER:
        return None
    return np.asarray(adjustment.v / remainder[:, None])


def _by_f_test(crosses: Crosses, adjusted: ByDegree) -> int:
    chosen, idle, noise = 1, 0, crosses.rounding_m
    square = _sum_of_squares(adjusted(chosen))
    for degree in range(2, HIGHEST_DEGREE + 1):
        if idle == 2 or not _is_candidate(crosses.XY, degree):
            break
        redundancy = len(crosses.XY) - terms(degree)
        candidate = _sum_of_squares(adjusted(degree))
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


def _all_prediction_errors(crosses: Crosses, adjusted: ByDegree) -> dict[int, Vector]:
    """Prediction errors of every degree that may be chosen, lowest first."""
    errors: dict[int, Vector] = {}
    for degree in range(1, HIGHEST_DEGREE + 1):
        if degree > 1 and not _is_candidate(crosses.XY, degree):
            break
        e = prediction_errors(adjusted(degree))
        if e is None:
            break
        errors[degree] = e
    return errors


def _is_candidate(XY: Vector, degree: int) -> bool:
    return len(XY) - terms(degree) >= 2 and condition_ratio(XY, degree) >= WEAK_RATIO


def _sum_of_squares(adjustment: LinearAdjustment) -> float:
    return float(np.sum(adjustment.v**2))


def _by_degree(crosses: Crosses, engine: Engine) -> ByDegree:
    """The adjustment of each degree, once: both rules ask for the same ones."""
    return cache(lambda degree: adjusted_in_metres(crosses, degree, engine))


def adjusted_in_metres(crosses: Crosses, degree: int, engine: Engine) -> LinearAdjustment:
    """v (n, 2) [m] = polynomial - given, with the redundancy numbers of the crosses."""
    centre, scale = frame(crosses.XY)
    target_m = crosses.target_m
    F = np.mean(target_m, axis=0) - target_m
    return adjust(term_names(degree), design((crosses.XY - centre) / scale, degree), F, engine)


def design(uv: Vector, degree: int) -> Vector:
    return polynomial.design(uv[:, 0], uv[:, 1], degree)


def terms(degree: int) -> int:
    """Coefficients of one coordinate, (d + 1)(d + 2)/2."""
    return (degree + 1) * (degree + 2) // 2


def term_names(degree: int) -> tuple[str, ...]:
    """1, u, v, u^2, u v, ...: the terms in the order of the coefficients."""
    return tuple(
        " ".join(_power(letter, exponent) for letter, exponent in (("u", j), ("v", k)) if exponent) or "1"
        for j, k in polynomial.exponents(degree)
    )


def _power(letter: str, exponent: int) -> str:
    return letter if exponent == 1 else f"{letter}^{exponent}"


def frame(XY: Vector) -> tuple[Vector, float]:
    """Middle of the extent of the crosses and half its longer side [mm]."""
    low, high = np.min(XY, axis=0), np.max(XY, axis=0)
    return (low + high) / 2.0, float(np.max(high - low)) / 2.0


def condition_ratio(XY: Vector, degree: int) -> float:
    """Smallest to largest singular value of the design matrix on the principal axes of the crosses."""
    R = np.linalg.qr(design(_principal_axes(XY), degree), mode="r")
    singular = np.linalg.svd(R, compute_uv=False)
    return float(singular[-1] / singular[0])


def _principal_axes(XY: Vector) -> Vector:
    """Crosses along their principal axes, each axis stretched to -1 ... 1: a narrow strip is not a weak sheet."""
    along = along_principal_axes(XY)
    return np.asarray(along / np.max(np.abs(along), axis=0))


def along_principal_axes(XY: Vector) -> Vector:
    """Crosses (n, 2) from their centroid, along their longest extent and across."""
    centred = XY - np.mean(XY, axis=0)
    return np.asarray(centred @ np.linalg.svd(np.linalg.qr(centred, mode="r"))[2].T)
