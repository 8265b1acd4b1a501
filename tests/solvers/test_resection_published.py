"""Resections with published digits: Wolf & Dewitt (two sets), the Wuhan textbooks, Strasbourg (DBAT)."""

import numpy as np
import pytest

from orient.geometry.rotation import aok_by_rotation, aok_from_matrix, opk_by_rotation, opk_from_matrix
from orient.solvers.functional_iteration import Termination
from orient.solvers.resection import Resection, resect
from tests.solvers.resection_scenes import FloatArray, expected, numbers

UP = np.array([0.0, 0.0, 1.0])


def adjusted(image: FloatArray, ground: FloatArray, f_mm: float) -> Resection:
    result = resect(image, np.tile(np.eye(2), (len(image), 1, 1)), ground, f_mm, camera_above=UP)
    assert result.termination is Termination.CONVERGED
    assert not result.is_ambiguous
    return result


def standard_deviations(result: Resection, by_rotation: FloatArray) -> FloatArray:
    T = np.eye(6)
    T[:3, :3] = by_rotation
    return np.asarray(np.sqrt(np.diag(T @ result.Q @ T.T) * result.vPv / result.redundancy))


@pytest.mark.parametrize(("name", "points"), [("book", "points_book.csv"), ("sample", "points_program_sample.csv")])
def test_wolf_dewitt(name: str, points: str) -> None:
    folder = "wolf-dewitt-resection/"
    values = numbers(folder + points, "x_mm", "y_mm", "X", "Y", "Z")
    result = adjusted(values[:, :2], values[:, 2:], 152.916)
    rows = expected(folder + "expected.csv", set=name)
    elements = [*np.degrees(opk_from_matrix(result.rotation)), *result.station]
    sigma = standard_deviations(result, opk_by_rotation(result.rotation))
    sigma[:3] = np.degrees(sigma[:3])
    shrink = np.sqrt(result.redundancy / result.n_equations)
    for k, quantity in enumerate(("omega", "phi", "kappa", "XL", "YL", "ZL")):
        row = rows[quantity]
        assert f"{elements[k]:.4f}" == row["published"]
        assert f"{sigma[k] * shrink:.4f}" == row["published_sd"]
        assert elements[k] == pytest.approx(float(row["reproduced"]), abs=6e-9)
        assert sigma[k] == pytest.approx(float(row["reproduced_sd_redundancy"]), abs=6e-9)
    s0 = np.sqrt(result.vPv / result.redundancy)
    assert f"{s0 * shrink:.4f}" == rows["s0"]["published"]
    assert s0 == pytest.approx(float(rows["s0"]["reproduced_sd_redundancy"]), abs=6e-9)


def test_wolf_dewitt_residuals_of_the_book() -> None:
    """The program prints measured minus computed of the x, y of a diapositive; the signs are those of v."""
    values = numbers("wolf-dewitt-resection/points_book.csv", "x_mm", "y_mm", "X", "Y", "Z")
    result = adjusted(values[:, :2], values[:, 2:], 152.916)
    printed = [[0.0006, -0.0023], [-0.0001, 0.0024], [0.0021, 0.0003], [-0.0026, -0.0004]]
    np.testing.assert_allclose(result.residuals, printed, atol=5.1e-5)


def test_wuhan() -> None:
    folder = "wuhan-resection/"
    values = numbers(folder + "points.csv", "x_mm", "y_mm", "X_m", "Y_m", "Z_m")
    result = adjusted(values[:, :2], values[:, 2:], 153.24)
    rows = expected(folder + "expected.csv")
    elements = [*aok_from_matrix(result.rotation), *result.station]
    sigma = standard_deviations(result, aok_by_rotation(result.rotation))
    for k, quantity in enumerate(("phi (Y axis first)", "omega", "kappa", "Xs", "Ys", "Zs")):
        row = rows[quantity]
        assert f"{elements[k]:.{6 if k < 3 else 2}f}" == row["published"]
        assert elements[k] == pytest.approx(float(row["reproduced"]), abs=1e-9 if k < 3 else 1e-6)
        assert sigma[k] == pytest.approx(float(row["reproduced_sd"]), abs=1e-9 if k < 3 else 1e-6)
    matrix = [[float(rows[f"R{i}{j}"]["reproduced"]) for j in (1, 2, 3)] for i in (1, 2, 3)]
    np.testing.assert_allclose(result.rotation, matrix, atol=1e-9)
    assert np.sqrt(result.vPv / 2) == pytest.approx(float(rows["s0"]["reproduced"]), abs=1e-9)


STRASBOURG = """
4060.000000 912.333333 999604.580 112344.443 139.453
6455.659259 7294.808042 1000134.50 112591.16 138.01
8197.333333 11243.666667 1000460.33 112765.82 139.45
2409.155556 11859.132296 1000551.27 112275.28 139.86
4354.797531 1106.042802 999619.041 112370.818 138.97
1672.000000 6836.000000 1000126.748 112179.093 138.54
4034.333333 937.333333 999606.93 112342.35 139.10
2189.380247 12119.378729 1000575.072 112258.195 139.643
7392.600000 7745.875486 1000166.790 112674.298 138.761
6530.898765 11607.874189 1000502.467 112625.887 139.644
7180.170370 10949.792477 1000441.906 112677.087 139.757
4377.039506 9766.507134 1000359.462 112429.749 139.156
"""
"""col, row [px], X, Y, Z [m] of photo 8937: demo data of DBAT (Boerlin and Grussenmeyer, 2016; BSD, give credit)."""


def test_strasbourg_large_coordinates_and_a_narrow_field() -> None:
    values = np.array(STRASBOURG.split(), dtype=np.float64).reshape(-1, 5)
    image = np.column_stack([0.006 * values[:, 0] - 26.577, 38.811 - 0.006 * values[:, 1]])
    result = adjusted(image, values[:, 2:], 123.9392)
    station = result.station - [999779.50631, 112260.59100, 139.83210]
    np.testing.assert_allclose(station, [296.923308, 157.178011, 1770.575056], atol=5e-5)
    angles = np.degrees(opk_from_matrix(result.rotation))
    np.testing.assert_allclose(angles, [-0.169121, -0.022822, 94.401677], atol=1e-6)
    # DBAT's standard deviations hold for the common s0 = 1.0419 px of five photos
    own = np.sqrt(result.vPv / result.redundancy)
    sigma = standard_deviations(result, opk_by_rotation(result.rotation)) * 1.0419 * 0.006 / own
    np.testing.assert_allclose(sigma[3:], [0.797, 1.21, 0.114], atol=5e-3)
    np.testing.assert_allclose(np.degrees(sigma[:3]), [0.0386, 0.0247, 0.00368], atol=6e-5)
    assert own / 0.006 == pytest.approx(0.64500, abs=5e-6)
    assert {("r_X", "Y_S"), ("r_Y", "X_S")} <= {(a, b) for a, b, _ in result.weak}
