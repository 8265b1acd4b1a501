"""dP = -D (D (B'PB + W) D)^-1 D (B'P (A de + L) + W t): unknown ground coordinates, eliminated point by point.

D_i projects onto the unknown directions of point i, W_i is the weight of its given coordinates, t_i = adjusted minus
given. Everything is a batched orthogonal decomposition of small blocks: the cost grows with the number of points only.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

PRESENT = 1e-10


@dataclass(frozen=True)
class GroundKnowledge:
    """What is known of the ground points: `free` D (n, 3, 3), `weight_root` G (n, 3, 3), G'G = D W D, ranks (n,)."""

    given: FloatArray
    free: FloatArray
    weight_root: FloatArray
    free_rank: IntArray
    weight_rank: IntArray

    @cached_property
    def unknown(self) -> NDArray[np.intp]:
        """Positions of the points that have unknown coordinates."""
        return np.flatnonzero(self.free_rank)


@dataclass(frozen=True, slots=True)
class PointTriangles:
    """R_P dP + R_e (de / s) = -rho of every point with unknowns: (m, 3, 3), (m, 3, u), (m, 3)."""

    R_P: FloatArray
    R_e: FloatArray
    rho: FloatArray


@dataclass(frozen=True, slots=True)
class PointCofactors:
    """`with_elements` (n, u+3, u+3): of the u elements together with each point P_i; `own` (n, 3, 3): of p_i alone.

    `with_common` (n, u+3, q): of these with the common unknowns z. `by_rim` (n, 3, q+u): dp_i by z and the elements.
    """

    with_elements: FloatArray
    own: FloatArray
    with_common: FloatArray
    by_rim: FloatArray


def ground_knowledge(given: FloatArray, free: FloatArray | None, weight: FloatArray | None) -> GroundKnowledge:
    """Projectors D and weights W of ground points `given` (n, 3); None means errorless and without weight.

    The weight acts in the unknown directions only (D W D): an errorless coordinate needs none.
    """
    none = np.zeros((len(given), 3, 3))
    D = none if free is None else 0.5 * (free + free.transpose(0, 2, 1))
    W = none if weight is None else D @ weight @ D
    values, axes = np.linalg.eigh(0.5 * (W + W.transpose(0, 2, 1)))
    present = values > PRESENT * np.maximum(values[:, -1:], 0.0)
    root = np.sqrt(np.where(present, values, 0.0))[:, :, None] * axes.transpose(0, 2, 1)
    free_rank = np.rint(np.trace(D, axis1=1, axis2=2)).astype(np.int64)
    return GroundKnowledge(given, D, root, free_rank, present.sum(axis=1).astype(np.int64))


def eliminate(
    design: FloatArray, design_P: FloatArray, free_term: FloatArray, shift: FloatArray, known: GroundKnowledge
) -> tuple[FloatArray, FloatArray, PointTriangles]:
    """Two rows per point that are left for the rim when the unknown points are eliminated, by QR of each point's block.

    `design` (m, 2, u), `design_P` (m, 2, 3), `free_term` (m, 2): whitened image equations of the points
    `known.unknown`; `shift` (m, 3) = adjusted minus given. Returns (2m, u) rows, their free terms (2m,), the triangles.
    The decomposition does not know u: it carries the unit vectors of the two image equations instead.
    """
    points, u = known.unknown, design.shape[2]
    if not len(points):
        return design.reshape(0, u), free_term.ravel(), PointTriangles(np.zeros((0, 3, 3)), np.zeros((0, 3, u)), shift)
    D, G = known.free[points], known.weight_root[points]
    scale = np.max(np.abs(design_P), axis=(1, 2), initial=0.0)[:, None, None]
    block = np.zeros((len(points), 8, 6))
    # heavy rows first: orthogonal reduction keeps its digits then
    block[:, 0:3, :3] = G
    block[:, 0:3, 5] = np.einsum("nij,nj->ni", G, shift)
    block[:, 3:5, :3] = design_P @ D
    block[:, 3:5, 3:5] = np.eye(2)
    block[:, 5:8, :3] = (np.eye(3) - D) * scale
    R = np.asarray(np.linalg.qr(block, mode="r"))
    reduced = R[:, :5, 3:5] @ design
    reduced_free_term = np.einsum("nij,nj->ni", R[:, :5, 3:5], free_term) + R[:, :5, 5]
    triangles = PointTriangles(R[:, :3, :3], reduced[:, :3], reduced_free_term[:, :3])
    return reduced[:, 3:].reshape(-1, u), reduced_free_term[:, 3:].ravel(), triangles


