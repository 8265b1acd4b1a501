"""The loop of every adjustment: its terminations, its damping, and the words for what is undetermined."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from orient.solvers.functional_iteration import (
    Termination,
    condition_ratio,
    iterate,
    strong_correlations,
    undetermined_combination,
)
from tests.solvers.resection_scenes import FloatArray


@dataclass(frozen=True)
class Linear:
    vPv: float
    triangle: FloatArray
    rho: FloatArray
    scales: FloatArray


@dataclass(frozen=True)
class Curve:
    """v = g(x) - observed with the unknowns x themselves as state."""

    g: Callable[[FloatArray], FloatArray]
    design: Callable[[FloatArray], FloatArray]

    def linearise(self, state: FloatArray) -> Linear:
        v, A = self.g(state), self.design(state)
        if not (np.isfinite(v).all() and np.isfinite(A).all()):
            return Linear(np.inf, np.zeros((len(state), len(state))), np.zeros(len(state)), np.ones(len(state)))
        R = np.linalg.qr(np.column_stack([A, v]), mode="r")
        u = len(state)
        return Linear(float(v @ v), R[:u, :u], R[:u, u], np.ones(u))

    def corrected(self, state: FloatArray, linear: Linear, corrections: FloatArray) -> tuple[FloatArray, float]:
        return state + corrections, 0.0


def one(g: Callable[[float], float], slope: Callable[[float], float]) -> Curve:
    return Curve(lambda x: np.array([g(x[0])]), lambda x: np.array([[slope(x[0])]]))


def test_linear_problem_converges_in_one_step_and_a_proof() -> None:
    B, F = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]]), np.array([-1.0, -2.0, -4.0])
    end = iterate(Curve(lambda x: B @ x + F, lambda x: B), np.zeros(2))
    assert end.termination is Termination.CONVERGED
    assert len(end.steps) == 2
    np.testing.assert_allclose(end.state, [5 / 6, 1.5])
    assert end.linear.vPv == pytest.approx(1 / 6)


def test_damping_rescues_a_start_from_which_gauss_newton_diverges() -> None:
    end = iterate(one(np.arctan, lambda x: 1 / (1 + x * x)), np.array([5.0]))
    assert end.termination is Termination.CONVERGED
    assert end.steps[0].damping > 0
    assert end.steps[-1].damping == 0
    assert end.state[0] == pytest.approx(0, abs=1e-10)


@pytest.mark.parametrize(
    ("curve", "start", "termination"),
    [
        (one(lambda x: np.exp(-x), lambda x: -np.exp(-x)), 0.0, Termination.MAX_ITERATIONS),
        (one(lambda x: 1.0, lambda x: 0.0), 0.0, Termination.SINGULAR),
        (one(lambda x: 1 / (1 + 1e-9 * x), lambda x: -1e-9 / (1 + 1e-9 * x) ** 2), 0.0, Termination.DIVERGED),
        (one(lambda x: 1.0 + x * x, lambda x: -1.0), 0.0, Termination.NO_DESCENT),
        (one(lambda x: np.nan, lambda x: 1.0), 0.0, Termination.NOT_FINITE),
    ],
    ids=lambda value: str(value) if isinstance(value, Termination) else "",
)
def test_every_end_is_a_result_with_its_code(curve: Curve, start: float, termination: Termination) -> None:
    end = iterate(curve, np.array([start]))
    assert end.termination is termination


def test_a_singular_start_may_lead_to_a_regular_solution() -> None:
    """An amplitude of zero hides its rate: the amplitude moves first, the rate then."""
    x = np.linspace(0.0, 4.0, 9)
    observed = 2.0 * np.exp(-x)
    decay = Curve(
        lambda b: b[0] * np.exp(-b[1] * x) - observed,
        lambda b: np.column_stack([np.exp(-b[1] * x), -b[0] * x * np.exp(-b[1] * x)]),
    )
    end = iterate(decay, np.array([0.0, 3.0]))
    assert end.steps[0].damping > 0
    assert end.termination is Termination.CONVERGED
    np.testing.assert_allclose(end.state, [2.0, 1.0], rtol=1e-9)


@pytest.mark.parametrize("polish", [False, True])
def test_the_polishing_problem_ends_the_iteration(polish: bool) -> None:
    """A problem with rough equations stops at its noise; the same with good ones takes over."""
    seen: list[str] = []

    def noted(name: str, slope: float) -> Curve:
        def design(x: FloatArray) -> FloatArray:
            seen.append(name)
            return np.array([[slope * 2 * x[0]]])

        return Curve(lambda x: x**2 - 2, design)

    rough, good = noted("rough", 1.001), noted("good", 1.0)
    end = iterate(rough, np.array([1.0]), polish=good if polish else None)
    assert end.termination is Termination.CONVERGED
    assert end.state[0] == pytest.approx(np.sqrt(2), rel=1e-12)
    assert seen[-1] == ("good" if polish else "rough")


def test_null_vector_is_written_in_unknowns() -> None:
    triangle = np.linalg.qr(np.array([[1.0, 1, 0], [1, 1, 0], [0, 0, 1], [2, 2, 0]]), mode="r")
    linear = Linear(0.0, triangle, np.zeros(3), np.ones(3))
    assert condition_ratio(triangle) < 1e-15
    assert undetermined_combination(linear, ("X_S", "r_Y", "Z_S")) in ("X_S 1.00, r_Y -1.00", "r_Y 1.00, X_S -1.00")


def test_an_unknown_that_no_observation_touches_is_named() -> None:
    linear = Linear(0.0, np.diag([1.0, 0.0]), np.zeros(2), np.ones(2))
    assert condition_ratio(linear.triangle) == 0
    assert undetermined_combination(linear, ("X_S", "Y_S")) == "Y_S 1.00"


def test_strong_correlations_name_the_pair() -> None:
    Q = np.array([[4.0, 3.96, 0.0], [3.96, 4.0, 0.1], [0.0, 0.1, 1.0]])
    assert strong_correlations(Q, ("a", "b", "c")) == (("a", "b", pytest.approx(0.99)),)


@dataclass(frozen=True)
class Steps:
    """An adjustment whose corrections are given: the state counts the iterations, v'Pv falls as each promises."""

    corrections: tuple[float | tuple[float, ...], ...]
    scales: tuple[float, ...] = (1.0,)

    def linearise(self, state: int) -> Linear:
        scales = np.array(self.scales)
        steps = [np.atleast_1d(correction) / scales for correction in self.corrections]
        vPv = sum(float(step @ step) for step in steps[state:])
        return Linear(vPv, np.eye(len(scales)), -steps[state], scales)

    def corrected(self, state: int, linear: Linear, corrections: FloatArray) -> tuple[int, float]:
        return state + 1, 0.0


