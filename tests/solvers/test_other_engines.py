"""Second solutions of models and of estimated cameras; poses by OpenCV and PoseLib; each can say no."""

from importlib.util import find_spec

import numpy as np
import pytest

from orient.solvers.absolute_orientation import orient_model
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.foreign_engines import ALLOWED, ENGINES, can_solve, solve_by_others
from orient.solvers.independent_absolute import ModelObservations, _System, solve_model_independently
from orient.solvers.independent_resection import ResectionObservations
from orient.solvers.resection import resect
from tests.jacobian import central_difference
from tests.solvers.absolute_scenes import covariances
from tests.solvers.absolute_scenes import scene as model_scene
from tests.solvers.resection_scenes import generator, looking, scene

MILLIONTH = 1e-6
SIGMA_MM = 0.005


def model_case(name: str, kinds: str, sides: str) -> tuple[ModelObservations, AbsoluteOrientation]:
    random = generator(f"{name} {kinds} {sides}")
    made = model_scene(random, kinds, tilt=0.3)
    n = len(kinds)
    on_ground, in_model = covariances(random, n, 0.03), covariances(random, n, 0.01)
    if sides == "equal":
        on_ground = np.tile(np.eye(3), (n, 1, 1))
    if sides == "model":
        on_ground = 0 * on_ground
    if sides == "some errorless":
        on_ground[: n // 2] = 0.0
    ground = made.ground + 0.1 * random.normal(size=(n, 3))
    model_cofactor = None if sides in ("ground", "equal") else in_model
    given = ModelObservations(made.model, ground, made.known, on_ground, model_cofactor)
    found = orient_model(made.model, ground, known=made.known, ground_cofactor=on_ground, model_cofactor=model_cofactor)
    assert found.is_result
    return given, found


@pytest.mark.parametrize("kinds", ["ffffff", "fffpphhh"])
@pytest.mark.parametrize("sides", ["equal", "ground", "model", "both", "some errorless"])
def test_a_model_solved_in_the_model_is_the_one_solved_on_the_ground(kinds: str, sides: str) -> None:
    given, found = model_case("model", kinds, sides)
    other = solve_model_independently(given, found.rotation, found.H, found.X0)
    sigma = np.sqrt(np.diag(other.Q))
    assert other.converged
    assert other.vPv == pytest.approx(found.vPv, rel=1e-9)
    assert np.max(np.abs(other.rotation - found.rotation)) < MILLIONTH * sigma[:3].min()
    assert abs(np.log(other.H / found.H)) < MILLIONTH * sigma[3]
    place = found.X0 + found.rotation @ other.model_centre / found.H
    assert np.max(np.abs(place - other.centre) / sigma[4:]) < MILLIONTH
    assert other.Q[:4, :4] == pytest.approx(found.Q_centred[:4, :4], rel=1e-6, abs=1e-9 * sigma[:4].max() ** 2)


def test_partials_of_the_second_model_engine_are_central_differences() -> None:
    given, found = model_case("partials", "fffpphhh", "both")
    system = _System(given, found.rotation, found.H, found.X0, 30.0)
    x = 1e-3 * generator("partials").normal(size=given.n_unknowns)
    steps = np.full(len(x), 1e-6)
    difference = central_difference(lambda at: system.residuals(at).real, x, steps)
    assert system.jacobian(x) == pytest.approx(difference, rel=1e-5, abs=1e-5 * np.abs(difference).max())


def test_a_model_that_is_not_the_solution_is_not_confirmed() -> None:
    given, found = model_case("moved", "fffpphhh", "both")
    moved = solve_model_independently(given, found.rotation, found.H * 1.01, found.X0 + 3.0)
    assert abs(np.log(moved.H / found.H)) < MILLIONTH * np.sqrt(moved.Q[3, 3])


def photo_case(name: str, n: int) -> tuple[ResectionObservations, np.ndarray, np.ndarray, np.ndarray]:
    random = generator(name)
    made = scene(random, n=n, rotation=looking(0.4, 0.3, 1.0), relief=0.2)
    image = made.noisy(SIGMA_MM, random)
    found = resect(image, made.unit, made.ground, made.f_mm)
    assert found.termination == "CONVERGED"
    given = ResectionObservations(image, made.unit, made.ground, made.f_mm)
    return given, found.station, found.rotation, SIGMA_MM * np.sqrt(np.diag(found.Q))


@pytest.mark.parametrize("n", [4, 6, 20, 300])
def test_poses_of_other_programs_agree_in_standard_deviations(n: int) -> None:
    installed = [module for module in ENGINES if find_spec(module)]
    if not installed:
        pytest.skip("neither opencv nor poselib is installed (extra `engines`)")
    given, station, rotation, sigma = photo_case(f"others {n}", n)
    poses = solve_by_others(given, station, rotation)
    assert len(poses) == len(installed)
    for pose in poses:
        assert np.max(np.abs(pose.station - station) / sigma[3:]) < ALLOWED, pose.engine
        assert np.max(np.abs(pose.rotation - rotation)) < ALLOWED * sigma[:3].max(), pose.engine


def test_poses_of_other_programs_contradict_a_wrong_station() -> None:
    pytest.importorskip("poselib")
    given, station, rotation, sigma = photo_case("wrong", 12)
    for pose in solve_by_others(given, station + 3 * sigma[3:], rotation):
        assert np.max(np.abs(pose.station - station - 3 * sigma[3:]) / sigma[3:]) > 1, pose.engine


def test_what_other_programs_cannot_solve_is_not_given_to_them() -> None:
    given, *_ = photo_case("cannot", 6)
    assert can_solve(given)
    heavy = given.image_cofactor.copy()
    heavy[0] *= 4
    free = np.zeros((6, 3, 3))
    free[0] = np.eye(3)
    for other in (
        ResectionObservations(given.image, heavy, given.ground, given.f_mm),
        ResectionObservations(given.image, given.image_cofactor, given.ground, given.f_mm, free),
        ResectionObservations(given.image[:3], given.image_cofactor[:3], given.ground[:3], given.f_mm),
        ResectionObservations(given.image, given.image_cofactor, given.ground, given.f_mm, is_station_fixed=True),
    ):
        assert not can_solve(other)
