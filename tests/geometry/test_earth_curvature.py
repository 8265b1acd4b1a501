"""The correction for control on a map plane, against the sphere itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orient.errors import GeometryError
from orient.geometry import earth_curvature
from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_aok
from orient.solvers.resection import resect

R = 6_371_000.0
UP = np.array([0.0, 0.0, 1.0])


def test_its_length_is_the_formula_and_it_points_outward():
    xy = np.array([[60.0, -80.0], [0.0, 0.0]])
    found = earth_curvature.correction(xy, 150.0, 6000.0, 500.0, R)
    np.testing.assert_allclose(np.linalg.norm(found[0]), 5500.0 * 100.0**3 / (2 * R * 150.0**2), rtol=1e-14)
    np.testing.assert_allclose(found[0] / xy[0], np.full(2, found[0, 0] / 60.0), rtol=1e-14)
    assert found[0, 0] > 0.0
    np.testing.assert_array_equal(found[1], 0.0)


def test_the_numbers_of_a_space_photo():
    """EQUATIONS 5.3: at r = 127 mm (90, 90) the formula gives 1.0114 mm, the reduction to the arc length 1.0415 mm."""
    H, f, xy = 250e3, 200.0, np.array([[90.0, 90.0]])
    r = float(np.linalg.norm(xy))
    nadir = np.arctan(r / f)
    along = (R + H) * np.cos(nadir) - np.sqrt(R**2 - ((R + H) * np.sin(nadir)) ** 2)
    arc = R * np.arcsin(along * np.sin(nadir) / R)
    assert f * arc / H - r == pytest.approx(1.0415, abs=5e-5)
    assert np.linalg.norm(earth_curvature.correction(xy, f, H, 0.0, R)) == pytest.approx(1.0114, abs=5e-5)


@given(st.floats(1.0, 115.0), st.floats(0.0, 2 * np.pi), st.floats(1500.0, 9000.0), st.floats(-0.03, 0.03))
def test_an_aerial_photo_of_the_sphere_becomes_one_of_the_map(r, azimuth, H, relief):
    """Vertical photo: image of the point of the sphere, corrected, is the image of its map position at its height."""
    f, h = 152.0, relief * H
    angle = r * (H - h) / f / (R + h)  # the arc at the height of the ground is r (H - h)/f
    direction = np.array([[np.cos(azimuth), np.sin(azimuth)]])
    image = f * (R + h) * np.sin(angle) / (R + H - (R + h) * np.cos(angle)) * direction
    corrected = image + earth_curvature.correction(image, f, H, h, R)
    first_order = np.linalg.norm(image - r * direction)
    assert np.linalg.norm(corrected - r * direction) < 0.005 * first_order + 1e-9


def test_what_it_does_to_a_space_photo_with_cartesian_control():
    """EQUATIONS 5.3: sigma0 0 -> 78 um, camera moved by 175, 272 and -1008 m (f 0.2 m, H 252 km, r <= 105 mm).

    The tilts are not printed; with these the scene agrees with all five numbers.
    """
    grid = 88_000.0 * np.array([(x, y) for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)])
    ground = np.column_stack([grid, -np.sum(grid**2, axis=1) / (2 * R)])
    station, rotation = np.array([0.0, 0.0, 252_000.0]), matrix_from_aok(*np.radians([-0.8, -1.24, 17.0]))
    image, _ = project(ground, station, rotation, 200.0)
    assert np.max(np.linalg.norm(image, axis=1)) == pytest.approx(105.0, abs=1.0)
    wrong = image + earth_curvature.correction(image, 200.0, 252_000.0, 500.0, R)
    unit = np.tile(np.eye(2), (9, 1, 1))
    before, after = (resect(xy, unit, ground, 200.0, camera_above=UP) for xy in (image, wrong))
    assert 1e3 * np.sqrt(before.vPv / 12) < 1e-6
    assert before.station == pytest.approx(station, abs=1e-3)
    assert 1e3 * np.sqrt(after.vPv / 12) == pytest.approx(78.0, abs=1.0)
    assert after.station - station == pytest.approx([175.0, 272.0, -1008.0], abs=4.0)


def test_a_camera_below_the_ground_is_refused():
    with pytest.raises(GeometryError, match=r"camera \(100.0 m\) is not above the ground \(200.0 m\)"):
        earth_curvature.correction([[1.0, 1.0]], 150.0, 100.0, 200.0, R)
