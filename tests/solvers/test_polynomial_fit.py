"""The polynomial of a sheet: a real map with published corners, exact polynomials, refusals, statistics."""

import csv
from pathlib import Path

import numpy as np
import pytest

from orient.errors import GeometryError
from orient.geodesy.ellipsoid import meridian_radius, named_ellipsoid, prime_vertical_radius
from orient.geometry.polynomial import design, exponents
from orient.solvers.polynomial_degree import Crosses, Rule
from orient.solvers.polynomial_fit import fit_sheet, predict, suspects

N37 = Path(__file__).parents[2] / "sample_projects" / "n37-map-graticule" / "crosses_all.csv"
SEVEN = np.array([True, True, True, True, True, False, True, True, False])


def grid(columns, rows, step=80.0):
    return np.array([(x * step, y * step) for x in range(columns) for y in range(rows)], dtype=np.float64)


def n37():
    """Pixels, y upwards, and N, E of the nine crosses of the sheet N-37-1-A."""
    with N37.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    XY = np.array([(float(row["col_px"]), -float(row["row_px"])) for row in rows])
    return XY, np.array([(float(row["N_m"]), float(row["E_m"])) for row in rows])


def warped(XY, degree, seed=3):
    """A map whose N, E are exact polynomials of X, Y."""
    random = np.random.default_rng(seed)
    uv = (XY - XY.mean(axis=0)) / 250.0
    terms = len(exponents(degree))
    coefficients = random.normal(0.0, 3e3, (terms, 2))
    coefficients[1:3] += np.array([[0.0, 2.5e5], [2.5e5, 0.0]])
    return design(uv[:, 0], uv[:, 1], degree) @ coefficients + np.array([4.7e6, 5.5e5])


class TestPublishedSheet:
    """Numbers of `expected.csv` of the data collection: independent adjustments of the same crosses."""

    def test_affine_of_seven_crosses(self):
        XY, target = n37()
        fit = fit_sheet(Crosses(XY, target, np.ones_like(target)), Rule(1), SEVEN)
        (c, a), (d, b) = fit.coefficients[1:] / fit.scale_mm
        assert [a, b, c, d] == pytest.approx([4.2073957, 0.15554167, -0.17349979, 4.18537518], abs=5.1e-8)
        # crosses.csv gives E, N to 0.1 mm
        assert predict(fit, np.zeros((1, 2))).values[0] == pytest.approx([6213023.49002, 7312587.74525], abs=2e-4)
        rms = np.sqrt(np.mean(fit.residuals_m[SEVEN] ** 2, axis=0))
        assert rms == pytest.approx([10.326, 4.100], abs=5e-4)
        assert fit.residuals_m[8] == pytest.approx([14.0, -122.9], abs=0.05)
        assert fit.residuals_m[5] == pytest.approx([11.9, -24.0], abs=0.05)
        assert np.isnan(fit.redundancy_numbers[8]) and fit.shift.probability[8] is None

    def test_sigma_of_nine_crosses(self):
        XY, target = n37()
        linear, square = (fit_sheet(Crosses(XY, target, np.ones_like(target)), Rule(degree)) for degree in (1, 2))
        assert np.sqrt(np.mean(linear.sigma0_m**2)) == pytest.approx(32.632, abs=5e-4)
        assert np.sqrt(np.mean(square.sigma0_m**2)) == pytest.approx(33.377, abs=5e-4)
        assert linear.residuals_m[8, 1] == pytest.approx(-90.10, abs=5e-3)

    @pytest.mark.parametrize("degree", [1, None])
    def test_the_bad_cross_is_named_and_no_other(self, degree):
        XY, target = n37()
        found, fit = suspects(Crosses(XY, target, np.ones_like(target)), Rule(degree))
        assert [suspect.index for suspect in found] == [8]
        assert found[0].statistic == pytest.approx(41.3487, abs=1e-3)
        assert found[0].corrected_probability < 2e-4
        assert (fit.degree, fit.redundancy, fit.is_fit.sum()) == (1, 5, 8)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_an_exact_polynomial_is_found_at_every_place(degree):
    XY = grid(7, 7)
    target = warped(XY, degree)
    fit = fit_sheet(Crosses(XY, target, np.ones_like(target)), Rule(degree))
    assert fit.residuals_m == pytest.approx(np.zeros_like(target), abs=1e-7)
    assert fit.redundancy_numbers.sum() == pytest.approx(fit.redundancy)
    inner = XY[:-1] + np.array([31.0, 17.0])
    both = np.vstack([XY, inner])
    uv = (both - XY.mean(axis=0)) / 250.0
    coefficients = np.linalg.lstsq(design(*(uv[:49].T), degree), target, rcond=None)[0]
    assert predict(fit, inner).values == pytest.approx(design(*(uv[49:].T), degree) @ coefficients, abs=1e-6)


