"""Similarity, polynomial and covariances of arrays, without a project."""

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import orient
from tests.solvers.absolute_scenes import generator, scene
from tests.solvers.resection_scenes import scene as photo_scene

S = scene(generator("test_fits"), "f" * 9)
XY = generator("test_fits sheet").uniform(0.0, 500.0, (30, 2))
P = photo_scene(generator("test_fits photo"), n=12)
BEYOND_ONE, NO_VARIANCE, INDEFINITE = np.eye(6), np.eye(6), np.eye(6)
BEYOND_ONE[0, 1] = BEYOND_ONE[1, 0] = 1.001
NO_VARIANCE[0] = NO_VARIANCE[:, 0] = [0.0, 1e-3, 0.0, 0.0, 0.0, 0.0]
INDEFINITE[:3, :3] = [[1.0, 0.9, -0.9], [0.9, 1.0, 0.9], [-0.9, 0.9, 1.0]]


def test_a_similarity_and_a_polynomial_come_back() -> None:
    fit = orient.similarity(S.model.tolist(), S.ground.tolist())
    np.testing.assert_allclose(fit.X0 + S.model @ fit.rotation.T / fit.H, S.ground, rtol=0, atol=1e-7)
    assert fit.t == pytest.approx(1 / S.H)
    sheet = orient.polynomial(XY, XY**2, 2)
    np.testing.assert_allclose(sheet.values([[3.0, 4.0]]), [[9.0, 16.0]], rtol=0, atol=1e-7)


def test_ground_covariances_of_a_resection() -> None:
    """sigma of the plan is of the size of H/f times that of the image; heights are kept."""
    one = orient.resection(P.noisy(0.005, generator("fits noise")), P.ground, P.f_mm, P.rotation, P.station)
    K = orient.ground_covariances(P.ground, one.station, one.vPv / 18 * one.Q)
    sigma = np.sqrt(np.trace(K, axis1=1, axis2=2) / 2)
    per_mm = np.linalg.norm(P.ground - P.station, axis=1) / P.f_mm
    assert np.all((sigma > 0.0005 * per_mm) & (sigma < 0.1 * per_mm))
    assert np.max(np.abs(K[:, 2])) < 1e-9 * np.max(K)


BAD: dict[str, tuple[Callable[[], Any], str]] = {
    "counts": (lambda: orient.similarity(S.model, S.ground[:5]), "model has 9 points and ground 5"),
    "shape": (lambda: orient.similarity(S.model[:, :2], S.ground), "model has the shape"),
    "too few": (lambda: orient.similarity(S.model[:2], S.ground[:2]), "2 points do not determine"),
    "weights": (lambda: orient.similarity(S.model, S.ground, np.zeros(9)), "weights are not all between"),
    "tiny weights": (lambda: orient.similarity(S.model, S.ground, np.full(9, 1e-320)), "weights are not all between"),
    "weights shape": (lambda: orient.similarity(S.model, S.ground, np.ones(3)), "weights has the shape"),
    "not finite": (lambda: orient.similarity(S.model * np.nan, S.ground), "model has numbers that are not finite"),
    "no numbers": (
        lambda: orient.similarity([["a"] * 3] * 9, S.ground),
        "model holds something that is no real number",
    ),
    "too large": (lambda: orient.similarity(1e160 * S.ground, S.ground), "beyond 1e"),
    "ragged": (
        lambda: orient.ground_covariances([[1.0], [1.0, 2.0]], [0, 0, 9], np.eye(6)),
        "ground is no array of numbers",
    ),
    "half a degree": (lambda: orient.polynomial(XY, XY, 1.5), "degree 1.5 is not in"),  # type: ignore[arg-type]
    "degree": (lambda: orient.polynomial(XY, XY, 0), "degree 0 is not in"),
    "two degrees": (lambda: orient.polynomial(XY, XY, np.array([1, 2])), "degree has the shape"),  # type: ignore[arg-type]
    "complex degree": (lambda: orient.polynomial(XY, XY, 2 + 0j), "degree holds something"),  # type: ignore[arg-type]
    "rows": (lambda: orient.polynomial(XY, XY, np.zeros(1, "f8,f8")), "degree holds something"),  # type: ignore[arg-type]
    "one column": (lambda: orient.polynomial(XY, XY[:, 0], 1), "z has the shape"),
    "no column": (lambda: orient.polynomial(XY, XY[:, :0], 1), "z has the shape"),
    "covariance": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], np.eye(3)), "covariance has the shape"),
    "up": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], np.eye(6), [[0, 0, 1]]), "up has the shape"),
    "no up": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], np.eye(6), [0, 0, 0]), "up has no direction"),
    "negative": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], -np.eye(6)), "no covariance matrix"),
    "correlation": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], BEYOND_ONE), "no covariance matrix"),
    "no variance": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], NO_VARIANCE), "no covariance matrix"),
    "three that exclude each other": (
        lambda: orient.ground_covariances(S.ground, [0, 0, 9], INDEFINITE),
        "covariance is no covariance matrix",
    ),
    "places as text": (lambda: orient.polynomial(XY, XY, 3).values("x"), "XY holds something that is no real number"),
    "places of another width": (lambda: orient.polynomial(XY, XY, 3).leverages([[1.0]]), "XY has the shape"),
    "places too large": (lambda: orient.polynomial(XY, XY, 3).leverages([[1e200, 0.0]]), "beyond 1e"),
    "places too far": (lambda: orient.polynomial(XY, XY, 3).values([[1e50, 0.0]]), "XY lies so far"),
    "triangle": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], np.tri(6)), "no covariance matrix"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_arrays_get_one_sentence(name: str) -> None:
    call, said = BAD[name]
    with pytest.raises(orient.UsageError, match=said):
        call()


