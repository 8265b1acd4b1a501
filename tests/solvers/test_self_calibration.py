"""Resection with an unknown camera: scenes of known truth, priors, known elements, what cannot be separated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest

from orient.geometry.camera import INTERIOR, Camera, Measured
from orient.geometry.collinearity import project
from orient.geometry.distortion import Distortion, distort
from orient.geometry.rotation import opk_by_rotation, opk_from_matrix, rotation_exp
from orient.solvers import resection
from orient.solvers.camera_unknowns import CameraUnknowns, separability
from orient.solvers.element_observations import ElementObservation, along
from orient.solvers.engines import Engine
from orient.solvers.functional_iteration import Termination
from orient.solvers.ground_points import ground_knowledge
from orient.solvers.resection import Resection, resect
from orient.solvers.resection_problem import Orientation, ResectionProblem
from tests.jacobian import central_difference
from tests.solvers.resection_scenes import FloatArray, generator, looking

F, SIGMA = 150.0, 0.005
S_TRUE = np.array([500.0, -300.0, 2000.0])
TRUE = {
    "f": F, "x0": 0.12, "y0": -0.08, "k1": 4e-7, "k2": -1e-11, "k3": 2e-16, "p1": 2e-6, "p2": -3e-6, "b1": 2e-4,
    "b2": -1e-4,
}  # fmt: skip
OPENCV = {**TRUE, "k1": 0.01, "k2": -0.006, "k3": 0.003, "p1": 3e-4, "p2": -4e-4}
DIRECTIONS = ("correction", "displacement", "ideal_to_distorted", "opencv")


@dataclass(frozen=True)
class Scene:
    """Readings of a frame camera over hilly ground, and what is true."""

    truth: Camera
    measured: Measured
    ground: FloatArray
    rotation: FloatArray
    station: FloatArray

    def unknowns(self, names: Sequence[str], start: Camera, sigmas: dict[str, float] | None = None) -> CameraUnknowns:
        cofactors = [((sigmas or {}).get(name, np.inf) / SIGMA) ** 2 for name in names]
        return CameraUnknowns(tuple(names), start, self.measured, np.array(cofactors))

    def resect(self, unknowns: CameraUnknowns, **options: object) -> Resection:
        image = self.measured.frame - unknowns.camera.principal_point
        unit = np.tile(np.eye(2), (len(image), 1, 1))
        return resect(image, unit, self.ground, unknowns.camera.f_mm, interior=unknowns, **options)  # type: ignore[arg-type]

    def noisy(self, random: np.random.Generator, sigma: float = SIGMA) -> "Scene":
        frame = self.measured.frame + random.normal(scale=sigma, size=self.measured.frame.shape)
        return replace(self, measured=replace(self.measured, frame=frame))


def lens(direction: str, values: dict[str, float], f: float = F) -> Distortion:
    coefficients = {name: values[name] for name in ("k1", "k2", "k3", "p1", "p2")}
    if direction == "opencv":
        return Distortion("opencv", "ideal_to_distorted", coefficients, None, f)
    return Distortion("brown", direction, coefficients)


def scene(name: str, direction: str, n: int = 30, relief: float = 500.0, tilt: float = 0.3, values=None) -> Scene:  # type: ignore[no-untyped-def]
    """Points on hills below an oblique camera; their readings go through the inverse of the true camera."""
    random = generator(name)
    values = values or (OPENCV if direction == "opencv" else TRUE)
    truth = Camera(values["f"], values["x0"], values["y0"], lens(direction, values), values["b1"], values["b2"])
    rotation = looking(0.4, tilt, 0.9)
    centre = S_TRUE - S_TRUE[2] / rotation[2, 2] * rotation[:, 2]
    ground = centre * [1, 1, 0] + np.column_stack(
        [random.uniform(-1100, 1100, (n, 2)), relief * random.uniform(-0.5, 0.5, n)]
    )
    image, zs = project(ground, S_TRUE, rotation, F)
    assert np.all(zs < 0)
    frame = readings(truth, image)
    return Scene(truth, Measured(frame, np.zeros_like(frame)), ground, rotation, S_TRUE)


def readings(truth: Camera, image: FloatArray) -> FloatArray:
    """Where the true camera would show the ideal image points: by fixed-point iteration, apart from `corrected`."""
    affine = np.eye(2) + truth.affinity
    if truth.is_from_ideal:
        return distort(truth.distortion, image) @ affine.T + truth.principal_point
    sign = -1.0 if truth.distortion.direction == "displacement" else 1.0
    q = image.copy()
    for _ in range(60):
        q = image - sign * (q @ truth.affinity.T + field(truth.distortion.coefficients, q))
    return q + truth.principal_point


def field(c: dict[str, float], q: FloatArray) -> FloatArray:
    """Brown's formula written out once more (docs/conventions.md 7)."""
    x, y = q.T
    r2 = x * x + y * y
    g = c["k1"] * r2 + c["k2"] * r2**2 + c["k3"] * r2**3
    dx = x * g + c["p1"] * (r2 + 2 * x * x) + 2 * c["p2"] * x * y
    dy = y * g + c["p2"] * (r2 + 2 * y * y) + 2 * c["p1"] * x * y
    return np.column_stack([dx, dy])


