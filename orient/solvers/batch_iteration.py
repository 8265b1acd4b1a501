"""Gauss-Newton for many photos with the same number of points: every array has the photos on its last axis.

Unknowns, equations and their order are those of `lean_design`.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from orient.geometry.rotation import cross_matrix
from orient.solvers.lean_design import NATURAL, PhotosDesign
from orient.solvers.lean_limits import LAST_IN_SIGMAS, LAST_STEP, SINGULAR, SMALL_STEP

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
CROSS = np.array([cross_matrix(axis) for axis in np.eye(3)])
"""[r]x = r1 CROSS[0] + r2 CROSS[1] + r3 CROSS[2]."""
LOWER = np.tri(6, dtype=np.bool_)[:, :, None]
DIAGONAL = np.diag_indices(3)


@dataclass(frozen=True, slots=True)
class Photos:
    """What is given of p photos: image (p, n, 2), ground (p, n, 3), f (p,), rough R (p, 3, 3) and S (p, 3)."""

    image: FloatArray
    ground: FloatArray
    f: FloatArray
    rotation: FloatArray
    station: FloatArray

    def __len__(self) -> int:
        return len(self.image)

    def __getitem__(self, at: slice | NDArray[np.intp]) -> "Photos":
        return Photos(*(getattr(self, field.name)[at] for field in fields(self)))


@dataclass(frozen=True, slots=True)
class BatchResection:
    """Orientations of p photos: R (p, 3, 3), S (p, 3), cofactors Q (p, 6, 6) of (r, S) with R_new = exp([r]x) R.

    `vPv` (p,) [mm^2]; `iterations` (p,); `converged` (p,): False where no start led to an end with all points in
    front: Q and v'Pv of such a photo are NaN, R and S mean nothing, and `resect` says why.
    """

    rotation: FloatArray
    station: FloatArray
    Q: FloatArray
    vPv: FloatArray
    iterations: NDArray[np.int64]
    converged: BoolArray

    def put(self, at: slice | NDArray[np.intp], part: "BatchResection") -> None:
        for field in fields(self):
            getattr(self, field.name)[at] = getattr(part, field.name)


def unsolved(photos: Photos) -> BatchResection:
    """The result before the iteration: rough values and NaN."""
    p = len(photos)
    Q, vPv, counts = np.full((p, 6, 6), np.nan), np.full(p, np.nan), np.zeros(p, dtype=np.int64)
    return BatchResection(photos.rotation.copy(), photos.station.copy(), Q, vPv, counts, counts > 0)


def gauss_newton(photos: Photos, max_iterations: int, may_be_left: float = 0.0) -> BatchResection:
    """All photos together until no more than a share of them is left: those have no iterations in the result."""
    running = _Running(photos)
    with np.errstate(all="ignore"):
        for _ in range(max_iterations):
            running.iterate()
            if np.count_nonzero(running.is_live) <= may_be_left * len(photos):
                break
        found = running.result(photos)
    if may_be_left:
        found.iterations[running.is_live] = 0
    return found


class _Running:
    """Points about the first one in camera distances, x/f, camera from ground M (3, 4, p), how far each photo is."""

    def __init__(self, photos: Photos) -> None:
        p, n, _ = photos.image.shape
        self.f = photos.f
        self.origin = photos.ground[:, 0].T
        away = self.origin - photos.station.T
        self.distance = np.linalg.norm(away, axis=0)
        self.image = np.divide(photos.image.transpose(2, 1, 0), self.f, out=np.empty((2, n, p)))
        self.ground = np.ones((4, n, p))
        np.subtract(photos.ground.transpose(2, 1, 0), self.origin[:, None], out=self.ground[:3])
        self.ground[:3] /= self.distance
        self.M = np.empty((3, 4, p))
        self.M[:, :3] = photos.rotation.transpose(2, 1, 0)
        self.M[:, 3] = np.einsum("ikp,kp->ip", self.M[:, :3], away / self.distance)
        self.N = np.empty((7, 7, p))
        self.count = np.zeros(p, dtype=np.int64)
        self.is_live, self.has_ended = self.count == 0, self.count > 0
        self.design = PhotosDesign(n, p)

    def iterate(self) -> None:
        """One step of the photos that are live; the others stay as they are."""
        N = self.design.normal_matrices(self.M, self.image, self.ground)
        y = _cholesky(N)
        step = _backward(N, y)
        np.copyto(self.N, N, where=self.is_live)
        np.copyto(self.M, _moved(self.M, step), where=self.is_live)
        self.count += self.is_live
        moved, size = np.abs(step).sum(axis=0), np.einsum("ip,ip->p", y, y)
        redundancy = max(2 * self.image.shape[1] - 6, 1)
        is_last = moved < np.where(size * redundancy < LAST_IN_SIGMAS**2 * N[6, 6], SMALL_STEP, LAST_STEP)
        self.has_ended |= self.is_live & is_last
        self.is_live &= ~is_last & np.isfinite(moved)

    def result(self, photos: Photos) -> BatchResection:
        """Of the photos that have ended, are determined and have all points in front."""
        in_front = np.einsum("kp,knp->np", self.M[2], self.ground).max(axis=0) < 0
        L = np.where(LOWER, self.N[:6, :6], 0.0)  # above the diagonal is whatever was there
        pivots = np.square(L[range(6), range(6)])
        regular = np.all(pivots > SINGULAR * np.einsum("ikp,ikp->ip", L, L), axis=0)
        good = self.has_ended & in_front & regular
        found = unsolved(photos)
        found.iterations[:], found.converged[:] = self.count, good
        M, d, f = self.M, self.distance, self.f
        Rt = M[:, :3]
        found.rotation[good] = Rt.transpose(2, 1, 0)[good]
        found.station[good] = (self.origin - d * np.einsum("ikp,ip->kp", Rt, M[:, 3])).T[good]
        found.Q[good] = _cofactors(L, Rt, d, f).transpose(2, 0, 1)[good]
        found.vPv[good] = (self.N[6, 6] * f**2)[good]
        return found


def _moved(M: FloatArray, step: FloatArray) -> FloatArray:
    """P_camera <- E P_camera + t (3, 4, p)."""
    natural = NATURAL @ step
    moved = np.einsum("ijp,jkp->ikp", _turns(natural[:3]), M)
    moved[:, 3] += natural[3:]
    return np.asarray(moved)


def _cholesky(N: FloatArray) -> FloatArray:
    """L with L L' = N in place of the first six rows and columns of N (7, 7, p); returns y = L^-1 g, g the last row."""
    for j in range(6):
        N[j:, j] -= np.einsum("ikp,kp->ip", N[j:, :j], N[j, :j])
        N[j:, j] /= np.sqrt(N[j, j])
    return N[6, :6]


