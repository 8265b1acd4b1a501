"""Moving, turning and scaling the model or the ground moves the elements with it; the order does not matter."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orient.geometry.rotation import rotation_exp
from orient.solvers.absolute_orientation import orient_model
from orient.solvers.absolute_points import ground_points
from orient.solvers.absolute_views import element_view
from tests.solvers.absolute_scenes import covariances, generator, scene

RANDOM = generator("test_absolute_properties")
KINDS = "fffppphh"
SCENE = scene(RANDOM, KINDS, tilt=0.3, X0=(30.0, -20.0, 10.0))
Q_G, Q_x = covariances(RANDOM, 8, 0.05), covariances(RANDOM, 8, 0.02)
GROUND = SCENE.ground + 0.03 * RANDOM.normal(size=(8, 3))
BASE = orient_model(SCENE.model, GROUND, known=SCENE.known, ground_cofactor=Q_G, model_cofactor=Q_x)

shifts = st.tuples(*[st.floats(-1e6, 1e6)] * 3).map(np.array)
turns = st.tuples(*[st.floats(-3, 3)] * 3).map(np.array)
scales = st.floats(-3, 3).map(lambda power: 10.0**power)
profile = settings(max_examples=15, deadline=None, derandomize=True)


@profile
@given(shift=shifts, turn=turns, scale=scales)
def test_the_elements_move_with_the_model(shift, turn, scale):
    """x' = s U x + d: R' = R U', H' = s H, X0' = X0 - R' d / H'; v'Pv stays."""
    U = rotation_exp(turn)
    model = scale * SCENE.model @ U.T + shift
    Q = scale**2 * U @ Q_x @ U.T
    found = orient_model(
        model, GROUND, known=SCENE.known, ground_cofactor=Q_G, model_cofactor=Q, allow_upside_down=True
    )
    rounding = 1e-8 + 1e-10 * float(np.max(np.abs(shift))) / scale
    np.testing.assert_allclose(found.rotation, BASE.rotation @ U.T, atol=rounding)
    np.testing.assert_allclose(found.H, scale * BASE.H, rtol=rounding)
    np.testing.assert_allclose(found.ground_centre, BASE.ground_centre, atol=1e3 * rounding)
    np.testing.assert_allclose(found.vPv, BASE.vPv, rtol=1e-5 + 100 * rounding)
    np.testing.assert_allclose(np.diag(found.Q_centred), np.diag(BASE.Q_centred), rtol=1e-4 + 100 * rounding)


@profile
@given(shift=shifts, turn=st.floats(-3, 3), scale=scales)
def test_the_elements_move_with_the_ground(shift, turn, scale):
    """P' = s U P + d, U about the vertical: R' = U R, H' = H/s, X0' = s U X0 + d."""
    U = rotation_exp([0.0, 0.0, turn])
    ground = scale * GROUND @ U.T + shift
    found = orient_model(
        SCENE.model,
        ground,
        known=U @ SCENE.known @ U.T,
        ground_cofactor=scale**2 * U @ Q_G @ U.T,
        model_cofactor=Q_x,
    )
    rounding = 1e-8 + 1e-10 * float(np.max(np.abs(shift))) / scale
    np.testing.assert_allclose(found.rotation, U @ BASE.rotation, atol=rounding)
    np.testing.assert_allclose(found.H, BASE.H / scale, rtol=rounding)
    np.testing.assert_allclose(found.X0, scale * U @ BASE.X0 + shift, atol=1e3 * rounding * scale)
    J = np.eye(7)
    J[:3, :3], J[3, 3], J[4:, 4:] = U, 1 / scale, scale * U
    np.testing.assert_allclose(np.diag(found.Q), np.diag(J @ BASE.Q @ J.T), rtol=1e-4 + 100 * rounding)


@profile
@given(order=st.permutations(range(8)))
def test_the_order_of_the_points_does_not_matter(order):
    found = orient_model(
        SCENE.model[order],
        GROUND[order],
        known=SCENE.known[order],
        ground_cofactor=Q_G[order],
        model_cofactor=Q_x[order],
    )
    np.testing.assert_allclose(found.rotation, BASE.rotation, atol=1e-9)
    np.testing.assert_allclose(found.X0, BASE.X0, atol=1e-7)
    np.testing.assert_allclose(found.residuals, BASE.residuals[order], atol=1e-8)
    np.testing.assert_allclose(found.redundancy_numbers, BASE.redundancy_numbers[order], atol=1e-8)


@profile
@given(factor=st.floats(1e-4, 1e4))
def test_the_unit_of_weight_does_not_matter(factor):
    found = orient_model(
        SCENE.model, GROUND, known=SCENE.known, ground_cofactor=factor * Q_G, model_cofactor=factor * Q_x
    )
    np.testing.assert_allclose(found.X0, BASE.X0, atol=1e-7)
    np.testing.assert_allclose(found.vPv * factor, BASE.vPv, rtol=1e-7)
    np.testing.assert_allclose(found.Q / factor, BASE.Q, rtol=1e-6, atol=1e-12)


@profile
@given(seed=st.integers(0, 10**6), tilt=st.floats(0, 0.6), H=scales, kinds=st.sampled_from(["ffpph", "pphhhh", "ffhh"]))
def test_exact_control_is_oriented_exactly(seed, tilt, H, kinds):
    s = scene(np.random.default_rng(seed), kinds, tilt=tilt, H=H)
    found = orient_model(s.model, s.ground, known=s.known)
    if found.condition_ratio < 1e-3 or found.redundancy == 0:
        return
    extent = np.ptp(s.ground, axis=0).max()
    assert found.is_result
    assert np.max(np.abs(found.residuals)) <= 1e-6 * extent + 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("kinds", ["fffff", "fffpphh"])
def test_the_simulated_spread_agrees_with_Q(kinds):
    """Errors of both sides, 10 000 runs: elements, ground points (control and new ones), v'Pv against their theory."""
    runs, n = 10_000, len(kinds)
    random = generator(f"spread {kinds}")
    s = scene(random, kinds, tilt=0.3, X0=(30.0, -20.0, 10.0))
    G, x = covariances(random, n, 0.02), covariances(random, n, 0.004)
    root_G, root_x = np.linalg.cholesky(G), np.linalg.cholesky(x)
    points = np.vstack([s.model, np.add(s.model[:2], [5.0, -3.0, 1.0])])
    own = np.concatenate([x, np.zeros((2, 3, 3))])
    control = [*range(n), None, None]
    elements, places, vPv = [], [], []
    for _ in range(runs):
        model = s.model + (root_x @ random.normal(size=(n, 3, 1)))[:, :, 0]
        ground = s.ground + (root_G @ random.normal(size=(n, 3, 1)))[:, :, 0]
        found = orient_model(model, ground, known=s.known, ground_cofactor=G, model_cofactor=x)
        observed = np.vstack([model, points[n:]])
        elements.append(element_view(found, "homothety").values)
        places.append(ground_points(found, observed)[0])
        vPv.append(found.vPv)
    truth = orient_model(s.model, s.ground, known=s.known, ground_cofactor=G, model_cofactor=x)
    sigma = element_view(truth, "homothety").standard_deviations(1.0)
    np.testing.assert_allclose(np.std(elements, axis=0), sigma, rtol=0.03)
    _, Q = ground_points(truth, points, own, control)
    predicted = np.sqrt(np.diagonal(Q, axis1=1, axis2=2))
    np.testing.assert_allclose(np.std(places, axis=0), predicted, rtol=0.03)
    np.testing.assert_allclose(np.mean(vPv), truth.redundancy, rtol=0.1)