def test_the_gradient_is_that_of_the_values():
    XY = grid(6, 6)
    target = warped(XY, 3)
    fit = fit_sheet(Crosses(XY, target, np.ones_like(target)), Rule(3))
    place, step = np.array([[123.0, 210.0], [300.0, 88.0]]), 1e-3
    for axis in (0, 1):
        move = np.eye(2)[axis] * step
        slope = (predict(fit, place + move).values - predict(fit, place - move).values) / (2.0 * step)
        assert predict(fit, place).gradient[:, :, axis] == pytest.approx(slope, rel=1e-8, abs=1e-5)


def test_degrees_and_metres_of_a_graticule():
    """B, L of a graticule: residuals and sigma0 in metres are those in degrees times M and N cos B."""
    ellipsoid = named_ellipsoid("krasovsky")
    XY = grid(7, 5) + np.random.default_rng(2).normal(0.0, 0.05, (35, 2))
    B, L = 40.0 + grid(7, 5)[:, 1] / 80.0, 18.0 + grid(7, 5)[:, 0] / 80.0
    north = meridian_radius(ellipsoid, np.deg2rad(B)) * np.pi / 180.0
    east = prime_vertical_radius(ellipsoid, np.deg2rad(B)) * np.cos(np.deg2rad(B)) * np.pi / 180.0
    fit = fit_sheet(Crosses(XY, np.column_stack([B, L]), np.column_stack([north, east])), Rule(1))
    degrees = predict(fit, XY).values - np.column_stack([B, L])
    assert fit.residuals_m == pytest.approx(degrees * np.column_stack([north, east]), abs=1e-6)
    assert fit.sigma0_m[0] == pytest.approx(np.sqrt(np.sum((degrees[:, 0] * north) ** 2) / 32))
    assert fit.sigma0 == pytest.approx(np.sqrt(np.sum(degrees**2, axis=0) / 32))


def test_the_sigma_of_a_point_is_its_spread():
    """f'Qf sigma0^2 is the variance of the polynomial at a point, over many digitised sheets."""
    random = np.random.default_rng(11)
    XY, place = grid(5, 4), np.array([[60.0, 50.0], [310.0, 230.0]])
    target = XY[:, ::-1] * 1000.0
    values, cofactors = [], predict(fit_sheet(Crosses(XY, target, np.ones_like(target)), Rule(2)), place).cofactor
    for _ in range(2000):
        noisy = target + random.normal(0.0, 50.0, target.shape)
        values.append(predict(fit_sheet(Crosses(XY, noisy, np.ones_like(target)), Rule(2)), place).values)
    spread = np.std(values, axis=0)
    assert spread == pytest.approx(50.0 * np.sqrt(cofactors)[:, None] * np.ones((1, 2)), rel=0.06)


class TestDegree:
    @pytest.mark.parametrize("degree", [1, 2, 3, 4])
    def test_the_degree_that_is_needed(self, degree):
        XY = grid(7, 7)
        target = warped(XY, degree)
        noise = np.random.default_rng(8).normal(0.0, 20.0, target.shape)
        fit = fit_sheet(Crosses(XY, target + noise, np.ones_like(target)))
        assert (fit.degree, fit.degree_chosen_by) == (degree, "f-test")

    def test_a_useless_degree_is_taken_in_about_one_of_twenty_sheets(self):
        random, XY = np.random.default_rng(21), grid(5, 5)
        target = XY * 1000.0
        higher = sum(
            fit_sheet(Crosses(XY, target + random.normal(0.0, 40.0, XY.shape), np.ones_like(XY))).degree > 1
            for _ in range(400)
        )
        # two looks at 5 %
        assert 15 <= higher <= 65

    @pytest.mark.parametrize(("n", "highest"), [(4, 1), (5, 1), (7, 1), (8, 2), (9, 2), (12, 3)])
    def test_a_redundancy_of_two_is_left(self, n, highest):
        XY = np.random.default_rng(5).uniform(0.0, 400.0, (n, 2))
        target = warped(XY, 3)
        assert fit_sheet(Crosses(XY, target, np.ones_like(target))).degree <= highest

    def test_a_given_degree_may_use_every_cross(self):
        XY = grid(3, 1) + np.array([[0.0, 0.0], [0.0, 50.0], [0.0, 0.0]])
        fit = fit_sheet(Crosses(XY, XY * 1000.0, np.ones_like(XY)), Rule(1))
        assert (fit.redundancy, fit.sigma0, fit.sigma0_m) == (0, None, None)
        assert fit.shift.probability == (None, None, None)


