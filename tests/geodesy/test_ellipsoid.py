import re

import numpy as np
import pytest

from orient.errors import OrientError
from orient.geodesy.ellipsoid import (
    BESSEL,
    KRASOVSKY,
    MOON,
    WGS84,
    meridian_radius,
    named_ellipsoid,
    prime_vertical_polynomial,
    prime_vertical_radius,
)
from tests.jacobian import central_difference


def test_krasovsky_constants():
    """EQUATIONS 4."""
    assert KRASOVSKY.e2 == pytest.approx(0.006693421622966, abs=5e-16)
    assert KRASOVSKY.ep2 == pytest.approx(0.006738525414683, abs=5e-16)
    assert prime_vertical_radius(KRASOVSKY, np.pi / 2) == pytest.approx(6399698.9018, abs=5e-5)


def test_radii_of_a_sphere_are_its_radius():
    B = np.radians([0.0, 45.0, -90.0])
    np.testing.assert_array_equal(prime_vertical_radius(MOON, B), 1737400.0)
    np.testing.assert_array_equal(meridian_radius(MOON, B), 1737400.0)


def test_meridian_radius_is_the_curvature_of_the_meridian():
    """dZ = M cosB dB with Z = N (1 - e^2) sinB."""
    B = np.radians(37.0)
    Z = lambda b: prime_vertical_radius(KRASOVSKY, b) * (1 - KRASOVSKY.e2) * np.sin(b)  # noqa: E731
    slope = central_difference(lambda b: Z(b)[0], [B], 1e-5)
    assert meridian_radius(KRASOVSKY, B) * np.cos(B) == pytest.approx(slope[0], rel=1e-9)


@pytest.mark.parametrize(
    ("text", "a", "rf"),
    [
        ("krasovsky", 6378245.0, 298.3),
        ("Krassowsky 1940", 6378245.0, 298.3),
        ("WGS 84", 6378137.0, 298.257223563),
        ("wgs-84", 6378137.0, 298.257223563),
        ("GRS80", 6378137.0, 298.257222101),
        ("bessel", 6377397.155, 299.1528128),
        ("Moon", 1737400.0, 0.0),
        ("airy", 6377563.396, 299.3249646),
        ("6378245/298.3", 6378245.0, 298.3),
        ("1737400 / 0", 1737400.0, 0.0),
    ],
)
def test_names(text, a, rf):
    found = named_ellipsoid(text)
    assert (found.a_m, found.inverse_flattening) == (a, pytest.approx(rf, abs=1e-6))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("clarkson", 'unknown ellipsoid "clarkson"'),
        ("", 'unknown ellipsoid ""'),
        ("6/298.3", "6 m is not in"),
        ("6378245/0.5", "inverse flattening 0.5"),
        ("nan/298.3", "unknown ellipsoid"),
    ],
)
def test_what_is_no_ellipsoid_is_refused(text, message):
    with pytest.raises(OrientError, match=message):
        named_ellipsoid(text)


def test_friendly_figures_agree_with_proj():
    from pyproj import get_ellps_map

    for ours, theirs in {"krasovsky": "krass", "hayford": "intl", "clarke1866": "clrk66"}.items():
        figures, found = get_ellps_map()[theirs], named_ellipsoid(ours)
        assert found.a_m == figures["a"]
        assert found.b_m == pytest.approx(figures.get("b", figures["a"] * (1 - 1 / figures.get("rf", 1e99))), abs=1e-3)


def test_the_polynomial_of_N_is_within_a_quarter_of_a_millimetre():
    """EQUATIONS 4: at most 0.22 mm, at the pole."""
    B = np.radians(np.linspace(0.0, 90.0, 901))
    difference = np.abs(prime_vertical_polynomial(KRASOVSKY, B) - prime_vertical_radius(KRASOVSKY, B))
    assert 1e3 * np.max(difference) == pytest.approx(0.22, abs=0.005)
    assert np.max(difference) == difference[-1]
    assert prime_vertical_polynomial(KRASOVSKY, 0.0) == 6378245.0


@pytest.mark.parametrize("ellipsoid", [WGS84, BESSEL, MOON], ids=lambda ellipsoid: ellipsoid.name)
def test_the_polynomial_of_N_names_the_ellipsoid_that_it_does_not_fit(ellipsoid):
    with pytest.raises(OrientError, match="for the Krasovsky ellipsoid only, not for " + re.escape(ellipsoid.name)):
        prime_vertical_polynomial(ellipsoid, 0.7)


def test_the_figures_of_krasovsky_under_any_name_are_krasovsky():
    assert prime_vertical_polynomial(named_ellipsoid("6378245/298.3"), 0.0) == 6378245.0
