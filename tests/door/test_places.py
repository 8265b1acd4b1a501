"""Image to ground and back: the stage's own numbers, round trips, a simulation."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

import orient
from orient.door.of_project import version_of
from orient.geometry.rotation import rotation_exp
from orient.pipeline.new_points import on_ground
from orient.pipeline.photo_model import STAGES, PhotoModel, photo_model
from orient.solvers.ground_covariance import symmetric_factor
from orient.store.project import open_project

Array = np.ndarray
PART = ("XX", "XY", "XY", "YY")
TRIALS = 1200


def model_of(photo: orient.Photo) -> PhotoModel:
    with open_project(photo.path) as project:
        runs = {stage: version_of(project, stage, None) for stage in STAGES}
        return photo_model({stage: project.read_tables(run.run_id) for stage, run in runs.items()})


def lists(photo: orient.Photo) -> tuple[orient.Table, Array, Array, Array]:
    """Rows of ground_covariance; the mean readings [mm], heights [m] and sigmas of the means of its points."""
    stored, image = photo.table("ground_covariance", "covariance"), photo.table("image_point", "refine")
    at = [list(image["point"]).index(point) for point in stored["point"]]
    points = stored.array("X_m", "Y_m", "Z_m")
    is_local = photo.orientation.geographic is None
    heights = points[:, 2] if is_local else photo.geographic_from_ground(points)[:, 2]
    sigma = photo.table("photo", "photo")["sigma_image_mm"][0] / np.sqrt(image["n_cycles"][at])
    return stored, image.array("x_comparator_mm", "y_comparator_mm")[at], heights, sigma


def part(stored: orient.Table, name: str) -> Array:
    return stored.array(*(f"{name}_{axes}_m2" for axes in PART)).reshape(-1, 2, 2)


def test_places_and_covariances_are_those_of_the_stage(sample: orient.Photo) -> None:
    stored, readings, heights, sigma = lists(sample)
    found = sample.image_to_ground(readings, heights, sigma=sigma, system="comparator")
    # rounding of geocentric coordinates of 6e6 m is 1e-9 m; it grows with the distance along slanting rays
    np.testing.assert_allclose(found.points, stored.array("X_m", "Y_m", "Z_m"), rtol=0, atol=1e-8)
    assert_same(sample, found.plan, part(stored, "K") + part(stored, "reading"))


def assert_same(photo: orient.Photo, plan: Array, expected: Array) -> None:
    """The stage takes the vertical at the given point, the door at the place itself: apart by |dX, dY| / radius."""
    is_local = photo.orientation.geographic is None
    apart = photo.table("ground_covariance", "covariance").array("dX_m", "dY_m")
    tilt = 0.0 if is_local else float(np.nanmax(np.abs(apart))) / 1.7e6
    scale = np.sqrt(np.einsum("ni,nj->nij", *2 * [np.diagonal(expected, axis1=1, axis2=2)]))
    assert np.max(np.abs(plan - expected) / scale) < 1e-12 + 2 * tilt


def test_the_height_of_the_points_enters_as_in_the_stage(space: orient.Photo) -> None:
    stored, readings, heights, sigma = lists(space)
    with open_project(space.path) as project:
        _, rows = project.query(
            "SELECT g.point, p.cov_ZZ_m2 FROM ground_covariance AS g JOIN geographic_point AS p USING (point) "
            "ORDER BY g.point"
        )
    sigma_H = np.sqrt([variance for _, variance in rows])
    found = space.image_to_ground(readings, heights, sigma=sigma, sigma_H=sigma_H, system="comparator")
    assert part(stored, "height").max() > 1.0
    assert_same(space, found.plan, part(stored, "K") + part(stored, "reading") + part(stored, "height"))


def test_ground_to_image_to_ground(sample: orient.Photo) -> None:
    stored, readings, heights, _ = lists(sample)
    points = stored.array("X_m", "Y_m", "Z_m")
    for system in ("comparator", "image", None):
        xy, _ = sample.ground_to_image(points, system=system)
        again = sample.image_to_ground(xy, heights, system=system).points
        distance = np.linalg.norm(points - sample.orientation.station, axis=1)
        assert np.max(np.linalg.norm(again - points, axis=1) / distance) < 1e-12
        np.testing.assert_allclose(again, points, rtol=0, atol=1e-8)
    # the readings come back through lens, refraction and fiducials: Newton closes to 1e-10 mm
    np.testing.assert_allclose(sample.ground_to_image(points, system="comparator").xy, readings, rtol=0, atol=1e-9)


def drawn(model: PhotoModel, rng: np.random.Generator) -> PhotoModel:
    """The same photo with an orientation that errs as its covariance says."""
    oriented = model.oriented
    error = symmetric_factor(oriented.covariance) @ rng.standard_normal(6)
    turned = rotation_exp(error[:3]) @ oriented.rotation
    return replace(model, oriented=replace(oriented, rotation=turned, station=oriented.station + error[3:]))


def test_a_simulation_agrees(calgary: orient.Photo) -> None:
    """Orientation, reading and height drawn at random: the spread of the places is the covariance, within 4 sigmas."""
    calgary.run("resection", interior="fixed")  # six elements: everything that is drawn
    model, rng = model_of(calgary), np.random.default_rng(20)
    readings, height, sigma_px, sigma_H = np.array([[60.0, 120.0]]), 1090.0, 1.3, 2.0
    sigma = sigma_px * abs(model.pixel_step[0])
    pixels = model.pixels_from_mm(readings)
    told = calgary.image_to_ground(pixels, height, sigma=sigma_px, sigma_H=sigma_H)
    places = []
    for _ in range(TRIALS):
        noisy = readings + np.sqrt(model.oriented.scale) * sigma * rng.standard_normal((1, 2))
        at = np.array([height + sigma_H * rng.standard_normal()])
        places.append(on_ground(drawn(model, rng), noisy, at, np.zeros((1, 2, 2)), np.zeros(1)).points[0])
    spread = np.cov(np.array(places).T)
    expected = told.covariances[0]
    sigmas = np.sqrt(np.diag(expected))
    # a covariance of N draws has itself a standard deviation of at most sqrt(2/N) of the product of the sigmas
    assert np.max(np.abs(spread - expected) / np.outer(sigmas, sigmas)) < 4 * np.sqrt(2 / TRIALS)


def test_covariance_in_the_image_by_a_simulation(calgary: orient.Photo) -> None:
    calgary.run("resection", interior="fixed")
    model, rng = model_of(calgary), np.random.default_rng(21)
    point, own = np.array([[-200.0, -300.0, 1085.0]]), np.diag([0.04, 0.09, 0.25])
    told = calgary.ground_to_image(point, own)
    moved = point + rng.multivariate_normal(np.zeros(3), own, TRIALS)
    images = [drawn(model, rng).project(model.frame.right_handed(place[None]))[0][0] for place in moved]
    # camera and fiducials are known here: the way back to the reading is the same for all draws
    spread, expected = np.cov(model.pixels_from_mm(model.readings(np.array(images))).T), told.covariances[0]
    sigmas = np.sqrt(np.diag(expected))
    assert np.max(np.abs(spread - expected) / np.outer(sigmas, sigmas)) < 4 * np.sqrt(2 / TRIALS)


def test_the_fiducials_make_the_places_less_sure(space: orient.Photo) -> None:
    """What all points share is more than the six elements: the interior orientation as sure as its marks."""
    reading, H = [[215.0, 190.0], [130.0, 100.0]], 800.0
    weighted = space.image_to_ground(reading, H).orientation
    space.run("resection", interior="fixed", reason="as if the film were without error")
    space.run()
    known = space.image_to_ground(reading, H).orientation
    assert not np.allclose(weighted[:, :2, :2], known[:, :2, :2], rtol=1e-3)


def test_the_sky_has_no_ground_and_the_other_side_no_image(space: orient.Photo, calgary: orient.Photo) -> None:
    behind = calgary.orientation.station + np.array([[0.0, 0.0, 50.0], [50.0, 20.0, -700.0], [90_000.0, 0.0, -700.0]])
    xy, covariances = calgary.ground_to_image(behind)
    assert np.isnan(xy).all(axis=1).tolist() == [True, False, True]
    assert np.isnan(covariances).all(axis=(1, 2)).tolist() == [True, False, True]
    above = calgary.orientation.station[2] + 100.0
    points, K = calgary.image_to_ground([[9000.0, 9000.0]], above)
    assert np.isnan(points).all()
    assert np.isnan(K).all()
    assert np.isnan(calgary.image_to_ground([[9000.0, 9000.0]], above).ellipses).all()


def test_heights_of_many_points_are_exact(space: orient.Photo) -> None:
    """The ray meets the ellipsoidal height itself, also at 9 km, where an enlarged ellipsoid is 0.1 m off."""
    heights = np.linspace(-400.0, 9000.0, 50)
    readings = np.column_stack([np.linspace(160.0, 260.0, 50), np.linspace(150.0, 240.0, 50)])
    found = space.image_to_ground(readings, heights)
    np.testing.assert_allclose(space.geographic_from_ground(found.points)[:, 2], heights, atol=2e-8)
    np.testing.assert_allclose(space.ground_to_image(found.points).xy, readings, atol=1e-9)


def test_geographic_round_trip(space: orient.Photo) -> None:
    """Heights to two units in the last place of the Earth's radius."""
    geographic = np.array([[42.1, 21.4, 800.0], [42.4, 22.0, -10.0]])
    points = space.ground_from_geographic(geographic)
    if find_spec("numba"):
        np.testing.assert_array_equal(space.ground_from_geographic(geographic, compiled=True), points)
    back = space.geographic_from_ground(points)
    np.testing.assert_allclose(back[:, :2], geographic[:, :2], rtol=1e-13)
    np.testing.assert_allclose(back[:, 2], geographic[:, 2], rtol=0, atol=2 * np.spacing(6.4e6))


