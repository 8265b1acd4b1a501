"""The interior orientation by scipy.optimize.least_squares with partials by the complex step: a second solution.

x = (a0 + a1 X + a2 Y)/(1 + c1 X + c2 Y), y likewise with b; similarity: b1 = -a2, b2 = a1; affine: c1 = c2 = 0.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lstsq

from orient.solvers.independent_algebra import minimised

FloatArray = NDArray[np.float64]

NAMES = {
    "similarity": ("a0", "b0", "a1", "a2"),
    "affine": ("a0", "a1", "a2", "b0", "b1", "b2"),
    "projective": ("a0", "a1", "a2", "b0", "b1", "b2", "c1", "c2"),
}


@dataclass(frozen=True, slots=True)
class IndependentPlane:
    """`parameters` by name; `cofactor` (m, m) in the order of `NAMES`; `vv` = sum of squared residuals [mm^2]."""

    parameters: dict[str, float]
    cofactor: FloatArray
    vv: float
    redundancy: int


def fit_plane(measured: FloatArray, calibrated: FloatArray, transformation: str) -> IndependentPlane:
    """T(X) - x -> min over the marks: measured (n, 2), calibrated (n, 2) [mm]; start: the affine one by lstsq."""
    names = NAMES[transformation]

    def residuals(p: NDArray[np.complex128]) -> NDArray[np.complex128]:
        return np.asarray(_transformed(dict(zip(names, p, strict=True)), measured) - calibrated).ravel()

    def real(p: FloatArray) -> FloatArray:
        return residuals(p.astype(np.complex128)).real

    def jacobian(p: FloatArray) -> FloatArray:
        steps = 1e-30j * np.eye(len(p))
        return np.stack([residuals(p + step).imag / 1e-30 for step in steps], axis=-1)

    p, vv, _ = minimised(real, jacobian, _start(measured, calibrated, names))
    inverse = np.linalg.pinv(jacobian(p))
    parameters = dict(zip(names, p.tolist(), strict=True))
    return IndependentPlane(parameters, inverse @ inverse.T, vv, measured.size - len(names))


def _transformed(p: dict[str, complex], XY: FloatArray) -> NDArray[np.complex128]:
    X, Y = XY.T
    b1, b2 = p.get("b1", -p["a2"]), p.get("b2", p["a1"])
    below = 1.0 + p.get("c1", 0.0) * X + p.get("c2", 0.0) * Y
    return np.column_stack([(p["a0"] + p["a1"] * X + p["a2"] * Y) / below, (p["b0"] + b1 * X + b2 * Y) / below])


def _start(measured: FloatArray, calibrated: FloatArray, names: tuple[str, ...]) -> FloatArray:
    design = np.column_stack([np.ones(len(measured)), measured])
    affine = dict(zip(NAMES["affine"], lstsq(design, calibrated)[0].T.ravel(), strict=True))
    return np.array([affine.get(name, 0.0) for name in names])
