"""v'Pv -> min for a resection by scipy.optimize.least_squares: a second solution that shares no formula with the first.

Rotation by Cayley's quotient instead of the exponential, partials by the complex step (what is known of station and
angles: by central differences) instead of the analytic ones, all unknowns in one dense system instead of eliminated
points, Levenberg-Marquardt instead of the functional iteration.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from orient.solvers.common_unknowns import CommonUnknowns
from orient.solvers.independent_algebra import (
    DISPLACED,
    STEP,
    cayley,
    last_cofactors,
    minimised,
    weight_root,
)
from orient.solvers.independent_camera import IndependentCamera

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MAX_UNKNOWNS = 1000
"""A dense system of more takes minutes."""
DIFFERENCE = 1e-6
"""Half step of the central differences, in radians and camera distances."""


@dataclass(frozen=True, slots=True)
class KnownNumber:
    """An observation of the exterior orientation: R (3, 3), S (3,) -> computed minus given; its cofactor."""

    misclosure: Callable[[FloatArray, FloatArray], float]
    cofactor: float


@dataclass(frozen=True)
class ResectionObservations:
    """What a resection is computed from, right-handed; arguments and units as in `solvers.resection.resect`.

    With a `camera` its readings are taken, not `image` and `f_mm`. `is_station_fixed`: the station is no unknown.
    """

    image: FloatArray
    image_cofactor: FloatArray
    ground: FloatArray
    f_mm: float
    free: FloatArray | None = None
    weight: FloatArray | None = None
    common: CommonUnknowns | None = None
    camera: IndependentCamera | None = None
    observed: Sequence[KnownNumber] = ()
    is_station_fixed: bool = False

    @cached_property
    def whitening(self) -> FloatArray:
        """(n, 2, 2) inverse Cholesky factors of the image cofactors."""
        return np.asarray(np.linalg.inv(np.linalg.cholesky(self.image_cofactor)))

    @cached_property
    def directions(self) -> list[FloatArray]:
        """Per point (3, k): orthonormal unknown directions."""
        free = np.zeros((len(self.ground), 3, 3)) if self.free is None else self.free
        values, vectors = np.linalg.eigh(free)
        return [axes[:, value > 0.5] for value, axes in zip(values, vectors, strict=True)]

    @cached_property
    def roots(self) -> list[FloatArray]:
        """Per point (m, k): G with G'G = E'WE, the weight of the given coordinates in the unknown directions."""
        weight = np.zeros((len(self.ground), 3, 3)) if self.weight is None else self.weight
        return [weight_root(E.T @ W @ E) for E, W in zip(self.directions, weight, strict=True)]

    @cached_property
    def common_root(self) -> FloatArray:
        """F (k, q) with F F' = cofactor of the common unknowns."""
        if self.common is None:
            return np.zeros((0, 0))
        sigma = np.sqrt(np.diagonal(self.common.cofactor))
        safe = np.where(sigma > 0, sigma, 1.0)
        return np.asarray(safe[:, None] * weight_root(self.common.cofactor / np.outer(safe, safe)).T)

    @cached_property
    def shift(self) -> FloatArray:
        """(n, 3, q) metres by the common unknowns of unit weight."""
        if self.common is None:
            return np.zeros((len(self.ground), 3, 0))
        return np.asarray(self.common.partials @ self.common_root)

    @cached_property
    def image_shift(self) -> FloatArray:
        """(n, 2, q) mm by the common unknowns of unit weight."""
        by_image = None if self.common is None else self.common.by_image
        if by_image is None:
            return np.zeros((len(self.ground), 2, self.common_root.shape[1]))
        return np.asarray(by_image @ self.common_root)

    @property
    def n_points(self) -> int:
        return sum(E.shape[1] for E in self.directions)

    @property
    def n_camera(self) -> int:
        """m, the unknown elements of the camera."""
        return 0 if self.camera is None else len(self.camera.names)

    @property
    def n_elements(self) -> int:
        """6 + m, fixed ones too."""
        return 6 + self.n_camera

    @property
    def unknowns(self) -> NDArray[np.intp]:
        """Places of the unknowns among (r, S, c, z, own ones)."""
        every = np.arange(self.n_elements + self.common_root.shape[1] + self.n_points)
        return every[(every < 3) | (every >= 6)] if self.is_station_fixed else every

    @property
    def n_unknowns(self) -> int:
        return len(self.unknowns)

    @property
    def n_equations(self) -> int:
        priors = 0 if self.camera is None else len(self.camera.observed)
        of_ground = int(self.common_root.shape[1]) + sum(len(root) for root in self.roots)
        return 2 * len(self.image) + priors + len(self.observed) + of_ground


