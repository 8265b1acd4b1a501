"""An orientation before anything is measured: standard deviations, ground accuracy, the worth of each control point.

Everything that `orient plan` shows; see `predicted_orientation`, `predicted_ground`, `control_effects`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.vertical_photo import element_units, normalised
from orient.solvers import mishchenko
from orient.solvers.control_effects import Effect, added, dropped
from orient.solvers.planned_photo import PlannedPhoto
from orient.solvers.predicted_ground import GroundMap, ground_map
from orient.solvers.predicted_orientation import Prediction, predict

FloatArray = NDArray[np.float64]

SAME_PLACE = 1e-3


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """The normal case by the formulas of seed 003, beside the inverse of the normal equations.

    `sigma` (6,) [m, rad] by (8)-(10), or with Dx and Dy, None if the layout allows neither; `largest_error`: of a
    standard deviation by (8)-(10) with one D, relative; `corner`: sqrt of the larger of K_XX, K_YY at (c, c) in units
    of the reading sigma, whatever the focal length; `focal_terms`: largest element of K^(f,c) there, which all cancel.
    """

    c_mm: float
    sigma: FloatArray | None
    largest_error: float
    corner: float
    focal_terms: float


@dataclass(frozen=True, slots=True)
class Plan:
    """Everything that can be said before measuring. `closed` only in the normal case (vertical, flat, errorless)."""

    photo: PlannedPhoto
    prediction: Prediction
    ground: GroundMap
    without: tuple[Effect, ...]
    one_more: tuple[Effect, ...]
    symmetry: mishchenko.Symmetry
    closed: ClosedForm | None


def plan(photo: PlannedPhoto, places: FloatArray, height_sigma_m: float = 0.0) -> Plan:
    """Prediction, ground accuracy at `places` (m, 2) [mm] over the frame, and what each point less or more would do.

    One more point is tried at every place where none is planned. Raises GeometryError as `predict` and `ground_map`.
    """
    prediction = predict(photo)
    ground = ground_map(photo, prediction, places, height_sigma_m)
    apart = np.linalg.norm(places[:, None, :] - photo.image[None, :, :], axis=2).min(axis=1)
    empty = places[apart > SAME_PLACE * float(np.max(np.abs(photo.image)))]
    names = [f"{x:g}, {y:g}" for x, y in empty]
    return Plan(
        photo,
        prediction,
        ground,
        dropped(photo, prediction, ground),
        added(photo, prediction, ground, empty, names),
        mishchenko.symmetry(normalised(photo.image)[0]),
        closed_form(photo) if photo.is_normal_case else None,
    )


def closed_form(photo: PlannedPhoto) -> ClosedForm:
    """Seed 003 on the layout of a vertical photo: what its closed form gives, and how wrong (8)-(10) would be.

    Relief, tilt and errors of the control are not in it: ask `PlannedPhoto.is_normal_case` before comparing.
    """
    points, c = normalised(photo.image)
    g = (photo.f_mm / c) ** 2
    units = photo.sigmas.image_mm * element_units(photo.f_mm, c, float(photo.station[2]))
    determinants = mishchenko.symmetry(points).determinants
    sigma = units * _roots(mishchenko.closed_form(points, g, determinants).Q) if determinants else None
    one_D = _roots(mishchenko.closed_form(points, g).Q) / _roots(mishchenko.cofactors(points, g))
    corner = np.ones(2)
    K = mishchenko.covariance(points, corner[None, :])[0, :, 0, :]
    parts = mishchenko.decomposition(points, g)
    terms = [mishchenko.element_matrices((corner, axis), (corner, axis), parts, g).focal for axis in (0, 1)]
    return ClosedForm(
        c, sigma, float(np.max(np.abs(one_D - 1))), float(np.max(_roots(K))), float(np.max(np.abs(terms)))
    )


def _roots(Q: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.diag(Q)))
