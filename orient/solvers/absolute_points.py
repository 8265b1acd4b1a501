"""X_G = R x/H + X0 with Q_G = B Q B' + t^2 R Q_x R': the points of a model on the ground, with cofactors."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from orient.geometry.similarity import ground_by_homothety, partials_rotation
from orient.solvers.absolute_result import AbsoluteOrientation

FloatArray = NDArray[np.float64]


def ground_points(
    found: AbsoluteOrientation,
    model: FloatArray,
    model_cofactor: FloatArray | None = None,
    control: Sequence[int | None] | None = None,
) -> tuple[FloatArray, FloatArray]:
    """X_G = R x/H + X0 (n, 3) [m] and its cofactors (n, 3, 3) = B Q B' + t^2 R Q_x R' - C - C'.

    `model` (n, 3) as observed, `model_cofactor` (n, 3, 3) of its own errors; `control` tells for each point its number
    among the control points of the adjustment, or None. The error of a control point's own model coordinates is
    already in the elements: C is their common part, so that the cofactors are right for these points too. Everything
    is taken from the centre of the control, so that far origins cost no digits. NaN when the control was singular.
    Source: seed 000, last paragraph; propagation of covariance.
    """
    arms = model - found.model_centre
    ground = ground_by_homothety(arms, found.rotation, found.H, found.ground_centre)
    B = partials_rotation(arms, found.rotation, found.t)
    Q = B @ found.Q_centred @ B.transpose(0, 2, 1)
    if model_cofactor is None:
        return ground, np.asarray(Q)
    scaled = found.t * found.rotation
    Q = Q + scaled @ model_cofactor @ scaled.T
    if control is None:
        return ground, np.asarray(Q)
    at = np.array([index for index, number in enumerate(control) if number is not None], dtype=np.intp)
    of = np.array([number for number in control if number is not None], dtype=np.intp)
    common = B[at] @ found.elements_with_model[of] @ scaled.T
    Q[at] += common + common.transpose(0, 2, 1)
    return ground, np.asarray(Q)