@pytest.mark.parametrize("system", ["px", "comparator", "image"])
def test_no_readings_meet_the_ground_nowhere(calgary: orient.Photo, system: str) -> None:
    none = calgary.image_to_ground(np.zeros((0, 2)), 1090.0, sigma=1.0, system=system)
    assert (none.points.shape, none.covariances.shape, none.plan.shape) == ((0, 3), (0, 3, 3), (0, 2, 2))
    assert none.ellipses.shape == (0, 3)
    assert calgary.ground_to_image(none.points, none.covariances, system).xy.shape == (0, 2)


@pytest.mark.filterwarnings("error")
def test_places_far_beyond_the_earth_get_one_sentence(space: orient.Photo) -> None:
    for ask in (space.geographic_from_ground, space.ground_from_geographic, space.ground_to_image):
        with pytest.raises(orient.UsageError, match="not finite or beyond 1e"):
            ask([[1e200, 0.0, 1e300]])


BAD = {
    "shape": (lambda p: p.image_to_ground([[1.0, 2.0, 3.0]], 0.0), "xy has the shape (1, 3)"),
    "text": (lambda p: p.image_to_ground([["a", "b"]], 0.0), "xy holds something that is no real number"),
    "nan": (lambda p: p.image_to_ground([[np.nan, 2.0]], 0.0), "xy has numbers that are not finite"),
    "huge": (lambda p: p.image_to_ground([[10**400, 2.0]], 0.0), "xy has numbers that are not finite or beyond"),
    "large": (lambda p: p.image_to_ground([[1e200, 2.0]], 0.0), "xy has numbers that are not finite or beyond"),
    "large ground": (lambda p: p.ground_to_image([[1e300, 2.0, 3.0]]), "points has numbers that are not finite or"),
    "masked": (lambda p: p.image_to_ground(np.ma.masked_less([[1.0, 2.0]], 2.0), 0.0), "xy has masked elements"),
    "heights": (lambda p: p.image_to_ground([[1.0, 2.0]], [1.0, 2.0]), "H has the shape (2,)"),
    "sigma": (lambda p: p.image_to_ground([[1.0, 2.0]], 0.0, sigma=-1.0), "sigma is negative"),
    "system": (lambda p: p.image_to_ground([[1.0, 2.0]], 0.0, system="pixel"), 'there is no system "pixel"'),
    "covariance": (lambda p: p.ground_to_image([[1.0, 2.0, 3.0]], np.eye(2)), "covariances has the shape (2, 2)"),
    "not symmetric": (
        lambda p: p.ground_to_image([[1.0, 2.0, 3.0]], np.arange(9.0).reshape(3, 3)),
        "covariances is no covariance matrix",
    ),
    "no correlation": (
        lambda p: p.ground_to_image([[1.0, 2.0, 3.0]] * 2, [np.eye(3), np.eye(3) + 2 * np.eye(3)[::-1]]),
        "covariances[1] is no covariance matrix",
    ),
    "sigma of none": (lambda p: p.image_to_ground(np.zeros((0, 2)), 0.0, sigma=[1.0, 2.0]), "sigma has the shape (2,)"),
    "local": (lambda p: p.geographic_from_ground([[0.0, 0.0, 0.0]]), "the ground of this photo is local"),
    "stale": (lambda p: p.image_to_ground([[1.0, 2.0]], 0.0), "the orientation is out of date (refine, resection"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_makes_no_sense_is_one_sentence(calgary: orient.Photo, case: str) -> None:
    ask, words = BAD[case]
    if case == "stale":
        readings = calgary.path.parent / "readings.csv"
        from tests.cli.commands import AERIAL

        readings.write_text((AERIAL / "readings.csv").read_text().replace("1345.75", "1345.85"))
        calgary.add("readings", readings, reason="mark 1 read again")
    with pytest.raises(orient.OrientError) as error:
        ask(calgary)
    assert words in error.value.message


def test_a_photo_without_pixels_has_no_px(space: orient.Photo) -> None:
    with pytest.raises(orient.UsageError, match="no pixels"):
        space.image_to_ground([[1.0, 2.0]], 0.0, system="px")
