"""What the second engines share: a turn by Cayley's quotient, roots of weights, cofactors from a dense system."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

DISPLACED = 1e-3
"""Start: turned by this [rad] and moved by this share of the distance, so that an engine has to find the way itself."""
STEP = 1e-30
"""Imaginary step: the derivative is exact to rounding."""
TIGHTEST = 1e-15
PRESENT = 1e-10


def cayley(r: ComplexArray) -> ComplexArray:
    """(I - [r/2]x)^-1 (I + [r/2]x): a turn about r, by |r| for small r."""
    x, y, z = r / 2
    S = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.linalg.solve(np.eye(3) - S, np.eye(3) + S))


def weight_root(weight: FloatArray) -> FloatArray:
    """(m, k): G with G'G = weight, without the directions that have none."""
    values, vectors = np.linalg.eigh(0.5 * (weight + weight.T))
    present = values > PRESENT * np.max(values, initial=0.0)
    return np.asarray(np.sqrt(values[present])[:, None] * vectors[:, present].T)


def last_cofactors(J: FloatArray, u: int) -> FloatArray:
    """(J'J)^-1 of the last u unknowns: the lower corner of the triangle of J is theirs alone."""
    R = qr(J, mode="r")[0][: J.shape[1], :]
    inverse = solve_triangular(R[-u:, -u:], np.eye(u))
    return np.asarray(inverse @ inverse.T)
