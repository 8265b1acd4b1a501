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
from scipy.linalg.lapack import dposv, dtrtrs

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
EYE, FROM_UNKNOWNS = np.eye(4), -NATURAL


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
            found = _gauss_newton(_Photo(image, ground, f_mm, S, ground_cofactor), R, S, is_far, max_iterations)
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
        if photo.weighted and not is_far:
            photo.move_points(step)
        M, moved = _moved(M, step)
        if not moved < math.inf:
            break
        is_last = moved < LAST_STEP or (
            moved < SMALL_STEP and float(step.dot(g)) * photo.redundancy < LAST_IN_SIGMAS**2 * float(N[6, 6])
        )
        if is_last and not is_far and photo.are_points_at_rest():
            if _is_regular(N, U) and photo.is_in_front(M):
                return photo.result(M, U, float(N[6, 6]), number)
            break
        is_far = is_far and moved > FAR
    return LeanResection(R, S, np.full((6, 6), np.nan), math.nan, number, converged=False)


def _is_regular(N: FloatArray, U: FloatArray) -> bool:
    """Do the points determine each unknown? U'U = N: the pivots tell what of its weight those before it leave."""
    return all(
        u * u > SINGULAR * weight for u, weight in zip(U.diagonal().tolist(), N.diagonal()[:6].tolist(), strict=True)
    )


class _Photo:
    """The points about the first one as columns: ground (4, n) [m] with ones, image x/f (2, n)."""

    def __init__(
        self, image: FloatArray, ground: FloatArray, f: float, station: FloatArray, cofactor: FloatArray | None
    ) -> None:
        n = len(image)
        self.f, self.origin = f, ground[0]
        self.distance = math.dist(self.origin.tolist(), station.tolist())
        self.redundancy = max(2 * n - 6, 1)
        self.ground = np.empty((4, n))
        self.ground[3] = 1.0
        self.points = self.ground[:3]
        np.subtract(ground.T, self.origin[:, None], self.points)
        m = min(n, POINTS_AT_ONCE)
        parts = [slice(begin, min(begin + m, n)) for begin in range(0, n, m)]
        self.weighted: list[tuple[slice, WeightedDesign]] = []
        self.moves: list[FloatArray] = []
        self.is_control_sure = True
        self.designs: list[tuple[slice, PhotoDesign]] = []
        if cofactor is None:
            shared = kept_design(m)
            self.designs += [(part, shared if part.stop - part.start == m else PhotoDesign(n % m)) for part in parts]
        else:  # a buffer for each part, because its points come back to their rows
            S = np.ascontiguousarray(cofactor.transpose(1, 2, 0)) * f**2
            self.is_control_sure = bool(S.max() < (UNSURE * self.distance) ** 2)
            self.weighted += [(part, WeightedDesign(self.points[:, part].copy(), S[:, :, part])) for part in parts]
            self.designs += self.weighted
        self.image = self.designs[0][1].image if m == n else np.empty((2, n))
        np.divide(image.T, f, self.image)

    def camera_from_ground(self, R: FloatArray, S: FloatArray) -> FloatArray:
        """(4, 4) of (xs, ys, zs, 1) in camera distances."""
        M = EYE.copy()
        M[:3, :3] = R.T / self.distance
        M[:3, 3] = M[:3, :3].dot(self.origin - S)
        return M

    def normal_matrix(self, M: FloatArray, is_far: bool) -> FloatArray:
        """(A l)'P(A l) (7, 7), some thousand points at a time."""
        if len(self.designs) == 1:
            return self.designs[0][1].normal_matrix(M, self.ground, is_far)
        N = np.zeros((7, 7))
        for part, design in self.designs:
            design.image[:] = self.image[:, part]
            N += design.normal_matrix(M, self.ground[:, part], is_far)
        return N

    def move_points(self, step: FloatArray) -> None:
        """Those with errors, and keep how far they were moved."""
        self.moves = []
        for part, design in self.weighted:
            moved = design.moved(step)
            self.moves.append(moved - self.points[:, part])
            self.points[:, part] = moved

    def are_points_at_rest(self) -> bool:
        return all(float(np.abs(move).max()) < LAST_MOVE * self.distance for move in self.moves)

    def is_in_front(self, M: FloatArray) -> bool:
        return bool(np.count_nonzero(M[2].dot(self.ground) < 0.0) == self.ground.shape[1])

    def result(self, M: FloatArray, U: FloatArray, vPv: float, number: int) -> LeanResection:
        R, t, d, f = M[:3, :3].T * self.distance, M[:3, 3], self.distance, self.f
        S = self.origin - R.dot(t) * d
        turn = np.zeros((6, 6))  # r -> -R r, dS = -R t d
        turn[:3, :3], turn[3:, 3:] = R, R * d
        turn = turn.dot(FROM_UNKNOWNS)
        F = dtrtrs(U, turn.T, trans=1)[0] / f
        Q = F.T.dot(F)
        if not self.weighted:
            return LeanResection(R, S, Q, vPv * f**2, number, True)
        back = np.linalg.inv(turn)
        G, own = zip(*(design.point_cofactors(back) for _, design in self.weighted), strict=True)
        P, by_elements = self.origin + self.points.T, np.concatenate(G)
        return LeanResection(R, S, Q, vPv * f**2, number, True, P, by_elements, np.concatenate(own) / f**2)


def _moved(M: FloatArray, step: FloatArray) -> tuple[FloatArray, float]:
    """M (4, 4) after P_camera <- E P_camera + t, E Cayley's rotation, exp([r]x) to second order; sum of |r|, |t|."""
    z, t1, t2, t3, y, x = unknowns = step.tolist()
    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
    xx, yy, zz = x * x, y * y, z * z
    k = 2.0 / (1.0 + xx + yy + zz)
    move = [
        *(1.0 - k * (yy + zz), k * (x * y - z), k * (x * z + y), -t1),
        *(k * (x * y + z), 1.0 - k * (xx + zz), k * (y * z - x), -t2),
        *(k * (x * z - y), k * (y * z + x), 1.0 - k * (xx + yy), t3),
        *(0.0, 0.0, 0.0, 1.0),
    ]
    return np.array(move).reshape(4, 4).dot(M), sum(map(abs, unknowns))
