"""Transformations of the plane, comparator (X, Y) -> fiducial system (x, y), by name.

    similarity  (a0, b0, a1, a2)              x = a0 + a1 X + a2 Y,  y = b0 - a2 X + a1 Y
    affine      (a0, a1, a2, b0, b1, b2)      x = a0 + a1 X + a2 Y,  y = b0 + b1 X + b2 Y
    projective  (a0, a1, a2, b0, b1, b2, c1, c2)   x = (a0 + a1 X + a2 Y)/(1 + c1 X + c2 Y), y likewise

Coordinates in mm. The first two are linear in their parameters: the fit needs no start values.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import UsageError

Array = NDArray[np.float64]

PARAMETER_NAMES = {
    "similarity": ("a0", "b0", "a1", "a2"),
    "affine": ("a0", "a1", "a2", "b0", "b1", "b2"),
    "projective": ("a0", "a1", "a2", "b0", "b1", "b2", "c1", "c2"),
}


def parameter_names(name: str) -> tuple[str, ...]:
    """Names of the parameters of `similarity`, `affine` or `projective`, in the order used everywhere."""
    if name not in PARAMETER_NAMES:
        raise UsageError(f'unknown transformation "{name}"', f"Choose one of {', '.join(PARAMETER_NAMES)}.")
    return PARAMETER_NAMES[name]


def apply(name: str, parameters: ArrayLike, XY: ArrayLike) -> Array:
    """(x, y) (n, 2) mm of the named transformation at XY (n, 2) mm; `parameters` in the order of `parameter_names`.

    On the vanishing line of a projective transformation (1 + c1 X + c2 Y = 0) the result is inf or nan.
    """
    coefficients, denominator = numerator_coefficients(name, parameters, XY)
    with np.errstate(divide="ignore", invalid="ignore"):
        result: Array = homogeneous(XY) @ coefficients.T / denominator[:, None]
    return result


def partials(name: str, parameters: ArrayLike, XY: ArrayLike) -> Array:
    """d(x, y)/d(parameters): (n, 2, m) at XY (n, 2), m parameters in the order of `parameter_names`.

    affine: rows (1, X, Y) in the own block; projective: those / D, and dx/dc1 = -x X/D, dx/dc2 = -x Y/D,
    D = 1 + c1 X + c2 Y.
    """
    names = parameter_names(name)
    rows = homogeneous(XY)
    result = np.zeros((len(rows), 2, len(names)))
    if name == "similarity":
        one, X, Y = rows.T
        result[:, 0, 0] = result[:, 1, 1] = one
        result[:, 0, 2], result[:, 0, 3] = X, Y
        result[:, 1, 2], result[:, 1, 3] = Y, -X
        return result
    _, denominator = numerator_coefficients(name, parameters, XY)
    result[:, 0, 0:3] = result[:, 1, 3:6] = rows / denominator[:, None]
    if name == "projective":
        xy = apply(name, parameters, XY)
        result[:, :, 6:8] = -xy[:, :, None] * rows[:, None, 1:] / denominator[:, None, None]
    return result


def invert(name: str, parameters: ArrayLike, xy: ArrayLike) -> Array:
    """XY (n, 2) mm whose image under the named transformation is xy (n, 2) mm.

    (a1 - x c1) X + (a2 - x c2) Y = x - a0, likewise y; c = 0 but for `projective`. A transformation that maps the plane
    onto a line has no inverse (LinAlgError).
    """
    p = np.asarray(parameters, dtype=np.float64)
    target = np.asarray(xy, dtype=np.float64)
    coefficients, _ = numerator_coefficients(name, p, np.zeros((1, 2)))
    c = p[6:8] if name == "projective" else np.zeros(2)
    system = coefficients[:, 1:] - target[:, :, None] * c
    return np.asarray(np.linalg.solve(system, (target - coefficients[:, 0])[:, :, None])[:, :, 0])


def homogeneous(XY: ArrayLike) -> Array:
    """Rows (1, X, Y): (n, 3)."""
    points = np.asarray(XY, dtype=np.float64)
    return np.column_stack([np.ones(len(points)), points])


def numerator_coefficients(name: str, parameters: ArrayLike, XY: ArrayLike) -> tuple[Array, Array]:
    """[[a0 a1 a2], [b0 b1 b2]] and the denominator 1 + c1 X + c2 Y (n,), which is 1 but for `projective`."""
    p = np.asarray(parameters, dtype=np.float64)
    if len(p) != len(parameter_names(name)):
        raise UsageError(f"{name} takes {len(parameter_names(name))} parameters, {len(p)} were given")
    rows = homogeneous(XY)
    if name == "similarity":
        return np.array([[p[0], p[2], p[3]], [p[1], -p[3], p[2]]]), rows[:, 0]
    denominator: Array = rows[:, 0] + rows[:, 1:] @ p[6:8] if name == "projective" else rows[:, 0]
    return p[:6].reshape(2, 3), denominator
