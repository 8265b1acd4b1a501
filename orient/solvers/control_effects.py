"""Q_(-i), Q_(+i): what one control point less or more does to a planned photo."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.solvers.ground_covariance import ray_at_height
from orient.solvers.planned_photo import UP, PlannedPhoto
from orient.solvers.predicted_ground import GroundMap
from orient.solvers.predicted_orientation import Prediction, whitened_partials

FloatArray = NDArray[np.float64]

INDISPENSABLE = 1e-9
"""Part of the information of a point that the others check, below which the photo is not determined without it."""


@dataclass(frozen=True, slots=True)
class Effect:
    """One point less or more: what becomes of the elements (6,) [m, rad] and of the mean ground sigma [m].

    Infinite when the photo is not determined without the point.
    """

    name: str
    x_mm: float
    y_mm: float
    sigma: FloatArray
    mean_sigma: float

    @property
    def is_determined(self) -> bool:
        return bool(np.isfinite(self.mean_sigma))


def dropped(photo: PlannedPhoto, prediction: Prediction, ground: GroundMap) -> tuple[Effect, ...]:
    """Q_(-i) = F (I + U (I - U'U)^-1 U') F', U' = W_i F: the prediction without each point, one by one."""
    U = prediction.shares.transpose(0, 2, 1)
    checked = np.eye(2) - prediction.shares @ U
    values, axes = np.linalg.eigh(checked)
    values[values[:, 0] < INDISPENSABLE] = np.nan
    change = (axes / values[:, None, :]) @ axes.transpose(0, 2, 1)
    return _effects(photo.names, photo.image, prediction, ground, U, change)


def added(
    photo: PlannedPhoto, prediction: Prediction, ground: GroundMap, image: FloatArray, names: Sequence[str]
) -> tuple[Effect, ...]:
    """Q_(+i) = F (I - U (I + U'U)^-1 U') F', U' = W_i F: the prediction with one more point at each of `image` (m, 2).

    The new point lies on the mean ground and is known like the control; places that see no ground are left out.
    """
    up = np.tile(UP, (len(image), 1))
    points = ray_at_height(image, photo.station, photo.rotation, photo.f_mm, np.zeros((len(image), 3)), up)
    seen = np.flatnonzero(np.isfinite(points).all(axis=1))
    rows = whitened_partials(photo, points[seen]) @ prediction.factor
    U = rows.transpose(0, 2, 1)
    change = np.asarray(-np.linalg.inv(np.eye(2) + rows @ U))
    return _effects([names[int(i)] for i in seen], image[seen], prediction, ground, U, change)


def _effects(
    names: Sequence[str],
    image: FloatArray,
    prediction: Prediction,
    ground: GroundMap,
    U: FloatArray,
    M: FloatArray,
) -> tuple[Effect, ...]:
    """F (I + U M U') F' for each U (n, 6, 2), M (n, 2, 2); not-a-number in M: nothing is determined."""
    by_element = prediction.named_factor @ U
    variance = np.diag(prediction.covariance) + np.einsum("nia,nab,nib->ni", by_element, M, by_element)
    rows = ground.jacobians.C[ground.met, :2] @ prediction.factor
    spread = np.einsum("mka,mkb->ab", rows, rows) / (2 * len(rows))
    mean = ground.mean_sigma**2 + np.einsum("nab,nbd,de,nea->n", M, U.transpose(0, 2, 1), spread, U)
    sigma = np.nan_to_num(np.sqrt(variance), nan=np.inf)
    mean_sigma = np.nan_to_num(np.sqrt(mean), nan=np.inf)
    return tuple(
        Effect(name, float(x), float(y), sigma[i], float(mean_sigma[i]))
        for i, (name, (x, y)) in enumerate(zip(names, image, strict=True))
    )
