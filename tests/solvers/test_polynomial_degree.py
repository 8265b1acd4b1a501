"""The degree of a sheet: prediction errors against n separate adjustments, the table of model errors, two choices."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pyproj import Proj

from orient.geodesy.ellipsoid import named_ellipsoid
from orient.solvers.engines import Engine
from orient.solvers.polynomial_degree import (
    LEAVE_ONE_OUT,
    Crosses,
    Rule,
    adjusted_in_metres,
    choose_degree,
    degree_choices,
    prediction_errors,
)
from orient.solvers.polynomial_fit import fit_sheet, predict
from tests.solvers.test_polynomial_fit import grid, warped

METRES_PER_DEGREE = 111_200.0
"""The table of EQUATIONS 4.4 counts so many, times cos of the sheet's middle latitude for L."""
TABLE = [
    # projection, height and width [deg], middle latitude, max error B/L [m] of degree 1 ... 5 (EQUATIONS 4.4)
    ("gauss-krueger", 2, 2, 42.5, "289/1322 9.8/18 0.1/0.2 0/0 0/0"),
    ("gauss-krueger", 2, 2, 60.0, "256/1704 9.9/34 0.2/0.6 0/0 0/0"),
    ("gauss-krueger", 4, 6, 42.5, "2574/8033 178/210 2.9/7.1 0.1/0.3 0/0"),
    ("gauss-krueger", 4, 6, 60.0, "2332/10380 176/401 6.2/15.8 0.2/0.8 0/0"),
    ("lambert", 2, 2, 42.5, "292/1316 5.9/11 0/0.1 0/0 0/0"),
    ("lambert", 4, 6, 42.5, "2666/7955 92/131 0.6/3.5 0/0.1 0/0"),
    ("lambert", 4, 6, 60.0, "2372/10323 144/343 3.9/12.3 0.1/0.5 0/0"),
]
IDS = [f"{row[0]} {row[1]}x{row[2]} at {row[3]}" for row in TABLE]


def projected(projection, height, middle, B, L):
    """E, N [m] on the Krasovsky ellipsoid; the standard parallels of the cone lie a sixth inside the sheet."""
    if projection == "gauss-krueger":
        return np.column_stack(Proj(proj="tmerc", lon_0=0, ellps="krass")(L, B))
    parallels = {"lat_1": middle - height / 3, "lat_2": middle + height / 3, "lat_0": middle}
    return np.column_stack(Proj(proj="lcc", lon_0=0, ellps="krass", **parallels)(L, B))


def graticule(height, width, middle, n):
    B = middle + np.linspace(-height / 2, height / 2, n)
    L = np.linspace(-width / 2, width / 2, n)
    return np.array([(b, l) for b in B for l in L])


def metres(BL, middle):
    return np.tile([METRES_PER_DEGREE, METRES_PER_DEGREE * np.cos(np.radians(middle))], (len(BL), 1))


def sheet(row, n, scale=1e6):
    """Digitiser X, Y [mm] and B, L [deg] of n x n crosses."""
    projection, height, width, middle, _ = row
    BL = graticule(height, width, middle, n)
    return projected(projection, height, middle, *BL.T) * 1000.0 / scale, BL


def half_a_digit(printed):
    """Half a unit of the last printed digit, and a hair for what was rounded on the edge."""
    return (0.05 if "." in printed or printed == "0" else 0.5) * 1.1


@pytest.mark.parametrize("row", TABLE, ids=IDS)
def test_the_table_of_model_errors(row):
    """Nine by nine crosses without error; the polynomial compared with the projection all over the sheet."""
    XY, BL = sheet(row, 9)
    XY_all, BL_all = sheet(row, 41)
    for degree, printed in enumerate(row[4].split(), start=1):
        fit = fit_sheet(Crosses(XY, BL, metres(BL, row[3])), Rule(degree))
        errors = np.max(np.abs(predict(fit, XY_all).values - BL_all) * metres(BL_all, row[3]), axis=0)
        for error, value in zip(errors, printed.split("/"), strict=True):
            assert error == pytest.approx(float(value), abs=half_a_digit(value))


