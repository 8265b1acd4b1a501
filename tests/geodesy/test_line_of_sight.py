"""Lines that meet a height: the points they were drawn to are found again, the sky is not."""

import numpy as np
import pytest

from orient.geodesy.ellipsoid import KRASOVSKY
from orient.geodesy.line_of_sight import line_at_height
from orient.geodesy.topocentric import geocentric_from_geographic, local_axes

B, L = np.radians([42.7, 23.0])
STATION = geocentric_from_geographic(B, L, 250e3, KRASOVSKY)


@pytest.mark.parametrize("height", [0.0, 800.0, 5000.0])
def test_points_of_a_height_are_met(height: float) -> None:
    """Within 5 km f^2 = 0.06 m along a ray that runs 20 degrees off the nadir or more."""
    random = np.random.default_rng(3)
    places = np.radians([42.7, 23.0]) + np.radians(random.uniform(-1.5, 1.5, (20, 2)))
    points = geocentric_from_geographic(*places.T, np.full(20, height), KRASOVSKY)
    met = line_at_height(STATION, 3.0 * (points - STATION), KRASOVSKY, height)
    np.testing.assert_allclose(met, points, atol=0.05)


def test_the_near_side_is_met_and_the_sky_is_not() -> None:
    north, east, up = local_axes(B, L).T
    below, beside, above = line_at_height(STATION, np.array([-up, 0.1 * up + north, up + east]), KRASOVSKY, 100.0)
    np.testing.assert_allclose(below, STATION - 249_900.0 * up, atol=1e-3)
    assert np.isnan(beside).all()
    assert np.isnan(above).all()
