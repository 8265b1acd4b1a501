"""v = B X + F, v'v -> min: an adjustment in one step, by Algorithm Z or by QR."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.solvers.engines import SMALLEST_PIVOT, Engine
from orient.solvers.zlatanov import NormalEquations, adjust_bordered
from orient.solvers.zlatanov_reduction import Reduction

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LinearAdjustment:
    """X (u,) and v (n,), or (u, f) and (n, f) for f free terms; Q_x = R^-1 R^-T.

    `shares` T' = B R^-1 (n, u), orthonormal columns; `redundancy_numbers` diag(Q_v) (n,), their sum is n - u.
    """

    X: FloatArray
    R_inverse: FloatArray
    v: FloatArray
    shares: FloatArray
    redundancy_numbers: FloatArray

    @property
    def Q_x(self) -> FloatArray:
        """Cofactor matrix (u, u) of the unknowns."""
        return np.asarray(self.R_inverse @ self.R_inverse.T)


def adjust(names: Sequence[str], B: FloatArray, F: FloatArray, engine: Engine = Engine.ZLATANOV) -> LinearAdjustment:
    """v = B X + F, v'v -> min: B (n, u) of full rank, weighted if need be, F (n,) or (n, f) free terms of the same B.

    Algorithm Z goes over the equations twice: the short form gives R_1, the full form reduces B R_1^-1, whose columns
    are orthonormal but for the rounding of the first pass. So nothing is lost to the squared condition, R = R_2 R_1 is
    as good as that of QR, and X, v, Q_v are read from the reduced matrix. Where a pivot of the first pass is below
    1e-11 (see `engines.triangle`), QR takes over. Callers refuse what is singular before, by `weakest_unknown`.
    Source: seed 000, (9)-(16); two passes: Yamamoto et al. 2015 (CholeskyQR2).
    """
    if engine is Engine.ZLATANOV:
        first = _reduced(names, B)
        if first.smallest_pivot > SMALLEST_PIVOT:
            return _second_pass(names, B, F, first.R_inverse)
    return _by_qr(B, F)


def weakest_unknown(names: Sequence[str], B: FloatArray) -> str:
    """The unknown that depends most on those before it: the name for a rank defect of B (n, u)."""
    return _reduced(names, B).weakest


def _reduced(names: Sequence[str], B: FloatArray) -> Reduction:
    equations = NormalEquations(names)
    equations.add(B, np.zeros(len(B)))
    return equations.reduced()


def _second_pass(names: Sequence[str], B: FloatArray, F: FloatArray, R_1_inverse: FloatArray) -> LinearAdjustment:
    reduction = adjust_bordered(names, B @ R_1_inverse, F, np.ones((len(B), 1, 1)))
    R_2_inverse = reduction.R_inverse
    return LinearAdjustment(
        X=-(R_1_inverse @ (R_2_inverse @ reduction.rho)),
        R_inverse=R_1_inverse @ R_2_inverse,
        v=reduction.v,
        shares=reduction.T.T,
        redundancy_numbers=reduction.Q_v[:, 0, 0],
    )


def _by_qr(B: FloatArray, F: FloatArray) -> LinearAdjustment:
    Q_factor, R = np.linalg.qr(B)
    R_inverse = np.linalg.solve(R, np.eye(len(R)))
    rho = Q_factor.T @ F
    return LinearAdjustment(
        X=-(R_inverse @ rho),
        R_inverse=R_inverse,
        v=F - Q_factor @ rho,
        shares=Q_factor,
        redundancy_numbers=1.0 - np.sum(Q_factor**2, axis=1),
    )
