"""Starts with one lead share an end only where that lead holds for it."""

import numpy as np
import pytest

import orient.solvers.resection as resection
from orient.solvers.functional_iteration import Termination
from orient.solvers.resection import Resection, resect
from tests.solvers.resection_scenes import FloatArray, generator, scene

SIGMA_MM = 0.01


@pytest.mark.parametrize("many", [4, resection.MANY_POINTS])
def test_unsure_control_keeps_its_rivals(many: int, monkeypatch: pytest.MonkeyPatch) -> None:
    # as if without errors all starts lead to one place; with them three orientations hold, and two fit equally well
    image = np.array([[26.347, -83.392], [-43.027, -5.565], [-27.899, -79.437], [87.497, -10.286]])
    ground = np.array([[10.4, -51.4, 0.1], [-256.2, 149.7, 0.4], [-169.3, -86.6, -0.3], [181.7, 181.8, 0.0]])
    monkeypatch.setattr(resection, "MANY_POINTS", many)
    found = _with_errors(image, ground, 300.0, np.array([5.0, 1.0, 1.0, 0.1]))
    assert found.termination is Termination.CONVERGED
    np.testing.assert_allclose(found.vPv, 0.000733, atol=1e-6)
    np.testing.assert_allclose([one.vPv for one in found.alternatives], [0.002488, 0.005672], atol=1e-6)
    assert [one.is_as_good for one in found.alternatives] == [True, False]


def test_an_unsure_reading_does_not_hide_a_rival_of_the_others() -> None:
    # the fourth point, a hundred times less sure, does not tell two orientations by the others apart
    image = np.array([[13.533, -42.699], [-4.157, -35.0], [-15.722, 42.682], [-2.898, -18.558]])
    ground = np.array([[-16.8, -290.1, 0.0], [-134.9, -238.6, 0.0], [-200.9, 289.1, 0.0], [-123.6, -127.3, 0.0]])
    cofactors = np.eye(2) * np.array([1.0, 1.0, 1.0, 1e4])[:, None, None]
    found = resect(image, cofactors, ground, 150.0, sigma0_mm=SIGMA_MM)
    assert found.termination is Termination.CONVERGED
    assert [one.is_as_good for one in found.alternatives] == [True]


def test_sure_control_is_adjusted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    adjusted: list[object] = []
    refined = resection._refined
    monkeypatch.setattr(resection, "_refined", lambda task, one: (adjusted.append(one), refined(task, one))[1])
    random = generator("test_sure_control")
    s = scene(random, n=8)
    found = resect(s.noisy(SIGMA_MM, random), s.unit, s.ground, s.f_mm)
    assert found.termination is Termination.CONVERGED
    assert len(adjusted) < sum(start.end is not None for start in found.starts)


def test_an_end_that_is_none_leaves_doubt_without_redundancy() -> None:
    # the best start has an end, from others the way to it is too flat: nothing tells them apart
    image = np.array([[216.827, -4.662], [96.97, 5.543], [79.343, -35.087]])
    ground = np.array([[-465.3, -316.1, -0.3], [-552.6, -199.0, 0.0], [-611.2, -218.0, 0.0]])
    found = _with_errors(image, ground, 1000.0, np.array([50.0, 0.1, 0.1]))
    assert found.redundancy == 0
    assert found.termination is Termination.MAX_ITERATIONS


def test_a_fixed_station_stays_with_many_points_too() -> None:
    random = generator("test_fixed_station_of_many")
    s = scene(random, n=resection.MANY_POINTS)
    fixed = s.station + np.array([0.5, -0.3, 0.2])
    found = resect(s.noisy(SIGMA_MM, random), s.unit, s.ground, s.f_mm, fixed_station=fixed)
    assert found.termination is Termination.CONVERGED
    np.testing.assert_allclose(found.station, fixed, atol=1e-9)


def _with_errors(image: FloatArray, ground: FloatArray, f_mm: float, sigma_m: FloatArray) -> Resection:
    n = len(image)
    return resect(
        image,
        np.tile(np.eye(2), (n, 1, 1)),
        ground,
        f_mm,
        ground_free=np.tile(np.eye(3), (n, 1, 1)),
        ground_weight=(SIGMA_MM / sigma_m[:, None, None]) ** 2 * np.eye(3),
        sigma0_mm=SIGMA_MM,
    )
