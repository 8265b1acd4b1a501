"""Makes this sample project: a photogrammetric model in two zones, its control on the ground, and the truth.

    python simulate.py [FOLDER]

The seed is fixed: every run writes the same files (here, or into FOLDER). It uses numpy and PROJ only and nothing of
orient, so that the programme is checked by something that does not share its mistakes.
"""

import csv
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pyproj import Proj, Transformer

Array = NDArray[np.float64]

SEED = 20021108
TO_GEOCENTRIC = Transformer.from_pipeline("+proj=pipeline +step +proj=cart +ellps=WGS84")

# The ground, as photo.toml states it: origin of T' at the nadir of [station], heights from height_m.
ORIGIN_B, ORIGIN_L, ORIGIN_H, CENTRAL_MERIDIAN = 42.15, 24.75, 500.0, 27.0
SIGMA_PLAN_M, SIGMA_HEIGHT_M = 0.06, 0.09

# Errors of a model point in the axes of the model [mm]: z is weaker than x, y and correlated with them.
MODEL_ROOT = np.array([[0.004, 0.0, 0.0], [0.001, 0.004, 0.0], [0.002, -0.0015, 0.0065]])


@dataclass(frozen=True)
class Zone:
    """Seven elements of one zone: angles about the fixed axes east, north, up of T' [deg], H [mm/m], X0 in T'."""

    name: str
    xi: float
    eta: float
    theta: float
    H: float
    origin_east_north_up: tuple[float, float, float]
    centre: tuple[float, float]

    @property
    def rotation(self) -> Array:
        """R = A_theta A_eta A_xi, east-north-up from model; A_eta turns X towards Z."""
        (sx, cx), (se, ce), (st, ct) = (
            (np.sin(np.deg2rad(a)), np.cos(np.deg2rad(a))) for a in (self.xi, self.eta, self.theta)
        )
        A_xi = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
        A_eta = np.array([[ce, 0.0, -se], [0.0, 1.0, 0.0], [se, 0.0, ce]])
        A_theta = np.array([[ct, -st, 0.0], [st, ct, 0.0], [0.0, 0.0, 1.0]])
        return np.asarray(A_theta @ A_eta @ A_xi)


ZONES = (
    Zone("west", 1.2, -0.8, 37.0, 0.05, (-2600.0, 310.0, 120.0), (-2200.0, 0.0)),
    Zone("east", -2.9, 1.7, -141.0, 0.0625, (2950.0, -420.0, 85.0), (2200.0, 200.0)),
)
HALF_EXTENT_M = (2600.0, 1900.0)
GIVEN = {
    "west": "full full full full plan plan height height height check check free free free free free",
    "east": "full full plan plan height height height height check check free free free free",
}
"""What is known of each point of a zone, in order."""
TIES = ("full", "free", "free", "free")
"""Points between the zones that both hold."""


@dataclass(frozen=True)
class Point:
    name: str
    given: str
    zones: tuple[str, ...]
    east_north_up: Array


def main(folder: Path) -> None:
    random = np.random.default_rng(SEED)
    points = land(random)
    write_model(folder, random, points)
    write_control(folder, random, points)
    text = json.dumps(truth(points), indent=1)
    (folder / "truth.json").write_text(text + "\n", encoding="utf-8")


def land(random: np.random.Generator) -> list[Point]:
    """Points of each zone around its centre and ties in between, with 500 m of relief."""
    points = []
    for zone in ZONES:
        for number, given in enumerate(GIVEN[zone.name].split(), 1):
            place = random.uniform(-1.0, 1.0, 2) * HALF_EXTENT_M + zone.centre
            points.append(Point(f"{zone.name[0].upper()}{number:02}", given, (zone.name,), with_relief(place, random)))
    for number, given in enumerate(TIES, 1):
        place = np.array([random.uniform(-250.0, 250.0), random.uniform(-1700.0, 1700.0)])
        points.append(Point(f"T{number:02}", given, ("west", "east"), with_relief(place, random)))
    return points


def with_relief(place: Array, random: np.random.Generator) -> Array:
    return np.array([*place, random.uniform(-150.0, 350.0)])


# ------------------------------------------------------------------------------------------------ the earth


def gamma() -> float:
    """Meridian convergence at the origin of T' [rad]."""
    zone = Proj(proj="tmerc", lon_0=CENTRAL_MERIDIAN, ellps="WGS84")
    return float(np.deg2rad(zone.get_factors(ORIGIN_L, ORIGIN_B).meridian_convergence))


def geocentric_from_partner() -> Array:
    """(3, 3), columns: grid east, grid north, up of T' in geocentric axes."""
    B, L, g = np.deg2rad(ORIGIN_B), np.deg2rad(ORIGIN_L), gamma()
    east = np.array([-np.sin(L), np.cos(L), 0.0])
    up = np.array([np.cos(B) * np.cos(L), np.cos(B) * np.sin(L), np.sin(B)])
    north = np.cross(up, east)
    return np.column_stack([np.cos(g) * east - np.sin(g) * north, np.cos(g) * north + np.sin(g) * east, up])


