"""Numbers of the corrected papers that no other test holds: seed 003, vertical photo of flat ground, 3 x 3 points."""

import numpy as np
import pytest
from numpy.typing import NDArray

from orient.geometry.collinearity import partials_aok, partials_rotation
from orient.solvers.functional_iteration import cofactor_matrix
from orient.solvers.ground_covariance import (
    covariance_factor,
    ground_covariance,
    pair_covariance,
    ray_at_height,
    ray_at_height_jacobians,
)
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.resection import resect
from orient.solvers.resection_problem import Orientation, ResectionProblem

Array = NDArray[np.float64]

F_MM, HALF_MM, H_M, SIGMA_MM = 200.0, 90.0, 250_000.0, 0.007
GRID = np.array([(x, y) for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)])
UP = np.array([0.0, 0.0, 1.0])


def vertical_photo(f_mm: float) -> tuple[Array, Array, Array, Array]:
    """Image, ground, station and Q of the elements (sigma0 = 1 mm) of the 3 x 3 grid; R = I."""
    image, station = HALF_MM * GRID, np.array([0.0, 0.0, H_M])
    ground = np.column_stack([image * H_M / f_mm, np.zeros(len(image))])
    found = resect(image, np.tile(np.eye(2), (len(image), 1, 1)), ground, f_mm, camera_above=UP)
    return image, ground, station, found.Q


def test_standard_deviations_of_the_nine_points() -> None:
    *_, Q = vertical_photo(F_MM)
    expected = [7.056143e-5, 7.056143e-5, 2.245251e-5, 20.233133, 20.233133, 5.613128]
    assert SIGMA_MM * np.sqrt(np.diag(Q)) == pytest.approx(expected, rel=2e-7)
    correlation = abs(Q[3, 1]) / np.sqrt(Q[3, 3] * Q[1, 1])
    assert correlation == pytest.approx(0.98956, abs=1e-5)


def test_closed_form_of_the_nine_points() -> None:
    """(8)-(10): Q11 = (n g^2 + 2 g [xi2] + [xi4] + [xi2 eta2])/D, Q44 = n/D, Q33 = Q66 = 1/[xi2 + eta2]."""
    *_, Q = vertical_photo(F_MM)
    g, D = (F_MM / HALF_MM) ** 2, 9 * (4 + 6) - 6**2
    assert Q[3, 3] == pytest.approx((H_M / F_MM) ** 2 * (9 * g**2 + 12 * g + 10) / D, rel=1e-9)
    assert Q[0, 0] == pytest.approx((F_MM / HALF_MM**2) ** 2 * 9 / D, rel=1e-9)
    assert Q[5, 5] == pytest.approx((H_M / HALF_MM) ** 2 / 12, rel=1e-9)
    assert Q[2, 2] == pytest.approx(1 / HALF_MM**2 / 12, rel=1e-9)


def test_the_cofactor_matrix_is_the_inverse_of_the_normal_matrix() -> None:
    image, ground, station, Q = vertical_photo(F_MM)
    problem = ResectionProblem(image, np.tile(np.eye(2), (9, 1, 1)), ground_knowledge(ground, None, None), F_MM)
    linear = problem.linearise(Orientation(np.eye(3), station, ground))
    R_scaled = linear.triangle / linear.scales
    scaled_Q = cofactor_matrix(linear) / np.outer(linear.scales, linear.scales)
    assert scaled_Q @ (linear.triangle.T @ linear.triangle) == pytest.approx(np.eye(6), abs=1e-9)
    A = partials_rotation(ground, station, np.eye(3), F_MM)[:, :, :6].reshape(-1, 6)
    assert R_scaled.T @ R_scaled == pytest.approx(A.T @ A, rel=1e-9, abs=1e-9)
    sizes = np.sqrt(np.diag(Q))
    assert cofactor_matrix(linear) / np.outer(sizes, sizes) == pytest.approx(Q / np.outer(sizes, sizes), abs=1e-9)


def test_rows_of_the_vertical_photo_are_minus_the_scaled_partials() -> None:
    """(5): (1, 0, xi, g + xi^2, xi eta, -eta), (0, 1, eta, xi eta, g + eta^2, xi), unknowns scaled as in (11)."""
    c, H = HALF_MM, H_M
    image, ground, station, _ = vertical_photo(F_MM)
    partials = partials_aok(ground, station, np.eye(3), F_MM)[:, :, [3, 4, 5, 0, 1, 2]]
    scaled = partials * np.array([H * c / F_MM, H * c / F_MM, H, F_MM / c, F_MM / c, 1.0]) / c
    xi, eta = image.T / c
    g, one, zero = (F_MM / c) ** 2, np.ones(9), np.zeros(9)
    in_x = np.column_stack([one, zero, xi, g + xi**2, xi * eta, -eta])
    in_y = np.column_stack([zero, one, eta, xi * eta, g + eta**2, xi])
    assert -scaled[:, 0] == pytest.approx(in_x, abs=1e-12)
    assert -scaled[:, 1] == pytest.approx(in_y, abs=1e-12)


def test_pair_covariance_is_C_Q_C() -> None:
    """(3): K_jk = C_j Q C_k', and one reading more adds the unit matrix in image scale."""
    _, _, station, Q = vertical_photo(F_MM)
    places, up = HALF_MM * np.array([[0.5, 0.25], [-0.75, 0.5]]), np.tile(UP, (2, 1))
    points = ray_at_height(places, station, np.eye(3), F_MM, np.zeros((2, 3)), up)
    jacobians = ray_at_height_jacobians(points, station, np.eye(3), F_MM, up)
    found = ground_covariance(jacobians, Q, np.tile(np.eye(2), (2, 1, 1)), np.zeros(2))
    image_scale = (F_MM / H_M) ** 2
    assert image_scale * found.orientation[0, 0, 0] == pytest.approx(0.168692129630, rel=1e-9)
    assert image_scale * found.reading[:, :2, :2] == pytest.approx(np.tile(np.eye(2), (2, 1, 1)), abs=1e-9)
    pair = pair_covariance(covariance_factor(jacobians, Q), np.array([0]), np.array([1]))[0]
    assert image_scale * pair == pytest.approx(image_scale * jacobians.C[0] @ Q @ jacobians.C[1].T, abs=1e-9)
