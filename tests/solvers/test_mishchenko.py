"""Seed 003: the numbers of EQUATIONS 3 - 3.2, the decomposition, the symmetry test, the invariance in f/c."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orient.errors import GeometryError
from orient.geometry.collinearity import partials_aok
from orient.geometry.vertical_photo import (
    SCALED_ELEMENTS,
    design,
    design_parts,
    element_units,
    focal_transformation,
    grid_layout,
    gruber_layout,
    normalised,
)
from orient.solvers import mishchenko
from tests.solvers.resection_scenes import FloatArray, generator

GRID = grid_layout(2.0, 2.0, 3, 3)
CORNERS = GRID[[0, 2, 4, 6, 8]]
RECTANGLE = GRID * [1.0, 0.5]
ASYMMETRIC = np.array([[-1.0, -0.8], [0.9, -1.0], [0.2, 0.1], [-0.7, 0.6], [1.0, 0.9], [0.4, -0.3]])
LAYOUTS = {"3x3 grid": GRID, "corners and centre": CORNERS, "rectangle 1:0.5": RECTANGLE, "asymmetric": ASYMMETRIC}
NEW = np.array([[0.5, 0.25]])
RATIOS = (0.8, 1.0, 2.2, 6.7, 20.0)
# EQUATIONS 3 prints 20.233313 for X_S and Y_S, two digits exchanged: 8.75 sqrt((9 g^2 + 12 g + 10) / 54) with
# g = 400/81 is 20.2331333; the other four are as printed
SIGMAS = {
    "X_S": "20.233133",
    "Y_S": "20.233133",
    "Z_S": "5.613128",
    "alpha": "7.056143e-05",
    "omega": "7.056143e-05",
    "kappa": "2.245251e-05",
}


def by_definition(points: FloatArray, g: float) -> FloatArray:
    """(A_z'A_z)^-1 without any shortcut."""
    A = design(points, g).reshape(-1, 6)
    return np.asarray(np.linalg.inv(A.T @ A))


def direct_covariance(points: FloatArray, new: FloatArray, g: float) -> FloatArray:
    """C_z Q_z C_z' (2m, 2m) as the seed prints it."""
    C = design(new, g).reshape(-1, 6)
    return np.asarray(C @ by_definition(points, g) @ C.T)


def test_design_is_minus_the_collinearity_partials_with_scaled_columns() -> None:
    """(5): the columns of d(x, y)/d(X_S, Y_S, Z_S, alpha, omega, kappa), per unit of c and of the scaled unknowns."""
    f, c, H = 200.0, 90.0, 250e3
    random = generator("columns")
    points = random.uniform(-1, 1, (5, 2))
    ground = np.column_stack([points * c * H / f, np.zeros(5)])
    partials = partials_aok(ground, np.array([0.0, 0.0, H]), np.eye(3), f)
    per_unknown = np.array([H * c / f, H * c / f, H, f / c, f / c, 1.0]) / c
    in_order = partials[:, :, [3, 4, 5, 0, 1, 2]] * per_unknown
    np.testing.assert_allclose(design(points, (f / c) ** 2), -in_order, atol=1e-14)


@pytest.mark.parametrize("element", SIGMAS)
def test_check_of_the_seed_grid(element: str) -> None:
    """EQUATIONS 3: f = .2, c = .09, H = 250 km, sigma = 7 um, to all digits."""
    points, c = normalised(90.0 * GRID)
    Q = mishchenko.cofactors(points, (200.0 / c) ** 2)
    found = 7e-3 * element_units(200.0, c, 250e3) * np.sqrt(np.diag(Q))
    place = SCALED_ELEMENTS.index(element)
    assert format(found[place], ".6e" if place >= 3 else ".6f") == SIGMAS[element]


def test_correlation_of_the_seed_grid() -> None:
    Q = mishchenko.cofactors(GRID, (200.0 / 90.0) ** 2)
    assert Q[0, 3] / np.sqrt(Q[0, 0] * Q[3, 3]) == pytest.approx(-0.98956, abs=5e-6)


@pytest.mark.parametrize(
    ("layout", "K_XX"),
    [
        ("3x3 grid", 0.168692129630),
        ("corners and centre", 0.305338541667),
        ("rectangle 1:0.5", 0.224537037037),
    ],
)
def test_K_of_the_table_is_the_same_for_every_focal_length(layout: str, K_XX: float) -> None:
    """EQUATIONS 3.2, all twelve digits from C(0) Q(0) C(0)'; C Q C' itself cancels to 1e-11 at f/c = 20."""
    points = LAYOUTS[layout]
    assert mishchenko.covariance(points, NEW)[0, 0, 0, 0] == pytest.approx(K_XX, abs=5e-13)
    direct = [direct_covariance(points, NEW, ratio**2)[0, 0] for ratio in RATIOS]
    np.testing.assert_allclose(direct, K_XX, atol=1e-9)


coordinate = st.floats(-1, 1)


@given(st.lists(st.tuples(coordinate, coordinate), min_size=6, max_size=12), st.floats(0.1, 5.0))
def test_invariance_needs_no_symmetry(places: list[tuple[float, float]], ratio: float) -> None:
    """K = C(0) Q(0) C(0)' = C Q C' for any layout that is not weak, and A(g) = A(0) T."""
    points = np.vstack([ASYMMETRIC, np.array(places)])
    g = ratio**2
    K = mishchenko.covariance(points, NEW).reshape(2, 2)
    np.testing.assert_allclose(direct_covariance(points, NEW, g), K, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(design(points, g), design(points, 0.0) @ focal_transformation(g), atol=1e-12)


def test_focal_transformation_is_unimodular() -> None:
    T = focal_transformation(3.7)
    assert np.linalg.det(T) == pytest.approx(1.0)
    np.testing.assert_array_equal(T @ focal_transformation(-3.7), np.eye(6))


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_cofactors_are_the_inverse(layout: str, ratio: float) -> None:
    """(4), up to the digits that the plain inverse keeps."""
    g = ratio**2
    plain = by_definition(LAYOUTS[layout], g)
    np.testing.assert_allclose(mishchenko.cofactors(LAYOUTS[layout], g), plain, atol=1e-12 * np.max(plain) * g)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(
    ("layout", "determinants"), [("3x3 grid", 1), ("corners and centre", 1), ("rectangle 1:0.5", 2)]
)
def test_closed_form_is_the_inverse_where_the_layout_allows_it(layout: str, determinants: int, ratio: float) -> None:
    """(8)-(10) to 1e-15 in units of the largest cofactor; Dx, Dy when only the moments of the axes differ."""
    points, g = LAYOUTS[layout], ratio**2
    assert mishchenko.symmetry(points).determinants == determinants
    closed = mishchenko.closed_form(points, g, 1 if determinants == 1 else 2)
    Q = mishchenko.cofactors(points, g)
    np.testing.assert_allclose(closed.Q, Q, atol=1e-14 * np.max(Q))
    general = mishchenko.decomposition(points, g)
    np.testing.assert_allclose(closed.focal, general.focal, atol=1e-14 * np.max(Q))
    np.testing.assert_allclose(closed.layout, general.layout, atol=1e-14)


def test_determinant_of_the_seed() -> None:
    """(10) as printed, with sum eta^4: the same as Dx and Dy under the symmetry."""
    xi, eta = GRID.T
    D = 9 * (np.sum(xi**2 * eta**2) + np.sum(eta**4)) - np.sum(xi**2) ** 2
    of_x, of_y = mishchenko.moments(GRID)
    assert D == of_x.D == of_y.D == 54.0


def test_error_of_the_one_determinant_form_of_a_rectangle() -> None:
    """EQUATIONS 3.1: 0.56 (f/c = 1) to 1.1e3 (f/c = 6.7) in Q."""
    errors = [
        float(np.max(np.abs(mishchenko.closed_form(RECTANGLE, g).Q - mishchenko.cofactors(RECTANGLE, g))))
        for g in (1.0, 6.7**2)
    ]
    assert f"{errors[0]:.2f} {errors[1]:.1e}" == "0.56 1.1e+03"


def test_error_of_K_of_a_rectangle() -> None:
    """EQUATIONS 3.2: .36 with one D (found at eta = .9), exact with Dx and Dy."""
    new = np.array([[0.5, 0.25], [-0.7, 0.9]])
    C = design(new, 0.0).reshape(-1, 6)
    K = mishchenko.covariance(RECTANGLE, new).reshape(4, 4)
    one = C @ mishchenko.closed_form(RECTANGLE, 0.0).layout @ C.T
    two = C @ mishchenko.closed_form(RECTANGLE, 0.0, 2).layout @ C.T
    assert f"{np.max(np.abs(one - K)):.2f}" == "0.36"
    np.testing.assert_allclose(two, K, atol=1e-14)


@pytest.mark.parametrize("determinants", [1, 2])
def test_no_closed_form_of_an_asymmetric_layout(determinants: int) -> None:
    """Both forms are wrong, by an amount that grows with f/c; K stays what it is."""
    wrong = [
        np.max(np.abs(mishchenko.closed_form(ASYMMETRIC, g, 1 if determinants == 1 else 2).Q
                      - mishchenko.cofactors(ASYMMETRIC, g)))
        for g in (1.0, 6.7**2)
    ]  # fmt: skip
    assert wrong[0] > 0.01
    assert wrong[1] > 100 * wrong[0]


@pytest.mark.parametrize(("f_to_c", "K_XX"), [(1.0, 0.863), (2.2, 9.51), (6.7, 686.0)])
def test_the_diagonal_of_Q_alone_is_wrong(f_to_c: float, K_XX: float) -> None:
    """EQUATIONS 3.2 (c): .863, 9.51, 686 instead of .1687."""
    full, diagonal, _ = uses(GRID, f_to_c**2)
    assert f"{diagonal[0, 0]:.3g}" == f"{K_XX:.3g}"
    assert full[0, 0] == pytest.approx(0.1687, abs=5e-5)


def uses(points: FloatArray, g: float) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]]:
    factor = np.linalg.cholesky(mishchenko.cofactors(points, g))
    return mishchenko.variance_of_uses(design(NEW, g), factor, {"position": (0, 1, 2), "angles": (3, 4, 5)})