def poor_start(direction: str, factor: float = 1.0) -> Camera:
    zero = dict.fromkeys(TRUE, 0.0)
    return Camera(factor * F, 0.0, 0.0, lens(direction, zero, factor * F))


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_all_ten_elements_are_found_in_a_scene_without_errors(direction: str) -> None:
    s = scene("all ten", direction)
    found = s.resect(s.unknowns(INTERIOR, poor_start(direction)))
    assert found.termination is Termination.CONVERGED
    # 1e-6 mm in the image for every element: rounding times the condition of sixteen unknowns
    scales = s.unknowns(INTERIOR, poor_start(direction)).scales / F
    assert (found.camera - s.truth.values(INTERIOR)) / scales == pytest.approx(np.zeros(10), abs=1e-6)
    assert found.station == pytest.approx(S_TRUE, abs=1e-4)
    assert found.f_mm == pytest.approx(F, abs=1e-6)
    assert np.max(np.abs(found.residuals)) < 1e-9


@pytest.mark.parametrize("factor", [0.7, 0.8, 1.2, 1.4])
def test_a_focal_length_wrong_by_a_fifth_and_more_is_mended(factor: float) -> None:
    s = scene("poor f", "correction").noisy(generator("poor f noise"))
    good = s.resect(s.unknowns(("f", "k1"), poor_start("correction")))
    poor = s.resect(s.unknowns(("f", "k1"), poor_start("correction", factor)))
    assert poor.termination is Termination.CONVERGED
    assert poor.camera == pytest.approx(good.camera, rel=1e-7)
    assert poor.station == pytest.approx(good.station, abs=1e-4)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_the_whole_design_by_central_differences(direction: str) -> None:
    s = scene("design", direction, n=6)
    unknowns = s.unknowns(INTERIOR, s.truth)
    unit = np.tile(np.eye(2), (6, 1, 1))
    problem = ResectionProblem(s.measured.frame, unit, ground_knowledge(s.ground, None, None), F, interior=unknowns)
    values = s.truth.values(INTERIOR)

    def misclosure(step: FloatArray) -> FloatArray:
        moved = rotation_exp(step[:3]) @ s.rotation
        state = Orientation(moved, S_TRUE + step[3:6], s.ground, camera=values + step[6:])
        return problem.image_equations(state).free_term

    scales = np.concatenate([[1e-5] * 3, [1e-2] * 3, 1e-5 * unknowns.scales])
    numeric = central_difference(misclosure, np.zeros(16), scales)
    found = problem.image_equations(Orientation(s.rotation, S_TRUE, s.ground, camera=values)).by_elements
    assert found * scales == pytest.approx(numeric * scales, abs=1e-9)


