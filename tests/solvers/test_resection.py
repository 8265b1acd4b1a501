"""Resection of scenes of known truth: every attitude, partial and weighted control, weak and impossible geometry."""

from itertools import pairwise

import numpy as np
import pytest

from orient.errors import GeometryError
from orient.geometry.collinearity import partials_aok, project
from orient.solvers.functional_iteration import SAME_VPV, WEAK_RATIO, Termination
from orient.solvers.resection import Resection, resect
from tests.solvers.resection_scenes import FloatArray, Scene, any_rotation, generator, looking, scene

UP = np.array([0.0, 0.0, 1.0])
EYE = np.eye(3)


def assert_is_truth(result: Resection, s: Scene, relative: float = 1e-8) -> None:
    assert result.termination is Termination.CONVERGED
    distance = np.linalg.norm(s.ground.mean(axis=0) - s.station)
    np.testing.assert_allclose(result.station, s.station, atol=relative * float(distance), rtol=0)
    np.testing.assert_allclose(result.rotation, s.rotation, atol=relative)


@pytest.mark.parametrize("nadir_deg", [0, 20, 60, 90, 120, 180])
@pytest.mark.parametrize("relief", [0.0, 0.2])
@pytest.mark.parametrize("n", [4, 9])
def test_every_attitude_without_approximations(nadir_deg: int, relief: float, n: int) -> None:
    random = generator(f"{nadir_deg} {relief} {n}")
    R = looking(random.uniform(0, 6), np.radians(nadir_deg), random.uniform(-3, 3))
    s = scene(random, n=n, rotation=R, relief=relief, origin=(450000.0, 5300000.0, 500.0))
    assert_is_truth(resect(s.image, s.unit, s.ground, s.f_mm), s)


@pytest.mark.parametrize(("f_mm", "half"), [(30.0, 20.0), (124.0, 40.0), (200.0, 90.0), (1000.0, 90.0)])
@pytest.mark.parametrize("distance", [3.0, 250e3])
def test_every_camera_and_scale(f_mm: float, half: float, distance: float) -> None:
    s = scene(generator(f"{f_mm} {distance}"), n=9, f_mm=f_mm, half_mm=half, distance=distance, relief=0.05)
    assert_is_truth(resect(s.image, s.unit, s.ground, s.f_mm), s, 1e-7)


def test_three_points_offer_their_alternatives_and_the_approximate_station_picks() -> None:
    random = generator("test_three_points")
    for _ in range(10):
        s = scene(random, n=3, relief=0.3)
        result = resect(s.image, s.unit, s.ground, s.f_mm, approximate_station=s.station * 1.001)
        assert_is_truth(result, s, 1e-6)
        assert result.redundancy == 0
        assert all(alternative.is_as_good for alternative in result.alternatives)
        assert result.is_ambiguous == bool(result.alternatives)


def test_normal_case_is_plain_gauss_newton_and_its_records_join() -> None:
    random = generator("test_normal_case")
    s = scene(random, n=12)
    result = resect(s.noisy(0.005, random), s.unit, s.ground, s.f_mm)
    assert all(step.damping == 0 for step in result.iterations)
    assert result.iterations[-1].max_scaled_step <= 1e-10
    vPv = [step.vPv for step in result.iterations]
    # at the optimum v'Pv is flat, a smaller change is rounding of the computed coordinates
    assert all(after <= before * (1 + SAME_VPV) for before, after in pairwise(vPv))
    for step, following in zip(result.iterations, result.iterations[1:], strict=False):
        np.testing.assert_allclose(step.station + step.correction_station, following.station)
        assert step.ground is None
        assert step.correction_ground is None


def test_equations_are_the_partials_of_the_papers_and_residuals_computed_minus_measured() -> None:
    random = generator("test_equations")
    s = scene(random, n=6)
    image = s.noisy(0.005, random)
    result = resect(image, s.unit, s.ground, s.f_mm)
    computed, zs = project(s.ground, result.station, result.rotation, s.f_mm)
    np.testing.assert_allclose(result.equations, partials_aok(s.ground, result.station, result.rotation, s.f_mm))
    np.testing.assert_allclose(result.residuals, computed - image, atol=1e-9)
    np.testing.assert_allclose(result.zs, zs)
    assert result.vPv == pytest.approx(np.sum(result.residuals**2))
    normal_equations = np.einsum("nij,ni->j", result.equations[:, :, :6], result.residuals)
    np.testing.assert_allclose(normal_equations / np.abs(result.equations[:, :, :6]).max(axis=(0, 1)), 0, atol=1e-9)