class TestSuspects:
    def test_two_bad_crosses_are_named_the_worse_first(self):
        XY = grid(7, 5)
        readings = XY + np.random.default_rng(4).normal(0.0, 0.05, XY.shape)
        readings[17] += [1.2, -0.9]
        readings[30] += [0.0, 0.8]
        found, fit = suspects(Crosses(readings, XY[:, ::-1] * 1000.0, np.ones_like(XY)), Rule(1))
        assert [suspect.index for suspect in found] == [17, 30]
        assert fit.is_fit.sum() == 33
        assert np.max(fit.sigma0_m) < 80.0

    def test_clean_sheets_lose_a_cross_in_one_of_a_hundred(self):
        random, XY = np.random.default_rng(14), grid(3, 3)
        target = XY * 1000.0
        alarms = sum(
            bool(suspects(Crosses(XY + random.normal(0.0, 0.08, XY.shape), target, np.ones_like(XY)), Rule(1))[0])
            for _ in range(500)
        )
        assert alarms <= 14

    def test_exact_crosses_with_one_error(self):
        """No spread at all, to the last digit: the bad cross is still the only one."""
        XY = grid(4, 4)
        readings = XY.copy()
        readings[5] += [0.4, 0.0]
        found, _ = suspects(Crosses(readings, XY * 1000.0 + 6e6, np.ones_like(XY)), Rule(1))
        assert [suspect.index for suspect in found] == [5]

    def test_exact_crosses_without_error(self):
        XY = grid(4, 4)
        assert suspects(Crosses(XY, XY * 1000.0 + 6e6, np.ones_like(XY)), Rule(1))[0] == ()

    def test_check_crosses_are_never_suspects(self):
        XY, target = n37()
        assert suspects(Crosses(XY, target, np.ones_like(target)), Rule(1), SEVEN)[0] == ()


REFUSED = [
    ("too few for the test", grid(3, 1) + np.array([[0, 0], [0, 9], [0, 0]]), None, "3 crosses; 4 are needed"),
    ("too few for a degree", grid(3, 3), 3, "9 crosses; degree 3 needs 10"),
    ("degree 0", grid(3, 3), 0, "degree 0 is not in 1 ... 5"),
    ("degree 6", grid(7, 7), 6, "degree 6 is not in 1 ... 5"),
    ("a line", grid(6, 1), 1, "lie on one line"),
    ("a slanted line read to 0.05 mm", None, 1, "lie on one line"),
    ("two parallels", grid(5, 2), 2, "lie on one curve of degree 2"),
    ("five rows", grid(7, 5), 5, "lie on one curve of degree 5"),
    ("the same place", np.vstack([grid(3, 3), [[80.0, 80.0]]]), 1, "crosses 5 and 10 have the same X, Y"),
]


@pytest.mark.parametrize(("XY", "degree", "message"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED])
def test_refusals_name_the_sheet_and_the_numbers(XY, degree, message):
    if XY is None:
        along = np.linspace(0.0, 400.0, 9)[:, None] * np.array([[0.8, 0.6]])
        XY = along + np.random.default_rng(1).normal(0.0, 0.05, along.shape)
    with pytest.raises(GeometryError, match=message) as refused:
        fit_sheet(Crosses(XY, XY * 1000.0, np.ones_like(XY), sheet="K-34"), Rule(degree))
    assert refused.value.message.startswith("sheet K-34: ")


def test_arguments_are_not_written_to():
    XY, target = n37()
    factors, used = np.ones_like(target), SEVEN.copy()
    copies = [array.copy() for array in (XY, target, factors, used)]
    suspects(Crosses(XY, target, factors), Rule(1), used)
    for array, copy in zip((XY, target, factors, used), copies, strict=True):
        assert np.array_equal(array, copy)
