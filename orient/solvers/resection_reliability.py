"""The observations of a resection as blocks for `reliability`: image and given ground coordinates, shared coefficients.

A point's block holds x, y of the image and X, Y, Z of the ground; its own unknowns are its adjusted ground coordinates.
The rim holds the common unknowns z and, last, the elements that are adjusted, those of the camera too.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import project
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.common_unknowns import WhitenedCommon
from orient.solvers.ground_covariance import ray_at_height_jacobians
from orient.solvers.ground_points import GroundKnowledge
from orient.solvers.reliability import Blocks, Reliability, own_misfits
from orient.solvers.resection import Resection
from orient.solvers.resection_problem import ImageEquations, image_equations

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

IMAGE, GROUND = (0, 1), (2, 3, 4)
"""Places of the coordinates in the block of a point."""
TURNED_AWAY = 1e-2
"""Weight of an axis, relative to the largest, below which a point given in part was not given along this axis."""
AT_ONCE = 2048
"""Points whose effects at all probes are in memory at once."""
MOST_PROBES = 60
"""Points at which the effect on the ground is looked at; far apart, so that the largest is among them."""


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured of n points, in the solver's frame: as the arguments of `resect`.

    `image` (n, 2) [mm], `image_cofactor` (n, 2, 2), `ground` what is known of the ground points, `by_common` (n, 3, q)
    their shift by the whitened common unknowns, `by_image` (n, 2, q) that of their image coordinates. `interior`:
    elements of the camera that are unknowns, with the readings of these points; None for a known camera.
    """

    image: FloatArray
    image_cofactor: FloatArray
    ground: GroundKnowledge
    by_common: FloatArray
    by_image: FloatArray
    interior: CameraUnknowns | None = None

    def at(self, keep: BoolArray | NDArray[np.intp]) -> "Measured":
        """Some of the points."""
        known = self.ground
        ground = GroundKnowledge(
            known.given[keep],
            known.free[keep],
            known.weight_root[keep],
            known.free_rank[keep],
            known.weight_rank[keep],
        )
        interior = None if self.interior is None else self.interior.of(keep)
        return Measured(
            self.image[keep], self.image_cofactor[keep], ground, self.by_common[keep], self.by_image[keep], interior
        )

    def seen_from(self, view: "View | Resection", place: FloatArray) -> ImageEquations:
        """v = computed - measured and its partials for points at `place` (n, 3), without common unknowns."""
        return image_equations(self.image, place, view.station, view.rotation, view.f_mm, self.interior, view.camera)


@dataclass(frozen=True, slots=True)
class View:
    """An orientation from which points are looked at: `Resection` is one. `camera` (m,): its estimated elements."""

    rotation: FloatArray
    station: FloatArray
    f_mm: float
    camera: FloatArray = field(default_factory=lambda: np.zeros(0))


def control_blocks(found: Resection, control: Measured, shared: WhitenedCommon, axes: FloatArray) -> list[Blocks]:
    """Groups: points (n, 5), x, y [mm], then ground coordinates [m]; the common unknowns, and what is known, if any.

    The last are the observations of `known_equations`, one a block: priors of the camera, then station and angles.
    `control` in the order of `found`; `axes` (3, 3) turns the ground coordinates to those that are to be tested.
    """
    points = _blocks(found, control, found.ground, found.residuals, _shared_shift(found, control, shared), axes)
    groups = [points, _coefficients(found, shared)] if shared.rank else [points]
    return [*groups, _known(found, shared)] if found.problem.n_known else groups


def other_blocks(found: Resection, others: Measured, shared: WhitenedCommon) -> Blocks:
    """Points that took no part in the adjustment, at their given places moved by the common unknowns."""
    shift = _shared_shift(found, others, shared)
    place = others.ground.given + shift
    in_image = others.by_image @ (shared.inverse @ found.common)
    residuals = others.seen_from(found, place).free_term - in_image
    return _blocks(found, others, place, residuals, shift, np.eye(3))


def view_misfits(view: View, points: Measured) -> FloatArray:
    """T_i (n,): weighted squared misfit of each point at a given orientation, its unknown coordinates fitted.

    In units of mm^2 (weights are 1 for one reading); infinite for a point behind the camera.
    """
    place = points.ground.given
    with np.errstate(all="ignore"):
        computed, zs = project(place, view.station, view.rotation, view.f_mm)
        seen = (zs < 0) & np.isfinite(computed).all(axis=1)
    T = np.full(len(place), np.inf)
    visible = points.at(seen)
    residuals = visible.seen_from(view, place[seen]).free_term
    blocks = _blocks(view, visible, place[seen], residuals, np.zeros_like(place[seen]), np.eye(3))
    T[seen] = own_misfits(blocks)
    return T


