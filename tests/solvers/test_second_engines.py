"""The second engines find the same adjustment as the program's own solvers, by other formulas and other algorithms."""

import numpy as np
import pytest

from orient.geometry import plane
from orient.geometry.polynomial import exponents
from orient.solvers.common_unknowns import CommonUnknowns
from orient.solvers.independent_plane import fit_plane
from orient.solvers.independent_polynomial import fit_in_legendre
from orient.solvers.independent_resection import ResectionObservations, solve_independently
from orient.solvers.interior_orientation import fit_interior
from orient.solvers.polynomial_degree import Crosses, Rule
from orient.solvers.polynomial_fit import fit_sheet
from orient.solvers.resection import resect
from orient.solvers.resection_simulation import Spread, simulate_resection
from tests.solvers.resection_scenes import FloatArray, Scene, generator, looking, scene

SIGMA_MM = 0.005
SIGMA_M = 0.05
MILLIONTH = 1e-6


def observed(name: str) -> tuple[Scene, ResectionObservations]:
    """Twelve points of every kind: without error, weighted, plan-only, height-only, on a sheet with common errors.

    The film is uncertain in its place and its scale, by as much as a reading.
    """
    random = generator(name)
    view = scene(random, n=12, rotation=looking(0.4, 0.3, 1.0), relief=0.2)
    up = np.array([0.0, 0.0, 1.0])
    free, weight = np.zeros((12, 3, 3)), np.zeros((12, 3, 3))
    free[4:8], weight[4:8] = np.eye(3), np.eye(3) * (SIGMA_MM / SIGMA_M) ** 2
    free[8:10] = np.outer(up, up)
    free[10:] = np.eye(3) - np.outer(up, up)
    partials, by_image = np.zeros((12, 3, 4)), np.zeros((12, 2, 4))
    partials[5:9, 0, 0], partials[5:9, 1, 1] = 1.0, random.uniform(0.5, 2.0, 4)
    by_image[:, 0, 2], by_image[:, :, 3] = 1.0, view.image / 100.0
    cofactor = np.diag([0.04 / SIGMA_MM**2, 0.09 / SIGMA_MM**2, 2.0, 2.0])
    common = CommonUnknowns(partials, cofactor, ("c1", "c2", "a0", "a1"), by_image)
    image = view.noisy(SIGMA_MM, random)
    ground = view.ground + (weight[:, :1, 0] > 0) * random.normal(size=(12, 3)) * SIGMA_M
    return view, ResectionObservations(image, view.unit, ground, view.f_mm, free, weight, common)


def test_resection_with_points_of_every_kind() -> None:
    view, given = observed("every kind")
    full = np.arange(12) < 8
    found = resect(
        given.image, given.image_cofactor, given.ground, given.f_mm, ground_free=given.free,
        ground_weight=given.weight, common=given.common, start_mask=full,
    )  # fmt: skip
    other = solve_independently(given, found.station, found.rotation)
    assert found.termination == "CONVERGED" and other.converged
    assert (given.n_equations, given.n_unknowns) == (found.n_equations, found.n_unknowns)
    sigma = np.sqrt(found.vPv / found.redundancy * np.diag(found.Q))
    assert np.max(np.abs(other.station - found.station) / sigma[3:]) < MILLIONTH
    assert np.max(np.abs(other.rotation - found.rotation)) < MILLIONTH * np.min(sigma[:3])
    assert other.vPv == pytest.approx(found.vPv, rel=1e-9)
    scale = np.sqrt(np.outer(np.diag(found.Q), np.diag(found.Q)))
    assert np.max(np.abs(other.Q - found.Q) / scale) < MILLIONTH
    assert np.linalg.norm(other.station - view.station) < 1.0


@pytest.mark.parametrize("n", [20, 300])
def test_it_goes_to_the_end_where_vPv_is_flat(n: int) -> None:
    """v'Pv alone does not tell a place 1e-6 sigma from the minimum: three of ten scenes need the last linear step."""
    for number in range(10):
        random = generator(f"many {n} {number}")
        view = scene(random, n=n, rotation=looking(0.4, 0.3, 1.0), relief=0.2)
        image = view.noisy(SIGMA_MM, random)
        found = resect(image, view.unit, view.ground, view.f_mm)
        given = ResectionObservations(image, view.unit, view.ground, view.f_mm)
        other = solve_independently(given, found.station, found.rotation)
        sigma = np.sqrt(found.vPv / found.redundancy * np.diag(found.Q))
        assert np.max(np.abs(other.station - found.station) / sigma[3:]) < 1e-8
        assert np.max(np.abs(other.rotation - found.rotation)) < 1e-8 * np.min(sigma[:3])