def geographic(east_north_up: Array) -> Array:
    """(n, 3) B, L [deg], H [m] of places in the right-handed partner of T'."""
    origin = np.array(TO_GEOCENTRIC.transform(ORIGIN_L, ORIGIN_B, ORIGIN_H))
    place = origin + east_north_up @ geocentric_from_partner().T
    longitude, latitude, height = TO_GEOCENTRIC.transform(*place.T, direction="INVERSE")
    return np.column_stack([latitude, longitude, height])


# ------------------------------------------------------------------------------------------------ the lists


def write_model(folder: Path, random: np.random.Generator, points: Sequence[Point]) -> None:
    """x = H R'(P - X0) and its errors, with their covariance, in mm."""
    covariance = MODEL_ROOT @ MODEL_ROOT.T
    columns = [f"{covariance[i, j]:.4e}" for i in range(3) for j in range(i, 3)]
    rows = []
    for zone in ZONES:
        for point in (point for point in points if zone.name in point.zones):
            exact = zone.H * zone.rotation.T @ (point.east_north_up - zone.origin_east_north_up)
            x, y, z = exact + MODEL_ROOT @ random.normal(size=3)
            rows.append((zone.name, point.name, f"{x:.4f}", f"{y:.4f}", f"{z:.4f}", *columns))
    header = ("zone", "point", "x", "y", "z", "cov_xx", "cov_xy", "cov_xz", "cov_yy", "cov_yz", "cov_zz")
    write_rows(folder / "model.csv", header, rows)


def write_control(folder: Path, random: np.random.Generator, points: Sequence[Point]) -> None:
    """B, L, H as far as they are given, with their errors and standard deviations; check points without error."""
    places = geographic(np.array([point.east_north_up for point in points]))
    rows = []
    for point, (B, L, H) in zip(points, places, strict=True):
        if point.given == "free":
            continue
        is_check = point.given == "check"
        north, east, up = np.zeros(3) if is_check else random.normal(size=3)
        plan = (
            f"{B + np.rad2deg(SIGMA_PLAN_M * north / meridian_radius(B)):.9f}",
            f"{L + np.rad2deg(SIGMA_PLAN_M * east / parallel_radius(B)):.9f}",
        )
        height = f"{H + SIGMA_HEIGHT_M * up:.3f}"
        sigmas = (f"{SIGMA_PLAN_M}", f"{SIGMA_PLAN_M}", f"{SIGMA_HEIGHT_M}")
        cells = (*(plan if point.given != "height" else ("", "")), height if point.given != "plan" else "")
        known = (*(sigmas[:2] if point.given != "height" else ("", "")), sigmas[2] if point.given != "plan" else "")
        rows.append((point.name, "check" if is_check else "control", *cells, *(("", "", "") if is_check else known)))
    header = ("point", "role", "B_deg", "L_deg", "H_m", "sigma_N_m", "sigma_E_m", "sigma_H_m")
    write_rows(folder / "control.csv", header, rows)


def meridian_radius(B: float) -> float:
    a, e2 = 6378137.0, 0.0066943799901413165
    return float(a * (1 - e2) / (1 - e2 * np.sin(np.deg2rad(B)) ** 2) ** 1.5)


def parallel_radius(B: float) -> float:
    a, e2 = 6378137.0, 0.0066943799901413165
    return float(a * np.cos(np.deg2rad(B)) / np.sqrt(1 - e2 * np.sin(np.deg2rad(B)) ** 2))


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


# ------------------------------------------------------------------------------------------------ the truth


def truth(points: Sequence[Point]) -> dict[str, object]:
    """The elements in the three forms, X north and Y east of T', and where every point really is."""
    places = geographic(np.array([point.east_north_up for point in points]))
    return {
        "origin": {"B_deg": ORIGIN_B, "L_deg": ORIGIN_L, "H_m": ORIGIN_H},
        "gamma_deg": round(float(np.rad2deg(gamma())), 9),
        "zones": {zone.name: elements(zone) for zone in ZONES},
        "points": {
            point.name: {
                "given": point.given,
                "T_prime_m": [round(float(v), 4) for v in point.east_north_up[[1, 0, 2]]],
                "B_deg": round(float(B), 9),
                "L_deg": round(float(L), 9),
                "H_m": round(float(H), 4),
            }
            for point, (B, L, H) in zip(points, places, strict=True)
        },
    }


def elements(zone: Zone) -> dict[str, dict[str, float]]:
    """homothety (seed 000, (2')), joint (4') and scale (seed 002, (108))."""
    east, north, up = zone.origin_east_north_up
    R = zone.rotation
    angles = {"xi": zone.xi, "eta": zone.eta, "theta": zone.theta}
    tilts = {
        "xi": float(np.rad2deg(np.arctan2(-R[0, 2], R[2, 2]))),
        "eta": float(np.rad2deg(np.arcsin(-R[1, 2]))),
        "theta": float(np.rad2deg(np.arctan2(R[1, 0], R[1, 1]))),
    }
    origin = {"X_0": north, "Y_0": east, "Z_0": up}
    joint = {"T_X": zone.H * north, "T_Y": zone.H * east, "T_Z": zone.H * up}
    forms = {
        "homothety": {**angles, "H": zone.H, **origin},
        "joint": {**angles, "H": zone.H, **joint},
        "scale": {**origin, "t": 1.0 / zone.H, **tilts},
    }
    return {form: {name: round(value, 9) for name, value in values.items()} for form, values in forms.items()}


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
