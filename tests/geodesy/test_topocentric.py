from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Geod, Transformer

from orient.geodesy import topocentric
from orient.geodesy.convergence import convergence
from orient.geodesy.ellipsoid import KRASOVSKY, MOON, WGS84, Ellipsoid, prime_vertical_polynomial
from orient.geodesy.topocentric import (
    Origin,
    geocentric_from_geographic,
    geographic_from_geocentric,
    geographic_from_topocentric,
    horizon_axes,
    topocentric_from_geographic,
    turn_from_grid,
    turn_to_grid,
)
from tests.jacobian import central_difference

ELLIPSOIDS = [KRASOVSKY, WGS84, MOON]


def proj_figure(ellipsoid):
    rf = ellipsoid.inverse_flattening
    return f"+a={ellipsoid.a_m} +rf={rf}" if rf else f"+R={ellipsoid.a_m}"


def proj_topocentric(B, L, H, origin, ellipsoid):
    """PROJ's cart + topocentric, put into the order north, east, up."""
    figure = proj_figure(ellipsoid)
    lat, lon = (float(angle) for angle in np.degrees([origin.B, origin.L]))
    at = f"+lat_0={lat!r} +lon_0={lon!r} +h_0={origin.H!r}"
    transformer = Transformer.from_pipeline(
        f"+proj=pipeline +step +proj=cart {figure} +step +proj=topocentric {figure} {at}"
    )
    east, north, up = transformer.transform(L, B, H, radians=True)
    return np.column_stack([north, east, up])


def test_the_vector_of_the_equations():
    """EQUATIONS 4.1, all digits."""
    origin = Origin(*np.radians([42.7, 23.0]), 500.0)
    T = topocentric_from_geographic(*np.radians([[43.7], [24.0]]), [100.0], origin, KRASOVSKY)
    np.testing.assert_allclose(T, [[111571.7073569, 80607.7406868, -1886.5146518]], rtol=0, atol=6e-8)
    gamma = float(convergence(origin.B, origin.L, np.radians(21.0), KRASOVSKY))
    assert np.degrees(gamma) == pytest.approx(1.356620170358, abs=2e-9)
    T_grid = turn_to_grid(T, np.radians(1.356620170358))
    np.testing.assert_allclose(T_grid, [[113448.8444978, 77943.6554395, -1886.5146518]], rtol=0, atol=6e-7)


@pytest.mark.parametrize(
    ("B_N", "errors"),
    [
        # largest error of the N polynomial [m] at 50, 100, 200, 300 km (EQUATIONS 4.1)
        (0.0, [1e-9, 1e-9, 2e-8, 5e-8]),
        (30.0, [2e-7, 5e-7, 1e-6, 2e-6]),
        (42.7, [6e-7, 1e-6, 2e-6, 3e-6]),
        (60.0, [5e-7, 1e-6, 2e-6, 4e-6]),
        (80.0, [2e-6, 3e-6, 7e-6, 1e-5]),
    ],
)
def test_the_table_of_the_N_polynomial(B_N, errors):
    """24 azimuths, heights 0, 1500, 3000 m, H_N 0, 500, 2000 m; the table has one digit."""
    for km, error in zip((50.0, 100.0, 200.0, 300.0), errors, strict=True):
        L, B, _ = Geod(ellps="krass").fwd(
            np.full(24, 23.0), np.full(24, B_N), np.arange(24) * 15.0, np.full(24, km * 1e3)
        )
        found = 0.0
        for H_N, H in product((0.0, 500.0, 2000.0), (0.0, 1500.0, 3000.0)):
            given = (np.radians(B), np.radians(L), H, Origin(np.radians(B_N), np.radians(23.0), H_N), KRASOVSKY)
            difference = topocentric_from_geographic(*given, prime_vertical_polynomial) - topocentric_from_geographic(
                *given
            )
            found = max(found, float(np.max(np.abs(difference))))
        assert found == pytest.approx(error, rel=0.51, abs=1e-9)


def test_iogp_geographic_to_topocentric():
    """IOGP 373-7-2 (RELIABILITY 8.2): east, north, up of the guidance note, WGS 84."""
    origin = Origin(*np.radians([55.0, 5.0]), 200.0)
    T = topocentric_from_geographic(*np.radians([[53.80939444444444], [2.12955]]), [73.0], origin, WGS84)
    np.testing.assert_allclose(T, [[-128642.040, -189013.869, -4220.171]], rtol=0, atol=1e-3)


