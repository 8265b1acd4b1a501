"""The packed index IJ of seed 000, equation (10)."""

import numpy as np
import pytest

from orient.solvers.packed import pack_upper, packed_index, packed_pairs, unpack_upper


@pytest.mark.parametrize("u", [1, 2, 7, 19])
def test_every_index_is_hit_once_in_order(u: int) -> None:
    assert [packed_index(i, j, u) for i, j in packed_pairs(u)] == list(range(1, u * (u + 1) // 2 + 1))


def test_index_of_the_seed_with_order_u_plus_one() -> None:
    U, i, j = 7, 3, 5
    assert packed_index(i, j, U + 1) == (i - 1) * (2 * (U + 1) - i) // 2 + j


def test_packing_puts_elements_at_their_index_and_back() -> None:
    A = np.arange(36.0).reshape(6, 6)
    symmetric = A + A.T
    packed = pack_upper(symmetric)
    assert all(packed[packed_index(i, j, 6) - 1] == symmetric[i - 1, j - 1] for i, j in packed_pairs(6))
    np.testing.assert_array_equal(unpack_upper(packed), symmetric)


@pytest.mark.parametrize(("i", "j"), [(0, 1), (2, 1), (1, 4)])
def test_outside_the_triangle_is_refused(i: int, j: int) -> None:
    with pytest.raises(ValueError, match="triangle"):
        packed_index(i, j, 3)


def test_a_length_that_is_no_triangle_is_refused() -> None:
    with pytest.raises(ValueError, match="5 numbers"):
        unpack_upper(np.zeros(5))
