"""K = C Q C': the numbers of seed 003, central differences, Monte Carlo, error ellipses."""

import os
import subprocess
import sys

import numpy as np
import pytest

from orient.geometry.collinearity import partials_rotation, project
from orient.geometry.rotation import rotation_exp
from orient.solvers.ground_covariance import (
    POINTS_AT_ONCE,
    STRIP,
    RayJacobians,
    all_pairs,
    covariance_by_orientation,
    covariance_factor,
    error_ellipses,
    ground_covariance,
    orientation_covariance,
    pair_covariance,
    ray_at_height,
    ray_at_height_jacobians,
)
from tests.jacobian import central_difference
from tests.solvers.resection_scenes import FloatArray, generator, looking

UP = np.array([0.0, 0.0, 1.0])
H = 250e3
STATION = np.array([0.0, 0.0, H])
GRID = np.array([[x, y] for y in (1.0, 0.0, -1.0) for x in (-1.0, 0.0, 1.0)])


def vertical(layout: FloatArray, f: float, c: float, relief: FloatArray | float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Cofactors (6, 6) of a vertical photo of control at x/c, y/c = `layout`, and the full ground (n, 3)."""
    Z = np.broadcast_to(np.asarray(relief) * H, len(layout))
    ground = np.column_stack([layout * c / f * (H - Z)[:, None], Z])
    A = partials_rotation(ground, STATION, np.eye(3), f)[:, :, :6].reshape(-1, 6)
    scale = 1 / np.linalg.norm(A, axis=0)
    R = np.linalg.qr(A * scale, mode="r")
    root = scale[:, None] * np.linalg.inv(R)
    return root @ root.T, ground


def in_image_scale(Q: FloatArray, point: tuple[float, float], f: float, c: float) -> FloatArray:
    """K of one new point on flat ground, divided by (H / f)^2."""
    ground = np.array([[point[0] * c * H / f, point[1] * c * H / f, 0.0]])
    jacobians = ray_at_height_jacobians(ground, STATION, np.eye(3), f, UP[None])
    K = ground_covariance(jacobians, Q, np.zeros((1, 2, 2)), np.zeros(1)).orientation[0]
    return K * (f / H) ** 2


LAYOUTS = {
    "3x3 grid": (GRID, 0.168692129630),
    "corners and centre": (GRID[[0, 2, 4, 6, 8]], 0.305338541667),
    "rectangle 1:0.5": (GRID * [1.0, 0.5], 0.224537037037),
}


@pytest.mark.parametrize("ratio", [0.8, 1.0, 2.2, 6.7, 20.0])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_seed_003_table_does_not_depend_on_the_focal_length(layout: str, ratio: float) -> None:
    """EQUATIONS 3.2: K_XX of the point (.5, .25) for f/c = 0.8 ... 20; from a full 6x6 Q it keeps 1e-9 at f/c = 20."""
    points, K_XX = LAYOUTS[layout]
    c = 90.0
    Q, _ = vertical(points, ratio * c, c)
    assert in_image_scale(Q, (0.5, 0.25), ratio * c, c)[0, 0] == pytest.approx(K_XX, abs=1e-9)


def test_relief_breaks_the_invariance() -> None:
    """EQUATIONS 3.2 (a): with relief K depends on f/c; here a chessboard of +-20 % of H."""
    relief = 0.2 * np.where(np.arange(9) % 2 == 0, 1.0, -1.0)
    c = 90.0
    K_XX = [in_image_scale(vertical(GRID, f, c, relief)[0], (0.5, 0.25), f, c)[0, 0] for f in (c, 2.2 * c, 6.7 * c)]
    assert np.ptp(K_XX) > 1e-3


@pytest.mark.parametrize(("f_mm", "c_mm"), [(152.0, 90.0), (305.0, 115.0), (1000.0, 150.0)])
def test_corner_of_the_photo_is_3402_nm(f_mm: float, c_mm: float) -> None:
    """3 x 3 points, sigma 5 um: 3.402 um at the corner whatever the camera; the diagonal of Q alone is far off."""
    Q, _ = vertical(GRID, f_mm, c_mm)
    K = in_image_scale(Q, (1.0, 1.0), f_mm, c_mm)
    assert f"{5 * np.sqrt(K[0, 0]):.3f}" == "3.402"
    alone = in_image_scale(np.diag(np.diag(Q)), (1.0, 1.0), f_mm, c_mm)
    assert alone[0, 0] > 9 * K[0, 0]


def oblique(n: int = 6) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    random = generator("oblique")
    rotation, station = looking(0.7, 0.8, 0.4), np.array([300.0, -200.0, 1500.0])
    image = random.uniform(-40, 40, (n, 2))
    up = random.normal(size=(n, 3)) * 0.02 + UP
    return image, rotation, station, up / np.linalg.norm(up, axis=1, keepdims=True)


def test_point_lies_on_its_ray_and_at_its_height() -> None:
    image, rotation, station, up = oblique()
    heights = np.array([[1e3, 2e3, 30.0 * k] for k in range(6)])
    points = ray_at_height(image, station, rotation, 150.0, heights, up)
    np.testing.assert_allclose(project(points, station, rotation, 150.0)[0], image, atol=1e-9)
    np.testing.assert_allclose(np.sum(up * (points - heights), axis=1), 0, atol=1e-8)


def test_jacobians_are_central_differences() -> None:
    image, rotation, station, up = oblique()
    heights = np.zeros((6, 3))
    points = ray_at_height(image, station, rotation, 150.0, heights, up)

    def moved(d: FloatArray) -> FloatArray:
        turned = rotation_exp(d[:3]) @ rotation
        return ray_at_height(image + d[6:8], station + d[3:6], turned, 150.0, heights + d[8] * up, up)

    steps = np.array([1e-6] * 3 + [1e-2] * 3 + [1e-4] * 2 + [1e-2])
    numeric = central_difference(moved, np.zeros(9), steps)
    jacobians = ray_at_height_jacobians(points, station, rotation, 150.0, up)
    np.testing.assert_allclose(jacobians.C, numeric[:, :, :6], rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(jacobians.J, numeric[:, :, 6:8], rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(jacobians.h, numeric[:, :, 8], rtol=1e-6, atol=1e-8)


def test_parts_agree_with_a_simulation() -> None:
    image, rotation, station, up = oblique(2)
    random = generator("simulation")
    root = random.normal(size=(6, 6)) * np.array([1e-4] * 3 + [0.2] * 3)[:, None]
    Q, reading, sigma_H = root @ root.T, np.tile(np.diag([1e-4, 4e-4]), (2, 1, 1)), np.array([1.0, 2.0])
    points = ray_at_height(image, station, rotation, 150.0, np.zeros((2, 3)), up)
    jacobians = ray_at_height_jacobians(points, station, rotation, 150.0, up)
    parts = ground_covariance(jacobians, Q, reading, sigma_H**2)
    trials = []
    for _ in range(4000):
        e, xy = root @ random.normal(size=6), image + random.normal(size=(2, 2)) * [0.01, 0.02]
        heights = (sigma_H * random.normal(size=2))[:, None] * up
        turned = rotation_exp(e[:3]) @ rotation
        trials.append(ray_at_height(xy, station + e[3:], turned, 150.0, heights, up).ravel())
    sample = np.cov(np.array(trials).T)
    sigma = np.sqrt(np.diag(sample))
    total = parts.total
    factor = covariance_factor(jacobians, Q)
    between = pair_covariance(factor, np.array([0]), np.array([1]))[0]
    predicted = np.block([[total[0], between], [between.T, total[1]]])
    np.testing.assert_allclose(predicted / np.outer(sigma, sigma), sample / np.outer(sigma, sigma), atol=0.1)


def test_all_parts_lie_in_the_level_plane_except_the_height() -> None:
    image, rotation, station, up = oblique()
    points = ray_at_height(image, station, rotation, 150.0, np.zeros((6, 3)), up)
    jacobians = ray_at_height_jacobians(points, station, rotation, 150.0, up)
    Q = np.diag([1e-8] * 3 + [1.0] * 3)
    parts = ground_covariance(jacobians, Q, np.tile(np.eye(2) * 1e-4, (6, 1, 1)), np.full(6, 4.0))
    along = np.einsum("ni,nij,nj->n", up, parts.total, up)
    np.testing.assert_allclose(along, 4.0, rtol=1e-9)
    np.testing.assert_allclose(parts.orientation, parts.orientation.transpose(0, 2, 1))


def test_level_and_backward_rays_have_no_point() -> None:
    rotation, station = looking(0.0, np.pi / 2, 0.0), np.array([0.0, 0.0, 10.0])
    image = np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 0.0]])
    image[1:, :] = (rotation.T @ [1.0, 0.0, -0.5])[:2] * 100, (rotation.T @ [1.0, 0.0, 0.5])[:2] * 100
    up = np.tile(UP, (3, 1))
    points = ray_at_height(image, station, rotation, 100.0, np.zeros((3, 3)), up)
    assert np.isnan(points[0]).all()
    assert points[1] == pytest.approx([20.0, 0.0, 0.0])
    assert np.isnan(points[2]).all()
    jacobians = ray_at_height_jacobians(points, station, rotation, 100.0, up)
    assert jacobians.determined.tolist() == [False, True, False]


def test_factor_serves_singular_covariances() -> None:
    image, rotation, station, up = oblique()
    points = ray_at_height(image, station, rotation, 150.0, np.zeros((6, 3)), up)
    jacobians = ray_at_height_jacobians(points, station, rotation, 150.0, up)
    Q = np.diag([0.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    factor = covariance_factor(jacobians, Q)
    np.testing.assert_allclose(factor @ factor.transpose(0, 2, 1), jacobians.C @ Q @ jacobians.C.transpose(0, 2, 1))


@pytest.mark.parametrize(
    ("covariance", "a", "b", "azimuth_deg"),
    [
        ([[4.0, 0.0], [0.0, 1.0]], 2.0, 1.0, 0.0),
        ([[1.0, 0.0], [0.0, 4.0]], 2.0, 1.0, 90.0),
        ([[2.5, 1.5], [1.5, 2.5]], 2.0, 1.0, 45.0),
        ([[2.5, -1.5], [-1.5, 2.5]], 2.0, 1.0, 135.0),
        ([[3.0, 0.0], [0.0, 3.0]], np.sqrt(3), np.sqrt(3), 0.0),
        ([[1.0, 1.0], [1.0, 1.0]], np.sqrt(2), 0.0, 45.0),
        ([[0.0, 0.0], [0.0, 0.0]], 0.0, 0.0, 0.0),
        ([[4.0, -1e-30], [-1e-30, 1.0]], 2.0, 1.0, 0.0),
    ],
    ids=["along first", "along second", "45", "135", "circle", "line", "point", "along first but for rounding"],
)
def test_error_ellipse(covariance: list[list[float]], a: float, b: float, azimuth_deg: float) -> None:
    ((found_a, found_b, azimuth),) = error_ellipses(np.array([covariance]))
    assert (found_a, found_b) == pytest.approx((a, b), abs=1e-12)
    assert np.degrees(azimuth) == pytest.approx(azimuth_deg, abs=1e-9)


@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
@pytest.mark.parametrize("n", [5, POINTS_AT_ONCE + 7], ids=["few", "more than one part"])
@pytest.mark.parametrize("tilt", [0.0, 0.6, 1.3])
def test_the_covariance_without_partials_is_that_of_the_partials(tilt: float, n: int, compiled: bool) -> None:
    """Own verticals and a full Q; relative to the largest variance of the point."""
    _need_numba(compiled)
    random = generator(f"without partials {tilt} {n}")
    R = rotation_exp([tilt, 0.2, -0.4])
    A = random.normal(size=(12, 6))
    Q = np.linalg.inv(A.T @ A) * np.outer(*[[1e-5] * 3 + [2.0] * 3] * 2)
    points = random.uniform([-8e4, -8e4, 0.0], [8e4, 8e4, 3e3], (n, 3))
    up = UP + random.normal(scale=0.01, size=(n, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    expected = orientation_covariance(ray_at_height_jacobians(points, STATION, R, 152.7, up), Q)
    found = covariance_by_orientation(points, STATION, Q, up, compiled=compiled)
    scale = np.trace(expected, axis1=1, axis2=2)[:, None, None]
    np.testing.assert_allclose(found / scale, expected / scale, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(found, found.transpose(0, 2, 1))


def _need_numba(compiled: bool) -> None:
    if compiled:
        pytest.importorskip("orient.solvers.ground_kernel", reason="numba is not installed: orient[fast]")


@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
@pytest.mark.parametrize("n", [0, 1, 300])
def test_the_plan_is_a_part_of_the_whole(n: int, compiled: bool) -> None:
    """Points that stand apart in memory; own verticals, and one for all."""
    _need_numba(compiled)
    random = generator(f"plan {n}")
    A = random.normal(size=(12, 6))
    points = random.uniform(-8e4, 8e4, (n, 6))[:, ::2]
    for up in (UP, (UP + random.normal(scale=0.01, size=(n, 6))[:, 1::2])):
        given = points, STATION, A.T @ A, up
        plan, whole = (covariance_by_orientation(*given, plan=choice, compiled=compiled) for choice in (True, False))
        np.testing.assert_array_equal(plan, whole[:, :2, :2])
        apart = whole - covariance_by_orientation(*given)
        assert np.max(np.abs(apart), initial=0.0) <= 1e-9 * np.max(whole, initial=0.0)


@pytest.mark.parametrize("n", [0, 1, 3 * POINTS_AT_ONCE + 5])
@pytest.mark.parametrize(("rows", "u"), [(1, 6), (2, 6), (3, 6), (3, 9)])
def test_the_compiled_covariance_of_given_partials(rows: int, u: int, n: int) -> None:
    """Partials that stand apart in memory; NaN of a level ray stays with its point."""
    _need_numba(True)
    random = generator(f"partials {rows} {u} {n}")
    C, A = random.normal(size=(n, rows, 2 * u))[:, :, ::2], random.normal(size=(2 * u, u))
    C[1:2] = np.nan
    jacobians = RayJacobians(C, np.zeros((n, rows, 2)), np.zeros((n, rows)))
    plain, compiled = (orientation_covariance(jacobians, A.T @ A, compiled=choice) for choice in (False, True))
    np.testing.assert_allclose(compiled, plain, rtol=0, atol=1e-11)
    np.testing.assert_array_equal(compiled, compiled.transpose(0, 2, 1))


@pytest.mark.parametrize("compiled", [False, True], ids=["numpy", "numba"])
def test_level_rays_have_no_covariance_without_partials_either(compiled: bool) -> None:
    _need_numba(compiled)
    points = np.array([[1e5, 0.0, H], [1e5, 0.0, 0.0]])
    K = covariance_by_orientation(points, STATION, np.eye(6), UP, compiled=compiled)
    assert np.isnan(K[0]).all() and np.isfinite(K[1]).all()


@pytest.mark.parametrize("m", [1, 7, STRIP - 1, STRIP, STRIP + 1, 333, 8 * STRIP, 1061])
@pytest.mark.parametrize("u", [6, 9])
def test_all_pairs_are_symmetric_to_the_last_bit(u: int, m: int) -> None:
    F = generator(f"pairs {u} {m}").normal(size=(m, u))
    K = all_pairs(F)
    np.testing.assert_array_equal(K, K.T)
    np.testing.assert_allclose(K, F @ F.T, rtol=0, atol=1e-13)


@pytest.mark.parametrize("kernels", ["Prescott", "Nehalem", "Sandybridge", "Haswell"])
def test_all_pairs_are_symmetric_with_the_kernels_of_other_processors(kernels: str) -> None:
    program = """
import numpy as np
from orient.solvers.ground_covariance import all_pairs
rng = np.random.default_rng(1)
for m in (33, 97, 320, 517):
    K = all_pairs(rng.normal(size=(m, 6)))
    assert (K == K.T).all(), m
"""
    subprocess.run([sys.executable, "-c", program], env={**os.environ, "OPENBLAS_CORETYPE": kernels}, check=True)


def test_a_product_that_is_not_symmetric_is_mirrored(monkeypatch: pytest.MonkeyPatch) -> None:
    F, product = generator("mirrored").normal(size=(3 * STRIP + 5, 6)), np.matmul

    def place_decides(a: FloatArray, b: FloatArray, *, out: FloatArray) -> None:
        product(a, b, out=out)
        out[:, STRIP + 1] *= 1.0 + 1e-15

    monkeypatch.setattr(np, "matmul", place_decides)
    K = all_pairs(F)
    np.testing.assert_array_equal(K, K.T)
    np.testing.assert_allclose(K, F @ F.T, rtol=1e-14, atol=1e-14)
