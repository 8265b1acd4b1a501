"""z = sum c_jk u^j v^k of many points: normal equations on centred, scaled coordinates, or QR.

The full fit of a map sheet with its tests is `orient.solvers.polynomial_fit.fit_sheet`; both have the same optimum, in
the same centre and scale.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError, UsageError, require_numba
from orient.geometry import polynomial
from orient.solvers.polynomial_degree import terms
from orient.words import counted

FloatArray = NDArray[np.float64]

POINTS_AT_ONCE = 2048
WELL_CONDITIONED = 1e3
"""Condition of the columns, scaled to one length, up to which normal equations keep nine digits of Q; above: QR."""
SMALL_RESIDUALS = 1e-6
"""v'v / z'z below which v'v = z'z - rho'rho has lost too many digits: then it is summed, and c corrected by it."""
SINGULAR = 1e10


@dataclass(frozen=True, slots=True)
class LeanPolynomial:
    """u = (X - X0)/scale, v = (Y - Y0)/scale; z = sum of c_jk u^j v^k, `coefficients` (m, c) as `exponents`.

    `centre` (X0, Y0), `R_inverse` (m, m) with Q = R^-1 R^-T, `vv` (c,) sums of squared residuals, redundancy n - m.
    """

    degree: int
    centre: FloatArray
    scale: float
    coefficients: FloatArray
    R_inverse: FloatArray
    vv: FloatArray
    redundancy: int

    @property
    def Q(self) -> FloatArray:
        """Cofactors (m, m) of the coefficients of each coordinate; covariance = sigma0^2 Q."""
        return np.asarray(self.R_inverse @ self.R_inverse.T)

    @property
    def sigma0(self) -> FloatArray | None:
        """sqrt(v'v / (n - m)) (c,) in the unit of z; None without redundancy."""
        return np.asarray(np.sqrt(self.vv / self.redundancy)) if self.redundancy > 0 else None

    def values(self, XY: FloatArray, *, compiled: bool = False) -> FloatArray:
        """z (k, c) at places XY (k, 2); `compiled` by numba (extra `orient[fast]`), the same to 1e-9."""
        require_numba(compiled)
        u, v = self._normalised(XY)
        return polynomial.values(u, v, self.coefficients, compiled=compiled)

    def leverages(self, XY: FloatArray) -> FloatArray:
        """h = rows Q rows' (k,): variance of z at XY by sigma0^2; 1 - h is the redundancy number of a fitted point."""
        uv = self._normalised(XY)
        equations = _Equations(uv, np.empty((0, uv.shape[1])), self.degree)
        parts = (np.sum((self.R_inverse.T @ D) ** 2, axis=0) for D in equations.bordered())
        return np.concatenate([np.empty(0), *parts])

    def _normalised(self, XY: FloatArray) -> FloatArray:
        """u, v (2, k); one place may come alone."""
        places = np.atleast_2d(np.asarray(XY, dtype=np.float64))
        if places.ndim != 2 or places.shape[1] != 2:  # one column would be taken for both
            raise UsageError(f"XY has the shape {np.shape(XY)}", "Give XY (k, 2).")
        return np.ascontiguousarray(((places - self.centre) / self.scale).T)


def lean_polynomial(XY: FloatArray, z: FloatArray, degree: int) -> LeanPolynomial:
    """v = D c - z, v'v -> min for each column of z (n, c); XY (n, 2), degree 1 or more.

    R'R = D'D by Cholesky, c = R^-1 rho, rho = R^-T D'z, v'v = z'z - rho'rho; where the residuals are small, both once
    more from the residuals, which gives back the digits that squaring cost. Where the columns depend on each other
    (`WELL_CONDITIONED`) QR takes over. Refuses (GeometryError) too few points and points on a curve of the degree.
    Source: seed 004, equation (1); corrected seminormal equations: Bjorck 1987.
    """
    m = terms(degree)
    if len(XY) < m:
        points = counted(len(XY), "point")
        raise GeometryError(f"{points}; degree {degree} needs {m}", "Give more points or a lower degree.")
    uv, centre, scale = _normalised(XY)
    columns = np.array(z.T, dtype=np.float64, order="C")
    origin = columns.mean(axis=1)
    columns -= origin[:, None]
    equations = _Equations(uv, columns, degree)
    found = _by_normals(equations)
    if found is None:
        R_inverse, first = _by_qr(equations)
        found = R_inverse, *_corrected(equations, R_inverse, first)
    R_inverse, coefficients, vv = found
    coefficients[0] += origin
    return LeanPolynomial(degree, centre, scale, coefficients, R_inverse, vv, len(XY) - m)


