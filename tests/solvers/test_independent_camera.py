"""The second engine's camera says the same as the first one's, which it shares no line with."""

import numpy as np
import pytest

from orient.geometry.camera import INTERIOR, Camera, Measured, camera_equations
from orient.geometry.distortion import Distortion
from orient.solvers.independent_algebra import STEP
from orient.solvers.independent_camera import IndependentCamera
from tests.jacobian import central_difference
from tests.solvers.resection_scenes import FloatArray, generator

BROWN = {"k0": 1e-5, "k1": -3e-8, "k2": 2e-12, "k3": 1e-16, "p1": 2e-7, "p2": -1e-7, "s1": 1e-7, "s3": -2e-7}
OPENCV = {"k1": -0.11, "k2": 0.03, "k3": -0.01, "k4": 0.02, "p1": 1e-3, "p2": -2e-3, "s1": 1e-3, "s4": 5e-4}
TABLE = np.array([[10.0, 0.002], [50.0, 0.011], [120.0, -0.004], [170.0, 0.02]])
LENSES = {
    "none": Distortion(),
    "brown correction": Distortion("brown", "correction", BROWN, None, 150.0),
    "brown displacement": Distortion("brown", "displacement", BROWN, None, 150.0),
    "brown from ideal": Distortion("brown", "ideal_to_distorted", BROWN, None, 150.0),
    "opencv": Distortion("opencv", "ideal_to_distorted", OPENCV, None, 150.0),
    "table": Distortion("radial_table", "correction", {}, TABLE, 150.0),
}


def both(name: str) -> tuple[Camera, tuple[str, ...], Measured, IndependentCamera, FloatArray]:
    lens = LENSES[name]
    camera = Camera(150.0, 0.3, -0.2, lens, 2e-4, -1e-4)
    fixed = ("k1", "k2", "k3", "p1", "p2") if lens.model in ("none", "radial_table") else ()
    names = tuple(one for one in INTERIOR if one not in fixed)
    random = generator(name)
    frame = random.uniform(-100, 100, (9, 2))
    measured = Measured(frame, random.uniform(-0.01, 0.01, (9, 2)))
    own = {"f": camera.f_mm, "x0": camera.x0_mm, "y0": camera.y0_mm, "b1": camera.b1, "b2": camera.b2}
    other = IndependentCamera(
        names, {**lens.coefficients, **own}, np.full(len(names), np.inf), lens.model, lens.direction, lens.table,
        measured.frame, measured.air,
    )  # fmt: skip
    return camera, names, measured, other, frame / 150.0


@pytest.mark.parametrize("name", LENSES)
def test_misclosures_are_those_of_the_first_engine(name: str) -> None:
    camera, names, measured, other, slopes = both(name)
    first = camera_equations(camera, names, 150.0 * slopes, measured)
    second = other.misclosures(slopes.astype(np.complex128), other.apriori.astype(np.complex128))
    assert second.real == pytest.approx(first.misclosure, abs=1e-12)  # mm
    assert other.apriori == pytest.approx(camera.values(names))


@pytest.mark.parametrize("name", LENSES)
def test_complex_step_analytic_partials_and_central_differences_agree(name: str) -> None:
    camera, names, measured, other, slopes = both(name)
    c = other.apriori
    size = np.where(c == 0, 1e-6, np.abs(c))
    columns = [
        other.misclosures(slopes.astype(np.complex128), c + 1j * STEP * one).imag / STEP for one in np.eye(len(names))
    ]
    by_step = np.stack(columns, axis=-1)
    by_difference = central_difference(
        lambda values: other.misclosures(slopes.astype(np.complex128), values.astype(np.complex128)).real,
        c, 1e-5 * size,
    )  # fmt: skip
    analytic = camera_equations(camera, names, 150.0 * slopes, measured).by_elements
    assert by_step * size == pytest.approx(by_difference * size, abs=1e-8)  # digits of the differences
    assert by_step * size == pytest.approx(analytic * size, abs=1e-11)