@dataclass(frozen=True, slots=True)
class IndependentResection:
    """Q (6+m, 6+m): r_X, r_Y, r_Z [rad], X_S, Y_S, Z_S [m] in the right-handed frame, camera; for unit weight.

    `camera` (m,): adjusted values. Zero in Q for a fixed station.
    """

    station: FloatArray
    rotation: FloatArray
    camera: FloatArray
    vPv: float
    Q: FloatArray
    converged: bool


@dataclass(frozen=True, slots=True)
class _System:
    """Unknowns x = (r, S / distance, c / size, z, t): turn about the base rotation, station, camera, common ones, own
    ones of points; all of them, those that are fixed too. `station`, `rotation`, `camera` where x is zero."""

    given: ResectionObservations
    rotation: FloatArray
    station: FloatArray
    camera: FloatArray
    distance: float
    origin: FloatArray
    places: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        places = np.zeros((len(self.given.ground), 3, self.given.n_points))
        first = 0
        for index, E in enumerate(self.given.directions):
            places[index, :, first : first + E.shape[1]] = E
            first += E.shape[1]
        object.__setattr__(self, "places", places)

    @property
    def size(self) -> FloatArray:
        """(m,) unit of the camera's unknowns: their own size, 1 for those that are zero."""
        return np.where(self.camera == 0, 1.0, np.abs(self.camera))

    def residuals(self, x: FloatArray) -> FloatArray:
        rim = self.given.n_elements
        q = self.given.common_root.shape[1]
        own, first = [], rim + q
        for root in self.given.roots:
            own.append(root @ x[first : first + root.shape[1]])
            first += root.shape[1]
        image = self._image(x.astype(np.complex128)).real.ravel()
        return np.concatenate([image, self._priors(x), self._observed(x), x[rim : rim + q], *own])

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Complex step for the rim, and for X, Y, Z of all points at once; the ground equations are linear."""
        rim, q, rows = self.given.n_elements, self.given.common_root.shape[1], 2 * len(self.given.image)
        J = np.zeros((self.given.n_equations, rim + q + self.given.n_points))
        for column in range(rim + q):
            step = x.astype(np.complex128)
            step[column] += STEP * 1j
            J[:rows, column] = self._image(step).imag.ravel() / STEP
        by_ground = np.stack(
            [
                self._image(x.astype(np.complex128), (STEP * 1j) * axis.astype(np.complex128)).imag / STEP
                for axis in np.eye(3)
            ],
            axis=-1,
        )
        J[:rows, rim + q :] = (by_ground @ self.places).reshape(rows, -1)
        row = rows + self._of_elements(x, J[rows:])
        J[row : row + q, rim : rim + q] = np.eye(q)
        row, column = row + q, rim + q
        for root in self.given.roots:
            J[row : row + len(root), column : column + root.shape[1]] = root
            row, column = row + len(root), column + root.shape[1]
        return J

    def _of_elements(self, x: FloatArray, J: FloatArray) -> int:
        """Writes the rows of what is known of camera, station and angles; returns how many there are."""
        camera = self.given.camera
        known = np.zeros(0, dtype=np.intp) if camera is None else camera.observed
        for row, place in enumerate(known):
            J[row, 6 + place] = self.size[place] / np.sqrt(0.0 if camera is None else camera.cofactors[place])
        for column in range(6):
            step = np.zeros_like(x)
            step[column] = DIFFERENCE
            gap = self._observed(x + step) - self._observed(x - step)
            J[len(known) : len(known) + len(gap), column] = gap / (2 * DIFFERENCE)
        return len(known) + len(self.given.observed)

    def _priors(self, x: FloatArray) -> FloatArray:
        camera = self.given.camera
        if camera is None:
            return np.zeros(0)
        misclosures = self.elements(x) - camera.apriori
        return np.asarray((misclosures / np.sqrt(camera.cofactors))[camera.observed])

    def _observed(self, x: FloatArray) -> FloatArray:
        rotation, station = self.placed(x)
        return np.array(
            [one.misclosure(rotation, station + self.origin) / np.sqrt(one.cofactor) for one in self.given.observed]
        )

    def elements(self, x: FloatArray) -> FloatArray:
        """(m,) values of the camera's unknowns."""
        return np.asarray(self.camera + self.size * x[6 : self.given.n_elements])

    def placed(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotation and station of the unknowns x."""
        return np.asarray(cayley(x[:3].astype(np.complex128)).real @ self.rotation), self._station(x).real

    def _station(self, x: FloatArray | ComplexArray) -> ComplexArray:
        return np.asarray(self.station + self.distance * x[3:6], dtype=np.complex128)

    def _image(self, x: ComplexArray, moved: ComplexArray | float = 0.0) -> ComplexArray:
        """(n, 2) whitened computed minus measured; `moved` shifts all ground points."""
        given, rim = self.given, self.given.n_elements
        q = given.common_root.shape[1]
        z = x[rim : rim + q]
        ground = given.ground + given.shift @ z + self.places @ x[rim + q :] + moved
        in_camera = (ground - self._station(x)) @ (cayley(x[:3]) @ self.rotation)
        slopes = -in_camera[:, :2] / in_camera[:, 2:]
        if given.camera is None:
            v = given.f_mm * slopes - given.image
        else:
            v = given.camera.misclosures(slopes, self.camera + self.size * x[6:rim])
        return np.asarray((given.whitening @ (v - given.image_shift @ z)[:, :, None])[:, :, 0])


def solve_independently(
    given: ResectionObservations, station: FloatArray, rotation: FloatArray, camera: FloatArray | None = None
) -> IndependentResection:
    """The orientation next to `station` (3,) [m], `rotation` (3, 3), `camera` (m,), from a start displaced from them.

    Minimises v'Pv over all elements, common unknowns and unknown ground coordinates together; Q is the block of the
    elements in (J'J)^-1. `converged` is False if scipy stopped for another reason than convergence.
    """
    origin = given.ground.mean(axis=0)
    centred = replace(given, ground=given.ground - origin)
    distance = float(np.mean(np.linalg.norm(given.ground - station, axis=1)))
    interior = np.zeros(0) if camera is None else camera
    system = _System(centred, rotation, station - origin, interior, distance, origin)
    every, free = given.n_elements + given.common_root.shape[1] + given.n_points, given.unknowns
    start = np.zeros(every)
    start[: given.n_elements] = DISPLACED * (-1.0) ** np.arange(given.n_elements)

    def spread(x: FloatArray) -> FloatArray:
        whole = np.zeros(every)
        whole[free] = x
        return whole

    found, vPv, converged = minimised(
        lambda x: system.residuals(spread(x)), lambda x: system.jacobian(spread(x))[:, free], start[free]
    )
    x = spread(found)
    turned, place = system.placed(x)
    Q = _cofactors(system, x)
    return IndependentResection(place + origin, turned, system.elements(x), vPv, Q, converged=converged)


def _cofactors(system: _System, x: FloatArray) -> FloatArray:
    """(J'J)^-1 of the elements."""
    given, (turned, place) = system.given, system.placed(x)
    elements = system.elements(x)
    here = replace(system, rotation=turned, station=place, camera=elements)
    J = here.jacobian(np.concatenate([np.zeros(given.n_elements), x[given.n_elements :]]))[:, given.unknowns]
    of_elements = given.unknowns[given.unknowns < given.n_elements]
    scales = np.concatenate([np.ones(3), np.full(3, system.distance), here.size])
    Q = np.zeros((given.n_elements, given.n_elements))
    Q[np.ix_(of_elements, of_elements)] = last_cofactors(np.roll(J, -len(of_elements), axis=1), len(of_elements))
    return np.asarray(scales[:, None] * Q * scales)