def point_corrections(triangles: PointTriangles, scaled_corrections: FloatArray, known: GroundKnowledge) -> FloatArray:
    """dP (n, 3) that belong to the corrections de / s (u,) of the elements; zero for points without unknowns."""
    corrections = np.zeros_like(known.given)
    points = known.unknown
    if not len(points):
        return corrections
    right = triangles.rho + triangles.R_e @ scaled_corrections
    corrections[points] = -(known.free[points] @ _solved(triangles.R_P, right[:, :, None]))[:, :, 0]
    return corrections


def point_cofactors(
    triangles: PointTriangles, scales: FloatArray, Q: FloatArray, known: GroundKnowledge, by_common: FloatArray
) -> PointCofactors:
    """Cofactors of the points from those, `Q` (q+u, q+u), of the common unknowns z and the u elements.

    P_i = given + by_common_i z + p_i, dp = -D R_P^-1 (R_rim d(z, e) + rho); `by_common` (n, 3, q); `scales` (q+u,).
    """
    points, q = known.unknown, by_common.shape[2]
    D = known.free[points]
    own = np.zeros((len(known.given), 3, len(Q)))
    own[points] = -D @ _solved(triangles.R_P, triangles.R_e) / scales
    whole = own.copy()
    whole[:, :, :q] += by_common
    inverse = D @ _solved(triangles.R_P, np.broadcast_to(np.eye(3), D.shape))
    u = len(Q) - q
    joint = np.zeros((len(known.given), u + 3, u + 3))
    joint[:, :u, :u] = Q[q:, q:]
    joint[:, u:, :u] = whole @ Q[:, q:]
    joint[:, :u, u:] = joint[:, u:, :u].transpose(0, 2, 1)
    joint[:, u:, u:] = whole @ Q @ whole.transpose(0, 2, 1)
    of_own = own @ Q @ own.transpose(0, 2, 1)
    for cofactor in (joint[:, u:, u:], of_own):
        cofactor[points] += inverse @ inverse.transpose(0, 2, 1)
    with_common = np.concatenate([np.broadcast_to(Q[q:, :q], (len(whole), len(Q) - q, q)), whole @ Q[:, :q]], axis=1)
    return PointCofactors(joint, of_own, with_common, own)


def undetermined_points(triangles: PointTriangles, known: GroundKnowledge, limit: float) -> NDArray[np.intp]:
    """Points whose unknown coordinates neither image nor weight determine (a height below the camera), weakest first.

    `limit`: ratio of the singular values of a point's own equations.
    """
    values = np.linalg.svd(np.nan_to_num(triangles.R_P), compute_uv=False)
    ratio = values[:, -1] / np.where(values[:, 0] > 0, values[:, 0], 1.0)
    order = np.argsort(ratio, kind="stable")
    return np.asarray(known.unknown[: len(ratio)][order[ratio[order] <= limit]])


def onto_rays(known: GroundKnowledge, chosen: NDArray[np.bool_], station: FloatArray, rays: FloatArray) -> FloatArray:
    """Ground (n, 3) with the `chosen` points moved in their weightless directions as near to their rays as they go."""
    D, G = known.free[chosen], known.weight_root[chosen]
    unweighted = D @ (np.eye(3) - np.linalg.pinv(G, rcond=1e-8) @ G)
    across = np.eye(3) - rays[chosen, :, None] * rays[chosen, None, :]
    gap = across @ (station - known.given[chosen])[:, :, None]
    ground = known.given.copy()
    ground[chosen] += (unweighted @ np.linalg.pinv(across @ unweighted, rcond=1e-6) @ gap)[:, :, 0]
    return ground


def _solved(R: FloatArray, right: FloatArray) -> FloatArray:
    """R^-1 right for stacks of small triangles; infinite where a triangle is singular."""
    if not len(R):
        return np.zeros_like(right)
    singular = np.abs(np.diagonal(R, axis1=1, axis2=2)).min(axis=1) == 0
    safe = np.where(singular[:, None, None], np.eye(3), R)
    return np.where(singular[:, None, None], np.inf, np.linalg.solve(safe, right))
