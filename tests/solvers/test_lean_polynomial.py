"""The lean fit against `fit_sheet` and numpy's lstsq on the same normalised coordinates."""

import numpy as np
import pytest

from orient.errors import GeometryError, UsageError
from orient.geometry import polynomial
from orient.solvers import lean_polynomial as lean
from orient.solvers.lean_polynomial import POINTS_AT_ONCE, lean_polynomial
from orient.solvers.polynomial_degree import Crosses, Rule, terms
from orient.solvers.polynomial_fit import fit_sheet
from tests.solvers.resection_scenes import FloatArray, generator


def crosses(name: str, n: int, degree: int, sigma: float = 0.5) -> tuple[FloatArray, FloatArray]:
    """Places on a sheet of 500 x 400 mm, northings and eastings of some 100 km with errors of `sigma`."""
    random = generator(name)
    XY = random.uniform([20.0, -30.0], [520.0, 370.0], (n, 2))
    u, v = ((XY - [270.0, 170.0]) / 250.0).T
    smooth = polynomial.design(u, v, degree) @ random.normal(scale=1e4, size=(terms(degree), 2))
    return XY, smooth + np.array([4.6e6, 3e5]) + random.normal(scale=sigma, size=(n, 2))


@pytest.mark.parametrize("sigma", [0.5, 500.0], ids=["small residuals", "large residuals"])
@pytest.mark.parametrize("n", [40, POINTS_AT_ONCE + 50], ids=["few", "more than one part"])
@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_the_coefficients_cofactors_and_tests_of_the_stage(degree: int, n: int, sigma: float) -> None:
    """v'v is a difference of squares when it is large, and a sum of squares when it is small."""
    XY, z = crosses(f"stage {degree} {n}", n, degree, sigma)
    fit, full = lean_polynomial(XY, z, degree), fit_sheet(Crosses(XY, z, np.ones_like(z)), Rule(degree))
    assert (fit.scale, fit.redundancy) == (full.scale_mm, full.redundancy)
    np.testing.assert_allclose(fit.centre, full.centre_mm, rtol=1e-15)
    np.testing.assert_allclose(fit.coefficients, full.coefficients, rtol=1e-9, atol=1e-9 * 1e4)
    np.testing.assert_allclose(fit.Q, full.cofactor, rtol=0, atol=1e-9 * np.max(full.cofactor))
    np.testing.assert_allclose(fit.sigma0, full.sigma0, rtol=1e-9)
    np.testing.assert_allclose(1.0 - fit.leverages(XY), full.redundancy_numbers, rtol=0, atol=1e-12)


@pytest.mark.parametrize("unit", [1.0, 1000.0], ids=["mm", "um"])
def test_raw_units_do_not_matter(unit: float) -> None:
    """Order 5 of raw micrometres, where lstsq on raw powers is wrong by 0.1 m: within 1e-9 of the extent of z."""
    XY, z = crosses("raw", 2000, 5)
    u, v = ((XY - [270.0, 170.0]) / 250.0).T
    D = polynomial.design(u, v, 5)
    best = D @ np.linalg.lstsq(D, z - z[0], rcond=None)[0] + z[0]
    np.testing.assert_allclose(lean_polynomial(XY * unit, z, 5).values(XY * unit), best, rtol=0, atol=1e-9 * np.ptp(z))


@pytest.mark.parametrize("shape", [(3, 1), (3, 3), (1,), (2, 2, 2)], ids=str)
def test_places_have_two_coordinates(shape: tuple[int, ...]) -> None:
    fit = lean_polynomial(*crosses("two coordinates", 30, 2), 2)
    for function in (fit.values, fit.leverages):
        with pytest.raises(UsageError, match="shape"):
            function(np.ones(shape))


