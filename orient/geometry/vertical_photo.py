"""A_z = [1 0 xi g+xi^2 xi*eta -eta; 0 1 eta xi*eta g+eta^2 xi], g = f^2/c^2: a vertical photo of flat terrain.

xi = x/c, eta = y/c with c = max|x|, |y| of the control. Its unknowns are scaled,

    u = ( f dX_S/(H c), f dY_S/(H c), dZ_S/H, (c/f) dalpha, (c/f) domega, dkappa ),

H = height above the ground, observations in units of c. A_z is minus the collinearity partials with their columns so
scaled. Also the layouts of control that are usual in the frame.
Source: seed 003 (I. I. Mishchenko), equations (5), (6), (11), (16), (17), (21) corrected; EQUATIONS 3.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SCALED_ELEMENTS = ("X_S", "Y_S", "Z_S", "alpha", "omega", "kappa")
X, Y = 0, 1
"""Axes of the image, as they are counted in the second index of the design."""


def normalised(image: ArrayLike, c: float | None = None) -> tuple[Array, float]:
    """xi = x/c, eta = y/c (n, 2), and c = max(|x|, |y|) in the unit of `image` (n, 2) unless it is given (6).

    All points in the principal point give c = 0 and not-a-number: such a layout determines nothing.
    """
    xy = np.asarray(image, dtype=np.float64)
    half = float(np.max(np.abs(xy))) if c is None else c
    with np.errstate(invalid="ignore", divide="ignore"):
        return xy / half, half


def design_parts(points: ArrayLike, g: float) -> tuple[Array, Array]:
    """L^(xi,eta), L^(f,c): the rows of A_z without g, and g alone, each (n, 2, 6); A_z is their sum (16), (17).

    X rows (1, 0, xi, xi^2, xi eta, -eta) and (0, 0, 0, g, 0, 0); Y rows (0, 1, eta, xi eta, eta^2, xi) and
    (0, 0, 0, 0, g, 0). `points` (n, 2): xi, eta. The first is C^(xi,eta) of (21),
    with eta_j^2 where xi_i^2 is printed.
    """
    xi, eta = np.asarray(points, dtype=np.float64).T
    one, zero = np.ones_like(xi), np.zeros_like(xi)
    by_layout = np.stack(
        [
            np.stack([one, zero, xi, xi * xi, xi * eta, -eta], axis=-1),
            np.stack([zero, one, eta, xi * eta, eta * eta, xi], axis=-1),
        ],
        axis=1,
    )
    by_focal_length = np.zeros_like(by_layout)
    by_focal_length[:, X, 3] = by_focal_length[:, Y, 4] = g
    return by_layout, by_focal_length


def design(points: ArrayLike, g: float) -> Array:
    """A_z (n, 2, 6) of control, or C_z of new points, by (5): `points` (n, 2) are xi, eta; g = (f/c)^2 >= 0."""
    by_layout, by_focal_length = design_parts(points, g)
    return by_layout + by_focal_length


def focal_transformation(g: float) -> Array:
    """T = I + g (E14 + E25) (6, 6), det T = 1: A_z(g) = A_z(0) T and C_z(g) = C_z(0) T for every layout.

    Its inverse is `focal_transformation(-g)`. Hence C Q C' does not know f/c. Source: EQUATIONS 3.2.
    """
    T = np.eye(6)
    T[0, 3] = T[1, 4] = g
    return T


def element_units(f: float, c: float, H: float) -> Array:
    """(H/f, H/f, H/c, f/c^2, f/c^2, 1/c): sigma of an element = sigma of a reading x this x sqrt(Q_ii), (6,).

    `f`, `c` and the reading in one unit, H in metres: X_S, Y_S, Z_S in metres, alpha, omega, kappa in radians.
    """
    return np.array([H / f, H / f, H / c, f / c**2, f / c**2, 1.0 / c])


def grid_layout(width: float, height: float, columns: int, rows: int) -> Array:
    """x_i = width (i/(columns-1) - 1/2), y_j = height (1/2 - j/(rows-1)): points (columns x rows, 2) about the origin.

    Row by row from the top left corner; a single column or row lies in the middle. 2 x 2 are the corners.
    """
    x = np.linspace(-0.5, 0.5, columns) * width if columns > 1 else np.zeros(1)
    y = np.linspace(0.5, -0.5, rows) * height if rows > 1 else np.zeros(1)
    return np.column_stack([np.tile(x, rows), np.repeat(y, columns)])


def gruber_layout(width: float, height: float, base: float = 0.4) -> Array:
    """(0, 0), (b, 0), (0, d), (b, d), (0, -d), (b, -d), b = base x width, d = base x height: (6, 2).

    The six points of O. von Gruber as the left photo of a pair with 1 - base = 60 % overlap sees them.
    """
    b, d = base * width, base * height
    return np.array([[0.0, 0.0], [b, 0.0], [0.0, d], [b, d], [0.0, -d], [b, -d]])
