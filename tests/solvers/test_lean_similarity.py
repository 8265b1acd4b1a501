"""The closed form and the full adjustment of `absolute` have the same optimum and the same cofactors."""

import numpy as np
import pytest

from orient.errors import GeometryError
from orient.geometry.rotation import rotation_exp
from orient.solvers.absolute_orientation import orient_model
from orient.solvers.lean_similarity import POINTS_AT_ONCE, _Scene, lean_similarity
from tests.solvers.absolute_scenes import FloatArray, Scene, generator, scene

SIZES = {"three points": 3, "a few": 8, "more than one part": POINTS_AT_ONCE + 100}


def noisy(s: Scene, sigma_m: float) -> FloatArray:
    return s.ground + generator("noise").normal(0.0, sigma_m, s.ground.shape)


def assert_same(model: FloatArray, ground: FloatArray, weights: FloatArray | None) -> None:
    """X0 to the digits of 4e6 m, seven elements to 1e-8 of their sigma where rounding allows, Q to 1e-9 of sigmas."""
    lean = lean_similarity(model, ground, weights)
    Q_G = None if weights is None else np.eye(3) / weights[:, None, None]
    full = orient_model(model, ground, ground_cofactor=Q_G, allow_upside_down=True)
    assert lean.redundancy == full.redundancy
    np.testing.assert_allclose(lean.X0, full.X0, rtol=0, atol=1e-8)
    np.testing.assert_allclose(lean.rotation, full.rotation, rtol=0, atol=3e-14)
    assert pytest.approx(full.H, rel=1e-13) == lean.H
    assert lean.vPv == pytest.approx(full.vPv, rel=1e-9)
    sigma = np.sqrt(np.diag(full.Q))
    np.testing.assert_allclose(lean.Q / np.outer(sigma, sigma), full.Q / np.outer(sigma, sigma), rtol=0, atol=1e-9)


@pytest.mark.parametrize("is_weighted", [False, True], ids=["equal weights", "own weights"])
@pytest.mark.parametrize("size", SIZES)
def test_the_optimum_and_the_cofactors_of_the_stage(size: str, is_weighted: bool) -> None:
    random = generator(f"{size} {is_weighted}")
    s = scene(random, "f" * SIZES[size], tilt=0.4)
    weights = random.uniform(0.2, 5.0, SIZES[size]) if is_weighted else None
    assert_same(s.model, noisy(s, 0.3), weights)


@pytest.mark.parametrize("theta", [0.0, 2.0, 3.1])
@pytest.mark.parametrize("tilt", [0.0, 1.5, 3.1])
def test_any_attitude(tilt: float, theta: float) -> None:
    """Also upside down; 20 points within 20 m of noise 1 cm: 1e-9 m of the optimum."""
    s = scene(generator("attitude"), "f" * 20, tilt=tilt, theta=theta, H=0.8, X0=(3.0, 2.0, 1.0))
    assert_same(s.model, noisy(s, 0.01), None)


@pytest.mark.parametrize("which", ["model", "ground", "both"])
def test_products_of_points_far_from_the_mean(which: str) -> None:
    """Squares about the mean would lose twelve digits of the few points that count."""
    random, weights = generator("products"), np.repeat([1.0, 1e-22], [12, 300])
    model, ground = random.uniform(-1, 1, (2, 312, 3))
    expected = _Scene(model[:12], ground[:12], None).products()
    model[12:] += 1e6 * (which != "ground")
    ground[12:] += 1e6 * (which != "model")
    for found, right in zip(_Scene(model, ground, weights).products(), expected, strict=True):
        np.testing.assert_allclose(found, right, rtol=0, atol=1e-6)


@pytest.mark.parametrize("compiled", [False, True])
def test_nearly_all_the_weight_far_from_the_mean(compiled: bool) -> None:
    if compiled:
        pytest.importorskip("orient.solvers.ground_kernel", reason="numba is not installed: orient[fast]")
    random = generator("few count")
    model = random.uniform(-1, 1, (312, 3))
    model[12:, 0] += 1e6
    expected = lean_similarity(model[:12], 2.0 * model[:12])
    found = lean_similarity(model, 2.0 * model, np.repeat([1.0, 1e-22], [12, 300]), compiled=compiled)
    np.testing.assert_allclose(found.Q_centred, expected.Q_centred, rtol=0, atol=1e-7 * np.max(expected.Q_centred))
    np.testing.assert_allclose(found.model_centre, expected.model_centre, rtol=0, atol=1e-12)