def test_redundancy_numbers_sum_to_the_redundancy_with_correlated_readings() -> None:
    random = generator("test_redundancy_numbers")
    s = scene(random, n=7)
    root = random.normal(size=(7, 2, 2)) * 0.3 + np.eye(2)
    result = resect(s.noisy(0.005, random), root @ root.transpose(0, 2, 1), s.ground, s.f_mm)
    assert result.redundancy == 2 * 7 - 6
    assert result.redundancy_numbers.sum() == pytest.approx(result.redundancy)
    np.testing.assert_array_equal(result.ground_redundancy, 0)


def test_tiny_ground_sigma_is_fixed_control() -> None:
    random = generator("test_tiny_ground_sigma")
    s = scene(random, n=8)
    image, eye = s.noisy(0.01, random), np.tile(EYE, (8, 1, 1))
    fixed = resect(image, s.unit, s.ground, s.f_mm)
    weighted = resect(image, s.unit, s.ground, s.f_mm, ground_free=eye, ground_weight=eye * 1e10)
    assert weighted.redundancy == fixed.redundancy
    np.testing.assert_allclose(weighted.station, fixed.station, atol=1e-6)
    np.testing.assert_allclose(weighted.rotation, fixed.rotation, atol=1e-9)
    np.testing.assert_allclose(weighted.Q, fixed.Q, rtol=1e-6, atol=1e-12)
    assert weighted.vPv == pytest.approx(fixed.vPv, rel=1e-6)


def dense_solution(s: Scene, image: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """One big least-squares system with 6 + 3n unknowns: the same adjustment without elimination."""
    from scipy.optimize import least_squares

    from orient.geometry.rotation import rotation_exp

    n, roots = len(image), np.linalg.cholesky(weight).transpose(0, 2, 1)

    def residuals(unknowns: FloatArray) -> FloatArray:
        shift = unknowns[6:].reshape(n, 3)
        rotation, station = rotation_exp(unknowns[:3]) @ s.rotation, s.station + 2000 * unknowns[3:6]
        image_part = project(s.ground + shift, station, rotation, s.f_mm)[0] - image
        return np.concatenate([image_part.ravel(), (roots @ shift[:, :, None]).ravel()])

    found = least_squares(residuals, np.zeros(6 + 3 * n), xtol=1e-15, ftol=1e-15, gtol=1e-15, jac="3-point")
    scale = np.array([1, 1, 1, 2000, 2000, 2000])
    Q = np.linalg.inv(found.jac.T @ found.jac)[:6, :6] * np.outer(scale, scale)
    return s.station + 2000 * found.x[3:6], Q, 2 * float(found.cost)


def test_weighted_control_equals_one_big_adjustment() -> None:
    random = generator("test_weighted_control")
    s = scene(random, n=6)
    root = random.normal(size=(6, 3, 3)) * 0.3 + EYE
    covariance = root @ root.transpose(0, 2, 1)
    image, weight = s.noisy(0.01, random), 0.01**2 * np.linalg.inv(covariance)
    moved = Scene(s.image, s.ground + (root @ random.normal(size=(6, 3, 1)))[:, :, 0], s.rotation, s.station, s.f_mm)
    result = resect(image, s.unit, moved.ground, s.f_mm, ground_free=np.tile(EYE, (6, 1, 1)), ground_weight=weight)
    station, Q, vPv = dense_solution(moved, image, weight)
    assert (result.n_equations, result.n_unknowns, result.redundancy) == (12 + 18, 6 + 18, 6)
    np.testing.assert_allclose(result.station, station, atol=1e-5)
    np.testing.assert_allclose(result.Q, Q, rtol=1e-4, atol=1e-6 * np.abs(Q).max())
    assert result.vPv == pytest.approx(vPv, rel=1e-8)
    assert result.redundancy_numbers.sum() + result.ground_redundancy.sum() == pytest.approx(6)


PARTIAL = {"plan_only": np.outer(UP, UP), "height_only": EYE - np.outer(UP, UP)}


@pytest.mark.parametrize("kind", PARTIAL)
def test_partial_control_finds_its_unknown_coordinates(kind: str) -> None:
    s = scene(generator(kind), n=9, rotation=looking(0.4, 0.5, 1.0), relief=0.1)
    free = np.zeros((9, 3, 3))
    free[4:] = PARTIAL[kind]
    given = s.ground + (free @ np.array([150.0, -200.0, 80.0]))
    result = resect(s.image, s.unit, given, s.f_mm, ground_free=free, camera_above=UP)
    assert_is_truth(result, s)
    np.testing.assert_allclose(result.ground, s.ground, atol=1e-5)
    assert result.redundancy == 18 - 6 - 5 * np.linalg.matrix_rank(PARTIAL[kind])
    assert result.redundancy_numbers.sum() == pytest.approx(result.redundancy)
    first = result.iterations[0]
    assert first.ground is not None
    np.testing.assert_allclose(result.ground_cofactors[:4], 0)
    assert np.all(np.trace(result.ground_cofactors[4:], axis1=1, axis2=2) > 0)


def test_height_of_weighted_plan_only_points_is_found() -> None:
    s = scene(generator("weighted plan"), n=8, rotation=looking(0.4, 0.4, 1.0))
    free, weight = np.tile(EYE, (8, 1, 1)), np.tile(EYE, (8, 1, 1)) * 1e-4
    weight[5:] = (EYE - np.outer(UP, UP)) * 1e-4
    given = s.ground.copy()
    given[5:, 2] += 100.0
    result = resect(s.image, s.unit, given, s.f_mm, ground_free=free, ground_weight=weight)
    assert_is_truth(result, s, 1e-7)
    assert result.redundancy == 16 + 15 + 6 - 6 - 24


def test_height_of_a_point_straight_below_is_undetermined_and_named() -> None:
    s = scene(generator("nadir"), n=7, rotation=looking(0.0, 0.0, 0.3))
    ground = np.vstack([s.ground, s.station - [0, 0, 2000.0]])
    image = np.vstack([s.image, [0.0, 0.0]])
    free = np.zeros((8, 3, 3))
    free[7] = PARTIAL["plan_only"]
    result = resect(image, np.tile(np.eye(2), (8, 1, 1)), ground, s.f_mm, ground_free=free, names=[*"abcdefgh"])
    assert result.termination is Termination.SINGULAR
    assert "point h" in result.undetermined
    assert "point h" in result.message


def below(points: FloatArray, station: FloatArray, f_mm: float = 150.0) -> Scene:
    R = looking(0.0, 0.0, 0.0)
    return Scene(project(points, station, R, f_mm)[0], points, R, station, f_mm)


def ring(*degrees: float, radius: float = 40.0) -> FloatArray:
    angles = np.radians(degrees)
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(len(angles))])


