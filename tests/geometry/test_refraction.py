import numpy as np
import pytest

from orient.errors import GeometryError
from orient.geometry import refraction

TABLE = [
    # H km, h km, integral, ARDC [urad]: EQUATIONS 5.1
    (1.5, 0, 18.57, 14.86),
    (3, 0, 34.44, 30.00),
    (5, 0, 51.81, 49.18),
    (10, 0, 79.48, 83.10),
    (3, 1, 22.36, 26.72),
    (10, 1, 69.31, 82.12),
    (20, 0, 90.82, 90.94),
    (250, 0, 9.394, 9.837),
    (250, 1, 8.368, 9.797),
]


@pytest.mark.parametrize(("H", "h", "integral", "ardc"), TABLE)
def test_the_table_of_the_equations(H, h, integral, ardc):
    last_digit = 0.00051 if H > 86 else 0.0051
    assert refraction.integral_constant(1e3 * H, 1e3 * h) * 1e6 == pytest.approx(integral, abs=last_digit)
    assert refraction.ardc_constant(1e3 * H, 1e3 * h) * 1e6 == pytest.approx(ardc, abs=last_digit)


@pytest.mark.parametrize(("h", "integral"), [(0.0, 9.394e-6), (1e3, 8.368e-6)])
def test_the_formula_for_space_is_the_integral_above_the_air(h, integral):
    """2.35 m stand for 2.3485 m."""
    found = refraction.space_constant(250e3, h)
    assert found == pytest.approx(integral, rel=8e-4)
    assert found == pytest.approx(refraction.integral_constant(250e3, h), rel=8e-4)


def test_the_formula_for_space_by_hand():
    """p(1 km)/p(0) = 0.887 (EQUATIONS 5.1); 0.89876 kPa/101.325 kPa in table 1 of the standard atmosphere."""
    assert refraction.relative_pressure(0.0) == 1.0
    assert refraction.relative_pressure(1000.0) == pytest.approx(0.89876 / 1.01325, rel=1e-4)
    assert refraction.relative_pressure(90e3) == 0.0
    assert refraction.space_constant(200e3, 1000.0) == pytest.approx(2.35 * 0.887 / 199e3, rel=1e-4)


@pytest.mark.parametrize("H", [80e3, 10e3])
def test_the_formula_for_space_is_refused_in_the_air(H):
    with pytest.raises(GeometryError, match=rf"holds above 80 km, not at {H:.1f} m"):
        refraction.space_constant(H, 0.0)


@pytest.mark.parametrize(
    ("nadir_deg", "ray_urad", "by_K_urad"),
    [
        (5, 0.852, 0.822),
        (10, 1.720, 1.656),
        (20, 3.571, 3.419),
        (27.5, 5.149, 4.890),
        (33, 6.480, 6.101),
        (45, 10.33, 9.394),
    ],
)
def test_K_tan_of_the_nadir_angle_from_space(nadir_deg, ray_urad, by_K_urad):
    """EQUATIONS 5.1: flat layers give up to 10 % less than ray tracing through a spherical atmosphere."""
    tangent = np.tan(np.radians(nadir_deg))
    assert 1e6 * refraction.integral_constant(250e3, 0.0) * tangent == pytest.approx(by_K_urad, abs=6e-4)
    assert 1e6 * refraction.space_constant(250e3, 0.0) * tangent == pytest.approx(ray_urad, rel=0.1)


def test_the_whole_atmosphere():
    assert refraction.refractivity_column(0.0, 1e6) == pytest.approx(2.3485, abs=5e-5)


def test_the_standard_atmosphere():
    """Densities of U.S. Standard Atmosphere 1976, table 1, at 5, 11, 30, 60 km over 1.2250 kg/m3."""
    heights = np.array([0.0, 5e3, 11e3, 30e3, 60e3, 90e3])
    density = 1.225 * refraction.refractivity(heights) / refraction.SEA_LEVEL_REFRACTIVITY
    np.testing.assert_allclose(density, [1.225, 0.73643, 0.36480, 0.018410, 3.0968e-4, 0.0], rtol=2e-4)


def test_the_dead_sea_and_balloons_above_the_air():
    assert refraction.integral_constant(1000.0, -430.0) > refraction.integral_constant(1000.0, 0.0)
    assert refraction.integral_constant(200e3, 100e3) == 0.0


def test_correction_points_to_the_principal_point():
    xy = np.array([[90.0, -60.0], [0.0, 0.0]])
    K = 1e-4
    found = refraction.correction(xy, 150.0, K)
    np.testing.assert_allclose(found[0], -K * xy[0] * (1 + (90**2 + 60**2) / 150**2), rtol=1e-14)
    np.testing.assert_array_equal(found[1], 0.0)


@pytest.mark.parametrize(
    "constant", [refraction.integral_constant, refraction.ardc_constant, refraction.space_constant]
)
def test_a_camera_below_the_ground_is_refused(constant):
    with pytest.raises(GeometryError, match=r"camera \(500.0 m\) is not above the ground \(600.0 m\)"):
        constant(500.0, 600.0)
    with pytest.raises(GeometryError, match="is not above the ground"):
        constant(float("nan"), 600.0)


def test_ardc_below_the_sea_is_refused():
    with pytest.raises(GeometryError, match="camera above the sea"):
        refraction.ardc_constant(-100.0, -400.0)
