"""The six elements with their 6 x 6 covariance as rows, in the project's own frame."""

import numpy as np

from orient.export.solved import Solved, stored_covariance
from orient.values import Scalar

PARAMETERS = ("X_S", "Y_S", "Z_S", "rotation_1", "rotation_2", "rotation_3")
UNITS = ("m", "m", "m", "rad", "rad", "rad")


def covariance_rows(solved: Solved) -> list[list[Scalar]]:
    """Parameter, unit, value, sigma and the row of the 6 x 6 covariance, in the project's frame."""
    covariance = stored_covariance(solved)
    values = [*solved.frame.right_handed(solved.station).tolist(), 0.0, 0.0, 0.0]
    return [
        [name, unit, value, float(np.sqrt(covariance[i, i])), *covariance[i].tolist()]
        for i, (name, unit, value) in enumerate(zip(PARAMETERS, UNITS, values, strict=True))
    ]
