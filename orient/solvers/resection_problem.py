"""v = B_e de + B_p dP + L, v_P = dP + t: the equations of a space resection, as `functional_iteration` wants them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import partials_rotation, project
from orient.geometry.rotation import rotation_exp
from orient.solvers.ground_points import (
    GroundKnowledge,
    PointTriangles,
    eliminate,
    joint_cofactors,
    point_corrections,
)

FloatArray = NDArray[np.float64]

ELEMENTS = ("r_X", "r_Y", "r_Z", "X_S", "Y_S", "Z_S")


@dataclass(frozen=True, slots=True)
class Orientation:
    """State of the iteration: the six elements and the ground points (n, 3)."""

    rotation: FloatArray
    station: FloatArray
    ground: FloatArray


@dataclass(frozen=True, slots=True)
class ResectionEquations:
    """The equations about one orientation, reduced to the six elements: R (de / s) = -rho."""

    vPv: float
    triangle: FloatArray
    rho: FloatArray
    scales: FloatArray
    points: PointTriangles


@dataclass(frozen=True, slots=True)
class ResectionProblem:
    """Image points (n, 2) [mm] with their cofactors (n, 2, 2), what is known of the ground, f [mm]."""

    image: FloatArray
    image_cofactor: FloatArray
    known: GroundKnowledge
    f_mm: float

    def linearise(self, state: Orientation) -> ResectionEquations:
        """Whitened equations about `state`, the unknown points eliminated, one QR decomposition of the rest."""
        computed, _ = project(state.ground, state.station, state.rotation, self.f_mm)
        partials = partials_rotation(state.ground, state.station, state.rotation, self.f_mm)
        distance = float(np.mean(np.linalg.norm(state.ground - state.station, axis=1)))
        scales = np.array([1.0, 1.0, 1.0, distance, distance, distance])
        rows = np.concatenate([partials, (computed - self.image)[:, :, None]], axis=2)
        if not (np.isfinite(rows).all() and np.isfinite(distance)):
            return _not_finite(scales)
        white = np.linalg.solve(np.linalg.cholesky(self.image_cofactor), rows)
        white[:, :, :6] *= scales
        shift = state.ground - self.known.given
        vPv = float(np.sum(white[:, :, 9] ** 2) + np.sum((self.known.weight_root @ shift[:, :, None]) ** 2))
        u = self.known.unknown
        rest, rest_free_term, points = eliminate(
            white[u, :, :6], white[u, :, 6:9], white[u, :, 9], shift[u], self.known
        )
        fixed = self.known.free_rank == 0
        design = np.vstack([white[fixed, :, :6].reshape(-1, 6), rest])
        free_term = np.concatenate([white[fixed, :, 9].ravel(), rest_free_term])
        R = np.asarray(np.linalg.qr(np.column_stack([design, free_term]), mode="r"))
        return ResectionEquations(vPv, R[:6, :6], R[:6, 6], scales, points)

    def corrected(
        self, state: Orientation, linear: ResectionEquations, corrections: FloatArray
    ) -> tuple[Orientation, float]:
        """R <- exp([r]x) R, S <- S + dS, P <- P + dP."""
        dP = point_corrections(linear.points, corrections / linear.scales, self.known)
        following = Orientation(
            rotation_exp(corrections[:3]) @ state.rotation, state.station + corrections[3:], state.ground + dP
        )
        return following, float(np.max(np.abs(dP), initial=0.0) / linear.scales[3])

    def redundancy_numbers(
        self, state: Orientation, linear: ResectionEquations, Q: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """diag(Q_v P) of the image coordinates (n, 2), of the ground weights together (n,), and Q_P (n, 3, 3)."""
        joint = joint_cofactors(linear.points, linear.scales, Q, self.known)
        design = partials_rotation(state.ground, state.station, state.rotation, self.f_mm)
        explained = design @ joint @ design.transpose(0, 2, 1) @ np.linalg.inv(self.image_cofactor)
        Q_P = joint[:, 6:, 6:]
        G = self.known.weight_root
        of_ground = self.known.weight_rank - np.trace(G @ Q_P @ G.transpose(0, 2, 1), axis1=1, axis2=2)
        return 1.0 - np.diagonal(explained, axis1=1, axis2=2), of_ground, Q_P


def _not_finite(scales: FloatArray) -> ResectionEquations:
    """A state that cannot be linearised: infinite v'Pv, which the loop refuses."""
    empty = PointTriangles(np.zeros((0, 3, 3)), np.zeros((0, 3, 6)), np.zeros((0, 3)))
    return ResectionEquations(np.inf, np.zeros((6, 6)), np.zeros(6), scales, empty)
