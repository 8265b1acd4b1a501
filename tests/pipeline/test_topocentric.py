"""Stage `topocentric` against PROJ, and the covariance against differences."""

import numpy as np
import pytest
from pyproj import Proj, Transformer

from orient.geodesy.ellipsoid import meridian_radius, prime_vertical_radius
from orient.pipeline.ground import ground_of
from orient.values import Row
from tests.jacobian import central_difference
from tests.pipeline.made import (
    Array,
    Place,
    frame_in,
    framed,
    geographic_rows,
    local,
    matrix_of,
    photo,
    places,
    random,
)

STATION = {"station_B_deg": 41.7, "station_L_deg": 22.3}
PROJ = (
    "+proj=pipeline +step +proj=unitconvert +xy_in=deg +xy_out=rad +step +proj=cart +ellps=WGS84 "
    "+step +proj=topocentric +ellps=WGS84 +lat_0=41.7 +lon_0=22.3 +h_0=500"
)


def axes(row: Row, *names: str) -> Array:
    return np.array([row[name] for name in names], dtype=float)


def test_t_is_proj_s_topocentric_with_the_axes_exchanged() -> None:
    chosen = places(8, "proj")
    rows = framed(photo(**STATION), geographic_rows(chosen))["topocentric_point"]
    proj = Transformer.from_pipeline(PROJ)
    for place, found in zip(chosen, rows, strict=True):
        B, L, H = place.seen
        east, north, up = proj.transform(L, B, H)
        assert axes(found, "X_T_m", "Y_T_m", "Z_T_m") == pytest.approx([north, east, up], abs=1e-6)
        assert axes(found, "X_m", "Y_m", "Z_m") == pytest.approx([north, east, up], abs=1e-6)  # gamma is 0


def test_t_prime_is_turned_to_grid_north() -> None:
    tables = framed(photo(**STATION, central_meridian_deg=21.0), geographic_rows(places(4, "gamma")))
    (frame,) = tables["topocentric_frame"]
    grid = Proj("+proj=tmerc +lon_0=21 +ellps=WGS84")
    assert frame["gamma_deg"] == pytest.approx(grid.get_factors(22.3, 41.7).meridian_convergence, abs=1e-7)
    gamma = np.radians(float(frame["gamma_deg"]))  # type: ignore[arg-type]
    grid_north = np.array([np.cos(gamma), np.sin(gamma)])
    grid_east = np.array([-np.sin(gamma), np.cos(gamma)])
    for found in tables["topocentric_point"]:
        in_t = axes(found, "X_T_m", "Y_T_m")
        assert axes(found, "X_m", "Y_m") == pytest.approx([in_t @ grid_north, in_t @ grid_east], abs=1e-6)
        assert found["Z_m"] == found["Z_T_m"]


def test_covariance_turns_from_the_point_s_horizon_to_t_prime() -> None:
    A = random("covariance").normal(size=(3, 3))
    covariance = A @ A.T
    place = Place("P", (44.0, 25.0, 900.0), (44.0, 25.0, 900.0), covariance=covariance)
    facts = photo(**STATION, central_meridian_deg=21.0)
    tables = framed(facts, geographic_rows([place]))
    frame, figure = frame_in(facts, tables), ground_of(facts["photo"][0]).figure
    B, L = np.radians(place.seen[:2])
    M, N = float(meridian_radius(figure, B)) + 900.0, float(prime_vertical_radius(figure, B)) + 900.0

    def t_prime(step: Array) -> Array:
        north, east, up = step
        latitude, longitude = np.array([B + north / M]), np.array([L + east / (N * np.cos(B))])
        return np.asarray(frame.from_geographic(latitude, longitude, np.array([900.0 + up]))[0])

    J = central_difference(t_prime, np.zeros(3), 10.0)
    (found,) = tables["topocentric_point"]
    assert matrix_of(found) == pytest.approx(J @ covariance @ J.T, rel=1e-6, abs=1e-6)
    assert axes(found, "up_X", "up_Y", "up_Z") == pytest.approx(J[:, 2], abs=1e-9)


@pytest.mark.parametrize("handedness", ["right", "left"])
def test_local_points_pass_through(handedness: str) -> None:
    given = (1.0, 2.0, 3.0)
    tables = framed(local(handedness), geographic_rows([Place("P", given, given)], is_local=True))
    (frame,), (found,) = tables["topocentric_frame"], tables["topocentric_point"]
    assert frame["kind"] == f"local_{handedness}"
    assert axes(found, "X_m", "Y_m", "Z_m").tolist() == axes(found, "X_T_m", "Y_T_m", "Z_T_m").tolist() == [1, 2, 3]


def test_what_is_known_of_a_point_is_said() -> None:
    whole, plan, height = places(3, "known")
    (B, L, _), (_, _, H) = plan.seen, height.seen
    chosen = [whole, Place("plan", (B, L, None), plan.seen), Place("height", (None, None, H), height.seen)]
    rows = framed(photo(**STATION), geographic_rows(chosen))["topocentric_point"]
    assert [row["known"] for row in rows] == ["XYZ", "plan", "height"]


def test_the_date_line_does_no_harm() -> None:
    both = [Place("W", (0.0, 179.9, 0.0), (0.0, 179.9, 0.0)), Place("E", (0.0, -179.9, 0.0), (0.0, -179.9, 0.0))]
    rows = framed(photo(), geographic_rows(both))["topocentric_point"]
    east = [float(row["Y_m"]) for row in rows]  # type: ignore[arg-type]
    assert east == pytest.approx([-11131.9, 11131.9], rel=1e-3)
