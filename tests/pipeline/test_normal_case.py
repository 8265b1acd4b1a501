"""Stage `covariance` on a simulated photo of the normal case: the printed digits of seed 003, and its conditions."""

from collections.abc import Mapping

import numpy as np
import pytest

from orient.geometry.collinearity import project
from orient.geometry.rotation import matrix_from_aok
from orient.geometry.vertical_photo import design, element_units, grid_layout
from orient.pipeline import covariance
from orient.solvers import mishchenko
from orient.solvers.packed import unpack_upper
from orient.values import Row, Scalar, Tables
from tests.pipeline.made import Array, Place, framed, geographic_rows, image_rows, local, oriented, settings

C_MM, H_M, SIGMA_MM = 90.0, 250e3, 0.007
GRID = grid_layout(2 * C_MM, 2 * C_MM, 3, 3)
RECTANGLE = GRID * [1.0, 0.5]
ASYMMETRIC = C_MM * np.array([[-1.0, -0.8], [0.9, -1.0], [0.2, 0.1], [-0.7, 0.6], [1.0, 0.9], [0.4, -0.3]])
NEW = C_MM * np.array([[0.5, 0.25]])
STATION = np.array([0.0, 0.0, H_M])


def tables(
    layout: Array = GRID,
    f_mm: float = 200.0,
    tilt: float = 0.0,
    relief: Array | None = None,
    sigma_m: float | None = None,
    cycles: int = 1,
    kappa: float = 0.3,
) -> Tables:
    """What `covariance` stores of an exact photo of local ground with one check point; sigma0 a priori scales.

    `cycles`: readings in the mean of the first point.
    """
    flat = np.column_stack([np.vstack([layout, NEW]) * H_M / f_mm, np.zeros(len(layout) + 1)])
    if relief is not None:
        flat[: len(layout), 2] = relief
    rotation = matrix_from_aok(tilt, 0.0, kappa)
    image, zs = project(flat @ matrix_from_aok(0.0, 0.0, kappa).T, STATION, rotation, f_mm)
    assert np.all(zs < 0)
    facts = local(
        "right", f_mm=f_mm, sigma_image_mm=SIGMA_MM, frame_width_mm=2 * C_MM, frame_height_mm=2 * C_MM
    )  # fmt: skip
    names = [*(f"P{i + 1}" for i in range(len(layout))), "new"]
    error = None if sigma_m is None else np.eye(3) * sigma_m**2
    ground = [
        Place(name, tuple(xyz), tuple(xyz), "check" if name == "new" else "control", error)  # type: ignore[arg-type]
        for name, xyz in zip(names, (flat @ matrix_from_aok(0.0, 0.0, kappa).T).tolist(), strict=True)
    ]
    measured = [dict(row) for row in image_rows(names, image, SIGMA_MM)]
    for part in ("cov_xx_mm2", "cov_yy_mm2"):
        measured[0][part] = SIGMA_MM**2 / cycles
    inputs = {
        "photo": facts,
        "refine": {"image_point": measured},
        "topocentric": framed(facts, geographic_rows(ground, is_local=True)),
    }
    found = {**inputs, "resection": oriented(inputs, variance="priori").tables}
    return covariance.compute(found, settings("covariance", map_side=3)).tables


def failed(rows: Tables, needed_for: str) -> list[str]:
    conditions = rows["closed_form_condition"]
    return [str(row["condition"]) for row in conditions if row["needed_for"] == needed_for and not row["is_met"]]


def column(rows: Tables, table: str, name: str) -> Array:
    return np.array([row[name] for row in rows[table]], dtype=np.float64)


def of(rows: Tables, table: str, **where: Scalar) -> Row:
    (row,) = (row for row in rows[table] if all(row[key] == value for key, value in where.items()))
    return row


@pytest.mark.parametrize("f_mm", [72.0, 90.0, 200.0, 603.0])
def test_K_of_the_seed_to_all_printed_digits(f_mm: float) -> None:
    """EQUATIONS 3.2: K_XX = .168692129630 at (.5, .25) for every f/c, by the seed, by the adjustment, on the ground."""
    rows = tables(f_mm=f_mm)
    found = of(rows, "focal_sum", point="new", axis="x")
    assert f"{found['layout_sum']:.12f}" == "0.168692129630"
    assert found["rigorous"] == pytest.approx(0.168692129630, rel=1e-8)
    assert abs(column(rows, "focal_sum", "focal_sum")).max() < 1e-12 * column(rows, "focal_sum", "focal_largest").max()
    in_image = of(rows, "ground_covariance_image", point="new")
    assert in_image["K_xx_mm2"] == pytest.approx(SIGMA_MM**2 * 0.168692129630, rel=1e-8)
    on_ground = of(rows, "ground_covariance", point="new")
    trace = float(on_ground["K_XX_m2"]) + float(on_ground["K_YY_m2"])  # type: ignore[arg-type]
    K = of(rows, "focal_sum", point="new", axis="y")["layout_sum"] + found["layout_sum"]  # type: ignore[operator]
    assert trace == pytest.approx((SIGMA_MM * H_M / f_mm) ** 2 * K, rel=1e-8)


