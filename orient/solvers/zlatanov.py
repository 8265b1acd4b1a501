"""Z = [B'PB, B'PF; ., F'PF] -> [R, rho; ., v'Pv]: Algorithm Z (Cholesky, Banachiewicz, Zlatanov), packed in 1-D.

v = B X + F, v'Pv -> min, P = Q_L^-1: the normal equations are summed up equation by equation (or group by group when
Q_L is correlated) in the upper triangle of the bordered matrix, which is kept as one row of numbers and reduced in
its place. Source: seed 000, equations (9)-(16), corrected.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from orient.errors import OrientError
from orient.solvers.packed import packed_index
from orient.solvers.zlatanov_reduction import (
    FullReduction,
    Reduction,
    corner_places,
    reduce_bordered_in_place,
    reduce_in_place,
    strip_places,
    triangle_indices,
)

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.intp]


def base_address(i: int | IndexArray, U: int) -> IndexArray:
    """(i - 1)(2(U + 1) - i)/2: what a column address is added to in row i (1-based), seed 000 (12)."""
    return np.asarray((i - 1) * (2 * (U + 1) - i) // 2)


def column_addresses(columns: Sequence[int] | IndexArray, U: int) -> IndexArray:
    """(J1, ..., Jk, JM), 1-based: unknowns of a compact equation and its free term, JM = U + 1; seed 000 (11).

    `columns` (..., k) -> (..., k + 1). The seed prints JM = 6, the length of its array; with U = 7 unknowns it is 8.
    """
    J = np.asarray(columns, dtype=np.intp)
    if J.size and (J.min() < 1 or J.max() > U):
        raise ValueError(f"columns {J.min()}..{J.max()} are not among 1..{U}")
    if np.any(np.diff(np.sort(J, axis=-1), axis=-1) == 0):
        raise ValueError("an equation names a column twice")
    JM = np.full((*J.shape[:-1], 1), U + 1, dtype=np.intp)
    return np.concatenate([J, JM], axis=-1)


def element_addresses(addresses: IndexArray, U: int) -> IndexArray:
    """base(J_a) + J_b, J_a <= J_b (1-based), of all pairs of one equation's columns, seed 000 (13).

    `addresses` (..., k + 1) -> (..., (k + 1)(k + 2)/2), pairs in the order of a packed triangle.
    """
    a, b = triangle_indices(addresses.shape[-1])
    smaller = np.minimum(addresses[..., a], addresses[..., b])
    larger = np.maximum(addresses[..., a], addresses[..., b])
    return base_address(smaller, U) + larger


class NormalEquations:
    """The bordered matrix Z of m named unknowns in the seed's short form, q = m + 1, while equations are added."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.n_equations = 0
        self._Z = np.zeros(packed_index(self.U + 1, self.U + 1, self.U + 1))

    @property
    def U(self) -> int:
        """Number of unknowns m; the triangle has the order U + 1."""
        return len(self.names)

    @property
    def packed(self) -> FloatArray:
        """Z as it stands, (U + 1)(U + 2)/2 numbers."""
        return self._Z.copy()

    def add(
        self,
        B: FloatArray,
        F: FloatArray,
        weights: FloatArray | None = None,
        columns: Sequence[int] | IndexArray | None = None,
    ) -> None:
        """Z(J_a, J_b) += p b_a b_b: equations v = B X + F with diagonal Q_L, weights p = 1/Q_L (n,), 1 by default.

        B (n, k) and F (n,); `columns` J1..Jk, 1-based: the unknowns of compact equations, the same for all (k,) or
        of each (n, k); all m unknowns by default. An equation of weight 0 is none.
        """
        rows = np.column_stack([B, F])
        if weights is not None and np.any(weights < 0):
            raise ValueError("a weight is negative")
        self._accumulate(rows, rows if weights is None else weights[:, None] * rows, columns)
        self.n_equations += len(rows) if weights is None else int(np.count_nonzero(weights))

    def add_group(
        self, B: FloatArray, F: FloatArray, Q_L: FloatArray, columns: Sequence[int] | IndexArray | None = None
    ) -> None:
        """Z += [B F]' Q_L^-1 [B F]: equations that are weighted together because Q_L is correlated.

        One group B (g, k), F (g,), Q_L (g, g), or many of one size: (groups, g, k), (groups, g), (groups, g, g);
        `columns` (k,) as in `add`. Q_L must be positive definite.
        """
        rows = _whitened(np.concatenate([B, np.asarray(F)[..., None]], axis=-1), Q_L)
        self._accumulate(rows, rows, columns)
        self.n_equations += len(rows)

    def reduced(self) -> Reduction:
        """(14) on a copy of Z: X, Q_x, v'Pv; more equations may be added afterwards."""
        Z = self.packed
        defect = reduce_in_place(Z, self.U)
        return Reduction(Z, self.names, self.n_equations, defect, 1)

    def _accumulate(self, rows: FloatArray, weighted: FloatArray, columns: Sequence[int] | IndexArray | None) -> None:
        a, b = triangle_indices(rows.shape[-1])
        addresses = self._addresses(columns, rows.shape[-1])
        if addresses.ndim == 1:
            self._Z[addresses] += (rows.T @ weighted)[a, b]
        else:
            products = weighted[:, a] * rows[:, b]
            self._Z += np.bincount(addresses.ravel(), products.ravel(), minlength=len(self._Z))

    def _addresses(self, columns: Sequence[int] | IndexArray | None, width: int) -> IndexArray:
        """0-based places of the products of an equation's `width` numbers, free term last."""
        k = self.U if columns is None else np.shape(columns)[-1]
        if width != k + 1:
            raise ValueError(f"{width - 1} coefficients for {k} columns")
        if columns is None:
            return np.arange(len(self._Z))
        return element_addresses(column_addresses(columns, self.U), self.U) - 1