def test_part_of_the_elements_is_wrong_too() -> None:
    """Position alone and angles alone: the blocks of Q, whose covariances with each other are missing."""
    g = 2.2**2
    _, diagonal, alone = uses(GRID, g)
    Q, C = mishchenko.cofactors(GRID, g), design(NEW, g)[0]
    for name, at in (("position", slice(0, 3)), ("angles", slice(3, 6))):
        np.testing.assert_allclose(alone[name][0], np.diag(C[:, at] @ Q[at, at] @ C[:, at].T), rtol=1e-12)
    np.testing.assert_allclose(diagonal[0], C**2 @ np.diag(Q), rtol=1e-12)


@pytest.mark.parametrize(("f_to_c", "K_XX"), [(1.0, 0.134), (2.2, 0.125), (6.7, 0.134)])
def test_prior_weights_on_part_of_the_elements_break_the_invariance(f_to_c: float, K_XX: float) -> None:
    """EQUATIONS 3.2 (b): unit weight on X_S, Y_S, Z_S."""
    A = design(GRID, f_to_c**2).reshape(-1, 6)
    Q = np.linalg.inv(A.T @ A + np.diag([1.0, 1, 1, 0, 0, 0]))
    C = design(NEW, f_to_c**2)[0]
    assert f"{(C @ Q @ C.T)[0, 0]:.3f}" == f"{K_XX:.3f}"


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize(("axis_j", "axis_k"), [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_element_matrices_sum_to_the_covariance(layout: str, axis_j: int, axis_k: int) -> None:
    """(12) = (14) + (15); the elements of K^(f,c) sum to zero, those of K^(xi,eta) to the covariance (19)."""
    points, g = LAYOUTS[layout], 6.7**2
    first, second = np.array([0.5, 0.25]), np.array([-0.7, 0.9])
    parts = mishchenko.decomposition(points, g)
    found = mishchenko.element_matrices((first, axis_j), (second, axis_k), parts, g)
    np.testing.assert_allclose(found.whole, found.focal + found.layout, atol=1e-12 * np.max(np.abs(found.whole)))
    assert abs(np.sum(found.focal)) <= 1e-13 * np.max(np.abs(found.focal))
    K = mishchenko.covariance(points, np.array([first, second]))[0, axis_j, 1, axis_k]
    assert np.sum(found.layout) == pytest.approx(K, abs=1e-13)
    rows = design(np.array([first, second]), g)
    diagonal_matrices = np.diag(rows[0, axis_j]) @ parts.Q @ np.diag(rows[1, axis_k])
    np.testing.assert_allclose(found.whole, diagonal_matrices, rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_element_sums_are_those_of_the_matrices(layout: str) -> None:
    """All points and both axes at once: the same sums and the same largest element."""
    g, points = 2.2**2, np.array([[0.5, 0.25], [-0.7, 0.9], [1.0, -1.0]])
    parts = mishchenko.decomposition(LAYOUTS[layout], g)
    focal_sum, focal_largest, layout_sum = mishchenko.element_sums(points, parts, g)
    for i, point in enumerate(points):
        for axis in (0, 1):
            one = mishchenko.element_matrices((point, axis), (point, axis), parts, g)
            assert focal_largest[i, axis] == pytest.approx(np.max(np.abs(one.focal)), rel=1e-12)
            assert layout_sum[i, axis] == pytest.approx(np.sum(one.layout), rel=1e-12)
            assert abs(focal_sum[i, axis]) <= 1e-13 * focal_largest[i, axis]


def test_printed_matrix_18() -> None:
    """(18) with its lost sixth column: four elements of the (X, X) matrix of a symmetric layout, all others zero."""
    g, n = 2.2**2, len(GRID)
    (xi_j, eta_j), (xi_k, eta_k) = (0.5, 0.25), (-0.7, 0.9)
    m, _ = mishchenko.moments(GRID)
    parts = mishchenko.closed_form(GRID, g)
    found = mishchenko.element_matrices((np.array([xi_j, eta_j]), 0), (np.array([xi_k, eta_k]), 0), parts, g).focal
    printed = np.zeros((6, 6))
    printed[0, 0] = g * g * n + 2 * g * m.S2
    printed[0, 3] = -g * g * n - g * n * xi_k**2 - g * m.S2
    printed[3, 0] = -g * g * n - g * n * xi_j**2 - g * m.S2
    printed[3, 3] = g * g * n + g * n * xi_k**2 + g * n * xi_j**2
    np.testing.assert_allclose(found, printed / m.D, atol=1e-13)


def test_rows_16_17_21() -> None:
    by_layout, by_focal_length = design_parts(np.array([[0.5, 0.25]]), 4.0)
    np.testing.assert_array_equal(by_layout[0], [[1, 0, 0.5, 0.25, 0.125, -0.25], [0, 1, 0.25, 0.125, 0.0625, 0.5]])
    np.testing.assert_array_equal(by_focal_length[0], [[0, 0, 0, 4, 0, 0], [0, 0, 0, 0, 4, 0]])


VIOLATIONS: dict[str, tuple[FloatArray, dict[str, float], int]] = {
    "grid": (GRID, {}, 1),
    "rectangle": (RECTANGLE, {"sum xi^2 - sum eta^2": 4.5, "sum xi^4 - sum eta^4": 5.625}, 2),
    "four on the axes": (np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]]), {}, 1),
    "one point more in x": (
        np.vstack([GRID, [[0.5, 0.0]]]),
        {"sum xi": 0.5, "sum xi (xi^2 + eta^2)": 0.125, "sum xi^2 - sum eta^2": 0.25, "sum xi^4 - sum eta^4": 0.0625},
        0,
    ),
    "one point more in y": (
        np.vstack([GRID, [[0.0, 0.5]]]),
        {
            "sum eta": 0.5,
            "sum eta (xi^2 + eta^2)": 0.125,
            "sum xi^2 - sum eta^2": -0.25,
            "sum xi^4 - sum eta^4": -0.0625,
        },
        0,
    ),
    "a pair on the diagonal": (
        np.vstack([GRID, [[0.5, 0.5], [-0.5, -0.5]]]),
        {"sum xi eta": 0.5, "sum xi eta (xi^2 + eta^2)": 0.25},
        0,
    ),
    "gruber": (
        gruber_layout(2.5, 2.5),
        {
            "sum xi": 3.0,
            "sum xi (xi^2 + eta^2)": 5.0,
            "sum xi^2 - sum eta^2": -1.0,
            "sum xi^4 - sum eta^4": -1.0,
        },
        0,
    ),
}


