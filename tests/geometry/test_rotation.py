import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from orient.geometry import rotation as rot
from tests.jacobian import central_difference

angle = st.floats(-math.pi, math.pi)
middle = st.floats(-1.55, 1.55)
vector = st.tuples(angle, angle, angle)


def random_rotation(seed: int) -> np.ndarray:
    return rot.rotation_exp(np.random.default_rng(seed).normal(size=3))


def elementary(axis: int, angle: float) -> np.ndarray:
    return rot.rotation_exp(angle * np.eye(3)[axis])


def test_aok_is_the_printed_product():
    """alpha turns X to Z, i.e. minus alpha about the right-handed Y axis."""
    expected = elementary(1, -0.3) @ elementary(0, 0.2) @ elementary(2, 0.7)
    np.testing.assert_allclose(rot.matrix_from_aok(0.3, 0.2, 0.7), expected, atol=1e-15)


def test_opk_is_the_standard_matrix():
    so, co, sp, cp, sk, ck = (g(a) for a in (0.3, -0.2, 0.7) for g in (math.sin, math.cos))
    M = [
        [cp * ck, co * sk + so * sp * ck, so * sk - co * sp * ck],
        [-cp * sk, co * ck - so * sp * sk, so * ck + co * sp * sk],
        [sp, -so * cp, co * cp],
    ]
    np.testing.assert_allclose(rot.matrix_from_opk(0.3, -0.2, 0.7).T, M, atol=1e-15)


@given(angle, middle, angle)
def test_angle_triples_round_trip(first, second, third):
    for compose, resolve in (
        (rot.matrix_from_aok, rot.aok_from_matrix),
        (rot.matrix_from_opk, rot.opk_from_matrix),
    ):
        found = resolve(compose(first, second, third))
        difference = np.remainder(found - [first, second, third] + math.pi, 2 * math.pi) - math.pi
        np.testing.assert_allclose(difference, 0.0, atol=1e-13 / math.cos(second))


@given(angle, st.sampled_from([-math.pi / 2, math.pi / 2]), angle)
def test_blind_views_still_give_back_the_matrix(first, second, third):
    for compose, resolve, blind in (
        (rot.matrix_from_aok, rot.aok_from_matrix, rot.near_blind_aok),
        (rot.matrix_from_opk, rot.opk_from_matrix, rot.near_blind_opk),
    ):
        R = compose(first, second, third)
        assert blind(R)
        np.testing.assert_allclose(compose(*resolve(R)), R, atol=1e-14)


def test_a_vertical_view_is_not_blind():
    assert not rot.near_blind_aok(np.eye(3))
    assert not rot.near_blind_opk(np.eye(3))


@given(vector)
@example((math.pi, 0.0, 0.0))
@example((0.0, math.pi, 0.0))
@example((0.0, 0.0, -math.pi))
@example((0.0, 0.0, 0.0))
def test_quaternion_round_trip(r):
    R = rot.rotation_exp(r)
    q = rot.quaternion_from_matrix(R)
    assert q[0] >= 0.0
    assert abs(np.linalg.norm(q) - 1.0) < 1e-15
    np.testing.assert_allclose(rot.matrix_from_quaternion(q), R, atol=1e-14)
    np.testing.assert_allclose(rot.matrix_from_quaternion(1.7 * q), R, atol=1e-14)


def test_quaternion_of_a_known_turn():
    q = rot.quaternion_from_matrix(rot.rotation_exp([0.0, 0.0, 0.5]))
    np.testing.assert_allclose(q, [math.cos(0.25), 0.0, 0.0, math.sin(0.25)], atol=1e-16)


@given(vector)
def test_rotation_exp_is_orthonormal(r):
    R = rot.rotation_exp(r)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=2e-15)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-14)
    np.testing.assert_allclose(rot.rotation_exp(-np.asarray(r)), R.T, atol=1e-15)


def test_rotation_exp_of_a_tiny_vector_keeps_its_digits():
    R = rot.rotation_exp([1e-9, -2e-9, 3e-9])
    np.testing.assert_allclose([R[2, 1], R[0, 2], R[1, 0]], [1e-9, -2e-9, 3e-9], rtol=1e-8)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(
    ("resolve", "by_rotation"),
    [(rot.aok_from_matrix, rot.aok_by_rotation), (rot.opk_from_matrix, rot.opk_by_rotation)],
    ids=["aok", "opk"],
)
def test_angle_partials(seed, resolve, by_rotation):
    R = random_rotation(seed)
    numeric = central_difference(lambda r: resolve(rot.rotation_exp(r) @ R), np.zeros(3), 1e-6)
    np.testing.assert_allclose(by_rotation(R), numeric, rtol=1e-7, atol=1e-8)
