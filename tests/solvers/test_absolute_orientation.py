"""Absolute orientation of scenes of known truth: every kind of control, every singular one by name."""

import numpy as np
import pytest

from orient.errors import GeometryError
from orient.geometry.rotation import rotation_exp
from orient.geometry.similarity import ground_by_homothety, matrix_from_fixed_axes, partials_homothety
from orient.solvers.absolute_orientation import orient_model
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.absolute_start import closed_form
from orient.solvers.absolute_views import element_view
from orient.solvers.functional_iteration import Termination
from tests.solvers.absolute_scenes import Scene, attitude, covariances, generator, scene


def oriented(s: Scene, **options: object) -> AbsoluteOrientation:
    return orient_model(s.model, s.ground, known=s.known, **options)


def assert_true(found: AbsoluteOrientation, s: Scene, tolerance: float = 1e-8) -> None:
    assert found.termination is Termination.CONVERGED
    np.testing.assert_allclose(found.rotation, s.rotation, atol=tolerance)
    np.testing.assert_allclose(found.H, s.H, rtol=tolerance)
    np.testing.assert_allclose(found.X0, s.X0, atol=tolerance * 1000)


@pytest.mark.parametrize(
    ("kinds", "n", "tilt"),
    [
        pytest.param("fff", 9, 0.1, id="three full"),
        pytest.param("fff", 9, 3.0, id="three full, any attitude"),
        pytest.param("ffffff", 18, 0.3, id="six full"),
        pytest.param("ffh", 7, 0.1, id="two full, one height"),
        pytest.param("pphhh", 7, 0.1, id="two plan, three heights"),
        pytest.param("pppphhh", 11, 0.5, id="four plan, three heights"),
        pytest.param("ffphh", 10, 0.4, id="mixed"),
        pytest.param("fpphh", 9, 0.4, id="one full, mixed"),
        pytest.param("fffpphh", 15, 0.9, id="three full, mixed"),
        pytest.param("ppppph", 11, 0.1, id="plan of a model with relief, one height"),
    ],
)
def test_control_of_every_kind_gives_the_truth(kinds, n, tilt, request):
    s = scene(generator(request.node.name), kinds, tilt=tilt)
    found = oriented(s, allow_upside_down=True)
    assert_true(found, s)
    assert found.n_equations == n
    assert found.redundancy == n - 7
    np.testing.assert_allclose(np.nansum(found.redundancy_numbers), n - 7, atol=1e-9)
    assert np.max(np.abs(found.residuals)) < 1e-7


@pytest.mark.parametrize("H", [1e-6, 0.3, 1.0, 1e4])
@pytest.mark.parametrize("theta", [0, 30, 60, 90, 120, 150, 180])
def test_every_scale_and_every_turn_where_zeros_and_one_fail(H, theta):
    """EQUATIONS 1.4: from angles 0 and H = 1 most of these diverge or end elsewhere."""
    s = scene(generator(f"{H} {theta}"), "ffffff", tilt=0.05, theta=np.radians(theta), H=H, X0=(12.0, -5.0, 3.0))
    assert_true(oriented(s), s, tolerance=1e-7)


def newton_from_zeros(s: Scene) -> bool:
    """Plain Newton in xi, eta, theta, H, X0 from angles 0 and H = 1; does it end at the truth?"""
    p = np.array([0.0, 0.0, 0.0, 1.0, *(s.ground.mean(axis=0) - s.model.mean(axis=0))])
    with np.errstate(all="ignore"):
        for _ in range(50):
            gap = ground_by_homothety(s.model, matrix_from_fixed_axes(*p[:3]), p[3], p[4:]) - s.ground
            design = partials_homothety(s.model, p[:3], p[3]).reshape(-1, 7)
            if not (np.isfinite(design).all() and np.isfinite(gap).all()):
                return False
            p = p - np.linalg.lstsq(design, gap.ravel(), rcond=None)[0]
    return bool(abs(p[3] - s.H) < 1e-6 * s.H and np.all(np.isfinite(p)))