def test_iogp_geocentric_to_topocentric():
    origin = Origin(*geographic_from_geocentric([3652755.3058, 319574.6799, 5201547.3536], WGS84))
    B, L, H = geographic_from_geocentric([3771793.968, 140253.342, 5124304.349], WGS84)
    T = topocentric_from_geographic(B, L, H, origin, WGS84)
    np.testing.assert_allclose(T, [-128642.040, -189013.869, -4220.171], rtol=0, atol=1e-3)


@pytest.mark.parametrize("ellipsoid", ELLIPSOIDS, ids=lambda e: e.name)
@pytest.mark.parametrize("B_N", [-90, -89.999, -60, -1, 0, 30, 42.7, 80, 89.5, 90])
@pytest.mark.parametrize("L_N", [0.0, 23.0, 179.9, -180.0])
@pytest.mark.parametrize("H_N", [0.0, 500.0, 300e3])
def test_agrees_with_proj(ellipsoid, B_N, L_N, H_N):
    origin = Origin(float(np.radians(B_N)), float(np.radians(L_N)), H_N)
    azimuth, distance = (grid.ravel() for grid in np.meshgrid(np.linspace(0, 6.0, 12), [0.0, 50e3, 300e3, 2e6]))
    dB = distance / ellipsoid.a_m * np.cos(azimuth)
    B = np.clip(origin.B + dB, -np.pi / 2, np.pi / 2)
    spread = np.maximum(np.cos(B), 0.05)
    L = np.remainder(origin.L + distance / ellipsoid.a_m * np.sin(azimuth) / spread + np.pi, 2 * np.pi) - np.pi
    H = np.resize([0.0, 1500.0, 300e3, -300.0], len(B))
    T = topocentric_from_geographic(B, L, H, origin, ellipsoid)
    np.testing.assert_allclose(T, proj_topocentric(B, L, H, origin, ellipsoid), rtol=0, atol=1e-7)
    back = geographic_from_topocentric(T, origin, ellipsoid)
    again = topocentric_from_geographic(*back.T, origin, ellipsoid)
    np.testing.assert_allclose(again, T, rtol=0, atol=2e-8)
    np.testing.assert_allclose(back[:, 0], B, rtol=0, atol=1e-14)
    np.testing.assert_allclose(back[:, 2], H, rtol=0, atol=1e-8)


latitude, longitude = st.floats(-np.pi / 2, np.pi / 2), st.floats(-np.pi, np.pi)


@pytest.mark.parametrize("ellipsoid", ELLIPSOIDS, ids=lambda e: e.name)
@given(latitude, longitude, st.floats(-11e3, 4e7))
def test_geocentric_round_trip(ellipsoid, B, L, H):
    XYZ = geocentric_from_geographic(B, L, H, ellipsoid)
    back = geographic_from_geocentric(XYZ, ellipsoid)
    assert back[0] == pytest.approx(B, abs=3e-15)
    assert back[2] == pytest.approx(H, abs=2e-8)
    np.testing.assert_allclose(geocentric_from_geographic(*back, ellipsoid), XYZ, rtol=0, atol=3e-8)


@pytest.mark.parametrize("steps", [1, topocentric.LATITUDE_STEPS], ids=["one round", "all rounds"])
@pytest.mark.parametrize("H", [-1e4, 0.0, 3e3, 9e3])
def test_one_round_is_enough_near_the_earth(H, steps, monkeypatch):
    """Within 4 ulp of the Earth's radius."""
    monkeypatch.setattr(topocentric, "LATITUDE_STEPS", steps)
    B = np.concatenate([np.linspace(-np.pi / 2, np.pi / 2, 1001), [1e-9, -1e-9]])
    XYZ = geocentric_from_geographic(B, 0.3, H, WGS84)
    back = geographic_from_geocentric(XYZ, WGS84)
    np.testing.assert_allclose(back[:, 2], H, rtol=0, atol=4e-9)
    np.testing.assert_allclose(geocentric_from_geographic(*back.T, WGS84), XYZ, rtol=0, atol=4e-9)


@pytest.mark.parametrize("inverse_flattening", [2.0, 5.0, 20.0])
@pytest.mark.parametrize("H", [-1e4, 0.0, 1e5, 4e7])
def test_very_flat_bodies_too(H, inverse_flattening):
    body = Ellipsoid("flat", 6e6, inverse_flattening)
    B = np.linspace(-np.pi / 2, np.pi / 2, 1001)
    XYZ = geocentric_from_geographic(B, -2.0, H, body)
    back = geographic_from_geocentric(XYZ, body)
    np.testing.assert_allclose(geocentric_from_geographic(*back.T, body), XYZ, rtol=0, atol=4e-8)


