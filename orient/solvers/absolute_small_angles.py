"""X_G - X = X0 + X dt - Y th - Z xi, ...: the linear orientation of a model nearly in place, seed 002, (111)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError
from orient.geometry.rotation import aok_from_matrix
from orient.geometry.similarity import ground_by_homothety, ground_by_small_angles, partials_small_angles
from orient.solvers.absolute_cofactors import added, weight_of
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.engines import Engine, triangle
from orient.solvers.functional_iteration import SINGULAR_RATIO, condition_ratio

FloatArray = NDArray[np.float64]

SMALL_ANGLE_ELEMENTS = ("X_0", "Y_0", "Z_0", "t", "xi", "eta", "theta")


@dataclass(frozen=True, slots=True)
class SmallAngleOrientation:
    """The elements of (111) beside the rigorous ones of the same control.

    `elements` (7,): X_0, Y_0, Z_0 [m], t, xi, eta, theta [rad] of the tilts; `rigorous` the same of the adjustment;
    `Q` (7, 7) cofactors of `elements`. `largest_gap_m`: largest distance between the two ground positions of a control
    point. `second_order` = (dt^2 + xi^2 + eta^2 + theta^2) / 2: the share of the model's size by which (111) errs.
    """

    elements: FloatArray
    rigorous: FloatArray
    Q: FloatArray
    vPv: float
    largest_gap_m: float
    second_order: float


def orient_by_small_angles(
    found: AbsoluteOrientation,
    model: FloatArray,
    ground: FloatArray,
    *,
    known: FloatArray | None = None,
    ground_cofactor: FloatArray | None = None,
    model_cofactor: FloatArray | None = None,
    engine: Engine = Engine.ZLATANOV,
) -> SmallAngleOrientation:
    """X_G - X = A (X0, dt, xi, eta, theta) + v, v'Pv -> min, t = 1 + dt: linear, one step, never iterated.

    Arguments as `orient_model`, whose result `found` on the same control it is compared with; `engine` reduces the
    equations. Meaningful only for a model that is nearly in place and in scale: look at `second_order` and
    `largest_gap_m`. Singular control raises GeometryError. Source: seed 002, (111).
    """
    K = np.broadcast_to(np.eye(3), (len(model), 3, 3)) if known is None else known
    if ground_cofactor is None:
        ground_cofactor = np.tile(np.eye(3) if model_cofactor is None else np.zeros((3, 3)), (len(model), 1, 1))
    arms = model - found.model_centre
    free_term = arms - (ground - found.ground_centre)
    rows = K @ np.concatenate([partials_small_angles(arms), free_term[:, :, None]], axis=2)
    white = weight_of(K, added(ground_cofactor, model_cofactor)).whiten(np.asarray(rows)).reshape(-1, 8)
    A, l = white[:, :7], white[:, 7]
    R, rho = triangle(A, l, engine)
    if condition_ratio(R) < SINGULAR_RATIO:
        raise GeometryError(
            "The control does not determine the elements of the small-angle formulas.", "Give more control points."
        )
    inverse = np.linalg.inv(R)
    centred = -inverse @ rho
    J, at_origin = _to_origin(found)
    vPv = float(np.sum((A @ centred + l) ** 2))
    return _compared(found, model, J @ centred + at_origin, np.asarray(J @ inverse @ inverse.T @ J.T), vPv)


def _to_origin(found: AbsoluteOrientation) -> tuple[FloatArray, FloatArray]:
    """X0 = C + P_c - x_c - M(x_c) (dt, xi, eta, theta) from the shift C of the centre: J (7, 7) and constant (7,)."""
    J = np.eye(7)
    J[:3, 3:] = -partials_small_angles(found.model_centre[None, :])[0, :, 3:]
    return J, np.concatenate([found.ground_centre - found.model_centre, np.zeros(4)])


def _compared(
    found: AbsoluteOrientation, model: FloatArray, elements: FloatArray, Q: FloatArray, vPv: float
) -> SmallAngleOrientation:
    by_small_angles = ground_by_small_angles(model, elements[3], elements[4:], elements[:3])
    by_rigorous = ground_by_homothety(model, found.rotation, found.H, found.X0)
    rigorous = np.concatenate([found.X0, [found.t], aok_from_matrix(found.rotation)])
    return SmallAngleOrientation(
        elements=elements + np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        rigorous=rigorous,
        Q=Q,
        vPv=vPv,
        largest_gap_m=float(np.max(np.linalg.norm(by_small_angles - by_rigorous, axis=1))),
        second_order=float(np.sum(elements[3:] ** 2) / 2),
    )
