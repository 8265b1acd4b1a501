"""OpenCV's exterior orientation and lens: against central differences, against orient's lens, and against OpenCV."""

import math

import numpy as np
import pytest

from orient.geometry.distortion import Distortion, distort
from orient.geometry.opencv_exterior import left_jacobian_inverse, opencv_exterior, rotation_log
from orient.geometry.opencv_lens import converted, distorted, fitted
from orient.geometry.rotation import matrix_from_opk, rotation_exp
from orient.geometry.vertical_photo import grid_layout
from tests.jacobian import central_difference

UPRIGHT, TURNED = np.array([1.0, -1.0, -1.0]), np.array([-1.0, 1.0, -1.0])
VIEWS = {
    "vertical": (0.02, -0.03, 1.2),
    "no rotation of the ground": (0.0, 0.0, 0.0),
    "horizontal": (1.5, 0.2, -0.4),
    "upside down": (0.01, 0.02, math.pi - 1e-3),
    "small turn of OpenCV's camera": (math.pi - 1e-4, 2e-5, -1e-5),
}


@pytest.mark.parametrize("axes", [UPRIGHT, TURNED], ids=["upright", "turned scan"])
@pytest.mark.parametrize("angles", VIEWS.values(), ids=VIEWS)
def test_the_jacobian_is_that_of_central_differences(angles: tuple[float, float, float], axes: np.ndarray) -> None:
    """1e-7 of the largest element: steps of 1e-5 rad and 1 m; the third derivative leaves 1e-10."""
    rotation, station = matrix_from_opk(*angles), np.array([120.0, -340.0, 2500.0])
    start = opencv_exterior(rotation, station, axes)

    def vector(x: np.ndarray) -> np.ndarray:
        moved = opencv_exterior(rotation_exp(x[:3]) @ rotation, station + x[3:], axes)
        rvec = moved.rvec
        if rvec @ start.rvec < 0:  # beyond a half turn: the same rotation the long way round
            rvec = rvec * (1 - 2 * math.pi / np.linalg.norm(rvec))
        return np.concatenate([rvec, moved.tvec])

    wanted = central_difference(vector, np.zeros(6), np.array([1e-5] * 3 + [1.0] * 3))
    assert np.abs(start.jacobian - wanted).max() < 1e-7 * np.abs(wanted).max()


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 1e-2, 1.0, 3.0, math.pi - 1e-9, math.pi])
def test_the_logarithm_is_the_way_back(angle: float) -> None:
    r = angle * np.array([0.6, 0.0, 0.8])
    assert rotation_log(rotation_exp(r)) == pytest.approx(r, abs=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-6, 0.0099, 0.0101, 1.0, 3.1], ids=str)
def test_the_left_jacobian(angle: float) -> None:
    """exp([phi]x) exp([r]x) = exp([r + J^-1 phi]x) to first order; 1e-9: second order of 1e-5."""
    r, phi = angle * np.array([0.48, 0.64, 0.6]), 1e-5 * np.array([0.3, -0.5, 0.7])
    found = rotation_log(rotation_exp(phi) @ rotation_exp(r)) - r
    assert found == pytest.approx(left_jacobian_inverse(r) @ phi, abs=1e-9)


LENSES = {
    "none": Distortion(),
    "opencv": Distortion(
        "opencv",
        "ideal_to_distorted",
        {"k1": -0.11, "k2": 0.02, "p1": 1e-3, "p2": -2e-3, "k4": 0.01, "k6": 1e-3, "s1": 1e-3, "s4": -2e-3},
        f_mm=100.0,
    ),
    "brown": Distortion(
        "brown",
        "ideal_to_distorted",
        {"k0": 1e-3, "k1": -2e-6, "k2": 3e-11, "k3": 1e-15, "p1": 2e-6, "p2": -3e-6, "s1": 1e-6, "s2": 2e-11}
        | {"s3": -4e-6, "s4": 1e-10},
        f_mm=100.0,
    ),
}


@pytest.mark.parametrize("axes", [UPRIGHT[:2], TURNED[:2]], ids=["upright", "turned scan"])
@pytest.mark.parametrize("lens", LENSES.values(), ids=LENSES)
def test_a_lens_from_ideal_to_distorted_is_converted_exactly(lens: Distortion, axes: np.ndarray) -> None:
    """1e-11 mm, rounding of 100 mm; OpenCV itself then distorts like orient."""
    cv2 = pytest.importorskip("cv2")
    f, ideal = 100.0, grid_layout(90.0, 60.0, 7, 5)
    found = converted(lens, f, axes)
    assert found is not None
    wanted = distort(lens, ideal)
    assert f * distorted(found, axes * ideal / f) * axes == pytest.approx(wanted, abs=1e-11)
    rays = np.column_stack([axes * ideal / f, np.ones(len(ideal))])
    K = np.diag([f * found.scale, f * found.scale, 1.0])
    seen, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), K, found.coefficients)
    assert seen[:, 0] * axes == pytest.approx(wanted, abs=1e-11)


@pytest.mark.parametrize("direction", ["correction", "displacement"])
def test_other_lenses_are_fitted(direction: str) -> None:
    """A metric camera of 153 mm: 1e-5 mm in a frame of 23 cm, as good as a hundredth of its smallest sigma."""
    lens = Distortion("brown", direction, {"k0": -9e-5, "k1": 1.5e-8, "k2": -5e-13, "p1": -1.3e-7})
    assert converted(lens, 153.0, UPRIGHT[:2]) is None
    ideal = grid_layout(230.0, 230.0, 31, 31)
    measured = distort(lens, ideal)
    found = fitted(UPRIGHT[:2] * ideal / 153.0, UPRIGHT[:2] * measured / 153.0)
    missed = 153.0 * distorted(found, UPRIGHT[:2] * ideal / 153.0) - UPRIGHT[:2] * measured
    assert np.abs(missed).max() < 1e-5
    assert found.scale == pytest.approx(1.0, abs=1e-3)


def test_a_denominator_is_found_where_it_is_there() -> None:
    lens = Distortion("opencv", "ideal_to_distorted", {"k1": 0.2, "k4": 0.5, "k5": 0.1}, f_mm=100.0)
    u = grid_layout(1.6, 1.2, 21, 21)
    wanted = distort(lens, 100.0 * u * UPRIGHT[:2]) * UPRIGHT[:2] / 100.0
    assert np.abs(distorted(fitted(u, wanted), u) - wanted).max() > 1e-5
    assert np.abs(distorted(fitted(u, wanted, rational=True), u) - wanted).max() < 1e-10
