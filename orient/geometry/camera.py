"""v = h(F; c) - G(c): a frame camera whose interior orientation c is to be found, in both directions of distortion.

F = (x, y) by collinearity, q = measured - (x0, y0), B = [b1 b2; 0 0], a = refraction and curvature (corrections).

    ideal_to_distorted        h = (I + B)(p + d(p)), p = F - a      G = q
    correction, displacement  h = F                                 G = q +- (d(q) + B q) + a

So the residual is always that of a coordinate that was measured or corrected by numbers, never of an inverted lens.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from orient.geometry.distortion import Distortion, coefficient_partials, field_of, ideal_position

Array = NDArray[np.float64]

INTERIOR = ("f", "x0", "y0", "k1", "k2", "k3", "p1", "p2", "b1", "b2")
"""What can be estimated, in the order of columns: focal length, principal point, lens, affinity."""
LENS = ("k1", "k2", "k3", "p1", "p2")


@dataclass(frozen=True, slots=True)
class Measured:
    """Image coordinates `frame` (n, 2) [mm] before any correction of the camera; `air` (n, 2): what refraction adds."""

    frame: Array
    air: Array


@dataclass(frozen=True, slots=True)
class Camera:
    """f, principal point, lens and affinity [mm]; the lens in its own definition and direction (conventions 7)."""

    f_mm: float
    x0_mm: float = 0.0
    y0_mm: float = 0.0
    distortion: Distortion = field(default_factory=Distortion)
    b1: float = 0.0
    b2: float = 0.0

    @property
    def is_from_ideal(self) -> bool:
        """Does the lens take ideal positions to distorted ones?"""
        return self.distortion.model != "none" and self.distortion.direction == "ideal_to_distorted"

    @property
    def principal_point(self) -> Array:
        return np.array([self.x0_mm, self.y0_mm])

    @property
    def affinity(self) -> Array:
        """B (2, 2)."""
        return np.array([[self.b1, self.b2], [0.0, 0.0]])

    def values(self, names: Sequence[str]) -> Array:
        """The named elements of `INTERIOR`; a coefficient that the lens does not have is 0."""
        known = {"f": self.f_mm, "x0": self.x0_mm, "y0": self.y0_mm, "b1": self.b1, "b2": self.b2}
        known |= {name: self.distortion.coefficients.get(name, 0.0) for name in LENS}
        return np.array([known[name] for name in names], dtype=np.float64)

    def with_values(self, names: Sequence[str], values: Array) -> "Camera":
        """The camera with other values of the named elements; opencv is normalised by the new f."""
        new: Mapping[str, float] = {name: float(value) for name, value in zip(names, values, strict=True)}
        lens = {name: value for name, value in new.items() if name in LENS}
        rest = {f"{name}_mm" if name in ("f", "x0", "y0") else name: new[name] for name in new if name not in LENS}
        coefficients = {**self.distortion.coefficients, **lens}
        f_mm = new.get("f", self.f_mm)
        return replace(self, **rest, distortion=replace(self.distortion, coefficients=coefficients, f_mm=f_mm))


@dataclass(frozen=True, slots=True)
class CameraEquations:
    """v and G (n, 2) [mm], the partials of v by the computed F (n, 2, 2) and by the named elements (n, 2, m)."""

    misclosure: Array
    measured: Array
    by_computed: Array
    by_elements: Array


def camera_equations(camera: Camera, names: Sequence[str], computed: Array, measured: Measured) -> CameraEquations:
    """v = h(F; c) - G(c) with dv/dF and dv/dc, `computed` F (n, 2) [mm] for f of the camera itself.

        from ideal:  dv/df = (I+B)[(I+d') F/f + (d - d'p)/f (opencv only)],  dv/dx0 = (1, 0)',  dv/dk = (I+B) dd/dk(p)
        otherwise:   dv/df = F/f,  dv/dx0 = (I +- (d' + B))(1, 0)',  dv/dk = -+ dd/dk(q)

    dv/df contains the change of F, which is proportional to f. Derived here; central differences in the tests.
    """
    if camera.is_from_ideal:
        return _in_measured(camera, names, computed, measured)
    return _in_corrected(camera, names, computed, measured)


def corrected(camera: Camera, measured: Measured) -> Array:
    """Image coordinates (n, 2) from the principal point, free of distortion, refraction and curvature."""
    q = measured.frame - camera.principal_point
    if camera.is_from_ideal:
        distorted = q @ np.linalg.inv(np.eye(2) + camera.affinity).T
        return ideal_position(camera.distortion, distorted) + measured.air
    d, _ = field_of(camera.distortion, q)
    return np.asarray(q + _sign(camera) * (d + q @ camera.affinity.T) + measured.air)


def _in_measured(camera: Camera, names: Sequence[str], computed: Array, measured: Measured) -> CameraEquations:
    ideal = computed - measured.air
    d, jacobian = field_of(camera.distortion, ideal)
    affine = np.eye(2) + camera.affinity
    distorted = ideal + d
    by_computed = affine @ (np.eye(2) + jacobian)
    by_f = (by_computed @ computed[:, :, None])[:, :, 0]
    if camera.distortion.model == "opencv":
        by_f = by_f + (d - (jacobian @ ideal[:, :, None])[:, :, 0]) @ affine.T
    lens = [name for name in names if name in LENS]
    by_lens = affine @ coefficient_partials(camera.distortion, lens, ideal)
    columns = _columns(names, by_f / camera.f_mm, np.broadcast_to(np.eye(2), jacobian.shape), by_lens, distorted)
    q = measured.frame - camera.principal_point
    return CameraEquations(distorted @ affine.T - q, q, by_computed, columns)


def _in_corrected(camera: Camera, names: Sequence[str], computed: Array, measured: Measured) -> CameraEquations:
    q = measured.frame - camera.principal_point
    sign = _sign(camera)
    d, jacobian = field_of(camera.distortion, q)
    by_point = np.eye(2) + sign * (jacobian + camera.affinity)
    lens = [name for name in names if name in LENS]
    by_lens = -sign * coefficient_partials(camera.distortion, lens, q)
    columns = _columns(names, computed / camera.f_mm, by_point, by_lens, -sign * q)
    G = q + sign * (d + q @ camera.affinity.T) + measured.air
    return CameraEquations(computed - G, G, np.broadcast_to(np.eye(2), jacobian.shape), columns)


def _columns(names: Sequence[str], by_f: Array, by_point: Array, by_lens: Array, by_affinity: Array) -> Array:
    """(n, 2, m) in the order of the names; b1 and b2 move x alone, by x and by y."""
    result = np.zeros((len(by_f), 2, len(names)))
    lens = [name for name in names if name in LENS]
    for place, name in enumerate(names):
        if name == "f":
            result[:, :, place] = by_f
        elif name in ("x0", "y0"):
            result[:, :, place] = by_point[:, :, 0 if name == "x0" else 1]
        elif name in LENS:
            result[:, :, place] = by_lens[:, :, lens.index(name)]
        else:
            result[:, 0, place] = by_affinity[:, 0 if name == "b1" else 1]
    return result


def _sign(camera: Camera) -> float:
    return -1.0 if camera.distortion.direction == "displacement" else 1.0
