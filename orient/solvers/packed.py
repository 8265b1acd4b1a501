"""IJ = (i-1)(2u-i)/2 + j: symmetric matrices of order u as packed upper triangles, rows one after the other."""

import math

import numpy as np
from numpy.typing import NDArray


def packed_index(i: int, j: int, u: int) -> int:
    """IJ = (i-1)(2u-i)/2 + j, i <= j, all counted from 1: place of element (i, j) in the packed triangle of order u.

    Source: seed 000, equation (10), where u is written U + 1.
    """
    if not 1 <= i <= j <= u:
        raise ValueError(f"({i}, {j}) is not in the upper triangle of order {u}")
    return (i - 1) * (2 * u - i) // 2 + j


def packed_pairs(u: int) -> tuple[tuple[int, int], ...]:
    """(i, j) of IJ = 1, 2, ..., u(u+1)/2, counted from 1."""
    return tuple((i, j) for i in range(1, u + 1) for j in range(i, u + 1))


def pack_upper(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Upper triangle of a (u, u) matrix as a vector of length u(u+1)/2 in the order of `packed_index`."""
    rows, columns = np.triu_indices(len(matrix))
    return np.array(matrix[rows, columns], dtype=np.float64)


def unpack_upper(packed: NDArray[np.float64]) -> NDArray[np.float64]:
    """Symmetric (u, u) matrix of a packed upper triangle; the inverse of `pack_upper`."""
    order = (math.isqrt(8 * len(packed) + 1) - 1) // 2
    if order * (order + 1) // 2 != len(packed):
        raise ValueError(f"{len(packed)} numbers are no packed triangle")
    matrix = np.zeros((order, order))
    rows, columns = np.triu_indices(order)
    matrix[rows, columns] = packed
    matrix[columns, rows] = packed
    return matrix