def _backward(L: FloatArray, y: FloatArray) -> FloatArray:
    """L'^-1 y."""
    x = np.empty_like(y)
    for i in range(5, -1, -1):
        x[i] = (y[i] - np.einsum("kp,kp->p", L[i + 1 : 6, i], x[i + 1 :])) / L[i, i]
    return x


def _turns(r: FloatArray) -> FloatArray:
    """(3, 3, p) of (3, p): Cayley's ((1 - c'c) I + 2 c c' + 2 [c]x) / (1 + c'c), c = r/2; exp([r]x) to second order."""
    c = 0.5 * r
    cc = np.einsum("ip,ip->p", c, c)
    turns = c[:, None] * c
    turns += np.einsum("kij,kp->ijp", CROSS, c)
    turns *= 2.0 / (1.0 + cc)
    turns[DIAGONAL] += (1.0 - cc) / (1.0 + cc)
    return turns


def _cofactors(L: FloatArray, Rt: FloatArray, d: FloatArray, f: FloatArray) -> FloatArray:
    """(6, 6, p) of (r, S) in the ground's axes, r -> -R r, dS = -R t d: F'F with L F = (-R, -R d)' / f."""
    turn = np.zeros((6, 6, len(f)))
    turn[:3, :3], turn[3:, 3:] = Rt / -f, Rt * (d / -f)
    F = np.einsum("ji,jkp->ikp", NATURAL, turn)
    for i in range(6):
        F[i] = (F[i] - np.einsum("kp,kjp->jp", L[i, :i], F[:i])) / L[i, i]
    return np.asarray(np.einsum("kip,kjp->ijp", F, F))
