"""Algorithm Z: seed 000 (9)-(16), both printed examples of the corrected paper, and dense matrices as judge."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from orient.solvers.packed import packed_index, packed_pairs
from orient.solvers.zlatanov import (
    NormalEquations,
    adjust_bordered,
    base_address,
    column_addresses,
    element_addresses,
)

Array = NDArray[np.float64]

B = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
F = np.array([-1.0, -2.0, -4.0])
CORRELATED = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]])
NAMES = ("a", "b")


def random_system(n: int = 12, m: int = 7, seed: int = 1) -> tuple[Array, Array, Array]:
    """B (n, m), F (n,), full positive definite Q_L (n, n)."""
    random = np.random.default_rng(seed)
    root = random.normal(size=(n, n))
    return random.normal(size=(n, m)), random.normal(size=n), root @ root.T + n * np.eye(n)


def dense(B: Array, F: Array, Q_L: Array) -> dict[str, Any]:
    """The adjustment by full matrices."""
    P = np.linalg.inv(Q_L)
    Q_x = np.linalg.inv(B.T @ P @ B)
    X = -Q_x @ B.T @ P @ F
    v = B @ X + F
    Q_Lhat = B @ Q_x @ B.T
    return {"X": X, "Q_x": Q_x, "v": v, "vPv": v @ P @ v, "Q_Lhat": Q_Lhat, "Q_v": Q_L - Q_Lhat, "P": P}


@pytest.mark.parametrize(
    ("Q_L", "starts_with_Q_L", "packed"),
    [
        (
            np.eye(3),
            False,
            """1.732051 1.732051 -4.041452 .57735 .57735 .57735  1.414214 -2.12132 -.707107 0 .707107
               .166667 -.166667 .333333 -.166667  -.833333 -.333333 .166667  -.333333 -.333333  -.833333""",
        ),
        (
            CORRELATED,
            True,
            """1.46385 1.9518 -4.09878 .68313 .68313 .68313  1.154701 -1.732051 -1.154701 -.288675 .57735
               .2 -.2 .3 -.2  .2 -.3 .2  .45 -.3  .2""",
        ),
    ],
    ids=["unit Q_L, Z33 = 0", "correlated Q_L, Z33 = Q_L"],
)
def test_packed_result_of_the_paper(Q_L: Array, starts_with_Q_L: bool, packed: str) -> None:
    result = adjust_bordered(NAMES, B, F, Q_L, starts_with_Q_L=starts_with_Q_L)
    expected = [float(number) for number in packed.split()]
    np.testing.assert_allclose(result.packed, expected, rtol=0, atol=6e-7)


def test_unit_example_of_the_paper() -> None:
    result = adjust_bordered(NAMES, B, F, np.eye(3), starts_with_Q_L=False)
    np.testing.assert_allclose(result.X, [5 / 6, 1.5], rtol=1e-14)
    np.testing.assert_allclose(result.v, [-1 / 6, 1 / 3, -1 / 6], rtol=1e-13)
    np.testing.assert_allclose(result.Q_x, [[5 / 6, -0.5], [-0.5, 0.5]], rtol=1e-14)
    assert result.vPv == pytest.approx(1 / 6)
    assert result.sigma0 == pytest.approx(np.sqrt(1 / 6))


def test_correlated_example_of_the_paper() -> None:
    result = adjust_bordered(NAMES, B, F, CORRELATED)
    np.testing.assert_allclose(result.X, [0.8, 1.5], rtol=1e-13)
    np.testing.assert_allclose(result.v, [-0.2, 0.3, -0.2], rtol=1e-12)
    np.testing.assert_allclose(result.Q_x, [[1.8, -1], [-1, 0.75]], rtol=1e-13)
    np.testing.assert_allclose(result.Q_v, [[0.2, -0.3, 0.2], [-0.3, 0.45, -0.3], [0.2, -0.3, 0.2]], rtol=1e-12)
    assert result.vPv == pytest.approx(0.2)


@pytest.mark.parametrize("starts_with_Q_L", [True, False])
def test_full_form_is_the_dense_adjustment(starts_with_Q_L: bool) -> None:
    system = random_system()
    expected = dense(*system)
    result = adjust_bordered([f"x{k}" for k in range(7)], *system, starts_with_Q_L=starts_with_Q_L)
    for name in ("X", "Q_x", "v", "vPv", "Q_v", "Q_Lhat"):
        np.testing.assert_allclose(getattr(result, name), expected[name], rtol=1e-12, atol=1e-12, err_msg=name)
    np.testing.assert_allclose(result.R.T @ result.T, system[0].T, atol=1e-12)
    assert np.trace(result.Q_v @ expected["P"]) == pytest.approx(result.redundancy)
    assert result.redundancy == 5


@pytest.mark.parametrize("U", [1, 7, 19])
def test_addresses_hit_every_place_of_the_triangle_once(U: int) -> None:
    """(10), (12), (13): order U + 1."""
    every = element_addresses(column_addresses(range(1, U + 1), U), U)
    assert every.tolist() == list(range(1, (U + 1) * (U + 2) // 2 + 1))
    assert all(base_address(i, U) + j == packed_index(i, j, U + 1) for i, j in packed_pairs(U + 1))


def test_free_term_of_seven_unknowns_stands_in_column_eight() -> None:
    """(11): the seed's JM = 6 is the column of Y0."""
    assert column_addresses((1, 2, 3, 4, 6), 7).tolist() == [1, 2, 3, 4, 6, 8]