@pytest.mark.parametrize(
    ("H", "theta", "low", "high"),
    [
        pytest.param(0.30, 0, 0, 10, id="H below 1/2: never"),
        pytest.param(1.00, 0, 90, 100, id="near the solution: always"),
        pytest.param(1.00, 150, 0, 20, id="large turn: hardly ever"),
        pytest.param(3.00, 60, 90, 100, id="H above 1: always"),
    ],
)
def test_zeros_are_no_safe_start(H, theta, low, high):
    """A coarse check of the table in EQUATIONS 1.4: the reason for the closed form."""
    random = generator(f"table {H} {theta}")
    solved = 0
    for _ in range(20):
        s = scene(random, "ffffff", tilt=0.05, theta=np.radians(theta), H=H, X0=(0.0, 0.0, 0.0))
        model = (s.model - s.model.mean(axis=0)) / 10
        centred = s.with_model(model)
        solved += newton_from_zeros(centred)
        assert_true(oriented(centred), centred)
    assert low <= 5 * solved <= high


def test_closed_form_is_exact():
    s = scene(generator("closed form"), "fffff", tilt=1.2)
    start = closed_form(s.model, s.ground, np.array([1.0, 2.0, 0.5, 1.0, 3.0]))
    np.testing.assert_allclose(start.rotation, s.rotation, atol=1e-9)
    np.testing.assert_allclose(start.H, s.H, rtol=1e-9)
    np.testing.assert_allclose(start.centre, s.X0, atol=1e-5)


def test_closed_form_stays_a_rotation_on_flat_and_mirrored_points():
    s = scene(generator("mirror"), "fffff")
    mirrored = closed_form(s.model * [1, 1, -1], s.ground, np.ones(5))
    np.testing.assert_allclose(np.linalg.det(mirrored.rotation), 1, atol=1e-12)


# ------------------------------------------------------------------------------------------- singular control

LINE = np.array([[0.0, 0, 0], [10, 4, 1], [20, 8, 2], [5, 2, 0.5]])
FLAT = np.array([[0.0, 0, 0], [9, 1, 0], [1, 8, 0], [7, 7, 0], [4, 2, 0], [2, 5, 0], [8, 4, 0]])
TWO_AND_BELOW = np.array([[0.0, 0, 0], [10, 4, 1], [5, 2, 3]])


@pytest.mark.parametrize(
    ("model", "kinds", "R", "words"),
    [
        pytest.param(LINE, "ffff", attitude(0.1, 2.0), "A, B, C, D lie on one line", id="line"),
        pytest.param(LINE[:3], "fff", np.eye(3), "lie on one line", id="three on a line"),
        pytest.param(LINE, "ffph", attitude(0.1, 2.0), "lie on one line", id="line with plan and height on it"),
        pytest.param(TWO_AND_BELOW, "ffh", attitude(0.0, 2.0), "vertical plane through A, B", id="vertical plane"),
        pytest.param(FLAT[:6], "ppppph", attitude(0.0, 1.0), "three heights are needed", id="flat, one height"),
        pytest.param(FLAT, "ppppphh", attitude(0.0, 1.0), "three heights are needed", id="flat, two heights"),
        pytest.param(
            np.vstack([FLAT[:2], np.add(LINE[:3], [3, 5, 0])]),
            "pphhh",
            attitude(0.0, 1.0),
            "C, D, E, lie on one line",
            id="heights on a line",
        ),
    ],
)
@pytest.mark.parametrize("noise", [0.0, 1e-9], ids=["exact", "rounded"])
def test_singular_control_is_named(model, kinds, R, words, noise):
    ground = 3.0 * model @ R.T + [1000, 2000, 300]
    ground = ground + noise * generator(words).normal(size=ground.shape)
    s = Scene(model, kinds, R, 1 / 3, np.zeros(3))
    found = orient_model(model, ground, known=s.known, names=list("ABCDEFGH"[: len(model)]))
    assert found.termination is Termination.SINGULAR
    assert not found.is_result
    assert words.lower() in found.message.lower()
    assert "1.00" in found.undetermined
    assert np.isnan(found.Q).all()


def test_the_line_is_undetermined_about_itself():
    ground = 2.0 * LINE + [1000, 2000, 300]
    found = orient_model(LINE, ground)
    along = LINE[1] / LINE[1].max()
    assert found.undetermined.startswith(f"r_X {along[0]:.2f}, r_Y {along[1]:.2f}, r_Z {along[2]:.2f} (about")


@pytest.mark.parametrize(
    ("kinds", "words"),
    [
        pytest.param("ff", "give 6 equations", id="two full"),
        pytest.param("fph", "give 6 equations", id="six equations"),
        pytest.param("ppppp", "without any height", id="no height"),
        pytest.param("hhhhhhh", "without any plan", id="no plan"),
    ],
)
def test_too_little_control_is_refused(kinds, words):
    with pytest.raises(GeometryError, match=words):
        oriented(scene(generator(kinds), kinds))


