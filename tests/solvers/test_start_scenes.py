"""A resection without approximate values: random scenes of every kind end in the truth, or say that they do not.

Right: the station within 2 % of the distance, or within the linear covariance (e'Q^-1 e / sigma0^2 < 60, by chance once
in 1e10). Four points in a narrow field leave elements so uncertain that the linear covariance does not hold: there the
exact form of the same test counts, (v'Pv of the truth - v'Pv) / sigma0^2 < 60, and the end must be the minimum that the
adjustment reaches from the truth itself, so that no second orientation that fits as well can pass.
Said: ambiguous (another orientation fits as well), or no result with its termination.
"""

from collections import Counter

import numpy as np
import pytest
from numpy.typing import NDArray

from orient.geometry.collinearity import project
from orient.solvers.direct_linear import direct_linear_resection
from orient.solvers.functional_iteration import Termination
from orient.solvers.plane_resection import plane_resection
from orient.solvers.resection import Resection, resect
from orient.solvers.start_values import Method, start_candidates
from tests.solvers.resection_scenes import Scene, generator, looking, scene

FloatArray = NDArray[np.float64]
SIGMA_MM = 0.005
NADIR = {"vertical": (0.0, 0.05), "oblique": (0.3, 1.2), "horizontal": (1.5, 1.65), "upward": (1.9, 3.14)}
CAMERAS = ((90.0, 110.0), (152.0, 110.0), (35.0, 18.0), (1000.0, 90.0))


def random_scene(random: np.random.Generator, kind: str, shape: str, n: int) -> Scene:
    """Any camera, 3 m to 300 km away; points with relief, or on a plane tilted up to 40 degrees to the camera."""
    f_mm, half = CAMERAS[random.integers(len(CAMERAS))]
    R = looking(random.uniform(-3, 3), random.uniform(*NADIR[kind]), random.uniform(-3, 3))
    distance = 10 ** random.uniform(0.5, 5.5)
    xy = random.uniform(-half, half, (n, 2)) / f_mm
    if shape == "relief":
        depth = distance * (1 + random.uniform(0.02, 0.3) * random.uniform(-1, 1, n))
    else:
        depth = distance / (1 + xy @ random.uniform(-0.6, 0.6, 2) * min(1.0, 0.8 * f_mm / half))
    station = distance * random.normal(size=3)
    ground = station + (np.column_stack([xy, np.full(n, -1.0)]) * depth[:, None]) @ R.T
    return Scene(project(ground, station, R, f_mm)[0], ground, R, station, f_mm)


def ending(found: Resection, s: Scene, image: FloatArray) -> str:
    """`right`, `wrong`, `ambiguous` (another orientation fits as well, which the stage refuses), or the termination."""
    if found.termination is not Termination.CONVERGED:
        return found.termination.value
    if found.is_ambiguous:
        return "ambiguous"
    return "right" if is_truth(found, s) or is_minimum_of_the_truth(found, s, image) else "wrong"


def is_truth(found: Resection, s: Scene) -> bool:
    moved = found.station - s.station
    turned = found.rotation @ s.rotation.T
    if np.linalg.norm(moved) < 0.02 * np.linalg.norm(s.ground.mean(axis=0) - s.station):
        return True
    e = np.array([turned[2, 1], turned[0, 2], turned[1, 0], *moved]) / SIGMA_MM
    return bool(e @ np.linalg.solve(found.Q, e) < 60 and np.linalg.norm(turned - np.eye(3)) < 0.5)


def is_minimum_of_the_truth(found: Resection, s: Scene, image: FloatArray) -> bool:
    """The same minimum as from the true orientation, and the truth within the region that the readings allow."""
    from_truth = resect(image, s.unit, s.ground, s.f_mm, sigma0_mm=SIGMA_MM, start=(s.rotation, s.station))
    is_same = np.linalg.norm(from_truth.station - found.station) < 1e-6 * np.linalg.norm(s.ground[0] - s.station)
    misfit = np.sum((project(s.ground, s.station, s.rotation, s.f_mm)[0] - image) ** 2)
    return bool(is_same and (misfit - found.vPv) / SIGMA_MM**2 < 60)