def _normalised(XY: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """u, v (2, n), middle of the extent of the points and half its longer side."""
    uv = np.array(XY.T, dtype=np.float64, order="C")
    low, high = uv.min(axis=1), uv.max(axis=1)
    centre, scale = (low + high) / 2.0, float(np.max(high - low)) / 2.0
    if not scale > 0:
        raise GeometryError("All points lie in one place.", "Correct the coordinates.")
    uv -= centre[:, None]
    uv /= scale
    return uv, centre, scale


@cache
def _exponents(degree: int) -> NDArray[np.intp]:
    return np.array(polynomial.exponents(degree), dtype=np.intp).T


class _Equations:
    """u, v (2, n) and z (c, n); what is made of some thousand points at a time stands in one buffer."""

    def __init__(self, uv: FloatArray, z: FloatArray, degree: int) -> None:
        self.uv, self.z, self.degree = uv, z, degree
        rows = max(2 * (2 * degree + 1) + len(z) * (degree + 1), terms(degree) + len(z))
        self._buffer = np.empty(rows * min(POINTS_AT_ONCE, uv.shape[1]))

    def normals(self) -> tuple[FloatArray, FloatArray]:
        """D'D (m, m) and D'z (m, c) from the sums of u^j v^k, j, k <= 2d: there are fewer of them than of products."""
        j, k = _exponents(self.degree)
        moments, with_z = self._moments()
        return moments[j[:, None] + j, k[:, None] + k], with_z[j, :, k]

    def bordered(self) -> Iterator[FloatArray]:
        """[D'; z'] (m + c, k) of the points in their order; the next part overwrites it."""
        m = terms(self.degree)
        for uv, z in self._parts():
            rows = self._rows(m + len(z), z)
            rows[0], row = 1.0, 1
            for total in range(1, self.degree + 1):
                np.multiply(rows[row - total : row], uv[0], out=rows[row : row + total])
                np.multiply(rows[row - 1], uv[1], out=rows[row + total])
                row += total + 1
            rows[m:] = z
            yield rows

    def _moments(self) -> tuple[FloatArray, FloatArray]:
        """sum u^j v^k (2d+1, 2d+1), sum u^j v^k z (d+1, c, d+1)."""
        low, high, c = self.degree + 1, 2 * self.degree + 1, len(self.z)
        moments, with_z = np.zeros((high, high)), np.zeros((low, c * low))
        for uv, z in self._parts():
            rows = self._rows(2 * high + c * low, z)
            powers, zV = rows[: 2 * high].reshape(2, high, -1), rows[2 * high :]
            powers[:, 0] = 1.0
            for exponent in range(1, high):
                np.multiply(powers[:, exponent - 1], uv, out=powers[:, exponent])
            U, V = powers
            np.multiply(z[:, None], V[:low], out=zV.reshape(c, low, -1))
            moments += U @ V.T
            with_z += U[:low] @ zV.T
        return moments, with_z.reshape(low, c, low)

    def _parts(self) -> Iterator[tuple[FloatArray, FloatArray]]:
        for begin in range(0, self.uv.shape[1], POINTS_AT_ONCE):
            part = slice(begin, begin + POINTS_AT_ONCE)
            yield self.uv[:, part], self.z[:, part]

    def _rows(self, count: int, z: FloatArray) -> FloatArray:
        return self._buffer[: count * z.shape[1]].reshape(count, -1)


def _by_normals(equations: _Equations) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """R^-1, c and v'v; None where D'D is not to be trusted."""
    N, g = equations.normals()
    if not np.all(np.diag(N) > 0.0):  # all points on an axis
        return None
    scales = 1.0 / np.sqrt(np.diag(N))
    try:
        L = np.linalg.cholesky(N * scales * scales[:, None])
        L_inverse = np.linalg.inv(L)
    except np.linalg.LinAlgError:
        return None
    if not np.linalg.norm(L) * np.linalg.norm(L_inverse) <= WELL_CONDITIONED:
        return None
    R_inverse = scales[:, None] * L_inverse.T
    rho = R_inverse.T @ g
    zz = np.einsum("cn,cn->c", equations.z, equations.z)
    vv, c = zz - np.sum(rho**2, axis=0), R_inverse @ rho
    if np.any(vv < SMALL_RESIDUALS * zz):
        c, vv = _corrected(equations, R_inverse, c)
    return R_inverse, c, vv


def _by_qr(equations: _Equations) -> tuple[FloatArray, FloatArray]:
    D = polynomial.design(equations.uv[0], equations.uv[1], equations.degree)
    scales = 1.0 / np.maximum(np.linalg.norm(D, axis=0), np.finfo(np.float64).tiny)
    Q, R = np.linalg.qr(D * scales)
    if not np.linalg.cond(R) < SINGULAR:
        degree = equations.degree
        raise GeometryError(
            f"The points lie on one curve of degree {degree}, so that degree {degree} is not determined.",
            "Give a lower degree or points off the curve.",
        )
    R_inverse = scales[:, None] * np.linalg.inv(R)
    return R_inverse, R_inverse @ (Q.T @ equations.z.T)


def _corrected(equations: _Equations, R_inverse: FloatArray, c: FloatArray) -> tuple[FloatArray, FloatArray]:
    """c after one correction by the residuals, and v'v there."""
    g, vv = np.zeros_like(c), np.zeros(c.shape[1])
    by_rows = np.concatenate([c, -np.eye(len(vv))]).T
    for rows in equations.bordered():
        v = by_rows @ rows
        g += rows[: len(c)] @ v.T
        vv += np.einsum("ck,ck->c", v, v)
    step = R_inverse.T @ g
    return c - R_inverse @ step, np.maximum(vv - np.sum(step**2, axis=0), 0.0)
