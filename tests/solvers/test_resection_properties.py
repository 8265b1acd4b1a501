"""Moving, turning and scaling the world moves the answer with it; the order of the points does not matter."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from orient.geometry.rotation import rotation_exp
from orient.solvers.resection import Resection, resect
from tests.solvers.resection_scenes import Scene, generator, scene

RANDOM = generator("test_resection_properties")
SCENE = scene(RANDOM, n=7)
IMAGE = SCENE.noisy(0.01, RANDOM)
BASE = resect(IMAGE, SCENE.unit, SCENE.ground, SCENE.f_mm)

shifts = st.tuples(*[st.floats(-1e6, 1e6)] * 3).map(np.array)
turns = st.tuples(*[st.floats(-3, 3)] * 3).map(np.array)
scales = st.floats(-3, 3).map(lambda power: 10.0**power)
profile = settings(max_examples=15, deadline=None, derandomize=True)


def adjusted(s: Scene = SCENE, ground: np.ndarray | None = None) -> Resection:
    return resect(IMAGE, s.unit, s.ground if ground is None else ground, s.f_mm)


@profile
@given(shift=shifts, turn=turns, scale=scales)
def test_the_answer_moves_with_the_world(shift: np.ndarray, turn: np.ndarray, scale: float) -> None:
    R = rotation_exp(turn)
    result = adjusted(ground=scale * SCENE.ground @ R.T + shift)
    size = 2000 * scale
    rounding = 1e-7 + 1e-8 * float(np.max(np.abs(shift))) / size
    np.testing.assert_allclose(result.rotation, R @ BASE.rotation, atol=rounding)
    np.testing.assert_allclose(result.station, scale * R @ BASE.station + shift, atol=size * rounding)
    assert abs(result.vPv - BASE.vPv) <= 1e-6 * BASE.vPv + rounding
    T = np.kron(np.diag([1.0, scale]), R)
    sigma = np.sqrt(np.diag(T @ BASE.Q @ T.T))
    np.testing.assert_allclose(np.sqrt(np.diag(result.Q)), sigma, rtol=1e-4 + rounding)


@profile
@given(order=st.permutations(range(7)))
def test_the_order_of_the_points_does_not_matter(order: list[int]) -> None:
    result = resect(IMAGE[order], SCENE.unit, SCENE.ground[order], SCENE.f_mm)
    np.testing.assert_allclose(result.station, BASE.station, atol=1e-6)
    np.testing.assert_allclose(result.redundancy_numbers, BASE.redundancy_numbers[order], atol=1e-6)


@profile
@given(factor=st.floats(0.01, 100.0))
def test_the_unit_of_weight_does_not_matter(factor: float) -> None:
    result = resect(IMAGE, factor * SCENE.unit, SCENE.ground, SCENE.f_mm)
    np.testing.assert_allclose(result.station, BASE.station, atol=1e-6)
    np.testing.assert_allclose(result.vPv * factor, BASE.vPv, rtol=1e-6)
    np.testing.assert_allclose(result.Q / factor, BASE.Q, rtol=1e-5, atol=1e-12)


@profile
@given(turn=st.floats(-3, 3))
def test_turning_the_camera_about_its_axis_turns_kappa_only(turn: float) -> None:
    c, s = np.cos(turn), np.sin(turn)
    image = IMAGE @ np.array([[c, -s], [s, c]])
    result = resect(image, SCENE.unit, SCENE.ground, SCENE.f_mm)
    np.testing.assert_allclose(result.station, BASE.station, atol=1e-6)
    np.testing.assert_allclose(result.rotation[:, 2], BASE.rotation[:, 2], atol=1e-8)
