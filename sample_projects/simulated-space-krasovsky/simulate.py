"""Makes this sample project: a map, a space photo of its land, the readings of both, and the truth beside them.

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

SEED = 20040417
CYCLES = 3
TO_GEOCENTRIC = Transformer.from_pipeline("+proj=pipeline +step +proj=cart +ellps=krass")

# The map: 1:1 000 000, 40-44 N, 18-24 E, conformal conic on two parallels; 1 mm on the true paper is 1 km.
SHEET, SOUTH, NORTH, WEST, EAST = "K-34", 40, 44, 18, 24
MAP = Proj(proj="lcc", lat_1=40 + 40 / 60, lat_2=43 + 20 / 60, lat_0=42, lon_0=21, ellps="krass")
PAPER = np.array([[1.0031, -0.0012], [0.0009, 0.9984]])
TABLE_TURN, TABLE_SHIFT_MM = np.deg2rad(1.3), np.array([412.6, 305.8])
SIGMA_DIGITISER_MM, SIGMA_HEIGHT_M = 0.07, 10.0

# The camera and the comparator, as photo.toml states them.
F, X0, Y0 = 200.0, 0.021, -0.014
K1, K2, P1, P2 = 6.2e-09, -2.9e-13, 1.4e-08, -0.9e-08
CALIBRATED = {
    "1": (-86.003, 85.998), "2": (86.001, 86.004), "3": (85.996, -86.002), "4": (-85.999, -85.997),
    "5": (0.003, 86.501), "6": (86.498, -0.002), "7": (-0.004, -86.503), "8": (-86.502, 0.001),
}  # fmt: skip
COMPARATOR = np.array([[1.00021, -0.01385], [0.01402, 0.99988]])
COMPARATOR_SHIFT_MM = np.array([214.317, 187.902])
SIGMA_COMPARATOR_MM = 0.004
SLIP_POINT, SLIP_CYCLE, SLIP_MM = "P11", 2, 0.045
"""One gross error at the comparator, in x."""

# The truth. Angles in the right-handed partner (east, north, up) of T'; origin = approximate nadir of photo.toml.
ORIGIN_B, ORIGIN_L, ORIGIN_H, CENTRAL_MERIDIAN = 42.2, 21.9, 800.0, 21.0
STATION_B, STATION_L, STATION_H = 42.2314, 21.8675, 250_480.0
ALPHA, OMEGA, KAPPA = 0.0312, -0.0187, 0.6400
REFRACTION_K = 2.35 * 0.907 / (250_000.0 - 800.0)
"""2.35 m (p(h)/p(0)) / (H - h), h = 800 m."""


@dataclass(frozen=True)
class Scene:
    """Points of the land: B, L [deg], H [m] and their ideal image [mm]."""

    names: tuple[str, ...]
    roles: tuple[str, ...]
    geographic: Array
    image: Array


def main(folder: Path) -> None:
    random = np.random.default_rng(SEED)
    scene = make_scene(random)
    write_crosses(folder, random)
    write_digitizer(folder, random, scene)
    write_readings(folder, random, scene)
    write_rows(folder / "control.csv", ("point", "role"), zip(scene.names, scene.roles, strict=True))
    text = json.dumps(truth(scene), indent=1)
    (folder / "truth.json").write_text(text + "\n", encoding="utf-8")


# ------------------------------------------------------------------------------------------------ the land


def make_scene(random: np.random.Generator) -> Scene:
    """36 points on a jittered 6 x 6 grid of the photo, each on its own height; eleven inner ones are check points."""
    steps = np.linspace(-72.0, 72.0, 6)
    image = np.array([(x, y) for y in steps[::-1] for x in steps]) + random.uniform(-9.0, 9.0, (36, 2))
    heights = np.round(random.triangular(40.0, 500.0, 2500.0, 36))
    inner = [7, 8, 10, 13, 15, 16, 19, 21, 22, 26, 28]
    names = tuple(f"P{i + 1:02d}" for i in range(36))
    roles = tuple("check" if i in inner else "control" for i in range(36))
    geographic = np.array([on_the_ground(xy, height) for xy, height in zip(image, heights, strict=True)])
    return Scene(names, roles, geographic, image_of(geocentric(geographic)))


def geocentric(geographic: Array) -> Array:
    """(n, 3) X_G, Y_G, Z_G [m] of B, L [deg], H [m]."""
    latitude, longitude, height = geographic.T
    return np.column_stack(TO_GEOCENTRIC.transform(longitude, latitude, height))


def geographic_of(place: Array) -> Array:
    """B, L [deg], H [m] of one geocentric place."""
    longitude, latitude, height = TO_GEOCENTRIC.transform(place[0], place[1], place[2], direction="INVERSE")
    return np.array([latitude, longitude, height])


def station() -> Array:
    return geocentric(np.array([[STATION_B, STATION_L, STATION_H]])).reshape(3)


def gamma() -> float:
    """Meridian convergence at the origin of T' [rad]."""
    zone = Proj(proj="tmerc", lon_0=CENTRAL_MERIDIAN, ellps="krass")
    return float(np.deg2rad(zone.get_factors(ORIGIN_L, ORIGIN_B).meridian_convergence))


