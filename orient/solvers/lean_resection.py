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
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.solvers.lean_design import SIGNS, UNKNOWNS, Design, WeightedDesign

FloatArray = NDArray[np.float64]

POINTS_AT_ONCE = 2048
"""Points whose equations stay in the processor's cache."""
LAST_STEP = 3e-9
"""Sum of |r| [rad] and |t| [camera distances]: Q, which is that of the place before the last step, is right to 1e-8."""
LAST_IN_SIGMAS = 1e-6
"""Or in standard deviations, for photos so weak that rounding alone makes larger steps."""
LAST_MOVE = 1e-9
"""Of a weighted ground point, in camera distances."""
EYE = np.eye(4)


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
        K = np.asarray(F @ F.T)
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
    `ground_cofactor` (n, 3, 3) [m^2/mm^2]: then each point is eliminated by its 2 x 2 matrix 1 + B S B'.
    Source: seed 004, equations (3)-(5) with ground observations.
    """
    photo = _Photo(image, ground, f_mm, station, ground_cofactor)
    M = photo.camera_from_ground(rotation, station)
    redundancy = max(2 * len(image) - 6, 1)
    with np.errstate(all="ignore"):
        for number in range(1, max_iterations + 1):
            N = photo.normal_matrix(M)
            g, vPv = N[6, :6], float(N[6, 6])
            try:
                inverse = np.linalg.inv(N[:6, :6])
            except np.linalg.LinAlgError:
                break
            step = inverse @ g
            size = float(step @ g)
            lift = photo.move_points(step)
            M = _moved(step) @ M
            is_small = sum(map(abs, step.tolist())) < LAST_STEP or size * redundancy < LAST_IN_SIGMAS**2 * vPv
            if is_small and lift < LAST_MOVE:
                return photo.result(M, inverse, vPv, number)
            if not math.isfinite(size):
                break
    return photo.failed(M, max_iterations)


class _Photo:
    """The points about the first one, in camera distances, as columns: ground (4, n) with ones, image x/f (2, n)."""

    def __init__(
        self, image: FloatArray, ground: FloatArray, f: float, station: FloatArray, cofactor: FloatArray | None
    ) -> None:
        n = len(image)
        self.f, self.origin = f, ground[0]
        self.distance = math.dist(ground[0].tolist(), station.tolist())
        self.image = np.divide(image.T, f, out=np.empty((2, n)))
        self.ground = np.ones((4, n))
        points = self.points = self.ground[:3]
        np.subtract(ground.T, self.origin[:, None], out=points)
        points /= self.distance
        self.weighted = None if cofactor is None else self._weighted_design(cofactor)
        self.blocks = self._blocks(n)

    def _weighted_design(self, cofactor: FloatArray) -> WeightedDesign:
        scaled = np.ascontiguousarray(cofactor.transpose(1, 2, 0)) * (self.f / self.distance) ** 2
        return WeightedDesign(self.points.copy(), scaled)

    def _blocks(self, n: int) -> list[tuple[Design, FloatArray, FloatArray]]:
        """Some thousand points at a time, all in one buffer; weighted ones together, they come back to their rows."""
        if self.weighted or n <= POINTS_AT_ONCE:
            return [(self.weighted or Design(n), self.image, self.ground)]
        parts = [slice(begin, begin + POINTS_AT_ONCE) for begin in range(0, n, POINTS_AT_ONCE)]
        full, last = Design(POINTS_AT_ONCE), Design(n - parts[-1].start)
        designs = [full] * (len(parts) - 1) + [last]
        return [
            (design, self.image[:, part], self.ground[:, part]) for design, part in zip(designs, parts, strict=True)
        ]

    def camera_from_ground(self, R: FloatArray, S: FloatArray) -> FloatArray:
        """(4, 4) of (xs, ys, zs, 1) in camera distances."""
        M = EYE.copy()
        M[:3, :3] = R.T
        M[:3, 3] = R.T @ ((self.origin - S) / self.distance)
        return M

    def normal_matrix(self, M: FloatArray) -> FloatArray:
        """(A l)'P(A l) (7, 7)."""
        camera = M[:3]
        total, *others = (design.normal_matrix(camera, image, ground) for design, image, ground in self.blocks)
        for N in others:
            total += N
        return total

    def move_points(self, step: FloatArray) -> float:
        """The largest move of a point with errors, in camera distances."""
        if self.weighted is None:
            return 0.0
        moved = self.weighted.moved(step)
        lift = float(np.abs(moved - self.points).max())
        self.points[:] = moved
        return lift

    def result(self, M: FloatArray, inverse: FloatArray, vPv: float, number: int) -> LeanResection:
        R, S = self._pose(M)
        in_front = float((M[2] @ self.ground).max()) < 0
        turn = np.zeros((6, 6))
        turn[:3, UNKNOWNS[:3]] = -R
        turn[3:, UNKNOWNS[3:]] = R * (SIGNS[3:] * -self.distance)
        Q = turn @ inverse @ turn.T / self.f**2
        vPv *= self.f**2
        if self.weighted is None:
            return LeanResection(R, S, Q, vPv, number, in_front)
        P = self.origin + self.distance * self.points.T
        G, own = self.weighted.point_cofactors()
        G = self.distance * G @ np.linalg.inv(turn)
        return LeanResection(R, S, Q, vPv, number, in_front, P, G, own * (self.distance / self.f) ** 2)

    def failed(self, M: FloatArray, number: int) -> LeanResection:
        return LeanResection(*self._pose(M), np.full((6, 6), np.nan), math.nan, number, converged=False)

    def _pose(self, M: FloatArray) -> tuple[FloatArray, FloatArray]:
        R = M[:3, :3].T
        return R, self.origin - self.distance * (R @ M[:3, 3])


def _moved(step: FloatArray) -> FloatArray:
    """(4, 4) of P_camera <- E P_camera + t; E is Cayley's rotation, exp([r]x) to second order, without arrays."""
    z, t1, t2, x, y, t3 = step.tolist()
    x, y, z = 0.5 * x, 0.5 * y, 0.5 * z
    xx, yy, zz = x * x, y * y, z * z
    k = 2.0 / (1.0 + xx + yy + zz)
    return np.array(
        [
            [1.0 - k * (yy + zz), k * (x * y - z), k * (x * z + y), -t1],
            [k * (x * y + z), 1.0 - k * (xx + zz), k * (y * z - x), -t2],
            [k * (x * z - y), k * (y * z + x), 1.0 - k * (xx + yy), t3],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
