"""The observations of an absolute orientation as blocks for `reliability`: given ground and model coordinates.

A point's block holds X, Y, Z of the ground and x, y, z of the model. Both go into one misclosure, L = C + R x/H - P in
the known directions K: an error of the ground moves it by -K d, one of the model by K t R d. Its weight is that of both
sides together, so the block needs no unknowns of its own, and a side without errors is simply not tested.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.geometry.similarity import partials_rotation
from orient.solvers.absolute_checks import known_rank
from orient.solvers.absolute_cofactors import added, turned, weight_of
from orient.solvers.absolute_problem import Similarity
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.reliability import Blocks

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

GROUND, MODEL = (0, 1, 2), (3, 4, 5)
"""Places of the coordinates in the block of a point."""
TURNED_AWAY = 1e-2
"""Share of a test direction within the known ones below which the point was not given along it."""


@dataclass(frozen=True, slots=True)
class ModelControl:
    """Control of one zone, right-handed, as the arguments of `orient_model`; independent points.

    `axes` (n, 3, 3): columns are the directions along which the ground coordinates are tested, orthonormal; of a point
    given in part the third is its own vertical, so that every known direction is one of them.
    """

    model: FloatArray
    ground: FloatArray
    known: FloatArray
    ground_cofactor: FloatArray
    model_cofactor: FloatArray | None
    axes: FloatArray

    def at(self, keep: BoolArray | NDArray[np.intp]) -> "ModelControl":
        """Some of the points."""
        model_cofactor = None if self.model_cofactor is None else self.model_cofactor[keep]
        return ModelControl(
            self.model[keep],
            self.ground[keep],
            self.known[keep],
            self.ground_cofactor[keep],
            model_cofactor,
            self.axes[keep],
        )

    def cofactor(self, view: Similarity) -> FloatArray:
        """Q_G + t^2 R Q_x R' (n, 3, 3)."""
        on_ground = None if self.model_cofactor is None else turned(view.t * view.rotation, self.model_cofactor)
        return added(self.ground_cofactor, on_ground)

    def misclosures(self, view: Similarity) -> FloatArray:
        """L = K (C + R x/H - P) (n, 3) [m]; `view` is about the origin of model and ground."""
        gaps = view.centre + view.t * self.model @ view.rotation.T - self.ground
        return np.asarray((self.known @ gaps[:, :, None])[:, :, 0])


def similarity_of(found: AbsoluteOrientation) -> Similarity:
    """The orientation about the centres of its control: `centre` belongs to model points less `model_centre`."""
    return Similarity(found.rotation, found.H, found.ground_centre)


def control_blocks(found: AbsoluteOrientation, control: ModelControl) -> Blocks:
    """(n, 6) observations X, Y, Z [m] and x, y, z [model units] of the adjusted control, elements (r, ln H, C).

    `control` in the order of `found`. The root of a block is W [K D, -K t R], W the root of the weight of its
    misclosure, D the axes; partials are taken at the adjusted model points, as in the adjustment.
    """
    return _blocks(found, control, found.model_residuals)


def other_blocks(found: AbsoluteOrientation, others: ModelControl) -> Blocks:
    """The same of points that took no part in the adjustment, at their observed model coordinates."""
    return _blocks(found, others, np.zeros_like(others.model))


def _blocks(found: AbsoluteOrientation, control: ModelControl, model_residuals: FloatArray) -> Blocks:
    view = similarity_of(found)
    centred = _about_centre(found, control)
    W = weight_of(control.known, centred.cofactor(view)).root
    L = centred.misclosures(view)
    by_ground = control.known @ control.axes
    by_model = -control.known @ np.broadcast_to(view.t * view.rotation, control.known.shape)
    G = np.concatenate([by_ground, by_model], axis=2)
    B = control.known @ partials_rotation(centred.model + model_residuals, view.rotation, view.t)
    # any coordinates of the ground that make this misclosure will do: K D a = L
    to_ground = np.linalg.pinv(by_ground, rcond=1e-6)
    design, residuals = np.zeros((len(L), 6, B.shape[2])), np.zeros((len(L), 6))
    design[:, :3] = to_ground @ B
    residuals[:, :3] = (to_ground @ L[:, :, None])[:, :, 0]
    is_given = np.linalg.norm(by_ground, axis=1) > TURNED_AWAY
    Q, P_ii = _own_cofactors(control, is_given)
    root = W @ G
    return Blocks(
        root=root,
        inverse=Q @ root.transpose(0, 2, 1),
        design=design,
        residuals=residuals,
        tested=np.isfinite(P_ii),
        rank=known_rank(control.known),
        weights=P_ii,
    )


def largest_model_shift(
    found: AbsoluteOrientation, model: FloatArray, effect: FloatArray
) -> tuple[FloatArray, NDArray[np.intp]]:
    """max_j |B_j de| [m] over the points `model` (p, 3), and which one: what errors of the elements do on the ground.

    `effect` (n, k, 7) changes of r, ln H, C. NaN and -1 where the effect is not known.
    """
    B = partials_rotation(model - found.model_centre, found.rotation, found.t)
    shifts = np.linalg.norm(np.einsum("pce,nke->nkpc", B, effect), axis=3)
    largest = np.argmax(np.nan_to_num(shifts, nan=-1.0), axis=2)
    metres = np.take_along_axis(shifts, largest[:, :, None], axis=2)[:, :, 0]
    return metres, np.where(np.isfinite(metres), largest, -1)


def view_misfits(view: Similarity, control: ModelControl) -> FloatArray:
    """T_i = L_i' P_i L_i (n,): weighted squared misfit of each point at a given similarity; infinite if not finite."""
    with np.errstate(all="ignore"):
        L = control.misclosures(view)
        try:
            white = weight_of(control.known, control.cofactor(view)).whiten(L[:, :, None])
        except np.linalg.LinAlgError:
            return np.full(len(L), np.inf)
        T = np.sum(white**2, axis=(1, 2))
    return np.where(np.isfinite(T), T, np.inf)


def _about_centre(found: AbsoluteOrientation, control: ModelControl) -> ModelControl:
    """Model points from the centre of the control, so that far origins cost no digits."""
    moved = control.model - found.model_centre
    return ModelControl(
        moved, control.ground, control.known, control.ground_cofactor, control.model_cofactor, control.axes
    )


def _own_cofactors(control: ModelControl, is_given: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Cofactors Q (n, 6, 6) of a block's observations, and their weights (Q^-1)_ii, infinite without an error."""
    n = len(control.model)
    Q, weights = np.zeros((n, 6, 6)), np.full((n, 6), np.inf)
    on_axes = control.axes.transpose(0, 2, 1) @ control.ground_cofactor @ control.axes
    on_axes = on_axes * is_given[:, :, None] * is_given[:, None, :]
    sides = [on_axes, np.zeros((n, 3, 3)) if control.model_cofactor is None else control.model_cofactor]
    for first, side in zip((0, 3), sides, strict=True):
        Q[:, first : first + 3, first : first + 3] = side
        diagonal = np.diagonal(np.linalg.pinv(side, rcond=1e-12, hermitian=True), axis1=1, axis2=2)
        weights[:, first : first + 3] = np.where(diagonal > 0, diagonal, np.inf)
    return Q, weights
