import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orient.errors import GeometryError, OrientError
from orient.geometry import refraction
from orient.geometry.distortion import Distortion, correction, distort, field_of, fold_radius
from tests.jacobian import central_difference

CALGARY = Distortion(
    "brown", "correction", {"k0": -0.8878e-4, "k1": 0.1528e-7, "k2": -0.5256e-12, "p1": -0.1346e-6, "p2": -0.1224e-7}
)
# calgary-2728 photo 27: x_fid, y_fid, x_refined, y_refined [mm]
CALGARY_POINTS = np.array(
    [
        [18.18253, 109.53842, 18.18676, 109.53160],
        [-7.58172, -49.07221, -7.57556, -49.07508],
        [90.28494, -91.03487, 90.28674, -91.03906],
        [-9.43790, 96.23476, -9.43308, 96.22784],
        [44.67648, 7.48514, 44.67842, 7.47848],
        [-2.31117, -6.00451, -2.30495, -6.00992],
        [18.93005, -81.82975, 18.93462, -81.83373],
        [52.74338, -93.16239, 52.74718, -93.16738],
    ]
)
J1, J2, PHI0 = -5.4958195e-07, -4.608942e-11, 2.965907
APOLLO = Distortion(
    "brown",
    "correction",
    {
        "k1": -1.3361854e-06,
        "k2": 5.2261757e-10,
        "k3": -5.0728336e-14,
        "s1": -J1 * math.sin(PHI0),
        "s2": -J2 * math.sin(PHI0),
        "s3": J1 * math.cos(PHI0),
        "s4": J2 * math.cos(PHI0),
    },
)
# apollo15-metric-0585: sample, line [px], refined x, y [mm]
APOLLO_POINTS = np.array(
    [
        [4878.9429159402, 5197.4639314539, -40.302298, 46.681927],
        [2070.8979991535, 525.57470185016, 15.831767, -46.700958],
        [2377.1060720587, 5213.3491579866, 9.712654, 46.969505],
        [1341.3996337705, 2412.6250651017, 30.409208, -8.994597],
        [1633.0555026314, 2457.0127719037, 24.585810, -8.109369],
        [1252.4756947845, 3507.5255758714, 32.183841, 12.883611],
        [3903.146836567, 120.3951602937, -20.789097, -54.819054],
        [70.6784580744, 2977.122567896, 55.815669, 2.287667],
    ]
)
OPENCV = Distortion(
    "opencv",
    "ideal_to_distorted",
    {"k1": -0.11, "k2": 0.09, "p1": 1.1e-3, "p2": -7e-4, "k3": -0.01, "k4": 0.02, "k5": -0.01, "k6": 0.003}
    | {"s1": 1e-3, "s2": -2e-4, "s3": 5e-4, "s4": 1e-4},
    f_mm=50.0,
)
TABLE = np.array([[0.0, 0.0], [20.0, 0.004], [40.0, 0.006], [60.0, 0.001], [80.0, -0.009]])


def test_calgary_chain_to_the_printed_digits():
    """principal point, then distortion, then ARDC refraction: refined_expected.csv to its rounding."""
    measured = CALGARY_POINTS[:, :2] - [-0.006, 0.006]
    K = refraction.ardc_constant(1841.05, 1089.55)
    after_lens = measured + correction(CALGARY, measured)
    refined = after_lens + refraction.correction(after_lens, 153.358, K)
    np.testing.assert_allclose(refined, CALGARY_POINTS[:, 2:], rtol=0, atol=1.2e-5)


def test_apollo_refined_coordinates_to_the_printed_digits():
    S, L = (4.0 * (APOLLO_POINTS[:, :2] - 0.5) + 0.5).T
    measured = np.column_stack([-0.005 * (S - 11450) + 0.006, 0.005 * (L - 11450) + 0.002])
    np.testing.assert_allclose(measured + correction(APOLLO, measured), APOLLO_POINTS[:, 2:], rtol=0, atol=6e-7)


def test_opencv_formula_with_y_down():
    """The formula of OpenCV's manual (calib3d), written out in its own axes."""
    c = OPENCV.coefficients
    ideal = np.array([[12.0, -9.0], [-3.0, 14.0]])
    x, y = ideal[:, 0] / 50.0, -ideal[:, 1] / 50.0
    r2 = x**2 + y**2
    radial = (1 + c["k1"] * r2 + c["k2"] * r2**2 + c["k3"] * r2**3) / (
        1 + c["k4"] * r2 + c["k5"] * r2**2 + c["k6"] * r2**3
    )
    u = x * radial + 2 * c["p1"] * x * y + c["p2"] * (r2 + 2 * x**2) + c["s1"] * r2 + c["s2"] * r2**2
    v = y * radial + c["p1"] * (r2 + 2 * y**2) + 2 * c["p2"] * x * y + c["s3"] * r2 + c["s4"] * r2**2
    np.testing.assert_allclose(distort(OPENCV, ideal), np.column_stack([50.0 * u, -50.0 * v]), rtol=0, atol=1e-13)


BROWN_FORWARD = Distortion("brown", "ideal_to_distorted", {**APOLLO.coefficients, "p1": 2e-6, "p2": -1e-6, "k0": 1e-4})
TABLE_MODEL = Distortion("radial_table", "displacement", table=TABLE)
MODELS = [CALGARY, APOLLO, OPENCV, BROWN_FORWARD, TABLE_MODEL, Distortion()]
IDS = ["calgary", "apollo", "opencv", "brown forward", "table", "none"]


@pytest.mark.parametrize("model", MODELS, ids=IDS)
@given(st.floats(-40, 40), st.floats(-40, 40))
def test_distort_undoes_the_correction(model, x, y):
    measured = np.array([[x, y]])
    ideal = measured + correction(model, measured)
    np.testing.assert_allclose(distort(model, ideal), measured, rtol=0, atol=3e-12)


