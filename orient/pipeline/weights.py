"""Which directions of a ground point are unknown, and with what weight its given coordinates hold them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orient.errors import OrientError
from orient.pipeline.tables import Array, covariances, names
from orient.values import Row

SMALL_EIGENVALUE = 1e-12


@dataclass(frozen=True, slots=True)
class GroundWeights:
    """Per point: projector on the directions with variance, weight in them, and which part was not given."""

    projector: Array
    weight: Array
    known: Array

    def at(self, up: Array) -> tuple[Array, Array]:
        """(n, 3, 3) projectors on all unknown directions and (n, 3, 3) weights, for verticals `up` (n, 3)."""
        vertical = up[:, :, None] * up[:, None, :]
        plan, height = self.known == "plan", self.known == "height"
        free, weight = self.projector.copy(), self.weight.copy()
        free[plan] += vertical[plan]
        # a height-only point is moved between the rounds: its one weight turns with its vertical
        varies = np.trace(self.projector[height], axis1=1, axis2=2)[:, None, None]
        free[height] = np.eye(3) - (1.0 - varies) * vertical[height]
        weight[height] = np.trace(self.weight[height], axis1=1, axis2=2)[:, None, None] * vertical[height]
        return free, weight


def ground_weights(rows: Sequence[Row], control: str, sigma0: float, covariance: Array | None = None) -> GroundWeights:
    """Weights P = sigma0^2 C^-1 of ground coordinates in the directions in which C is not zero.

    `control` is auto (each point as it was given), fixed (no errors) or weighted (every point must have a covariance).
    `covariance` (n, 3, 3): others than those of the rows, such as without the part that the points of a sheet share.
    A point whose covariance has no height part keeps its height without error. Source: seed 004, (4), with the
    observation equations that EQUATIONS 4 adds.
    """
    covariance = covariances(rows) if covariance is None else covariance
    has_one = np.asarray(np.isfinite(covariance).all(axis=(1, 2)))
    if control == "weighted" and not has_one.all():
        point = rows[int(np.argmin(has_one))]["point"]
        raise OrientError(
            f'control point "{point}" has no standard deviation, but --control weighted was asked',
            "Give sigmas in control.csv, or use --control auto.",
        )
    if control == "fixed":
        has_one[:] = False
    eigenvalues, vectors = np.linalg.eigh(np.where(has_one[:, None, None], covariance, 0.0))
    largest = eigenvalues[:, -1:]
    varies = (eigenvalues > SMALL_EIGENVALUE * largest) & (largest > 0)
    inverse = np.where(varies, 1.0 / np.where(varies, eigenvalues, 1.0), 0.0)
    projector = vectors * varies[:, None, :] @ vectors.transpose(0, 2, 1)
    weight = sigma0**2 * (vectors * inverse[:, None, :] @ vectors.transpose(0, 2, 1))
    return GroundWeights(projector, weight, np.array(names(rows, "known")))
