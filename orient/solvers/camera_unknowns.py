"""c = c0 + dc: elements of the interior orientation as unknowns of a resection, held by what is known of them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orient.geometry.camera import Camera, CameraEquations, Measured, camera_equations

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class CameraUnknowns:
    """The named elements (of `geometry.camera.INTERIOR`), the camera a priori, the readings before its corrections.

    `cofactors` (m,): a-priori variance / sigma0^2 of each element in its own unit, infinite for one that is free.
    """

    names: tuple[str, ...]
    camera: Camera
    measured: Measured
    cofactors: FloatArray

    @property
    def apriori(self) -> FloatArray:
        """(m,) values before the adjustment."""
        return self.camera.values(self.names)

    @property
    def observed(self) -> NDArray[np.intp]:
        """Places of the elements that have a standard deviation a priori."""
        return np.flatnonzero(np.isfinite(self.cofactors))

    @property
    def scales(self) -> FloatArray:
        """(m,): what moves the image by about f. f for lengths, f / r^k for coefficients, r the largest radius."""
        f = self.camera.f_mm
        is_normalised = self.camera.distortion.model == "opencv"
        q = self.measured.frame - self.camera.principal_point
        r = float(np.max(np.linalg.norm(q, axis=1))) / (f if is_normalised else 1.0)
        size = 1.0 if is_normalised else f
        powers = {"k1": 3, "k2": 5, "k3": 7, "p1": 2, "p2": 2}
        of_affinity = {"b1": 1.0, "b2": 1.0}
        return np.array([of_affinity.get(n, size / r ** powers[n] if n in powers else f) for n in self.names])

    def at(self, values: FloatArray) -> Camera:
        """The camera with these values of the unknowns."""
        return self.camera.with_values(self.names, values)

    def is_camera(self, values: FloatArray) -> bool:
        """Finite numbers and a positive focal length: nothing else can be linearised."""
        f_mm = values[self.names.index("f")] if "f" in self.names else self.camera.f_mm
        return bool(np.isfinite(values).all() and f_mm > 0)

    def equations(self, values: FloatArray, computed: FloatArray) -> CameraEquations:
        """v, dv/dF and dv/dc at these values."""
        return camera_equations(self.at(values), self.names, computed, self.measured)

    def priors(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """v = c - c0 of the elements with a standard deviation, whitened: (p, m) and (p,)."""
        places = self.observed
        root = 1.0 / np.sqrt(self.cofactors[places])
        design = np.zeros((len(places), len(self.names)))
        design[np.arange(len(places)), places] = root
        return design, root * (values - self.apriori)[places]

    def of(self, keep: NDArray[np.intp] | NDArray[np.bool_] | Sequence[int]) -> "CameraUnknowns":
        """The same elements with the readings of some of the points."""
        return replace(self, measured=Measured(self.measured.frame[keep], self.measured.air[keep]))

    def without(self) -> "CameraUnknowns":
        """The same camera, taken as known."""
        return CameraUnknowns((), self.camera, self.measured, np.zeros(0))


def separability(triangle: FloatArray) -> FloatArray:
    """sqrt(1 - R_i^2) = 1 / sqrt(N_ii Q_ii) (u,): 1 - the multiple correlation of each unknown with all the others.

    `triangle` R (u, u), N = R'R. 0 where the equations are singular along the unknown; 1 for one that stands alone.
    """
    norms = np.linalg.norm(triangle, axis=0)
    unit = triangle / np.where(norms > 0, norms, 1.0)
    _, values, axes = np.linalg.svd(unit)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = np.sum(np.where(axes.T == 0, 0.0, axes.T / values) ** 2, axis=1)
    return np.where(norms > 0, 1.0 / np.sqrt(variance), 0.0)


def strongest_partner(triangle: FloatArray, i: int) -> tuple[int, float]:
    """The other unknown with the largest |Q_ij| / sqrt(Q_ii Q_jj), and that correlation."""
    norms = np.linalg.norm(triangle, axis=0)
    unit = triangle / np.where(norms > 0, norms, 1.0)
    _, values, axes = np.linalg.svd(unit)
    scaled = axes.T / np.maximum(values, np.finfo(np.float64).eps * values[0])
    scaled /= np.linalg.norm(scaled, axis=1, keepdims=True)
    correlations = scaled @ scaled[i]
    correlations[i] = 0.0
    partner = int(np.argmax(np.abs(correlations)))
    return partner, float(correlations[partner])
