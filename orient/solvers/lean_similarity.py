"""X_G = R x/H + X0 of many points in closed form: sums of products, one singular value decomposition, one correction.

The full adjustment with starts, tests and iterations is `orient.solvers.absolute_orientation.orient_model`; both have
the same optimum and cofactors. Here all coordinates of a ground point have one weight, and the model has no errors.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry.rotation import rotation_exp
from orient.solvers.absolute_orientation import origin_by_centre
from orient.solvers.absolute_problem import Similarity
from orient.solvers.absolute_search import FAR_BETTER, FIT_SHARE

FloatArray = NDArray[np.float64]

POINTS_AT_ONCE, POINTS_OF_ROUGH_CENTRE = 8192, 64
ON_LINE = 1e-7
"""Width to length of the points below which they are one line: the model can turn about it."""


@dataclass(frozen=True, slots=True)
class LeanSimilarity:
    """R (3, 3), H, X0 (3,) [m], cofactors Q (7, 7) of (r, H, X0) with R_new = exp([r]x) R, v'Pv [m^2].

    `Q_centred`: of r, ln H and the ground position of `model_centre` (3,), uncorrelated but among r. `vPv_mirrored`:
    what the mirrored model would leave; `is_mirrored` when it fits far better, so that this is no result.
    """

    rotation: FloatArray
    H: float
    X0: FloatArray
    Q: FloatArray
    Q_centred: FloatArray
    model_centre: FloatArray
    vPv: float
    redundancy: int
    vPv_mirrored: float
    is_mirrored: bool

    @property
    def t(self) -> float:
        """Scale denominator 1/H [m per model unit]."""
        return 1.0 / self.H

    @property
    def sigma0(self) -> float | None:
        """sqrt(v'Pv / (3n - 7)) [m]; None without redundancy."""
        return float(np.sqrt(self.vPv / self.redundancy)) if self.redundancy > 0 else None


def lean_similarity(
    model: FloatArray, ground: FloatArray, weights: FloatArray | None = None, *, compiled: bool = False
) -> LeanSimilarity:
    """v = C + R x/H - P, sum p |v|^2 -> min, x and P from their weighted centres: R = V diag(1, 1, +-1) U'.

        U D V' = sum p x P',  1/H = tr(D diag(1, 1, +-1)) / sum p |x|^2,  then one Gauss-Newton step

    The step, on residuals of their own, takes away what the squares cost: it leaves 1e-9 m on 100 km.
    `model` (n, 3) in its own unit, `ground` (n, 3) [m], both right-handed; `weights` p (n,) = sigma0^2/sigma^2, 1
    without. N is diagonal about the centres but for r: q = R x/H, N_r = sum p (|q|^2 I - q q'), N_lnH = sum p |q|^2,
    N_C = sum p. `compiled`: sums by numba (extra `orient[fast]`), the same to 1e-9. Refuses (GeometryError) points on
    a line, in the model or on the ground. Sources: Horn (1987), Umeyama (1991); H as in seed 000 (2).
    """
    scene = (_CompiledScene if compiled else _Scene)(model, ground, weights)
    xx, xP, PP = scene.products()
    width = _width(xx)
    U, d, Vt = np.linalg.svd(xP)
    if not d[1] > ON_LINE * width * d[0]:  # the widths of both, as shares of their lengths, are factors of d[1]/d[0]
        raise GeometryError(
            "The ground points lie on one line or in one place, or have nothing to do with the model.",
            "Give the coordinates of the same points in the same order.",
        )
    signs = np.array([1.0, 1.0, 1.0 if np.linalg.det(U @ Vt) > 0 else -1.0])
    start = Similarity(np.asarray((Vt.T * signs) @ U.T), float(np.trace(xx) / (d @ signs)), np.zeros(3))
    N_r, N_scale = _normals(start, xx)
    state, vPv = scene.corrected(start, N_r, N_scale)
    Q_centred = np.diag([0.0, 0.0, 0.0, 1.0 / N_scale, *[1.0 / scene.total] * 3])
    Q_centred[:3, :3] = np.linalg.inv(N_r)
    J = origin_by_centre(state, scene.model_centre)
    # the mirror turns the sign of the smallest product: sum p |P|^2 - tr(D S)^2 / sum p |x|^2
    mirrored = max(vPv + float((d @ signs) ** 2 - (d @ (signs * [1, 1, -1])) ** 2) / float(np.trace(xx)), 0.0)
    return LeanSimilarity(
        rotation=state.rotation,
        H=state.H,
        X0=np.asarray(scene.ground_centre + state.centre - state.t * state.rotation @ scene.model_centre),
        Q=np.asarray(J @ Q_centred @ J.T),
        Q_centred=Q_centred,
        model_centre=scene.model_centre,
        vPv=vPv,
        redundancy=3 * len(model) - 7,
        vPv_mirrored=mirrored,
        is_mirrored=FAR_BETTER * (mirrored + FIT_SHARE**2 * PP) < vPv,
    )


def _width(xx: FloatArray) -> float:
    """Width of the model, as a share of its length."""
    lengths = np.sqrt(np.maximum(np.linalg.eigvalsh(xx), 0.0))
    if not lengths[1] > ON_LINE * lengths[2]:
        raise GeometryError(
            "The points lie on one line or in one place: the model can turn about it.", "Give a point off the line."
        )
    return float(lengths[1] / lengths[2])


def _normals(state: Similarity, xx: FloatArray) -> tuple[FloatArray, float]:
    """N_r (3, 3) and N_lnH about the centres."""
    qq = state.t**2 * state.rotation @ xx @ state.rotation.T
    size = float(np.trace(qq))
    return size * np.eye(3) - qq, size


class _Scene:
    """Sums over the points, some thousand at a time, about the mean of some points until the centres are known."""

    def __init__(self, model: FloatArray, ground: FloatArray, weights: FloatArray | None) -> None:
        self.model, self.ground, self.weights = model, ground, weights
        some = slice(None, None, 1 + len(model) // POINTS_OF_ROUGH_CENTRE)
        self.model_centre, self.ground_centre = model[some].mean(axis=0), ground[some].mean(axis=0)

    def products(self) -> tuple[FloatArray, FloatArray, float]:
        """sum p x x', sum p x P' (3, 3), sum p |P|^2 about the centres, which follow from the same pass.

        A second one where the first was about places so far off that squares lose digits.
        """
        for _ in range(2):
            xx, xP, PP, (*sums, self.total) = self._moments()
            x, P = np.reshape(sums, (2, 3)) / self.total
            self.model_centre, self.ground_centre = self.model_centre + x, self.ground_centre + P
            Wx, WP = self.total * x, self.total * P
            xx, xP, PP = xx - np.outer(Wx, x), xP - np.outer(Wx, P), PP - float(WP @ P)
            if Wx @ x < np.trace(xx) and WP @ P < PP:
                break
        return xx, xP, PP

    def _moments(self) -> tuple[FloatArray, FloatArray, float, list[float]]:
        """The same about the places of now; sum p x, sum p P and sum p."""
        total = np.zeros((8, 7))
        for part, rows in self._centred():
            # with the idle last row: a product of a matrix with itself is three times slower in OpenBLAS
            total += self._weighted(rows, part) @ rows[:7].T
        x, one, P = slice(0, 3), 3, slice(4, 7)
        sums = [*total[one, x], *total[one, P], total[one, one]]
        return total[x, x], total[x, P], float(np.trace(total[P, P])), sums

    def corrected(self, state: Similarity, N_r: FloatArray, N_scale: float) -> tuple[Similarity, float]:
        """One step of r, ln H and C from sum p [q]x v, sum p q v, sum p v; v'Pv after it."""
        arm = state.t * state.rotation
        sums, vPv = self.residual_sums(arm)
        moment, shift = arm @ sums[:3], sums[3]
        turning = np.array([moment[1, 2] - moment[2, 1], moment[2, 0] - moment[0, 2], moment[0, 1] - moment[1, 0]])
        r, scale, C = -np.linalg.solve(N_r, turning), float(np.trace(moment)) / N_scale, -shift / self.total
        gain = -float(r @ turning) + scale * float(np.trace(moment)) - float(C @ shift)
        H = state.H * float(np.exp(scale))
        return Similarity(np.asarray(rotation_exp(r) @ state.rotation), H, C), max(vPv - gain, 0.0)

    def residual_sums(self, arm: FloatArray) -> tuple[FloatArray, float]:
        """sum p x v' over sum p v' (4, 3) and v'Pv of v = arm x - P."""
        sums, vPv = np.zeros((4, 3)), 0.0
        for part, rows in self._centred():
            v = arm @ rows[:3] - rows[4:7]
            pv = self._weighted(v, part)
            sums += rows[:4] @ pv.T
            vPv += float(np.vdot(pv, v))
        return sums, vPv

    def _centred(self) -> Iterator[tuple[slice, FloatArray]]:
        """x from its centre, 1, P from its centre, 1 (8, m), in a buffer that the next part overwrites."""
        buffer = np.ones((8, min(POINTS_AT_ONCE, len(self.model))))
        for begin in range(0, len(self.model), POINTS_AT_ONCE):
            part = slice(begin, begin + POINTS_AT_ONCE)
            rows = buffer[:, : len(self.model[part])]
            np.subtract(self.model[part].T, self.model_centre[:, None], out=rows[:3])
            np.subtract(self.ground[part].T, self.ground_centre[:, None], out=rows[4:7])
            yield part, rows

    def _weighted(self, vectors: FloatArray, part: slice) -> FloatArray:
        return vectors if self.weights is None else np.asarray(vectors * self.weights[part])


class _CompiledScene(_Scene):
    """The same sums in one loop each."""

    def _moments(self) -> tuple[FloatArray, FloatArray, float, list[float]]:
        from orient.solvers.ground_kernel import similarity_moments

        x, P, x_C, P_C, p = self._arrays()
        found = np.asarray(similarity_moments(x, P, x_C, P_C, p))
        xx = np.empty((3, 3))
        xx[np.triu_indices(3)] = xx.T[np.triu_indices(3)] = found[:6]
        return xx, found[6:15].reshape(3, 3), float(found[15]), found[16:].tolist()

    def residual_sums(self, arm: FloatArray) -> tuple[FloatArray, float]:
        from orient.solvers.ground_kernel import similarity_sums

        x, P, x_C, P_C, p = self._arrays()
        found = np.asarray(similarity_sums(x, P, x_C, P_C, p, arm))
        return found[:12].reshape(4, 3), float(found[12])

    def _arrays(self) -> tuple[FloatArray, ...]:
        weights = np.empty(0) if self.weights is None else self.weights
        given = self.model, self.ground, self.model_centre, self.ground_centre, weights
        return tuple(np.ascontiguousarray(array) for array in given)
