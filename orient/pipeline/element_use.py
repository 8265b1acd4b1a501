"""Rows of `element_use`: what becomes of the ground sigmas if less than the full 6 x 6 matrix is used (seed 003)."""

from collections.abc import Mapping, Sequence

import numpy as np

from orient.pipeline.ground_budget import ELEMENTS
from orient.pipeline.oriented import Oriented
from orient.pipeline.tables import Array
from orient.solvers.ground_covariance import symmetric_factor
from orient.solvers.mishchenko import variance_of_uses
from orient.solvers.predicted_orientation import named_angles
from orient.values import Row

RIGHT, DIAGONAL = "six elements", "standard deviations only"
STATION = ("X_S", "Y_S", "Z_S")


def use_rows(oriented: Oriented, C: Array) -> list[Row]:
    """Root mean square ground sigma and factors of each use of the elements.

    `C` (n, 2, 6): partials of the plan position of n points by (r, S). The elements are those that people use: the
    station, and alpha, omega, kappa (near their blind view omega, phi, kappa).
    """
    angles, by_rotation = named_angles(oriented.rotation)
    J = np.eye(ELEMENTS)
    J[:3, :3] = by_rotation
    names = (*angles, *STATION)
    factor = J @ symmetric_factor(oriented.covariance)
    full, diagonal, alone = variance_of_uses(C @ np.linalg.inv(J), factor, _groups(names))
    variances = {RIGHT: full, DIAGONAL: diagonal, **alone}
    return [_row(use, variance, full) for use, variance in variances.items()]


def _groups(names: Sequence[str]) -> Mapping[str, Sequence[int]]:
    without = {f"all but {name}": [k for k in range(ELEMENTS) if k != i] for i, name in enumerate(names)}
    return {"position only": (3, 4, 5), "angles only": (0, 1, 2), **without}


def _row(use: str, variance: Array, full: Array) -> Row:
    factors = np.sqrt(variance / full)
    return {
        "elements": use,
        "sigma_m": float(np.sqrt(np.mean(variance))),
        "factor": float(np.sqrt(np.mean(variance) / np.mean(full))),
        "factor_least": float(np.min(factors)),
        "factor_most": float(np.max(factors)),
    }
