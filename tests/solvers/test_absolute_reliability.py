"""Redundancy, w, smallest errors and effects of an absolute orientation against the adjustment done again."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from orient.solvers.absolute_orientation import orient_model, origin_by_centre
from orient.solvers.absolute_problem import Similarity
from orient.solvers.absolute_reliability import (
    GROUND,
    MODEL,
    ModelControl,
    control_blocks,
    largest_model_shift,
    other_blocks,
    similarity_of,
    view_misfits,
)
from orient.solvers.absolute_result import AbsoluteOrientation
from orient.solvers.absolute_views import VIEWS, view_changes
from orient.solvers.critical_values import w_limits
from orient.solvers.reliability import BlockTests, Reliability, block_statistic, observation_tests, prediction_statistic
from tests.solvers.absolute_scenes import covariances, generator, scene

SIGMA_M, SIGMA_MODEL = 0.05, 0.004
DRAWN = 0.002
"""Size of the errors in sigmas: the theory is of first order, what it neglects grows with the residuals."""
LIMITS = w_limits(1.0)
KINDS = "ffffpphhh"


def control(name: str, kinds: str = KINDS, sides: str = "both") -> ModelControl:
    """A scene with correlated errors on both sides, or on one of them."""
    random = generator(name)
    made = scene(random, kinds, tilt=0.2)
    n = len(kinds)
    on_ground, in_model = covariances(random, n, SIGMA_M), covariances(random, n, SIGMA_MODEL)
    root = np.linalg.cholesky(on_ground), np.linalg.cholesky(in_model)
    errors = [DRAWN * L @ random.normal(size=(n, 3, 1)) for L in root]
    has_ground, has_model = sides != "model", sides != "ground"
    return ModelControl(
        made.model + (errors[1][:, :, 0] if has_model else 0.0),
        made.ground + (errors[0][:, :, 0] if has_ground else 0.0),
        made.known,
        on_ground if has_ground else 0 * on_ground,
        in_model if has_model else None,
        np.tile(np.eye(3), (n, 1, 1)),
    )


def adjusted(given: ModelControl) -> AbsoluteOrientation:
    found = orient_model(
        given.model, given.ground, known=given.known, ground_cofactor=given.ground_cofactor,
        model_cofactor=given.model_cofactor, tolerance=1e-13,
    )  # fmt: skip
    assert found.is_result
    return found


def judged(found: AbsoluteOrientation, given: ModelControl) -> tuple[BlockTests, Reliability]:
    reliability = observation_tests([control_blocks(found, given)], LIMITS, 7)
    return reliability.tests[0], reliability


def moved(given: ModelControl, point: int, place: int, size: float) -> ModelControl:
    """One observation with an error."""
    if place in GROUND:
        ground = given.ground.copy()
        ground[point] += size * given.axes[point][:, place]
        return replace(given, ground=ground)
    model = given.model.copy()
    model[point, place - 3] += size
    return replace(given, model=model)


@dataclass(frozen=True)
class Case:
    sides: str
    kinds: str = KINDS

    @property
    def id(self) -> str:
        return f"{self.sides} {self.kinds}"


CASES = [Case("both"), Case("ground"), Case("model"), Case("both", "ffffff"), Case("both", "fffppp")]


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_redundancy_numbers_sum_to_the_redundancy_and_shares_are_shares(case: Case) -> None:
    given = control(case.id, case.kinds, case.sides)
    found = adjusted(given)
    tests, reliability = judged(found, given)
    assert np.nansum(tests.redundancy) == pytest.approx(found.redundancy, abs=1e-9)
    assert np.nanmin(tests.share) >= -1e-12 and np.nanmax(tests.share) <= 1 + 1e-12
    assert np.linalg.inv(reliability.root.T @ reliability.root) == pytest.approx(found.Q_centred, rel=1e-6, abs=1e-15)
    known = {"f": [True] * 3, "p": [True, True, False], "h": [False, False, True]}
    is_there = np.array([[*(k and case.sides != "model" for k in known[kind]), *[case.sides != "ground"] * 3]
                         for kind in case.kinds])  # fmt: skip
    assert (np.isfinite(tests.share) == is_there).all()


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_effects_are_central_differences_of_the_adjustment(case: Case) -> None:
    """dx = Q A'P e: observations moved by a hundredth of their sigma; 3e-3 for the digits of a far origin."""
    given = control(case.id, case.kinds, case.sides)
    found = adjusted(given)
    tests, _ = judged(found, given)
    to_origin = origin_by_centre(Similarity(found.rotation, found.H, found.X0), found.model_centre)
    units = np.sqrt(np.diag(found.Q_centred))
    for point, place in np.argwhere(tests.is_tested).tolist()[::3]:
        step = 1e-2 * (SIGMA_M if place in GROUND else SIGMA_MODEL)
        ends = [adjusted(moved(given, point, place, sign * step)) for sign in (1.0, -1.0)]
        turn = ends[0].rotation @ ends[1].rotation.T
        dx = np.array([turn[2, 1], turn[0, 2], turn[1, 0], ends[0].H - ends[1].H, *(ends[0].X0 - ends[1].X0)])
        centred = np.linalg.solve(to_origin, dx) / (2 * step)
        claimed = tests.effect[point, place] / tests.mdb[point, place]
        assert np.max(np.abs(centred - claimed) / units) < 3e-3 * max(np.max(np.abs(claimed) / units), 1.0)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.id)
