"""Redundancy numbers, w, tau, smallest findable errors and their effects, against dense matrices and closed forms."""

import numpy as np
import pytest
from scipy.special import betainc, nctdtr

from orient.geometry.rotation import rotation_exp
from orient.solvers.common_unknowns import CommonUnknowns, whitened
from orient.solvers.critical_values import DELTA0, W_CRITICAL, chance, global_test, tau_limits, w_limits
from orient.solvers.ground_covariance import ray_at_height
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.reliability import (
    Blocks,
    block_statistic,
    most_correlated,
    observation_tests,
    prediction_statistic,
)
from orient.solvers.resection import Resection, resect
from orient.solvers.resection_reliability import (
    IMAGE,
    Measured,
    control_blocks,
    far_apart,
    largest_ground_shift,
    other_blocks,
)
from tests.solvers.linear_models import blocks_of
from tests.solvers.resection_scenes import FloatArray, generator, scene

SIGMA = 0.005


def test_limits_are_those_of_baarda() -> None:
    assert pytest.approx(3.2905, abs=5e-5) == W_CRITICAL
    assert pytest.approx(4.1321, abs=5e-5) == DELTA0
    assert pytest.approx(17.075, abs=5e-4) == DELTA0**2


@pytest.mark.parametrize("r", [2, 3, 10, 18, 432])
def test_tau_squared_over_r_is_beta_distributed(r: int) -> None:
    limits = tau_limits(4.0 * r, r)
    assert limits.sigma0 == pytest.approx(2.0)
    assert betainc(0.5, (r - 1) / 2, limits.critical**2 / r) == pytest.approx(0.999, abs=1e-9)
    t = limits.critical * np.sqrt((r - 1) / (r - limits.critical**2))
    assert 1 - nctdtr(r - 1, limits.delta0, t) == pytest.approx(0.80, abs=1e-4)


def test_tau_cannot_test_with_one_redundant_equation() -> None:
    assert tau_limits(1.0, 1).critical == np.inf


def test_global_test_accepts_95_percent() -> None:
    test = global_test(10.0, 10, 1.0)
    assert (test.lower, test.upper) == pytest.approx((3.247, 20.483), abs=1e-3)  # chi^2 tables, r = 10
    assert test.verdict == "accepted"
    assert global_test(33.96, 10, 1.0).verdict == "too large"
    assert global_test(3.0, 10, 1.0).verdict == "too small"


def test_levelling_loop_by_hand() -> None:
    """h1 + h2 + h3 = 0 with a misclosure of 6 mm: v = -2 mm each, r = 1/3, w = 6/(sigma sqrt 3), MDB = delta0 sigma
    sqrt 3."""
    A = np.array([[[1.0, 0.0]], [[0.0, 1.0]], [[-1.0, -1.0]]])
    (test,) = observation_tests([blocks_of(A, -np.array([[12.0], [13.0], [-19.0]]))], w_limits(2.0), 2).tests
    assert test.redundancy.ravel() == pytest.approx([1 / 3] * 3)
    assert np.abs(test.w).ravel() == pytest.approx([6 / (2 * np.sqrt(3))] * 3)
    assert test.mdb.ravel() == pytest.approx([DELTA0 * 2 * np.sqrt(3)] * 3)
    # an error of one leg cannot be told from one of the others
    assert most_correlated([test], [(0, 0, 0)])[0, 0, 0].rho == pytest.approx(1.0)


def random_blocks(name: str) -> tuple[Blocks, FloatArray]:
    """Eight blocks of three correlated observations, four unknowns."""
    random = generator(name)
    A, L = random.normal(size=(8, 3, 4)), random.normal(size=(8, 3))
    C = random.normal(size=(8, 3, 3))
    P = np.linalg.inv(C @ C.transpose(0, 2, 1) + 0.3 * np.eye(3))
    return blocks_of(A, L, P), P