def test_a_station_that_is_not_the_solution_is_not_confirmed() -> None:
    """The second engine starts next to what it is told, and must leave it."""
    view, given = observed("moved")
    near, far = (solve_independently(given, view.station + shift, view.rotation) for shift in (0.0, 5.0))
    sigma = SIGMA_MM * np.sqrt(np.diag(near.Q))[3:]
    assert np.max(np.abs(far.station - near.station) / sigma) < MILLIONTH
    assert np.max(np.abs(far.station - view.station - 5.0) / sigma) > 10


@pytest.mark.parametrize("transformation", plane.PARAMETER_NAMES)
@pytest.mark.parametrize("is_mirrored", [False, True])
def test_interior_orientation(transformation: str, is_mirrored: bool) -> None:
    random = generator(f"{transformation} {is_mirrored}")
    marks = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, -1.05], [1.05, 0], [0, 1.05], [-1.05, 0]]) * 113.0
    measured = marks * [-1.0 if is_mirrored else 1.0, 1.0] + [150.0, 140.0] + random.normal(size=marks.shape) * 0.004
    measured += 2e-6 * measured * measured[:, :1]
    own = fit_interior(measured, marks, transformation)
    other = fit_plane(measured, marks, transformation)
    assert own.sigmas is not None
    gap = np.array([other.parameters[name] for name in own.names]) - own.parameters
    assert np.max(np.abs(gap) / own.sigmas) < MILLIONTH
    assert other.vv == pytest.approx(float(np.sum(own.residuals**2)), rel=1e-9)
    np.testing.assert_allclose(np.diag(other.cofactor), np.diag(own.cofactor), rtol=1e-6)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5])
def test_sheet_polynomial(degree: int) -> None:
    random = generator(f"sheet {degree}")
    X, Y = np.meshgrid(np.arange(7) * 60.0, np.arange(6) * 70.0)
    XY = np.column_stack([X.ravel(), Y.ravel()]) + random.normal(size=(42, 2))
    target = np.column_stack([55 + XY[:, 1] / 1e4, 37 + XY[:, 0] / 8e3]) + random.normal(size=(42, 2)) * 1e-5
    own = fit_sheet(Crosses(XY, target, np.ones_like(target)), Rule(degree))
    other = fit_in_legendre((XY - own.centre_mm) / own.scale_mm, target, degree)
    assert own.sigma0 is not None and other.sigma0 is not None
    assert len(other.coefficients) == len(exponents(degree))
    sigma = np.sqrt(np.diag(own.cofactor))[:, None] * own.sigma0
    assert np.max(np.abs(other.coefficients - own.coefficients) / sigma) < MILLIONTH
    np.testing.assert_allclose(other.sigma0, own.sigma0, rtol=1e-8)
    scale = np.sqrt(np.outer(np.diag(own.cofactor), np.diag(own.cofactor)))
    assert np.max(np.abs(other.cofactor - own.cofactor) / scale) < 1e-9


def spread_of(given: ResectionObservations, view: Scene, n: int, seed: int = 1) -> Spread:
    return simulate_resection(given, view.station, view.rotation, view.ground, SIGMA_MM, n, seed)


def test_simulated_spread_is_that_of_Q_and_depends_on_the_seed_alone() -> None:
    view, given = observed("simulation")
    once, again, other = spread_of(given, view, 150), spread_of(given, view, 150), spread_of(given, view, 150, seed=2)
    assert (once.n, once.n_failed, once.surprises) == (150, 0, [])
    assert np.array_equal(once.simulated, again.simulated)
    assert not np.array_equal(once.simulated, other.simulated)


def test_a_spread_that_Q_does_not_predict_is_named() -> None:
    predicted: FloatArray = np.ones(2)
    spread = Spread(("r_X", "X_S"), predicted, np.array([1.0, 1.3]), n=1000, n_failed=0)
    assert spread.allowed == pytest.approx(0.03 + 4 / np.sqrt(2000))
    assert [text.split(" is ")[0] for text in spread.surprises] == ["simulated spread of X_S"]


@pytest.mark.slow
def test_ten_thousand_simulations_agree_within_3_percent() -> None:
    view, given = observed("simulation")
    spread = spread_of(given, view, 10_000)
    assert np.max(np.abs(spread.simulated / spread.predicted - 1)) < 0.03
