"""Resection and absolute orientation by Algorithm Z and by QR: the same to 1e-9 relative (issue 3, 1)."""

import numpy as np
import pytest

from orient.solvers.absolute_orientation import orient_model
from orient.solvers.absolute_small_angles import orient_by_small_angles
from orient.solvers.engines import Engine
from orient.solvers.resection import resect
from tests.solvers.absolute_scenes import scene as model_scene
from tests.solvers.resection_scenes import generator, scene


@pytest.mark.parametrize("kind", ["errorless", "weighted", "flat and distant"])
def test_resection(kind: str) -> None:
    random = generator(f"test_resection {kind}")
    s = scene(
        random, n=9, relief=1e-3 if kind == "flat and distant" else 0.1, distance=2.5e5 if "flat" in kind else 2e3
    )
    image = s.noisy(0.01, random)
    knowledge = {}
    if kind == "weighted":
        knowledge = {
            "ground_free": np.tile(np.eye(3), (9, 1, 1)),
            "ground_weight": np.tile(np.eye(3) * 4e-4, (9, 1, 1)),
        }
    by_Z, by_qr = (resect(image, s.unit, s.ground, s.f_mm, engine=engine, **knowledge) for engine in Engine)
    np.testing.assert_allclose(by_Z.rotation, by_qr.rotation, rtol=0, atol=1e-9)
    np.testing.assert_allclose(by_Z.station, by_qr.station, rtol=1e-9)
    np.testing.assert_allclose(by_Z.Q, by_qr.Q, rtol=1e-7, atol=1e-9 * np.max(by_qr.Q))
    np.testing.assert_allclose(np.diag(by_Z.Q), np.diag(by_qr.Q), rtol=1e-8)
    assert by_Z.vPv == pytest.approx(by_qr.vPv, rel=1e-9)


@pytest.mark.parametrize("kinds", ["ffffff", "ffpphhhf"])
@pytest.mark.parametrize("correlated", [False, True])
@pytest.mark.parametrize("with_model_errors", [False, True])
def test_absolute_orientation(kinds: str, correlated: bool, with_model_errors: bool) -> None:
    random = generator(f"test_absolute {kinds} {correlated}")
    s = model_scene(random, kinds)
    ground = s.ground + random.normal(size=s.ground.shape) * 0.05
    root = random.normal(size=(3 * len(kinds),) * 2)
    Q_G = root @ root.T + np.eye(len(root)) if correlated else None
    Q_x = np.tile(np.diag([1e-8, 2e-8, 4e-8]), (len(kinds), 1, 1)) if with_model_errors else None
    by_Z, by_qr = (
        orient_model(s.model, ground, known=s.known, ground_cofactor=Q_G, model_cofactor=Q_x, engine=engine)
        for engine in Engine
    )
    np.testing.assert_allclose(by_Z.rotation, by_qr.rotation, rtol=0, atol=1e-9)
    np.testing.assert_allclose(by_Z.X0, by_qr.X0, rtol=1e-9)
    np.testing.assert_allclose(by_Z.H, by_qr.H, rtol=1e-9)
    assert by_Z.vPv == pytest.approx(by_qr.vPv, rel=1e-9)
    np.testing.assert_allclose(np.diag(by_Z.Q), np.diag(by_qr.Q), rtol=1e-8)


@pytest.mark.parametrize("kinds", ["ffffff", "ffpphhhf"])
def test_small_angles(kinds: str) -> None:
    s = model_scene(generator(f"test_small_angles {kinds}"), kinds, tilt=1e-4, theta=1e-4, H=1.0001)
    found = orient_model(s.model, s.ground, known=s.known)
    by_Z, by_qr = (orient_by_small_angles(found, s.model, s.ground, known=s.known, engine=engine) for engine in Engine)
    extent = np.ptp(s.ground)
    np.testing.assert_allclose(by_Z.elements, by_qr.elements, rtol=1e-9, atol=1e-9 * 1e-4)
    np.testing.assert_allclose(np.diag(by_Z.Q), np.diag(by_qr.Q), rtol=1e-9)
    assert by_Z.vPv == pytest.approx(by_qr.vPv, rel=1e-9, abs=1e-18 * extent**2)