@pytest.mark.parametrize("direction", ["correction", "opencv"])
def test_both_engines_agree(direction: str) -> None:
    s = scene("engines", direction).noisy(generator("engines noise"))
    names = ("f", "x0", "y0", "k1", "k2", "p1", "p2")
    by_Z, by_qr = (s.resect(s.unknowns(names, poor_start(direction)), engine=engine) for engine in Engine)
    sigma = np.sqrt(np.diag(by_qr.Q))
    assert by_Z.station == pytest.approx(by_qr.station, rel=1e-9)
    assert (by_Z.camera - by_qr.camera) / sigma[6:] == pytest.approx(np.zeros(7), abs=1e-6)
    assert by_Z.Q / np.outer(sigma, sigma) == pytest.approx(
        by_qr.Q / np.outer(sigma, sigma), abs=1e-9 / by_qr.condition_ratio
    )
    assert by_Z.vPv == pytest.approx(by_qr.vPv, rel=1e-9)


def test_a_prior_is_an_observation() -> None:
    """Dense least squares of the same linearised equations, the prior as one row more."""
    s = scene("prior", "correction").noisy(generator("prior noise"))
    start = poor_start("correction")
    sigmas = {"f": 0.02, "x0": 0.03}
    unknowns = s.unknowns(("f", "x0", "k1"), start, sigmas)
    found = s.resect(unknowns)
    assert found.termination is Termination.CONVERGED
    assert found.redundancy == 2 * 30 + 2 - 9
    B = np.concatenate([partials(s, found), found.camera_equations], axis=2).reshape(-1, 9)
    root = SIGMA / np.array([0.02, 0.03])
    B = np.vstack([B, np.hstack([np.zeros((2, 6)), np.diag([*root, 0.0])[:2]])])
    v = np.concatenate([found.residuals.ravel(), root * (found.camera - start.values(("f", "x0", "k1")))[:2]])
    Q = np.linalg.inv(B.T @ B)
    sigma = np.sqrt(np.diag(Q))
    assert found.Q / np.outer(sigma, sigma) == pytest.approx(Q / np.outer(sigma, sigma), abs=1e-8)
    assert (B.T @ v) * sigma == pytest.approx(np.zeros(9), abs=1e-9)
    assert found.vPv == pytest.approx(v @ v, rel=1e-12)
    shares = found.redundancy_numbers.sum() + found.known_redundancy.sum()
    assert shares == pytest.approx(found.redundancy, abs=1e-8)


def partials(s: Scene, found: Resection) -> FloatArray:
    from orient.geometry.collinearity import partials_rotation

    return partials_rotation(s.ground, found.station, found.rotation, found.f_mm)[:, :, :6]


@pytest.mark.parametrize("f_start", [150.0, 180.0])
@pytest.mark.parametrize("sigma", [0.0, SIGMA])
def test_f_over_flat_ground_seen_vertically_is_refused_by_name(f_start: float, sigma: float) -> None:
    plain = {**dict.fromkeys(TRUE, 0.0), "f": F}
    s = scene("flat", "correction", relief=0.0, tilt=0.0, values=plain)
    s = s.noisy(generator("flat noise"), sigma) if sigma else s
    found = s.resect(s.unknowns(("f",), poor_start("correction", f_start / F)))
    assert found.termination is Termination.SINGULAR
    assert found.message.startswith("f and Z_S cannot be separated (correlation 1.000). Undetermined: f 1.00, Z_S ")
    assert np.isnan(found.Q).all()