@pytest.mark.parametrize("dB", [1e-12, 1e-6, 1e-3, 0.3, np.pi - 1e-9])
def test_small_and_large_differences_keep_their_digits(dB):
    """Along the meridian of a sphere: X = R sin dB, Z = -R (1 - cos dB) to 4 ulp."""
    origin = Origin(-np.pi / 2, 0.0, 0.0)
    T = topocentric_from_geographic(origin.B + dB, 0.0, 0.0, origin, MOON)
    dB = (origin.B + dB) - origin.B
    expected = MOON.a_m * np.array([np.sin(dB), 0.0, -2.0 * np.sin(dB / 2.0) ** 2])
    np.testing.assert_allclose(T, expected, rtol=1e-15, atol=4e-16 * MOON.a_m * min(dB, 1.0))


@pytest.mark.parametrize("ellipsoid", ELLIPSOIDS, ids=lambda e: e.name)
@pytest.mark.parametrize("shape", [(0,), (), (1,), (3, 7), (topocentric.POINTS_AT_ONCE + 700,)], ids=str)
def test_compiled_coordinates_are_those_of_numpy(shape, ellipsoid):
    """To the last bit; columns of a table, one place NaN; the historical radius is numpy's."""
    pytest.importorskip("numba", reason="numba is not installed: orient[fast]")
    table = np.random.default_rng(len(shape)).uniform([-1.5, -4.0, -400.0], [1.5, 4.0, 9000.0], (*shape, 3))
    table.reshape(-1, 3)[2:3, 1] = np.nan
    B, L, H = np.moveaxis(table, -1, 0)
    given = B, L, H, Origin(0.7, -2.0, 300.0), ellipsoid
    plain, compiled = (topocentric_from_geographic(*given, compiled=choice) for choice in (False, True))
    assert compiled.shape == (*shape, 3)
    np.testing.assert_array_equal(compiled, plain)
    given = B, L, 0.0, Origin(0.7, -2.0, 300.0), KRASOVSKY, prime_vertical_polynomial
    plain, compiled = (topocentric_from_geographic(*given, compiled=choice) for choice in (False, True))
    np.testing.assert_array_equal(compiled, plain)


def test_the_origin_is_the_origin():
    origin = Origin(0.7, 3.0, 1234.5)
    np.testing.assert_array_equal(topocentric_from_geographic(0.7, 3.0, 1234.5, origin, WGS84), 0.0)
    np.testing.assert_array_equal(topocentric_from_geographic(0.7, 3.0, 1244.5, origin, WGS84), [0, 0, 10])


def test_axes_are_north_east_up():
    origin = Origin(0.7, 0.3, 0.0)
    T = topocentric_from_geographic([0.7001, 0.7, 0.7], [0.3, 0.3001, 0.3], [0, 0, 9], origin, WGS84)
    assert (np.argmax(np.abs(T), axis=1) == [0, 1, 2]).all()
    assert (np.diag(T) > 0).all()


@pytest.mark.parametrize("seed", range(4))
def test_horizon_axes_are_the_derivatives_of_T(seed):
    random = np.random.default_rng(seed)
    origin = Origin(0.6, 0.4, 100.0)
    B, L, H = random.uniform([-1.2, -3.0, -100.0], [1.2, 3.0, 3000.0])
    from orient.geodesy.ellipsoid import meridian_radius, prime_vertical_radius

    numeric = central_difference(
        lambda e: topocentric_from_geographic(e[0], e[1], e[2], origin, WGS84), [B, L, H], [1e-6, 1e-6, 10.0]
    )
    arms = np.array(
        [meridian_radius(WGS84, B) + H, (prime_vertical_radius(WGS84, B) + H) * np.cos(B), 1.0], dtype=float
    )
    A = horizon_axes([B], [L], origin)
    assert A.shape == (1, 3, 3)
    np.testing.assert_allclose(A[0] * arms, numeric, rtol=1e-7, atol=0.1)
    np.testing.assert_allclose(A[0] @ A[0].T, np.eye(3), atol=1e-15)


def test_horizon_of_the_origin_is_T():
    origin = Origin(0.6, 0.4, 100.0)
    np.testing.assert_allclose(horizon_axes(0.6, 0.4, origin), np.eye(3), atol=1e-15)


def test_turning_there_and_back():
    T = np.random.default_rng(3).normal(size=(5, 3))
    np.testing.assert_allclose(turn_from_grid(turn_to_grid(T, 0.3), 0.3), T, atol=1e-15)
