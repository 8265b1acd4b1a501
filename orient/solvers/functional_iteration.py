"""x_(k+1) = x_k - (A'PA)^-1 A'P L(x_k): the loop that every adjustment of orient runs through.

A problem linearises itself about a state and gives the triangle of the QR decomposition of its weighted, scaled
design matrix; the loop solves, damps when v'Pv would grow, records every iteration, and ends with a termination.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SINGULAR_RATIO = 1e-8
WEAK_RATIO = 1e-4
WEAK_CORRELATION = 0.95
DIVERGED_STEP = 1e6
FIRST_DAMPING = 1e-8
LARGEST_DAMPING = 1e8
SAME_VPV = 1e-9
"""Relative growth of v'Pv that is rounding, not a worse state: a full step is taken in spite of it."""
ROUNDING = 32 * float(np.finfo(np.float64).eps)


class Termination(StrEnum):
    """How an adjustment ended; only CONVERGED is a result."""

    CONVERGED = "CONVERGED"
    MAX_ITERATIONS = "MAX_ITERATIONS"
    SINGULAR = "SINGULAR"
    DIVERGED = "DIVERGED"
    NO_DESCENT = "NO_DESCENT"
    NOT_FINITE = "NOT_FINITE"
    BEHIND_CAMERA = "BEHIND_CAMERA"
    BELOW_GROUND = "BELOW_GROUND"


class Linearised(Protocol):
    """An adjustment about one state: R (x / s) = -rho, with R'R = s A'PA s."""

    @property
    def vPv(self) -> float:
        """Sum of weighted squared residuals of the state itself."""

    @property
    def triangle(self) -> FloatArray:
        """R (u, u), upper triangle of the QR decomposition of the weighted design matrix times the scales."""

    @property
    def rho(self) -> FloatArray:
        """Q'L (u,)."""

    @property
    def scales(self) -> FloatArray:
        """s (u,): 1 for angles [rad], the camera-ground distance for lengths [m]."""


State = TypeVar("State")
Linear = TypeVar("Linear", bound=Linearised)


class Problem(Protocol[State, Linear]):
    """What the loop needs to know of an adjustment."""

    def linearise(self, state: State) -> Linear:
        """Equations of the adjustment about `state`."""

    def corrected(self, state: State, linear: Linear, corrections: FloatArray) -> tuple[State, float]:
        """State after `corrections` (u,), and the largest scaled step of its eliminated unknowns (0 if none)."""


@dataclass(frozen=True, slots=True)
class Step(Generic[State]):
    """One iteration: the approximations, what it added, and v'Pv of the approximations."""

    state: State
    corrections: FloatArray
    vPv: float
    max_scaled_step: float
    damping: float


@dataclass(frozen=True, slots=True)
class Iterated(Generic[State, Linear]):
    """The end of an adjustment: its last state with the equations there, and the way to it."""

    termination: Termination
    state: State
    linear: Linear
    condition_ratio: float
    steps: tuple[Step[State], ...]


def iterate(
    problem: Problem[State, Linear], start: State, *, tolerance: float = 1e-10, max_iterations: int = 50
) -> Iterated[State, Linear]:
    """delta = -(A'PA)^-1 A'P L until max_i |delta_i| / s_i <= tolerance: Gauss-Newton from `start`.

    A step that would make v'Pv grow is damped: (A'PA + lambda diag(A'PA)) delta = -A'P L with the first lambda of
    1e-8, 1e-7, ... that does not. `tolerance` is raised to the rounding noise of the geometry, 32 eps / condition
    ratio.
    An adjustment that does not converge is a result with its termination, never an exception: SINGULAR when the
    column-scaled weighted design matrix has a ratio of singular values below 1e-8, NO_DESCENT when no damping helps,
    DIVERGED when a step exceeds a million scales, NOT_FINITE when numbers overflow.
    Source: Gauss; damping after Levenberg (1944) and Marquardt (1963).
    """
    with np.errstate(all="ignore"):
        return _iterate(problem, start, tolerance, max_iterations)