@pytest.mark.parametrize(("points", "violated", "determinants"), VIOLATIONS.values(), ids=VIOLATIONS)
def test_symmetry_names_every_violated_condition(
    points: FloatArray, violated: dict[str, float], determinants: int
) -> None:
    found = mishchenko.symmetry(points)
    assert {each.name: pytest.approx(each.value, abs=1e-12) for each in found.violated} == violated
    assert found.determinants == determinants


@given(st.lists(st.tuples(st.floats(0.1, 1), st.floats(0.1, 1)), min_size=1, max_size=5))
def test_mirroring_about_both_axes_makes_a_layout_symmetric(places: list[tuple[float, float]]) -> None:
    """Every layout that is symmetric about both axes separates; its closed form with Dx and Dy is the inverse."""
    quarter = np.array(places)
    points = np.vstack([quarter * sign for sign in ([1, 1], [1, -1], [-1, 1], [-1, -1])])
    assert mishchenko.symmetry(points).determinants in (1, 2)
    Q = mishchenko.cofactors(points, 2.0)
    np.testing.assert_allclose(mishchenko.closed_form(points, 2.0, 2).Q, Q, atol=1e-10 * np.max(Q))


def test_conditions_are_necessary_for_the_separation() -> None:
    """Where a separating condition fails, Q couples {X, alpha}, {Y, omega}, Z and kappa."""
    apart = np.ones((6, 6), dtype=bool)
    for block in ([0, 3], [1, 4], [2], [5]):
        apart[np.ix_(block, block)] = False
    for points, _, determinants in VIOLATIONS.values():
        coupling = np.abs(mishchenko.cofactors(points, 2.0)[apart])
        assert (np.max(coupling) > 1e-9) == (determinants == 0)


UNDETERMINED = {
    "two points": np.array([[0.0, 0.0], [1.0, 1.0]]),
    "a line": np.array([[-1.0, -1.0], [0.0, 0.0], [0.5, 0.5], [1.0, 1.0]]),
    "nadir on the circle of three points": np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]),
    "not a number": np.array([[0.0, np.nan], [1.0, 0.0], [0.0, 1.0]]),
}


@pytest.mark.parametrize("points", UNDETERMINED.values(), ids=UNDETERMINED)
def test_layouts_that_determine_nothing_are_refused(points: FloatArray) -> None:
    with pytest.raises(GeometryError, match="does not determine the six elements"):
        mishchenko.cofactors(points, 1.0)
    with pytest.raises(GeometryError, match="does not determine"):
        mishchenko.covariance(points, NEW)


def test_closed_form_without_determinant_is_refused() -> None:
    with pytest.raises(GeometryError, match="does not determine"):
        mishchenko.closed_form(np.array([[1.0, 0.0], [-1.0, 0.0], [1.0, 0.0]]), 1.0)