def test_numbers_that_are_none_are_refused_by_name():
    s = scene(generator("nan"), "ffff")
    model = s.model.copy()
    model[2, 1] = np.nan
    with pytest.raises(GeometryError, match="Point C has a coordinate"):
        orient_model(model, s.ground, names=list("ABCD"))


def test_one_place_is_refused():
    s = scene(generator("place"), "ffff")
    with pytest.raises(GeometryError, match="one place on the ground"):
        orient_model(s.model, np.tile([1.0, 2.0, 3.0], (4, 1)))
    with pytest.raises(GeometryError, match="one place in the model"):
        orient_model(np.tile([1.0, 2.0, 3.0], (4, 1)), s.ground)


def test_errorless_on_both_sides_is_refused_by_name():
    s = scene(generator("errorless"), "ffff")
    Q = np.tile(np.eye(3), (4, 1, 1))
    Q[1, 2, 2] = 0
    with pytest.raises(GeometryError, match="point B has no error"):
        orient_model(s.model, s.ground, ground_cofactor=Q, names=list("ABCD"))
    assert_true(orient_model(s.model, s.ground, ground_cofactor=Q, model_cofactor=np.tile(np.eye(3), (4, 1, 1))), s)


# ------------------------------------------------------------------------------------------- more than one answer


def test_two_full_and_a_height_have_two_solutions():
    s = scene(generator("two solutions"), "ffh", tilt=0.1)
    found = oriented(s)
    assert_true(found, s)
    (other,) = found.alternatives
    assert other.is_as_good
    assert other.rotation[2, 2] < found.rotation[2, 2]
    gap = s.model @ other.rotation.T / other.H + other.X0 - s.ground
    np.testing.assert_allclose(gap[:2], 0, atol=1e-6)
    np.testing.assert_allclose(gap[2, 2], 0, atol=1e-6)
    along = s.ground[1] - s.ground[0]
    np.testing.assert_allclose(other.rotation @ s.rotation.T @ along, along, atol=1e-6)


def test_two_upright_solutions_are_called_ambiguous():
    model = np.array([[-10.0, 0, 0], [10, 0, 0], [1, 3, 5]])
    R = rotation_exp([0.9, 0, 0])
    found = orient_model(model, model @ R.T, known=Scene(model, "ffh", R, 1, np.zeros(3)).known)
    assert found.is_ambiguous
    assert found.rotation[2, 2] > found.alternatives[0].rotation[2, 2] > 0


def test_a_tilted_flat_model_with_one_height_can_lean_to_either_side():
    s = scene(generator("either side"), "ppppph", tilt=0.3, relief=0.0)
    found = oriented(s)
    assert found.is_ambiguous
    rotations = [found.rotation, *(other.rotation for other in found.alternatives)]
    assert min(np.max(np.abs(R - s.rotation)) for R in rotations) < 1e-6


@pytest.mark.parametrize("kinds", ["ffffff", "ffpphhh", "pppphhhh"])
def test_exchanged_axes_are_called_mirrored(kinds):
    s = scene(generator(f"exchanged {kinds}"), kinds, tilt=0.05)
    random = generator("noise of the exchange")
    ground = s.ground[:, [1, 0, 2]] + 1e-3 * random.normal(size=s.ground.shape)
    found = orient_model(s.model, ground, known=s.known)
    assert found.is_mirrored
    assert not found.is_result
    assert "X and Y are exchanged" in found.message
    assert found.vPv_mirrored < 1e-3 * found.vPv


def test_exchanged_axes_on_flat_ground_turn_the_model_upside_down():
    s = scene(generator("flat exchange"), "ffffff", tilt=0.05, relief=0.0)
    ground = s.ground[:, [1, 0, 2]]
    found = orient_model(s.model, ground)
    assert found.is_upside_down and found.is_mirrored
    assert "upside down" in found.message
    allowed = orient_model(s.model, ground, allow_upside_down=True)
    assert allowed.is_result and allowed.is_upside_down


def test_a_model_with_relief_may_be_upside_down():
    s = scene(generator("z down"), "ffffff", tilt=3.0)
    found = oriented(s)
    assert_true(found, s)
    assert found.is_result and found.is_upside_down


# ------------------------------------------------------------------------------------------- weights and iteration


