"""Three-point resections and start candidates find the truth from any attitude, without approximations."""

import numpy as np
import pytest

from orient.solvers.p3p import resections_of_triples, three_point_resections
from orient.solvers.start_values import camera_rays, distinct, spread_triples, start_candidates
from tests.solvers.resection_scenes import Scene, any_rotation, generator, looking, scene

FIELDS = {"wide": (90.0, 110.0), "aerial": (152.0, 100.0), "strasbourg": (124.0, 40.0), "long": (1000.0, 90.0)}


@pytest.mark.parametrize("field", FIELDS)
def test_p3p_contains_the_truth(field: str) -> None:
    random = generator(field)
    f_mm, half = FIELDS[field]
    for _ in range(40):
        s = scene(random, n=3, f_mm=f_mm, half_mm=half)
        found = three_point_resections(camera_rays(s.image, f_mm), s.ground)
        error = min(np.max(np.abs(S - s.station)) for _, S in found) / 2000
        assert len(found) <= 4
        assert error < 1e-7


def test_p3p_solutions_are_exact_and_rotations() -> None:
    random = generator("test_p3p_solutions_are_exact_and_rotations")
    for _ in range(40):
        s = scene(random, n=3, relief=0.4)
        rays = camera_rays(s.image, s.f_mm)
        exact = 0
        for R, S in three_point_resections(rays, s.ground):
            seen = (s.ground - S) @ R
            exact += np.allclose(seen / np.linalg.norm(seen, axis=1, keepdims=True), rays, atol=1e-9)
            np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
            assert np.linalg.det(R) == pytest.approx(1.0)
        assert exact >= 1


def test_p3p_symmetric_triangle_below_the_camera_has_four_solutions() -> None:
    corners = np.array([[np.cos(a), np.sin(a), 0.0] for a in (0.3, 0.3 + 2 * np.pi / 3, 0.3 + 4 * np.pi / 3)])
    image = corners[:, :2] * 100.0
    found = three_point_resections(camera_rays(image, 150.0), corners * 1000.0)
    assert len(found) == 4
    assert min(np.max(np.abs(S - [0, 0, 1500.0])) for _, S in found) < 1e-6


def test_p3p_of_many_triples_is_that_of_each() -> None:
    random = generator("test_p3p_of_many_triples")
    ground = random.normal(size=(40, 3, 3))
    ground[7] = ground[7, :1] + np.outer([0.0, 1.0, 3.0], ground[7, 1])  # a line
    rays = ground - [0.1, -0.2, 5.0]
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    together = resections_of_triples(rays, ground)
    assert together[7] == []
    assert {len(found) for found in together} > {1, 2}
    for one, ray, place in zip(together, rays, ground, strict=True):
        alone = three_point_resections(ray, place)
        assert len(one) == len(alone)
        for (R, S), (R_alone, S_alone) in zip(one, alone, strict=True):
            assert np.array_equal(R, R_alone)
            assert np.array_equal(S, S_alone)


@pytest.mark.parametrize("collinear", ["image", "ground"])
def test_p3p_of_points_on_a_line_is_empty(collinear: str) -> None:
    s = scene(generator(collinear), n=3)
    image, ground = s.image.copy(), s.ground.copy()
    if collinear == "image":
        image[2] = 0.3 * image[0] + 0.7 * image[1]
    else:
        ground[2] = 0.3 * ground[0] + 0.7 * ground[1]
    assert three_point_resections(camera_rays(image, s.f_mm), ground) == []


ATTITUDES = {
    "vertical": looking(0.3, 0.0, 2.0),
    "oblique": looking(1.0, 0.9, -1.0),
    "horizontal": looking(2.0, np.pi / 2, 0.1),
    "upward": looking(-1.0, 2.5, 3.0),
    "zenith": looking(0.0, np.pi, 1.0),
}


@pytest.mark.parametrize("relief", [0.0, 0.1])
@pytest.mark.parametrize("attitude", ATTITUDES)
def test_best_candidate_is_the_truth(attitude: str, relief: float) -> None:
    s = scene(generator(attitude), rotation=ATTITUDES[attitude], relief=relief, origin=(4.5e6, 5.2e6, 300.0))
    best = start_candidates(s.image, s.ground, s.f_mm)[0]
    assert best.all_in_front
    assert best.rms_mm < 1e-5
    np.testing.assert_allclose(best.station, s.station, atol=1e-3)
    np.testing.assert_allclose(best.rotation, s.rotation, atol=1e-6)


def test_approximate_station_gives_a_candidate_with_its_rotation() -> None:
    s = scene(generator("test_approximate_station"))
    near = start_candidates(s.image, s.ground, s.f_mm, s.station + 1.0)
    mine = next(candidate for candidate in near if candidate.triple == ())
    np.testing.assert_allclose(mine.rotation, s.rotation, atol=2e-3)


def test_candidates_are_sorted_and_triples_are_spread() -> None:
    random = generator("test_candidates_are_sorted")
    s = scene(random, n=60)
    candidates = start_candidates(s.noisy(0.01, random), s.ground, s.f_mm)
    front = [candidate.rms_mm for candidate in candidates if candidate.all_in_front]
    assert front == sorted(front)
    assert all(c.all_in_front for c in candidates[: len(front)])
    assert 1 <= len(spread_triples(s.image, s.ground)) <= 20
    assert len(distinct(candidates, s.ground)) <= 6


def test_flat_ground_in_a_narrow_field_offers_both_tilts() -> None:
    """A plane seen through a long lens nearly fits with its tilt reversed."""
    R = any_rotation(generator("R"))
    random = generator("test_flat_ground_in_a_narrow_field")
    plane = np.column_stack([random.uniform(-100, 100, (8, 2)), np.zeros(8)])
    tilt = looking(0.4, 0.5, 0.2)
    station = 20000.0 * tilt[:, 2]
    camera = (plane - station) @ tilt
    image = -1000.0 * camera[:, :2] / camera[:, 2:]
    s = Scene(image, plane @ R.T, R @ tilt, R @ station, 1000.0)
    stations = [c.station / 20000.0 for c in distinct(start_candidates(s.image, s.ground, s.f_mm), s.ground)]
    nadir = [float(np.arccos(np.clip(station @ R[:, 2], -1, 1))) for station in stations]
    assert sum(abs(angle - 0.5) < 0.1 for angle in nadir) >= 2


def test_double_solutions_keep_the_digits_that_rounding_leaves() -> None:
    """Above the circle through the points two solutions meet: half of the digits are left, and no fewer."""
    random = generator("on the cylinder")
    away = []
    for _ in range(600):
        ground = np.column_stack([random.normal(size=(3, 2)), np.zeros(3)])
        a, b, c = ground[:, :2]
        centre = np.linalg.solve(2 * np.array([b - a, c - a]), [b @ b - a @ a, c @ c - a @ a])
        turn, radius = random.uniform(0, 2 * np.pi), np.linalg.norm(a - centre)
        station = np.array([*(centre + radius * np.array([np.cos(turn), np.sin(turn)])), random.uniform(1, 4)])
        rays = (ground - station) / np.linalg.norm(ground - station, axis=1, keepdims=True)
        found = three_point_resections(rays, ground)
        away.append(min((float(np.linalg.norm(S - station)) for _, S in found), default=np.inf))
    assert np.median(away) < 7e-8
    assert np.mean(np.array(away) > 1e-5) < 0.08