def dense(blocks: Blocks, P: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """P (24, 24), Q_v, Q of the unknowns and A, by the textbook."""
    A = blocks.design.reshape(24, 4)
    whole = np.zeros((24, 24))
    for i in range(8):
        whole[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = P[i]
    Q = np.linalg.inv(A.T @ whole @ A)
    return whole, np.linalg.inv(whole) - A @ Q @ A.T, Q, A


def test_correlated_observations_against_dense_matrices() -> None:
    blocks, weights = random_blocks("dense")
    sigma0 = 1.7
    (test,) = observation_tests([blocks], w_limits(sigma0), 2).tests
    P, Q_v, Q, A = dense(blocks, weights)
    PQP, v = P @ Q_v @ P, blocks.residuals.ravel()
    assert test.redundancy.ravel() == pytest.approx(np.diag(Q_v @ P), abs=1e-12)
    assert test.share.ravel() == pytest.approx(np.diag(PQP) / np.diag(P), abs=1e-12)
    assert test.w.ravel() == pytest.approx(P @ v / (sigma0 * np.sqrt(np.diag(PQP))), abs=1e-12)
    mdb = DELTA0 * sigma0 / np.sqrt(np.diag(PQP))
    assert test.mdb.ravel() == pytest.approx(mdb)
    effect = (Q @ A.T @ P * mdb).T[:, 2:]
    assert test.effect.reshape(24, 2) == pytest.approx(effect, abs=1e-12)
    noise = np.sqrt(np.einsum("ni,ij,nj->n", effect, np.linalg.inv(Q[2:, 2:]), effect)) / sigma0
    assert test.bias_to_noise.ravel() == pytest.approx(noise)
    correlation = np.abs(PQP / np.sqrt(np.outer(np.diag(PQP), np.diag(PQP))))
    correlation[:3, :3] = 0
    near = most_correlated([test], [(0, 0, 1)])[0, 0, 1]
    assert near.rho == pytest.approx(correlation[1].max())
    assert 3 * near.partner[1] + near.partner[2] == int(correlation[1].argmax())
    T, freedom = block_statistic(test, (0, 1, 2), w_limits(sigma0))
    at = slice(3, 6)
    assert T[1] == pytest.approx((P @ v)[at] @ np.linalg.solve(PQP[at, at], (P @ v)[at]) / sigma0**2)
    assert list(freedom) == [3] * 8


def test_misfit_of_a_left_out_block_is_its_own_test() -> None:
    """Deleting a block and predicting it gives the same statistic as testing it in place."""
    random = generator("deletion")
    A, L = random.normal(size=(7, 2, 3)), random.normal(size=(7, 2))
    limits = w_limits(1.0)
    whole = observation_tests([blocks_of(A, L)], limits, 3)
    T, _ = block_statistic(whole.tests[0], (0, 1), limits)
    rest = blocks_of(A[1:], L[1:])
    x = -np.linalg.lstsq(A[1:].reshape(-1, 3), L[1:].ravel(), rcond=None)[0]
    left_out = Blocks(np.eye(2)[None], np.eye(2)[None], A[:1], A[:1] @ x + L[:1])
    predicted, freedom = prediction_statistic(left_out, observation_tests([rest], limits, 3), limits)
    assert predicted[0] == pytest.approx(T[0])
    assert freedom[0] == 2


def test_unchecked_observation_has_no_test() -> None:
    """The last unknown is in the last observation only."""
    A = np.array([[[1.0, 0.0]], [[1.0, 0.0]], [[1.0, 0.0]], [[1.0, 1.0]]])
    (test,) = observation_tests([blocks_of(A, np.array([[1.0], [2.0], [0.0], [50.0]]))], w_limits(1.0), 2).tests
    assert test.redundancy.ravel() == pytest.approx([2 / 3, 2 / 3, 2 / 3, 0.0], abs=1e-15)
    for values in (test.w, test.mdb, test.bias_to_noise):
        assert np.isnan(values[3, 0])
        assert np.isfinite(values[:3]).all()
    assert np.isnan(block_statistic(test, (0,), w_limits(1.0))[0][3])
    assert most_correlated([test], [(0, 3, 0)]) == {}


def weighted_scene(name: str, with_common: bool) -> tuple[Resection, Measured, CommonUnknowns | None]:
    """Twelve points: six weighted, one without height, one with a weighted height only; correlated image weights."""
    random = generator(name)
    made = scene(random, 12)
    free, weight = np.zeros((12, 3, 3)), np.zeros((12, 3, 3))
    free[:6] = np.eye(3)
    weight[:6] = np.diag((SIGMA / np.array([0.05, 0.06, 0.1])) ** 2)
    free[6] = np.diag([0.0, 0.0, 1.0])
    free[7] = np.eye(3)
    weight[7] = np.diag([0.0, 0.0, (SIGMA / 0.1) ** 2])
    ground = made.ground.copy()
    ground[:6] += random.normal(size=(6, 3)) * [0.05, 0.06, 0.1]
    cofactor = np.tile([[1.0, 0.3], [0.3, 1.5]], (12, 1, 1))
    shift = np.zeros((12, 3, 2))
    shift[:5, 0, 0] = shift[:5, 1, 1] = 1.0
    common = CommonUnknowns(shift, np.array([[4.0, 0.8], [0.8, 8.0]]), ["a", "b"]) if with_common else None
    image = made.noisy(SIGMA, random)
    found = resect(image, cofactor, ground, made.f_mm, ground_free=free, ground_weight=weight, common=common)
    by_common = whitened(common, 12).by_ground
    points = Measured(
        image, cofactor, ground_knowledge(ground, free, weight), by_common, np.zeros((12, 2, by_common.shape[2]))
    )
    return found, points, common


@pytest.mark.parametrize("with_common", [False, True], ids=["points alone", "common unknowns"])
def test_resection_numbers_agree_and_sum_to_the_redundancy(with_common: bool) -> None:
    found, points, common = weighted_scene("sum", with_common)
    tests = observation_tests(control_blocks(found, points, whitened(common, 12), np.eye(3)), w_limits(SIGMA), 6).tests
    assert sum(np.nansum(test.redundancy) for test in tests) == pytest.approx(found.redundancy, abs=1e-12)
    assert tests[0].redundancy[:, :2] == pytest.approx(found.redundancy_numbers, abs=1e-11)
    assert np.nansum(tests[0].redundancy[:, 2:], axis=1) == pytest.approx(found.ground_redundancy, abs=1e-11)
    if with_common:
        assert tests[1].redundancy[0] == pytest.approx(found.common_redundancy, abs=1e-11)
    # one direction of the seventh point is checked, nothing of the eighth, whose plan is free
    T, freedom = block_statistic(tests[0], IMAGE, w_limits(SIGMA))
    assert list(freedom[6:9]) == [1, 0, 2]
    assert np.isnan(T[7])


def test_effect_is_what_an_error_does_to_the_elements() -> None:
    random = generator("effect")
    made = scene(random, 9)
    image = made.noisy(SIGMA, random)
    found = resect(image, made.unit, made.ground, made.f_mm)
    points = Measured(
        image, made.unit, ground_knowledge(made.ground, None, None), np.zeros((9, 3, 0)), np.zeros((9, 2, 0))
    )
    shared = whitened(None, 9)
    (test,) = observation_tests(control_blocks(found, points, shared, np.eye(3)), w_limits(SIGMA), 6).tests
    up = np.tile([0.0, 0.0, 1.0], (9, 1))
    shift, place = largest_ground_shift(found, up, far_apart(image), test.effect)
    moved = image.copy()
    moved[4, 1] += test.mdb[4, 1]
    after = resect(moved, made.unit, made.ground, made.f_mm)
    assert after.station - found.station == pytest.approx(test.effect[4, 1, 3:], rel=0.02, abs=1e-3)
    turned = rotation_exp(test.effect[4, 1, :3]) @ found.rotation
    assert after.rotation == pytest.approx(turned, abs=1e-6)
    before, behind = (
        ray_at_height(found.computed, one.station, one.rotation, made.f_mm, made.ground, up) for one in (found, after)
    )
    shifts = np.linalg.norm(behind - before, axis=1)
    assert shift[4, 1] == pytest.approx(shifts.max(), rel=0.02)
    assert place[4, 1] == shifts.argmax()


def test_point_left_out_is_judged_like_one_that_is_in() -> None:
    """Another orientation is found without it, but its statistic is that of its own block, to linear precision."""
    random = generator("left out")
    made = scene(random, 10)
    image = made.noisy(SIGMA, random)
    limits, shared = w_limits(SIGMA), whitened(None, 10)
    points = Measured(
        image, made.unit, ground_knowledge(made.ground, None, None), np.zeros((10, 3, 0)), np.zeros((10, 2, 0))
    )
    whole = resect(image, made.unit, made.ground, made.f_mm)
    inside = observation_tests(control_blocks(whole, points, shared, np.eye(3)), limits, 6)
    T, _ = block_statistic(inside.tests[0], IMAGE, limits)
    rest = points.at(np.arange(1, 10))
    without = resect(image[1:], made.unit[1:], made.ground[1:], made.f_mm)
    tests = observation_tests(control_blocks(without, rest, whitened(None, 9), np.eye(3)), limits, 6)
    predicted, freedom = prediction_statistic(
        other_blocks(without, points.at(np.arange(1)), whitened(None, 1)), tests, limits
    )
    assert predicted[0] == pytest.approx(T[0], rel=1e-3)
    assert freedom[0] == 2


def test_probes_of_a_large_photo_cover_it() -> None:
    image = generator("probes").uniform(-100, 100, (5000, 2))
    chosen = image[far_apart(image)]
    assert len(chosen) == 60
    assert np.max(np.min(np.linalg.norm(image[:, None] - chosen[None], axis=2), axis=1)) < 25.0


@pytest.mark.parametrize("r", [3, 18, 432])
def test_chance_of_the_limit_is_alpha0(r: int) -> None:
    assert chance(W_CRITICAL, w_limits(1.0), r) == pytest.approx(0.001)
    limits = tau_limits(float(r), r)
    assert chance(limits.critical, limits, r) == pytest.approx(0.001)
    assert chance(np.sqrt(r) + 1.0, limits, r) == 0.0
