"""m_i = mu sqrt(Q_ii): the seven elements as each paper names them, with their cofactors Q' = J Q J'.

* `rotation`: small rotation about the ground axes, H, X0: what the adjustment solves for;
* `homothety`: xi, eta, theta about the fixed axes, H, X0 (seed 000, form (2'));
* `joint`: the same with T = H X0 in model units (seed 000, form (4'));
* `scale`: X0, t = 1/H and the tilts (seed 002, (108)).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.rotation import aok_by_rotation, aok_from_matrix, near_blind_aok
from orient.geometry.similarity import fixed_axes_by_rotation, fixed_axes_from_matrix, near_blind_fixed_axes
from orient.solvers.absolute_orientation import origin_by_centre
from orient.solvers.absolute_problem import ELEMENTS, Similarity
from orient.solvers.absolute_result import AbsoluteOrientation

FloatArray = NDArray[np.float64]

ANGLES = ("xi", "eta", "theta")
TRANSLATION = ("X_0", "Y_0", "Z_0")


@dataclass(frozen=True, slots=True)
class ElementView:
    """Seven elements under one paper's names: values and Q (7, 7); units rad, m, model units; NaN Q if singular.

    `near_blind`: the outer two angles have lost their meaning (the angles are then still right as a triple).
    """

    names: tuple[str, ...]
    values: FloatArray
    Q: FloatArray
    near_blind: bool

    def standard_deviations(self, variance_scale: float) -> FloatArray:
        """m_i = mu sqrt(Q_ii), mu^2 = `variance_scale`: (7,). Source: seed 002, equation (59)."""
        return np.asarray(np.sqrt(variance_scale * np.diag(self.Q)))


def element_view(found: AbsoluteOrientation, view: str) -> ElementView:
    """The elements as `rotation`, `homothety`, `joint` or `scale`; ValueError for another word."""
    if view not in VIEWS:
        raise ValueError(f"{view} is none of {', '.join(VIEWS)}")
    names, values, J, near_blind = VIEWS[view](found)
    return ElementView(names, values, np.asarray(J @ found.Q @ J.T), near_blind)


def view_changes(found: AbsoluteOrientation, view: str, changes: FloatArray) -> FloatArray:
    """(..., 7) changes of the elements of a view, from those of r, ln H and the ground position of the model centre."""
    to_origin = origin_by_centre(Similarity(found.rotation, found.H, found.X0), found.model_centre)
    J = VIEWS[view](found)[2] @ to_origin
    return np.asarray(changes @ J.T)


Parts = tuple[tuple[str, ...], FloatArray, FloatArray, bool]


def _rotation(found: AbsoluteOrientation) -> Parts:
    return ELEMENTS, np.array([0.0, 0.0, 0.0, found.H, *found.X0]), np.eye(7), False


def _homothety(found: AbsoluteOrientation) -> Parts:
    J = np.eye(7)
    J[:3, :3] = fixed_axes_by_rotation(found.rotation)
    values = np.array([*fixed_axes_from_matrix(found.rotation), found.H, *found.X0])
    return (*ANGLES, "H", *TRANSLATION), values, J, near_blind_fixed_axes(found.rotation)


def _joint(found: AbsoluteOrientation) -> Parts:
    """dT = X0 dH + H dX0."""
    _, values, J, near_blind = _homothety(found)
    J[4:, 3] = found.X0
    J[4:, 4:] = found.H * np.eye(3)
    return (*ANGLES, "H", "T_X", "T_Y", "T_Z"), np.array([*values[:4], *found.T]), J, near_blind


def _scale(found: AbsoluteOrientation) -> Parts:
    """dt = -dH/H^2."""
    J = np.zeros((7, 7))
    J[:3, 4:] = np.eye(3)
    J[3, 3] = -1.0 / found.H**2
    J[4:, :3] = aok_by_rotation(found.rotation)
    values = np.array([*found.X0, found.t, *aok_from_matrix(found.rotation)])
    return (*TRANSLATION, "t", *ANGLES), values, J, near_blind_aok(found.rotation)


VIEWS: Mapping[str, Callable[[AbsoluteOrientation], Parts]] = {
    "rotation": _rotation,
    "homothety": _homothety,
    "joint": _joint,
    "scale": _scale,
}