@pytest.mark.parametrize("direction", ["correction", "displacement", "ideal_to_distorted"])
@given(
    st.floats(-3e-4, 3e-4), st.floats(-2e-8, 2e-8), st.floats(-1e-12, 1e-12),
    st.floats(-2e-6, 2e-6), st.floats(-2e-6, 2e-6),
    st.floats(-80, 80), st.floats(-80, 80),
)  # fmt: skip
def test_brown_goes_both_ways(direction, k0, k1, k2, p1, p2, x, y):
    """Any lens of an aerial camera, in all three directions: there and back, and back and there."""
    model = Distortion("brown", direction, {"k0": k0, "k1": k1, "k2": k2, "p1": p1, "p2": p2})
    place = np.array([[x, y]])
    np.testing.assert_allclose(distort(model, place + correction(model, place)), place, rtol=0, atol=3e-12)
    measured = distort(model, place)
    np.testing.assert_allclose(measured + correction(model, measured), place, rtol=0, atol=3e-12)


@pytest.mark.parametrize("model", MODELS, ids=IDS)
def test_field_jacobian(model):
    for point in np.random.default_rng(5).uniform(-35, 35, (6, 2)):
        numeric = central_difference(lambda p: field_of(model, p[None])[0][0], point, 1e-4)
        np.testing.assert_allclose(field_of(model, point[None])[1][0], numeric, rtol=1e-6, atol=1e-10)


@pytest.mark.parametrize("model", MODELS, ids=IDS)
def test_the_principal_point_stays(model):
    np.testing.assert_array_equal(correction(model, np.zeros((1, 2))), 0.0)
    assert correction(model, np.zeros((0, 2))).shape == (0, 2)


def test_a_certificate_is_taken_from_the_measured_radius():
    """x (1 - D(r)/r), D linear between the rows: D(50) = 0.0035 mm."""
    found = correction(TABLE_MODEL, np.array([[30.0, 40.0], [-40.0, 0.0]]))
    np.testing.assert_allclose(found, [[-0.0035 * 0.6, -0.0035 * 0.8], [0.006, 0.0]], rtol=0, atol=1e-16)


def test_a_certificate_without_the_row_zero_starts_at_zero():
    model = Distortion("radial_table", "displacement", table=TABLE[1:])
    np.testing.assert_allclose(correction(model, [[10.0, 0.0]]), [[-0.002, 0.0]], rtol=0, atol=1e-16)


def test_beyond_the_certificate_is_refused():
    with pytest.raises(GeometryError, match=r"table ends at 80 mm, a point lies at 90\.000 mm"):
        correction(TABLE_MODEL, [[90.0, 0.0]])


def test_fold_of_a_cubic():
    """r (1 + k1 r^2) turns at r = 1/sqrt(-3 k1), where it is 2/3 of that."""
    k1 = -1e-4
    turn = 1.0 / math.sqrt(3e-4)
    assert fold_radius(Distortion("brown", "correction", {"k1": k1}), 70.0) == pytest.approx(turn, rel=1e-8)
    assert fold_radius(Distortion("brown", "displacement", {"k1": -k1}), 70.0) == pytest.approx(turn, rel=1e-8)
    assert fold_radius(Distortion("brown", "correction", {"k1": k1}), 57.0) is None
    forward = Distortion("brown", "ideal_to_distorted", {"k1": k1})
    assert fold_radius(forward, 70.0) == pytest.approx(turn * 2 / 3, rel=1e-8)
    assert fold_radius(forward, 38.0) is None


@pytest.mark.parametrize("model", MODELS, ids=IDS)
def test_real_lenses_do_not_fold(model):
    assert fold_radius(model, 45.0) is None


def test_a_point_beyond_the_fold_is_named():
    model = Distortion("brown", "ideal_to_distorted", {"k1": -1e-4})
    inside = correction(model, [[38.0, 0.0]])
    assert distort(model, np.array([[38.0, 0.0]]) + inside) == pytest.approx(np.array([[38.0, 0.0]]), abs=1e-11)
    with pytest.raises(GeometryError, match=r"cannot be inverted at x = 0\.000 mm, y = 39\.000 mm \(radius 39\.0 mm\)"):
        correction(model, [[10.0, 0.0], [0.0, 39.0]])


@pytest.mark.filterwarnings("error")
def test_a_point_far_outside_every_frame_is_refused_without_a_warning():
    model = Distortion("brown", "ideal_to_distorted", {"k1": -1e-4, "k2": 1e-9, "k3": 1e-12})
    with pytest.raises(GeometryError, match="cannot be inverted"):
        correction(model, [[1e60, -1e60]])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"model": "brwon"}, 'unknown model "brwon"'),
        ({"model": "brown", "direction": "forward"}, 'unknown direction "forward"'),
        ({"model": "brown", "coefficients": {"k9": 1.0}}, 'brown has no coefficient "k9"'),
        ({"model": "brown", "coefficients": {"k1": math.nan}}, "k1 must be a finite number"),
        ({"model": "opencv", "direction": "correction", "f_mm": 1.0}, "opencv goes from ideal to distorted"),
        ({"model": "opencv", "direction": "ideal_to_distorted"}, "needs the focal length"),
        ({"model": "radial_table", "direction": "displacement"}, "at least two rows"),
        ({"model": "radial_table", "direction": "displacement", "table": TABLE[::-1]}, "and grow"),
    ],
)
def test_a_bad_model_is_refused_with_its_reason(arguments, message):
    with pytest.raises(OrientError, match=message):
        Distortion(**arguments)
