"""Z_kk <- sqrt(Z_kk), Z_kj <- Z_kj / Z_kk, Z_ij <- Z_ij - Z_ki Z_kj: what Algorithm Z makes of the bordered matrix.

Source: seed 000, equations (14)-(16), corrected.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from orient.solvers.packed import packed_index

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.intp]

RANK_DEFECT = 1e-13
"""A pivot below this part of its N_kk is the rounding of the sums: the unknown depends on those before it."""


@dataclass(frozen=True, slots=True)
class Reduction:
    """[R, rho; ., v'Pv] of the short form, U = m: the solution of v = B X + F, v'Pv -> min.

    `packed`: the reduced triangle; `names` of the m unknowns; `n_equations` of positive weight; `defect`: index of the
    unknown whose pivot vanished, None if none: X, Q_x and what follows from them are NaN then. `free_terms`: columns of
    F that were adjusted with the same B; with more than one, rho, X and v have a column for each.
    """

    packed: FloatArray
    names: tuple[str, ...]
    n_equations: int
    defect: int | None
    free_terms: int

    @property
    def is_determined(self) -> bool:
        """Did the m steps find m pivots?"""
        return self.defect is None

    @property
    def undetermined(self) -> str:
        """Name of the unknown that the equations do not determine beside those before it; "" if there is none."""
        return "" if self.defect is None else self.names[self.defect]

    @property
    def weakest(self) -> str:
        """Name of the unknown of which those before it leave least; the undetermined one if there is one."""
        return self.undetermined or self.names[int(np.argmin(self._pivots()))]

    @property
    def smallest_pivot(self) -> float:
        """min_k R_kk^2 / N_kk: the share of an unknown that those before it leave; 0 if one is undetermined."""
        return float(np.min(self._pivots())) if self.is_determined else 0.0

    @property
    def R(self) -> FloatArray:
        """Upper triangle (m, m), R'R = N = B'PB."""
        m = len(self.names)
        return self._upper()[:m, :m]

    @property
    def rho(self) -> FloatArray:
        """R^-T M (m,), M = B'PF."""
        m = len(self.names)
        return _single(self._upper()[:m, m : m + self.free_terms])

    @property
    def R_bar_inverse(self) -> FloatArray:
        """[R, rho; 0, 1]^-1 = [R^-1, X; 0, 1] (m + 1, m + 1), seed 000 (15)."""
        m, border = len(self.names), len(self.names) + self.free_terms
        if not self.is_determined:
            return np.full((border, border), np.nan)
        R_bar = self._upper()[:border, :border]
        R_bar[m:, m:] = np.eye(self.free_terms)
        return np.asarray(np.linalg.inv(R_bar))

    @property
    def R_inverse(self) -> FloatArray:
        """R^-1 (m, m)."""
        m = len(self.names)
        return self.R_bar_inverse[:m, :m]

    @property
    def X(self) -> FloatArray:
        """-R^-1 rho (m,)."""
        m = len(self.names)
        return _single(self.R_bar_inverse[:m, m:])

    @property
    def Q_x(self) -> FloatArray:
        """R^-1 (R^-1)' (m, m), seed 000 (16)."""
        R_inverse = self.R_inverse
        return np.asarray(R_inverse @ R_inverse.T)

    @property
    def vPv(self) -> float:
        """F'PF - rho'rho, 0 where rounding makes it negative; a difference of large numbers when F is large.

        Of all free terms together.
        """
        m, border = len(self.names), len(self.names) + self.free_terms
        squares = np.diagonal(self._upper()[m:border, m:border])
        return float(np.sum(np.maximum(squares, 0.0))) if self.is_determined else np.nan

    @property
    def redundancy(self) -> int:
        """n - m, for each free term."""
        return self.n_equations - len(self.names)

    @property
    def sigma0(self) -> float:
        """sqrt(v'Pv / (n - m)), of all free terms together; NaN without redundancy."""
        redundancy = self.free_terms * self.redundancy
        return float(np.sqrt(self.vPv / redundancy)) if redundancy > 0 else np.nan

    def residuals(self, B: FloatArray, F: FloatArray) -> FloatArray:
        """v = B X + F, in the shape of F (..., n)."""
        return np.asarray(B @ self.X + F)

    def adjusted_cofactors(self, B: FloatArray) -> FloatArray:
        """Q_Lhat = T'T = B N^-1 B' of groups of equations: B (..., g, m) -> (..., g, g)."""
        T_transposed = B @ self.R_inverse
        return np.asarray(T_transposed @ np.swapaxes(T_transposed, -1, -2))

    def residual_cofactors(self, B: FloatArray, Q_L: FloatArray) -> FloatArray:
        """Q_v = Q_L - B N^-1 B' of groups of equations: B (..., g, m), Q_L (..., g, g)."""
        return np.asarray(Q_L - self.adjusted_cofactors(B))

    def redundancy_numbers(self, B: FloatArray, Q_L: FloatArray) -> FloatArray:
        """diag(Q_v P), sum n - m, for groups B (..., g, m), Q_L (..., g, g) -> (..., g)."""
        explained = self.adjusted_cofactors(B) @ np.linalg.inv(Q_L)
        return np.asarray(1.0 - np.diagonal(explained, axis1=-2, axis2=-1))

    def _pivots(self) -> FloatArray:
        """R_kk^2 / N_kk (m,)."""
        R = self.R
        return np.asarray(np.diag(R) ** 2 / np.sum(R**2, axis=0))

    def _upper(self) -> FloatArray:
        """The reduced triangle as a matrix of order q with zeros below the diagonal."""
        return upper_matrix(self.packed)


@dataclass(frozen=True, slots=True)
class FullReduction(Reduction):
    """[R, rho, T; ., v'Pv, v'; ., ., Z33 - T'T] of the full form, q = m + 1 + n, Z33 = Q_L or 0.

    `Q_L` (n, n), or (n/g, g, g) when only groups of g equations are correlated: Z then holds only these blocks of the
    third block, and what stands there has the shape of Q_L.
    """

    Q_L: FloatArray
    starts_with_Q_L: bool

    @property
    def T(self) -> FloatArray:
        """R^-T B' (m, n)."""
        return self._strip()[: len(self.names)]

    @property
    def v(self) -> FloatArray:
        """F + B X (n,), read from row m + 1."""
        v = self._strip()[len(self.names) :].T
        return _single(v if self.is_determined else np.full_like(v, np.nan))

    @property
    def third_block(self) -> FloatArray:
        """Z33 - T'T: +Q_v when Z33 = Q_L at the start, -Q_Lhat when Z33 = 0; never Q_L, as (15) prints."""
        block = np.full_like(self.Q_L, np.nan)
        if self.is_determined:
            a, b = triangle_indices(self.Q_L.shape[-1])
            below = self.packed[strip_places(self._border, self.n_equations)[-1].stop :]
            block[..., a, b] = below.reshape(*self.Q_L.shape[:-2], -1)
            block[..., b, a] = block[..., a, b]
        return block

    @property
    def Q_v(self) -> FloatArray:
        """Q_L - B N^-1 B', in the shape of Q_L."""
        return self.third_block if self.starts_with_Q_L else self.Q_L + self.third_block

    @property
    def Q_Lhat(self) -> FloatArray:
        """B N^-1 B', in the shape of Q_L."""
        return self.Q_L - self.third_block if self.starts_with_Q_L else -self.third_block

    @property
    def _border(self) -> int:
        return len(self.names) + self.free_terms

    def _upper(self) -> FloatArray:
        """[R, rho; 0, v'Pv] (m + 1, m + 1)."""
        return upper_matrix(self.packed[corner_places(self._border, self.n_equations)])

    def _strip(self) -> FloatArray:
        """[T; v'] (m + 1, n)."""
        return np.array([self.packed[place] for place in strip_places(self._border, self.n_equations)])


def reduce_in_place(Z: FloatArray, m: int) -> int | None:
    """The m steps (14) on the packed triangle `Z` itself; the 0-based unknown whose pivot vanished, None if none.

    For k = 1..m: Z_kk <- sqrt(Z_kk); Z_kj <- Z_kj / Z_kk (j > k); Z_ij <- Z_ij - Z_ki Z_kj (k < i <= j).
    A pivot <= 1e-13 N_kk is a rank defect; the steps stop there.
    """
    order = _order(Z)
    rows, columns = triangle_indices(order)
    start, pivot_row = 0, np.zeros(order)
    N_kk = [Z[packed_index(k, k, order) - 1] for k in range(1, m + 1)]
    for k in range(m):
        if not Z[start] > RANK_DEFECT * N_kk[k]:
            return k
        after = start + order - k
        Z[start:after] /= math.sqrt(Z[start])
        pivot_row[k:] = Z[start:after]
        Z[after:] -= pivot_row[rows[after:]] * pivot_row[columns[after:]]
        start = after
    return None


def reduce_bordered_in_place(Z: FloatArray, m: int, border: int, n: int, group: int) -> int | None:
    """The m steps (14) on a triangle of order border + n of which the first rows and the third block's groups are kept.

    A column needs those left of it for nothing but the pivots, so the steps run on the first `border` columns, then on
    the other n at once: [B'; F'] <- R_bar^-T [B'; F'] = [T; v'], Z33 <- Z33 - T'T.
    """
    at_corner, strips = corner_places(border, n), strip_places(border, n)
    corner = Z[at_corner]
    defect = reduce_in_place(corner, m)
    Z[at_corner] = corner
    if defect is not None:
        return defect
    R_bar = upper_matrix(corner)
    R_bar[m:, m:] = np.eye(border - m)
    strip = np.linalg.inv(R_bar).T @ np.array([Z[place] for place in strips])
    for place, row in zip(strips, strip, strict=True):
        Z[place] = row
    T = strip[:m].T.reshape(n // group, group, m)
    a, b = triangle_indices(group)
    Z[strips[-1].stop :] -= np.einsum("gam,gbm->gab", T, T, optimize=group > 1)[:, a, b].ravel()
    return None


def upper_matrix(packed: FloatArray) -> FloatArray:
    """(q, q) matrix with the packed triangle on and above the diagonal, zeros below."""
    matrix = np.zeros((_order(packed), _order(packed)))
    matrix[triangle_indices(len(matrix))] = packed
    return matrix


@lru_cache(maxsize=16)
def triangle_indices(order: int) -> tuple[IndexArray, IndexArray]:
    """0-based row and column of every element of a packed triangle; read-only."""
    rows, columns = np.triu_indices(order)
    rows.flags.writeable = columns.flags.writeable = False
    return rows, columns


@lru_cache(maxsize=64)
def corner_places(border: int, n: int) -> IndexArray:
    """Where the triangle of the first `border` columns stands in one of order border + n, 0-based."""
    starts = np.array([place.start for place in strip_places(border, n)]) - border
    rows, columns = triangle_indices(border)
    places = starts[rows] + columns
    places.flags.writeable = False
    return places


@lru_cache(maxsize=64)
def strip_places(border: int, n: int) -> tuple[slice, ...]:
    """Where the last n elements of each of the first `border` rows of a triangle of order border + n stand."""
    ends = np.cumsum(border + n - np.arange(border)).tolist()
    return tuple(slice(end - n, end) for end in ends)


def _single(columns: FloatArray) -> FloatArray:
    """(k,) of (k, 1): one free term is no column."""
    return columns[:, 0] if columns.shape[1] == 1 else columns


def _order(packed: FloatArray) -> int:
    return (math.isqrt(8 * len(packed) + 1) - 1) // 2