def bordered_matrix(B: FloatArray, F: FloatArray, Q_L: FloatArray, *, starts_with_Q_L: bool) -> FloatArray:
    """Z = [B'PB, B'PF, B'; ., F'PF, F'; ., ., Z33] of order q = m + 1 + n, packed, seed 000 (9); Z33 = Q_L or 0.

    B (n, m), F (n,), or (n, f) for f free terms; Q_L (n, n), or (n/g, g, g) for groups: then only the blocks of Q_L are
    kept of the third block. Q_L enters the first block only as P = Q_L^-1.
    """
    rows = np.column_stack([B, F])
    (n, border), group = rows.shape, Q_L.shape[-1]
    white = _whitened(rows.reshape(-1, group, border), Q_L)
    strips = strip_places(border, n)
    below = strips[-1].stop
    Z = np.zeros(below + n * (group + 1) // 2)
    Z[corner_places(border, n)] = (white.T @ white)[triangle_indices(border)]
    for place, column in zip(strips, rows.T, strict=True):
        Z[place] = column
    if starts_with_Q_L:
        Z[below:] = Q_L[(..., *triangle_indices(group))].ravel()
    return Z


def adjust_bordered(
    names: Sequence[str], B: FloatArray, F: FloatArray, Q_L: FloatArray, *, starts_with_Q_L: bool = True
) -> FullReduction:
    """v = B X + F, v'Pv -> min, P = Q_L^-1, by the full form: X, Q_x, v'Pv and also v, Q_v, Q_Lhat stand in Z.

    B (n, m), F (n,), or (n, f) for f free terms with the same B; Q_L (n, n), or (n/g, g, g) for groups of g equations
    that are correlated among themselves only, g = 1 for a diagonal; of the third block only these groups are in Z.
    An unknown that the equations do not determine is named in `undetermined`. Source: seed 000, (9), (14)-(16).
    """
    Z = bordered_matrix(B, F, Q_L, starts_with_Q_L=starts_with_Q_L)
    n, free_terms = len(F), 1 if F.ndim == 1 else F.shape[1]
    defect = reduce_bordered_in_place(Z, len(names), len(names) + free_terms, n, Q_L.shape[-1])
    return FullReduction(Z, tuple(names), n, defect, free_terms, Q_L, starts_with_Q_L)


def _whitened(rows: FloatArray, Q_L: FloatArray) -> FloatArray:
    """L^-1 rows, Q_L = L L': groups (..., g, k) one below the other."""
    if Q_L.shape[-1] == 1 and np.all(Q_L > 0):
        return np.asarray(rows / np.sqrt(Q_L)).reshape(-1, rows.shape[-1])
    try:
        L = np.linalg.cholesky(Q_L)
    except np.linalg.LinAlgError:
        raise OrientError(
            "A cofactor matrix of observations is not positive definite.",
            "Check its standard deviations (none zero) and correlations (all below 1).",
        ) from None
    return np.asarray(np.linalg.solve(L, rows)).reshape(-1, rows.shape[-1])