def geocentric_from_partner() -> Array:
    """(3, 3), columns: grid east, grid north, up of T' in geocentric axes."""
    B, L, g = np.deg2rad(ORIGIN_B), np.deg2rad(ORIGIN_L), gamma()
    east = np.array([-np.sin(L), np.cos(L), 0.0])
    up = np.array([np.cos(B) * np.cos(L), np.cos(B) * np.sin(L), np.sin(B)])
    north = np.cross(up, east)
    return np.column_stack([np.cos(g) * east - np.sin(g) * north, np.cos(g) * north + np.sin(g) * east, up])


def partner_from_image() -> Array:
    """A = A_alpha(Y) A_omega(X) A_kappa(Z), columns: axes of the image in east, north, up of T'."""
    (sa, so, sk), (ca, co, ck) = np.sin([ALPHA, OMEGA, KAPPA]), np.cos([ALPHA, OMEGA, KAPPA])
    about_y = np.array([[ca, 0.0, -sa], [0.0, 1.0, 0.0], [sa, 0.0, ca]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, co, -so], [0.0, so, co]])
    about_z = np.array([[ck, -sk, 0.0], [sk, ck, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_y @ about_x @ about_z)


def image_of(place: Array) -> Array:
    """x = -f x_s/z_s, y = -f y_s/z_s of geocentric places (n, 3)."""
    x_s, y_s, z_s = ((place - station()) @ geocentric_from_partner() @ partner_from_image()).T
    return np.column_stack([-F * x_s / z_s, -F * y_s / z_s])


def on_the_ground(image: Array, height: float) -> Array:
    """B, L [deg], H [m] where the ray of an image point reaches the height."""
    direction = geocentric_from_partner() @ partner_from_image() @ np.array([*image, -F])
    direction /= np.linalg.norm(direction)
    distance = 0.0
    for _ in range(50):
        distance += geographic_of(station() + distance * direction)[2] - height
    return geographic_of(station() + distance * direction)


# ------------------------------------------------------------------------------------------------- the map


def on_the_table(latitude: Array, longitude: Array) -> Array:
    """Digitiser X, Y [mm]: projection, stretched and sheared paper, turned and shifted sheet."""
    drawn = np.column_stack(MAP(longitude, latitude)) * 1e-3
    turn = np.array([[np.cos(TABLE_TURN), -np.sin(TABLE_TURN)], [np.sin(TABLE_TURN), np.cos(TABLE_TURN)]])
    return np.asarray(drawn @ PAPER.T @ turn.T + TABLE_SHIFT_MM)


def write_crosses(folder: Path, random: np.random.Generator) -> None:
    """35 crosses of the graticule of one degree; each is the mean of three readings."""
    parallels, meridians = np.meshgrid(np.arange(SOUTH, NORTH + 1), np.arange(WEST, EAST + 1), indexing="ij")
    latitude, longitude = parallels.ravel().astype(float), meridians.ravel().astype(float)
    noise = random.normal(0.0, SIGMA_DIGITISER_MM / np.sqrt(CYCLES), (len(latitude), 2))
    readings = on_the_table(latitude, longitude) + noise
    rows = (
        (SHEET, f"{B:.0f}-{L:.0f}", f"{X:.3f}", f"{Y:.3f}", f"{B:.0f}", f"{L:.0f}")
        for (X, Y), B, L in zip(readings, latitude, longitude, strict=True)
    )
    write_rows(folder / "crosses.csv", ("sheet", "cross", "X_mm", "Y_mm", "B_deg", "L_deg"), rows)


def write_digitizer(folder: Path, random: np.random.Generator, scene: Scene) -> None:
    """All points in cycles; the height of a point is read from the contours, once."""
    table = on_the_table(scene.geographic[:, 0], scene.geographic[:, 1])
    heights = np.round(scene.geographic[:, 2] + random.normal(0.0, SIGMA_HEIGHT_M, len(table)))
    rows = []
    for cycle in range(1, CYCLES + 1):
        readings = table + random.normal(0.0, SIGMA_DIGITISER_MM, table.shape)
        for name, (X, Y), H in zip(scene.names, readings, heights, strict=True):
            rows.append((SHEET, name, cycle, f"{X:.2f}", f"{Y:.2f}", f"{H:.0f}", f"{SIGMA_HEIGHT_M:.0f}"))
    write_rows(folder / "digitizer.csv", ("sheet", "point", "cycle", "X_mm", "Y_mm", "H_m", "sigma_H_m"), rows)


# ----------------------------------------------------------------------------------------------- the photo


def refracted(ideal: Array) -> Array:
    """The place r from which the correction -K (r + r^3/f^2) leads back to the ideal one."""
    seen = ideal
    for _ in range(20):
        seen = ideal + REFRACTION_K * seen * (1.0 + np.sum(seen**2, axis=1, keepdims=True) / F**2)
    return seen


def distorted(straight: Array) -> Array:
    """The place to which the lens correction has to be added to get the straight one."""
    seen = straight
    for _ in range(50):
        (x, y), r2 = seen.T, np.sum(seen**2, axis=1)
        radial = K1 * r2 + K2 * r2**2
        dx = x * radial + P1 * (r2 + 2.0 * x**2) + 2.0 * P2 * x * y
        dy = y * radial + P2 * (r2 + 2.0 * y**2) + 2.0 * P1 * x * y
        seen = straight - np.column_stack([dx, dy])
    return seen


def write_readings(folder: Path, random: np.random.Generator, scene: Scene) -> None:
    """Marks and points in cycles at the comparator, with one slip."""
    points = distorted(refracted(scene.image)) + np.array([X0, Y0])
    frame = np.vstack([np.array(list(CALIBRATED.values())), points])
    names = [*((mark, "fiducial") for mark in CALIBRATED), *((name, "point") for name in scene.names)]
    comparator = frame @ COMPARATOR.T + COMPARATOR_SHIFT_MM
    rows = []
    for cycle in range(1, CYCLES + 1):
        readings = comparator + random.normal(0.0, SIGMA_COMPARATOR_MM, comparator.shape)
        for (name, kind), (x, y) in zip(names, readings, strict=True):
            slip = SLIP_MM if (name, cycle) == (SLIP_POINT, SLIP_CYCLE) else 0.0
            rows.append((name, kind, cycle, f"{x + slip:.4f}", f"{y:.4f}"))
    write_rows(folder / "readings.csv", ("point", "kind", "cycle", "x_mm", "y_mm"), rows)


# ------------------------------------------------------------------------------------------------ the truth


def truth(scene: Scene) -> dict[str, object]:
    """What the programme should find, and what it could not know."""
    geocentric_from_image = geocentric_from_partner() @ partner_from_image()
    return {
        "station": dict(zip(("X_G_m", "Y_G_m", "Z_G_m"), station().round(4).tolist(), strict=True))
        | {"B_deg": STATION_B, "L_deg": STATION_L, "H_m": STATION_H},
        "origin": {"B_deg": ORIGIN_B, "L_deg": ORIGIN_L, "H_m": ORIGIN_H},
        "gamma_deg": degrees(gamma()),
        "station_in_T_prime_east_north_up_m": in_partner(station()).round(4).tolist(),
        "aok_deg": {"alpha": degrees(ALPHA), "omega": degrees(OMEGA), "kappa": degrees(KAPPA)},
        "geocentric_from_image": geocentric_from_image.round(12).tolist(),
        "geocentric_opk_deg": dict(zip(("omega", "phi", "kappa"), opk_deg(geocentric_from_image), strict=True)),
        "slip": {"point": SLIP_POINT, "cycle": SLIP_CYCLE, "dx_mm": SLIP_MM},
        "points": {
            name: {
                "B_deg": round(B, 9), "L_deg": round(L, 9), "H_m": round(H, 3), "x_mm": round(x, 6), "y_mm": round(y, 6)
            }
            for name, (B, L, H), (x, y) in zip(
                scene.names, scene.geographic.tolist(), scene.image.tolist(), strict=True
            )
        },
    }  # fmt: skip


def degrees(angle: float) -> float:
    return round(float(np.rad2deg(angle)), 9)


def in_partner(place: Array) -> Array:
    """East, north, up of T' of one geocentric place."""
    origin = geocentric(np.array([[ORIGIN_B, ORIGIN_L, ORIGIN_H]]))[0]
    return np.asarray((place - origin) @ geocentric_from_partner())


def opk_deg(ground_from_image: Array) -> list[float]:
    """omega, phi, kappa of M = M_kappa M_phi M_omega = (ground_from_image)'."""
    M = ground_from_image.T
    angles = np.arctan2(-M[2, 1], M[2, 2]), np.arcsin(M[2, 0]), np.arctan2(-M[1, 0], M[0, 0])
    return [degrees(angle) for angle in angles]


def write_rows(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
