"""Elements under each paper's names, points on the ground, small angles."""

import numpy as np
import pytest

from orient.errors import GeometryError
from orient.geometry.rotation import aok_from_matrix, rotation_exp
from orient.geometry.similarity import (
    fixed_axes_from_matrix,
    matrix_from_fixed_axes,
    partials_homothety,
    partials_joint_homothety,
    partials_scale,
)
from orient.solvers.absolute_orientation import orient_model
from orient.solvers.absolute_points import ground_points
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.absolute_small_angles import orient_by_small_angles
from orient.solvers.absolute_views import element_view
from tests.solvers.absolute_scenes import KNOWN, Scene, attitude, covariances, generator, scene

RANDOM = generator("test_absolute_views")
SCENE = scene(RANDOM, "ffffffff", tilt=0.2, H=0.4, X0=(120.0, -50.0, 30.0))
GROUND = SCENE.ground + 0.05 * RANDOM.normal(size=(8, 3))
FOUND = orient_model(SCENE.model, GROUND)


@pytest.mark.parametrize(
    ("view", "partials"),
    [
        ("homothety", lambda v: partials_homothety(SCENE.model, v[:3], v[3])),
        ("joint", lambda v: partials_joint_homothety(SCENE.model, v[:3], v[3], v[4:])),
        ("scale", lambda v: partials_scale(SCENE.model, v[4:], v[3])),
    ],
)
def test_cofactors_of_a_view_are_those_of_its_own_partials(view, partials):
    seen = element_view(FOUND, view)
    B = partials(seen.values).reshape(-1, 7)
    scales = np.linalg.norm(B, axis=0)
    Q = np.linalg.inv((B / scales).T @ (B / scales)) / np.outer(scales, scales)
    np.testing.assert_allclose(seen.Q, Q, rtol=1e-7, atol=1e-12)
    sigmas = seen.standard_deviations(FOUND.sigma0**2)
    np.testing.assert_allclose(sigmas, FOUND.sigma0 * np.sqrt(np.diag(Q)), rtol=1e-7)
    assert not seen.near_blind


def test_views_hold_the_same_similarity():
    homothety, joint, scale = (element_view(FOUND, name).values for name in ("homothety", "joint", "scale"))
    np.testing.assert_allclose(homothety[:3], fixed_axes_from_matrix(FOUND.rotation))
    np.testing.assert_allclose(joint[4:], homothety[3] * homothety[4:])
    np.testing.assert_allclose(scale[3], 1 / homothety[3])
    np.testing.assert_allclose(scale[4:], aok_from_matrix(FOUND.rotation))
    np.testing.assert_allclose(FOUND.T, joint[4:])
    assert element_view(FOUND, "homothety").names == ("xi", "eta", "theta", "H", "X_0", "Y_0", "Z_0")
    assert element_view(FOUND, "scale").names == ("X_0", "Y_0", "Z_0", "t", "xi", "eta", "theta")


def test_a_blind_view_says_so():
    R = matrix_from_fixed_axes(0.3, 1.55, 0.2)
    s = Scene(SCENE.model, "f" * 8, R, 1.0, np.zeros(3))
    found = orient_model(s.model, s.ground)
    assert element_view(found, "homothety").near_blind
    assert not element_view(found, "scale").near_blind


def test_an_unknown_view_is_refused():
    with pytest.raises(ValueError, match="none of rotation, homothety, joint, scale"):
        element_view(FOUND, "helmert")


# ------------------------------------------------------------------------------------------- points


def test_points_follow_the_elements():
    others = np.add(SCENE.model[:3], [3.0, -20.0, 1.0])
    ground, Q = ground_points(FOUND, others)
    np.testing.assert_allclose(ground, others @ FOUND.rotation.T / FOUND.H + FOUND.X0, atol=1e-9)
    view = element_view(FOUND, "homothety")
    B = partials_homothety(others, view.values[:3], view.values[3])
    np.testing.assert_allclose(Q, B @ view.Q @ B.transpose(0, 2, 1), rtol=1e-7, atol=1e-9)
    own = 0.01 * np.tile(np.eye(3), (3, 1, 1))
    _, with_own = ground_points(FOUND, others, own)
    np.testing.assert_allclose(with_own - Q, own / FOUND.H**2, atol=1e-9)


def test_control_points_know_that_their_own_errors_are_in_the_elements():
    """With an errorless ground the cofactors of computed control points are those of their residuals, Q_L - B Q B'."""
    Q_x = covariances(generator("own"), 8, 0.1)
    found = orient_model(SCENE.model, GROUND, model_cofactor=Q_x)
    _, Q = ground_points(found, SCENE.model, Q_x, control=range(8))
    _, elements_only = ground_points(found, SCENE.model)
    own = found.t**2 * found.rotation @ Q_x @ found.rotation.T
    np.testing.assert_allclose(Q, own - elements_only, atol=0.02 * np.max(own))
    _, mixed = ground_points(found, SCENE.model, Q_x, control=[0, None, 2, None, None, None, None, None])
    np.testing.assert_allclose(mixed[[0, 2]], Q[[0, 2]])
    np.testing.assert_allclose(mixed[1], (elements_only + own)[1])


# ------------------------------------------------------------------------------------------- small angles


@pytest.mark.parametrize("size", [1e-2, 1e-3, 1e-4])
def test_small_angles_approach_the_rigorous_elements_by_squares(size):
    s = Scene(SCENE.model, "f" * 8, rotation_exp(size * np.array([0.5, -0.7, 0.4])), 1 / (1 + 0.6 * size), np.ones(3))
    found = orient_model(s.model, s.ground)
    small = orient_by_small_angles(found, s.model, s.ground)
    np.testing.assert_allclose(small.elements[3:], small.rigorous[3:], atol=2 * size**2)
    assert small.second_order < 1.5 * size**2
    assert small.largest_gap_m < 2 * 20 * size**2
    assert small.vPv >= found.vPv


def test_small_angles_with_partial_control_and_weights():
    s = scene(generator("small partial"), "ffpphhh", tilt=1e-5, theta=1e-5, H=1.00001, X0=(1e5, 2e5, 30.0))
    Q_G, Q_x = covariances(RANDOM, 7, 1.0), covariances(RANDOM, 7, 0.1)
    options = {"known": s.known, "ground_cofactor": Q_G, "model_cofactor": Q_x}
    found = orient_model(s.model, s.ground, **options)
    small = orient_by_small_angles(found, s.model, s.ground, **options)
    np.testing.assert_allclose(small.elements, small.rigorous, rtol=1e-8, atol=1e-7)
    np.testing.assert_allclose(small.Q, element_view(found, "scale").Q, rtol=2e-3, atol=1e-4 * np.max(small.Q[3:, 3:]))


def test_large_angles_show_how_far_small_ones_are_off():
    s = Scene(SCENE.model, "f" * 8, attitude(0.2, 0.5), 0.5, np.zeros(3))
    small = orient_by_small_angles(orient_model(s.model, s.ground), s.model, s.ground)
    assert small.second_order > 0.1
    assert small.largest_gap_m > 0.1


def test_small_angles_refuse_singular_control():
    line = np.outer([0.0, 1, 2, 5], [1.0, 0.2, 0.1])
    with pytest.raises(GeometryError, match="small-angle"):
        orient_by_small_angles(singular(line), line, line)


def singular(line: np.ndarray) -> AbsoluteOrientation:
    return orient_model(line, line, known=np.array([KNOWN["f"]] * 4))