def compact_rows(random: np.random.Generator, n: int) -> list[tuple[Array, Array, Array, tuple[int, ...]]]:
    """X-, Y- and Z-equations of seed 000: four common unknowns and one of X0, Y0, Z0, with weights."""
    axes = ((1, 2, 3, 4, 5), (1, 2, 3, 4, 6), (1, 2, 3, 4, 7))
    return [(random.normal(size=(n, 5)), random.normal(size=n), random.uniform(0.5, 2, n), J) for J in axes]


def test_compact_equations_are_the_full_ones() -> None:
    compact, full = NormalEquations("abcdefg"), NormalEquations("abcdefg")
    for b, f, p, J in compact_rows(np.random.default_rng(3), 4):
        compact.add(b, f, p, columns=J)
        spread = np.zeros((4, 7))
        spread[:, np.array(J) - 1] = b
        full.add(spread, f, p)
    np.testing.assert_allclose(compact.packed, full.packed, atol=1e-14)
    assert compact.n_equations == 12


def test_each_equation_may_have_its_own_columns() -> None:
    """Zones: every photo has its own parameters; columns in any order."""
    by_axis, mixed = NormalEquations("abcdefg"), NormalEquations("abcdefg")
    rows = compact_rows(np.random.default_rng(4), 4)
    for b, f, p, J in rows:
        by_axis.add(b, f, p, columns=J)
    b, f, p = (np.concatenate([row[k] for row in rows]) for k in range(3))
    mixed.add(b[:, ::-1], f, p, columns=np.repeat([row[3][::-1] for row in rows], 4, axis=0))
    np.testing.assert_allclose(mixed.packed, by_axis.packed, atol=1e-14)


def test_short_form_gives_everything_group_by_group() -> None:
    random = np.random.default_rng(5)
    design, free_term = random.normal(size=(4, 3, 7)), random.normal(size=(4, 3))
    root = random.normal(size=(4, 3, 3))
    Q_L = root @ root.transpose(0, 2, 1) + np.eye(3)
    whole = np.zeros((12, 12))
    for g in range(4):
        whole[3 * g : 3 * g + 3, 3 * g : 3 * g + 3] = Q_L[g]
    expected = dense(design.reshape(12, 7), free_term.ravel(), whole)
    equations = NormalEquations("abcdefg")
    equations.add_group(design, free_term, Q_L)
    result = equations.reduced()
    np.testing.assert_allclose(result.X, expected["X"], rtol=1e-12)
    np.testing.assert_allclose(result.Q_x, expected["Q_x"], rtol=1e-11, atol=1e-12)
    assert result.vPv == pytest.approx(expected["vPv"], rel=1e-12)
    np.testing.assert_allclose(result.residuals(design, free_term).ravel(), expected["v"], atol=1e-12)
    blocks = [expected["Q_v"][3 * g : 3 * g + 3, 3 * g : 3 * g + 3] for g in range(4)]
    np.testing.assert_allclose(result.residual_cofactors(design, Q_L), blocks, atol=1e-12)
    numbers = result.redundancy_numbers(design, Q_L)
    np.testing.assert_allclose(numbers.ravel(), np.diag(expected["Q_v"] @ expected["P"]), atol=1e-12)
    assert numbers.sum() == pytest.approx(12 - 7)