NO_NUMBERS: dict[str, tuple[Any, str, str]] = {
    "huge": ([[10**400, 0, 0]] * 9, "beyond 1e", "Leave out points"),
    "longer than a float": (np.full((9, 3), np.longdouble("1e4000")), "beyond 1e", "Leave out points"),
    "a decimal that signals": ([[Decimal("sNaN")] * 3] * 9, "not finite", "Leave out points"),
    "masked": (np.ma.masked_less(S.ground, np.median(S.ground)), "masked", "Leave out what is masked"),
    "masked rows": (list(np.ma.masked_less(S.ground, np.median(S.ground))), "masked", "Leave out what is masked"),
    "masked numbers": ([[np.ma.masked, 0.0, 0.0]] * 9, "masked", "Leave out what is masked"),
    "complex": (S.ground + 0j, "no real number", "whole numbers or floats"),
    "complex objects": (np.full((9, 3), 1j, dtype=object), "no real number", "whole numbers or floats"),
    "days": (np.zeros((9, 3), "datetime64[D]"), "no real number", "whole numbers or floats"),
    "hours": (np.zeros((9, 3), "timedelta64[h]"), "no real number", "whole numbers or floats"),
    "texts of numbers": (np.full((9, 3), "1.5"), "no real number", "whole numbers or floats"),
    "nothing": (None, "no real number", "whole numbers or floats"),
    "ragged": ([[1.0], [1.0, 2.0]], "no array of numbers", "rows of one length"),
}


@pytest.mark.parametrize("name", NO_NUMBERS)
@pytest.mark.filterwarnings("error")
def test_what_is_no_real_number_gets_one_sentence_and_a_remedy(name: str) -> None:
    given, said, remedy = NO_NUMBERS[name]
    with pytest.raises(orient.UsageError, match=f"^ground .*{said}") as error:
        orient.ground_covariances(given, [0, 0, 9], np.eye(6))
    assert remedy in error.value.hint


def test_numbers_of_any_kind_are_numbers() -> None:
    """A mask that hides nothing, whole numbers beyond 64 bits, fractions, decimals, single precision."""
    expected = orient.ground_covariances(np.full((2, 3), 2.0**70), [0, 0, 9], np.eye(6))
    for given in (
        np.ma.masked_less(np.full((2, 3), 2.0**70), 0.0),
        [[2**70] * 3] * 2,
        [[Fraction(2**71, 2), Decimal(2**70), 2.0**70]] * 2,
        np.full((2, 3), 2.0**70, np.float32),
    ):
        np.testing.assert_array_equal(orient.ground_covariances(given, [0, 0, 9], np.eye(6)), expected)


def test_no_hint_speaks_of_points_where_none_can_be_left_out() -> None:
    for change in ({"station": [np.nan, 0, 0]}, {"covariance": np.full((6, 6), np.inf)}, {"up": [np.nan, 0, 0]}):
        with pytest.raises(orient.UsageError, match="not finite") as error:
            orient.ground_covariances(**{"ground": S.ground, "station": [0, 0, 9], "covariance": np.eye(6), **change})
        assert error.value.hint == ""


@pytest.mark.parametrize("K", [np.zeros((6, 6)), np.ones((6, 6)), 1e-320 * np.eye(6), np.diag([1e60 / 2, 1e-160] * 3)])
def test_singular_covariances_are_covariances(K: np.ndarray[Any, Any]) -> None:
    assert np.isfinite(orient.ground_covariances(P.ground, P.station, K)).all()


@pytest.mark.parametrize("ground", [np.full((9, 3), 6e6 + 0.1), np.outer(np.arange(9), [1, 2, 3]) + 6e6])
def test_ground_points_on_a_line_or_in_one_place_are_refused(ground: np.ndarray[Any, Any]) -> None:
    with pytest.raises(orient.GeometryError, match="ground points lie on one line or in one place"):
        orient.similarity(S.model, ground)


def test_the_plan_of_ground_covariances() -> None:
    """(n, 2, 2) of the first two coordinates."""
    given = P.ground, P.station, np.eye(6)
    whole = orient.ground_covariances(*given)
    np.testing.assert_array_equal(orient.ground_covariances(*given, plan=True), whole[:, :2, :2])


def test_what_is_compiled_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("orient.errors.find_spec", lambda name: None)
    for call in (
        lambda: orient.similarity(S.model, S.ground, compiled=True),
        lambda: orient.ground_covariances(S.ground, [0, 0, 9e3], np.eye(6), compiled=True),
        lambda: orient.polynomial(XY, XY, 1).values(XY, compiled=True),
        lambda: orient.resections([P.image], [P.ground], P.f_mm, compiled=True),
    ):
        with pytest.raises(orient.UsageError, match="compiled loops need numba"):
            call()
