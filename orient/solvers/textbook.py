"""One least-squares step as it would stand on paper: v = A x + l, N = A'PA, Algorithm Z, x, every line to some digits.

Each line is computed from the lines above as they are printed, so that a reader with pencil and paper arrives at the
same figures. With `digits` None nothing is rounded. Source of the reduction: seed 000, (9), (14), (15).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import GeometryError

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Group:
    """Equations v = A x + l that are weighted together: A (g, u), l (g,), P (g, g) = Q_L^-1."""

    design: FloatArray
    free_term: FloatArray
    weight: FloatArray


@dataclass(frozen=True, slots=True)
class Step:
    """The page: groups as printed, Z = [A'PA, A'Pl; ., l'Pl] (u + 1, u + 1), its reductions, x (u,), v'Pv after it.

    `reductions[k]` (u + 1, u + 1): Z after k + 1 steps; its rows 0 ... k are those of [R, rho]. Upper triangles.
    """

    groups: Sequence[Group]
    Z: FloatArray
    reductions: Sequence[FloatArray]
    x: FloatArray
    vPv: float


def as_printed(values: ArrayLike, digits: int | None) -> FloatArray:
    """The numbers that a reader sees when `digits` significant figures are printed."""
    exact = np.asarray(values, dtype=np.float64)
    if digits is None:
        return exact
    shown = [float(f"{value:.{digits}g}") for value in exact.ravel().tolist()]
    return np.array(shown).reshape(exact.shape)


def textbook_step(groups: Sequence[Group], digits: int | None) -> Step:
    """x = -N^-1 A'Pl by Algorithm Z, line by line; GeometryError where a pivot is not positive."""
    shown = [Group(*(as_printed(part, digits) for part in (one.design, one.free_term, one.weight))) for one in groups]
    Z = as_printed(_bordered(shown), digits)
    reductions = _reductions(Z, digits)
    return Step(shown, Z, reductions, _solution(reductions[-1], digits), float(reductions[-1][-1, -1]))


def _bordered(groups: Sequence[Group]) -> FloatArray:
    """Sum of [A l]' P [A l]."""
    size = groups[0].design.shape[1] + 1
    Z = np.zeros((size, size))
    for one in groups:
        rows = np.column_stack([one.design, one.free_term])
        Z += rows.T @ one.weight @ rows
    return np.triu(Z)


def _reductions(Z: FloatArray, digits: int | None) -> list[FloatArray]:
    """R_kk = sqrt(Z_kk), R_kj = Z_kj / R_kk, Z_ij <- Z_ij - R_ki R_kj."""
    current, found = Z, []
    for k in range(len(Z) - 1):
        if not current[k, k] > 0:
            told = "" if digits is None else f" with {digits} digits"
            raise GeometryError(f"the pivot of unknown {k + 1} is lost to rounding{told}", "Give more: --digits 15")
        current = current.copy()
        pivot = as_printed(np.sqrt(current[k, k]), digits)
        row = as_printed(current[k, k + 1 :] / pivot, digits)
        current[k, k], current[k, k + 1 :] = pivot, row
        current[k + 1 :, k + 1 :] = np.triu(as_printed(current[k + 1 :, k + 1 :] - np.outer(row, row), digits))
        found.append(current)
    return found


def _solution(reduced: FloatArray, digits: int | None) -> FloatArray:
    """x_k = -(rho_k + sum_j>k R_kj x_j) / R_kk, from the last unknown to the first."""
    u = len(reduced) - 1
    x = np.zeros(u)
    for k in range(u - 1, -1, -1):
        x[k] = as_printed(-(reduced[k, u] + reduced[k, k + 1 : u] @ x[k + 1 :]) / reduced[k, k], digits)
    return x