def test_order_and_portions_of_the_equations_do_not_matter() -> None:
    design, free_term, _ = random_system(n=40)
    weights = np.random.default_rng(6).uniform(0.1, 10, 40)
    at_once, one_by_one = NormalEquations("abcdefg"), NormalEquations("abcdefg")
    at_once.add(design, free_term, weights)
    for k in np.random.default_rng(7).permutation(40):
        one_by_one.add(design[k : k + 1], free_term[k : k + 1], weights[k : k + 1])
    np.testing.assert_allclose(one_by_one.packed, at_once.packed, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(one_by_one.reduced().X, at_once.reduced().X, rtol=1e-12)


def test_weights_are_the_diagonal_of_P() -> None:
    design, free_term, _ = random_system()
    Q_L = np.diag(np.random.default_rng(8).uniform(0.1, 10, 12))
    weighted, grouped = NormalEquations("abcdefg"), NormalEquations("abcdefg")
    weighted.add(design, free_term, 1 / np.diag(Q_L))
    grouped.add_group(design, free_term, Q_L)
    np.testing.assert_allclose(weighted.packed, grouped.packed, rtol=1e-12, atol=1e-12)


def test_equations_may_be_added_after_a_reduction() -> None:
    design, free_term, _ = random_system()
    equations, whole = NormalEquations("abcdefg"), NormalEquations("abcdefg")
    equations.add(design[:8], free_term[:8])
    before = equations.packed
    equations.reduced()
    np.testing.assert_array_equal(equations.packed, before)
    equations.add(design[8:], free_term[8:])
    whole.add(design, free_term)
    np.testing.assert_allclose(equations.reduced().X, whole.reduced().X, rtol=1e-12)


@pytest.mark.parametrize("starts_with_Q_L", [True, False])
@pytest.mark.parametrize("group", [1, 2, 3])
def test_groups_are_the_blocks_of_the_full_form(group: int, starts_with_Q_L: bool) -> None:
    """(9), (15) with a third block of which only the groups of Q_L are kept: the same numbers, less of them."""
    design, free_term, _ = random_system()
    root = np.random.default_rng(group).normal(size=(12 // group, group, group))
    blocks = root @ root.transpose(0, 2, 1) + np.eye(group)
    whole = np.zeros((12, 12))
    for g, block in enumerate(blocks):
        whole[group * g : group * (g + 1), group * g : group * (g + 1)] = block
    names = [f"x{k}" for k in range(7)]
    full, kept = (
        adjust_bordered(names, design, free_term, Q, starts_with_Q_L=starts_with_Q_L) for Q in (whole, blocks)
    )
    for name in ("X", "Q_x", "v", "vPv", "T"):
        np.testing.assert_allclose(getattr(kept, name), getattr(full, name), rtol=1e-11, atol=1e-12, err_msg=name)
    for name in ("Q_v", "Q_Lhat"):
        for g, block in enumerate(getattr(kept, name)):
            places = slice(group * g, group * (g + 1))
            np.testing.assert_allclose(block, getattr(full, name)[places, places], atol=1e-12, err_msg=name)
    assert len(kept.packed) == 8 * 9 // 2 + 8 * 12 + 12 * (group + 1) // 2


def test_free_terms_share_the_reduction() -> None:
    design, free_term, Q_L = random_system()
    other = np.random.default_rng(9).normal(size=12)
    names = [f"x{k}" for k in range(7)]
    pair = adjust_bordered(names, design, np.column_stack([free_term, other]), Q_L)
    apart = [adjust_bordered(names, design, F, Q_L) for F in (free_term, other)]
    for k, one in enumerate(apart):
        np.testing.assert_allclose(pair.X[:, k], one.X, rtol=1e-12)
        np.testing.assert_allclose(pair.v[:, k], one.v, atol=1e-13)
        np.testing.assert_allclose(pair.rho[:, k], one.rho, rtol=1e-12)
    np.testing.assert_allclose(pair.Q_v, apart[0].Q_v, atol=1e-13)
    assert pair.vPv == pytest.approx(apart[0].vPv + apart[1].vPv)
    assert pair.sigma0 == pytest.approx(np.sqrt((apart[0].vPv + apart[1].vPv) / 10))