@pytest.mark.parametrize(
    ("off_m", "ending"), [(0.0, Termination.SINGULAR), (0.05, Termination.CONVERGED), (10.0, Termination.CONVERGED)]
)
def test_three_points_with_the_camera_on_their_cylinder(off_m: float, ending: Termination) -> None:
    """RELIABILITY 8.3: ratio 9e-10 on the cylinder, 6e-5 five centimetres off, 1.2e-2 ten metres off."""
    s = below(ring(0, 120, 240), np.array([-40.0 - off_m, 0.0, 100.0]))
    result = resect(s.image, s.unit, s.ground, s.f_mm, approximate_station=s.station)
    assert result.termination is ending or result.condition_ratio < 1e-6
    if off_m == 0:
        assert result.condition_ratio < 1e-6
        assert result.undetermined or result.condition_ratio < WEAK_RATIO
    if off_m == 0.05:
        assert result.condition_ratio < WEAK_RATIO * 10
    if off_m == 10.0:
        assert result.condition_ratio > WEAK_RATIO


def test_a_fourth_point_on_the_circle_cures_the_cylinder() -> None:
    s = below(ring(0, 70, 130, 240), np.array([-40.0, 0.0, 100.0]))
    result = resect(s.image, s.unit, s.ground, s.f_mm)
    assert result.condition_ratio > 1e-3
    assert_is_truth(result, s)


@pytest.mark.parametrize("off_mm", [1.0, 10.0, 1000.0])
def test_points_nearly_on_a_line_are_weak(off_mm: float) -> None:
    """RELIABILITY 8.3: ratio 8e-7 for 1 mm in 80 m, growing with the distance from the line."""
    points = np.column_stack([np.linspace(-40, 40, 6), np.zeros(6), np.zeros(6)])
    points[2, 1] = off_mm / 1000
    points[4, 1] = -off_mm / 1000
    s = below(points, np.array([3.0, 20.0, 100.0]))
    result = resect(s.image, s.unit, s.ground, s.f_mm)
    assert 1e-7 * off_mm < result.condition_ratio < 1e-5 * off_mm
    assert (result.condition_ratio < WEAK_RATIO) == (off_mm < 1000)


