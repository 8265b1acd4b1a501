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

For few points the lines above the first nine hold, for each of these eight, its factor and the u or v beside it.

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
N_LINES, N_POINT_LINES, N_FACTORS = 17, 6, 4
FACTORS, U_V = HEAD[N_FACTORS + 1 : 1 : -1], HEAD[:2]
SPREAD = np.concatenate([FACTORS.repeat(2, axis=0), np.tile(U_V, (N_FACTORS, 1)), HEAD])
"""Each factor of the products, each (u, v) beside it, and the head."""
SPREAD_OVER = np.concatenate([SPREAD, np.tile(HEAD[2], (len(SPREAD), 1))])
"""And for each line its zs."""
FEW_POINTS = 64
"""Up to so many numpy is sooner done with lines written out than with spreading one over others."""
ACROSS = np.array([[1.0], [-1.0]])
"""(v, u) to (v, -u)."""
OPPOSITE = np.array([-1.0, -1.0, 1.0])
"""t of the unknowns."""


class Design:
    """Rows of A and l of points without errors, (n,) of one photo or (n, p) of p photos.

    `lines` of zeros are written in place and may have others below.
    """

    def __init__(self, lines: FloatArray) -> None:
        self.lines, shape = lines, lines.shape[1:]
        self.uv, self.products, self.l = lines[:2], lines[9:17].reshape(4, 2, *shape), lines[15:17]
        self.flat = lines[1:17].reshape(8, -1, *shape[1:])
        self.equations = self.flat[1:]


class PhotoDesign(Design):
    """Of one photo, in few calls, with `extra` lines below; the lines of `SPREAD` above, where points are few."""

    def __init__(self, n: int, extra: int = 0) -> None:
        n_above = 0 if n > FEW_POINTS else len(SPREAD) - len(HEAD)
        everything = np.zeros((n_above + N_LINES + extra, n))
        super().__init__(everything[n_above:])
        self.quotients = everything[: n_above + len(HEAD)]
        if n > FEW_POINTS:
            self.matrix, self.camera = HEAD, np.empty((len(HEAD), n))
            self.numerators, self.denominators = self.camera, self.camera[2]
            self.factors, self.computed = self.lines[N_FACTORS + 1 : 1 : -1, None], self.uv
        else:
            self.matrix, self.camera = SPREAD_OVER, np.empty((len(SPREAD_OVER), n))
            self.numerators, self.denominators = np.split(self.camera, 2)
            self.factors, self.computed = everything[:n_above].reshape(2, N_FACTORS, 2, n)
        self.constants, self.measured = np.zeros((N_FACTORS, 2, n)), np.empty_like(self.computed)
        self.constants[1, 0], self.constants[2, 1] = -1.0, 1.0
        self.image, self.equations_T = self.constants[3], self.equations.T
        self.ground = np.ones((4, n))
        self.points = self.ground[:3]

    def place(self, image: FloatArray, ground: FloatArray, origin: FloatArray, f: float) -> None:
        """Points about the origin and what is measured of them: image (n, 2), ground (n, 3)."""
        np.divide(image.T, f, self.image)
        np.negative(self.image, self.measured)
        np.subtract(ground.T, origin[:, None], self.points)

    def normal_matrix(self, M: FloatArray, is_far: bool) -> FloatArray:
        """(7, 7) of A and l: `M` (4, 4) camera from ground (4, n) with ones."""
        self._linearise(M, is_far)
        # with the idle first row: a product of a matrix with itself is three times slower in OpenBLAS
        product: FloatArray = self.flat.dot(self.equations_T)
        return product[1:]

    def _linearise(self, M: FloatArray, is_far: bool) -> None:
        self.matrix.dot(M).dot(self.ground, self.camera)
        np.divide(self.numerators, self.denominators, self.quotients)
        np.multiply(self.factors, self.measured if is_far else self.computed, self.products)
        np.add(self.products, self.constants, self.products)
        if is_far:
            np.add(self.uv, self.image, self.l)

    def is_in_front(self) -> bool:
        return bool(self.denominators.max() < 0.0)


_KEPT = local()


def kept_design(n: int) -> PhotoDesign:
    """The one that this thread used last, if it is for n points: for few points making it is a tenth of the time."""
    design: PhotoDesign | None = getattr(_KEPT, "design", None)
    if design is None or design.image.shape[1] != n:
        design = _KEPT.design = PhotoDesign(n)
    return design


class WeightedDesign(PhotoDesign):
    """The same of points with errors, eliminated: rows whitened by the Cholesky factor of 1 + B S B'.

    The cofactors S (3, 3, n) are for readings of unit weight in x/f.
    Three more rows are those of H = (B S)' L'^-1, whose products with the equations lead back to the points.
    """

    def __init__(self, cofactor: FloatArray) -> None:
        n = cofactor.shape[2]
        super().__init__(n, extra=N_POINT_LINES)
        self.cofactor = cofactor
        self.H = self.lines[N_LINES:].reshape(3, 2, n)
        self.x_lines, self.y_lines = self.lines[3::2], self.lines[4::2]

    def place(self, image: FloatArray, ground: FloatArray, origin: FloatArray, f: float) -> None:
        super().place(image, ground, origin, f)
        self.given = self.points.copy()

    def _linearise(self, M: FloatArray, is_far: bool) -> None:
        super()._linearise(M, is_far)
        if not is_far:
            self._eliminate_points(M)

    def _eliminate_points(self, M: FloatArray) -> None:
        # a shift of the point is one of the camera, in its axes: the rows of t
        B = (M[:3, :3].T * OPPOSITE).dot(self.equations[1:4]).reshape(self.H.shape)
        self.l -= np.einsum("kin,kn->in", B, self.given - self.points)
        np.einsum("kin,kln->lin", B, self.cofactor, out=self.H)
        (xx, xy), (_, yy) = np.einsum("kin,kjn->ijn", B, self.H)
        by_l11 = 1.0 / np.sqrt(1.0 + xx)
        l21 = xy * by_l11
        self.x_lines *= by_l11
        self.y_lines -= l21 * self.x_lines
        self.y_lines *= 1.0 / np.sqrt(1.0 + yy - l21 * l21)

    def move_points(self, step: FloatArray) -> float:
        """P = P0 + S B' (1 + B S B')^-1 (l - A d); by how much at most."""
        residual = self.l - step.dot(self.equations[:6]).reshape(self.l.shape)
        points = self.given + np.einsum("kin,in->kn", self.H, residual)
        farthest = float(np.abs(points - self.points).max())
        self.points[:] = points
        return farthest

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
        super().__init__(np.zeros((N_LINES, n, p)))
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
