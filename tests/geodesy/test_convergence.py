import numpy as np
import pytest
from pyproj import Proj, Transformer

from orient.geodesy.convergence import convergence
from orient.geodesy.ellipsoid import KRASOVSKY, MOON, WGS84, Ellipsoid
from orient.geodesy.topocentric import Origin, topocentric_from_geographic, turn_to_grid

SECOND = np.pi / 180 / 3600


def rigorous(B_deg, l_deg, ellipsoid):
    """PROJ's exact transverse Mercator [rad]."""
    rf = ellipsoid.inverse_flattening
    figure = {"a": ellipsoid.a_m, "rf": rf} if rf else {"R": ellipsoid.a_m}
    factors = Proj(proj="tmerc", lon_0=0, algo="poder_engsager", **figure).get_factors(l_deg, B_deg)
    return np.radians(factors.meridian_convergence)


TABLE = [
    # B deg: printed formula minus rigorous ["], l = 1, 2, 3, 4.5, 6, 9, 12 deg (EQUATIONS 4.2)
    (20, [0, 3e-6, 1.0e-5, 2.5e-5, 1.9e-5, -5.4e-4, -4.5e-3]),
    (42.7, [0, 3e-6, 9e-6, 2.9e-5, 6.4e-5, 1.2e-4, -2.9e-4]),
    (55, [0, 1e-6, 4e-6, 1.4e-5, 3.4e-5, 1.1e-4, 2.2e-4]),
    (70, [0, 0, 1e-6, 2e-6, 5e-6, 1.6e-5, 3.3e-5]),
]
LONGITUDES = [1, 2, 3, 4.5, 6, 9, 12]


def printed(B, l):
    """The formula with the constants as the paper prints them."""
    c2 = np.cos(B) ** 2
    return np.arctan((((l**2 + 0.0045) * c2 + 1) * 0.00674 * l**3 * c2**2 + np.tan(l)) * np.sin(B))


@pytest.mark.parametrize(("B", "errors"), TABLE)
def test_the_table_of_the_equations(B, errors):
    for l, error in zip(LONGITUDES, errors, strict=True):
        exact = rigorous(B, l, KRASOVSKY)
        as_printed = printed(np.radians(B), np.radians(l))
        ours = float(convergence(np.radians(B), np.radians(l), 0.0, KRASOVSKY))
        assert (as_printed - exact) / SECOND == pytest.approx(error, abs=3e-6 + 0.02 * abs(error))
        # with e'^2 in full digits the formula promises this
        assert abs(ours - exact) / SECOND < (1e-4 if l <= 6 else 0.006)


def test_the_value_of_the_equations():
    assert float(convergence(np.radians(42.7), np.radians(23.0), np.radians(21.0), KRASOVSKY)) / SECOND == (
        pytest.approx(4883.832613, abs=5e-6)
    )


@pytest.mark.parametrize("ellipsoid", [WGS84, Ellipsoid("flat", 6e6, 150.0), MOON], ids=lambda e: e.name)
def test_other_ellipsoids(ellipsoid):
    for B in (-50, 10, 60):
        for l in (-3, 2):
            ours = float(convergence(np.radians(B), np.radians(l), 0.0, ellipsoid))
            assert ours == pytest.approx(rigorous(B, l, ellipsoid), abs=1e-4 * SECOND)


def test_across_the_date_line():
    west, east = convergence(0.7, np.radians([-179.0, 181.0]), np.radians(177.0), KRASOVSKY)
    assert west == pytest.approx(east, abs=1e-15)
    assert west > 0


def test_a_step_along_grid_north_is_a_step_along_the_first_axis_of_the_grid_system():
    """The turn sense: 10 m along grid north, east of the central meridian."""
    grid = Transformer.from_pipeline("+proj=tmerc +lon_0=21 +ellps=krass")
    L, B = np.radians([24.0, 42.7])
    E, N = grid.transform(L, B, radians=True)
    there = grid.transform([E, E], [N, N + 10.0], radians=True, direction="INVERSE")
    T = topocentric_from_geographic(there[1], there[0], 0.0, Origin(B, L, 0.0), KRASOVSKY)
    gamma = float(convergence(B, L, np.radians(21.0), KRASOVSKY))
    assert gamma > 0
    assert T[1, 1] > 0.3  # grid north lies east of true north
    step = turn_to_grid(T, gamma)[1]
    assert step[0] == pytest.approx(10.0, abs=0.01)
    assert abs(step[1]) < 1e-4
