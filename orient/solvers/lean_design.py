"""The equations of `lean_resection`, written in place into one buffer, so that one product gives A'PA, A'Pl and l'Pl.

The unknowns have the order r3, -t1, -t2, t3, r2, r1. The first nine lines are (xs, ys, zs, 1) / zs in another order:

    line                    row     x      y
    u, v, 1                 r3      v     -u
                            -t1     w      0
                            -t2     0      w

Then come the lines w, -u, v, 1 times (u, v), and what is constant:

                            t3     w u    w v
                            r2    -u u   -u v      -1      0
                            r1     v u    v v       0      1
                            l       u      v       x/f    y/f

Far from the solution (-x/f, -y/f) as measured takes the place of this (u, v), but not in l: these are the equations
x zs + f xs = 0 with the weight 1/zs, which are linear in t.
"""

from threading import local

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

NATURAL = np.diag([1.0, -1.0, -1.0, 1.0, 1.0, 1.0])[[5, 4, 0, 1, 2, 3]]
"""(6, 6): (r1, r2, r3, t1, t2, t3) of the unknowns."""
HEAD = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], *(4 * [[0, 0, 0, 0]])])
HEAD[[5, 8], 3] = 1.0
"""(xs, ys, zs, ys, -xs, 1, 0, 0, 1) of (xs, ys, zs, 1)."""
ACROSS = np.array([[1.0], [-1.0]])
"""(v, u) to (v, -u)."""
OPPOSITE = np.array([-1.0, -1.0, 1.0])
"""t of the unknowns."""
N_LINES, N_POINT_LINES = 17, 6


class Design:
    """Rows of A and l of points without errors, (n,) of one photo or (n, p) of p photos, and `extra` lines below."""

    def __init__(self, *shape: int, extra: int = 0) -> None:
        lines = self.lines = np.zeros((N_LINES + extra, *shape))
        self.uv, self.products, self.l = lines[:2], lines[9:17].reshape(4, 2, *shape), lines[15:17]
        self.flat = lines[1:17].reshape(8, -1, *shape[1:])
        self.equations = self.flat[1:]


class PhotoDesign(Design):
    """Of one photo, in few calls. `image` x/f (2, n) is filled by the caller."""

    def __init__(self, n: int, extra: int = 0) -> None:
        super().__init__(n, extra=extra)
        self.camera, self.constants = np.empty((9, n)), np.zeros((4, 2, n))
        self.constants[1, 0], self.constants[2, 1] = -1.0, 1.0
        self.zs, self.image = self.camera[2], self.constants[3]
        self.head, self.factors, self.equations_T = self.lines[:9], self.lines[5:1:-1, None], self.equations.T

    def normal_matrix(self, M: FloatArray, ground: FloatArray, is_far: bool) -> FloatArray:
        """(7, 7) of A and l: `M` (4, 4) camera from ground (4, n) with ones."""
        self._linearise(M, ground, is_far)
        # with the idle first row: a product of a matrix with itself is three times slower in OpenBLAS
        product: FloatArray = self.flat.dot(self.equations_T)
        return product[1:]

    def _linearise(self, M: FloatArray, ground: FloatArray, is_far: bool) -> None:
        HEAD.dot(M).dot(ground, self.camera)
        np.divide(self.camera, self.zs, self.head)
        np.multiply(self.factors, -self.image if is_far else self.uv, self.products)
        np.add(self.products, self.constants, self.products)
        if is_far:
            np.add(self.uv, self.image, self.l)


_KEPT = local()


def kept_design(n: int) -> PhotoDesign:
    """The one that this thread used last, if it is for n points: for few points making it is a tenth of the time."""
    design: PhotoDesign | None = getattr(_KEPT, "design", None)
    if design is None or design.image.shape[1] != n:
        design = _KEPT.design = PhotoDesign(n)
    return design


