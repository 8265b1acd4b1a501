"""R, S and Q of one photo from rough values: Gauss-Newton and nothing else, for many points or many calls.

The full adjustment with starts, tests and iterations is `orient.solvers.resection.resect`; both have the same optimum.
Axes and signs as in `resection_batch`: r and t are a turn and a shift of the ground in the camera's axes.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.solvers.ground_covariance import all_pairs

FloatArray = NDArray[np.float64]
Symmetric = tuple[FloatArray, FloatArray, FloatArray]
"""Elements xx, xy, yy (n,) of n symmetric 2 x 2 matrices."""

POINTS_AT_ONCE = 8192
LAST_STEP = 1e-6
"""In standard deviations, as in `resection_batch`: Q is that of the place before the last step."""
LAST_MOVE = 1e-9
"""Of a weighted ground point, in camera distances."""


@dataclass(frozen=True, slots=True)
class LeanResection:
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
        F = np.vstack([np.eye(6), self.by_elements.reshape(-1, 6)]) @ np.linalg.cholesky(self.Q)
        K = all_pairs(F)
        blocks = 6 + 3 * np.arange(len(self.own))[:, None] + np.arange(3)
        K[blocks[:, :, None], blocks[:, None, :]] += self.own
        return K


def lean_resection(
    image: FloatArray,
    ground: FloatArray,
    f_mm: float,
    rotation: FloatArray,
    station: FloatArray,
    ground_cofactor: FloatArray | None = None,
    max_iterations: int = 20,
) -> LeanResection:
    """x = -f xs/zs, y = -f ys/zs, (xs, ys, zs) = R'(P - S); v'Pv -> min from rough R, S.

    `image` (n, 2) [mm]; `ground` (n, 3) [m], right-handed, without errors or with the covariance / sigma0^2
    `ground_cofactor` (n, 3, 3) [m^2/mm^2]: then each point is eliminated by its 2 x 2 matrix 1 + A S A'.
    Source: seed 004, equations (3)-(5) with ground observations.
    """
    problem = _Photo(image / f_mm, ground, f_mm, None if ground_cofactor is None else ground_cofactor * f_mm**2)
    R, S, P = np.asarray(rotation, dtype=np.float64), station, ground
    for number in range(1, max_iterations + 1):
        N, g, vPv = problem.normal_equations(R, S, P)
        try:
            step: FloatArray = np.linalg.solve(N, g).astype(np.float64)
        except np.linalg.LinAlgError:
            break
        distance = problem.distance(S)
        size = float(step @ g) * max(2 * len(image) - 6, 1)
        moved = P if ground_cofactor is None else problem.points(R, S, P, step)
        turned = R @ _turn(step[:3]).T
        S = S - turned @ step[3:] * distance
        lift = 0.0 if ground_cofactor is None else float(np.abs(moved - P).max()) / distance
        R, P = turned, moved
        if size < LAST_STEP**2 * vPv and lift < LAST_MOVE:
            return _result(problem, R, S, P, N, vPv, number, distance)
        if not math.isfinite(size):
            break
    nothing = np.full((6, 6), np.nan)
    return LeanResection(R, S, nothing, math.nan, max_iterations, converged=False)


def _result(
    problem: "_Photo",
    R: FloatArray,
    S: FloatArray,
    P: FloatArray,
    N: FloatArray,
    vPv: float,
    number: int,
    distance: float,
) -> LeanResection:
    in_front = bool(np.all((P - S) @ R[:, 2] < 0))
    turn = np.zeros((6, 6))
    turn[:3, :3], turn[3:, 3:] = R, R * distance
    Q = turn @ np.linalg.inv(N) @ turn.T / problem.f**2
    if problem.cofactor is None:
        return LeanResection(R, S, Q, vPv * problem.f**2, number, in_front)
    G, own = problem.point_cofactors(R, S, P)
    G = -G @ np.linalg.inv(turn)  # d(r, S) in the ground's axes is minus the turned d(r, t)
    return LeanResection(R, S, Q, vPv * problem.f**2, number, in_front, P, G, own / problem.f**2)


@dataclass(frozen=True, slots=True)
class _Photo:
    """Image x/f (n, 2), ground (n, 3), and the cofactors of the ground for readings of unit weight in x/f."""

    image: FloatArray
    given: FloatArray
    f: float
    cofactor: FloatArray | None

    def distance(self, S: FloatArray) -> float:
        return math.dist(self.given[0].tolist(), S.tolist())

    def normal_equations(self, R: FloatArray, S: FloatArray, P: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """A'PA (6, 6), A'Pl (6,), l'Pl, some thousand points at a time."""
        N, g, vPv = np.zeros((6, 6)), np.zeros(6), 0.0
        for begin in range(0, len(self.image), POINTS_AT_ONCE):
            part = slice(begin, begin + POINTS_AT_ONCE)
            A, l = self._equations(R, S, P, part)
            N = N + A @ A.T
            g = g + A @ l
            vPv += float(l @ l)
        return N, g, vPv

    def _equations(self, R: FloatArray, S: FloatArray, P: FloatArray, part: slice) -> tuple[FloatArray, FloatArray]:
        """Whitened A' (6, 2m) and l (2m,) of some of the points."""
        uv, w = self._projected(R, S, P[part])
        u, v = uv
        A = self._design(u, v, w * self.distance(S))
        l = self.image[part].T + uv
        if self.cofactor is not None:
            shift = self._by_point(u, v, w, (self.given[part] - P[part]) @ R)
            _whiten(A, l, shift, self._misclosure_cofactor(R, u, v, w, part))
        return A.reshape(6, -1), l.ravel()

    @staticmethod
    def _projected(R: FloatArray, S: FloatArray, P: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(xs/zs, ys/zs) (2, m), 1/zs (m,)."""
        camera = R.T @ (P - S).T
        w = 1.0 / camera[2]
        return camera[:2] * w, w

    @staticmethod
    def _design(u: FloatArray, v: FloatArray, w: FloatArray) -> FloatArray:
        """d(x/f, y/f)/d(r, t) (6, 2, m)."""
        uv, nothing, minus_w = u * v, np.zeros_like(u), -w
        rows = [uv, 1.0 + v * v, -1.0 - u * u, -uv, v, -u, minus_w, nothing, nothing, minus_w, u * w, v * w]
        return np.array(rows).reshape(6, 2, -1)

    @staticmethod
    def _by_point(u: FloatArray, v: FloatArray, w: FloatArray, d: FloatArray) -> FloatArray:
        """B d (2, m): what a move d (m, 3) of the points in the camera's axes does to x/f, y/f."""
        return np.array([w * (u * d[:, 2] - d[:, 0]), w * (v * d[:, 2] - d[:, 1])])

    def _misclosure_cofactor(
        self, R: FloatArray, u: FloatArray, v: FloatArray, w: FloatArray, part: slice
    ) -> Symmetric:
        """1 + B S B' as (xx, xy, yy)."""
        assert self.cofactor is not None
        s = (R.T @ self.cofactor[part] @ R).transpose(1, 2, 0)
        ww = w * w
        xx = 1.0 + ww * (s[0, 0] - 2.0 * u * s[0, 2] + u * u * s[2, 2])
        yy = 1.0 + ww * (s[1, 1] - 2.0 * v * s[1, 2] + v * v * s[2, 2])
        xy = ww * (s[0, 1] - v * s[0, 2] - u * s[1, 2] + u * v * s[2, 2])
        return xx, xy, yy

    def points(self, R: FloatArray, S: FloatArray, P: FloatArray, step: FloatArray) -> FloatArray:
        """P = P0 + S B' (1 + B S B')^-1 (l - A d), all with the partials about the old place."""
        whole = slice(None)
        assert self.cofactor is not None
        uv, w = self._projected(R, S, P)
        u, v = uv
        A = self._design(u, v, w * self.distance(S))
        l = self.image.T + uv - self._by_point(u, v, w, (self.given - P) @ R)
        l -= (step @ A.reshape(6, -1)).reshape(l.shape)
        x, y = _weighted(self._misclosure_cofactor(R, u, v, w, whole), l)
        in_ground = (R @ np.array([-w * x, -w * y, w * (u * x + v * y)])).T
        return np.asarray(self.given + (self.cofactor @ in_ground[:, :, None])[:, :, 0])

    def point_cofactors(self, R: FloatArray, S: FloatArray, P: FloatArray) -> tuple[FloatArray, FloatArray]:
        """dP = G d(r, t): G (n, 3, 6), and the cofactors (n, 3, 3) of the points if the elements were known."""
        assert self.cofactor is not None
        (u, v), w = self._projected(R, S, P)
        A = self._design(u, v, w * self.distance(S))
        zero = np.zeros_like(w)
        B = np.stack([np.stack([-w, zero, u * w]), np.stack([zero, -w, v * w])]).transpose(2, 0, 1) @ R.T
        BS = B @ self.cofactor
        xx, xy, yy = self._misclosure_cofactor(R, u, v, w, slice(None))
        det = xx * yy - xy * xy
        W = np.stack([np.stack([yy, -xy]), np.stack([-xy, xx])]).transpose(2, 0, 1) / det[:, None, None]
        gain = BS.transpose(0, 2, 1) @ W
        own = self.cofactor - gain @ BS
        return -gain @ A.transpose(2, 1, 0), 0.5 * (own + own.transpose(0, 2, 1))


def _whiten(A: FloatArray, l: FloatArray, shift: FloatArray, M: Symmetric) -> None:
    """Rows x, y of A (6, 2, m) and l - shift by the Cholesky factor of M, in place."""
    xx, xy, yy = M
    l11 = np.sqrt(xx)
    l21 = xy / l11
    l22 = np.sqrt(yy - l21 * l21)
    l -= shift
    for rows in (A, l[None]):
        rows[:, 0] /= l11
        rows[:, 1] = (rows[:, 1] - l21 * rows[:, 0]) / l22


def _weighted(M: Symmetric, l: FloatArray) -> tuple[FloatArray, FloatArray]:
    """M^-1 l (2, m) by rows."""
    xx, xy, yy = M
    det = xx * yy - xy * xy
    return (yy * l[0] - xy * l[1]) / det, (xx * l[1] - xy * l[0]) / det


def _turn(r: FloatArray) -> FloatArray:
    """exp([r]x) without arrays: nine numbers."""
    x, y, z = r.tolist()
    angle = math.sqrt(x * x + y * y + z * z)
    a = math.sin(angle) / angle if angle > 1e-8 else 1.0
    b = 2.0 * (math.sin(0.5 * angle) / angle) ** 2 if angle > 1e-8 else 0.5
    return np.array(
        [
            [1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y],
            [b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x],
            [b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)],
        ]
    )
