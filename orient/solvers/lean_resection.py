"""R, S and Q of one photo from rough values: Gauss-Newton and nothing else, for many points or many calls.

The full adjustment with starts, tests and iterations is `orient.solvers.resection.resect`; both have the same optimum.
r and t are a turn and a shift of the ground in the camera's axes, t in camera distances. With u = xs/zs, v = ys/zs,
w = 1/zs

    dx/f = u v r1 - (1 + u^2) r2 + v r3 - w t1 + u w t3
    dy/f = (1 + v^2) r1 - u v r2 - u r3 - w t2 + v w t3

For few points the time is that of the numpy calls, for many that of the memory: so the rows of A and l are written in
place into one buffer that stays in the processor's cache, and one product of it gives A'A, A'l and l'l.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dposv

from orient.solvers.ground_covariance import all_pairs
from orient.solvers.lean_design import NATURAL, PhotoDesign, WeightedDesign, kept_design
from orient.solvers.lean_limits import LAST_IN_SIGMAS, LAST_STEP, MANY_POINTS, SINGULAR, SMALL_STEP, some_points

FloatArray = NDArray[np.float64]

POINTS_AT_ONCE = 2048
"""Points whose equations stay in the processor's cache."""
FAR = 0.03
"""Until a step is smaller the image points as measured stand for the computed ones, and control has no errors."""
UNSURE = 100.0
"""Not so with control that is less sure than so many readings."""
LAST_MOVE = 1e-9
"""Of a weighted ground point, in camera distances."""
EYE = np.eye(4)
TURN, SHIFT = np.split(-NATURAL, 2)


class LeanResection(NamedTuple):
    """R (3, 3), S (3,), cofactors Q (6, 6) of (r, S) with R_new = exp([r]x) R, v'Pv [mm^2], iterations.

    `ground` (n, 3): adjusted points, `by_elements` G (n, 3, 6) and `own` (n, 3, 3): their cofactors are
    own + G Q G', those with the elements G Q; all three None for control without errors.
    """

    rotation: FloatArray
    station: FloatArray
    Q: FloatArray
    vPv: float
    iterations: int
    converged: bool
    ground: FloatArray | None = None
    by_elements: FloatArray | None = None
    own: FloatArray | None = None

    @property
    def joint_cofactors(self) -> FloatArray:
        """(6+3n, 6+3n) of the elements and all points: K = F Q F' + own blocks, exactly symmetric."""
        if self.by_elements is None or self.own is None:
            return self.Q
        n, L = len(self.own), np.linalg.cholesky(self.Q)
        K = all_pairs(np.concatenate([L, self.by_elements.reshape(-1, 6).dot(L)]))
        row, column = K.strides
        blocks = as_strided(K[6:, 6:], (n, 3, 3), (3 * (row + column), row, column))  # along the diagonal
        blocks += self.own
        return K


def lean_resection(
    image: FloatArray,
    ground: FloatArray,
    f_mm: float,
    rotation: FloatArray,
    station: FloatArray,
    ground_cofactor: FloatArray | None = None,
    max_iterations: int = 20,
    may_be_far: bool = True,
) -> LeanResection:
    """x = -f xs/zs, y = -f ys/zs, (xs, ys, zs) = R'(P - S); v'Pv -> min from rough R, S.

    `image` (n, 2) [mm]; `ground` (n, 3) [m], right-handed, without errors or with the covariance / sigma0^2
    `ground_cofactor` (n, 3, 3) [m^2/mm^2]: then each point is eliminated by its 2 x 2 matrix 1 + B S B'.
    `may_be_far`: with the equations for far off until a step is small; without them the steps are those of a batch.
    Source: seed 004, equations (3)-(5) with ground observations.
    """
    has_errors = ground_cofactor is not None
    with np.errstate(all="ignore"):
        for R, S, is_far in _starts(image, ground, f_mm, rotation, station, may_be_far, has_errors):
            found = _gauss_newton(_photo(image, ground, f_mm, S, ground_cofactor), R, S, is_far, max_iterations)
            if found.converged:
                break
    return found


