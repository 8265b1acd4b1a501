import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from orient.geometry.collinearity import image_ray, partials_aok, partials_rotation, project
from orient.geometry.rotation import matrix_from_aok, rotation_exp
from tests.jacobian import central_difference

F = 0.2
ANGLES = (0.05, -0.03, 0.6)
STATION = np.array([1000.0, -2000.0, 250000.0])
POINT = np.array([[51000.0, -32000.0, 0.0]])
R = matrix_from_aok(*ANGLES)


def test_the_vector_of_the_equations():
    """EQUATIONS 4.3, all digits."""
    image, zs = project(POINT, STATION, R, F)
    np.testing.assert_allclose(image[0], [0.0144223936948, -0.0313452204693], rtol=0, atol=6e-14)
    np.testing.assert_allclose(zs, [-252972.913144], rtol=0, atol=6e-7)
    J = partials_aok(POINT, STATION, R, F)[0]
    np.testing.assert_allclose(
        J[:, :3],
        [[-0.166186342134, -0.111650178018, -0.031345220469], [0.117947630835, -0.167845380074, -0.014422393695]],
        rtol=0,
        atol=6e-13,
    )
    by_station = [
        [-6.4951473215e-7, -4.4791470428e-7, -7.6153181918e-8],
        [4.3867937686e-7, -6.4849880859e-7, 1.6555573240e-7],
    ]
    np.testing.assert_allclose(J[:, 3:6], by_station, rtol=1e-10)
    np.testing.assert_array_equal(J[:, 6:], -J[:, 3:6])


SCENES = [(ANGLES, POINT), ((0.7, 0.4, -2.0), POINT), ((-1.2, 0.9, 3.0), np.array([[71e3, -2e3, 800.0]]))]
STEPS = np.array([1e-6] * 3 + [1.0] * 6)


@pytest.mark.parametrize(("angles", "ground"), SCENES)
def test_partials_by_angles(angles, ground):
    def image(e):
        return project(e[None, 6:], e[3:6], matrix_from_aok(*e[:3]), F)[0][0]

    at = np.concatenate([angles, STATION, ground[0]])
    analytic = partials_aok(ground, STATION, matrix_from_aok(*angles), F)[0]
    np.testing.assert_allclose(analytic, central_difference(image, at, STEPS), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(("angles", "ground"), SCENES)
def test_partials_by_rotation(angles, ground):
    turned = matrix_from_aok(*angles)

    def image(e):
        return project(e[None, 6:], e[3:6], rotation_exp(e[:3]) @ turned, F)[0][0]

    at = np.concatenate([np.zeros(3), STATION, ground[0]])
    analytic = partials_rotation(ground, STATION, turned, F)[0]
    np.testing.assert_allclose(analytic, central_difference(image, at, STEPS), rtol=1e-6, atol=1e-12)


def test_many_points_at_once():
    ground = np.random.default_rng(1).uniform(-5e4, 5e4, (7, 3))
    together = partials_rotation(ground, STATION, R, F)
    one_by_one = [partials_rotation(point[None], STATION, R, F)[0] for point in ground]
    assert together.shape == (7, 2, 9)
    np.testing.assert_allclose(together, one_by_one, rtol=1e-14)


coordinates = arrays(np.float64, (4, 3), elements=st.floats(-1000, 1000))
shift = arrays(np.float64, (3,), elements=st.floats(-1e4, 1e4))


@given(coordinates, shift, shift.map(lambda v: v / 4e3))
def test_moving_and_turning_the_world_leaves_the_image(ground, move, turn):
    station = np.array([10.0, 20.0, 3000.0])
    T = rotation_exp(turn)
    image, zs = project(ground, station, R, 153.0)
    moved, moved_zs = project(ground @ T.T + move, T @ station + move, T @ R, 153.0)
    np.testing.assert_allclose(moved, image, rtol=0, atol=1e-8)
    np.testing.assert_allclose(moved_zs, zs, rtol=0, atol=1e-8)


@given(coordinates)
def test_the_ray_of_an_image_point_meets_the_ground_point(ground):
    station = np.array([10.0, 20.0, 3000.0])
    image, zs = project(ground, station, R, 153.0)
    assert (zs < 0).all()
    rays = image_ray(image, R, 153.0)
    distances = np.linalg.norm(ground - station, axis=1)
    np.testing.assert_allclose(station + distances[:, None] * rays, ground, rtol=0, atol=1e-8)


def test_a_point_beside_the_camera_lies_at_infinity_without_a_warning():
    image, zs = project(np.array([[5.0, 0.0, 0.0]]), np.zeros(3), np.eye(3), F)
    assert zs[0] == 0.0
    assert not np.isfinite(image).any()
