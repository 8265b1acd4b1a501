"""Forward formulas and partials of the absolute orientation: EQUATIONS 1.1, 1.2 and section 2."""

import math
import re

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from orient.geometry import similarity
from orient.geometry.rotation import aok_from_matrix, cross_matrix, matrix_from_aok, rotation_exp
from tests.jacobian import central_difference

ANGLES = (0.31, -0.22, 0.67)
H = 1.7
X0 = np.array([12.0, -5.0, 3.0])
MODEL = np.array([[2.3, -1.1, 0.9]])
MANY = np.random.default_rng(7).normal(size=(5, 3)) * [3.0, 2.0, 1.0]

angle = st.floats(-math.pi, math.pi)


def numbers(text: str) -> list[float]:
    return [float(token) for token in re.findall(r"[+-]?[0-9]*\.[0-9]+|0", text)]


def test_the_matrix_of_the_test_vector_to_all_digits():
    printed = """.764929564  .606018641 -.218229623; -.539204574 .787800481 .297705945;
        .352336754 -.110053668 .929379902"""
    r = similarity.matrix_from_fixed_axes(*ANGLES).T
    np.testing.assert_allclose(r, np.reshape(numbers(printed), (3, 3)), atol=5e-10)


def test_the_printed_order_of_the_elementary_matrices():
    """r = A_xi' A_eta' A_theta' with row vectors; A_eta turns X towards Z, i.e. by -eta about Y."""
    xi, eta, theta = ANGLES
    product = rotation_exp([0, 0, theta]) @ rotation_exp([0, -eta, 0]) @ rotation_exp([xi, 0, 0])
    np.testing.assert_allclose(similarity.matrix_from_fixed_axes(*ANGLES), product, atol=1e-15)


@pytest.mark.parametrize(
    ("forward", "printed"),
    [
        pytest.param(similarity.ground_by_homothety, "13.570333005, -4.748109386, 3.004139552", id="2'"),
        pytest.param(similarity.ground_by_joint_homothety, "8.629156535, -2.689285856, 1.768845435", id="4'"),
    ],
)
def test_the_points_of_the_test_vector_to_all_digits(forward, printed):
    ground = forward(MODEL, similarity.matrix_from_fixed_axes(*ANGLES), H, X0)
    np.testing.assert_allclose(ground[0], numbers(printed), atol=5e-10)


def test_the_jacobians_of_the_test_vector_to_all_digits():
    printed = """.057479 -.003245 -.251891 -.923725 ; -.345860 -.002571 1.570333 -.148171 ;
        -.758972 1.387282 0 -.002435"""
    partials = similarity.partials_homothety(MODEL, ANGLES, H)[0]
    np.testing.assert_allclose(partials[:, :4], np.reshape(numbers(printed), (3, 4)), atol=5.1e-7)
    np.testing.assert_array_equal(partials[:, 4:], np.eye(3))
    joint = similarity.partials_joint_homothety(MODEL, ANGLES, H, X0)[0]
    np.testing.assert_allclose(joint[:, 3], [-5.075974, 1.581933, -1.040497], atol=5.1e-7)
    np.testing.assert_allclose(joint[:, :3], partials[:, :3], atol=1e-15)
    np.testing.assert_allclose(joint[:, 4:], np.eye(3) / H, atol=1e-15)


def by_homothety(p):
    return similarity.ground_by_homothety(MANY, similarity.matrix_from_fixed_axes(*p[:3]), p[3], p[4:])


def by_joint_homothety(p):
    return similarity.ground_by_joint_homothety(MANY, similarity.matrix_from_fixed_axes(*p[:3]), p[3], p[4:])


def by_scale(p):
    return similarity.ground_by_scale(MANY, matrix_from_aok(*p[4:]), p[3], p[:3])


def by_rotation(p):
    turned = rotation_exp(p[:3]) @ matrix_from_aok(*ANGLES)
    return similarity.ground_by_homothety(MANY, turned, H * math.exp(p[3]), p[4:])


def by_small_angles(p):
    return similarity.ground_by_small_angles(MANY, p[3], p[4:], p[:3])


@pytest.mark.parametrize(
    ("forward", "at", "partials"),
    [
        pytest.param(by_homothety, [*ANGLES, H, *X0], similarity.partials_homothety(MANY, ANGLES, H), id="2'"),
        pytest.param(
            by_joint_homothety, [*ANGLES, H, *X0], similarity.partials_joint_homothety(MANY, ANGLES, H, X0), id="4'"
        ),
        pytest.param(by_scale, [*X0, H, *ANGLES], similarity.partials_scale(MANY, ANGLES, H), id="110"),
        pytest.param(
            by_rotation,
            [0, 0, 0, 0, *X0],
            similarity.partials_rotation(MANY, matrix_from_aok(*ANGLES), 1 / H),
            id="rotation",
        ),
        pytest.param(by_small_angles, [*X0, 0.1, *ANGLES], similarity.partials_small_angles(MANY), id="111"),
    ],
)
def test_partials_are_the_central_differences(forward, at, partials):
    np.testing.assert_allclose(central_difference(forward, at), partials, atol=1e-8)


