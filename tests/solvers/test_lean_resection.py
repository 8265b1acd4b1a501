"""Lean and batched resections against the full adjustment, with and without the compiled kernel."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from orient.geometry.collinearity import partials_rotation, project
from orient.geometry.rotation import matrix_from_opk
from orient.solvers import resection_batch as module
from orient.solvers.lean_resection import lean_resection
from orient.solvers.resection import resect
from orient.solvers.resection_batch import by_numpy, resection_batch

Array = NDArray[np.float64]
F_MM, SIGMA_MM = 300.0, 0.005
POINT_COVARIANCE = np.diag([4.0, 4.0, 9.0])


@dataclass(frozen=True)
class Photo:
    """A space photo 250 km above relief of 3 km; rough values 3 % and 6 degrees off."""

    image: Array
    ground: Array
    given: Array
    R0: Array
    S0: Array


def photo(n: int, seed: int) -> Photo:
    rng = np.random.default_rng(seed)
    ground = np.column_stack([rng.uniform(-75000, 75000, (n, 2)), rng.uniform(0, 3000, n)])
    R, S = matrix_from_opk(*rng.uniform(-0.1, 0.1, 3)).T, np.array([3000.0, -2000.0, 250000.0])
    image = project(ground, S, R, F_MM)[0] + rng.normal(scale=SIGMA_MM, size=(n, 2))
    given = ground + rng.normal(size=(n, 3)) * np.sqrt(np.diag(POINT_COVARIANCE))
    R0 = matrix_from_opk(*rng.uniform(-0.1, 0.1, 3)).T @ R
    return Photo(image, ground, given, R0, S + rng.normal(scale=8000, size=3))


def in_sigmas(values: Array, Q: Array) -> float:
    return float(np.max(np.abs(values) / (SIGMA_MM * np.sqrt(np.diag(Q)))))


@pytest.mark.parametrize("n", [6, 20, 1000])
def test_the_optimum_is_that_of_the_full_adjustment(n: int) -> None:
    one = photo(n, n)
    full = resect(one.image, np.tile(np.eye(2), (n, 1, 1)), one.ground, F_MM)
    lean = lean_resection(one.image, one.ground, F_MM, one.R0, one.S0)
    turned = lean.rotation @ full.rotation.T
    apart = [turned[2, 1], turned[0, 2], turned[1, 0], *(lean.station - full.station)]
    assert lean.converged
    assert in_sigmas(np.array(apart), full.Q) < 1e-6  # rotation to eps of the matrix: 1e-16 of 1e-9 rad
    assert lean.vPv == pytest.approx(full.vPv, rel=1e-10)
    assert np.allclose(lean.Q, full.Q, rtol=1e-8, atol=1e-8 * np.sqrt(np.outer(np.diag(full.Q), np.diag(full.Q))).max())


@pytest.mark.parametrize("n", [6, 100])
def test_weighted_control(n: int) -> None:
    one = photo(n, n)
    S = np.tile(POINT_COVARIANCE / SIGMA_MM**2, (n, 1, 1))
    identity = np.tile(np.eye(3), (n, 1, 1))
    weight = np.linalg.inv(S)
    full = resect(one.image, np.tile(np.eye(2), (n, 1, 1)), one.given, F_MM, ground_free=identity, ground_weight=weight)
    lean = lean_resection(one.image, one.given, F_MM, one.R0, one.S0, S)
    assert lean.ground is not None and lean.vPv == pytest.approx(full.vPv, rel=1e-9)
    assert np.abs(lean.ground - full.ground).max() < 1e-6  # m, of coordinates of 1e5 m
    K = lean.joint_cofactors
    assert np.array_equal(K, K.T)
    blocks = K[6:, 6:].reshape(n, 3, n, 3)[np.arange(n), :, np.arange(n)]
    assert np.allclose(blocks, full.ground_cofactors, rtol=0, atol=1e-8 * np.abs(full.ground_cofactors).max())
    dense = _dense_cofactors(lean.rotation, lean.station, lean.ground)
    scale = np.sqrt(np.diag(dense))
    assert np.abs((K - dense) / np.outer(scale, scale)).max() < 1e-7  # the dense inverse loses some digits itself


def _dense_cofactors(R: Array, S: Array, P: Array) -> Array:
    """Inverse of the normal equations of the elements and all points."""
    partials = partials_rotation(P, S, R, F_MM)
    n = len(P)
    A = np.zeros((2 * n, 6 + 3 * n))
    A[:, :6] = partials[:, :, :6].reshape(-1, 6)
    for i in range(n):
        A[2 * i : 2 * i + 2, 6 + 3 * i : 9 + 3 * i] = partials[i, :, 6:]
    N = A.T @ A
    N[6:, 6:] += np.kron(np.eye(n), np.linalg.inv(POINT_COVARIANCE / SIGMA_MM**2))
    scale = 1 / np.sqrt(np.diag(N))
    return np.asarray(np.linalg.inv(N * np.outer(scale, scale)) * np.outer(scale, scale))


def batch(p: int, n: int) -> tuple[Array, Array, Array, Array]:
    photos = [photo(n, seed) for seed in range(p)]
    return tuple(np.array([getattr(one, name) for one in photos]) for name in ("image", "ground", "R0", "S0"))  # type: ignore[return-value]


def test_a_batch_is_its_photos_one_by_one() -> None:
    image, ground, R0, S0 = batch(600, 12)  # more than one block
    many = resection_batch(image, ground, F_MM, R0, S0, compiled=False)
    assert many.converged.all()
    for i in (0, 511, 512, 599):
        lean = lean_resection(image[i], ground[i], F_MM, R0[i], S0[i])
        assert in_sigmas(many.station[i] - lean.station, lean.Q[3:, 3:]) < 1e-6
        assert np.allclose(many.Q[i], lean.Q, rtol=0, atol=1e-8 * np.abs(lean.Q).max())


def test_without_rough_values_and_with_bad_ones() -> None:
    image, ground, R0, S0 = batch(3, 12)
    wrong = np.array([1.0, 1.0, -1.0]) * S0
    told = resection_batch(image, ground, F_MM, R0, S0)
    for found in (resection_batch(image, ground, F_MM), resection_batch(image, ground, F_MM, R0, wrong)):
        assert found.converged.all()
        assert np.allclose(found.station, told.station, rtol=0, atol=1e-4)  # m; sigma is some 20 m


def test_a_photo_without_a_solution_is_marked_and_spoils_no_other() -> None:
    image, ground, R0, S0 = batch(3, 12)
    image[1] = np.random.default_rng(1).uniform(-90, 90, (12, 2))
    ground[1] = ground[1, :1]  # all points in one place
    found = resection_batch(image, ground, F_MM, R0, S0)
    assert found.converged.tolist() == [True, False, True]
    assert np.isnan(found.Q[1]).all() and np.isfinite(found.Q[[0, 2]]).all()


def test_the_compiled_sums_are_the_same() -> None:
    kernel = pytest.importorskip("orient.solvers.resection_kernel", reason="numba is not installed: orient[fast]")
    image, ground, R0, S0 = batch(40, 12)
    found = [resection_batch(image, ground, F_MM, R0, S0, compiled=choice) for choice in (False, True)]
    for name in ("rotation", "station", "Q", "vPv"):
        one, other = (getattr(result, name) for result in found)
        scale = np.abs(one).max()
        assert np.allclose(one, other, rtol=0, atol=1e-9 * scale), name
    assert module._solver(None, module.COMPILED_FROM) is kernel.by_kernel
    assert module._solver(None, module.COMPILED_FROM - 1) is by_numpy
