"""The exterior orientation as numbers: station, rotation, elements in any convention of angles, full covariance."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orient.errors import GeometryError, UsageError
from orient.geometry.rotation import (
    aok_by_rotation,
    aok_from_matrix,
    matrix_from_quaternion,
    near_blind_aok,
    near_blind_opk,
    opk_by_rotation,
    opk_from_matrix,
)
from orient.pipeline.tables import columns, number, required, single
from orient.solvers.packed import unpack_upper
from orient.values import Tables

Array = NDArray[np.float64]

STATION = ("X_S", "Y_S", "Z_S")


@dataclass(frozen=True, slots=True)
class _Triple:
    """A convention of angles: names, the angles of R, d(angles)/dr (3, 3), and where they lose their meaning."""

    names: tuple[str, str, str]
    angles: Callable[[Array], Array]
    by_rotation: Callable[[Array], Array]
    near_blind: Callable[[Array], bool]


TRIPLES = {
    "aok": _Triple(("alpha", "omega", "kappa"), aok_from_matrix, aok_by_rotation, near_blind_aok),
    "opk": _Triple(("omega", "phi", "kappa"), opk_from_matrix, opk_by_rotation, near_blind_opk),
}
SIX = 6


@dataclass(frozen=True, slots=True)
class Element:
    """One element: radians or metres, and its standard deviation."""

    value: float
    sigma: float


@dataclass(frozen=True, slots=True)
class Orientation:
    """Exterior orientation of one version of `resection`.

    version         version of the stage
    frame           topocentric: T' = grid north, grid east, up (left-handed) | local_right | local_left
    station         (3,) X_S, Y_S, Z_S [m] in that frame
    rotation        (3, 3) image axes -> RIGHT-HANDED ground: east, north, up of T'; local_right as given, local_left
                    with X and Y exchanged (docs/conventions.md)
    to_right_handed (3, 3) takes vectors of the frame to the right-handed ground, and back: it is its own inverse
    covariance      (6, 6) of r_X, r_Y, r_Z [rad], X_S, Y_S, Z_S [m]: R_new = exp([r]x) R about the right-handed axes,
                    the station in the frame
    geographic      (3,) latitude, longitude [deg], ellipsoidal height [m] of the station; None for local ground
    f_mm            focal length, the adjusted one if it was estimated
    sigma0_mm       standard deviation of unit weight a posteriori; None without redundancy
    sigma0_apriori_mm   the same a priori
    redundancy      equations less unknowns
    """

    version: int
    frame: str
    station: Array
    rotation: Array
    to_right_handed: Array
    covariance: Array
    geographic: Array | None
    f_mm: float
    sigma0_mm: float | None
    sigma0_apriori_mm: float
    redundancy: int

    def elements(self, convention: str = "aok") -> Mapping[str, Element]:
        """The six elements by name, angles first: aok (alpha, omega, kappa of the papers) or opk (omega, phi, kappa).

        Radians and metres. Near the blind view of the convention its angles are meaningless one by one: GeometryError.
        """
        triple = _triple(convention)
        values = [*triple.angles(self.rotation).tolist(), *self.station.tolist()]
        sigmas = np.sqrt(np.diag(self.covariance_of(convention))).tolist()
        names = (*triple.names, *STATION)
        return {name: Element(value, sigma) for name, value, sigma in zip(names, values, sigmas, strict=True)}

    def covariance_of(self, convention: str = "aok") -> Array:
        """(6, 6) of the elements in the order of `elements` [rad, m]: J Sigma J' with J = d(angles)/dr."""
        triple = _triple(convention)
        if triple.near_blind(self.rotation):
            raise GeometryError(
                f"the photo looks along the blind view of {convention}: its angles mean nothing one by one",
                "Use the rotation matrix with `covariance`, or the other convention.",
            )
        J = np.eye(SIX)
        J[:3, :3] = triple.by_rotation(self.rotation)
        return np.asarray(J @ self.covariance @ J.T)


def orientation_from(version: int, resection: Tables, to_right_handed: Array) -> Orientation:
    """From the tables of the stage."""
    row = single(resection, "orientation")
    packed = [required(entry, "value") for entry in resection["cofactor"] if entry["unknowns"] == "rotation"]
    cofactors = unpack_upper(np.array(packed))[:SIX, :SIX]
    is_on_earth = row["B_S_deg"] is not None
    return Orientation(
        version=version,
        frame=str(row["frame"]),
        station=columns([row], "X_S_m", "Y_S_m", "Z_S_m")[0],
        rotation=matrix_from_quaternion(columns([row], "q_w", "q_x", "q_y", "q_z")[0]),
        to_right_handed=to_right_handed,
        covariance=required(row, "variance_scale") * cofactors,
        geographic=columns([row], "B_S_deg", "L_S_deg", "H_S_m")[0] if is_on_earth else None,
        f_mm=required(row, "f_mm"),
        sigma0_mm=number(row, "sigma0_mm"),
        sigma0_apriori_mm=required(row, "sigma0_apriori_mm"),
        redundancy=int(required(row, "redundancy")),
    )


def _triple(convention: str) -> _Triple:
    if convention not in TRIPLES:
        raise UsageError(f'there is no convention "{convention}"', f"Conventions are {', '.join(TRIPLES)}.")
    return TRIPLES[convention]