def test_compiled_values_are_the_same() -> None:
    """To 1e-9 of the extent of z, some 100 km."""
    pytest.importorskip("numba", reason="numba is not installed: orient[fast]")
    XY, z = crosses("compiled", 300, 5)
    fit = lean_polynomial(XY, z, 5)
    for places in (XY, XY[:1], XY[7]):
        np.testing.assert_allclose(fit.values(places, compiled=True), fit.values(places), rtol=0, atol=1e-9)


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_an_exact_polynomial_comes_back(degree: int) -> None:
    """Residuals are rounding of 4.6e6 m."""
    XY, z = crosses("exact", 300, degree, sigma=0.0)
    fit = lean_polynomial(XY, z, degree)
    assert np.max(np.abs(fit.values(XY) - z)) < 1e-8
    assert fit.sigma0 is not None and np.all(fit.sigma0 < 1e-8)


def test_badly_conditioned_columns_are_left_to_qr(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two clusters of places: the normals have the condition 1e9; coefficients as lstsq has them, to 1e-9."""
    random = generator("clusters")
    XY = np.concatenate([random.uniform(0, 1.0, (60, 2)), random.uniform(0, 1.0, (60, 2)) + np.array([60.0, 55.0])])
    z = random.normal(size=(120, 1))
    asked: list[bool] = []
    by_qr = lean._by_qr
    monkeypatch.setattr(lean, "_by_qr", lambda equations: (asked.append(True), by_qr(equations))[1])
    fit = lean_polynomial(XY, z, 3)
    assert asked
    u, v = ((XY - fit.centre) / fit.scale).T
    D = polynomial.design(u, v, 3)
    best = np.linalg.lstsq(D, z, rcond=1e-15)[0]
    np.testing.assert_allclose(D @ fit.coefficients, D @ best, rtol=0, atol=1e-9)
    np.testing.assert_allclose(fit.coefficients, best, rtol=0, atol=1e-9 * np.abs(best).max())
    np.testing.assert_allclose(fit.leverages(XY).sum(), 10.0, rtol=1e-9)


def test_a_narrow_strip_is_not_badly_conditioned(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lean, "_by_qr", lambda equations: pytest.fail("QR was asked"))
    XY, z = crosses("strip", 500, 5)
    wide, narrow = lean_polynomial(XY, z, 5), lean_polynomial(XY * [1.0, 1e-3], z, 5)
    np.testing.assert_allclose(narrow.values(XY * [1.0, 1e-3]), wide.values(XY), rtol=0, atol=1e-9 * np.ptp(z))


CURVES = {
    "an axis, degree 1": (np.arange(20.0)[:, None] * [1.0, 0.0], 1),
    "a line, degree 1": (np.arange(20.0)[:, None] * [1.0, 2.0], 1),
    "two rows, degree 2": (np.array([[x, y] for x in range(9) for y in (0.0, 1.0)]), 2),
    "a circle, degree 2": (np.array([[np.cos(t), np.sin(t)] for t in np.arange(15.0)]), 2),
}


@pytest.mark.parametrize("name", CURVES)
def test_points_on_a_curve_of_the_degree_are_refused(name: str) -> None:
    XY, degree = CURVES[name]
    with pytest.raises(GeometryError, match=f"curve of degree {degree}"):
        lean_polynomial(XY, XY, degree)


def test_too_few_points_and_points_in_one_place() -> None:
    with pytest.raises(GeometryError, match="5 points; degree 2 needs 6"):
        lean_polynomial(np.zeros((5, 2)), np.zeros((5, 2)), 2)
    with pytest.raises(GeometryError, match="one place"):
        lean_polynomial(np.ones((9, 2)), np.zeros((9, 2)), 1)


def test_as_many_points_as_terms_leave_no_sigma() -> None:
    XY, z = crosses("exactly", 6, 2)
    fit = lean_polynomial(XY, z, 2)
    assert fit.redundancy == 0 and fit.sigma0 is None
    np.testing.assert_allclose(fit.leverages(XY), 1.0, rtol=1e-9)


def test_one_place_may_come_alone_and_no_place_is_none() -> None:
    XY, z = crosses("alone", 30, 2)
    fit = lean_polynomial(XY, z, 2)
    np.testing.assert_array_equal(fit.values(XY[0]), fit.values(XY)[:1])
    assert (fit.values(XY[:0]).shape, fit.leverages(XY[:0]).shape) == ((0, 2), (0,))
