"""Rows of `error_budget`: how much of the covariance of a ground point comes from which source of errors.

dP = T d(e, c) + J dx + h dH with T = [C, J H]: a new ray depends on the elements e and, through H = dx/dc, on the
estimated elements of the camera and the interior orientation c of the photo, whose errors are those of e too. With the
parts Sigma_s of their covariance (`source_cofactor`), K = T Sigma T' = sum of T Sigma_s T'; the own reading and the own
height of the point stand apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orient.geometry import plane
from orient.geometry.camera import Camera, Measured
from orient.pipeline.camera import adjusted_camera, camera_effect
from orient.pipeline.error_sources import HEIGHTS, IMAGE, SOURCES
from orient.pipeline.frames import Frame
from orient.pipeline.interior_unknowns import InteriorUnknowns, image_shift, interior_unknowns
from orient.pipeline.tables import Array, by_names, group, required, single
from orient.solvers.packed import unpack_upper
from orient.values import Columns, Row, Tables

ELEMENTS = 6
PHOTO, POINT = "photo", "point"
PARTS = ("XX", "XY", "YY")


@dataclass(frozen=True, slots=True)
class SeenImage:
    """Corrected image coordinates (n, 2) of readings, their partials by the reading (n, 2, 2) and by the unknowns.

    `by_unknowns` (n, 2, m+k): estimated elements of the camera, then the interior orientation.
    """

    image: Array
    by_reading: Array
    by_unknowns: Array

    def jacobian(self, C: Array, J: Array) -> Array:
        """T = [C, J dx/d(camera, interior orientation)] (n, 3, 6+m+k) from C (n, 3, 6) and J (n, 3, 2)."""
        return np.concatenate([C, J @ self.by_unknowns], axis=2)

    def reading(self, covariance: Array) -> Array:
        """(n, 2, 2) covariance of the corrected coordinates from that of the readings."""
        return np.asarray(self.by_reading @ covariance @ self.by_reading.transpose(0, 2, 1))


@dataclass(frozen=True, slots=True)
class RayUnknowns:
    """All that a new image ray depends on: elements and, where they were adjusted, camera and interior orientation.

    `cofactor` (6+m+k, 6+m+k), m elements of the camera and k parameters of the interior orientation, and its parts by
    source; right-handed frame. `camera`: as adjusted, with the names of the m elements; None for a known one.
    """

    cofactor: Array
    by_source: dict[str, Array]
    interior: InteriorUnknowns | None
    adjusted: Sequence[Row]
    camera: tuple[Camera, tuple[str, ...]] | None = None

    @property
    def with_known_interior(self) -> Array:
        """(6, 6) cofactors of the elements if camera and interior orientation were known: Q_ee - Q_ec Q_cc^-1 Q_ce."""
        e, c = slice(0, ELEMENTS), slice(ELEMENTS, None)
        Q = self.cofactor
        scale = np.sqrt(np.diag(Q)[c])
        of_c, across = Q[c, c] / np.outer(scale, scale), Q[e, c] / scale
        return np.asarray(Q[e, e] - across @ np.linalg.solve(of_c, across.T))

    def seen(self, image: Array, comparator: Array, measured: Measured) -> SeenImage:
        """Readings through the adjusted interior orientation and the adjusted camera.

        `image` (n, 2): corrected by the camera a priori; `measured`: before that, `comparator` (n, 2): before the
        interior orientation [mm].
        """
        shift = image_shift(self.interior, self.adjusted, comparator)
        return self._through_camera(image + shift, comparator, measured, shift)

    def at_places(self, places: Array, comparator: Array, principal_point: Array) -> SeenImage:
        """The same for `places` (n, 2) of the frame about the principal point: readings where the camera is estimated.

        Of a known camera they are corrected coordinates: the distortion at the edge of the frame is left out.
        """
        nothing = np.zeros_like(places)
        return self._through_camera(places, comparator, Measured(places + principal_point, nothing), nothing)

    def _through_camera(self, image: Array, comparator: Array, measured: Measured, shift: Array) -> SeenImage:
        """`image` (n, 2) where the camera is known, else `measured` moved by `shift` through the estimated one."""
        H = np.zeros((len(image), 2, 0)) if self.interior is None else self.interior.by_image(comparator)
        if self.camera is None:
            return SeenImage(image, np.broadcast_to(np.eye(2), (len(image), 2, 2)), H)
        camera, names = self.camera
        seen, by_reading, by_camera = camera_effect(camera, names, measured, shift)
        return SeenImage(seen, by_reading, np.concatenate([by_camera, by_reading @ H], axis=2))

    def comparator(self, in_frame: Array) -> Array:
        """(n, 2) comparator coordinates of places of the fiducial system [mm]; those without fiducial marks."""
        if self.interior is None:
            return in_frame
        return plane.invert(self.interior.transformation, self.interior.values, in_frame)


def ray_unknowns_of(photo: Tables, refine: Tables, resection: Tables, frame: Frame) -> RayUnknowns:
    """As the stage `resection` stored them."""
    adjusted = resection.get("adjusted_interior", ())
    unknowns = "ray" if adjusted else "rotation"
    whole = right_handed_cofactors([row for row in resection["cofactor"] if row["unknowns"] == unknowns], frame)
    parts = {
        source: right_handed_cofactors(rows, frame)
        for source, rows in group(resection["source_cofactor"], "source").items()
    }
    camera = adjusted_camera(single(photo, "photo"), photo, resection)
    return RayUnknowns(whole, parts, interior_unknowns(refine) if adjusted else None, adjusted, camera)


def right_handed_cofactors(rows: Sequence[Row], frame: Frame) -> Array:
    """Packed rows of r, S and what follows, from the stored frame back to the right-handed one."""
    stored = unpack_upper(np.array([required(row, "value") for row in rows]))
    turn = np.eye(len(stored))
    turn[3:6, 3:6] = frame.partner
    return np.asarray(turn @ stored @ turn)


def budget_rows(
    points: Sequence[str], T: Array, rays: RayUnknowns, variance_scale: float, reading: Array, height: Array
) -> Columns:
    """One row for each of the n `points`, source and part; `T` (n, 2, 6+m+k) in the plan axes of each point.

    `reading`, `height` (n, 2, 2): covariances of the own reading and the own height, in the same axes.
    """
    ordered = sorted(rays.by_source, key=lambda source: SOURCES.index(source) if source in SOURCES else len(SOURCES))
    parts = [(source, PHOTO, variance_scale * T @ rays.by_source[source] @ T.transpose(0, 2, 1)) for source in ordered]
    parts += [(IMAGE, POINT, reading)]
    if height.any():
        parts.append((HEIGHTS, POINT, height))
    covariances = np.stack([covariance for _, _, covariance in parts], axis=1)
    packed = covariances[:, :, *np.triu_indices(2)].reshape(-1, len(PARTS))
    return Columns(
        {
            "point": [point for point in points for _ in parts],
            "source": [source for source, _, _ in parts] * len(points),
            "part": [part for _, part, _ in parts] * len(points),
            **by_names([f"cov_{part}_m2" for part in PARTS], packed),
        }
    )
