"""The equations of `lean_resection`, written in place into one buffer, so that one product gives A'PA, A'Pl and l'Pl.

The unknowns have the order r3, -t1, -t2, r1, r2, t3: three neighbouring rows times (u, v) are then those of r1, r2, t3.

    row            x          y
    (u, v)         u          v
    r3             v         -u
    -t1            w          0
    -t2            0          w
    r1            u v       v v + 1
    r2         -u u - 1      -u v
    t3            w u        w v
    l           x/f + u    y/f + v
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

NATURAL = np.diag([1.0, 1.0, 1.0, -1.0, -1.0, 1.0])[:, [2, 3, 4, 0, 1, 5]]
"""(6, 6): (r1, r2, r3, t1, t2, t3) of the unknowns."""
ACROSS = np.array([[1.0], [-1.0]])
"""(v, u) to (v, -u); also what the rows of r1 and r2 add."""
N_ROWS, N_POINT_ROWS = 8, 3


class Design:
    """Rows of A and l of points without errors, (n,) of one photo or (n, p) of p photos, and `extra` rows below."""

    def __init__(self, *shape: int, extra: int = 0) -> None:
        self.rows = np.zeros((N_ROWS + extra, 2, *shape))
        lines = self.rows.reshape(-1, *shape)
        self.camera = np.empty((3, *shape))
        self.xs_ys, self.zs = self.camera[:2], self.camera[2]
        self.uv, self.vu, self.r3 = self.rows[0], self.rows[0, ::-1], self.rows[1]
        self.w, self.both_w = lines[4], lines[4:8:3]
        self.factors, self.products = lines[2:5, None], self.rows[4:7]
        self.ones, self.l = lines[9:11], self.rows[7]
        self.flat = self.rows[:N_ROWS].reshape(N_ROWS, -1, *shape[1:])
        self.equations = self.flat[1:]
        self.across = ACROSS if len(shape) == 1 else ACROSS[:, None]

    def normal_matrix(self, M: FloatArray, image: FloatArray, ground: FloatArray) -> FloatArray:
        """(7, 7) of A and l: `M` (3, 4) camera from ground (4, n) with ones, `image` x/f (2, n)."""
        np.matmul(M, ground, self.camera)
        self._linearise(M, image, ground)
        # with the idle first row: a product of a matrix with itself is three times slower in OpenBLAS
        product: FloatArray = self.flat @ self.equations.T
        return product[1:]

    def normal_matrices(self, M: FloatArray, image: FloatArray, ground: FloatArray) -> FloatArray:
        """(7, 7, p) of p photos, the lower triangles only: `M` (3, 4, p), `ground` (4, n, p), `image` (2, n, p)."""
        np.einsum("ikp,knp->inp", M, ground, out=self.camera)
        self._linearise(M, image, ground)
        A, N = self.equations, np.empty((7, 7, M.shape[2]))
        for i in range(7):
            np.einsum("ap,jap->jp", A[i], A[: i + 1], out=N[i, : i + 1])
        return N

    def _linearise(self, M: FloatArray, image: FloatArray, ground: FloatArray) -> None:
        np.reciprocal(self.zs, self.both_w)
        np.multiply(self.xs_ys, self.w, self.uv)
        np.multiply(self.vu, self.across, self.r3)
        np.multiply(self.factors, self.uv, self.products)
        np.add(self.ones, self.across, self.ones)
        np.add(image, self.uv, self.l)


class WeightedDesign(Design):
    """The same of points with errors, eliminated: rows whitened by the Cholesky factor of 1 + B S B'.

    `given` (3, n) and the cofactors S (3, 3, n) for readings of unit weight in x/f, both in camera distances.
    Three more rows are those of H = (B S)' L'^-1, whose products with the equations lead back to the points.
    """

    def __init__(self, given: FloatArray, cofactor: FloatArray) -> None:
        n = given.shape[1]
        super().__init__(n, extra=N_POINT_ROWS)
        self.given, self.cofactor = given, cofactor
        self.H, self.zeros = self.rows[N_ROWS:], self.rows.reshape(-1, n)[5:7]
        self.x_rows, self.y_rows = self.rows[1:, 0], self.rows[1:, 1]

    def _linearise(self, M: FloatArray, image: FloatArray, ground: FloatArray) -> None:
        super()._linearise(M, image, ground)
        self.zeros[:] = 0.0
        B = (self.uv * M[2, :3, None, None] - M[:2, :3].T[:, :, None]) * self.w
        self.l -= np.einsum("kin,kn->in", B, self.given - ground[:3])
        np.einsum("kin,kln->lin", B, self.cofactor, out=self.H)
        (xx, xy), (_, yy) = np.einsum("kin,kjn->ijn", B, self.H)
        l11 = np.sqrt(1.0 + xx)
        l21 = xy / l11
        self.x_rows /= l11
        self.y_rows -= l21 * self.x_rows
        self.y_rows /= np.sqrt(1.0 + yy - l21 * l21)

    def moved(self, step: FloatArray) -> FloatArray:
        """P = P0 + S B' (1 + B S B')^-1 (l - A d) (3, n)."""
        residual = self.l - (step @ self.equations[:6]).reshape(self.l.shape)
        return np.asarray(self.given + np.einsum("kin,in->kn", self.H, residual))

    def point_cofactors(self) -> tuple[FloatArray, FloatArray]:
        """dP = G d(unknowns): G (n, 3, 6), and the cofactors (n, 3, 3) of the points if the elements were known."""
        A = self.rows[1:7]
        G = -np.einsum("kin,jin->nkj", self.H, A)
        return G, np.asarray((self.cofactor - np.einsum("kin,lin->kln", self.H, self.H)).transpose(2, 0, 1))
