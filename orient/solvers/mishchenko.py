"""Q_z = (A_z'A_z)^-1, K = C_z Q_z C_z': orientation and ground of a vertical photo of flat terrain, a priori.

In units of the reading error, in the image scale; sums run over the n control points, g = f^2/c^2. For every layout
K = C(0) Q(0) C(0)' holds f/c out of the ground; the closed forms of the seed need a symmetric layout.
Source: seed 003 (I. I. Mishchenko), equations (1)-(21) corrected; EQUATIONS 3, 3.1, 3.2.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry.vertical_photo import design, design_parts, focal_transformation

FloatArray = NDArray[np.float64]

SINGULAR_RATIO = 1e-8
ROUNDING = 1e-12
SYMMETRIC = 1e-9
"""A moment per point below this is a zero with rounding."""


@dataclass(frozen=True, slots=True)
class Decomposition:
    """Q_z = Q^(f,c) + Q^(xi,eta) (7): what the lens does, and what number and place of the points do; (6, 6) each."""

    focal: FloatArray
    layout: FloatArray

    @property
    def Q(self) -> FloatArray:
        """The whole cofactor matrix."""
        return self.focal + self.layout


@dataclass(frozen=True, slots=True)
class ElementMatrices:
    """K_jk as (6, 6) tables whose elements sum to the covariance: `whole` (12) = `focal` (14) + `layout` (15)."""

    whole: FloatArray
    focal: FloatArray
    layout: FloatArray


@dataclass(frozen=True, slots=True)
class AxisMoments:
    """n, S2 = sum xi^2, S4 = sum xi^4 + sum xi^2 eta^2: the block {X_S, alpha}; with eta for xi {Y_S, omega}."""

    n: int
    S2: float
    S4: float

    @property
    def D(self) -> float:
        """n S4 - S2^2, the determinant of the block: Dx or Dy; independent of f.

        The one D of (10) has sum eta^4 for sum xi^4, which is the same in a symmetric layout.
        """
        return self.n * self.S4 - self.S2**2


@dataclass(frozen=True, slots=True)
class Condition:
    """One condition of the closed form that a layout does not meet, and the value of its sum."""

    name: str
    value: float
    separates: bool
    """True: without it {X_S, alpha}, {Y_S, omega}, Z_S, kappa do not separate; False: two determinants are needed."""


@dataclass(frozen=True, slots=True)
class Symmetry:
    """Which closed form a layout allows, and what stands in the way of the simpler one."""

    violated: tuple[Condition, ...]

    @property
    def determinants(self) -> Literal[0, 1, 2]:
        """1: (8)-(10) with one D; 2: with Dx and Dy; 0: no closed form, only the inverse."""
        if any(condition.separates for condition in self.violated):
            return 0
        return 2 if self.violated else 1


def cofactors(points: FloatArray, g: float) -> FloatArray:
    """Q_z = (A_z'A_z)^-1 (6, 6) of (4), for any layout `points` (n, 2) = xi, eta and g = (f/c)^2.

    From Q(0) by Q(g) = T^-1 Q(0) T^-T, so that a long focal length costs no digits. Raises GeometryError when the
    layout does not determine six elements.
    """
    F = focal_transformation(-g) @ _root(points)
    return np.asarray(F @ F.T)


def covariance(points: FloatArray, new: FloatArray) -> FloatArray:
    """K = C(0) Q(0) C(0)' (m, 2, m, 2) of (3), (20): covariances of new points in units of sigma^2, for any layout.

    The same as C_z Q_z C_z' for every f/c: the printed condition of a symmetric layout is not needed. On the ground
    sigma_X = sigma (H/f) sqrt(K_XX). It is the part of the orientation; a new point's own reading adds the unit
    matrix. `points` (n, 2) control, `new` (m, 2), all xi, eta of one c. Source: EQUATIONS 3.2.
    """
    rows = design(new, 0.0) @ _root(points)
    return np.asarray(np.einsum("jae,kbe->jakb", rows, rows))


def decomposition(points: FloatArray, g: float) -> Decomposition:
    """Q^(xi,eta) = Q(0), Q^(f,c) = -g (E Q(0) + Q(0) E') + g^2 E Q(0) E', E = E14 + E25: (7) for any layout."""
    root = _root(points)
    Q0 = root @ root.T
    E = focal_transformation(1.0) - np.eye(6)
    return Decomposition(-g * (E @ Q0 + Q0 @ E.T) + g * g * E @ Q0 @ E.T, Q0)


def closed_form(points: FloatArray, g: float, determinants: Literal[1, 2] = 1) -> Decomposition:
    """(8)-(10): Q11 = (n g^2 + 2 g S2 + S4)/D, Q14 = -(n g + S2)/D, Q44 = n/D, Q33 = Q66 = 1/sum(xi^2 + eta^2).

    The block {Y_S, omega} is the same as {X_S, alpha}, or, with two `determinants`, has its own sums and Dy. This is
    (A_z'A_z)^-1 only if `symmetry` allows it; it is computed without asking. Raises GeometryError when a determinant
    is zero. Source: seed 003 with the lost exponents of (9) put back; Dx, Dy: EQUATIONS 3.1.
    """
    of_x, of_y = moments(points)
    focal, layout = np.zeros((6, 6)), np.zeros((6, 6))
    for place, m in enumerate((of_x, of_y if determinants == 2 else of_x)):
        tilt, determinant = place + 3, m.D
        if determinant <= ROUNDING * m.n * m.S4:
            raise _undetermined()
        focal[place, place] = (g * g * m.n + 2 * g * m.S2) / determinant
        focal[place, tilt] = focal[tilt, place] = -g * m.n / determinant
        layout[place, place] = m.S4 / determinant
        layout[place, tilt] = layout[tilt, place] = -m.S2 / determinant
        layout[tilt, tilt] = m.n / determinant
    layout[2, 2] = layout[5, 5] = 1 / (of_x.S2 + of_y.S2)
    return Decomposition(focal, layout)


def moments(points: FloatArray) -> tuple[AxisMoments, AxisMoments]:
    """The even moments of a layout `points` (n, 2) = xi, eta, for the axes x and y."""
    xx, yy = (points**2).T
    mixed = float(np.sum(xx * yy))
    of_x, of_y = (AxisMoments(len(points), float(np.sum(s)), float(np.sum(s * s)) + mixed) for s in (xx, yy))
    return of_x, of_y


def conditions(points: FloatArray) -> tuple[Condition, ...]:
    """sum xi = sum eta = sum xi eta = 0, the same times (xi^2 + eta^2); sum xi^2 = sum eta^2, sum xi^4 = sum eta^4.

    The first six separate {X_S, alpha}, {Y_S, omega}, Z_S and kappa (necessary and sufficient for g > 0), the last
    two give one D. Every layout that is symmetric about both axes meets the six. Source: EQUATIONS 3.1.
    """
    xi, eta = points.T
    rr = xi**2 + eta**2
    sums = (
        ("sum xi", xi, True),
        ("sum eta", eta, True),
        ("sum xi eta", xi * eta, True),
        ("sum xi (xi^2 + eta^2)", xi * rr, True),
        ("sum eta (xi^2 + eta^2)", eta * rr, True),
        ("sum xi eta (xi^2 + eta^2)", xi * eta * rr, True),
        ("sum xi^2 - sum eta^2", xi**2 - eta**2, False),
        ("sum xi^4 - sum eta^4", xi**4 - eta**4, False),
    )
    return tuple(Condition(name, float(np.sum(terms)), separates) for name, terms, separates in sums)


def symmetry(points: FloatArray, tolerance: float = SYMMETRIC) -> Symmetry:
    """Which of the `conditions` a layout does not meet: a sum that exceeds `tolerance` per point."""
    return Symmetry(tuple(each for each in conditions(points) if abs(each.value) > tolerance * len(points)))


def element_matrices(
    first: tuple[FloatArray, int], second: tuple[FloatArray, int], parts: Decomposition, g: float
) -> ElementMatrices:
    """L_j Q L_k (12) = K^(f,c) (14) + K^(xi,eta) (15), element by element, for two new points and an axis of each.

    K^(f,c) = L_j Q^(f,c) L_k + L_j^(f,c) Q^(xi,eta) L_k + L_j^(xi,eta) Q^(xi,eta) L_k^(f,c): its elements sum to zero,
    (18) is its (X, X) of a symmetric layout; the elements of `layout` sum to the covariance (19). `first`, `second`:
    point (2,) = xi, eta and axis 0 (X) or 1 (Y); `parts` of `closed_form` or, for any layout, `decomposition`.
    """
    return _elements(_parts_of_row(first, g), _parts_of_row(second, g), parts)


def element_sums(points: FloatArray, parts: Decomposition, g: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of K_XX and K_YY of each new point: sum and largest element of K^(f,c), sum of K^(xi,eta); (m, 2) each.

    (13) = (14) + (15): the first is zero for every layout, so that the last is the covariance, in units of sigma^2;
    the second tells how large the terms are that cancel. `points` (m, 2) = xi, eta.
    """
    rows = design_parts(points, g)
    found = _elements(rows, rows, parts)
    largest = np.max(np.abs(found.focal), axis=(-2, -1))
    return np.sum(found.focal, axis=(-2, -1)), largest, np.sum(found.layout, axis=(-2, -1))


def variance_of_uses(
    C: FloatArray, factor: FloatArray, groups: Mapping[str, Sequence[int]]
) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]]:
    """diag(C Q C'): with the full Q, with its diagonal alone, and with the elements of each group alone; (m, k) each.

    Only the first is the variance of the ground. The parts of f/c cancel between the elements, so that a part of the
    six, or the six without their covariances, is wrong by a factor that grows with f/c (grid of 3 x 3, f/c = 6.7,
    point (.5, .25): 686 for .1687). `C` (m, k, 6) partials by the elements, `factor` F with Q = F F'; `groups`:
    positions of elements by name. Source: seed 003, last recommendation; EQUATIONS 3.2 (c).
    """
    full = np.sum((C @ factor) ** 2, axis=-1)
    diagonal = C**2 @ np.sum(factor**2, axis=1)
    alone = {name: np.sum((C[..., list(at)] @ factor[list(at)]) ** 2, axis=-1) for name, at in groups.items()}
    return full, diagonal, alone


def _elements(
    first: tuple[FloatArray, FloatArray], second: tuple[FloatArray, FloatArray], parts: Decomposition
) -> ElementMatrices:
    """(12), (14), (15) for rows (..., 6) of L^(xi,eta) and L^(f,c) of both points."""
    (j, j_focal), (k, k_focal) = first, second
    whole = _outer(j + j_focal, k + k_focal)
    focal = whole * parts.focal + (_outer(j_focal, k + k_focal) + _outer(j, k_focal)) * parts.layout
    return ElementMatrices(whole * parts.Q, focal, _outer(j, k) * parts.layout)


def _outer(left: FloatArray, right: FloatArray) -> FloatArray:
    return np.asarray(left[..., :, None] * right[..., None, :])


def _parts_of_row(place: tuple[FloatArray, int], g: float) -> tuple[FloatArray, FloatArray]:
    point, axis = place
    by_layout, by_focal_length = design_parts(point[None, :], g)
    return by_layout[0, axis], by_focal_length[0, axis]


def _root(points: FloatArray) -> FloatArray:
    """F (6, 6) with Q(0) = F F'."""
    if not np.isfinite(points).all() or len(points) < 3:
        raise _undetermined()
    R = np.linalg.qr(design(points, 0.0).reshape(-1, 6), mode="r")
    norms = np.linalg.norm(R, axis=0)
    values = np.linalg.svd(R / np.where(norms > 0, norms, 1.0), compute_uv=False)
    if not values[-1] > SINGULAR_RATIO * values[0]:
        raise _undetermined()
    return np.asarray(np.linalg.inv(R))


def _undetermined() -> GeometryError:
    return GeometryError(
        "The layout does not determine the six elements of a vertical photo.",
        "Take three or more points that do not lie on a line, nor with the nadir on a circle.",
    )
