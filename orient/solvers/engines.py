"""R (u, u), rho (u,) with R'R = A'A, R'rho = A'l: two ways from weighted equations to their triangle."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from orient.solvers.zlatanov import NormalEquations

FloatArray = NDArray[np.float64]


SMALLEST_PIVOT = 1e-11
"""Below, the normal equations have lost so many digits that only QR can tell weak from singular."""


class Engine(StrEnum):
    """How an adjustment is solved: Algorithm Z (normal equations), polished by QR in its last steps, or QR alone."""

    ZLATANOV = "zlatanov"
    QR = "qr"


def triangle(A: FloatArray, l: FloatArray, engine: Engine = Engine.QR) -> tuple[FloatArray, FloatArray]:
    """|A x + l| -> min, R x = -rho: the triangle R (u, u) and rho (u,) of the weighted, scaled equations.

    A (n, u), l (n,); with n < u the missing rows of R are zero. Normal equations square the condition of A: where a
    pivot R_kk^2 of Algorithm Z is below 1e-11 N_kk, QR takes over, which can tell weak from singular.
    Source: seed 000, (14)-(15); QR by Householder.
    """
    if engine is Engine.ZLATANOV:
        equations = NormalEquations([""] * A.shape[1])
        equations.add(A, l)
        reduction = equations.reduced()
        if reduction.smallest_pivot > SMALLEST_PIVOT:
            return reduction.R, reduction.rho
    return _qr(A, l)


def _qr(A: FloatArray, l: FloatArray) -> tuple[FloatArray, FloatArray]:
    u = A.shape[1]
    R = np.zeros((u, u + 1))
    rows = np.linalg.qr(np.column_stack([A, l]), mode="r")[:u]
    R[: len(rows)] = rows
    return R[:, :u], R[:, u]
