"""v = B_e de + B_p (G dc + dp) - H dc + L, v_p = dp + t, v_c = dc + c: the equations of a space resection.

Elements e (six of the exterior, and those of the camera that are not known) and common unknowns c (sheets of the
points, interior orientation of the image) on the rim, points p eliminated, then c, as `functional_iteration` wants
them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from orient.geometry.collinearity import projected_with_partials
from orient.geometry.rotation import rotation_exp
from orient.solvers.camera_unknowns import CameraUnknowns
from orient.solvers.common_unknowns import CommonTriangle, WhitenedCommon, no_common, redundancy_numbers
from orient.solvers.element_observations import ElementObservation, whitened_rows
from orient.solvers.engines import Engine, triangle
from orient.solvers.ground_points import (
    GroundKnowledge,
    PointTriangles,
    eliminate,
    point_cofactors,
    point_corrections,
)

FloatArray = NDArray[np.float64]

ELEMENTS = ("r_X", "r_Y", "r_Z", "X_S", "Y_S", "Z_S")
NOTHING = np.zeros(0)


@dataclass(frozen=True, slots=True)
class Orientation:
    """State of the iteration: the six elements, the ground points (n, 3), the common unknowns z (q,) of unit weight.

    `camera` (m,): values of the elements of the interior orientation that are unknowns.
    """

    rotation: FloatArray
    station: FloatArray
    ground: FloatArray
    common: FloatArray = field(default_factory=NOTHING.copy)
    camera: FloatArray = field(default_factory=NOTHING.copy)


@dataclass(frozen=True, slots=True)
class ResectionEquations:
    """The equations about one orientation, reduced to the u elements: R (de / s) = -rho; `distance` to the ground."""

    vPv: float
    triangle: FloatArray
    rho: FloatArray
    scales: FloatArray
    distance: float
    points: PointTriangles
    common: CommonTriangle


@dataclass(frozen=True, slots=True)
class Quality:
    """Cofactors of z and the elements (q+u, q+u), of the ground (n, 3, 3), and the redundancy numbers diag(Q_v P).

    `image` (n, 2); `ground` (n,): of the given coordinates of a point together; `common` (k,); `of_elements`: of what
    is known of the elements, first of the interior, then of the exterior orientation.
    """

    rim: FloatArray
    Q_P: FloatArray
    image: FloatArray
    ground: FloatArray
    common: FloatArray
    of_elements: FloatArray


@dataclass(frozen=True, slots=True)
class ImageEquations:
    """v = A de + B dP + L of the image coordinates: A (n, 2, u), B (n, 2, 3), L (n, 2), not yet weighted.

    `image_equations` hands back the six and the camera's elements in A, and no common unknowns in L.

    `measured` (n, 2): what L compares with; `by_computed` (n, 2, 2): dv by the coordinates of collinearity.
    """

    by_elements: FloatArray
    by_ground: FloatArray
    free_term: FloatArray
    measured: FloatArray
    by_computed: FloatArray


@dataclass(frozen=True)
class ResectionProblem:
    """Image points (n, 2) [mm] with their cofactors (n, 2, 2), what is known of the ground, f [mm], what is shared.

    `interior`: elements of the interior orientation that are unknowns too; `image` then only serves the start.
    `observed`: what is known of the exterior orientation; with `is_station_fixed` the station of the state is kept.
    """

    image: FloatArray
    image_cofactor: FloatArray
    known: GroundKnowledge
    f_mm: float
    shared: WhitenedCommon | None = None
    engine: Engine = Engine.QR
    interior: CameraUnknowns | None = None
    observed: Sequence[ElementObservation] = ()
    is_station_fixed: bool = False

    @cached_property
    def common(self) -> WhitenedCommon:
        """What the points share; nothing by default."""
        return no_common(len(self.image)) if self.shared is None else self.shared

    @cached_property
    def all_unknowns(self) -> tuple[str, ...]:
        """The six elements and those of the camera, fixed ones too: the order of every Q that is handed back."""
        return ELEMENTS if self.interior is None else (*ELEMENTS, *self.interior.names)

    @cached_property
    def free(self) -> NDArray[np.intp]:
        """Places (u,) of the unknowns among `all_unknowns`."""
        every = range(len(self.all_unknowns))
        return np.array([i for i in every if not (self.is_station_fixed and 3 <= i < len(ELEMENTS))], dtype=np.intp)

    @property
    def unknowns(self) -> tuple[str, ...]:
        """Names (u,) of the elements that are adjusted."""
        return tuple(self.all_unknowns[i] for i in self.free)

    @cached_property
    def _whitening(self) -> FloatArray:
        """L (n, 2, 2), L L' = cofactors of the image coordinates."""
        return np.asarray(np.linalg.cholesky(self.image_cofactor))

    @property
    def n_known(self) -> int:
        """How many equations say what is known of the elements."""
        return len(self.observed) + (0 if self.interior is None else len(self.interior.observed))

    def focal_length(self, state: Orientation) -> float:
        """f [mm] of the state."""
        return self.f_mm if self.interior is None else self.interior.at(state.camera).f_mm

    def image_equations(self, state: Orientation) -> ImageEquations:
        """Partials and misclosures of the image coordinates; through the lens where the camera is unknown."""
        equations = image_equations(
            self.image, state.ground, state.station, state.rotation, self.f_mm, self.interior, state.camera
        )
        misclosure = equations.free_term - self.common.image_shift(state.common)
        by_elements = equations.by_elements[:, :, self.free] if self.is_station_fixed else equations.by_elements
        return replace(equations, by_elements=by_elements, free_term=misclosure)

    def image_rows(self, state: Orientation) -> tuple[FloatArray, FloatArray]:
        """Partials of v of the image coordinates by z and the elements (n, 2, q+u), by the point itself (n, 2, 3)."""
        image = self.image_equations(state)
        by_common = image.by_ground @ self.common.by_ground - self.common.by_image
        return np.concatenate([by_common, image.by_elements], axis=2), image.by_ground

    def known_equations(self, state: Orientation) -> tuple[FloatArray, FloatArray]:
        """Whitened equations (k, u), (k,) of what is known of the camera and of the station and the angles."""
        m = len(state.camera)
        priors = (np.zeros((0, m)), NOTHING) if self.interior is None else self.interior.priors(state.camera)
        outer = whitened_rows(self.observed, state.rotation, state.station)
        design = np.zeros((len(priors[1]) + len(outer[1]), len(ELEMENTS) + m))
        design[: len(priors[1]), 6:] = priors[0]
        design[len(priors[1]) :, :6] = outer[0]
        return design[:, self.free], np.concatenate([priors[1], outer[1]])

    @property
    def known_cofactors(self) -> FloatArray:
        """Cofactors (k,) of what is known of the elements, each in its own unit, in the order of `known_equations`."""
        priors = NOTHING if self.interior is None else self.interior.cofactors[self.interior.observed]
        return np.concatenate([priors, [one.cofactor for one in self.observed]])

    @property
    def to_named(self) -> FloatArray:
        """(6+m+k, q+u): all elements and c = F z from the rim, z and the elements that are adjusted."""
        k, q = self.common.factor.shape
        size = len(self.all_unknowns)
        turn = np.zeros((size + k, q + len(self.free)))
        turn[self.free, np.arange(q, turn.shape[1])] = 1.0
        turn[size:, :q] = self.common.factor
        return turn

    def linearise(self, state: Orientation) -> ResectionEquations:
        """Whitened equations about `state`, the unknown points eliminated, the rest reduced by the engine."""
        distance = float(np.mean(np.linalg.norm(state.ground - state.station, axis=1)))
        scales = self._scales(distance)
        if self.interior is not None and not self.interior.is_camera(state.camera):
            return _not_finite(scales, self.common.rank, distance)
        image = self.image_equations(state)
        u = len(scales)
        rows = np.concatenate(
            [image.by_elements, image.by_ground, image.free_term[:, :, None], -self.common.by_image], axis=2
        )
        if not (np.isfinite(rows).all() and np.isfinite(distance)):
            return _not_finite(scales, self.common.rank, distance)
        white = np.linalg.solve(self._whitening, rows)
        white[:, :, :u] *= scales
        shift = state.ground - self.known.given - self.common.shift(state.common)
        known_design, known_free_term = self.known_equations(state)
        vPv = float(np.sum(white[:, :, u + 3] ** 2) + np.sum((self.known.weight_root @ shift[:, :, None]) ** 2))
        vPv += float(state.common @ state.common) + float(known_free_term @ known_free_term)
        design, free_term, points = self._rim_equations(white, shift, state.common)
        q = self.common.rank
        if len(known_free_term):
            design = np.vstack([design, np.hstack([np.zeros((len(known_design), q)), known_design * scales])])
            free_term = np.concatenate([free_term, known_free_term])
        R, rho = triangle(design, free_term, self.engine)
        common = CommonTriangle(R[:q, :q], R[:q, q:], rho[:q])
        return ResectionEquations(vPv, R[q:, q:], rho[q:], scales, distance, points, common)

    def _scales(self, distance: float) -> FloatArray:
        """(u,): 1 rad for angles, the distance for the station, what moves the image by f for the camera."""
        outer = np.array([1.0, 1.0, 1.0, distance, distance, distance])
        inner = NOTHING if self.interior is None else self.interior.scales
        return np.concatenate([outer, inner])[self.free]

    def _rim_equations(
        self, white: FloatArray, shift: FloatArray, z: FloatArray
    ) -> tuple[FloatArray, FloatArray, PointTriangles]:
        """Equations of z and the elements: those that z has itself, of fixed points, of points without theirs."""
        q, unknown = self.common.rank, self.known.unknown
        u = white.shape[2] - q - 4
        fixed = self.known.free_rank == 0
        by_ground, free_term = white[:, :, u : u + 3], white[:, :, u + 3]
        by_common = by_ground @ self.common.by_ground + white[:, :, u + 4 :]
        rim = np.concatenate([by_common, white[:, :, :u]], axis=2)
        rest, rest_free_term, points = eliminate(
            rim[unknown], by_ground[unknown], free_term[unknown], shift[unknown], self.known
        )
        design = np.vstack([np.eye(q, q + u), rim[fixed].reshape(-1, q + u), rest])
        return design, np.concatenate([z, free_term[fixed].ravel(), rest_free_term]), points

    def corrected(
        self, state: Orientation, linear: ResectionEquations, corrections: FloatArray
    ) -> tuple[Orientation, float]:
        """R <- exp([r]x) R, S <- S + dS, c <- c + dc, z <- z + dz, P <- P + G F dz + dp."""
        scaled = corrections / linear.scales
        dz = linear.common.corrections(scaled)
        dp = point_corrections(linear.points, np.concatenate([dz, scaled]), self.known)
        dP = self.common.shift(dz) + dp
        step = self.of_all(corrections)
        following = Orientation(
            rotation_exp(step[:3]) @ state.rotation,
            state.station + step[3:6],
            state.ground + dP,
            state.common + dz,
            state.camera + step[6:],
        )
        return following, float(np.max(np.abs(dP), initial=0.0) / linear.distance)

    def of_all(self, values: FloatArray) -> FloatArray:
        """(u,) or (u, u) of the unknowns among all elements: zero for those that are fixed."""
        size = len(self.all_unknowns)
        whole = np.zeros((size,) * values.ndim)
        whole[np.ix_(*(self.free,) * values.ndim)] = values
        return whole

    def quality(self, state: Orientation, linear: ResectionEquations, Q: FloatArray) -> Quality:
        """Cofactors and redundancy numbers of everything, from the cofactors Q (u, u) of the elements."""
        q = self.common.rank
        rim = linear.common.rim_cofactors(linear.scales, Q)
        scales = np.concatenate([np.ones(q), linear.scales])
        points = point_cofactors(linear.points, scales, rim, self.known, self.common.by_ground)
        image = self.image_equations(state)
        design = np.concatenate([image.by_elements, image.by_ground], axis=2)
        explained = design @ points.with_elements @ design.transpose(0, 2, 1)
        H = self.common.by_image
        across = design @ points.with_common @ H.transpose(0, 2, 1)
        explained += H @ rim[:q, :q] @ H.transpose(0, 2, 1) - across - across.transpose(0, 2, 1)
        weight = np.linalg.inv(self.image_cofactor)
        G = self.known.weight_root
        of_ground = self.known.weight_rank - np.trace(G @ points.own @ G.transpose(0, 2, 1), axis1=1, axis2=2)
        known, _ = self.known_equations(state)
        return Quality(
            rim=rim,
            Q_P=points.with_elements[:, len(Q) :, len(Q) :],
            image=1.0 - np.diagonal(explained @ weight, axis1=1, axis2=2),
            ground=of_ground,
            common=redundancy_numbers(self.common, rim[:q, :q]),
            of_elements=1.0 - np.sum((known @ Q) * known, axis=1),
        )


