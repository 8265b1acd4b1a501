"""What is added to an image coordinate reduced to the principal point: lens distortion, refraction, earth curvature."""

from collections.abc import Sequence

import numpy as np

from orient.errors import OrientError
from orient.geometry import distortion, earth_curvature, refraction
from orient.pipeline.camera import given_camera
from orient.pipeline.tables import Array, number, required
from orient.values import Row, Tables

NO_WAY_BACK_MM = 1e-6
REFRACTION = {
    "integral": refraction.integral_constant,
    "ardc": refraction.ardc_constant,
    "space": refraction.space_constant,
}


def image_corrections(photo: Row, tables: Tables, reduced: Array, names: Sequence[str]) -> tuple[Array, Array, Array]:
    """(n, 2) [mm] of lens, refraction and curvature for `reduced` (n, 2) [mm], by the camera of photo.toml.

    `names` of the points, for messages.
    """
    lens = _lens(given_camera(photo, tables).distortion, reduced, names)
    return lens, *air_and_curvature(reduced + lens, photo)


def air_and_curvature(xy: Array, photo: Row) -> tuple[Array, Array]:
    """(n, 2) corrections for refraction and for earth curvature of `xy` (n, 2), free of distortion [mm]."""
    air = _refraction(xy, photo)
    return air, _curvature(xy + air, photo)


def _lens(camera: distortion.Distortion, reduced: Array, names: Sequence[str]) -> Array:
    """(n, 2) correction that the way back undoes at every point: else the certificate does not hold so far out."""
    lens: Array = distortion.correction(camera, reduced)
    gap = np.linalg.norm(distortion.distort(camera, reduced + lens) - reduced, axis=1)
    worst = int(np.argmax(gap))
    if gap[worst] > NO_WAY_BACK_MM:
        raise OrientError(
            f"point {names[worst]}: the distortion has no inverse there (off by {gap[worst]:.2g} mm)",
            "Check the coefficients of the distortion and their direction in photo.toml.",
        )
    return lens


def _refraction(xy: Array, photo: Row) -> Array:
    """(n, 2) correction for a vertical view; `refraction` tells the formula."""
    model = str(photo["refraction"])
    if model == "none":
        return np.zeros_like(xy)
    height, ground = _heights(photo, "the refraction formulas", '[refraction] model = "none"')
    return np.asarray(refraction.correction(xy, required(photo, "f_mm"), REFRACTION[model](height, ground)))


def _curvature(xy: Array, photo: Row) -> Array:
    """(n, 2) correction for ground that is declared to be a map plane with heights; else zero."""
    radius = number(photo, "curvature_radius_m")
    if radius is None:
        return np.zeros_like(xy)
    if photo["ground_kind"] != "local":
        raise earth_curvature.needs_no_correction(str(photo["ground_kind"]))
    height, ground = _heights(photo, "the formulas of earth curvature", "no [curvature]")
    return earth_curvature.correction(xy, required(photo, "f_mm"), height, ground, radius)


def _heights(photo: Row, what: str, instead: str) -> tuple[float, float]:
    """Heights of the camera and of the ground, for a view from above."""
    if photo["platform"] == "terrestrial":
        raise OrientError(
            f"{what} hold for a view from above, not for a terrestrial photo", f"Write {instead} in photo.toml."
        )
    height = number(photo, "camera_height_m")
    height = number(photo, "station_H_m") if height is None else height
    ground = number(photo, "ground_height_m")
    if height is None or ground is None:
        raise OrientError(
            f"{what} need the heights of the camera and of the ground",
            f"Give camera_height_m and height_m in photo.toml, or {instead}.",
        )
    return height, ground
