"""The polynomial of a map sheet in Legendre's basis, by LAPACK's complete orthogonal factorisation: a second solution.

The same space of functions, hence the same fit; P_j(u) P_k(v) instead of u^j v^k, gelsy instead of Householder's QR.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.linalg import lstsq

from orient.geometry.polynomial import exponents

FloatArray = NDArray[np.float64]

ENGINE = "scipy lstsq, Legendre"


@dataclass(frozen=True, slots=True)
class IndependentPolynomial:
    """Coefficients (m, 2) of u^j v^k in the order of `exponents`, cofactor (m, m), sigma0 (2,); None: no redundancy."""

    coefficients: FloatArray
    cofactor: FloatArray
    sigma0: FloatArray | None


def fit_in_legendre(uv: FloatArray, target: FloatArray, degree: int) -> IndependentPolynomial:
    """v = polynomial - target -> min over the crosses; uv (n, 2) reduced, target (n, 2).

    Source: seed 004, equation (1); Legendre polynomials as in Abramowitz and Stegun, 22.3.
    """
    terms = exponents(degree)
    full = legendre.legvander2d(uv[:, 0], uv[:, 1], [degree, degree]).reshape(len(uv), degree + 1, degree + 1)
    design = np.column_stack([full[:, j, k] for j, k in terms])
    solution = lstsq(design, target, lapack_driver="gelsy")[0]
    inverse = np.linalg.pinv(design)
    to_powers = _to_powers(terms)
    residuals = design @ solution - target
    redundancy = len(uv) - len(terms)
    sigma0 = np.sqrt(np.sum(residuals**2, axis=0) / redundancy) if redundancy > 0 else None
    cofactor = to_powers @ (inverse @ inverse.T) @ to_powers.T
    return IndependentPolynomial(to_powers @ solution, cofactor, sigma0)


def _to_powers(terms: tuple[tuple[int, int], ...]) -> FloatArray:
    """(m, m): coefficients of u^j v^k by those of P_j(u) P_k(v)."""
    place = {term: index for index, term in enumerate(terms)}
    matrix = np.zeros((len(terms), len(terms)))
    for column, (j, k) in enumerate(terms):
        by_u, by_v = (legendre.leg2poly(np.eye(order + 1)[order]) for order in (j, k))
        for a, b in np.ndindex(j + 1, k + 1):
            matrix[place[a, b], column] = by_u[a] * by_v[b]
    return matrix