def _starts(
    image: FloatArray,
    ground: FloatArray,
    f_mm: float,
    rotation: FloatArray,
    station: FloatArray,
    may_be_far: bool,
    has_errors: bool,
) -> Iterator[tuple[FloatArray, FloatArray, bool]]:
    """R, S and whether they are far off.

    With many points the orientation by some of them, which leaves two steps for all; then the rough values, from where
    the equations for far off lead in fewer steps, but not from everywhere.
    """
    if len(image) >= MANY_POINTS and not has_errors:
        at = some_points(len(image))
        x, P = np.take(image, at, axis=0), np.take(ground, at, axis=0)
        found = lean_resection(x, P, f_mm, rotation, station, may_be_far=may_be_far)
        if found.converged:
            yield found.rotation, found.station, False
    if may_be_far:
        yield rotation, station, True
    yield rotation, station, False


def _photo(
    image: FloatArray, ground: FloatArray, f: float, station: FloatArray, cofactor: FloatArray | None
) -> "_Photo":
    if cofactor is not None:
        return _WeightedPhoto(image, ground, f, station, cofactor)
    return (_Photo if len(image) <= POINTS_AT_ONCE else _LongPhoto)(image, ground, f, station)


def _gauss_newton(photo: "_Photo", R: FloatArray, S: FloatArray, is_far: bool, max_iterations: int) -> LeanResection:
    """Far off with the image points as measured and the control as given, until a step is small; never to the end."""
    M = photo.camera_from_ground(R, S)
    is_far = is_far and photo.is_control_sure
    for number in range(1, max_iterations + 1):
        N = photo.normal_matrix(M, is_far)
        g = N[6, :6]
        U, step, failed = dposv(N[:6, :6], g)
        if failed:
            break
        if not is_far:
            photo.move_points(step)
        M, moved = _moved(M, step)
        if not moved < math.inf:
            break
        is_last = moved < LAST_STEP or (
            moved < SMALL_STEP and float(step.dot(g)) * photo.redundancy < LAST_IN_SIGMAS**2 * float(N[6, 6])
        )
        if is_last and not is_far and photo.are_points_at_rest():
            if _is_regular(N, U) and photo.is_in_front():
                return photo.result(M, U, float(N[6, 6]), number)
            break
        is_far = is_far and moved > FAR
    return LeanResection(R, S, np.full((6, 6), np.nan), math.nan, number, converged=False)


def _is_regular(N: FloatArray, U: FloatArray) -> bool:
    """Do the points determine each unknown? U'U = N: the pivots tell what of its weight those before it leave."""
    pivots, weights = U.diagonal().tolist(), N.diagonal().tolist()[:6]
    return all(pivot**2 > SINGULAR * weight for pivot, weight in zip(pivots, weights, strict=True))


class _Photo:
    """Of points without errors that fit one buffer."""

    is_control_sure = True

    def __init__(self, image: FloatArray, ground: FloatArray, f: float, station: FloatArray) -> None:
        self.image, self.ground, self.f, self.origin = image, ground, f, ground[0]
        self.distance = math.dist(self.origin.tolist(), station.tolist())
        self.redundancy = max(2 * len(image) - 6, 1)
        self._prepare()

    def _prepare(self) -> None:
        self.design = kept_design(len(self.image))
        self.design.place(self.image, self.ground, self.origin, self.f)

    def camera_from_ground(self, R: FloatArray, S: FloatArray) -> FloatArray:
        """(4, 4) of (xs, ys, zs, 1) in camera distances from ground about its first point."""
        M = EYE.copy()
        M[:3, :3] = R.T
        M[:3, 3] = (self.origin - S).dot(R)
        M[:3] /= self.distance
        return M

    def normal_matrix(self, M: FloatArray, is_far: bool) -> FloatArray:
        """(A l)'P(A l) (7, 7)."""
        return self.design.normal_matrix(M, is_far)

    def is_in_front(self) -> bool:
        """At the place of the last normal matrix."""
        return self.design.is_in_front()

    def move_points(self, step: FloatArray) -> None:
        """Those with errors."""

    def are_points_at_rest(self) -> bool:
        return True

    def result(self, M: FloatArray, U: FloatArray, vPv: float, number: int) -> LeanResection:
        d, f = self.distance, self.f
        R = (M[:3, :3] * d).T
        S = self.origin - R.dot(M[:3, 3]) * d
        F = dtrsm(1.0 / f, U, self.elements(R).T, trans_a=1)
        return LeanResection(R, S, F.T.dot(F), vPv * f**2, number, True)

    def elements(self, R: FloatArray) -> FloatArray:
        """(6, 6) of the unknowns: r -> -R r, dS = -R t d."""
        elements = np.empty((6, 6))
        R.dot(TURN, elements[:3])
        (R * self.distance).dot(SHIFT, elements[3:])
        return elements