class WeightedDesign(PhotoDesign):
    """The same of points with errors, eliminated: rows whitened by the Cholesky factor of 1 + B S B'.

    `given` (3, n) and the cofactors S (3, 3, n) for readings of unit weight in x/f.
    Three more rows are those of H = (B S)' L'^-1, whose products with the equations lead back to the points.
    """

    def __init__(self, given: FloatArray, cofactor: FloatArray) -> None:
        n = given.shape[1]
        super().__init__(n, extra=N_POINT_LINES)
        self.given, self.cofactor = given, cofactor
        self.H = self.lines[N_LINES:].reshape(3, 2, n)
        self.x_lines, self.y_lines = self.lines[3::2], self.lines[4::2]

    def _linearise(self, M: FloatArray, ground: FloatArray, is_far: bool) -> None:
        super()._linearise(M, ground, is_far)
        if not is_far:
            self._eliminate_points(M, ground)

    def _eliminate_points(self, M: FloatArray, ground: FloatArray) -> None:
        # a shift of the point is one of the camera, in its axes: the rows of t
        B = (M[:3, :3].T * OPPOSITE).dot(self.equations[1:4]).reshape(self.H.shape)
        self.l -= np.einsum("kin,kn->in", B, self.given - ground[:3])
        np.einsum("kin,kln->lin", B, self.cofactor, out=self.H)
        (xx, xy), (_, yy) = np.einsum("kin,kjn->ijn", B, self.H)
        by_l11 = 1.0 / np.sqrt(1.0 + xx)
        l21 = xy * by_l11
        self.x_lines *= by_l11
        self.y_lines -= l21 * self.x_lines
        self.y_lines *= 1.0 / np.sqrt(1.0 + yy - l21 * l21)

    def moved(self, step: FloatArray) -> FloatArray:
        """P = P0 + S B' (1 + B S B')^-1 (l - A d) (3, n)."""
        residual = self.l - step.dot(self.equations[:6]).reshape(self.l.shape)
        return np.asarray(self.given + np.einsum("kin,in->kn", self.H, residual))

    def point_cofactors(self, unknowns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """dP = G d(elements): G (n, 3, 6), and the cofactors (n, 3, 3) of the points if the elements were known.

        `unknowns` (6, 6): those of the elements.
        """
        A = unknowns.T.dot(self.equations[:6]).reshape(6, *self.l.shape)
        G, own = np.einsum("kin,jin->kjn", self.H, -A), self.cofactor - np.einsum("kin,lin->kln", self.H, self.H)
        return G.transpose(2, 0, 1), own.transpose(2, 0, 1)


class PhotosDesign(Design):
    """Of many photos at once, in few bytes."""

    def __init__(self, n: int, p: int) -> None:
        super().__init__(n, p)
        self.camera = np.empty((3, n, p))
        self.xs_ys, self.zs, self.vu, self.r3 = self.camera[:2], self.camera[2], self.lines[1::-1], self.lines[3:5]
        self.w, self.both_w, self.factors = self.lines[5], self.lines[5:9:3], self.lines[5:2:-1, None]
        self.t3_r2_r1, self.ones = self.products[:3], self.lines[11:15:3]

    def normal_matrices(self, M: FloatArray, image: FloatArray, ground: FloatArray) -> FloatArray:
        """(7, 7, p) of p photos, the lower triangles only: `M` (3, 4, p), `ground` (4, n, p), `image` (2, n, p)."""
        np.einsum("ikp,knp->inp", M, ground, out=self.camera)
        np.reciprocal(self.zs, self.both_w)
        np.multiply(self.xs_ys, self.w, self.uv)
        np.multiply(self.vu, ACROSS[:, None], self.r3)
        np.multiply(self.factors, self.uv, self.t3_r2_r1)
        np.subtract(self.ones, ACROSS[:, None], self.ones)
        np.add(self.uv, image, self.l)
        A, N = self.equations, np.empty((7, 7, M.shape[2]))
        for i in range(7):
            np.einsum("ap,jap->jp", A[i], A[: i + 1], out=N[i, : i + 1])
        return N
