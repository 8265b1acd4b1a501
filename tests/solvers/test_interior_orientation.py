"""Interior orientation: the Calgary camera, exact scenes, sigmas by simulation, refusals."""

import csv
import tomllib
from pathlib import Path

import numpy as np
import pytest

from orient.errors import GeometryError
from orient.geometry import plane
from orient.solvers.interior_orientation import fit_interior

SAMPLES = Path(__file__).parents[2] / "sample_projects"
MARKS = np.array([(-106, -106), (106, 106), (-106, 106), (106, -106), (-112, 0), (112, 0), (0, 112), (0, -112)], float)
EXACT = {
    "similarity": np.array([210.0, 190.0, 0.9998, 0.02]),
    "affine": np.array([210.0, 1.001, -0.02, 190.0, 0.021, 0.9985]),
    "projective": np.array([210.0, 1.001, -0.02, 190.0, 0.021, 0.9985, 2e-5, -1e-5]),
}


def readings_of(photo):
    """Readings of a Calgary photo [mm] and the calibrated marks."""
    folder = SAMPLES / f"calgary-{photo}"
    with (folder / "readings.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    marks = tomllib.loads((folder / "photo.toml").read_text(encoding="utf-8"))["fiducials"]["marks"]
    places = {row["point"]: (0.0119 * float(row["col_px"]), -0.0119 * float(row["row_px"])) for row in rows}
    return places, marks


# expected.csv and refined_expected.csv of the data collection: independent computation; sigma0, point, x, y [mm]
CALGARY = [
    ("27", 0.0047419, "200", 18.18253, 109.53842),
    ("27", 0.0047419, "105", 90.28494, -91.03487),
    ("28", 0.0051069, "200", -77.83450, 113.41168),
    ("28", 0.0051069, "203", -38.91781, -90.03598),
]


@pytest.mark.parametrize(("photo", "sigma0", "point", "x", "y"), CALGARY)
def test_the_calgary_camera(photo, sigma0, point, x, y):
    places, marks = readings_of(photo)
    fit = fit_interior(np.array([places[mark] for mark in marks]), np.array(list(marks.values())), "affine")
    assert fit.sigma0 == pytest.approx(sigma0, abs=5.1e-8)
    assert (fit.redundancy, fit.is_mirrored) == (10, False)
    transformed = plane.apply("affine", fit.parameters, np.array([places[point]]))[0]
    assert transformed == pytest.approx([x, y], abs=1e-5)


@pytest.mark.parametrize("name", EXACT)
def test_an_exact_transformation_is_found(name):
    measured = MARKS + np.array([214.0, 188.0])
    calibrated = plane.apply(name, EXACT[name], measured)
    fit = fit_interior(measured, calibrated, name)
    assert fit.names == tuple(plane.parameter_names(name))
    assert fit.parameters == pytest.approx(EXACT[name], rel=1e-9, abs=1e-11)
    assert fit.residuals == pytest.approx(np.zeros_like(MARKS), abs=1e-10)


@pytest.mark.parametrize("name", EXACT)
def test_residuals_are_transformed_minus_calibrated_and_least(name):
    random = np.random.default_rng(6)
    calibrated = plane.apply(name, EXACT[name], MARKS) + random.normal(0.0, 0.004, MARKS.shape)
    fit = fit_interior(MARKS, calibrated, name)
    assert fit.residuals == pytest.approx(plane.apply(name, fit.parameters, MARKS) - calibrated, abs=1e-10)
    A = plane.partials(name, fit.parameters, MARKS).reshape(16, -1)
    A = A / np.linalg.norm(A, axis=0)
    assert A.T @ fit.residuals.ravel() == pytest.approx(np.zeros(A.shape[1]), abs=1e-9)
    assert fit.redundancy == 16 - A.shape[1]


@pytest.mark.parametrize("name", EXACT)
def test_sigmas_agree_with_simulation(name):
    """The cofactors hold for X far from the origin too, where a0 and a1 correlate strongly."""
    random, measured = np.random.default_rng(9), MARKS + np.array([214.0, 188.0])
    exact = plane.apply(name, EXACT[name], measured)
    drawn = [
        fit_interior(measured, exact + random.normal(0.0, 0.004, exact.shape), name).parameters for _ in range(800)
    ]
    Q = fit_interior(measured, exact + random.normal(0.0, 0.004, exact.shape), name).cofactor
    assert np.std(drawn, axis=0) == pytest.approx(0.004 * np.sqrt(np.diag(Q)), rel=0.11)


@pytest.mark.parametrize(("name", "n"), [("similarity", 2), ("affine", 3), ("projective", 4)])
def test_the_least_number_of_marks_leaves_no_sigma(name, n):
    fit = fit_interior(MARKS[:n], plane.apply(name, EXACT[name], MARKS[:n]), name)
    assert (fit.redundancy, fit.sigma0, fit.sigmas) == (0, None, None)
    assert fit.parameters == pytest.approx(EXACT[name], rel=1e-8, abs=1e-10)


def test_a_photo_measured_from_its_back():
    fit = fit_interior(MARKS * np.array([-1.0, 1.0]), MARKS, "affine")
    assert fit.is_mirrored
    assert fit.sigma0 == pytest.approx(0.0, abs=1e-12)


OBLIQUE = np.array([(-100.0, -90.0), (95.0, 100.0), (-80.0, 105.0), (110.0, -100.0)])
LINE = np.array([(-100.0, -50.0), (-20.0, -10.0), (40.0, 20.0), (80.0, 40.0), (100.0, 50.0)])
REFUSED = [
    ("one mark", MARKS[:1], MARKS[:1], "similarity", "1 fiducial mark is measured; similarity needs 2"),
    ("two marks", MARKS[:2], MARKS[:2], "affine", "2 fiducial marks are measured; affine needs 3"),
    ("three marks", MARKS[:3], MARKS[:3], "projective", "3 fiducial marks are measured; projective needs 4"),
    ("a line", LINE, LINE, "affine", "lie on one line"),
    ("three of four on a line", np.vstack([LINE[:3], MARKS[:1]]), np.vstack([LINE[:3], MARKS[:1]]), "projective",
     "a, b, c, d do not determine c2 of a projective"),
    ("one place twice", MARKS[[0, 1, 2, 0]], MARKS[[0, 1, 2, 3]], "affine", "a and d have the same measured place"),
    ("one certificate line twice", MARKS[:4], MARKS[[0, 1, 1, 3]], "affine", "b and c have the same calibrated"),
    ("exchanged marks", OBLIQUE, OBLIQUE[[0, 2, 1, 3]], "projective", "horizon"),
    ("unknown name", MARKS, MARKS, "bilinear", "unknown transformation bilinear"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("measured", "calibrated", "name", "message"), [row[1:] for row in REFUSED], ids=[row[0] for row in REFUSED]
)
def test_refusals(measured, calibrated, name, message):
    with pytest.raises(GeometryError, match=message):
        fit_interior(measured, calibrated, name, marks="abcdefgh"[: len(measured)])


def test_a_line_is_enough_for_a_similarity():
    fit = fit_interior(LINE, plane.apply("similarity", EXACT["similarity"], LINE), "similarity")
    assert fit.parameters == pytest.approx(EXACT["similarity"], abs=1e-10)
