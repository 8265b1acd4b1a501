"""Common unknowns of a resection against one dense adjustment with the full covariance of all points."""

import time
import tracemalloc
from dataclasses import dataclass

import numpy as np
import pytest

from orient.errors import GeometryError
from orient.geometry import polynomial
from orient.geometry.collinearity import partials_rotation, project
from orient.geometry.rotation import rotation_exp
from orient.solvers.common_unknowns import CommonUnknowns, whitened
from orient.solvers.functional_iteration import Termination, cofactor_matrix, iterate
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.resection import Resection, resect
from orient.solvers.resection_problem import Orientation, ResectionProblem
from orient.solvers.resection_result import Refined
from tests.solvers.resection_scenes import FloatArray, Scene, generator, looking, scene

SIGMA_MM = 0.005
TERMS = 6
"""Coefficients of a polynomial of degree 2, for each of two coordinates."""


@dataclass(frozen=True)
class SheetScene:
    """Points on two sheets, then some on none; `reading` (n, 3, 3) covariance of each point's own part [m^2]."""

    scene: Scene
    partials: FloatArray
    covariance: FloatArray
    reading: FloatArray

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"c{i}" for i in range(len(self.covariance)))

    @property
    def common(self) -> CommonUnknowns:
        return CommonUnknowns(self.partials, self.covariance / SIGMA_MM**2, self.names)

    @property
    def full_covariance(self) -> FloatArray:
        """(3n, 3n) of all ground coordinates: what the solver never builds."""
        n, _, k = self.partials.shape
        G = self.partials.reshape(3 * n, k)
        full = G @ self.covariance @ G.T
        for i in range(n):
            full[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] += self.reading[i]
        return full

    def simulated(self, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """Image and ground coordinates with errors."""
        n = len(self.reading)
        c = np.linalg.cholesky(self.covariance) @ random.normal(size=len(self.covariance))
        values, axes = np.linalg.eigh(self.reading)
        roots = axes * np.sqrt(np.maximum(values, 0.0))[:, None, :]
        own = (roots @ random.normal(size=(n, 3, 1)))[:, :, 0]
        return self.scene.noisy(SIGMA_MM, random), self.scene.ground + self.partials @ c + own

    def resect(self, image: FloatArray, ground: FloatArray, **options: float) -> Resection:
        """The solver with common unknowns."""
        free, weight = free_and_weight(self.reading)
        return resect(
            image,
            self.scene.unit,
            ground,
            self.scene.f_mm,
            ground_free=free,
            ground_weight=weight,
            common=self.common,
            start_mask=np.ones(len(image), dtype=np.bool_),
            **options,  # type: ignore[arg-type]
        )

    def problem(self, image: FloatArray, ground: FloatArray, each_apart: bool = False) -> ResectionProblem:
        """The adjustment itself; `each_apart`: whole covariance of each point, but none between points."""
        shared = self.partials @ self.covariance @ self.partials.transpose(0, 2, 1) if each_apart else 0.0
        free, weight = free_and_weight(self.reading + shared)
        common = whitened(None if each_apart else self.common, len(image))
        return ResectionProblem(image, self.scene.unit, ground_knowledge(ground, free, weight), self.scene.f_mm, common)

    def adjust(self, image: FloatArray, ground: FloatArray, each_apart: bool = False) -> Refined:
        """The iteration from the truth, without the search for start values."""
        problem = self.problem(image, ground, each_apart)
        z = np.zeros(problem.common.rank)
        return iterate(problem, Orientation(self.scene.rotation, self.scene.station, ground, z))


def free_and_weight(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    values, axes = np.linalg.eigh(covariance)
    varies = values > 1e-12 * np.maximum(values[:, -1:], 1e-300)
    inverse = np.where(varies, SIGMA_MM**2 / np.where(varies, values, 1.0), 0.0)
    transposed = axes.transpose(0, 2, 1)
    return axes * varies[:, None, :] @ transposed, axes * inverse[:, None, :] @ transposed


def sheet_scene(random: np.random.Generator, n: int, alone: int = 0, common_m: float = 4.0) -> SheetScene:
    """Two sheets with polynomials of degree 2 fitted to 12 crosses each; the last `alone` points are on none."""
    s = scene(random, n=n, rotation=looking(0.7, 0.3, 1.0), relief=0.1, distance=20000.0)
    centre, extent = s.ground.mean(axis=0), np.ptp(s.ground[:, :2], axis=0).max() / 2
    uv = ((s.ground - centre) / extent)[:, :2]
    k = 4 * TERMS
    partials, covariance = np.zeros((n, 3, k)), np.zeros((k, k))
    for sheet in range(2):
        crosses = polynomial.design(*random.uniform(-1.2, 1.2, (2, 12)), 2)
        cofactor = np.linalg.inv(crosses.T @ crosses)
        on_it = np.flatnonzero(np.arange(n - alone) % 2 == sheet)
        rows = polynomial.design(*uv[on_it].T, 2)
        axes, _ = np.linalg.qr(np.eye(3) + 0.02 * random.normal(size=(3, 3)))
        # one coordinate in degrees, one in metres: the unknowns differ by five orders of magnitude
        for coordinate, metres in enumerate((111e3, 1.0)):
            span = slice((2 * sheet + coordinate) * TERMS, (2 * sheet + coordinate + 1) * TERMS)
            partials[on_it, :, span] = axes[:, coordinate][None, :, None] * rows[:, None, :] * metres
            covariance[span, span] = cofactor * (common_m / metres) ** 2
    root = np.eye(3) + 0.3 * random.normal(size=(n, 3, 3))
    return SheetScene(s, partials, covariance, 2.0 * root @ root.transpose(0, 2, 1))


@dataclass(frozen=True)
class Dense:
    station: FloatArray
    rotation: FloatArray
    Q: FloatArray
    ground: FloatArray
    Q_ground: FloatArray
    vPv: float


def dense_adjustment(sheets: SheetScene, image: FloatArray, ground: FloatArray) -> Dense:
    """f(e, P) = l + v, P ~ (ground, C): Sigma = Q_l + B C B' (2n, 2n), de = -(A' Sigma^-1 A)^-1 A' Sigma^-1 w."""
    s, n = sheets.scene, len(image)
    C = sheets.full_covariance / SIGMA_MM**2
    rotation, station, P = s.rotation, s.station, ground
    scale = np.array([1, 1, 1, 2e4, 2e4, 2e4])
    for _ in range(15):
        partials = partials_rotation(P, station, rotation, s.f_mm)
        A = partials[:, :, :6].reshape(2 * n, 6) * scale
        B = np.zeros((2 * n, 3 * n))
        for i in range(n):
            B[2 * i : 2 * i + 2, 3 * i : 3 * i + 3] = partials[i, :, 6:]
        w = (project(P, station, rotation, s.f_mm)[0] - image).ravel() + B @ (ground - P).ravel()
        half = np.linalg.cholesky(np.eye(2 * n) + B @ C @ B.T)
        A_white, w_white = np.linalg.solve(half, A), np.linalg.solve(half, w)
        Q_factor, R = np.linalg.qr(A_white)
        e = -np.linalg.solve(R, Q_factor.T @ w_white) * scale
        rest = w_white + A_white @ (e / scale)
        rotation, station = rotation_exp(e[:3]) @ rotation, station + e[3:]
        CB = np.linalg.solve(half, B @ C)
        P = ground - (CB.T @ rest).reshape(n, 3)
    inverse = np.linalg.inv(R) * scale[:, None]
    by_image = CB - Q_factor @ (Q_factor.T @ CB)
    return Dense(station, rotation, inverse @ inverse.T, P, C - CB.T @ by_image, float(rest @ rest))


def diagonal_blocks(Q: FloatArray) -> FloatArray:
    n = len(Q) // 3
    return np.array([Q[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] for i in range(n)])


def assert_close(found: FloatArray, expected: FloatArray, relative: float = 1e-9) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=relative * float(np.max(np.abs(expected))))


def assert_is_dense(found: Resection, dense: Dense) -> None:
    assert found.termination is Termination.CONVERGED
    assert_close(found.station, dense.station)
    assert_close(found.rotation, dense.rotation)
    sigma = np.sqrt(np.diag(dense.Q))
    assert_close(found.Q / np.outer(sigma, sigma), dense.Q / np.outer(sigma, sigma))
    assert_close(found.ground, dense.ground)
    assert_close(found.ground_cofactors, diagonal_blocks(dense.Q_ground))
    assert found.vPv == pytest.approx(dense.vPv, rel=1e-9)


@pytest.mark.parametrize("n", [5, 14, 40])
def test_common_unknowns_are_the_dense_adjustment(n: int) -> None:
    random = generator(f"dense {n}")
    sheets = sheet_scene(random, n, alone=2)
    image, ground = sheets.simulated(random)
    found = sheets.resect(image, ground)
    assert_is_dense(found, dense_adjustment(sheets, image, ground))
    assert found.redundancy == 2 * n - 6
    assert (found.n_equations, found.n_unknowns) == (5 * n + 24, 6 + 3 * n + 24)


def test_known_heights_and_exact_readings_leave_the_sheet_alone() -> None:
    """A point whose height has no error, and one whose reading has none: only the sheet moves it."""
    random = generator("partly exact")
    sheets = sheet_scene(random, 12)
    reading = sheets.reading.copy()
    reading[3:6, 2, :], reading[3:6, :, 2] = 0.0, 0.0
    reading[6:8] = 0.0
    partials = sheets.partials.copy()
    partials[7] = 0.0
    sheets = SheetScene(sheets.scene, partials, sheets.covariance, reading)
    image, ground = sheets.simulated(random)
    found = sheets.resect(image, ground)
    assert_is_dense(found, dense_adjustment(sheets, image, ground))
    np.testing.assert_array_equal(found.ground[7], ground[7])
    np.testing.assert_allclose(found.ground[6] - ground[6], sheets.partials[6] @ found.common, atol=1e-9)


def test_redundancy_numbers_sum_to_the_redundancy() -> None:
    random = generator("redundancy")
    sheets = sheet_scene(random, 14, alone=3)
    found = sheets.resect(*sheets.simulated(random))
    parts = found.redundancy_numbers.sum() + found.ground_redundancy.sum() + found.common_redundancy.sum()
    assert parts == pytest.approx(found.redundancy, abs=1e-9)
    assert ((found.common_redundancy > 0) & (found.common_redundancy < 1)).any()


def test_v_of_every_observation_makes_vPv_and_the_normal_equations_hold() -> None:
    random = generator("residuals")
    sheets = sheet_scene(random, 10, alone=2)
    image, ground = sheets.simulated(random)
    found = sheets.resect(image, ground)
    own = found.ground - ground - sheets.partials @ found.common
    _, weight = free_and_weight(sheets.reading)
    P_c = SIGMA_MM**2 * np.linalg.inv(sheets.covariance)
    vPv = np.sum(found.residuals**2) + np.einsum("ni,nij,nj", own, weight, own) + found.common @ P_c @ found.common
    assert found.vPv == pytest.approx(vPv, rel=1e-9)
    by_points = np.einsum("nij,ni->nj", found.equations[:, :, 6:], found.residuals)
    np.testing.assert_allclose(by_points + np.einsum("nij,nj->ni", weight, own), 0, atol=1e-9)
    gradient = np.einsum("nik,ni->k", sheets.partials, by_points) + P_c @ found.common
    sigma = np.sqrt(np.diag(sheets.covariance)) / SIGMA_MM
    np.testing.assert_allclose(gradient * sigma, 0, atol=1e-8)


def test_joint_cofactors_carry_the_ground_points() -> None:
    """cov(P_i) of a point whose own part is known: G Q_c G'; the elements' block is Q itself."""
    random = generator("joint")
    sheets = sheet_scene(random, 12)
    reading = sheets.reading.copy()
    reading[5] = 0.0
    sheets = SheetScene(sheets.scene, sheets.partials, sheets.covariance, reading)
    found = sheets.resect(*sheets.simulated(random))
    np.testing.assert_allclose(found.joint_cofactors[:6, :6], found.Q)
    of_c = found.joint_cofactors[6:, 6:]
    G = sheets.partials[5]
    np.testing.assert_allclose(found.ground_cofactors[5], G @ of_c @ G.T, rtol=1e-9, atol=1e-6)
    improved = np.diag(of_c) / np.diag(sheets.covariance / SIGMA_MM**2)
    assert (improved < 1).all()
    np.testing.assert_allclose(np.linalg.eigvalsh(scaled(found.joint_cofactors))[0] > -1e-12, True)


def scaled(Q: FloatArray) -> FloatArray:
    sigma = np.sqrt(np.diag(Q))
    return np.asarray(Q / np.outer(sigma, sigma))


def test_iterations_record_the_common_unknowns() -> None:
    random = generator("records")
    sheets = sheet_scene(random, 10)
    found = sheets.resect(*sheets.simulated(random))
    np.testing.assert_array_equal(found.iterations[0].common, 0.0)
    for step, following in zip(found.iterations, found.iterations[1:], strict=False):
        np.testing.assert_allclose(step.common + step.correction_common, following.common, atol=1e-12)
    last = found.iterations[-1]
    np.testing.assert_allclose(last.common + last.correction_common, found.common)


def test_a_tiny_covariance_is_none() -> None:
    random = generator("tiny")
    sheets = sheet_scene(random, 10)
    image, ground = sheets.simulated(random)
    tiny = SheetScene(sheets.scene, sheets.partials, sheets.covariance * 1e-24, sheets.reading)
    zero = SheetScene(sheets.scene, sheets.partials, sheets.covariance * 0.0, sheets.reading)
    free, weight = free_and_weight(sheets.reading)
    plain = resect(
        image, sheets.scene.unit, ground, sheets.scene.f_mm, ground_free=free, ground_weight=weight,
        start_mask=np.ones(10, dtype=np.bool_),
    )  # fmt: skip
    for found in (tiny.resect(image, ground), zero.resect(image, ground)):
        assert_close(found.station, plain.station)
        assert_close(found.Q, plain.Q)
        assert found.redundancy == plain.redundancy
    assert zero.resect(image, ground).n_unknowns == plain.n_unknowns
    assert zero.resect(image, ground).common_redundancy.sum() == 0


def test_unknowns_that_the_photo_cannot_improve_keep_their_covariance() -> None:
    random = generator("useless")
    sheets = sheet_scene(random, 10)
    k = len(sheets.covariance)
    partials = np.concatenate([sheets.partials, np.zeros((10, 3, 1))], axis=2)
    covariance = np.zeros((k + 1, k + 1))
    covariance[:k, :k], covariance[k, k] = sheets.covariance, 9.0
    more = SheetScene(sheets.scene, partials, covariance, sheets.reading)
    image, ground = sheets.simulated(random)
    found = more.resect(image, ground)
    assert found.common[k] == pytest.approx(0.0, abs=1e-9)
    assert found.joint_cofactors[-1, -1] == pytest.approx(9.0 / SIGMA_MM**2)
    assert found.common_redundancy[k] == pytest.approx(0.0, abs=1e-9)
    assert_close(found.Q, sheets.resect(image, ground).Q)


@pytest.mark.parametrize("spoil", [-1.0, np.nan])
def test_a_bad_covariance_is_refused(spoil: float) -> None:
    random = generator("bad")
    sheets = sheet_scene(random, 8)
    covariance = sheets.covariance.copy()
    covariance[2, 2] = spoil
    bad = SheetScene(sheets.scene, sheets.partials, covariance, sheets.reading)
    with pytest.raises(GeometryError, match="common unknowns"):
        bad.resect(sheets.scene.image, sheets.scene.ground)


def test_cost_grows_with_the_number_of_points_only() -> None:
    """10 000 points take about ten times the time and memory of 1000; their full covariance alone would take 7 GB."""
    seconds, bytes_used = [], []
    for n in (1000, 10_000):
        random = generator(f"cost {n}")
        sheets = sheet_scene(random, n)
        image, ground = sheets.simulated(random)
        runs = []
        for _ in range(3):
            begin = time.process_time()
            assert sheets.adjust(image, ground).termination is Termination.CONVERGED
            runs.append(time.process_time() - begin)
        seconds.append(min(runs))
        tracemalloc.start()
        sheets.adjust(image, ground)
        bytes_used.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert seconds[1] < 30 * seconds[0]
    assert bytes_used[1] < 11 * bytes_used[0]


@dataclass(frozen=True)
class Spread:
    """Simulated errors against what Q says. `elements` (6,), `points` (n, 3): spread / sigma; `whole`: e'Q^-1 e / 6."""

    elements: FloatArray
    points: FloatArray
    whole: float
    sigma0: float


def spread_against_Q(trials: int, each_apart: bool) -> Spread:
    random = generator("spread")
    sheets = sheet_scene(random, 24)
    truth = sheets.scene
    errors, of_points, wholes, squares = [], [], [], []
    for _ in range(trials):
        image, ground = sheets.simulated(random)
        found = sheets.adjust(image, ground, each_apart)
        Q = cofactor_matrix(found.linear)
        turned = found.state.rotation @ truth.rotation.T
        e = np.array([turned[2, 1], turned[0, 2], turned[1, 0], *(found.state.station - truth.station)]) / SIGMA_MM
        wholes.append(e @ np.linalg.solve(Q, e) / 6)
        errors.append(e / np.sqrt(np.diag(Q)))
        Q_P = sheets.problem(image, ground, each_apart).quality(found.state, found.linear, Q).Q_P
        of_points.append((found.state.ground - truth.ground) / np.sqrt(np.diagonal(Q_P, axis1=1, axis2=2)) / SIGMA_MM)
        squares.append(found.linear.vPv / SIGMA_MM**2)
    rms = [np.sqrt(np.mean(np.square(values), axis=0)) for values in (errors, of_points)]
    return Spread(rms[0], rms[1], float(np.mean(wholes)), float(np.sqrt(np.mean(squares) / (2 * 24 - 6))))


def test_simulated_spread_agrees_with_Q() -> None:
    """Spread / sigma is 1 with common unknowns, for elements and adjusted points, and so is sigma0.

    With the same covariance of every point but none between points it is 1.31 to 1.36 for the elements, 1.2 on average
    and up to 1.5 for the points (sigmas a quarter too small), e'Q^-1 e / 6 = 1.9; and sigma0 = 0.95 gives no warning.
    """
    together, apart = spread_against_Q(150, each_apart=False), spread_against_Q(150, each_apart=True)
    np.testing.assert_allclose(together.elements, 1.0, atol=0.2)
    assert together.whole == pytest.approx(1.0, abs=0.15)
    assert together.sigma0 == pytest.approx(1.0, abs=0.05)
    np.testing.assert_allclose(together.points, 1.0, atol=0.25)
    assert (apart.elements > 1.2).all()
    assert apart.whole > 1.6
    assert apart.sigma0 < 1.0


@pytest.mark.slow
def test_10_000_runs_agree_with_Q_within_3_percent() -> None:
    found = spread_against_Q(10_000, each_apart=False)
    np.testing.assert_allclose(found.elements, 1.0, atol=0.03)
    np.testing.assert_allclose(found.points, 1.0, atol=0.03)
    assert found.whole == pytest.approx(1.0, abs=0.03)
    assert found.sigma0 == pytest.approx(1.0, abs=0.01)