def test_flat_points() -> None:
    s = scene(generator("flat"), "f" * 9, relief=0.0)
    assert_same(s.model, noisy(s, 0.05), None)


def test_without_noise_the_step_leaves_a_nanometre() -> None:
    """100 km of ground, 500 km from the origin."""
    s = scene(generator("exact"), "f" * 50, H=2e-4, X0=(0.0, 0.0, 0.0))
    found = lean_similarity(s.model, s.ground)
    back = found.X0 + s.model @ found.rotation.T / found.H
    assert np.max(np.abs(back - s.ground)) < 2e-9
    assert found.sigma0 is not None and found.sigma0 < 1e-9


def test_cofactors_are_those_of_a_simulation() -> None:
    """400 draws: variances within 5 sigma = 5 sqrt(2/400) of the predicted ones."""
    s, random = scene(generator("draws"), "f" * 10, X0=(100.0, 200.0, 30.0)), generator("draws of noise")
    Q = lean_similarity(s.model, s.ground).Q
    draws = [lean_similarity(s.model, s.ground + random.normal(0.0, 0.01, (10, 3))) for _ in range(400)]
    spread = np.var([[found.H, *found.X0] for found in draws], axis=0) / 0.01**2
    np.testing.assert_allclose(spread, np.diag(Q)[3:], rtol=5 * np.sqrt(2 / 400))


def test_a_mirrored_model_is_said_to_be_one() -> None:
    s = scene(generator("mirrored"), "f" * 12)
    mirrored = lean_similarity(s.model * [1.0, -1.0, 1.0], noisy(s, 0.01))
    assert mirrored.is_mirrored
    assert mirrored.vPv_mirrored == pytest.approx(lean_similarity(s.model, noisy(s, 0.01)).vPv, rel=1e-3)
    assert not lean_similarity(s.model, noisy(s, 0.01)).is_mirrored


@pytest.mark.parametrize("size", [0.0, 1.0], ids=["one place", "a line"])
def test_points_on_a_line_are_refused(size: float) -> None:
    line = size * np.arange(5.0)[:, None] * [1.0, 2.0, 3.0] + [7.0, 5.0, 3.0]
    with pytest.raises(GeometryError, match="one line"):
        lean_similarity(line, line)


def test_turning_and_scaling_the_ground_moves_the_answer_with_it() -> None:
    s, turn = scene(generator("moved"), "f" * 15, X0=(50.0, 40.0, 30.0)), rotation_exp([0.3, -2.0, 1.0])
    ground = noisy(s, 0.2)
    before, after = lean_similarity(s.model, ground), lean_similarity(s.model, 3.0 * ground @ turn.T + [5.0, 6.0, 7.0])
    np.testing.assert_allclose(after.rotation, turn @ before.rotation, rtol=0, atol=1e-13)
    assert pytest.approx(before.H / 3.0, rel=1e-12) == after.H
    np.testing.assert_allclose(after.X0, 3.0 * turn @ before.X0 + [5.0, 6.0, 7.0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("is_weighted", [False, True], ids=["equal weights", "own weights"])
def test_the_compiled_sums_are_the_same(is_weighted: bool) -> None:
    pytest.importorskip("orient.solvers.ground_kernel", reason="numba is not installed: orient[fast]")
    s = scene(generator("compiled"), "f" * 500)
    weights, ground = generator("weights").uniform(0.2, 5.0, 500) if is_weighted else None, noisy(s, 0.3)
    model = np.asfortranarray(s.model)
    plain, compiled = (lean_similarity(model, ground, weights, compiled=choice) for choice in (False, True))
    np.testing.assert_allclose(compiled.X0, plain.X0, rtol=0, atol=1e-8)
    np.testing.assert_allclose(compiled.rotation, plain.rotation, rtol=0, atol=3e-14)
    np.testing.assert_allclose([compiled.H, compiled.vPv], [plain.H, plain.vPv], rtol=1e-9)
    np.testing.assert_allclose(compiled.Q, plain.Q, rtol=1e-9, atol=1e-9 * np.max(plain.Q))
