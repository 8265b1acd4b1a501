"""Planning: the closed formulas of seed 003, the resection itself, simulations, one point less or more."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orient.errors import GeometryError
from orient.geometry.rotation import aok_from_matrix
from orient.geometry.vertical_photo import element_units, grid_layout, gruber_layout
from orient.solvers import functional_iteration, mishchenko, planning
from orient.solvers.control_effects import added, dropped
from orient.solvers.ground_covariance import ray_at_height
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.planned_photo import UP, PlannedPhoto, Sigmas, planned_photo
from orient.solvers.predicted_ground import ground_by_use, ground_map
from orient.solvers.predicted_orientation import predict, whitened_partials
from orient.solvers.resection import resect
from orient.solvers.resection_problem import Orientation, ResectionProblem
from tests.solvers.resection_scenes import FloatArray, generator

F_MM, HEIGHT, SIGMA = 150.0, 1500.0, 0.006
PLACES = grid_layout(230.0, 230.0, 5, 5)
ASYMMETRIC = np.array([[-100.0, -80.0], [90.0, -100.0], [20.0, 10.0], [-70.0, 60.0], [100.0, 90.0], [40.0, -30.0]])
RELIEF = np.array([0.0, 60.0, -45.0, 30.0, 15.0, -20.0])


def planned(
    image: FloatArray,
    sigmas: Sigmas = Sigmas(SIGMA),  # noqa: B008 (frozen)
    relief: FloatArray | None = None,
    tilt_deg: float = 0.0,
    f_mm: float = F_MM,
) -> PlannedPhoto:
    names = [f"P{i + 1}" for i in range(len(image))]
    return planned_photo(image, names, f_mm, HEIGHT, sigmas, relief=relief, tilt=radians(tilt_deg))


def without(photo: PlannedPhoto, i: int) -> PlannedPhoto:
    rest = [k for k in range(len(photo.names)) if k != i]
    return replace(photo, names=tuple(photo.names[k] for k in rest), image=photo.image[rest], ground=photo.ground[rest])


LOW = np.array([[-100.0, -80.0], [100.0, -80.0], [90.0, -10.0], [-95.0, -5.0]])
OBLIQUE = planned(ASYMMETRIC, Sigmas(SIGMA, 0.1, 0.2), RELIEF, 25.0)
SCENES = {
    "vertical, flat": planned(ASYMMETRIC),
    "relief": planned(ASYMMETRIC, relief=RELIEF),
    "oblique with weak control": OBLIQUE,
    "towards the horizon": planned(LOW, tilt_deg=90.0),
}


@pytest.mark.parametrize("ratio", [0.8, 1.0, 2.2, 6.7])
@pytest.mark.parametrize("layout", ["grid", "corners and centre", "rectangle"])
def test_closed_formulas_where_they_hold(layout: str, ratio: float) -> None:
    """Vertical, flat, symmetric: sigmas by (8)-(10), or with Dx and Dy, to 1e-9; all covariances with them."""
    grid = grid_layout(200.0, 100.0 if layout == "rectangle" else 200.0, 3, 3)
    image = grid[[0, 2, 4, 6, 8]] if layout == "corners and centre" else grid
    photo = planned(image, f_mm=ratio * 100)
    found, closed = predict(photo), planning.closed_form(photo)
    assert photo.is_normal_case
    assert closed.sigma is not None
    np.testing.assert_allclose(found.sigma, closed.sigma, rtol=1e-9)
    units = SIGMA * element_units(ratio * 100, 100.0, HEIGHT)
    Q = mishchenko.closed_form(image / 100, ratio**2, 2).Q * np.outer(units, units)
    np.testing.assert_allclose(found.covariance, Q, atol=1e-9 * np.max(np.outer(found.sigma, found.sigma)))


def test_check_of_the_seed() -> None:
    """EQUATIONS 3: f = 200 mm, c = 90 mm, H = 250 km, sigma = 7 um (X_S: see test_mishchenko)."""
    names = [str(i) for i in range(9)]
    photo = planned_photo(grid_layout(180.0, 180.0, 3, 3), names, 200.0, 250e3, Sigmas(7e-3))
    expected = [20.233133, 20.233133, 5.613128, 7.056143e-5, 7.056143e-5, 2.245251e-5]
    np.testing.assert_allclose(predict(photo).sigma, expected, rtol=1e-7)
    first, second, value = predict(photo).correlations()[0]
    assert {first, second} in ({"X_S", "alpha"}, {"Y_S", "omega"})
    assert value == pytest.approx(-0.98956, abs=5e-6)


def test_map_of_a_vertical_photo_is_the_covariance_of_the_seed() -> None:
    """K of the map over (sigma H / f)^2 is C(0) Q(0) C(0)', for any layout; the reading adds the unit matrix."""
    photo = planned(ASYMMETRIC)
    ground = ground_map(photo, predict(photo), PLACES)
    K = mishchenko.covariance(ASYMMETRIC / 100, PLACES / 100)
    scale = (SIGMA * HEIGHT / F_MM) ** 2
    expected = np.array([K[i, :, i, :] for i in range(len(PLACES))])
    np.testing.assert_allclose(ground.covariance.orientation[:, :2, :2] / scale, expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(ground.covariance.reading[:, :2, :2] / scale, np.tile(np.eye(2), (25, 1, 1)), atol=1e-12)


@pytest.mark.parametrize("f_mm", [88.0, 152.0, 305.0, 1000.0])
def test_corner_of_a_grid_is_3402_nm_for_every_camera(f_mm: float) -> None:
    photo = planned(grid_layout(200.0, 200.0, 3, 3), Sigmas(0.005), f_mm=f_mm)
    assert f"{5 * planning.closed_form(photo).corner:.3f}" == "3.402"
    ground = ground_map(photo, predict(photo), np.array([[100.0, 100.0]]))
    in_image = np.sqrt(ground.covariance.orientation[0, 0, 0]) * f_mm / HEIGHT
    assert f"{1000 * in_image:.3f}" == "3.402"


@pytest.mark.parametrize("photo", SCENES.values(), ids=SCENES)
def test_the_resection_finds_the_predicted_cofactors(photo: PlannedPhoto) -> None:
    """Exact observations, weighted control: sigma^2 Q of `resect` is F F'."""
    n = len(photo.names)
    free, weight = ground_weights(photo)
    found = resect(
        photo.image, np.tile(np.eye(2), (n, 1, 1)), photo.ground, F_MM, ground_free=free, ground_weight=weight
    )
    prediction = predict(photo)
    covariance = photo.sigmas.image_mm**2 * found.Q
    scales = np.sqrt(np.diag(covariance))
    F = prediction.factor
    np.testing.assert_allclose(F @ F.T / np.outer(scales, scales), covariance / np.outer(scales, scales), atol=1e-7)
    assert np.sum(prediction.redundancy_numbers) == pytest.approx(2 * n - 6)
    assert prediction.redundancy == 2 * n - 6


def ground_weights(photo: PlannedPhoto) -> tuple[FloatArray | None, FloatArray | None]:
    """What `resect` wants to know of control of the planned accuracy."""
    sigmas = photo.sigmas
    if sigmas.control_m == 0:
        return None, None
    inverse = sigmas.image_mm**2 / np.array([sigmas.control_m, sigmas.control_m, sigmas.height_m]) ** 2
    n = len(photo.names)
    return np.tile(np.eye(3), (n, 1, 1)), np.tile(np.diag(inverse), (n, 1, 1))


def test_height_error_alone_moves_nothing_straight_below() -> None:
    """The image of a point in the nadir does not feel its height; elsewhere sigma grows."""
    image = ASYMMETRIC.copy()
    image[2] = 0.0
    errorless, high = planned(image), planned(image, Sigmas(SIGMA, 0.0, 1.0))
    assert np.all(predict(high).sigma > predict(errorless).sigma)
    alone = whitened_partials(high, high.ground[2:3])
    np.testing.assert_allclose(alone, whitened_partials(errorless, errorless.ground[2:3]))


@pytest.mark.parametrize("photo", SCENES.values(), ids=SCENES)
def test_dropping_a_point_is_the_prediction_without_it(photo: PlannedPhoto) -> None:
    prediction = predict(photo)
    ground = ground_map(photo, prediction, PLACES, 0.3)
    effects = dropped(photo, prediction, ground)
    assert [effect.name for effect in effects] == list(photo.names)
    for i, effect in enumerate(effects):
        rest = without(photo, i)
        anew = predict(rest)
        np.testing.assert_allclose(effect.sigma, anew.sigma, rtol=1e-6)
        assert effect.mean_sigma == pytest.approx(ground_map(rest, anew, PLACES, 0.3).mean_sigma, rel=1e-6)
        assert np.all(effect.sigma >= prediction.sigma * (1 - 1e-12))


@pytest.mark.parametrize("photo", SCENES.values(), ids=SCENES)
def test_adding_a_point_is_the_prediction_with_it(photo: PlannedPhoto) -> None:
    prediction = predict(photo)
    ground = ground_map(photo, prediction, PLACES)
    candidates = np.array([[-60.0, -90.0], [10.0, -40.0]])
    for place, effect in zip(candidates, added(photo, prediction, ground, candidates, "ab"), strict=True):
        point = on_ground(photo, place[None, :])
        more = replace(
            photo,
            names=(*photo.names, "new"),
            image=np.vstack([photo.image, place]),
            ground=np.vstack([photo.ground, point]),
        )
        anew = predict(more)
        np.testing.assert_allclose(effect.sigma, anew.sigma, rtol=1e-7)
        assert effect.mean_sigma == pytest.approx(ground_map(more, anew, PLACES).mean_sigma, rel=1e-7)
        assert np.all(effect.sigma <= prediction.sigma * (1 + 1e-12))


def on_ground(photo: PlannedPhoto, image: FloatArray) -> FloatArray:
    up = np.tile(UP, (len(image), 1))
    return ray_at_height(image, photo.station, photo.rotation, photo.f_mm, np.zeros((len(image), 3)), up)


def test_points_that_cannot_be_spared_are_named() -> None:
    """Three on a circle with the nadir: the fourth carries the orientation. Of three points, each does."""
    photo = planned(np.array([[50.0, 0.0], [25.0, 25.0], [25.0, -25.0], [-60.0, 40.0]]))
    prediction = predict(photo)
    effects = dropped(photo, prediction, ground_map(photo, prediction, PLACES))
    assert [effect.name for effect in effects if not effect.is_determined] == ["P4"]
    three = planned(ASYMMETRIC[:3])
    lone = dropped(three, predict(three), ground_map(three, predict(three), PLACES))
    assert not any(effect.is_determined for effect in lone)
    assert all(np.isinf(effect.sigma).all() for effect in lone)


def simulated(photo: PlannedPhoto, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Spread (6,) of the elements and (2,) of one ground point; `noise` (runs, 5n + 2) of unit variance."""
    n = len(photo.names)
    free, weight = ground_weights(photo)
    sigmas = np.array([photo.sigmas.control_m, photo.sigmas.control_m, photo.sigmas.height_m])
    elements, points = [], []
    for row in noise:
        image = photo.image + photo.sigmas.image_mm * row[: 2 * n].reshape(n, 2)
        given_ground = photo.ground + sigmas * row[2 * n : 5 * n].reshape(n, 3)
        known = ground_knowledge(given_ground, free, weight)
        problem = ResectionProblem(image, np.tile(np.eye(2), (n, 1, 1)), known, photo.f_mm)
        start = Orientation(photo.rotation, photo.station, given_ground)
        end = functional_iteration.iterate(problem, start, tolerance=1e-8).state
        elements.append([*end.station, *aok_from_matrix(end.rotation)])
        read = PLACE + photo.sigmas.image_mm * row[5 * n :]
        oriented = replace(photo, station=end.station, rotation=end.rotation)
        points.append(on_ground(oriented, read)[0, :2])
    return np.std(elements, axis=0), np.std(points, axis=0)


def assert_spread(photo: PlannedPhoto, noise: FloatArray, tolerance: float) -> None:
    spread, of_point = simulated(photo, noise)
    prediction = predict(photo)
    np.testing.assert_allclose(spread, prediction.sigma, rtol=tolerance)
    ground = ground_map(photo, prediction, PLACE)
    np.testing.assert_allclose(of_point, np.sqrt(np.diag(ground.covariance.total[0]))[:2], rtol=tolerance)


PLACE = np.array([[80.0, -60.0]])
SIMULATED = {"relief": SCENES["relief"], "oblique with weak control": OBLIQUE}


@pytest.mark.parametrize("scene", SIMULATED)
def test_simulated_spread_agrees_within_5_percent(scene: str) -> None:
    """200 adjusted photos; their noise is made orthonormal, so that what differs is not the luck of the sample."""
    photo = SIMULATED[scene]
    drawn = generator(scene).normal(size=(200, 5 * len(photo.names) + 2))
    orthonormal = np.linalg.qr(drawn - drawn.mean(axis=0))[0]
    assert_spread(photo, orthonormal * np.sqrt(len(drawn)), 0.05)


@pytest.mark.slow
@pytest.mark.parametrize("scene", SIMULATED)
def test_simulated_spread_of_10000_runs_agrees_within_3_percent(scene: str) -> None:
    """Independent noise, which knows a standard deviation to 0.7 %."""
    photo = SIMULATED[scene]
    assert_spread(photo, generator(scene).normal(size=(10_000, 5 * len(photo.names) + 2)), 0.03)


def test_use_of_part_of_the_elements() -> None:
    """Standard deviations alone, or part of the elements, are wrong by a factor that grows with f."""
    factors = []
    for f_mm in (100.0, 670.0):
        photo = planned(grid_layout(200.0, 200.0, 3, 3), f_mm=f_mm)
        prediction = predict(photo)
        place = ground_map(photo, prediction, np.array([[50.0, 25.0]]))
        used = ground_by_use(photo, prediction, place)
        total = place.covariance.orientation[0]
        assert used["six elements"] == pytest.approx(np.sqrt((total[0, 0] + total[1, 1]) / 2))
        factors.append(used["standard deviations only"] / used["six elements"])
        assert min(used["position only"], used["angles only"]) > used["six elements"]
    scale = 670.0 / 100.0
    assert factors[1] > scale * factors[0]


def test_closed_form_is_off_for_an_asymmetric_layout() -> None:
    closed = planning.closed_form(planned(ASYMMETRIC))
    assert closed.sigma is None
    assert closed.largest_error > 0.01


def test_plan_holds_everything() -> None:
    grid = planned(grid_layout(230.0, 230.0, 3, 3))
    made = planning.plan(grid, PLACES)
    assert made.closed is not None
    assert len(made.without) == 9
    assert len(made.one_more) == 25 - 9
    assert made.symmetry.violated == ()
    assert planning.plan(OBLIQUE, PLACES).closed is None


def test_places_above_the_horizon_are_left_out() -> None:
    photo = SCENES["towards the horizon"]
    prediction = predict(photo)
    ground = ground_map(photo, prediction, PLACES)
    assert np.count_nonzero(ground.met) == 10
    assert np.isfinite(ground.mean_sigma)
    assert prediction.names[3:] == ("omega", "phi", "kappa")
    assert len(added(photo, prediction, ground, PLACES, [str(i) for i in range(25)])) == 10
    with pytest.raises(GeometryError, match="sees no ground"):
        ground_map(photo, prediction, np.array([[0.0, 10.0]]))


@given(st.floats(0.2, 5.0), st.floats(0.2, 5.0))
def test_scaling_the_height_and_the_sigma(height: float, sigma: float) -> None:
    """Errorless control: lengths grow with H and sigma, angles with sigma alone."""
    names = [str(i) for i in range(6)]
    base = predict(planned_photo(ASYMMETRIC, names, F_MM, HEIGHT, Sigmas(SIGMA))).sigma
    other = predict(planned_photo(ASYMMETRIC, names, F_MM, height * HEIGHT, Sigmas(sigma * SIGMA))).sigma
    np.testing.assert_allclose(other[:3], base[:3] * height * sigma, rtol=1e-9)
    np.testing.assert_allclose(other[3:], base[3:] * sigma, rtol=1e-9)


REFUSED = {
    "two points": (ASYMMETRIC[:2], None, 0.0, "has 2 points, an orientation needs at least 3"),
    "no points": (ASYMMETRIC[:0], None, 0.0, "has 0 points"),
    "a line": (np.array([[0.0, 0.0], [10.0, 10.0], [50.0, 50.0]]), None, 0.0, "lie on a line"),
    "a place twice": (ASYMMETRIC[[0, 1, 2, 2]], None, 0.0, "P3 and P4 coincide in the photo"),
    "above the horizon": (ASYMMETRIC, None, 80.0, "ray of point P4 does not meet the ground"),
    "higher than the camera": (ASYMMETRIC[:3], np.array([0.0, 2000.0, 0.0]), 0.0, "ray of point P2 does not meet"),
    "not a number": (np.array([[0.0, np.nan], [1.0, 0.0], [0.0, 1.0]]), None, 0.0, "ray of point P1"),
}


@pytest.mark.parametrize(("image", "relief", "tilt_deg", "message"), REFUSED.values(), ids=REFUSED)
def test_bad_layouts_are_refused_by_name(
    image: FloatArray, relief: FloatArray | None, tilt_deg: float, message: str
) -> None:
    with pytest.raises(GeometryError, match=message):
        planned(image, relief=relief, tilt_deg=tilt_deg)


def test_the_dangerous_cylinder_is_named() -> None:
    """Three points on a circle with the nadir, seen from above it: r_X, r_Y, X_S, Y_S, Z_S move together."""
    with pytest.raises(GeometryError, match=r"Undetermined: r_X 1\.00.*Y_S") as caught:
        predict(planned(np.array([[0.0, 0.0], [50.0, 0.0], [0.0, 50.0]])))
    assert "cylinder" in caught.value.hint


def test_layouts_of_the_frame() -> None:
    np.testing.assert_array_equal(grid_layout(4.0, 2.0, 2, 2), [[-2, 1], [2, 1], [-2, -1], [2, -1]])
    np.testing.assert_array_equal(grid_layout(4.0, 2.0, 1, 3), [[0, 1], [0, 0], [0, -1]])
    np.testing.assert_allclose(gruber_layout(100.0, 50.0)[[0, 3, 4]], [[0, 0], [40, 20], [0, -20]])