@pytest.mark.parametrize(("relief", "tilt"), [(20.0, 0.0), (0.0, 0.5), (100.0, 0.0)])
def test_relief_or_an_oblique_view_separates_f(relief: float, tilt: float) -> None:
    plain = {**dict.fromkeys(TRUE, 0.0), "f": F}
    s = scene("relief", "correction", relief=relief, tilt=tilt, values=plain).noisy(generator("relief noise"))
    found = s.resect(s.unknowns(("f",), poor_start("correction", 1.1)))
    assert found.termination is Termination.CONVERGED
    assert abs(found.f_mm - F) < 3.5 * SIGMA * np.sqrt(found.Q[6, 6])


def test_a_prior_makes_f_over_flat_ground_possible() -> None:
    plain = {**dict.fromkeys(TRUE, 0.0), "f": F}
    s = scene("flat", "correction", relief=0.0, tilt=0.0, values=plain).noisy(generator("flat prior"))
    found = s.resect(s.unknowns(("f",), poor_start("correction"), {"f": 0.05}))
    assert found.termination is Termination.CONVERGED
    # the photo adds nothing: f keeps its prior, and the height pays for it
    assert SIGMA * np.sqrt(found.Q[6, 6]) == pytest.approx(0.05, rel=1e-2)
    assert SIGMA * np.sqrt(found.Q[5, 5]) == pytest.approx(0.05 / F * S_TRUE[2], rel=0.05)


def test_separability_is_one_minus_the_multiple_correlation() -> None:
    random = generator("separability")
    A = random.normal(size=(20, 4))
    A[:, 3] = A[:, :3] @ [1.0, -2.0, 0.5] + 1e-3 * random.normal(size=20)
    rest = A[:, :3]
    left = A[:, 3] - rest @ np.linalg.lstsq(rest, A[:, 3], rcond=None)[0]
    expected = np.linalg.norm(left) / np.linalg.norm(A[:, 3])
    assert separability(np.linalg.qr(A, mode="r"))[3] == pytest.approx(expected, rel=1e-6)


def known_angle(place: int, given: float, sigma: float) -> ElementObservation:
    def misclosure(rotation: FloatArray, station: FloatArray) -> tuple[float, FloatArray]:
        value = opk_from_matrix(rotation)[place] - given
        return float(value), np.concatenate([opk_by_rotation(rotation)[place], np.zeros(3)])

    return ElementObservation("opk", (sigma / SIGMA) ** 2, misclosure)


def test_a_known_station_and_angle_are_observations() -> None:
    s = scene("known", "correction", n=8).noisy(generator("known noise"))
    camera = s.unknowns((), s.truth)
    free = s.resect(camera)
    axis = np.array([0.6, 0.0, 0.8])
    sigma_m = 0.5 * SIGMA * float(np.sqrt(axis @ free.Q[3:, 3:] @ axis))
    given = float(axis @ S_TRUE) + 0.3 * sigma_m
    kappa = float(opk_from_matrix(s.rotation)[2])
    known = [ElementObservation("along", (sigma_m / SIGMA) ** 2, along(axis, given)), known_angle(2, kappa, 1e-6)]
    held = s.resect(camera, observed=known)
    assert held.redundancy == free.redundancy + 2
    a = np.zeros((2, 6))
    a[0, 3:], a[1, :3] = axis, opk_by_rotation(held.rotation)[2]
    weights = np.array([SIGMA / sigma_m, SIGMA / 1e-6]) ** 2
    B = partials(s, held).reshape(-1, 6)
    Q = np.linalg.inv(B.T @ B + a.T @ (weights[:, None] * a))
    sigma = np.sqrt(np.diag(Q))
    assert held.Q / np.outer(sigma, sigma) == pytest.approx(Q / np.outer(sigma, sigma), abs=1e-8)
    assert held.known_redundancy == pytest.approx(1 - np.diag(a @ Q @ a.T) * weights, abs=1e-8)
    assert held.known_redundancy.sum() + held.redundancy_numbers.sum() == pytest.approx(held.redundancy, abs=1e-8)
    assert opk_from_matrix(held.rotation)[2] == pytest.approx(kappa, abs=3e-6)