def printed_criterion(corrections: tuple[float, ...], W: float, eps: float = 1e-10) -> int | None:
    """Seed 004 (5) as printed, dW^(k+1)/W - dW^(k)/W <= eps: the iterations after which it stops, None for never."""
    with np.errstate(all="ignore"):
        differences = np.diff(np.array(corrections) / np.float64(W))
    stops = np.flatnonzero(differences <= eps)
    return int(stops[0]) + 2 if len(stops) else None


def test_printed_criterion_takes_divergence_for_convergence() -> None:
    """(i) Corrections 0.1, then -5: their difference is -5.1, which is less than any eps."""
    corrections = (0.1, -5.0, 250.0, -1.25e4, 6e5)
    assert printed_criterion(corrections, W=1.0) == 2
    end = iterate(Steps(corrections), 0, max_iterations=4)
    assert end.termination is Termination.MAX_ITERATIONS
    assert [step.max_scaled_step for step in end.steps] == pytest.approx([0.1, 5.0, 250.0, 1.25e4])


def test_printed_criterion_stops_at_constant_steps() -> None:
    """(ii) Corrections 1, 1, 1: the difference is 0, the unknown still walks."""
    corrections = (1.0,) * 8
    assert printed_criterion(corrections, W=1.0) == 2
    end = iterate(Steps(corrections), 0, max_iterations=7)
    assert end.termination is Termination.MAX_ITERATIONS
    assert len(end.steps) == 7


def test_printed_criterion_divides_by_an_angle_of_zero() -> None:
    """(iii) W = 0, an angle of a vertical photo: minus infinity stops at once, and infinity less itself never does."""
    corrections = (0.3, -0.02, 1e-4, 1e-7, 1e-13, 0.0)
    assert printed_criterion(corrections, W=0.0) == 2
    assert printed_criterion((0.3, 0.02, 1e-4, 1e-7, 1e-13, 0.0), W=0.0) is None
    end = iterate(Steps(corrections), 0)
    assert end.termination is Termination.CONVERGED
    assert [step.max_scaled_step for step in end.steps] == pytest.approx(np.abs(corrections[:5]))


def test_the_criterion_is_the_largest_step_over_its_scale() -> None:
    """max_i |delta_i|/s_i <= eps: a length of 5e-3 m counts as 1e-6 of a distance of 5000 m."""
    corrections = ((1e-12, 50.0), (1e-12, -6e-3), (1e-12, 4e-3), (0.0, 0.0))
    end = iterate(Steps(corrections, scales=(1.0, 5000.0)), 0, tolerance=1e-6)
    assert end.termination is Termination.CONVERGED
    assert [step.max_scaled_step for step in end.steps] == pytest.approx([1e-2, 1.2e-6, 0.8e-6])
