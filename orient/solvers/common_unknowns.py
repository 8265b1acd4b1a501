"""P_i = P_i0 + G_i c + p_i, x_i = x_i0 + H_i c + v_i: corrections c that many points share.

On the ground: the polynomial of their map sheet. In the image: the interior orientation through fiducial marks.
c has its own a-priori cofactor matrix C = F F'. Inside, c = F z with z of unit weight: well scaled whatever the units
of c, and a direction in which C vanishes is no unknown. The points are eliminated one by one, then z; what stays is a
triangle of the elements. The cost grows with the number of points only.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError

FloatArray = NDArray[np.float64]

PRESENT = 1e-14
"""Eigenvalue of the correlation matrix, relative to the largest, below which a direction of c is taken as known."""


@dataclass(frozen=True, slots=True)
class CommonUnknowns:
    """`partials` G (n, 3, k): shift of each point [m] by each unknown, zero where a point does not depend on it.

    `by_image` H (n, 2, k) [mm]: likewise of its image coordinates, None where no unknown moves them. `cofactor` (k, k):
    a-priori covariance / sigma0^2 of the unknowns; `names` (k,) serve the messages.
    """

    partials: FloatArray
    cofactor: FloatArray
    names: Sequence[str]
    by_image: FloatArray | None = None


@dataclass(frozen=True, slots=True)
class WhitenedCommon:
    """`factor` F (k, q), F F' = cofactor; `inverse` (q, k), F^-1 F = I; `by_ground` (n, 3, q) = G_i F.

    `by_image` (n, 2, q) = H_i F.
    """

    factor: FloatArray
    inverse: FloatArray
    by_ground: FloatArray
    by_image: FloatArray

    @property
    def rank(self) -> int:
        """q, the number of unknowns z."""
        return int(self.factor.shape[1])

    def shift(self, z: FloatArray) -> FloatArray:
        """(n, 3) G_i F z."""
        return np.asarray(self.by_ground @ z)

    def image_shift(self, z: FloatArray) -> FloatArray:
        """(n, 2) H_i F z."""
        return np.asarray(self.by_image @ z)


@dataclass(frozen=True, slots=True)
class CommonTriangle:
    """R_z dz + R_e (de / s) = -rho: (q, q), (q, u), (q,); the equations of z when the points are eliminated."""

    R_z: FloatArray
    R_e: FloatArray
    rho: FloatArray

    def corrections(self, scaled_elements: FloatArray) -> FloatArray:
        """dz (q,) that belong to the corrections de / s (u,) of the elements."""
        return np.asarray(-np.linalg.solve(self.R_z, self.rho + self.R_e @ scaled_elements))

    def rim_cofactors(self, scales: FloatArray, Q: FloatArray) -> FloatArray:
        """Cofactor matrix (q+u, q+u) of z and the elements from that, (u, u), of the elements."""
        q = len(self.R_z)
        inverse = np.linalg.inv(self.R_z)
        by_elements = -inverse @ self.R_e / scales
        rim = np.empty((q + len(Q), q + len(Q)))
        rim[q:, q:] = Q
        rim[:q, q:] = by_elements @ Q
        rim[q:, :q] = rim[:q, q:].T
        rim[:q, :q] = inverse @ inverse.T + by_elements @ Q @ by_elements.T
        return rim


def no_common(n: int) -> WhitenedCommon:
    """Points that share nothing."""
    return WhitenedCommon(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros((n, 3, 0)), np.zeros((n, 2, 0)))


def whitened(common: CommonUnknowns | None, n: int) -> WhitenedCommon:
    """c = F z, F = diag(sigma) V sqrt(lambda) from the correlations V lambda V' of c; refuses a bad covariance."""
    if common is None:
        return no_common(n)
    variances = np.diagonal(common.cofactor)
    by_image = np.zeros((n, 2, len(variances))) if common.by_image is None else common.by_image
    is_finite = all(np.isfinite(part).all() for part in (common.cofactor, common.partials, by_image))
    if not (is_finite and (variances >= 0).all()):
        raise GeometryError(f"The covariance of the common unknowns ({_listed(common.names)}) is not positive.")
    sigma = np.sqrt(variances)
    safe = np.where(sigma > 0, sigma, 1.0)
    values, axes = np.linalg.eigh(common.cofactor / np.outer(safe, safe))
    if len(values) and values[0] < -np.sqrt(PRESENT) * values[-1]:
        raise GeometryError(f"The covariance of the common unknowns ({_listed(common.names)}) is not positive.")
    present = values > PRESENT * np.max(values, initial=0.0)
    root, axes = np.sqrt(values[present]), axes[:, present]
    factor = sigma[:, None] * axes * root
    return WhitenedCommon(factor, (axes / root / safe[:, None]).T, common.partials @ factor, by_image @ factor)


def together(parts: Sequence[CommonUnknowns]) -> CommonUnknowns | None:
    """Independent groups of unknowns, one after the other; None for none. All parts speak of the same n points."""
    if not parts:
        return None
    ends = np.cumsum([len(part.names) for part in parts])
    cofactor = np.zeros((ends[-1], ends[-1]))
    by_image = np.zeros((len(parts[0].partials), 2, ends[-1]))
    for part, end in zip(parts, ends, strict=True):
        span = slice(end - len(part.names), end)
        cofactor[span, span] = part.cofactor
        if part.by_image is not None:
            by_image[:, :, span] = part.by_image
    partials = np.concatenate([part.partials for part in parts], axis=2)
    return CommonUnknowns(partials, cofactor, [name for part in parts for name in part.names], by_image)


def redundancy_numbers(common: WhitenedCommon, Q_z: FloatArray) -> FloatArray:
    """diag(I - Q_c C^-1) (k,): what the photo adds to the a-priori knowledge of each c; their sum is q - tr Q_z."""
    added = common.factor @ (np.eye(common.rank) - Q_z)
    return np.asarray(np.sum(added * common.inverse.T, axis=1))


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:3]) + (" ..." if len(names) > 3 else "")
