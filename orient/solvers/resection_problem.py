"""v = B_e de + B_p (G dc + dp) - H dc + L, v_p = dp + t, v_c = dc + c: the equations of a space resection.

Elements e and common unknowns c (sheets of the points, interior orientation of the image) on the rim, points p
eliminated, then c, as `functional_iteration` wants them.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import partials_rotation, project
from orient.geometry.rotation import rotation_exp
from orient.solvers.common_unknowns import CommonTriangle, WhitenedCommon, no_common, redundancy_numbers
from orient.solvers.engines import Engine, triangle
from orient.solvers.ground_points import (
    GroundKnowledge,
    PointTriangles,
    eliminate,
    point_cofactors,
    point_corrections,
)

FloatArray = NDArray[np.float64]

ELEMENTS = ("r_X", "r_Y", "r_Z", "X_S", "Y_S", "Z_S")


NO_COMMON = np.zeros(0)


@dataclass(frozen=True, slots=True)
class Orientation:
    """State of the iteration: the six elements, the ground points (n, 3), the common unknowns z (q,) of unit weight."""

    rotation: FloatArray
    station: FloatArray
    ground: FloatArray
    common: FloatArray = field(default_factory=NO_COMMON.copy)


@dataclass(frozen=True, slots=True)
class ResectionEquations:
    """The equations about one orientation, reduced to the six elements: R (de / s) = -rho."""

    vPv: float
    triangle: FloatArray
    rho: FloatArray
    scales: FloatArray
    points: PointTriangles
    common: CommonTriangle


@dataclass(frozen=True, slots=True)
class Quality:
    """Cofactors of z and the elements (q+6, q+6), of the ground (n, 3, 3), and the redundancy numbers diag(Q_v P).

    `image` (n, 2); `ground` (n,): of the given coordinates of a point together; `common` (k,).
    """

    rim: FloatArray
    Q_P: FloatArray
    image: FloatArray
    ground: FloatArray
    common: FloatArray


@dataclass(frozen=True, slots=True)
class ResectionProblem:
    """Image points (n, 2) [mm] with their cofactors (n, 2, 2), what is known of the ground, f [mm], what is shared."""

    image: FloatArray
    image_cofactor: FloatArray
    known: GroundKnowledge
    f_mm: float
    shared: WhitenedCommon | None = None
    engine: Engine = Engine.QR

    @property
    def common(self) -> WhitenedCommon:
        """What the points share; nothing by default."""
        return no_common(len(self.image)) if self.shared is None else self.shared

    def linearise(self, state: Orientation) -> ResectionEquations:
        """Whitened equations about `state`, the unknown points eliminated, the rest reduced by the engine."""
        computed, _ = project(state.ground, state.station, state.rotation, self.f_mm)
        partials = partials_rotation(state.ground, state.station, state.rotation, self.f_mm)
        distance = float(np.mean(np.linalg.norm(state.ground - state.station, axis=1)))
        scales = np.array([1.0, 1.0, 1.0, distance, distance, distance])
        common_rows = -self.common.by_image
        free_term = computed - self.image - self.common.image_shift(state.common)
        rows = np.concatenate([partials, free_term[:, :, None], common_rows], axis=2)
        if not (np.isfinite(rows).all() and np.isfinite(distance)):
            return _not_finite(scales, self.common.rank)
        white = np.linalg.solve(np.linalg.cholesky(self.image_cofactor), rows)
        white[:, :, :6] *= scales
        shift = state.ground - self.known.given - self.common.shift(state.common)
        vPv = float(np.sum(white[:, :, 9] ** 2) + np.sum((self.known.weight_root @ shift[:, :, None]) ** 2))
        design, free_term, points = self._rim_equations(white, shift, state.common)
        R, rho = triangle(design, free_term, self.engine)
        q = self.common.rank
        common = CommonTriangle(R[:q, :q], R[:q, q:], rho[:q])
        vPv += float(state.common @ state.common)
        return ResectionEquations(vPv, R[q:, q:], rho[q:], scales, points, common)

    def _rim_equations(
        self, white: FloatArray, shift: FloatArray, z: FloatArray
    ) -> tuple[FloatArray, FloatArray, PointTriangles]:
        """Equations of z and the elements: those that z has itself, of fixed points, of points without theirs."""
        q, u = self.common.rank, self.known.unknown
        fixed = self.known.free_rank == 0
        by_common = white[:, :, 6:9] @ self.common.by_ground + white[:, :, 10:]
        rim = np.concatenate([by_common, white[:, :, :6]], axis=2)
        rest, rest_free_term, points = eliminate(rim[u], white[u, :, 6:9], white[u, :, 9], shift[u], self.known)
        design = np.vstack([np.eye(q, q + 6), rim[fixed].reshape(-1, q + 6), rest])
        return design, np.concatenate([z, white[fixed, :, 9].ravel(), rest_free_term]), points

    def corrected(
        self, state: Orientation, linear: ResectionEquations, corrections: FloatArray
    ) -> tuple[Orientation, float]:
        """R <- exp([r]x) R, S <- S + dS, z <- z + dz, P <- P + G F dz + dp."""
        scaled = corrections / linear.scales
        dz = linear.common.corrections(scaled)
        dp = point_corrections(linear.points, np.concatenate([dz, scaled]), self.known)
        dP = self.common.shift(dz) + dp
        following = Orientation(
            rotation_exp(corrections[:3]) @ state.rotation,
            state.station + corrections[3:],
            state.ground + dP,
            state.common + dz,
        )
        return following, float(np.max(np.abs(dP), initial=0.0) / linear.scales[3])

    def image_rows(self, state: Orientation) -> tuple[FloatArray, FloatArray]:
        """Partials of v of the image coordinates by z and the elements (n, 2, q+6), by the point itself (n, 2, 3)."""
        partials = partials_rotation(state.ground, state.station, state.rotation, self.f_mm)
        by_common = partials[:, :, 6:] @ self.common.by_ground - self.common.by_image
        return np.concatenate([by_common, partials[:, :, :6]], axis=2), partials[:, :, 6:]

    def quality(self, state: Orientation, linear: ResectionEquations, Q: FloatArray) -> Quality:
        """Cofactors and redundancy numbers of everything, from the cofactors Q (6, 6) of the elements."""
        q = self.common.rank
        rim = linear.common.rim_cofactors(linear.scales, Q)
        scales = np.concatenate([np.ones(q), linear.scales])
        points = point_cofactors(linear.points, scales, rim, self.known, self.common.by_ground)
        design = partials_rotation(state.ground, state.station, state.rotation, self.f_mm)
        explained = design @ points.with_elements @ design.transpose(0, 2, 1)
        H = self.common.by_image
        across = design @ points.with_common @ H.transpose(0, 2, 1)
        explained += H @ rim[:q, :q] @ H.transpose(0, 2, 1) - across - across.transpose(0, 2, 1)
        weight = np.linalg.inv(self.image_cofactor)
        G = self.known.weight_root
        of_ground = self.known.weight_rank - np.trace(G @ points.own @ G.transpose(0, 2, 1), axis1=1, axis2=2)
        return Quality(
            rim=rim,
            Q_P=points.with_elements[:, 6:, 6:],
            image=1.0 - np.diagonal(explained @ weight, axis1=1, axis2=2),
            ground=of_ground,
            common=redundancy_numbers(self.common, rim[:q, :q]),
        )


def _not_finite(scales: FloatArray, q: int) -> ResectionEquations:
    """A state that cannot be linearised: infinite v'Pv, which the loop refuses."""
    empty = PointTriangles(np.zeros((0, 3, 3)), np.zeros((0, 3, q + 6)), np.zeros((0, 3)))
    common = CommonTriangle(np.eye(q), np.zeros((q, 6)), np.zeros(q))
    return ResectionEquations(np.inf, np.zeros((6, 6)), np.zeros(6), scales, empty, common)
