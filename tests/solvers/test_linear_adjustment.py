"""One linear adjustment by Algorithm Z in two passes and by QR: the same, whatever the condition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orient.solvers.engines import Engine
from orient.solvers.linear_adjustment import LinearAdjustment, adjust, weakest_unknown

NAMES = tuple("abcdefg")


def system(seed: int, n: int, u: int, weakness: float, free_terms: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """B (n, u) whose singular values fall to `weakness`, columns of very different length, and F."""
    random = np.random.default_rng(seed)
    left = np.linalg.qr(random.normal(size=(n, u)))[0]
    right = np.linalg.qr(random.normal(size=(u, u)))[0]
    B = left * np.geomspace(1.0, weakness, u) @ right.T
    B = B / np.linalg.norm(B, axis=0)
    return B * 10.0 ** random.uniform(-4, 4, u), B @ random.normal(size=(u, free_terms)) + 1e-3 * random.normal(
        size=(n, free_terms)
    )


def both(B: np.ndarray, F: np.ndarray) -> list[LinearAdjustment]:
    return [adjust(NAMES[: B.shape[1]], B, F, engine) for engine in Engine]


@given(
    seed=st.integers(0, 10**6),
    u=st.integers(1, 7),
    more=st.integers(0, 40),
    weakness=st.floats(-4, 0).map(lambda power: 10.0**power),
)
def test_engines_agree_to_1e_9(seed: int, u: int, more: int, weakness: float) -> None:
    """Down to the weakest sheet that is not refused, singular values 1 to 1e-4; s are the sigmas of the unknowns."""
    B, F = system(seed, u + more, u, weakness)
    by_Z, by_qr = both(B, F)
    s = np.sqrt(np.diag(by_qr.Q_x))
    np.testing.assert_allclose(by_Z.Q_x / np.outer(s, s), by_qr.Q_x / np.outer(s, s), rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.diag(by_Z.Q_x), np.diag(by_qr.Q_x), rtol=1e-9)
    np.testing.assert_allclose(by_Z.X, by_qr.X, rtol=1e-9, atol=1e-9 * np.max(np.abs(by_qr.X)))
    np.testing.assert_allclose(by_Z.v, by_qr.v, rtol=0, atol=1e-12 * np.max(np.abs(F)))
    np.testing.assert_allclose(by_Z.redundancy_numbers, by_qr.redundancy_numbers, rtol=0, atol=1e-12)
    assert np.sum(by_Z.redundancy_numbers) == pytest.approx(more, abs=1e-9)


@pytest.mark.parametrize("engine", Engine)
def test_what_is_found_is_the_dense_adjustment(engine: Engine) -> None:
    B, F = system(1, 20, 5, 0.1)
    found = adjust(NAMES[:5], B, F, engine)
    N_inverse = np.linalg.inv(B.T @ B)
    np.testing.assert_allclose(found.X, -N_inverse @ B.T @ F, rtol=1e-8)
    np.testing.assert_allclose(found.v, B @ found.X + F, atol=1e-12)
    np.testing.assert_allclose(found.Q_x, N_inverse, rtol=1e-8)
    np.testing.assert_allclose(found.redundancy_numbers, 1 - np.diag(B @ N_inverse @ B.T), atol=1e-10)
    np.testing.assert_allclose(found.shares.T @ found.shares, np.eye(5), atol=1e-14)


def test_one_free_term_is_no_column() -> None:
    B, F = system(2, 9, 3, 0.5)
    for one, two in zip(both(B, F[:, 0]), both(B, F), strict=True):
        assert one.X.shape == (3,)
        assert one.v.shape == (9,)
        np.testing.assert_allclose(one.X, two.X[:, 0], rtol=1e-12)


def test_the_second_pass_restores_what_normal_equations_lose() -> None:
    """Singular values 1 to 1e-5: the columns of B R_1^-1 are off by 1e-7, those of the result by nothing."""
    B, F = system(3, 40, 6, 1e-5)
    shares = adjust(NAMES[:6], B, F).shares
    np.testing.assert_allclose(shares.T @ shares, np.eye(6), atol=1e-14)


def test_what_normal_equations_cannot_carry_goes_to_qr() -> None:
    B, F = system(4, 40, 6, 1e-7)
    by_Z, by_qr = both(B, F)
    np.testing.assert_array_equal(by_Z.X, by_qr.X)


@pytest.mark.parametrize(("place", "noise"), [(2, 0.0), (4, 0.0), (4, 1e-4)], ids=["third", "last", "nearly"])
def test_the_weakest_unknown_is_named(place: int, noise: float) -> None:
    random = np.random.default_rng(5)
    B = random.normal(size=(30, 5))
    B[:, place] = B[:, 0] - 2 * B[:, 1] + noise * random.normal(size=30)
    assert weakest_unknown(NAMES[:5], B) == NAMES[place]
