"""Algorithm Z and QR are one triangle."""

import numpy as np
import pytest

from orient.solvers.engines import Engine, triangle
from orient.solvers.functional_iteration import SINGULAR_RATIO, condition_ratio


@pytest.mark.parametrize(("n", "u"), [(6, 6), (12, 7), (500, 19), (1, 1)])
def test_both_engines_give_the_same_normal_equations_and_solution(n: int, u: int) -> None:
    random = np.random.default_rng(n)
    A, l = random.normal(size=(n, u)), random.normal(size=n)
    for engine in Engine:
        R, rho = triangle(A, l, engine)
        np.testing.assert_allclose(R.T @ R, A.T @ A, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(R.T @ rho, A.T @ l, rtol=1e-12, atol=1e-11)
        np.testing.assert_array_equal(R, np.triu(R))
    solutions = [np.linalg.solve(*triangle(A, l, engine)) for engine in Engine]
    np.testing.assert_allclose(solutions[0], solutions[1], rtol=1e-9)


@pytest.mark.parametrize("noise", [0.0, 1e-9, 1e-7], ids=["singular", "nearly", "weak"])
def test_near_singular_geometry_is_judged_by_qr(noise: float) -> None:
    """Normal equations cannot tell a ratio of 1e-9 from 1e-7: they must not call the first one weak."""
    random = np.random.default_rng(2)
    A = random.normal(size=(30, 4))
    A[:, 3] = A[:, 0] + A[:, 1] + noise * random.normal(size=30)
    ratios = [condition_ratio(triangle(A, np.ones(30), engine)[0]) for engine in Engine]
    assert ratios[0] == ratios[1]
    assert (ratios[0] < SINGULAR_RATIO) == (noise < 1e-8)


@pytest.mark.parametrize("engine", Engine)
def test_too_few_equations_leave_empty_rows(engine: Engine) -> None:
    R, rho = triangle(np.array([[1.0, 2.0, 3.0]]), np.array([4.0]), engine)
    assert R.shape == (3, 3)
    assert rho.shape == (3,)
    np.testing.assert_array_equal(R[1:], 0)