REFUSED = {
    "two points": (2, lambda s: None, "2 control points have three known coordinates"),
    "line on the ground": (5, lambda s: s.ground.__setitem__(slice(None), np.outer(np.arange(5), [1, 2, 3])), "line"),
    "line in the photo": (4, lambda s: s.image.__setitem__(slice(None), np.outer(np.arange(4), [1, 2])), "photo"),
    "same ground": (4, lambda s: s.ground.__setitem__(3, s.ground[1]), "Points B and D coincide on the ground"),
    "same image": (4, lambda s: s.image.__setitem__(2, s.image[0]), "Points A and C coincide in the photo"),
    "not a number": (4, lambda s: s.ground.__setitem__((2, 1), np.nan), "Point C has a coordinate"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_impossible_control_is_refused_by_name(case: str) -> None:
    n, spoil, words = REFUSED[case]
    s = scene(generator(case), n=n)
    spoil(s)
    with pytest.raises(GeometryError, match=words):
        resect(s.image, s.unit, s.ground, s.f_mm, names=[*"ABCDE"][:n])


def test_line_message_says_how_far_off() -> None:
    s = scene(generator("line"), n=4)
    ground = np.outer(np.arange(4.0), [100.0, 0.0, 0.0])
    with pytest.raises(GeometryError, match=r"on a line \(off by .* m in 300 m\)"):
        resect(s.image, s.unit, ground, s.f_mm)


def test_unknown_point_and_missing_equations_are_refused() -> None:
    s = scene(generator("unknown"), n=4)
    free = np.zeros((4, 3, 3))
    free[3] = EYE
    with pytest.raises(GeometryError, match="Point 4 has no known ground coordinate"):
        resect(s.image, s.unit, s.ground, s.f_mm, ground_free=free)


def test_image_covariance_must_be_positive() -> None:
    s = scene(generator("covariance"), n=4)
    cofactor = s.unit.copy()
    cofactor[1] = 0.0
    with pytest.raises(GeometryError, match="covariance of the image coordinates of point 2"):
        resect(s.image, cofactor, s.ground, s.f_mm)


def test_camera_below_the_ground_is_no_result() -> None:
    s = scene(generator("below"), n=8, rotation=looking(0.0, np.pi, 0.3))
    result = resect(s.image, s.unit, s.ground, s.f_mm, camera_above=UP)
    assert result.termination is Termination.BELOW_GROUND
    assert "below the ground" in result.message


def test_points_behind_the_camera_are_no_result() -> None:
    """A point behind the camera has an image by the formula too."""
    s = scene(generator("behind"), n=8, relief=0.3)
    ground = s.ground.copy()
    ground[5:] = 2 * s.station - ground[5:]
    result = resect(s.image, s.unit, ground, s.f_mm)
    assert result.termination is Termination.BEHIND_CAMERA
    assert "behind the camera" in result.message


def test_mirrored_image_does_not_fit() -> None:
    s = scene(generator("mirrored"), n=8, relief=0.3)
    result = resect(s.image * [-1, 1], s.unit, s.ground, s.f_mm)
    assert result.termination is not Termination.CONVERGED or result.vPv > 1.0


def test_iterations_can_run_out() -> None:
    random = generator("run out")
    s = scene(random, n=8)
    result = resect(s.noisy(0.5, random), s.unit, s.ground, s.f_mm, max_iterations=1)
    assert result.termination is Termination.MAX_ITERATIONS
    assert len(result.iterations) == 1
    assert np.isfinite(result.Q).all()


def test_arguments_are_not_written_into() -> None:
    s = scene(generator("arguments"), n=6)
    frozen = [s.image, s.unit, s.ground]
    for array in frozen:
        array.setflags(write=False)
    assert_is_truth(resect(*frozen, s.f_mm), s)


def test_simulated_spread_agrees_with_Q() -> None:
    random = generator("test_simulated_spread")
    s = scene(random, n=8, rotation=any_rotation(random))
    trials = [resect(s.noisy(0.01, random), s.unit, s.ground, s.f_mm) for _ in range(120)]
    scale = 0.01 * np.sqrt(np.diag(trials[0].Q))
    stations = np.array([t.station - s.station for t in trials]) / scale[3:]
    turned = [t.rotation @ s.rotation.T for t in trials]
    turns = np.array([[t[2, 1], t[0, 2], t[1, 0]] for t in turned]) / scale[:3]
    spread = np.hstack([turns, stations]).std(axis=0)
    # 120 trials give a standard deviation within +-6.5 %
    np.testing.assert_allclose(spread, 1.0, atol=0.25)
    mean_vPv = np.mean([t.vPv for t in trials]) / 0.01**2
    assert mean_vPv == pytest.approx(trials[0].redundancy, rel=0.15)


def test_exchanged_ground_axes_on_flat_control_put_the_camera_below() -> None:
    """EQUATIONS 4.3: X and Y swapped, flat ground: zero residuals with the camera at -Z_S. Only its place tells."""
    s = scene(generator("exchanged"), n=9, rotation=looking(0.3, 0.0, 1.0), relief=0.0)
    swapped = s.ground[:, [1, 0, 2]]
    result = resect(s.image, s.unit, swapped, s.f_mm, camera_above=UP)
    assert result.termination is Termination.BELOW_GROUND
    assert result.vPv < 1e-12
    depth = s.ground[0, 2] - result.station[2]
    assert depth == pytest.approx(s.station[2] - s.ground[0, 2], rel=1e-6)
