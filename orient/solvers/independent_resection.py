"""v'Pv -> min for a resection by scipy.optimize.least_squares: a second solution that shares no formula with the first.

Rotation by Cayley's quotient instead of the exponential, partials by the complex step instead of the analytic ones, all
unknowns in one dense system instead of eliminated points, Levenberg-Marquardt instead of the functional iteration.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular
from scipy.optimize import least_squares

from orient.solvers.common_unknowns import CommonUnknowns

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

ENGINE = "scipy least_squares"
MAX_UNKNOWNS = 1000
"""A dense system of more takes minutes."""
DISPLACED = 1e-3
"""Start: turned by this [rad] and moved by this share of the camera distance, so that it has to find the way itself."""
STEP = 1e-30
PRESENT = 1e-10
TIGHTEST = 1e-15


@dataclass(frozen=True)
class ResectionObservations:
    """What a resection is computed from, right-handed; arguments and units as in `solvers.resection.resect`."""

    image: FloatArray
    image_cofactor: FloatArray
    ground: FloatArray
    f_mm: float
    free: FloatArray | None = None
    weight: FloatArray | None = None
    common: CommonUnknowns | None = None

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
        return [_root(E.T @ W @ E) for E, W in zip(self.directions, weight, strict=True)]

    @cached_property
    def common_root(self) -> FloatArray:
        """F (k, q) with F F' = cofactor of the common unknowns."""
        if self.common is None:
            return np.zeros((0, 0))
        sigma = np.sqrt(np.diagonal(self.common.cofactor))
        safe = np.where(sigma > 0, sigma, 1.0)
        return np.asarray(safe[:, None] * _root(self.common.cofactor / np.outer(safe, safe)).T)

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
    def n_unknowns(self) -> int:
        return 6 + int(self.common_root.shape[1]) + self.n_points

    @property
    def n_equations(self) -> int:
        return 2 * len(self.image) + int(self.common_root.shape[1]) + sum(len(root) for root in self.roots)


@dataclass(frozen=True, slots=True)
class IndependentResection:
    """Q (6, 6): r_X, r_Y, r_Z [rad], X_S, Y_S, Z_S [m] in the right-handed frame, for unit weight."""

    station: FloatArray
    rotation: FloatArray
    vPv: float
    Q: FloatArray
    converged: bool


@dataclass(frozen=True, slots=True)
class _System:
    """Unknowns x = (r, S / distance, z, t): turn about the base rotation, station, common ones, own ones of points."""

    given: ResectionObservations
    rotation: FloatArray
    station: FloatArray
    distance: float
    places: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        places = np.zeros((len(self.given.ground), 3, self.given.n_points))
        first = 0
        for index, E in enumerate(self.given.directions):
            places[index, :, first : first + E.shape[1]] = E
            first += E.shape[1]
        object.__setattr__(self, "places", places)

    def residuals(self, x: FloatArray) -> FloatArray:
        q = self.given.common_root.shape[1]
        own, first = [], 6 + q
        for root in self.given.roots:
            own.append(root @ x[first : first + root.shape[1]])
            first += root.shape[1]
        return np.concatenate([self._image(x.astype(np.complex128)).real.ravel(), x[6 : 6 + q], *own])

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Complex step for the rim, and for X, Y, Z of all points at once; the ground equations are linear."""
        q, rows = self.given.common_root.shape[1], 2 * len(self.given.image)
        J = np.zeros((self.given.n_equations, self.given.n_unknowns))
        for column in range(6 + q):
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
        J[:rows, 6 + q :] = (by_ground @ self.places).reshape(rows, -1)
        J[rows : rows + q, 6 : 6 + q] = np.eye(q)
        row, column = rows + q, 6 + q
        for root in self.given.roots:
            J[row : row + len(root), column : column + root.shape[1]] = root
            row, column = row + len(root), column + root.shape[1]
        return J

    def placed(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotation and station of the unknowns x."""
        return np.asarray(_cayley(x[:3].astype(np.complex128)).real @ self.rotation), self._station(x).real

    def _station(self, x: FloatArray | ComplexArray) -> ComplexArray:
        return np.asarray(self.station + self.distance * x[3:6], dtype=np.complex128)

    def _image(self, x: ComplexArray, moved: ComplexArray | float = 0.0) -> ComplexArray:
        """(n, 2) whitened computed minus measured; `moved` shifts all ground points."""
        q = self.given.common_root.shape[1]
        ground = self.given.ground + self.given.shift @ x[6 : 6 + q] + self.places @ x[6 + q :] + moved
        camera = (ground - self._station(x)) @ (_cayley(x[:3]) @ self.rotation)
        computed = -self.given.f_mm * camera[:, :2] / camera[:, 2:]
        v = computed - self.given.image - self.given.image_shift @ x[6 : 6 + q]
        return np.asarray((self.given.whitening @ v[:, :, None])[:, :, 0])


def solve_independently(
    given: ResectionObservations, station: FloatArray, rotation: FloatArray
) -> IndependentResection:
    """The orientation next to `station` (3,) [m] and `rotation` (3, 3), from a start displaced from them.

    Minimises v'Pv over six elements, common unknowns and unknown ground coordinates together; Q is the block of the
    elements in (J'J)^-1. `converged` is False if scipy stopped for another reason than convergence.
    """
    origin = given.ground.mean(axis=0)
    centred = ResectionObservations(
        given.image, given.image_cofactor, given.ground - origin, given.f_mm, given.free, given.weight, given.common
    )
    distance = float(np.mean(np.linalg.norm(given.ground - station, axis=1)))
    system = _System(centred, rotation, station - origin, distance)
    start = np.zeros(given.n_unknowns)
    start[:6] = DISPLACED * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    found = least_squares(
        system.residuals, start, system.jacobian, method="lm", x_scale="jac", xtol=TIGHTEST, ftol=TIGHTEST,
        gtol=TIGHTEST, max_nfev=200,
    )  # fmt: skip
    turned, place = system.placed(found.x)
    return IndependentResection(place + origin, turned, 2 * float(found.cost), _cofactors(system, found.x),
                                converged=found.status > 0)  # fmt: skip


def _cofactors(system: _System, x: FloatArray) -> FloatArray:
    """(J'J)^-1 of the elements: their columns come last, so that the triangle's lower corner is theirs alone."""
    turned, place = system.placed(x)
    here = _System(system.given, turned, place, system.distance)
    J = here.jacobian(np.concatenate([np.zeros(6), x[6:]]))
    R = qr(np.roll(J, -6, axis=1), mode="r")[0][: J.shape[1], :]
    inverse = solve_triangular(R[-6:, -6:], np.eye(6))
    scales = np.repeat([1.0, system.distance], 3)
    return np.asarray(scales[:, None] * (inverse @ inverse.T) * scales)


def _cayley(r: ComplexArray) -> ComplexArray:
    """(I - [r/2]x)^-1 (I + [r/2]x): a turn about r, by |r| for small r."""
    x, y, z = r / 2
    S = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.linalg.solve(np.eye(3) - S, np.eye(3) + S))


def _root(weight: FloatArray) -> FloatArray:
    """(m, k): G with G'G = weight, without the directions that have none."""
    values, vectors = np.linalg.eigh(0.5 * (weight + weight.T))
    present = values > PRESENT * np.max(values, initial=0.0)
    return np.asarray(np.sqrt(values[present])[:, None] * vectors[:, present].T)