def test_w_and_the_smallest_error_follow_from_the_growth_of_vPv(case: Case) -> None:
    """v'Pv(e) = v'Pv - 2 e (Pv)_i + e^2 (P Q_v P)_ii along an error e of one observation."""
    given = control(case.id, case.kinds, case.sides)
    found = adjusted(given)
    tests, _ = judged(found, given)
    for point, place in np.argwhere(tests.is_tested & (tests.share > 0.05)).tolist()[::3]:
        step = 0.05 * (SIGMA_M if place in GROUND else SIGMA_MODEL)
        plus, minus = (adjusted(moved(given, point, place, sign * step)).vPv for sign in (1.0, -1.0))
        curvature = (plus - 2 * found.vPv + minus) / (2 * step**2)
        slope = (plus - minus) / (4 * step)
        assert curvature == pytest.approx((LIMITS.delta0 / tests.mdb[point, place]) ** 2, rel=5e-3)
        assert -slope / np.sqrt(curvature) == pytest.approx(tests.w[point, place], abs=5e-3)


def test_a_point_left_out_is_judged_like_one_that_is_in() -> None:
    """The misfit of an excluded point has the statistic of its block test (exact but for the linearisation)."""
    given = control("left out", "fffffpph")
    tests, _ = judged(adjusted(given), given)
    T, freedom = block_statistic(tests, GROUND, LIMITS)
    for point in (0, 5, 7):
        rest = given.at(np.arange(8) != point)
        found = adjusted(rest)
        _, reliability = judged(found, rest)
        alone, free = prediction_statistic(other_blocks(found, given.at(np.array([point]))), reliability, LIMITS)
        assert alone[0] == pytest.approx(T[point], rel=1e-2)
        assert free[0] == freedom[point]


def test_both_sides_of_a_point_give_the_same_block_test() -> None:
    given = control("sides")
    tests, _ = judged(adjusted(given), given)
    by_ground, by_model = (block_statistic(tests, side, LIMITS) for side in (GROUND, MODEL))
    full = np.array([kind == "f" for kind in KINDS])
    assert by_ground[0][full] == pytest.approx(by_model[0][full], rel=1e-9)


def test_shift_and_view_of_an_effect_are_those_of_the_changed_orientation() -> None:
    """The ground points and the angles of an orientation that really is changed by a small error."""
    given = control("view")
    found = adjusted(given)
    tests, _ = judged(found, given)
    point, place, size = 1, 3, 1e-3 * SIGMA_MODEL
    effect = tests.effect[point, place] / tests.mdb[point, place] * size
    other = adjusted(moved(given, point, place, size))
    before, after = (VIEWS["homothety"](one)[1] for one in (found, other))
    sigma = np.sqrt(np.diag(found.Q))
    assert view_changes(found, "homothety", effect) == pytest.approx(after - before, abs=1e-6 * sigma.max())
    shift, where = largest_model_shift(found, given.model, effect[None, None])
    places = [given.model @ one.rotation.T / one.H + one.X0 for one in (found, other)]
    lengths = np.linalg.norm(places[1] - places[0], axis=1)
    assert shift[0, 0] == pytest.approx(lengths.max(), rel=1e-3)
    assert where[0, 0] == np.argmax(lengths)


def test_misfits_at_the_adjusted_orientation_sum_to_vPv() -> None:
    given = control("misfits")
    found = adjusted(given)
    T = view_misfits(Similarity(found.rotation, found.H, found.X0), given)
    assert float(T.sum()) == pytest.approx(found.vPv, rel=1e-6)
    assert similarity_of(found).centre == pytest.approx(found.ground_centre)
