"""Atmospheric refraction: the image stands dr = +K (r + r^3/f^2) too far out; correction = -K x (1 + r^2/f^2).

K [rad] is the refraction at 45 degrees from the nadir: apparent - true nadir angle = K tan(nadir angle). Near-vertical
photos of the Earth only. H = camera, h = ground, metres above sea level. EQUATIONS 5.1. Schut's formula is not offered:
it is made for aerial photos, negative above 25 km, and below 10 km it says what the integral says.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import GeometryError

Array = NDArray[np.float64]

SEA_LEVEL_REFRACTIVITY = 2.778e-4
"""n - 1 at 0.55 um, 15 C, 1013.25 hPa."""
EARTH_RADIUS_M = 6_356_766.0
TOP_M = 86_000.0
GRAVITY_CONSTANT = 9.80665 * 0.0289644 / 8.31432
"""g0 M0 / R* [K/m]."""
LAYERS = (
    # base [geopotential m], base temperature [K], lapse rate [K/m]: U.S. Standard Atmosphere 1976, table 4
    (0.0, 288.15, -0.0065),
    (11_000.0, 216.65, 0.0),
    (20_000.0, 216.65, 0.001),
    (32_000.0, 228.65, 0.0028),
    (47_000.0, 270.65, 0.0),
    (51_000.0, 270.65, -0.0028),
    (71_000.0, 214.65, -0.002),
)
SPACE_COLUMN_M = 2.35
"""INT (n - 1) dz from the sea to space, as rounded in the formula for space photos."""
SPACE_FROM_M = 80_000.0
NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)


def integral_constant(H_m: float, h_m: float) -> float:
    """K = (1/(H-h)) INT_h^H (n(z) - n(H)) dz [rad], n of the U.S. Standard Atmosphere 1976, any camera height.

    H_m, h_m: camera and ground above sea level [m]. Flat layers; above 86 km n = 1. Derived from Snell's law; the
    rigorous spherical form is Gyer, PE&RS 62(3), 1996, 301-310. A camera not above the ground raises GeometryError.
    """
    require_camera_above_ground(H_m, h_m)
    column = refractivity_column(h_m, H_m)
    at_camera = float(refractivity(np.array([H_m]))[0])
    return column / (H_m - h_m) - at_camera


def ardc_constant(H_m: float, h_m: float) -> float:
    """K = [2410 H/(H^2 - 6H + 250) - (2410 h/(h^2 - 6h + 250)) h/H] 1e-6 [rad], H and h in km (given here in m).

    ARDC model atmosphere 1959, as the Manual of Photogrammetry (1980) prints it. Up to 20 % from the integral when
    the ground is high or the flight low. A camera not above the ground or not above the sea raises GeometryError.
    """
    require_camera_above_ground(H_m, h_m)
    if H_m <= 0.0:
        raise GeometryError(
            f"refraction: the ARDC formula needs a camera above the sea, {H_m:.1f} m is not",
            "Choose the refraction 'integral' or 'none'.",
        )
    H, h = H_m / 1000.0, h_m / 1000.0
    return (2410.0 * H / (H * H - 6.0 * H + 250.0) - 2410.0 * h / (h * h - 6.0 * h + 250.0) * h / H) * 1e-6


def space_constant(H_m: float, h_m: float) -> float:
    """K = 2.35 m (p(h)/p(0))/(H - h) [rad], p the pressure of the U.S. Standard Atmosphere 1976: above the air only.

    What is left of the integral when no air is above the camera: the column below weighs p(h). A camera at 80 km or
    below, or not above the ground, raises GeometryError.
    """
    require_camera_above_ground(H_m, h_m)
    if H_m <= SPACE_FROM_M:
        raise GeometryError(
            f"refraction: the formula for space photos holds above {SPACE_FROM_M / 1e3:.0f} km, not at {H_m:.1f} m",
            "Choose the refraction 'integral', which serves every height.",
        )
    return SPACE_COLUMN_M * relative_pressure(h_m) / (H_m - h_m)


def correction(xy: ArrayLike, f_mm: float, K: float) -> Array:
    """-K x (1 + r^2/f^2), -K y (1 + r^2/f^2): (n, 2) mm to ADD to xy (n, 2) mm, towards the principal point."""
    image = np.asarray(xy, dtype=np.float64)
    r2 = np.sum(image * image, axis=-1, keepdims=True)
    result: Array = -K * image * (1.0 + r2 / f_mm**2)
    return result


def require_camera_above_ground(H_m: float, h_m: float) -> None:
    if not H_m > h_m:
        raise GeometryError(
            f"refraction: the camera ({H_m:.1f} m) is not above the ground ({h_m:.1f} m)",
            "Correct the two heights in photo.toml, or choose the refraction 'none'.",
        )


def refractivity(z_m: Array) -> Array:
    """n - 1 at geometric heights z (n,) [m]: 2.778e-4 rho(z)/rho(0); zero above 86 km."""
    pressure, kelvin = relative_pressure_and_temperature(z_m)
    return np.asarray(SEA_LEVEL_REFRACTIVITY * pressure * LAYERS[0][1] / kelvin)


def relative_pressure(z_m: float) -> float:
    """p(z)/p(0) at a geometric height [m]; 0.887 at 1 km, zero above 86 km."""
    return float(relative_pressure_and_temperature(np.array([z_m]))[0][0])


def relative_pressure_and_temperature(z_m: Array) -> tuple[Array, Array]:
    """p(z)/p(0), zero above 86 km, and T [K] at geometric heights z (n,) [m]."""
    inside_air = np.minimum(z_m, TOP_M)
    geopotential = EARTH_RADIUS_M * inside_air / (EARTH_RADIUS_M + inside_air)
    result, temperatures = np.zeros_like(z_m), np.zeros_like(z_m)
    pressure = 1.0
    for index, (base, temperature, lapse) in enumerate(LAYERS):
        first, last = index == 0, index == len(LAYERS) - 1
        top = np.inf if last else LAYERS[index + 1][0]
        inside = ((geopotential >= base) | first) & (geopotential < top)
        ratio, temperatures[inside] = pressure_ratio(geopotential[inside] - base, temperature, lapse)
        result[inside] = pressure * ratio
        if not last:
            pressure *= float(pressure_ratio(np.array([top - base]), temperature, lapse)[0][0])
    return np.where(z_m > TOP_M, 0.0, result), temperatures


def pressure_ratio(rise: Array, temperature: float, lapse: float) -> tuple[Array, Array]:
    """p/p_base and T [K] at `rise` geopotential metres above the base of a layer (barometric formula)."""
    kelvin = temperature + lapse * rise
    if lapse == 0.0:
        return np.exp(-GRAVITY_CONSTANT * rise / temperature), kelvin
    return (temperature / kelvin) ** (GRAVITY_CONSTANT / lapse), kelvin


def refractivity_column(h_m: float, H_m: float) -> float:
    """INT_h^H (n - 1) dz [m], by Gauss-Legendre of 16 nodes layer by layer."""
    bounds = [EARTH_RADIUS_M * base / (EARTH_RADIUS_M - base) for base, _, _ in LAYERS[1:]] + [TOP_M]
    top = max(h_m, min(H_m, TOP_M))
    edges = [h_m, *(edge for edge in bounds if h_m < edge < top), top]
    total = 0.0
    for lower, upper in pairwise(edges):
        half = 0.5 * (upper - lower)
        total += half * float(WEIGHTS @ refractivity(lower + half * (1.0 + NODES)))
    return total
