"""x_(k+1) = x_k - (A'PA)^-1 A'P L(x_k): the loop that every adjustment of orient runs through.

A problem linearises itself about a state and gives the triangle of the QR decomposition of its weighted, scaled
design matrix; the loop solves, shortens a step that does not lower v'Pv, records every
iteration, and ends with a termination.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from orient.solvers.trust_region import BoundedStep, TrustRegion

FloatArray = NDArray[np.float64]

SINGULAR_RATIO = 1e-8
WEAK_RATIO = 1e-4
WEAK_CORRELATION = 0.95
DIVERGED_STEP = 1e6
SAME_VPV = 1e-9
"""Relative change of v'Pv that is rounding, not a better or worse state: a whole step is taken in spite of it."""
SHORTEST_STEP = float(np.finfo(np.float64).eps)
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
    problem: Problem[State, Linear],
    start: State,
    *,
    polish: Problem[State, Linear] | None = None,
    tolerance: float = 1e-10,
    max_iterations: int = 50,
) -> Iterated[State, Linear]:
    """delta = -(A'PA)^-1 A'P L until max_i |delta_i| / s_i <= tolerance: Gauss-Newton from `start`.

    A step that does not lower v'Pv as it promises is replaced by a shorter one of Levenberg and Marquardt,
    (A'PA + lambda D^2) delta = -A'P L, inside a trust region that grows and shrinks with its success.
    `tolerance` is raised to the rounding noise of the geometry, 32 eps / condition ratio. `polish` is the same problem
    solved with more digits: it takes over where `problem`, solved by normal equations, meets its own noise
    (32 eps / ratio^2), and ends the iteration.
    An adjustment that does not converge is a result with its termination, never an exception: SINGULAR when it ends
    where the column-scaled weighted design matrix has a ratio of singular values below 1e-8 (passing such a state is
    allowed), NO_DESCENT when no step lowers v'Pv, DIVERGED when a step exceeds a million scales, NOT_FINITE when
    numbers overflow.
    Source: Gauss; Levenberg (1944) and Marquardt (1963); trust region after Moré (1978).
    """
    with np.errstate(all="ignore"):
        return _iterate(problem, start, polish, tolerance, max_iterations)


def _iterate(
    problem: Problem[State, Linear],
    start: State,
    polish: Problem[State, Linear] | None,
    tolerance: float,
    max_iterations: int,
) -> Iterated[State, Linear]:
    state, linear, ratio, arrived = start, problem.linearise(start), 0.0, False
    region = TrustRegion.at_start(linear.triangle)
    steps: list[Step[State]] = []

    def ended(termination: Termination) -> Iterated[State, Linear]:
        return Iterated(termination, state, linear, ratio, tuple(steps))

    while True:
        if not _is_finite(linear):
            return ended(Termination.NOT_FINITE)
        ratio = condition_ratio(linear.triangle)
        is_singular = ratio < SINGULAR_RATIO
        if arrived and polish is None:
            return ended(Termination.SINGULAR if is_singular else Termination.CONVERGED)
        if len(steps) >= max_iterations:
            return ended(Termination.SINGULAR if is_singular else Termination.MAX_ITERATIONS)
        if arrived and polish is not None:
            problem, linear, polish = polish, polish.linearise(state), None
        noise = ROUNDING / max(ratio, SINGULAR_RATIO) ** (1 if polish is None else 2)
        region = region.including(linear.triangle, linear.scales)
        descent = _descend(problem, state, linear, region, max(tolerance, noise), is_singular=is_singular)
        if descent is None:
            return ended(Termination.SINGULAR if is_singular else Termination.NO_DESCENT)
        steps.append(descent.step)
        state, linear, region, arrived = descent.state, descent.linear, descent.region, descent.arrived
        if descent.step.max_scaled_step > DIVERGED_STEP:
            return ended(Termination.DIVERGED)


@dataclass(frozen=True, slots=True)
class _Descent(Generic[State, Linear]):
    """A step that was taken, where it led, and whether it shows that there is nothing left to correct."""

    step: Step[State]
    state: State
    linear: Linear
    region: TrustRegion
    arrived: bool


def _descend(
    problem: Problem[State, Linear],
    state: State,
    linear: Linear,
    region: TrustRegion,
    tolerance: float,
    *,
    is_singular: bool,
) -> _Descent[State, Linear] | None:
    """The first step, whole or ever shorter, that lowers v'Pv; None when it would have to be shorter than eps."""
    while True:
        trial = region.step(linear.triangle, linear.rho, linear.scales, SINGULAR_RATIO if is_singular else 0.0)
        following, eliminated_step = problem.corrected(state, linear, trial.corrections)
        after = problem.linearise(following)
        of_unknowns = float(np.max(np.abs(trial.corrections / linear.scales)))
        step = Step(state, trial.corrections, linear.vPv, max(of_unknowns, eliminated_step), trial.damping)
        arrived = trial.is_whole and step.max_scaled_step <= tolerance
        if arrived or (trial.is_whole and _is_rounding(trial, linear, after)):
            return _Descent(step, following, after, region, arrived)
        gain = (linear.vPv - after.vPv) / trial.predicted if trial.predicted > 0 else 0.0
        if region.accepts(trial, gain):
            return _Descent(step, following, after, region.after(trial, gain), False)
        if not of_unknowns > SHORTEST_STEP:
            return None
        region = region.after(trial, gain)


def _is_rounding(trial: BoundedStep, linear: Linearised, after: Linearised) -> bool:
    """Is v'Pv so flat here that its change says nothing about the step?"""
    return trial.predicted <= SAME_VPV * linear.vPv and after.vPv <= linear.vPv * (1 + SAME_VPV)


def cofactor_matrix(linear: Linearised) -> FloatArray:
    """Q = s R^-1 R^-T s (u, u)."""
    inverse = linear.scales[:, None] * np.linalg.inv(linear.triangle)
    return np.asarray(inverse @ inverse.T)


def condition_ratio(rows: FloatArray) -> float:
    """Smallest to largest singular value after scaling every column to length 1; 0 if a column is empty.

    `rows` (n, u), n >= u: a design matrix or its triangle.
    """
    values = np.linalg.svd(_unit_columns(rows), compute_uv=False)
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
    """Pairs of unknowns with |Q_ij| / sqrt(Q_ii Q_jj) > limit; one without variance has no partner."""
    sigma = np.sqrt(np.diag(Q))
    correlation = Q / np.outer(*(np.where(sigma == 0, np.inf, sigma),) * 2)
    pairs = np.argwhere(np.triu(np.abs(correlation) > limit, k=1)).tolist()
    return tuple((names[i], names[j], float(correlation[i, j])) for i, j in pairs)


def _is_finite(linear: Linearised) -> bool:
    return bool(np.isfinite(linear.vPv) and np.isfinite(linear.triangle).all() and np.isfinite(linear.rho).all())


def _unit_columns(triangle: FloatArray) -> FloatArray:
    norms = np.linalg.norm(triangle, axis=0)
    return np.asarray(triangle / np.where(norms > 0, norms, 1.0))
