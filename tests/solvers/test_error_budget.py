"""The interior orientation as common unknowns of the image, and the parts of the covariance by source."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from orient.errors import GeometryError
from orient.solvers.common_unknowns import CommonUnknowns, together, whitened
from orient.solvers.error_budget import Sources, error_budget, sensitivities
from orient.solvers.functional_iteration import Termination
from orient.solvers.resection import Resection, resect
from tests.solvers.resection_scenes import FloatArray, generator
from tests.solvers.test_resection_common import SIGMA_MM, SheetScene, free_and_weight, sheet_scene

AFFINE = ("a0", "a1", "a2", "b0", "b1", "b2")


@dataclass(frozen=True)
class FilmScene:
    """Points of two sheets and of none on a film whose affine interior orientation comes from eight marks."""

    sheets: SheetScene
    by_image: FloatArray
    film: FloatArray

    @property
    def of_film(self) -> CommonUnknowns:
        partials = np.zeros((len(self.by_image), 3, len(self.film)))
        return CommonUnknowns(partials, self.film / SIGMA_MM**2, AFFINE, self.by_image)

    @property
    def common(self) -> CommonUnknowns:
        found = together([self.of_film, self.sheets.common])
        assert found is not None
        return found

    def resect(
        self, image: FloatArray, ground: FloatArray, c: FloatArray | None = None, covariance: FloatArray | None = None
    ) -> Resection:
        """`c`: a-priori values of the common unknowns; `covariance` (n, 2, 2) of the image points."""
        if c is not None:
            k = len(self.film)
            image = image + self.by_image @ c[:k]
            ground = ground + self.sheets.partials @ c[k:]
        free, weight = free_and_weight(self.sheets.reading)
        return resect(
            image,
            self.sheets.scene.unit if covariance is None else covariance / SIGMA_MM**2,
            ground,
            self.sheets.scene.f_mm,
            ground_free=free,
            ground_weight=weight,
            common=self.common,
            start_mask=np.ones(len(image), dtype=np.bool_),
            approximate_station=self.sheets.scene.station,
        )

    def simulated(self, random: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        image, ground = self.sheets.simulated(random)
        return image + self.by_image @ (np.linalg.cholesky(self.film) @ random.normal(size=len(self.film))), ground


def film_scene(name: str, n: int = 14, alone: int = 3) -> tuple[FilmScene, np.random.Generator]:
    random = generator(name)
    sheets = sheet_scene(random, n, alone=alone)
    marks = 100.0 * np.array([(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if (x, y) != (0, 0)])
    design = np.column_stack([np.ones(8), marks])
    film = np.kron(np.eye(2), 0.008**2 * np.linalg.inv(design.T @ design))
    rows = np.column_stack([np.ones(n), sheets.scene.image])
    by_image = np.zeros((n, 2, 6))
    by_image[:, 0, :3] = by_image[:, 1, 3:] = rows
    return FilmScene(sheets, by_image, film), random


def sources_of(scene: FilmScene) -> Sources:
    """In units of sigma0^2: cofactors."""
    n, k = len(scene.by_image), len(scene.film)
    reading = scene.sheets.reading / SIGMA_MM**2
    heights = np.zeros_like(reading)
    heights[:, 2, 2] = 0.3 * reading[:, 2, 2]
    film, maps = np.zeros((2, *scene.common.cofactor.shape))
    film[:k, :k] = scene.common.cofactor[:k, :k]
    maps[k:, k:] = 0.4 * scene.common.cofactor[k:, k:]
    image = {"readings": np.tile(np.eye(2), (n, 1, 1))}
    common = {"film": film, "map": maps, "digitiser": 1.5 * maps}
    return Sources(image, {"digitiser": reading - heights, "heights": heights}, common)


def relative(Q: FloatArray, of: FloatArray) -> FloatArray:
    sigma = np.sqrt(np.diag(of))
    return np.asarray(Q / np.outer(sigma, sigma))


def assert_same(found: FloatArray, expected: FloatArray, limit: float) -> None:
    """In units of the sigmas: the elements have rad and m."""
    np.testing.assert_allclose(relative(found, expected), relative(expected, expected), rtol=0, atol=limit)


# ------------------------------------------------------------------------------------------------ the film


def test_film_as_unknown_is_the_full_covariance_of_the_readings() -> None:
    """The same adjustment with the (2n, 2n) covariance of the image points instead, iterated densely about the ends."""
    scene, random = film_scene("film dense")
    image, ground = scene.simulated(random)
    found = scene.resect(image, ground)
    assert found.termination is Termination.CONVERGED
    n = len(image)
    rim_rows, by_point = found.problem.image_rows(found.state)
    A, B = rim_rows[:, :, -6:].reshape(2 * n, 6), np.zeros((2 * n, 3 * n))
    for i in range(n):
        B[2 * i : 2 * i + 2, 3 * i : 3 * i + 3] = by_point[i]
    H = scene.by_image.reshape(2 * n, 6)
    full = SIGMA_MM**2 * np.eye(2 * n) + H @ scene.film @ H.T + B @ scene.sheets.full_covariance @ B.T
    normal = A.T @ np.linalg.solve(full, A)
    assert_same(SIGMA_MM**2 * found.Q, np.linalg.inv(normal), 1e-7)
    misclosure = found.computed + scene.by_image @ found.common[:6] - image
    free = misclosure.ravel() - B @ (found.ground - ground).ravel()
    step = np.linalg.solve(normal, A.T @ np.linalg.solve(full, free))
    assert np.all(np.abs(step) < 1e-6 * SIGMA_MM * np.sqrt(np.diag(found.Q)))


def test_the_film_takes_part_in_everything_that_is_told() -> None:
    """Redundancy numbers, v'Pv and residuals of the readings alone; the film only makes the sigmas larger."""
    scene, random = film_scene("film told")
    image, ground = scene.simulated(random)
    found = scene.resect(image, ground)
    parts = found.redundancy_numbers.sum() + found.ground_redundancy.sum() + found.common_redundancy.sum()
    assert parts == pytest.approx(found.redundancy, abs=1e-8)
    own = found.ground - ground - scene.sheets.partials @ found.common[6:]
    _, weight = free_and_weight(scene.sheets.reading)
    of_c = found.common @ np.linalg.solve(scene.common.cofactor, found.common)
    vPv = np.sum(found.residuals**2) + np.einsum("ni,nij,nj", own, weight, own) + of_c
    assert found.vPv == pytest.approx(vPv, rel=1e-9)
    known = replace(scene, film=1e-20 * scene.film)
    without = known.resect(image, ground)
    assert np.all(np.diag(found.Q) >= np.diag(without.Q) * (1 - 1e-9))
    assert np.diag(found.Q)[:2].sum() > 1.01 * np.diag(without.Q)[:2].sum()


