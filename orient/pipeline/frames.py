"""Between the stored frames and the solver's right-handed one, and from both to the Earth.

T' is north, east, up (left-handed). Its right-handed partner is east, north, up: the first two axes change places.
Local Cartesian ground is its own partner when it is right-handed.
"""

from dataclasses import dataclass

import numpy as np

from orient.geodesy.ellipsoid import Ellipsoid
from orient.geodesy.line_of_sight import line_at_height, line_at_heights
from orient.geodesy.topocentric import (
    Origin,
    geocentric_from_geographic,
    geographic_from_geocentric,
    geographic_from_topocentric,
    horizon_axes,
    local_axes,
    topocentric_from_geographic,
    turn_from_grid,
    turn_to_grid,
)
from orient.pipeline.ground import Ground
from orient.pipeline.tables import Array, required
from orient.units import RADIANS_PER_DEGREE
from orient.values import Row

SWAP = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, slots=True)
class Frame:
    """The frame of the stored ground coordinates. `partner` is its own inverse and turns it right-handed."""

    kind: str
    partner: Array
    origin: Origin | None = None
    gamma: float = 0.0
    ellipsoid: Ellipsoid | None = None

    @property
    def is_local(self) -> bool:
        """Local Cartesian ground: its Z is the height, and it has no place on an ellipsoid."""
        return self.origin is None

    @property
    def is_left_handed(self) -> bool:
        """Do X and Y change places in the right-handed partner?"""
        return bool(self.partner[0, 0] == 0.0)

    def right_handed(self, vectors: Array) -> Array:
        """(..., 3) vectors of the stored frame in the right-handed frame; the same call goes back."""
        turned: Array = vectors @ self.partner
        return turned

    def right_handed_matrix(self, matrices: Array) -> Array:
        """(..., 3, 3) covariances or weights likewise."""
        turned: Array = self.partner @ matrices @ self.partner
        return turned

    def geographic(self, xyz: Array) -> Array:
        """(n, 3) B, L [rad], H of points of T'. Needs a topocentric frame."""
        origin, ellipsoid = self._earth()
        return geographic_from_topocentric(turn_from_grid(xyz, self.gamma), origin, ellipsoid)

    def from_geographic(self, latitude: Array, longitude: Array, height: Array, *, compiled: bool = False) -> Array:
        """(n, 3) T' of points given by B, L [rad], H; `compiled` by numba, which no stage asks for."""
        origin, ellipsoid = self._earth()
        T = topocentric_from_geographic(latitude, longitude, height, origin, ellipsoid, compiled=compiled)
        return turn_to_grid(T, self.gamma)

    def from_horizon(self, latitude: Array, longitude: Array) -> Array:
        """(n, 3, 3) matrices that take north, east, up of each point's own horizon to T'; B, L [rad]."""
        origin, _ = self._earth()
        turned: Array = turn_to_grid(np.eye(3), self.gamma).T @ horizon_axes(latitude, longitude, origin)
        return turned

    def geocentric_from_right_handed(self) -> Array:
        """(3, 3) rotation that takes east, north, up of T' to geocentric axes."""
        origin, _ = self._earth()
        to_t = turn_from_grid(np.eye(3), self.gamma).T
        rotation: Array = local_axes(origin.B, origin.L) @ to_t @ self.partner
        return rotation

    def geocentric(self, geographic: Array) -> Array:
        """(n, 3) geocentric X, Y, Z of B, L [rad], H."""
        _, ellipsoid = self._earth()
        latitude, longitude, height = geographic.T
        return geocentric_from_geographic(latitude, longitude, height, ellipsoid)

    def meet(self, station: Array, rays: Array, height: float) -> Array:
        """(n, 3) B, L [rad], H where `rays` (n, 3) from `station` (3,), right-handed, meet the height; NaN: nowhere."""
        _, ellipsoid = self._earth()
        start = self.geocentric(self.geographic(self.right_handed(station)[None, :]))[0]
        points = line_at_height(start, rays @ self.geocentric_from_right_handed().T, ellipsoid, height)
        return geographic_from_geocentric(points, ellipsoid)

    def meet_heights(self, station: Array, rays: Array, heights: Array) -> Array:
        """(n, 3) right-handed points on `rays` (n, 3) from `station` (3,) with the heights (n,); NaN: nowhere."""
        _, ellipsoid = self._earth()
        start = self.geocentric(self.geographic(self.right_handed(station)[None, :]))[0]
        points = line_at_heights(start, rays @ self.geocentric_from_right_handed().T, ellipsoid, heights)
        return np.asarray(station + (points - start) @ self.geocentric_from_right_handed())

    def _earth(self) -> tuple[Origin, Ellipsoid]:
        if self.origin is None or self.ellipsoid is None:
            raise ValueError("a local Cartesian frame has no place on the Earth")
        return self.origin, self.ellipsoid


def frame_of(row: Row, ground: Ground) -> Frame:
    """The frame described by a `topocentric_frame` row."""
    kind = str(row["kind"])
    if kind != "topocentric":
        return Frame(kind, np.eye(3) if kind == "local_right" else SWAP)
    origin = Origin(
        required(row, "B_N_deg") * RADIANS_PER_DEGREE,
        required(row, "L_N_deg") * RADIANS_PER_DEGREE,
        required(row, "H_N_m"),
    )
    return Frame(kind, SWAP, origin, required(row, "gamma_deg") * RADIANS_PER_DEGREE, ground.figure)
