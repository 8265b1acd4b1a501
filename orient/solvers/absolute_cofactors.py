"""Q_e = K (Q_G + t^2 R Q_x R') K: cofactors of point coordinates, as blocks (n, 3, 3) or in full (3n, 3n).

Blocks when the points are independent of each other (cost linear in n), the full matrix when they are correlated. The
functions here treat both alike; vectors of points are (n, 3, k).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def turned(A: FloatArray, Q: FloatArray) -> FloatArray:
    """A_i Q_ij A_j' of blocks or of a full matrix; A is (3, 3) for all points or (n, 3, 3)."""
    if Q.ndim == 3:
        return np.asarray(A @ Q @ np.swapaxes(A, -1, -2))
    n = len(Q) // 3
    every = np.broadcast_to(A, (n, 3, 3))
    blocks = Q.reshape(n, 3, n, 3).transpose(0, 2, 1, 3)
    result = every[:, None] @ blocks @ every.transpose(0, 2, 1)[None, :]
    return np.asarray(result.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n))


def times(Q: FloatArray, vectors: FloatArray) -> FloatArray:
    """Q V (n, 3, k)."""
    if Q.ndim == 3:
        return np.asarray(Q @ vectors)
    return np.asarray((Q @ vectors.reshape(len(Q), -1)).reshape(vectors.shape))


def diagonal_blocks(Q: FloatArray) -> FloatArray:
    """The own cofactors (n, 3, 3) of every point."""
    if Q.ndim == 3:
        return Q
    blocks = Q.reshape(len(Q) // 3, 3, len(Q) // 3, 3)
    return np.asarray(np.einsum("iaib->iab", blocks))


def added(first: FloatArray, second: FloatArray | None) -> FloatArray:
    """Sum of two cofactors; blocks are placed on the diagonal when the other one is full."""
    if second is None:
        return first
    if first.ndim == second.ndim:
        return np.asarray(first + second)
    return np.asarray(_full(first) + _full(second))


def _full(Q: FloatArray) -> FloatArray:
    if Q.ndim == 2:
        return Q
    n = len(Q)
    full = np.zeros((n, 3, n, 3))
    full[np.arange(n), :, np.arange(n), :] = Q
    return full.reshape(3 * n, 3 * n)


@dataclass(frozen=True, slots=True)
class Weight:
    """P = (K Q K)^+ by `root` W = L^-1 of K Q K + (I - K) s = L L': whitens and weights what lies in K."""

    root: FloatArray

    def whiten(self, vectors: FloatArray) -> FloatArray:
        """W V (n, 3, k)."""
        return times(self.root, vectors)

    def times(self, vectors: FloatArray) -> FloatArray:
        """P V (n, 3, k)."""
        return times(np.swapaxes(self.root, -1, -2), self.whiten(vectors))

    def trace(self, known: FloatArray) -> float:
        """Sum of the weights P_ii in the known directions."""
        return float(np.sum((self.root @ (known if self.root.ndim == 3 else _full(known))) ** 2))


def weight_of(known: FloatArray, Q: FloatArray) -> Weight:
    """Weight of misclosures in the known directions K (n, 3, 3) with cofactors Q; LinAlgError if not definite."""
    size = np.trace(diagonal_blocks(Q), axis1=1, axis2=2)[:, None, None] / 3
    filler = (np.eye(3) - known) * np.where(size > 0, size, 1.0)
    L = np.linalg.cholesky(added(turned(known, Q), filler))
    return Weight(np.asarray(np.linalg.inv(L), dtype=np.float64))