def test_iterations_lead_from_the_start_to_the_result():
    s = scene(generator("iterations"), "ffpphh", tilt=0.3)
    noisy = s.ground + 0.1 * generator("noise").normal(size=s.ground.shape)
    found = orient_model(s.model, noisy, known=s.known)
    assert len(found.iterations) >= 2
    for one, following in zip(found.iterations[:-1], found.iterations[1:], strict=True):
        turned = rotation_exp(one.correction_rotation) @ one.rotation
        np.testing.assert_allclose(turned, following.rotation, atol=1e-12)
        np.testing.assert_allclose(one.H + one.correction_H, following.H, rtol=1e-12)
        np.testing.assert_allclose(one.X0 + one.correction_X0, following.X0, atol=1e-6)
        assert following.vPv <= one.vPv * (1 + 1e-9)
    assert found.iterations[-1].max_scaled_step <= 1e-10


def test_tolerance_and_iterations_are_obeyed():
    s = scene(generator("limits"), "ppphhh", tilt=0.6)
    found = orient_model(s.model, s.ground, known=s.known, max_iterations=1)
    assert found.termination in (Termination.MAX_ITERATIONS, Termination.SINGULAR)
    assert not found.is_result


def test_a_free_point_does_not_matter():
    """A cofactor a million million times larger takes a point out, in the start as in the end."""
    random = generator("free point")
    s = scene(random, "ffffff")
    ground = s.ground + 0.01 * random.normal(size=(6, 3))
    wrong = ground.copy()
    wrong[3] += [500.0, -800.0, 300.0]
    Q = np.tile(np.eye(3), (6, 1, 1))
    Q[3] *= 1e16
    without = np.arange(6) != 3
    full = orient_model(s.model, wrong, ground_cofactor=Q)
    less = orient_model(s.model[without], ground[without])
    np.testing.assert_allclose(full.rotation, less.rotation, atol=1e-8)
    np.testing.assert_allclose(full.X0, less.X0, atol=1e-4)
    np.testing.assert_allclose(full.redundancy_numbers[3], 1, atol=1e-8)


def test_full_cofactors_of_independent_points_are_the_blocks():
    random = generator("full cofactors")
    s = scene(random, "fffpphh")
    ground = s.ground + 0.05 * random.normal(size=s.ground.shape)
    Q_G, Q_x = covariances(random, 7, 1.0), covariances(random, 7, 0.1)
    blocks = orient_model(s.model, ground, known=s.known, ground_cofactor=Q_G, model_cofactor=Q_x)
    for first, second in [(full(Q_G), full(Q_x)), (Q_G, full(Q_x)), (full(Q_G), Q_x)]:
        dense = orient_model(s.model, ground, known=s.known, ground_cofactor=first, model_cofactor=second)
        np.testing.assert_allclose(dense.Q, blocks.Q, rtol=1e-6)
        np.testing.assert_allclose(dense.X0, blocks.X0, atol=1e-7)
        np.testing.assert_allclose(dense.model_residuals, blocks.model_residuals, atol=1e-8)
        np.testing.assert_allclose(dense.ground_residuals, blocks.ground_residuals, atol=1e-8)
        np.testing.assert_allclose(dense.redundancy_numbers, blocks.redundancy_numbers, atol=1e-7)
        np.testing.assert_allclose(dense.elements_with_model, blocks.elements_with_model, atol=1e-7)


def full(Q: np.ndarray) -> np.ndarray:
    n = len(Q)
    matrix = np.zeros((n, 3, n, 3))
    matrix[np.arange(n), :, np.arange(n), :] = Q
    return matrix.reshape(3 * n, 3 * n)


def test_errors_of_both_sides_are_adjusted_rigorously():
    """Against an adjustment with the model coordinates as unknowns; the adjusted points satisfy the similarity."""
    random = generator("both sides")
    s = scene(random, "ffffpphhh", tilt=0.4, H=0.5)
    n = len(s.model)
    Q_G, Q_x = covariances(random, n, 1.0), covariances(random, n, 0.5)
    ground = s.ground + np.einsum("nij,nj->ni", np.linalg.cholesky(Q_G), random.normal(size=(n, 3))) * 0.1
    model = s.model + np.einsum("nij,nj->ni", np.linalg.cholesky(Q_x), random.normal(size=(n, 3))) * 0.1
    found = orient_model(model, ground, known=s.known, ground_cofactor=Q_G, model_cofactor=Q_x)
    adjusted = (model + found.model_residuals) @ found.rotation.T / found.H + found.X0
    gap = s.known @ (adjusted - ground - found.ground_residuals)[:, :, None]
    np.testing.assert_allclose(gap, 0, atol=1e-7)
    R, H, X0, vPv, Q = brute(found, model, ground, s.known, Q_G, Q_x)
    np.testing.assert_allclose(found.rotation, R, atol=1e-9)
    np.testing.assert_allclose([found.H, *found.X0], [H, *X0], rtol=1e-9)
    np.testing.assert_allclose(found.vPv, vPv, rtol=1e-9)
    np.testing.assert_allclose(np.sqrt(np.diag(found.Q)), np.sqrt(np.diag(Q)), rtol=1e-5)