def largest_ground_shift(
    found: Resection, up: FloatArray, probes: NDArray[np.intp], effect: FloatArray
) -> tuple[FloatArray, NDArray[np.intp]]:
    """max_j |C_j de| [m] over the points `probes`, and which one: what errors of the elements do on the ground.

    `effect` (n, k, 6+m) changes of the elements; `up` (p, 3) verticals of the probes. The ground point lies where its
    ray, through the camera with its changed elements, meets its height. NaN (and -1) where no ray meets the ground or
    the effect is not known.
    """
    place = found.ground[probes]
    rays = ray_at_height_jacobians(place, found.station, found.rotation, found.f_mm, up)
    C = np.concatenate([rays.C, rays.J @ _image_by_camera(found, probes)], axis=2)
    seen = np.flatnonzero(np.isfinite(C).all(axis=(1, 2)))
    if not len(seen):
        return np.full(effect.shape[:2], np.nan), np.full(effect.shape[:2], -1)
    metres, largest = np.empty(effect.shape[:2]), np.empty(effect.shape[:2], dtype=np.intp)
    for begin in range(0, len(effect), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        metres[some], largest[some] = _largest_of(C[seen], effect[some])
    return metres, probes[seen][largest]


def _largest_of(C: FloatArray, effect: FloatArray) -> tuple[FloatArray, NDArray[np.intp]]:
    """max_j |C_j de| and j, (n, k) each, from C (p, 3, u) and changes of the elements (n, k, u)."""
    shifts = np.linalg.norm(np.einsum("pce,nke->nkpc", C, effect), axis=3)
    largest = np.argmax(np.nan_to_num(shifts, nan=-1.0), axis=2)
    return np.take_along_axis(shifts, largest[:, :, None], axis=2)[:, :, 0], largest


def _image_by_camera(found: Resection, probes: NDArray[np.intp]) -> FloatArray:
    """(p, 2, m) change of the corrected image point of a reading by the estimated elements: -H^-1 A."""
    by_computed = found.problem.image_equations(found.state).by_computed[probes]
    return np.asarray(-np.linalg.inv(by_computed) @ found.camera_equations[probes])


def far_apart(image: FloatArray, most: int = MOST_PROBES) -> NDArray[np.intp]:
    """Up to `most` points that cover the photo (n, 2): all, or farthest-point sampling."""
    if len(image) <= most:
        return np.arange(len(image))
    chosen = [int(np.argmax(np.linalg.norm(image - image.mean(axis=0), axis=1)))]
    gap = np.linalg.norm(image - image[chosen[0]], axis=1)
    while len(chosen) < most:
        chosen.append(int(np.argmax(gap)))
        gap = np.minimum(gap, np.linalg.norm(image - image[chosen[-1]], axis=1))
    return np.array(sorted(chosen))


def _shared_shift(found: Resection, points: Measured, shared: WhitenedCommon) -> FloatArray:
    """(n, 3) G c of the adjusted common unknowns."""
    return np.asarray(points.by_common @ (shared.inverse @ found.common))


def _blocks(
    found: View | Resection,
    points: Measured,
    place: FloatArray,
    residuals: FloatArray,
    shift: FloatArray,
    axes: FloatArray,
) -> Blocks:
    """Points at `place`, which the common unknowns have moved by `shift` from where they were given."""
    known, (n, _, q) = points.ground, points.by_common.shape
    equations = points.seen_from(found, place)
    by_elements = equations.by_elements
    if isinstance(found, Resection):
        by_elements = by_elements[:, :, found.problem.free]
    design, own = np.zeros((n, 5, q + by_elements.shape[2])), np.zeros((n, 5, 3))
    design[:, :2, :q] = equations.by_ground @ points.by_common - points.by_image
    design[:, :2, q:] = by_elements
    own[:, :2] = equations.by_ground @ known.free
    own[:, 2:] = axes.T @ known.free
    L = np.linalg.cholesky(points.image_cofactor)
    root, inverse = np.zeros((n, 5, 5)), np.zeros((n, 5, 5))
    root[:, :2, :2], inverse[:, :2, :2] = np.linalg.inv(L), L
    root[:, 2:, 2:] = known.weight_root @ axes
    inverse[:, 2:, 2:] = np.linalg.pinv(root[:, 2:, 2:], rcond=1e-6)
    tested = np.ones((n, 5), dtype=np.bool_)
    tested[:, 2:] = _given_axes(root[:, 2:, 2:], known)
    v = np.hstack([residuals, (place - known.given - shift) @ axes])
    return Blocks(root, inverse, design, v, own, known.free_rank, tested, 2 + known.weight_rank)


def _given_axes(root: FloatArray, known: GroundKnowledge) -> BoolArray:
    """(n, 3) axes along which a point has a weighted coordinate."""
    weights = np.sum(root**2, axis=1)
    along = weights > TURNED_AWAY * np.max(weights, axis=1, keepdims=True)
    return np.asarray((known.weight_rank[:, None] == 3) | (along & (known.weight_rank[:, None] > 0)))


def _coefficients(found: Resection, shared: WhitenedCommon) -> Blocks:
    """c = F z observed as zero with the covariance F F': one block for all of them."""
    k, q = shared.factor.shape
    design = np.zeros((1, k, q + len(found.problem.free)))
    design[0, :, :q] = shared.factor
    return Blocks(shared.inverse[None], shared.factor[None], design, found.common[None])


def _known(found: Resection, shared: WhitenedCommon) -> Blocks:
    """What is known of the elements, one observation in each block, in its own unit."""
    root = 1.0 / np.sqrt(found.problem.known_cofactors)
    white, misclosure = found.problem.known_equations(found.state)
    design = np.zeros((len(root), 1, shared.rank + white.shape[1]))
    design[:, 0, shared.rank :] = white / root[:, None]
    return Blocks(root[:, None, None], 1.0 / root[:, None, None], design, (misclosure / root)[:, None])


def of_all_elements(found: Resection, reliability: Reliability) -> Reliability:
    """The same tests with effects on all 6 + m elements: zero on a station that is fixed."""
    free, size = found.problem.free, len(found.problem.all_unknowns)
    if len(free) == size:
        return reliability
    spread = np.zeros((len(free), size))
    spread[np.arange(len(free)), free] = 1.0
    return replace(reliability, tests=[replace(test, effect=test.effect @ spread) for test in reliability.tests])
