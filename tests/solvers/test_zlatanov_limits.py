"""Algorithm Z where it must say no: undetermined unknowns by name, no redundancy, wrong input."""

import numpy as np
import pytest
from numpy.typing import NDArray

from orient.errors import OrientError
from orient.solvers.zlatanov import NormalEquations, adjust_bordered

B = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
F = np.array([-1.0, -2.0, -4.0])
CORRELATED = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]])
NAMES = ("a", "b")


def system(m: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """B (12, m), F (12,)."""
    random = np.random.default_rng(1)
    return random.normal(size=(12, m)), random.normal(size=12)


@pytest.mark.parametrize(
    ("column", "named"),
    [
        (lambda b: 0 * b[:, 0], "H"),
        (lambda b: 2 * b[:, 0] - 3 * b[:, 1], "H"),
        (lambda b: 1e-9 * b[:, 2], "H"),
    ],
    ids=["never observed", "a combination", "proportional, small"],
)
def test_an_undetermined_unknown_is_named(column: object, named: str) -> None:
    design, free_term = system(5)
    design[:, 3] = column(design)  # type: ignore[operator]
    equations = NormalEquations(["xi", "eta", "theta", "H", "X0"])
    equations.add(design, free_term)
    result = equations.reduced()
    assert result.undetermined == named
    assert not result.is_determined
    assert np.isnan(result.X).all()
    assert np.isnan(result.Q_x).all()
    assert np.isnan(result.vPv)


def test_fewer_equations_than_unknowns_name_the_first_that_is_left() -> None:
    equations = NormalEquations("abc")
    equations.add(np.array([[1.0, 2.0, 3.0]]), np.array([1.0]))
    assert equations.reduced().undetermined == "b"


def test_full_form_names_the_undetermined_unknown_too() -> None:
    result = adjust_bordered(("a", "b"), np.ones((3, 2)), F, CORRELATED)
    assert result.undetermined == "b"
    assert np.isnan(result.v).all()
    assert np.isnan(result.Q_v).all()


def test_scale_of_an_unknown_does_not_matter() -> None:
    """Rank is judged against N_kk of the same unknown: radians beside kilometres are no defect."""
    design, free_term = system(7)
    scales = 10.0 ** np.arange(-9, 10, 3)
    equations, scaled = NormalEquations("abcdefg"), NormalEquations("abcdefg")
    equations.add(design, free_term)
    scaled.add(design * scales, free_term)
    np.testing.assert_allclose(scaled.reduced().X * scales, equations.reduced().X, rtol=1e-11)


def test_zero_weight_is_no_equation() -> None:
    design, free_term = system(7)
    weights = np.array([1.0] * 10 + [0.0] * 2)
    equations = NormalEquations("abcdefg")
    equations.add(design, free_term, weights)
    assert equations.reduced().redundancy == 3


def test_no_redundancy_has_no_sigma0() -> None:
    equations = NormalEquations("a")
    equations.add(np.array([[2.0]]), np.array([-4.0]))
    result = equations.reduced()
    np.testing.assert_allclose(result.X, [2.0])
    assert np.isnan(result.sigma0)


@pytest.mark.parametrize("columns", [(0, 1), (1, 3), (1, 1), (1,)], ids=str)
def test_wrong_columns_are_refused(columns: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match="column"):
        NormalEquations(NAMES).add(B, F, columns=columns)


def test_negative_weight_is_refused() -> None:
    with pytest.raises(ValueError, match="negative"):
        NormalEquations(NAMES).add(B, F, np.array([1.0, -1.0, 1.0]))


def test_indefinite_cofactor_matrix_is_refused() -> None:
    with pytest.raises(OrientError, match="not positive definite"):
        NormalEquations(NAMES).add_group(B, F, np.diag([1.0, 1.0, -1.0]))