def test_whitening_refuses_a_film_that_is_not_finite() -> None:
    scene, _ = film_scene("film bad")
    bad = replace(scene.of_film, by_image=np.full_like(scene.by_image, np.nan))
    with pytest.raises(GeometryError, match="a0, a1, a2"):
        whitened(bad, len(scene.by_image))


# ------------------------------------------------------------------------------------------ the sensitivities


def changed(scene: FilmScene, kind: str, at: tuple[int, ...], step: float) -> FloatArray:
    """The unknowns (rotation as a small one about the truth's adjustment, station, c) after one observation moved."""
    image, ground = scene.sheets.scene.image.copy(), scene.sheets.scene.ground.copy()
    c = np.zeros(scene.common.cofactor.shape[0])
    {"image": image, "ground": ground, "common": c}[kind][at] += step
    found = scene.resect(image, ground, c)
    assert found.termination is Termination.CONVERGED
    turned = found.rotation @ scene.sheets.scene.rotation.T
    # c counts from its a-priori value; the sensitivity is that of the sum
    return np.array([turned[2, 1], turned[0, 2], turned[1, 0], *found.station, *(c + found.common)])


@pytest.mark.parametrize(
    ("kind", "at", "step"),
    [
        ("image", (0, 0), 0.01),
        ("image", (6, 1), 0.01),
        ("image", (13, 0), 0.01),
        ("ground", (0, 0), 3.0),
        ("ground", (5, 1), 3.0),
        ("ground", (12, 2), 3.0),
        ("common", (0,), 0.01),
        ("common", (4,), 1e-4),
        ("common", (7,), 2e-5),
        ("common", (25,), 3.0),
    ],
    ids=str,
)
def test_sensitivities_are_what_a_changed_observation_does(kind: str, at: tuple[int, ...], step: float) -> None:
    """Central differences through the whole resection; the steps are of the size of the errors."""
    scene, _ = film_scene("central differences")
    found = scene.resect(scene.sheets.scene.image, scene.sheets.scene.ground)
    S = sensitivities(found)
    expected = {"image": S.by_image, "ground": S.by_ground, "common": S.by_common}[kind]
    expected = expected[:, at[0]] if kind == "common" else expected[at[0], :, at[1]]
    difference = (changed(scene, kind, at, step) - changed(scene, kind, at, -step)) / (2 * step)
    sigma = np.sqrt(np.diag(found.joint_cofactors))
    limit = 2e-6 * float(np.max(np.abs(expected / sigma)))
    np.testing.assert_allclose(difference / sigma, expected / sigma, rtol=0, atol=limit)


# ------------------------------------------------------------------------------------------------- the parts


def test_the_parts_of_all_sources_sum_to_the_covariance() -> None:
    scene, random = film_scene("sum")
    found = scene.resect(*scene.simulated(random))
    parts = error_budget(sensitivities(found), sources_of(scene))
    assert set(parts) == {"readings", "digitiser", "heights", "film", "map"}
    assert_same(sum(parts.values(), np.zeros_like(found.joint_cofactors)), found.joint_cofactors, 1e-12)
    for part in parts.values():
        assert np.all(np.linalg.eigvalsh(relative(part, found.joint_cofactors)) > -1e-12)
        assert np.diag(part)[:6].min() > 0


def test_errorless_control_leaves_the_readings_alone() -> None:
    random = generator("alone")
    sheets = sheet_scene(random, 8)
    found = resect(sheets.scene.noisy(SIGMA_MM, random), sheets.scene.unit, sheets.scene.ground, sheets.scene.f_mm)
    parts = error_budget(sensitivities(found), Sources(image={"readings": sheets.scene.unit}))
    assert_same(parts["readings"], found.Q, 1e-12)


def test_a_source_that_is_twice_as_large_has_four_times_its_part() -> None:
    """With the weights as they were: the sensitivities do not know the sources."""
    scene, random = film_scene("twice")
    S = sensitivities(scene.resect(*scene.simulated(random)))
    once = sources_of(scene)
    twice = replace(once, ground={name: 4 * covariance for name, covariance in once.ground.items()})
    one, other = error_budget(S, once), error_budget(S, twice)
    np.testing.assert_allclose(other["heights"], 4 * one["heights"], rtol=1e-12)
    np.testing.assert_array_equal(other["film"], one["film"])
