import numpy as np
import pytest

from orient.errors import UsageError
from orient.geometry import plane, polynomial
from tests.jacobian import central_difference

RANDOM = np.random.default_rng(20240101)
PARAMETERS = {
    "similarity": [3.0, -2.0, 0.9, 0.2],
    "affine": [3.0, 0.9, 0.2, -2.0, -0.21, 0.88],
    "projective": [3.0, 0.9, 0.2, -2.0, -0.21, 0.88, 1e-3, -2e-3],
}


def test_terms_stand_by_total_degree():
    assert polynomial.exponents(2) == ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    assert [len(polynomial.exponents(d)) for d in range(6)] == [1, 3, 6, 10, 15, 21]


def test_design_of_one_point():
    np.testing.assert_array_equal(polynomial.design([2.0], [3.0], 2), [[1, 2, 3, 4, 6, 9]])


@pytest.mark.parametrize("degree", range(6))
def test_polynomial_gradient(degree):
    uv = RANDOM.uniform(-1, 1, (6, 2))
    analytic = polynomial.gradient(*uv.T, degree)
    numeric = [central_difference(lambda p: polynomial.design(p[:1], p[1:], degree)[0], point) for point in uv]
    np.testing.assert_allclose(analytic, numeric, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("n", [0, 1, 7, 1000])
@pytest.mark.parametrize("degree", [0, 1, 2, 3, 5, 8])
def test_compiled_values_are_those_of_the_design(degree, n):
    """Places that stand apart in memory, one of them NaN."""
    pytest.importorskip("numba", reason="numba is not installed: orient[fast]")
    uv = RANDOM.uniform(-1, 1, (n, 2))
    uv[3:4, 0] = np.nan
    coefficients = RANDOM.normal(size=(len(polynomial.exponents(degree)), 3))
    plain, compiled = (polynomial.values(*uv.T, coefficients, compiled=choice) for choice in (False, True))
    assert compiled.shape == (n, 3)
    np.testing.assert_allclose(compiled, plain, rtol=0, atol=1e-13)
    if degree:
        np.testing.assert_allclose(compiled, polynomial.design(*uv.T, degree) @ coefficients, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", PARAMETERS)
def test_plane_partials(name):
    XY = RANDOM.uniform(-100, 100, (5, 2))
    numeric = central_difference(lambda p: plane.apply(name, p, XY), PARAMETERS[name], 1e-7)
    assert len(plane.parameter_names(name)) == len(PARAMETERS[name])
    np.testing.assert_allclose(plane.partials(name, PARAMETERS[name], XY), numeric, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", ["similarity", "affine"])
def test_linear_transformations_are_their_partials(name):
    XY = RANDOM.uniform(-100, 100, (5, 2))
    by_partials = plane.partials(name, np.zeros(len(PARAMETERS[name])), XY) @ PARAMETERS[name]
    np.testing.assert_allclose(plane.apply(name, PARAMETERS[name], XY), by_partials, rtol=1e-14)


@pytest.mark.parametrize("name", PARAMETERS)
def test_the_inverse_comes_back(name):
    XY = RANDOM.uniform(-50, 50, (8, 2))
    xy = plane.apply(name, PARAMETERS[name], XY)
    np.testing.assert_allclose(plane.invert(name, PARAMETERS[name], xy), XY, atol=1e-10)


def test_the_similarity_of_the_module():
    np.testing.assert_allclose(plane.apply("similarity", [3, -2, 0.9, 0.2], [[10, 20]]), [[16.0, 14.0]])


def test_the_vanishing_line_is_infinite_without_a_warning():
    assert not np.isfinite(plane.apply("projective", [0, 1, 0, 0, 0, 1, -1, 0], [[1.0, 5.0]])).any()


def test_wrong_names_and_counts_are_named():
    with pytest.raises(UsageError, match='unknown transformation "helmert"'):
        plane.parameter_names("helmert")
    with pytest.raises(UsageError, match="affine takes 6 parameters, 2 were given"):
        plane.apply("affine", [1, 2], [[0, 0]])