def _iterate(
    problem: Problem[State, Linear], start: State, tolerance: float, max_iterations: int
) -> Iterated[State, Linear]:
    state, linear, ratio = start, problem.linearise(start), 0.0
    steps: list[Step[State]] = []

    def ended(termination: Termination) -> Iterated[State, Linear]:
        return Iterated(termination, state, linear, ratio, tuple(steps))

    while True:
        if not _is_finite(linear):
            return ended(Termination.NOT_FINITE)
        ratio = condition_ratio(linear.triangle)
        if ratio < SINGULAR_RATIO:
            return ended(Termination.SINGULAR)
        if steps and steps[-1].damping == 0 and steps[-1].max_scaled_step <= max(tolerance, ROUNDING / ratio):
            return ended(Termination.CONVERGED)
        if len(steps) >= max_iterations:
            return ended(Termination.MAX_ITERATIONS)
        taken = _descend(problem, state, linear, max(tolerance, ROUNDING / ratio))
        if taken is None:
            return ended(Termination.NO_DESCENT)
        step, state, linear = taken
        steps.append(step)
        if step.max_scaled_step > DIVERGED_STEP:
            return ended(Termination.DIVERGED)


def _descend(
    problem: Problem[State, Linear], state: State, linear: Linear, tolerance: float
) -> tuple[Step[State], State, Linear] | None:
    """The first step, undamped or ever more damped, that does not make v'Pv grow."""
    damping = 0.0
    while damping <= LARGEST_DAMPING:
        corrections = solve(linear, damping)
        following, eliminated_step = problem.corrected(state, linear, corrections)
        scaled = max(float(np.max(np.abs(corrections / linear.scales))), eliminated_step)
        after = problem.linearise(following)
        is_last = damping == 0 and scaled <= tolerance
        if is_last or after.vPv <= linear.vPv * (1 + (SAME_VPV if damping == 0 else 0.0)):
            return Step(state, corrections, linear.vPv, scaled, damping), following, after
        damping = damping * 10 if damping else FIRST_DAMPING
    return None


def solve(linear: Linearised, damping: float = 0.0) -> FloatArray:
    """delta (u,) of (R'R + lambda diag(R'R)) (delta / s) = -R' rho."""
    if damping == 0:
        return np.asarray(linear.scales * -np.linalg.solve(linear.triangle, linear.rho))
    norms = np.linalg.norm(linear.triangle, axis=0)
    design = np.vstack([linear.triangle, np.sqrt(damping) * np.diag(norms)])
    free_term = np.concatenate([linear.rho, np.zeros(len(norms))])
    return np.asarray(linear.scales * -np.linalg.lstsq(design, free_term, rcond=None)[0])


def cofactor_matrix(linear: Linearised) -> FloatArray:
    """Q = s R^-1 R^-T s (u, u)."""
    inverse = linear.scales[:, None] * np.linalg.inv(linear.triangle)
    return np.asarray(inverse @ inverse.T)


def condition_ratio(triangle: FloatArray) -> float:
    """Smallest to largest singular value after scaling every column to length 1; 0 if a column is empty."""
    values = np.linalg.svd(_unit_columns(triangle), compute_uv=False)
    return float(values[-1] / values[0]) if values[0] > 0 else 0.0


def undetermined_combination(linear: Linearised, names: Sequence[str]) -> str:
    """The direction in which the unknowns can move without moving the observations, in words.

    The null vector, largest component 1, in units of the scales: `X_S 1.00, r_Y -0.98`.
    """
    norms = np.linalg.norm(linear.triangle, axis=0)
    if np.any(norms == 0):
        return ", ".join(f"{name} 1.00" for name, norm in zip(names, norms, strict=True) if norm == 0)
    null = np.linalg.svd(_unit_columns(linear.triangle))[2][-1] / norms
    null = null / null[np.argmax(np.abs(null))]
    parts = [(abs(value), f"{name} {value:.2f}") for name, value in zip(names, null, strict=True) if abs(value) >= 0.01]
    return ", ".join(text for _, text in sorted(parts, reverse=True))


def strong_correlations(
    Q: FloatArray, names: Sequence[str], limit: float = WEAK_CORRELATION
) -> tuple[tuple[str, str, float], ...]:
    """Pairs of unknowns with |Q_ij| / sqrt(Q_ii Q_jj) > limit."""
    sigma = np.sqrt(np.diag(Q))
    correlation = Q / np.outer(sigma, sigma)
    pairs = np.argwhere(np.triu(np.abs(correlation) > limit, k=1)).tolist()
    return tuple((names[i], names[j], float(correlation[i, j])) for i, j in pairs)


def _is_finite(linear: Linearised) -> bool:
    return bool(np.isfinite(linear.vPv) and np.isfinite(linear.triangle).all() and np.isfinite(linear.rho).all())


def _unit_columns(triangle: FloatArray) -> FloatArray:
    norms = np.linalg.norm(triangle, axis=0)
    return np.asarray(triangle / np.where(norms > 0, norms, 1.0))