def image_equations(
    image: FloatArray,
    ground: FloatArray,
    station: FloatArray,
    rotation: FloatArray,
    f_mm: float,
    interior: CameraUnknowns | None,
    camera: FloatArray,
) -> ImageEquations:
    """v = F - image for the known camera, else v = h(F; c) - G(c) with the values `camera` c (m,) of its elements.

    `interior` holds the readings of these points; with it `image` and `f_mm` are not used.
    """
    f_mm = f_mm if interior is None else interior.at(camera).f_mm
    computed, partials = projected_with_partials(ground, station, rotation, f_mm)
    if interior is None:
        identity = np.broadcast_to(np.eye(2), (len(computed), 2, 2))
        return ImageEquations(partials[:, :, :6], partials[:, :, 6:], computed - image, image, identity)
    lens = interior.equations(camera, computed)
    partials = lens.by_computed @ partials
    by_elements = np.concatenate([partials[:, :, :6], lens.by_elements], axis=2)
    return ImageEquations(by_elements, partials[:, :, 6:], lens.misclosure, lens.measured, lens.by_computed)


def _not_finite(scales: FloatArray, q: int, distance: float) -> ResectionEquations:
    """A state that cannot be linearised: infinite v'Pv, which the loop refuses."""
    u = len(scales)
    empty = PointTriangles(np.zeros((0, 3, 3)), np.zeros((0, 3, q + u)), np.zeros((0, 3)))
    common = CommonTriangle(np.eye(q), np.zeros((q, u)), np.zeros(q))
    return ResectionEquations(np.inf, np.zeros((u, u)), np.zeros(u), scales, distance, empty, common)