class TestChoiceOnMaps:
    """Sheets of 7 x 7 crosses at 1:1 000 000, read with 0.1 mm: 100 m on the ground."""

    @staticmethod
    def choices(row, seed):
        XY, BL = sheet(row, 7)
        XY = XY + np.random.default_rng(seed).normal(0.0, 0.1, XY.shape)
        return degree_choices(Crosses(XY, BL, metres(BL, row[3])))

    @pytest.mark.parametrize("row", [row for row in TABLE if row[1] == 4], ids=[i for i in IDS if "4x6" in i])
    def test_sheets_of_four_by_six_degrees_need_degree_3_or_4(self, row):
        found = [self.choices(row, seed) for seed in range(5)]
        assert {choices.f_test for choices in found} <= {3, 4}
        assert {choices.leave_one_out for choices in found} <= {3, 4}

    @pytest.mark.parametrize("row", [row for row in TABLE if row[1] == 2], ids=[i for i in IDS if "2x2" in i])
    def test_the_quadratic_of_the_paper_is_enough_for_two_by_two_degrees(self, row):
        found = [self.choices(row, seed) for seed in range(5)]
        assert {choices.f_test for choices in found} == {2}
        assert {choices.leave_one_out for choices in found} == {2}


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31), st.integers(1, 3), st.integers(14, 30))
def test_prediction_errors_are_those_of_n_adjustments(seed, degree, n):
    """e_i/(1 - h_i) = polynomial of the n - 1 other crosses, at cross i, minus given."""
    random = np.random.default_rng(seed)
    XY = random.uniform(0.0, 400.0, (n, 2))
    target = XY * 1000.0 + random.normal(0.0, 50.0, XY.shape)
    found = prediction_errors(adjusted_in_metres(Crosses(XY, target, np.ones_like(XY)), degree, Engine.ZLATANOV))
    for i in range(n):
        others = np.arange(n) != i
        fit = fit_sheet(Crosses(XY[others], target[others], np.ones((n - 1, 2))), Rule(degree))
        assert found[i] == pytest.approx(
            (predict(fit, XY[i : i + 1]).values - target[i : i + 1])[0], rel=1e-5, abs=1e-3
        )


def test_a_cross_that_stands_alone_cannot_be_predicted():
    """Four crosses, three of them on a line: the fourth alone carries the slope across."""
    XY = np.array([[0.0, 0.0], [100.0, 0.0], [200.0, 0.0], [100.0, 100.0]])
    crosses = Crosses(XY, XY * 1000.0, np.ones_like(XY))
    assert prediction_errors(adjusted_in_metres(crosses, 1, Engine.ZLATANOV)) is None
    assert choose_degree(crosses, Rule(choice=LEAVE_ONE_OUT)) == 1


class TestLeaveOneOut:
    @pytest.mark.parametrize("degree", [1, 2, 3, 4])
    def test_the_degree_that_is_needed(self, degree):
        XY = grid(7, 7)
        target = warped(XY, degree)
        noise = np.random.default_rng(8).normal(0.0, 20.0, target.shape)
        fit = fit_sheet(Crosses(XY, target + noise, np.ones_like(target)), Rule(choice=LEAVE_ONE_OUT))
        assert (fit.degree, fit.degree_chosen_by) == (degree, "leave-one-out")

    def test_without_any_error_the_lowest_exact_degree_is_taken(self):
        """All higher degrees are the same to rounding: the smallest PRESS is chance there, parsimony decides."""
        XY = grid(7, 7)
        target = warped(XY, 2)
        assert choose_degree(Crosses(XY, target, np.ones_like(target)), Rule(choice=LEAVE_ONE_OUT)) == 2

    def test_a_useless_degree_is_taken_in_a_few_sheets_of_a_hundred_at_most(self):
        random, XY = np.random.default_rng(21), grid(5, 5)
        target = XY * 1000.0
        higher = sum(
            choose_degree(
                Crosses(XY, target + random.normal(0.0, 40.0, XY.shape), np.ones_like(XY)), Rule(choice=LEAVE_ONE_OUT)
            )
            > 1
            for _ in range(300)
        )
        assert higher <= 9

    def test_the_rms_tells_what_a_new_point_would_have(self):
        """Crosses of 30 m: a new point of the right degree is predicted to a little more than that, in each axis."""
        random, XY = np.random.default_rng(3), grid(7, 7)
        target = warped(XY, 2) + random.normal(0.0, 30.0, XY.shape)
        rms = degree_choices(Crosses(XY, target, np.ones_like(target))).prediction_m
        assert list(rms) == [1, 2, 3, 4, 5]
        assert 30.0 < rms[2] / np.sqrt(2.0) < 36.0
        assert rms[1] > rms[2]

    def test_order_and_place_of_the_crosses_do_not_matter(self):
        random, XY = np.random.default_rng(4), grid(5, 5)
        target = warped(XY, 3) + random.normal(0.0, 500.0, XY.shape)
        order = random.permutation(len(XY))
        turned = XY[order] @ np.array([[0.6, 0.8], [-0.8, 0.6]]) + [1000.0, -77.0]
        first = degree_choices(Crosses(XY, target, np.ones_like(target))).prediction_m
        second = degree_choices(Crosses(turned, target[order], np.ones_like(target))).prediction_m
        assert second == pytest.approx(first, rel=1e-6)


def test_the_table_counts_metres_as_the_ellipsoid_does_to_two_per_mille():
    krasovsky = named_ellipsoid("krasovsky")
    assert pytest.approx(np.radians(krasovsky.a_m), rel=2e-3) == METRES_PER_DEGREE
