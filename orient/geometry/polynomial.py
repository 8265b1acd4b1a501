"""Polynomials in two variables: z = sum a_jk u^j v^k, j + k <= degree, as seed 004 (1) writes them.

Terms stand by total degree, powers of u falling: 1, u, v, u^2, uv, v^2, ... The caller centres and scales u and v.
"""

from itertools import accumulate

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
POINTS_AT_ONCE = 24_576


def exponents(degree: int) -> tuple[tuple[int, int], ...]:
    """((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), ...): (degree+1)(degree+2)/2 pairs (j, k) of u^j v^k."""
    return tuple((total - k, k) for total in range(degree + 1) for k in range(total + 1))


def design(u: ArrayLike, v: ArrayLike, degree: int) -> Array:
    """z = D a: the rows u^j v^k of D (n, m), m = (degree+1)(degree+2)/2, of u, v (n,)."""
    u_powers, v_powers = powers(u, degree), powers(v, degree)
    return np.stack([u_powers[j] * v_powers[k] for j, k in exponents(degree)], axis=-1)


def gradient(u: ArrayLike, v: ArrayLike, degree: int) -> Array:
    """dz/du = sum a_jk j u^(j-1) v^k, dz/dv = sum a_jk k u^j v^(k-1): (n, m, 2), so that dz/d(u, v) = a . gradient."""
    u_powers, v_powers = powers(u, degree), powers(v, degree)
    terms = exponents(degree)
    by_u = np.stack([j * u_powers[max(j - 1, 0)] * v_powers[k] for j, k in terms], axis=-1)
    by_v = np.stack([k * u_powers[j] * v_powers[max(k - 1, 0)] for j, k in terms], axis=-1)
    return np.stack([by_u, by_v], axis=-1)


def powers(u: ArrayLike, degree: int) -> list[Array]:
    """[1, u, u^2, ..., u^degree], each (n,)."""
    base = np.asarray(u, dtype=np.float64)
    return list(accumulate([base] * degree, np.multiply, initial=np.ones_like(base)))


def values(u: ArrayLike, v: ArrayLike, coefficients: Array, *, compiled: bool = False) -> Array:
    """z (n, c) = sum a_jk u^j v^k of c polynomials, `coefficients` (m, c), by Horner's rule.

    z = sum over k of v^k (sum over j of a_jk u^j): both sums nested, no powers,
    some thousand points at once. `compiled`: by numba (extra `orient[fast]`), the same to 1e-9; the columns of z then
    stand one after the other. No stage asks for it.
    """
    u, v = np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)
    degree = int((np.sqrt(8 * len(coefficients) + 1) - 3) / 2)
    if compiled:
        return _compiled_values(u, v, degree, coefficients)
    by_power = dict(zip(exponents(degree), coefficients, strict=True))
    found = np.empty((len(u), coefficients.shape[1]))
    for begin in range(0, len(u), POINTS_AT_ONCE):
        part = slice(begin, begin + POINTS_AT_ONCE)
        for c in range(coefficients.shape[1]):
            found[part, c] = _horner(u[part], v[part], degree, {jk: float(row[c]) for jk, row in by_power.items()})
    return found


def _horner(u: Array, v: Array, degree: int, a: dict[tuple[int, int], float]) -> Array:
    """One polynomial of some points."""
    total, inner = np.full_like(u, a[0, degree]), np.empty_like(u)
    for k in range(degree - 1, -1, -1):
        np.multiply(u, a[degree - k, k], out=inner)
        inner += a[degree - k - 1, k]
        for j in range(degree - k - 2, -1, -1):
            inner *= u
            inner += a[j, k]
        total *= v
        total += inner
    return total


def _compiled_values(u: Array, v: Array, degree: int, coefficients: Array) -> Array:
    from orient.geometry.polynomial_kernel import horner

    by_power = np.zeros((coefficients.shape[1], degree + 1, degree + 1))
    j, k = np.array(exponents(degree)).T
    by_power[:, j, k] = coefficients.T
    u, v = np.ascontiguousarray(u), np.ascontiguousarray(v)
    columns = np.empty((len(by_power), len(u)))
    for a, z in zip(by_power, columns, strict=True):
        horner(degree)(u, v, a, z)
    return columns.T