def brute(found, model, ground, known, Q_G, Q_x):
    """Gauss-Newton in 7 + 3n unknowns with explicit observations of both sides."""
    n = len(model)
    R, H, X0, x = found.rotation, found.H, found.X0, model.copy()
    weight_G = np.linalg.pinv(known @ Q_G @ known, rcond=1e-10)
    roots = [
        np.linalg.cholesky(W + 1e-12 * np.eye(3) * np.trace(W)).T @ K for W, K in zip(weight_G, known, strict=True)
    ]
    whiten_x = np.linalg.inv(np.linalg.cholesky(Q_x))
    for _ in range(20):
        design, free = np.zeros((6 * n, 7 + 3 * n)), np.zeros(6 * n)
        for i in range(n):
            q = R @ x[i] / H
            turn = [[0, q[2], -q[1]], [-q[2], 0, q[0]], [q[1], -q[0], 0]]
            B = np.column_stack([turn, -q / H, np.eye(3)])
            own = slice(7 + 3 * i, 10 + 3 * i)
            design[6 * i : 6 * i + 3, :7] = roots[i] @ B
            design[6 * i : 6 * i + 3, own] = roots[i] @ R / H
            free[6 * i : 6 * i + 3] = roots[i] @ (q + X0 - ground[i])
            design[6 * i + 3 : 6 * i + 6, own] = whiten_x[i]
            free[6 * i + 3 : 6 * i + 6] = whiten_x[i] @ (x[i] - model[i])
        scales = np.linalg.norm(design, axis=0)
        step = -np.linalg.lstsq(design / scales, free, rcond=None)[0] / scales
        R, H, X0, x = rotation_exp(step[:3]) @ R, H + step[3], X0 + step[4:7], x + step[7:].reshape(n, 3)
    N = np.linalg.inv((design / scales).T @ (design / scales)) / np.outer(scales, scales)
    return R, H, X0, float(free @ free), N[:7, :7]


def test_unit_weights_are_the_normal_equations_of_seed_000():
    """Q of form (2') is (B'B)^-1 with the printed partials."""
    random = generator("normal equations")
    s = scene(random, "ffffff", X0=(12.0, -5.0, 3.0))
    found = orient_model(s.model, s.ground + 0.01 * random.normal(size=(6, 3)))
    view = element_view(found, "homothety")
    B = partials_homothety(s.model, view.values[:3], found.H).reshape(-1, 7)
    np.testing.assert_allclose(view.Q, np.linalg.inv(B.T @ B), rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(B.T @ found.residuals.ravel(), 0, atol=1e-6)
    np.testing.assert_allclose(found.vPv, np.sum(found.residuals**2), rtol=1e-10)
    np.testing.assert_allclose(found.sigma0, np.sqrt(np.sum(found.residuals**2) / 11), rtol=1e-10)
    np.testing.assert_array_equal(found.model_residuals, 0)
    np.testing.assert_allclose(found.ground_residuals, found.residuals, atol=1e-12)


def test_arguments_are_not_written():
    s = scene(generator("arguments"), "fffph")
    model, ground, known = s.model.copy(), s.ground.copy(), s.known.copy()
    orient_model(model, ground, known=known)
    np.testing.assert_array_equal(model, s.model)
    np.testing.assert_array_equal(ground, s.ground)
    np.testing.assert_array_equal(known, s.known)


def test_slanted_verticals_carry_plan_and_height():
    """Directions of plan and height may differ from point to point, as verticals on a curved Earth do."""
    random = generator("verticals")
    s = scene(random, "ffpphhh", tilt=0.2)
    up = np.array([0.0, 0, 1]) + 0.05 * random.normal(size=(7, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    vertical = up[:, :, None] * up[:, None, :]
    known = np.array([{"f": np.eye(3), "p": np.eye(3) - V, "h": V}[k] for k, V in zip(s.kinds, vertical, strict=True)])
    moved = s.ground + ((np.eye(3) - known) @ (100 * random.normal(size=(7, 3, 1))))[:, :, 0]
    assert_true(orient_model(s.model, moved, known=known), s)