def test_starts_share_their_end_although_the_camera_moves_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """A focal length two hundredths off moves the station by as much: what counts is where the camera is released."""
    s = scene("shared end", "correction", values={**dict.fromkeys(TRUE, 0.0), "f": F})
    adjusted: list[object] = []
    refined = resection._refined
    monkeypatch.setattr(resection, "_refined", lambda task, one: (adjusted.append(one), refined(task, one))[1])
    found = s.resect(s.unknowns(("f",), poor_start("correction", 0.98)))
    assert found.termination is Termination.CONVERGED
    assert found.camera == pytest.approx([F], abs=1e-6)
    assert len(adjusted) < sum(start.end is not None for start in found.starts)


def test_a_fixed_station_stays_and_two_points_more_are_saved() -> None:
    s = scene("fixed", "opencv").noisy(generator("fixed noise"))
    found = s.resect(s.unknowns(("f", "k1", "k2"), poor_start("opencv", 0.8)), fixed_station=S_TRUE)
    assert found.termination is Termination.CONVERGED
    assert found.station == pytest.approx(S_TRUE, abs=1e-9)
    assert found.n_unknowns == 6
    assert not found.Q[3:6].any()
    assert found.weak == () or all("_S" not in pair[0] + pair[1] for pair in found.weak)


def test_one_equation_too_few_is_said() -> None:
    s = scene("few", "correction", n=3)
    with pytest.raises(Exception, match="lacks 1 equation: 6 for 7 unknowns"):
        s.resect(s.unknowns(("f",), s.truth))


def test_the_iterations_begin_with_the_camera_as_given() -> None:
    s = scene("steps", "correction").noisy(generator("steps noise"))
    found = s.resect(s.unknowns(("f", "k1"), poor_start("correction", 0.9)))
    first, last = found.iterations[0], found.iterations[-1]
    assert first.camera.tolist() == [0.9 * F, 0.0]
    assert first.correction_camera.tolist() == [0.0, 0.0]
    assert last.camera + last.correction_camera == pytest.approx(found.camera, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("direction", ["correction", "opencv"])
def test_the_simulated_spread_of_all_unknowns_agrees_with_Q(direction: str) -> None:
    """10 000 photos: each sigma within 3 % (its own error is 0.7 %), with a prior and a known height."""
    s = scene("spread", direction, n=20)
    names, sigmas = ("f", "x0", "y0", "k1", "k2"), {"f": 0.02}
    random = generator(f"spread {direction}")
    height = np.array([0.0, 0.0, 1.0])
    values = []
    for _ in range(10_000):
        drawn = s.noisy(random)
        given = replace(s.truth, f_mm=s.truth.f_mm + random.normal(scale=0.02))
        known = along(height, S_TRUE[2] + random.normal(scale=0.3))
        found = drawn.resect(
            drawn.unknowns(names, given, sigmas),
            observed=[ElementObservation("Z_S", (0.3 / SIGMA) ** 2, known)],
            start=(s.rotation, S_TRUE),
        )
        assert found.termination is Termination.CONVERGED
        turned = opk_from_matrix(found.rotation)
        values.append(np.concatenate([turned, found.station, found.camera]))
    spread = np.cov(np.array(values).T)
    J = np.eye(11)
    J[:3, :3] = opk_by_rotation(s.rotation)
    expected = SIGMA**2 * J @ found.Q @ J.T
    root = np.linalg.inv(np.linalg.cholesky(expected))
    assert np.sqrt(np.diag(spread) / np.diag(expected)) == pytest.approx(np.ones(11), abs=0.03)
    # the extreme eigenvalues of eleven unknowns in 10 000 trials lie at (1 +- sqrt(11 / 10 000))^2
    assert np.linalg.eigvalsh(root @ spread @ root.T) == pytest.approx(np.ones(11), abs=0.09)