def test_cofactors_are_the_closed_form_and_the_printed_sigmas() -> None:
    """EQUATIONS 3: f = 200, c = 90 mm, H = 250 km, 7 um: 20.233133, 5.613128 m, 7.056143e-5, 2.245251e-5 rad."""
    rows = tables()
    assert failed(rows, "normal case") == failed(rows, "separation") == failed(rows, "one D") == []
    parts = [unpack_upper(column(rows, "focal_cofactor", name)) for name in ("by_focal_length", "by_layout")]
    closed = unpack_upper(column(rows, "focal_cofactor", "closed_form"))
    np.testing.assert_allclose(sum(parts), closed, atol=1e-9 * np.max(closed))
    sigmas = SIGMA_MM * element_units(200.0, C_MM, H_M) * np.sqrt(np.diag(closed))
    shown = [f"{value:.6f}" for value in sigmas[:3]] + [f"{value:.6e}" for value in sigmas[3:]]
    assert shown == ["20.233133", "20.233133", "5.613128", "7.056143e-05", "7.056143e-05", "2.245251e-05"]


@pytest.mark.parametrize("f_to_c", [1.0, 2.2, 6.7])
def test_the_use_of_less_than_Q_is_that_of_the_seed(f_to_c: float) -> None:
    """EQUATIONS 3.2 (c): the factors of all points by A_z alone; the digits of one point are in test_mishchenko."""
    uses = {str(row["elements"]): row for row in tables(f_mm=f_to_c * C_MM, kappa=0.0)["element_use"]}
    points, g = GRID / C_MM, f_to_c**2
    groups = {"position only": (0, 1, 2), "angles only": (3, 4, 5), "all but kappa": (0, 1, 2, 3, 4)}
    factor = np.linalg.cholesky(mishchenko.cofactors(points, g))
    full, diagonal, alone = mishchenko.variance_of_uses(design(np.vstack([points, NEW / C_MM]), g), factor, groups)
    expected = {"standard deviations only": diagonal, **alone}
    assert uses["six elements"]["factor"] == 1.0
    for use, variance in expected.items():
        assert uses[use]["factor"] == pytest.approx(np.sqrt(np.sum(variance) / np.sum(full)), rel=1e-6), use
        assert uses[use]["factor_most"] == pytest.approx(np.sqrt(np.max(variance / full)), rel=1e-6), use


def test_a_rectangle_needs_two_determinants() -> None:
    rows = tables(RECTANGLE)
    assert failed(rows, "normal case") == failed(rows, "separation") == []
    assert failed(rows, "one D") == ["sum xi^2 - sum eta^2", "sum xi^4 - sum eta^4"]
    Q = column(rows, "focal_cofactor", "by_focal_length") + column(rows, "focal_cofactor", "by_layout")
    np.testing.assert_allclose(column(rows, "focal_cofactor", "closed_form"), Q, atol=1e-9 * np.max(Q))
    assert f"{of(rows, 'focal_sum', point='new', axis='x')['layout_sum']:.12f}" == "0.224537037037"


@pytest.mark.parametrize("f_mm", [90.0, 603.0])
def test_the_invariance_needs_no_symmetry(f_mm: float) -> None:
    """EQUATIONS 3.2 in its stronger form: no closed form of six odd points, and yet K does not know f/c."""
    rows = tables(ASYMMETRIC, f_mm=f_mm)
    assert "sum xi" in failed(rows, "separation")
    assert column(rows, "focal_cofactor", "closed_form").dtype == np.float64
    assert np.isnan(column(rows, "focal_cofactor", "closed_form")).all()
    reference = tables(ASYMMETRIC, f_mm=200.0)
    for name in ("layout_sum", "rigorous"):
        np.testing.assert_allclose(column(rows, "focal_sum", name), column(reference, "focal_sum", name), rtol=1e-7)


ODD: Mapping[str, tuple[dict[str, object], str]] = {
    "tilted": ({"tilt": np.radians(5.0)}, "camera axis vertical"),
    "relief": ({"relief": 0.1 * H_M * np.array([0.0, 1, 0, -1, 0, 1, 0, -1, 0])}, "ground flat"),
    "weighted control": ({"sigma_m": 20.0}, "control without errors"),
    "unequal readings": ({"cycles": 4}, "readings of equal weight"),
}


@pytest.mark.parametrize(("given", "named"), ODD.values(), ids=ODD)
def test_no_number_outside_the_normal_case(given: dict[str, object], named: str) -> None:
    rows = tables(**given)  # type: ignore[arg-type]
    assert any(condition.startswith(named) for condition in failed(rows, "normal case"))
    assert "focal_cofactor" not in rows
    assert "focal_sum" not in rows


def test_a_small_tilt_is_told_with_its_effect() -> None:
    """Two degrees: still near-vertical; how far the formulas are from the adjustment stands in the condition."""
    rows = tables(tilt=np.radians(2.0))
    agreement = next(row for row in rows["closed_form_condition"] if str(row["condition"]).startswith("sigmas by (3)"))
    apart = np.sqrt(column(rows, "focal_sum", "layout_sum") / column(rows, "focal_sum", "rigorous")) - 1
    assert agreement["value"] == pytest.approx(np.max(np.abs(apart)))
    assert 1e-4 < float(agreement["value"]) < 0.05  # type: ignore[arg-type]