class _LongPhoto(_Photo):
    """Of more points without errors: part by part in one buffer."""

    def _prepare(self) -> None:
        n, m = len(self.image), POINTS_AT_ONCE
        shared = kept_design(m)
        self.parts = [(slice(i, i + m), shared) for i in range(0, n - m + 1, m)]
        if n % m:
            self.parts.append((slice(n - n % m, n), PhotoDesign(n % m)))

    def normal_matrix(self, M: FloatArray, is_far: bool) -> FloatArray:
        N, self.front = np.zeros((7, 7)), True
        for part, design in self.parts:
            design.place(self.image[part], self.ground[part], self.origin, self.f)
            N += design.normal_matrix(M, is_far)
            self.front = self.front and design.is_in_front()
        return N

    def is_in_front(self) -> bool:
        return self.front


class _WeightedPhoto(_Photo):
    """Of points with errors: a buffer for each part, because the points come back to their rows."""

    def __init__(
        self, image: FloatArray, ground: FloatArray, f: float, station: FloatArray, cofactor: FloatArray
    ) -> None:
        self.cofactor = np.ascontiguousarray(cofactor.transpose(1, 2, 0)) * f**2
        super().__init__(image, ground, f, station)  # which prepares with the cofactors
        self.is_control_sure = bool(self.cofactor.max() < (UNSURE * self.distance) ** 2)

    def _prepare(self) -> None:
        self.designs: list[WeightedDesign] = []
        self.moves = [math.inf]
        for i in range(0, len(self.image), POINTS_AT_ONCE):
            part = slice(i, i + POINTS_AT_ONCE)
            design = WeightedDesign(self.cofactor[:, :, part])
            design.place(self.image[part], self.ground[part], self.origin, self.f)
            self.designs.append(design)

    def normal_matrix(self, M: FloatArray, is_far: bool) -> FloatArray:
        return np.asarray(np.add.reduce([design.normal_matrix(M, is_far) for design in self.designs]))

    def is_in_front(self) -> bool:
        return all(design.is_in_front() for design in self.designs)

    def move_points(self, step: FloatArray) -> None:
        self.moves = [design.move_points(step) for design in self.designs]

    def are_points_at_rest(self) -> bool:
        return all(move < LAST_MOVE * self.distance for move in self.moves)

    def result(self, M: FloatArray, U: FloatArray, vPv: float, number: int) -> LeanResection:
        found = super().result(M, U, vPv, number)
        unknowns = np.asarray(np.linalg.inv(self.elements(found.rotation)), dtype=np.float64)
        G, own = zip(*(design.point_cofactors(unknowns) for design in self.designs), strict=True)
        P = self.origin + np.concatenate([design.points.T for design in self.designs])
        return found._replace(ground=P, by_elements=np.concatenate(G), own=np.concatenate(own) / self.f**2)


def _moved(M: FloatArray, step: FloatArray) -> tuple[FloatArray, float]:
    """M (4, 4) after P_camera <- E P_camera + t, E Cayley's rotation, exp([r]x) to second order; sum of |r|, |t|."""
    z, t1, t2, t3, y, x = step.tolist()
    moved = abs(x) + abs(y) + abs(z) + abs(t1) + abs(t2) + abs(t3)
    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
    k = 2.0 / (1.0 + x * x + y * y + z * z)
    kx, ky, kz = k * x, k * y, k * z
    xx, yy, zz, xy, xz, yz = kx * x, ky * y, kz * z, kx * y, kx * z, ky * z
    move = [
        *(1.0 - yy - zz, xy - kz, xz + ky, -t1),
        *(xy + kz, 1.0 - xx - zz, yz - kx, -t2),
        *(xz - ky, yz + kx, 1.0 - xx - yy, t3),
        *(0.0, 0.0, 0.0, 1.0),
    ]
    return np.array(move).reshape(4, 4).dot(M), moved
