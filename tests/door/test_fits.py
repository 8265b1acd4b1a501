"""Similarity, polynomial and covariances of arrays, without a project."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import orient
from tests.solvers.absolute_scenes import generator, scene
from tests.solvers.resection_scenes import scene as photo_scene

S = scene(generator("test_fits"), "f" * 9)
XY = generator("test_fits sheet").uniform(0.0, 500.0, (30, 2))
P = photo_scene(generator("test_fits photo"), n=12)


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
    "weights": (lambda: orient.similarity(S.model, S.ground, np.zeros(9)), "weights are not all positive"),
    "weights shape": (lambda: orient.similarity(S.model, S.ground, np.ones(3)), "weights has the shape"),
    "not finite": (lambda: orient.similarity(S.model * np.nan, S.ground), "model has numbers that are not finite"),
    "no numbers": (lambda: orient.similarity([["a"] * 3] * 9, S.ground), "model is no array of numbers"),
    "too large": (lambda: orient.similarity(1e160 * S.ground, S.ground), "beyond 1e"),
    "ragged": (lambda: orient.ground_covariances([[1.0], [1.0, 2.0]], [0, 0, 9], np.eye(6)), "ground is no array"),
    "half a degree": (lambda: orient.polynomial(XY, XY, 1.5), "degree 1.5 is not in"),  # type: ignore[arg-type]
    "degree": (lambda: orient.polynomial(XY, XY, 0), "degree 0 is not in"),
    "one column": (lambda: orient.polynomial(XY, XY[:, 0], 1), "z has the shape"),
    "no column": (lambda: orient.polynomial(XY, XY[:, :0], 1), "z has the shape"),
    "covariance": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], np.eye(3)), "covariance has the shape"),
    "up": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], np.eye(6), [[0, 0, 1]]), "up has the shape"),
    "no up": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], np.eye(6), [0, 0, 0]), "up has no direction"),
    "negative": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], -np.eye(6)), "no covariance matrix"),
    "triangle": (lambda: orient.ground_covariances(S.ground, [0, 0, 9], np.tri(6)), "no covariance matrix"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_arrays_get_one_sentence(name: str) -> None:
    call, said = BAD[name]
    with pytest.raises(orient.UsageError, match=said):
        call()


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
