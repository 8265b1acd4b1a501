"""The camera's equations: every partial against central differences, both directions against each other."""

import zlib
from dataclasses import replace

import numpy as np
import pytest

from orient.geometry.camera import INTERIOR, Camera, Measured, camera_equations, corrected
from orient.geometry.distortion import Distortion, correction, distort
from tests.jacobian import Array, central_difference

BROWN = {"k0": 1e-4, "k1": 3e-7, "k2": -2e-11, "k3": 1e-15, "p1": 2e-6, "p2": -3e-6, "s1": 1e-6}
OPENCV = {"k1": -0.12, "k2": 0.05, "k3": 0.01, "k4": 0.02, "k5": 0.03, "k6": 0.01, "p1": 1e-3, "p2": -2e-3, "s3": 1e-3}
TABLE = np.array([[0.0, 0.0], [40.0, 0.01], [80.0, -0.02], [200.0, 0.05]])
LENSES = {
    "none": Distortion(),
    "correction": Distortion("brown", "correction", BROWN),
    "displacement": Distortion("brown", "displacement", BROWN),
    "ideal_to_distorted": Distortion("brown", "ideal_to_distorted", BROWN),
    "opencv": Distortion("opencv", "ideal_to_distorted", OPENCV, None, 150.0),
    "table": Distortion("radial_table", "displacement", {}, TABLE),
}
STEPS = {
    "f": 1e-3, "x0": 1e-3, "y0": 1e-3, "k1": 1e-9, "k2": 1e-13, "k3": 1e-17, "p1": 1e-8, "p2": 1e-8, "b1": 1e-6,
    "b2": 1e-6,
}  # fmt: skip
OPENCV_STEPS = dict.fromkeys(("k1", "k2", "k3", "p1", "p2"), 1e-06)


def case(lens: str) -> tuple[Camera, tuple[str, ...], Array, Measured]:
    random = np.random.default_rng(zlib.crc32(lens.encode()))
    camera = Camera(150.0, 0.3, -0.2, LENSES[lens], 2e-4, -1e-4)
    names = tuple(n for n in INTERIOR if lens not in ("none", "table") or not n.startswith(("k", "p")))
    direction = random.uniform(-0.5, 0.5, (7, 2))
    measured = Measured(150.0 * direction + random.normal(size=(7, 2)), random.normal(scale=0.01, size=(7, 2)))
    return camera, names, direction, measured


@pytest.mark.parametrize("lens", LENSES)
def test_partials_by_the_elements(lens: str) -> None:
    camera, names, direction, measured = case(lens)

    def misclosure(values: Array) -> Array:
        moved = camera.with_values(names, values)
        return camera_equations(moved, (), moved.f_mm * direction, measured).misclosure

    steps = np.array([(OPENCV_STEPS if lens == "opencv" else {}).get(name, STEPS[name]) for name in names])
    numeric = central_difference(misclosure, camera.values(names), steps)
    found = camera_equations(camera, names, camera.f_mm * direction, measured).by_elements
    # each column moves the image by millimetres per step scaled to 1 mm
    size = np.max(np.abs(numeric), axis=(0, 1))
    assert np.all(size > 0)
    assert found / size == pytest.approx(numeric / size, abs=1e-7)


@pytest.mark.parametrize("lens", LENSES)
def test_partials_by_the_computed_coordinates(lens: str) -> None:
    camera, _, direction, measured = case(lens)
    computed = camera.f_mm * direction
    found = camera_equations(camera, (), computed, measured).by_computed
    for i, place in enumerate(computed):
        one = Measured(measured.frame[i : i + 1], measured.air[i : i + 1])
        numeric = central_difference(
            lambda xy, one=one: camera_equations(camera, (), xy[None], one).misclosure[0], place
        )
        assert found[i] == pytest.approx(numeric, abs=1e-7)


@pytest.mark.parametrize("lens", LENSES)
def test_a_corrected_point_has_no_misclosure(lens: str) -> None:
    camera, _, _, measured = case(lens)
    image = corrected(camera, measured)
    found = camera_equations(camera, (), image, measured)
    assert found.misclosure == pytest.approx(np.zeros_like(image), abs=1e-10)
    assert np.max(np.abs(image - measured.frame)) > 0.1


@pytest.mark.parametrize("lens", LENSES)
def test_without_affinity_it_is_what_refine_does(lens: str) -> None:
    camera, _, _, measured = case(lens)
    plain = replace(camera, b1=0.0, b2=0.0)
    reduced = measured.frame - plain.principal_point
    assert corrected(plain, measured) == pytest.approx(reduced + correction(plain.distortion, reduced) + measured.air)


def test_imgraft_camera_has_its_f_along_y_and_an_affinity() -> None:
    """u = fx x (1 + k1 r^2) + cx, v = fy y (1 + k1 r^2) + cy with fx = f (1 + b1), fy = f."""
    f, b1, k1 = 30.0, -1.2e-3, -0.11
    camera = Camera(f, 0.0, 0.0, Distortion("opencv", "ideal_to_distorted", {"k1": k1}, None, f), b1)
    x = np.array([[0.3, -0.2], [-0.1, 0.25]])
    bent = x * (1 + k1 * np.sum(x * x, axis=1))[:, None]
    measured = Measured(bent * [f * (1 + b1), f], np.zeros((2, 2)))
    assert camera_equations(camera, (), f * x, measured).misclosure == pytest.approx(np.zeros((2, 2)), abs=1e-13)
    assert distort(camera.distortion, f * x) == pytest.approx(f * bent)