def test_partials_of_110_are_the_printed_ones():
    """The nine angular partials in the letters of the reconstruction, term by term."""
    xi, _, _ = ANGLES
    (a1, a2, _), (b1, b2, _), (c1, c2, _) = R = matrix_from_aok(*ANGLES)
    X, Y, _ = MODEL[0]
    u, v, w = R @ MODEL[0]
    t, s, c = 2.5, math.sin(xi), math.cos(xi)
    rows = [
        [u, -t * w, -t * v * s, t * (a2 * X - a1 * Y)],
        [v, 0, -t * (w * c - u * s), t * (b2 * X - b1 * Y)],
        [w, t * u, t * v * c, t * (c2 * X - c1 * Y)],
    ]
    partials = similarity.partials_scale(MODEL, ANGLES, t)[0]
    np.testing.assert_allclose(partials[:, 3:], rows, atol=1e-14)
    np.testing.assert_array_equal(partials[:, :3], np.eye(3))


@given(xi=angle, eta=st.floats(-1.55, 1.55), theta=angle)
def test_fixed_axes_come_back(xi, eta, theta):
    R = similarity.matrix_from_fixed_axes(xi, eta, theta)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
    assert math.isclose(np.linalg.det(R), 1.0, rel_tol=1e-13)
    back = similarity.fixed_axes_from_matrix(R)
    difference = np.angle(np.exp(1j * (back - [xi, eta, theta])))
    np.testing.assert_allclose(difference, 0, atol=1e-12)


@given(xi=angle, sign=st.sampled_from([1, -1]), theta=angle)
@example(xi=0.4, sign=1, theta=-2.0)
def test_the_blind_view_gives_the_matrix_back(xi, sign, theta):
    R = similarity.matrix_from_fixed_axes(xi, sign * math.pi / 2, theta)
    assert similarity.near_blind_fixed_axes(R)
    back = similarity.matrix_from_fixed_axes(*similarity.fixed_axes_from_matrix(R))
    np.testing.assert_allclose(back, R, atol=1e-12)


def test_inverse_formulas_of_1_1():
    r = similarity.matrix_from_fixed_axes(*ANGLES).T
    assert math.isclose(math.atan2(r[1, 2], r[2, 2]), ANGLES[0])
    assert math.isclose(math.asin(r[0, 2]), ANGLES[1])
    assert math.isclose(math.atan2(r[0, 1], r[0, 0]), ANGLES[2])


def test_fixed_axes_by_rotation_is_the_central_difference():
    R = similarity.matrix_from_fixed_axes(*ANGLES)
    numeric = central_difference(lambda p: similarity.fixed_axes_from_matrix(rotation_exp(p) @ R), np.zeros(3))
    np.testing.assert_allclose(similarity.fixed_axes_by_rotation(R), numeric, atol=1e-9)


def test_the_definitions_of_seed_002_give_the_tilts():
    """tan(xi) = -a3/c3, sin(eta) = -b3, tan(theta) = b1/b2."""
    a, b, c = matrix_from_aok(*ANGLES)
    found = [math.atan2(-a[2], c[2]), math.asin(-b[2]), math.atan2(b[0], b[1])]
    np.testing.assert_allclose(found, ANGLES, atol=1e-15)
    np.testing.assert_allclose(aok_from_matrix(np.array([a, b, c])), ANGLES, atol=1e-15)


def test_both_forms_and_the_scale_describe_one_similarity():
    R = similarity.matrix_from_fixed_axes(*ANGLES)
    expected = similarity.ground_by_homothety(MANY, R, H, X0)
    np.testing.assert_allclose(similarity.ground_by_joint_homothety(MANY, R, H, H * X0), expected, atol=1e-14)
    np.testing.assert_allclose(similarity.ground_by_scale(MANY, R, 1 / H, X0), expected, atol=1e-14)


@given(size=st.floats(1e-6, 1e-2))
def test_small_angles_err_by_squares(size):
    angles, dt = size * np.array([0.6, -0.5, 0.4]), 0.5 * size
    rigorous = similarity.ground_by_scale(MANY, matrix_from_aok(*angles), 1 + dt, X0)
    gap = np.max(np.abs(similarity.ground_by_small_angles(MANY, dt, angles, X0) - rigorous))
    assert gap <= 2 * size**2 * np.max(np.linalg.norm(MANY, axis=1)) + 1e-14


def test_partials_do_not_write_into_arguments():
    model = MANY.copy()
    similarity.partials_joint_homothety(model, ANGLES, H, X0)
    similarity.partials_rotation(model, np.eye(3), 2.0)
    np.testing.assert_array_equal(model, MANY)
    assert cross_matrix(model).shape == (5, 3, 3)
