"""Lean and batched resections against the full adjustment, with and without the compiled kernel."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.scenes import F_MM, HEIGHT_M, POINT_SIGMA_M, SIGMA_MM, Photo, photo, photos
from orient.geometry.collinearity import partials_rotation, project
from orient.geometry.rotation import matrix_from_opk
from orient.solvers import lean_design
from orient.solvers import lean_resection as lean_module
from orient.solvers import resection_batch as module
from orient.solvers.batch_iteration import BatchResection
from orient.solvers.lean_resection import LeanResection, lean_resection
from orient.solvers.resection import resect
from orient.solvers.resection_batch import by_numpy, resection_batch

Array = NDArray[np.float64]
POINT_COVARIANCE = np.diag(POINT_SIGMA_M**2)
MOVED = np.array([500.0, -300.0, 900.0])
WAYS = {"alone": 3, "batch": 9, "compiled": 9, "compiled, in lanes": 39}
"""Photos that go together; a kernel takes sixteen at a time, or fewer one by one."""


def in_sigmas(values: Array, Q: Array) -> float:
    return float(np.max(np.abs(values) / (SIGMA_MM * np.sqrt(np.diag(Q)))))


@pytest.mark.parametrize("n", [6, 20, 64, 65, 1000, 2049, 4096, 5000])
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


@pytest.mark.parametrize("n", [6, 64, 65, 100])
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


def test_a_batch_is_its_photos_one_by_one() -> None:
    image, ground, R0, S0 = photos(600, 12)  # more than one block
    many = resection_batch(image, ground, F_MM, R0, S0, compiled=False)
    assert many.converged.all()
    for i in (0, 511, 512, 599):
        lean = lean_resection(image[i], ground[i], F_MM, R0[i], S0[i])
        assert in_sigmas(many.station[i] - lean.station, lean.Q[3:, 3:]) < 1e-6
        assert np.allclose(many.Q[i], lean.Q, rtol=0, atol=1e-8 * np.abs(lean.Q).max())


def test_threads_do_not_share_what_is_kept_between_calls() -> None:
    some = [photo(n, seed) for seed in range(4) for n in (6, 12, 13)]

    def solved(one: Photo) -> LeanResection:
        return lean_resection(one.image, one.ground, F_MM, one.R0, one.S0)

    expected = [solved(one) for one in some]
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(solved, some * 50))
    for one, other in zip(found, expected * 50, strict=True):
        assert np.array_equal(one.station, other.station) and np.array_equal(one.Q, other.Q)


def test_what_is_above_the_diagonal_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    """The lower triangles of the normal matrices are written into memory that holds anything."""
    image, ground, R0, S0 = photos(20, 12)
    expected = resection_batch(image, ground, F_MM, R0, S0, compiled=False)
    monkeypatch.setattr(lean_design.np, "empty", lambda shape, **kinds: np.full(shape, np.nan))
    found = resection_batch(image, ground, F_MM, R0, S0, compiled=False)
    assert found.converged.all()
    assert np.array_equal(found.Q, expected.Q)


def test_without_rough_values_and_with_bad_ones() -> None:
    image, ground, R0, S0 = photos(3, 12)
    wrong = np.array([1.0, 1.0, -1.0]) * S0
    told = resection_batch(image, ground, F_MM, R0, S0)
    for found in (resection_batch(image, ground, F_MM), resection_batch(image, ground, F_MM, R0, wrong)):
        assert found.converged.all()
        assert np.allclose(found.station, told.station, rtol=0, atol=1e-4)  # m; sigma is some 20 m


@pytest.mark.parametrize("place", ["one point", "a line", "a far point"])
@pytest.mark.parametrize("way", WAYS)
def test_a_photo_without_a_solution_is_marked_and_spoils_no_other(way: str, place: str) -> None:
    p = WAYS[way]
    image, ground, R0, S0 = photos(p, 12)
    image[1] = np.random.default_rng(1).uniform(-90, 90, (12, 2))
    along = np.linspace(0, 1, 12)[:, None]
    ground[1] = {"one point": ground[1, :1], "a line": ground[1, :1] * along, "a far point": ground[1, :1] + 1e7}[place]
    found = resection_batch(image, ground, F_MM, R0, S0, compiled=_is_compiled(way))
    assert found.converged.tolist() == [i != 1 for i in range(p)]
    assert np.isnan(found.Q[1]).all()
    assert np.isfinite(found.Q[found.converged]).all()


def _is_compiled(way: str) -> bool:
    if way.startswith("compiled"):
        pytest.importorskip("numba", reason="numba is not installed: orient[fast]")
        return True
    return False


@pytest.mark.parametrize(("p", "n"), [(1, 12), (15, 6), (16, 6), (40, 12), (20, 399), (20, 400), (2, 5000)])
def test_the_compiled_sums_are_the_same(p: int, n: int) -> None:
    """Photos in lanes and one by one, with some points first and with all; arrays that stand apart in memory."""
    kernel = pytest.importorskip("orient.solvers.resection_kernel", reason="numba is not installed: orient[fast]")
    image, ground, R0, S0 = (np.repeat(array, 2, axis=-1)[..., ::2] for array in photos(p, n))
    found = [resection_batch(image, ground, F_MM, R0, S0, compiled=choice) for choice in (False, True)]
    for name in ("rotation", "station", "Q", "vPv"):
        one, other = (getattr(result, name) for result in found)
        scale = np.abs(one).max()
        assert np.allclose(one, other, rtol=0, atol=1e-9 * scale), name
    assert all(result.converged.all() for result in found)
    assert found[0].iterations.tolist() == found[1].iterations.tolist()
    assert module._solver(None, module.COMPILED_FROM) is kernel.by_kernel
    assert module._solver(None, module.COMPILED_FROM - 1) is by_numpy


def _solved_as(way: str, image: Array, ground: Array, R0: Array, S0: Array) -> LeanResection | BatchResection:
    """One photo, alone or as the last of many."""
    if way == "alone":
        return lean_resection(image, ground, F_MM, R0, S0)
    many = [np.tile(array, (WAYS[way], *[1] * array.ndim)) for array in (image, ground, R0, S0)]
    return resection_batch(many[0], many[1], F_MM, many[2], many[3], compiled=_is_compiled(way))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("n", [3, 12])
def test_exact_readings_and_three_points_converge(way: str, n: int) -> None:
    one = photo(n, n)
    S, R = one.S0 + 100.0, one.R0
    found = _solved_as(way, project(one.ground, S, R, F_MM)[0], one.ground, R, S + MOVED)
    assert np.all(found.converged)
    assert np.all(np.asarray(found.iterations) < 8)
    assert np.abs(found.station - S).max() < 1e-5  # m, from 250 km: rounding, in three points' weak directions
    assert np.abs(found.rotation - R).max() < 1e-11


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("n", [4, 6, 20, 100])
def test_the_cofactors_are_those_of_the_optimum(way: str, n: int) -> None:
    """Q is that of the place before the last step; once more from the optimum it is exact."""
    for seed in range(10):
        one = photo(n, seed)
        found = _solved_as(way, one.image, one.ground, one.R0, one.S0)
        again = _solved_as(way, one.image, one.ground, *_pose(found))
        scale = np.sqrt(np.diag(np.atleast_3d(again.Q.T)[:, :, -1]))
        assert np.abs((found.Q - again.Q) / np.outer(scale, scale)).max() < 2e-8
        assert np.abs((found.station - again.station) / (SIGMA_MM * scale[3:])).max() < 2e-8


def _pose(found: LeanResection | BatchResection) -> tuple[Array, Array]:
    return found.rotation.reshape(-1, 3, 3)[-1], found.station.reshape(-1, 3)[-1]


def test_many_points_in_the_rhythm_of_a_grid() -> None:
    """Every sixteenth of these points lies on one line."""
    X, Y = np.meshgrid(np.linspace(-7e4, 7e4, 16), np.linspace(-7e4, 7e4, 400))
    ground = np.column_stack([X.ravel(), Y.ravel(), 1500.0 + 1500.0 * np.sin(X.ravel() / 9e3 + Y.ravel() / 7e3)])
    one = photo(6, 6)
    image = project(ground, one.S0, one.R0, F_MM)[0] + np.random.default_rng(1).normal(scale=SIGMA_MM, size=(6400, 2))
    lean = lean_resection(image, ground, F_MM, one.R0, one.S0 + 5000.0)
    few_steps = lean_resection(image, ground, F_MM, lean.rotation, lean.station)
    assert lean.converged
    assert lean.iterations <= 3
    assert in_sigmas(lean.station - few_steps.station, lean.Q[3:, 3:]) < 1e-7


@pytest.mark.parametrize("way", ["batch", "compiled, in lanes"])
def test_photos_that_take_longer_go_on_by_themselves(way: str) -> None:
    image, ground, R0, S0 = photos(60, 12)
    S0[::9] *= [1.0, 1.0, 1.6]
    many = resection_batch(image, ground, F_MM, R0, S0, compiled=_is_compiled(way))
    single = [lean_resection(image[i], ground[i], F_MM, R0[i], S0[i], may_be_far=False) for i in range(60)]
    assert many.converged.all()
    assert many.iterations.tolist() == [one.iterations for one in single]
    assert len(set(many.iterations.tolist())) > 2
    assert np.allclose(many.station, [one.station for one in single], rtol=0, atol=1e-6)  # m; sigma is some 20 m


@pytest.mark.parametrize("weighted", [False, True], ids=["fixed", "weighted"])
def test_from_anywhere_an_end_is_the_optimum(weighted: bool) -> None:
    """Starts up to half the height, 30 degrees of tilt and 120 of azimuth off: what has converged has no other Q."""
    rng, ends = np.random.default_rng(3), 0
    for seed in range(60):
        n = int(rng.choice([4, 6, 12, 40]))
        one = photo(n, seed)
        given = one.given if weighted else one.ground
        S = np.tile(POINT_COVARIANCE / SIGMA_MM**2, (n, 1, 1)) if weighted else None
        tilt, azimuth = np.radians(rng.uniform(-30, 30, 2)), np.radians(rng.uniform(-120, 120))
        rough = matrix_from_opk(*tilt, azimuth) @ one.R0, one.S0 + rng.uniform(-0.5, 0.5, 3) * HEIGHT_M
        found = lean_resection(one.image, given, F_MM, *rough, S)
        if found.converged:
            ends += 1
            again = lean_resection(one.image, given, F_MM, found.rotation, found.station, S)
            sigmas = np.sqrt(np.diag(again.Q))
            assert in_sigmas(found.station - again.station, again.Q[3:, 3:]) < 1e-5
            assert np.abs((found.Q - again.Q) / np.outer(sigmas, sigmas)).max() < 1e-6  # of 3 to 4 points Q is unsure
            assert found.vPv == pytest.approx(again.vPv, rel=1e-9, abs=1e-12)
        else:
            assert np.isnan(found.Q).all() and np.isnan(found.vPv)
    assert ends > 40


def _ends(image: Array, ground: Array, R: Array, S: Array) -> list[LeanResection]:
    """With the image points as measured far off, and with the computed ones alone."""
    given = lean_module._photo(image, ground, F_MM, S, None)
    return [lean_module._gauss_newton(given, R, S, is_far, 20) for is_far in (True, False)]


@pytest.mark.parametrize("n", [6, 20, 100])
def test_the_points_as_measured_lead_sooner_to_the_same_end(n: int) -> None:
    counts = []
    for seed in range(20):
        one = photo(n, seed)
        sooner, later = _ends(one.image, one.ground, one.R0, one.S0)
        assert in_sigmas(sooner.station - later.station, later.Q[3:, 3:]) < 1e-6
        # at the optimum too the first step, as measured, is not the last: Q is not that of its equations
        again = lean_resection(one.image, one.ground, F_MM, later.rotation, later.station)
        assert again.iterations > 1
        counts.append((sooner.iterations, later.iterations))
    mean = np.mean(counts, axis=0)
    assert mean[0] < mean[1] - 0.2


def test_where_the_points_as_measured_lead_nowhere_the_computed_ones_do() -> None:
    image, ground, R0, S0 = photos(40, 12)
    rng, ends = np.random.default_rng(2), set()
    for i in range(40):
        R, S = matrix_from_opk(0.3, -0.3, rng.uniform(0, 2)) @ R0[i], S0[i] + [0.0, 0.0, 0.3 * HEIGHT_M]
        by_measured, by_computed = (end.converged for end in _ends(image[i], ground[i], R, S))
        ends.add((by_measured, by_computed))
        assert lean_resection(image[i], ground[i], F_MM, R, S).converged == (by_measured or by_computed)
    assert {(False, True), (True, True)} <= ends


def test_control_without_heights_is_never_taken_as_given() -> None:
    """Every second point has only a plan; its height is a guess a third of the height of flight off."""
    one = photo(20, 4)
    given, S = one.given.copy(), np.tile(POINT_COVARIANCE / SIGMA_MM**2, (20, 1, 1))
    given[::2, 2] += HEIGHT_M / 3
    S[::2, 2, 2] = (HEIGHT_M / SIGMA_MM) ** 2
    given_as_it_is = lean_module._photo(one.image, given, F_MM, one.S0, S)
    assert not given_as_it_is.is_control_sure
    found = lean_resection(one.image, given, F_MM, one.R0, one.S0, S)
    true = lean_resection(one.image, one.given, F_MM, one.R0, one.S0)
    assert found.converged
    assert in_sigmas(found.station - true.station, found.Q[3:, 3:]) < 30.0  # of readings; control has five of them


@pytest.mark.parametrize("n", [12, 2100])
@pytest.mark.parametrize("weighted", [False, True], ids=["fixed", "weighted"])
def test_a_point_behind_the_camera_is_no_result(weighted: bool, n: int) -> None:
    """It lies on its ray, so everything fits."""
    one = photo(n, 3)
    S = np.tile(POINT_COVARIANCE / SIGMA_MM**2, (n, 1, 1)) if weighted else None
    found = lean_resection(one.image, one.ground, F_MM, one.R0, one.S0, S)
    assert found.converged
    behind = one.ground.copy()
    behind[5] = found.station - 0.01 * (behind[5] - found.station)
    assert not lean_resection(one.image, behind, F_MM, found.rotation, found.station, S).converged


def test_points_come_to_rest_before_the_end() -> None:
    """From the optimum itself the elements rest at once, but the points are still where they were given."""
    one = photo(12, 6)
    S, given = np.tile(np.eye(3) / SIGMA_MM**2, (12, 1, 1)), one.ground + (one.given - one.ground) / 20.0  # 1 m
    found = lean_resection(one.image, given, F_MM, one.R0, one.S0, S)
    again = lean_resection(one.image, given, F_MM, found.rotation, found.station, S, may_be_far=False)
    sigmas = np.sqrt(np.diag(found.Q))
    assert np.abs((again.Q - found.Q) / np.outer(sigmas, sigmas)).max() < 1e-9


@pytest.mark.parametrize("way", WAYS)
def test_too_few_iterations_are_told(way: str) -> None:
    one = photo(12, 1)
    if way == "alone":
        found: LeanResection | BatchResection = lean_resection(one.image, one.ground, F_MM, one.R0, one.S0, None, 2)
    else:
        p = WAYS[way]
        many = [np.tile(array, (p, *[1] * array.ndim)) for array in (one.image, one.ground, one.R0, one.S0)]
        module_solve = module._solver(_is_compiled(way), 0)
        photos_of = module.Photos(many[0], many[1], np.full(p, F_MM), many[2], many[3])
        found = module_solve(photos_of, 2)
    assert not np.any(found.converged)
    assert np.all(np.asarray(found.iterations) == 2)
    assert np.isnan(found.Q).all()
