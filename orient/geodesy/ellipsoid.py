"""Ellipsoids of rotation: a and 1/f, and the radii of curvature that follow. 1/f = 0 stands for a sphere."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orient.errors import OrientError
from orient.units import NUMBER

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """a [m] and 1/f. e2 = f (2 - f) and ep2 = e'^2 = e2/(1 - e2) follow; both are 0 for a sphere (1/f = 0)."""

    name: str
    a_m: float
    inverse_flattening: float

    @property
    def flattening(self) -> float:
        return 1.0 / self.inverse_flattening if self.inverse_flattening else 0.0

    @property
    def b_m(self) -> float:
        """Semi-minor axis b = a (1 - f) [m]."""
        return self.a_m * (1.0 - self.flattening)

    @property
    def e2(self) -> float:
        """First eccentricity squared, e^2 = f (2 - f)."""
        return self.flattening * (2.0 - self.flattening)

    @property
    def ep2(self) -> float:
        """Second eccentricity squared, e'^2 = e^2/(1 - e^2)."""
        return self.e2 / (1.0 - self.e2)


KRASOVSKY = Ellipsoid("Krasovsky 1940", 6378245.0, 298.3)
WGS84 = Ellipsoid("WGS 84", 6378137.0, 298.257223563)
GRS80 = Ellipsoid("GRS 80", 6378137.0, 298.257222101)
BESSEL = Ellipsoid("Bessel 1841", 6377397.155, 299.1528128)
HAYFORD = Ellipsoid("International 1924 (Hayford)", 6378388.0, 297.0)
CLARKE_1866 = Ellipsoid("Clarke 1866", 6378206.4, 294.978698213898)
CLARKE_1880 = Ellipsoid("Clarke 1880 (RGS)", 6378249.145, 293.465)
EARTH_SPHERE = Ellipsoid("Earth sphere", 6371000.0, 0.0)
MOON = Ellipsoid("Moon (sphere, IAU)", 1737400.0, 0.0)
MARS = Ellipsoid("Mars (IAU 2000)", 3396190.0, 169.894447223612)

FRIENDLY = {
    "krasovsky": KRASOVSKY,
    "krasovsky1940": KRASOVSKY,
    "krasovskij": KRASOVSKY,
    "krassovsky": KRASOVSKY,
    "krassowsky": KRASOVSKY,
    "krassowsky1940": KRASOVSKY,
    "krassowski": KRASOVSKY,
    "krass": KRASOVSKY,
    "wgs84": WGS84,
    "grs80": GRS80,
    "grs1980": GRS80,
    "bessel": BESSEL,
    "bessel1841": BESSEL,
    "hayford": HAYFORD,
    "international": HAYFORD,
    "international1924": HAYFORD,
    "intl": HAYFORD,
    "clarke1866": CLARKE_1866,
    "clrk66": CLARKE_1866,
    "clarke1880": CLARKE_1880,
    "sphere": EARTH_SPHERE,
    "moon": MOON,
    "mars": MARS,
}


def named_ellipsoid(text: str) -> Ellipsoid:
    """The ellipsoid called `text`: a friendly name, a name of PROJ's table, or `a/rf` in metres as `6378245/298.3`.

    Upper and lower case, blanks, `-`, `_` and `.` do not matter; `a/0` is a sphere. An unknown name, or figures that
    are no ellipsoid, raise OrientError.
    """
    numbers = [part.strip() for part in text.split("/")]
    if len(numbers) == 2 and all(NUMBER.fullmatch(part) for part in numbers):
        return checked_ellipsoid(text, float(numbers[0]), float(numbers[1]))
    key = re.sub(r"[\s_.-]", "", text).casefold()
    found = FRIENDLY.get(key) or proj_ellipsoid(key)
    if found is None:
        raise OrientError(
            f'unknown ellipsoid "{text[:60]}"',
            "Write a name such as krasovsky, wgs84, grs80, bessel, moon, mars, or a/rf such as 6378245/298.3.",
        )
    return found


def checked_ellipsoid(name: str, a_m: float, inverse_flattening: float) -> Ellipsoid:
    """Ellipsoid of given figures; OrientError unless 1 km <= a <= 1e9 m and 1/f is 0 (sphere) or at least 2."""
    if not 1e3 <= a_m <= 1e9:
        raise OrientError(f"ellipsoid: the semi-major axis {a_m:g} m is not in 1000 ... 1e9 m", "Give a in metres.")
    if inverse_flattening != 0.0 and not 2.0 <= inverse_flattening <= 1e9:
        raise OrientError(
            f"ellipsoid: the inverse flattening {inverse_flattening:g} is neither 0 nor at least 2",
            "Write 1/f such as 298.3, or 0 for a sphere.",
        )
    return Ellipsoid(name, a_m, inverse_flattening)


def proj_ellipsoid(key: str) -> Ellipsoid | None:
    """The ellipsoid whose short name in PROJ's table is `key` (case does not matter), or None."""
    from pyproj import get_ellps_map

    for name, figures in get_ellps_map().items():
        if name.casefold() == key:
            a = float(figures["a"])
            rf = figures.get("rf")
            b = float(figures.get("b", a))
            inverse = float(rf) if rf is not None else (a / (a - b) if a != b else 0.0)
            return Ellipsoid(str(figures.get("description") or name), a, inverse)
    return None


def prime_vertical_radius(ellipsoid: Ellipsoid, B: ArrayLike) -> Array:
    """N = a / sqrt(1 - e^2 sin^2 B) [m], B (n,) in radians (exact; the paper's polynomial is within 0.22 mm of it)."""
    s = np.sin(np.asarray(B, dtype=np.float64)) ** 2
    result: Array = ellipsoid.a_m / np.sqrt(1.0 - ellipsoid.e2 * s)
    return result


def prime_vertical_polynomial(ellipsoid: Ellipsoid, B: ArrayLike) -> Array:
    """N = ((0.605 s + 107.155) s + 21346.142) s + 6378245 [m], s = sin^2 B, B (n,) in radians: the historical value.

    The coefficients are those of the Krasovsky ellipsoid; any other raises OrientError. At most 0.22 mm (at the pole)
    from the exact N. Source: seed 004.
    """
    if (ellipsoid.a_m, ellipsoid.inverse_flattening) != (KRASOVSKY.a_m, KRASOVSKY.inverse_flattening):
        raise OrientError(
            f"the polynomial of N holds for the Krasovsky ellipsoid only, not for {ellipsoid.name}",
            "Take the exact radius: orient topocentric PROJECT --radius exact",
        )
    s = np.sin(np.asarray(B, dtype=np.float64)) ** 2
    result: Array = ((0.605 * s + 107.155) * s + 21346.142) * s + 6378245.0
    return result


def meridian_radius(ellipsoid: Ellipsoid, B: ArrayLike) -> Array:
    """M = a (1 - e^2) / (1 - e^2 sin^2 B)^(3/2) [m], B (n,) in radians."""
    s = np.sin(np.asarray(B, dtype=np.float64)) ** 2
    result: Array = ellipsoid.a_m * (1.0 - ellipsoid.e2) / (1.0 - ellipsoid.e2 * s) ** 1.5
    return result
