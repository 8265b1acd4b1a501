"""What the second engines share: a turn by Cayley's quotient, roots of weights, cofactors from a dense system."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq, qr, solve_triangular
from scipy.optimize import least_squares

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MINPACK = "scipy least_squares"
"""Name of the engine behind `minimised`."""
DISPLACED = 1e-3
"""Start: turned by this [rad] and moved by this share of the distance, so that an engine has to find the way itself."""
STEP = 1e-30
"""Imaginary step: the derivative is exact to rounding."""
TIGHTEST, MOST_CALLS = 1e-15, 200
PRESENT = 1e-10


def minimised(
    residuals: Callable[[FloatArray], FloatArray], jacobian: Callable[[FloatArray], FloatArray], start: FloatArray
) -> tuple[FloatArray, float, bool]:
    """x with v'v -> min for v = residuals(x), v'v, and whether scipy's Levenberg-Marquardt (MINPACK) converged.

    It ends where v'v falls no more: with some hundred readings 1e-6 standard deviations from the minimum. So its end is
    led on by one linear step.
    """
    found = least_squares(
        residuals, start, jacobian, method="lm", x_scale="jac", xtol=TIGHTEST, ftol=TIGHTEST, gtol=TIGHTEST,
        max_nfev=MOST_CALLS,
    )  # fmt: skip
    x, has_converged = np.asarray(found.x), bool(found.status > 0)
    if has_converged:
        lengths = np.linalg.norm(found.jac, axis=0)
        x = x - lstsq(found.jac / lengths, found.fun)[0] / lengths
    v = residuals(x)
    return x, float(v @ v), has_converged


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