def endings(kind: str, shape: str, count: int) -> Counter[str]:
    random = generator(f"{kind} {shape}")
    found: Counter[str] = Counter()
    for number in range(count):
        s = random_scene(random, kind, shape, 3 + number % 8)
        image = s.noisy(SIGMA_MM, random)
        result = resect(image, s.unit, s.ground, s.f_mm, sigma0_mm=SIGMA_MM)
        found[ending(result, s, image) + (" of 3" if len(s.image) == 3 else "")] += 1
    return found


@pytest.mark.parametrize("shape", ["relief", "plane"])
@pytest.mark.parametrize("kind", NADIR)
def test_no_scene_ends_in_a_wrong_success(kind: str, shape: str) -> None:
    found = endings(kind, shape, 24)
    assert found["wrong"] + found["wrong of 3"] == 0, found
    assert found["right"] >= 19, found


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["relief", "plane"])
@pytest.mark.parametrize("kind", NADIR)
def test_no_scene_of_a_thousand_ends_in_a_wrong_success(kind: str, shape: str) -> None:
    """875 scenes of four to ten points and 125 of three: printed by `pytest -s`."""
    found = endings(kind, shape, 1000)
    print(kind, shape, dict(found))
    assert found["wrong"] + found["wrong of 3"] == 0, found
    assert found["right"] >= 0.98 * 875, found


@pytest.mark.parametrize("n", [6, 20])
def test_direct_linear_is_exact_with_relief(n: int) -> None:
    s = scene(generator("direct linear"), n=n, relief=0.3)
    centre, size = s.ground.mean(axis=0), 1000.0
    ((R, S),) = direct_linear_resection(s.image, (s.ground - centre) / size, s.f_mm)
    np.testing.assert_allclose(R, s.rotation, atol=1e-10)
    np.testing.assert_allclose(S * size + centre, s.station, atol=1e-6)
    assert direct_linear_resection(s.image[:5], s.ground[:5], s.f_mm) == []


@pytest.mark.parametrize("n", [4, 20])
@pytest.mark.parametrize("tilt", [0.0, 0.6])
def test_plane_is_exact_on_a_plane(n: int, tilt: float) -> None:
    random = generator("plane")
    R = looking(1.0, tilt, 0.4)
    plane = np.column_stack([random.uniform(-1, 1, (n, 2)), np.zeros(n)])
    station = 3.0 * R[:, 2]
    image, zs = project(plane, station, R, 152.0)
    ((found, S),) = plane_resection(image, plane, 152.0)
    np.testing.assert_allclose(found, R, atol=1e-10)
    np.testing.assert_allclose(S, station, atol=1e-9)
    assert np.all(zs < 0)
    assert plane_resection(image[:3], plane[:3], 152.0) == []


def test_mirrored_control_puts_the_direct_linear_camera_behind() -> None:
    s = scene(generator("mirrored linear"), n=9, relief=0.3)
    candidates = start_candidates(s.image * [-1, 1], s.ground, s.f_mm)
    linear = [candidate for candidate in candidates if candidate.method is Method.DIRECT_LINEAR]
    assert linear
    assert not any(candidate.all_in_front and candidate.rms_mm < 1.0 for candidate in linear)


def test_every_refined_start_has_its_end() -> None:
    s = scene(generator("starts and ends"), n=3, relief=0.3)
    found = resect(s.image, s.unit, s.ground, s.f_mm)
    assert found.ends[0].termination is found.termination
    np.testing.assert_array_equal(found.ends[0].station, found.station)
    assert {start.end for start in found.starts} >= set(range(len(found.ends)))
    assert [end.vPv for end in found.ends[1:]] == sorted(end.vPv for end in found.ends[1:])
